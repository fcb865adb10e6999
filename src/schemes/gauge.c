/*
  The constant of the pressure, which is undetermined without a boundary that prescribes a pressure.
  All solvers fix it by these functions and in no other way.
*/
#include "step.h"

/* GaugeRemove - Removes the mean of a pressure with undetermined constant; collective */
PetscErrorCode GaugeRemove(const Particles *particles, Vec p)
{
  PetscFunctionBegin;
  PetscCall(FluidRemoveMean(particles, p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  GaugeColumn - Creates a column c that makes A + c c^T regular, if the matrix A leaves the constant
  of the pressure undetermined

    c = (0, ..., 0, 1, ..., 1)/sqrt(N),   N: number of pressures on all ranks

  Collective. The solution p of (A + c c^T) p = b has a fixed mean, and c c^T p subtracts from b the
  uniform source for which no pressure exists. See docs/theory.md, (90).

  Input Parameter:
. before - number of other unknowns of each particle, whose rows precede the rows of the pressure
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
