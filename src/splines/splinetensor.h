/* The stiffness of the splines of a box in the basis that makes it diagonal. */
#ifndef ISPH_SPLINETENSOR_H
#define ISPH_SPLINETENSOR_H

#include "splines.h"

/* A matrix of an axis, in both orders: row by row and column by column. */
typedef struct {
  PetscInt   n;
  PetscReal *V, *transposed; /* columns of V: eigenvectors, V^T M V = I */
  PetscReal *lambda;         /* their eigenvalues, scale^2 L [-] */
} SplineAxis;

typedef struct {
  PetscInt   dim;
  SplineAxis axis[ISPH_MAX_DIM];
} SplineTensor;

/* splineeigen.c */
PetscErrorCode SplineEigen(PetscInt n, PetscReal K[], PetscReal M[], PetscReal lambda[],
                           PetscReal V[]);

/* splinetensor.c */
PetscErrorCode SplineTensorSet(const SplineLattice *lattice, PetscReal scale, SplineTensor *t);
PetscErrorCode SplineTensorFree(SplineTensor *t);
void SplineTensorAlong(const SplineTensor *t, const PetscInt n[], PetscInt a, PetscBool back,
                       const PetscReal from[], PetscReal to[]);
void SplineTensorDivide(const SplineTensor *t, const PetscInt first[], const PetscInt n[],
                        PetscReal value[]);

#endif
