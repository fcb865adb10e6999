/* The sparsity pattern that all operators share, and the matrices on it. All operators have the
   same neighbours. So the columns of a row are sorted once, and every operator writes its values to
   the same slots: positions in the arrays of values. */
#include "isph/operators.h"

/* PatternBegin - Empties a pattern and allocates room for rows. Input: has_columns - the global
   columns are kept; rows - number of own rows; entries - an upper bound of the number of all
   entries. */
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

/* PatternRow - Adds row i; to be called for i = 0, 1, 2, ... A repeated column (a particle and its
   periodic image) becomes a single entry. Input: cols - global columns in any order; local - local
   indices of their particles; n - number of columns. Output: slot - position of the entry of
   cols[k] in the arrays of values. Returns: true if the slots of cols[0], cols[1], ... follow each
   other. */
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

/* Returns true if all columns of row i are own ones, from `start` to before `end`: so are those of
   most rows, and columns ascend. */
static inline PetscBool RowIsOwn(const Pattern *pattern, PetscInt i, PetscInt start, PetscInt end)
{
  const PetscInt first = pattern->row[i], last = pattern->row[i + 1] - 1;

  return first > last || (pattern->col[first] >= start && pattern->col[last] < end);
}

/* Creates a MATMPIAIJ from rows that are split beforehand, which needs no copies. Own columns begin
   with the global number `start`. */
static PetscErrorCode SplitMat(MPI_Comm comm, const Pattern *pattern, PetscInt rows, PetscInt cols,
                               PetscInt start, const PetscReal values[], Mat *A)
{
  const PetscInt entries = pattern->row[rows];
  PetscInt       own     = 0, n[2];
  SparseRows     part[2]; /* over own columns, and over columns of other ranks */

  PetscFunctionBegin;
  for (PetscInt s = 0; s < entries; s++)
    own += pattern->col[s] >= start && pattern->col[s] < start + cols ? 1 : 0;
  n[0] = own;
  n[1] = entries - own;
  for (PetscInt k = 0; k < 2; k++) {
    PetscCall(SparseRowsMalloc(rows, n[k], &part[k]));
    n[k] = 0;
  }
  for (PetscInt i = 0; i < rows; i++) {
    for (PetscInt s = pattern->row[i]; s < pattern->row[i + 1]; s++) {
      const PetscInt col = pattern->col[s];
      const PetscInt k   = col >= start && col < start + cols ? 0 : 1;

      part[k].col[n[k]]     = k == 0 ? col - start : col;
      part[k].value[n[k]++] = values[s];
    }
    for (PetscInt k = 0; k < 2; k++) part[k].row[i + 1] = n[k];
  }
  PetscCall(MatCreateMPIAIJWithSplitArrays(comm, rows, cols, PETSC_DETERMINE, PETSC_DETERMINE,
                                           part[0].row, part[0].col, part[0].value, part[1].row,
                                           part[1].col, part[1].value, A));
  PetscCall(MatSetOption(*A, MAT_NO_OFF_PROC_ENTRIES, PETSC_TRUE));
  PetscCall(SparseRowsKeep(&part[0], "rows", *A));
  PetscCall(SparseRowsKeep(&part[1], "other_rows", *A));
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

/* PatternMat - Creates a matrix on the pattern. Collective on comm. Input: rows, cols - local
   sizes; values - in the order of the pattern; on a single rank the matrix uses this array; like -
   matrix of this function with the same pattern; NULL: none. Output: A - MATSEQAIJ on a single
   rank, otherwise MATMPIAIJ, which shares columns and scatter with `like`: a scatter of its own
   would take eight more collective calls. */
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

/* PatternMatSet - Sets the values of a matrix of PatternMat() to those of its rows, which it keeps
   as MAT_VALUES. Collective. On a single rank they are the array of the matrix. */
PetscErrorCode PatternMatSet(const SparseRows *rows, Mat A)
{
  const Pattern pattern = {.row = rows->row, .col = rows->col, .n = rows->n};
  PetscBool     parallel;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)A, MATMPIAIJ, &parallel));
  if (parallel) PetscCall(SplitMatSet(&pattern, rows->value, A));
  PetscCall(MatAssemblyBegin(A, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(A, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* PatternBlocks - Creates a matrix of dim x dim blocks on a pattern, with zeros. Collective.
   Component b of particle j is unknown number dim j + b. The entries of a slot in each of the dim
   rows of a particle follow each other, and columns ascend. Input: entries - of a slot in a row:
   dim, or 1 if blocks are diagonal; columns - number of own particles that the columns stand
   for. */
PetscErrorCode PatternBlocks(const Particles *p, PetscInt entries, const Pattern *pattern,
                             PetscInt columns, Mat *A)
{
  const PetscInt d = p->dim, n = d * entries * pattern->row[p->n_fluid];
  SparseRows     to;
  Pattern        blocks;
  PetscInt       q = 0;

  PetscFunctionBegin;
  PetscCall(SparseRowsMalloc(d * p->n_fluid, n, &to));
  PetscCall(PetscArrayzero(to.value, n));
  for (PetscInt r = 0; r < to.n; r++) {
    const PetscInt i = r / d, first = entries == 1 ? r % d : 0;

    for (PetscInt s = pattern->row[i]; s < pattern->row[i + 1]; s++)
      for (PetscInt b = 0; b < entries; b++) to.col[q++] = d * pattern->col[s] + first + b;
    to.row[r + 1] = q;
  }
  blocks = (Pattern){.row = to.row, .col = to.col, .n = to.n};
  PetscCall(PatternMat(p->comm, &blocks, to.n, d * columns, to.value, NULL, A));
  PetscCall(MatSetBlockSizes(*A, d, d));
  PetscCall(SparseRowsKeep(&to, MAT_VALUES, *A));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PatternFree(Pattern *pattern)
{
  PetscFunctionBegin;
  PetscCall(FreeAll(&pattern->row, &pattern->col, &pattern->local));
  pattern->n = pattern->capacity = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}
