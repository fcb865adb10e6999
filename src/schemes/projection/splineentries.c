/* Growing lists of the entries of matrices, whose storage serves many assemblies. */
#include "splines.h"

/* SplineEntriesBegin - Empties a list, which will have at most `rows` rows; not collective */
PetscErrorCode SplineEntriesBegin(PetscInt rows, SplineEntries *e)
{
  PetscInt  *col;
  PetscReal *value;

  PetscFunctionBegin;
  if (rows + 1 > e->rows_capacity) {
    e->rows_capacity = rows + 1;
    PetscCall(PetscFree(e->row));
    PetscCall(PetscMalloc1(e->rows_capacity, &e->row));
  }
  e->n = e->rows = e->row[0] = 0;
  PetscCall(SplineEntriesReserve(1, e, &col, &value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineEntriesReserve - Makes room for a row of n entries, which the caller fills; not
   collective */
PetscErrorCode SplineEntriesReserve(PetscInt n, SplineEntries *e, PetscInt **col, PetscReal **value)
{
  PetscFunctionBegin;
  if (e->n + n > e->capacity) {
    e->capacity = 2 * (e->n + n) + 1024;
    PetscCall(PetscRealloc(sizeof(*e->col) * (size_t)e->capacity, &e->col));
    PetscCall(PetscRealloc(sizeof(*e->value) * (size_t)e->capacity, &e->value));
  }
  *col   = &e->col[e->n];
  *value = &e->value[e->n];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineEntriesAddRow - Adds the row of n entries in the room of SplineEntriesReserve(): sorts its
   columns, and adds up entries of the same column; not collective */
void SplineEntriesAddRow(PetscInt n, SplineEntries *e)
{
  PetscInt  *col = &e->col[e->n], last = 0;
  PetscReal *value = &e->value[e->n];

  for (PetscInt k = 1; k < n; k++) { /* insertion: the columns are nearly in order */
    const PetscInt  moved = col[k];
    const PetscReal entry = value[k];
    PetscInt        q     = k;

    if (moved > col[k - 1]) continue;
    for (; q > 0 && col[q - 1] > moved; q--) {
      col[q]   = col[q - 1];
      value[q] = value[q - 1];
    }
    col[q]   = moved;
    value[q] = entry;
  }
  for (PetscInt k = 1; k < n; k++) {
    if (col[k] == col[last]) {
      value[last] += value[k];
    } else {
      col[++last] = col[k];
      value[last] = value[k];
    }
  }
  if (n) e->n += last + 1;
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
