/*
  Identities of the Laplacians that couple velocity components: the divergence of the stress is
  exact for quadratic velocities, rigid motions have no force, and all eigenvalues damp.
*/
/* RANKS: 1 2 */
#include "cloud.h"

static Cloud CloudOfForm(PetscInt k, PetscInt dim, PetscReal jitter)
{
  const CloudBox box = CloudPeriodic(dim, jitter);
  char           options[128];
  Cloud          cloud;

  ASSERT_OK(PetscSNPrintf(options, sizeof(options), "-visc_laplacian %s", CloudLaplacian(k)->name));
  ASSERT_OK(CloudCreate(&box, options, &cloud));
  return cloud;
}

/* Sets y to component c of the viscous operator applied to the velocity u. */
static void Apply(const Cloud *cloud, const Quadratic u[], PetscInt c, Vec y)
{
  Vec all, stress;

  ASSERT_OK(VelocityVec(cloud->particles, &all));
  ASSERT_OK(VecDuplicate(all, &stress));
  for (PetscInt a = 0; a < cloud->scene.dim; a++) {
    ASSERT_OK(CloudSet(cloud, &u[a], cloud->f[0]));
    ASSERT_OK(VecStrideScatter(cloud->f[0], a, all, INSERT_VALUES));
  }
  ASSERT_OK(MatMult(cloud->ops->velocity[0].visc.A, all, stress));
  ASSERT_OK(VecStrideGather(stress, c, y, INSERT_VALUES));
  ASSERT_OK(VecDestroy(&all));
  ASSERT_OK(VecDestroy(&stress));
}

/* Returns the largest error of component c of the operator, which is exactly
   lap u_c + 2 d(div u)/dx_c, in units of 1/dx^2. */
static PetscReal StressError(const Cloud *cloud, const Quadratic u[], PetscInt c)
{
  Quadratic expected = QuadraticLaplacian(cloud, &u[c]);
  PetscReal error;

  for (PetscInt b = 0; b < cloud->scene.dim; b++) {
    const Quadratic slope = QuadraticDerivative(cloud, &u[b], b),
                    grad  = QuadraticDerivative(cloud, &slope, c);

    expected.c += 2.0 * grad.c;
  }
  Apply(cloud, u, c, cloud->y);
  ASSERT_OK(CloudError(cloud, cloud->y, &expected, PETSC_TRUE, &error));
  return error * PetscSqr(cloud->scene.dx);
}

static void test_quadratics(void **state)
{
  (void)state;
  for (PetscInt k = CloudScalarForms(); k < LaplacianTable.count; k++) {
    for (PetscInt dim = 2; dim <= 3; dim++) {
      Cloud cloud = CloudOfForm(k, dim, 0.25);

      for (PetscInt m = 0; m < QuadraticCount(dim) * dim; m++) {
        Quadratic u[ISPH_MAX_DIM] = {{0}};

        u[m % dim] = QuadraticMonomial(dim, m / dim);
        for (PetscInt c = 0; c < dim; c++)
          CloudAssertNone("quadratics", CloudLaplacian(k)->name, StressError(&cloud, u, c) > 1e-8);
      }
      ASSERT_OK(CloudDestroy(&cloud));
    }
  }
}

/* A rigid motion, rotation with unit rate in every plane plus translation, has no stress. */
static void test_one_piece(void **state)
{
  (void)state;
  for (PetscInt k = CloudScalarForms(); k < LaplacianTable.count; k++) {
    for (PetscInt dim = 2; dim <= 3; dim++) {
      Quadratic u[ISPH_MAX_DIM] = {{0}};
      Cloud     cloud           = CloudOfForm(k, dim, 0.25);

      for (PetscInt a = 0; a < dim; a++) {
        u[a].c = 1.0 + a;
        for (PetscInt b = 0; b < dim; b++) u[a].g[b] = b > a ? 1.0 : (b < a ? -1.0 : 0.0);
      }
      for (PetscInt c = 0; c < dim; c++)
        CloudAssertNone("one piece", CloudLaplacian(k)->name, StressError(&cloud, u, c) > 1e-9);
      ASSERT_OK(CloudDestroy(&cloud));
    }
  }
}

/* Tests the property safe_implicit: all eigenvalues of -L have positive real parts, except a zero
   for each constant velocity component. */
static void test_damps(void **state)
{
  PetscMPIInt ranks;

  (void)state;
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  if (ranks > 1) return;
  for (PetscInt k = CloudScalarForms(); k < LaplacianTable.count; k++) {
    for (PetscReal jitter = 0.25; jitter < 0.6; jitter += 0.25) {
      const CloudBox box = {.dim = 2, .cells = {12, 12, 1}, .n_periodic = 2, .jitter = jitter};
      char           options[128];
      PetscInt       rows, low = 0;
      PetscReal     *re, *im;
      Cloud          cloud;
      KSP            ksp;
      PC             pc;

      ASSERT_OK(
          PetscSNPrintf(options, sizeof(options), "-visc_laplacian %s", CloudLaplacian(k)->name));
      ASSERT_OK(CloudCreate(&box, options, &cloud));
      ASSERT_OK(MatGetSize(cloud.ops->velocity[0].visc.A, &rows, NULL));
      ASSERT_OK(PetscMalloc2(rows, &re, rows, &im));
      ASSERT_OK(KSPCreate(PETSC_COMM_WORLD, &ksp));
      ASSERT_OK(KSPSetOperators(ksp, cloud.ops->velocity[0].visc.A, cloud.ops->velocity[0].visc.A));
      ASSERT_OK(KSPGetPC(ksp, &pc));
      ASSERT_OK(PCSetType(pc, PCNONE));
      ASSERT_OK(KSPSetUp(ksp));
      ASSERT_OK(KSPComputeEigenvaluesExplicitly(ksp, rows, re, im));
      for (PetscInt e = 0; e < rows; e++) low += -re[e] * PetscSqr(cloud.scene.dx) < 1e-9;
      CloudAssertNone("safe_implicit", CloudLaplacian(k)->name, low != 2);
      ASSERT_OK(KSPDestroy(&ksp));
      ASSERT_OK(PetscFree2(re, im));
      ASSERT_OK(CloudDestroy(&cloud));
    }
  }
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_quadratics),
      cmocka_unit_test(test_one_piece),
      cmocka_unit_test(test_damps),
  };
  int failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
  return PetscFinalize() || failed ? 1 : 0;
}
