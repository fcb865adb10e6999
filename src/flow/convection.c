/* The convective term of fixed particles. In a turning frame, see src/scene/scene.c, the advecting
   velocity is that relative to the frame, and w z x u, by which its axes turn, belongs to the
   term. */
#include "isph/flow.h"

/* ConvectionCentral - Computes the convective term v.grad u from the gradient operators, without
   the velocity filter. Collective. For inputs and output see ConvectionApply(); walls NULL:
   zero. */
static PetscErrorCode ConvectionCentral(PetscInt dim, const VelocityOperators *of, const Vec v[],
                                        Vec u, Vec walls, Vec work, Vec result)
{
  PetscFunctionBegin;
  PetscCall(VecZeroEntries(result));
  for (PetscInt a = 0; a < dim; a++) {
    PetscCall(AffineApply(&of->grad_u[a], u, walls, work));
    PetscCall(VecPointwiseMult(work, work, v[a]));
    PetscCall(VecAXPY(result, 1.0, work));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Multiplies x by the factor of the residual of the fit of component c in ConvectionApply(),
   -velocity_filter included [1/s]. */
static PetscErrorCode ScaleByFilterRate(const Flow *flow, const Vec v[], PetscInt c, Vec x)
{
  const Scene       *scene    = flow->scene;
  const PetscReal    strength = flow->state->velocity_filter;
  const PetscReal    nu       = SceneHas(scene, PHYSICS_VISCOSITY) ? scene->nu_low : 0.0;
  const PetscReal   *dx       = flow->particles->dx;
  const PetscScalar *at[ISPH_MAX_DIM];
  PetscScalar       *value;
  PetscInt           n;

  PetscFunctionBegin;
  if (flow->state->filter_rate[c]) {
    PetscCall(VecPointwiseMult(x, x, flow->state->filter_rate[c]));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(VecGetLocalSize(x, &n));
  PetscCall(VecGetArray(x, &value));
  for (PetscInt a = 0; a < scene->dim; a++) PetscCall(VecGetArrayRead(v[a], &at[a]));
  for (PetscInt i = 0; i < n; i++) {
    PetscReal speed2 = 0.0;

    for (PetscInt a = 0; a < scene->dim; a++)
      speed2 += PetscSqr(ParticlesStretch(flow->particles, a, i) * at[a][i]);
    value[i] *= strength / dx[i] * PetscMax(0.0, PetscSqrtReal(speed2) - 2.0 * nu / dx[i]);
  }
  for (PetscInt a = 0; a < scene->dim; a++) PetscCall(VecRestoreArrayRead(v[a], &at[a]));
  PetscCall(VecRestoreArray(x, &value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns true if the convective term of component c has a velocity filter; one of a strength
   above 1 acts before explicit steps, FlowFilter(). */
static PetscBool HasFilter(const Flow *flow, PetscInt c)
{
  if (!OperatorsOfVelocity(flow->ops, c)->filter_u.needed) return PETSC_FALSE;
  return flow->state->velocity_filter <= 1.0 || flow->state->filter_rate[c];
}

/*
  ConvectionApply - Computes the convective term of fixed particles, with the velocity filter

    (v.grad u)_i + S max(0, |v_a/e_a|_i - 2 nu/dx_i^2) (u - fit)_i

  Collective. S is -velocity_filter, e_a the edges of the particle's cell, and fit the value of a
  quadratic fit of u at particle i. The second term is the difference between upwind-biased and
  central differences. It damps grid modes in the time in which the flow passes dx, and only if |v|
  dx/nu > 2. It is of order 2, U dx^2 u''', on any arrangement of particles, and of order 3 on
  lattices. Without it (-velocity_filter 0) explicit steps of the first term amplify grid modes that
  viscosity does not damp. For S above 1 the factor is that of VelocityFilterRates(). Input: v -
  advecting velocity over fluid [m/s]; c - number of the convected component; u - convected
  component, with its wall data `walls` [m/s]; work - work vector. Output: result - the convective
  term [m/s^2].
*/
PetscErrorCode ConvectionApply(const Flow *flow, const Vec v[], PetscInt c, Vec u, Vec walls,
                               Vec work, Vec result)
{
  const VelocityOperators *of = OperatorsOfVelocity(flow->ops, c);

  PetscFunctionBegin;
  PetscCall(ConvectionCentral(flow->scene->dim, of, v, u, walls, work, result));
  if (!HasFilter(flow, c)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(AffineApply(&of->filter_u, u, walls, work));
  PetscCall(ScaleByFilterRate(flow, v, c, work));
  PetscCall(VecAXPY(result, 1.0, work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds diag(rate) A to a matrix of the same sparsity pattern. */
static PetscErrorCode AddScaled(Mat A, Vec rate, Mat work, Mat sum)
{
  PetscFunctionBegin;
  PetscCall(MatCopy(A, work, SAME_NONZERO_PATTERN));
  PetscCall(MatDiagonalScale(work, rate, NULL));
  PetscCall(MatAXPY(sum, 1.0, work, SAME_NONZERO_PATTERN));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ConvectionAddMatrix - Adds the matrix of ConvectionApply(), without its wall data, to a matrix.
   Collective. Input: v - advecting velocity over fluid [m/s]; c - number of the convected
   component; work - work matrix with the sparsity pattern of `sum`; rate - work vector.
   Input/Output: sum - matrix [1/s]. */
PetscErrorCode ConvectionAddMatrix(const Flow *flow, const Vec v[], PetscInt c, Mat work, Vec rate,
                                   Mat sum)
{
  const VelocityOperators *of = OperatorsOfVelocity(flow->ops, c);

  PetscFunctionBegin;
  for (PetscInt a = 0; a < flow->scene->dim; a++)
    PetscCall(AddScaled(of->grad_u[a].A, v[a], work, sum));
  if (!HasFilter(flow, c)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecSet(rate, 1.0));
  PetscCall(ScaleByFilterRate(flow, v, c, rate));
  PetscCall(AddScaled(of->filter_u.A, rate, work, sum));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ConvectionPass - Changes velocities over the fluid at time t by ScenePassing(), into the velocity
   that advects; collective */
PetscErrorCode ConvectionPass(const Flow *flow, PetscReal t, const Vec v[])
{
  const Particles *p = flow->particles;
  PetscScalar     *value[ISPH_MAX_DIM];

  PetscFunctionBegin;
  if (!flow->scene->frame) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt a = 0; a < p->dim; a++) PetscCall(VecGetArray(v[a], &value[a]));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscReal x[ISPH_MAX_DIM], u[ISPH_MAX_DIM];

    for (PetscInt a = 0; a < p->dim; a++) {
      x[a] = p->x[a][i];
      u[a] = value[a][i];
    }
    ScenePassing(flow->scene, t, x, u);
    for (PetscInt a = 0; a < p->dim; a++) value[a][i] = u[a];
  }
  for (PetscInt a = 0; a < p->dim; a++) PetscCall(VecRestoreArray(v[a], &value[a]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ConvectionTurn - Adds `scale` times component c of w z x u at time t to f, in a turning frame;
   collective */
PetscErrorCode ConvectionTurn(const Flow *flow, PetscReal t, PetscReal scale, const Vec u[],
                              PetscInt c, Vec f)
{
  PetscFunctionBegin;
  if (!flow->scene->frame || c > 1) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecAXPY(f, (c ? scale : -scale) * SceneFrameRate(flow->scene, t), u[1 - c]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FlowConvective - Computes the convective term of fixed particles at x from the velocity and its
   gradient du_a/dx_b at [a dim + b]; zero if particles move [m/s^2] */
void FlowConvective(const Flow *flow, const PetscReal x[], const PetscReal u[], const PetscReal A[],
                    PetscReal N[])
{
  const Scene    *scene = flow->scene;
  const PetscReal t = flow->clock->t, rate = SceneFrameRate(scene, t);
  PetscReal       v[ISPH_MAX_DIM];

  for (PetscInt a = 0; a < scene->dim; a++) v[a] = u[a];
  ScenePassing(scene, t, x, v);
  for (PetscInt a = 0; a < scene->dim; a++) {
    N[a] = scene->frame && a < 2 ? (a ? rate : -rate) * u[1 - a] : 0.0;
    for (PetscInt b = 0; flow->state->has_convection && b < scene->dim; b++)
      N[a] += v[b] * A[a * scene->dim + b];
  }
}

/*
  ConvectionExplicit - Computes the convective term of a known velocity at time t

    (v.grad u_c) + (w z x u)_c,   v = u less the velocity of the frame

  Collective. For its filter see ConvectionApply(). Input: u - over fluid [m/s]. Output: result
  [m/s^2].
*/
PetscErrorCode ConvectionExplicit(Flow *flow, PetscReal t, const Vec u[], PetscInt c, Vec work,
                                  Vec result)
{
  const PetscBool passes = flow->scene->frame ? PETSC_TRUE : PETSC_FALSE;
  Vec             v[ISPH_MAX_DIM];

  PetscFunctionBegin;
  for (PetscInt a = 0; a < flow->scene->dim; a++) {
    v[a] = u[a];
    if (!passes) continue;
    PetscCall(FlowGetWork(flow, &v[a]));
    PetscCall(VecCopy(u[a], v[a]));
  }
  PetscCall(ConvectionPass(flow, t, v));
  PetscCall(ConvectionApply(flow, v, c, u[c], flow->walls.u[c], work, result));
  PetscCall(ConvectionTurn(flow, t, 1.0, u, c, result));
  for (PetscInt a = 0; a < flow->scene->dim && passes; a++) PetscCall(FlowRestoreWork(flow, &v[a]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  ConvectionExtrapolate - Subtracts the convective term N of ConvectionExplicit(), extrapolated in
  time, from a force

    force -= w_0 N^n + w_1 N^{n-1} + w_2 N^{n-2},   w of HistoryAhead()

  Collective. Keeps N^n for the next step. Input: at - time of the force within the step: 1 or 1/2.
*/
PetscErrorCode ConvectionExtrapolate(Flow *flow, PetscReal at, Vec force[])
{
  FlowState *s = flow->state;
  PetscReal  weight[HISTORY];
  Vec        work, convection;

  PetscFunctionBegin;
  HistoryAhead(flow->clock, at, weight);
  PetscCall(FlowGetWork(flow, &work));
  PetscCall(FlowGetWork(flow, &convection));
  for (PetscInt c = 0; c < flow->scene->dim; c++) {
    PetscCall(ConvectionExplicit(flow, flow->clock->t, s->u, c, work, convection));
    PetscCall(VecAXPY(force[c], -weight[0], convection));
    PetscCall(VecAXPY(force[c], -weight[1], s->convection_prev[c]));
    if (weight[2] != 0.0) PetscCall(VecAXPY(force[c], -weight[2], s->convection_before[c]));
    if (s->convection_before[c]) PetscCall(VecCopy(s->convection_prev[c], s->convection_before[c]));
    PetscCall(VecCopy(convection, s->convection_prev[c]));
  }
  PetscCall(FlowRestoreWork(flow, &convection));
  PetscCall(FlowRestoreWork(flow, &work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  ConvectionOfCorrection - Subtracts the convective term of half of the next correction from a force

    force -= at (r/2) v.grad (u - u*)^n,   r = min(1, ClockRatio()^2)

  Collective. The implicit term convects the predicted velocity u*, which the projection changes by
  k/rho grad phi. This change is of order dt^2, and that of the last step differs by dt^3. Without
  this force it is most of the error in time of an unsteady flow. With the whole of it in place of
  half, long steps are unstable. See theory.md, (motion:correction) and (motion:factors). Input: at
  - share of u* in the velocity that the integrator convects: 1 or 1/2; v - advecting velocity over
  fluid [m/s].
*/
PetscErrorCode ConvectionOfCorrection(Flow *flow, PetscReal at, const Vec v[], Vec force[])
{
  const FlowState *s     = flow->state;
  const PetscReal  share = 0.5 * at * PetscMin(1.0, PetscSqr(ClockRatio(flow->clock)));
  const PetscInt   dim   = flow->scene->dim;
  Vec              work, term;

  PetscFunctionBegin;
  if (!s->correction_prev[0] || share <= 0.0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FlowGetWork(flow, &work));
  PetscCall(FlowGetWork(flow, &term));
  for (PetscInt c = 0; c < dim; c++) {
    PetscCall(ConvectionCentral(dim, OperatorsOfVelocity(flow->ops, c), v, s->correction_prev[c],
                                NULL, work, term));
    PetscCall(VecAXPY(force[c], -share, term));
  }
  PetscCall(FlowRestoreWork(flow, &term));
  PetscCall(FlowRestoreWork(flow, &work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  VelocityExtrapolate - Extrapolates the velocity in time

    v = w_0 u^n + w_1 u^{n-1} + w_2 u^{n-2},   w of HistoryAhead()

  Collective. Input: at - time of v within the step: 1 or 1/2. Output: v - over fluid [m/s].
*/
PetscErrorCode VelocityExtrapolate(const Flow *flow, PetscReal at, const Vec v[])
{
  const FlowState *s = flow->state;
  PetscReal        weight[HISTORY];

  PetscFunctionBegin;
  HistoryAhead(flow->clock, at, weight);
  for (PetscInt c = 0; c < flow->scene->dim; c++) {
    PetscCall(VecCopy(s->u[c], v[c]));
    PetscCall(VecAXPBY(v[c], weight[1], weight[0], s->u_prev[c]));
    if (weight[2] != 0.0) PetscCall(VecAXPY(v[c], weight[2], s->u_before[c]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
