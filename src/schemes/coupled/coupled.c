/* The coupled scheme: its row, options and refusals. It solves for velocity and pressure together,
   in time or for a steady flow. */
#include "coupled.h"
#include "schemes/scalars/scalars.h"
#include "schemes/stages/stages.h"

/* Refuses forms for which the coupled scheme has no solver. */
static PetscErrorCode RefuseForms(const Flow *flow)
{
  const OperatorForms *forms = &flow->ops->forms;
  const BoundaryRow   *slip  = SceneSlipKind(flow->scene);

  PetscFunctionBegin;
  UserCheck(!slip || SceneHasFreeSurface(flow->scene) ||
                (flow->scheme->splines && forms->visc.row->weak && !flow->state->has_convection),
            "-scheme coupled: it has one operator for all velocity components, and %s wants one "
            "for each; use -visc_laplacian weak_stress without convection past fixed particles, "
            "or -scheme projection",
            slip->option.name);
  UserCheck(flow->scheme->splines || !flow->ops->cut_surface,
            "-pressure_points same: a free surface needs coarse");
  UserCheck(flow->scheme->splines || forms->gradient->DivergenceFit,
            "-gradient %s: -scheme coupled needs one-sided pressure gradients beside walls, which "
            "only -gradient mls has",
            forms->gradient->name);
  UserCheck(LaplacianIs(&forms->visc, FORM_SAFE_IMPLICIT) ||
                LaplacianIs(&forms->visc, FORM_DISSIPATES),
            "-visc_laplacian %s: its matrix has eigenvalues of both signs, and -scheme coupled has "
            "no solver for it; use a form that is safe_implicit or dissipates in -catalogue",
            forms->visc.row->name);
  UserCheck(!flow->clock->steady_solve || LaplacianIs(&forms->visc, FORM_SAFE_IMPLICIT),
            "-steady: without du/dt -visc_laplacian %s leaves grid modes or constants wrong; use a "
            "form that is safe_implicit in -catalogue",
            forms->visc.row->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses -steady for flows with no steady state or with several steady states. */
static PetscErrorCode RefuseSteady(const Flow *flow)
{
  const Scene *scene  = flow->scene;
  PetscBool    filter = PETSC_FALSE;

  PetscFunctionBegin;
  if (!flow->clock->steady_solve) PetscFunctionReturn(PETSC_SUCCESS);
  UserCheck(!SceneMoves(scene), "-steady: particles that move have no steady positions; use "
                                "-motion eulerian, or -without convection for creeping flow");
  UserCheck(SceneHas(scene, PHYSICS_WALLS),
            "-steady: case %s has no walls, and without them any uniform velocity is a solution",
            scene->problem->name);
  UserCheck(!SceneIsDrivenInTime(scene) &&
                !(scene->exact.n && ExpressionUses(&scene->exact, EXPRESSION_TIME)),
            "-steady: a wall's velocity, the body force or -scene_exact depends on t; advance in "
            "time, with -dt_adapt error");
  if (scene->motion) PetscCall(OptionGiven("-velocity_filter", &filter));
  UserCheck(!filter, "-velocity_filter: -steady applies no filter to convection");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* CoupledCreate - Reads the options of the coupled scheme. Collective on PETSC_COMM_WORLD. For
   options of the solver see CoupledSolverCreate(). */
static PetscErrorCode CoupledCreate(Flow *flow)
{
  const Scene             *scene   = flow->scene;
  const PetscBool          viscous = SceneHas(scene, PHYSICS_VISCOSITY);
  const PressurePointsRow *points;
  Coupled                 *c;

  PetscFunctionBegin;
  PetscCall(PetscNew(&c));
  flow->scheme->data = c;
  c->flow            = flow;
  UserCheck(viscous && SceneHas(scene, PHYSICS_PRESSURE),
            "-scheme coupled: it solves for velocity and pressure together, and case %s has no %s "
            "here; add -with %s, or use -scheme projection",
            scene->problem->name, viscous ? "pressure" : "viscosity",
            viscous ? "pressure" : "viscosity");
  UserCheck(!SceneMovesGraded(scene),
            "-scheme coupled: particles that move have a uniform spacing with it; use -scheme "
            "projection, or -motion eulerian");
  PetscCall(RefuseSteady(flow));
  PetscCall(SteadyRefuse(flow, NULL, PETSC_FALSE));
  PetscCall(PressurePointsChoose(scene, &points));
  flow->scheme->needs |= NEED_MATRICES;
  if (points->coarse) PetscCall(PressureOnSplinesCreate(flow, &c->spacing));
  else flow->scheme->needs |= NEED_FREE_GRAD_P | NEED_FILTER_P;
  if (flow->clock->steady_solve) {
    flow->state->velocity_filter = RegimeValue(scene->regime, REGIME_FILTER_U);
    flow->scheme->needs &= ~(unsigned)NEED_FILTER_U;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CoupledSetUp(Flow *flow)
{
  Coupled *c = (Coupled *)flow->scheme->data;

  PetscFunctionBegin;
  if (c->spacing > 0.0) {
    PetscCall(SplinesCreate(flow, c->spacing, &flow->scheme->splines));
    flow->scheme->splines->has_products = PETSC_TRUE;
  }
  PetscCall(RefuseForms(flow));
  PetscCall(CoupledSolverCreate(flow, c));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CoupledRegister(Flow *flow)
{
  PetscFunctionBegin;
  if (flow->scheme->splines) PetscCall(SplinesStart(flow, flow->scheme->splines));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CoupledAssembleSplines(Flow *flow)
{
  Splines  *s = flow->scheme->splines;
  PetscBool anew;

  PetscFunctionBegin;
  if (!s) PetscFunctionReturn(PETSC_SUCCESS);
  anew = s->in_cut != flow->ops->assemblies;
  PetscCall(SplinesAssemble(flow, s));
  PetscCall(SplinesMix(flow, s));
  PetscCall(SplinesCutAssemble(flow, s));
  if (anew && flow->ops->cut_surface) PetscCall(FlowTensionMatrix(flow));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CoupledBegin(Flow *flow)
{
  PetscFunctionBegin;
  PetscCall(FlowBegin(flow));
  PetscCall(ScalarsBegin(flow));
  if (flow->scheme->splines) PetscCall(SplinesBegin(flow->scheme->splines));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CoupledView(const Flow *flow, PetscViewer viewer)
{
  PetscFunctionBegin;
  if (flow->scheme->splines) PetscCall(SplinesView(flow->scheme->splines, viewer));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CoupledDestroy(Flow *flow)
{
  PetscFunctionBegin;
  if (!flow->scheme->data) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(CoupledSolverFree((Coupled *)flow->scheme->data));
  PetscCall(SplinesDestroy(&flow->scheme->splines));
  PetscCall(PetscFree(flow->scheme->data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const Stage start = {.name   = "start",
                            .brief  = "pressure of the last step",
                            .Do     = CoupledStart,
                            .solves = PETSC_TRUE};

static const Stage solve = {.name   = "solve",
                            .brief  = "new velocity and pressure together",
                            .Do     = CoupledSolve,
                            .solves = PETSC_TRUE};

static const Stage *const stages[] = {
    &StageMomentum, &StageBodies, &StageMove, &StagePass, &StageRebuild,
    &StageScalars,  &StageFilter, &start,     &solve,     &StageMean,
    &StageCheck,    &StageError,  NULL,
};

static const Judge *const judges[] = {&JudgeBodies, &JudgeJump, &JudgeFailure, NULL};

const SchemeRow SchemeCoupled = {
    .name     = "coupled",
    .brief    = "velocity and pressure in one matrix: no splitting error at any step, or -steady",
    .citation = "Elman, Silvester & Wathen, Finite Elements and Fast Iterative Solvers (2014)",
    .Create   = CoupledCreate,
    .SetUp    = CoupledSetUp,
    .Register = CoupledRegister,
    .Assemble = CoupledAssembleSplines,
    .Begin    = CoupledBegin,
    .Start    = CoupledFreeStart,
    .Error    = CoupledError,
    .Limit    = FlowLimit,
    .View     = CoupledView,
    .Destroy  = CoupledDestroy,
    .stages   = stages,
    .judges   = judges,
    .memory   = {{5.5, 5.5, 5.7, 72.0}, {16.0, 16.0, 20.3, 118.0}},
};
