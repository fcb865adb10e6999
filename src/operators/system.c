/* The matrix shift I + scale A of an operator, for solvers: from its rows, so that A itself need
   not be a matrix. Solvers that only multiply take a shell, which stores no entries. */
#include "isph/operators.h"

/* The context of a shell. */
typedef struct {
  const AffineOperator *op;
  PetscReal             shift, scale;
} Shell;

/* Computes y = shift x + scale A x. */
static PetscErrorCode ShellMult(Mat J, Vec x, Vec y)
{
  const Shell *shell;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(J, (void *)&shell));
  PetscCall(AffineApply(shell->op, x, NULL, y));
  PetscCall(VecAXPBY(y, shell->shift, shell->scale, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Copies the diagonal. */
static PetscErrorCode ShellGetDiagonal(Mat J, Vec diagonal)
{
  const Shell        *shell;
  const OperatorRows *rows;
  PetscScalar        *value;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(J, (void *)&shell));
  rows = shell->op->rows;
  PetscCall(VecGetArrayWrite(diagonal, &value));
  for (PetscInt i = 0; i < rows->fluid.n; i++) {
    const PetscInt   first = rows->fluid.row[i];
    const PetscReal *a     = AffineRow(rows, shell->op, i);

    value[i] = shell->shift;
    for (PetscInt s = first; s < rows->fluid.row[i + 1]; s++)
      if (rows->fluid.col[s] == rows->particles->row[i]) value[i] += shell->scale * a[s - first];
  }
  PetscCall(VecRestoreArrayWrite(diagonal, &value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ShellDestroy(Mat J)
{
  Shell *shell;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(J, (void *)&shell));
  PetscCall(PetscFree(shell));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates a shell, which has products and a diagonal. */
static PetscErrorCode ShellCreate(const AffineOperator *op, Mat *J)
{
  const Particles *p = op->rows->particles;
  Shell           *shell;

  PetscFunctionBegin;
  PetscCall(PetscNew(&shell));
  shell->op = op;
  PetscCall(
      MatCreateShell(p->comm, p->n_fluid, p->n_fluid, PETSC_DETERMINE, PETSC_DETERMINE, shell, J));
  PetscCall(MatShellSetOperation(*J, MATOP_MULT, (void (*)(void))ShellMult));
  PetscCall(MatShellSetOperation(*J, MATOP_GET_DIAGONAL, (void (*)(void))ShellGetDiagonal));
  PetscCall(MatShellSetOperation(*J, MATOP_DESTROY, (void (*)(void))ShellDestroy));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  AffineSystemCreate - Creates a matrix with the sparsity pattern of A

  Collective. Input: type - type of the matrix; MATSAME: the usual one; MATSHELL: products and the
  diagonal by the rows, in all assemblies of an epoch. Output: J - the matrix, for
  AffineSystemSet(), also of other operators with the same rows. If it is no shell, it uses the
  storage of the rows until the next assembly, so there is one at a time.
*/
PetscErrorCode AffineSystemCreate(const AffineOperator *op, MatType type, Mat *J)
{
  OperatorRows    *rows = op->rows;
  const Particles *p;
  PetscBool        same, shell;
  PetscInt         entries;

  PetscFunctionBegin;
  PetscCall(PetscStrcmp(type, MATSHELL, &shell));
  if (shell) {
    PetscCall(ShellCreate(op, J));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
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
  PetscBool           plain, is_shell;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)J, MATSHELL, &is_shell));
  if (is_shell) {
    Shell *shell;

    PetscCall(MatShellGetContext(J, (void *)&shell));
    *shell = (Shell){.op = op, .shift = shift, .scale = scale};
    PetscCall(MatAssemblyBegin(J, MAT_FINAL_ASSEMBLY)); /* tells solvers that J has changed */
    PetscCall(MatAssemblyEnd(J, MAT_FINAL_ASSEMBLY));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (op->A) {
    PetscCall(MatCopy(op->A, J, SAME_NONZERO_PATTERN));
    PetscCall(MatScale(J, scale));
    PetscCall(MatShift(J, shift));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  value = rows->system;
  for (PetscInt i = 0; i < rows->fluid.n; i++) {
    const PetscInt   first = rows->fluid.row[i];
    const PetscReal *a     = AffineRow(rows, op, i);

    for (PetscInt s = first; s < rows->fluid.row[i + 1]; s++) {
      value[s] = scale * a[s - first];
      if (rows->fluid.col[s] == rows->particles->row[i]) value[s] += shift;
    }
  }
  PetscCall(PetscObjectTypeCompareAny((PetscObject)J, &plain, MATSEQAIJ, MATMPIAIJ, ""));
  if (plain) PetscCall(PatternMatSet(&rows->fluid, value, J));
  else PetscCall(SetRows(rows, value, J));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* AffineSystemFlatten - Creates a matrix with the entries of a shell; collective */
PetscErrorCode AffineSystemFlatten(Mat J, Mat *flat)
{
  const Shell *shell;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(J, (void *)&shell));
  PetscCall(AffineSystemCreate(shell->op, MATSAME, flat));
  PetscCall(AffineSystemSet(shell->op, shell->shift, shell->scale, *flat));
  PetscFunctionReturn(PETSC_SUCCESS);
}
