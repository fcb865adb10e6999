/*
  Values at points by moving least squares: a fit about a point with a free constant,

    f(x + X) = c_0 + sum_t c_t phi_t(X/R),   min sum_k W_k (f_k - fit(X_k))^2,   value = c_0

  and the same fit of a vector, of which some neighbours give the normal component only.

  Reference: P. Lancaster & K. Salkauskas, Math. Comput. 37 (1981) 141-158
*/
#include "mls.h"

/* Factors m symmetric matrices at once, as DenseCholesky(): entry (t, q) of matrix i is
   a[(t terms + q) m + i]; clears the flags of matrices that are not positive definite. */
static inline void CholeskyFactors(PetscInt terms, PetscInt m, PetscReal a[], PetscBool definite[])
{
  for (PetscInt t = 0; t < terms; t++) {
    PetscReal pivot[POINT_FITS];

    for (PetscInt i = 0; i < m; i++) pivot[i] = a[(t * terms + t) * m + i];
    for (PetscInt k = 0; k < t; k++) {
#pragma omp simd
      for (PetscInt i = 0; i < m; i++) pivot[i] -= PetscSqr(a[(t * terms + k) * m + i]);
    }
    for (PetscInt i = 0; i < m; i++) {
      if (!(pivot[i] > 1e-10 * a[(t * terms + t) * m + i])) {
        definite[i] = PETSC_FALSE;
        pivot[i]    = 1.0;
      }
    }
#pragma omp simd
    for (PetscInt i = 0; i < m; i++) {
      pivot[i]                   = 1.0 / PetscSqrtReal(pivot[i]);
      a[(t * terms + t) * m + i] = pivot[i];
    }
    for (PetscInt r = t + 1; r < terms; r++) {
      PetscReal sum[POINT_FITS];

      for (PetscInt i = 0; i < m; i++) sum[i] = a[(r * terms + t) * m + i];
      for (PetscInt k = 0; k < t; k++) {
#pragma omp simd
        for (PetscInt i = 0; i < m; i++)
          sum[i] -= a[(r * terms + k) * m + i] * a[(t * terms + k) * m + i];
      }
#pragma omp simd
      for (PetscInt i = 0; i < m; i++) a[(r * terms + t) * m + i] = sum[i] * pivot[i];
    }
  }
}

/* Solves M c = e_0 for m matrices with the factors of CholeskyFactors(). */
static inline void CholeskySolves(PetscInt terms, PetscInt m, const PetscReal a[], PetscReal c[])
{
  for (PetscInt t = 0; t < terms; t++) {
    for (PetscInt i = 0; i < m; i++) c[t * m + i] = t == 0 ? 1.0 : 0.0;
    for (PetscInt k = 0; k < t; k++) {
#pragma omp simd
      for (PetscInt i = 0; i < m; i++) c[t * m + i] -= a[(t * terms + k) * m + i] * c[k * m + i];
    }
#pragma omp simd
    for (PetscInt i = 0; i < m; i++) c[t * m + i] *= a[(t * terms + t) * m + i];
  }
  for (PetscInt t = terms - 1; t >= 0; t--) {
    for (PetscInt k = t + 1; k < terms; k++) {
#pragma omp simd
      for (PetscInt i = 0; i < m; i++) c[t * m + i] -= a[(k * terms + t) * m + i] * c[k * m + i];
    }
#pragma omp simd
    for (PetscInt i = 0; i < m; i++) c[t * m + i] *= a[(t * terms + t) * m + i];
  }
}

/* Computes the basis 1, s_a, s_a s_b (b <= a), ... for neighbour k of m points: phi[t m + i]; the
   order is that of MlsBasis(). */
static inline void PointBases(PetscInt dim, PetscInt degree, PetscInt m, PetscReal *const s[],
                              PetscInt k, PetscReal phi[])
{
  PetscReal *lower = phi + m, *next = phi + (1 + dim) * m;

  for (PetscInt i = 0; i < m; i++) phi[i] = 1.0;
  for (PetscInt a = 0; a < dim; a++) {
#pragma omp simd
    for (PetscInt i = 0; i < m; i++) phi[(1 + a) * m + i] = s[a][k * m + i];
  }
  for (PetscInt d = 2; d <= degree; d++) {
    for (PetscInt a = 0; a < dim; a++) {
      for (PetscInt q = 0; q < MlsMonomials(a, d - 1); q++, next += m) {
#pragma omp simd
        for (PetscInt i = 0; i < m; i++) next[i] = s[a][k * m + i] * lower[q * m + i];
      }
    }
    lower += MlsMonomials(dim - 1, d - 1) * m;
  }
}

static inline void PointFitsInline(PetscInt dim, PetscInt degree, PetscInt m, PetscInt n,
                                   PetscReal *const s[], const PetscReal W[], PetscReal w[],
                                   PetscBool fits[])
{
  const PetscInt terms = 1 + MlsTerms(dim, degree);
  PetscReal      moments[POINT_FIT_TERMS * POINT_FIT_TERMS * POINT_FITS];
  PetscReal      phi[POINT_FIT_TERMS * POINT_FITS], c[POINT_FIT_TERMS * POINT_FITS];

  for (PetscInt e = 0; e < terms * terms * m; e++) moments[e] = 0.0;
  for (PetscInt k = 0; k < n; k++) {
    PointBases(dim, degree, m, s, k, phi);
    for (PetscInt t = 0; t < terms; t++) {
      PetscReal weighted[POINT_FITS];

#pragma omp simd
      for (PetscInt i = 0; i < m; i++) weighted[i] = W[k * m + i] * phi[t * m + i];
      for (PetscInt q = 0; q <= t; q++) {
#pragma omp simd
        for (PetscInt i = 0; i < m; i++)
          moments[(t * terms + q) * m + i] += weighted[i] * phi[q * m + i];
      }
    }
  }
  for (PetscInt i = 0; i < m; i++) fits[i] = PETSC_TRUE;
  CholeskyFactors(terms, m, moments, fits);
  CholeskySolves(terms, m, moments, c);
  for (PetscInt k = 0; k < n; k++) {
    PetscReal sum[POINT_FITS] = {0.0};

    PointBases(dim, degree, m, s, k, phi);
    for (PetscInt t = 0; t < terms; t++) {
#pragma omp simd
      for (PetscInt i = 0; i < m; i++) sum[i] += phi[t * m + i] * c[t * m + i];
    }
#pragma omp simd
    for (PetscInt i = 0; i < m; i++) w[k * m + i] = W[k * m + i] * sum[i];
  }
}

