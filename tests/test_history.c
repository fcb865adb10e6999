/*
  The formulas in time are exact for polynomials of t up to their order, with steps of unequal
  lengths, and fall to a lower order where earlier velocities are not known or steps grow too fast.
*/
/* RANKS: 1 */
#include "isph/schemes.h"
#include "cloud.h"

static const PetscReal now        = 0.7,
                       steps[][3] = {{0.1, 0.1, 0.1}, {0.12, 0.1, 0.15}, {0.05, 0.1, 0.07}};

static Clock ClockOf(PetscInt order, const PetscReal length[3])
{
  return (Clock){.order = order, .dt = length[0], .dt_previous = length[1], .dt_before = length[2]};
}

/* Returns the sum of weights times t^m at t^n, t^{n-1}, t^{n-2}. */
static PetscReal Sum(const Clock *c, PetscInt m, const PetscReal weight[HISTORY])
{
  const PetscReal t[] = {now, now - c->dt_previous, now - c->dt_previous - c->dt_before};
  PetscReal       sum = 0.0;

  for (PetscInt k = 0; k < HISTORY; k++) sum += weight[k] * PetscPowReal(t[k], (PetscReal)m);
  return sum;
}

/* Extrapolations to two times of the step, and the path, whose velocity is t^m. */
static void test_ahead_and_path(void **state)
{
  (void)state;
  for (PetscInt order = 1; order <= 3; order++) {
    for (PetscInt k = 0; k < 3; k++) {
      const Clock     clock = ClockOf(order, steps[k]);
      const PetscReal dt = clock.dt, end = now + dt;
      PetscReal       weight[HISTORY];

      for (PetscInt m = 0; m < order; m++) {
        const PetscReal p = (PetscReal)m;

        for (PetscInt half = 1; half <= 2; half++) {
          HistoryAhead(&clock, 0.5 * (PetscReal)half, weight);
          assert_true(PetscAbsReal(Sum(&clock, m, weight) -
                                   PetscPowReal(now + 0.5 * (PetscReal)half * dt, p)) < 1e-12);
        }
        HistoryPath(&clock, weight);
        assert_true(PetscAbsReal(Sum(&clock, m, weight) -
                                 (PetscPowReal(end, p + 1.0) - PetscPowReal(now, p + 1.0)) /
                                     ((p + 1.0) * dt)) < 1e-12);
      }
    }
  }
}

/* Sets the velocities of a flow to t^m. */
static void SetPower(const Clock *c, PetscInt m, FlowState *s)
{
  const PetscReal t[]   = {now, now - c->dt_previous, now - c->dt_previous - c->dt_before};
  const Vec       all[] = {s->u[0], s->u_prev[0], s->u_before[0]};

  for (PetscInt k = 0; k < 3; k++) ASSERT_OK(VecSet(all[k], PetscPowReal(t[k], (PetscReal)m)));
}

/* (u^{n+1} - start)/k is the derivative at the end of the step. */
static void test_start(void **state)
{
  Scene     scene = {.dim = 1};
  FlowState s     = {.epoch = 0};
  Vec      *all[] = {&s.u[0], &s.u_prev[0], &s.u_before[0], &s.u_next[0]};

  (void)state;
  for (PetscInt k = 0; k < 4; k++) ASSERT_OK(VecCreateSeq(PETSC_COMM_SELF, 1, all[k]));
  for (PetscInt order = 1; order <= 3; order++) {
    for (PetscInt k = 0; k < 3; k++) {
      Clock           clock = ClockOf(order, steps[k]);
      Flow            flow  = {.scene = &scene, .clock = &clock, .state = &s};
      const PetscReal end   = now + clock.dt;

      for (PetscInt m = 0; m <= order; m++) {
        const PetscReal slope = m ? (PetscReal)m * PetscPowReal(end, (PetscReal)(m - 1)) : 0.0;
        PetscReal       dt, start;

        SetPower(&clock, m, &s);
        ASSERT_OK(HistoryStart(&flow, PETSC_TRUE, &dt));
        ASSERT_OK(VecSum(s.u_next[0], &start));
        assert_true(PetscAbsReal(PetscPowReal(end, (PetscReal)m) - start - dt * slope) < 1e-12);
      }
    }
  }
  for (PetscInt k = 0; k < 4; k++) ASSERT_OK(VecDestroy(all[k]));
}

