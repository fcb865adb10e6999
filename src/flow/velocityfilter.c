/* The velocity filter by rates: it takes a part of the residual of a quadratic fit of the velocity,
   as fast as the flow can amplify disturbances that the pressure does not act on. A velocity w
   between the points of a coarse pressure is free of divergence for them, whatever it is. So it
   grows by -w.grad u as in Burgers' equation, in the direction in which the flow compresses, where
   no pressure turns it away. */
#include "isph/flow.h"

#define FILTER_RATE 2.0 /* factor of |A A|^(1/2) [-] */

/* Returns |A| of a gradient A_ca = du_c/dx_a, and |A A| in `product`; both are Frobenius' norms. */
static PetscReal GradientNorms(PetscInt dim, PetscReal A[][ISPH_MAX_DIM], PetscReal *product)
{
  PetscReal length = 0.0;

  *product = 0.0;
  for (PetscInt c = 0; c < dim; c++) {
    for (PetscInt a = 0; a < dim; a++) {
      PetscReal entry = 0.0;

      for (PetscInt b = 0; b < dim; b++) entry += A[c][b] * A[b][a];
      *product += PetscSqr(entry);
      length += PetscSqr(A[c][a]);
    }
  }
  *product = PetscSqrtReal(*product);
  return PetscSqrtReal(length);
}

/* Computes D r of VelocityFilter() for the gradient A with |A| = length and |A A| = product. */
static void ShearTimes(PetscInt dim, PetscReal A[][ISPH_MAX_DIM], PetscReal length,
                       PetscReal product, const PetscReal r[], PetscReal result[])
{
  PetscReal turned[ISPH_MAX_DIM] = {0.0};

  for (PetscInt c = 0; c < dim; c++)
    for (PetscInt a = 0; a < dim; a++) turned[c] += A[c][a] * r[a];
  for (PetscInt a = 0; a < dim; a++) {
    result[a] = -product / PetscSqrtReal((PetscReal)dim) * r[a];
    for (PetscInt c = 0; c < dim; c++) result[a] += A[c][a] * turned[c];
    result[a] /= length;
  }
}

/* VelocityFilterActsOnShear - Returns true if the filter damps disturbances across a shear, see
   VelocityFilter() */
PetscBool VelocityFilterActsOnShear(const Flow *flow)
{
  Regime *regime = flow->scene->regime;

  RegimeSetFact(regime, FACT_STRONG, flow->state->velocity_filter > 1.0);
  return RegimeValue(regime, REGIME_SHEAR) > 0.0;
}

/*
  VelocityFilter - Adds the change by which grid modes are filtered out of a particle's velocity

    u -= min(1, S) min(1, k |A A|^(1/2)) r + k D r,   k = max(1, S) RATE dt,
    D = (A^T A - |A A|/d^(1/2) I)/|A|,   A_ca = du_c/dx_a

  |.| is Frobenius' norm, S is -velocity_filter, RATE is FILTER_RATE, and r the residual of a
  quadratic fit of u at the particle in d dimensions. |A A|^(1/2) is the rate at which the flow can
  amplify disturbances in strain and rotation. In these D vanishes. In parallel flow A A vanishes,
  and D is the shear rate times the projection on its direction: disturbances across the flow, which
  take energy from the shear, are damped, and boundary layers, however thin, keep their velocity. In
  a resolved flow the rate is U/L, and the filter is of order 3. A strength below 1 is a share,
  above 1 it multiplies the rate; the regime decides on the last term (`across`), which counts for a
  pressure on coarse points only. k in this term is bounded, so that no component of r changes its
  sign. See theory.md, (filters:velocity) and (filters:shear). Input: A - gradient of the velocity
  [1/s]; r - residual of its fit [m/s]; factor - S; across - flag: VelocityFilterActsOnShear(); dt -
  length of the step [s]. Input/Output: change - of the velocity [m/s].
*/
void VelocityFilter(PetscInt dim, PetscReal A[][ISPH_MAX_DIM], const PetscReal r[],
                    PetscReal factor, PetscBool across, PetscReal dt, PetscReal change[])
{
  const PetscReal k = PetscMax(1.0, factor) * FILTER_RATE * dt;
  PetscReal       shear[ISPH_MAX_DIM], product, share, along;
  const PetscReal length = GradientNorms(dim, A, &product);

  if (length == 0.0) return;
  share = PetscMin(1.0, k * PetscSqrtReal(product));
  along = across ? PetscMin(k, (1.0 - share) / length) : 0.0;
  share *= PetscMin(1.0, factor);
  for (PetscInt c = 0; c < dim; c++) change[c] -= share * r[c];
  if (along == 0.0) return;
  ShearTimes(dim, A, length, product, r, shear);
  for (PetscInt c = 0; c < dim; c++) change[c] -= along * shear[c];
}

/* Gradients of the velocity components at [c][a], and with a filter their residuals. */
typedef struct {
  AffineProducts     products;
  const PetscScalar *value[ISPH_MAX_DIM][AFFINE_MOST];
} FilterFields;

