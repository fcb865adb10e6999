/*
  Fits of several particles at once, one in each lane of a vector: the formulas are those of mls.c,
  for particles whose neighbours all give values. A fit alone spends most of its time on sums across
  lanes and on a system of a few unknowns; here no operation crosses lanes.
*/
#include "mls.h"
#include "mlsbatch.h"

/* A number of each particle. Unaligned, as PETSc allocates memory. */
typedef PetscReal Lanes
    __attribute__((vector_size(ISPH_LANES * sizeof(PetscReal)), aligned(sizeof(PetscReal))));

#define ROWS    (2 + ISPH_MAX_DIM) /* filter, Laplacian, gradient */
#define MOMENTS (MLS_MAX_TERMS * (MLS_MAX_TERMS + 1) / 2)

struct MlsBatch {
  PetscInt capacity;        /* neighbours */
  Lanes   *s[ISPH_MAX_DIM]; /* offsets of neighbours over the radius */
  Lanes   *W, *row[ROWS];   /* weights of neighbours in the fit and in the rows */
};

/* The systems of a batch. */
typedef struct {
  Lanes M[MOMENTS];             /* moments, then factors */
  Lanes pivot[MLS_MAX_TERMS];   /* and their inverses later */
  Lanes b[ROWS][MLS_MAX_TERMS]; /* right-hand sides, then solutions */
  Lanes m[MLS_MAX_TERMS], sum;  /* of the filter */
} Systems;

