/* Stages of a step that schemes share, the observers of steps, and the choice of those that apply
   to a flow. A list of stages stands with its scheme. A stage that a flow does not need, such as
   openings in a closed box, costs it nothing. */
#include "stages.h"

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

/* FlowRebuildNeighbors - Computes neighbours and vectors for the present positions, no matrices;
   collective */
PetscErrorCode FlowRebuildNeighbors(Flow *flow)
{
  PetscFunctionBegin;
  PetscCall(UpdateNeighbors(flow));
  PetscCall(WallValuesRenumber(flow->scene, flow->particles, &flow->walls));
  PetscCall(FlowStateRenumber(flow));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes neighbours, matrices and vectors for the present positions. */
static PetscErrorCode Rebuild(Flow *flow)
{
  PetscFunctionBegin;
  PetscCall(UpdateNeighbors(flow));
  PetscCall(InterfacesUpdateHalo(flow->particles));
  PetscCall(FlowAssemble(flow));
  PetscCall(WallValuesRenumber(flow->scene, flow->particles, &flow->walls));
  PetscCall(FlowStateRenumber(flow));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FlowBegin - Prepares the flow for the next step at the start of a run, after a restart, or after
   an undone step. Collective. Computes from the particles' fields all other data that a finished
   step leaves. */
PetscErrorCode FlowBegin(Flow *flow)
{
  const Scene *scene = flow->scene;

  PetscFunctionBegin;
  PetscCall(Rebuild(flow));
  PetscCall(WallValuesSetVelocity(scene, flow->particles, flow->clock->t, 0.0, &flow->walls));
  flow->scene->rheology.t = flow->clock->t;
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

/* FlowFollow - Moves owners and halo to the new positions of the particles; an epoch that has
   started since the last rebuild has its halo; collective */
PetscErrorCode FlowFollow(Flow *flow)
{
  PetscFunctionBegin;
  PetscCall(PetscLogEventBegin(flow->state->event[FLOW_EVENT_NEIGHBORS], 0, 0, 0, 0));
  PetscCall(ParticlesUpdateEpoch(flow->scene, flow->particles, PETSC_FALSE, NULL));
  if (flow->state->epoch == flow->particles->epoch) PetscCall(ParticlesUpdateHalo(flow->particles));
  PetscCall(PetscLogEventEnd(flow->state->event[FLOW_EVENT_NEIGHBORS], 0, 0, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool Moves(const Flow *flow)
{
  return SceneMoves(flow->scene);
}

static PetscBool HasBodiesInPlace(const Flow *flow)
{
  return flow->scene->pose && !SceneMoves(flow->scene);
}

static PetscBool HasOpenings(const Flow *flow)
{
  return flow->state->openings.open;
}

static PetscBool KeepsMomentum(const Flow *flow)
{
  return SceneKeepsMomentum(flow->scene);
}

static PetscBool EstimatesError(const Flow *flow)
{
  return flow->clock->adapt->estimates;
}

/* Returns true if the velocity filter is no part of the motion of particles, nor of convection. */
static PetscBool FiltersFirst(const Flow *flow)
{
  const FlowState *s = flow->state;

  return s->has_convection && !s->implicit_convection && s->velocity_filter > 1.0;
}

static PetscErrorCode FollowAndRebuild(Flow *flow)
{
  PetscFunctionBegin;
  PetscCall(FlowFollow(flow));
  if (flow->particles->fluid) {
    PetscCall(UpdateNeighbors(flow));
    PetscCall(InterfacesFollow(flow->particles, flow->neighbors));
  }
  PetscCall(Rebuild(flow));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const Stage StageMomentum = {.name    = "momentum",
                             .brief   = "mean velocity, of flows that keep their momentum",
                             .Applies = KeepsMomentum,
                             .Do      = MomentumKeep};

const Stage StageBodies = {
    .name    = "bodies",
    .brief   = "first guess of the velocities of free bodies that stay in their place",
    .Applies = HasBodiesInPlace,
    .Do      = BodiesMove,
};

const Stage StageMove = {.name    = "move",
                         .brief   = "places by the flow and by shifting, bodies that move",
                         .Applies = Moves,
                         .Do      = FlowMove};

const Stage StageFilter = {.name    = "filter",
                           .brief   = "velocities of fixed particles without grid modes",
                           .Applies = FiltersFirst,
                           .Do      = FlowFilter};

const Stage StagePass = {.name    = "pass",
                         .brief   = "particles leave and enter through openings",
                         .Applies = HasOpenings,
                         .Do      = OpeningsPass};

const Stage StageRebuild = {.name    = "rebuild",
                            .brief   = "owners, neighbours and matrices at the new places",
                            .Applies = Moves,
                            .Do      = FollowAndRebuild};

const Stage StageMean = {.name    = "mean",
                         .brief   = "restored mean velocity",
                         .Applies = KeepsMomentum,
                         .Do      = MomentumRestore};

const Stage StageCheck = {
    .name = "check", .brief = "energy, speed and divergence within their bounds", .Do = FlowCheck};

const Stage StageError = {.name    = "error",
                          .brief   = "error in time and length of the next step",
                          .Applies = EstimatesError,
                          .Do      = TimeErrorCheck};

static const Observer *const observers[] = {&ObserverFlight, &ObserverAcceleration, &ObserverJump};

static PetscErrorCode ListObservers(Flow *flow)
{
  Scheme *s = flow->scheme;

  PetscFunctionBegin;
  s->n_observers = 0;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(observers); k++)
    if (observers[k]->Applies(flow)) s->observer[s->n_observers++] = observers[k];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SchemeArrange - Chooses the stages and observers of the steps of a run; the stages are stages of
   -log_view too. Collective. To be called when all parts of the run exist, before its first
   step. */
PetscErrorCode SchemeArrange(Flow *flow)
{
  Scheme   *s = flow->scheme;
  PetscBool logs;

  PetscFunctionBegin;
  PetscCall(PetscLogIsActive(&logs));
  s->n_stages = 0;
  for (const Stage *const *stage = s->row->stages; *stage; stage++) {
    if ((*stage)->Applies && !(*stage)->Applies(flow)) continue;
    PetscCheck(s->n_stages < SCHEME_MAX_STAGES, PETSC_COMM_SELF, PETSC_ERR_PLIB,
               "%s is one more than SCHEME_MAX_STAGES = %d", (*stage)->name, SCHEME_MAX_STAGES);
    if (logs) PetscCall(LogStageGet((*stage)->name, &s->stage_log[s->n_stages]));
    s->stage[s->n_stages++] = *stage;
  }
  PetscCall(ListObservers(flow));
  PetscCall(AttemptArrange(flow));
  PetscFunctionReturn(PETSC_SUCCESS);
}
