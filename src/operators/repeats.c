/*
  Rows that repeat. Particles on a lattice, away from walls, have neighbours at the same offsets, so
  their rows have the same weights to rounding, and are stored once. Rows are compared by all that
  they depend on: offsets, volumes and the order of columns.
*/
#include "assembly.h"

#define STEPS    1024.0 /* of offsets for the search, in a spacing */
#define SAME     1e-12  /* relative difference of equal sizes */
#define ROUNDING 64.0   /* of places, in units of the last digit */

/* A table of different rows: equal rows begin their search at the same place. */
typedef struct {
  const Scene     *scene;
  const Particles *p;
  const Pattern   *rows;
  PetscReal        tolerance; /* of offsets [m] */
  PetscInt         size, *of; /* a power of 2; row at each place, -1: none */
} RepeatTable;

/* Returns the place in the table at which the search for a row begins. */
static PetscInt PlaceOf(const RepeatTable *t, PetscInt i)
{
  const PetscReal steps = STEPS / t->scene->dx;
  PetscInt64      hash  = 0;

  for (PetscInt s = t->rows->row[i]; s < t->rows->row[i + 1]; s++) {
    for (PetscInt a = 0; a < t->p->dim; a++) {
      const PetscReal offset = t->p->x[a][t->rows->local[s]] - t->p->x[a][i];

      hash = (hash * 31 + (PetscInt64)PetscFloorReal(steps * offset + 0.5)) % ((PetscInt64)1 << 48);
    }
  }
  return (hash ^ (hash >> 24)) & (t->size - 1);
}

static inline PetscBool AreEqual(PetscReal a, PetscReal b)
{
  return PetscAbsReal(a - b) <= SAME * PetscAbsReal(a) ? PETSC_TRUE : PETSC_FALSE;
}

/* Returns true if rows i and c have equal weights. */
static PetscBool AreAlike(const RepeatTable *t, PetscInt i, PetscInt c)
{
  const Particles *p   = t->p;
  const PetscInt   n   = t->rows->row[i + 1] - t->rows->row[i];
  const PetscInt *of_i = &t->rows->local[t->rows->row[i]], *of_c = &t->rows->local[t->rows->row[c]];

  if (t->rows->row[c + 1] - t->rows->row[c] != n || !AreEqual(p->dx[i], p->dx[c]))
    return PETSC_FALSE;
  for (PetscInt a = 0; a < p->dim; a++)
    if (!AreEqual(ParticlesStretch(p, a, i), ParticlesStretch(p, a, c))) return PETSC_FALSE;
  for (PetscInt k = 0; k < n; k++) {
    const PetscInt j = of_i[k], e = of_c[k];

    if (!AreEqual(p->volume[j], p->volume[e])) return PETSC_FALSE;
    for (PetscInt a = 0; a < p->dim; a++) {
      const PetscReal difference = (p->x[a][j] - p->x[a][i]) - (p->x[a][e] - p->x[a][c]);

      if (PetscAbsReal(difference) > t->tolerance) return PETSC_FALSE;
    }
  }
  return PETSC_TRUE;
}

/*
  FindRepeats - Finds an earlier equal row of each row

  Not collective. Input: rows - the pattern. Input/Output: like - true for rows without walls whose
  columns are those of their neighbours; out: an earlier equal row, or the row itself.
*/
PetscErrorCode FindRepeats(const Scene *scene, const Particles *p, const Pattern *rows,
                           PetscInt like[])
{
  RepeatTable t       = {.scene = scene, .p = p, .rows = rows, .size = 64};
  PetscReal   largest = 0.0;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < scene->dim; a++)
    largest = PetscMax(largest, PetscMax(PetscAbsReal(scene->lo[a]), PetscAbsReal(scene->hi[a])));
  t.tolerance = ROUNDING * PETSC_MACHINE_EPSILON * largest;
  while (t.size < 2 * rows->n) t.size *= 2;
  PetscCall(PetscMalloc1(t.size, &t.of));
  for (PetscInt k = 0; k < t.size; k++) t.of[k] = -1;
  for (PetscInt i = 0; i < rows->n; i++) {
    const PetscBool comparable = like[i] && rows->row[i + 1] - rows->row[i] > 1;
    PetscInt        at;

    like[i] = i;
    if (!comparable) continue;
    at = PlaceOf(&t, i);
    while (t.of[at] >= 0 && !AreAlike(&t, i, t.of[at])) at = (at + 1) & (t.size - 1);
    if (t.of[at] >= 0) like[i] = t.of[at];
    else t.of[at] = i;
  }
  PetscCall(PetscFree(t.of));
  PetscFunctionReturn(PETSC_SUCCESS);
}
