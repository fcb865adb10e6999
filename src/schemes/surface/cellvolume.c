/*
  The cells of particles below a free surface, from the places of the particles alone. Points belong
  to the nearest particle. The cell of a particle on the surface ends at the paraboloid with its
  normal n and curvature k, all cells end at walls and at REACH from the particle. In 2D they are
  polygons. Beside bodies and in 3D they are sums over points of a fine grid,

    V_i = sum over points of s^d clip(1/2 - h/s),   h = n.X + k |X - (n.X) n|^2/(2 (d - 1)),

  with the step s of the grid. Isolated particles have their own volume instead of a cell. The sum
  is the volume inside the surface: clumps and voids, and surfaces that rise or sink, change it. See
  theory.md, (surface:cell).
*/
#include "geometry/cellpolygon.h"
#include "surface.h"

#define REACH 1.2  /* largest distance of a point from its particle; beyond it is a void [dx] */
#define NEAR  1.5  /* distance of near neighbours [dx] */
#define TIE   1e-9 /* difference of squared distances that is rounding [dx^2] */

/* The grid about a particle. */
typedef struct {
  PetscReal corner[ISPH_MAX_DIM];       /* first point, from the particle [m] */
  PetscReal step[ISPH_MAX_DIM], volume; /* [m], [m^dim] */
  PetscInt  n[ISPH_MAX_DIM];
} PointGrid;

/* A neighbour with a cell: the point X from the particle belongs to it if 2 X.x > x^2. */
typedef struct {
  PetscReal x[ISPH_MAX_DIM], square; /* distance from the particle [m], and its square */
  PetscBool first;                   /* it has the points of equal distance */
} Rival;

/* Returns true if fluid particle j has a cell. */
static PetscBool HasCell(const Flow *flow, PetscInt j)
{
  return !ParticlesIsWall(flow->particles, j) && flow->ops->free->kind[j] != SURFACE_ISOLATED;
}

/* Sets the points of the grid within `reach` of particle i; beyond walls of the box there are none.
   Input: points - of the grid along dx. */
static void GridAbout(const Flow *flow, PetscInt i, PetscReal reach, PetscInt points,
                      PointGrid *grid)
{
  const Scene     *scene = flow->scene;
  const Particles *p     = flow->particles;

  grid->volume = 1.0;
  for (PetscInt a = 0; a < scene->dim; a++) {
    const PetscInt  all   = points * scene->cells[a];
    const PetscReal s     = (scene->hi[a] - scene->lo[a]) / all;
    PetscInt        first = (PetscInt)PetscFloorReal((p->x[a][i] - reach - scene->lo[a]) / s),
             last         = (PetscInt)PetscCeilReal((p->x[a][i] + reach - scene->lo[a]) / s);

    if (BoundaryIs(scene, 2 * a, BOUNDARY_PARTICLES)) first = PetscMax(first, 0);
    if (BoundaryIs(scene, 2 * a + 1, BOUNDARY_PARTICLES)) last = PetscMin(last, all);
    grid->step[a]   = s;
    grid->corner[a] = scene->lo[a] + (first + 0.5) * s - p->x[a][i];
    grid->n[a]      = PetscMax(last - first, 0);
    grid->volume *= s;
  }
}

/* Sets the neighbours of own particle i that may have points within `reach` of it. Output: nearest2
   - square of the distance within which all points are nearer to i [m^2]. */
static PetscInt FindRivals(const Flow *flow, PetscInt i, PetscReal reach, Rival rival[],
                           PetscReal *nearest2)
{
  const Particles *p     = flow->particles;
  const Neighbors *nb    = flow->neighbors;
  const PetscReal  tie   = TIE * PetscSqr(flow->scene->dx);
  PetscReal        least = PETSC_INFINITY;
  PetscInt         n     = 0;

  for (PetscInt q = nb->row[i]; q < nb->row[i + 1]; q++) {
    const PetscInt j = nb->col[q];
    Rival         *r = &rival[n];

    if (!HasCell(flow, j)) continue;
    r->square = 0.0;
    for (PetscInt a = 0; a < p->dim; a++) {
      r->x[a] = p->x[a][j] - p->x[a][i];
      r->square += PetscSqr(r->x[a]);
    }
    if (r->square > PetscSqr(2.0 * reach)) continue;
    r->first = p->id[j] < p->id[i];
    least    = PetscMin(least, r->square);
    n++;
  }
  *nearest2 = least > tie ? least * PetscSqr(0.5 - 0.5 * tie / least) : 0.0; /* (d^2 - tie)/(2 d) */
  return n;
}

/* Returns true if no rival is nearer to the point X from its particle. Input and output: last - the
   rival that had the last point, which mostly has the next too. */
