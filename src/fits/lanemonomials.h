/* Monomials of four points or neighbours at once, and factors of four matrices, one in each lane of
   a vector. */
#ifndef ISPH_FOUR_H
#define ISPH_FOUR_H

#include "mls.h"

/* Computes the monomials of degree 2 to `degree` of the offsets s, times a factor, in the order of
   MlsBasis(). Input/Output: phi - in: the factor times s; out: all monomials. */
static ISPH_INLINE void FourMonomials(PetscInt dim, PetscInt degree, const Four s[], Four phi[])
{
  PetscInt lower = 0, t = dim;

#pragma GCC unroll 8
  for (PetscInt d = 2; d <= degree; d++) {
#pragma GCC unroll 3
    for (PetscInt a = 0; a < dim; a++) {
#pragma GCC unroll 16
      for (PetscInt q = 0; q < MlsMonomials(a, d - 1); q++) phi[t++] = s[a] * phi[lower + q];
    }
    lower += MlsMonomials(dim - 1, d - 1);
  }
}

/* Computes the factors L D L^T of matrices, stored by rows up to the diagonal, and the inverse
   pivots. Output: least - the least pivot over its diagonal entry, for each lane. */
static ISPH_INLINE void FourFactor(PetscInt terms, Four M[], Four inverse[], Four *least)
{
  *least = (Four){1.0, 1.0, 1.0, 1.0};
  for (PetscInt j = 0; j < terms; j++) {
    Four *row = &M[j * (j + 1) / 2], pivot = row[j], share;

    for (PetscInt k = 1; k < j; k++) { /* row j of L D, from the left */
      const Four *above = &M[k * (k + 1) / 2];

      for (PetscInt q = 0; q < k; q++) row[k] -= row[q] * above[q];
    }
    for (PetscInt k = 0; k < j; k++) {
      const Four factor = row[k] * inverse[k];

      pivot -= factor * row[k];
      row[k] = factor;
    }
    share = pivot / row[j];
    for (PetscInt i = 0; i < 4; i++) /* keeps NaN */
      (*least)[i] = share[i] < (*least)[i] || share[i] != share[i] ? share[i] : (*least)[i];
    inverse[j] = 1.0 / pivot;
  }
}

#endif
