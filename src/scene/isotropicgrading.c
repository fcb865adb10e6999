/*
  Isotropic grading: the spacing as a function of place, the smaller of an expression typed by the
  user and of a spacing that grows with the distance from walls and bodies. Samples on a lattice
  give its bounds, which supports and time steps depend on, and its growth.
*/
#include "isph/scene.h"

#define SAMPLES 2 /* along an edge of a lattice cell */

/* Returns the distance of x from the nearest boundary without slip; zero behind it; infinite if
   there is none [m]. */
static PetscReal WallDistance(const Scene *scene, const PetscReal x[])
{
  PetscInt side;

  return PetscMax(SceneDistanceTo(scene, BOUNDARY_NO_SLIP | BOUNDARY_PARTICLES, x, &side), 0.0);
}

/* Returns the wanted spacing at x before bounds are applied [dx]. */
static PetscReal WantedSpacing(const Scene *scene, const PetscReal x[])
{
  const Grading *g     = &scene->grading;
  PetscReal      value = 1.0, y[ISPH_MAX_DIM] = {0.0};

  for (PetscInt a = 0; a < scene->dim; a++) {
    const PetscReal length = scene->hi[a] - scene->lo[a];

    y[a] = x[a];
    if (SceneIsPeriodic(scene, a)) y[a] -= length * PetscFloorReal((x[a] - scene->lo[a]) / length);
  }
  if (g->spacing.n) value = ExpressionValue(&g->spacing, 0, 0.0, y);
  if (g->growth > 0.0) {
    const PetscReal rows = GRADING_ROWS * scene->spacing_wall;
    const PetscReal way  = PetscMax(WallDistance(scene, y) / scene->dx - rows, 0.0);

    value = PetscMin(value, scene->spacing_wall + g->growth * way);
  }
  return value;
}

/* GradingSpacing - Returns the spacing at x of isotropic grading, within the bounds of its samples
   [m]; not collective */
PetscReal GradingSpacing(const Scene *scene, const PetscReal x[])
{
  const PetscReal wanted = scene->dx * WantedSpacing(scene, x);

  return PetscMin(PetscMax(wanted, scene->grading.least), scene->grading.most);
}

/* Returns the growth of the spacing about x from a particle to the next, by differences that stay
   in the box [-]. */
static PetscReal GrowthAt(const Scene *scene, const PetscReal x[], PetscReal spacing)
{
  const PetscReal step = 0.25 * spacing * scene->dx;
  PetscReal       sum = 0.0, y[ISPH_MAX_DIM] = {0.0};

  for (PetscInt a = 0; a < scene->dim; a++) y[a] = x[a];
  for (PetscInt a = 0; a < scene->dim; a++) {
    PetscReal low = x[a] - step, high = x[a] + step, difference;

    if (!SceneIsPeriodic(scene, a)) {
      low  = PetscMax(low, scene->lo[a]);
      high = PetscMin(high, scene->hi[a]);
    }
    y[a]       = high;
    difference = WantedSpacing(scene, y);
    y[a]       = low;
    difference -= WantedSpacing(scene, y);
    y[a] = x[a];
    sum += PetscSqr(difference * scene->dx / (high - low));
  }
  return PetscSqrtReal(sum);
}

/* Returns the spacing on a side of the box in 3D, or 0 if it differs between lattice points of the
   side [m]. */
static PetscReal EvenSpacing(const Scene *scene, PetscInt side)
{
  const PetscInt a = (side / 2 + 1) % 3, b = (side / 2 + 2) % 3, along = scene->cells[a] + 1;
  PetscReal      x[ISPH_MAX_DIM], even = 0.0;

  x[side / 2] = side % 2 ? scene->hi[side / 2] : scene->lo[side / 2];
  for (PetscInt k = 0; k < along * (scene->cells[b] + 1); k++) {
    PetscReal spacing;

    x[a]    = scene->lo[a] + k % along * SceneCellSide(scene, a);
    x[b]    = scene->lo[b] + k / along * SceneCellSide(scene, b);
    spacing = GradingSpacing(scene, x);
    if (k && PetscAbsReal(spacing - even) > 1e-6 * even) return 0.0;
    even = spacing;
  }
  return even;
}

/* GradingHasRows - Returns true if ordered rows of particles follow a boundary: in 3D the spacing
   on it must be even; not collective */
PetscBool GradingHasRows(const Scene *scene, PetscInt side)
{
  if (scene->dim == 2) return PETSC_TRUE;
  return !BoundaryBody(scene, side) && scene->grading.even[side] > 0.0;
}

/*
  GradingSample - Samples the wanted spacing in the fluid on a lattice of dx/2 and sets the bounds
  of the spacing, its growth, and the volume of particles that have the velocity of the flow

  Collective. Each rank samples a contiguous range of points. The samples include walls, where the
  spacing of isotropic grading from walls has its least value.
*/
PetscErrorCode GradingSample(Scene *scene)
{
  Grading    *g = &scene->grading;
  PetscInt    count[ISPH_MAX_DIM], cells, least_side = SceneBoundaries(scene);
  PetscInt64  total    = 1;
  PetscReal   bound[3] = {0.0, 0.0, 0.0}; /* -least, most [dx], growth */
  PetscReal   sum[2]   = {0.0, 0.0};      /* of volumes [dx^dim], and of their squares */
  PetscMPIInt rank, ranks;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &ranks));
  PetscCall(SceneCountCells(scene->dim, scene->cells, &cells));
  for (PetscInt a = 0; a < scene->dim; a++) {
    count[a] = SAMPLES * scene->cells[a] + 1;
    total *= count[a];
  }
  bound[0] = -PETSC_MAX_REAL;
  for (PetscInt64 k = total * rank / ranks; k < total * (rank + 1) / ranks; k++) {
    PetscReal  x[ISPH_MAX_DIM] = {0.0}, spacing, volume;
    PetscInt64 index           = k;

    for (PetscInt a = 0; a < scene->dim; a++) {
      x[a] = scene->lo[a] + (scene->hi[a] - scene->lo[a]) * (PetscReal)(index % count[a]) /
                                (PetscReal)(count[a] - 1);
      index /= count[a];
    }
    if (SceneFluidDistance(scene, x, &least_side) < -scene->dx) continue;
    spacing  = WantedSpacing(scene, x);
    bound[0] = PetscMax(bound[0], -spacing);
    bound[1] = PetscMax(bound[1], spacing);
    bound[2] = PetscMax(bound[2], GrowthAt(scene, x, spacing));
    volume   = PetscPowRealInt(spacing, (int)scene->dim);
    sum[0] += volume;
    sum[1] += PetscSqr(volume);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, bound, 3, MPIU_REAL, MPIU_MAX, PETSC_COMM_WORLD));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 2, MPIU_REAL, MPIU_SUM, PETSC_COMM_WORLD));
  scene->motion_volume = SceneVolume(scene) * sum[1] / sum[0];
  g->least             = -bound[0] * scene->dx;
  g->most              = bound[1] * scene->dx;
  g->growth_most       = bound[2];
  for (PetscInt side = 0; side < 2 * scene->dim && scene->dim == 3; side++)
    g->even[side] = EvenSpacing(scene, side);
  PetscFunctionReturn(PETSC_SUCCESS);
}
