/* Migration of particles to their owners, and sorting of own particles. A particle that leaves is
   sent as a record; particles that stay and received records are sorted together. */
#include "impl.h"

/* The own particles to be: those that stay, by their local indices, followed by records. */
typedef struct {
  PetscInt         n_kept, n; /* particles that stay, and all */
  const PetscInt  *kept;
  const PetscReal *record;
  PetscInt         width; /* of a record */
} Items;

/* Sort key of an item: fluid or wall with the cell, id. */
typedef struct {
  PetscInt64 cell, id;
  PetscInt   item;
} SortKey;

#define CELL_BITS 20 /* of each axis in SortKey.cell */

/* Returns number `place` of the record of item k; values: those of the particles. */
static inline PetscReal ItemValue(const Items *items, PetscInt k, PetscInt place,
                                  const PetscReal values[])
{
  return k < items->n_kept ? values[items->kept[k]]
                           : items->record[(size_t)(k - items->n_kept) * items->width + place];
}

static inline PetscInt64 ItemId(const Items *items, PetscInt k, const Particles *p)
{
  return k < items->n_kept
             ? p->id[items->kept[k]]
             : (PetscInt64)items->record[(size_t)(k - items->n_kept) * items->width + RECORD_ID];
}

static inline ParticleKind ItemKind(const Items *items, PetscInt k, const Particles *p)
{
  return k < items->n_kept
             ? p->kind[items->kept[k]]
             : (ParticleKind)
                   items->record[(size_t)(k - items->n_kept) * items->width + RECORD_KIND];
}

/* Lists own particles that stay, and packs the others as records in the order of receiving
   ranks. */
static PetscErrorCode PackRecords(const Particles *p, const PetscInt owner[], PetscInt n_to[],
                                  PetscInt kept[], PetscInt *n_kept, PetscReal **records)
{
  const PetscInt own = ParticlesOwn(p), width = ParticlesRecordWidth(p);
  PetscMPIInt    ranks, rank;
  PetscInt      *next;
  RecordColumns  columns;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(p->comm, &ranks));
  PetscCallMPI(MPI_Comm_rank(p->comm, &rank));
  PetscCall(PetscCalloc1(ranks + 1, &next));
  PetscCall(RecordsBegin(p, &columns));
  *n_kept = 0;
  for (PetscInt i = 0; i < own; i++) {
    if (owner[i] == rank) kept[(*n_kept)++] = i;
    else n_to[owner[i]]++;
  }
  for (PetscMPIInt r = 0; r < ranks; r++) next[r + 1] = next[r] + n_to[r];
  PetscCall(PetscMalloc1((size_t)next[ranks] * width, records));
  for (PetscInt i = 0; i < own; i++) {
    if (owner[i] != rank) RecordPack(p, &columns, i, &(*records)[(size_t)next[owner[i]]++ * width]);
  }
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

/* Sorts items by kind (fluid or wall), cell and id. Cells have the size of an interaction radius
   and begin at the corner of the scene's box, so that the order of two particles does not depend on
   their owners. Particles that stay on a lattice have the order of their ids, along its lines, in
   which products of operators take several rows at a time. Field 0 of a record is x. */
static PetscErrorCode SortItems(const Scene *scene, const Particles *p, const Items *items,
                                SortKey **keys)
{
  const PetscInt  last   = (1 << CELL_BITS) - 1;
  const PetscReal offset = 1024.0; /* cells below the box, for walls */
  const PetscBool lines  = !SceneMoves(scene) && !scene->grading.on;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(items->n, keys));
  for (PetscInt k = 0; k < items->n; k++) {
    SortKey *key = &(*keys)[k];

    key->item = k;
    key->id   = ItemId(items, k, p);
    key->cell = ParticleKinds[ItemKind(items, k, p)].is_wall;
    for (PetscInt a = p->dim - 1; a >= 0 && !lines; a--) {
      const PetscReal x = ItemValue(items, k, RECORD_FIELDS + a, p->x[a]);
      const PetscReal s = (x - scene->lo[a]) / p->halo_width + offset;

      key->cell = (key->cell << CELL_BITS) + (s < 0.0 ? 0 : (s > last ? last : (PetscInt64)s));
    }
  }
  if (items->n > 1) qsort(*keys, (size_t)items->n, sizeof(**keys), CompareKeys);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes items into the arrays in sorted order, one array after the other: a copy of all particles
   would be the peak of a run's memory. */
