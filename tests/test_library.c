/*
  The library of isph.h: flows side by side are those that run alone, functions of the user are
  those of expressions, fields and vectors are the same numbers, particles enter and leave, a
  checkpoint goes on bit by bit, and errors are values.
*/
/* RANKS: 1 2 */
#include <string.h>
#include "cloud.h"
#include "isph.h"

#define WORDS_MOST 32

/* Creates a flow from a line of options; sets it up unless an error is expected. */
static IsphFlow Flowing(const char line[], PetscErrorCode expected)
{
  char     text[512], *word[WORDS_MOST], *rest = text;
  int      n = 0;
  IsphFlow flow;

  (void)snprintf(text, sizeof(text), "%s", line);
  while (n < WORDS_MOST && (word[n] = strtok_r(NULL, " ", &rest))) n++;
  ASSERT_OK(IsphFlowCreate(&flow));
  ASSERT_OK(IsphFlowSetOptions(flow, n, word));
  assert_int_equal(IsphFlowSetUp(flow), expected);
  return flow;
}

/* Returns a sum over this rank that every number of the velocity enters in its own way. */
static PetscReal Fingerprint(IsphFlow flow)
{
  PetscReal        *u[3], sum = 0.0;
  PetscInt          dim, fluid, walls, components;
  const PetscInt64 *id;

  ASSERT_OK(IsphFlowGetSizes(flow, &dim, &fluid, &walls));
  ASSERT_OK(IsphFlowGetField(flow, "velocity", &components, u));
  ASSERT_OK(IsphFlowGetIds(flow, &id));
  assert_int_equal(components, dim);
  for (PetscInt i = 0; i < fluid; i++)
    for (PetscInt c = 0; c < dim; c++) sum += u[c][i] * (PetscReal)(1 + id[i] % 97);
  return sum;
}

#define CAVITY "-case cavity -n 12 -reynolds 10 -dt 0.01 -t_end 0.05"
#define VORTEX "-case taylor_green -n 12 -reynolds 10 -dt 0.01 -t_end 0.05 -scheme wcsph"

/* Two flows of different schemes take turns; each is as if it were alone. */
static void test_side_by_side(void **state)
{
  const char *const line[2] = {CAVITY, VORTEX};
  IsphFlow          flow[2];
  PetscReal         alone[2];

  for (PetscInt k = 0; k < 2; k++) {
    flow[k] = Flowing(line[k], PETSC_SUCCESS);
    ASSERT_OK(IsphFlowRun(flow[k], PETSC_INFINITY));
    alone[k] = Fingerprint(flow[k]);
    ASSERT_OK(IsphFlowDestroy(&flow[k]));
  }
  for (PetscInt k = 0; k < 2; k++) flow[k] = Flowing(line[k], PETSC_SUCCESS);
  for (PetscBool over = PETSC_FALSE; !over;) {
    for (PetscInt k = 0; k < 2; k++) ASSERT_OK(IsphFlowStep(flow[k]));
    ASSERT_OK(IsphFlowIsOver(flow[0], &over));
  }
  ASSERT_OK(IsphFlowRun(flow[1], PETSC_INFINITY));
  for (PetscInt k = 0; k < 2; k++) {
    assert_true(Fingerprint(flow[k]) == alone[k]);
    ASSERT_OK(IsphFlowDestroy(&flow[k]));
  }
}

static PetscReal Lid(PetscInt n, const PetscReal argument[], void *ctx)
{
  *(PetscInt *)ctx += 1;
  assert_int_equal(n, 2);
  return PetscSinReal(PETSC_PI * argument[0]) * argument[1];
}

