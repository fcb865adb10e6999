/*
  Values at points by moving least squares: a quadratic fit about a point with a free constant,

    f(x + X) = c_0 + sum_t c_t phi_t(X/R),   min sum_k W_k (f_k - fit(X_k))^2,   value = c_0

  Reference: P. Lancaster & K. Salkauskas, Math. Comput. 37 (1981) 141-158
*/
#include "isph/operators.h"

/* Computes the basis 1, s_a, s_a s_b (b <= a) of neighbour k. */
static inline void PointBasis(PetscInt dim, PetscReal *const s[], PetscInt k, PetscReal phi[])
{
  PetscInt t = 1 + dim;

  phi[0] = 1.0;
  for (PetscInt a = 0; a < dim; a++) {
    phi[1 + a] = s[a][k];
    for (PetscInt b = 0; b <= a; b++) phi[t++] = s[a][k] * s[b][k];
  }
}

static inline PetscBool PointFitInline(PetscInt dim, PetscInt n, PetscReal *const s[],
                                       const PetscReal W[], PetscReal w[])
{
  const PetscInt terms                                      = 1 + dim + dim * (dim + 1) / 2;
  PetscReal      moments[POINT_FIT_TERMS * POINT_FIT_TERMS] = {0.0}, phi[POINT_FIT_TERMS];
  PetscReal      c[POINT_FIT_TERMS]                         = {1.0};

  for (PetscInt k = 0; k < n; k++) {
    PointBasis(dim, s, k, phi);
    for (PetscInt t = 0; t < terms; t++) {
      const PetscReal weighted = W[k] * phi[t];

      for (PetscInt q = 0; q <= t; q++) moments[t * terms + q] += weighted * phi[q];
    }
  }
  for (PetscInt t = 0; t < terms; t++) {
    for (PetscInt q = 0; q < t; q++) moments[q * terms + t] = moments[t * terms + q];
  }
  if (DenseCholesky(terms, moments)) return PETSC_FALSE;
  DenseCholeskySolve(terms, moments, c);
  for (PetscInt k = 0; k < n; k++) {
    PetscReal sum = 0.0;

    PointBasis(dim, s, k, phi);
    for (PetscInt t = 0; t < terms; t++) sum += phi[t] * c[t];
    w[k] = W[k] * sum;
  }
  return PETSC_TRUE;
}

/*
  PointFit - Computes the weights w_k of f(x) = sum_k w_k f_k

  Not collective.

  Input Parameters:
+ n - number of neighbours
. s - their offsets (x_k - x)/R, at most 1 in length [-]
- W - their weights in the fit [-]

  Returns: PETSC_FALSE if the neighbours do not determine the fit, and then sets no weights

  Properties: exact for quadratic fields.
*/
PetscBool PointFit(PetscInt dim, PetscInt n, PetscReal *const s[], const PetscReal W[],
                   PetscReal w[])
{
  return dim == 2 ? PointFitInline(2, n, s, W, w) : PointFitInline(3, n, s, W, w);
}
