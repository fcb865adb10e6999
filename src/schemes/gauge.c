/*
  The gauge of the pressure: without a boundary that gives its value the pressure floats, it is
  known up to a constant. All solvers fix the constant here and nowhere else.
*/
#include "step.h"

/* GaugeRemove - Removes the mean of a pressure that floats; collective */
PetscErrorCode GaugeRemove(Vec p)
{
  PetscFunctionBegin;
  PetscCall(VecRemoveMean(p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  GaugeColumn - Makes the column c whose square c c^T makes the matrix of a floating pressure
  regular

    c = (0, ..., 0, 1, ..., 1)/sqrt(N)

  Collective. A solution of (A + c c^T) p = b has a fixed mean, and c c^T p takes from b the uniform
  source that no pressure can answer.

  Input Parameter:
. before - rows of other unknowns before the pressures, per particle
*/
PetscErrorCode GaugeColumn(const Particles *p, PetscInt before, Mat *column)
{
  const PetscInt n = p->n_fluid, first = before * n;
  PetscScalar   *entry;

  PetscFunctionBegin;
  PetscCall(MatCreateDense(p->comm, first + n, PETSC_DECIDE, PETSC_DETERMINE, 1, NULL, column));
  PetscCall(MatDenseGetArrayWrite(*column, &entry));
  for (PetscInt i = 0; i < first + n; i++)
    entry[i] = i < first ? 0.0 : 1.0 / PetscSqrtReal((PetscReal)p->N_fluid);
  PetscCall(MatDenseRestoreArrayWrite(*column, &entry));
  PetscCall(MatAssemblyBegin(*column, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(*column, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}
