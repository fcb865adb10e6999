/*
  Values at points by moving least squares: a fit about a point with a free constant,

    f(x + X) = c_0 + sum_t c_t phi_t(X/R),   min sum_k W_k (f_k - fit(X_k))^2,   value = c_0

  its derivatives c_a/R, and the same fit of a vector, of which some neighbours give the normal
  component only.

  Reference: P. Lancaster & K. Salkauskas, Math. Comput. 37 (1981) 141-158
*/
#include "lanemonomials.h"

/* Computes the basis 1, s_a, s_a s_b (b <= a), ... at four points: s[a][at], s[a][at + 1], ...; the
   order is that of MlsBasis(). */
static ISPH_INLINE void FourBases(PetscInt dim, PetscInt degree, PetscReal *const s[], PetscInt at,
                                  Four phi[])
{
  Four x[ISPH_MAX_DIM];

  phi[0] = (Four){1.0, 1.0, 1.0, 1.0};
  for (PetscInt a = 0; a < dim; a++) x[a] = phi[1 + a] = *FourAt(&s[a][at]);
  FourMonomials(dim, degree, x, phi + 1);
}

/* Solves M c = e_0, see FourFactor(). */
static ISPH_INLINE void FourSolve(PetscInt terms, Four M[], Four c[], Four *least)
{
  Four inverse[POINT_FIT_TERMS];

  FourFactor(terms, M, inverse, least);
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
      const Four weighted = *FourAt(&W[k * m + first]) * phi[t];

      for (PetscInt q = 0; q <= t; q++) M[e++] += weighted * phi[q];
    }
  }
  FourSolve(terms, M, c, &least);
  for (PetscInt i = 0; i < 4; i++) fits[first + i] = least[i] > 1e-10;
  for (PetscInt k = 0; k < n; k++) {
    Four phi[POINT_FIT_TERMS], sum = c[0];

    FourBases(dim, degree, s, k * m + first, phi);
    for (PetscInt t = 1; t < terms; t++) sum += phi[t] * c[t];
    *(Four *)&w[k * m + first] = *FourAt(&W[k * m + first]) * sum;
  }
}

/* PointFits - Computes the weights w_k of f(x_i) = sum_k w_k f_k at the m = 2^dim points i at once.
   Input: n - most neighbours of a point; s - their offsets (x_k - x_i)/R, at most 1 in length:
   s[a][k m + i] [-]; W - their weights in the fit: W[k m + i], 0 for those that a point lacks [-].
   Output: w - the weights: w[k m + i]; fits - PETSC_FALSE for points whose neighbours do not
   determine the fit; w is then undefined. Properties: exact for polynomials of the degree. The
   weights of a point do not depend on other points. */
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

/* Adds the products of the basis times a weight. */
static ISPH_INLINE void AddMoments(PetscInt terms, Four weight, const Four phi[], Four moments[])
{
  PetscInt e = 0;

  for (PetscInt t = 0; t < terms; t++) {
    const Four weighted = weight * phi[t];

    for (PetscInt q = 0; q <= t; q++) moments[e++] += weighted * phi[q];
  }
}

/* Solves M c = e_t for a moment matrix M and its factor. Refines c: M may be ill conditioned. */
static void RefinedColumn(PetscInt terms, PetscInt t, const PetscReal moments[],
                          const PetscReal factor[], PetscReal c[])
{
  for (PetscInt q = 0; q < terms; q++) c[q] = q == t ? 1.0 : 0.0;
  DenseCholeskySolve(terms, factor, c);
  for (PetscInt pass = 0; pass < 2; pass++) {
    PetscReal residual[POINT_FIT_TERMS] = {0.0};

    residual[t] = 1.0;
    for (PetscInt r = 0; r < terms; r++) {
      for (PetscInt q = 0; q < terms; q++) residual[r] -= moments[r * terms + q] * c[q];
    }
    DenseCholeskySolve(terms, factor, residual);
    for (PetscInt q = 0; q < terms; q++) c[q] += residual[q];
  }
}

