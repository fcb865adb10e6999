/* Matrices from sorted rows, and sums of matrices of different patterns. */
#include "isph/operators.h"

/* SparseRowsMalloc - Allocates n rows for SparseRowsMat(), which frees them */
PetscErrorCode SparseRowsMalloc(PetscInt n, PetscInt entries, SparseRows *rows)
{
  PetscFunctionBegin;
  rows->n = n;
  PetscCall(PetscMalloc1(n + 1, &rows->row));
  PetscCall(PetscMalloc1(entries, &rows->col));
  PetscCall(PetscMalloc1(entries, &rows->value));
  rows->row[0] = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode RowsFree(SparseRows *rows)
{
  PetscFunctionBegin;
  PetscCall(FreeAll(&rows->row, &rows->col, &rows->value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode RowsDestroy(void *rows)
{
  PetscFunctionBegin;
  PetscCall(RowsFree((SparseRows *)rows));
  PetscCall(PetscFree(rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SparseRowsKeep - Keeps the arrays of rows with a matrix, which frees them at its end. Input: name
   - of the rows, for SparseRowsGet(). */
PetscErrorCode SparseRowsKeep(const SparseRows *rows, const char name[], Mat A)
{
  PetscContainer container;
  SparseRows    *kept;

  PetscFunctionBegin;
  PetscCall(PetscNew(&kept));
  *kept = *rows;
  PetscCall(PetscContainerCreate(PETSC_COMM_SELF, &container));
  PetscCall(PetscContainerSetPointer(container, kept));
  PetscCall(PetscContainerSetUserDestroy(container, RowsDestroy));
  PetscCall(PetscObjectCompose((PetscObject)A, name, (PetscObject)container));
  PetscCall(PetscContainerDestroy(&container));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SparseRowsGet - Returns rows of SparseRowsKeep(), NULL if there are none */
PetscErrorCode SparseRowsGet(Mat A, const char name[], SparseRows **rows)
{
  PetscContainer container;

  PetscFunctionBegin;
  *rows = NULL;
  PetscCall(PetscObjectQuery((PetscObject)A, name, (PetscObject *)&container));
  if (container) PetscCall(PetscContainerGetPointer(container, (void **)rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SparseRowsMat - Creates a matrix from rows of SparseRowsMalloc(). Collective on comm. Input: cols
   - local size. Input/Output: rows - the matrix takes them over. Output: A - MATSEQAIJ on a single
   rank, otherwise MATMPIAIJ. */
PetscErrorCode SparseRowsMat(MPI_Comm comm, SparseRows *rows, PetscInt cols, Mat *A)
{
  PetscMPIInt size;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(comm, &size));
  if (size > 1) {
    PetscCall(MatCreateMPIAIJWithArrays(comm, rows->n, cols, PETSC_DETERMINE, PETSC_DETERMINE,
                                        rows->row, rows->col, rows->value, A));
    PetscCall(RowsFree(rows));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MatCreateSeqAIJWithArrays(comm, rows->n, cols, rows->row, rows->col, rows->value, A));
  PetscCall(SparseRowsKeep(rows, "rows", *A));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the row x + y; returns the end of the sum. */
static PetscInt AddRow(const SparseRows *x, const SparseRows *y, PetscInt i, SparseRows *sum)
{
  const PetscInt none = PETSC_INT_MAX;
  PetscInt       k = x->row[i], l = y->row[i], q = sum->row[i];

  while (k < x->row[i + 1] || l < y->row[i + 1]) {
    const PetscInt a = k < x->row[i + 1] ? x->col[k] : none;
    const PetscInt b = l < y->row[i + 1] ? y->col[l] : none;

    sum->col[q]     = PetscMin(a, b);
    sum->value[q++] = a < b ? x->value[k] : a > b ? y->value[l] : y->value[l] + x->value[k];
    if (a <= b) k++;
    if (b <= a) l++;
  }
  return q;
}

/* Gets the rows of a MATSEQAIJ, or returns them. */
static PetscErrorCode RowsGet(Mat A, PetscBool back, SparseRows *rows)
{
  PetscBool done;

  PetscFunctionBegin;
  if (back) {
    PetscCall(MatSeqAIJRestoreArrayRead(A, (const PetscScalar **)&rows->value));
    PetscCall(MatRestoreRowIJ(A, 0, PETSC_FALSE, PETSC_FALSE, &rows->n,
                              (const PetscInt **)&rows->row, (const PetscInt **)&rows->col, &done));
  } else {
    PetscCall(MatGetRowIJ(A, 0, PETSC_FALSE, PETSC_FALSE, &rows->n, (const PetscInt **)&rows->row,
                          (const PetscInt **)&rows->col, &done));
    PetscCall(MatSeqAIJGetArrayRead(A, (const PetscScalar **)&rows->value));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SparseAdd - Adds X to *Y, which becomes a new matrix with the entries of both; collective */
PetscErrorCode SparseAdd(Mat X, Mat *Y)
{
  SparseRows x, y, rows;
  PetscBool  sequential;
  PetscInt   cols, bs, cbs;
  Mat        sum;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)*Y, MATSEQAIJ, &sequential));
  if (!sequential) {
    PetscCall(MatAXPY(*Y, 1.0, X, UNKNOWN_NONZERO_PATTERN));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MatGetLocalSize(*Y, NULL, &cols));
  PetscCall(MatGetBlockSizes(*Y, &bs, &cbs));
  PetscCall(RowsGet(X, PETSC_FALSE, &x));
  PetscCall(RowsGet(*Y, PETSC_FALSE, &y));
  PetscCall(SparseRowsMalloc(y.n, x.row[y.n] + y.row[y.n], &rows));
  for (PetscInt i = 0; i < y.n; i++) rows.row[i + 1] = AddRow(&x, &y, i, &rows);
  PetscCall(RowsGet(*Y, PETSC_TRUE, &y));
  PetscCall(RowsGet(X, PETSC_TRUE, &x));
  PetscCall(SparseRowsMat(PetscObjectComm((PetscObject)*Y), &rows, cols, &sum));
  PetscCall(MatSetBlockSizes(sum, bs, cbs));
  PetscCall(MatDestroy(Y));
  *Y = sum;
  PetscFunctionReturn(PETSC_SUCCESS);
}