/*
  PointFits - Computes the weights w_k of f(x_i) = sum_k w_k f_k at the m = 2^dim points i at once

  Not collective.

  Input Parameters:
+ n - most neighbours of a point
. s - their offsets (x_k - x_i)/R, at most 1 in length: s[a][k m + i] [-]
- W - their weights in the fit: W[k m + i], 0 for those that a point lacks [-]

  Output Parameters:
+ w    - the weights: w[k m + i]
- fits - PETSC_FALSE for points whose neighbours do not determine the fit; w is then undefined

  Properties: exact for polynomials of the degree. The weights of a point do not depend on other
  points.
*/
void PointFits(PetscInt dim, PetscInt degree, PetscInt n, PetscReal *const s[], const PetscReal W[],
               PetscReal w[], PetscBool fits[])
{
  if (dim == 2 && degree == 2) PointFitsInline(2, 2, 4, n, s, W, w, fits);
  else if (dim == 2) PointFitsInline(2, degree, 4, n, s, W, w, fits);
  else if (degree == 2) PointFitsInline(3, 2, 8, n, s, W, w, fits);
  else PointFitsInline(3, degree, 8, n, s, W, w, fits);
}

/* Computes the moment matrix of the fit of a vector. */
static void VectorMoments(PetscInt dim, PetscInt degree, PetscInt n, PetscReal *const s[],
                          const PetscReal W[], const PetscBool wall[], PetscReal *const normal[],
                          PetscReal moments[])
{
  const PetscInt terms = 1 + MlsTerms(dim, degree), size = dim * terms;

  for (PetscInt k = 0; k < n; k++) {
    PetscReal phi[POINT_FIT_TERMS];

    PointBases(dim, degree, 1, s, k, phi);
    for (PetscInt c = 0; c < dim; c++) {
      for (PetscInt e = 0; e < dim; e++) {
        const PetscReal couple = wall[k] ? normal[c][k] * normal[e][k] : (c == e ? 1.0 : 0.0);

        if (couple == 0.0) continue;
        for (PetscInt t = 0; t < terms; t++) {
          for (PetscInt q = 0; q < terms; q++)
            moments[(c * terms + t) * size + e * terms + q] += couple * W[k] * phi[t] * phi[q];
        }
      }
    }
  }
}

/*
  VectorFit - Computes the weights w of u_a(x) = sum_k sum_b w[a][b]_k u_b,k in a fit of a vector u

    sum_k W_k |u_k - fit(X_k)|^2 + sum_w W_w (n.(u_w - fit(X_w)))^2 -> min

  with fluid neighbours k and wall neighbours w, see DivergenceFit_Mls(). Not collective.

  Input Parameters:
+ n       - number of neighbours
. s       - their offsets (x_k - x)/R, at most 1 in length [-]
. W       - their weights in the fit [-]
. wall    - flags of neighbours that give the normal component only
- normal  - their unit normals

  Output Parameter:
. w - w[a dim + b], n weights each

  Returns: PETSC_FALSE if the neighbours do not determine the fit, and then sets no weights

  Properties: exact for polynomials of the degree.
*/
PetscBool VectorFit(PetscInt dim, PetscInt degree, PetscInt n, PetscReal *const s[],
                    const PetscReal W[], const PetscBool wall[], PetscReal *const normal[],
                    PetscReal *const w[])
{
  const PetscInt terms = 1 + MlsTerms(dim, degree), size = dim * terms;
  PetscReal      moments[ISPH_MAX_DIM * ISPH_MAX_DIM * POINT_FIT_TERMS * POINT_FIT_TERMS];

  for (PetscInt e = 0; e < size * size; e++) moments[e] = 0.0;
  VectorMoments(dim, degree, n, s, W, wall, normal, moments);
  if (DenseCholesky(size, moments)) return PETSC_FALSE;
  for (PetscInt a = 0; a < dim; a++) {
    PetscReal c[ISPH_MAX_DIM * POINT_FIT_TERMS] = {0.0};

    c[a * terms] = 1.0;
    DenseCholeskySolve(size, moments, c);
    for (PetscInt k = 0; k < n; k++) {
      PetscReal phi[POINT_FIT_TERMS], part[ISPH_MAX_DIM] = {0.0}, along = 0.0;

      PointBases(dim, degree, 1, s, k, phi);
      for (PetscInt b = 0; b < dim; b++) {
        for (PetscInt t = 0; t < terms; t++) part[b] += W[k] * phi[t] * c[b * terms + t];
        if (wall[k]) along += normal[b][k] * part[b];
      }
      for (PetscInt b = 0; b < dim; b++)
        w[a * dim + b][k] = wall[k] ? along * normal[b][k] : part[b];
    }
  }
  return PETSC_TRUE;
}
