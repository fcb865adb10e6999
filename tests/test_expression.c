/*
  Expressions: compares values with C arithmetic and rates with derivatives. Checks the dependence
  on place and time, and the refusal of malformed texts by messages with the option and the fault.
*/
/* RANKS: 1 2 */
#include <string.h>
#include "cloud.h"
#include "isph/options.h"

#define ANYWHERE (EXPRESSION_PLACE | EXPRESSION_TIME)

/* Creates a scope of `dim` dimensions in which nu = 0.25. */
static ExpressionScope *Scope(PetscInt dim)
{
  ExpressionScope *scope = NULL;

  assert_int_equal(ExpressionScopeCreate(dim, NULL, &scope), PETSC_SUCCESS);
  assert_int_equal(ExpressionScopeDefine(scope, "nu", 0.25), PETSC_SUCCESS);
  return scope;
}

static void test_values(void **state)
{
  const PetscReal  x[] = {0.3, -0.7, 1.1}, t = 2.0;
  ExpressionScope *scope = Scope(3);
  const struct {
    const char *text;
    PetscReal   value;
    unsigned    uses;
  } samples[] = {
      {"-1.5e-3", -1.5e-3, 0},
      {" 0.1 ", 0.1, 0},
      {"2*pi*nu", 0.5 * PETSC_PI, 0},
      {"x+2*y-z/2", 0.3 - 1.4 - 0.55, EXPRESSION_PLACE},
      {"sin(2*pi*t)+t^2", 4.0, EXPRESSION_TIME},
      {"min(x, y) * max(t, 1)", -1.4, ANYWHERE},
      {"x > 0 && t <= 2 ? exp(-x) : 7", 0.74081822068171788, ANYWHERE},
      {"log(t)", 0.69314718055994531, EXPRESSION_TIME}, /* natural */
      {"-x^2", -0.09, EXPRESSION_PLACE},
      {"(-y)", 0.7, EXPRESSION_PLACE},
      {"0.5 && 1", 1.0, 0}, /* every number except 0 is true: also one below 1, */
      {"nu || 0", 1.0, 0},  /* a constant, */
      {"(2^-1 + 0.2) && -0.5", 1.0, 0},
      {"41e30 && 1", 1.0, 0}, /* and one above the largest int */
      {"t*(0 || 0.5) + (0.5 && 0)", 2.0, EXPRESSION_TIME},
      {"1 || 1 && 0", 1.0, 0}, /* && before ||, both after == and < */
      {"0 && 0 || x", 1.0, EXPRESSION_PLACE},
      {"0 || 0 && 1", 0.0, 0},
      {"2 == 2 && x<1&&-y", 1.0, EXPRESSION_PLACE},
  };

  (void)state;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(samples); k++) {
    const PetscReal wanted = samples[k].value;
    Expression      e;
    PetscReal       value;

    assert_int_equal(ExpressionSet(scope, "-t", samples[k].text, 1, 1, ANYWHERE, &e),
                     PETSC_SUCCESS);
    value = ExpressionValue(&e, 0, t, x);
    if (!(PetscAbsReal(value - wanted) <= 4e-15 * PetscAbsReal(wanted)))
      fail_msg("%s is %.17g, not %.17g", samples[k].text, value, wanted);
    assert_int_equal(e.uses[0], samples[k].uses);
    assert_true((e.parser[0] == NULL) == (samples[k].uses == 0)); /* numbers need no parser */
  }
  assert_int_equal(ExpressionScopeCheck(scope), PETSC_SUCCESS);
  assert_false(ExpressionScopeIsIdle(scope));
  assert_int_equal(ExpressionScopeDestroy(&scope), PETSC_SUCCESS);
}

/* Numbers keep all their bits and create no parser in the scope. */
static void test_numbers(void **state)
{
  ExpressionScope *scope = Scope(2);
  Expression       e;
  const Expression none = {.n = 0}, one = ExpressionNumber(0.1);

  (void)state;
  assert_int_equal(ExpressionSet(scope, "-t", "0.1,-3,1e-300", 2, 3, ANYWHERE, &e), PETSC_SUCCESS);
  assert_int_equal(e.n, 3);
  assert_true(e.value[0] == 0.1 && e.value[1] == -3.0 && e.value[2] == 1e-300);
  assert_true(ExpressionValue(&e, 1, 5.0, NULL) == -3.0);
  assert_true(ExpressionRate(&e, 1, 5.0, NULL, 1.0) == 0.0);
  assert_true(ExpressionValue(&none, 0, 5.0, NULL) == 0.0);
  assert_true(ExpressionValue(&one, 0, 5.0, NULL) == 0.1);
  assert_true(ExpressionScopeIsIdle(scope));
  assert_int_equal(ExpressionScopeDestroy(&scope), PETSC_SUCCESS);
}

