/*
  Forces and torques of the fluid on walls: sums of tractions over points of the surface,

    F = sum (-p n + mu (dw/dn + grad(u.n))) dA,   T = sum (x - c) x (...)

  with n into the fluid and w the velocity minus the wall velocity. The wall velocity of a body is
  extended into the fluid as a rigid motion, which has no strain; then the second viscous term is
  zero, because w is zero on the surface. The velocity of a side may vary along the side; there the
  second term follows from the derivatives of the wall velocity and from continuity. dw/dn is a
  one-sided difference of third order between the surface and probes at the heights dx, 2 dx and
  3 dx, or of the order of those that are not outside a free surface. Only the wet parts of a wall
  have forces. See docs/theory.md, (112) and (113).
*/
#include "monitors.h"

/* Returns the height of the first probe above point x of a boundary: the spacing, on sides of the
   box along the normal [m]. */
static PetscReal HeightUnit(const Scene *scene, PetscInt side, const PetscReal x[])
{
  PetscReal stretch[ISPH_MAX_DIM];

  if (BoundaryBody(scene, side)) return SceneSpacing(scene, x);
  SceneStretch(scene, x, stretch);
  return SceneSpacing(scene, x) / stretch[side / 2];
}

/* Probes the velocity minus the wall velocity, and the pressure unless p is NULL, at the middles of
   facets raised by `height` spacings along the normal; NaN outside a free surface. */
static PetscErrorCode ProbeAbove(const Flow *flow, PetscInt side, const Facets *s, PetscReal height,
                                 PetscReal w[], PetscReal p[])
{
  const Scene   *scene = flow->scene;
  const PetscInt dim   = scene->dim;
  PetscReal     *raised;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(s->n * dim, &raised));
  for (PetscInt k = 0; k < s->n; k++) {
    const PetscReal way = height * HeightUnit(scene, side, &s->x[k * dim]);

    for (PetscInt a = 0; a < dim; a++)
      raised[k * dim + a] = s->x[k * dim + a] + way * s->normal[k * dim + a];
  }
  PetscCall(ProbePoints(flow, s->n, raised, w, p));
  for (PetscInt k = 0; k < s->n; k++) {
    const PetscReal *x = BoundaryBody(scene, side) ? &raised[k * dim] : &s->x[k * dim];
    PetscReal        wall[ISPH_MAX_DIM];

    SceneWallVelocity(scene, side, flow->clock->t, x, wall);
    for (PetscInt a = 0; a < dim; a++) w[k * dim + a] -= wall[a];
  }
  PetscCall(PetscFree(raised));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the derivative of component c of the velocity of a side with respect to the coordinate
   along `axis` at x [1/s]. */
static PetscReal WallVelocityDerivative(const Flow *flow, PetscInt side, PetscInt c, PetscInt axis,
                                        const PetscReal x[])
{
  const Scene *scene = flow->scene;
  PetscReal    way, edge[ISPH_MAX_DIM], y[ISPH_MAX_DIM], u[2][ISPH_MAX_DIM];

  SceneEdges(scene, x, edge);
  way = 0.25 * edge[axis];
  for (PetscInt end = 0; end < 2; end++) {
    for (PetscInt b = 0; b < scene->dim; b++) y[b] = x[b];
    y[axis] += end ? way : -way;
    SceneWallVelocity(scene, side, flow->clock->t, y, u[end]);
  }
  return (u[1][c] - u[0][c]) / (2.0 * way);
}

/* Returns d(u.n)/dx_a on a side of the box at x [1/s]. If a is the axis normal to the side, the
   derivative follows from continuity. */
static PetscReal NormalVelocityDerivative(const Flow *flow, PetscInt side, PetscInt a,
                                          const PetscReal x[])
{
  const PetscInt axis  = side / 2;
  PetscReal      along = 0.0;

  if (a != axis) return (side % 2 ? -1.0 : 1.0) * WallVelocityDerivative(flow, side, axis, a, x);
  for (PetscInt b = 0; b < flow->scene->dim; b++)
    along -= b == axis ? 0.0 : WallVelocityDerivative(flow, side, b, b, x);
  return along * (side % 2 ? -1.0 : 1.0);
}

/* Returns the centre of torques: the centre of a body, or the middle of the box. */
static void TorqueCentre(const Scene *scene, PetscInt side, PetscReal c[])
{
  const Body *body = BoundaryBody(scene, side);

  for (PetscInt a = 0; a < scene->dim; a++) {
    c[a] = 0.5 * (scene->lo[a] + scene->hi[a]);
    if (body && a < 2) c[a] = body->centre[a];
  }
}

/* AddTorque - Adds (x - c) x f to T, in 2D the component T[2]; not collective */
void AddTorque(PetscInt dim, const PetscReal c[], const PetscReal x[], const PetscReal f[],
               PetscReal T[])
{
  PetscReal arm[ISPH_MAX_DIM] = {0.0}, g[ISPH_MAX_DIM] = {0.0};

  for (PetscInt a = 0; a < dim; a++) {
    arm[a] = x[a] - c[a];
    g[a]   = f[a];
  }
  for (PetscInt a = 0; a < 3; a++) {
    const PetscInt b = (a + 1) % 3, e = (a + 2) % 3;

    T[a] += arm[b] * g[e] - arm[e] * g[b];
  }
}