/* MlsBatchCreate - Creates the workspace of a batch; not collective */
PetscErrorCode MlsBatchCreate(MlsBatch **batch)
{
  PetscFunctionBegin;
  PetscCall(PetscNew(batch));
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

/* MlsBatchDestroy - Frees the workspace; not collective */
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

/* Computes the basis of neighbour k, see MlsBasis(). */
static ISPH_INLINE void Basis(PetscInt dim, PetscInt degree, const MlsBatch *b, PetscInt k,
                              Lanes phi[])
{
  PetscInt lower = 0, t = dim;

  for (PetscInt a = 0; a < dim; a++) phi[a] = b->s[a][k];
  for (PetscInt d = 2; d <= degree; d++) {
    for (PetscInt a = 0; a < dim; a++)
      for (PetscInt q = 0; q < MlsMonomials(a, d - 1); q++) phi[t++] = phi[a] * phi[lower + q];
    lower += MlsMonomials(dim - 1, d - 1);
  }
}

/* Computes the moments and the right-hand sides. */
static ISPH_INLINE void SetSystems(PetscInt dim, PetscInt degree, PetscInt n, Stencil *const st[],
                                   const MlsBatch *b, Systems *y)
{
  const PetscInt terms = MlsTerms(dim, degree);
  const Lanes    zero  = {0.0};
  Lanes          M[MOMENTS], m[MLS_MAX_TERMS];

  for (PetscInt e = 0; e < terms * (terms + 1) / 2; e++) M[e] = zero;
  for (PetscInt t = 0; t < terms; t++) m[t] = zero;
  y->sum = zero;
  for (PetscInt k = 0; k < n; k++) {
    Lanes    phi[MLS_MAX_TERMS];
    PetscInt e = 0;

    Basis(dim, degree, b, k, phi);
    y->sum += b->W[k];
    for (PetscInt t = 0; t < terms; t++) {
      const Lanes weighted = b->W[k] * phi[t];

      m[t] += weighted;
      for (PetscInt q = 0; q <= t; q++) M[e++] += weighted * phi[q];
    }
  }
  for (PetscInt e = 0; e < terms * (terms + 1) / 2; e++) y->M[e] = M[e];
  for (PetscInt t = 0; t < terms; t++) y->m[t] = y->b[0][t] = m[t];
  for (PetscInt r = 1; r < 2 + dim; r++)
    for (PetscInt t = 0; t < terms; t++) y->b[r][t] = zero;
  for (PetscInt l = 0; l < ISPH_LANES; l++) {
    const PetscReal over = 1.0 / st[l]->radius;

    y->sum[l] += st[l]->self[0];
    for (PetscInt a = 0; a < dim; a++) {
      const PetscReal slope = st[l]->stretch[a] * over;

      y->b[1][dim + a * (a + 1) / 2 + a][l] = 2.0 * PetscSqr(slope);
      y->b[2 + a][a][l]                     = slope;
    }
  }
}

/* Solves the systems by the factors L D L^T of M. Output: least - the least pivot over the diagonal
   entry of M, for each lane. */
static ISPH_INLINE void SolveSystems(PetscInt dim, PetscInt terms, Systems *y, Lanes *least)
{
  const Lanes zero = {0.0};

  *least = zero + PETSC_INFINITY;
  for (PetscInt j = 0; j < terms; j++) {
    Lanes *row = &y->M[j * (j + 1) / 2], share;

    y->pivot[j] = row[j];
    for (PetscInt k = 0; k < j; k++) { /* row j of L D, from the left */
      const Lanes *above = &y->M[k * (k + 1) / 2];

      for (PetscInt q = 0; q < k; q++) row[k] -= row[q] * above[q];
    }
    for (PetscInt k = 0; k < j; k++) {
      const Lanes factor = row[k] * y->pivot[k]; /* inverse pivots of earlier rows */

      y->pivot[j] -= factor * row[k];
      row[k] = factor;
    }
    share = y->pivot[j] / row[j];
    for (PetscInt l = 0; l < ISPH_LANES; l++)
      (*least)[l] = share[l] < (*least)[l] || share[l] != share[l] ? share[l] : (*least)[l];
    y->pivot[j] = 1.0 / y->pivot[j];
  }
  for (PetscInt r = 0; r < 2 + dim; r++) {
    Lanes *x = y->b[r];

    for (PetscInt j = 1; j < terms; j++)
      for (PetscInt k = 0; k < j; k++) x[j] -= y->M[j * (j + 1) / 2 + k] * x[k];
    for (PetscInt j = 0; j < terms; j++) x[j] *= y->pivot[j];
    for (PetscInt j = terms - 1; j > 0; j--)
      for (PetscInt k = 0; k < j; k++) x[k] -= y->M[j * (j + 1) / 2 + k] * x[j];
  }
}

/* Computes the weights of all rows from the solutions. */
static ISPH_INLINE void SetRows(PetscInt dim, PetscInt degree, PetscInt n, MlsBatch *b, Systems *y)
{
  const PetscInt terms = MlsTerms(dim, degree);
  Lanes          x[ROWS][MLS_MAX_TERMS], per_sum;

  for (PetscInt r = 0; r < 2 + dim; r++)
    for (PetscInt t = 0; t < terms; t++) x[r][t] = y->b[r][t];
  for (PetscInt t = 0; t < terms; t++) y->sum -= y->m[t] * x[0][t];
  per_sum = 1.0 / y->sum;
  for (PetscInt k = 0; k < n; k++) {
    Lanes phi[MLS_MAX_TERMS];

    Basis(dim, degree, b, k, phi);
    for (PetscInt r = 0; r < 2 + dim; r++) {
      Lanes sum = x[r][0] * phi[0];

      for (PetscInt t = 1; t < terms; t++) sum += x[r][t] * phi[t];
      b->row[r][k] = r == 0 ? b->W[k] * (sum - 1.0) * per_sum : b->W[k] * sum;
    }
  }
}

/* Copies the rows of a lane to the fit of its particle. */
static void KeepLane(const MlsBatch *b, PetscInt degree, PetscInt lane, Stencil *st)
{
  PetscReal *to[ROWS] = {st->fit.filter, st->fit.laplacian};

  for (PetscInt a = 0; a < st->dim; a++) to[2 + a] = st->fit.gradient[a];
  for (PetscInt r = 0; r < 2 + st->dim; r++)
    for (PetscInt k = 0; k < st->n; k++) to[r][k] = b->row[r][k][lane];
  st->fit.wanted = st->fit.degree = degree;
}

static ISPH_INLINE void FitInline(PetscInt dim, PetscInt degree, PetscInt n, Stencil *const st[],
                                  MlsBatch *b, Lanes *least)
{
  Systems y;

  SetSystems(dim, degree, n, st, b, &y);
  SolveSystems(dim, MlsTerms(dim, degree), &y, least);
  SetRows(dim, degree, n, b, &y);
}

/* Computes the fits of all lanes, in a copy of the code for each dimension and degree. */
static ISPH_WIDE void FitLanes(PetscInt dim, PetscInt degree, PetscInt n, Stencil *const st[],
                               MlsBatch *b, Lanes *least)
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

/*
  MlsFitBatch - Computes the rows of the fits of several particles

  Not collective. Skips particles with neighbours that give derivatives or nothing, and those whose
  neighbours do not determine the fit: their rows are computed when a row function asks for them.

  Input Parameters:
+ degree - of the fits, 2 to 4
. count  - number of stencils, at most ISPH_LANES
- st     - stencils of the particles

  Output Parameter:
. st - the rows of their fits
*/
PetscErrorCode MlsFitBatch(PetscInt degree, PetscInt count, Stencil *const st[], MlsBatch *b)
{
  Stencil *of_lane[ISPH_LANES];
  PetscInt lanes = 0, n = 0;
  Lanes    least;

  PetscFunctionBegin;
  for (PetscInt l = 0; l < count; l++) {
    if (!HasValuesOnly(st[l])) continue;
    of_lane[lanes++] = st[l];
    n                = PetscMax(n, st[l]->n);
  }
  if (!lanes) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(BatchReserve(n, b));
  for (PetscInt l = lanes; l < ISPH_LANES; l++) of_lane[l] = of_lane[0]; /* repeated, not kept */
  for (PetscInt l = 0; l < ISPH_LANES; l++) FillLane(of_lane[l], l, n, b);
  FitLanes(st[0]->dim, degree, n, of_lane, b, &least);
  for (PetscInt l = 0; l < lanes; l++)
    if (least[l] > of_lane[l]->weak) KeepLane(b, degree, l, of_lane[l]);
  PetscFunctionReturn(PETSC_SUCCESS);
}
