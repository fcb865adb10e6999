/* Functions that restore, replace, insert and remove particles. All except ParticlesUnpack() start
   an epoch; other modules then renew the values that they keep for each particle. */
#include "impl.h"

/* ParticlesUnpack - Restores fields of own particles from records packed in the present epoch.
   Collective. In an epoch the order of own particles is constant, so records need no search.
   Updates the positions of the halo. */
PetscErrorCode ParticlesUnpack(Particles *p, const PetscReal record[])
{
  const PetscInt width = ParticlesRecordWidth(p);
  RecordColumns  columns;

  PetscFunctionBegin;
  PetscCall(RecordsBegin(p, &columns));
  for (PetscInt i = 0; i < ParticlesOwn(p); i++)
    RecordUnpack(&columns, &record[(size_t)i * width], i);
  PetscCall(RecordsEnd(&columns));
  PetscCall(ParticlesUpdateHalo(p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ParticlesReplace - Replaces own particles by records and starts an epoch. Collective. Each
   particle must be given once, on any rank. The resulting owners, order and numbers depend only on
   the particles and the number of ranks. Input: n - number of records on this rank; record - the
   records, in the layout of ParticlesPack(). */
PetscErrorCode ParticlesReplace(const Scene *scene, Particles *p, PetscInt n,
                                const PetscReal record[])
{
  PetscFunctionBegin;
  PetscCall(ParticlesStore(scene, p, n, record));
  p->redraw = PETSC_TRUE;
  PetscCall(ParticlesUpdateEpoch(scene, p, PETSC_TRUE, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Replaces own particles by n records, frees the records, and starts an epoch. */
static PetscErrorCode StoreAndFree(const Scene *scene, Particles *p, PetscInt n, PetscReal **record)
{
  PetscFunctionBegin;
  PetscCall(ParticlesStore(scene, p, n, *record));
  PetscCall(PetscFree(*record));
  PetscCall(ParticlesUpdateEpoch(scene, p, PETSC_TRUE, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Fluid around a position, from which a new particle takes mean values. */
typedef struct {
  Cells      cells;
  PetscInt   n, capacity, *j;
  PetscReal *weight, sum;
} Surroundings;

/* Builds the cells for the search; updates the halo of all fields with the policies ENTRY_MEAN and
   ENTRY_NEAREST. */
static PetscErrorCode SurroundingsCreate(Particles *p, Surroundings *near)
{
  PetscFunctionBegin;
  PetscCall(PetscMemzero(near, sizeof(*near)));
  for (PetscInt f = 0; f < p->n_fields; f++) {
    const EntryPolicy entry = p->field[f].entry;

    if (entry != ENTRY_MEAN && entry != ENTRY_NEAREST) continue;
    for (PetscInt c = 0; c < p->field[f].components; c++)
      PetscCall(ParticlesHaloField(p, p->field[f].slot[c]));
  }
  near->capacity = ParticlesAll(p);
  PetscCall(CellsBuild(p, p->halo_width, &near->cells));
  PetscCall(PetscMalloc2(near->capacity, &near->j, near->capacity, &near->weight));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SurroundingsDestroy(Surroundings *near)
{
  PetscFunctionBegin;
  PetscCall(CellsFree(&near->cells));
  PetscCall(PetscFree2(near->j, near->weight));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds fluid near x with weights (1 - r/R)^2, R = halo_width. */
static PetscErrorCode SurroundingsFind(const Particles *p, const PetscReal x[], Surroundings *near)
{
  PetscInt found;

  PetscFunctionBegin;
  PetscCall(CellsFind(&near->cells, x, p->halo_width, near->capacity, near->j, &found));
  near->n   = 0;
  near->sum = 0.0;
  for (PetscInt k = 0; k < found; k++) {
    PetscReal r2 = 0.0;

    if (ParticlesIsWall(p, near->j[k])) continue;
    for (PetscInt a = 0; a < p->dim; a++) r2 += PetscSqr(p->x[a][near->j[k]] - x[a]);
    near->j[near->n]      = near->j[k];
    near->weight[near->n] = PetscSqr(1.0 - PetscSqrtReal(r2) / p->halo_width);
    near->sum += near->weight[near->n++];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the weighted mean of a component of a field; zero without fluid nearby. */
static PetscReal SurroundingsMean(const Surroundings *near, const PetscReal value[])
{
  PetscReal sum = 0.0;

  for (PetscInt k = 0; k < near->n; k++) sum += near->weight[k] * value[near->j[k]];
  return near->sum > 0.0 ? sum / near->sum : 0.0;
}

/* Returns the value of the nearest fluid; zero without fluid nearby. */
static PetscReal SurroundingsNearest(const Surroundings *near, const PetscReal value[])
{
  PetscInt nearest = 0;

  for (PetscInt k = 1; k < near->n; k++)
    if (near->weight[k] > near->weight[nearest]) nearest = k;
  return near->n ? value[near->j[nearest]] : 0.0;
}

/* Returns the default value of component c of a field for a new particle at x. */
static PetscReal EntryValue(const Scene *scene, const Field *field, PetscInt c, const PetscReal x[],
                            const Surroundings *near)
{
  PetscReal stretch[ISPH_MAX_DIM];

  switch (field->entry) {
  case ENTRY_MEAN:
    return SurroundingsMean(near, field->slot[c]);
  case ENTRY_NEAREST:
    return SurroundingsNearest(near, field->slot[c]);
  case ENTRY_POSITION:
    return x[c];
  case ENTRY_SPACING:
    return SceneSpacing(scene, x);
  case ENTRY_STRETCH:
    SceneStretch(scene, x, stretch);
    return stretch[c];
  case ENTRY_VOLUME:
    return SceneVolumeAt(scene, x);
  default:
    return 0.0;
  }
}

/* Sets all fields of new particle k in `record`, the layout of ParticlesPack(). `near` finds the
   fluid around the position of the particle, for fields whose default is a mean. */
static PetscErrorCode FillRecord(const Scene *scene, const Particles *p, const NewParticles *added,
                                 PetscInt k, Surroundings *near, PetscReal record[])
{
  const PetscReal *x     = &added->x[k * p->dim];
  PetscReal       *value = &record[RECORD_FIELDS];

  PetscFunctionBegin;
  PetscCall(SurroundingsFind(p, x, near));
  for (PetscInt f = 0; f < p->n_fields; f++) {
    const Field *field = &p->field[f];

    for (PetscInt c = 0; c < field->components; c++)
      value[c] = EntryValue(scene, field, c, x, near);
    if (added->Value && field->entry != ENTRY_POSITION) added->Value(field, k, value, added->ctx);
    value += field->components;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ParticlesInsert - Adds particles with new ids and starts an epoch. Collective, between steps.
   Does nothing if no rank adds a particle. Input: added - kind, positions and values;
   ParticlesHolds() must be true for each position. Output: first - id of the first new particle of
   this rank; its other new particles have the ids that follow; may be NULL. Notes: Each field of a
   new particle has the value of its EntryPolicy unless Value() replaces it; Value() is called for
   each field except positions. After an insertion the scheme's Begin reinitialises the flow. Ids
   depend on the number of ranks. Mean values come from own and halo particles: this is the reason
   for the condition on positions. */
PetscErrorCode ParticlesInsert(const Scene *scene, Particles *p, const NewParticles *added,
                               PetscInt64 *first)
{
  const PetscInt own = ParticlesOwn(p), width = ParticlesRecordWidth(p);
  PetscInt64     n = added->n, before = 0, total;
  PetscReal     *record;
  Surroundings   near;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Allreduce(&n, &total, 1, MPIU_INT64, MPI_SUM, p->comm));
  PetscCallMPI(MPI_Exscan(&n, &before, 1, MPIU_INT64, MPI_SUM, p->comm));
  if (first) *first = p->next_id + before;
  if (!total) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(p->next_id + total <= PARTICLES_MAX_ID, p->comm, PETSC_ERR_ARG_OUTOFRANGE,
             "More than %" PetscInt64_FMT " particles in the life of a run", PARTICLES_MAX_ID);
  PetscCall(SurroundingsCreate(p, &near));
  PetscCall(PetscMalloc1((size_t)(own + added->n) * width, &record));
  PetscCall(ParticlesPack(p, record));
  for (PetscInt k = 0; k < added->n; k++) {
    PetscReal *row = &record[(size_t)(own + k) * width];

    row[RECORD_ID]   = (PetscReal)(p->next_id + before + k);
    row[RECORD_KIND] = (PetscReal)added->kind;
    PetscCall(FillRecord(scene, p, added, k, &near, row));
  }
  PetscCall(SurroundingsDestroy(&near));
  p->next_id += total;
  PetscCall(StoreAndFree(scene, p, own + added->n, &record));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ParticlesRemove - Removes own particles and starts an epoch. Collective, between steps. Does
   nothing if no rank removes a particle. Ids of removed particles are not used again. Afterwards
   the scheme's Begin reinitialises the flow. Input: n - number of particles to remove on this rank;
   local - their local indices, each once, in any order. */
PetscErrorCode ParticlesRemove(const Scene *scene, Particles *p, PetscInt n, const PetscInt local[])
{
  const PetscInt own = ParticlesOwn(p), width = ParticlesRecordWidth(p);
  PetscInt       total, kept                  = 0;
  PetscBool     *goes;
  PetscReal     *record;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Allreduce(&n, &total, 1, MPIU_INT, MPI_SUM, p->comm));
  if (!total) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1(own, &goes));
  for (PetscInt k = 0; k < n; k++) {
    PetscCheck(local[k] >= 0 && local[k] < own && !goes[local[k]], PETSC_COMM_SELF,
               PETSC_ERR_ARG_OUTOFRANGE,
               "Particle %" PetscInt_FMT " is not an own one, or removed twice", local[k]);
    goes[local[k]] = PETSC_TRUE;
  }
  PetscCall(PetscMalloc1((size_t)own * width, &record));
  PetscCall(ParticlesPack(p, record));
  for (PetscInt i = 0; i < own; i++) {
    if (goes[i]) continue;
    if (kept < i)
      PetscCall(PetscArraycpy(&record[(size_t)kept * width], &record[(size_t)i * width], width));
    kept++;
  }
  PetscCall(PetscFree(goes));
  PetscCall(StoreAndFree(scene, p, kept, &record));
  PetscFunctionReturn(PETSC_SUCCESS);
}
