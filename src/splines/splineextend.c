/*
  Extended B-splines beside bodies. A spline with little fluid in its support has a small row in the
  divergence, and the pressure there would be badly determined. Its coefficient is no unknown, but
  extrapolated from the nearest block of splines with enough fluid, its masters:

    p_q = sum_m E_qm p_m,   psi_m <- psi_m + sum_q E_qm psi_q

  with a block of 3 x 3 splines quadratic sequences are kept. The splines still sum to 1. In 3D the
  masters are in the layer of the spline.

  Reference: K. Hoellig, U. Reif, J. Wipper, SIAM J. Numer. Anal. 39 (2001) 442-462
*/
#include "splines.h"

#define ENOUGH 0.35 /* least share of the weight of a spline that is in the fluid [-] */

/* The splines in the plane while their masters are sought. */
typedef struct {
  PetscReal *fluid, *box; /* int psi over the fluid, and over the box [cells] */
  PetscReal *offset[2];   /* centroid of the fluid, from the centre of the spline [cells] */
  PetscBool *enough, *given;
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

/* Returns the number of the spline `step` after an index along both axes, -1 outside the box. */
static PetscInt StepTo(const SplineLattice *plane, const PetscInt from[2], PetscInt i, PetscInt j)
{
  const PetscInt step[2] = {i, j};
  PetscInt       to[2];

  for (PetscInt a = 0; a < 2; a++) {
    to[a] = from[a] + step[a];
    if (plane->periodic[a]) to[a] = (to[a] + 2 * plane->count[a]) % plane->count[a];
    else if (to[a] < 0 || to[a] >= plane->count[a]) return -1;
  }
  return SplineNatural(plane, to);
}

/* Returns true if a block of m x m splines, whose first is (i, j) from an index, has enough fluid.
   */
static PetscBool BlockIsComplete(const SplineLattice *plane, const Plane *w,
                                 const PetscInt index[2], PetscInt i, PetscInt j, PetscInt m)
{
  for (PetscInt k = 0; k < m * m; k++) {
    const PetscInt q = StepTo(plane, index, i + k % m, j + k / m);

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

/* Finds the complete block of m x m splines nearest to the fluid of spline q, within 4 cells;
   returns false if there is none. Equal distances are decided by the order of the search. */
static PetscBool FindMasters(const SplineLattice *plane, const Plane *w, PetscInt q, PetscInt m,
                             SplineSlave *slave)
{
  const PetscInt index[2] = {q % plane->count[0], q / plane->count[0]};
  PetscReal      best     = PETSC_INFINITY, lagrange[2][3];
  PetscInt       at[2]    = {0, 0};

  for (PetscInt k = 0; k < 121; k++) {
    const PetscInt first[2] = {k % 11 - 5, k / 11 - 5};
    PetscReal      d2 = 0.0, far = 0.0;

    for (PetscInt a = 0; a < 2; a++) {
      const PetscReal middle = first[a] + 0.5 * (m - 1);

      d2 += PetscSqr(middle - w->offset[a][q]);
      far = PetscMax(far, PetscAbsReal(middle));
    }
    if (far > 4.0 || d2 > best - 1e-6) continue;
    if (!BlockIsComplete(plane, w, index, first[0], first[1], m)) continue;
    best  = d2;
    at[0] = first[0];
    at[1] = first[1];
  }
  if (best == PETSC_INFINITY) return PETSC_FALSE;
  for (PetscInt a = 0; a < 2; a++) LagrangeWeights(m, -at[a], lagrange[a]);
  slave->n = m * m;
  for (PetscInt k = 0; k < m * m; k++) {
    const PetscInt to = StepTo(plane, index, at[0] + k % m, at[1] + k / m);

    slave->master[k][0] = to % plane->count[0];
    slave->master[k][1] = to / plane->count[0];
    slave->weight[k]    = lagrange[0][k % m] * lagrange[1][k / m];
    slave->step[k][0]   = at[0] + k % m;
    slave->step[k][1]   = at[1] + k / m;
  }
  return PETSC_TRUE;
}

/* Extends the range of cells of each master by those of a slave. */
static void ExtendRange(const SplineLattice *plane, const SplineSlave *slave, SplineBodies *s)
{
  for (PetscInt k = 0; k < slave->n; k++) {
    SplineRange *range = &s->range[SplineNatural(plane, slave->master[k])];

    for (PetscInt a = 0; a < 2; a++) {
      range->low[a]  = PetscMin(range->low[a], -slave->step[k][a]);
      range->high[a] = PetscMax(range->high[a], -slave->step[k][a]);
    }
  }
}

/* Sets the masters of all splines that have too little fluid. A spline without masters stays. */
static PetscErrorCode SetSlaves(const SplineLattice *plane, const Plane *w, SplineBodies *s)
{
  PetscInt capacity = 0;

  PetscFunctionBegin;
  for (PetscInt q = 0; q < plane->N; q++) {
    PetscBool found = PETSC_FALSE;

    s->slave[q] = w->fluid[q] > 0.0 ? SPLINE_FREE : SPLINE_UNUSED;
    if (s->slave[q] == SPLINE_UNUSED || w->enough[q] || w->given[q]) continue;
    if (s->n_slaves == capacity) {
      capacity = 2 * capacity + 64;
      PetscCall(PetscRealloc(sizeof(*s->slaves) * (size_t)capacity, &s->slaves));
    }
    for (PetscInt m = 3; m >= 1 && !found; m--)
      found = FindMasters(plane, w, q, m, &s->slaves[s->n_slaves]);
    if (!found) continue;
    ExtendRange(plane, &s->slaves[s->n_slaves], s);
    s->slave[q] = s->n_slaves++;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineSideGives - Returns true if a side gives the pressure; not collective */
PetscBool SplineSideGives(const SplineLattice *l)
{
  for (PetscInt side = 0; side < 2 * l->dim; side++)
    if (l->given[side]) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* SplineIsGiven - Returns true if the coefficient of a spline is given by a side, the first in
   order; not collective */
PetscBool SplineIsGiven(const SplineLattice *l, const PetscInt index[], PetscInt *side)
{
  for (*side = 0; *side < 2 * l->dim; (*side)++) {
    const PetscInt a = *side / 2;

    if (l->given[*side] && index[a] == (*side % 2 ? l->count[a] - 1 : 0)) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/*
  SplineSourcesOf - Lists the numbers that make the coefficient of a spline: its own, or those of
  its masters

  Not collective. The outermost spline q beside a side that gives the pressure is followed by spline
  r inside. Its own number is given, c_q = 2 p(side), and its coefficient is c_q - p_r: the sum of
  both is the pressure on the side, and spline r is psi_r - psi_q, which is zero there.
*/
void SplineSourcesOf(const SplineLattice *l, const SplineBodies *bodies, const PetscInt index[],
                     SplineSources *sources)
{
  const SplineSlave *slave            = NULL;
  PetscInt           at[ISPH_MAX_DIM] = {0}, side, k = SPLINE_FREE;
  PetscReal          weight = 1.0;

  sources->n = 0;
  for (PetscInt a = 0; a < l->dim; a++) at[a] = index[a];
  while (SplineIsGiven(l, at, &side)) {
    for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) sources->index[sources->n][a] = at[a];
    sources->weight[sources->n++] = weight;
    at[side / 2] += side % 2 ? -1 : 1;
    weight = -weight;
  }
  if (bodies) k = bodies->slave[SplineColumn(l, at)];
  if (k >= 0) slave = &bodies->slaves[k];
  for (PetscInt m = 0; m < (slave ? slave->n : 1); m++) {
    PetscInt *of = sources->index[sources->n];

    for (PetscInt a = 0; a < ISPH_MAX_DIM; a++)
      of[a] = slave && a < 2 ? slave->master[m][a] : at[a];
    sources->weight[sources->n++] = slave ? weight * slave->weight[m] : weight;
  }
}

/* SplinesInCell - Lists the extended splines of the plane that are not zero in a cell, at most
   SPLINES_IN_CELL and some more than once; returns their number; not collective */
PetscInt SplinesInCell(const SplineLattice *plane, const SplineBodies *s, PetscInt cell,
                       PetscInt number[])
{
  SplineValues at;
  PetscReal    x[2];
  PetscInt     n = 0;

  x[0] = plane->lo[0] + (cell % plane->cells[0] + 0.5) * plane->side[0];
  x[1] = plane->lo[1] + (cell / plane->cells[0] + 0.5) * plane->side[1];
  SplinesAt(plane, x, &at);
  for (PetscInt k = 0; k < at.n; k++) {
    SplineSources sources;

    SplineSourcesOf(plane, s, at.index[k], &sources);
    for (PetscInt m = 0; m < sources.n; m++) number[n++] = SplineNatural(plane, sources.index[m]);
  }
  return n;
}

/* Sets the number of extended splines that are not zero in each cell. */
static PetscErrorCode SetWidths(const SplineLattice *plane, SplineBodies *s)
{
  PetscInt number[SPLINES_IN_CELL];

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(plane->cells[0] * plane->cells[1], &s->width));
  for (PetscInt c = 0; c < plane->cells[0] * plane->cells[1]; c++) {
    s->width[c] = SplinesInCell(plane, s, c, number);
    PetscCall(PetscSortRemoveDupsInt(&s->width[c], number));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineExtensionSet - Sets the masters of splines with little fluid; not collective */
PetscErrorCode SplineExtensionSet(const SplineLattice *lattice, SplineBodies *s)
{
  const SplineLattice plane = SplinePlane(lattice);
  Plane               w;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(plane.N, &s->slave, plane.N, &s->range));
  PetscCall(PetscMemzero(s->range, sizeof(*s->range) * (size_t)plane.N));
  PetscCall(PetscCalloc6(plane.N, &w.fluid, plane.N, &w.box, plane.N, &w.offset[0], plane.N,
                         &w.offset[1], plane.N, &w.enough, plane.N, &w.given));
  Integrate(&plane, s, &w);
  for (PetscInt q = 0; q < plane.N; q++) {
    if (w.fluid[q] < 1e-12 * w.box[q]) w.fluid[q] = 0.0;
    for (PetscInt a = 0; a < 2; a++) w.offset[a][q] /= w.fluid[q] > 0.0 ? w.fluid[q] : 1.0;
    const PetscInt index[2] = {q % plane.count[0], q / plane.count[0]};
    PetscInt       side;

    w.given[q]  = SplineIsGiven(&plane, index, &side);
    w.enough[q] = !w.given[q] && w.fluid[q] >= ENOUGH * w.box[q] ? PETSC_TRUE : PETSC_FALSE;
  }
  PetscCall(SetSlaves(&plane, &w, s));
  PetscCall(SetWidths(&plane, s));
  PetscCall(PetscFree6(w.fluid, w.box, w.offset[0], w.offset[1], w.enough, w.given));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineExtensionFree - Frees the masters; not collective */
PetscErrorCode SplineExtensionFree(SplineBodies *s)
{
  PetscFunctionBegin;
  PetscCall(PetscFree2(s->slave, s->range));
  PetscCall(PetscFree(s->slaves));
  PetscCall(PetscFree(s->width));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplinesArePlain - Returns true if all coefficients are unknowns; not collective */
PetscBool SplinesArePlain(const Splines *s)
{
  return s->bodies || SplineSideGives(&s->lattice) ? PETSC_FALSE : PETSC_TRUE;
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
    SplineSources sources;

    if (SplinesArePlain(s)) {
      row->number[k] = SplinesGlobal(s, p, at.index[k]);
      row->value[k]  = at.value[k];
      for (PetscInt a = 0; a < l->dim; a++) row->gradient[a][k] = at.gradient[a][k];
      row->n++;
      continue;
    }

    SplineSourcesOf(&s->lattice, s->bodies, at.index[k], &sources);
    for (PetscInt m = 0; m < sources.n; m++)
      AddEntry(l->dim, SplinesGlobal(s, p, sources.index[m]), sources.weight[m], &at, k, row);
  }
}

/* SplineRowWidth - Returns the number of entries of SplineRowAt() at a point, which bodies make
   greater; not collective */
PetscInt SplineRowWidth(const Splines *s, const SplineLattice *l, const PetscReal x[])
{
  if (!s->bodies) return SplinesAtPoint(l);
  return s->bodies->width[SplineCellAt(l, x)] * (l->dim == 3 ? l->degree + 1 : 1);
}
