/* The corrector of the projection: the pressure increment, and the new velocity and pressure. */
#include "projection.h"

/*
  Sets the right-hand side of A phi = b, A = -dx_i^2 lap:

    b = -dx_i^2 rho/k ((1 - alpha) div u* + alpha (1 - C)/dt) - B (increase of n.grad p in the step)

  alpha is -ppe_alpha, C the concentration, k the length of the viscous step, and B the wall
  part of A. See docs/theory.md, (89) and (121).
*/
static PetscErrorCode SetSource(Flow *flow, Vec source)
{
  const Scene       *scene = flow->scene;
  const Operators   *ops   = flow->ops;
  FlowState         *s     = flow->state;
  Projection        *pr    = (Projection *)flow->scheme->data;
  const PetscScalar *scale, *divergence;
  PetscScalar       *b;
  Vec                work;

  PetscFunctionBegin;
  PetscCall(FlowDivergence(flow, s->u_next, s->divergence));
  PetscCall(VecGetArrayRead(ops->ppe_scale, &scale));
  PetscCall(VecGetArrayRead(s->divergence, &divergence));
  PetscCall(VecGetArrayWrite(source, &b));
  for (PetscInt i = 0; i < flow->particles->n_fluid; i++)
    b[i] = scale[i] * scene->rho / pr->k * (1.0 - pr->alpha) * divergence[i];
  for (PetscInt i = 0; pr->alpha > 0.0 && i < flow->particles->n_fluid; i++)
    b[i] += scale[i] * scene->rho / pr->k * pr->alpha * (1.0 - ops->concentration.value[i]) /
            flow->clock->dt;
  PetscCall(VecRestoreArrayWrite(source, &b));
  PetscCall(VecRestoreArrayRead(s->divergence, &divergence));
  PetscCall(VecRestoreArrayRead(ops->ppe_scale, &scale));
  if (flow->walls.p_step) {
    PetscCall(FlowGetWork(flow, &work));
    PetscCall(AffineApplyWalls(&ops->ppe, flow->walls.p_step, work));
    PetscCall(VecAXPY(source, -1.0, work));
    PetscCall(FlowRestoreWork(flow, &work));
  }
  PetscCall(FreePressureIncrement(flow, source));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Corrects the velocity, u = u* - k/rho grad phi, k: length of the viscous step. */
static PetscErrorCode CorrectVelocity(Flow *flow)
{
  const Projection *pr = (const Projection *)flow->scheme->data;
  Vec               gradient;

  PetscFunctionBegin;
  PetscCall(FlowGetWork(flow, &gradient));
  for (PetscInt a = 0; a < flow->scene->dim; a++) {
    PetscCall(AffineApply(&flow->ops->grad_p[a], pr->phi, flow->walls.p_step, gradient));
    PetscCall(VecAXPY(flow->state->u_next[a], -pr->k / flow->scene->rho, gradient));
  }
  PetscCall(FlowRestoreWork(flow, &gradient));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Multiplies the residual of a quadratic fit of the pressure by the share that the filter removes

    S max(0.1, 1/(1 + 8 nu dt/dx_i^2))

  S is -ppe_filter. The second number in max() is the factor by which an implicit viscous step damps
  the checkerboard of a lattice. With the operators L, D and G of Laplacian, divergence and
  gradient, disordered particles have pressure modes p with L^-1 D G p = m p and m < 0. An
  incremental projection amplifies them by about 1 + |m|^(1/2) in each step, however short the step
  is; therefore the filter is needed. Viscosity damps these modes too, so filter and viscosity
  complement each other. See docs/theory.md, (78) and (79).

  The price is a divergence: if a steady pressure has the residual r, the projection leaves the
  divergence k (L - D G) S r/rho, which can feed energy into thin layers. In the cavity at
  Re = 1000, n = 48, fixed particles, CFL number 1, t = 40, the energy has errors of -18, -8.5, 5.1,
  38 % for S = 0, 0.02, 0.1, 0.5. Therefore the default on a lattice of fixed particles is S = 0.1.
*/
static PetscErrorCode ShareOfResidual(const Flow *flow, Vec residual)
{
  const Particles  *p  = flow->particles;
  const Projection *pr = (const Projection *)flow->scheme->data;
  const PetscReal   nu = SceneHas(flow->scene, PHYSICS_VISCOSITY) ? flow->scene->nu_low : 0.0;
  PetscScalar      *r;

  PetscFunctionBegin;
  PetscCall(VecGetArray(residual, &r));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    if (FreeSurfaceHolds(flow->ops->free, i)) r[i] = 0.0; /* the surface gives the pressure */
    r[i] *=
        pr->filter * PetscMax(0.1, 1.0 / (1.0 + 8.0 * nu * flow->clock->dt / PetscSqr(p->dx[i])));
  }
  PetscCall(VecRestoreArray(residual, &r));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Returns the share of the pressure increment phi that is added to the pressure,
  min(1, 4 dt/dt_wanted)

  An error e of the velocity gives phi of about rho e dx/dt. If a report cuts a step
  short, phi is therefore far too large for the following steps, which may be thousands of times as
  long. An incremental projection therefore adds about the phi that a step of usual length would
  have; the true change of the pressure in such a short time is small. See docs/theory.md, (91).
*/
static PetscReal PressureGain(const Flow *flow)
{
  const Projection *pr = (const Projection *)flow->scheme->data;

  return pr->row->incremental ? PetscMin(1.0, 4.0 * flow->clock->dt / flow->clock->dt_wanted) : 1.0;
}

/*
  Adds c div u* to the pressure, where no free surface is within the support

  The term is exact if the viscous term of grad phi is that of its dilatation, grad (2 nu lap phi).
  Beside a free surface the rows have its condition of zero stress, and weaker forces on a particle
  that stands out, but the same div u*: the pressure then gains more than the viscosity takes. See
  docs/theory.md, (290).
*/
static PetscErrorCode AddDilatation(const Flow *flow, PetscReal c)
{
  const FlowState   *s   = flow->state;
  const Operators   *ops = flow->ops;
  const PetscScalar *divergence;
  PetscScalar       *p;

  PetscFunctionBegin;
  if (!ops->free) {
    PetscCall(VecAXPY(s->p, c, s->divergence));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(VecGetArrayRead(s->divergence, &divergence));
  PetscCall(VecGetArray(s->p, &p));
  for (PetscInt i = 0; i < flow->particles->n_fluid; i++)
    if (!OperatorsBesideSurface(ops, i)) p[i] += c * divergence[i];
  PetscCall(VecRestoreArray(s->p, &p));
  PetscCall(VecRestoreArrayRead(s->divergence, &divergence));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Updates the pressure, p = [p^n] + s (phi [- c mu div u*]), s = PressureGain(), and its data at
  walls, then applies the pressure filter and removes an undetermined mean

  p^n is present in incremental projections, and div u* in the rotational projection. c is
  LaplacianDilatation(). mu is rho times the least viscosity of the flow. This mu is exact for
  a uniform viscosity, and stable for a varying viscosity. With the local viscosity in its place, a
  drop 1e5 times as viscous as the fluid around it became unstable within 4 steps.
*/
static PetscErrorCode UpdatePressure(Flow *flow)
{
  const Scene      *scene = flow->scene;
  FlowState        *s     = flow->state;
  const Projection *pr    = (const Projection *)flow->scheme->data;
  const PetscReal   gain  = PressureGain(flow);
  Vec               residual;

  PetscFunctionBegin;
  PetscCall(WallGradientCorrect(flow, gain));
  PetscCall(VecCopy(s->p, s->p_before));
  if (!pr->row->incremental) PetscCall(VecSet(s->p, scene->level));
  PetscCall(VecAXPY(s->p, gain, pr->phi));
  if (pr->row->rotational && SceneHas(scene, PHYSICS_VISCOSITY)) {
    const PetscReal dilatation = LaplacianDilatation(&flow->ops->forms.visc, flow->scene->dim);

    PetscCall(AddDilatation(flow, -gain * dilatation * scene->rho * scene->nu_low));
  }
  if (pr->filter > 0.0) {
    PetscCall(FlowGetWork(flow, &residual));
    PetscCall(AffineApply(&flow->ops->filter_p, s->p, flow->walls.p, residual));
    PetscCall(ShareOfResidual(flow, residual));
    PetscCall(VecAXPY(s->p, -1.0, residual));
    PetscCall(FlowRestoreWork(flow, &residual));
  }
  PetscCall(GaugeRemove(scene, flow->particles, s->p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Solves for the pressure increment on splines from div u*, and corrects velocity and pressure

    A phi = -scale^2 rho/k D u*,   u = u* - k/rho G phi,   p = [p^n] + s (phi [- c mu div u*])

  The terms are those of UpdatePressure(). There is no wall condition of the pressure:
  the splines take part in the balance of volume at walls.
*/
static PetscErrorCode ProjectOnSplines(Flow *flow)
{
  Projection     *pr    = (Projection *)flow->scheme->data;
  const Scene    *scene = flow->scene;
  FlowState      *state = flow->state;
  Splines        *s     = pr->splines;
  const PetscReal gain = PressureGain(flow), t = flow->clock->t + flow->clock->dt;

  PetscFunctionBegin;
  PetscCall(SplinesDivergence(flow, s, state->u_next, t, s->b));
  PetscCall(VecPointwiseDivide(s->divergence, s->b, s->mass));
  PetscCall(SplinesValue(s, s->divergence, state->divergence));
  PetscCall(VecScale(s->b, -PetscSqr(s->scale) * scene->rho / pr->k));
  PetscCall(SplinesGivePressure(t, pr->row->incremental, s, s->b));
  PetscCall(PressureSolve(flow, s->b, s->phi, pr->ppe));
  if (flow->scheme->failure.code) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SplinesAccelerate(s, s->phi, -pr->k / scene->rho, state->u_next));
  PetscCall(VecCopy(state->p, state->p_before));
  if (!pr->row->incremental) PetscCall(VecSet(s->p, scene->level));
  PetscCall(VecAXPY(s->p, gain, s->phi));
  if (pr->row->rotational && SceneHas(scene, PHYSICS_VISCOSITY)) {
    const PetscReal dilatation = LaplacianDilatation(&flow->ops->forms.visc, flow->scene->dim);

    PetscCall(VecAXPY(s->p, -gain * dilatation * scene->rho * scene->nu_low, s->divergence));
  }
  PetscCall(SplinesGivePressure(t, PETSC_FALSE, s, s->p));
  PetscCall(SplinesSpread(flow, s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the increment of the pressure on particles for the present numbering. */
static PetscErrorCode RenumberProjection(Flow *flow)
{
  Projection *pr = (Projection *)flow->scheme->data;

  PetscFunctionBegin;
  if (pr->splines || pr->epoch == flow->particles->epoch) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecDestroy(&pr->phi));
  PetscCall(FluidVec(flow->particles, NULL, &pr->phi));
  pr->epoch = flow->particles->epoch;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Keeps u - u* of the present step for ConvectionOfCorrection(), in two parts: u* before the
   correction, with `after` the difference. */
static PetscErrorCode KeepCorrection(const FlowState *s, PetscBool after)
{
  PetscFunctionBegin;
  for (PetscInt c = 0; c < ISPH_MAX_DIM && s->correction_prev[c]; c++) {
    if (after) PetscCall(VecAYPX(s->correction_prev[c], -1.0, s->u_next[c]));
    else PetscCall(VecCopy(s->u_next[c], s->correction_prev[c]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ProjectVelocity - Solves for the pressure increment phi from div u*, then corrects velocity and
   pressure; collective */
PetscErrorCode ProjectVelocity(Flow *flow)
{
  Projection *pr = (Projection *)flow->scheme->data;
  Vec         b;

  PetscFunctionBegin;
  PetscCall(RenumberProjection(flow));
  PetscCall(WallValuesSetVelocity(flow->scene, flow->particles, flow->clock->t + flow->clock->dt,
                                  pr->k / flow->scene->rho, &flow->walls));
  PetscCall(KeepCorrection(flow->state, PETSC_FALSE));
  if (pr->splines) {
    PetscCall(ProjectOnSplines(flow));
    PetscCall(KeepCorrection(flow->state, PETSC_TRUE));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(FlowGetWork(flow, &b));
  PetscCall(SetSource(flow, b));
  PetscCall(PressureSolve(flow, b, pr->phi, pr->ppe));
  PetscCall(FlowRestoreWork(flow, &b));
  if (flow->scheme->failure.code) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(CorrectVelocity(flow));
  PetscCall(KeepCorrection(flow->state, PETSC_TRUE));
  PetscCall(UpdatePressure(flow));
  PetscFunctionReturn(PETSC_SUCCESS);
}
