/* The window of a rank: the pressure of the splines at particles, without a matrix, and sums over
   splines. Splines are products of polynomials along the axes, so the place of a particle in its
   cell gives all of them. Their coefficients are collected in a block of the lattice around the
   particles of a rank, the window, where the splines beside bodies have the coefficients of their
   masters already (splineextend.c). */
#include "splines.h"

/* Returns the first spline along an axis that is not zero at the lowest or at the highest place of
   this rank's particles. */
static PetscInt FirstAt(const SplineLattice *l, const Particles *p, PetscInt a, PetscBool last)
{
  const Scene    *scene = l->scene;
  const PetscReal x     = last ? PetscMin(p->hi[a], scene->hi[a]) + p->skin
                               : PetscMax(p->lo[a], scene->lo[a]) - p->skin;
  PetscReal       y     = x;

  if (!l->periodic[a]) y = PetscMin(PetscMax(x, scene->lo[a]), scene->hi[a]);
  return SplineFirstAlong(l, a, (SceneToUniform(scene, a, y) - l->lo[a]) / l->side[a]);
}

/* Computes the index of entry k of the window in the lattice. */
static void WindowIndex(const SplineLattice *l, const SplineWindow *w, PetscInt k, PetscInt index[])
{
  SplineIndex(l->dim, w->first, w->n, k, index);
  for (PetscInt a = 0; a < l->dim; a++) {
    const PetscInt count = l->count[a];

    if (l->periodic[a]) index[a] = (index[a] % count + count) % count;
  }
}

/* Lists the splines whose coefficients make entry k of the window: itself, or its masters. Returns
   their number; number and weight may be NULL. */
static PetscInt ListSources(const Splines *s, const Particles *p, PetscInt k, PetscInt number[],
                            PetscReal weight[])
{
  PetscInt           index[ISPH_MAX_DIM] = {0};
  const SplineSlave *slave;
  PetscInt           n;

  WindowIndex(&s->pressure, &s->window, k, index);
  slave = SplineSlaveAt(s, index);
  n     = slave ? slave->n : 1;
  for (PetscInt m = 0; number && m < n; m++) {
    number[m] = SplinesGlobal(s, p, slave ? slave->master[m] : index);
    weight[m] = slave ? slave->weight[m] : 1.0;
  }
  return n;
}

/* SplineWindowSet - Sets the window of this rank for the present numbers of the splines.
   Collective. The window holds all splines that are not zero at particles that are less than the
   skin beyond the box of the rank, and those at the points of quadrature in the box. */
PetscErrorCode SplineWindowSet(Splines *s, const Particles *p)
{
  const SplineLattice *l = &s->pressure;
  SplineWindow        *w = &s->window;
  PetscInt             n;
  IS                   from;

  PetscFunctionBegin;
  w->size = 1;
  for (PetscInt a = 0; a < l->dim; a++) {
    w->first[a] = FirstAt(l, p, a, PETSC_FALSE);
    w->n[a]     = FirstAt(l, p, a, PETSC_TRUE) - w->first[a] + l->degree + 1;
    w->size *= w->n[a];
  }
  PetscCall(PetscMalloc2(w->size, &w->value, w->size + 1, &w->start));
  w->start[0] = 0;
  for (PetscInt k = 0; k < w->size; k++)
    w->start[k + 1] = w->start[k] + ListSources(s, p, k, NULL, NULL);
  n = w->start[w->size];
  PetscCall(PetscMalloc3(n, &w->source, n, &w->weight, n, &w->number));
  for (PetscInt k = 0; k < w->size; k++)
    (void)ListSources(s, p, k, &w->source[w->start[k]], &w->weight[w->start[k]]);
  PetscCall(PetscArraycpy(w->number, w->source, n));
  PetscCall(PetscSortRemoveDupsInt(&n, w->number));
  for (PetscInt e = 0; e < w->start[w->size]; e++)
    PetscCall(PetscFindInt(w->source[e], n, w->number, &w->source[e]));
  PetscCall(VecCreateSeq(PETSC_COMM_SELF, n, &w->coefficients));
  PetscCall(ISCreateGeneral(PETSC_COMM_SELF, n, w->number, PETSC_USE_POINTER, &from));
  PetscCall(VecScatterCreate(s->mass, from, w->coefficients, NULL, &w->collect));
  PetscCall(ISDestroy(&from));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineWindowFree - Frees the window; collective */
PetscErrorCode SplineWindowFree(SplineWindow *w)
{
  PetscFunctionBegin;
  PetscCall(VecScatterDestroy(&w->collect));
  PetscCall(VecDestroy(&w->coefficients));
  PetscCall(PetscFree2(w->value, w->start));
  PetscCall(PetscFree3(w->source, w->weight, w->number));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplinePlacesFree - Frees the places of particles; not collective */
PetscErrorCode SplinePlacesFree(SplinePlaces *at)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(at->base));
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) PetscCall(PetscFree2(at->t[a], at->per_edge[a]));
  at->n = at->capacity = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes room for n places. */
