/* Parts of moving least-squares fits, shared by fits of scalars and of vectors: the basis at all
   neighbours, the sums over neighbours, and the solution of the normal equations. All are inlined,
   so that the compiler knows the numbers of terms. Loops over neighbours are innermost, and arrays
   over neighbours end in zeros up to a multiple of ISPH_LANES, so that they need no remainder. */
#ifndef ISPH_MLS_H
#define ISPH_MLS_H

#include "isph/fits.h"

#define MLS_MAX_WIDTH              40 /* MlsWidth() of terms, Laplacian, gradient, filter */
#define MLS_VECTOR_TERMS           (ISPH_MAX_DIM * MLS_MAX_TERMS)
#define MLS_VECTOR_WIDTH           104 /* MlsWidth() of the terms and a right-hand side */
#define MLS_QUADRATIC_VECTOR_WIDTH 28

/* Returns the number of monomials of degree d of the axes 0 to last. */
static ISPH_INLINE PetscInt MlsMonomials(PetscInt last, PetscInt d)
{
  PetscInt count = 1;

  for (PetscInt q = 1; q <= d; q++) count = count * (last + q) / q;
  return count;
}

/* Returns the number of monomials of degree 1 to `degree`. */
static ISPH_INLINE PetscInt MlsTerms(PetscInt dim, PetscInt degree)
{
  PetscInt terms = 0;

  for (PetscInt d = 1; d <= degree; d++) terms += MlsMonomials(dim - 1, d);
  return terms;
}

/* Returns the length of the rows of a system, so that rows need no remainder either. */
static ISPH_INLINE PetscInt MlsWidth(PetscInt columns)
{
  return (columns + 3) / 4 * 4;
}

/* Computes n.grad of the basis at wall neighbour k, times the length st->scale; in: phi - the basis
   at k; out: its derivative in its place. */
static ISPH_INLINE void MlsBasisNormalDerivative(const Stencil *st, PetscInt dim, PetscInt degree,
                                                 PetscInt k, PetscInt stride, PetscReal phi[])
{
  PetscReal value[MLS_MAX_TERMS], s[ISPH_MAX_DIM], n[ISPH_MAX_DIM];
  PetscInt  lower = 0, t = dim;

  for (PetscInt q = 0; q < MlsTerms(dim, degree); q++) value[q] = phi[q * stride];
  for (PetscInt a = 0; a < dim; a++) {
    s[a] = value[a];
    n[a] = phi[a * stride] = st->stretch[a] * st->normal[a][k] * st->scale / st->radius;
  }
  for (PetscInt d = 2; d <= degree; d++) {
    for (PetscInt a = 0; a < dim; a++) {
      for (PetscInt q = lower; q < lower + MlsMonomials(a, d - 1); q++)
        phi[stride * t++] = n[a] * value[q] + s[a] * phi[stride * q];
    }
    lower += MlsMonomials(dim - 1, d - 1);
  }
}

/*
  Computes the weights W_k and the basis phi_t at all neighbours for their present equations

    sum_t c_t phi_t = scale times data of neighbour k

  with s = X/R and phi = s_a, then s_a s_b (b <= a), then s_a s_b s_c (c <= b <= a), and so on;
  `scale` is st->scale for n.grad f, otherwise 1. The monomials of degree d that begin with s_a are
  s_a times the first monomials of degree d - 1. A neighbour without an equation has the weight 0.
*/
static ISPH_INLINE void MlsBasis(Stencil *st, PetscInt dim, PetscInt degree)
{
  const PetscInt  stride = st->capacity, n = LanesPadded(st->n);
  const PetscReal over = 1.0 / st->radius;
  PetscReal      *phi = st->fit.phi, *W = st->fit.W, *lower = phi, *next = phi + dim * stride;

  for (PetscInt k = 0; k < st->n; k++) W[k] = st->equation[k] == EQUATION_NONE ? 0.0 : st->W[k];
  for (PetscInt k = st->n; k < n; k++) W[k] = 0.0;
  for (PetscInt a = 0; a < dim; a++) {
    for (PetscInt k = 0; k < st->n; k++) phi[a * stride + k] = over * st->X[a][k];
    for (PetscInt k = st->n; k < n; k++) phi[a * stride + k] = 0.0;
  }
  for (PetscInt d = 2; d <= degree; d++) {
    for (PetscInt a = 0; a < dim; a++) {
      for (PetscInt q = 0; q < MlsMonomials(a, d - 1); q++, next += stride) {
#pragma omp simd
        for (PetscInt k = 0; k < n; k++) next[k] = phi[a * stride + k] * lower[q * stride + k];
      }
    }
    lower += MlsMonomials(dim - 1, d - 1) * stride;
  }
  for (PetscInt k = 0; st->n_wall && k < st->n; k++) {
    if (st->equation[k] == EQUATION_NORMAL_DERIVATIVE)
      MlsBasisNormalDerivative(st, dim, degree, k, stride, phi + k);
  }
}

