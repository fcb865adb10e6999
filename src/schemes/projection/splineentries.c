/* Growing lists of the entries of matrices. */
#include "splines.h"

/* SplineEntriesAdd - Adds an entry to the last row; not collective */
PetscErrorCode SplineEntriesAdd(PetscInt col, PetscReal value, SplineEntries *e)
{
  PetscFunctionBegin;
  if (e->n == e->capacity) {
    e->capacity = 2 * e->capacity + 1024;
    PetscCall(PetscRealloc(sizeof(*e->col) * (size_t)e->capacity, &e->col));
    PetscCall(PetscRealloc(sizeof(*e->value) * (size_t)e->capacity, &e->value));
  }
  e->col[e->n]     = col;
  e->value[e->n++] = value;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineEntriesMat - Makes the matrix of a list of entries, whose pattern and values stay with the
   caller; collective */
PetscErrorCode SplineEntriesMat(MPI_Comm comm, const SplineEntries *e, PetscInt cols,
                                Pattern *pattern, PetscReal **values, Mat *A)
{
  const PetscInt rows = e->rows;
  PetscInt      *slot, longest = 1;

  PetscFunctionBegin;
  PetscCall(MatDestroy(A));
  PetscCall(PatternBegin(pattern, rows, e->n));
  PetscCall(PetscFree(*values));
  PetscCall(PetscCalloc1(e->n, values));
  for (PetscInt i = 0; i < rows; i++) longest = PetscMax(longest, e->row[i + 1] - e->row[i]);
  PetscCall(PetscMalloc1(longest, &slot));
  for (PetscInt i = 0; i < rows; i++) {
    const PetscInt n = e->row[i + 1] - e->row[i];

    PatternRow(pattern, i, &e->col[e->row[i]], n, slot);
    for (PetscInt k = 0; k < n; k++) (*values)[slot[k]] += e->value[e->row[i] + k];
  }
  PetscCall(PetscFree(slot));
  PetscCall(PatternMat(comm, pattern, rows, cols, *values, A));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineEntriesFree - Frees a list; not collective */
PetscErrorCode SplineEntriesFree(SplineEntries *e)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(e->col));
  PetscCall(PetscFree(e->value));
  PetscCall(PetscFree(e->row));
  PetscFunctionReturn(PETSC_SUCCESS);
}
