/* Identities that make a function a smoothing kernel, for every row of the kernel table. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <cmocka.h>
#include "isph/operators.h"

#define H 0.7 /* smoothing length: not 1, so that a missing power of h shows */

static const KernelRow *Kernel(PetscInt k)
{
  return (const KernelRow *)(const void *)TableGet(&KernelTable, k);
}

static void AssertSmall(PetscReal error, PetscReal tolerance, const KernelRow *kernel,
                        const char *what, PetscReal at)
{
  if (!(PetscAbsReal(error) <= tolerance))
    print_error("%s: %s at %g: %g\n", kernel->name, what, (double)at, (double)error);
  assert_true(PetscAbsReal(error) <= tolerance);
}

static PetscReal SphereArea(PetscInt dim, PetscReal r)
{
  return dim == 1 ? 2.0 : dim == 2 ? 2.0 * PETSC_PI * r : 4.0 * PETSC_PI * r * r;
}

/* Checks int W dV = 1, int r W' dV = -d and int r^2 W'' dV = d (d + 1): theory.md,
   (particles:integrals). */
static void test_moments(void **state)
{
  const PetscInt n = 4000; /* midpoints: relative error O(1/n^2), below 1e-6 */

  (void)state;
  for (PetscInt k = 0; k < KernelTable.count; k++) {
    const KernelRow *kernel = Kernel(k);

    for (PetscInt dim = 1; dim <= 3; dim++) {
      const PetscReal dr     = kernel->support * H / n;
      PetscReal       sum[3] = {0.0}, w[3];

      for (PetscInt i = 0; i < n; i++) {
        const PetscReal r = (i + 0.5) * dr, dV = SphereArea(dim, r) * dr;

        KernelEvaluate(kernel, dim, H, r, w);
        sum[0] += w[0] * dV;
        sum[1] += r * w[1] * dV;
        sum[2] += r * r * w[2] * dV;
      }
      AssertSmall(sum[0] - 1.0, 1e-6, kernel, "integral of W", dim);
      AssertSmall(sum[1] + dim, 1e-5, kernel, "integral of r W'", dim);
      AssertSmall(sum[2] - dim * (dim + 1), 1e-4, kernel, "integral of r^2 W''", dim);
    }
  }
}

/* Compares W' and W'' with central differences, whose error between knots is O(eps^2). */
static void test_derivatives(void **state)
{
  const PetscReal eps = 1e-5;

  (void)state;
  for (PetscInt k = 0; k < KernelTable.count; k++) {
    const KernelRow *kernel = Kernel(k);

    for (PetscInt dim = 1; dim <= 3; dim++) {
      PetscReal scale[3]; /* of W, W' and W'' */

      KernelEvaluate(kernel, dim, H, 0.0, scale);
      for (PetscReal q = 0.013; q < kernel->support + 0.3; q += 0.0171) { /* never at a knot */
        PetscReal low[3], mid[3], high[3];

        KernelEvaluate(kernel, dim, H, q * H - eps, low);
        KernelEvaluate(kernel, dim, H, q * H, mid);
        KernelEvaluate(kernel, dim, H, q * H + eps, high);
        AssertSmall((high[0] - low[0]) / (2.0 * eps) - mid[1], 1e-7 * scale[0] / H, kernel, "dW/dr",
                    q);
        AssertSmall((high[1] - low[1]) / (2.0 * eps) - mid[2], 1e-7 * scale[0] / (H * H), kernel,
                    "d2W/dr2", q);
      }
    }
  }
}

/*
  Checks W >= 0, W' <= 0, W'(0) = 0, and W'' - W'/r = r (W'/r)' >= 0, which makes the weights of the
  Laplacian gotoh positive: theory.md, (particles:convex). W, W' and W'' are zero at the edge of the
  support and beyond, and W and W' are continuous there.
*/
static void test_shape(void **state)
{
  (void)state;
  for (PetscInt k = 0; k < KernelTable.count; k++) {
    const KernelRow *kernel = Kernel(k);
    PetscReal        w[3], top[3];

    for (PetscInt dim = 1; dim <= 3; dim++) {
      const PetscReal edge = kernel->support * H;

      KernelEvaluate(kernel, dim, H, 0.0, top);
      assert_true(top[0] > 0.0);
      AssertSmall(top[1], 1e-14 * top[0], kernel, "W'(0)", 0.0);
      for (PetscReal r = 0.001; r < edge; r += 0.0037) {
        KernelEvaluate(kernel, dim, H, r, w);
        AssertSmall(PetscMin(w[0], 0.0), 0.0, kernel, "W < 0", r);
        AssertSmall(PetscMax(w[1], 0.0), 0.0, kernel, "W' > 0", r);
        AssertSmall(PetscMin(w[2] - w[1] / r, 0.0), 1e-10 * top[0], kernel, "W'' - W'/r < 0", r);
      }
      for (PetscReal r = edge; r < 2.0 * edge; r += 0.1 * edge) {
        KernelEvaluate(kernel, dim, H, r, w);
        for (PetscInt d = 0; d < 3; d++) AssertSmall(w[d], 0.0, kernel, "beyond the support", r);
      }
      KernelEvaluate(kernel, dim, H, edge * (1.0 - 1e-8), w);
      AssertSmall(w[0], 1e-10 * top[0], kernel, "jump of W", edge);
      AssertSmall(w[1], 1e-10 * top[0], kernel, "jump of W'", edge);
      KernelEvaluate(kernel, dim, H, edge * (1.0 - 1e-3), w);
      assert_true(w[0] > 0.0); /* the support is not smaller */
    }
  }
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_moments),
      cmocka_unit_test(test_derivatives),
      cmocka_unit_test(test_shape),
  };
  int failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  return PetscFinalize() || failed ? 1 : 0;
}
