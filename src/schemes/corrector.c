/* The corrector of the projection scheme: the pressure increment, and what velocity and pressure gain. */
#include "projection.h"

/* Right-hand side of A phi = b, A = -dx^2 lap: -dx^2 rho/k ((1-alpha) div u* + alpha (1-C)/dt) - B
 * slope. */
static PetscErrorCode AssemblePressureSource(const Scene *scene, const Clock *clock,
                                             const Particles *p, const Operators *ops,
                                             Scheme *scheme)
{
  Projection     *pr    = (Projection *)scheme->data;
  const PetscReal scale = -PetscSqr(scene->dx) * scene->rho / pr->k;
  PetscScalar    *b;

  PetscFunctionBegin;
  PetscCall(VecZeroEntries(pr->div));
  for (PetscInt c = 0; c < scene->dim; c++) {
    PetscCall(AffineApplyAdd(&ops->div[c], pr->star[c], ops->wall_u[c], pr->div));
  }
  PetscCall(VecCopy(pr->div, pr->b));
  PetscCall(VecScale(pr->b, scale * (1.0 - scheme->alpha)));
  if (scheme->alpha > 0.0) {
    PetscCall(VecGetArray(pr->b, &b));
    for (PetscInt i = 0; i < p->n_fluid; i++)
      b[i] += scale * scheme->alpha * (1.0 - ops->concentration[i]) / clock->dt;
    PetscCall(VecRestoreArray(pr->b, &b));
  }
  if (ops->ppe.B) {
    PetscCall(MatMult(ops->ppe.B, ops->wall_slope_step, pr->work));
    PetscCall(VecAXPY(pr->b, -1.0, pr->work));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* u = u* - k/rho (grad phi). */
static PetscErrorCode VelocityCorrect(const Scene *scene, const Operators *ops, Projection *pr)
{
  PetscFunctionBegin;
  for (PetscInt a = 0; a < scene->dim; a++) {
    PetscCall(AffineApply(&ops->grad_p[a], pr->phi, ops->wall_slope_step, pr->work));
    PetscCall(VecAXPY(pr->star[a], -pr->k / scene->rho, pr->work));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  p = [p^n] + phi [- c mu div u*], then p -= S dx^4 lap lap p, which takes grid-scale modes that no
  projection on one set of points sees and leaves smooth pressure to fourth order; its mean is the
  gauge. c is LaplacianDilatation(); mu the least there is: right where it is uniform, stable however
  it varies. With the local one a drop of 1e5 times the viscosity about it blew up within 4 steps.

  What p gains by the filter leaves a divergence (k/rho) S dx^4 lap^3 p, from which convection makes
  energy. That of p += S dx^2 lap p is larger: no S served both Re = 1 (0.1 leaves u_min 1.1 % too small at
  nu dt/dx^2 = 2) and Re = 100 moving (0.02 leaves v_min 0.5 % off at n = 100, this one 0.004 %). The largest
  eigenvalue of -dx^2 lap is 8 in 2D and 12 in 3D on lattices, so that S < 1/72 takes no mode beyond zero.
*/
static PetscErrorCode PressureUpdate(const Scene *scene, const Particles *p, Operators *ops,
                                     const Scheme *scheme)
{
  Projection *pr = (Projection *)scheme->data;

  PetscFunctionBegin;
  PetscCall(VecCopy(pr->p, pr->p_before));
  if (!scheme->projection->incremental) PetscCall(VecZeroEntries(pr->p));
  PetscCall(VecAXPY(pr->p, 1.0, pr->phi));
  if (scheme->projection->rotational && SceneHas(scene, PHYSICS_VISCOSITY)) {
    PetscCall(VecAXPY(pr->p, -LaplacianDilatation(&ops->visc_form) * scene->rho * scene->nu_low,
                      pr->div));
  }
  if (ops->wall) PetscCall(VecAXPY(ops->wall_slope, 1.0, ops->wall_slope_step));
  if (scheme->filter > 0.0) {
    PetscCall(AffineApply(&ops->ppe, pr->p, ops->wall_slope, pr->work)); /* -dx^2 lap p */
    PetscCall(MatMult(ops->ppe.A, pr->work, pr->b));                     /* dx^4 lap lap p */
    PetscCall(VecAXPY(pr->p, -scheme->filter, pr->b));
  }
  PetscCall(VecRemoveMean(pr->p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ProjectVelocity - phi from div u*, then velocity and pressure from phi; collective */
PetscErrorCode ProjectVelocity(const Scene *scene, const Clock *clock, const Particles *p,
                               Operators *ops, Scheme *scheme)
{
  Projection *pr = (Projection *)scheme->data;

  PetscFunctionBegin;
  PetscCall(PetscLogEventBegin(pr->event[EVENT_PRESSURE], 0, 0, 0, 0));
  PetscCall(OperatorsSetWallVelocity(scene, p, clock->t + clock->dt, pr->k / scene->rho, ops));
  PetscCall(AssemblePressureSource(scene, clock, p, ops, scheme));
  PetscCall(PressureSolve(clock, p, ops, pr->b, pr->phi, scheme->ppe, &scheme->failure));
  PetscCall(PetscLogEventEnd(pr->event[EVENT_PRESSURE], 0, 0, 0, 0));
  if (scheme->failure.code) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscLogEventBegin(pr->event[EVENT_CORRECT], 0, 0, 0, 0));
  PetscCall(VelocityCorrect(scene, ops, pr));
  PetscCall(PressureUpdate(scene, p, ops, scheme));
  PetscCall(PetscLogEventEnd(pr->event[EVENT_CORRECT], 0, 0, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}
