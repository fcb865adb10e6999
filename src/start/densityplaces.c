/*
  First places of particles whose spacing is a function of place. A region is divided into cells of
  the largest spacing. Along a path through all cells the wanted number of particles is summed up,

    M = int dV/s^n,   s: spacing,

  and a cell receives as many particles as the rounded sum grows by in it. Within a cell, bisections
  give each particle the same share of M. Sums are whole numbers, so places do not depend on the
  number of ranks. They are those of a lattice if s has its largest value everywhere.
*/
#include "start.h"

#define UNIT       ((PetscReal)((PetscInt64)1 << 32)) /* a particle, in whole numbers of M */
#define LEAF_SHARE 2.0 /* half the points of the quadrature along the smallest spacing of a cell */

/* Points of the midpoint rule in a cell. */
typedef struct {
  PetscInt   n, along; /* all of them, and along an axis */
  PetscInt  *order;    /* their indices, permuted by bisections */
  PetscReal *x, *mass; /* coordinates of each [m], share of M; zero outside the fluid */
  PetscReal *key;
} Leaves;

/* RegionSetBox - Sets a region to the box of the fluid */
void RegionSetBox(const Scene *scene, Region *region)
{
  *region = (Region){.n = scene->dim};
  for (PetscInt a = 0; a < scene->dim; a++) region->axis[a] = a;
}

/* RegionSetSide - Sets a region to a side of the box */
void RegionSetSide(const Scene *scene, PetscInt side, Region *region)
{
  *region = (Region){0};
  for (PetscInt a = 0; a < scene->dim; a++) {
    region->x[a] = side % 2 ? scene->hi[a] : scene->lo[a];
    if (a != side / 2) region->axis[region->n++] = a;
  }
}

/* Returns the number of cells along axis m of a region. */
static PetscInt CellsAlong(const Scene *scene, const Region *region, PetscInt m)
{
  const PetscReal ratio = scene->dx / SceneCoarsest(scene);

  return PetscMax(
      1, (PetscInt)PetscFloorReal(scene->cells[region->axis[m]] * ratio * (1.0 + 1e-9) + 1e-9));
}

/* Computes the corners of cell `index` of the path, whose direction along an axis alternates. */
static void CellAt(const Scene *scene, const Region *region, PetscInt index, PetscReal lo[],
                   PetscReal hi[])
{
  PetscInt rest = index, cell[ISPH_MAX_DIM];

  for (PetscInt m = 0; m < region->n; m++) {
    const PetscInt count = CellsAlong(scene, region, m);

    cell[m] = rest % count;
    rest /= count;
    if (rest % 2) cell[m] = count - 1 - cell[m];
  }
  for (PetscInt m = 0; m < region->n; m++) {
    const PetscInt  a    = region->axis[m];
    const PetscReal edge = (scene->hi[a] - scene->lo[a]) / CellsAlong(scene, region, m);

    lo[m] = scene->lo[a] + cell[m] * edge;
    hi[m] = scene->lo[a] + (cell[m] + 1) * edge;
  }
}

/* Returns the number of points of the midpoint rule along an axis of a cell. */
static PetscInt PointsAlong(const Scene *scene, const Region *region, const PetscReal lo[],
                            const PetscReal hi[])
{
  PetscReal least = PETSC_MAX_REAL, edge = 0.0, x[ISPH_MAX_DIM];

  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) x[a] = region->x[a];
  for (PetscInt corner = 0; corner <= 1 << region->n; corner++) {
    for (PetscInt m = 0; m < region->n; m++) {
      x[region->axis[m]] = (corner >> m) & 1 ? hi[m] : lo[m];
      if (corner == 1 << region->n) x[region->axis[m]] = 0.5 * (lo[m] + hi[m]);
      edge = PetscMax(edge, hi[m] - lo[m]);
    }
    least = PetscMin(least, SceneSpacing(scene, x));
  }
  return 2 * (PetscInt)PetscCeilReal(LEAF_SHARE * (edge / least) - 0.1);
}

