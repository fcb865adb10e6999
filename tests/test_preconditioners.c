/*
  Matrices of preconditioners: entries of a product within a pattern, and the pair-wise Laplacian,
  which is that of quadratic fields on a lattice, and symmetric without a sum of rows anywhere.
*/
/* RANKS: 1 3 */
#include "cloud.h"
#include "isph/solvers.h"

#define ROWS 7 /* on each rank */

/* Creates a matrix of `rows` by `cols` of each rank with entries in a part of all places. */
static Mat Scattered(PetscInt rows, PetscInt cols, PetscInt seed)
{
  PetscInt first, last, N;
  Mat      A;

  ASSERT_OK(MatCreate(PETSC_COMM_WORLD, &A));
  ASSERT_OK(MatSetSizes(A, rows, cols, PETSC_DETERMINE, PETSC_DETERMINE));
  ASSERT_OK(MatSetType(A, MATAIJ));
  ASSERT_OK(MatSetUp(A));
  ASSERT_OK(MatSetOption(A, MAT_NEW_NONZERO_ALLOCATION_ERR, PETSC_FALSE));
  ASSERT_OK(MatGetOwnershipRange(A, &first, &last));
  ASSERT_OK(MatGetSize(A, NULL, &N));
  for (PetscInt i = first; i < last; i++)
    for (PetscInt j = 0; j < N; j++) {
      const PetscReal noise = ParticlesHash(seed, i, j);

      if (noise < 0.4 && (seed != 2 || i % 3))
        PetscCallAbort(PETSC_COMM_SELF, MatSetValue(A, i, j, noise - 0.2, INSERT_VALUES));
    }
  ASSERT_OK(MatAssemblyBegin(A, MAT_FINAL_ASSEMBLY));
  ASSERT_OK(MatAssemblyEnd(A, MAT_FINAL_ASSEMBLY));
  return A;
}

/* Returns the entry of row i in a column; 0: none. */
static PetscScalar EntryOf(Mat A, PetscInt i, PetscInt column, PetscInt *entries)
{
  const PetscInt    *col;
  const PetscScalar *value;
  PetscScalar        entry = 0.0;
  PetscInt           n;

  PetscCallAbort(PETSC_COMM_SELF, MatGetRow(A, i, &n, &col, &value));
  for (PetscInt k = 0; k < n; k++)
    if (col[k] == column) entry = value[k];
  *entries = n;
  PetscCallAbort(PETSC_COMM_SELF, MatRestoreRow(A, i, &n, &col, &value));
  return entry;
}

/* Entries of the pattern are those of Z + X Y, and others stay zero. */
static void test_product(void **state)
{
  Mat      X = Scattered(2 * ROWS, ROWS, 1), Y = Scattered(ROWS, 2 * ROWS, 2);
  Mat      Z = Scattered(2 * ROWS, 2 * ROWS, 3), all, before;
  PetscInt first, last, N, wrong = 0;

  (void)state;
  ASSERT_OK(MatMatMult(X, Y, MAT_INITIAL_MATRIX, PETSC_DEFAULT, &all));
  ASSERT_OK(MatDuplicate(Z, MAT_COPY_VALUES, &before));
  ASSERT_OK(SparseAddProduct(X, Y, Z));
  ASSERT_OK(MatGetOwnershipRange(Z, &first, &last));
  ASSERT_OK(MatGetSize(Z, NULL, &N));
  for (PetscInt i = first; i < last; i++)
    for (PetscInt j = 0; j < N; j++) {
      PetscInt          n, m;
      const PetscScalar old = EntryOf(before, i, j, &n), sum = EntryOf(Z, i, j, &m);

      if (n != m) wrong++;
      if (PetscAbsReal(sum - (old == 0.0 ? 0.0 : old + EntryOf(all, i, j, &n))) > 1e-14) wrong++;
    }
  CloudAssertNone("entries", "product", wrong);
  ASSERT_OK(MatDestroy(&before));
  ASSERT_OK(MatDestroy(&all));
  ASSERT_OK(MatDestroy(&Z));
  ASSERT_OK(MatDestroy(&Y));
  ASSERT_OK(MatDestroy(&X));
}

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
  ASSERT_OK(PairLaplacian(&flow, one, NULL, NULL, NULL, &A));
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
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_product),
                                     cmocka_unit_test(test_laplacian)};
  int                     failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
  return PetscFinalize() || failed ? 1 : 0;
}
