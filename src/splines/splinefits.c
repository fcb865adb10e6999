/* Fits of the velocity of particles at the points of quadrature of the splines. Walls take part
   with their normal velocity: beside walls along the axes in the fit of one component, beside
   oblique walls in a fit of all components together. The points of a cell share most of their
   particles and are treated together. */
#include "splines.h"

/* A fit of all components at a point; the arrays are those of VectorFit(). */
typedef struct {
  PetscInt  n, j[ISPH_MAX_DIM * NEAREST_CAPACITY];
  PetscReal s[ISPH_MAX_DIM][ISPH_MAX_DIM * NEAREST_CAPACITY], W[ISPH_MAX_DIM * NEAREST_CAPACITY];
  PetscReal w[ISPH_MAX_DIM * ISPH_MAX_DIM][ISPH_MAX_DIM * NEAREST_CAPACITY];
  PetscBool wall[ISPH_MAX_DIM * NEAREST_CAPACITY];
  PetscReal normal[ISPH_MAX_DIM][ISPH_MAX_DIM * NEAREST_CAPACITY];
} CoupledFit;

/* Particles around a cell, for the fits of a component. */
typedef struct {
  Flow         *flow;
  SplineAround *around;
  PetscInt      component;
  PetscReal     reach[POINT_FITS]; /* of the last search about each point [m] */
} Search;

