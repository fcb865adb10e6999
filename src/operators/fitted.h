/* Rows that products make from fits. */
#ifndef ISPH_FITTED_H
#define ISPH_FITTED_H

#include "isph/operators.h"

/* Products of the rows of n operators with each of 1 or dim fields. */
typedef struct {
  PetscInt              fields, n;
  const AffineOperator *op[ISPH_MAX_DIM][AFFINE_MOST]; /* at [field][operator] */
  PetscScalar          *y[ISPH_MAX_DIM][AFFINE_MOST];
  PetscBool             add; /* y is increased */
} FittedProducts;

PetscErrorCode FittedCreate(const OperatorForms *forms, PetscInt dim, PetscBool filters,
                            FittedRows **rows);
PetscErrorCode FittedDestroy(FittedRows **rows);
PetscErrorCode FittedReserve(const Particles *particles, PetscInt longest, FittedRows *rows);
void           FittedPlace(const FittedRows *rows, Stencil *stencil);
PetscErrorCode FittedApply(const FittedProducts *products, const OperatorRows *rows);

#endif
