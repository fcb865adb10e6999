/*
  The pair-wise Laplacian of preconditioners, which is that of quadratic fields on a lattice, and
  symmetric without a sum of rows anywhere.
*/
/* RANKS: 1 3 */
#include "cloud.h"
#include "isph/solvers.h"

/* All pairs of a lattice are one layer apart along an axis: a wave of k radians a layer has the
   eigenvalue 4 sin^2(k/2), nearly k^2. */
static void CheckLaplacian(PetscInt dim)
{
  const CloudBox  box = CloudPeriodic(dim, 0.0);
  const PetscReal k   = 2.0 * PETSC_PI / box.cells[0];
  Cloud           cloud;
  Flow            flow;
  Vec             one, y;
  Mat             A;
  PetscReal       norm;
  PetscScalar    *value;

  ASSERT_OK(CloudCreate(&box, "", &cloud));
  flow = (Flow){.scene     = &cloud.scene,
                .particles = cloud.particles,
                .neighbors = cloud.neighbors,
                .ops       = cloud.ops};
  ASSERT_OK(FluidVec(cloud.particles, NULL, &one));
  ASSERT_OK(VecDuplicate(one, &y));
  ASSERT_OK(VecSet(one, 1.0));
  ASSERT_OK(PairLaplacian(&flow, one, NULL, NULL, &A));
  CloudAssertNone("symmetry", box.name, CloudAsymmetry(A) > 1e-13);
  ASSERT_OK(MatMult(A, one, y));
  ASSERT_OK(VecNorm(y, NORM_INFINITY, &norm));
  CloudAssertNone("sums of rows", box.name, norm > 1e-12);
  ASSERT_OK(VecGetArrayWrite(one, &value));
  for (PetscInt i = 0; i < cloud.particles->n_fluid; i++)
    value[i] = PetscSinReal(k * cloud.particles->x[0][i] / cloud.scene.dx);
  ASSERT_OK(VecRestoreArrayWrite(one, &value));
  ASSERT_OK(MatMult(A, one, y));
  ASSERT_OK(VecAXPY(y, -4.0 * PetscSqr(PetscSinReal(0.5 * k)), one));
  ASSERT_OK(VecNorm(y, NORM_INFINITY, &norm));
  CloudAssertNone("a wave", box.name, norm > 1e-12);
  ASSERT_OK(MatDestroy(&A));
  ASSERT_OK(VecDestroy(&y));
  ASSERT_OK(VecDestroy(&one));
  ASSERT_OK(CloudDestroy(&cloud));
}

static void test_laplacian(void **state)
{
  (void)state;
  CheckLaplacian(2);
  CheckLaplacian(3);
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_laplacian)};
  int                     failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
  return PetscFinalize() || failed ? 1 : 0;
}
