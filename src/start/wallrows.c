/* Ordered rows of fluid particles along walls, for scenes whose spacing is a function of place.
   Each wall particle has one particle above it in each row. Row m fills the band from D(m) to D(m +
   1) along the normal, dD/dm = s(D), and its particles are at D(m + 1/2). Disorder beside walls has
   larger errors than disorder elsewhere: it changes the shear stress. */
#include "start.h"

/* Returns the height D(m) above a point of a wall, by the midpoint rule in steps of 1/2 [m]. */
static PetscReal RowHeight(const Scene *scene, const PetscReal foot[], const PetscReal normal[],
                           PetscReal m)
{
  PetscReal height = 0.0;

  for (PetscReal at = 0.0; at < m - 1e-9; at += 0.5) {
    PetscReal spacing = 0.0;

    for (PetscInt half = 0; half < 2; half++) {
      PetscReal x[ISPH_MAX_DIM] = {0.0};

      for (PetscInt a = 0; a < scene->dim; a++)
        x[a] = foot[a] + (height + 0.25 * spacing) * normal[a];
      spacing = SceneSpacing(scene, x);
    }
    height += 0.5 * spacing;
  }
  return height;
}

/* RowsHold - Returns true if x is in the bands of the rows of any wall */
PetscBool RowsHold(const Scene *scene, const PetscReal x[])
{
  WallPlane planes[WALL_PLANES];
  PetscInt  n;

  SceneWallPlanes(scene, x, (GRADING_ROWS + 1) * SceneCoarsest(scene), planes, &n);
  for (PetscInt k = 0; k < n; k++) {
    PetscReal foot[ISPH_MAX_DIM] = {0.0};

    if (!GradingHasRows(scene, planes[k].side)) continue;
    for (PetscInt a = 0; a < scene->dim; a++)
      foot[a] = x[a] - planes[k].distance * planes[k].normal[a];
    if (planes[k].distance < RowHeight(scene, foot, planes[k].normal, GRADING_ROWS))
      return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Returns true if no boundary is nearer to x than its own wall; of walls at the same distance, as
   along the bisector of a corner, the first one has the particle. Walls have whole numbers of
   particles, so that these distances differ by a share of the spacing. */
static PetscBool IsNearest(const Scene *scene, const PetscReal x[], PetscInt side, PetscReal height)
{
  const PetscReal slack = 0.25 * SceneSpacing(scene, x);
  WallPlane       planes[WALL_PLANES];
  PetscInt        n;

  SceneWallPlanes(scene, x, height + slack, planes, &n);
  for (PetscInt k = 0; k < n; k++) {
    if (planes[k].distance < height - slack || planes[k].side < side) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* RowsAdd - Adds a particle at x; the caller sets its index and rows->N */
PetscErrorCode RowsAdd(const Scene *scene, const PetscReal x[], Rows *rows)
{
  PetscFunctionBegin;
  if (rows->n == rows->capacity) {
    rows->capacity = 2 * rows->capacity + 64;
    PetscCall(PetscRealloc(sizeof(*rows->x) * (size_t)(rows->capacity * scene->dim), &rows->x));
    PetscCall(PetscRealloc(sizeof(*rows->index) * (size_t)rows->capacity, &rows->index));
  }
  for (PetscInt a = 0; a < scene->dim; a++) rows->x[rows->n * scene->dim + a] = x[a];
  rows->n++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the particles of all rows above a wall particle. */
static PetscErrorCode AddRows(const Scene *scene, const SurfacePoint *point, Rows *rows)
{
  PetscFunctionBegin;
  for (PetscInt m = 0; m < GRADING_ROWS; m++) {
    const PetscReal height          = RowHeight(scene, point->x, point->normal, m + 0.5);
    PetscReal       x[ISPH_MAX_DIM] = {0.0};

    for (PetscInt a = 0; a < scene->dim; a++) x[a] = point->x[a] + height * point->normal[a];
    if (IsNearest(scene, x, point->side, height)) PetscCall(RowsAdd(scene, x, rows));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* RowsCreate - Creates the particles of the rows above wall particles. Collective on
   PETSC_COMM_WORLD. Input: walls - in the order of sides. Output: rows - this rank's share; free
   with RowsDestroy(). */
PetscErrorCode RowsCreate(const Scene *scene, const Surfaces *walls, Rows *rows)
{
  PetscInt k = 0;

  PetscFunctionBegin;
  for (PetscInt side = 0; side < SceneBoundaries(scene); side++) {
    const PetscInt begin = rows->n;
    PetscInt       own, before = 0, all;

    for (; k < walls->n && walls->point[k].side == side; k++)
      if (GradingHasRows(scene, side)) PetscCall(AddRows(scene, &walls->point[k], rows));
    own = rows->n - begin;
    PetscCallMPI(MPI_Exscan(&own, &before, 1, MPIU_INT, MPI_SUM, PETSC_COMM_WORLD));
    PetscCallMPI(MPI_Allreduce(&own, &all, 1, MPIU_INT, MPI_SUM, PETSC_COMM_WORLD));
    for (PetscInt i = begin; i < rows->n; i++) rows->index[i] = rows->N + before + i - begin;
    rows->N += all;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* RowsDestroy - Frees the share */
PetscErrorCode RowsDestroy(Rows *rows)
{
  PetscFunctionBegin;
  PetscCall(FreeAll(&rows->x, &rows->index));
  PetscFunctionReturn(PETSC_SUCCESS);
}
