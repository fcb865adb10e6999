/*
  Extended B-splines beside bodies. A spline with little fluid in its support has a small row in the
  divergence, and the pressure there would be badly determined. Its coefficient is no unknown, but
  extrapolated from the nearest block of splines with enough fluid, its masters:

    p_q = sum_m E_qm p_m,   psi_m <- psi_m + sum_q E_qm psi_q

  with a block of 3 x 3 splines quadratic sequences are kept. The splines still sum to 1. In 3D the
  masters are in the layer of the spline.

  The outermost spline q beside a side that gives the pressure is followed by spline r inside. Its
  own number is given, c_q = 2 p(side), and its coefficient is c_q - p_r: the sum of both is the
  pressure on the side, and spline r is psi_r - psi_q, which is zero there. So its masters are q and
  r, or q and the masters of r.

  Reference: K. Hoellig, U. Reif, J. Wipper, SIAM J. Numer. Anal. 39 (2001) 442-462
*/
#include "splines.h"

#define ENOUGH 0.35 /* least share of the weight of a spline that is in the fluid [-] */

/* The splines in the plane while their masters are sought. */
typedef struct {
  PetscReal *fluid, *box; /* int psi over the fluid, and over the box [cells] */
  PetscReal *offset[2];   /* centroid of the fluid, from the centre of the spline [cells] */
  PetscBool *enough;
} Plane;

/* Adds the splines at a point to the integrals. */
static void AddPoint(const SplineLattice *plane, const PetscReal x[], PetscReal fluid,
                     PetscReal box, Plane *w)
{
  SplineValues at;

  SplinesAt(plane, x, &at);
  for (PetscInt k = 0; k < at.n; k++) {
    const PetscInt q = SplineNatural(plane, at.index[k]);

    w->fluid[q] += fluid * at.value[k];
    w->box[q] += box * at.value[k];
    for (PetscInt a = 0; a < 2; a++) {
      const PetscReal s     = (x[a] - plane->lo[a]) / plane->side[a];
      const PetscInt  cell  = PetscMin(PetscMax((PetscInt)s, 0), plane->cells[a] - 1);
      const PetscInt  below = a == 0 ? k % 3 : k / 3;

      w->offset[a][q] += fluid * at.value[k] * (s - cell - (below - 0.5));
    }
  }
}

/* Integrates all splines of the plane over the fluid and over the box. */
static void Integrate(const SplineLattice *plane, const SplineBodies *s, Plane *w)
{
  for (PetscInt c = 0; c < plane->cells[0] * plane->cells[1]; c++) {
    for (PetscInt corner = 0; corner < 4; corner++) {
      const PetscInt index[2] = {c % plane->cells[0], c / plane->cells[0]};
      PetscReal      x[2];

      for (PetscInt a = 0; a < 2; a++)
        x[a] =
            plane->lo[a] + (index[a] + 0.5 + ((corner >> a) % 2 ? GAUSS : -GAUSS)) * plane->side[a];
      AddPoint(plane, x, s->cut[c] < 0 ? 0.25 * s->fraction[c] : 0.0, 0.25, w);
    }
    if (s->cut[c] < 0) continue;
    for (PetscInt g = 0; g < s->cuts[s->cut[c]].n; g++) {
      const PetscInt  k    = s->cuts[s->cut[c]].first + g;
      const PetscReal x[2] = {s->x[0][k], s->x[1][k]};

      AddPoint(plane, x, s->weight[k], 0.0, w);
    }
  }
}

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

/* Returns true if a block of m splines along each axis, whose first is `first` after an index, has
   enough fluid. */
