/* Fits of several particles at once, one in each lane of a vector: the formulas are those of mls.c,
   for particles whose neighbours all give values. A fit alone spends most of its time on sums
   across lanes and on a system of a few unknowns; here no operation crosses lanes. */
#include "mlsbatch.h"
#include "lanemonomials.h"

#define ROWS      (2 + ISPH_MAX_DIM) /* filter, Laplacian, gradient */
#define MOMENTS   (MLS_MAX_TERMS * (MLS_MAX_TERMS + 1) / 2)
#define MONOMIALS 164 /* of degree 1 to 2 MLS_MAX_DEGREE in 3D */
#define DEGREES   (MLS_MAX_DEGREE - 1)

struct MlsBatch {
  PetscInt  dim;
  PetscInt  product[DEGREES][MOMENTS];       /* monomial of each moment, of the degrees 2, 3, ... */
  PetscInt  capacity;                        /* neighbours */
  Four     *s[ISPH_MAX_DIM];                 /* offsets of neighbours over the radius */
  Four     *W, *row[ROWS];                   /* weights of neighbours in the fit and in the rows */
  Four      x[ROWS][MLS_MAX_TERMS], per_sum; /* solutions for the rows; factor of the filter */
  PetscBool rows;                            /* all rows are needed, not the Laplacian alone */
};

/* The systems of a batch. */
typedef struct {
  Four M[MOMENTS];             /* moments, then factors */
  Four pivot[MLS_MAX_TERMS];   /* their inverses */
  Four b[ROWS][MLS_MAX_TERMS]; /* right-hand sides, then solutions */
  Four m[MLS_MAX_TERMS], sum;  /* of the filter */
} Systems;

/* Lists the exponents of the monomials of degree 1 to `degree`, in the order of MlsBasis(). */
static void ListExponents(PetscInt dim, PetscInt degree, PetscInt exponent[][ISPH_MAX_DIM])
{
  PetscInt lower = 0, t = dim;

  for (PetscInt e = 0; e < dim * ISPH_MAX_DIM; e++)
    exponent[e / ISPH_MAX_DIM][e % ISPH_MAX_DIM] = e % (ISPH_MAX_DIM + 1) ? 0 : 1;
  for (PetscInt d = 2; d <= degree; d++) {
    for (PetscInt a = 0; a < dim; a++) {
      for (PetscInt q = 0; q < MlsMonomials(a, d - 1); q++, t++) {
        for (PetscInt b = 0; b < ISPH_MAX_DIM; b++)
          exponent[t][b] = exponent[lower + q][b] + (a == b ? 1 : 0);
      }
    }
    lower += MlsMonomials(dim - 1, d - 1);
  }
}

/* Finds the monomial that each product of two terms of a degree is. */
static void SetProducts(PetscInt degree, MlsBatch *b)
{
  const PetscInt terms = MlsTerms(b->dim, degree);
  PetscInt       exponent[MONOMIALS][ISPH_MAX_DIM], e = 0;

  ListExponents(b->dim, 2 * degree, exponent);
  for (PetscInt t = 0; t < terms; t++) {
    for (PetscInt q = 0; q <= t; q++, e++) {
      for (PetscInt m = 0; m < MlsTerms(b->dim, 2 * degree); m++) {
        PetscBool same = PETSC_TRUE;

        for (PetscInt a = 0; a < ISPH_MAX_DIM; a++)
          if (exponent[m][a] != exponent[t][a] + exponent[q][a]) same = PETSC_FALSE;
        if (same) b->product[degree - 2][e] = m;
      }
    }
  }
}

