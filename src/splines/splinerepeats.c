/*
  The matrix of the pressure increment on a lattice of fixed particles, where most rows repeat. Row
  q of A is a sum over the points of quadrature g in the support of spline q,

    A_q = scale^2 sum_g V_g sum_a dpsi_q/dx_a(x_g) F_a(g),   F_a(g) = sum_k w_k dchi/dx_a(x_k),

  with the fit w at point g. Points with equal F and equal psi have one number, so rows with the
  same numbers at the same points are equal, and only different rows are computed.
*/
#include "splines.h"

#define SAME        1e-11 /* relative difference of equal values; places in cells have rounding */
#define HEAD        3     /* entries before a row of F: place, slopes, and volume of the point */
#define MOST_POINTS (27 << ISPH_MAX_DIM) /* in the support of a spline without masters */

/* All that the rows are computed from. */
typedef struct {
  const Splines   *s;
  const Particles *p;
  PetscInt        *point; /* first point in each cell */
  SplineRows      *fits;  /* F */
  SplineEntries    row;
  PetscInt        *spline; /* of each stored row: the spline that it was computed for */
} Product;

/* Adds w times the gradient of the splines chi at particle i to component a of the row, or to all
   components with a = -1: component b of the gradient. */
static PetscErrorCode AddGradient(const Splines *s, PetscInt i, PetscReal w, const PetscInt ab[2],
                                  SplineEntries *row)
{
  const PetscInt      dim = s->lattice.dim, n = s->pressure.degree + 1;
  const SplineWindow *window = &s->window;
  PetscReal           b[ISPH_MAX_DIM][SPLINES_ALONG], d[ISPH_MAX_DIM][SPLINES_ALONG];

  PetscFunctionBegin;
  for (PetscInt a = 0; a < dim; a++)
    SplineBasis(s->pressure.degree, s->at.t[a][i], s->at.per_edge[a][i], b[a], d[a]);
  for (PetscInt k = 0; k < SplinesAtPoint(&s->pressure); k++) {
    const PetscInt  e[ISPH_MAX_DIM] = {k % n, k / n % n, k / (n * n)};
    const PetscReal z               = dim == 3 ? b[2][e[2]] : 1.0;
    const PetscReal slope[]         = {d[0][e[0]] * b[1][e[1]] * z, b[0][e[0]] * d[1][e[1]] * z,
                               dim == 3 ? b[0][e[0]] * b[1][e[1]] * d[2][e[2]] : 0.0};
    const PetscInt  q = s->at.base[i] + e[0] + window->n[0] * (e[1] + window->n[1] * e[2]);

    for (PetscInt m = window->start[q]; m < window->start[q + 1]; m++) {
      const PetscReal factor              = w * window->weight[m];
      PetscReal       value[ISPH_MAX_DIM] = {0.0};

      for (PetscInt a = 0; a < dim; a++) {
        if (ab[0] < 0) value[a] = factor * slope[a];
        else if (a == ab[0]) value[a] = factor * slope[ab[1]];
      }
      PetscCall(SplineEntriesAdd(window->number[window->source[m]], value, row));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds a fit of component b at a point to component a of its row of F. */
static PetscErrorCode AddFit(const Splines *s, const Particles *p, const PetscInt range[2],
                             const PetscInt ab[2], SplineEntries *row)
{
  PetscFunctionBegin;
  for (PetscInt k = range[0]; k < range[1]; k++) {
    const PetscInt j = s->fits.j[k];

    if (!ParticlesIsWall(p, j))
      PetscCall(AddGradient(s, p->row[j] - p->row[0], s->fits.w[k], ab, row));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the row of F at point g. */
static PetscErrorCode RowOfFit(const Splines *s, const Particles *p, PetscInt g, SplineEntries *row)
{
  const SplineFits *f = &s->fits;

  PetscFunctionBegin;
  SplineEntriesClear(row);
  if (SplineFitIsSingle(p->dim, f, g)) {
    PetscCall(
        AddFit(s, p, (PetscInt[]){f->first[0][0][g], f->last[0][0][g]}, (PetscInt[]){-1, -1}, row));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (PetscInt a = 0; a < p->dim; a++) {
    for (PetscInt b = 0; b < p->dim; b++) {
      if (a == b || f->coupled)
        PetscCall(AddFit(s, p, (PetscInt[]){f->first[a][b][g], f->last[a][b][g]},
                         (PetscInt[]){a, b}, row));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns true if the splines psi at point g are unknowns that follow each other as in the window
   without a period or a body. */
static PetscBool IsPlain(const Splines *s, PetscInt g)
{
  const SplineWindow *w    = &s->window;
  const PetscInt      base = s->inside_at.base[g];
  const PetscInt      zero = w->number[w->source[w->start[base]]];

  if (s->inside.side[g] >= 0) return PETSC_FALSE;
  for (PetscInt k = 0; k < SplinesAtPoint(&s->lattice); k++) {
    const PetscInt q      = base + k % 3 + w->n[0] * (k / 3 % 3 + w->n[1] * (k / 9));
    const PetscInt number = zero + k % 3 + s->own.n[0] * (k / 3 % 3 + s->own.n[1] * (k / 9));

    if (w->start[q + 1] != w->start[q] + 1 || w->weight[w->start[q]] != 1.0 ||
        w->number[w->source[w->start[q]]] != number)
      return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* Sets the entries before the row of F that was stored last: all on which psi at point g
   depends. */
static void SetHead(const Splines *s, PetscInt g, SplineRows *r)
{
  const PetscInt at    = r->first[r->stored - 1];
  PetscReal     *value = r->value + at * r->each;

  for (PetscInt e = 0; e < HEAD; e++) r->offset[at + e] = 0;
  for (PetscInt a = 0; a < r->each; a++) {
    value[a]               = s->inside_at.t[a][g];
    value[r->each + a]     = s->inside_at.per_edge[a][g] * s->lattice.side[a];
    value[2 * r->each + a] = s->inside.weight[g];
  }
}

/* Returns true if two stored rows are equal. */
static PetscBool AreEqual(const SplineRows *r, PetscInt i, PetscInt c)
{
  const PetscInt   n    = r->first[i + 1] - r->first[i];
  const PetscReal *of_i = r->value + r->first[i] * r->each,
                  *of_c = r->value + r->first[c] * r->each;
  PetscReal largest[2]  = {0.0, 0.0}; /* in the head, and in the row */

  if (r->first[c + 1] - r->first[c] != n) return PETSC_FALSE;
  for (PetscInt e = 0; e < n; e++)
    if (r->offset[r->first[i] + e] != r->offset[r->first[c] + e]) return PETSC_FALSE;
  for (PetscInt k = 0; k < n * r->each; k++)
    largest[k >= HEAD * r->each] = PetscMax(largest[k >= HEAD * r->each], PetscAbsReal(of_i[k]));
  for (PetscInt k = 0; k < n * r->each; k++)
    if (PetscAbsReal(of_i[k] - of_c[k]) > SAME * largest[k >= HEAD * r->each]) return PETSC_FALSE;
  return PETSC_TRUE;
}

/* Drops the row that was stored last, that of point g, if an earlier one is equal. */
static void JoinPoint(PetscInt g, SplineRows *r)
{
  const PetscInt last = r->stored - 1, n = r->first[last + 1] - r->first[last];
  PetscInt       at = SplineRowsPlace(n, r->offset + r->first[last], r);

  while (r->table[at] >= 0 && !AreEqual(r, last, r->table[at])) at = (at + 1) & (r->size - 1);
  if (r->table[at] < 0) {
    r->table[at] = last;
    return;
  }
  r->of[g] = r->table[at];
  r->stored--;
}

/* Computes F at all points; complete: false if too few rows repeat. */
static PetscErrorCode ComputeFits(Product *t, PetscBool *complete)
{
  const Splines      *s = t->s;
  const SplineWindow *w = &s->window;
  SplineRows         *r;

  PetscFunctionBegin;
  PetscCall(SplineRowsCreate(s->inside.n, s->lattice.dim, &t->fits));
  r = t->fits;
  PetscCall(PetscMalloc1(r->n, &r->base));
  t->row.each = r->each;
  for (PetscInt g = 0; g < r->n; g++) {
    r->base[g] = w->number[w->source[w->start[s->inside_at.base[g]]]];
    PetscCall(RowOfFit(s, t->p, g, &t->row));
    PetscCall(SplineRowsStore(&t->row, HEAD, g, r));
    SetHead(s, g, r);
    if (IsPlain(s, g)) JoinPoint(g, r);
    if (r->stored > r->most) break;
  }
  SplineEntriesClear(&t->row);
  *complete = r->stored <= r->most;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Counts the points in each cell. */
static PetscErrorCode ListPoints(Product *t)
{
  const SplineLattice *l                  = &t->s->lattice;
  const PetscInt       zero[ISPH_MAX_DIM] = {0};
  PetscInt             cells              = 1;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < l->dim; a++) cells *= l->cells[a];
  PetscCall(PetscMalloc1(cells + 1, &t->point));
  t->point[0] = 0;
  for (PetscInt c = 0; c < cells; c++) {
    PetscInt  cell[ISPH_MAX_DIM], node;
    PetscReal x[ISPH_MAX_DIM];

    SplineIndex(l->dim, zero, l->cells, c, cell);
    t->point[c + 1] = t->point[c];
    for (PetscInt k = 0; k < 1 << l->dim; k++)
      if (SplinePoint(t->s, cell, k, x, &node) > 0.0 && SplineHolds(t->s, t->p, node, x))
        t->point[c + 1]++;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The cells in the support of a spline. */
typedef struct {
  PetscInt cells, first[ISPH_MAX_DIM], n[ISPH_MAX_DIM];
} Support;

/* Sets the support of own spline q; returns false if q is no unknown. */
static PetscBool SupportOf(const Product *t, PetscInt q, Support *support)
{
  PetscInt index[ISPH_MAX_DIM];

  if (!SplineOwn(t->s, q, index)) return PETSC_FALSE;
  support->cells = SplineSupport(t->s, index, support->first, support->n);
  return PETSC_TRUE;
}

/* Computes the range of points in cell k of a support, empty outside the box. */
static void PointsOf(const Product *t, const Support *support, PetscInt k, PetscInt range[2])
{
  const SplineLattice *l = &t->s->lattice;
  PetscInt             cell[ISPH_MAX_DIM], c;

  range[0] = range[1] = 0;
  if (!SplineBlockCell(l, support->first, support->n, k, cell)) return;
  c        = cell[0] + l->cells[0] * (cell[1] + (l->dim == 3 ? l->cells[1] * cell[2] : 0));
  range[0] = t->point[c];
  range[1] = t->point[c + 1];
}

/* Computes the numbers of the points in the support of spline q, on which its row depends; returns
   their number, 0: too many, or q is no unknown. */
static PetscInt KeyOf(const Product *t, PetscInt q, PetscInt key[])
{
  PetscInt n = 0, range[2];
  Support  support;

  if (!SupportOf(t, q, &support) || support.cells > 27) return 0;
  for (PetscInt k = 0; k < support.cells; k++) {
    PointsOf(t, &support, k, range);
    for (PetscInt g = range[0]; g < range[1]; g++) {
      key[n++] = t->fits->of[g];
      key[n++] = t->fits->base[g] - q;
    }
  }
  return n;
}

/* Adds factor times the row of F at point g, times the gradient t of psi_q there. */
static PetscErrorCode AddPointRow(const SplineRows *fits, PetscInt g, PetscReal factor,
                                  const PetscReal gradient[], SplineEntries *row)
{
  PetscFunctionBegin;
  for (PetscInt e = fits->first[fits->of[g]] + HEAD; e < fits->first[fits->of[g] + 1]; e++) {
    PetscReal sum = 0.0;

    for (PetscInt a = 0; a < fits->each; a++) sum += gradient[a] * fits->value[e * fits->each + a];
    sum *= factor;
    PetscCall(SplineEntriesAdd(fits->base[g] + fits->offset[e], &sum, row));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the integrals of the gradient of psi_q of point g; returns false if they are zero. */
static PetscBool GradientOf(const Splines *s, PetscInt g, PetscInt q, PetscReal gradient[])
{
  const SplineWindow *w   = &s->window;
  PetscBool           any = PETSC_FALSE;
  PetscReal           value[ISPH_MAX_DIM][SPLINES_AT_QUADRATIC];

  for (PetscInt a = 0; a < s->lattice.dim; a++) {
    gradient[a] = 0.0;
    SplinePointIntegrals(s, g, a, value[a]);
  }
  for (PetscInt k = 0; k < SplinesAtPoint(&s->lattice); k++) {
    const PetscInt at = s->inside_at.base[g] + k % 3 + w->n[0] * (k / 3 % 3 + w->n[1] * (k / 9));

    for (PetscInt m = w->start[at]; m < w->start[at + 1]; m++) {
      if (w->number[w->source[m]] != q) continue;
      any = PETSC_TRUE;
      for (PetscInt a = 0; a < s->lattice.dim; a++) gradient[a] += w->weight[m] * value[a][k];
    }
  }
  return any;
}

/* Computes the row of spline q; a spline that is no unknown has the equation phi = 0. */
static PetscErrorCode ComputeRow(Product *t, PetscInt q)
{
  const PetscReal one = 1.0, factor = PetscSqr(t->s->scale);
  PetscInt        range[2];
  Support         support;

  PetscFunctionBegin;
  SplineEntriesClear(&t->row);
  if (!SupportOf(t, q, &support)) {
    PetscCall(SplineEntriesAdd(q, &one, &t->row));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (PetscInt k = 0; k < support.cells; k++) {
    PointsOf(t, &support, k, range);
    for (PetscInt g = range[0]; g < range[1]; g++) {
      PetscReal gradient[ISPH_MAX_DIM];

      if (GradientOf(t->s, g, q, gradient))
        PetscCall(AddPointRow(t->fits, g, factor, gradient, &t->row));
    }
  }
  PetscCall(PetscSortIntWithScalarArray(t->row.n, t->row.column, t->row.value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets row q: finds an equal row, or computes it. */
static PetscErrorCode SetRow(Product *t, PetscInt q, SplineRows *r)
{
  PetscInt       key[2 * MOST_POINTS], other[2 * MOST_POINTS];
  const PetscInt n  = KeyOf(t, q, key);
  PetscInt       at = SplineRowsPlace(n, key, r);

  PetscFunctionBegin;
  for (; n && r->table[at] >= 0; at = (at + 1) & (r->size - 1)) {
    PetscBool equal;

    if (KeyOf(t, t->spline[r->table[at]], other) != n) continue;
    PetscCall(PetscArraycmp(key, other, n, &equal));
    if (!equal) continue;
    r->of[q] = r->table[at];
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(ComputeRow(t, q));
  if (n && r->stored < r->most) r->table[at] = r->stored;
  t->spline[r->stored] = q;
  PetscCall(SplineRowsStore(&t->row, 0, q, r));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  SplineRowsCompute - Computes the rows of the matrix of the pressure increment

  Not collective; for a single rank with fixed particles. Output: rows - NULL if too few repeat.
*/
PetscErrorCode SplineRowsCompute(const Splines *s, const Particles *p, SplineRows **rows)
{
  const PetscInt n        = s->own.size;
  Product        t        = {.s = s, .p = p};
  PetscBool      complete = PETSC_FALSE;

  PetscFunctionBegin;
  *rows = NULL;
  PetscCall(PetscMalloc1(n, &t.row.place));
  for (PetscInt k = 0; k < n; k++) t.row.place[k] = -1;
  PetscCall(ComputeFits(&t, &complete));
  if (complete) {
    PetscCall(ListPoints(&t));
    PetscCall(PetscMalloc1(n, &t.spline));
    PetscCall(SplineRowsCreate(n, 1, rows));
    t.row.each = 1;
    for (PetscInt q = 0; q < n; q++) PetscCall(SetRow(&t, q, *rows));
  }
  PetscCall(SplineRowsDestroy(&t.fits));
  PetscCall(PetscFree(t.row.place));
  PetscCall(PetscFree(t.row.column));
  PetscCall(PetscFree(t.row.value));
  PetscCall(PetscFree(t.point));
  PetscCall(PetscFree(t.spline));
  PetscFunctionReturn(PETSC_SUCCESS);
}
