/* Vectors of four numbers, one of each of four points or neighbours, and their monomials. */
#ifndef ISPH_FOUR_H
#define ISPH_FOUR_H

#include "mls.h"

/* Unaligned, as PETSc allocates memory. */
typedef PetscReal Four
    __attribute__((vector_size(4 * sizeof(PetscReal)), aligned(sizeof(PetscReal)), may_alias));

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

/* Returns the sum of the four numbers. */
static ISPH_INLINE PetscReal FourSum(const Four *v)
{
  return ((*v)[0] + (*v)[1]) + ((*v)[2] + (*v)[3]);
}

#endif
