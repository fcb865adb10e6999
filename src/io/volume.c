/*
  The volume inside free surfaces, from the places of the particles alone. Points of a fine grid
  belong to the nearest particle. The cell of a particle on the surface ends at the paraboloid with
  its normal n and curvature k, all cells end at walls and at REACH from the particle:

    V = sum over points of s^d clip(1/2 - h/s),   h = n.X + k |X - (n.X) n|^2/(2 (d - 1)),

  with the step s of the grid. The reference is the sum of the volumes of the particles, which never
  change: clumps and voids, and surfaces that rise or sink, make a difference. See docs/theory.md,
  (158).
*/
#include "monitors.h"

#define GRID  4    /* points along dx */
#define REACH 1.2  /* largest distance of a point from its particle; beyond it is a void [dx] */
#define TIE   1e-9 /* difference of squared distances that is rounding [dx^2] */

/* The grid about a particle. */
typedef struct {
  PetscReal step[ISPH_MAX_DIM], volume; /* [m], [m^dim] */
  PetscInt  first[ISPH_MAX_DIM], n[ISPH_MAX_DIM];
} PointGrid;

/* Sets the points of the grid within `reach` of particle i; beyond walls of the box there are
   none. */
static void GridAbout(const Scene *scene, const Particles *p, PetscInt i, PetscReal reach,
                      PointGrid *grid)
{
  grid->volume = 1.0;
  for (PetscInt a = 0; a < scene->dim; a++) {
    const PetscInt  all   = GRID * scene->cells[a];
    const PetscReal s     = (scene->hi[a] - scene->lo[a]) / all;
    PetscInt        first = (PetscInt)PetscFloorReal((p->x[a][i] - reach - scene->lo[a]) / s),
             last         = (PetscInt)PetscCeilReal((p->x[a][i] + reach - scene->lo[a]) / s);

    if (BoundaryIs(scene, 2 * a, BOUNDARY_PARTICLES)) first = PetscMax(first, 0);
    if (BoundaryIs(scene, 2 * a + 1, BOUNDARY_PARTICLES)) last = PetscMin(last, all);
    grid->step[a]  = s;
    grid->first[a] = first;
    grid->n[a]     = PetscMax(last - first, 0);
    grid->volume *= s;
  }
}

/* Returns true if fluid particle j has a cell: isolated particles have their own volume instead. */
static PetscBool HasCell(const FreeSurface *free, PetscInt j)
{
  return free->kind[j] != SURFACE_ISOLATED ? PETSC_TRUE : PETSC_FALSE;
}

/* Returns true if neighbour q of own particle i has a cell. */
static PetscBool NeighbourHasCell(const Flow *flow, PetscInt q)
{
  const PetscInt j = flow->neighbors->col[q];

  return !ParticlesIsWall(flow->particles, j) && HasCell(flow->ops->free, j) ? PETSC_TRUE
                                                                             : PETSC_FALSE;
}

/* Returns the square of half the distance of own particle i to the nearest particle with a cell:
   nearer points belong to i [m^2]. */
static PetscReal OwnReach2(const Flow *flow, PetscInt i)
{
  const Particles *p     = flow->particles;
  const Neighbors *nb    = flow->neighbors;
  const PetscReal  tie   = TIE * PetscSqr(flow->scene->dx);
  PetscReal        least = PETSC_INFINITY;

  for (PetscInt q = nb->row[i]; q < nb->row[i + 1]; q++) {
    PetscReal d2 = 0.0;

    if (!NeighbourHasCell(flow, q)) continue;
    for (PetscInt a = 0; a < p->dim; a++) d2 += PetscSqr(p->x[a][i] - p->x[a][nb->col[q]]);
    least = PetscMin(least, d2);
  }
  return least > tie ? least * PetscSqr(0.5 - 0.5 * tie / least) : 0.0; /* (d^2 - tie)/(2 d) */
}

/* Returns true if a point at the distance X from own particle i is nearer to neighbour q. */
static PetscBool IsNearer(const Flow *flow, PetscInt i, const PetscReal X[], PetscReal r2,
                          PetscInt q)
{
  const Particles *p   = flow->particles;
  const PetscInt   j   = flow->neighbors->col[q];
  const PetscReal  tie = TIE * PetscSqr(flow->scene->dx);
  PetscReal        d2  = 0.0;

  if (!NeighbourHasCell(flow, q)) return PETSC_FALSE;
  for (PetscInt a = 0; a < p->dim; a++) d2 += PetscSqr(p->x[a][i] + X[a] - p->x[a][j]);
  return d2 < r2 - tie || (d2 < r2 + tie && p->id[j] < p->id[i]) ? PETSC_TRUE : PETSC_FALSE;
}

/* Returns true if own particle i is the nearest to a point at the distance X from it. Input and
   output: nearer - the last neighbour nearer to a point, which mostly is nearer to the next too. */
