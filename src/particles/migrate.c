/*
  Particles go to their owners and are put in order there. A particle travels as one record, its id
  and all components of all fields; the records received are sorted and written back into the
  arrays.
*/
#include "impl.h"

/* A record's place in the order: kind, cell, id. */
typedef struct {
  PetscInt64 cell;
  PetscInt   id;
  PetscInt   record;
} SortKey;

#define CELL_BITS 20 /* of each axis in SortKey.cell */

/* ParticlesRecordWidth - Numbers in a particle's record: its id, then all components of all
   fields */
PetscInt ParticlesRecordWidth(const Particles *p)
{
  PetscInt width = 1;

  for (PetscInt f = 0; f < p->n_fields; f++) width += p->field[f].components;
  return width;
}

/* All components of all fields as a record holds them; free with PetscFree(). */
static PetscErrorCode FieldColumns(const Particles *p, PetscInt *n, PetscReal ***column)
{
  PetscFunctionBegin;
  *n = 0;
  PetscCall(PetscMalloc1(ParticlesRecordWidth(p), column));
  for (PetscInt f = 0; f < p->n_fields; f++) {
    for (PetscInt c = 0; c < p->field[f].components; c++) {
      (*column)[(*n)++] = p->field[f].slot[c];
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The record of own particle i: id, then its components in all columns. */
static inline void PackRecord(const Particles *p, PetscInt n, PetscReal *const column[], PetscInt i,
                              PetscReal record[])
{
  record[0] = (PetscReal)p->id[i]; /* exact below 2^53 */
  for (PetscInt k = 0; k < n; k++) record[1 + k] = column[k][i];
}

/*
  ParticlesPack - Copies the own particles with all fields

  Not collective. Output: record - ParticlesOwn() records of ParticlesRecordWidth() numbers, in
  order.
*/
PetscErrorCode ParticlesPack(const Particles *p, PetscReal record[])
{
  const PetscInt width = ParticlesRecordWidth(p);
  PetscInt       n;
  PetscReal    **column;

  PetscFunctionBegin;
  PetscCall(FieldColumns(p, &n, &column));
  for (PetscInt i = 0; i < ParticlesOwn(p); i++)
    PackRecord(p, n, column, i, &record[(size_t)i * width]);
  PetscCall(PetscFree(column));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  ParticlesUnpack - Gives the own particles the fields of records packed in the present epoch

  Collective: the halo's positions follow.
*/
PetscErrorCode ParticlesUnpack(Particles *p, const PetscReal record[])
{
  const PetscInt width = ParticlesRecordWidth(p);
  PetscInt       n;
  PetscReal    **column;

  PetscFunctionBegin;
  PetscCall(FieldColumns(p, &n, &column));
  for (PetscInt i = 0; i < ParticlesOwn(p); i++) {
    for (PetscInt k = 0; k < n; k++) column[k][i] = record[(size_t)i * width + 1 + k];
  }
  PetscCall(PetscFree(column));
  PetscCall(ParticlesUpdateHalo(p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lays the own particles out as records, those for rank 0 first. */
static PetscErrorCode PackRecords(const Particles *p, const PetscInt owner[], PetscInt n_to[],
                                  PetscReal **records)
{
  const PetscInt own = ParticlesOwn(p), width = ParticlesRecordWidth(p);
  PetscMPIInt    ranks;
  PetscInt      *next, n;
  PetscReal    **column;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(p->comm, &ranks));
  PetscCall(PetscMalloc1((size_t)own * width, records));
  PetscCall(PetscCalloc1(ranks + 1, &next));
  PetscCall(FieldColumns(p, &n, &column));
  for (PetscInt i = 0; i < own; i++) n_to[owner[i]]++;
  for (PetscMPIInt r = 0; r < ranks; r++) next[r + 1] = next[r] + n_to[r];
  for (PetscInt i = 0; i < own; i++)
    PackRecord(p, n, column, i, &(*records)[(size_t)next[owner[i]]++ * width]);
  PetscCall(PetscFree(column));
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
  Cells are of one interaction radius and start at the corner of the scene's box, so that the order
  of two particles does not depend on who owns them. Field 0 of a record is x.
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
    key->id     = (PetscInt)record[0];
    key->cell   = key->id >= p->N_fluid;
    for (PetscInt a = p->dim - 1; a >= 0; a--) {
      const PetscReal s = (record[1 + a] - scene->lo[a]) / p->halo_width + offset;

      key->cell = (key->cell << CELL_BITS) + (s < 0.0 ? 0 : (s > last ? last : (PetscInt64)s));
    }
  }
  if (n > 1) qsort(*keys, (size_t)n, sizeof(**keys), CompareKeys);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes the records in sorted order into the arrays. */
static PetscErrorCode UnpackRecords(Particles *p, PetscInt n, const PetscReal records[],
                                    const SortKey keys[])
{
  const PetscInt width = ParticlesRecordWidth(p);
  PetscInt       n_columns;
  PetscReal    **column;

  PetscFunctionBegin;
  p->n_fluid = p->n_wall = p->n_halo_fluid = p->n_halo_wall = 0;
  PetscCall(ParticlesReserve(p, n));
  PetscCall(FieldColumns(p, &n_columns, &column));
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal *record = &records[(size_t)keys[i].record * width];

    p->id[i] = keys[i].id;
    if (keys[i].id < p->N_fluid) p->n_fluid++;
    else p->n_wall++;
    for (PetscInt k = 0; k < n_columns; k++) column[k][i] = record[1 + k];
  }
  PetscCall(PetscFree(column));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Numbers own fluid and own wall particles consecutively over the ranks. */
static PetscErrorCode NumberParticles(Particles *p)
{
  PetscInt n[2] = {p->n_fluid, p->n_wall}, start[2] = {0, 0};

  PetscFunctionBegin;
  PetscCallMPI(MPI_Exscan(n, start, 2, MPIU_INT, MPI_SUM, p->comm));
  p->fluid_start = start[0];
  p->wall_start  = start[1];
  for (PetscInt i = 0; i < p->n_fluid; i++) p->row[i] = p->fluid_start + i;
  for (PetscInt w = 0; w < p->n_wall; w++) p->row[p->n_fluid + w] = p->wall_start + w;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  ParticlesReplace - Puts records in the place of the own particles and starts an epoch

  Collective. Together the ranks give each particle once, whoever owns it afterwards: owners, order
  and numbers that follow depend on the particles and the number of ranks alone.

  Input Parameters:
+ n      - how many records this rank gives
- record - as ParticlesPack() lays them out
*/
PetscErrorCode ParticlesReplace(const Scene *scene, Particles *p, PetscInt n,
                                const PetscReal record[])
{
  SortKey *keys;

  PetscFunctionBegin;
  PetscCall(SortRecords(scene, p, n, record, &keys));
  PetscCall(UnpackRecords(p, n, record, keys));
  PetscCall(PetscFree(keys));
  p->redraw = PETSC_TRUE;
  PetscCall(ParticlesUpdateEpoch(scene, p, PETSC_TRUE, NULL));
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
