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
*/
void PatternRow(Pattern *pattern, PetscInt i, const PetscInt cols[], const PetscInt local[],
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
  if (ascending) return;
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

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(comm, &size));
  if (size == 1) {
    PetscCall(MatCreateSeqAIJWithArrays(comm, rows, cols, pattern->row, pattern->col, values, A));
  } else {
    PetscCall(MatCreateMPIAIJWithArrays(comm, rows, cols, PETSC_DETERMINE, PETSC_DETERMINE,
                                        pattern->row, pattern->col, values, A));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PatternFree(Pattern *pattern)
{
  PetscFunctionBegin;
  PetscCall(PetscFree3(pattern->row, pattern->col, pattern->local));
  pattern->n = pattern->capacity = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}
