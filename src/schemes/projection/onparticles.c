/* The projection with the pressure on the particles: its equation, gradient and update. Boundaries
   have data of the pressure (wallgradient.c). */
#include "projection.h"

/* Creates the increment of the pressure on particles for the present numbering. */
static PetscErrorCode Renumber(Flow *flow)
{
  Projection *pr = (Projection *)flow->scheme->data;

  PetscFunctionBegin;
  if (pr->epoch == flow->particles->epoch) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecDestroy(&pr->phi));
  PetscCall(FluidVec(flow->particles, NULL, &pr->phi));
  pr->epoch = flow->particles->epoch;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Sets the right-hand side of A phi = b, A = -dx_i^2 lap:

    b = -dx_i^2 rho/k ((1 - alpha) div u* + alpha (1 - C)/dt) - B (increase of n.grad p in the step)

  alpha is -ppe_alpha, C the concentration, k the length of the viscous step, and B the wall
  part of A. See theory.md, (projection:system) and (projection:matrix).
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
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SolveOnParticles(Flow *flow)
{
  Projection *pr = (Projection *)flow->scheme->data;
  Vec         b;

  PetscFunctionBegin;
  PetscCall(Renumber(flow));
  PetscCall(FlowGetWork(flow, &b));
  PetscCall(SetSource(flow, b));
  PetscCall(PressureSolve(flow, b, pr->phi, pr->ppe));
  PetscCall(FlowRestoreWork(flow, &b));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds factor times the gradient of phi, which has the change of the data at walls, or of the
   pressure. */
static PetscErrorCode AccelerateOnParticles(Flow *flow, PetscBool increment, PetscReal factor,
                                            const Vec u[])
{
  const Projection *pr = (const Projection *)flow->scheme->data;
  Vec               gradient;

  PetscFunctionBegin;
  PetscCall(FlowGetWork(flow, &gradient));
  for (PetscInt a = 0; a < flow->scene->dim; a++) {
    if (increment)
      PetscCall(AffineApply(&flow->ops->grad_p[a], pr->phi, flow->walls.p_step, gradient));
    else PetscCall(AffineApply(&flow->ops->grad_p[a], flow->state->p, flow->walls.p, gradient));
    PetscCall(VecAXPY(u[a], factor, gradient));
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
  complement each other. See theory.md, (filters:pressure) and (filters:modes).

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
    r[i] *=
        pr->filter * PetscMax(0.1, 1.0 / (1.0 + 8.0 * nu * flow->clock->dt / PetscSqr(p->dx[i])));
  }
  PetscCall(VecRestoreArray(residual, &r));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Updates the pressure and its data at walls, then applies the pressure filter and removes an
   undetermined mean. */
static PetscErrorCode UpdateOnParticles(Flow *flow, PetscReal gain)
{
  const Scene      *scene = flow->scene;
  FlowState        *s     = flow->state;
  const Projection *pr    = (const Projection *)flow->scheme->data;
  Vec               residual;

  PetscFunctionBegin;
  PetscCall(WallGradientCorrect(flow, gain));
  if (!pr->row->incremental) PetscCall(VecSet(s->p, scene->level));
  PetscCall(VecAXPY(s->p, gain, pr->phi));
  if (pr->row->rotational && SceneHas(scene, PHYSICS_VISCOSITY)) {
    const PetscReal dilatation = LaplacianDilatation(&flow->ops->forms.visc, flow->scene->dim);

    PetscCall(VecAXPY(s->p, -gain * dilatation * scene->rho * scene->nu_low, s->divergence));
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

/* Sets the wall data of velocities to those of the acceleration f before the projection. */
static PetscErrorCode ForceAtWalls(Flow *flow, PetscReal t)
{
  const Particles *p     = flow->particles;
  const Scene     *scene = flow->scene;
  PetscReal       *u[ISPH_MAX_DIM];

  PetscFunctionBegin;
  if (!flow->walls.p) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt a = 0; a < scene->dim; a++) PetscCall(VecGetArray(flow->walls.u[a], &u[a]));
  for (PetscInt k = 0; k < p->n_wall; k++) {
    const PetscInt side = (PetscInt)p->side[p->n_fluid + k];
    PetscReal      x[ISPH_MAX_DIM], f[ISPH_MAX_DIM];

    ParticlesWallPoint(p, p->n_fluid + k, x);
    SceneBodyForce(scene, t, x, f);
    for (PetscInt a = 0; a < scene->dim; a++)
      u[a][k] = BoundaryVelocityEquation(scene, side, a) == EQUATION_VALUE ? f[a] : 0.0;
  }
  for (PetscInt a = 0; a < scene->dim; a++) PetscCall(VecRestoreArray(flow->walls.u[a], &u[a]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets b of the first pressure from the force; the wall data of the pressure are p_step. */
static PetscErrorCode FirstOnParticles(Flow *flow, const Vec force[], Vec b)
{
  Vec work;

  PetscFunctionBegin;
  PetscCall(ForceAtWalls(flow, flow->clock->t));
  PetscCall(FlowGetWork(flow, &work));
  PetscCall(FlowDivergence(flow, force, work));
  PetscCall(VecPointwiseMult(b, flow->ops->ppe_scale, work));
  PetscCall(VecScale(b, flow->scene->rho));
  if (flow->walls.p_step) {
    PetscCall(AffineApplyWalls(&flow->ops->ppe, flow->walls.p_step, work));
    PetscCall(VecAXPY(b, -1.0, work));
  }
  PetscCall(FlowRestoreWork(flow, &work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static Vec UnknownsOnParticles(const Flow *flow)
{
  return flow->state->p;
}

const PressureSpace PressureOnParticles = {
    .Begin          = WallGradientBegin,
    .StartStep      = WallGradientPredict,
    .Unknowns       = UnknownsOnParticles,
    .Solve          = SolveOnParticles,
    .Accelerate     = AccelerateOnParticles,
    .Update         = UpdateOnParticles,
    .SetFirstSource = FirstOnParticles,
};
