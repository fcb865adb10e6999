/*
  The sparsity pattern that all operators share, and the matrices on it. All operators have the same
  neighbours. So the columns of a row are sorted once, and every operator writes its values to the
  same slots: positions in the arrays of values.
*/
#include "isph/operators.h"

/*
  PatternBegin - Empties a pattern and allocates room for rows

  Not collective. Input: has_columns - the global columns are kept; rows - number of own rows;
  entries - an upper bound of the number of all entries.
*/
PetscErrorCode PatternBegin(Pattern *pattern, PetscBool has_columns, PetscInt rows,
                            PetscInt entries)
{
  PetscFunctionBegin;
  if (rows > pattern->n || !pattern->row || entries > pattern->capacity) {
    const PetscInt more     = pattern->row ? entries / 8 + 16 : 0; /* fixed particles come once */
    const PetscInt capacity = PetscMax(pattern->capacity, entries + more);

    PetscCall(PatternFree(pattern));
    PetscCall(PetscMalloc1(rows + 1, &pattern->row));
    PetscCall(PetscMalloc1(capacity, &pattern->local));
    if (has_columns) PetscCall(PetscMalloc1(capacity, &pattern->col));
    pattern->capacity = capacity;
  }
  pattern->n      = rows;
  pattern->row[0] = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sorts columns in ascending order without repetition: the slots of the columns given, and the
   number of different ones. Insertion sort: the columns are nearly in order. */
static PetscInt SortColumns(PetscInt n, const PetscInt cols[], PetscInt sorted[], PetscInt slot[])
{
  PetscInt length = 0;

  for (PetscInt k = 0; k < n; k++) {
    PetscInt q = k;

    for (; q > 0 && sorted[q - 1] > cols[k]; q--) sorted[q] = sorted[q - 1];
    sorted[q] = cols[k];
  }
  for (PetscInt k = 0; k < n; k++)
    if (length == 0 || sorted[k] != sorted[length - 1]) sorted[length++] = sorted[k];
  for (PetscInt k = 0; k < n; k++) {
    PetscInt low = 0, high = length - 1;

    while (low < high) {
      const PetscInt middle = (low + high) / 2;

      if (sorted[middle] < cols[k]) low = middle + 1;
      else high = middle;
    }
    slot[k] = low;
  }
  return length;
}

/*
  PatternRow - Adds row i; to be called for i = 0, 1, 2, ...

  Not collective. A repeated column (a particle and its periodic image) becomes a single entry.

  Input Parameters:
+ cols  - global columns in any order
. local - local indices of their particles
- n     - number of columns

  Output Parameter:
. slot - position of the entry of cols[k] in the arrays of values

  Returns: true if the slots of cols[0], cols[1], ... follow each other
*/
PetscBool PatternRow(Pattern *pattern, PetscInt i, const PetscInt cols[], const PetscInt local[],
                     PetscInt n, PetscInt slot[])
{
  const PetscInt first     = pattern->row[i];
  PetscInt       length    = n;
  PetscBool      ascending = PETSC_TRUE;

  for (PetscInt k = 0; k < n; k++) {
    if (k && cols[k] <= cols[k - 1]) ascending = PETSC_FALSE;
    slot[k] = k;
  }
  if (!ascending) length = SortColumns(n, cols, pattern->local + first, slot);
  for (PetscInt k = 0; k < n; k++) slot[k] += first;
  for (PetscInt k = 0; k < n; k++) pattern->local[slot[k]] = local[k];
  for (PetscInt k = 0; pattern->col && k < n; k++) pattern->col[slot[k]] = cols[k];
  pattern->row[i + 1] = first + length;
  return ascending;
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

/* Returns true if all columns of row i are own ones, from `start` to before `end`: so are those of
   most rows, and columns ascend. */
static inline PetscBool RowIsOwn(const Pattern *pattern, PetscInt i, PetscInt start, PetscInt end)
{
  const PetscInt first = pattern->row[i], last = pattern->row[i + 1] - 1;

  return first > last || (pattern->col[first] >= start && pattern->col[last] < end) ? PETSC_TRUE
                                                                                    : PETSC_FALSE;
}

/* Creates a MATMPIAIJ from rows that are split beforehand, which needs no copies. Own columns begin
   with the global number `start`. */
static PetscErrorCode SplitMat(MPI_Comm comm, const Pattern *pattern, PetscInt rows, PetscInt cols,
                               PetscInt start, const PetscReal values[], Mat *A)
{
  const PetscInt entries = pattern->row[rows];
  PetscInt       own     = 0, n[2];
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
  PetscCall(MatSetOption(*A, MAT_NO_OFF_PROC_ENTRIES, PETSC_TRUE));
  PetscCall(MatKeep(*A, "rows", split, SplitRowsDestroy));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the values of a MATMPIAIJ of PatternMat(), whose rows over own columns and over columns of
   other ranks are apart. */
static PetscErrorCode SplitMatSet(const Pattern *pattern, const PetscReal values[], Mat A)
{
  PetscInt     start, end, n[2] = {0, 0};
  PetscScalar *to[2];
  Mat          part[2];

  PetscFunctionBegin;
  PetscCall(MatMPIAIJGetSeqAIJ(A, &part[0], &part[1], NULL));
  PetscCall(MatGetOwnershipRangeColumn(A, &start, &end));
  for (PetscInt k = 0; k < 2; k++) PetscCall(MatSeqAIJGetArrayWrite(part[k], &to[k]));
  for (PetscInt i = 0; i < pattern->n; i++) {
    const PetscInt length = pattern->row[i + 1] - pattern->row[i];

    if (RowIsOwn(pattern, i, start, end)) {
      PetscCall(PetscArraycpy(to[0] + n[0], values + pattern->row[i], length));
      n[0] += length;
      continue;
    }
    for (PetscInt s = pattern->row[i]; s < pattern->row[i + 1]; s++) {
      const PetscInt k = pattern->col[s] >= start && pattern->col[s] < end ? 0 : 1;

      to[k][n[k]++] = values[s];
    }
  }
  for (PetscInt k = 0; k < 2; k++) PetscCall(MatSeqAIJRestoreArrayWrite(part[k], &to[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  PatternMat - Creates a matrix on the pattern

  Collective on comm.

  Input Parameters:
+ rows, cols - local sizes
. values     - in the order of the pattern; on a single rank the matrix uses this array
- like       - matrix of this function with the same pattern; NULL: none

  Output Parameter:
. A - MATSEQAIJ on a single rank, otherwise MATMPIAIJ, which shares columns and scatter with `like`:
      a scatter of its own would take eight more collective calls
*/
PetscErrorCode PatternMat(MPI_Comm comm, const Pattern *pattern, PetscInt rows, PetscInt cols,
                          PetscReal values[], Mat like, Mat *A)
{
  PetscMPIInt size;
  PetscInt    start = 0;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(comm, &size));
  if (size == 1) {
    PetscCall(MatCreateSeqAIJWithArrays(comm, rows, cols, pattern->row, pattern->col, values, A));
  } else if (like) {
    PetscCall(MatDuplicate(like, MAT_SHARE_NONZERO_PATTERN, A));
    PetscCall(PetscObjectCompose((PetscObject)*A, "like", (PetscObject)like)); /* its columns */
    PetscCall(SplitMatSet(pattern, values, *A));
  } else {
    PetscCallMPI(MPI_Scan(&cols, &start, 1, MPIU_INT, MPI_SUM, comm));
    PetscCall(SplitMat(comm, pattern, rows, cols, start - cols, values, A));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* PatternMatSet - Sets the values of a matrix of PatternMat(); on a single rank `values` is the
   array of the matrix; collective */
PetscErrorCode PatternMatSet(const Pattern *pattern, const PetscReal values[], Mat A)
{
  PetscBool parallel;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)A, MATMPIAIJ, &parallel));
  if (parallel) PetscCall(SplitMatSet(pattern, values, A));
  PetscCall(MatAssemblyBegin(A, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(A, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PatternFree(Pattern *pattern)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(pattern->row));
  PetscCall(PetscFree(pattern->col));
  PetscCall(PetscFree(pattern->local));
  pattern->n = pattern->capacity = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}
