/* Forms of two passes: the first computes the velocity gradient and the stress of each particle,
   the second the force from the stresses of its neighbours. Transposed forms give the pressure and
   the density the same gradient, so that momentum and energy stay. */
#include "wcsph.h"

#define WEAK 10.0  /* largest diagonal entry of an inverse moment matrix [-] */
#define FULL 0.999 /* kernel sum of a support that no surface cuts, over that of a lattice [-] */

/* Returns the composed form of the run; NULL: viscosity has one pass. */
const ComposedForm *WcsphComposed(const Wcsph *w)
{
  const LaplacianRow *row = w->flow->ops->forms.visc.row;

  return row ? row->composed : NULL;
}

/* Notes if a free surface cuts the support. The sum has volumes of the lattice: those of a region
   that its particles do not fill are smaller, inside too. */
static PetscErrorCode SurfaceRow(Stencil *st, void *ctx)
{
  const Wcsph *w   = (const Wcsph *)ctx;
  PetscReal    sum = st->self[0];

  PetscFunctionBegin;
  for (PetscInt k = 0; k < st->n; k++) sum += st->W[k];
  w->surface[st->i] = sum * w->flow->particles->cell_volume < FULL * w->lattice ? 1.0 : 0.0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* WcsphFindSurface - Finds the particles whose support a free surface cuts; collective */
PetscErrorCode WcsphFindSurface(Flow *flow, Wcsph *w)
{
  PetscFunctionBegin;
  PetscCall(
      OperatorsStream(flow->scene, flow->particles, flow->neighbors, flow->ops, SurfaceRow, w));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns true if a wall is in the support, or if a free surface cut it at the start. */
static PetscBool IsExterior(const Wcsph *w, const Stencil *st)
{
  return st->n_wall || (w->surface && w->surface[st->i] > 0.0) ? PETSC_TRUE : PETSC_FALSE;
}

/* Computes the inverse of M = sum_k V_k (grad_i W) X^T, which is I inside the fluid and about I/2
   on a plane surface. Returns false if the neighbours hardly span space, as in a string of
   particles: an entry of the diagonal of M^-1 is above WEAK. Input: weight - workspace. */
static PetscBool FirmMoment(const Stencil *st, PetscReal weight[], PetscReal inverse[])
{
  const PetscInt d = st->dim;

  MomentWeights(st, PETSC_TRUE, weight);
  if (!MomentInverse(st, weight, inverse)) return PETSC_FALSE;
  for (PetscInt a = 0; a < d; a++)
    if (inverse[a * (d + 1)] > WEAK) return PETSC_FALSE;
  return PETSC_TRUE;
}

/* Returns the correction of the gradient of a composed form at a particle, as CorrectionBit.
   Output: inverse - M^-1 of first order, otherwise unchanged. */
static unsigned GradientCorrection(const Wcsph *w, const ComposedForm *form, const Stencil *st,
                                   PetscReal inverse[])
{
  const CorrectionRow *chosen = w->flow->ops->forms.visc.correction;
  const unsigned       bit    = chosen ? chosen->bit : 0;

  if (form->gradient == GRADIENT_SPH) return bit;
  if (form->gradient == GRADIENT_COUPLED && !IsExterior(w, st)) return bit;
  return FirmMoment(st, w->pairs.w, inverse) ? CORRECTION_FIRST_ORDER : bit;
}

/* Multiplies a tensor from the right by a matrix. */
static void TimesMatrix(PetscInt d, const PetscReal matrix[], PetscReal tensor[])
{
  PetscReal product[ISPH_MAX_DIM * ISPH_MAX_DIM] = {0.0};

  for (PetscInt e = 0; e < d * d; e++)
    for (PetscInt b = 0; b < d; b++) product[e] += tensor[e / d * d + b] * matrix[b * d + e % d];
  for (PetscInt e = 0; e < d * d; e++) tensor[e] = product[e];
}

/*
  Computes and stores the stress of a particle

    tau = mu (g + g^T - t tr(g) I),   g_ab = sum_k (du_k)_a (c_k)_b

  or, for transposed forms, (tau - p I) M^-1, with M = I where the gradient has no correction. A
  transposed form also stores div u, for the density.
*/
static PetscErrorCode StressRow(Stencil *st, void *ctx)
{
  Wcsph              *w     = (Wcsph *)ctx;
  const Scene        *scene = w->flow->scene;
  const LaplacianRow *row   = w->flow->ops->forms.visc.row;
  const PetscInt      d     = st->dim;
  const PetscReal     mu = scene->nu * scene->rho, t = ComposedTrace(row->composed, d);
  Pairs              *pairs              = &w->pairs;
  PetscReal           none[ISPH_MAX_DIM] = {0.0}, g[ISPH_MAX_DIM * ISPH_MAX_DIM] = {0.0};
  PetscReal           trace = 0.0, stress[ISPH_MAX_DIM * ISPH_MAX_DIM];
  PetscReal           inverse[ISPH_MAX_DIM * ISPH_MAX_DIM];
  unsigned            correction;
  PairTerms           own = {.rho = w->local.rho[st->i]};
  PairSums            sums;

  PetscFunctionBegin;
  PetscCall(WcsphSetPairs(w, none, st));
  correction = GradientCorrection(w, row->composed, st, inverse);
  StencilGradients(st, correction);
  for (PetscInt e = 0; e < d * d; e++)
    for (PetscInt k = 0; k < st->n; k++) g[e] += pairs->du[e / d][k] * pairs->c[e % d][k];
  for (PetscInt a = 0; a < d; a++) trace += g[a * d + a];
  for (PetscInt e = 0; e < d * d; e++) {
    const PetscInt a = e / d, b = e % d;

    stress[e] = mu * (g[e] + g[b * d + a] - (a == b ? t * trace : 0.0));
    if (a == b && row->composed->transposed) stress[e] -= w->local.p[st->i];
  }
  if (row->composed->transposed && correction == CORRECTION_FIRST_ORDER)
    TimesMatrix(d, inverse, stress);
  for (PetscInt e = 0; e < d * d; e++) w->local.stress[e][st->i] = stress[e];
  PairsSum(st, pairs, &own, &sums);
  w->local.divergence[st->i] = sums.divergence;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* WcsphStresses - Computes the stresses of all local particles; collective. Does nothing unless the
   viscous form has two passes. */
PetscErrorCode WcsphStresses(Flow *flow, Wcsph *w)
{
  const PetscInt d = flow->scene->dim;

  PetscFunctionBegin;
  if (!WcsphComposed(w)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(
      OperatorsStream(flow->scene, flow->particles, flow->neighbors, flow->ops, StressRow, w));
  for (PetscInt e = 0; e < d * d; e++)
    PetscCall(ParticlesHaloField(flow->particles, w->local.stress[e]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns true if entry e of the stresses has the pressure in it: a diagonal entry of a transposed
   form. */
static PetscBool HasPressure(const Wcsph *w, PetscInt e)
{
  return WcsphComposed(w)->transposed && e % (w->flow->scene->dim + 1) == 0;
}

/*
  Computes the slopes of the stresses of a particle from its fluid neighbours, exact for linear
  stresses

    s_ab = M^-1 sum_k V_k ((tau_k)_ab - (tau_i)_ab) grad_i W_k,   M = sum_k V_k (grad_i W_k) X_k^T

  or, for transposed forms, those of P + p I. The slopes are zero if there is no wall or if the
  fluid does not span space.
*/
static void StressSlopes(const Wcsph *w, const Stencil *st, PetscReal slope[][ISPH_MAX_DIM])
{
  const PetscInt d      = st->dim;
  PetscReal     *weight = w->pairs.w, inverse[ISPH_MAX_DIM * ISPH_MAX_DIM];
  PetscBool      regular;

  for (PetscInt e = 0; e < d * d; e++)
    for (PetscInt a = 0; a < d; a++) slope[e][a] = 0.0;
  if (!st->n_wall) return;
  MomentWeights(st, PETSC_FALSE, weight);
  regular = MomentInverse(st, weight, inverse);
  for (PetscInt e = 0; e < d * d && regular; e++) {
    const PetscReal *stress = w->local.stress[e], *p = HasPressure(w, e) ? w->local.p : NULL;
    PetscReal        sum[ISPH_MAX_DIM] = {0.0};

    for (PetscInt k = 0; k < st->n; k++) {
      PetscReal rise = stress[st->j[k]] - stress[st->i];

      if (st->wall[k]) continue;
      if (p) rise += p[st->j[k]] - p[st->i];
      for (PetscInt b = 0; b < d; b++) sum[b] += weight[k] * rise * st->X[b][k];
    }
    for (PetscInt a = 0; a < d; a++)
      for (PetscInt b = 0; b < d; b++) slope[e][a] += inverse[a * d + b] * sum[b];
  }
}

/* Sets entry e of the stresses of the neighbours. A dummy has the stress of the particle, continued
   by the slopes, and its own pressure. */
static void NeighborStresses(const Wcsph *w, const Stencil *st, PetscInt e, const PetscReal slope[],
                             PetscReal value[])
{
  const PetscReal *stress   = w->local.stress[e];
  const PetscBool  pressure = HasPressure(w, e);

  for (PetscInt k = 0; k < st->n; k++) value[k] = stress[st->wall[k] ? st->i : st->j[k]];
  for (PetscInt k = 0; st->n_wall && k < st->n; k++) {
    if (!st->wall[k]) continue;
    for (PetscInt a = 0; a < st->dim; a++) value[k] += slope[a] * st->X[a][k];
    if (pressure) value[k] += w->local.p[st->i] + w->p_rest - w->pairs.p[k];
  }
}

/*
  StressForce - Adds the acceleration by the stresses of StressRow()

    1/rho_i sum_k (tau_k - tau_i).c_k                       or, transposed,
    1/rho_i sum_k V_k (P_k + P_i).grad_i W,   P = (tau - p I) M^-1

  The stress of a dummy behind a wall is that of NeighborStresses(): theory.md,
  (viscosity:continued). Input: c
  - with the correction of the form, or without correction if it is transposed
*/
void StressForce(const Wcsph *w, const Stencil *st, PetscReal acceleration[])
{
  const PetscInt  d    = st->dim;
  const PetscReal sign = WcsphComposed(w)->transposed ? 1.0 : -1.0;
  PetscReal       slope[ISPH_MAX_DIM * ISPH_MAX_DIM][ISPH_MAX_DIM], *value = w->pairs.w;

  StressSlopes(w, st, slope);
  for (PetscInt e = 0; e < d * d; e++) {
    const PetscReal *c   = w->pairs.c[e % d];
    const PetscReal  own = sign * w->local.stress[e][st->i];
    PetscReal        sum = 0.0;

    NeighborStresses(w, st, e, slope[e], value);
    for (PetscInt k = 0; k < st->n; k++) sum += (value[k] + own) * c[k];
    acceleration[e / d] += sum / w->local.rho[st->i];
  }
}