/* A lid by a function is the lid of the same expression; a step ends at the time of the run. */
static void test_function(void **state)
{
  const char *const value[2] = {"sin(pi*x)*t, 0", "lid(x, t), 0"};
  PetscReal         sum[2], t, dt;
  PetscInt          step, calls = 0;

  for (PetscInt k = 0; k < 2; k++) {
    IsphFlow flow;

    ASSERT_OK(IsphFlowCreate(&flow));
    ASSERT_OK(IsphFlowSetFunction(flow, "lid", Lid, &calls));
    ASSERT_OK(IsphFlowSetOption(flow, "-case", "scene"));
    ASSERT_OK(IsphFlowSetOption(flow, "-n", "12"));
    ASSERT_OK(IsphFlowSetOption(flow, "-scene_wall_top_velocity", value[k]));
    ASSERT_OK(IsphFlowSetUp(flow));
    ASSERT_OK(IsphFlowRun(flow, 0.123));
    ASSERT_OK(IsphFlowGetTime(flow, &t, &dt, &step));
    assert_true(PetscAbsReal(t - 0.123) < 1e-12);
    assert_true(step > 0);
    sum[k] = Fingerprint(flow);
    ASSERT_OK(IsphFlowDestroy(&flow));
  }
  assert_true(calls > 0);
  assert_true(sum[0] == sum[1]);
}

/* Components are the numbers of vectors; the force on the floor is the weight of the fluid. */
static void test_contents(void **state)
{
  IsphFlow    flow = Flowing("-case hydrostatic -n 12 -t_end 0.1 -motion eulerian", PETSC_SUCCESS);
  PetscReal   force[2][3], torque[3], error[2], x[2] = {0.5, 0.5}, u[3], p, value[4], t, *place[3];
  PetscReal   rows[3000], sum;
  PetscInt    n, fluid, walls;
  const char *name, *kind;
  Vec         v;

  ASSERT_OK(IsphFlowRun(flow, PETSC_INFINITY));
  for (PetscInt k = 0; k < 2; k++)
    ASSERT_OK(IsphFlowGetForce(flow, 2 + k, force[k], torque, error));
  assert_true(PetscAbsReal(force[0][1] + force[1][1] + 1.0) < 1e-6);
  ASSERT_OK(IsphFlowProbe(flow, 1, x, u, &p));
  assert_true(PetscAbsReal(u[0]) < 1e-6 && PetscAbsReal(u[1]) < 1e-6);
  ASSERT_OK(IsphFlowGetBoundary(flow, 2, &name, &kind));
  assert_string_equal(name, "bottom");
  assert_string_equal(kind, "wall");
  ASSERT_OK(IsphFlowGetBoundary(flow, 4, &name, &kind));
  assert_null(name);

  ASSERT_OK(IsphFlowGetVec(flow, "position", 1, &v));
  ASSERT_OK(VecSum(v, &sum));
  ASSERT_OK(VecGetSize(v, &n));
  assert_int_equal(n, 144);
  assert_true(PetscAbsReal(sum / 144.0 - 0.5) < 1e-12);
  ASSERT_OK(VecDestroy(&v));
  ASSERT_OK(IsphFlowGetSizes(flow, &n, &fluid, &walls));
  ASSERT_OK(IsphFlowGetField(flow, "position", &n, place));
  ASSERT_OK(IsphFlowComputeField(flow, "boundary", &n, rows));
  assert_true(rows[0] == -1.0);
  assert_true(!walls || rows[fluid] >= 0.0);

  ASSERT_OK(IsphFlowMeasure(flow));
  ASSERT_OK(IsphFlowGetQuantity(flow, 0, &name, &t, value));
  assert_non_null(name);
  assert_true(PetscAbsReal(t - 0.1) < 1e-12);
  assert_int_equal(IsphFlowGetPose(flow, 0, force[0], value, u, torque), PETSC_ERR_USER_INPUT);
  ASSERT_OK(IsphFlowDestroy(&flow));
}

