/*
  Sparse matrices from rows with ascending columns. PETSc inserts the entries of such rows one by
  one, which takes longer than the computation of most of them.
*/
#ifndef ISPH_SPARSE_H
#define ISPH_SPARSE_H

#include "isph/base.h"
#include <petscmat.h>

/* Own rows of a matrix, compressed; columns are global and ascend. */
typedef struct {
  PetscInt     n, *row, *col;
  PetscScalar *value;
} SparseRows;

PetscErrorCode MatKeep(Mat A, const char name[], void *data, PetscErrorCode (*Destroy)(void *));
PetscErrorCode SparseRowsMalloc(PetscInt n, PetscInt entries, SparseRows *rows);
PetscErrorCode SparseRowsMat(MPI_Comm comm, SparseRows *rows, PetscInt cols, Mat *A);
PetscErrorCode SparseAdd(Mat X, Mat *Y);

#endif
