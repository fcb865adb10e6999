/*
  Diagonals of preconditioners: AmgDiagonal() raises entries below half of the sum of the others,
  negative ones too, and changes nothing else.
*/
/* RANKS: 1 2 */
#include "cloud.h"
#include "isph/solvers.h"

#define ROWS 4 /* on each rank */

/* A row has its diagonal entry, -1 in the other columns of its rank, and 5 in one column of the
   next rank, if there is one: the sum of the others is 3 or 8. */
static void test_raised(void **state)
{
  const PetscScalar entry[ROWS] = {-0.5, 0.1, 1.75, 4.0};
  PetscMPIInt       rank, size;
  PetscInt          first;
  Mat               A, B;

  (void)state;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  MPI_Comm_size(PETSC_COMM_WORLD, &size);
  first = ROWS * rank;
  ASSERT_OK(MatCreateAIJ(PETSC_COMM_WORLD, ROWS, ROWS, PETSC_DETERMINE, PETSC_DETERMINE, ROWS, NULL,
                         1, NULL, &A));
  for (PetscInt i = 0; i < ROWS; i++) {
    for (PetscInt j = 0; j < ROWS; j++)
      ASSERT_OK(MatSetValue(A, first + i, first + j, i == j ? entry[i] : -1.0, INSERT_VALUES));
    if (size > 1)
      ASSERT_OK(MatSetValue(A, first + i, (first + ROWS + i) % (ROWS * size), 5.0, INSERT_VALUES));
  }
  ASSERT_OK(MatAssemblyBegin(A, MAT_FINAL_ASSEMBLY));
  ASSERT_OK(MatAssemblyEnd(A, MAT_FINAL_ASSEMBLY));
  ASSERT_OK(MatDuplicate(A, MAT_COPY_VALUES, &B));
  ASSERT_OK(AmgDiagonal(A));
  ASSERT_OK(MatAXPY(A, -1.0, B, SAME_NONZERO_PATTERN));
  for (PetscInt i = 0; i < ROWS; i++) {
    const PetscReal    least = size > 1 ? 4.0 : 1.5;
    PetscInt           n;
    const PetscInt    *column;
    const PetscScalar *change;

    ASSERT_OK(MatGetRow(A, first + i, &n, &column, &change));
    assert_int_equal(n, size > 1 ? ROWS + 1 : ROWS);
    for (PetscInt k = 0; k < n; k++)
      assert_true(PetscAbsReal(change[k] - (column[k] == first + i ? PetscMax(least - entry[i], 0.0)
                                                                   : 0.0)) < 1e-14);
    ASSERT_OK(MatRestoreRow(A, first + i, &n, &column, &change));
  }
  ASSERT_OK(MatDestroy(&B));
  ASSERT_OK(MatDestroy(&A));
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_raised)};
  int                     failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
  return PetscFinalize() || failed ? 1 : 0;
}
