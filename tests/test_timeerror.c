/*
  The error in time: its estimate is exact for cubic functions of time, gradients have no part in
  the solenoidal norm, and periods of expressions are found at any length of the window.
*/
/* RANKS: 1 2 */
#include "isph/start.h"
#include "isph/schemes.h"
#include "crowd.h"

/* Creates a flow of particles on a lattice, without operators. */
static void Make(Setting *s, Flow *flow, Clock *clock, FlowState *state, Scheme *scheme)
{
  static const SchemeRow row = {.name = "none", .Limit = FlowLimit};
  static DtAdaptRow      adapt;

  adapt           = (DtAdaptRow){.name = "error", .follows = PETSC_TRUE};
  s->scene.jitter = 0.0;
  s->scene.length = s->scene.speed = s->scene.rho = 1.0;
  *clock  = (Clock){.cfl = 0.5, .order = 2, .adapt = &adapt, .dt_max = PETSC_INFINITY};
  *state  = (FlowState){.epoch = 0};
  *scheme = (Scheme){.row = &row};
  *flow   = (Flow){.scene = &s->scene, .clock = clock, .state = state, .scheme = scheme};
  ASSERT_OK(ParticlesCreate(&s->scene, RADIUS * s->scene.dx, &flow->particles));
  ASSERT_OK(ParticlesFill(&s->scene, s->walls, NULL, flow->particles));
  for (PetscInt a = 0; a < s->scene.dim; a++) {
    ASSERT_OK(FluidVec(flow->particles, NULL, &state->u[a]));
    ASSERT_OK(FluidVec(flow->particles, NULL, &state->u_prev[a]));
    ASSERT_OK(FluidVec(flow->particles, NULL, &state->u_before[a]));
    ASSERT_OK(FluidVec(flow->particles, NULL, &state->u_next[a]));
  }
}

static void Free(Flow *flow)
{
  FlowState *s = flow->state;

  for (PetscInt a = 0; a < flow->scene->dim; a++) {
    ASSERT_OK(VecDestroy(&s->u[a]));
    ASSERT_OK(VecDestroy(&s->u_prev[a]));
    ASSERT_OK(VecDestroy(&s->u_before[a]));
    ASSERT_OK(VecDestroy(&s->u_next[a]));
  }
  for (PetscInt k = 0; k < FLOW_MAX_WORK; k++) ASSERT_OK(VecDestroy(&s->work[k]));
  ASSERT_OK(ParticlesDestroy(&flow->particles));
}

/* Sets the velocities of four times to t^m along the first axis. */
static void SetPower(Flow *flow, PetscInt m)
{
  const Clock    *c   = flow->clock;
  FlowState      *s   = flow->state;
  const PetscReal now = 0.7, before = now - c->dt_previous;
  const PetscReal t[]   = {now + c->dt, now, before, before - c->dt_before};
  Vec *const      all[] = {s->u_next, s->u, s->u_prev, s->u_before};

  for (PetscInt k = 0; k < 4; k++) {
    for (PetscInt a = 0; a < flow->scene->dim; a++)
      ASSERT_OK(VecSet(all[k][a], a ? 0.0 : PetscPowReal(t[k], (PetscReal)m)));
  }
}

