/* Basis of moving least-squares fits, shared by fits of scalars and of vectors. */
#ifndef ISPH_MLS_H
#define ISPH_MLS_H

#include "rows.h"

static inline PetscInt MlsTerms(PetscInt dim, PetscInt degree)
{
  const PetscInt quadratic = dim + dim * (dim + 1) / 2;

  return degree == 2 ? quadratic : quadratic + dim * (dim + 1) * (dim + 2) / 6;
}

/* Computes the basis at neighbour k with s = X/R: s_a, then s_a s_b (b <= a), then s_a s_b s_c
   (c <= b <= a). */
static inline void MlsBasis(const Stencil *st, PetscInt dim, PetscInt degree, PetscInt k,
                            PetscReal phi[])
{
  PetscReal s[ISPH_MAX_DIM];
  PetscInt  t = dim;

  for (PetscInt a = 0; a < dim; a++) phi[a] = s[a] = st->X[a][k] / st->radius;
  for (PetscInt a = 0; a < dim; a++) {
    for (PetscInt b = 0; b <= a; b++) phi[t++] = s[a] * s[b];
  }
  for (PetscInt a = 0; degree > 2 && a < dim; a++) {
    for (PetscInt b = 0; b <= a; b++) {
      for (PetscInt c = 0; c <= b; c++) phi[t++] = s[a] * s[b] * s[c];
    }
  }
}

void MlsFactorOrRidge(PetscInt n, PetscReal moments[], const PetscReal copy[],
                      PetscInt *regularised);

#endif
