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

/* Computes n.grad of the basis at wall neighbour k, times the length st->scale. */
static inline void MlsBasisNormalDerivative(const Stencil *st, PetscInt dim, PetscInt degree,
                                            PetscInt k, PetscReal phi[])
{
  PetscReal s[ISPH_MAX_DIM], n[ISPH_MAX_DIM];
  PetscInt  t = dim;

  for (PetscInt a = 0; a < dim; a++) {
    s[a]   = st->X[a][k] / st->radius;
    phi[a] = n[a] = st->normal[a][k] * st->scale / st->radius;
  }
  for (PetscInt a = 0; a < dim; a++) {
    for (PetscInt b = 0; b <= a; b++) phi[t++] = n[a] * s[b] + s[a] * n[b];
  }
  for (PetscInt a = 0; degree > 2 && a < dim; a++) {
    for (PetscInt b = 0; b <= a; b++) {
      for (PetscInt c = 0; c <= b; c++)
        phi[t++] = n[a] * s[b] * s[c] + s[a] * n[b] * s[c] + s[a] * s[b] * n[c];
    }
  }
}

/* Computes phi in the equation sum_t c_t phi_t = scale times data of neighbour k; returns the
   scale. */
static inline PetscReal MlsEquation(const Stencil *st, PetscInt dim, PetscInt degree, PetscInt k,
                                    PetscReal phi[])
{
  if (st->equation[k] == EQUATION_NONE) {
    for (PetscInt t = 0; t < MlsTerms(dim, degree); t++) phi[t] = 0.0;
    return 0.0;
  }
  if (st->equation[k] == EQUATION_NORMAL_DERIVATIVE) {
    MlsBasisNormalDerivative(st, dim, degree, k, phi);
    return st->scale;
  }
  MlsBasis(st, dim, degree, k, phi);
  return 1.0;
}

void MlsFactorOrRidge(PetscInt n, PetscReal moments[], const PetscReal copy[],
                      PetscInt *regularised);

#endif