static PetscErrorCode PlacesReserve(PetscInt dim, PetscInt n, SplinePlaces *at)
{
  PetscFunctionBegin;
  if (n > at->capacity) {
    PetscCall(SplinePlacesFree(at));
    at->capacity = n + n / 8;
    PetscCall(PetscMalloc1(at->capacity, &at->base));
    for (PetscInt a = 0; a < dim; a++)
      PetscCall(PetscMalloc2(at->capacity, &at->t[a], at->capacity, &at->per_edge[a]));
  }
  at->n = n;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes place i, at x: the first spline that is not zero there, and the place between knots. */
static inline void SetPlace(const SplineLattice *l, const SplineWindow *w, const PetscReal x[],
                            PetscInt i, SplinePlaces *at)
{
  at->base[i] = 0;
  for (PetscInt a = l->dim - 1; a >= 0; a--) {
    PetscInt first;

    SplinePlaceAlong(l, a, x[a], &first, &at->t[a][i], &at->per_edge[a][i]);
    at->base[i] = at->base[i] * w->n[a] + first - w->first[a];
  }
}

/* SplinePlacesSet - Computes the places of own fluid particles; not collective */
PetscErrorCode SplinePlacesSet(const Particles *p, Splines *s)
{
  PetscFunctionBegin;
  PetscCall(PlacesReserve(p->dim, p->n_fluid, &s->at));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    const PetscReal x[ISPH_MAX_DIM] = {p->x[0][i], p->x[1][i], p->dim == 3 ? p->x[2][i] : 0.0};

    SetPlace(&s->pressure, &s->window, x, i, &s->at);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplinePointPlacesSet - Computes the places of the points of quadrature inside; not collective.
   Nodes of cut cells may be outside their cells, and take the place of its centre. */
PetscErrorCode SplinePointPlacesSet(Splines *s)
{
  const SplinePoints *points = &s->inside;

  PetscFunctionBegin;
  PetscCall(PlacesReserve(s->lattice.dim, points->n, &s->inside_at));
  for (PetscInt g = 0; g < points->n; g++) {
    const PetscInt node = points->side[g], nodes = 1 << s->lattice.dim;
    PetscReal      x[ISPH_MAX_DIM] = {0.0};

    for (PetscInt a = 0; a < s->lattice.dim; a++)
      x[a] = node >= 0 ? s->bodies->cuts[node / nodes].centre[a] : points->x[a][g];
    SetPlace(&s->lattice, &s->window, x, g, &s->inside_at);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collects the coefficients of the window. */
static PetscErrorCode Collect(SplineWindow *w, Vec p)
{
  const PetscScalar *c;

  PetscFunctionBegin;
  PetscCall(VecScatterBegin(w->collect, p, w->coefficients, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecScatterEnd(w->collect, p, w->coefficients, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecGetArrayRead(w->coefficients, &c));
  for (PetscInt k = 0; k < w->size; k++) {
    w->value[k] = 0.0;
    for (PetscInt e = w->start[k]; e < w->start[k + 1]; e++)
      w->value[k] += w->weight[e] * c[w->source[e]];
  }
  PetscCall(VecRestoreArrayRead(w->coefficients, &c));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineWindowSum - Sums the values of the window into the splines that make its entries, those of
   other ranks too; collective */
PetscErrorCode SplineWindowSum(SplineWindow *w, Vec sum)
{
  PetscScalar *c;

  PetscFunctionBegin;
  PetscCall(VecZeroEntries(w->coefficients));
  PetscCall(VecGetArray(w->coefficients, &c));
  for (PetscInt k = 0; k < w->size; k++)
    for (PetscInt e = w->start[k]; e < w->start[k + 1]; e++)
      c[w->source[e]] += w->weight[e] * w->value[k];
  PetscCall(VecRestoreArray(w->coefficients, &c));
  PetscCall(VecZeroEntries(sum));
  PetscCall(VecScatterBegin(w->collect, w->coefficients, sum, ADD_VALUES, SCATTER_REVERSE));
  PetscCall(VecScatterEnd(w->collect, w->coefficients, sum, ADD_VALUES, SCATTER_REVERSE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Evaluates the splines at all particles: values, or gradients if `value` is NULL. Inlined, so that
   the compiler knows the dimension and the degree. */
static ISPH_INLINE void EvaluateInline(PetscInt dim, PetscInt degree, const SplineWindow *w,
                                       const SplinePlaces *at, PetscReal value[],
                                       PetscReal gradient[])
{
  const PetscInt m = degree + 1, row = w->n[0], plane = dim == 3 ? row * w->n[1] : 0;

  for (PetscInt i = 0; i < at->n; i++) {
    PetscReal b[ISPH_MAX_DIM][SPLINES_ALONG], d[ISPH_MAX_DIM][SPLINES_ALONG];
    PetscReal sum[1 + ISPH_MAX_DIM] = {0.0};

    for (PetscInt a = 0; a < dim; a++)
      SplineBasis(degree, at->t[a][i], at->per_edge[a][i], b[a], d[a]);
    for (PetscInt k = 0; k < (dim == 3 ? m : 1); k++) {
      PetscReal flat[3] = {0.0}; /* in a plane of splines: value, derivatives along two axes */

      for (PetscInt j = 0; j < m; j++) {
        const PetscReal *c     = w->value + at->base[i] + k * plane + j * row;
        PetscReal        along = b[0][0] * c[0], slope = d[0][0] * c[0];

        for (PetscInt e = 1; e < m; e++) along += b[0][e] * c[e];
        flat[0] += b[1][j] * along;
        if (value) continue;
        for (PetscInt e = 1; e < m; e++) slope += d[0][e] * c[e];
        flat[1] += b[1][j] * slope;
        flat[2] += d[1][j] * along;
      }
      for (PetscInt e = 0; e < 3; e++) sum[e] += dim == 3 ? b[2][k] * flat[e] : flat[e];
      if (dim == 3 && !value) sum[3] += d[2][k] * flat[0];
    }
    if (value) value[i] = sum[0];
    for (PetscInt a = 0; !value && a < dim; a++) gradient[dim * i + a] = sum[1 + a];
  }
}

static ISPH_WIDE void EvaluateWide(const Splines *s, PetscReal value[], PetscReal gradient[])
{
  if (s->lattice.dim == 2 && s->pressure.degree == 2) {
    EvaluateInline(2, 2, &s->window, &s->at, value, gradient);
  } else if (s->lattice.dim == 2) {
    EvaluateInline(2, 3, &s->window, &s->at, value, gradient);
  } else if (s->pressure.degree == 2) {
    EvaluateInline(3, 2, &s->window, &s->at, value, gradient);
  } else {
    EvaluateInline(3, 3, &s->window, &s->at, value, gradient);
  }
}

static PetscErrorCode Evaluate(Splines *s, Vec p, PetscReal value[], PetscReal gradient[])
{
  PetscFunctionBegin;
  PetscCall(Collect(&s->window, p));
  EvaluateWide(s, value, gradient);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplinesValue - Computes sum_q p_q psi_q at each own fluid particle; collective */
PetscErrorCode SplinesValue(Splines *s, Vec p, Vec value)
{
  PetscScalar *v;

  PetscFunctionBegin;
  PetscCall(VecGetArrayWrite(value, &v));
  PetscCall(Evaluate(s, p, v, NULL));
  PetscCall(VecRestoreArrayWrite(value, &v));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplinesGradient - Computes sum_q p_q grad psi_q at each own fluid particle [1/m], beside
   interfaces the adjoint of the divergence: component a at particle i at [i dim + a]; collective */
PetscErrorCode SplinesGradient(Splines *s, Vec p, PetscReal gradient[])
{
  const PetscScalar *g;
  Vec                excess;

  PetscFunctionBegin;
  if (!s->cut[0]) {
    PetscCall(Evaluate(s, p, NULL, gradient));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SplinesExcess(s, p, &excess));
  PetscCall(MatMult(s->cut[0], excess, s->cut_gradient));
  PetscCall(VecDestroy(&excess));
  PetscCall(VecGetArrayRead(s->cut_gradient, &g));
  PetscCall(PetscArraycpy(gradient, g, s->lattice.dim * s->at.n));
  PetscCall(VecRestoreArrayRead(s->cut_gradient, &g));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplinesGradientAtPoints - Computes sum_q p_q grad psi_q at the points of quadrature [1/m]:
   component a at point g at [g dim + a]; collective */
PetscErrorCode SplinesGradientAtPoints(Splines *s, Vec p, PetscReal gradient[])
{
  PetscFunctionBegin;
  PetscCall(Collect(&s->window, p));
  if (s->lattice.dim == 2) EvaluateInline(2, 2, &s->window, &s->inside_at, NULL, gradient);
  else EvaluateInline(3, 2, &s->window, &s->inside_at, NULL, gradient);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplinesAccelerate - Adds factor times SplinesGradient(), over the density of particles, to the
   components of a vector field over fluid; collective. The fits' work array holds the gradient. */
PetscErrorCode SplinesAccelerate(Splines *s, Vec p, PetscReal factor, const Vec u[])
{
  PetscScalar *v;

  PetscFunctionBegin;
  PetscCall(SplinesGradient(s, p, s->fits.value));
  SplinesDivideByInertia(s, s->fits.value);
  for (PetscInt a = 0; a < s->lattice.dim; a++) {
    PetscCall(VecGetArray(u[a], &v));
    for (PetscInt i = 0; i < s->at.n; i++) v[i] += factor * s->fits.value[s->lattice.dim * i + a];
    PetscCall(VecRestoreArray(u[a], &v));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
