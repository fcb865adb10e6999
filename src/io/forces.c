/*
  Forces and torques of the fluid on the walls of the box: the traction at points on the surface,
  summed.

    F = sum (-p n + mu du/dn) dA,   T = sum (x - c) x (...),   c the middle of the box

  n points into the fluid; on a rigid wall without slip the rest of the viscous stress vanishes. du/dn
  is one-sided, of second order, from probes at the wall and one and two dx above it.
*/
#include "monitors.h"

/* Midpoints of cells of the lattice on a side of the box. */
static PetscInt SidePoints(const Scene *scene, PetscInt side, PetscReal x[])
{
  const PetscInt axis = side / 2;
  PetscInt       n    = 1;

  for (PetscInt a = 0; a < scene->dim; a++) n *= a == axis ? 1 : scene->cells[a];
  for (PetscInt k = 0; x && k < n; k++) {
    PetscInt index = k;

    for (PetscInt a = 0; a < scene->dim; a++) {
      const PetscReal h = (scene->hi[a] - scene->lo[a]) / scene->cells[a];

      if (a == axis) {
        x[k * scene->dim + a] = side % 2 ? scene->hi[a] : scene->lo[a];
        continue;
      }
      x[k * scene->dim + a] = scene->lo[a] + (index % scene->cells[a] + 0.5) * h;
      index /= scene->cells[a];
    }
  }
  return n;
}

/* Velocities at the points raised by `height` along the inner normal. */
static PetscErrorCode ProbeAbove(const Flow *flow, PetscInt side, PetscReal height, PetscInt n,
                                 const PetscReal x[], PetscReal raised[], PetscReal u[],
                                 PetscReal p[])
{
  const PetscInt dim = flow->scene->dim;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < n * dim; k++)
    raised[k] = x[k] + (k % dim == side / 2 ? (side % 2 ? -height : height) : 0.0);
  PetscCall(ProbePoints(flow, n, raised, u, p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* T += (x - c) x f; in 2D the component out of the plane, which stands in T[2]. */
static void AddTorque(const Scene *scene, const PetscReal x[], const PetscReal f[], PetscReal T[])
{
  PetscReal arm[ISPH_MAX_DIM] = {0.0}, g[ISPH_MAX_DIM] = {0.0};

  for (PetscInt a = 0; a < scene->dim; a++) {
    arm[a] = x[a] - 0.5 * (scene->lo[a] + scene->hi[a]);
    g[a]   = f[a];
  }
  for (PetscInt a = 0; a < 3; a++) {
    const PetscInt b = (a + 1) % 3, c = (a + 2) % 3;

    T[a] += arm[b] * g[c] - arm[c] * g[b];
  }
}

/* Force and torque on one side [N, N m; per metre of depth in 2D]. */
static PetscErrorCode SideForce(const Flow *flow, PetscInt side, PetscReal F[], PetscReal T[])
{
  const Scene    *scene = flow->scene;
  const PetscInt  dim = scene->dim, axis = side / 2, n = SidePoints(scene, side, NULL);
  const PetscReal mu     = SceneHas(scene, PHYSICS_VISCOSITY) ? scene->rho * scene->nu : 0.0;
  const PetscReal normal = side % 2 ? -1.0 : 1.0, d = scene->dx;
  PetscReal      *x, *raised, *u[3], *p, area = 1.0;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < dim; a++)
    area *= a == axis ? 1.0 : (scene->hi[a] - scene->lo[a]) / scene->cells[a];
  PetscCall(PetscMalloc6(n * dim, &x, n * dim, &raised, n * dim, &u[0], n * dim, &u[1], n * dim,
                         &u[2], n, &p));
  (void)SidePoints(scene, side, x);
  for (PetscInt k = 0; k < 3; k++)
    PetscCall(ProbeAbove(flow, side, k * d, n, x, raised, u[k], k ? NULL : p));
  for (PetscInt k = 0; k < n; k++) {
    PetscReal f[ISPH_MAX_DIM] = {0.0}, wall[ISPH_MAX_DIM];

    SceneWallVelocity(scene, side, flow->clock->t, &x[k * dim], wall);
    for (PetscInt a = 0; a < dim; a++) {
      const PetscInt q = k * dim + a;

      f[a] = area * mu * (-3.0 * wall[a] + 4.0 * u[1][q] - u[2][q]) / (2.0 * d);
    }
    if (!PetscIsNanReal(p[k])) f[axis] -= area * p[k] * normal;
    for (PetscInt a = 0; a < dim; a++) F[a] += f[a];
    AddTorque(scene, &x[k * dim], f, T);
  }
  PetscCall(PetscFree6(x, raised, u[0], u[1], u[2], p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* MonitorForces - A row for each side of the box that is a wall: 2 axis + (0 low, 1 high); collective */
PetscErrorCode MonitorForces(const Flow *flow, const Monitor *monitor)
{
  const Scene *scene = flow->scene;

  PetscFunctionBegin;
  for (PetscInt side = 0; side < 2 * scene->dim; side++) {
    PetscReal F[ISPH_MAX_DIM] = {0.0}, T[ISPH_MAX_DIM] = {0.0};

    if (scene->periodic[side / 2] || !SceneHas(scene, PHYSICS_WALLS)) continue;
    PetscCall(SideForce(flow, side, F, T));
    if (!MonitorRow(flow, monitor, side)) continue;
    MonitorVector(monitor, scene->dim, F);
    MonitorVector(monitor, 3, T);
    (void)fprintf(monitor->stream, "\n");
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
