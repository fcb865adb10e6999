/*
  The start of a run. The projection makes the given velocity free of divergence; otherwise the
  pressure of the first step would be this impulse over dt. Then comes the pressure, if none is
  given: that of the body force and of the pressures at boundaries, which the velocity at the start
  does not change,

    lap p = rho div f,   n.grad p = rho n.(f - a) at walls,   p given at openings and free surfaces

  with the equations of a projection whose u* is the acceleration f. A fluid at rest under its
  weight stays at rest, and the first step has no impulse of the whole weight. Without it the
  viscous step spreads this impulse from the walls, and the projection cannot undo that.
*/
#include "projection.h"

/* Solves for the pressure from the force, and adds it to the level at which the run starts. */
static PetscErrorCode SolveFirst(Flow *flow, const Vec force[], Projection *pr)
{
  const Vec p = pr->space->Unknowns(flow);
  Vec       b, phi;

  PetscFunctionBegin;
  PetscCall(VecDuplicate(p, &b));
  PetscCall(VecDuplicate(b, &phi));
  PetscCall(pr->space->SetFirstSource(flow, force, b));
  PetscCall(PressureRefine(flow, b, phi, pr->ppe));
  PetscCall(VecAXPY(p, 1.0, phi));
  if (pr->splines) PetscCall(SplinesSpread(flow, pr->splines));
  PetscCall(VecDestroyAll(&phi, &b));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Projects the velocity that a case or the user gives at the start, if it is not zero: a step of
   the length k that forces do not notice, whose increment of the pressure is left out. */
static PetscErrorCode FreeStart(Flow *flow, Projection *pr)
{
  const PetscReal alpha = pr->alpha, dt = flow->clock->dt;
  PetscBool       moves;

  PetscFunctionBegin;
  PetscCall(FlowGiveStart(flow, &moves));
  if (!moves) PetscFunctionReturn(PETSC_SUCCESS);
  pr->alpha       = 0.0;
  pr->k           = FLOW_START_LENGTH * dt;
  flow->clock->dt = 0.0; /* walls move as at the start */
  if (flow->walls.p_step) PetscCall(VecZeroEntries(flow->walls.p_step));
  PetscCall(WallValuesSetVelocity(flow->scene, flow->particles, flow->clock->t, 0.0, &flow->walls));
  PetscCall(pr->space->Solve(flow));
  PetscCall(
      pr->space->Accelerate(flow, PETSC_TRUE, -pr->k / flow->scene->rho, flow->state->u_next));
  flow->clock->dt = dt;
  pr->alpha       = alpha;
  PetscCheck(!flow->scheme->failure.code, PETSC_COMM_WORLD, flow->scheme->failure.code, "%s",
             flow->scheme->failure.sentence);
  PetscCall(FlowTakeStart(flow));
  PetscCall(flow->scheme->row->Begin(flow));
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
  *driven = most > 0.0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ProjectionStart - Frees the velocity at the start of a run of divergence, and solves for its
   pressure, if none is given and a body force or boundaries drive the flow. Collective. Chorin's
   projection has no pressure in its predictor, and needs none. Output: velocity, pressure, its full
   wall data, and the largest body force that it does not balance. Errors: the run ends if a solve
   fails. */
PetscErrorCode ProjectionStart(Flow *flow)
{
  Projection     *pr  = (Projection *)flow->scheme->data;
  const PetscInt  dim = flow->scene->dim;
  const PetscReal t   = flow->clock->t;
  Vec             force[ISPH_MAX_DIM];
  PetscBool       driven;

  PetscFunctionBegin;
  if (pr->row) PetscCall(FreeStart(flow, pr));
  if (!pr->row || !pr->row->incremental || pr->wall_slope_share > 0.0)
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(WallValuesStepPressure(flow->scene, flow->particles, t, &flow->walls));
  PetscCall(IsDriven(flow, &driven));
  if (driven) {
    for (PetscInt a = 0; a < dim; a++) {
      PetscCall(FlowGetWork(flow, &force[a]));
      PetscCall(VecZeroEntries(force[a]));
    }
    PetscCall(AddBodyForce(flow, t, force));
    PetscCall(SolveFirst(flow, force, pr));
    pr->wall_slope_share = 1.0;
    PetscCall(pr->space->Begin(flow));
    PetscCall(ProjectionForce(flow, t, force));
    for (PetscInt a = 0; a < dim; a++) PetscCall(FlowRestoreWork(flow, &force[a]));
    PetscCall(WallValuesSetVelocity(flow->scene, flow->particles, t, 0.0, &flow->walls));
    PetscCheck(!flow->scheme->failure.code, PETSC_COMM_WORLD, flow->scheme->failure.code, "%s",
               flow->scheme->failure.sentence);
  }
  PetscCall(pr->space->Begin(flow));
  PetscFunctionReturn(PETSC_SUCCESS);
}
