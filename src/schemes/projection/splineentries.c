/* Growing lists of the entries of matrices, whose storage serves many assemblies. */
#include "splines.h"

/* SplineEntriesBegin - Empties a list, which will have at most `rows` rows; not collective */
PetscErrorCode SplineEntriesBegin(PetscInt rows, SplineEntries *e)
{
  PetscFunctionBegin;
  if (rows + 1 > e->rows_capacity) {
    e->rows_capacity = rows + 1;
    PetscCall(PetscFree(e->row));
    PetscCall(PetscMalloc1(e->rows_capacity, &e->row));
  }
  e->n = e->rows = e->row[0] = 0;
  PetscCall(SplineEntriesReserve(1, e));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineEntriesReserve - Makes room for n more entries; not collective */
PetscErrorCode SplineEntriesReserve(PetscInt n, SplineEntries *e)
{
  PetscFunctionBegin;
  if (e->n + n <= e->capacity) PetscFunctionReturn(PETSC_SUCCESS);
  e->capacity = 2 * (e->n + n) + 1024;
  PetscCall(PetscRealloc(sizeof(*e->col) * (size_t)e->capacity, &e->col));
  PetscCall(PetscRealloc(sizeof(*e->value) * (size_t)e->capacity, &e->value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineEntriesEnd - Ends a row: sorts its columns and adds entries of the same column; not
   collective */
void SplineEntriesEnd(SplineEntries *e)
{
  const PetscInt first = e->row[e->rows];
  PetscInt       last  = first;

  for (PetscInt k = first + 1; k < e->n; k++) { /* insertion: the columns are nearly in order */
    const PetscInt  col   = e->col[k];
    const PetscReal value = e->value[k];
    PetscInt        q     = k;

    for (; q > first && e->col[q - 1] > col; q--) {
      e->col[q]   = e->col[q - 1];
      e->value[q] = e->value[q - 1];
    }
    e->col[q]   = col;
    e->value[q] = value;
  }
  for (PetscInt k = first + 1; k < e->n; k++) {
    if (e->col[k] == e->col[last]) {
      e->value[last] += e->value[k];
    } else {
      e->col[++last] = e->col[k];
      e->value[last] = e->value[k];
    }
  }
  if (e->n > first) e->n = last + 1;
  e->row[++e->rows] = e->n;
}

/* SplineEntriesMat - Makes the matrix of a list; on a single rank it uses the list's storage;
   collective */
PetscErrorCode SplineEntriesMat(MPI_Comm comm, const SplineEntries *e, PetscInt cols, Mat *A)
{
  const Pattern pattern = {.row = e->row, .col = e->col, .n = e->rows};

  PetscFunctionBegin;
  PetscCall(PatternMat(comm, &pattern, e->rows, cols, e->value, A));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineEntriesFree - Frees a list; not collective */
PetscErrorCode SplineEntriesFree(SplineEntries *e)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(e->col));
  PetscCall(PetscFree(e->value));
  PetscCall(PetscFree(e->row));
  PetscCall(PetscMemzero(e, sizeof(*e)));
  PetscFunctionReturn(PETSC_SUCCESS);
}
