/* Storage of particles: arrays that grow together, fields registered by other modules, and records
   for communication and files. */
#include "impl.h"

/* ParticlesReserve - Reserves room for n particles, own and halo, in every array, and keeps values.
   Note: new entries are zero. Capacity is never less than 1, so that an existing field is never
   NULL. */
PetscErrorCode ParticlesReserve(Particles *p, PetscInt n)
{
  const PetscInt old      = p->capacity;
  const PetscInt capacity = PetscMax(PetscMax(n, 1), old + old / 4);

  PetscFunctionBegin;
  if (n <= old && old > 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscRealloc(sizeof(*p->id) * (size_t)capacity, &p->id));
  PetscCall(PetscRealloc(sizeof(*p->kind) * (size_t)capacity, &p->kind));
  PetscCall(PetscRealloc(sizeof(*p->row) * (size_t)capacity, &p->row));
  PetscCall(PetscArrayzero(p->id + old, capacity - old));
  PetscCall(PetscArrayzero(p->kind + old, capacity - old));
  PetscCall(PetscArrayzero(p->row + old, capacity - old));
  for (PetscInt f = 0; f < p->n_fields; f++) {
    for (PetscInt c = 0; c < p->field[f].components; c++) {
      PetscReal *grown;
      PetscCall(PetscCalloc1(capacity, &grown));
      PetscCall(PetscArraycpy(grown, p->field[f].slot[c], old));
      PetscCall(PetscFree(p->field[f].slot[c]));
      p->field[f].slot[c] = grown;
    }
  }
  p->capacity = capacity;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ParticlesRegister - Registers arrays as a field, whose values migrate and are sorted with the
   particles. Collective: fields must be registered in the same order on all ranks. Input: particles
   - the particles; name - for messages and files; the string is not copied; components - number of
   arrays; halo - HALO_EPOCH: values of the halo are filled at the start of each later epoch; entry
   - default value for particles that are inserted later; slot - the caller's array of `components`
   pointers; must live as long as the particles. Notes: slot[c][i], i < capacity, is allocated here,
   set to zero, and freed by ParticlesDestroy(). The address may change at each start of an epoch:
   always use the slot, and keep no copy of it. Every field must have values for own particles,
   fluid and wall. A field of positions is not wrapped into the box. */
PetscErrorCode ParticlesRegister(Particles *particles, const char name[], PetscInt components,
                                 HaloPolicy halo, EntryPolicy entry, PetscReal **slot)
{
  Field *field = &particles->field[particles->n_fields];

  PetscFunctionBegin;
  PetscCheck(particles->n_fields < PARTICLES_MAX_FIELDS, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "Field %s is one more than PARTICLES_MAX_FIELDS = %d", name, PARTICLES_MAX_FIELDS);
  PetscCall(ParticlesReserve(particles, 1));
  for (PetscInt c = 0; c < components; c++) {
    PetscCall(PetscCalloc1(particles->capacity, &slot[c]));
  }
  *field =
      (Field){.name = name, .components = components, .halo = halo, .entry = entry, .slot = slot};
  particles->n_fields++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ParticlesRecordWidth - Returns the length of a record: id, kind, then all components of all
   fields */
PetscInt ParticlesRecordWidth(const Particles *p)
{
  PetscInt width = RECORD_FIELDS;

  for (PetscInt f = 0; f < p->n_fields; f++) width += p->field[f].components;
  return width;
}

/* RecordsBegin - Lists all components of all fields in the order of a record. Output: columns -
   valid until capacity or fields change; free with RecordsEnd(). */
PetscErrorCode RecordsBegin(const Particles *p, RecordColumns *columns)
{
  PetscFunctionBegin;
  columns->n = 0;
  PetscCall(PetscMalloc1(ParticlesRecordWidth(p), &columns->values));
  for (PetscInt f = 0; f < p->n_fields; f++) {
    for (PetscInt c = 0; c < p->field[f].components; c++) {
      columns->values[columns->n++] = p->field[f].slot[c];
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode RecordsEnd(RecordColumns *columns)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(columns->values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* RecordPack - Copies id, kind and fields of local particle i to a record */
void RecordPack(const Particles *p, const RecordColumns *columns, PetscInt i, PetscReal record[])
{
  record[RECORD_ID]   = (PetscReal)p->id[i]; /* exact: ids stay below PARTICLES_MAX_ID */
  record[RECORD_KIND] = (PetscReal)p->kind[i];
  for (PetscInt k = 0; k < columns->n; k++) record[RECORD_FIELDS + k] = columns->values[k][i];
}

/* RecordUnpack - Copies the fields of a record to local particle i */
void RecordUnpack(const RecordColumns *columns, const PetscReal record[], PetscInt i)
{
  for (PetscInt k = 0; k < columns->n; k++) columns->values[k][i] = record[RECORD_FIELDS + k];
}

/* ParticlesPack - Copies own particles with all fields to records. Output: record - ParticlesOwn()
   records of ParticlesRecordWidth() numbers, in the order of local indices. */
PetscErrorCode ParticlesPack(const Particles *p, PetscReal record[])
{
  const PetscInt width = ParticlesRecordWidth(p);
  RecordColumns  columns;

  PetscFunctionBegin;
  PetscCall(RecordsBegin(p, &columns));
  for (PetscInt i = 0; i < ParticlesOwn(p); i++)
    RecordPack(p, &columns, i, &record[(size_t)i * width]);
  PetscCall(RecordsEnd(&columns));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the bounds of the numbers of a field, in records that a file gives. */
static void FieldBounds(const Scene *scene, const Particles *p, const Field *field, PetscReal *low,
                        PetscReal *high)
{
  *low  = -PETSC_MAX_REAL;
  *high = PETSC_MAX_REAL;
  if (field->slot == &p->volume) *low = PETSC_MACHINE_EPSILON * p->cell_volume;
  if (field->slot == &p->nu || field->slot == &p->interface) *low = 0.0;
  if (field->slot == &p->share) {
    *low  = 0.0;
    *high = 1.0;
  }
  if (field->slot == &p->fluid || field->slot == &p->other) {
    *low  = 0.0;
    *high = (PetscReal)SceneFluids(scene) - 1.0;
  }
  if (field->slot == &p->dx) {
    *low  = SceneFinest(scene) * (1.0 - PETSC_SQRT_MACHINE_EPSILON);
    *high = SceneCoarsest(scene) * (1.0 + PETSC_SQRT_MACHINE_EPSILON);
  }
  if (field->slot == p->stretch) {
    *low  = PETSC_SQRT_MACHINE_EPSILON;
    *high = PetscSqrtReal((PetscReal)p->dim) * (1.0 + PETSC_SQRT_MACHINE_EPSILON);
  }
  if (field->slot == &p->side) {
    *low  = 0.0;
    *high = (PetscReal)SceneBoundaries(scene) - 1.0;
  }
}

/* Returns true if a number is whole and at least 0, and smaller than a bound. */
static PetscBool IsWhole(PetscReal number, PetscReal bound)
{
  return number >= 0.0 && number < bound && number == PetscFloorReal(number);
}

/* ParticlesValidRecord - Determines if a record of a file can be the record of a particle. Its id
   is smaller than p->next_id, its kind is known, and the numbers of its fields are finite and
   within their bounds. */
PetscBool ParticlesValidRecord(const Scene *scene, const Particles *p, const PetscReal record[])
{
  const PetscReal *number = &record[RECORD_FIELDS];
  PetscBool        valid  = p->next_id <= PARTICLES_MAX_ID &&
                    IsWhole(record[RECORD_ID], (PetscReal)p->next_id) &&
                    IsWhole(record[RECORD_KIND], PARTICLE_KINDS);

  for (PetscInt f = 0; f < p->n_fields; f++) {
    PetscReal low, high;

    FieldBounds(scene, p, &p->field[f], &low, &high);
    for (PetscInt c = 0; c < p->field[f].components; c++, number++)
      valid = valid && *number >= low && *number <= high;
  }
  return valid;
}

/* The kinds of particles, in the order of ParticleKind. */
const ParticleKindRow ParticleKinds[PARTICLE_KINDS] = {
    [PARTICLE_FLUID] = {"fluid", PETSC_FALSE},
    [PARTICLE_WALL]  = {"wall", PETSC_TRUE},
};
