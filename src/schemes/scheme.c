/* The table of schemes, and creation and destruction of the scheme of a run. A new scheme needs a
   folder with its row at the foot of a file, and one word here. */
#include "isph/motion.h"
#include "isph/schemes.h"
#include "schemes/scalars/scalars.h"

#define SCHEMES(ROW)                                                                               \
  ROW(SchemeProjection)                                                                            \
  ROW(SchemeCoupled)                                                                               \
  ROW(SchemeWcsph)

#define DECLARE(row) extern const SchemeRow row;
SCHEMES(DECLARE)

#define ADDRESS(row) &row,
static const SchemeRow *const schemes[]   = {SCHEMES(ADDRESS)};
const Table                   SchemeTable = TABLE_OF_POINTERS("Schemes", schemes);

static const OptionRow options[] = {
    OPTION(NAME, "-scheme", "scheme that advances velocity and pressure", NULL, REGIME,
           .table = &SchemeTable, .where = "flows"),
};
const OptionTable SchemeOptions = OPTIONS("Scheme", options);

/* Refuses options that flows with a free surface exclude. */
static PetscErrorCode RefuseSurface(const Flow *flow)
{
  const Scene *scene = flow->scene;

  PetscFunctionBegin;
  if (!SceneHasFreeSurface(scene)) PetscFunctionReturn(PETSC_SUCCESS);
  UserCheck(SceneHas(scene, PHYSICS_PRESSURE),
            "-without pressure: a fluid with a free surface needs it");
  UserCheck(
      !flow->state->has_convection,
      "-motion eulerian: a free surface moves with its particles; use lagrangian, or -without "
      "convection for displacements far below dx");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SchemeCreate - Chooses the scheme, creates the state of the flow, and sets the first time step.
   Collective on PETSC_COMM_WORLD. Input/Output: flow - in: scene and clock; out: state, scheme, and
   the needs for the creation of operators. */
PetscErrorCode SchemeCreate(Flow *flow)
{
  Regime   *regime = flow->scene->regime;
  Scheme   *s;
  PetscReal force2 = 0.0;

  PetscFunctionBegin;
  PetscCall(PetscNew(&s));
  flow->scheme = s;
  s->needs     = SceneNeeds(flow->scene);
  for (PetscInt a = 0; a < flow->scene->dim; a++) force2 += PetscSqr(flow->scene->body_force[a]);
  s->stats.force_max = PetscSqrtReal(force2);
  RegimeSetFact(regime, FACT_STEADY, flow->clock->steady_solve);
  PetscCall(OptionGetRow(&options[0], RegimeWord(regime, REGIME_SCHEME), &s->row));
  PetscCall(ClockRemember(flow->clock, &s->memory));
  PetscCall(FlowRemember(flow));
  PetscCall(SchemeChooseStep(flow));
  PetscCall(FlowStateCreate(flow));
  PetscCall(MotionCreate(flow, &s->needs));
  PetscCall(OpeningsCreate(flow));
  PetscCall(RefuseSurface(flow));
  PetscCall(GradedRemember(flow));
  PetscCall(ScalarsCreate(flow));
  PetscCall(s->row->Create(flow));
  PetscCall(UnevennessReport(flow));
  PetscCall(AccelerationRemember(flow));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SchemeSetUp - Creates the solvers after the choice of operators, and chooses the time step again,
   because integrators decide on the control of steps; collective */
PetscErrorCode SchemeSetUp(Flow *flow)
{
  PetscFunctionBegin;
  PetscCall(flow->scheme->row->SetUp(flow));
  PetscCall(ScalarsSetUp(flow));
  PetscCall(SchemeChooseStep(flow));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SchemeRegister - Adds the fields of state and scheme to the particles, with initial values;
   collective */
PetscErrorCode SchemeRegister(Flow *flow)
{
  PetscFunctionBegin;
  PetscCall(FlowStateRegister(flow));
  PetscCall(AccelerationRegister(flow));
  PetscCall(BodiesRegister(flow->scene, flow->scheme));
  PetscCall(FreeBodiesCreate(flow));
  PetscCall(ScalarsRegister(flow));
  PetscCall(OpeningsRegister(flow));
  if (flow->scheme->row->Register) PetscCall(flow->scheme->row->Register(flow));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SchemeDestroy - Frees scheme, state and wall values; collective */
PetscErrorCode SchemeDestroy(Flow *flow)
{
  PetscFunctionBegin;
  if (!flow->scheme) PetscFunctionReturn(PETSC_SUCCESS);
  if (flow->state) { /* a refused option leaves a part of it */
    PetscCall(flow->scheme->row->Destroy(flow));
    PetscCall(AttemptDestroy(&flow->scheme->attempt));
    PetscCall(ScalarsDestroy(flow));
    PetscCall(FreeBodiesDestroy(flow->scene, &flow->state->bodies));
  }
  PetscCall(FlowStateDestroy(flow));
  PetscCall(WallValuesFree(&flow->walls));
  PetscCall(PetscFree(flow->scheme));
  PetscFunctionReturn(PETSC_SUCCESS);
}
