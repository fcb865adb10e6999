/* The constant of the pressure, which is undetermined unless a boundary gives a value of the
   pressure (ScenePressureFloats()). All solvers fix it by these functions and in no other way; for
   a determined pressure the functions change nothing. */
#include "isph/solvers.h"

/* GaugeRemove - Removes the mean of a pressure with undetermined constant; collective */
PetscErrorCode GaugeRemove(const Scene *scene, const Particles *particles, Vec p)
{
  PetscFunctionBegin;
  if (ScenePressureFloats(scene)) PetscCall(FluidRemoveMean(particles, p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  GaugeColumn - Creates a column c that makes A + c c^T regular, if the matrix A leaves the constant
  of the pressure undetermined

    c = sqrt(s/N) (0, ..., 0, 1, ..., 1),   N: number of pressures on all ranks

  Collective. The solution p of (A + c c^T) p = b has a fixed mean, and c c^T p subtracts from b the
  uniform source for which no pressure exists, whatever s is. With the s of GaugePreconditioner() a
  constant is an eigenvector of both matrices with the same eigenvalue, so that it costs no
  iteration. See theory.md, (projection:constant). Input: before - number of other unknowns on this
  rank, whose rows precede the rows of the pressure; n - number of pressures on this rank; strength
  - s [-]. Output: column - NULL for a determined pressure.
*/
PetscErrorCode GaugeColumn(const Scene *scene, MPI_Comm comm, PetscInt before, PetscInt n,
                           PetscReal strength, Mat *column)
{
  PetscInt     N;
  PetscScalar *entry;

  PetscFunctionBegin;
  *column = NULL;
  if (!ScenePressureFloats(scene)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Allreduce(&n, &N, 1, MPIU_INT, MPI_SUM, comm));
  PetscCall(MatCreateDense(comm, before + n, PETSC_DECIDE, PETSC_DETERMINE, 1, NULL, column));
  PetscCall(MatDenseGetArrayWrite(*column, &entry));
  for (PetscInt i = 0; i < before + n; i++)
    entry[i] = i < before ? 0.0 : PetscSqrtReal(strength / (PetscReal)N);
  PetscCall(MatDenseRestoreArrayWrite(*column, &entry));
  PetscCall(MatAssemblyBegin(*column, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(*column, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* GaugeMatrix - Creates the regular matrix A + c c^T, or A itself for a column NULL; collective */
PetscErrorCode GaugeMatrix(Mat A, Mat column, Mat *regular)
{
  PetscFunctionBegin;
  if (column) {
    PetscCall(MatCreateLRC(A, column, NULL, column, regular));
  } else {
    PetscCall(PetscObjectReference((PetscObject)A));
    *regular = A;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* GaugePreconditioner - Makes a singular matrix of the pressure regular for a preconditioner:
   A + s I; collective. Input: shift - s [-] */
PetscErrorCode GaugePreconditioner(const Scene *scene, PetscReal shift, Mat A)
{
  PetscFunctionBegin;
  if (ScenePressureFloats(scene)) PetscCall(MatShift(A, shift));
  PetscFunctionReturn(PETSC_SUCCESS);
}
