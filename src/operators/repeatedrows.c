/* Rows that repeat, and runs of them. Particles on a lattice have neighbours at the same offsets,
   in the same places before a plane wall, so their rows have the same weights to rounding, and are
   stored once. Rows are compared by all that they depend on: offsets, volumes, the order of
   columns, and the boundaries of wall neighbours. */
#include "rows/assembly.h"

#define STEPS    1024.0 /* of offsets for the search, in a spacing */
#define SAME     1e-12  /* relative difference of equal sizes; difference of equal normals */
#define ROUNDING 64.0   /* of places, in units of the last digit */

/* A table of different rows: equal rows begin their search at the same place. */
typedef struct {
  const Scene        *scene;
  const Particles    *p;
  const OperatorRows *rows;
  PetscReal           tolerance; /* of offsets [m] */
  PetscInt            size, *of; /* a power of 2; row at each place, -1: none */
} RepeatTable;

/* Lists the fluid or wall neighbours of row i by local indices; returns their number. */
static inline PetscInt ListOf(const Pattern *pattern, PetscInt i, const PetscInt **local)
{
  *local = NULL;
  if (!pattern->row) return 0; /* no walls */
  *local = &pattern->local[pattern->row[i]];
  return pattern->row[i + 1] - pattern->row[i];
}

/* Returns the place in the table at which the search for a row begins. */
static PetscInt PlaceOf(const RepeatTable *t, PetscInt i)
{
  const PetscReal steps = STEPS / t->scene->dx;
  const PetscInt *local, n = ListOf(&t->rows->fluid, i, &local);
  PetscInt64      hash = 0;

  for (PetscInt k = 0; k < n; k++) {
    for (PetscInt a = 0; a < t->p->dim; a++) {
      const PetscReal offset = t->p->x[a][local[k]] - t->p->x[a][i];

      hash = (hash * 31 + (PetscInt64)PetscFloorReal(steps * offset + 0.5)) % ((PetscInt64)1 << 48);
    }
  }
  return (hash ^ (hash >> 24)) & (t->size - 1);
}

static inline PetscBool AreEqual(PetscReal a, PetscReal b)
{
  return PetscAbsReal(a - b) <= SAME * PetscAbsReal(a);
}

/* Returns true if wall particles j and e belong to the same boundary and have equal depths and
   normals. */
static PetscBool AreSameWall(const Particles *p, PetscInt j, PetscInt e)
{
  if (p->side[j] != p->side[e] || !AreEqual(p->depth[j], p->depth[e])) return PETSC_FALSE;
  for (PetscInt a = 0; a < p->dim; a++)
    if (PetscAbsReal(p->normal[a][j] - p->normal[a][e]) > SAME) return PETSC_FALSE;
  return PETSC_TRUE;
}

/* Returns true if rows i and c have the same neighbours of a pattern. */
static PetscBool HaveSame(const RepeatTable *t, const Pattern *pattern, PetscInt i, PetscInt c)
{
  const Particles *p = t->p;
  const PetscInt  *of_i, *of_c, n = ListOf(pattern, i, &of_i);

  if (ListOf(pattern, c, &of_c) != n) return PETSC_FALSE;
  for (PetscInt k = 0; k < n; k++) {
    const PetscInt j = of_i[k], e = of_c[k];

    if (!AreEqual(p->volume[j], p->volume[e])) return PETSC_FALSE;
    if (pattern == &t->rows->walls && !AreSameWall(p, j, e)) return PETSC_FALSE;
    for (PetscInt a = 0; a < p->dim; a++) {
      const PetscReal difference = (p->x[a][j] - p->x[a][i]) - (p->x[a][e] - p->x[a][c]);

      if (PetscAbsReal(difference) > t->tolerance) return PETSC_FALSE;
    }
  }
  return PETSC_TRUE;
}

/* Returns true if rows i and c have equal weights. */
static PetscBool AreAlike(const RepeatTable *t, PetscInt i, PetscInt c)
{
  const Particles *p = t->p;

  if (!AreEqual(p->dx[i], p->dx[c])) return PETSC_FALSE;
  for (PetscInt a = 0; a < p->dim; a++)
    if (!AreEqual(ParticlesStretch(p, a, i), ParticlesStretch(p, a, c))) return PETSC_FALSE;
  return HaveSame(t, &t->rows->fluid, i, c) && HaveSame(t, &t->rows->walls, i, c);
}

/* FindRepeats - Finds an earlier equal row of each row. Input: rows - the patterns. Input/Output:
   like - true for rows each of whose columns is that of a single neighbour; out: an earlier equal
   row, or the row itself. */
PetscErrorCode FindRepeats(const Scene *scene, const Particles *p, const OperatorRows *rows,
                           PetscInt like[])
{
  RepeatTable t       = {.scene = scene, .p = p, .rows = rows, .size = 64};
  PetscReal   largest = 0.0;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < scene->dim; a++)
    largest = PetscMax(largest, PetscMax(PetscAbsReal(scene->lo[a]), PetscAbsReal(scene->hi[a])));
  t.tolerance = ROUNDING * PETSC_MACHINE_EPSILON * largest;
  while (t.size < 2 * rows->fluid.n) t.size *= 2;
  PetscCall(PetscMalloc1(t.size, &t.of));
  for (PetscInt k = 0; k < t.size; k++) t.of[k] = -1;
  for (PetscInt i = 0; i < rows->fluid.n; i++) {
    const PetscBool comparable = like[i] && rows->fluid.row[i + 1] - rows->fluid.row[i] > 1;
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

/* Returns true if row i has no walls, repeats the row before it, and its columns are the next
   particles. */
static PetscBool ContinuesRun(const OperatorRows *rows, const PetscInt like[], PetscInt i)
{
  const PetscInt *of_i, *before, *walls, n = ListOf(&rows->fluid, i, &of_i);

  if (like[i] != like[i - 1] || ListOf(&rows->walls, i, &walls)) return PETSC_FALSE;
  (void)ListOf(&rows->fluid, i - 1, &before);
  for (PetscInt k = 0; k < n; k++)
    if (of_i[k] != before[k] + 1) return PETSC_FALSE;
  return PETSC_TRUE;
}

/* FindRuns - Lists runs of equal rows without walls whose columns follow each other, as along a
   line of a lattice. Input: like - of FindRepeats(). Output: rows->run - first row and number of
   rows of each run. */
PetscErrorCode FindRuns(const PetscInt like[], OperatorRows *rows)
{
  const PetscInt n = rows->fluid.n;

  PetscFunctionBegin;
  rows->n_runs = 0;
  for (PetscInt i = 0, end; i < n; i = end) {
    for (end = i + 1; end < n && ContinuesRun(rows, like, end);) end++;
    if (end - i < RUN_LANES) continue;
    if (rows->n_runs == rows->runs_capacity) {
      rows->runs_capacity = 2 * rows->runs_capacity + 64;
      PetscCall(PetscRealloc(sizeof(*rows->run) * (size_t)rows->runs_capacity, &rows->run));
    }
    rows->run[rows->n_runs][0]   = i;
    rows->run[rows->n_runs++][1] = end - i;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