/* Formulas that are blended with order 1 are exact for linear velocities at the end of a step, and
   for constant ones along a path; a whole jump leaves u^n alone. */
static void test_jump(void **state)
{
  const PetscReal shares[] = {0.3, 1.0};
  Scene           scene    = {.dim = 1};
  FlowState       s        = {.epoch = 0};
  Vec            *all[]    = {&s.u[0], &s.u_prev[0], &s.u_before[0], &s.u_next[0]};

  (void)state;
  for (PetscInt k = 0; k < 4; k++) ASSERT_OK(VecCreateSeq(PETSC_COMM_SELF, 1, all[k]));
  for (PetscInt k = 0; k < 12; k++) {
    Clock     clock = ClockOf(2 + k % 2, steps[k / 4]);
    Flow      flow  = {.scene = &scene, .clock = &clock, .state = &s};
    PetscReal dt, start, weight[HISTORY];

    clock.jump = shares[k / 2 % 2];
    HistoryPath(&clock, weight);
    assert_true(PetscAbsReal(weight[0] + weight[1] + weight[2] - 1.0) < 1e-12);
    for (PetscInt m = 0; m < 2; m++) {
      SetPower(&clock, m, &s);
      ASSERT_OK(HistoryStart(&flow, PETSC_TRUE, &dt));
      ASSERT_OK(VecSum(s.u_next[0], &start));
      assert_true(PetscAbsReal((m ? now + clock.dt - dt : 1.0) - start) < 1e-12);
    }
    if (clock.jump < 1.0) continue;
    assert_true(weight[0] == 1.0 && weight[1] == 0.0 && weight[2] == 0.0);
    assert_true(dt == clock.dt && start == now);
  }
  for (PetscInt k = 0; k < 4; k++) ASSERT_OK(VecDestroy(all[k]));
}

/* The order follows what is known: one velocity, two, three; and the ratio of steps. */
static void test_fall(void **state)
{
  const struct {
    PetscReal length[3];
    PetscInt  order;
  } cases[] = {{{0.1, 0.0, 0.0}, 1}, {{0.1, 0.1, 0.0}, 2},  {{0.1, 0.1, 0.1}, 3},
               {{0.1, 0.2, 0.1}, 3}, {{0.15, 0.1, 0.1}, 3}, {{0.16, 0.1, 0.1}, 2},
               {{0.2, 0.1, 0.1}, 2}, {{0.25, 0.1, 0.1}, 1}};

  (void)state;
  for (size_t k = 0; k < sizeof(cases) / sizeof(cases[0]); k++) {
    const Clock third = ClockOf(3, cases[k].length), second = ClockOf(2, cases[k].length),
                first = ClockOf(1, cases[k].length);

    assert_int_equal(ClockOrder(&third), cases[k].order);
    assert_int_equal(ClockOrder(&second), PetscMin(cases[k].order, 2));
    assert_int_equal(ClockOrder(&first), 1);
  }
}

/* With -time_order 3 the first steps grow by CLOCK_GROWTH up to the whole length. */
static void test_first_steps(void **state)
{
  static const DtAdaptRow adapt = {.name = "none"};
  const StepLimit         limit = {.dt = 1.0};
  Clock clock = {.order = 3, .adapt = &adapt, .dt_given = 0.01, .t_end = 1e9, .dt_max = 1.0};

  (void)state;
  clock.control.dt = PETSC_INFINITY;
  for (clock.step = 0; clock.step < 12; clock.step++) {
    const PetscReal left = (PetscReal)PetscMax(CLOCK_SHORT - clock.step, 0);

    ASSERT_OK(ClockChoose(&limit, &clock));
    assert_true(PetscAbsReal(clock.dt / (0.01 * PetscPowReal(CLOCK_GROWTH, -left)) - 1.0) < 1e-6);
  }
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_ahead_and_path), cmocka_unit_test(test_start),
      cmocka_unit_test(test_jump),           cmocka_unit_test(test_fall),
      cmocka_unit_test(test_first_steps),
  };
  int failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  return PetscFinalize() || failed ? 1 : 0;
}
