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

/* Root mean square of u^{n+1} - u^n of fixed particles. */
static PetscErrorCode ChangeOfVelocity(const Scene *scene, const Particles *p, Projection *pr,
                                       PetscReal *change)
{
  PetscReal sum = 0.0, part;

  PetscFunctionBegin;
  for (PetscInt c = 0; c < scene->dim; c++) {
    PetscCall(VecWAXPY(pr->force[c], -1.0, pr->u[c], pr->star[c]));
    PetscCall(RootMeanSquare(p, pr->force[c], &part));
    sum += PetscSqr(part);
  }
  *change = PetscSqrtReal(sum);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What pressures are measured by, rho U (U + nu/L) [Pa]. */
static PetscReal PressureScale(const Scene *scene)
{
  const PetscReal nu = SceneHas(scene, PHYSICS_VISCOSITY) ? scene->nu : 0.0;

  return scene->rho * scene->speed * (scene->speed + nu / scene->length);
}

/* The shortest time scale of the flow, min(L/U, L^2/nu) [s]. */
static PetscReal TimeScale(const Scene *scene)
{
  const PetscReal advective = scene->length / scene->speed;

  if (!SceneHas(scene, PHYSICS_VISCOSITY)) return advective;
  return PetscMin(advective, PetscSqr(scene->length) / scene->nu_high);
}

/*
  The rates of fixed particles: of u and p at each particle and of div u*, whose root mean square
  settles at what the approximate projection leaves, not at zero; all relative, per time scale T, or
  per step if that is longer. An incremental projection at large steps shows a small du long before
  the flow is right; the pressure increment tells.
*/
static PetscErrorCode MeasureChange_Fixed(const Scene *scene, const Clock *clock,
                                          const Particles *p, Scheme *scheme)
{
  Projection     *pr    = (Projection *)scheme->data;
  StepStats      *stats = &scheme->stats;
  const PetscReal scale = PetscMax(1.0, TimeScale(scene) / clock->dt);
  PetscReal       du = 0.0, div = 0.0, dp = 0.0;

  PetscFunctionBegin;
  PetscCall(ChangeOfVelocity(scene, p, pr, &du));
  if (pr->p) {
    PetscCall(RootMeanSquare(p, pr->div, &div));
    PetscCall(VecWAXPY(pr->work, -1.0, pr->p_before, pr->p));
    PetscCall(RootMeanSquare(p, pr->work, &dp));
  }
  stats->change[0] = du * scale / scene->speed;
  stats->change[1] =
      PetscAbsReal(div - scheme->number[NUMBER_DIV]) * scale * scene->length / scene->speed;
  stats->change[2]           = dp * scale / PressureScale(scene);
  scheme->number[NUMBER_DIV] = div;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Root mean square of the velocity, from the energy [m/s]. */
static PetscReal RmsSpeed(const Scene *scene, const Particles *p, const StepStats *stats)
{
  return PetscSqrtReal(2.0 * stats->kinetic_energy /
                       (scene->rho * SceneVolume(scene) * PetscMax(p->N_fluid, 1)));
}

/*
  The rates of moving particles: single steps are noise of shifting and of new neighbours, so means
  of the root mean squares of u, div u* and p over windows of T, at least 20 steps, are compared,
  each with the window before.
*/
static PetscErrorCode MeasureChange_Moving(const Scene *scene, const Clock *clock,
                                           const Particles *p, Scheme *scheme)
{
  Projection     *pr     = (Projection *)scheme->data;
  StepStats      *stats  = &scheme->stats;
  PetscReal      *number = scheme->number, *sum = &number[NUMBER_SUM], *mean = &number[NUMBER_MEAN];
  const PetscReal t = clock->t + clock->dt, T = TimeScale(scene), start = number[NUMBER_START];
  PetscReal       u, div = 0.0, pressure = 0.0;

  PetscFunctionBegin;
  u = RmsSpeed(scene, p, stats);
  if (pr->p) {
    PetscCall(RootMeanSquare(p, pr->div, &div));
    PetscCall(RootMeanSquare(p, pr->p, &pressure));
  }
  sum[0] += u / scene->speed;
  sum[1] += div * scene->length / scene->speed;
  sum[2] += pressure / PressureScale(scene);
  number[NUMBER_COUNT] += 1.0;
  if (number[NUMBER_COUNT] < 20.0 || t - start < T) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < 3; k++) {
    const PetscReal now = sum[k] / number[NUMBER_COUNT];

    stats->change[k] = start > 0.0 ? PetscAbsReal(now - mean[k]) * T / (t - start) : PETSC_INFINITY;
    mean[k]          = now;
    sum[k]           = 0.0;
  }
  number[NUMBER_START] = t;
  number[NUMBER_COUNT] = 0.0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Largest |D u| of the new velocity [1/s]. */
static PetscErrorCode MeasureDivergence(const Scene *scene, const Operators *ops, const Vec u[],
                                        Projection *pr, PetscReal *largest)
{
  PetscFunctionBegin;
  PetscCall(VecZeroEntries(pr->work));
  for (PetscInt c = 0; c < scene->dim; c++) {
    PetscCall(AffineApplyAdd(&ops->div[c], u[c], ops->wall_u[c], pr->work));
  }
  PetscCall(VecNorm(pr->work, NORM_INFINITY, largest));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Kinetic energy, largest speed and, where there is a pressure, largest divergence

  Collective. Input: u - velocity components. Output: scheme->stats.
*/
static PetscErrorCode MeasureFlow(const Scene *scene, const Particles *p, const Operators *ops,
                                  const Vec u[], Scheme *scheme)
{
  StepStats         *stats = &scheme->stats;
  PetscReal          sum = 0.0, most[2] = {0.0, ops->wall_speed_bound};
  const PetscScalar *v[ISPH_MAX_DIM];

  PetscFunctionBegin;
  for (PetscInt a = 0; a < scene->dim; a++) PetscCall(VecGetArrayRead(u[a], &v[a]));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscReal speed2 = 0.0;

    for (PetscInt a = 0; a < scene->dim; a++) speed2 += PetscSqr(v[a][i]);
    sum += speed2;
    most[0] = PetscMax(most[0], PetscSqrtReal(speed2));
  }
  for (PetscInt a = 0; a < scene->dim; a++) PetscCall(VecRestoreArrayRead(u[a], &v[a]));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPIU_REAL, MPIU_SUM, p->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, most, 2, MPIU_REAL, MPIU_MAX, p->comm));
  stats->kinetic_energy   = 0.5 * scene->rho * SceneVolume(scene) * sum;
  stats->speed_max        = most[0];
  stats->wall_speed_bound = most[1];
  if (p->p)
    PetscCall(MeasureDivergence(scene, ops, u, (Projection *)scheme->data, &stats->divergence));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* MeasureBegin - What a step would have measured, of the flow at the start; collective */
PetscErrorCode MeasureBegin(const Scene *scene, const Particles *p, const Operators *ops,
                            Scheme *scheme)
{
  PetscFunctionBegin;
  PetscCall(MeasureFlow(scene, p, ops, ((Projection *)scheme->data)->u, scheme));
  if (SceneHas(scene, PHYSICS_BODY_FORCE)) PetscCall(AddBodyForce(scene, 0.0, p, NULL, scheme));
  for (PetscInt k = 0; k < 3; k++) scheme->stats.change[k] = PETSC_INFINITY;
  scheme->number[NUMBER_SPEED] = RmsSpeed(scene, p, &scheme->stats);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  What the velocity's root mean square can be by all that moves the flow, 5 % added for
  discretisation, 1e-6 U for rounding

    |u| <= |u|(0) + min(int F dt, max F/r) + max wall drive,  F = max |f|

  with the rate r at which walls at rest would slow it (SceneDecayRate()). All but the last term
  follow from the energy's balance, whatever the length of the step; that walls make no flow faster
  than SceneWallSpeedBound() holds of every flow known to be right, with room: a cavity has a third
  of that at most.
*/
static PetscReal SpeedBound(const Scene *scene, const Clock *clock, Scheme *scheme)
{
  const PetscReal rate   = SceneDecayRate(scene);
  PetscReal      *number = scheme->number, forced;

  if (scheme->force_step > 0.0)
    number[NUMBER_IMPULSE] += clock->steady_solve ? PETSC_INFINITY : scheme->force_step * clock->dt;
  number[NUMBER_FORCE] = PetscMax(number[NUMBER_FORCE], scheme->force_step);
  number[NUMBER_WALLS] = PetscMax(number[NUMBER_WALLS], scheme->stats.wall_speed_bound);
  scheme->force_step   = 0.0;
  forced               = number[NUMBER_IMPULSE];
  if (rate > 0.0) forced = PetscMin(forced, number[NUMBER_FORCE] / rate);
  return 1.05 * (number[NUMBER_SPEED] + forced + number[NUMBER_WALLS]) + 1e-6 * scene->speed;
}

/*
  StepMeasure - Measures the step just made, u* being the new velocity, and tells one gone wrong

  Collective. Sets scheme->failure where energy is not finite, or is more than what moves the flow
  can have made of it, or a particle is a hundred times as fast as the reference.
*/
PetscErrorCode StepMeasure(const Scene *scene, const Clock *clock, const Particles *p,
                           const Operators *ops, Scheme *scheme)
{
  Projection *pr    = (Projection *)scheme->data;
  StepStats  *stats = &scheme->stats;
  PetscReal   bound, rms;

  PetscFunctionBegin;
  PetscCall(MeasureFlow(scene, p, ops, pr->star, scheme));
  bound = SpeedBound(scene, clock, scheme);
  rms   = RmsSpeed(scene, p, stats);
  if (!(rms <= bound) || stats->speed_max >= 100.0 * scene->speed) {
    char where[CLOCK_WHERE], advice[128] = "try a smaller -coupled_ksp_rtol, or advance in time";

    PetscCall(ClockWhere(clock, where));
    if (!clock->steady_solve) {
      PetscCall(
          PetscSNPrintf(advice, sizeof(advice),
                        "the flow is unstable at dt = %.6g (CFL %.2g); try a smaller -dt or -cfl",
                        (double)clock->dt, (double)(clock->dt * scene->speed / scene->dx)));
    }
    FailureSet(&scheme->failure, PETSC_ERR_FP,
               "%s: the velocity has left every bound (root mean square %.6g, at most %.6g by what "
               "moves the flow; largest %.6g, reference %.6g): %s",
               where, (double)rms, (double)bound, (double)stats->speed_max, (double)scene->speed,
               advice);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  stats->visc_its = scheme->visc ? ViscosityIterations(scheme->visc) : 0;
  if (scheme->coupled) stats->visc_its = CoupledIterations(scheme->coupled);
  stats->ppe_its = scheme->ppe ? PressureIterations(scheme->ppe) : 0;
  stats->visc_its_sum += stats->visc_its;
  stats->ppe_its_sum += stats->ppe_its;
  if (clock->steady_tol > 0.0 && SceneMoves(scene)) {
    PetscCall(MeasureChange_Moving(scene, clock, p, scheme));
  } else if (clock->steady_tol > 0.0) {
    PetscCall(MeasureChange_Fixed(scene, clock, p, scheme));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