static PetscBool IsNearest(const Flow *flow, PetscInt i, const PetscReal X[], PetscReal r2,
                           PetscInt *nearer)
{
  const Neighbors *nb = flow->neighbors;

  if (*nearer < nb->row[i + 1] && IsNearer(flow, i, X, r2, *nearer)) return PETSC_FALSE;
  for (PetscInt q = nb->row[i]; q < nb->row[i + 1]; q++) {
    if (!IsNearer(flow, i, X, r2, q)) continue;
    *nearer = q;
    return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* Returns the part of the grid cell about a point at the distance X from own particle i that is
   inside the surface and outside bodies [-]. */
static PetscReal PartInside(const Flow *flow, PetscInt i, const PetscReal X[], PetscReal s)
{
  const Particles   *p    = flow->particles;
  const FreeSurface *free = flow->ops->free;
  PetscReal above = 0.0, r2 = 0.0, x[ISPH_MAX_DIM] = {0.0}, normal[ISPH_MAX_DIM], part = 1.0;
  PetscInt  body;

  for (PetscInt a = 0; a < p->dim; a++) {
    above += free->normal[i * p->dim + a] * X[a];
    r2 += PetscSqr(X[a]);
    x[a] = p->x[a][i] + X[a];
  }
  if (free->kind[i] == SURFACE_SMOOTH)
    above += 0.5 * free->curvature[i] / (p->dim - 1) * (r2 - PetscSqr(above));
  if (free->kind[i] != SURFACE_INSIDE) part = PetscMin(PetscMax(0.5 - above / s, 0.0), 1.0);
  if (part > 0.0 && flow->scene->n_bodies)
    part *= PetscMin(PetscMax(0.5 + SceneDistance(flow->scene, x, &body, normal) / s, 0.0), 1.0);
  return part;
}

/* Returns the volume that belongs to own particle i [m^dim]. */
static PetscReal CellVolume(const Flow *flow, PetscInt i)
{
  const Scene     *scene = flow->scene;
  const Particles *p     = flow->particles;
  const PetscReal  reach = PetscMin(REACH * scene->dx, 0.5 * flow->ops->forms.radius);
  const PetscReal  own2  = OwnReach2(flow, i);
  PetscReal        sum   = 0.0;
  PetscInt         n = 1, nearer = flow->neighbors->row[i];
  PointGrid        grid;

  if (!HasCell(flow->ops->free, i)) return p->volume[i];
  GridAbout(scene, p, i, reach, &grid);
  for (PetscInt a = 0; a < p->dim; a++) n *= grid.n[a];
  for (PetscInt k = 0; k < n; k++) {
    PetscReal X[ISPH_MAX_DIM] = {0.0}, r2 = 0.0, part;
    PetscInt  rest = k;

    for (PetscInt a = 0; a < p->dim; a++) {
      X[a] = scene->lo[a] + (grid.first[a] + rest % grid.n[a] + 0.5) * grid.step[a] - p->x[a][i];
      r2 += PetscSqr(X[a]);
      rest /= grid.n[a];
    }
    if (r2 > PetscSqr(reach)) continue;
    part = PartInside(flow, i, X, grid.step[0]);
    if (part > 0.0 && (r2 < own2 || IsNearest(flow, i, X, r2, &nearer))) sum += part;
  }
  return sum * grid.volume;
}

/*
  FluidVolume - Computes the volume inside the free surface [m^dim]

  Collective. Output: volume - at the places of the last step; mass - sum of the volumes of the
  particles, its reference.
*/
PetscErrorCode FluidVolume(const Flow *flow, PetscReal *volume, PetscReal *mass)
{
  PetscReal sum = 0.0;

  PetscFunctionBegin;
  /* fixed particles keep no lists of neighbours */
  PetscCall(NeighborsUpdate(flow->particles, 0.0, flow->neighbors));
  for (PetscInt i = 0; i < flow->particles->n_fluid; i++) sum += CellVolume(flow, i);
  if (!SceneMoves(flow->scene)) PetscCall(NeighborsRelease(flow->neighbors));
  PetscCallMPI(MPI_Allreduce(&sum, volume, 1, MPIU_REAL, MPIU_SUM, flow->particles->comm));
  *mass = flow->particles->weight * flow->particles->cell_volume;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses a flow without a free surface. */
static PetscErrorCode PrepareVolume(Flow *flow, const Monitor *monitor)
{
  PetscFunctionBegin;
  (void)monitor;
  UserCheck(flow->ops->free,
            "-probe_volume: this flow has no free surface, and its volume is that of the box");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes the volume and its error. */
static PetscErrorCode WriteVolume(const Flow *flow, Monitor *monitor)
{
  PetscReal volume, mass;

  PetscFunctionBegin;
  PetscCall(FluidVolume(flow, &volume, &mass));
  if (MonitorRow(flow, monitor))
    (void)fprintf(monitor->stream, ",%.12g,%.6g\n", (double)volume, (double)(volume / mass - 1.0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const MonitorKind MonitorVolume = {
    .name    = "volume",
    .header  = "volume,error",
    .Prepare = PrepareVolume,
    .Write   = WriteVolume,
};