/*
  Computes the kinematic viscosity at the points [m^2/s]. For a fluid that is not Newtonian it
  follows from the strain rate, which is |dw/dn| at a wall without slip.
*/
static PetscErrorCode SurfaceViscosity(const Flow *flow, const Facets *s, const PetscReal slope[],
                                       PetscReal nu[])
{
  const Scene *scene = flow->scene;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < s->n; k++) nu[k] = SceneHas(scene, PHYSICS_VISCOSITY) ? scene->nu : 0.0;
  if (SceneIsNewtonian(scene)) {
    if (flow->particles->nu) PetscCall(ProbeViscosity(flow, s->n, s->x, nu));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (PetscInt k = 0; k < s->n; k++) {
    PetscReal square = 0.0;

    for (PetscInt a = 0; a < scene->dim; a++) square += PetscSqr(slope[k * scene->dim + a]);
    nu[k] = RheologyViscosity(&scene->rheology, PetscSqrtReal(square));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the slope on the wall of a function that vanishes there, from its values at the heights
   of 1 to 3 units. Upper values that are NaN are left out. */
static PetscReal SlopeAtWall(const PetscReal w[], PetscReal unit)
{
  if (!PetscIsNanReal(w[2])) return (18.0 * w[0] - 9.0 * w[1] + 2.0 * w[2]) / (6.0 * unit);
  if (!PetscIsNanReal(w[1])) return (4.0 * w[0] - w[1]) / (2.0 * unit);
  return PetscIsNanReal(w[0]) ? 0.0 : w[0] / unit;
}

/* Computes the slopes on the wall of the velocity minus the wall velocity, which vanishes on walls
   without slip, from its values at the heights of 1 to 3 units; NaN at dry points [1/s]. p: on the
   wall. */
static PetscErrorCode ProbeSlopes(const Flow *flow, PetscInt side, const Facets *s,
                                  PetscReal slope[], PetscReal p[])
{
  const Scene    *scene = flow->scene;
  const PetscInt  dim   = scene->dim;
  const PetscBool sticks =
      BoundaryIs(scene, side, BOUNDARY_CONFINES | BOUNDARY_NO_SLIP) ? PETSC_TRUE : PETSC_FALSE;
  PetscReal *w[3];

  PetscFunctionBegin;
  PetscCall(PetscMalloc3(s->n * dim, &w[0], s->n * dim, &w[1], s->n * dim, &w[2]));
  PetscCall(ProbeAbove(flow, side, s, 0.0, slope, p));
  for (PetscInt k = 0; k < (sticks ? 3 : 2); k++)
    PetscCall(ProbeAbove(flow, side, s, (PetscReal)(k + 1), w[k], NULL));
  for (PetscInt q = 0; q < s->n * dim; q++) {
    const PetscReal unit    = HeightUnit(scene, side, &s->x[q / dim * dim]);
    const PetscReal above[] = {w[0][q], w[1][q], w[2][q]};

    if (PetscIsNanReal(slope[q])) continue;
    if (sticks) slope[q] = SlopeAtWall(above, unit);
    else if (PetscIsNanReal(w[0][q]) || PetscIsNanReal(w[1][q])) slope[q] = 0.0;
    else slope[q] = (-3.0 * slope[q] + 4.0 * w[0][q] - w[1][q]) / (2.0 * unit);
  }
  PetscCall(PetscFree3(w[0], w[1], w[2]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds grad(u.n) along an opening to the slopes: differences of u.n between points at a quarter of
   a cell beside the middles of facets. */
static PetscErrorCode AddAlongOpening(const Flow *flow, PetscInt side, const Facets *s,
                                      PetscReal slope[])
{
  const PetscInt dim = flow->scene->dim, axis = side / 2;
  PetscReal     *x[2], *u[2];

  PetscFunctionBegin;
  PetscCall(
      PetscMalloc4(s->n * dim, &x[0], s->n * dim, &x[1], s->n * dim, &u[0], s->n * dim, &u[1]));
  for (PetscInt b = 0; b < dim; b++) {
    if (b == axis) continue;
    for (PetscInt end = 0; end < 2; end++) {
      PetscCall(PetscArraycpy(x[end], s->x, s->n * dim));
      for (PetscInt k = 0; k < s->n; k++)
        x[end][k * dim + b] += (end ? 0.25 : -0.25) * SceneSpacing(flow->scene, &s->x[k * dim]);
      PetscCall(ProbePoints(flow, s->n, x[end], u[end], NULL));
    }
    for (PetscInt k = 0; k < s->n; k++) {
      const PetscReal change = u[1][k * dim + axis] - u[0][k * dim + axis];

      if (PetscIsNanReal(change)) continue;
      slope[k * dim + b] +=
          s->normal[k * dim + axis] * change / (x[1][k * dim + b] - x[0][k * dim + b]);
    }
  }
  PetscCall(PetscFree4(x[0], x[1], u[0], u[1]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  WallLoads - Computes the forces of the fluid on the facets of a boundary: a side of the box or a
  body

  Collective. Output: s - the wet facets, to be freed by FacetsFree(); f - viscous forces, dim
  components each, NaN at dry facets [N]; p - pressures, NaN without one [Pa]; both to be freed by
  PetscFree(). In 2D forces are per metre of depth.
*/
PetscErrorCode WallLoads(const Flow *flow, PetscInt side, Facets *s, PetscReal **f, PetscReal **p)
{
  const Scene    *scene = flow->scene;
  const PetscInt  dim   = scene->dim;
  const PetscBool sticks =
      BoundaryIs(scene, side, BOUNDARY_CONFINES | BOUNDARY_NO_SLIP) ? PETSC_TRUE : PETSC_FALSE;
  PetscReal *nu;

  PetscFunctionBegin;
  PetscCall(FacetsOfWall(scene, side, s));
  PetscCall(FacetsKeepWet(flow, s));
  PetscCall(PetscMalloc1(s->n * dim, f));
  PetscCall(PetscMalloc1(s->n, p));
  PetscCall(PetscMalloc1(s->n, &nu));
  PetscCall(ProbeSlopes(flow, side, s, *f, *p));
  PetscCall(SurfaceViscosity(flow, s, *f, nu));
  if (!sticks && !BoundaryIs(scene, side, BOUNDARY_CONFINES))
    PetscCall(AddAlongOpening(flow, side, s, *f));
  for (PetscInt k = 0; k < s->n; k++) {
    PetscReal normal = 0.0;

    for (PetscInt a = 0; a < dim; a++) normal += (*f)[k * dim + a] * s->normal[k * dim + a];
    for (PetscInt a = 0; a < dim; a++) {
      PetscReal *slope = &(*f)[k * dim + a];

      if (!sticks) *slope += normal * s->normal[k * dim + a];
      else if (!BoundaryBody(scene, side))
        *slope += NormalVelocityDerivative(flow, side, a, &s->x[k * dim]);
      *slope *= s->area[k] * scene->rho * nu[k];
    }
  }
  PetscCall(PetscFree(nu));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  WallForce - Computes force and torque of the fluid on a wall: a side of the box or a body

  Collective. Parts of the wall outside a free surface take no part. Output: F [N]; T [N m] about
  the centre of a body or the middle of the box. In 2D both are per metre of depth, and the torque
  is T[2].
*/
PetscErrorCode WallForce(const Flow *flow, PetscInt side, PetscReal F[], PetscReal T[])
{
  const PetscInt dim = flow->scene->dim;
  PetscReal     *f, *p, centre[ISPH_MAX_DIM];
  Facets         s;

  PetscFunctionBegin;
  TorqueCentre(flow->scene, side, centre);
  PetscCall(WallLoads(flow, side, &s, &f, &p));
  for (PetscInt k = 0; k < s.n; k++) {
    PetscReal *load = &f[k * dim];

    if (PetscIsNanReal(load[0])) continue;
    for (PetscInt a = 0; a < dim; a++) {
      if (!PetscIsNanReal(p[k])) load[a] -= s.area[k] * p[k] * s.normal[k * dim + a];
      F[a] += load[a];
    }
    AddTorque(dim, centre, &s.x[k * dim], load, T);
  }
  PetscCall(PetscFree(f));
  PetscCall(PetscFree(p));
  PetscCall(FacetsFree(&s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes a row for each wall without slip: sides of the box, then bodies. */
static PetscErrorCode WriteForces(const Flow *flow, Monitor *monitor)
{
  const Scene *scene = flow->scene;

  PetscFunctionBegin;
  for (PetscInt side = 0; side < SceneBoundaries(scene); side++) {
    PetscReal force[2 * ISPH_MAX_DIM] = {0.0}; /* force, then torque */
    char      name[WALL_NAME];

    if (!SceneHas(scene, PHYSICS_WALLS)) continue;
    if (!BoundaryIs(scene, side, BOUNDARY_CONFINES | BOUNDARY_NO_SLIP)) continue;
    PetscCall(WallForce(flow, side, force, &force[ISPH_MAX_DIM]));
    PetscCall(MonitorMean(flow->clock, side, 2 * ISPH_MAX_DIM, force, monitor));
    SceneWallName(scene, side, name);
    if (!MonitorRow(flow->clock, monitor)) continue;
    (void)fprintf(monitor->stream, ",%s", name);
    MonitorVector(monitor, scene->dim, force);
    MonitorVector(monitor, 3, &force[ISPH_MAX_DIM]);
    (void)fprintf(monitor->stream, "\n");
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Each boundary has a window, which stays empty without forces on it. */
static PetscInt ForceWindows(const Scene *scene, const Monitor *monitor)
{
  (void)monitor;
  return SceneBoundaries(scene);
}

const MonitorKind MonitorForces = {
    .name    = "forces",
    .header  = "wall,fx,fy,fz,tx,ty,tz",
    .Windows = ForceWindows,
    .Write   = WriteForces,
};
