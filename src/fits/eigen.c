/* The dense eigenproblem K v = lambda M v, as of an axis of splines, by LAPACK. */
#include "isph/fits.h"
#include <petscblaslapack.h>

/* DenseEigen - Solves K V = M V diag(lambda), V^T M V = 1, for n x n matrices. Input: K, M -
   symmetric, M positive definite; destroyed. Output: lambda - eigenvalues in ascending order; V -
   eigenvectors in columns, by rows. */
PetscErrorCode DenseEigen(PetscInt n, PetscReal K[], PetscReal M[], PetscReal lambda[],
                          PetscReal V[])
{
  const PetscBLASInt itype = 1, size = (PetscBLASInt)n, room = 34 * size;
  PetscBLASInt       info;
  PetscReal         *work;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(room, &work));
  LAPACKsygv_(&itype, "V", "U", &size, K, &size, M, &size, lambda, work, &room, &info);
  PetscCall(PetscFree(work));
  PetscCheck(info <= size, PETSC_COMM_SELF, PETSC_ERR_LIB, "The mass of splines is singular");
  PetscCheck(info == 0, PETSC_COMM_SELF, PETSC_ERR_LIB,
             "The eigenvalues of splines do not converge");
  for (PetscInt i = 0; i < n; i++)
    for (PetscInt k = 0; k < n; k++) V[i * n + k] = K[k * n + i]; /* columns are stored in turn */
  PetscFunctionReturn(PETSC_SUCCESS);
}
