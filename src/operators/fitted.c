/* Rows that no array stores. If particles move, the gradients and the filter of the velocity are
   applied once in a step, so the rows of a particle are not worth their memory. Its coefficients in
   the fit are kept instead, see (rows:sums), (rows:from-sums) and (rows:residual-sums) in
   theory.md: a product sums the moments of the field over the neighbours, and multiplies them by
   these coefficients. The moments serve all rows of a particle. Neighbours have the weights and the
   offsets of the assembly, computed anew. */
#include "fitted.h"
#include "fits/lanemonomials.h"

/* Arrays over neighbours end in zeros up to a multiple of 4. */
struct FittedRows {
  PetscInt         dim, degree, terms, stride; /* coefficients of a particle */
  const KernelRow *kernel;
  PetscReal        h_over_dx;
  PetscInt         moved;       /* stamp of the positions */
  PetscReal       *coefficient; /* at [stride i]: of the gradient, of the filter */
  PetscInt         capacity, longest;
  PetscReal       *s[ISPH_MAX_DIM]; /* offsets over the radius */
  PetscReal       *r, *W, *dW, *ddW;
  PetscReal       *difference; /* W_k (f_k - f_i) */
  PetscInt        *j;
};

/* FittedCreate - Creates the rows of fits of the chosen degree; filters - the filter is one of
   them */