/* Sets the fit of the `wanted` nearest particles at point i; input: ctx - a Search. */
static PetscErrorCode Fill(void *ctx, PetscInt i, PetscInt wanted, NearestFits *f, PetscBool *more)
{
  Search             *search = (Search *)ctx;
  const SplineAround *around = search->around;
  const PetscInt      dim = search->flow->particles->dim, m = 1 << dim;
  PetscReal           inverse;

  PetscFunctionBegin;
  PetscCall(SplineNearest(search->flow, i, search->component, wanted, search->around,
                          &search->reach[i], &f->n[i], &f->R[i], more));
  inverse = 1.0 / f->R[i];
  for (PetscInt e = 0; e < f->n[i]; e++) {
    const PetscInt k = around->found[e];

    f->j[e * m + i] = around->j[k];
    f->W[e * m + i] = NearestWeight(PetscSqrtReal(around->r2[k]) * inverse);
    for (PetscInt a = 0; a < dim; a++)
      f->s[a][e * m + i] = around->stretch[a][i] * (around->x[a][k] - around->at[a][i]) * inverse;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the largest sum of the absolute weights of a component. */
static PetscReal LargestSum(PetscInt dim, const CoupledFit *f)
{
  PetscReal largest = 0.0;

  for (PetscInt a = 0; a < dim; a++) {
    PetscReal sum = 0.0;

    for (PetscInt b = 0; b < dim; b++) {
      for (PetscInt k = 0; k < f->n; k++) sum += PetscAbsReal(f->w[a * dim + b][k]);
    }
    largest = PetscMax(largest, sum);
  }
  return largest;
}

/* Fills the particles of a coupled fit up with the weight zero. */
static void PadCoupled(PetscInt dim, CoupledFit *f)
{
  for (PetscInt k = f->n; k < LanesPadded(f->n); k++) {
    f->W[k]    = 0.0;
    f->wall[k] = PETSC_FALSE;
    for (PetscInt a = 0; a < dim; a++) f->s[a][k] = f->normal[a][k] = 0.0;
  }
}

/* Sets the weights of a coupled fit to those of a mean. */
static void SetCoupledMean(PetscInt dim, CoupledFit *f)
{
  PetscReal sum = 0.0;

  for (PetscInt k = 0; k < f->n; k++) sum += f->W[k];
  for (PetscInt k = 0; k < f->n; k++) {
    for (PetscInt e = 0; e < dim * dim; e++) f->w[e][k] = e % (dim + 1) ? 0.0 : f->W[k] / sum;
  }
}

/* Sets the weights of fit i to those of a mean. */
static void SetMean(PetscInt m, PetscInt i, NearestFits *f)
{
  PetscReal sum = 0.0;

  for (PetscInt k = 0; k < f->n[i]; k++) sum += f->W[k * m + i];
  for (PetscInt k = 0; k < f->n[i]; k++) f->w[k * m + i] = f->W[k * m + i] / sum;
}

/* Computes the fits of component c at the points of a cell that have a flag. */
static PetscErrorCode FitComponent(Flow *flow, PetscInt c, const PetscBool todo[],
                                   SplineAround *around, NearestFits *f)
{
  const PetscInt dim = flow->particles->dim, degree = flow->ops->forms.degree;
  Search         search = {.flow = flow, .around = around, .component = c};

  PetscFunctionBegin;
  PetscCall(NearestFitsCompute(dim, degree, SplineLeast(dim, degree), todo, Fill, &search, f));
  for (PetscInt i = 0; i < around->m; i++) {
    if (!f->n[i] || f->fits[i]) continue;
    flow->ops->regularised_rows++;
    SetMean(1 << dim, i, f);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the fit of all components at point i of a cell, see FitComponent(). */
static PetscErrorCode FitCoupled(Flow *flow, PetscInt i, SplineAround *around, CoupledFit *f)
{
  const Particles *p   = flow->particles;
  const PetscInt   dim = p->dim, degree = flow->ops->forms.degree, least = SplineLeast(dim, degree);
  PetscReal       *s[ISPH_MAX_DIM], *normal[ISPH_MAX_DIM], *w[ISPH_MAX_DIM * ISPH_MAX_DIM];
  PetscReal        reach = 0.0, R = 0.0, size;
  PetscInt         wanted = least;
  PetscBool        found;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < dim; a++) {
    s[a]      = f->s[a];
    normal[a] = f->normal[a];
  }
  for (PetscInt e = 0; e < dim * dim; e++) w[e] = f->w[e];
  for (size = PETSC_INFINITY;; wanted += least / 3) {
    PetscCall(SplineNearest(flow, i, SPLINE_ALL, wanted, around, &reach, &f->n, &R, &found));
    for (PetscInt e = 0; e < f->n; e++) {
      const PetscInt k = around->found[e];

      f->j[e]    = around->j[k];
      f->wall[e] = around->wall[k];
      f->W[e]    = NearestWeight(PetscSqrtReal(around->r2[k]) / R);
      for (PetscInt a = 0; a < dim; a++) {
        f->s[a][e]      = around->stretch[a][i] * (around->x[a][k] - around->at[a][i]) / R;
        f->normal[a][e] = f->wall[e] ? p->normal[a][f->j[e]] : 0.0;
      }
    }
    PadCoupled(dim, f);
    size = VectorFit(dim, degree, LanesPadded(f->n), s, f->W, f->wall, normal, w)
               ? LargestSum(dim, f)
               : PETSC_INFINITY;
    if (!NearestTakesMore(least, wanted, found, size)) break;
  }
  if (size < PETSC_INFINITY) PetscFunctionReturn(PETSC_SUCCESS);
  flow->ops->regularised_rows++;
  SetCoupledMean(dim, f);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Fits at the points of a cell. */
typedef struct {
  PetscBool   oblique[POINT_FITS];              /* point i has a coupled fit */
  PetscInt    shared[ISPH_MAX_DIM][POINT_FITS]; /* component whose fit serves component c */
  NearestFits component[ISPH_MAX_DIM];
  CoupledFit  all[POINT_FITS];
} CellFits;

/* Computes all fits in a cell. Beside walls each component has a fit of its own; elsewhere they
   share it. Beside walls oblique to the axes there is a fit of all components together. */
static PetscErrorCode FitCell(Flow *flow, PetscInt sets, SplineAround *around, CellFits *f)
{
  const Particles *p = flow->particles;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < around->m; i++) f->oblique[i] = SplineIsNearOblique(flow, i, around);
  for (PetscInt c = 0; c < sets; c++) {
    PetscBool todo[POINT_FITS] = {PETSC_FALSE}; /* a cell may have fewer points here */

    for (PetscInt i = 0; i < around->m; i++) {
      f->shared[c][i] = c;
      for (PetscInt b = c - 1; b >= 0 && !f->oblique[i]; b--) {
        if (f->shared[b][i] == b && SplineFitIsShared(p, i, b, c, f->component[b].R[i], around))
          f->shared[c][i] = b;
      }
      todo[i] = !f->oblique[i] && f->shared[c][i] == c;
    }
    PetscCall(FitComponent(flow, c, todo, around, &f->component[c]));
  }
  for (PetscInt i = 0; i < around->m; i++)
    if (f->oblique[i]) PetscCall(FitCoupled(flow, i, around, &f->all[i]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the fit of component a from component b at point g: weights w[k step] of n particles
   j[k step]. */
static PetscErrorCode AddFit(PetscInt a, PetscInt b, PetscInt g, PetscInt n, PetscInt step,
                             const PetscInt j[], const PetscReal w[], SplineFits *f)
{
  PetscFunctionBegin;
  if (f->n + n > f->capacity) {
    f->capacity = f->n + n + f->n / 8 + 1024;
    PetscCall(PetscRealloc(sizeof(*f->j) * (size_t)f->capacity, &f->j));
    PetscCall(PetscRealloc(sizeof(*f->w) * (size_t)f->capacity, &f->w));
  }
  f->first[a][b][g] = f->n;
  for (PetscInt k = 0; k < n; k++) {
    f->j[f->n + k] = j[k * step];
    f->w[f->n + k] = w[k * step];
  }
  f->n += n;
  f->last[a][b][g] = f->n;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the fits of component a at point i of a cell, which has the number g. */
static PetscErrorCode AddComponent(PetscInt dim, PetscInt a, PetscInt i, PetscInt g,
                                   const CellFits *cell, SplineFits *f)
{
  const PetscInt     m = 1 << dim, shared = cell->shared[a][i];
  const NearestFits *fit = &cell->component[a];
  const CoupledFit  *all = &cell->all[i];

  PetscFunctionBegin;
  for (PetscInt b = 0; b < dim; b++) {
    if (a != b && !f->coupled) continue;
    if (cell->oblique[i]) {
      PetscCall(AddFit(a, b, g, all->n, 1, all->j, all->w[a * dim + b], f));
    } else if (a == b && shared != a) {
      f->first[a][a][g] = f->first[shared][shared][g];
      f->last[a][a][g]  = f->last[shared][shared][g];
    } else {
      PetscCall(AddFit(a, b, g, a == b ? fit->n[i] : 0, m, &fit->j[i], &fit->w[i], f));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Empties the list of fits and makes room for the ranges of n points. */
static PetscErrorCode BeginFits(const Flow *flow, PetscBool coupled, PetscInt n, SplineFits *f)
{
  PetscFunctionBegin;
  f->n       = 0;
  f->sets    = SceneHas(flow->scene, PHYSICS_WALLS) ? flow->scene->dim : 1;
  f->coupled = coupled;
  if (f->points == n && f->first[0][0]) PetscFunctionReturn(PETSC_SUCCESS);
  f->points   = n;
  f->capacity = PetscMax(f->capacity, n * SplineLeast(flow->scene->dim, flow->ops->forms.degree));
  PetscCall(PetscRealloc(sizeof(*f->j) * (size_t)f->capacity, &f->j));
  PetscCall(PetscRealloc(sizeof(*f->w) * (size_t)f->capacity, &f->w));
  for (PetscInt a = 0; a < f->sets; a++) {
    for (PetscInt b = 0; b < flow->scene->dim; b++) {
      if (a != b && !f->coupled) continue;
      PetscCall(PetscFree2(f->first[a][b], f->last[a][b]));
      PetscCall(PetscMalloc2(n, &f->first[a][b], n, &f->last[a][b]));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineFitsAssemble - Computes the fits at all points of this rank, unless strain cells that end
   at a free surface have the divergence; collective */
PetscErrorCode SplineFitsAssemble(Flow *flow, Splines *s)
{
  const Particles *p = flow->particles;
  SplineFits      *f = &s->fits;
  SplineAround     around;
  CellFits        *cell;

  PetscFunctionBegin;
  if (flow->ops->cut_surface) {
    PetscCall(SplineFitsReserve(p, f));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscNew(&cell));
  PetscCall(SplineAroundCreate(flow, &around));
  PetscCall(BeginFits(flow, s->bodies ? PETSC_TRUE : PETSC_FALSE, s->inside.n, f));
  PetscCall(SplineFitsReserve(p, f));
  for (PetscInt first = 0; first < s->inside.n; first += around.m) {
    PetscCall(SplineAroundSet(flow, s, first, &around));
    PetscCall(FitCell(flow, f->sets, &around, cell));
    for (PetscInt i = 0; i < around.m; i++) {
      for (PetscInt a = 0; a < f->sets; a++)
        PetscCall(AddComponent(p->dim, a, i, first + i, cell, f));
    }
  }
  PetscCall(SplineAroundFree(&around));
  PetscCall(PetscFree(cell));
  PetscFunctionReturn(PETSC_SUCCESS);
}
