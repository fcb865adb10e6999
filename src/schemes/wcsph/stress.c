/*
  Forms of two passes: the first computes the velocity gradient and the stress of each particle, the
  second the force from the stresses of its neighbours. Transposed forms give the pressure and the
  density the same gradient, so that momentum and energy stay.
*/
#include "wcsph.h"

/* Returns the composed form of the run; NULL: viscosity has one pass, or is implicit. */
const ComposedForm *WcsphComposed(const Wcsph *w)
{
  const LaplacianRow *row = w->flow->ops->forms.visc.row;

  return row && !w->implicit ? row->composed : NULL;
}

/* Returns true if a wall, or a particle that was on a free surface at the start, is in the
   support. */
static PetscBool IsExterior(const Wcsph *w, const Stencil *st)
{
  if (st->n_wall) return PETSC_TRUE;
  if (!w->surface) return PETSC_FALSE;
  if (w->surface[st->i] > 0.0) return PETSC_TRUE;
  for (PetscInt k = 0; k < st->n; k++)
    if (w->surface[st->j[k]] > 0.0) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Returns the correction of the gradient of a composed form at a particle, as CorrectionBit. */
static unsigned GradientCorrection(const Wcsph *w, const ComposedForm *form, const Stencil *st)
{
  const CorrectionRow *chosen = w->flow->ops->forms.visc.correction;

  if (form->gradient == GRADIENT_FIRST_ORDER) return CORRECTION_FIRST_ORDER;
  if (form->gradient == GRADIENT_COUPLED && IsExterior(w, st)) return CORRECTION_FIRST_ORDER;
  return chosen ? chosen->bit : 0;
}

/* Multiplies a tensor from the right by M^-1, M = sum_k V_k (grad_i W) X^T; leaves it if the
   neighbours do not span space. */
static void TimesInverseMoment(const Stencil *st, PetscReal weight[], PetscReal tensor[])
{
  const PetscInt d = st->dim;
  PetscReal      inverse[ISPH_MAX_DIM * ISPH_MAX_DIM], product[ISPH_MAX_DIM * ISPH_MAX_DIM];

  for (PetscInt k = 0; k < st->n; k++) weight[k] = -st->V[k] * st->dW[k] / st->r[k];
  if (!MomentInverse(st, weight, inverse)) return;
  for (PetscInt e = 0; e < d * d; e++) {
    product[e] = 0.0;
    for (PetscInt b = 0; b < d; b++) product[e] += tensor[e / d * d + b] * inverse[b * d + e % d];
  }
  for (PetscInt e = 0; e < d * d; e++) tensor[e] = product[e];
}

/*
  Computes and stores the stress of a particle

    tau = mu (g + g^T - t tr(g) I),   g_ab = sum_k (du_k)_a (c_k)_b

  or, for transposed forms, (tau - p I) M^-1, with M = I where the gradient has no correction. A
  transposed form also stores tr(g), for the density.
*/
static PetscErrorCode StressRow(Stencil *st, void *ctx)
{
  Wcsph              *w     = (Wcsph *)ctx;
  const Scene        *scene = w->flow->scene;
  const LaplacianRow *row   = w->flow->ops->forms.visc.row;
  const PetscInt      d     = st->dim;
  const PetscReal     mu = scene->nu * scene->rho, t = 1.0 - row->grad_div;
  const unsigned      correction         = GradientCorrection(w, row->composed, st);
  Pairs              *pairs              = &w->pairs;
  PetscReal           none[ISPH_MAX_DIM] = {0.0}, g[ISPH_MAX_DIM * ISPH_MAX_DIM] = {0.0};
  PetscReal           trace = 0.0, stress[ISPH_MAX_DIM * ISPH_MAX_DIM];

  PetscFunctionBegin;
  PetscCall(WcsphSetPairs(w, none, st));
  KernelGradients(st, correction, pairs->c);
  for (PetscInt e = 0; e < d * d; e++)
    for (PetscInt k = 0; k < st->n; k++) g[e] += pairs->du[e / d][k] * pairs->c[e % d][k];
  for (PetscInt a = 0; a < d; a++) trace += g[a * d + a];
  for (PetscInt e = 0; e < d * d; e++) {
    const PetscInt a = e / d, b = e % d;

    stress[e] = mu * (g[e] + g[b * d + a] - (a == b ? t * trace : 0.0));
    if (a == b && row->composed->transposed) stress[e] -= w->local.p[st->i];
  }
  if (row->composed->transposed && correction == CORRECTION_FIRST_ORDER)
    TimesInverseMoment(st, pairs->w, stress);
  for (PetscInt e = 0; e < d * d; e++) w->local.stress[e][st->i] = stress[e];
  w->local.divergence[st->i] = trace;
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

/*
  StressForce - Adds the acceleration by the stresses of StressRow()

    1/rho_i sum_k (tau_k - tau_i).c_k                       or, transposed,
    1/rho_i sum_k V_k (P_k + P_i).grad_i W,   P = (tau - p I) M^-1

  A dummy behind a wall has the stress of the particle. Input: c - with the correction of the form,
  or without correction if it is transposed; not collective
*/
void StressForce(const Wcsph *w, const Stencil *st, PetscReal acceleration[])
{
  const PetscInt  d = st->dim, i = st->i;
  const PetscReal sign = WcsphComposed(w)->transposed ? 1.0 : -1.0;

  for (PetscInt e = 0; e < d * d; e++) {
    const PetscReal *stress = w->local.stress[e], *c = w->pairs.c[e % d];
    PetscReal        sum = 0.0;

    for (PetscInt k = 0; k < st->n; k++)
      sum += ((st->wall[k] ? stress[i] : stress[st->j[k]]) + sign * stress[i]) * c[k];
    acceleration[e / d] += sum / w->local.rho[i];
  }
}