PetscErrorCode FittedCreate(const OperatorForms *forms, PetscInt dim, PetscBool filters,
                            FittedRows **rows)
{
  FittedRows *f;

  PetscFunctionBegin;
  PetscCall(PetscNew(&f));
  f->dim       = dim;
  f->degree    = forms->degree;
  f->terms     = MlsTerms(dim, forms->degree);
  f->stride    = dim * f->terms + (filters ? 1 + f->terms : 0);
  f->kernel    = forms->kernel;
  f->h_over_dx = forms->h_over_dx;
  *rows        = f;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FreeNeighbors(FittedRows *f)
{
  PetscFunctionBegin;
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) PetscCall(PetscFree(f->s[a]));
  PetscCall(PetscFree6(f->r, f->W, f->dW, f->ddW, f->difference, f->j));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FittedDestroy - Frees the rows */
PetscErrorCode FittedDestroy(FittedRows **rows)
{
  PetscFunctionBegin;
  if (!*rows) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FreeNeighbors(*rows));
  PetscCall(FreeAll(&(*rows)->coefficient, rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FittedReserve - Makes room for the coefficients of all own particles, and for the neighbours of a
   product; longest - of the lists of neighbours, the particle included */
PetscErrorCode FittedReserve(const Particles *p, PetscInt longest, FittedRows *f)
{
  PetscFunctionBegin;
  f->moved = p->moved;
  if (p->n_fluid > f->capacity) {
    f->capacity = p->n_fluid + p->n_fluid / 8;
    PetscCall(PetscFree(f->coefficient));
    PetscCall(PetscMalloc1(f->stride * f->capacity, &f->coefficient));
  }
  if (longest + 4 <= f->longest) PetscFunctionReturn(PETSC_SUCCESS);
  f->longest = 2 * longest + 4;
  PetscCall(FreeNeighbors(f));
  for (PetscInt a = 0; a < f->dim; a++) PetscCall(PetscMalloc1(f->longest, &f->s[a]));
  PetscCall(PetscMalloc6(f->longest, &f->r, f->longest, &f->W, f->longest, &f->dW, f->longest,
                         &f->ddW, f->longest, &f->difference, f->longest, &f->j));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FittedPlace - Asks the batch of a stencil for coefficients in place of rows */
void FittedPlace(const FittedRows *f, Stencil *st)
{
  st->fit.coefficient = f->coefficient + (size_t)f->stride * (size_t)st->i;
  st->fit.with_filter = f->stride > f->dim * f->terms;
}

/* Lists the neighbours of particle i over fluid, itself included, and over walls; returns their
   number. */
static PetscInt ListNeighbors(const OperatorRows *rows, PetscInt i, PetscInt j[])
{
  PetscInt n = 0;

  for (PetscInt s = rows->fluid.row[i]; s < rows->fluid.row[i + 1]; s++)
    j[n++] = rows->fluid.local[s];
  for (PetscInt s = rows->walls.row ? rows->walls.row[i] : 0;
       rows->walls.row && s < rows->walls.row[i + 1]; s++)
    j[n++] = rows->walls.local[s];
  return n;
}

/* Computes the offsets of n neighbours from particle i over the radius, and their weights in the
   fit; pads the arrays. */
static ISPH_INLINE void SetNeighbors(PetscInt dim, const Particles *p, PetscInt i, PetscInt n,
                                     FittedRows *f)
{
  const PetscReal h = f->h_over_dx * p->dx[i], radius = f->kernel->support * h;
  PetscReal      *r = f->r;

  for (PetscInt a = 0; a < dim; a++) {
    const PetscReal *x = p->x[a], own = x[i], over = ParticlesStretch(p, a, i) / radius;
    PetscReal       *s = f->s[a];

    for (PetscInt k = 0; k < n; k++) s[k] = over * (x[f->j[k]] - own);
    for (PetscInt k = n; k % 4; k++) s[k] = 0.0;
  }
  for (PetscInt k = 0; k < n; k++) {
    PetscReal r2 = 0.0;

    for (PetscInt a = 0; a < dim; a++) r2 += PetscSqr(f->s[a][k]);
    r[k] = radius * PetscSqrtReal(r2);
  }
  KernelEvaluateAll(f->kernel, dim, h, n, r, f->W, f->dW, f->ddW);
}

/* Computes the moments of a field, sum_k W_k phi_t(k) (f_k - f_i), those of phi_t = 1 first. Input:
   value - of the field at [step j]. */
static ISPH_INLINE void SumMoments(PetscInt dim, PetscInt degree, PetscInt n,
                                   const PetscReal value[], PetscInt step, PetscReal own,
                                   FittedRows *f, PetscReal m[])
{
  const PetscInt terms      = MlsTerms(dim, degree);
  PetscReal     *difference = f->difference;
  Four           sum[1 + MLS_MAX_TERMS];

  for (PetscInt k = 0; k < n; k++) difference[k] = f->W[k] * (value[step * f->j[k]] - own);
  for (PetscInt k = n; k % 4; k++) difference[k] = 0.0;
  for (PetscInt t = 0; t <= terms; t++) sum[t] = (Four){0.0};
  for (PetscInt k = 0; k < n; k += 4) {
    Four s[ISPH_MAX_DIM], phi[1 + MLS_MAX_TERMS];

    phi[0] = *FourAt(&difference[k]);
    for (PetscInt a = 0; a < dim; a++) {
      s[a]       = *FourAt(&f->s[a][k]);
      phi[1 + a] = phi[0] * s[a];
    }
    FourMonomials(dim, degree, s, phi + 1);
#pragma GCC unroll 16
    for (PetscInt t = 0; t <= terms; t++) sum[t] += phi[t];
  }
  for (PetscInt t = 0; t <= terms; t++) m[t] = FourSum(&sum[t]);
}

/* Returns the product of a row of the fit of particle i from the moments of the field. */
static inline PetscReal RowOfMoments(const FittedRows *f, PetscInt i, FitRow row,
                                     const PetscReal m[])
{
  const PetscReal *c   = f->coefficient + (size_t)f->stride * (size_t)i;
  PetscReal        sum = 0.0;

  if (row == FIT_FILTER) {
    c += f->dim * f->terms;
    sum = c[f->terms] * m[0];
  } else {
    c += (row - FIT_GRADIENT) * f->terms;
  }
  for (PetscInt t = 0; t < f->terms; t++) sum += c[t] * m[1 + t];
  return sum;
}

/* Returns the product of row i of an operator that stores it. */
static PetscReal RowApart(const OperatorRows *rows, const AffineOperator *op, PetscInt i,
                          const PetscReal value[], PetscInt step)
{
  const PetscReal *a     = op->apart + rows->apart[i];
  const Pattern   *fluid = &rows->fluid, *walls = &rows->walls;
  PetscReal        sum = 0.0;

  for (PetscInt s = fluid->row[i]; s < fluid->row[i + 1]; s++)
    sum += a[s - fluid->row[i]] * value[step * fluid->local[s]];
  if (!op->b) return sum;
  for (PetscInt s = walls->row[i]; s < walls->row[i + 1]; s++)
    sum += op->b[s] * value[step * walls->local[s]];
  return sum;
}

static inline void StoreProduct(const FittedProducts *to, PetscInt c, PetscInt k, PetscInt i,
                                PetscReal product)
{
  to->y[c][k][i] = to->add ? to->y[c][k][i] + product : product;
}

/* Computes all products, see FittedApply(). Inlined, so that the compiler knows the number of
   terms. */
static ISPH_INLINE void ApplyInline(PetscInt dim, PetscInt degree, const FittedProducts *to,
                                    const OperatorRows *rows)
{
  FittedRows    *f    = rows->fitted;
  const PetscInt step = to->fields;

  for (PetscInt i = 0; i < rows->fluid.n; i++) {
    PetscInt n;

    if (rows->apart[i] >= 0) {
      for (PetscInt e = 0; e < to->fields * to->n; e++) {
        const PetscInt c = e / to->n, k = e % to->n;

        StoreProduct(to, c, k, i, RowApart(rows, to->op[c][k], i, rows->value + c, step));
      }
      continue;
    }
    n = ListNeighbors(rows, i, f->j);
    SetNeighbors(dim, rows->particles, i, n, f);
    for (PetscInt c = 0; c < to->fields; c++) {
      PetscReal m[1 + MLS_MAX_TERMS];

      SumMoments(dim, degree, n, rows->value + c, step, rows->value[step * i + c], f, m);
      for (PetscInt k = 0; k < to->n; k++)
        StoreProduct(to, c, k, i, RowOfMoments(f, i, to->op[c][k]->fitted, m));
    }
  }
}

static ISPH_WIDE void ApplyWide(const FittedProducts *to, const OperatorRows *rows)
{
  const PetscInt degree = rows->fitted->degree;

  if (rows->fitted->dim == 2 && degree == 2) ApplyInline(2, 2, to, rows);
  else if (rows->fitted->dim == 2) ApplyInline(2, degree, to, rows);
  else if (degree == 2) ApplyInline(3, 2, to, rows);
  else ApplyInline(3, degree, to, rows);
}

/*
  FittedApply - Computes the products of operators whose rows are made from fits

    grad_a f = sum_t c_at m_t,   m_t = sum_k W_k phi_t(X_k/R) (f_k - f_i),

  and the filter in the same way, theory.md, (rows:sums), (rows:from-sums) and (rows:residual-sums).
  Input: the fields by local index, halo included, in rows->value at [fields j + field], with zeros
  in place of absent data.
*/
PetscErrorCode FittedApply(const FittedProducts *to, const OperatorRows *rows)
{
  PetscFunctionBegin;
  PetscCheck(rows->fitted->moved == rows->particles->moved, PETSC_COMM_SELF, PETSC_ERR_ORDER,
             "Particles have moved since the assembly of the operators");
  ApplyWide(to, rows);
  PetscFunctionReturn(PETSC_SUCCESS);
}
