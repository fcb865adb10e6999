/* The matrix shift I + scale A of an operator, for solvers: from its rows, so that A itself need
   not be a matrix. */
#include "isph/operators.h"

/*
  AffineSystemCreate - Creates a matrix with the sparsity pattern of A

  Collective. Input: type - type of the matrix; MATSAME: the usual one. Output: J - the matrix, for
  AffineSystemSet(), also of other operators with the same rows. It uses the storage of the rows
  until the next assembly, so there is one at a time.
*/
PetscErrorCode AffineSystemCreate(const AffineOperator *op, MatType type, Mat *J)
{
  OperatorRows    *rows = op->rows;
  const Particles *p;
  PetscBool        same;
  PetscInt         entries;

  PetscFunctionBegin;
  if (op->A) {
    PetscCall(MatConvert(op->A, type, MAT_INITIAL_MATRIX, J));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  p       = rows->particles;
  entries = rows->fluid.row[p->n_fluid];
  if (entries > rows->system_capacity) {
    rows->system_capacity = entries + entries / 8;
    PetscCall(PetscFree(rows->system));
    PetscCall(PetscMalloc1(rows->system_capacity, &rows->system));
  }
  PetscCall(PetscArrayzero(rows->system, entries));
  PetscCall(PatternMat(p->comm, &rows->fluid, p->n_fluid, p->n_fluid, rows->system, J));
  PetscCall(PetscStrcmp(type, MATSAME, &same));
  if (!same) PetscCall(MatConvert(*J, type, MAT_INPLACE_MATRIX, J));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the rows of a matrix of any type. */
static PetscErrorCode SetRows(const OperatorRows *rows, const PetscReal value[], Mat J)
{
  const Pattern *pattern = &rows->fluid;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < pattern->n; i++) {
    const PetscInt first = pattern->row[i];

    PetscCall(MatSetValues(J, 1, &rows->particles->row[i], pattern->row[i + 1] - first,
                           pattern->col + first, value + first, INSERT_VALUES));
  }
  PetscCall(MatAssemblyBegin(J, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(J, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* AffineSystemSet - Computes J = shift I + scale A in a matrix of AffineSystemCreate();
   collective */
PetscErrorCode AffineSystemSet(const AffineOperator *op, PetscReal shift, PetscReal scale, Mat J)
{
  const OperatorRows *rows = op->rows;
  PetscReal          *value;
  PetscBool           plain;

  PetscFunctionBegin;
  if (op->A) {
    PetscCall(MatCopy(op->A, J, SAME_NONZERO_PATTERN));
    PetscCall(MatScale(J, scale));
    PetscCall(MatShift(J, shift));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  value = rows->system;
  for (PetscInt i = 0; i < rows->fluid.n; i++) {
    for (PetscInt s = rows->fluid.row[i]; s < rows->fluid.row[i + 1]; s++) {
      value[s] = scale * op->a[s];
      if (rows->fluid.col[s] == rows->particles->row[i]) value[s] += shift;
    }
  }
  PetscCall(PetscObjectTypeCompareAny((PetscObject)J, &plain, MATSEQAIJ, MATMPIAIJ, ""));
  if (plain) PetscCall(PatternMatSet(&rows->fluid, value, J));
  else PetscCall(SetRows(rows, value, J));
  PetscFunctionReturn(PETSC_SUCCESS);
}
