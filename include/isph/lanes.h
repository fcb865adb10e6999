/*
  Sums over arrays in a fixed number of partial sums, so that processors with vectors of any length
  add in the same order. Arrays over neighbours end in zeros up to a multiple of this number, and
  loops over them need no remainder.
*/
#ifndef ISPH_LANES_H
#define ISPH_LANES_H

#include "isph/base.h"

#define ISPH_LANES 8

/* Rounds a length up to a multiple of ISPH_LANES. */
static ISPH_INLINE PetscInt LanesPadded(PetscInt n)
{
  return (n + ISPH_LANES - 1) / ISPH_LANES * ISPH_LANES;
}

/* Adds the partial sums; changes them. */
static ISPH_INLINE PetscReal LanesTotal(PetscReal lane[])
{
  for (PetscInt half = ISPH_LANES / 2; half > 0; half /= 2) {
    for (PetscInt l = 0; l < half; l++) lane[l] += lane[l + half];
  }
  return lane[0];
}

/* Computes sum_k a_k b_k; n is a multiple of ISPH_LANES. */
static ISPH_INLINE PetscReal LanesSum(PetscInt n, const PetscReal a[], const PetscReal b[])
{
  PetscReal lane[ISPH_LANES] = {0.0};

  for (PetscInt k = 0; k < n; k += ISPH_LANES) {
    for (PetscInt l = 0; l < ISPH_LANES; l++) lane[l] += a[k + l] * b[k + l];
  }
  return LanesTotal(lane);
}

/* Vector of four numbers, one of each of four points or neighbours. Unaligned, as PETSc allocates
   memory. */
typedef PetscReal Four
    __attribute__((vector_size(4 * sizeof(PetscReal)), aligned(sizeof(PetscReal)), may_alias));

/* Returns the sum of the four numbers. */
static ISPH_INLINE PetscReal FourSum(const Four *v)
{
  return ((*v)[0] + (*v)[1]) + ((*v)[2] + (*v)[3]);
}

/* Returns four numbers of an array, from the first. */
static ISPH_INLINE const Four *FourAt(const PetscReal *first)
{
  return (const Four *)(const void *)first;
}

#endif
