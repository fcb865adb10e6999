/*
  The sparsity pattern that all operators share, and the matrices on it. All operators have the same
  neighbours. So the columns of a row are sorted once, and every operator writes its values to the
  same slots: positions in the arrays of values.
*/
#include "isph/operators.h"

/*
  PatternBegin - Empties a pattern and allocates room for rows

  Not collective. Input: number of own rows, and an upper bound of the number of all entries.
*/
PetscErrorCode PatternBegin(Pattern *pattern, PetscInt rows, PetscInt entries)
{
  PetscFunctionBegin;
  if (rows > pattern->n || !pattern->row || entries > pattern->capacity) {
    const PetscInt capacity = PetscMax(pattern->capacity, entries + entries / 8 + 16);

    PetscCall(PatternFree(pattern));
    PetscCall(
        PetscMalloc3(rows + 1, &pattern->row, capacity, &pattern->col, capacity, &pattern->local));
    pattern->capacity = capacity;
  }
  pattern->n      = rows;
  pattern->row[0] = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  PatternRow - Adds row i; to be called for i = 0, 1, 2, ...

  Not collective. A repeated column (a particle and its periodic image) becomes a single entry.

  Input Parameters:
+ cols  - global columns in any order
. local - local indices of their particles; NULL: none are kept
- n     - number of columns

  Output Parameter:
. slot - position of the entry of cols[k] in the arrays of values

  Returns: true if the slots of cols[0], cols[1], ... follow each other
*/
PetscBool PatternRow(Pattern *pattern, PetscInt i, const PetscInt cols[], const PetscInt local[],
                     PetscInt n, PetscInt slot[])
{
  const PetscInt first = pattern->row[i];
  PetscInt      *row = &pattern->col[first], length = 0;
  PetscBool      ascending = PETSC_TRUE;

  for (PetscInt k = 0; k < n; k++) {
    if (k && cols[k] <= cols[k - 1]) ascending = PETSC_FALSE;
    row[k]  = cols[k];
    slot[k] = first + k;
  }
  pattern->row[i + 1] = first + n;
  for (PetscInt k = 0; local && k < n; k++) pattern->local[first + k] = local[k];
  if (ascending) return PETSC_TRUE;
  for (PetscInt k = 1; k < n; k++) { /* insertion sort: the columns are nearly in order */
    const PetscInt col = row[k];
    PetscInt       q   = k;

    for (; q > 0 && row[q - 1] > col; q--) row[q] = row[q - 1];
    row[q] = col;
  }
  for (PetscInt k = 0; k < n; k++) {
    if (length == 0 || row[k] != row[length - 1]) row[length++] = row[k];
  }
  pattern->row[i + 1] = first + length;
  for (PetscInt k = 0; k < n; k++) {
    PetscInt low = 0, high = length - 1;

    while (low < high) {
      const PetscInt middle = (low + high) / 2;

      if (row[middle] < cols[k]) low = middle + 1;
      else high = middle;
    }
    slot[k] = first + low;
    if (local) pattern->local[slot[k]] = local[k];
  }
  return PETSC_FALSE;
}

/* The storage of a parallel matrix: rows over own columns and over columns of other ranks. */
typedef struct {
  PetscInt    *row[2], *col[2];
  PetscScalar *value[2];
} SplitRows;

static PetscErrorCode SplitRowsDestroy(void *ctx)
{
  SplitRows *split = (SplitRows *)ctx;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < 2; k++)
    PetscCall(PetscFree3(split->row[k], split->col[k], split->value[k]));
  PetscCall(PetscFree(split));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates a MATMPIAIJ from rows that are split beforehand, which needs no copies. Own columns begin
   with the global number `start`. */
static PetscErrorCode SplitMat(MPI_Comm comm, const Pattern *pattern, PetscInt rows, PetscInt cols,
                               PetscInt start, const PetscReal values[], Mat *A)
{
  const PetscInt entries = pattern->row[rows];
  PetscInt       own     = 0, n[2];
  PetscContainer container;
  SplitRows     *split;

  PetscFunctionBegin;
  for (PetscInt s = 0; s < entries; s++)
    own += pattern->col[s] >= start && pattern->col[s] < start + cols ? 1 : 0;
  n[0] = own;
  n[1] = entries - own;
  PetscCall(PetscNew(&split));
  for (PetscInt k = 0; k < 2; k++) {
    PetscCall(PetscMalloc3(rows + 1, &split->row[k], n[k], &split->col[k], n[k], &split->value[k]));
    n[k] = split->row[k][0] = 0;
  }
  for (PetscInt i = 0; i < rows; i++) {
    for (PetscInt s = pattern->row[i]; s < pattern->row[i + 1]; s++) {
      const PetscInt col = pattern->col[s];
      const PetscInt k   = col >= start && col < start + cols ? 0 : 1;

      split->col[k][n[k]]     = k == 0 ? col - start : col;
      split->value[k][n[k]++] = values[s];
    }
    for (PetscInt k = 0; k < 2; k++) split->row[k][i + 1] = n[k];
  }
  PetscCall(MatCreateMPIAIJWithSplitArrays(comm, rows, cols, PETSC_DETERMINE, PETSC_DETERMINE,
                                           split->row[0], split->col[0], split->value[0],
                                           split->row[1], split->col[1], split->value[1], A));
  PetscCall(PetscContainerCreate(PETSC_COMM_SELF, &container));
  PetscCall(PetscContainerSetPointer(container, split));
  PetscCall(PetscContainerSetUserDestroy(container, SplitRowsDestroy));
  PetscCall(PetscObjectCompose((PetscObject)*A, "rows", (PetscObject)container));
  PetscCall(PetscContainerDestroy(&container));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  PatternMat - Creates a matrix on the pattern

  Collective on comm.

  Input Parameters:
+ rows, cols - local sizes
- values     - in the order of the pattern; on a single rank the matrix uses this array

  Output Parameter:
. A - MATSEQAIJ on a single rank, otherwise MATMPIAIJ
*/
PetscErrorCode PatternMat(MPI_Comm comm, const Pattern *pattern, PetscInt rows, PetscInt cols,
                          PetscReal values[], Mat *A)
{
  PetscMPIInt size;
  PetscInt    start = 0;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(comm, &size));
  if (size == 1) {
    PetscCall(MatCreateSeqAIJWithArrays(comm, rows, cols, pattern->row, pattern->col, values, A));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCallMPI(MPI_Scan(&cols, &start, 1, MPIU_INT, MPI_SUM, comm));
  PetscCall(SplitMat(comm, pattern, rows, cols, start - cols, values, A));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  PatternMatSet - Sets the values of a MATSEQAIJ or MATMPIAIJ of PatternMat()

  Collective. Input: values - in the order of the pattern.
*/
PetscErrorCode PatternMatSet(const Pattern *pattern, const PetscReal values[], Mat A)
{
  PetscBool    parallel;
  PetscInt     start = 0, end = 0, n[2] = {0, 0};
  PetscScalar *to[2];
  Mat          part[2] = {A, NULL};

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)A, MATMPIAIJ, &parallel));
  if (!parallel) {
    PetscCall(MatSeqAIJGetArrayWrite(A, &to[0]));
    if (to[0] != values) PetscCall(PetscArraycpy(to[0], values, pattern->row[pattern->n]));
    PetscCall(MatSeqAIJRestoreArrayWrite(A, &to[0]));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MatMPIAIJGetSeqAIJ(A, &part[0], &part[1], NULL));
  PetscCall(MatGetOwnershipRangeColumn(A, &start, &end));
  for (PetscInt k = 0; k < 2; k++) PetscCall(MatSeqAIJGetArrayWrite(part[k], &to[k]));
  for (PetscInt s = 0; s < pattern->row[pattern->n]; s++) {
    const PetscInt k = pattern->col[s] >= start && pattern->col[s] < end ? 0 : 1;

    to[k][n[k]++] = values[s];
  }
  for (PetscInt k = 0; k < 2; k++) PetscCall(MatSeqAIJRestoreArrayWrite(part[k], &to[k]));
  PetscCall(MatAssemblyBegin(A, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(A, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PatternFree(Pattern *pattern)
{
  PetscFunctionBegin;
  PetscCall(PetscFree3(pattern->row, pattern->col, pattern->local));
  pattern->n = pattern->capacity = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}