/* Computes the moments sum_k W_k phi_t phi_q. Input: W - weights of the neighbours, padded; width -
   length of the rows of M. Output: M - block of terms x terms. */
static ISPH_INLINE void MlsMoments(const Stencil *st, PetscInt terms, const PetscReal W[],
                                   PetscInt width, PetscReal M[])
{
  const PetscInt   stride = st->capacity, n = LanesPadded(st->n);
  const PetscReal *phi      = st->fit.phi;
  PetscReal       *weighted = st->fit.weighted;

  for (PetscInt t = 0; t < terms; t++) {
#pragma omp simd
    for (PetscInt k = 0; k < n; k++) weighted[k] = W[k] * phi[t * stride + k];
    for (PetscInt q = 0; q <= t; q++)
      M[t * width + q] = M[q * width + t] = LanesSum(n, weighted, phi + q * stride);
  }
}

/* Computes the weights w_k = scale W_k sum_t c_t phi_t of the data of all neighbours, with the
   scale of MlsBasis(); the entries of c are `width` apart. */
static ISPH_INLINE void MlsWeights(const Stencil *st, PetscInt terms, PetscInt width,
                                   const PetscReal c[], PetscReal w[])
{
  const PetscInt   stride = st->capacity;
  const PetscReal *phi = st->fit.phi, *W = st->fit.W;

#pragma omp simd
  for (PetscInt k = 0; k < st->n; k++) {
    PetscReal sum = 0.0;

    for (PetscInt t = 0; t < terms; t++) sum += phi[t * stride + k] * c[t * width];
    w[k] = W[k] * sum;
  }
  for (PetscInt k = 0; st->n_wall && k < st->n; k++)
    if (st->equation[k] == EQUATION_NORMAL_DERIVATIVE) w[k] *= st->scale;
}

/*
  Solves M X = B by Gauss elimination without pivoting, for a symmetric positive definite M, of
  which it reads the entries on and above the diagonal

  Input/Output Parameter:
. a - n rows of `width` numbers: M, then B; out: X in place of B

  Returns: PETSC_FALSE if a pivot is at most the share `weak` of its diagonal entry
*/
static ISPH_INLINE PetscBool MlsEliminate(PetscInt n, PetscInt width, PetscReal weak, PetscReal a[])
{
  PetscReal least[MLS_VECTOR_TERMS], inverse[MLS_VECTOR_TERMS];

  for (PetscInt j = 0; j < n; j++) least[j] = weak * a[j * width + j];
  for (PetscInt j = 0; j < n; j++) {
    const PetscReal *pivot = a + j * width;

    if (!(pivot[j] > least[j])) return PETSC_FALSE;
    inverse[j] = 1.0 / pivot[j];
    for (PetscInt i = j + 1; i < n; i++) {
      const PetscReal factor = pivot[i] * inverse[j];

      if (factor == 0.0) continue; /* vectors beside flat walls: uncoupled components */
#pragma omp simd
      for (PetscInt c = i / 4 * 4; c < width; c++) a[i * width + c] -= factor * pivot[c];
    }
  }
  for (PetscInt j = n - 1; j >= 0; j--) {
    for (PetscInt c = n; c < width; c++) a[j * width + c] *= inverse[j];
    for (PetscInt i = 0; i < j; i++) {
      for (PetscInt c = n; c < width; c++) a[i * width + c] -= a[i * width + j] * a[j * width + c];
    }
  }
  return PETSC_TRUE;
}

/* Solves the normal equations of a fit. If the points do not determine the fit, adds a multiple of
   the unit matrix: the first of 1e-8, 1e-6, ... times the trace that makes the matrix positive
   definite. Input: system - as for MlsEliminate(). Output: solved - the rows of the system with X
   in place of B. Returns: PETSC_FALSE if the points do not determine the fit. */
static ISPH_INLINE PetscBool MlsSolve(PetscInt n, PetscInt width, const PetscReal system[],
                                      PetscReal solved[])
{
  PetscReal trace = 0.0;

  for (PetscInt e = 0; e < n * width; e++) solved[e] = system[e];
  if (MlsEliminate(n, width, MLS_WEAK, solved)) return PETSC_TRUE;
  for (PetscInt t = 0; t < n; t++) trace += system[t * width + t];
  if (!(trace > 0.0)) trace = 1.0;
  for (PetscReal ridge = 1e-8; ridge < 1e6; ridge *= 100.0) {
    for (PetscInt e = 0; e < n * width; e++) solved[e] = system[e];
    for (PetscInt t = 0; t < n; t++) solved[t * width + t] += ridge * trace;
    if (MlsEliminate(n, width, MLS_WEAK, solved)) break;
  }
  return PETSC_FALSE;
}

#endif
