/*
  Migration of particles to their owners, and sorting of own particles. A particle is sent as a
  record; received records are sorted and written into the arrays.
*/
#include "impl.h"

/* Sort key of a record: fluid or wall, cell, id. */
typedef struct {
  PetscInt64 cell, id;
  PetscInt   record;
} SortKey;

#define CELL_BITS 20 /* of each axis in SortKey.cell */

/* Packs own particles as records in the order of receiving ranks. */
static PetscErrorCode PackRecords(const Particles *p, const PetscInt owner[], PetscInt n_to[],
                                  PetscReal **records)
{
  const PetscInt own = ParticlesOwn(p), width = ParticlesRecordWidth(p);
  PetscMPIInt    ranks;
  PetscInt      *next;
  RecordColumns  columns;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(p->comm, &ranks));
  PetscCall(PetscMalloc1((size_t)own * width, records));
  PetscCall(PetscCalloc1(ranks + 1, &next));
  PetscCall(RecordsBegin(p, &columns));
  for (PetscInt i = 0; i < own; i++) n_to[owner[i]]++;
  for (PetscMPIInt r = 0; r < ranks; r++) next[r + 1] = next[r] + n_to[r];
  for (PetscInt i = 0; i < own; i++)
    RecordPack(p, &columns, i, &(*records)[(size_t)next[owner[i]]++ * width]);
  PetscCall(RecordsEnd(&columns));
  PetscCall(PetscFree(next));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static int CompareKeys(const void *a, const void *b)
{
  const SortKey *k = (const SortKey *)a, *l = (const SortKey *)b;

  if (k->cell != l->cell) return k->cell < l->cell ? -1 : 1;
  return (k->id > l->id) - (k->id < l->id);
}

/*
  Sorts records by kind (fluid or wall), cell and id. Cells have the size of an interaction radius
  and begin at the corner of the scene's box, so that the order of two particles does not depend on
  their owners. Field 0 of a record is x.
*/
static PetscErrorCode SortRecords(const Scene *scene, const Particles *p, PetscInt n,
                                  const PetscReal records[], SortKey **keys)
{
  const PetscInt  width = ParticlesRecordWidth(p), last = (1 << CELL_BITS) - 1;
  const PetscReal offset = 1024.0; /* cells below the box, for walls */

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(n, keys));
  for (PetscInt k = 0; k < n; k++) {
    const PetscReal *record = &records[(size_t)k * width];
    SortKey         *key    = &(*keys)[k];

    key->record = k;
    key->id     = (PetscInt64)record[RECORD_ID];
    key->cell   = ParticleKinds[(PetscInt)record[RECORD_KIND]].is_wall;
    for (PetscInt a = p->dim - 1; a >= 0; a--) {
      const PetscReal s = (record[RECORD_FIELDS + a] - scene->lo[a]) / p->halo_width + offset;

      key->cell = (key->cell << CELL_BITS) + (s < 0.0 ? 0 : (s > last ? last : (PetscInt64)s));
    }
  }
  if (n > 1) qsort(*keys, (size_t)n, sizeof(**keys), CompareKeys);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes records into the arrays in sorted order. */
static PetscErrorCode UnpackRecords(Particles *p, PetscInt n, const PetscReal records[],
                                    const SortKey keys[])
{
  const PetscInt width = ParticlesRecordWidth(p);
  RecordColumns  columns;

  PetscFunctionBegin;
  p->n_fluid = p->n_wall = p->n_halo_fluid = p->n_halo_wall = 0;
  PetscCall(ParticlesReserve(p, n));
  PetscCall(RecordsBegin(p, &columns));
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal *record = &records[(size_t)keys[i].record * width];

    p->id[i]   = keys[i].id;
    p->kind[i] = (ParticleKind)record[RECORD_KIND];
    if (ParticleKinds[p->kind[i]].is_wall) p->n_wall++;
    else p->n_fluid++;
    RecordUnpack(&columns, record, i);
  }
  PetscCall(RecordsEnd(&columns));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Numbers fluid particles and, separately, wall particles consecutively over ranks; sums the
   weights of the fluid. */
static PetscErrorCode NumberParticles(Particles *p)
{
  PetscInt n[2] = {p->n_fluid, p->n_wall}, start[2] = {0, 0};

  PetscFunctionBegin;
  PetscCallMPI(MPI_Exscan(n, start, 2, MPIU_INT, MPI_SUM, p->comm));
  p->fluid_start = start[0];
  p->wall_start  = start[1];
  p->weight      = 0.0;
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    p->row[i] = p->fluid_start + i;
    p->weight += ParticlesWeight(p, i);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &p->weight, 1, MPIU_REAL, MPIU_SUM, p->comm));
  for (PetscInt w = 0; w < p->n_wall; w++) p->row[p->n_fluid + w] = p->wall_start + w;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  ParticlesStore - Replaces own particles by the particles of records, and counts the particles of
  all ranks

  Collective. Owners, numbers and halo are invalid until an epoch starts.

  Input Parameters:
+ n      - number of records of this rank
- record - the records, in the layout of ParticlesPack()

  Output Parameter:
. p - own particles in sorted order, n_fluid, n_wall, N_fluid and N_wall; the halo is empty
*/
PetscErrorCode ParticlesStore(const Scene *scene, Particles *p, PetscInt n,
                              const PetscReal record[])
{
  SortKey *keys;
  PetscInt all[2];

  PetscFunctionBegin;
  PetscCall(SortRecords(scene, p, n, record, &keys));
  PetscCall(UnpackRecords(p, n, record, keys));
  PetscCall(PetscFree(keys));
  all[0] = p->n_fluid;
  all[1] = p->n_wall;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, all, 2, MPIU_INT, MPI_SUM, p->comm));
  p->N_fluid = all[0];
  p->N_wall  = all[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  ParticlesMigrate - Sends own particles with all fields to their owners, sorts and numbers them

  Collective

  Input Parameters:
+ scene - the scene
. p     - the particles
- owner - rank of every own particle

  Output Parameter:
. p - own particles sorted by (fluid or wall, cell, id) and numbered; the halo is empty
*/
PetscErrorCode ParticlesMigrate(const Scene *scene, Particles *p, const PetscInt owner[])
{
  PetscMPIInt ranks, n_sources, *source;
  PetscInt   *n_to, *n_from, n = 0;
  PetscReal  *sent, *records;
  SortKey    *keys;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(p->comm, &ranks));
  PetscCall(PetscCalloc1(ranks, &n_to));
  PetscCall(PackRecords(p, owner, n_to, &sent));
  PetscCall(ExchangeItems(p->comm, MPIU_REAL, ParticlesRecordWidth(p), n_to, sent, &n_sources,
                          &source, &n_from, &records));
  PetscCall(PetscFree(sent));
  for (PetscMPIInt s = 0; s < n_sources; s++) n += n_from[s];
  PetscCall(SortRecords(scene, p, n, records, &keys));
  PetscCall(UnpackRecords(p, n, records, keys));
  PetscCall(NumberParticles(p));
  PetscCall(PetscFree(keys));
  PetscCall(PetscFree(records));
  PetscCall(PetscFree(n_from));
  PetscCall(PetscFree(source));
  PetscCall(PetscFree(n_to));
  PetscFunctionReturn(PETSC_SUCCESS);
}