/* Computes the fit, see PointFit(). Inlined, so that the compiler knows the number of terms. */
static ISPH_INLINE PetscBool PointFitInline(PetscInt dim, PetscInt degree, PetscInt n,
                                            PetscReal *const s[], const PetscReal W[],
                                            PetscInt wanted, PetscBool ridge, PetscReal *const w[])
{
  const PetscInt terms = 1 + MlsTerms(dim, degree);
  Four           phi[POINT_FIT_TERMS], sums[POINT_FIT_TERMS * (POINT_FIT_TERMS + 1) / 2];
  PetscReal      moments[POINT_FIT_TERMS * POINT_FIT_TERMS], c[1 + ISPH_MAX_DIM][POINT_FIT_TERMS];
  PetscReal      factor[POINT_FIT_TERMS * POINT_FIT_TERMS];

  for (PetscInt e = 0; e < terms * (terms + 1) / 2; e++) sums[e] = (Four){0.0};
  for (PetscInt k = 0; k < n; k += 4) {
    FourBases(dim, degree, s, k, phi);
    AddMoments(terms, *FourAt(&W[k]), phi, sums);
  }
  for (PetscInt t = 0, e = 0; t < terms; t++)
    for (PetscInt q = 0; q <= t; q++)
      moments[t * terms + q] = moments[q * terms + t] = FourSum(&sums[e++]);
  for (PetscInt e = 0; e < terms * terms; e++) factor[e] = moments[e];
  if (DenseCholesky(terms, factor)) {
    if (!ridge) return PETSC_FALSE;
    DenseCholeskyRidge(terms, moments, 1e-10, factor);
  }
  for (PetscInt t = 0; t < wanted; t++) RefinedColumn(terms, t, moments, factor, c[t]);
  for (PetscInt k = 0; k < n; k += 4) {
    FourBases(dim, degree, s, k, phi);
    for (PetscInt t = 0; t < wanted; t++) {
      Four sum = {0.0};

      for (PetscInt q = 0; q < terms; q++) sum += phi[q] * c[t][q];
      *(Four *)&w[t][k] = *FourAt(&W[k]) * sum;
    }
  }
  return PETSC_TRUE;
}

/* PointFit - Computes the weights of f and of R df/dx_a at a point, f = sum_k w[0]_k f_k and R
   df/dx_a = sum_k w[1 + a]_k f_k. Input: n - number of neighbours, a multiple of 4; those of the
   weight zero fill it up; s - their offsets (x_k - x)/R, at most 1 in length [-]; W - their weights
   in the fit [-]; wanted - number of rows of w; ridge - flag: a multiple of the unit matrix is
   added where they do not determine the fit. Output: w - n weights each. Returns: PETSC_FALSE if
   the neighbours do not determine the fit, and then sets no weights. Properties: exact for
   polynomials of the degree. */
ISPH_WIDE PetscBool PointFit(PetscInt dim, PetscInt degree, PetscInt n, PetscReal *const s[],
                             const PetscReal W[], PetscInt wanted, PetscBool ridge,
                             PetscReal *const w[])
{
  if (dim == 2 && degree == 2) return PointFitInline(2, 2, n, s, W, wanted, ridge, w);
  if (dim == 2) return PointFitInline(2, 3, n, s, W, wanted, ridge, w);
  return degree == 2 ? PointFitInline(3, 2, n, s, W, wanted, ridge, w)
                     : PointFitInline(3, 3, n, s, W, wanted, ridge, w);
}

/* Neighbours of a fit of a vector, in fours. */
typedef struct {
  PetscInt          n;
  PetscReal *const *s;
  const PetscReal  *W;
  const PetscBool  *wall;
  PetscReal *const *normal;
} VectorPoints;

#define VECTOR_PAIRS   (ISPH_MAX_DIM * (ISPH_MAX_DIM + 1) / 2)
#define VECTOR_MOMENTS (POINT_FIT_TERMS * (POINT_FIT_TERMS + 1) / 2)

/* Moments of a fit of a vector, rows up to the diagonal: of fluid neighbours, which are those of
   each component, and of wall neighbours times n_c n_e. */
typedef struct {
  Four fluid[VECTOR_MOMENTS], wall[VECTOR_PAIRS][VECTOR_MOMENTS];
} VectorMoments;

/* Computes the flags of neighbours k to k + 3 as numbers: 1 for walls; returns true if there is a
   wall. */
static ISPH_INLINE PetscBool WallFlags(const VectorPoints *points, PetscInt k, Four *wall)
{
  PetscBool any = PETSC_FALSE;

  for (PetscInt l = 0; l < 4; l++) {
    (*wall)[l] = points->wall[k + l] ? 1.0 : 0.0;
    any        = any || points->wall[k + l];
  }
  return any;
}

/* Computes the moments of the fit of a vector. */
static ISPH_INLINE void SumMoments(PetscInt dim, PetscInt degree, const VectorPoints *points,
                                   VectorMoments *m)
{
  const PetscInt terms = 1 + MlsTerms(dim, degree), size = terms * (terms + 1) / 2;

  for (PetscInt e = 0; e < size; e++) m->fluid[e] = (Four){0.0};
  for (PetscInt pair = 0; pair < dim * (dim + 1) / 2; pair++)
    for (PetscInt e = 0; e < size; e++) m->wall[pair][e] = (Four){0.0};
  for (PetscInt k = 0; k < points->n; k += 4) {
    const Four W = *FourAt(&points->W[k]);
    Four       phi[POINT_FIT_TERMS], wall;
    PetscInt   pair = 0;

    FourBases(dim, degree, points->s, k, phi);
    if (!WallFlags(points, k, &wall)) {
      AddMoments(terms, W, phi, m->fluid);
      continue;
    }
    AddMoments(terms, W - W * wall, phi, m->fluid);
    for (PetscInt c = 0; c < dim; c++) {
      const Four along = W * wall * *FourAt(&points->normal[c][k]);

      for (PetscInt e = 0; e <= c; e++)
        AddMoments(terms, along * *FourAt(&points->normal[e][k]), phi, m->wall[pair++]);
    }
  }
}

