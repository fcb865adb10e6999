/*
  Tractions of the fluid on walls. Force and torque by them are sums over points of the surface,

    F = sum (-p n + mu (dw/dn + grad(u.n))) dA,   T = sum (x - c) x (...)

  with n into the fluid and w the velocity minus the wall velocity. The wall velocity of a body is
  extended into the fluid as a rigid motion, which has no strain; then the second viscous term is
  zero, because w is zero on the surface. The velocity of a side may vary along the side; there the
  second term follows from the derivatives of the wall velocity and from continuity. dw/dn is a
  one-sided difference of third order between the surface and probes at the heights dx, 2 dx and
  3 dx, or of the order of those that are not outside a free surface. Only the wet parts of a wall
  have forces. See theory.md, (forces:traction) and (forces:slope).
*/
#include "isph/forces.h"

/* FacetHeight - Returns the height of the first probe above point x of a boundary: the spacing, on
   sides of the box along the normal [m]; not collective */
PetscReal FacetHeight(const Scene *scene, PetscInt side, const PetscReal x[])
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
    const PetscReal way = height * FacetHeight(scene, side, &s->x[k * dim]);

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

/* StrainRate - Returns the strain rate sqrt(2 E:E) of a velocity gradient [1/s]; not collective */
PetscReal StrainRate(PetscInt dim, const PetscReal A[])
{
  PetscReal square = 0.0;

  for (PetscInt a = 0; a < dim; a++) {
    for (PetscInt b = 0; b < dim; b++) square += 0.5 * PetscSqr(A[a * dim + b] + A[b * dim + a]);
  }
  return PetscSqrtReal(square);
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

/* PointViscosity - Computes the kinematic viscosity at points [m^2/s]; collective. For a fluid that
   is not Newtonian it follows from the strain rates there [1/s]. */
PetscErrorCode PointViscosity(const Flow *flow, PetscInt n, const PetscReal x[],
                              const PetscReal rate[], PetscReal nu[])
{
  const Scene *scene = flow->scene;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < n; k++) {
    nu[k] = SceneHas(scene, PHYSICS_VISCOSITY) ? scene->nu : 0.0;
    if (!SceneIsNewtonian(scene)) {
      PetscReal  y[ISPH_MAX_DIM] = {0.0};
      FluidPlace at;

      for (PetscInt a = 0; a < scene->dim; a++) y[a] = x[k * scene->dim + a];
      at    = RheologyAt(scene, (PetscReal *const[]){y, y + 1, y + 2}, 0);
      nu[k] = RheologyViscosity(&scene->rheology, &at, rate[k]);
    }
  }
  if (SceneIsNewtonian(scene) && flow->particles->nu) PetscCall(ProbeViscosity(flow, n, x, nu));
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
    const PetscReal unit    = FacetHeight(scene, side, &s->x[q / dim * dim]);
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

/* FacetLoads - Computes the forces of the fluid on facets of a boundary: a side of the box or a
   body; collective. Output: f - viscous forces, dim components each, NaN at dry facets [N]; p -
   pressures, NaN without one [Pa]; both to be freed by PetscFree(). In 2D forces are per metre of
   depth. */
PetscErrorCode FacetLoads(const Flow *flow, PetscInt side, const Facets *s, PetscReal **f,
                          PetscReal **p)
{
  const Scene    *scene = flow->scene;
  const PetscInt  dim   = scene->dim;
  const PetscBool sticks =
      BoundaryIs(scene, side, BOUNDARY_CONFINES | BOUNDARY_NO_SLIP) ? PETSC_TRUE : PETSC_FALSE;
  PetscReal *nu, *rate;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(s->n * dim, f));
  PetscCall(PetscMalloc1(s->n, p));
  PetscCall(PetscMalloc2(s->n, &nu, s->n, &rate));
  PetscCall(ProbeSlopes(flow, side, s, *f, *p));
  for (PetscInt k = 0; k < s->n; k++) { /* at a wall without slip |dw/dn| */
    rate[k] = 0.0;
    for (PetscInt a = 0; a < dim; a++) rate[k] += PetscSqr((*f)[k * dim + a]);
    rate[k] = PetscSqrtReal(rate[k]);
  }
  PetscCall(PointViscosity(flow, s->n, s->x, rate, nu));
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
  PetscCall(PetscFree2(nu, rate));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* WallLoads - Computes FacetLoads() of all wet facets of a boundary; collective. Output: s - the
   facets, to be freed by FacetsFree(). */
PetscErrorCode WallLoads(const Flow *flow, PetscInt side, Facets *s, PetscReal **f, PetscReal **p)
{
  PetscFunctionBegin;
  PetscCall(FacetsOfWall(flow->scene, side, s));
  PetscCall(FacetsKeepWet(flow, s));
  PetscCall(FacetLoads(flow, side, s, f, p));
  PetscFunctionReturn(PETSC_SUCCESS);
}
