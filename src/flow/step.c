/* The step of a flow: the stages of its scheme in their order. They are chosen once in a run, see
   src/schemes/stages/stages.c. Observers look at the flow before and after them. */
#include "isph/flow.h"

#define FULL 0.9 /* share of a box that is full [-] */

/* Advances the state, u^{n-2} <- u^{n-1} <- u^n <- u^{n+1}, and the time. */
static PetscErrorCode Advance(Flow *flow)
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

/* FlowAssemble - Assembles all matrices for the present positions, unless this is done. Collective.
   Only assemblies read neighbours, so the neighbours of fixed particles are freed after it, except
   with a free surface, whose gradients by reactions are assembled in the solve. */
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

/* FlowPrepareOutput - Assembles the operators that outputs read, if the scheme assembles none in
   its steps. Collective. Other schemes have assembled them at the end of a step. */
PetscErrorCode FlowPrepareOutput(const Flow *flow)
{
  PetscBool changed;

  PetscFunctionBegin;
  if (!(flow->ops->needs & NEED_STREAMS)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(OperatorsAssemble(flow->scene, flow->particles, flow->neighbors, flow->ops, &changed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FlowStep - Makes a step of the clock's dt by the stages of the scheme. Collective. If the step
   fails, scheme->failure has the reason, time has not advanced, and the fields are invalid. Judges
   of the solves send the step back to an earlier stage. */
static PetscErrorCode FlowStep(Flow *flow)
{
  Scheme *s = flow->scheme;

  PetscFunctionBegin;
  s->failure.code         = PETSC_SUCCESS;
  flow->scene->rheology.t = flow->clock->t + flow->clock->dt;
  for (PetscInt k = 0; k < s->n_observers; k++)
    if (s->observer[k]->Begin) PetscCall(s->observer[k]->Begin(flow));
  for (PetscInt k = 0; k < s->n_stages && !s->failure.code;) {
    PetscCall(PetscLogStagePush(s->stage_log[k]));
    PetscCall(s->stage[k]->Do(flow));
    PetscCall(PetscLogStagePop());
    PetscCall(AttemptNext(flow, &k));
  }
  if (s->failure.code) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < s->n_observers; k++) PetscCall(s->observer[k]->End(flow));
  PetscCall(Advance(flow));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gives a failed step the reason that the box is full, if fluid enters it, cannot leave, and fills
   FULL of it: the last voids are narrower than the supports of fits, and solves fail there. */
static PetscErrorCode BlameFullBox(Flow *flow)
{
  const Particles *p       = flow->particles;
  const PetscReal  room    = flow->state->openings.room;
  StepFailure     *failure = &flow->scheme->failure;
  const PetscReal  volume  = p->weight * p->cell_volume;
  char             where[CLOCK_WHERE];

  PetscFunctionBegin;
  if (room == 0.0 || volume < FULL * room) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ClockWhere(flow->clock, where));
  failure->code = PETSC_SUCCESS;
  FailureSet(failure, PETSC_ERR_USER_INPUT,
             "%s: the box is full: the fluid has the volume %.4g, the box between its bodies %.4g, "
             "and fluid enters; give -scene_outflow, a larger -scene_box or a smaller -t_end",
             where, (double)volume, (double)room);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FlowMakeStep - Makes a successful step, or ends the run. Collective. If the chosen row of
   -dt_adapt retries steps, a step that fails or has too large an error is undone and repeated with
   a shorter dt. */
PetscErrorCode FlowMakeStep(Flow *flow)
{
  const StepFailure *failure = &flow->scheme->failure;
  PetscBool          again;
  StepLimit          limit;

  PetscFunctionBegin;
  do {
    PetscCall(SchemeLimit(flow, &limit));
    PetscCall(ClockChoose(&limit, flow->clock));
    PetscCall(SceneCheckVelocities(flow->scene, flow->clock->t + flow->clock->dt));
    PetscCall(AttemptBegin(flow));
    PetscCall(FlowStep(flow));
    PetscCall(ExpressionScopeCheck(flow->scene->scope));
    PetscCall(AttemptEnd(flow, &again));
  } while (again);
  if (failure->code) PetscCall(BlameFullBox(flow));
  PetscCheck(!failure->code, PETSC_COMM_WORLD, failure->code, "%s", failure->sentence);
  PetscFunctionReturn(PETSC_SUCCESS);
}