/* A particle leaves, and another takes its place; the flow goes on. */
static void test_population(void **state)
{
  const PetscReal  x[2]  = {0.3, 0.4};
  const PetscInt64 id[1] = {40}, none[1] = {-1};
  IsphFlow         flow = Flowing(VORTEX, PETSC_SUCCESS);
  PetscInt         dim, fluid, walls, all;

  ASSERT_OK(IsphFlowStep(flow));
  ASSERT_OK(IsphFlowRemove(flow, 1, id));
  assert_int_equal(IsphFlowRemove(flow, 1, none), PETSC_ERR_USER_INPUT);
  ASSERT_OK(IsphFlowInsert(flow, 1, x, NULL));
  ASSERT_OK(IsphFlowGetSizes(flow, &dim, &fluid, &walls));
  ASSERT_OK((PetscErrorCode)MPI_Allreduce(&fluid, &all, 1, MPIU_INT, MPI_SUM, PETSC_COMM_WORLD));
  assert_int_equal(all, 144);
  ASSERT_OK(IsphFlowChanged(flow));
  ASSERT_OK(IsphFlowRun(flow, PETSC_INFINITY));
  ASSERT_OK(IsphFlowDestroy(&flow));
}

/* A run that goes on from a checkpoint is equal to the last bit. */
static void test_checkpoint(void **state)
{
  IsphFlow  flow = Flowing(CAVITY, PETSC_SUCCESS);
  PetscReal sum;

  ASSERT_OK(IsphFlowRun(flow, 0.02));
  ASSERT_OK(IsphFlowWriteCheckpoint(flow, "library.h5"));
  ASSERT_OK(IsphFlowWriteSnapshot(flow, "library_snapshot.h5"));
  ASSERT_OK(IsphFlowRun(flow, PETSC_INFINITY));
  sum = Fingerprint(flow);
  ASSERT_OK(IsphFlowDestroy(&flow));
  flow = Flowing(CAVITY " -restart library.h5", PETSC_SUCCESS);
  ASSERT_OK(IsphFlowRun(flow, PETSC_INFINITY));
  assert_true(Fingerprint(flow) == sum);
  ASSERT_OK(IsphFlowDestroy(&flow));
}

static PetscErrorCode Stops(IsphFlow flow, void *ctx)
{
  *(PetscInt *)ctx += 1;
  return *(PetscInt *)ctx == 2 ? PETSC_ERR_USER : PETSC_SUCCESS;
}

/* Refusals are values with a text, after which other flows run; a monitor ends a run. */
static void test_errors(void **state)
{
  const char *const wrong[][2] = {
      {"-case cavity -foo 1", "-foo: unknown option"},
      {"-case cavity -n 2", "-n 2: allowed is 4 to 100000"},
      {"-case cavity -log_view", "-log_view: it belongs to the program"},
      {"-case cavity -scheme coupled -ppe_ksp_type cg", "-ppe_ksp_type"}};
  PetscReal t, dt;
  PetscInt  step = 0;
  IsphFlow  flow;

  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(wrong); k++) {
    flow = Flowing(wrong[k][0], PETSC_ERR_USER_INPUT);
    assert_non_null(strstr(IsphFlowGetError(flow), wrong[k][1]));
    assert_int_equal(IsphFlowStep(flow), PETSC_ERR_USER_INPUT);
    ASSERT_OK(IsphFlowDestroy(&flow));
  }
  ASSERT_OK(IsphFlowCreate(&flow));
  assert_int_equal(IsphFlowStep(flow), PETSC_ERR_USER_INPUT);
  assert_int_equal(IsphFlowSetFunction(flow, "2x", Lid, NULL), PETSC_ERR_USER_INPUT);
  ASSERT_OK(IsphFlowDestroy(&flow));
  flow = Flowing(CAVITY, PETSC_SUCCESS);
  ASSERT_OK(IsphFlowSetMonitor(flow, Stops, &step));
  assert_int_equal(IsphFlowRun(flow, PETSC_INFINITY), PETSC_ERR_USER);
  ASSERT_OK(IsphFlowGetTime(flow, &t, &dt, &step));
  assert_int_equal(step, 2);
  ASSERT_OK(IsphFlowRun(flow, PETSC_INFINITY));
  ASSERT_OK(IsphFlowDestroy(&flow));
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_side_by_side), cmocka_unit_test(test_function),
      cmocka_unit_test(test_contents),     cmocka_unit_test(test_population),
      cmocka_unit_test(test_checkpoint),   cmocka_unit_test(test_errors),
  };
  int failed;

  ASSERT_OK(IsphInitialize());
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  return IsphFinalize() || failed ? 1 : 0;
}
