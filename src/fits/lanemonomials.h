/* Monomials of four points or neighbours at once, one in each lane of a vector. */
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

#endif
