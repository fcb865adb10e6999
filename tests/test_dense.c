/* Dense solvers for the small matrices of stencils: definite matrices, general matrices, and
   singular matrices, to which a multiple of the unit matrix is added. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <cmocka.h>
#include "isph/operators.h"

#define N 3

/* Solves a x = b for a symmetric positive definite matrix up to rounding. */
static void test_definite(void **state)
{
  const PetscReal a[N * N]   = {4.0, 1.0, 0.5, 1.0, 3.0, 0.25, 0.5, 0.25, 2.0},
                        x[N] = {1.0, -2.0, 3.0};
  PetscReal factor[N * N], b[N] = {0.0};

  (void)state;
  for (PetscInt i = 0; i < N; i++) {
    for (PetscInt k = 0; k < N; k++) b[i] += a[i * N + k] * x[k];
  }
  for (PetscInt k = 0; k < N * N; k++) factor[k] = a[k];
  assert_int_equal(DenseCholesky(N, factor), 0);
  DenseCholeskySolve(N, factor, b);
  for (PetscInt i = 0; i < N; i++) assert_true(PetscAbsReal(b[i] - x[i]) < 1e-14);
}

/* Solves x a = b for an unsymmetric matrix with a leading zero; a zero row gives a zero pivot. */
static void test_any(void **state)
{
  const PetscReal a[N * N]   = {0.0, 2.0, 1.0, 3.0, 1.0, -1.0, 0.5, 4.0, 2.0},
                        x[N] = {1.0, -2.0, 3.0};
  PetscReal left[N * N], b[N] = {0.0};

  (void)state;
  for (PetscInt q = 0; q < N; q++) {
    for (PetscInt p = 0; p < N; p++) b[q] += x[p] * a[p * N + q];
  }
  for (PetscInt k = 0; k < N * N; k++) left[k] = a[k];
  DenseEliminate(N, left, 1, b);
  for (PetscInt q = 0; q < N; q++)
    assert_true(PetscAbsReal(b[q] / left[q * (N + 1)] - x[q]) < 1e-14);
  for (PetscInt k = 0; k < N * N; k++) left[k] = k / N == 1 ? 0.0 : a[k];
  DenseEliminate(N, left, 1, b);
  assert_true(left[N + 1] == 0.0);
}

/* Solves with a matrix of rank 1, as points on a line give: with a multiple of the unit matrix the
   solution is that of smallest norm. */
static void test_ridge(void **state)
{
  const PetscReal a[4] = {1.0, 2.0, 2.0, 4.0};
  PetscReal       factor[4], b[2] = {5.0, 10.0}; /* a (1, 2), the solution of smallest norm */

  (void)state;
  for (PetscInt k = 0; k < 4; k++) factor[k] = a[k];
  assert_int_equal(DenseCholesky(2, factor), 2);
  DenseCholeskyRidge(2, a, 1e-8, factor);
  DenseCholeskySolve(2, factor, b);
  assert_true(PetscAbsReal(b[0] - 1.0) < 1e-6 && PetscAbsReal(b[1] - 2.0) < 1e-6);
}

/* A matrix with NaN gives a solution with NaN; the loop over larger multiples of the unit matrix
   ends. */
static void test_not_finite(void **state)
{
  const PetscReal a[4] = {1.0, NAN, NAN, 1.0};
  PetscReal       factor[4], b[2] = {1.0, 1.0};

  (void)state;
  DenseCholeskyRidge(2, a, 1e-8, factor);
  DenseCholeskySolve(2, factor, b);
  assert_true(PetscIsInfOrNanReal(b[0]) || PetscIsInfOrNanReal(b[1]));
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_definite), cmocka_unit_test(test_any),
                                     cmocka_unit_test(test_ridge),
                                     cmocka_unit_test(test_not_finite)};

  return cmocka_run_group_tests(tests, NULL, NULL);
}
