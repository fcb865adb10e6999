/*
  Extended B-splines beside bodies. A spline with little fluid in its support has a small row in the
  divergence, and the pressure there would be badly determined. Its coefficient is no unknown, but
  extrapolated from the nearest block of splines with enough fluid, its masters:

    p_q = sum_m E_qm p_m,   psi_m <- psi_m + sum_q E_qm psi_q

  with a block of three splines along each axis quadratic sequences are kept. The splines still sum
  to 1.

  The outermost spline q beside a side that gives the pressure is followed by spline r inside. Its
  own number is given, c_q = 2 p(side), and its coefficient is c_q - p_r: the sum of both is the
  pressure on the side, and spline r is psi_r - psi_q, which is zero there. So its masters are q and
  r, or q and the masters of r.

  Reference: K. Hoellig, U. Reif, J. Wipper, SIAM J. Numer. Anal. 39 (2001) 442-462
*/
#include "splines.h"
#include "isph/fits.h"

#define EXTENSION_RIDGE 1e-3 /* of fits of masters, over the sum of their weights */
#define ENOUGH          0.35 /* least share of the weight of a spline that is in the fluid [-] */

/* The splines while their masters are sought. */
typedef struct {
  PetscReal *fluid, *box; /* int psi over the fluid, and over the box [cells] */
  PetscReal
      *offset[ISPH_MAX_DIM]; /* centroid of the fluid, from the centre of the spline [cells] */
  PetscBool *enough;
} Work;

/* Computes the index of the spline `step` after an index; returns its number, -1 outside the box.
 */
static PetscInt StepTo(const SplineLattice *l, const PetscInt from[], const PetscInt step[],
                       PetscInt to[])
{
  for (PetscInt a = 0; a < l->dim; a++) {
    to[a] = from[a] + step[a];
    if (l->periodic[a]) to[a] = (to[a] + 2 * l->count[a]) % l->count[a];
    else if (to[a] < 0 || to[a] >= l->count[a]) return -1;
  }
  return SplineNatural(l, to);
}

/* SplineOfCell - Computes the index of spline k of a cell; returns its number; not collective */
PetscInt SplineOfCell(const SplineLattice *l, const PetscInt cell[], PetscInt k, PetscInt index[])
{
  PetscInt step[ISPH_MAX_DIM] = {k % 3, k / 3 % 3, k / 9};

  for (PetscInt a = 0; a < l->dim; a++) step[a] -= l->periodic[a] ? 1 : 0;
  return StepTo(l, cell, step, index);
}

/* Adds parts of int psi over the fluid and over the box, of spline k of a cell, at a point. */
static void AddIntegral(const SplineLattice *l, const PetscInt cell[], PetscInt k,
                        const PetscReal x[], PetscReal fluid, PetscReal box, Work *w)
{
  const PetscInt digit[ISPH_MAX_DIM] = {k % 3, k / 3 % 3, k / 9};
  PetscInt       index[ISPH_MAX_DIM];
  const PetscInt q = SplineOfCell(l, cell, k, index);

  w->fluid[q] += fluid;
  w->box[q] += box;
  for (PetscInt a = 0; a < l->dim; a++)
    w->offset[a][q] += fluid * ((x[a] - l->lo[a]) / l->side[a] - cell[a] - (digit[a] - 0.5));
}

