/* The corrector of the projection scheme: the pressure increment, and what velocity and pressure
   gain. */
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
    PetscCall(MatMult(ops->ppe.B, ops->wall_dpdn_step, pr->work));
    PetscCall(VecAXPY(pr->b, -1.0, pr->work));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* u = u* - k/rho (grad phi). */
static PetscErrorCode VelocityCorrect(const Scene *scene, const Operators *ops, Projection *pr)
{
  PetscFunctionBegin;
  for (PetscInt a = 0; a < scene->dim; a++) {
    PetscCall(AffineApply(&ops->grad_p[a], pr->phi, ops->wall_dpdn_step, pr->work));
    PetscCall(VecAXPY(pr->star[a], -pr->k / scene->rho, pr->work));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Which share of the pressure's roughness a step takes,

    S max(0.1, 1/(1 + 8 nu dt/dx^2)),

  for S = 1 about what an implicit viscous step leaves of the mode +1, -1 of a lattice. Modes of the
  pressure that no projection on one set of points sees, L^-1 D G p = m p with a small and, among
  disordered particles, negative m, grow by |m|^(1/2) in each step of an incremental projection,
  however short it is, unless viscosity or this takes them; the less the one, the more the other.

  The price: a steady pressure whose roughness is r leaves a divergence of dt (L - D G) s r/rho, and
  that may feed energy where layers are thin. Fixed particles at Re = 1000, n = 48, CFL number 1, t
  = 40 in the cavity: -18, -8.5, 5.1, 38 % for S = 0, 0.02, 0.1, 0.5. Hence only 0.1 where particles
  stay on a lattice.
*/
static PetscReal FilterShare(const Scene *scene, const Clock *clock, const Scheme *scheme)
{
  const PetscReal nu = SceneHas(scene, PHYSICS_VISCOSITY) ? scene->nu_low : 0.0;

  return scheme->filter * PetscMax(0.1, 1.0 / (1.0 + 8.0 * nu * clock->dt / PetscSqr(scene->dx)));
}

/*
  PressureGain - Share of phi that the pressure gains, min(1, 4 dt/dt_wanted); not collective

  An error e of the velocity, which nobody sees while steps are alike, makes a phi of about
  rho e dx/dt. Of a step that was cut short for a report a pressure that is kept takes what a usual
  step would have given it: its own change in so short a time is small. Otherwise the next step,
  thousands of times as long, is a blow.
*/
PetscReal PressureGain(const Clock *clock, const Scheme *scheme)
{
  return scheme->projection->incremental ? PetscMin(1.0, 4.0 * clock->dt / clock->dt_wanted) : 1.0;
}

/*
  p = [p^n] + s (phi [- c mu div u*]), s = PressureGain(), less a share of what a quadratic fit
  leaves of it, which is of fourth order where p is smooth; its mean is the gauge. c is
  LaplacianDilatation(); mu the least there is: right where it is uniform, stable however it varies.
  With the local one a drop of 1e5 times the viscosity about it blew up within 4 steps.
*/
static PetscErrorCode PressureUpdate(const Scene *scene, const Clock *clock, Operators *ops,
                                     const Scheme *scheme)
{
  Projection     *pr   = (Projection *)scheme->data;
  const PetscReal gain = PressureGain(clock, scheme);

  PetscFunctionBegin;
  PetscCall(VecCopy(pr->p, pr->p_before));
  if (!scheme->projection->incremental) PetscCall(VecZeroEntries(pr->p));
  PetscCall(VecAXPY(pr->p, gain, pr->phi));
  if (scheme->projection->rotational && SceneHas(scene, PHYSICS_VISCOSITY)) {
    const PetscReal dilatation = LaplacianDilatation(&ops->visc_form);

    PetscCall(VecAXPY(pr->p, -gain * dilatation * scene->rho * scene->nu_low, pr->div));
  }
  if (scheme->filter > 0.0) {
    PetscCall(MatMult(ops->filter_p.A, pr->p, pr->work));
    PetscCall(VecAXPY(pr->p, -FilterShare(scene, clock, scheme), pr->work));
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
  PetscCall(PressureUpdate(scene, clock, ops, scheme));
  PetscCall(PetscLogEventEnd(pr->event[EVENT_CORRECT], 0, 0, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}
