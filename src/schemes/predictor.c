/* The predictor of the projection scheme: forces at the new time, then the viscous step to u*. */
#include "projection.h"

/*
  u.grad u of fixed particles: extrapolated into the force for implicit kinds; for the others the
  advecting velocity is extrapolated and the TS does the rest.
*/
static PetscErrorCode AddConvection(const Scene *scene, const Clock *clock, const Operators *ops,
                                    PetscReal at, Scheme *scheme)
{
  Projection     *pr = (Projection *)scheme->data;
  const PetscBool extrapolate =
      !scheme->visc || ViscosityIntegrator(scheme->visc)->kind == TIME_IMPLICIT;
  const PetscReal w = scheme->time_order == 2 ? at * ClockRatio(clock) : 0.0;

  PetscFunctionBegin;
  for (PetscInt c = 0; c < scene->dim; c++) {
    if (!extrapolate) {
      PetscCall(VecCopy(pr->u[c], pr->conv[c]));
      PetscCall(VecAXPBY(pr->conv[c], -w, 1.0 + w, pr->u_prev[c]));
      continue;
    }
    PetscCall(ConvectionApply(scene, ops, pr->u, pr->u[c], ops->wall_u[c], pr->work, pr->conv[c]));
    PetscCall(VecAXPY(pr->force[c], -(1.0 + w), pr->conv[c]));
    PetscCall(VecAXPY(pr->force[c], w, pr->conv_prev[c]));
    PetscCall(VecCopy(pr->conv[c], pr->conv_prev[c]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  AddBodyForce - force += f(x, t) on the own fluid, and the largest |f| of it

  Collective. Input: t [s]; force - vectors over the fluid, NULL where only the largest is asked
  for. Output: scheme->stats.force_max [m/s^2]. A force that is the same everywhere takes no look at
  particles.
*/
PetscErrorCode AddBodyForce(const Scene *scene, PetscReal t, const Particles *p, Vec force[],
                            Scheme *scheme)
{
  PetscScalar *g[ISPH_MAX_DIM];
  PetscReal    most = 0.0;

  PetscFunctionBegin;
  if (!scene->force.n) {
    for (PetscInt a = 0; a < scene->dim; a++) {
      if (force) PetscCall(VecShift(force[a], scene->body_force[a]));
      most += PetscSqr(scene->body_force[a]);
    }
    scheme->stats.force_max = PetscSqrtReal(most);
    scheme->force_step      = PetscMax(scheme->force_step, scheme->stats.force_max);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (PetscInt a = 0; a < scene->dim && force; a++) PetscCall(VecGetArray(force[a], &g[a]));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscReal x[ISPH_MAX_DIM], f[ISPH_MAX_DIM], square = 0.0;

    for (PetscInt a = 0; a < scene->dim; a++) x[a] = p->x[a][i];
    SceneBodyForce(scene, t, x, f);
    for (PetscInt a = 0; a < scene->dim; a++) {
      if (force) g[a][i] += f[a];
      square += PetscSqr(f[a]);
    }
    most = PetscMax(most, square);
  }
  for (PetscInt a = 0; a < scene->dim && force; a++) PetscCall(VecRestoreArray(force[a], &g[a]));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPIU_REAL, MPIU_MAX, p->comm));
  scheme->stats.force_max = PetscSqrtReal(most);
  scheme->force_step      = PetscMax(scheme->force_step, scheme->stats.force_max);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The force on u*: -grad p^n/rho + f - convection; at = 1 or 1/2: where in the step it is taken. */
static PetscErrorCode AssembleForce(const Scene *scene, const Clock *clock, const Particles *p,
                                    const Operators *ops, PetscReal at, Scheme *scheme)
{
  Projection *pr = (Projection *)scheme->data;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < scene->dim; a++) {
    if (scheme->projection && scheme->projection->incremental) {
      PetscCall(AffineApply(&ops->grad_p[a], pr->p, ops->wall_dpdn, pr->force[a]));
      PetscCall(VecScale(pr->force[a], -1.0 / scene->rho));
    } else {
      PetscCall(VecZeroEntries(pr->force[a]));
    }
  }
  if (SceneHas(scene, PHYSICS_BODY_FORCE))
    PetscCall(AddBodyForce(scene, clock->t + at * clock->dt, p, pr->force, scheme));
  if (pr->has_convection) PetscCall(AddConvection(scene, clock, ops, at, scheme));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  PredictorStart - What an implicit step starts from, in u*, how long it is, and its force

  Collective. BDF2 with w = ClockRatio(): k = dt (1+w)/(1+2w), start = ((1+w)^2 u^n - w^2
  u^{n-1})/(1+2w).

  Input Parameters:
+ history - BDF2 where u^{n-1} is known; else from u^n over dt
- at      - 1 or 1/2: where in the step the force is taken

  Output Parameter:
. dt - k [s]
*/
PetscErrorCode PredictorStart(const Scene *scene, const Clock *clock, const Particles *p,
                              const Operators *ops, PetscBool history, PetscReal at, Scheme *scheme,
                              PetscReal *dt)
{
  Projection     *pr = (Projection *)scheme->data;
  const PetscReal w  = history && scheme->time_order == 2 ? ClockRatio(clock) : 0.0;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < scene->dim; a++) {
    PetscCall(VecCopy(pr->u[a], pr->star[a]));
    PetscCall(VecAXPBY(pr->star[a], -w * w / (1.0 + 2.0 * w), PetscSqr(1.0 + w) / (1.0 + 2.0 * w),
                       pr->u_prev[a]));
  }
  PetscCall(AssembleForce(scene, clock, p, ops, at, scheme));
  *dt = clock->dt * (1.0 + w) / (1.0 + 2.0 * w);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* PredictVelocity - u*: where the viscous step starts, its force, and the step; collective */
PetscErrorCode PredictVelocity(const Scene *scene, const Clock *clock, Particles *p, Operators *ops,
                               Scheme *scheme)
{
  Projection                 *pr    = (Projection *)scheme->data;
  const ViscousIntegratorRow *kind  = scheme->visc ? ViscosityIntegrator(scheme->visc) : NULL;
  const PetscBool             inner = pr->has_convection && kind && kind->kind != TIME_IMPLICIT;
  PetscReal                   dt;

  PetscFunctionBegin;
  PetscCall(PredictorStart(scene, clock, p, ops, !kind || kind->history,
                           !kind || kind->end_of_step ? 1.0 : 0.5, scheme, &dt));
  pr->k = dt;
  if (scheme->visc) {
    const PetscReal projection_factor =
        scheme->projection ? dt * ViscosityResponse(scheme->visc) / scene->rho : 0.0;

    PetscCall(ViscositySolve(scene, clock, p, dt, projection_factor, pr->force,
                             inner ? pr->conv : NULL, ops, pr->star, scheme->visc,
                             &scheme->failure));
    pr->k *= ViscosityResponse(scheme->visc);
  } else {
    for (PetscInt a = 0; a < scene->dim; a++) PetscCall(VecAXPY(pr->star[a], dt, pr->force[a]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
