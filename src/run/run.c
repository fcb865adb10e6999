/* The run of a flow: creation of its parts, a step with the output after it, and the report at the
   end, which is also written after a failure. */
#include "isph/start.h"
#include "impl.h"

#define FIND_PASSES 10 /* after which given fluids have their interfaces */

/* Registers the stages of a run for -log_view. Without a log all stages are the main stage, because
   PETSc gives each stage a record of 0.2 MB. */
static PetscErrorCode RegisterStages(Run *run)
{
  const char *const names[RUN_STAGES] = {
      [STAGE_SETUP] = "Set-up", [STAGE_STEPS] = "Steps", [STAGE_OUTPUT] = "Output"};
  PetscBool logs;

  PetscFunctionBegin;
  PetscCall(PetscLogIsActive(&logs));
  for (PetscInt k = 0; k < RUN_STAGES && logs; k++)
    PetscCall(LogStageGet(names[k], &run->stage[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates clock, scheme and operators from options, before particles exist. Input: given - number
   of given fluid particles. */
static PetscErrorCode RunChoose(Run *run, PetscInt given)
{
  Flow *flow = &run->flow;

  PetscFunctionBegin;
  PetscCall(ClockCreate(flow->scene, &flow->clock));
  PetscCall(SnapshotsCreate(flow->scene, &run->snapshots));
  flow->clock->land_every = SnapshotsInterval(run->snapshots);
  PetscCall(SchemeCreate(flow));
  PetscCall(OperatorsCreate(flow->scene, flow->scheme->needs | SnapshotsNeeds(run->snapshots),
                            &flow->ops));
  PetscCall(MachineMemoryCheck(flow, given ? (PetscReal)given : ParticlesExpect(flow->scene),
                               &run->memory));
  PetscCall(SchemeSetUp(flow));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the particles with the fields of the scheme, and the lists of neighbours. */
static PetscErrorCode RunFill(Run *run, const char path[], const FluidStart *start)
{
  Flow         *flow = &run->flow;
  WallPlacement walls;

  PetscFunctionBegin;
  PetscCall(OperatorsPlacement(flow->scene, flow->ops, &walls));
  PetscCall(ParticlesCreate(flow->scene, flow->ops->forms.reach, &flow->particles));
  PetscCall(ParticlesFill(flow->scene, walls, path[0] ? start : NULL, flow->particles));
  if (flow->particles->nu && SceneIsNewtonian(flow->scene)) {
    PetscCall(SceneBoundGivenViscosity(flow->particles->n_fluid, flow->particles->nu, flow->scene));
  }
  PetscCall(SchemeRegister(flow));
  PetscCall(NeighborsCreate(flow->ops->forms.radius, SceneCoarsest(flow->scene), &flow->neighbors));
  if (SceneMovesGraded(flow->scene)) { /* edges of cells grow from a cell to the next */
    flow->neighbors->slope =
        SceneGrowth(flow->scene) * flow->neighbors->radius / flow->neighbors->spacing;
  }
  PetscCall(StartCheck(flow->scene, path, flow->particles, flow->neighbors));
  for (PetscInt pass = 0; pass < FIND_PASSES && start->nu; pass++)
    PetscCall(InterfacesFollow(flow->particles, flow->neighbors));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the outputs of the run. */
static PetscErrorCode RunOpenFiles(Run *run)
{
  PetscFunctionBegin;
  PetscCall(MonitorsCreate(&run->flow, &run->monitors));
  PetscCall(ProgressCreate(&run->progress));
  PetscCall(ReportCreate(&run->report));
  PetscCall(CheckpointsCreate(&run->checkpoints));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* RunCreate - Creates all parts of the run from the scene, each from parts that were created before
   it, as options say; an option that nothing reads is refused; collective */
PetscErrorCode RunCreate(Run *run)
{
  FluidStart start;
  char       path[PETSC_MAX_PATH_LEN];

  PetscFunctionBegin;
  PetscCall(PetscTime(&run->started));
  PetscCall(RegisterStages(run));
  PetscCall(PetscLogStagePush(run->stage[STAGE_SETUP]));
  PetscCall(RunCheckOutputs());
  PetscCall(StartRead(run->flow.scene, &start, path));
  PetscCall(RunChoose(run, start.N));
  PetscCall(RunFill(run, path, &start));
  PetscCall(StartFree(&start));
  PetscCall(RunOpenFiles(run));
  PetscCall(SchemeArrange(&run->flow));
  PetscCall(OptionsRefuseUnknown(PETSC_FALSE));
  PetscCall(PetscLogStagePop());
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* RunDestroy - Destroys those parts of the run that exist; the scene remains; collective */
PetscErrorCode RunDestroy(Run *run)
{
  Flow *flow = &run->flow;

  PetscFunctionBegin;
  PetscCall(CheckpointsDestroy(&run->checkpoints));
  PetscCall(ReportDestroy(&run->report));
  PetscCall(ProgressDestroy(&run->progress));
  PetscCall(MonitorsDestroy(&run->monitors));
  PetscCall(SnapshotsDestroy(&run->snapshots));
  PetscCall(NeighborsDestroy(&flow->neighbors));
  PetscCall(ParticlesDestroy(&flow->particles));
  PetscCall(SchemeDestroy(flow));
  PetscCall(OperatorsDestroy(&flow->ops));
  PetscCall(ClockDestroy(&flow->clock));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Checks if the run is over; prints the reason for an early end. */
static PetscErrorCode RunIsOver(Run *run)
{
  Clock           *clock  = run->flow.clock;
  const PetscReal *change = run->flow.scheme->stats.change;

  PetscFunctionBegin;
  run->over = (clock->t >= clock->t_end * (1.0 - 1e-12) || clock->step >= clock->max_steps)
                  ? PETSC_TRUE
                  : PETSC_FALSE;
  if (clock->steady_tol > 0.0 && clock->step > 2 && change[0] < clock->steady_tol &&
      change[1] < clock->steady_tol && change[2] < clock->steady_tol) {
    run->over = clock->steady = PETSC_TRUE;
    PetscCall(
        SayLine("steady at t = %.6g: u changes by %.1e, div u* by %.1e, p by %.1e, all below %.3g",
                (double)clock->t, (double)change[0], (double)change[1], (double)change[2],
                (double)clock->steady_tol));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* RunMeasure - Measures the present flow: the quantities of its case, and the estimate of its
   error; collective */
PetscErrorCode RunMeasure(Run *run)
{
  PetscFunctionBegin;
  run->report->t = run->flow.clock->t;
  PetscCall(FlowPrepareOutput(&run->flow));
  PetscCall(run->flow.scene->problem->Measure(&run->flow, run->report));
  PetscCall(ScalarsMeasure(&run->flow, run->report));
  PetscCall(BalancesMeasure(&run->flow, run->report));
  PetscCall(TrustMeasure(&run->flow, run->report));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Measures the flow if a time of -report_times is reached; RunReport() measures it at the end. */
static PetscErrorCode RunMeasureDue(Run *run)
{
  Clock *clock = run->flow.clock;

  PetscFunctionBegin;
  if (clock->next_report == clock->n_reports ||
      clock->t < clock->report_time[clock->next_report] * (1.0 - 1e-12)) {
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(RunMeasure(run));
  clock->next_report++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* RunBegin - Prepares the flow at the start, or reads it from a checkpoint; collective */
PetscErrorCode RunBegin(Run *run)
{
  PetscBool restarted;

  PetscFunctionBegin;
  PetscCall(CheckpointsRestart(run, &restarted));
  if (restarted) {
    PetscCall(MonitorsRestart(run->flow.clock->t, run->monitors));
    PetscCall(SnapshotsWrite(&run->flow, PETSC_FALSE, run->snapshots)); /* of a new series */
    PetscCall(MonitorsBegin(&run->flow, run->monitors));
  } else {
    PetscCall(run->flow.scheme->row->Begin(&run->flow));
    if (run->flow.scheme->row->Start) PetscCall(run->flow.scheme->row->Start(&run->flow));
    PetscCall(SnapshotsWrite(&run->flow, PETSC_FALSE, run->snapshots));
    PetscCall(MonitorsWrite(&run->flow, run->monitors));
  }
  PetscCall(ExpressionScopeCheck(run->flow.scene->scope));
  PetscCall(RunIsOver(run));
  if (!run->over) PetscCall(RunMeasureDue(run)); /* a restarted run may begin at a report time */
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes files, progress line and reports between steps. */
static PetscErrorCode RunBetweenSteps(Run *run, PetscBool over)
{
  PetscFunctionBegin;
  PetscCall(PetscLogStagePush(run->stage[STAGE_OUTPUT]));
  PetscCall(SnapshotsWrite(&run->flow, over, run->snapshots));
  PetscCall(MonitorsWrite(&run->flow, run->monitors));
  PetscCall(ProgressUpdate(&run->flow, over, run->progress));
  PetscCall(CheckpointsUpdate(over, run));
  if (!over) PetscCall(RunMeasureDue(run)); /* after the checkpoint, as in a restarted run */
  PetscCall(PetscLogStagePop());
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses options that no solver has read, once each solver has solved. Output: checked - flag:
   this is done. */
static PetscErrorCode RefuseUnread(const Scheme *scheme, PetscBool *checked)
{
  PetscFunctionBegin;
  if (*checked) PetscFunctionReturn(PETSC_SUCCESS);
  *checked = PETSC_TRUE;
  for (PetscInt k = 0; k < scheme->n_solves; k++)
    if (scheme->solve[k]->ksp && scheme->solve[k]->iterations == 0) *checked = PETSC_FALSE;
  if (*checked) PetscCall(OptionsRefuseUnknown(PETSC_TRUE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* RunStep - Makes a step, and writes what is due after it; collective */
PetscErrorCode RunStep(Run *run)
{
  PetscFunctionBegin;
  PetscCall(PetscLogStagePush(run->stage[STAGE_STEPS]));
  PetscCall(FlowMakeStep(&run->flow));
  PetscCall(RefuseUnread(run->flow.scheme, &run->checked));
  PetscCall(RunIsOver(run));
  PetscCall(InterruptCheck(&run->signal));
  PetscCall(RunBetweenSteps(run, run->over || run->signal ? PETSC_TRUE : PETSC_FALSE));
  PetscCall(PetscLogStagePop());
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reports the number of undone steps if steps are retried, the figures of the scheme, the number of
   steps rejected because of their error, and the number of fallbacks of each solve that had any. */
static PetscErrorCode RunReportChoices(Run *run)
{
  const Scheme *scheme = run->flow.scheme;

  PetscFunctionBegin;
  if (run->flow.clock->adapt->retries)
    PetscCall(ReportAdd(run->report, "retries", run->flow.clock->retries));
  for (PetscInt k = 0; k < scheme->n_figures; k++) {
    const SchemeFigure *figure = &scheme->figure[k];

    if (figure->quiet && *figure->value <= figure->most) continue;
    PetscCall(ReportAdd(run->report, figure->name, *figure->value));
  }
  if (run->flow.clock->adapt->estimates)
    PetscCall(ReportAdd(run->report, "rejected", run->flow.clock->control.rejected));
  for (PetscInt k = 0; k < scheme->n_solves; k++) {
    char name[32];

    if (scheme->solve[k]->setups > 1) {
      PetscCall(PetscSNPrintf(name, sizeof(name), "%ssetups", scheme->solve[k]->prefix));
      PetscCall(ReportAdd(run->report, name, scheme->solve[k]->setups));
    }
    if (!scheme->solve[k]->falls) continue;
    PetscCall(PetscSNPrintf(name, sizeof(name), "%sfalls", scheme->solve[k]->prefix));
    PetscCall(ReportAdd(run->report, name, scheme->solve[k]->falls));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints a line for each figure of the scheme that has left its range. */
static PetscErrorCode RunPrintFigures(const Scheme *scheme)
{
  PetscFunctionBegin;
  for (PetscInt k = 0; k < scheme->n_figures; k++) {
    const SchemeFigure *figure = &scheme->figure[k];

    if (*figure->value <= figure->most) continue;
    PetscCall(SayLine("%s %.3g, should be at most %.3g: %s", figure->name, (double)*figure->value,
                      (double)figure->most, figure->remedy));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reports errors and cost. Input: status - ok, interrupted or diverged; measured - false for a
   diverged flow, which is not measured; viewer - NULL: only the CSV file. */
static PetscErrorCode ReportAll(Run *run, const char status[], PetscBool measured,
                                PetscViewer viewer)
{
  PetscLogDouble now;

  PetscFunctionBegin;
  run->report->t = run->flow.clock->t; /* of quantities of the run itself */
  if (measured) PetscCall(RunMeasure(run));
  else if (viewer) PetscCall(BalancesOfFailed(&run->flow, run->report, viewer));
  PetscCall(ExpressionScopeCheck(run->flow.scene->scope));
  PetscCall(RunReportChoices(run));
  PetscCall(PetscTime(&now));
  if (measured && viewer) {
    PetscCall(ReportView(run->report, now - run->started, viewer));
    PetscCall(TrustView(&run->flow, run->report, viewer));
    PetscCall(SteadyView(&run->flow, viewer));
    PetscCall(SpeedView(&run->flow, viewer));
  }
  if (viewer) PetscCall(BalancesView(&run->flow, viewer));
  if (viewer) PetscCall(RunPrintFigures(run->flow.scheme));
  PetscCall(ReportWrite(&run->flow, run->report, now - run->started, status));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* RunShowBanner - Prints the banner with the usual step of this run; collective. After a restart
   the clock has the last step of the earlier run, which a report at this time still shows. */
PetscErrorCode RunShowBanner(Run *run, PetscViewer viewer)
{
  const PetscReal last = run->flow.clock->dt;

  PetscFunctionBegin;
  PetscCall(SchemeChooseStep(&run->flow));
  PetscCall(BannerView(&run->flow, &run->memory, viewer));
  run->flow.clock->dt = last;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* RunReport - Measures the flow at the end of a run and reports; checks the bounds of
   -check_<quantity>. Collective. Input: failed - error of the last step, after which a diverged
   flow is reported and no other; viewer - NULL: only the CSV file. */
PetscErrorCode RunReport(Run *run, PetscErrorCode failed, PetscViewer viewer)
{
  const PetscMPIInt signal = run->signal;

  PetscFunctionBegin;
  PetscCall(PetscLogStagePush(run->stage[STAGE_OUTPUT]));
  if (!failed) PetscCall(ReportAll(run, signal ? "interrupted" : "ok", PETSC_TRUE, viewer));
  else if (failed == run->flow.scheme->failure.code)
    PetscCall(ReportAll(run, failed > ERROR_INTERRUPTED(0) ? "interrupted" : "diverged",
                        PETSC_FALSE, viewer));
  PetscCall(PetscLogStagePop());
  if (failed) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(!signal, PETSC_COMM_WORLD, ERROR_INTERRUPTED(signal),
             "interrupted by %s at t = %.6g (step %" PetscInt_FMT "); all files are complete",
             InterruptName(signal), (double)run->flow.clock->t, run->flow.clock->step);
  PetscCall(ReportCheck(run->report));
  PetscFunctionReturn(PETSC_SUCCESS);
}
