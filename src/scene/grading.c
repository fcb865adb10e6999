/* Gradings. Lattices whose cells are smaller at walls are the product of a map along each axis; an
   axis without a map is uniform. Isotropic grading is the spacing as a function of place, the
   smaller of an expression typed by the user and of a spacing that grows with the distance from
   walls and bodies; samples on a lattice give its bounds, which supports and time steps depend on,
   and its growth. */
#include "isph/scene.h"

#define SAMPLES 2 /* along an edge of a lattice cell */

/* SceneIsMapped - Returns true if cells of the lattice differ */
PetscBool SceneIsMapped(const Scene *scene)
{
  for (PetscInt a = 0; a < scene->dim; a++)
    if (scene->map[a].strength > 0.0) return PETSC_TRUE;
  return PETSC_FALSE;
}

/*
  Returns the place y in [0, 1] of a point s in [0, 1] of the uniform lattice

    y = (1 + tanh(beta (2 s - 1))/tanh beta)/2   between two walls
    y = 1 + tanh(beta (s - 1))/tanh beta         from a wall at the low end

  Reference: M. Vinokur, J. Comput. Phys. 50 (1983) 215-234
*/
static PetscReal MapForward(const LatticeMap *map, PetscReal s)
{
  const PetscReal beta = map->strength, end = map->end;

  if (map->wall[0] && map->wall[1]) return 0.5 + 0.5 * PetscTanhReal(beta * (2.0 * s - 1.0)) / end;
  return map->wall[0] ? 1.0 + PetscTanhReal(beta * (s - 1.0)) / end : PetscTanhReal(beta * s) / end;
}

/* Returns the slope dy/ds of MapForward(). */
static PetscReal MapSlope(const LatticeMap *map, PetscReal s)
{
  const PetscReal beta = map->strength;
  const PetscReal t = map->wall[0] && map->wall[1] ? 2.0 * s - 1.0 : (map->wall[0] ? s - 1.0 : s);

  return beta / (map->end * PetscSqr(PetscCoshReal(beta * t)));
}

/* Returns the point s of the uniform lattice whose place is y; the inverse of MapForward(). */
static PetscReal MapBack(const LatticeMap *map, PetscReal y)
{
  const PetscReal beta = map->strength, end = map->end;

  if (map->wall[0] && map->wall[1]) return 0.5 + 0.5 * PetscAtanhReal((2.0 * y - 1.0) * end) / beta;
  return map->wall[0] ? 1.0 + PetscAtanhReal((y - 1.0) * end) / beta
                      : PetscAtanhReal(y * end) / beta;
}

/* Solves 2 beta/sinh(2 beta) = ratio, the slope of the map at a wall, by bisection. */
static PetscReal MapStrength(PetscReal ratio)
{
  PetscReal low = 0.0, high = 8.0; /* a ratio below 1e-5 */

  for (PetscInt k = 0; k < 60; k++) {
    const PetscReal beta = 0.5 * (low + high);

    if (2.0 * beta > ratio * PetscSinhReal(2.0 * beta)) low = beta;
    else high = beta;
  }
  return 0.5 * (low + high);
}

/* SceneLatticePlace - Returns the coordinate of a place on the lattice, given in cells from the low
   end of an axis [m] */
PetscReal SceneLatticePlace(const Scene *scene, PetscInt axis, PetscReal place)
{
  const LatticeMap *map = &scene->map[axis];

  if (map->strength == 0.0) return scene->lo[axis] + place * SceneCellSide(scene, axis);
  return scene->lo[axis] +
         (scene->hi[axis] - scene->lo[axis]) * MapForward(map, place / scene->cells[axis]);
}

/* SceneFromUniform - Returns the coordinate x of the point that has the coordinate y on the uniform
   lattice, and sets slope to dx/dy [m], [-] */
PetscReal SceneFromUniform(const Scene *scene, PetscInt axis, PetscReal y, PetscReal *slope)
{
  const LatticeMap *map    = &scene->map[axis];
  const PetscReal   length = scene->hi[axis] - scene->lo[axis], s = (y - scene->lo[axis]) / length;

  *slope = 1.0;
  if (map->strength == 0.0) return y;
  *slope = MapSlope(map, s);
  return scene->lo[axis] + length * MapForward(map, s);
}

/* SceneToUniform - Returns the coordinate on the uniform lattice of a point at x, or of the nearest
   end of the axis if x is outside the box, the inverse of SceneFromUniform() [m] */
PetscReal SceneToUniform(const Scene *scene, PetscInt axis, PetscReal x)
{
  const LatticeMap *map    = &scene->map[axis];
  const PetscReal   length = scene->hi[axis] - scene->lo[axis];

  if (map->strength == 0.0) return x;
  return scene->lo[axis] +
         length * MapBack(map, PetscMin(PetscMax((x - scene->lo[axis]) / length, 0.0), 1.0));
}

/* SceneCellSide - Returns the mean edge of the cells of the lattice along an axis [m]; it equals dx
   if the length of the box is a multiple of dx */
PetscReal SceneCellSide(const Scene *scene, PetscInt axis)
{
  return (scene->hi[axis] - scene->lo[axis]) / scene->cells[axis];
}