/* Computes the gradients of a velocity v, and with `residuals` the residuals of its fits. */
static PetscErrorCode FieldsGet(Flow *flow, const Vec v[], PetscBool residuals, FilterFields *f)
{
  const PetscInt  dim = flow->scene->dim;
  AffineProducts *of  = &f->products;

  PetscFunctionBegin;
  of->fields = dim;
  of->n      = dim + (residuals ? 1 : 0);
  for (PetscInt c = 0; c < dim; c++) {
    const VelocityOperators *ops = OperatorsOfVelocity(flow->ops, c);

    of->f[c]     = v[c];
    of->walls[c] = flow->walls.u[c];
    for (PetscInt k = 0; k < of->n; k++) {
      of->op[c][k] = k < dim ? &ops->grad_u[k] : &ops->filter_u;
      PetscCall(FlowGetWork(flow, &of->y[c][k]));
    }
  }
  PetscCall(AffineApplyFields(of));
  for (PetscInt c = 0; c < dim; c++)
    for (PetscInt k = 0; k < of->n; k++) PetscCall(VecGetArrayRead(of->y[c][k], &f->value[c][k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FieldsRestore(Flow *flow, FilterFields *f)
{
  PetscFunctionBegin;
  for (PetscInt c = 0; c < f->products.fields; c++) {
    for (PetscInt k = 0; k < f->products.n; k++) {
      PetscCall(VecRestoreArrayRead(f->products.y[c][k], &f->value[c][k]));
      PetscCall(FlowRestoreWork(flow, &f->products.y[c][k]));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the gradient at particle i. */
static void GradientAt(PetscInt dim, const FilterFields *f, PetscInt i, PetscReal A[][ISPH_MAX_DIM])
{
  for (PetscInt c = 0; c < dim; c++)
    for (PetscInt a = 0; a < dim; a++) A[c][a] = f->value[c][a][i];
}

/* FlowFilter - Filters grid modes out of the velocities of fixed particles before a step.
   Collective. Earlier velocities receive the same change, so that it is no change in time. */
PetscErrorCode FlowFilter(Flow *flow)
{
  const PetscInt   dim    = flow->scene->dim;
  const Particles *p      = flow->particles;
  FlowState       *s      = flow->state;
  const PetscBool  across = VelocityFilterActsOnShear(flow);
  FilterFields     f;

  PetscFunctionBegin;
  PetscCall(FieldsGet(flow, s->u, PETSC_TRUE, &f));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscReal A[ISPH_MAX_DIM][ISPH_MAX_DIM], r[ISPH_MAX_DIM], change[ISPH_MAX_DIM] = {0.0};

    GradientAt(dim, &f, i, A);
    for (PetscInt c = 0; c < dim; c++) r[c] = f.value[c][dim][i];
    VelocityFilter(dim, A, r, s->velocity_filter, across, flow->clock->dt, change);
    for (PetscInt c = 0; c < dim; c++) {
      p->u[c][i] += change[c];
      s->u_previous[c][i] += change[c];
      if (s->u_earlier[c]) s->u_earlier[c][i] += change[c];
    }
  }
  PetscCall(FieldsRestore(flow, &f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  VelocityFilterRates - Computes the rates of the filter in an implicit step, for ConvectionApply()

    S min(1/dt, RATE (|A A|^(1/2) + max(0, D_cc)))   for component c, see VelocityFilter()

  Collective. Does nothing unless convection is implicit and S above 1. A rate beyond that of the
  step would follow the velocity, with a delay, faster than a step can. To be ended by
  VelocityFilterForget(). Input: v - advecting velocity [m/s].
*/
PetscErrorCode VelocityFilterRates(Flow *flow, const Vec v[])
{
  const PetscInt  dim    = flow->scene->dim;
  FlowState      *s      = flow->state;
  const PetscBool across = VelocityFilterActsOnShear(flow);
  PetscScalar    *rate[ISPH_MAX_DIM];
  FilterFields    f;

  PetscFunctionBegin;
  if (!s->implicit_convection || s->velocity_filter <= 1.0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FieldsGet(flow, v, PETSC_FALSE, &f));
  for (PetscInt c = 0; c < dim; c++) {
    PetscCall(FlowGetWork(flow, &s->filter_rate[c]));
    PetscCall(VecGetArrayWrite(s->filter_rate[c], &rate[c]));
  }
  for (PetscInt i = 0; i < flow->particles->n_fluid; i++) {
    PetscReal A[ISPH_MAX_DIM][ISPH_MAX_DIM], product, length;

    GradientAt(dim, &f, i, A);
    length = GradientNorms(dim, A, &product);
    for (PetscInt c = 0; c < dim; c++) {
      PetscReal unit[ISPH_MAX_DIM] = {0.0}, shear[ISPH_MAX_DIM] = {0.0};

      unit[c] = 1.0;
      if (across && length > 0.0) ShearTimes(dim, A, length, product, unit, shear);
      rate[c][i] = s->velocity_filter *
                   PetscMin(1.0 / flow->clock->dt,
                            FILTER_RATE * (PetscSqrtReal(product) + PetscMax(0.0, shear[c])));
    }
  }
  for (PetscInt c = 0; c < dim; c++) PetscCall(VecRestoreArrayWrite(s->filter_rate[c], &rate[c]));
  PetscCall(FieldsRestore(flow, &f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* VelocityFilterForget - Ends the use of the rates; collective */
PetscErrorCode VelocityFilterForget(Flow *flow)
{
  PetscFunctionBegin;
  for (PetscInt c = 0; c < flow->scene->dim; c++)
    PetscCall(FlowRestoreWork(flow, &flow->state->filter_rate[c]));
  PetscFunctionReturn(PETSC_SUCCESS);
}