/* Components are split at commas outside brackets, and each has its own dependence. */
static void test_components(void **state)
{
  const PetscReal  x[]   = {0.25, 0.5};
  ExpressionScope *scope = Scope(2);
  Expression       e;

  (void)state;
  assert_int_equal(ExpressionSet(scope, "-t", "max(x,(y)), 3, t*min(1,2)", 2, 3, ANYWHERE, &e),
                   PETSC_SUCCESS);
  assert_int_equal(e.n, 3);
  assert_true(ExpressionValue(&e, 0, 2.0, x) == 0.5);
  assert_true(ExpressionValue(&e, 1, 2.0, x) == 3.0);
  assert_true(ExpressionValue(&e, 2, 2.0, x) == 2.0);
  assert_int_equal(e.uses[0], EXPRESSION_PLACE);
  assert_int_equal(e.uses[1], 0);
  assert_int_equal(e.uses[2], EXPRESSION_TIME);
  assert_true(ExpressionUses(&e, EXPRESSION_TIME) && ExpressionUses(&e, EXPRESSION_PLACE));
  assert_int_equal(ExpressionScopeDestroy(&scope), PETSC_SUCCESS);
}

/* The rate of sin(3t) has an error of at most 4.5e-10, (3 tau 1e-5)^2/6 with rounding. No
   expression is evaluated at a time before zero: sqrt(t) is not finite there. */
static void test_rate(void **state)
{
  ExpressionScope *scope = Scope(2);
  Expression       e;

  (void)state;
  assert_int_equal(ExpressionSet(scope, "-t", "sin(3*t),sqrt(t)*t", 2, 2, EXPRESSION_TIME, &e),
                   PETSC_SUCCESS);
  for (PetscInt k = 1; k < 20; k++) {
    const PetscReal t = 0.1 * k;

    assert_true(PetscAbsReal(ExpressionRate(&e, 0, t, NULL, 1.0) - 3.0 * PetscCosReal(3.0 * t)) <
                4.8e-10);
  }
  assert_true(PetscAbsReal(ExpressionRate(&e, 1, 0.0, NULL, 1.0)) < 1e-2);
  assert_int_equal(ExpressionScopeCheck(scope), PETSC_SUCCESS);
  assert_int_equal(ExpressionScopeDestroy(&scope), PETSC_SUCCESS);
}

static void test_refused(void **state)
{
  static const struct {
    const char *text, *says;
  } wrong[] = {
      {"sin(2*x", "position"},
      {"x+foo", "\"foo\" found at position 2"},
      {"z", "names are x, y, t, pi, nu"},
      {"x=3", "= cannot assign"},
      {"y+(t=2)", "= cannot assign"},
      {"2pi", "position 1"},
      {"1,2", "got 2"},
      {"", "empty"},
      {"(1,2)", "(1,2)"},
      {"1/0", "not finite"},
      {"inf", "not finite"},
      {"sin(1,2)", "sin(1,2)"},
      {"\"a\"", "\"a\""},
      {"x && foo || y", "\"foo\" found at position 5"},
      {"&& x", "\"&& x \" found at position 0"},
      {"x &&& y", "\"& y \" found at position 4"},
      {"x &~ y", "~ is no operator"},
  };
  char             message[512], sum[4000];
  ExpressionScope *scope = Scope(2);
  Expression       e;

  (void)state;
  assert_int_equal(PetscPushErrorHandler(CloudKeepMessage, message), PETSC_SUCCESS);
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(wrong); k++) {
    message[0] = '\0';
    if (ExpressionSet(scope, "-t_text", wrong[k].text, 1, 1, ANYWHERE, &e) != PETSC_ERR_USER_INPUT)
      fail_msg("'%s' was taken", wrong[k].text);
    assert_non_null(strstr(message, "-t_text"));
    if (!strstr(message, wrong[k].says)) fail_msg("'%s': %s", wrong[k].text, message);
  }
  assert_int_equal(ExpressionSet(scope, "-t_text", "t", 1, 1, EXPRESSION_PLACE, &e),
                   PETSC_ERR_USER_INPUT);
  for (size_t k = 0; k + 2 < sizeof(sum); k += 2) (void)snprintf(&sum[k], sizeof(sum) - k, "x+");
  for (size_t length = 901; length < sizeof(sum); length += 1000) { /* "x+x+...+x" */
    char kept = sum[length];

    sum[length] = '\0';
    assert_int_equal(ExpressionSet(scope, "-t_text", sum, 1, 1, ANYWHERE, &e),
                     length < 1000 ? PETSC_SUCCESS : PETSC_ERR_USER_INPUT);
    sum[length] = kept;
  }
  assert_int_equal(PetscPopErrorHandler(), PETSC_SUCCESS);
  assert_int_equal(ExpressionScopeDestroy(&scope), PETSC_SUCCESS);
}