static PetscBool IsOwn(PetscInt dim, const PetscReal X[], const Rival rival[], PetscInt n,
                       PetscReal tie, PetscInt *last)
{
  for (PetscInt k = -1; k < n; k++) {
    const Rival *r    = &rival[k < 0 ? *last : k];
    PetscReal    more = r->square;

    for (PetscInt a = 0; a < dim; a++) more -= 2.0 * r->x[a] * X[a];
    if (more >= tie || (more >= -tie && !r->first)) continue;
    if (k >= 0) *last = k;
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

/* Returns the volume of the cell of own particle i in 2D off bodies [m^2]. Input: rival[n] - its
   neighbours; reach - of cells. */
static PetscReal PolygonVolume(const Flow *flow, PetscInt i, PetscReal reach, const Rival rival[],
                               PetscInt n)
{
  const Scene       *scene  = flow->scene;
  const Particles   *p      = flow->particles;
  const FreeSurface *free   = flow->ops->free;
  const PetscReal   *normal = &free->normal[2 * i], tie = TIE * scene->dx;
  PetscReal          area;
  Polygon            cell;

  PolygonDisc(reach, &cell);
  /* near rivals first: they leave few corners to the others */
  for (PetscInt far = 0; far < 2; far++) {
    for (PetscInt k = 0; k < n; k++) {
      if ((rival[k].square < PetscSqr(NEAR * scene->dx)) == far) continue;
      if (rival[k].square > tie * scene->dx) PolygonCut(rival[k].x, 0.5 * rival[k].square, &cell);
      else if (rival[k].first) return 0.0;
    }
  }
  for (PetscInt side = 0; side < 4; side++) {
    const PetscReal sign = side % 2 ? 1.0 : -1.0,
                    e[2] = {side < 2 ? sign : 0.0, side < 2 ? 0.0 : sign};
    const PetscReal end  = side % 2 ? scene->hi[side / 2] : scene->lo[side / 2];

    if (BoundaryIs(scene, side, BOUNDARY_PARTICLES))
      PolygonCut(e, sign * (end - p->x[side / 2][i]), &cell);
  }
  if (free->kind[i] == SURFACE_INSIDE) return PolygonArea(&cell);
  PolygonCut(normal, 0.0, &cell);
  area = PolygonArea(&cell);
  if (free->kind[i] != SURFACE_SMOOTH) return area;
  return PetscMax(0.0, area - PolygonSegment(normal, free->curvature[i], tie, &cell));
}

/* Returns true if the cell of own particle i is not a polygon. */
static PetscBool NeedsGrid(const Flow *flow, PetscInt i, PetscReal reach)
{
  const Particles *p               = flow->particles;
  PetscReal        x[ISPH_MAX_DIM] = {0.0}, normal[ISPH_MAX_DIM];
  PetscInt         body;

  if (p->dim == 3) return PETSC_TRUE;
  if (!flow->scene->n_bodies) return PETSC_FALSE;
  for (PetscInt a = 0; a < p->dim; a++) x[a] = p->x[a][i];
  return SceneDistance(flow->scene, x, &body, normal) < reach;
}

/* Returns the volume of the cell of own particle i [m^dim]. Input: rival - room for its
   neighbours. */
static PetscReal CellVolume(const Flow *flow, PetscInt points, PetscInt i, Rival rival[])
{
  const Scene    *scene = flow->scene;
  const PetscReal tie   = TIE * PetscSqr(scene->dx);
  const PetscReal reach = PetscMin(REACH * scene->dx, 0.5 * flow->ops->forms.radius);
  PetscReal       sum   = 0.0, nearest2;
  const PetscInt  n     = FindRivals(flow, i, reach, rival, &nearest2);
  PetscInt        all = 1, last = 0, at[ISPH_MAX_DIM] = {0};
  PointGrid       grid;

  if (!NeedsGrid(flow, i, reach)) return PolygonVolume(flow, i, reach, rival, n);
  GridAbout(flow, i, reach, points, &grid);
  for (PetscInt a = 0; a < scene->dim; a++) all *= grid.n[a];
  for (PetscInt k = 0; k < all; k++) {
    PetscReal X[ISPH_MAX_DIM] = {0.0}, r2 = 0.0;

    for (PetscInt a = 0; a < scene->dim; a++) {
      X[a] = grid.corner[a] + at[a] * grid.step[a];
      r2 += PetscSqr(X[a]);
    }
    for (PetscInt a = 0; a < scene->dim && ++at[a] == grid.n[a]; a++) at[a] = 0;
    if (r2 > PetscSqr(reach)) continue;
    if (r2 < nearest2 || n == 0 || IsOwn(scene->dim, X, rival, n, tie, &last))
      sum += PartInside(flow, i, X, grid.step[0]);
  }
  return sum * grid.volume;
}

/* FlowCellVolumes - Computes the volumes of the cells of own particles. Not collective. Input: flow
   - with neighbours and kinds at the places of the particles; points - of the grid along dx.
   Output: volume - of the cells [m^dim]. */
PetscErrorCode FlowCellVolumes(const Flow *flow, PetscInt points, PetscReal volume[])
{
  const Particles *p    = flow->particles;
  const Neighbors *nb   = flow->neighbors;
  PetscInt         most = 0;
  Rival           *rival;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < p->n_fluid; i++) most = PetscMax(most, nb->row[i + 1] - nb->row[i]);
  PetscCall(PetscMalloc1(most, &rival));
  for (PetscInt i = 0; i < p->n_fluid; i++)
    volume[i] = HasCell(flow, i) ? CellVolume(flow, points, i, rival) : p->volume[i];
  PetscCall(PetscFree(rival));
  PetscFunctionReturn(PETSC_SUCCESS);
}