/*
  The error of BDF2 is k h (h + h1) u'''/6, with k = h (1 + w)/(1 + 2w), w = h/h1, if u^{n+1} is
  exact: then u^{n+1} - P = h (h + h1) (h + h1 + h2) u'''/6, and the estimate is this error to first
  order in k/(h + h1 + h2). The error of backward Euler is h^2 u''/2.
*/
static void test_order(void **state)
{
  const PetscReal steps[][3] = {{0.1, 0.1, 0.1}, {0.2, 0.1, 0.15}, {0.05, 0.1, 0.07}};

  (void)state;
  for (PetscInt order = 1; order <= 2; order++) {
    for (PetscInt k = 0; k < 3; k++) {
      Setting   s = CrowdBox("2D channel", 2, 8, 8, 1, 1, 1);
      FlowState flow_state;
      Scheme    scheme;
      Clock     clock;
      Flow      flow;

      Make(&s, &flow, &clock, &flow_state, &scheme);
      clock.order        = order;
      clock.step         = 5;
      clock.control.rtol = 1e3; /* every step is kept */
      clock.dt           = steps[k][0];
      clock.dt_previous  = steps[k][1];
      clock.dt_before    = steps[k][2];
      for (PetscInt m = 0; m <= order + 1; m++) {
        const PetscReal h = clock.dt, a = h + clock.dt_previous, b = a + clock.dt_before,
                        w = ClockRatio(&clock), k_bdf = h * (1.0 + w) / (1.0 + 2.0 * w);
        const PetscReal exact = m <= order   ? 0.0
                                : order == 1 ? h * h * a / (h + a)
                                             : k_bdf * h * a * b / (k_bdf + b);

        SetPower(&flow, m);
        ASSERT_OK(TimeErrorCheck(&flow));
        CloudAssertNone("kept", s.name, scheme.failure.code != 0);
        CloudAssertNone("error", s.name,
                        PetscAbsReal(clock.control.last * clock.control.rtol * 0.1 -
                                     PetscMax(exact, 1e-4)) > 1e-12);
      }
      Free(&flow);
    }
  }
}

/* A step with too large an error fails, and its next length has the error that the controller aims
   at. */
static void test_rejection(void **state)
{
  Setting   s = CrowdBox("2D channel", 2, 8, 8, 1, 1, 1);
  FlowState flow_state;
  Scheme    scheme;
  Clock     clock;
  Flow      flow;

  (void)state;
  Make(&s, &flow, &clock, &flow_state, &scheme);
  clock.step         = 5;
  clock.control.rtol = 1e-3;
  clock.dt = clock.dt_previous = clock.dt_before = 0.05;
  SetPower(&flow, 3);
  ASSERT_OK(TimeErrorCheck(&flow));
  /* u = t^3, C = 2/11: 2/11 6 h^3 = 1.4e-4, tolerance 1e-4 */
  CloudAssertNone("rejected", s.name, !scheme.failure.code);
  CloudAssertNone("length", s.name,
                  PetscAbsReal(scheme.failure.dt_next -
                               0.05 * PetscPowReal(0.7 * 11e-4 / (12 * 1.25e-4), 1.0 / 3.0)) >
                      1e-12);
  Free(&flow);
}

/* Sets e to the gradient of cos(k x) cos(l y), or to the curl of sin(k x) sin(l y). */
static void SetField(const Flow *flow, PetscBool gradient, PetscInt k, PetscInt l, Vec e[])
{
  const Scene *scene = flow->scene;
  PetscScalar *v[2];

  for (PetscInt a = 0; a < 2; a++) ASSERT_OK(VecGetArray(e[a], &v[a]));
  for (PetscInt i = 0; i < flow->particles->n_fluid; i++) {
    PetscReal w[2], phase[2];

    for (PetscInt a = 0; a < 2; a++) {
      w[a]     = (a ? l : k) * PETSC_PI / (scene->hi[a] - scene->lo[a]);
      phase[a] = w[a] * (flow->particles->x[a][i] - scene->lo[a]);
    }
    if (gradient) {
      v[0][i] = -w[0] * PetscSinReal(phase[0]) * PetscCosReal(phase[1]);
      v[1][i] = -w[1] * PetscCosReal(phase[0]) * PetscSinReal(phase[1]);
    } else {
      v[0][i] = w[1] * PetscSinReal(phase[0]) * PetscCosReal(phase[1]);
      v[1][i] = -w[0] * PetscCosReal(phase[0]) * PetscSinReal(phase[1]);
    }
  }
  for (PetscInt a = 0; a < 2; a++) ASSERT_OK(VecRestoreArray(e[a], &v[a]));
}