/* MlsBatchCreate - Creates the workspace of a batch of particles in `dim` dimensions */
PetscErrorCode MlsBatchCreate(PetscInt dim, MlsBatch **batch)
{
  PetscFunctionBegin;
  PetscCall(PetscNew(batch));
  (*batch)->dim = dim;
  for (PetscInt degree = 2; degree <= MLS_MAX_DEGREE; degree++) SetProducts(degree, *batch);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode BatchFree(MlsBatch *b)
{
  PetscFunctionBegin;
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) PetscCall(PetscFree(b->s[a]));
  for (PetscInt r = 0; r < ROWS; r++) PetscCall(PetscFree(b->row[r]));
  PetscCall(PetscFree(b->W));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* MlsBatchDestroy - Frees the workspace */
PetscErrorCode MlsBatchDestroy(MlsBatch **batch)
{
  PetscFunctionBegin;
  if (!*batch) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(BatchFree(*batch));
  PetscCall(PetscFree(*batch));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode BatchReserve(PetscInt n, MlsBatch *b)
{
  PetscFunctionBegin;
  if (n <= b->capacity) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(BatchFree(b));
  b->capacity = 2 * n;
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) PetscCall(PetscMalloc1(b->capacity, &b->s[a]));
  for (PetscInt r = 0; r < ROWS; r++) PetscCall(PetscMalloc1(b->capacity, &b->row[r]));
  PetscCall(PetscMalloc1(b->capacity, &b->W));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Copies the neighbours of a particle to its lane, followed by weights of zero up to n. */
static void FillLane(const Stencil *st, PetscInt lane, PetscInt n, MlsBatch *b)
{
  const PetscReal over = 1.0 / st->radius;

  for (PetscInt k = 0; k < st->n; k++) {
    b->W[k][lane] = st->W[k];
    for (PetscInt a = 0; a < st->dim; a++) b->s[a][k][lane] = over * st->X[a][k];
  }
  for (PetscInt k = st->n; k < n; k++) {
    b->W[k][lane] = 0.0;
    for (PetscInt a = 0; a < st->dim; a++) b->s[a][k][lane] = 0.0;
  }
}

/* Computes the moments and the right-hand sides. The products of two terms are fewer monomials than
   pairs of terms, and the sum of each is computed once. */
static ISPH_INLINE void SetSystems(PetscInt dim, PetscInt degree, PetscInt n, Stencil *const st[],
                                   const MlsBatch *b, Systems *y)
{
  const PetscInt terms = MlsTerms(dim, degree), monomials = MlsTerms(dim, 2 * degree);
  const Four     zero = {0.0};
  Four           sum[MONOMIALS], weights = zero;

  for (PetscInt m = 0; m < monomials; m++) sum[m] = zero;
  for (PetscInt k = 0; k < n; k++) {
    Four s[ISPH_MAX_DIM], phi[MONOMIALS];

    weights += b->W[k];
    for (PetscInt a = 0; a < dim; a++) {
      s[a]   = b->s[a][k];
      phi[a] = b->W[k] * s[a];
    }
    FourMonomials(dim, 2 * degree, s, phi);
#pragma GCC unroll 40
    for (PetscInt m = 0; m < monomials; m++) sum[m] += phi[m];
  }
  y->sum = weights;
  for (PetscInt e = 0; e < terms * (terms + 1) / 2; e++) y->M[e] = sum[b->product[degree - 2][e]];
  for (PetscInt t = 0; t < terms; t++) y->m[t] = y->b[0][t] = sum[t];
  for (PetscInt r = 1; r < 2 + dim; r++)
    for (PetscInt t = 0; t < terms; t++) y->b[r][t] = zero;
  for (PetscInt l = 0; l < MLS_BATCH; l++) {
    const PetscReal over = 1.0 / st[l]->radius;

    y->sum[l] += st[l]->self[0];
    for (PetscInt a = 0; a < dim; a++) {
      const PetscReal slope = st[l]->stretch[a] * over;

      y->b[1][dim + a * (a + 1) / 2 + a][l] = 2.0 * PetscSqr(slope);
      y->b[2 + a][a][l]                     = slope;
    }
  }
}

/* Solves the systems, see FourFactor(). */
static ISPH_INLINE void SolveSystems(PetscInt dim, PetscInt terms, Systems *y, Four *least)
{
  FourFactor(terms, y->M, y->pivot, least);
  for (PetscInt r = 0; r < 2 + dim; r++) {
    Four *x = y->b[r];

    for (PetscInt j = 1; j < terms; j++)
      for (PetscInt k = 0; k < j; k++) x[j] -= y->M[j * (j + 1) / 2 + k] * x[k];
    for (PetscInt j = 0; j < terms; j++) x[j] *= y->pivot[j];
    for (PetscInt j = terms - 1; j > 0; j--)
      for (PetscInt k = 0; k < j; k++) x[k] -= y->M[j * (j + 1) / 2 + k] * x[j];
  }
}

/* Keeps the solutions for the rows. */
static ISPH_INLINE void KeepSolutions(PetscInt dim, PetscInt terms, const Systems *y, MlsBatch *b)
{
  Four sum = y->sum;

  for (PetscInt r = 0; r < 2 + dim; r++)
    for (PetscInt t = 0; t < terms; t++) b->x[r][t] = y->b[r][t];
  for (PetscInt t = 0; t < terms; t++) sum -= y->m[t] * y->b[0][t];
  b->per_sum = 1.0 / sum;
}

/* Computes the sum of the terms times their coefficients. */
static ISPH_INLINE void Sum(PetscInt terms, const Four x[], const Four phi[], Four *sum)
{
  *sum = x[0] * phi[0];
  for (PetscInt t = 1; t < terms; t++) *sum += x[t] * phi[t];
}

/* Computes the weights of the rows from the solutions. */
static ISPH_INLINE void SetRows(PetscInt dim, PetscInt degree, PetscInt n, MlsBatch *b)
{
  const PetscInt terms   = MlsTerms(dim, degree);
  const Four     per_sum = b->per_sum;
  Four           x[ROWS][MLS_MAX_TERMS];

  for (PetscInt r = 0; r < 2 + dim; r++)
    for (PetscInt t = 0; t < terms; t++) x[r][t] = b->x[r][t];
  for (PetscInt k = 0; k < n; k++) {
    Four s[ISPH_MAX_DIM], phi[MLS_MAX_TERMS], sum;

    for (PetscInt a = 0; a < dim; a++) s[a] = phi[a] = b->s[a][k];
    FourMonomials(dim, degree, s, phi);
    Sum(terms, x[1], phi, &sum);
    b->row[1][k] = b->W[k] * sum;
    if (!b->rows) continue;
    Sum(terms, x[0], phi, &sum);
    b->row[0][k] = b->W[k] * (sum - 1.0) * per_sum;
    for (PetscInt r = 2; r < 2 + dim; r++) {
      Sum(terms, x[r], phi, &sum);
      b->row[r][k] = b->W[k] * sum;
    }
  }
}

/* Copies the coefficients of the gradient and of the filter of a lane, see fitted.c. */
static void KeepCoefficients(const MlsBatch *b, PetscInt terms, PetscInt lane, Stencil *st)
{
  PetscReal *to = st->fit.coefficient;

  for (PetscInt a = 0; a < st->dim; a++)
    for (PetscInt t = 0; t < terms; t++) *to++ = b->x[2 + a][t][lane];
  st->fit.fitted = PETSC_TRUE;
  if (!st->fit.with_filter) return;
  for (PetscInt t = 0; t < terms; t++) *to++ = b->x[0][t][lane] * b->per_sum[lane];
  *to = -b->per_sum[lane];
}

/* Copies the rows of a lane to the fit of its particle. */
static void KeepLane(const MlsBatch *b, PetscInt degree, PetscInt lane, Stencil *st)
{
  PetscReal *to[ROWS] = {st->fit.filter, st->fit.laplacian};

  st->fit.wanted = st->fit.degree = degree;
  for (PetscInt k = 0; k < st->n; k++) to[1][k] = b->row[1][k][lane];
  if (st->fit.coefficient) {
    KeepCoefficients(b, MlsTerms(st->dim, degree), lane, st);
    return;
  }
  for (PetscInt a = 0; a < st->dim; a++) to[2 + a] = st->fit.gradient[a];
  for (PetscInt r = 0; r < 2 + st->dim; r++)
    for (PetscInt k = 0; r != 1 && k < st->n; k++) to[r][k] = b->row[r][k][lane];
}

static ISPH_INLINE void FitInline(PetscInt dim, PetscInt degree, PetscInt n, Stencil *const st[],
                                  MlsBatch *b, Four *least)
{
  Systems y;

  SetSystems(dim, degree, n, st, b, &y);
  SolveSystems(dim, MlsTerms(dim, degree), &y, least);
  KeepSolutions(dim, MlsTerms(dim, degree), &y, b);
  SetRows(dim, degree, n, b);
}

/* Computes the fits of all lanes, in a copy of the code for each dimension and degree. */
static ISPH_WIDE void FitLanes(PetscInt dim, PetscInt degree, PetscInt n, Stencil *const st[],
                               MlsBatch *b, Four *least)
{
  if (dim == 2 && degree == 2) FitInline(2, 2, n, st, b, least);
  else if (dim == 2 && degree == 3) FitInline(2, 3, n, st, b, least);
  else if (dim == 2) FitInline(2, 4, n, st, b, least);
  else if (degree == 2) FitInline(3, 2, n, st, b, least);
  else if (degree == 3) FitInline(3, 3, n, st, b, least);
  else FitInline(3, 4, n, st, b, least);
}

/* Returns true if all neighbours give values in the present fit. */
static PetscBool HasValuesOnly(const Stencil *st)
{
  for (PetscInt k = 0; st->n_wall && k < st->n; k++)
    if (st->equation[k] != EQUATION_VALUE) return PETSC_FALSE;
  return PETSC_TRUE;
}

/* MlsFitBatch - Computes the rows of the fits of several particles. Skips particles with neighbours
   that give derivatives or nothing, and those whose neighbours do not determine the fit: their rows
   are computed when a row function asks for them. Input: degree - of the fits, 2 to 4; count -
   number of stencils, at most MLS_BATCH; st - stencils of the particles. Output: st - the rows of
   their fits; in place of the gradient and the filter their coefficients, if the stencil has a
   place for them. */
PetscErrorCode MlsFitBatch(PetscInt degree, PetscInt count, Stencil *const st[], MlsBatch *b)
{
  Stencil *of_lane[MLS_BATCH];
  PetscInt lanes = 0, n = 0;
  Four     least;

  PetscFunctionBegin;
  for (PetscInt l = 0; l < count; l++) {
    if (!HasValuesOnly(st[l])) continue;
    of_lane[lanes++] = st[l];
    n                = PetscMax(n, st[l]->n);
  }
  if (!lanes) PetscFunctionReturn(PETSC_SUCCESS);
  b->rows = PETSC_FALSE;
  for (PetscInt l = 0; l < lanes; l++)
    if (!of_lane[l]->fit.coefficient) b->rows = PETSC_TRUE;
  PetscCall(BatchReserve(n, b));
  for (PetscInt l = lanes; l < MLS_BATCH; l++) of_lane[l] = of_lane[0]; /* repeated, not kept */
  for (PetscInt l = 0; l < MLS_BATCH; l++) FillLane(of_lane[l], l, n, b);
  FitLanes(st[0]->dim, degree, n, of_lane, b, &least);
  for (PetscInt l = 0; l < lanes; l++)
    if (least[l] > of_lane[l]->weak) KeepLane(b, degree, l, of_lane[l]);
  PetscFunctionReturn(PETSC_SUCCESS);
}
