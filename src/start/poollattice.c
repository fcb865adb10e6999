/* The lattice of a pool whose borders are lines along the axes. Between two lines the spacing along
   an axis is even and near dx. The outer particles are half an edge away from the lines, as on the
   lattice of a full box. All regions of a pool share the lattice. */
#include "start.h"

#define EDGE_LEAST 0.8 /* edges of cells for which a pool has a lattice [dx] */
#define EDGE_MOST  1.25
#define NEAR       1e-6 /* distance of lines that are the same [dx] */
#define BODY_CLEAR 0.4  /* least distance from bodies [dx] */
#define WALL_CLEAR 0.3  /* of displaced particles from walls [dx] */

/* The lattice along an axis: places of particles [m]. */
typedef struct {
  PetscInt   n;
  PetscReal *place;
} PoolAxis;

/* Returns true if a body may be in a pool, by the boxes around both. */
static PetscBool MayBeIn(const Pools *pools, PetscInt pool, const Body *body)
{
  const Scene *scene = pools->scene;

  for (PetscInt k = 0; k < scene->n_filled; k++) {
    PetscBool apart = pools->of[k] != pool;

    for (PetscInt a = 0; a < scene->dim; a++) {
      PetscReal one[2], two[2];

      BodySpan(&scene->filled[k], a, one);
      BodySpan(body, a, two);
      apart = apart || PetscMax(PetscMax(one[0], two[0]), scene->lo[a]) >
                           PetscMin(PetscMin(one[1], two[1]), scene->hi[a]) - NEAR * scene->dx;
    }
    if (!apart || (body->around && pools->of[k] == pool)) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Computes the lines across an axis that bound the regions of a pool, in ascending order, which the
   caller frees, with those of bodies: a lattice leaves gaps beside others. Output: count - their
   number, 0 if a border is no line along an axis. */
static PetscErrorCode PoolLines(const Pools *pools, PetscInt pool, PetscInt axis, PetscInt *count,
                                PetscReal **lines)
{
  const Scene *scene = pools->scene;
  PetscReal    low = scene->hi[axis], high = scene->lo[axis], *line;
  PetscInt     n = 0, kept = 0, room = 0;

  PetscFunctionBegin;
  *count = 0;
  for (PetscInt k = 0; k < scene->n_filled; k++) room += PetscMax(2, scene->filled[k].n / 2);
  for (PetscInt b = 0; b < scene->n_bodies; b++) room += PetscMax(2, SceneBody(scene, b)->n / 2);
  PetscCall(PetscMalloc1(room, lines));
  line = *lines;
  for (PetscInt k = 0; k < scene->n_filled; k++) {
    PetscInt more;

    if (pools->of[k] != pool) continue;
    more = BodyLines(&scene->filled[k], axis, &line[n]);
    if (!more) PetscFunctionReturn(PETSC_SUCCESS);
    n += more;
  }
  for (PetscInt l = 0; l < n; l++) {
    low  = PetscMin(low, PetscMax(line[l], scene->lo[axis]));
    high = PetscMax(high, PetscMin(line[l], scene->hi[axis]));
  }
  for (PetscInt b = 0; b < scene->n_bodies; b++) {
    PetscInt more;

    if (!MayBeIn(pools, pool, SceneBody(scene, b))) continue;
    more = BodyLines(SceneBody(scene, b), axis, &line[n]);
    if (!more) PetscFunctionReturn(PETSC_SUCCESS);
    n += more;
  }
  for (PetscInt l = 0; l < n; l++) line[l] = PetscMin(PetscMax(line[l], low), high);
  PetscCall(PetscSortReal(n, line));
  for (PetscInt l = 0; l < n; l++)
    if (!kept || line[l] - line[kept - 1] > NEAR * scene->dx) line[kept++] = line[l];
  *count = kept;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the number of particles between two lines; computes the edge of their cells [m]. */
static PetscInt CountBetween(PetscReal dx, const PetscReal line[2], PetscReal *edge)
{
  const PetscReal length = line[1] - line[0];
  const PetscInt  n      = (PetscInt)PetscFloorReal(length / dx + 0.5);

  *edge = n ? length / n : PETSC_MAX_REAL;
  return n;
}

/* PoolHasLattice - Finds out if lines along the axes bound a pool, and if cells of about dx fit
   between them */
PetscErrorCode PoolHasLattice(const Pools *pools, PetscInt pool, PetscBool *has)
{
  const Scene *scene = pools->scene;

  PetscFunctionBegin;
  *has = PETSC_TRUE;
  for (PetscInt axis = 0; axis < scene->dim; axis++) {
    PetscReal *line, edge;
    PetscInt   n;

    PetscCall(PoolLines(pools, pool, axis, &n, &line));
    if (n < 2) *has = PETSC_FALSE;
    for (PetscInt l = 0; l + 1 < n; l++) {
      (void)CountBetween(scene->dx, &line[l], &edge);
      if (edge < EDGE_LEAST * scene->dx || edge > EDGE_MOST * scene->dx) *has = PETSC_FALSE;
    }
    PetscCall(PetscFree(line));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AxisCreate(const Pools *pools, PetscInt pool, PetscInt a, PoolAxis *axis)
{
  PetscReal *line, edge;
  PetscInt   lines, room = 0;

  PetscFunctionBegin;
  PetscCall(PoolLines(pools, pool, a, &lines, &line));
  for (PetscInt l = 0; l + 1 < lines; l++) room += CountBetween(pools->scene->dx, &line[l], &edge);
  PetscCall(PetscMalloc1(room, &axis->place));
  axis->n = 0;
  for (PetscInt l = 0; l + 1 < lines; l++) {
    const PetscInt n = CountBetween(pools->scene->dx, &line[l], &edge);

    for (PetscInt k = 0; k < n; k++) axis->place[axis->n++] = line[l] + (k + 0.5) * edge;
  }
  PetscCall(PetscFree(line));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Displaces a particle at random, and keeps it off walls. */
static void Jitter(const Scene *scene, PetscInt64 id, PetscReal x[])
{
  const PetscReal least = WALL_CLEAR * scene->dx;
  PetscReal       distance, normal[ISPH_MAX_DIM];
  PetscInt        body;

  for (PetscInt a = 0; a < scene->dim; a++) {
    const PetscReal period = scene->hi[a] - scene->lo[a];

    x[a] += scene->jitter * scene->dx * ParticlesHash(scene->seed, id, a);
    if (SceneIsPeriodic(scene, a)) x[a] -= period * PetscFloorReal((x[a] - scene->lo[a]) / period);
    else x[a] = PetscMin(PetscMax(x[a], scene->lo[a] + least), scene->hi[a] - least);
  }
  distance = SceneDistance(scene, x, &body, normal);
  for (PetscInt a = 0; distance < least && a < scene->dim; a++)
    x[a] += (least - distance) * normal[a];
}

/* Computes the place of lattice cell `index`; returns true if it is in the pool and off bodies. */
static PetscBool CellHolds(const Pools *pools, PetscInt pool, const PoolAxis axis[], PetscInt index,
                           PetscReal x[])
{
  const Scene *scene = pools->scene;
  PetscReal    depth, normal[ISPH_MAX_DIM];
  PetscInt     body;

  for (PetscInt a = 0; a < scene->dim; a++) {
    x[a] = axis[a].place[index % axis[a].n];
    index /= axis[a].n;
  }
  if (PoolAt(pools, x, &depth) != pool || depth < -NEAR * scene->dx) return PETSC_FALSE;
  return SceneDistance(scene, x, &body, normal) >= BODY_CLEAR * scene->dx;
}

/* PoolLattice - Adds this rank's share of the particles of a pool that has a lattice. Collective on
   PETSC_COMM_WORLD. Particles are displaced by the jitter of the scene. */
PetscErrorCode PoolLattice(const Pools *pools, PetscInt pool, Rows *rows)
{
  const Scene   *scene = pools->scene;
  const PetscInt begin = rows->n;
  PetscInt       count[ISPH_MAX_DIM], cells, first, last, own, before = 0, all;
  PetscReal      x[ISPH_MAX_DIM] = {0.0};
  PoolAxis       axis[ISPH_MAX_DIM];

  PetscFunctionBegin;
  for (PetscInt a = 0; a < scene->dim; a++) {
    PetscCall(AxisCreate(pools, pool, a, &axis[a]));
    count[a] = axis[a].n;
  }
  PetscCall(SceneCountCells(scene->dim, count, &cells));
  ParticlesShare(PETSC_COMM_WORLD, cells, &first, &last);
  for (PetscInt c = first; c < last; c++)
    if (CellHolds(pools, pool, axis, c, x)) PetscCall(RowsAdd(scene, x, rows));
  own = rows->n - begin;
  PetscCallMPI(MPI_Exscan(&own, &before, 1, MPIU_INT, MPI_SUM, PETSC_COMM_WORLD));
  PetscCallMPI(MPI_Allreduce(&own, &all, 1, MPIU_INT, MPI_SUM, PETSC_COMM_WORLD));
  own = begin;
  for (PetscInt c = first; c < last; c++) {
    if (!CellHolds(pools, pool, axis, c, x)) continue;
    rows->index[own] = rows->N + before + own - begin;
    if (scene->jitter > 0.0) Jitter(scene, rows->index[own], &rows->x[own * scene->dim]);
    own++;
  }
  rows->N += all;
  for (PetscInt a = 0; a < scene->dim; a++) PetscCall(PetscFree(axis[a].place));
  PetscFunctionReturn(PETSC_SUCCESS);
}
