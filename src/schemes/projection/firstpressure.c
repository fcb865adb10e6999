/*
  The pressure at the start of a run, if none is given: that of the body force and of the pressures
  at boundaries, which the velocity at the start does not change,

    lap p = rho div f,   n.grad p = rho n.(f - a) at walls,   p given at openings and free surfaces

  with the equations of a projection whose u* is the acceleration f. A fluid at rest under its
  weight stays at rest, and the first step has no impulse of the whole weight. Without it the
  viscous step spreads this impulse from the walls, and the projection cannot undo that.
*/
#include "projection.h"

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

/* Sets b of the pressure on particles from the force; the wall data of the pressure are p_step. */
static PetscErrorCode SourceOnParticles(Flow *flow, const Vec force[], Vec b)
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
  PetscCall(FreePressureFirst(flow, b));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets b of the pressure on splines from the force. Walls have the velocity after the projection in
   the divergence; that of a fluid at rest has their part alone. */
static PetscErrorCode SourceOnSplines(Flow *flow, const Vec force[], Splines *s, Vec b)
{
  const PetscReal t = flow->clock->t;
  Vec             zero[ISPH_MAX_DIM];

  PetscFunctionBegin;
  PetscCall(SplinesDivergence(flow, s, force, t, b));
  for (PetscInt a = 0; a < flow->scene->dim; a++) {
    PetscCall(FlowGetWork(flow, &zero[a]));
    PetscCall(VecZeroEntries(zero[a]));
  }
  PetscCall(SplinesDivergence(flow, s, zero, t, s->b));
  for (PetscInt a = 0; a < flow->scene->dim; a++) PetscCall(FlowRestoreWork(flow, &zero[a]));
  PetscCall(VecAXPY(b, -1.0, s->b));
  PetscCall(VecScale(b, -PetscSqr(s->scale) * flow->scene->rho));
  PetscCall(SplinesGivePressure(t, PETSC_TRUE, s, b));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Solves for the pressure from the force, and adds it to the level at which the run starts. */
static PetscErrorCode SolveFirst(Flow *flow, const Vec force[], Projection *pr)
{
  Vec b, phi;

  PetscFunctionBegin;
  PetscCall(VecDuplicate(pr->splines ? pr->splines->b : flow->state->p, &b));
  PetscCall(VecDuplicate(b, &phi));
  if (pr->splines) PetscCall(SourceOnSplines(flow, force, pr->splines, b));
  else PetscCall(SourceOnParticles(flow, force, b));
  PetscCall(PressureRefine(flow, b, phi, pr->ppe));
  PetscCall(VecAXPY(pr->splines ? pr->splines->p : flow->state->p, 1.0, phi));
  if (pr->splines) PetscCall(SplinesSpread(flow, pr->splines));
  PetscCall(VecDestroy(&phi));
  PetscCall(VecDestroy(&b));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Checks if the flow has a body force at its start, or a boundary a pressure that is not the level
   of the scene. */
static PetscErrorCode IsDriven(const Flow *flow, PetscBool *driven)
{
  const Particles *p = flow->particles;
  PetscReal most = SceneHas(flow->scene, PHYSICS_BODY_FORCE) ? flow->scheme->stats.force_max : 0.0;
  const PetscScalar *step;

  PetscFunctionBegin;
  if (flow->walls.p) {
    PetscCall(VecGetArrayRead(flow->walls.p_step, &step));
    for (PetscInt k = 0; k < p->n_wall; k++) {
      const PetscInt side = (PetscInt)p->side[p->n_fluid + k];

      if (BoundaryEquation(flow->scene, side, FIT_PRESSURE) == EQUATION_VALUE)
        most = PetscMax(most, PetscAbsReal(step[k]));
    }
    PetscCall(VecRestoreArrayRead(flow->walls.p_step, &step));
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPIU_REAL, MPIU_MAX, p->comm));
  *driven = most > 0.0 ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  ProjectionStart - Solves for the pressure at the start of a run, if none is given and a body force
  or boundaries drive the flow

  Collective. Chorin's projection has no pressure in its predictor, and needs none. Output: the
  pressure, its full wall data, and the largest body force that it does not balance. Errors: the run
  ends if the solve fails.
*/
PetscErrorCode ProjectionStart(Flow *flow)
{
  Projection     *pr  = (Projection *)flow->scheme->data;
  const PetscInt  dim = flow->scene->dim;
  const PetscReal t   = flow->clock->t;
  Vec             force[ISPH_MAX_DIM];
  PetscBool       driven;

  PetscFunctionBegin;
  if (!pr->row || !pr->row->incremental || pr->wall_slope_share > 0.0)
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(WallValuesStepPressure(flow->scene, flow->particles, t, &flow->walls));
  PetscCall(IsDriven(flow, &driven));
  if (pr->splines && flow->walls.p) PetscCall(VecZeroEntries(flow->walls.p_step));
  if (driven) {
    for (PetscInt a = 0; a < dim; a++) {
      PetscCall(FlowGetWork(flow, &force[a]));
      PetscCall(VecZeroEntries(force[a]));
    }
    if (SceneHas(flow->scene, PHYSICS_BODY_FORCE)) PetscCall(AddBodyForce(flow, t, force));
    PetscCall(SolveFirst(flow, force, pr));
    pr->wall_slope_share = 1.0;
    if (!pr->splines)
      PetscCall(WallValuesSetPressure(flow->scene, flow->particles, t, 1.0, &flow->walls));
    PetscCall(ProjectionForce(flow, t, force));
    for (PetscInt a = 0; a < dim; a++) PetscCall(FlowRestoreWork(flow, &force[a]));
    PetscCall(WallValuesSetVelocity(flow->scene, flow->particles, t, 0.0, &flow->walls));
    PetscCheck(!flow->scheme->failure.code, PETSC_COMM_WORLD, flow->scheme->failure.code, "%s",
               flow->scheme->failure.sentence);
  }
  if (!pr->splines) PetscCall(WallGradientBegin(flow));
  PetscFunctionReturn(PETSC_SUCCESS);
}
