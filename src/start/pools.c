/* Pools: the connected parts of the fluid at the start of a run. Filled regions that touch form a
   pool. Pools whose borders are lines along the axes have a lattice (poollattice.c); the particles
   of other pools are relaxed (densityplaces.c, relax.c). All particles of a pool have the same
   share of its volume. */
#include "start.h"
#include <string.h>

#define POINTS 8   /* of the quadrature of volumes, along dx */
#define TOUCH  0.5 /* gap below which regions touch [dx] */

/* Computes the part of a filled region in the box, along an axis. */
static void SpanInBox(const Scene *scene, PetscInt region, PetscInt axis, PetscReal span[2])
{
  BodySpan(&scene->filled[region], axis, span);
  span[0] = PetscMax(span[0], scene->lo[axis]);
  span[1] = PetscMin(span[1], scene->hi[axis]);
}

/* Returns true if two filled regions touch, by the boxes around them. */
static PetscBool RegionsTouch(const Scene *scene, PetscInt k, PetscInt m)
{
  for (PetscInt a = 0; a < scene->dim; a++) {
    PetscReal one[2], two[2];

    SpanInBox(scene, k, a, one);
    SpanInBox(scene, m, a, two);
    if (PetscMax(one[0], two[0]) - PetscMin(one[1], two[1]) > TOUCH * scene->dx) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* Joins the regions that touch, directly or through others, and numbers the pools. */
static void JoinRegions(const Scene *scene, Pools *pools)
{
  PetscBool changed = PETSC_TRUE;

  for (PetscInt k = 0; k < scene->n_filled; k++) pools->of[k] = k;
  while (changed) {
    changed = PETSC_FALSE;
    for (PetscInt k = 0; k < scene->n_filled; k++) {
      for (PetscInt m = 0; m < k; m++) {
        const PetscInt first = PetscMin(pools->of[k], pools->of[m]);

        if (pools->of[k] == pools->of[m] || !RegionsTouch(scene, k, m)) continue;
        pools->of[k] = pools->of[m] = first;
        changed                     = PETSC_TRUE;
      }
    }
  }
  for (PetscInt k = 0; k < scene->n_filled; k++)
    pools->of[k] = pools->of[k] == k ? pools->n++ : pools->of[pools->of[k]];
}

/* Returns the part of a small cube of edge s about x that is in a pool and outside bodies, exact if
   a single plane along the axes cuts the cube [-]. */
static PetscReal PartInside(const Pools *pools, PetscInt pool, const PetscReal x[], PetscReal s)
{
  PetscReal part = 0.0, solid, normal[ISPH_MAX_DIM];
  PetscInt  body;

  for (PetscInt k = 0; k < pools->scene->n_filled; k++) {
    if (pools->of[k] != pool) continue;
    part += PetscMin(PetscMax(0.5 + SceneFilledDistance(pools->scene, k, x) / s, 0.0), 1.0);
  }
  solid = SceneDistance(pools->scene, x, &body, normal);
  return PetscMin(part, 1.0) * PetscMin(PetscMax(0.5 + solid / s, 0.0), 1.0);
}

/* Computes the box around a pool, of height 1 in 2D; returns true if all of its regions, and all
   bodies, are the same at every z. */
static PetscBool BoxAround(const Pools *pools, PetscInt pool, PetscReal lo[], PetscReal hi[])
{
  const Scene *scene = pools->scene;
  PetscBool    even  = PETSC_TRUE;

  lo[2] = 0.0;
  hi[2] = 1.0;
  for (PetscInt a = 0; a < scene->dim; a++) {
    lo[a] = PETSC_MAX_REAL;
    hi[a] = -PETSC_MAX_REAL;
    for (PetscInt k = 0; k < scene->n_filled; k++) {
      PetscReal span[2];

      if (pools->of[k] != pool) continue;
      if (scene->dim == 3 && !BodyReachesThrough(&scene->filled[k], 2)) even = PETSC_FALSE;
      SpanInBox(scene, k, a, span);
      lo[a] = PetscMin(lo[a], span[0]);
      hi[a] = PetscMax(hi[a], span[1]);
    }
  }
  for (PetscInt b = 0; b < scene->n_bodies && scene->dim == 3; b++)
    if (!BodyReachesThrough(SceneBody(scene, b), 2)) even = PETSC_FALSE;
  return even;
}

/* The midpoint rule in the box around a pool: cells of about dx, each with POINTS along an axis. */
typedef struct {
  PetscReal lo[ISPH_MAX_DIM], edge[ISPH_MAX_DIM];      /* low corner; edges of cells [m] */
  PetscInt n[ISPH_MAX_DIM], points[ISPH_MAX_DIM], all; /* cells; points of a cell along axes, all */
  PetscReal unit;                                      /* of sums in whole numbers, a point */
} Quadrature;

/* Computes the place of a part of a cell, in the middle for a single part along each axis. */
static void PartAt(const Quadrature *q, PetscInt64 cell, const PetscInt parts[], PetscInt part,
                   PetscReal x[])
{
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) {
    x[a] = q->lo[a] + q->edge[a] * (cell % q->n[a] + (part % parts[a] + 0.5) / parts[a]);
    cell /= q->n[a];
    part /= parts[a];
  }
}

/* Returns the depth of x inside a pool and outside bodies [m]. */
static PetscReal DepthInside(const Pools *pools, PetscInt pool, const PetscReal x[])
{
  PetscReal depth = -PETSC_INFINITY, normal[ISPH_MAX_DIM];
  PetscInt  body;

  for (PetscInt k = 0; k < pools->scene->n_filled; k++)
    if (pools->of[k] == pool) depth = PetscMax(depth, SceneFilledDistance(pools->scene, k, x));
  return PetscMin(depth, SceneDistance(pools->scene, x, &body, normal));
}

/* Returns the part of a cell in a pool, in whole numbers; no border is in a cell whose middle is
   far from all of them, so that its points need not be visited. */
static PetscInt64 SumCell(const Pools *pools, PetscInt pool, const Quadrature *q, PetscInt64 cell)
{
  const PetscInt  middle[ISPH_MAX_DIM] = {1, 1, 1};
  const PetscReal s                    = q->edge[0] / POINTS;
  PetscReal       x[ISPH_MAX_DIM], reach = 0.5 * s, depth;
  PetscInt64      sum = 0;

  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) reach += q->points[a] > 1 ? 0.5 * q->edge[a] : 0.0;
  PartAt(q, cell, middle, 0, x);
  depth = DepthInside(pools, pool, x);
  if (depth >= reach) return (PetscInt64)q->unit * q->all;
  for (PetscInt k = 0; k < q->all && depth > -reach; k++) {
    PartAt(q, cell, q->points, k, x);
    sum += (PetscInt64)(q->unit * PartInside(pools, pool, x, s) + 0.5);
  }
  return sum;
}