/* A value that is not finite on one rank ends the run on all ranks; the message holds the option,
   the place and the time. */
static void test_not_finite(void **state)
{
  const PetscReal  x[]          = {0.5, 0.25};
  char             message[512] = "";
  ExpressionScope *scope        = Scope(2);
  Expression       e;
  PetscMPIInt      rank, size;

  (void)state;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  MPI_Comm_size(PETSC_COMM_WORLD, &size);
  assert_int_equal(ExpressionSet(scope, "-t_text", "x||y ? 1/(x-t) : 0", 1, 1, ANYWHERE, &e),
                   PETSC_SUCCESS);
  assert_true(ExpressionValue(&e, 0, 0.25, x) == 4.0);
  assert_int_equal(ExpressionScopeCheck(scope), PETSC_SUCCESS);
  if (rank == size - 1) assert_true(ExpressionValue(&e, 0, 0.5, x) == 0.0);
  assert_int_equal(PetscPushErrorHandler(CloudKeepMessage, message), PETSC_SUCCESS);
  assert_int_equal(ExpressionScopeCheck(scope), PETSC_ERR_USER_INPUT);
  assert_int_equal(PetscPopErrorHandler(), PETSC_SUCCESS);
  assert_string_equal(message,
                      "-t_text 'x||y ? 1/(x-t) : 0': is not finite at x = 0.5, y = 0.25, t = 0.5");
  assert_int_equal(ExpressionScopeCheck(NULL), PETSC_SUCCESS);
  assert_int_equal(ExpressionScopeDestroy(&scope), PETSC_SUCCESS);
}

/* Returns the largest error between x = 0 and 1 of a curve through n values of a function. */
static PetscReal CurveError(PetscReal (*Function)(PetscReal), PetscInt n)
{
  PetscReal t[129], y[129], slope[129], error = 0.0;
  TimeCurve curve = {.n = n, .t = t, .y = y, .slope = slope};

  for (PetscInt k = 0; k < n; k++) {
    t[k] = 0.1 * (PetscReal)(k % 2) / (PetscReal)n + (PetscReal)k / (PetscReal)(n - 1);
    y[k] = Function(t[k]);
  }
  assert_null(TimeCurveSet(&curve));
  for (PetscInt k = 0; k <= 1000; k++)
    error = PetscMax(error, PetscAbsReal(TimeCurveValue(&curve, 1e-3 * (PetscReal)k) -
                                         Function(1e-3 * (PetscReal)k)));
  return error;
}

static PetscReal Monotone(PetscReal t)
{
  return PetscExpReal(-2.0 * t);
}

static PetscReal Line(PetscReal t)
{
  return 3.0 - 2.0 * t;
}

/* The order that TimeCurveSet() states, lines to rounding, rest before a motion, faults. */
static void test_curve(void **state)
{
  PetscReal t[] = {0.0, 1.0, 2.0, 3.0, 4.0}, y[] = {1.0, 1.0, 2.0, 5.0, 4.0}, slope[5];
  TimeCurve curve = {.n = 5, .t = t, .y = y, .slope = slope};

  (void)state;
  assert_true(CurveError(Line, 2) < 1e-14 && CurveError(Line, 17) < 1e-14);
  assert_true(CurveError(Monotone, 128) < CurveError(Monotone, 32) / 32.0); /* order 2.5 or more */
  assert_null(TimeCurveSet(&curve));
  for (PetscInt k = 0; k <= 400; k++) {
    const PetscReal at = 0.01 * (PetscReal)k, value = TimeCurveValue(&curve, at);

    if (at <= 1.0) assert_true(value == 1.0);
    assert_true(value <= 5.0);
  }
  for (PetscInt k = 1; k < 4; k++) /* a continuous slope */
    assert_true(PetscAbsReal(TimeCurveValue(&curve, t[k] - 1e-6) - 2.0 * y[k] +
                             TimeCurveValue(&curve, t[k] + 1e-6)) < 1e-10);
  t[2] = 1.0;
  assert_non_null(TimeCurveSet(&curve));
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_values),     cmocka_unit_test(test_numbers),
      cmocka_unit_test(test_components), cmocka_unit_test(test_rate),
      cmocka_unit_test(test_refused),    cmocka_unit_test(test_not_finite),
      cmocka_unit_test(test_curve),
  };
  int failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
  return PetscFinalize() || failed ? 1 : 0;
}
