/*
  Moving particles: with the flow, then a little aside so that they stay evenly spread; the fields
  they carry follow by Taylor series.
*/
#include "projection.h"

/* Keeps a displaced position 0.3 dx off every wall; returns nothing, mends x. */
static void KeepOffWalls(const Scene *scene, PetscReal x[])
{
  const PetscReal clearance = 0.3 * scene->dx;
  WallPlane       planes[SCENE_MAX_PLANES];
  PetscInt        n;

  SceneWallPlanes(scene, x, clearance, planes, &n);
  for (PetscInt q = 0; q < n; q++) {
    for (PetscInt a = 0; a < scene->dim; a++) {
      x[a] += (clearance - planes[q].distance) * planes[q].normal[a];
    }
  }
}

/* Gradients at the old positions that the Taylor series need: of p always, of u where there is
 * shifting. */
static PetscErrorCode EvaluateSlopes(const Scene *scene, const Operators *ops, PetscBool shifting,
                                     Projection *pr)
{
  PetscFunctionBegin;
  for (PetscInt a = 0; a < scene->dim; a++) {
    if (pr->p) PetscCall(AffineApply(&ops->grad_p[a], pr->p, ops->wall_slope, pr->force[a]));
    for (PetscInt c = 0; shifting && c < scene->dim; c++) {
      PetscCall(AffineApply(&ops->grad_u[a], pr->u[c], ops->wall_u[c], pr->velocity_slope[c][a]));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  ParticlesMove - Takes particles from x^n to x^{n+1} by Adams-Bashforth and shifts them

    dr = dt ((1 + w/2) u^n - w/2 u^{n-1}) + shift,   w = dt/dt_previous
    u += shift.grad u,   p += dr.grad p

  Collective. The pressure is carried as an Eulerian field, velocities as the particles' own but for
  the shift. On entry the operators are those at x^n; on exit they are stale.
*/
PetscErrorCode ParticlesMove(const Scene *scene, const Clock *clock, Operators *ops, Particles *p,
                             Scheme *scheme)
{
  Projection     *pr       = (Projection *)scheme->data;
  const PetscBool shifting = scheme->shift->Displace ? PETSC_TRUE : PETSC_FALSE;
  const PetscReal w =
      scheme->time_order == 2 && clock->dt_previous > 0.0 ? clock->dt / clock->dt_previous : 0.0;
  const PetscScalar *slope_p[ISPH_MAX_DIM], *slope_u[ISPH_MAX_DIM][ISPH_MAX_DIM];

  PetscFunctionBegin;
  PetscCall(EvaluateSlopes(scene, ops, shifting, pr));
  for (PetscInt a = 0; a < scene->dim; a++) {
    PetscCall(VecGetArrayRead(pr->force[a], &slope_p[a]));
    for (PetscInt c = 0; shifting && c < scene->dim; c++) {
      PetscCall(VecGetArrayRead(pr->velocity_slope[c][a], &slope_u[c][a]));
    }
  }
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscReal shift[ISPH_MAX_DIM] = {0.0}, x[ISPH_MAX_DIM], gradient_c[ISPH_MAX_DIM];

    for (PetscInt a = 0; shifting && a < scene->dim; a++) gradient_c[a] = ops->gradient_c[a][i];
    if (shifting)
      scheme->shift->Displace(scene, scheme->stats.speed_max, clock->dt, gradient_c, shift);
    for (PetscInt a = 0; a < scene->dim; a++) {
      x[a] = p->x[a][i] +
             clock->dt * ((1.0 + 0.5 * w) * p->u[a][i] - 0.5 * w * pr->u_previous[a][i]) + shift[a];
    }
    KeepOffWalls(scene, x);
    for (PetscInt a = 0; a < scene->dim; a++) {
      if (p->p) p->p[i] += (x[a] - p->x[a][i]) * slope_p[a][i];
      if (pr->has_moved) pr->moved[a][i] = x[a] - p->x[a][i];
      p->x[a][i] = x[a];
      for (PetscInt c = 0; shifting && c < scene->dim; c++) {
        p->u[c][i] += shift[a] * slope_u[c][a][i];
        pr->u_previous[c][i] += shift[a] * slope_u[c][a][i];
      }
    }
  }
  for (PetscInt a = 0; a < scene->dim; a++) {
    PetscCall(VecRestoreArrayRead(pr->force[a], &slope_p[a]));
    for (PetscInt c = 0; shifting && c < scene->dim; c++) {
      PetscCall(VecRestoreArrayRead(pr->velocity_slope[c][a], &slope_u[c][a]));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
