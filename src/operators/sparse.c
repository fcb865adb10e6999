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

/* The own rows of a matrix: those of its diagonal block, and on several ranks those of the other
   columns, whose global numbers ascend. */
typedef struct {
  Mat             mat[2];
  SparseRows      rows[2];
  PetscInt        blocks, n, start, n_others; /* n: columns of the diagonal block from `start` */
  const PetscInt *others;
} OwnRows;

/* Gets the own rows of a matrix, or returns them. */
static PetscErrorCode OwnRowsGet(Mat A, PetscBool back, OwnRows *own)
{
  PetscBool parallel;

  PetscFunctionBegin;
  PetscCall(PetscObjectBaseTypeCompare((PetscObject)A, MATMPIAIJ, &parallel));
  own->blocks = parallel ? 2 : 1;
  own->mat[0] = A;
  if (parallel) PetscCall(MatMPIAIJGetSeqAIJ(A, &own->mat[0], &own->mat[1], &own->others));
  PetscCall(MatGetOwnershipRangeColumn(A, &own->start, NULL));
  PetscCall(MatGetLocalSize(A, NULL, &own->n));
  own->n_others = 0;
  if (parallel) PetscCall(MatGetSize(own->mat[1], NULL, &own->n_others));
  for (PetscInt b = 0; b < own->blocks; b++) PetscCall(RowsGet(own->mat[b], back, &own->rows[b]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the number of a global column among those of a matrix: the own ones, then the others; -1:
   it has no such column. */
static PetscInt ColumnAmong(const OwnRows *own, PetscInt column)
{
  PetscInt place;

  if (column >= own->start && column < own->start + own->n) return column - own->start;
  if (own->blocks == 1) return -1;
  (void)PetscFindInt(column, own->n_others, own->others, &place);
  return place < 0 ? -1 : own->n + place;
}

/* Appends entries of a row, without columns that `of` has not. */
static void AppendRow(const OwnRows *of, PetscInt n, const PetscInt col[], const PetscInt number[],
                      PetscInt shift, const PetscScalar value[], SparseRows *to, PetscInt *end)
{
  for (PetscInt k = 0; k < n; k++) {
    const PetscInt c = ColumnAmong(of, number ? number[col[k]] : shift + col[k]);

    if (c < 0) continue;
    to->col[*end]       = c;
    to->value[(*end)++] = value[k];
  }
}

/* Gathers the rows of Y that are columns of X: the own ones, then those of other ranks; columns are
   numbered as those of `sum`. */
static PetscErrorCode GatherRows(const OwnRows *x, Mat Y, const OwnRows *sum, SparseRows *to)
{
  OwnRows    y;
  SparseRows others = {.n = 0};
  PetscInt   end    = 0, entries, N;
  IS         rows, cols;
  Mat       *sub = NULL;

  PetscFunctionBegin;
  PetscCall(OwnRowsGet(Y, PETSC_FALSE, &y));
  if (y.blocks > 1) {
    PetscCall(MatGetSize(Y, NULL, &N));
    PetscCall(ISCreateGeneral(PETSC_COMM_SELF, x->n_others, x->others, PETSC_USE_POINTER, &rows));
    PetscCall(ISCreateStride(PETSC_COMM_SELF, N, 0, 1, &cols));
    PetscCall(MatCreateSubMatrices(Y, 1, &rows, &cols, MAT_INITIAL_MATRIX, &sub));
    PetscCall(ISDestroy(&rows));
    PetscCall(ISDestroy(&cols));
    PetscCall(RowsGet(*sub, PETSC_FALSE, &others));
  }
  entries = others.n ? others.row[others.n] : 0;
  for (PetscInt b = 0; b < y.blocks; b++) entries += y.rows[b].row[y.rows[b].n];
  PetscCall(SparseRowsMalloc(y.rows[0].n + others.n, entries, to));
  for (PetscInt i = 0; i < to->n; i++) {
    for (PetscInt b = 0; i < y.rows[0].n && b < y.blocks; b++) {
      const PetscInt k = y.rows[b].row[i], n = y.rows[b].row[i + 1] - k;

      AppendRow(sum, n, &y.rows[b].col[k], b ? y.others : NULL, y.start, &y.rows[b].value[k], to,
                &end);
    }
    if (i >= y.rows[0].n) {
      const PetscInt k = others.row[i - y.rows[0].n], n = others.row[i - y.rows[0].n + 1] - k;

      AppendRow(sum, n, &others.col[k], NULL, 0, &others.value[k], to, &end);
    }
    to->row[i + 1] = end;
  }
  if (sub) {
    PetscCall(RowsGet(*sub, PETSC_TRUE, &others));
    PetscCall(MatDestroySubMatrices(1, &sub));
  }
  PetscCall(OwnRowsGet(Y, PETSC_TRUE, &y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the products of row i of X with rows y to row i of the sum. Input: place - for each column
   of the sum its entry in this row; NULL: no entry; on return all are NULL again. */
static void AddProducts(const OwnRows *x, const SparseRows *y, PetscInt i, OwnRows *sum,
                        PetscScalar *place[])
{
  for (PetscInt b = 0; b < x->blocks; b++)
    for (PetscInt k = x->rows[b].row[i]; k < x->rows[b].row[i + 1]; k++) {
      const PetscInt j = x->rows[b].col[k] + (b ? x->n : 0);

      for (PetscInt l = y->row[j]; l < y->row[j + 1]; l++)
        if (place[y->col[l]]) *place[y->col[l]] += x->rows[b].value[k] * y->value[l];
    }
}

/* Returns true if row i of X has a column whose row of y has entries. */
static PetscBool HasProducts(const OwnRows *x, const SparseRows *y, PetscInt i)
{
  for (PetscInt b = 0; b < x->blocks; b++)
    for (PetscInt k = x->rows[b].row[i]; k < x->rows[b].row[i + 1]; k++) {
      const PetscInt j = x->rows[b].col[k] + (b ? x->n : 0);

      if (y->row[j] < y->row[j + 1]) return PETSC_TRUE;
    }
  return PETSC_FALSE;
}

/* SparseAddProduct - Adds to a matrix those entries of the product X Y that are in its pattern.
   Collective. For preconditioners: the product itself has many more entries. The sum is of type
   MATAIJ, X and Y also of derived types; rows of Y without entries cost nothing. */
PetscErrorCode SparseAddProduct(Mat X, Mat Y, Mat sum)
{
  OwnRows       x, z;
  SparseRows    y;
  PetscScalar **place;

  PetscFunctionBegin;
  PetscCall(OwnRowsGet(X, PETSC_FALSE, &x));
  PetscCall(OwnRowsGet(sum, PETSC_FALSE, &z));
  PetscCall(GatherRows(&x, Y, &z, &y));
  PetscCall(PetscCalloc1(z.n + z.n_others, &place));
  for (PetscInt i = 0; i < z.rows[0].n; i++) {
    if (!HasProducts(&x, &y, i)) continue;
    for (PetscInt b = 0; b < z.blocks; b++)
      for (PetscInt k = z.rows[b].row[i]; k < z.rows[b].row[i + 1]; k++)
        place[z.rows[b].col[k] + (b ? z.n : 0)] = &z.rows[b].value[k];
    AddProducts(&x, &y, i, &z, place);
    for (PetscInt b = 0; b < z.blocks; b++)
      for (PetscInt k = z.rows[b].row[i]; k < z.rows[b].row[i + 1]; k++)
        place[z.rows[b].col[k] + (b ? z.n : 0)] = NULL;
  }
  PetscCall(PetscFree(place));
  PetscCall(RowsFree(&y));
  PetscCall(OwnRowsGet(sum, PETSC_TRUE, &z));
  PetscCall(OwnRowsGet(X, PETSC_TRUE, &x));
  for (PetscInt b = 0; b < z.blocks; b++) { /* tells PETSc about the new entries */
    PetscScalar *entry;

    PetscCall(MatSeqAIJGetArray(z.mat[b], &entry));
    PetscCall(MatSeqAIJRestoreArray(z.mat[b], &entry));
  }
  PetscCall(MatAssemblyBegin(sum, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(sum, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}
