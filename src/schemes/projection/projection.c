/*
  The projection scheme. Particles move first, so that all other terms belong to t^{n+1}:

    x   += dr                                             FlowMove
    du/dt = nu lap u - (u-w).grad u - grad p^n/rho + f    -> u*          PredictVelocity
    lap phi = rho/k div u*                                               PressureSolve
    u    = u* - k/rho grad phi                                           ProjectVelocity
    p    = p^n + phi - mu div u*                                         ProjectVelocity

  k is the length of the viscous step: for the default of second order 2dt/3, as a backward Euler
  step from (4u^n - u^{n-1})/3. w is the velocity of the particles: u (Lagrangian) or 0 (Eulerian).
*/
#include "projection.h"
#include "schemes/scalars/scalars.h"
#include "schemes/stages/stages.h"

static PetscErrorCode ProjectionSetUp(Flow *flow)
{
  Projection *pr = (Projection *)flow->scheme->data;

  PetscFunctionBegin;
  if (SceneHas(flow->scene, PHYSICS_VISCOSITY)) PetscCall(ViscosityCreate(flow, &pr->visc));
  if (pr->spacing > 0.0) PetscCall(SplinesCreate(flow, pr->spacing, &pr->splines));
  if (pr->row) pr->space = pr->splines ? &PressureOnSplines : &PressureOnParticles;
  if (pr->row) PetscCall(PressureCreate(flow, &pr->ppe));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the share of the wall pressure gradient: 1 for a given initial pressure, which balances
   the force at walls, otherwise 0. */
static PetscErrorCode ProjectionRegister(Flow *flow)
{
  const Particles *p     = flow->particles;
  Projection      *pr    = (Projection *)flow->scheme->data;
  const PetscReal  level = flow->scene->level;
  PetscReal        most  = 0.0;

  PetscFunctionBegin;
  for (PetscInt i = 0; p->p && i < p->n_fluid; i++)
    most = PetscMax(most, PetscAbsReal(p->p[i] - level));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPIU_REAL, MPIU_MAX, p->comm));
  pr->wall_slope_share = most > 0.0 ? 1.0 : 0.0;
  if (pr->splines) PetscCall(SplinesStart(flow, pr->splines));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ProjectionBegin(Flow *flow)
{
  const Projection *pr = (const Projection *)flow->scheme->data;

  PetscFunctionBegin;
  PetscCall(FlowBegin(flow));
  PetscCall(ScalarsBegin(flow));
  if (pr->row) PetscCall(pr->space->Begin(flow));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ProjectionAssemble(Flow *flow)
{
  const Projection *pr = (const Projection *)flow->scheme->data;

  PetscFunctionBegin;
  if (pr->splines) PetscCall(SplinesAssemble(flow, pr->splines));
  if (pr->splines) PetscCall(SplinesMix(flow, pr->splines));
  if (pr->splines) PetscCall(SplinesCutAssemble(flow, pr->splines));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints the projection, its integrator, and a warning about steps that are long compared with
   the time of diffusion. */
static PetscErrorCode ProjectionView(const Flow *flow, PetscViewer viewer)
{
  const Scene      *scene  = flow->scene;
  const Projection *pr     = (const Projection *)flow->scheme->data;
  const PetscReal   number = scene->nu * flow->clock->dt / PetscSqr(scene->length);

  PetscFunctionBegin;
  PetscCall(TableViewRow("projection", pr->row, viewer));
  if (pr->splines) PetscCall(SplinesView(pr->splines, viewer));
  if (pr->visc) PetscCall(ViscosityView(pr->visc, viewer));
  if (pr->row && pr->visc && number > 0.02) {
    PetscCall(PetscViewerASCIIPrintf(viewer,
                                     "%-11s nu dt/L^2 = %.2g: first order in dt until the flow "
                                     "is steady; -scheme coupled has no such error\n",
                                     "splitting", (double)number));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ProjectionDestroy(Flow *flow)
{
  Projection *pr = (Projection *)flow->scheme->data;

  PetscFunctionBegin;
  if (!pr) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ViscosityDestroy(&pr->visc));
  PetscCall(PressureDestroy(&pr->ppe));
  PetscCall(SplinesDestroy(&pr->splines));
  PetscCall(VecDestroy(&pr->phi));
  PetscCall(PetscFree(flow->scheme->data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool HasPressure(const Flow *flow)
{
  return ((const Projection *)flow->scheme->data)->row ? PETSC_TRUE : PETSC_FALSE;
}

static const Stage predict = {.name   = "predict",
                              .brief  = "velocity after force and viscosity, u*",
                              .Do     = PredictVelocity,
                              .solves = PETSC_TRUE};

static const Stage project = {.name    = "project",
                              .brief   = "pressure from div u*, new velocity",
                              .Applies = HasPressure,
                              .Do      = ProjectVelocity,
                              .solves  = PETSC_TRUE};

static const Stage *const stages[] = {
    &StageMomentum, &StageBodies, &StageMove, &StagePass, &StageRebuild,
    &StageScalars,  &StageFilter, &predict,   &project,   &StageMean,
    &StageCheck,    &StageError,  NULL,
};

static const Judge *const judges[] = {&JudgeBodies, &JudgeFailure, NULL};

const SchemeRow SchemeProjection = {
    .name     = "projection",
    .brief    = "implicit viscosity, then a pressure projection",
    .citation = "Guermond, Minev & Shen, Comput. Methods Appl. Mech. Eng. 195 (2006)",
    .Create   = ProjectionCreate,
    .SetUp    = ProjectionSetUp,
    .Register = ProjectionRegister,
    .Assemble = ProjectionAssemble,
    .Begin    = ProjectionBegin,
    .Start    = ProjectionStart,
    .Limit    = FlowLimit,
    .View     = ProjectionView,
    .Destroy  = ProjectionDestroy,
    .stages   = stages,
    .judges   = judges,
    .memory   = {{2.2, 2.8, 2.3, 6.9}, {6.4, 9.2, 5.6, 35.0}},
};
