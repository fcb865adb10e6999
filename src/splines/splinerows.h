/* Rows of a matrix that repeat and are stored once, with columns relative to their own numbers. */
#ifndef ISPH_SPLINEROWS_H
#define ISPH_SPLINEROWS_H

#include "splines.h"

/* Rows that repeat. */
typedef struct {
  PetscInt   n, *of;                   /* rows; the stored row of each */
  PetscInt  *base;                     /* columns of each are relative to it; NULL: its number */
  PetscInt   each;                     /* values of an entry */
  PetscInt   most;                     /* stored rows that the table can hold */
  PetscInt   stored, row_room, *first; /* first entry of each stored row, and the end of the last */
  PetscInt   capacity, *offset;        /* column of each entry, less the base */
  PetscReal *value;
  PetscInt   size, *table; /* a power of 2; stored row at each place, -1: none */
} SplineRows;

/* A row in the making. */
typedef struct {
  PetscInt  *place; /* of each column among the entries, -1: none */
  PetscInt   n, capacity, each, *column;
  PetscReal *value;
} SplineEntries;

PetscErrorCode SplineRowsCreate(PetscInt n, PetscInt each, SplineRows **rows);
PetscErrorCode SplineRowsDestroy(SplineRows **rows);
PetscErrorCode SplineRowsStore(const SplineEntries *row, PetscInt head, PetscInt k, SplineRows *r);
PetscErrorCode SplineRowsShell(MPI_Comm comm, SplineRows *rows, Mat *A);
PetscInt       SplineRowsPlace(PetscInt n, const PetscInt number[], const SplineRows *r);
PetscErrorCode SplineEntriesAdd(PetscInt column, const PetscReal value[], SplineEntries *row);
void           SplineEntriesClear(SplineEntries *row);

/* splinerepeats.c */
PetscErrorCode SplineRowsCompute(const Splines *s, const Particles *p, SplineRows **rows);

#endif