static PetscErrorCode LeavesFree(Leaves *leaves)
{
  PetscFunctionBegin;
  PetscCall(PetscFree4(leaves->order, leaves->x, leaves->mass, leaves->key));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns true if a cell may be in a pool, by the depth of its middle. */
static PetscBool MayHold(const Pools *pools, const Region *region, const PetscReal lo[],
                         const PetscReal hi[])
{
  PetscReal x[ISPH_MAX_DIM] = {0.0}, half = 0.0, depth;

  for (PetscInt m = 0; m < region->n; m++) {
    x[region->axis[m]] = 0.5 * (lo[m] + hi[m]);
    half += 0.25 * PetscSqr(hi[m] - lo[m]);
  }
  (void)PoolAt(pools, x, &depth);
  return depth > -PetscSqrtReal(half);
}

/* Computes the points of a cell, none if it is empty, and the sums of their shares of M and of
   their volumes. */
static PetscErrorCode LeavesCreate(const Scene *scene, const Region *region, const Pools *pools,
                                   PetscInt index, Leaves *leaves, PetscReal *mass,
                                   PetscReal *volume)
{
  const PetscInt n = region->n;
  PetscReal      lo[ISPH_MAX_DIM], hi[ISPH_MAX_DIM], x[ISPH_MAX_DIM], part = 1.0;

  PetscFunctionBegin;
  CellAt(scene, region, index, lo, hi);
  leaves->along = pools && !MayHold(pools, region, lo, hi) ? 0 : PointsAlong(scene, region, lo, hi);
  leaves->n     = 1;
  for (PetscInt m = 0; m < n; m++) {
    leaves->n *= leaves->along;
    if (leaves->n) part *= (hi[m] - lo[m]) / leaves->along / SceneCellSide(scene, region->axis[m]);
  }
  PetscCall(PetscMalloc4(leaves->n, &leaves->order, leaves->n * n, &leaves->x, leaves->n,
                         &leaves->mass, leaves->n, &leaves->key));
  *mass = *volume = 0.0;
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) x[a] = region->x[a];
  for (PetscInt k = 0; k < leaves->n; k++) {
    PetscInt  rest = k, body;
    PetscReal normal[ISPH_MAX_DIM], share = part;

    for (PetscInt m = 0; m < n; m++) {
      leaves->x[k * n + m] =
          lo[m] + (hi[m] - lo[m]) * ((rest % leaves->along) + 0.5) / leaves->along;
      x[region->axis[m]] = leaves->x[k * n + m];
      rest /= leaves->along;
    }
    if (SceneDistance(scene, x, &body, normal) <= 0.0) share = 0.0;
    *volume += share;
    if (pools && !PoolsHold(pools, x)) share = 0.0;
    if (share > 0.0 && !pools && n == scene->dim && RowsHold(scene, x)) share = 0.0;
    for (PetscInt m = 0; m < n && share > 0.0; m++) share *= scene->dx / SceneSpacing(scene, x);
    leaves->mass[k]  = share;
    leaves->order[k] = k;
    *mass += share;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sorts entries [first, last) of the order along the longest edge of the box around them. */
static PetscErrorCode SortLongest(PetscInt n, Leaves *leaves, PetscInt first, PetscInt last)
{
  const PetscInt S      = leaves->along;
  PetscInt       stride = 1, longest = 0, widest = -1;

  PetscFunctionBegin;
  for (PetscInt m = 0; m < n; m++, stride *= S) {
    PetscInt low = S, high = -1;

    for (PetscInt k = first; k < last; k++) {
      low  = PetscMin(low, leaves->order[k] / stride % S);
      high = PetscMax(high, leaves->order[k] / stride % S);
    }
    if (high - low <= widest) continue;
    widest  = high - low;
    longest = m;
  }
  stride = 1;
  for (PetscInt m = 0; m < longest; m++) stride *= S;
  for (PetscInt k = first; k < last; k++) /* ties in the order of indices */
    leaves->key[k] = (PetscReal)(leaves->order[k] / stride % S) +
                     0.5 * (PetscReal)leaves->order[k] / (PetscReal)leaves->n;
  PetscCall(PetscSortRealWithArrayInt(last - first, &leaves->key[first], &leaves->order[first]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes the places of k particles in entries [first, last) of the order to x, by bisections; each
   is the centre of an equal share of M. */
static PetscErrorCode Bisect(PetscInt n, Leaves *leaves, PetscInt first, PetscInt last, PetscInt k,
                             PetscReal x[])
{
  PetscReal sum = 0.0, half = 0.0, centre[ISPH_MAX_DIM] = {0.0};
  PetscInt  cut = first;

  PetscFunctionBegin;
  for (PetscInt l = first; l < last; l++) {
    sum += leaves->mass[leaves->order[l]];
    for (PetscInt m = 0; m < n; m++)
      centre[m] += leaves->mass[leaves->order[l]] * leaves->x[leaves->order[l] * n + m];
  }
  if (k == 1) {
    for (PetscInt m = 0; m < n; m++) x[m] = centre[m] / sum;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SortLongest(n, leaves, first, last));
  while (half + 0.5 * leaves->mass[leaves->order[cut]] < sum * (k / 2) / k)
    half += leaves->mass[leaves->order[cut++]];
  PetscCall(Bisect(n, leaves, first, cut, k / 2, x));
  PetscCall(Bisect(n, leaves, cut, last, k - k / 2, &x[(k / 2) * n]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sums up M and the volume of this rank's cells of the path, and of the cells before them, in
   whole numbers. */
static PetscErrorCode SumCells(const Scene *scene, const Region *region, const Pools *pools,
                               PetscInt first, PetscInt last, PetscInt64 before[2],
                               PetscInt64 all[2])
{
  PetscInt64 own[2] = {0, 0};

  PetscFunctionBegin;
  before[0] = before[1] = 0;
  for (PetscInt c = first; c < last; c++) {
    Leaves    leaves;
    PetscReal mass, volume;

    PetscCall(LeavesCreate(scene, region, pools, c, &leaves, &mass, &volume));
    PetscCall(LeavesFree(&leaves));
    own[0] += (PetscInt64)(mass * UNIT + 0.5);
    own[1] += (PetscInt64)(volume * UNIT + 0.5);
  }
  PetscCallMPI(MPI_Exscan(own, before, 2, MPIU_INT64, MPI_SUM, PETSC_COMM_WORLD));
  PetscCallMPI(MPI_Allreduce(own, all, 2, MPIU_INT64, MPI_SUM, PETSC_COMM_WORLD));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* PlacesCreate - Creates the first places of the particles of a region. Collective on
   PETSC_COMM_WORLD. Each rank creates the places in a contiguous part of the path. Input: pools -
   the fluid at the start; NULL if it fills the region. Output: places - this rank's share; free
   with PlacesDestroy(). */
PetscErrorCode PlacesCreate(const Scene *scene, const Region *region, const Pools *pools,
                            Places *places)
{
  const PetscInt64 half = (PetscInt64)(0.5 * UNIT);
  PetscInt64       before[2], all[2], end;
  PetscInt         count[ISPH_MAX_DIM], cells, first, last, n = 0;

  PetscFunctionBegin;
  for (PetscInt m = 0; m < region->n; m++) count[m] = CellsAlong(scene, region, m);
  PetscCall(SceneCountCells(region->n, count, &cells));
  ParticlesShare(PETSC_COMM_WORLD, cells, &first, &last);
  PetscCall(SumCells(scene, region, pools, first, last, before, all));
  places->dim = region->n;
  places->N   = (PetscInt)((all[0] + half) >> 32);
  PetscCall(SceneCountCells(1, &places->N, &places->N));
  places->first  = (PetscInt)((before[0] + half) >> 32);
  places->volume = (PetscReal)all[1] / UNIT;
  places->n      = 0;
  PetscCall(PetscMalloc1(1, &places->x));
  for (PetscInt c = first; c < last; c++, before[0] = end) {
    Leaves    leaves;
    PetscReal mass, volume;
    PetscInt  k;

    PetscCall(LeavesCreate(scene, region, pools, c, &leaves, &mass, &volume));
    end = before[0] + (PetscInt64)(mass * UNIT + 0.5);
    k   = (PetscInt)(((end + half) >> 32) - ((before[0] + half) >> 32));
    if ((places->n + k) > n) {
      n = 2 * (places->n + k) + 64;
      PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)(n * region->n), &places->x));
    }
    if (k) PetscCall(Bisect(region->n, &leaves, 0, leaves.n, k, &places->x[places->n * region->n]));
    places->n += k;
    PetscCall(LeavesFree(&leaves));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* PlacesDestroy - Frees the places */
PetscErrorCode PlacesDestroy(Places *places)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(places->x));
  PetscFunctionReturn(PETSC_SUCCESS);
}