/* Midpoint sums of these harmonics over a lattice are exact: gradients have the norm zero, and a
   smooth curl keeps its root mean square. */
static void test_norm(void **state)
{
  Setting   s = CrowdBox("2D box", 2, 24, 20, 1, 0, 1);
  FlowState flow_state;
  Scheme    scheme;
  Clock     clock;
  Flow      flow;
  PetscReal norm, sums[2];

  (void)state;
  Make(&s, &flow, &clock, &flow_state, &scheme);
  for (PetscInt k = 1; k <= 4; k++) {
    SetField(&flow, PETSC_TRUE, k, 5 - k, flow_state.u);
    ASSERT_OK(SolenoidalNorm(flow.scene, flow.particles, flow_state.u, &norm));
    CloudAssertNone("gradient", s.name, norm > 1e-12);
    SetField(&flow, PETSC_FALSE, k, 5 - k, flow_state.u);
    ASSERT_OK(SolenoidalNorm(flow.scene, flow.particles, flow_state.u, &norm));
    for (PetscInt a = 0; a < 2; a++)
      ASSERT_OK(FluidSum(flow.particles, flow_state.u[a], PETSC_TRUE, &sums[a]));
    CloudAssertNone(
        "curl", s.name,
        PetscAbsReal(norm - PetscSqrtReal((sums[0] + sums[1]) / flow.particles->weight)) > 1e-12);
  }
  Free(&flow);
}

/* Returns the period of a force within a window of 1 s. */
static PetscReal Period(const char text[])
{
  Setting          s     = CrowdBox("2D channel", 2, 8, 8, 1, 1, 1);
  ExpressionScope *scope = NULL;
  PetscReal        period;

  s.scene.length = 1.0;
  ASSERT_OK(ExpressionScopeCreate(2, NULL, &scope));
  ASSERT_OK(ExpressionSet(scope, "-body_force", text, 2, 2, EXPRESSION_PLACE | EXPRESSION_TIME,
                          &s.scene.force));
  period = SceneDrivingPeriod(&s.scene, 0.3, 1.0, 1e-6);
  ASSERT_OK(ExpressionScopeCheck(scope));
  ASSERT_OK(ExpressionScopeDestroy(&scope));
  return period;
}

static void test_period(void **state)
{
  const struct {
    const char *text;
    PetscReal   low, high;
  } samples[] = {
      {"cos(2*pi*t/0.3), 0", 0.27, 0.33},
      {"x*cos(2*pi*t/0.3), y", 0.27, 0.33},
      {"1 + t, 3*cos(2*pi*t/1e-3)", 0.8e-3, 1.2e-3},
      {"cos(2*pi*t*64), 0", 0.8 / 64, 1.2 / 64}, /* the period of the samples of the first window */
      {"sin(2*pi*t*1e5), 0", 0.8e-5, 1.2e-5},
      {"cos(2*pi*t*312.5), 0", 0.8 / 312.5, 1.2 / 312.5},
      {"sin(t), 0", 1.0, PETSC_INFINITY}, /* longer than the window */
      {"t < 0.5 ? 0 : 1, 0", 1.0, PETSC_INFINITY},
      {"log(0.5-t), 1", 1.0, PETSC_INFINITY},           /* not finite in a part of the window */
      {"1e-9*sin(2*pi*t*100), 1", 1.0, PETSC_INFINITY}, /* no more than `least` */
      {"x, 2", 1.0, PETSC_INFINITY},
  };

  (void)state;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(samples); k++) {
    const PetscReal period = Period(samples[k].text);

    if (!(period >= samples[k].low && period <= samples[k].high))
      fail_msg("'%s' has the period %g", samples[k].text, (double)period);
  }
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_order),
      cmocka_unit_test(test_rejection),
      cmocka_unit_test(test_norm),
      cmocka_unit_test(test_period),
  };
  int failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
  return PetscFinalize() || failed ? 1 : 0;
}