/* Fills the lower triangle of the matrix of all components. */
static ISPH_INLINE void FillMatrix(PetscInt dim, PetscInt terms, const VectorMoments *m,
                                   PetscReal matrix[])
{
  const PetscInt size = dim * terms;
  PetscInt       pair = 0;

  for (PetscInt c = 0; c < dim; c++) {
    for (PetscInt e = 0; e <= c; e++, pair++) {
      PetscInt entry = 0;

      for (PetscInt t = 0; t < terms; t++) {
        for (PetscInt q = 0; q <= t; q++, entry++) {
          PetscReal sum = FourSum(&m->wall[pair][entry]);

          if (c == e) sum += FourSum(&m->fluid[entry]);
          matrix[(c * terms + t) * size + e * terms + q] = sum;
          matrix[(c * terms + q) * size + e * terms + t] = sum;
        }
      }
    }
  }
}

/* Computes the weights of all neighbours for component a from the coefficients of its value. */
static ISPH_INLINE void SetVectorWeights(PetscInt dim, PetscInt degree, PetscInt a,
                                         const VectorPoints *points, const PetscReal c[],
                                         PetscReal *const w[])
{
  const PetscInt terms = 1 + MlsTerms(dim, degree);

  for (PetscInt k = 0; k < points->n; k += 4) {
    Four            phi[POINT_FIT_TERMS], part[ISPH_MAX_DIM], wall, along = {0.0};
    const PetscBool beside = WallFlags(points, k, &wall);

    FourBases(dim, degree, points->s, k, phi);
    for (PetscInt b = 0; b < dim; b++) {
      part[b] = (Four){0.0};
      for (PetscInt t = 0; t < terms; t++) part[b] += phi[t] * c[b * terms + t];
      part[b] *= *FourAt(&points->W[k]);
      if (beside) along += *FourAt(&points->normal[b][k]) * part[b];
    }
    for (PetscInt b = 0; b < dim; b++) {
      if (beside) part[b] += wall * (along * *FourAt(&points->normal[b][k]) - part[b]);
      *(Four *)&w[a * dim + b][k] = part[b];
    }
  }
}

/* Computes the fit, see VectorFit(). Inlined, so that the compiler knows the number of terms. */
static ISPH_INLINE PetscBool VectorFitInline(PetscInt dim, PetscInt degree,
                                             const VectorPoints *points, PetscReal *const w[])
{
  const PetscInt terms = 1 + MlsTerms(dim, degree), size = dim * terms;
  VectorMoments  moments;
  PetscReal      matrix[ISPH_MAX_DIM * ISPH_MAX_DIM * POINT_FIT_TERMS * POINT_FIT_TERMS];

  SumMoments(dim, degree, points, &moments);
  FillMatrix(dim, terms, &moments, matrix);
  if (DenseCholesky(size, matrix)) return PETSC_FALSE;
  for (PetscInt a = 0; a < dim; a++) {
    PetscReal c[ISPH_MAX_DIM * POINT_FIT_TERMS] = {0.0};

    c[a * terms] = 1.0;
    DenseCholeskySolve(size, matrix, c);
    SetVectorWeights(dim, degree, a, points, c, w);
  }
  return PETSC_TRUE;
}

/*
  VectorFit - Computes the weights w of u_a(x) = sum_k sum_b w[a][b]_k u_b,k in a fit of a vector u

    sum_k W_k |u_k - fit(X_k)|^2 + sum_w W_w (n.(u_w - fit(X_w)))^2 -> min

  with fluid neighbours k and wall neighbours w, see DivergenceFit_Mls(). Input: n - number of
  neighbours, a multiple of 4; those of the weight zero fill it up; s - their offsets (x_k - x)/R,
  at most 1 in length [-]; W - their weights in the fit [-]; wall - flags of neighbours that give
  the normal component only; normal - their unit normals, zero for fluid. Output: w - w[a dim + b],
  n weights each. Returns: PETSC_FALSE if the neighbours do not determine the fit, and then sets no
  weights. Properties: exact for polynomials of the degree.
*/
ISPH_WIDE PetscBool VectorFit(PetscInt dim, PetscInt degree, PetscInt n, PetscReal *const s[],
                              const PetscReal W[], const PetscBool wall[],
                              PetscReal *const normal[], PetscReal *const w[])
{
  const VectorPoints points = {.n = n, .s = s, .W = W, .wall = wall, .normal = normal};

  if (dim == 2 && degree == 2) return VectorFitInline(2, 2, &points, w);
  if (dim == 2) return VectorFitInline(2, degree, &points, w);
  return degree == 2 ? VectorFitInline(3, 2, &points, w) : VectorFitInline(3, degree, &points, w);
}