/* Integrates all splines over the fluid and over the box. */
static void Integrate(const SplineLattice *l, const SplineBodies *s, Work *w)
{
  const PetscInt corners = 1 << l->dim, n = SplinesAtPoint(l);
  PetscInt       cells = 1;

  for (PetscInt a = 0; a < l->dim; a++) cells *= l->cells[a];
  for (PetscInt e = 0; e < cells * corners; e++) {
    const PetscInt  c = e / corners, corner = e % corners;
    const PetscReal fluid = s->cut[c] < 0 ? s->fraction[c] / corners : 0.0;
    PetscInt        cell[ISPH_MAX_DIM];
    PetscReal       x[ISPH_MAX_DIM];
    SplineValues    at;

    SplineIndex(l->dim, NULL, l->cells, c, cell);
    for (PetscInt a = 0; a < l->dim; a++)
      x[a] = l->lo[a] + (cell[a] + 0.5 + ((corner >> a) % 2 ? GAUSS : -GAUSS)) * l->side[a];
    SplinesAt(l, x, &at);
    for (PetscInt k = 0; k < n; k++)
      AddIntegral(l, cell, k, x, fluid * at.value[k], at.value[k] / corners, w);
    if (s->cut[c] < 0) continue;
    SplineCutNode(l->dim, &s->cuts[s->cut[c]], corner, x);
    for (PetscInt k = 0; k < n; k++)
      AddIntegral(l, cell, k, x, s->cuts[s->cut[c]].integral[corner * (1 + l->dim) * n + k], 0.0,
                  w);
  }
}

/* Returns true if a block of m splines along each axis, whose first is `first` after an index, has
   enough fluid. */
