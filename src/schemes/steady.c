/*
  What a step did: energy, largest speed and divergence, and how far the flow still is from steady.
*/
#include "projection.h"

/* Root mean square over all fluid particles of a vector. */
static PetscErrorCode RootMeanSquare(const Particles *p, Vec v, PetscReal *rms)
{
  PetscFunctionBegin;
  PetscCall(VecNorm(v, NORM_2, rms));
  *rms /= PetscSqrtReal((PetscReal)PetscMax(p->N_fluid, 1));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Change of u at a fixed place: (u^{n+1} - u^n) - dr.grad u, rms over components. */
static PetscErrorCode ChangeOfVelocity(const Scene *scene, const Particles *p, const Operators *ops,
                                       Projection *pr, PetscReal *change)
{
  PetscReal sum = 0.0;

  PetscFunctionBegin;
  for (PetscInt c = 0; c < scene->dim; c++) {
    PetscReal          part;
    const PetscScalar *slope;
    PetscScalar       *diff;

    PetscCall(VecWAXPY(pr->force[c], -1.0, pr->u[c], pr->star[c]));
    for (PetscInt a = 0; pr->has_moved && a < scene->dim; a++) {
      PetscCall(AffineApply(&ops->grad_u[a], pr->star[c], ops->wall_u[c], pr->work));
      PetscCall(VecGetArrayRead(pr->work, &slope));
      PetscCall(VecGetArray(pr->force[c], &diff));
      for (PetscInt i = 0; i < p->n_fluid; i++) diff[i] -= pr->moved[a][i] * slope[i];
      PetscCall(VecRestoreArray(pr->force[c], &diff));
      PetscCall(VecRestoreArrayRead(pr->work, &slope));
    }
    PetscCall(RootMeanSquare(p, pr->force[c], &part));
    sum += PetscSqr(part);
  }
  *change = PetscSqrtReal(sum);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  The three rates that must all be small at a steady state: du, div u* and dp, each relative and per
  shortest time scale T = min(L/U, L^2/nu) or per step if that is longer. An incremental projection
  at large steps shows a small du long before the flow is right; div u* and dp tell.
*/
static PetscErrorCode MeasureChange(const Scene *scene, const Clock *clock, const Particles *p,
                                    const Operators *ops, Scheme *scheme)
{
  Projection     *pr    = (Projection *)scheme->data;
  StepStats      *stats = &scheme->stats;
  const PetscReal L = scene->length, U = scene->speed,
                  nu = SceneHas(scene, PHYSICS_VISCOSITY) ? scene->nu : 0.0;
  const PetscReal scale =
      PetscMax(1.0, PetscMin(L / U, nu > 0.0 ? L * L / nu : PETSC_MAX_REAL) / clock->dt);

  PetscReal div;

  PetscFunctionBegin;
  PetscCall(ChangeOfVelocity(scene, p, ops, pr, &stats->change_u));
  stats->change_u *= scale / U;
  stats->change_div = stats->change_p = 0.0;
  if (scheme->projection) {
    PetscCall(RootMeanSquare(p, pr->div, &div));
    stats->change_div = PetscAbsReal(div - pr->div_before) * scale * L / U;
    pr->div_before    = div;
    PetscCall(VecWAXPY(pr->work, -1.0, pr->p_before, pr->p));
    PetscCall(RootMeanSquare(p, pr->work, &stats->change_p));
    stats->change_p *= scale / (scene->rho * U * (U + nu / L));
  }
  stats->change = PetscMax(stats->change_u, PetscMax(stats->change_div, stats->change_p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Largest |D u| of the new velocity [1/s]. */
static PetscErrorCode MeasureDivergence(const Scene *scene, const Operators *ops, Projection *pr,
                                        PetscReal *largest)
{
  PetscFunctionBegin;
  PetscCall(VecZeroEntries(pr->work));
  for (PetscInt c = 0; c < scene->dim; c++) {
    PetscCall(AffineApplyAdd(&ops->div[c], pr->star[c], ops->wall_u[c], pr->work));
  }
  PetscCall(VecNorm(pr->work, NORM_INFINITY, largest));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  StepJudge - Measures the step just made, u* being the new velocity, and stops a run gone wrong

  Collective.

  Errors: PETSC_ERR_FP where energy is not finite or speeds have left every bound
*/
PetscErrorCode StepJudge(const Scene *scene, const Clock *clock, const Particles *p,
                         const Operators *ops, Scheme *scheme)
{
  Projection        *pr    = (Projection *)scheme->data;
  StepStats         *stats = &scheme->stats;
  PetscReal          sum = 0.0, most = 0.0;
  const PetscScalar *u[ISPH_MAX_DIM];

  PetscFunctionBegin;
  for (PetscInt a = 0; a < scene->dim; a++) PetscCall(VecGetArrayRead(pr->star[a], &u[a]));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscReal speed2 = 0.0;

    for (PetscInt a = 0; a < scene->dim; a++) speed2 += PetscSqr(u[a][i]);
    sum += speed2;
    most = PetscMax(most, speed2);
  }
  for (PetscInt a = 0; a < scene->dim; a++) PetscCall(VecRestoreArrayRead(pr->star[a], &u[a]));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPIU_REAL, MPIU_SUM, p->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPIU_REAL, MPIU_MAX, p->comm));
  stats->kinetic_energy = 0.5 * scene->rho * SceneVolume(scene) * sum;
  stats->speed_max      = PetscSqrtReal(most);
  PetscCheck(!PetscIsInfOrNanReal(sum) && stats->speed_max < 100.0 * scene->speed, PETSC_COMM_WORLD,
             PETSC_ERR_FP,
             "step %" PetscInt_FMT
             " (t = %.6g): the velocity has left every bound (largest speed %.6g, reference %.6g): "
             "the flow is unstable at dt = %.6g (CFL %.2g); try a smaller -dt or -cfl",
             clock->step + 1, (double)(clock->t + clock->dt), (double)stats->speed_max,
             (double)scene->speed, (double)clock->dt,
             (double)(clock->dt * scene->speed / scene->dx));
  stats->visc_its = scheme->visc ? ViscosityIterations(scheme->visc) : 0;
  stats->ppe_its  = scheme->ppe ? PressureIterations(scheme->ppe) : 0;
  stats->visc_its_sum += stats->visc_its;
  stats->ppe_its_sum += stats->ppe_its;
  if (scheme->projection) PetscCall(MeasureDivergence(scene, ops, pr, &stats->divergence));
  if (clock->steady_tol > 0.0) PetscCall(MeasureChange(scene, clock, p, ops, scheme));
  PetscFunctionReturn(PETSC_SUCCESS);
}