/* Returns true if a pool is a ball that nothing cuts, whose volume is known. */
static PetscBool IsFreeBall(const Pools *pools, PetscInt pool, PetscReal *volume)
{
  const Scene *scene = pools->scene;
  PetscInt     ball  = -1;

  if (scene->dim == 2 || scene->n_bodies) return PETSC_FALSE;
  for (PetscInt k = 0; k < scene->n_filled; k++) {
    if (pools->of[k] != pool) continue;
    if (ball >= 0 || strcmp(scene->filled[k].shape->name, "ball")) return PETSC_FALSE;
    ball = k;
  }
  for (PetscInt a = 0; a < scene->dim; a++) {
    PetscReal span[2];

    BodySpan(&scene->filled[ball], a, span);
    if (span[0] < scene->lo[a] || span[1] > scene->hi[a]) return PETSC_FALSE;
  }
  *volume = 4.0 / 3.0 * PETSC_PI * PetscPowRealInt(scene->filled[ball].extent, 3);
  return PETSC_TRUE;
}

/* Computes the volume of a pool, by the midpoint rule in the box around it; the sum is a whole
   number, so that it does not depend on the number of ranks. */
static PetscErrorCode PoolVolume(const Pools *pools, PetscInt pool, PetscReal *volume)
{
  const Scene   *scene = pools->scene;
  PetscReal      hi[ISPH_MAX_DIM];
  Quadrature     q    = {.n = {1, 1, 1}, .points = {1, 1, 1}, .all = 1};
  const PetscInt axes = BoxAround(pools, pool, q.lo, hi) ? 2 : 3;
  PetscInt       cells, first, last;
  PetscInt64     sum = 0;

  PetscFunctionBegin;
  if (IsFreeBall(pools, pool, volume)) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt a = 0; a < axes; a++) {
    q.n[a]               = (PetscInt)PetscCeilReal((hi[a] - q.lo[a]) / scene->dx);
    q.all *= q.points[a] = POINTS;
  }
  PetscCall(SceneCountCells(axes, q.n, &cells));
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) q.edge[a] = (hi[a] - q.lo[a]) / q.n[a];
  q.unit = (PetscReal)((PetscInt64)1 << ((PetscReal)cells * q.all < 4e9 ? 30 : 25)); /* < 2^62 */
  ParticlesShare(PETSC_COMM_WORLD, cells, &first, &last);
  for (PetscInt cell = first; cell < last; cell++) sum += SumCell(pools, pool, &q, cell);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPIU_INT64, MPI_SUM, PETSC_COMM_WORLD));
  *volume = (PetscReal)sum / q.unit;
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) *volume *= q.edge[a] / q.points[a];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* PoolsCreate - Finds the pools of a scene and their volumes. Collective on PETSC_COMM_WORLD.
   Output: pools - none if the fluid fills the box. Errors: refuses a jitter if no pool has a
   lattice. */
PetscErrorCode PoolsCreate(const Scene *scene, Pools *pools)
{
  PetscBool lattices = PETSC_FALSE;

  PetscFunctionBegin;
  *pools = (Pools){.scene = scene};
  JoinRegions(scene, pools);
  for (PetscInt pool = 0; pool < pools->n; pool++) {
    PetscCall(PoolVolume(pools, pool, &pools->volume[pool]));
    PetscCall(PoolHasLattice(pools, pool, &pools->lattice[pool]));
    if (pools->lattice[pool]) lattices = PETSC_TRUE;
    else pools->relaxed = PETSC_TRUE;
  }
  UserCheck(
      scene->jitter == 0.0 || !pools->n || lattices,
      "-jitter %.6g: it displaces lattices, which only regions bounded by lines along the axes "
      "have; leave it out",
      (double)scene->jitter);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* PoolsHold - Returns true if relaxed particles may be at x: in a pool without lattice */
PetscBool PoolsHold(const Pools *pools, const PetscReal x[])
{
  PetscReal depth;

  return pools->lattice[PoolAt(pools, x, &depth)] || depth < 0.0 ? PETSC_FALSE : PETSC_TRUE;
}
