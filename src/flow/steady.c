/* The steady test: changes of velocity, divergence and pressure in a time scale of the flow. */
#include "isph/flow.h"

#define LONG    10.0 /* steps beyond it are no steps in time [time scale of the flow] */
#define SETTLED 0.02 /* distance from a steady flow that counts as none [-] */

/* Computes the root mean square of a vector over the volume of the fluid: theory.md,
   (particles:means). */
static PetscErrorCode RootMeanSquare(const Particles *p, Vec v, PetscReal *rms)
{
  PetscReal sum;

  PetscFunctionBegin;
  PetscCall(FluidSum(p, v, PETSC_TRUE, &sum));
  *rms = PetscSqrtReal(sum / p->weight);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the root mean square of b - a; collective. */
static PetscErrorCode RmsDifference(Flow *flow, Vec a, Vec b, PetscReal *rms)
{
  Vec difference;

  PetscFunctionBegin;
  PetscCall(FlowGetWork(flow, &difference));
  PetscCall(VecWAXPY(difference, -1.0, a, b));
  PetscCall(RootMeanSquare(flow->particles, difference, rms));
  PetscCall(FlowRestoreWork(flow, &difference));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the scale of pressures, rho U (U + nu/L) [Pa]. */
static PetscReal PressureScale(const Scene *scene)
{
  const PetscReal nu = SceneHas(scene, PHYSICS_VISCOSITY) ? scene->nu : 0.0;

  return scene->rho * scene->speed * (scene->speed + nu / scene->length);
}

/* Returns the shortest time scale of the flow, min(L/U, L^2/nu) [s]. */
static PetscReal TimeScale(const Scene *scene)
{
  const PetscReal advective = scene->length / scene->speed;

  if (!SceneHas(scene, PHYSICS_VISCOSITY)) return advective;
  return PetscMin(advective, PetscSqr(scene->length) / scene->nu_high);
}

/* FlowRmsSpeed - Returns the root mean square of the velocity, from the energy [m/s] */
PetscReal FlowRmsSpeed(const Flow *flow)
{
  const Particles *p = flow->particles;

  return PetscSqrtReal(2.0 * flow->scheme->stats.kinetic_energy /
                       (flow->scheme->stats.density * p->cell_volume * p->weight));
}

/* Measures the rates of change on fixed particles: of u and p at each particle, and of the root
   mean square of div u*, which converges to the error of the approximate projection and not to
   zero. Rates are relative changes in TimeScale(), or in a step if the step is longer. With an
   incremental projection at large steps, u changes little long before the flow is steady, but p
   still changes. */
static PetscErrorCode MeasureFixed(Flow *flow)
{
  const Scene     *scene = flow->scene;
  const FlowState *s     = flow->state;
  StepStats       *stats = &flow->scheme->stats;
  SteadyTest      *test  = &flow->scheme->steady;
  const PetscReal  scale = PetscMax(1.0, TimeScale(scene) / flow->clock->dt);
  PetscReal        sum = 0.0, div = 0.0, dp = 0.0;

  PetscFunctionBegin;
  for (PetscInt c = 0; c < scene->dim; c++) {
    PetscReal part;

    PetscCall(RmsDifference(flow, s->u[c], s->u_next[c], &part));
    sum += PetscSqr(part);
  }
  if (s->p) {
    PetscCall(RootMeanSquare(flow->particles, s->divergence, &div));
    PetscCall(RmsDifference(flow, s->p_before, s->p, &dp));
  }
  for (PetscInt k = 0; k < 3; k++) test->mean[k] = stats->change[k];
  stats->change[0] = PetscSqrtReal(sum) * scale / scene->speed;
  stats->change[1] = PetscAbsReal(div - test->divergence) * scale * scene->length / scene->speed;
  stats->change[2] = dp * scale / PressureScale(scene);
  test->divergence = div;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Measures the rates of change with moving particles. Shifting and new neighbours make single steps
   noisy. Therefore the root mean squares of u, div u* and p are averaged over windows of
   TimeScale(), but at least 20 steps, and compared with the averages of the window before. */
static PetscErrorCode MeasureMoving(Flow *flow)
{
  const Scene     *scene = flow->scene;
  const FlowState *s     = flow->state;
  StepStats       *stats = &flow->scheme->stats;
  SteadyTest      *test  = &flow->scheme->steady;
  const PetscReal  t = flow->clock->t + flow->clock->dt, T = TimeScale(scene), start = test->start;
  PetscReal        u, div = 0.0, pressure = 0.0;

  PetscFunctionBegin;
  u = FlowRmsSpeed(flow);
  if (s->p) {
    PetscCall(RootMeanSquare(flow->particles, s->divergence, &div));
    PetscCall(RootMeanSquare(flow->particles, s->p, &pressure));
  }
  test->sum[0] += u / scene->speed;
  test->sum[1] += div * scene->length / scene->speed;
  test->sum[2] += pressure / PressureScale(scene);
  test->count += 1.0;
  if (test->count < 20.0 || t - start < T) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < 3; k++) {
    const PetscReal now = test->sum[k] / test->count;

    stats->change[k] =
        start > 0.0 ? PetscAbsReal(now - test->mean[k]) * T / (t - start) : PETSC_INFINITY;
    test->mean[k] = now;
    test->sum[k]  = 0.0;
  }
  test->start = t;
  test->count = 0.0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns true if a step is much longer than the time scale of the flow, so that it serves to reach
   a steady flow only. */
static PetscBool IsLong(const Flow *flow)
{
  return flow->clock->dt > LONG * TimeScale(flow->scene);
}

/* SteadyMeasure - Measures the rates of change of the flow and sets stats.change, if -steady_tol is
   given or the step is long; collective */
PetscErrorCode SteadyMeasure(Flow *flow)
{
  const PetscBool tests = flow->clock->steady_tol > 0.0;

  PetscFunctionBegin;
  if (!tests && (!IsLong(flow) || flow->clock->steady_solve)) PetscFunctionReturn(PETSC_SUCCESS);
  if (tests && SceneMoves(flow->scene)) PetscCall(MeasureMoving(flow));
  else PetscCall(MeasureFixed(flow));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the distance of a quantity from its limit, if its last changes are the first terms of a
   geometric series. */
static PetscReal Distance(PetscReal now, PetscReal before)
{
  const PetscReal ratio = now < before ? now / before : 1.0;

  return now * ratio / PetscMax(1.0 - ratio, 1e-3);
}

/* SteadyView - Prints a line if the last step was much longer than the time scale of the flow, and
   the flow is still far from steady. Collective on the viewer. Steps of many diffusion times are
   taken to reach a steady flow. The changes may be small in each step and far from their sum: the
   pressure, and forces with it, can need hundreds of such steps. Prints nothing about flows whose
   driving depends on time, or whose bodies move. */
PetscErrorCode SteadyView(const Flow *flow, PetscViewer viewer)
{
  const Clock      *clock  = flow->clock;
  const PetscReal  *now    = flow->scheme->stats.change;
  const SteadyTest *test   = &flow->scheme->steady;
  const PetscReal   period = SceneDrivingPeriod(flow->scene, clock->t, clock->dt, 0.0);
  PetscReal         u, p;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < flow->scene->n_bodies; k++)
    if (flow->scene->boundary[SceneBodySide(flow->scene, k)].moves)
      PetscFunctionReturn(PETSC_SUCCESS);
  if (clock->steady_solve || clock->steady || clock->step < 3 || !IsLong(flow) ||
      clock->steady_tol > 0.0 || period < PETSC_INFINITY)
    PetscFunctionReturn(PETSC_SUCCESS);
  u = Distance(now[0], test->mean[0]);
  p = Distance(now[2], test->mean[2]);
  if (!(PetscMax(u, p) > SETTLED)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscViewerASCIIPrintf(
      viewer,
      "not steady: steps are %.2g times the time scale of the flow, and the last changes leave the "
      "velocity about %.2g %% of U and the pressure %.2g %% of its scale from steady; try more "
      "steps, or -scheme coupled\n",
      (double)(clock->dt / TimeScale(flow->scene)), 100.0 * (double)u, 100.0 * (double)p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SteadyRefuse - Refuses -steady_tol if the test could end the run far from the steady state.
   Collective. A flow with a driving force or wall velocity that depends on time has no steady
   state. A projection whose rotational term does not contain the whole viscosity converges slowly
   in the Stokes limit, so that at large steps the test is met too early: with the incremental
   projection at Re = 0.01 and nu dt/L^2 = 100, the cavity meets -steady_tol 1e-3 with an error of
   31 % in u_min. Input: projection - name of the projection; NULL: no pressure, or no splitting;
   rotational - flag: the projection has a rotational term, with the least viscosity. */
PetscErrorCode SteadyRefuse(const Flow *flow, const char projection[], PetscBool rotational)
{
  const Scene    *scene  = flow->scene;
  const Clock    *clock  = flow->clock;
  const PetscReal left   = scene->nu_high - (rotational ? scene->nu_low : 0.0);
  const PetscReal number = left * clock->dt / PetscSqr(scene->length);

  PetscFunctionBegin;
  UserCheck(clock->steady_tol == 0.0 || !SceneIsDrivenInTime(scene),
            "-steady_tol: a wall's velocity or the body force depends on t, and a temporarily "
            "steady flow would end the run; use -t_end");
  UserCheck(
      clock->steady_tol == 0.0 || !projection || !SceneHas(scene, PHYSICS_VISCOSITY) ||
          number <= 0.01,
      "-steady_tol with -projection %s at nu dt/L^2 = %.2g: convergence is too slow for a test of "
      "the steady state; use -projection rotational with a uniform viscosity, or -dt below %.2g",
      projection, (double)number, (double)(0.01 * clock->dt / number));
  PetscFunctionReturn(PETSC_SUCCESS);
}
