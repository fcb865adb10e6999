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

/* Returns the global column of slot s. */
static inline PetscInt Column(const OperatorRows *rows, PetscInt s)
{
  return rows->particles->row[rows->fluid.local[s]];
}

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
      if (Column(rows, s) == rows->particles->row[i]) value[i] += shell->scale * a[s - first];
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
  PetscCall(PetscObjectComposeFunction((PetscObject)*J, MAT_FLATTEN, AffineSystemFlatten));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates a matrix with the pattern of the rows and zeros. */
static PetscErrorCode SystemMat(const OperatorRows *rows, Mat *J)
{
  const Particles *p       = rows->particles;
  const PetscInt   n       = rows->fluid.row[p->n_fluid];
  Pattern          pattern = rows->fluid;
  SparseRows       entries;

  PetscFunctionBegin;
  PetscCall(SparseRowsMalloc(p->n_fluid, n, &entries));
  PetscCall(PetscArraycpy(entries.row, pattern.row, p->n_fluid + 1));
  PetscCall(PetscArrayzero(entries.value, n));
  for (PetscInt s = 0; s < n; s++) entries.col[s] = Column(rows, s);
  pattern.row = entries.row;
  pattern.col = entries.col;
  PetscCall(PatternMat(p->comm, &pattern, p->n_fluid, p->n_fluid, entries.value, NULL, J));
  PetscCall(SparseRowsKeep(&entries, MAT_VALUES, *J));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* AffineSystemCreate - Creates a matrix with the sparsity pattern of A. Collective. Input: type -
   type of the matrix; MATSAME: the usual one; MATSHELL: products and the diagonal by the rows, in
   all assemblies of an epoch. Output: J - the matrix, for AffineSystemSet(), also of other
   operators with the same rows. If it is no shell, it is valid until the next assembly. */
PetscErrorCode AffineSystemCreate(const AffineOperator *op, MatType type, Mat *J)
{
  PetscBool same, shell;

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
  PetscCall(SystemMat(op->rows, J));
  PetscCall(PetscStrcmp(type, MATSAME, &same));
  if (!same) PetscCall(MatConvert(*J, type, MAT_INPLACE_MATRIX, J));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the entries of shift I + scale A in the order of the pattern. */
static void SystemValues(const AffineOperator *op, PetscReal shift, PetscReal scale,
                         PetscReal value[])
{
  const OperatorRows *rows = op->rows;

  for (PetscInt i = 0; i < rows->fluid.n; i++) {
    const PetscInt   first = rows->fluid.row[i];
    const PetscReal *a     = AffineRow(rows, op, i);

    for (PetscInt s = first; s < rows->fluid.row[i + 1]; s++) {
      value[s] = scale * a[s - first];
      if (Column(rows, s) == rows->particles->row[i]) value[s] += shift;
    }
  }
}

/* Sets the rows of a matrix of any type. */
static PetscErrorCode SetRows(const AffineOperator *op, PetscReal shift, PetscReal scale, Mat J)
{
  const Pattern *pattern = &op->rows->fluid;
  const PetscInt entries = pattern->row[pattern->n];
  PetscInt      *col;
  PetscReal     *value;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(entries, &value, entries, &col));
  SystemValues(op, shift, scale, value);
  for (PetscInt s = 0; s < entries; s++) col[s] = Column(op->rows, s);
  for (PetscInt i = 0; i < pattern->n; i++) {
    const PetscInt first = pattern->row[i], n = pattern->row[i + 1] - first;

    PetscCall(MatSetValues(J, 1, &op->rows->particles->row[i], n, col + first, value + first,
                           INSERT_VALUES));
  }
  PetscCall(PetscFree2(value, col));
  PetscCall(MatAssemblyBegin(J, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(J, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* AffineSystemSet - Computes J = shift I + scale A in a matrix of AffineSystemCreate();
   collective */
PetscErrorCode AffineSystemSet(const AffineOperator *op, PetscReal shift, PetscReal scale, Mat J)
{
  SparseRows *entries;
  PetscBool   plain, is_shell;

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
  PetscCall(PetscObjectTypeCompareAny((PetscObject)J, &plain, MATSEQAIJ, MATMPIAIJ, ""));
  PetscCall(SparseRowsGet(J, MAT_VALUES, &entries));
  if (plain && entries) {
    SystemValues(op, shift, scale, entries->value);
    PetscCall(PatternMatSet(entries, J));
  } else PetscCall(SetRows(op, shift, scale, J));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* AffineBlock - Creates a matrix of the operators op[c] on interlaced components: op[c] fills rows
   dim i + c or columns dim j + c. Collective. Input: rows - with columns. Output: block - destroy
   with MatDestroy(). */
PetscErrorCode AffineBlock(const Particles *p, const OperatorRows *rows, const AffineLayout *by,
                           const AffineOperator op[], Mat *block)
{
  const Pattern *pattern = &rows->fluid;
  const PetscInt n       = by->rows * p->n_fluid;
  SparseRows     to;
  PetscInt       q = 0;

  PetscFunctionBegin;
  PetscCall(SparseRowsMalloc(n, by->rows * by->cols * pattern->row[p->n_fluid], &to));
  for (PetscInt r = 0; r < n; r++) {
    const PetscInt i = r / by->rows, first = pattern->row[i];

    for (PetscInt s = first; s < pattern->row[i + 1]; s++) {
      if (by->only && by->only[by->rows > 1 ? pattern->local[s] : i] == 0.0) continue;
      for (PetscInt c = 0; c < by->cols; c++) {
        const AffineOperator *of = &op[by->rows > 1 ? r % by->rows : c];

        to.col[q]     = by->cols * pattern->col[s] + c;
        to.value[q++] = by->scale * AffineRow(rows, of, i)[s - first];
      }
    }
    to.row[r + 1] = q;
  }
  PetscCall(SparseRowsMat(p->comm, &to, by->cols * p->n_fluid, block));
  PetscCall(MatDiagonalScale(*block, by->row_units, by->col_units));
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