static PetscBool BlockIsComplete(const SplineLattice *l, const Work *w, const PetscInt index[],
                                 const PetscInt first[], PetscInt m)
{
  const PetscInt n[ISPH_MAX_DIM] = {m, m, m};

  for (PetscInt k = 0; k < PetscPowInt(m, l->dim); k++) {
    PetscInt step[ISPH_MAX_DIM], to[ISPH_MAX_DIM], q;

    SplineIndex(l->dim, first, n, k, step);
    q = StepTo(l, index, step, to);
    if (q < 0 || !w->enough[q]) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* Computes the weights of Lagrange's polynomials of degree m - 1 through 0, 1, ... at t. */
static void LagrangeWeights(PetscInt m, PetscReal t, PetscReal weight[])
{
  for (PetscInt k = 0; k < m; k++) {
    weight[k] = 1.0;
    for (PetscInt e = 0; e < m; e++) weight[k] *= e == k ? 1.0 : (t - e) / (k - e);
  }
}

/* Finds the complete block of m splines along each axis nearest to the fluid of spline q, within 4
   cells; returns false if there is none. Equal distances are decided by the order of the search. */
static PetscBool FindMasters(const SplineLattice *l, const Work *w, PetscInt q, PetscInt m,
                             SplineSlave *slave)
{
  const PetscInt from[ISPH_MAX_DIM] = {-5, -5, -5}, width[ISPH_MAX_DIM] = {11, 11, 11};
  const PetscInt n[ISPH_MAX_DIM] = {m, m, m}, zero[ISPH_MAX_DIM] = {0};
  PetscReal      best             = PETSC_INFINITY, lagrange[ISPH_MAX_DIM][3];
  PetscInt       at[ISPH_MAX_DIM] = {0}, index[ISPH_MAX_DIM];

  SplineIndex(l->dim, NULL, l->count, q, index);
  for (PetscInt k = 0; k < PetscPowInt(11, l->dim); k++) {
    PetscInt  first[ISPH_MAX_DIM];
    PetscReal d2 = 0.0, far = 0.0;

    SplineIndex(l->dim, from, width, k, first);
    for (PetscInt a = 0; a < l->dim; a++) {
      const PetscReal middle = first[a] + 0.5 * (m - 1);

      d2 += PetscSqr(middle - w->offset[a][q]);
      far = PetscMax(far, PetscAbsReal(middle));
    }
    if (far > 4.0 || d2 > best - 1e-6) continue;
    if (!BlockIsComplete(l, w, index, first, m)) continue;
    best = d2;
    for (PetscInt a = 0; a < l->dim; a++) at[a] = first[a];
  }
  if (best == PETSC_INFINITY) return PETSC_FALSE;
  for (PetscInt a = 0; a < l->dim; a++) LagrangeWeights(m, -at[a], lagrange[a]);
  slave->n = PetscPowInt(m, l->dim);
  for (PetscInt k = 0; k < slave->n; k++) {
    PetscInt digit[ISPH_MAX_DIM];

    SplineIndex(l->dim, zero, n, k, digit);
    slave->weight[k] = 1.0;
    for (PetscInt a = 0; a < l->dim; a++) {
      slave->step[k][a] = at[a] + digit[a];
      slave->weight[k] *= lagrange[a][digit[a]];
    }
  }
  return PETSC_TRUE;
}

/* Sets the weights of the linear fit of masters, with weights of their distance^-2 and a ridge that
   leaves their mean where they are in a row. Input: step - from the spline to each. */
static void FitMasters(PetscInt dim, SplineSlave *slave)
{
  const PetscInt terms = dim + 1;
  PetscReal      M[16] = {0.0}, factor[16], c[4] = {1.0}, sum = 0.0;

  for (PetscInt m = 0; m < slave->n; m++) {
    PetscReal w = 0.0;

    for (PetscInt a = 0; a < dim; a++) w += PetscSqr((PetscReal)slave->step[m][a]);
    sum += slave->weight[m] = 1.0 / w;
    for (PetscInt e = 0; e < terms; e++)
      for (PetscInt q = 0; q < terms; q++)
        M[e * terms + q] += slave->weight[m] * (e ? (PetscReal)slave->step[m][e - 1] : 1.0) *
                            (q ? (PetscReal)slave->step[m][q - 1] : 1.0);
  }
  for (PetscInt e = 1; e < terms; e++) M[e * terms + e] += EXTENSION_RIDGE * sum;
  DenseCholeskyRidge(terms, M, 0.0, factor);
  DenseCholeskySolve(terms, factor, c);
  for (PetscInt m = 0; m < slave->n; m++) {
    PetscReal w = c[0];

    for (PetscInt a = 0; a < dim; a++) w += c[1 + a] * slave->step[m][a];
    slave->weight[m] *= w;
  }
}

/* SplineNearMasters - Gives spline q the linear fit of masters about as near as the nearest;
   returns false if there is none; not collective. Input: enough - splines that can be masters;
   piece - the pieces of fluid of splines, which have masters in their own only; -1: in any.
   Output: slave - n, weight, and indices of masters. */
PetscBool SplineNearMasters(const SplineLattice *l, const PetscBool enough[],
                            const PetscInt piece[], PetscInt q, SplineSlave *slave)
{
  const PetscInt from[ISPH_MAX_DIM] = {-3, -3, -3}, width[ISPH_MAX_DIM] = {7, 7, 7};
  PetscReal      nearest = PETSC_INFINITY;
  PetscInt       index[ISPH_MAX_DIM];

  SplineIndex(l->dim, NULL, l->count, q, index);
  slave->n = 0;
  for (PetscInt pass = 0; pass < 2; pass++) {
    for (PetscInt k = 0; k < PetscPowInt(7, l->dim); k++) {
      PetscInt  step[ISPH_MAX_DIM], to[ISPH_MAX_DIM], m;
      PetscReal d = 0.0;

      SplineIndex(l->dim, from, width, k, step);
      m = StepTo(l, index, step, to);
      if (m < 0 || !enough[m] || (piece[q] >= 0 && piece[m] != piece[q])) continue;
      for (PetscInt a = 0; a < l->dim; a++) d += PetscSqr((PetscReal)step[a]);
      d = PetscSqrtReal(d);
      if (pass == 0) nearest = PetscMin(nearest, d);
      if (pass == 0 || d > nearest + 1.5 || slave->n == SPLINE_MASTERS) continue;
      for (PetscInt a = 0; a < l->dim; a++) {
        slave->step[slave->n][a]   = step[a];
        slave->master[slave->n][a] = to[a];
      }
      slave->n++;
    }
  }
  if (slave->n) FitMasters(l->dim, slave);
  return slave->n ? PETSC_TRUE : PETSC_FALSE;
}

/* Gives spline q masters: n, weight and step of `slave`. */
static PetscErrorCode AddSlave(PetscInt q, const SplineSlave *slave, SplineExtension *e)
{
  PetscFunctionBegin;
  if (e->n == e->capacity) {
    e->capacity = 2 * e->capacity + 64;
    PetscCall(PetscRealloc(sizeof(*e->slaves) * (size_t)e->capacity, &e->slaves));
  }
  e->slaves[e->n] = *slave;
  e->slave[q]     = e->n++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the list of slaves, with those beside sides that give the pressure. */
static PetscErrorCode CreateList(const SplineLattice *l, SplineExtension **extension)
{
  SplineExtension *e;

  PetscFunctionBegin;
  PetscCall(PetscNew(&e));
  PetscCall(PetscMalloc1(l->N, &e->slave));
  for (PetscInt q = 0; q < l->N; q++) {
    SplineSlave slave = {.n = 2, .weight = {1.0, -1.0}};
    PetscInt    index[ISPH_MAX_DIM], side;

    e->slave[q] = SPLINE_FREE;
    SplineIndex(l->dim, NULL, l->count, q, index);
    if (!SplineIsGiven(l, index, &side)) continue;
    slave.step[1][side / 2] = side % 2 ? -1 : 1;
    PetscCall(AddSlave(q, &slave, e));
  }
  *extension = e;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the masters of all splines that have too little fluid. A spline without masters stays. */
static PetscErrorCode SetSlaves(const SplineLattice *l, const Work *w, SplineExtension *e)
{
  PetscFunctionBegin;
  for (PetscInt q = 0; q < l->N; q++) {
    PetscBool   found = PETSC_FALSE;
    SplineSlave slave = {0};

    if (w->fluid[q] <= 0.0) e->slave[q] = SPLINE_UNUSED;
    if (e->slave[q] != SPLINE_FREE || w->enough[q]) continue;
    for (PetscInt m = 3; m >= 1 && !found; m--) found = FindMasters(l, w, q, m, &slave);
    if (found) PetscCall(AddSlave(q, &slave, e));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplinesInCell - Lists the extended splines that are not zero in a cell, at most SPLINES_EXTENDED
   and some more than once; returns their number; not collective */
PetscInt SplinesInCell(const SplineLattice *l, const SplineExtension *extension,
                       const PetscInt cell[], PetscInt number[])
{
  PetscInt n = 0;

  for (PetscInt k = 0; k < (l->dim == 3 ? 27 : 9); k++) {
    PetscInt           index[ISPH_MAX_DIM];
    const PetscInt     q     = SplineOfCell(l, cell, k, index);
    const PetscInt     e     = extension ? extension->slave[q] : SPLINE_FREE;
    const SplineSlave *slave = e >= 0 ? &extension->slaves[e] : NULL;

    for (PetscInt m = 0; m < (slave ? slave->n : 1); m++)
      number[n++] = slave ? SplineNatural(l, slave->master[m]) : q;
  }
  return n;
}

/* Sets the number of extended splines that are not zero in each cell. */
static PetscErrorCode SetWidths(const SplineLattice *l, SplineExtension *e)
{
  PetscInt number[SPLINES_EXTENDED], cells = 1;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < l->dim; a++) cells *= l->cells[a];
  PetscCall(PetscMalloc1(cells, &e->width));
  for (PetscInt c = 0; c < cells; c++) {
    PetscInt cell[ISPH_MAX_DIM];

    SplineIndex(l->dim, NULL, l->cells, c, cell);
    e->width[c] = SplinesInCell(l, e, cell, number);
    PetscCall(PetscSortRemoveDupsInt(&e->width[c], number));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gives splines with little fluid masters. */
static PetscErrorCode AddBodies(const SplineLattice *l, const SplineBodies *s, SplineExtension *e)
{
  Work w;

  PetscFunctionBegin;
  PetscCall(PetscCalloc6(l->N, &w.fluid, l->N, &w.box, l->N, &w.offset[0], l->N, &w.offset[1], l->N,
                         &w.offset[2], l->N, &w.enough));
  Integrate(l, s, &w);
  for (PetscInt q = 0; q < l->N; q++) {
    if (w.fluid[q] < 1e-12 * w.box[q]) w.fluid[q] = 0.0;
    for (PetscInt a = 0; a < l->dim; a++) w.offset[a][q] /= w.fluid[q] > 0.0 ? w.fluid[q] : 1.0;
    w.enough[q] = w.fluid[q] >= ENOUGH * w.box[q] && e->slave[q] == SPLINE_FREE;
  }
  PetscCall(SetSlaves(l, &w, e));
  PetscCall(PetscFree6(w.fluid, w.box, w.offset[0], w.offset[1], w.offset[2], w.enough));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the indices of the masters of spline q. A master that is a slave is replaced by its own
   masters. */
static PetscErrorCode Compose(const SplineLattice *l, PetscInt q, const SplineExtension *e)
{
  SplineSlave *slave = &e->slaves[e->slave[q]], all = {.composed = PETSC_TRUE};
  PetscInt     index[ISPH_MAX_DIM];

  PetscFunctionBegin;
  if (slave->composed) PetscFunctionReturn(PETSC_SUCCESS);
  SplineIndex(l->dim, NULL, l->count, q, index);
  for (PetscInt k = 0; k < slave->n; k++) {
    const PetscInt     to   = StepTo(l, index, slave->step[k], slave->master[k]);
    const SplineSlave *next = to != q && e->slave[to] >= 0 ? &e->slaves[e->slave[to]] : NULL;

    if (next) PetscCall(Compose(l, to, e));
    for (PetscInt m = 0; m < (next ? next->n : 1); m++, all.n++) {
      all.weight[all.n] = slave->weight[k] * (next ? next->weight[m] : 1.0);
      for (PetscInt a = 0; a < l->dim; a++)
        all.step[all.n][a] = slave->step[k][a] + (next ? next->step[m][a] : 0);
      (void)StepTo(l, index, all.step[all.n], all.master[all.n]);
    }
  }
  *slave = all;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Extends the range of cells of each master by those of a slave. */
static void ExtendRange(const SplineLattice *l, const SplineSlave *slave, SplineExtension *e)
{
  for (PetscInt k = 0; k < slave->n; k++) {
    SplineRange *range = &e->range[SplineNatural(l, slave->master[k])];

    for (PetscInt a = 0; a < l->dim; a++) {
      range->low[a]  = PetscMin(range->low[a], -slave->step[k][a]);
      range->high[a] = PetscMax(range->high[a], -slave->step[k][a]);
    }
  }
}

/* SplineExtensionCreate - Lists the splines that have masters, beside bodies and beside sides that
   give the pressure. Not collective. Output: extension - NULL if there are none. */
PetscErrorCode SplineExtensionCreate(const SplineLattice *l, const SplineBodies *bodies,
                                     SplineExtension **extension)
{
  SplineExtension *e;

  PetscFunctionBegin;
  *extension = NULL;
  if (!bodies && !SplineSideGives(l)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(CreateList(l, &e));
  if (bodies) PetscCall(AddBodies(l, bodies, e));
  PetscCall(PetscCalloc1(l->N, &e->range));
  for (PetscInt q = 0; q < l->N; q++) {
    PetscInt index[ISPH_MAX_DIM], side;

    if (e->slave[q] < 0) continue;
    PetscCall(Compose(l, q, e));
    SplineIndex(l->dim, NULL, l->count, q, index);
    if (!SplineIsGiven(l, index, &side)) ExtendRange(l, &e->slaves[e->slave[q]], e);
  }
  PetscCall(SetWidths(l, e));
  *extension = e;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineExtensionDestroy - Frees the list; not collective */
PetscErrorCode SplineExtensionDestroy(SplineExtension **extension)
{
  SplineExtension *e = *extension;

  PetscFunctionBegin;
  if (!e) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FreeAll(&e->slave, &e->slaves, &e->range, &e->width, extension));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds weight times spline k at a point to the entry of a number. */
static void AddEntry(PetscInt dim, PetscInt number, PetscReal weight, const SplineValues *at,
                     PetscInt k, SplineRow *row)
{
  PetscInt e = 0;

  while (e < row->n && row->number[e] != number) e++;
  if (e == row->n) {
    row->n++;
    row->number[e] = number;
    row->value[e]  = 0.0;
    for (PetscInt a = 0; a < dim; a++) row->gradient[a][e] = 0.0;
  }
  row->value[e] += weight * at->value[k];
  for (PetscInt a = 0; a < dim; a++) row->gradient[a][e] += weight * at->gradient[a][k];
}

/* Computes a row from splines, which have masters. */
static void SetRow(const Splines *s, PetscInt dim, const Particles *p, const SplineValues *at,
                   SplineRow *row)
{
  row->n = 0;
  for (PetscInt k = 0; k < at->n; k++) {
    const SplineSlave *slave = SplineSlaveAt(s, at->index[k]);

    if (!s->extension) {
      row->number[k] = SplinesGlobal(s, p, at->index[k]);
      row->value[k]  = at->value[k];
      for (PetscInt a = 0; a < dim; a++) row->gradient[a][k] = at->gradient[a][k];
      row->n++;
      continue;
    }
    for (PetscInt m = 0; m < (slave ? slave->n : 1); m++)
      AddEntry(dim, SplinesGlobal(s, p, slave ? slave->master[m] : at->index[k]),
               slave ? slave->weight[m] : 1.0, at, k, row);
  }
}

/* SplineRowAt - Computes the splines that are not zero at a point, extended beside bodies. Not
   collective. Input: l - s->lattice or s->pressure. Output: row - their global numbers, values [-]
   and gradients [1/m]. */
void SplineRowAt(const Splines *s, const SplineLattice *l, const Particles *p, const PetscReal x[],
                 SplineRow *row)
{
  SplineValues at;

  SplinesAt(l, x, &at);
  SetRow(s, l->dim, p, &at, row);
}

/* SplineSumAt - Returns the sum at a point of splines whose numbers are all on this rank, and
   computes its gradient; not collective */
PetscReal SplineSumAt(const Splines *s, const Particles *p, const PetscScalar all[],
                      const PetscReal x[], PetscReal gradient[])
{
  PetscReal sum = 0.0;
  SplineRow at;

  SplineRowAt(s, &s->lattice, p, x, &at);
  for (PetscInt a = 0; a < p->dim; a++) gradient[a] = 0.0;
  for (PetscInt k = 0; k < at.n; k++) {
    sum += at.value[k] * all[at.number[k]];
    for (PetscInt a = 0; a < p->dim; a++) gradient[a] += at.gradient[a][k] * all[at.number[k]];
  }
  return sum;
}

/* SplineRowOfPatch - Computes row 3 m + a of a patch, 12 for each: the integrals of node m and axis
   a, extended; not collective. Output: row - their global numbers, and values [-]. */
void SplineRowOfPatch(const Splines *s, const Particles *p, PetscInt number, SplineRow *row)
{
  const SplinePatch *patch = &s->bodies->patches[number / 12];
  SplineValues       at    = {.n = SPLINES_AT_QUADRATIC};
  PetscInt           cell[ISPH_MAX_DIM];

  SplineIndex(3, NULL, s->lattice.cells, patch->cell, cell);
  for (PetscInt k = 0; k < at.n; k++) {
    (void)SplineOfCell(&s->lattice, cell, k, at.index[k]);
    at.value[k] = patch->integral[number / 3 % 4][number % 3][k];
  }
  SetRow(s, 3, p, &at, row);
}

/* SplineRowWidth - Returns the number of entries of SplineRowAt() at a point, which masters make
   greater; not collective */
PetscInt SplineRowWidth(const Splines *s, const SplineLattice *l, const PetscReal x[])
{
  return s->extension ? s->extension->width[SplineCellAt(l, x)] : SplinesAtPoint(l);
}