static PetscBool BlockIsComplete(const SplineLattice *l, const Plane *w, const PetscInt index[],
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
static PetscBool FindMasters(const SplineLattice *l, const Plane *w, PetscInt q, PetscInt m,
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

/* SplineSideGives - Returns true if a side gives the pressure; not collective */
PetscBool SplineSideGives(const SplineLattice *l)
{
  for (PetscInt side = 0; side < 2 * l->dim; side++)
    if (l->given[side]) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* SplineIsGiven - Returns true if the number of a spline is given by a side, the first in order;
   not collective */
PetscBool SplineIsGiven(const SplineLattice *l, const PetscInt index[], PetscInt *side)
{
  for (*side = 0; *side < 2 * l->dim; (*side)++) {
    const PetscInt a = *side / 2;

    if (l->given[*side] && index[a] == (*side % 2 ? l->count[a] - 1 : 0)) return PETSC_TRUE;
  }
  return PETSC_FALSE;
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
static PetscErrorCode SetSlaves(const SplineLattice *l, const Plane *w, SplineExtension *e)
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
  const PetscInt width[ISPH_MAX_DIM] = {3, 3, 3};
  PetscInt       n                   = 0;

  for (PetscInt k = 0; k < (l->dim == 3 ? 27 : 9); k++) {
    PetscInt           step[ISPH_MAX_DIM], index[ISPH_MAX_DIM], q, e;
    const SplineSlave *slave;

    SplineIndex(l->dim, NULL, width, k, step);
    for (PetscInt a = 0; a < l->dim; a++) step[a] -= l->periodic[a] ? 1 : 0;
    q     = StepTo(l, cell, step, index);
    e     = extension ? extension->slave[q] : SPLINE_FREE;
    slave = e >= 0 ? &extension->slaves[e] : NULL;
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
static PetscErrorCode AddBodies(const SplineLattice *lattice, const SplineBodies *s,
                                SplineExtension *e)
{
  const SplineLattice plane = SplinePlane(lattice);
  SplineExtension    *flat;
  Plane               w;

  PetscFunctionBegin;
  PetscCall(PetscCalloc5(plane.N, &w.fluid, plane.N, &w.box, plane.N, &w.offset[0], plane.N,
                         &w.offset[1], plane.N, &w.enough));
  Integrate(&plane, s, &w);
  PetscCall(CreateList(&plane, &flat));
  for (PetscInt q = 0; q < plane.N; q++) {
    if (w.fluid[q] < 1e-12 * w.box[q]) w.fluid[q] = 0.0;
    for (PetscInt a = 0; a < 2; a++) w.offset[a][q] /= w.fluid[q] > 0.0 ? w.fluid[q] : 1.0;
    w.enough[q] =
        w.fluid[q] >= ENOUGH * w.box[q] && flat->slave[q] == SPLINE_FREE ? PETSC_TRUE : PETSC_FALSE;
  }
  PetscCall(SetSlaves(&plane, &w, flat));
  for (PetscInt q = 0; q < lattice->N; q++) {
    const PetscInt k = flat->slave[q % plane.N];

    if (k == SPLINE_UNUSED) e->slave[q] = k;
    if (k >= 0 && e->slave[q] == SPLINE_FREE) PetscCall(AddSlave(q, &flat->slaves[k], e));
  }
  PetscCall(SplineExtensionDestroy(&flat));
  PetscCall(PetscFree5(w.fluid, w.box, w.offset[0], w.offset[1], w.enough));
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

/*
  SplineExtensionCreate - Lists the splines that have masters, beside bodies and beside sides that
  give the pressure

  Not collective. Output: extension - NULL if there are none.
*/
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
  PetscCall(PetscFree(e->slave));
  PetscCall(PetscFree(e->slaves));
  PetscCall(PetscFree(e->range));
  PetscCall(PetscFree(e->width));
  PetscCall(PetscFree(*extension));
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

/*
  SplineRowAt - Computes the splines that are not zero at a point, extended beside bodies

  Not collective. Input: l - s->lattice or s->pressure. Output: row - their global numbers, values
  [-] and gradients [1/m].
*/
void SplineRowAt(const Splines *s, const SplineLattice *l, const Particles *p, const PetscReal x[],
                 SplineRow *row)
{
  SplineValues at;

  SplinesAt(l, x, &at);
  row->n = 0;
  for (PetscInt k = 0; k < at.n; k++) {
    const SplineSlave *slave = SplineSlaveAt(s, at.index[k]);

    if (!slave && !s->extension) {
      row->number[k] = SplinesGlobal(s, p, at.index[k]);
      row->value[k]  = at.value[k];
      for (PetscInt a = 0; a < l->dim; a++) row->gradient[a][k] = at.gradient[a][k];
      row->n++;
    } else if (!slave) {
      AddEntry(l->dim, SplinesGlobal(s, p, at.index[k]), 1.0, &at, k, row);
    }
    for (PetscInt m = 0; slave && m < slave->n; m++)
      AddEntry(l->dim, SplinesGlobal(s, p, slave->master[m]), slave->weight[m], &at, k, row);
  }
}

/* SplineRowWidth - Returns the number of entries of SplineRowAt() at a point, which masters make
   greater; not collective */
PetscInt SplineRowWidth(const Splines *s, const SplineLattice *l, const PetscReal x[])
{
  return s->extension ? s->extension->width[SplineCellAt(l, x)] : SplinesAtPoint(l);
}
