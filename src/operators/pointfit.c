/*
  Values at points by moving least squares: a fit about a point with a free constant,

    f(x + X) = c_0 + sum_t c_t phi_t(X/R),   min sum_k W_k (f_k - fit(X_k))^2,   value = c_0

  and the same fit of a vector, of which some neighbours give the normal component only.

  Reference: P. Lancaster & K. Salkauskas, Math. Comput. 37 (1981) 141-158
*/
#include "four.h"

/* Computes the basis 1, s_a, s_a s_b (b <= a), ... at four points: s[a][at], s[a][at + 1], ...; the
   order is that of MlsBasis(). */
static ISPH_INLINE void FourBases(PetscInt dim, PetscInt degree, PetscReal *const s[], PetscInt at,
                                  Four phi[])
{
  Four x[ISPH_MAX_DIM];

  phi[0] = (Four){1.0, 1.0, 1.0, 1.0};
  for (PetscInt a = 0; a < dim; a++) x[a] = phi[1 + a] = *(const Four *)&s[a][at];
  FourMonomials(dim, degree, x, phi + 1);
}

/*
  Solves M c = e_0 by the factors L D L^T of M, whose rows are one after the other up to the
  diagonal. Output: least - the least pivot over its diagonal entry.
*/
static ISPH_INLINE void FourSolve(PetscInt terms, Four M[], Four c[], Four *least)
{
  Four inverse[POINT_FIT_TERMS];

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
  for (PetscInt j = 0; j < terms; j++) { /* L D z = e_0; L^T c = z */
    c[j] = -M[j * (j + 1) / 2];
    for (PetscInt k = 1; k < j; k++) c[j] -= M[j * (j + 1) / 2 + k] * c[k];
  }
  c[0] = (Four){1.0, 1.0, 1.0, 1.0};
  for (PetscInt j = 0; j < terms; j++) c[j] *= inverse[j];
  for (PetscInt j = terms - 1; j > 0; j--)
    for (PetscInt k = 0; k < j; k++) c[k] -= M[j * (j + 1) / 2 + k] * c[j];
}

/* Computes the fits of four points of m, the first of which is number `first`; see PointFits().
   Inlined, so that the compiler knows the number of terms. */
static ISPH_INLINE void FourFits(PetscInt dim, PetscInt degree, PetscInt m, PetscInt first,
                                 PetscInt n, PetscReal *const s[], const PetscReal W[],
                                 PetscReal w[], PetscBool fits[])
{
  const PetscInt terms = 1 + MlsTerms(dim, degree);
  Four           M[POINT_FIT_TERMS * (POINT_FIT_TERMS + 1) / 2], c[POINT_FIT_TERMS], least;

  for (PetscInt e = 0; e < terms * (terms + 1) / 2; e++) M[e] = (Four){0.0};
  for (PetscInt k = 0; k < n; k++) {
    Four     phi[POINT_FIT_TERMS];
    PetscInt e = 0;

    FourBases(dim, degree, s, k * m + first, phi);
    for (PetscInt t = 0; t < terms; t++) {
      const Four weighted = *(const Four *)&W[k * m + first] * phi[t];

      for (PetscInt q = 0; q <= t; q++) M[e++] += weighted * phi[q];
    }
  }
  FourSolve(terms, M, c, &least);
  for (PetscInt i = 0; i < 4; i++) fits[first + i] = least[i] > 1e-10 ? PETSC_TRUE : PETSC_FALSE;
  for (PetscInt k = 0; k < n; k++) {
    Four phi[POINT_FIT_TERMS], sum = c[0];

    FourBases(dim, degree, s, k * m + first, phi);
    for (PetscInt t = 1; t < terms; t++) sum += phi[t] * c[t];
    *(Four *)&w[k * m + first] = *(const Four *)&W[k * m + first] * sum;
  }
}

/* Computes the basis of FourBases() for neighbour k of a single point. */
static inline void PointBasis(PetscInt dim, PetscInt degree, PetscReal *const s[], PetscInt k,
                              PetscReal phi[])
{
  PetscReal *lower = phi + 1, *next = phi + 1 + dim;

  phi[0] = 1.0;
  for (PetscInt a = 0; a < dim; a++) phi[1 + a] = s[a][k];
  for (PetscInt d = 2; d <= degree; d++) {
    for (PetscInt a = 0; a < dim; a++)
      for (PetscInt q = 0; q < MlsMonomials(a, d - 1); q++) *next++ = s[a][k] * lower[q];
    lower += MlsMonomials(dim - 1, d - 1);
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
ISPH_WIDE void PointFits(PetscInt dim, PetscInt degree, PetscInt n, PetscReal *const s[],
                         const PetscReal W[], PetscReal w[], PetscBool fits[])
{
  for (PetscInt first = 0; first < 1 << dim; first += 4) {
    if (dim == 2 && degree == 2) FourFits(2, 2, 4, first, n, s, W, w, fits);
    else if (dim == 2) FourFits(2, degree, 4, first, n, s, W, w, fits);
    else if (degree == 2) FourFits(3, 2, 8, first, n, s, W, w, fits);
    else FourFits(3, degree, 8, first, n, s, W, w, fits);
  }
}

/* Computes the moment matrix of the fit of a vector. */
static void VectorMoments(PetscInt dim, PetscInt degree, PetscInt n, PetscReal *const s[],
                          const PetscReal W[], const PetscBool wall[], PetscReal *const normal[],
                          PetscReal moments[])
{
  const PetscInt terms = 1 + MlsTerms(dim, degree), size = dim * terms;

  for (PetscInt k = 0; k < n; k++) {
    PetscReal phi[POINT_FIT_TERMS];

    PointBasis(dim, degree, s, k, phi);
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

      PointBasis(dim, degree, s, k, phi);
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
