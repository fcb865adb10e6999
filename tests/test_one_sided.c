/*
  Pressure rows of the coupled scheme, which use fluid neighbours alone: the gradient is exact for
  quadratic fields beside walls too, and the residual of the fit is zero.
*/
/* RANKS: 1 2 */
#include "cloud.h"

static void CreateBox(PetscInt dim, PetscReal jitter, const char options[], Cloud *cloud)
{
  const CloudBox box = {.name                 = "box",
                        .dim                  = dim,
                        .cells                = {8, 9, 7},
                        .jitter               = jitter,
                        .grad_p_without_walls = PETSC_TRUE};

  ASSERT_OK(CloudCreate(&box, options, cloud));
  ASSERT_OK(VecSet(cloud->e, 1e3)); /* wall data must not matter */
}

static void CheckQuadratics(const char *where, const Cloud *cloud)
{
  const PetscReal dx   = cloud->scene.dx;
  const Quadratic zero = {0};
  PetscReal       error;

  for (PetscInt k = 0; k < QuadraticCount(cloud->scene.dim); k++) {
    const Quadratic p = QuadraticMonomial(cloud->scene.dim, k);

    ASSERT_OK(CloudSet(cloud, &p, cloud->f[0]));
    for (PetscInt a = 0; a < cloud->scene.dim; a++) {
      const Quadratic exact = QuadraticDerivative(cloud, &p, a);

      ASSERT_OK(AffineApply(&cloud->ops->grad_p[a], cloud->f[0], cloud->e, cloud->y));
      ASSERT_OK(CloudError(cloud, cloud->y, &exact, PETSC_FALSE, &error));
      CloudAssertNone("grad p", where, error * dx > 1e-9);
    }
    ASSERT_OK(AffineApply(&cloud->ops->filter_p, cloud->f[0], cloud->e, cloud->y));
    ASSERT_OK(CloudError(cloud, cloud->y, &zero, PETSC_FALSE, &error));
    CloudAssertNone("roughness", where, error > 1e-10);
  }
}

static void test_quadratics(void **state)
{
  const char *const options[] = {"", "-wall dummy_linear -visc_laplacian schwaiger",
                                 "-h_over_dx 1.6"};
  Cloud             cloud;

  (void)state;
  for (PetscInt dim = 2; dim <= 3; dim++) {
    for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(options); k++) {
      CreateBox(dim, 0.2, options[k], &cloud);
      CheckQuadratics(options[k], &cloud);
      ASSERT_OK(CloudDestroy(&cloud));
    }
  }
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_quadratics)};
  int                     failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
  return PetscFinalize() || failed ? 1 : 0;
}