static PetscErrorCode ArrangeItems(Particles *p, const Items *items, const SortKey keys[])
{
  RecordColumns columns;
  PetscReal    *sorted;

  PetscFunctionBegin;
  p->n_fluid = p->n_wall = p->n_halo_fluid = p->n_halo_wall = 0;
  PetscCall(ParticlesReserve(p, items->n));
  PetscCall(RecordsBegin(p, &columns));
  PetscCall(PetscMalloc1(items->n, &sorted));
  for (PetscInt c = 0; c < columns.n; c++) {
    for (PetscInt i = 0; i < items->n; i++)
      sorted[i] = ItemValue(items, keys[i].item, RECORD_FIELDS + c, columns.values[c]);
    PetscCall(PetscArraycpy(columns.values[c], sorted, items->n));
  }
  for (PetscInt i = 0; i < items->n; i++) sorted[i] = ItemKind(items, keys[i].item, p);
  for (PetscInt i = 0; i < items->n; i++) {
    p->id[i]   = keys[i].id;
    p->kind[i] = (ParticleKind)sorted[i];
    if (ParticleKinds[p->kind[i]].is_wall) p->n_wall++;
    else p->n_fluid++;
  }
  PetscCall(PetscFree(sorted));
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

/* ParticlesStore - Replaces own particles by the particles of records, and counts the particles of
   all ranks. Collective. Owners, numbers and halo are invalid until an epoch starts. Input: n -
   number of records of this rank; record - the records, in the layout of ParticlesPack(). Output: p
   - own particles in sorted order, n_fluid, n_wall, N_fluid and N_wall; the halo is empty. */
PetscErrorCode ParticlesStore(const Scene *scene, Particles *p, PetscInt n,
                              const PetscReal record[])
{
  const Items items = {.n = n, .record = record, .width = ParticlesRecordWidth(p)};
  SortKey    *keys;
  PetscInt    all[2];

  PetscFunctionBegin;
  PetscCall(SortItems(scene, p, &items, &keys));
  PetscCall(ArrangeItems(p, &items, keys));
  PetscCall(PetscFree(keys));
  all[0] = p->n_fluid;
  all[1] = p->n_wall;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, all, 2, MPIU_INT, MPI_SUM, p->comm));
  p->N_fluid = all[0];
  p->N_wall  = all[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ParticlesMigrate - Sends own particles with all fields to their owners, sorts and numbers them.
   Collective. Input: scene - the scene; p - the particles; owner - rank of every own particle.
   Output: p - own particles sorted by (fluid or wall, cell, id) and numbered; the halo is empty. */
PetscErrorCode ParticlesMigrate(const Scene *scene, Particles *p, const PetscInt owner[])
{
  PetscMPIInt ranks, n_sources, *source;
  PetscInt   *n_to, *n_from, *kept;
  PetscReal  *sent, *records;
  Items       items = {.width = ParticlesRecordWidth(p)};
  SortKey    *keys;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(p->comm, &ranks));
  PetscCall(PetscCalloc1(ranks, &n_to));
  PetscCall(PetscMalloc1(ParticlesOwn(p), &kept));
  PetscCall(PackRecords(p, owner, n_to, kept, &items.n_kept, &sent));
  PetscCall(ExchangeItems(p->comm, MPIU_REAL, items.width, n_to, sent, &n_sources, &source, &n_from,
                          &records));
  PetscCall(PetscFree(sent));
  items.n      = items.n_kept;
  items.kept   = kept;
  items.record = records;
  for (PetscMPIInt s = 0; s < n_sources; s++) items.n += n_from[s];
  PetscCall(SortItems(scene, p, &items, &keys));
  PetscCall(ArrangeItems(p, &items, keys));
  PetscCall(NumberParticles(p));
  PetscCall(FreeAll(&keys, &kept, &records, &n_from, &source, &n_to));
  PetscFunctionReturn(PETSC_SUCCESS);
}
