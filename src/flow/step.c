/*
  The step of a flow, shared by schemes with a single solve per step. Particles move first, so that
  all terms belong to t^{n+1}. Then matrices are assembled, the scheme solves for u^{n+1} and
  p^{n+1}, and the result is checked and becomes the state.
*/
#include "step.h"

/* FlowAdvance - Advances the state, u^{n-2} <- u^{n-1} <- u^n <- u^{n+1}, and the time;
   collective */
PetscErrorCode FlowAdvance(Flow *flow)
{
  FlowState *s = flow->state;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < flow->scene->dim; a++) {
    if (s->u_before[a]) PetscCall(VecCopy(s->u_prev[a], s->u_before[a]));
    PetscCall(VecCopy(s->u[a], s->u_prev[a]));
    PetscCall(VecCopy(s->u_next[a], s->u[a]));
  }
  PetscCall(ClockAdvance(flow->clock));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Updates the neighbours. */
static PetscErrorCode UpdateNeighbors(Flow *flow)
{
  const PetscLogEvent *event = flow->state->event;

  PetscFunctionBegin;
  PetscCall(PetscLogEventBegin(event[FLOW_EVENT_NEIGHBORS], 0, 0, 0, 0));
  if (SceneMovesGraded(flow->scene)) PetscCall(ParticlesResize(flow->scene, flow->particles));
  PetscCall(NeighborsUpdate(flow->particles, flow->scheme->stats.speed_max * flow->clock->dt,
                            flow->neighbors));
  PetscCall(PetscLogEventEnd(event[FLOW_EVENT_NEIGHBORS], 0, 0, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the vectors for the present numbering. */
static PetscErrorCode Renumber(Flow *flow)
{
  PetscFunctionBegin;
  PetscCall(WallValuesRenumber(flow->scene, flow->particles, &flow->walls));
  PetscCall(FlowStateRenumber(flow));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FlowRebuildNeighbors - Computes neighbours and vectors for the present positions, no matrices;
   collective */
PetscErrorCode FlowRebuildNeighbors(Flow *flow)
{
  PetscFunctionBegin;
  PetscCall(UpdateNeighbors(flow));
  PetscCall(Renumber(flow));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  FlowAssemble - Assembles all matrices for the present positions, unless this is done

  Collective. Only the assembly reads neighbours, so the neighbours of fixed particles are freed
  after it.
*/
PetscErrorCode FlowAssemble(Flow *flow)
{
  const PetscLogEvent *event = flow->state->event;
  PetscBool            changed;

  PetscFunctionBegin;
  PetscCall(PetscLogEventBegin(event[FLOW_EVENT_OPERATORS], 0, 0, 0, 0));
  PetscCall(OperatorsAssemble(flow->scene, flow->particles, flow->neighbors, flow->ops, &changed));
  if (flow->scheme->row->Assemble) PetscCall(flow->scheme->row->Assemble(flow));
  if (!SceneMoves(flow->scene)) PetscCall(NeighborsRelease(flow->neighbors));
  PetscCall(PetscLogEventEnd(event[FLOW_EVENT_OPERATORS], 0, 0, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  FlowPrepareOutput - Assembles the operators that outputs read, if the scheme assembles none in its
  steps

  Collective. Other schemes have assembled them at the end of a step.
*/
PetscErrorCode FlowPrepareOutput(const Flow *flow)
{
  PetscBool changed;

  PetscFunctionBegin;
  if (!(flow->ops->needs & NEED_STREAMS)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(OperatorsAssemble(flow->scene, flow->particles, flow->neighbors, flow->ops, &changed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FlowRebuild - Computes neighbours, matrices and vectors for the present positions; collective */
PetscErrorCode FlowRebuild(Flow *flow)
{
  PetscFunctionBegin;
  PetscCall(UpdateNeighbors(flow));
  PetscCall(FlowAssemble(flow));
  PetscCall(Renumber(flow));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  FlowBegin - Prepares the flow for the next step at the start of a run, after a restart, or after
  an undone step

  Collective. Computes from the particles' fields all other data that a finished step leaves.
*/
PetscErrorCode FlowBegin(Flow *flow)
{
  const Scene *scene = flow->scene;

  PetscFunctionBegin;
  PetscCall(FlowRebuild(flow));
  PetscCall(WallValuesSetVelocity(scene, flow->particles, flow->clock->t, 0.0, &flow->walls));
  if (!SceneIsNewtonian(scene)) {
    PetscCall(
        OperatorsFollowStrain(scene, flow->particles, &flow->walls, flow->state->u, flow->ops));
  }
  if (flow->clock->step == 0) {
    PetscCall(FlowMeasureStart(flow));
    PetscCall(TimeErrorStart(flow));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  FlowStep - Makes a step of the clock's dt

  Collective. If the step fails, scheme->failure has the reason, time has not advanced, and the
  fields are invalid.

  Input Parameter:
. Solve - solve of the scheme: sets u_next to u^{n+1} and p to p^{n+1}
*/
PetscErrorCode FlowStep(Flow *flow, FlowSolve Solve)
{
  StepFailure    *failure = &flow->scheme->failure;
  const PetscBool keeps   = SceneKeepsMomentum(flow->scene);
  PetscReal       mean[ISPH_MAX_DIM];

  PetscFunctionBegin;
  failure->code = PETSC_SUCCESS;
  if (keeps) PetscCall(FlowMeanVelocity(flow, flow->state->u, mean));
  PetscCall(AverageBegin(flow));
  if (SceneMoves(flow->scene)) {
    PetscCall(FlowMove(flow));
    if (!failure->code) PetscCall(FlowRebuild(flow));
  }
  if (!failure->code) PetscCall(VolumesControl(flow));
  if (!failure->code) PetscCall(BudgetBegin(flow));
  if (!failure->code) PetscCall(BurstSolve(flow, Solve));
  if (!failure->code) PetscCall(FlowCollide(flow));
  if (!failure->code) PetscCall(BudgetPart(flow, PART_SOLVE, 0.0, NULL));
  if (!failure->code && keeps) PetscCall(MomentumRestore(flow, mean));
  if (!failure->code && keeps) PetscCall(BudgetPart(flow, PART_MEAN, 0.0, NULL));
  if (!failure->code) PetscCall(FlowCheck(flow));
  if (!failure->code && flow->clock->adapt->estimates) PetscCall(TimeErrorCheck(flow));
  if (!failure->code) PetscCall(AverageEnd(flow));
  if (!failure->code) BudgetEnd(flow);
  if (!failure->code) PetscCall(FlowAdvance(flow));
  PetscFunctionReturn(PETSC_SUCCESS);
}