/* SceneCellsAlong - Returns the number of cells of the reference spacing along an axis */
PetscInt SceneCellsAlong(const Scene *scene, PetscInt axis)
{
  return (PetscInt)PetscFloorReal((scene->hi[axis] - scene->lo[axis]) / scene->dx + 0.5);
}

/* SceneCountCells - Computes the product of n numbers of cells, and refuses numbers that are too
   large for indices of particles; collective on PETSC_COMM_WORLD */
PetscErrorCode SceneCountCells(PetscInt n, const PetscInt count[], PetscInt *cells)
{
  PetscInt64 product = 1;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < n; k++) {
    product *= count[k];
    UserCheck(product < PETSC_INT_MAX / 8,
              "-n asks for more particles than fit: more than %" PetscInt_FMT, PETSC_INT_MAX / 8);
  }
  *cells = (PetscInt)product;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SceneEdges - Computes the edges of a cell of the lattice that is centred at x, or that is nearest
   to x in the half of a cell beside a side of the box [m] */
void SceneEdges(const Scene *scene, const PetscReal x[], PetscReal edge[])
{
  for (PetscInt a = 0; a < scene->dim; a++) {
    const LatticeMap *map    = &scene->map[a];
    const PetscReal   length = scene->hi[a] - scene->lo[a], half = 0.5 / scene->cells[a];
    PetscReal         s = (x[a] - scene->lo[a]) / length;

    edge[a] = SceneCellSide(scene, a);
    if (map->strength == 0.0) continue;
    s       = MapBack(map, PetscMin(PetscMax(s, 0.0), 1.0));
    s       = PetscMin(PetscMax(s, half), 1.0 - half);
    edge[a] = length * (MapForward(map, s + half) - MapForward(map, s - half));
  }
}

/* LatticeGrowth - Returns the largest growth of the edges of the lattice from a cell to the next
   [-] */
PetscReal LatticeGrowth(const Scene *scene)
{
  PetscReal growth = 0.0;

  for (PetscInt a = 0; a < scene->dim; a++) {
    const LatticeMap *map   = &scene->map[a];
    const PetscReal   sides = map->wall[0] && map->wall[1] ? 4.0 : 2.0;

    growth =
        PetscMax(growth, sides * map->strength * PetscTanhReal(map->strength) / scene->cells[a]);
  }
  return growth;
}

/*
  LatticeMotionEdge - Returns the mean of e^2 over the mean of e along an axis, with the edge e of
  the cells [m]. Means are over the coordinate x. With T = tanh(beta) and the slope y' of the map

    int y'^3 ds / int y'^2 ds = beta/T (1 - 2 T^2/3 + T^4/5)/(1 - T^2/3)

  times the mean edge, for a map from one wall and between two walls.
*/
PetscReal LatticeMotionEdge(const Scene *scene, PetscInt axis)
{
  const PetscReal beta = scene->map[axis].strength, T = scene->map[axis].end;

  if (beta == 0.0) return SceneCellSide(scene, axis);
  return SceneCellSide(scene, axis) * (beta / T) *
         (1.0 - 2.0 * T * T / 3.0 + PetscSqr(T * T) / 5.0) / (1.0 - T * T / 3.0);
}

/* LatticeSetMap - Sets the map of an axis from scene->spacing_wall; sides that are walls with no
   slip have smaller cells */
void LatticeSetMap(Scene *scene, PetscInt axis)
{
  LatticeMap     *map = &scene->map[axis];
  const PetscReal n   = scene->cells[axis];
  PetscReal       first, middle;

  map->least = map->most = SceneCellSide(scene, axis);
  for (PetscInt end = 0; end < 2; end++)
    map->wall[end] = BoundaryIs(scene, 2 * axis + end, BOUNDARY_NO_SLIP);
  if (!map->wall[0] && !map->wall[1]) return;
  map->strength = MapStrength(scene->spacing_wall);
  map->end      = PetscTanhReal(map->strength);
  first         = map->wall[0] ? 1.0 : n;
  middle        = map->wall[0] && map->wall[1] ? 0.5 * n + 0.5 : (map->wall[0] ? n : 1.0);
  if (!SceneMoves(scene)) middle = PetscFloorReal(middle); /* particles are in cells */
  map->least = SceneLatticePlace(scene, axis, first) - SceneLatticePlace(scene, axis, first - 1.0);
  map->most = SceneLatticePlace(scene, axis, middle) - SceneLatticePlace(scene, axis, middle - 1.0);
}

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
   [m] */
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
   on it must be even */
PetscBool GradingHasRows(const Scene *scene, PetscInt side)
{
  if (scene->dim == 2) return PETSC_TRUE;
  return !BoundaryBody(scene, side) && scene->grading.even[side] > 0.0;
}

/* GradingSample - Samples the wanted spacing in the fluid on a lattice of dx/2 and sets the bounds
   of the spacing, its growth, and the volume of particles that have the velocity of the flow.
   Collective. Each rank samples a contiguous range of points. The samples include walls, where the
   spacing of isotropic grading from walls has its least value. */
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
