/* Row functions of the tables in laplacians.c and gradients.c that other files define, and
   functions that they share. */
#ifndef ISPH_ROWS_ROWS_H
#define ISPH_ROWS_ROWS_H

#include "isph/rows.h"

PetscErrorCode LaplacianRow_StressMls(Stencil *stencil, PetscReal w[]);
PetscErrorCode LaplacianRow_PairwiseStress(Stencil *stencil, PetscReal w[]);
PetscReal      Factor_PairwiseStress(const Stencil *stencil);
PetscErrorCode LaplacianRow_Violeau(Stencil *stencil, PetscReal w[]);
PetscErrorCode LaplacianRow_Cleary(Stencil *stencil, PetscReal w[]);
PetscErrorCode LaplacianRow_Direct(Stencil *stencil, PetscReal w[]);
PetscErrorCode LaplacianRow_DirectDifference(Stencil *stencil, PetscReal w[]);
void           CorrectKernel_FirstOrder(Stencil *stencil, PetscReal dW[], PetscReal ddW[]);
PetscErrorCode FormDescribe(unsigned properties, char text[], size_t length);

/* Computes the corrected kernel gradient M^-1 grad_i W of neighbour k; `inverse` holds M^-1,
   M = sum_k V_k (grad_i W) X^T. */
static inline void CorrectedKernelGradient(const Stencil *st, const PetscReal inverse[], PetscInt k,
                                           PetscReal gradient[])
{
  for (PetscInt a = 0; a < st->dim; a++) {
    gradient[a] = 0.0;
    for (PetscInt b = 0; b < st->dim; b++) {
      gradient[a] -= inverse[a * st->dim + b] * st->X[b][k] * st->dW[k] / st->r[k];
    }
  }
}

#endif
