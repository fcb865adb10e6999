/*
  The run of a flow: everything it owns made in order, the time loop with what happens between
  steps, and what is told at its end, however it ends.
*/
#include "impl.h"

static Flow RunFlow(const Run *run)
{
  const Flow flow = {run->scene, run->particles, run->neighbors, run->ops, run->clock, run->scheme};

  return flow;
}

/* scene -> clock, operators, scheme -> particles, neighbours -> files -> first matrices. */
static PetscErrorCode RunCreate(Run *run)
{
  WallPlacement walls;
  FluidStart    start;
  char          path[PETSC_MAX_PATH_LEN];

  PetscFunctionBegin;
  PetscCall(StartRead(run->scene, &start, path));
  PetscCall(ClockCreate(run->scene, &run->clock));
  PetscCall(OperatorsCreate(run->scene, &run->ops));
  PetscCall(SchemeCreate(run->scene, run->clock, run->ops, &run->scheme));
  if (run->clock->adapt->retries) PetscCall(UndoCreate(&run->undo));
  PetscCall(OperatorsPlacement(run->scene, run->ops, &walls));
  PetscCall(ParticlesCreate(run->scene, walls, run->ops->reach, path[0] ? &start : NULL,
                            &run->particles));
  PetscCall(StartFree(&start));
  if (run->particles->nu && SceneIsNewtonian(run->scene))
    PetscCall(SceneBoundGivenViscosity(run->particles->n_fluid, run->particles->nu, run->scene));
  PetscCall(SchemeRegister(run->scene, run->particles, run->scheme));
  PetscCall(NeighborsCreate(run->ops->radius, &run->neighbors));
  PetscCall(StartCheck(run->scene, path, run->particles, run->neighbors));
  PetscCall(SnapshotsCreate(run->scene, &run->snapshots));
  PetscCall(MonitorsCreate(run->scene, &run->monitors));
  PetscCall(ProgressCreate(&run->progress));
  PetscCall(ReportCreate(&run->report));
  if (run->scheme->visc && ViscosityIntegrator(run->scheme->visc)->kind != TIME_EXPLICIT)
    PetscCall(MatrixFileCreate("visc_", &run->visc_matrix));
  if (run->ops->ppe.needed) PetscCall(MatrixFileCreate("ppe_", &run->ppe_matrix));
  PetscCall(CheckpointsCreate(run->scheme, &run->checkpoints));
  PetscCall(OptionsRefuseUnknown(PETSC_FALSE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode RunDestroy(Run *run)
{
  PetscFunctionBegin;
  PetscCall(CheckpointsDestroy(&run->checkpoints));
  PetscCall(MatrixFileDestroy(&run->ppe_matrix));
  PetscCall(MatrixFileDestroy(&run->visc_matrix));
  PetscCall(ReportDestroy(&run->report));
  PetscCall(ProgressDestroy(&run->progress));
  PetscCall(MonitorsDestroy(&run->monitors));
  PetscCall(SnapshotsDestroy(&run->snapshots));
  PetscCall(NeighborsDestroy(&run->neighbors));
  PetscCall(ParticlesDestroy(&run->particles));
  PetscCall(UndoDestroy(&run->undo));
  PetscCall(SchemeDestroy(&run->scheme));
  PetscCall(OperatorsDestroy(&run->ops));
  PetscCall(ClockDestroy(&run->clock));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The flow at the start, or that of a checkpoint. */
static PetscErrorCode RunBegin(Run *run)
{
  PetscBool restarted;

  PetscFunctionBegin;
  PetscCall(CheckpointsRestart(run, &restarted));
  if (restarted) {
    PetscCall(MonitorsRestart(run->clock->t, run->monitors));
  } else {
    const Flow flow = RunFlow(run);

    PetscCall(run->scheme->row->Begin(run->scene, run->clock, run->particles, run->neighbors,
                                      run->ops, run->scheme));
    PetscCall(SnapshotsWrite(&flow, PETSC_FALSE, run->snapshots));
    PetscCall(MonitorsWrite(&flow, run->monitors));
  }
  PetscCall(ExpressionScopeCheck(run->scene->scope));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Whether the run is over, and in words why where that is not t_end. */
static PetscErrorCode RunIsOver(Run *run, PetscBool *over)
{
  Clock           *clock  = run->clock;
  const PetscReal *change = run->scheme->stats.change;

  PetscFunctionBegin;
  *over = (clock->t >= clock->t_end * (1.0 - 1e-12) || clock->step >= clock->max_steps)
              ? PETSC_TRUE
              : PETSC_FALSE;
  if (clock->steady_tol > 0.0 && clock->step > 2 && change[0] < clock->steady_tol &&
      change[1] < clock->steady_tol && change[2] < clock->steady_tol) {
    *over = clock->steady = PETSC_TRUE;
    PetscCall(
        SayLine("steady at t = %.6g: u changes by %.1e, div u* by %.1e, p by %.1e, all below %.3g",
                (double)clock->t, (double)change[0], (double)change[1], (double)change[2],
                (double)clock->steady_tol));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  One step that went well, or the end of the run: a failed one is undone and tried with a shorter dt
  where the clock retries.
*/
static PetscErrorCode RunStep(Run *run)
{
  Clock           *clock   = run->clock;
  const StepStats *stats   = &run->scheme->stats;
  StepFailure     *failure = &run->scheme->failure;

  PetscFunctionBegin;
  do {
    PetscCall(ClockChoose(run->scene, stats->speed_max, stats->force_max, clock));
    if (run->undo) PetscCall(UndoSave(clock, run->particles, run->scheme, run->undo));
    PetscCall(run->scheme->row->Step(run->scene, clock, run->particles, run->neighbors, run->ops,
                                     run->scheme));
    PetscCall(ExpressionScopeCheck(run->scene->scope));
    if (!failure->code) PetscFunctionReturn(PETSC_SUCCESS);
    if (!run->undo || failure->fatal) break;
    PetscCall(UndoRestore(run->scene, run->undo, clock, run->particles, run->neighbors, run->ops,
                          run->scheme));
    PetscCall(ClockRetry(clock, failure));
  } while (!failure->fatal);
  PetscCheck(PETSC_FALSE, PETSC_COMM_WORLD, failure->code, "%s", failure->sentence);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Judges the flow if it has come to a time of -report_times; at a run's end the end's report
   does. */
static PetscErrorCode RunMeasureDue(Run *run)
{
  const Flow flow  = RunFlow(run);
  Clock     *clock = run->clock;

  PetscFunctionBegin;
  if (clock->next_report == clock->n_reports ||
      clock->t < clock->report_time[clock->next_report] * (1.0 - 1e-12)) {
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  run->report->t = clock->t;
  PetscCall(run->scene->problem->Measure(&flow, run->report));
  clock->next_report++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What is due after a step: files, the progress line, reports at their times. */
static PetscErrorCode RunBetweenSteps(Run *run, PetscBool over)
{
  const Flow flow = RunFlow(run);

  PetscFunctionBegin;
  PetscCall(SnapshotsWrite(&flow, over, run->snapshots));
  PetscCall(MonitorsWrite(&flow, run->monitors));
  PetscCall(ProgressUpdate(&flow, over, run->progress));
  PetscCall(CheckpointsUpdate(over, run));
  if (!over) PetscCall(RunMeasureDue(run)); /* with the particles in the order of a restarted run */
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The time loop; signal - what stopped it early, NULL for nothing. */
static PetscErrorCode RunSolve(Run *run, const char **signal)
{
  Clock    *clock = run->clock;
  PetscInt  first = clock->step;
  PetscBool over;

  PetscFunctionBegin;
  *signal = NULL;
  PetscCall(RunIsOver(run, &over));
  if (!over) PetscCall(RunMeasureDue(run)); /* of a run that was stopped at such a time */
  while (!over && !*signal) {
    PetscCall(RunStep(run));
    if (clock->step == first + 1) PetscCall(OptionsRefuseUnknown(PETSC_TRUE));
    PetscCall(RunIsOver(run, &over));
    PetscCall(InterruptCheck(signal));
    PetscCall(RunBetweenSteps(run, over || *signal ? PETSC_TRUE : PETSC_FALSE));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The matrices of the last solves, where asked for. */
static PetscErrorCode RunWriteMatrices(const Run *run)
{
  const Scheme *scheme = run->scheme;

  PetscFunctionBegin;
  if (run->visc_matrix)
    PetscCall(MatrixFileWrite(run->particles, ViscosityMatrix(scheme->visc), run->visc_matrix));
  if (run->ppe_matrix) PetscCall(MatrixFileWrite(run->particles, run->ops->ppe.A, run->ppe_matrix));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What it took to get there, where it took anything. */
static PetscErrorCode RunCountTroubles(Run *run)
{
  const Scheme  *scheme  = run->scheme;
  const PetscInt visc    = scheme->visc ? *ViscosityFalls(scheme->visc) : 0;
  const PetscInt ppe     = scheme->ppe ? *PressureFalls(scheme->ppe) : 0;
  const PetscInt coupled = scheme->coupled ? *CoupledFalls(scheme->coupled) : 0;

  PetscFunctionBegin;
  if (run->undo) PetscCall(ReportAdd(run->report, "retries", run->clock->retries));
  if (visc) PetscCall(ReportAdd(run->report, "visc_falls", visc));
  if (ppe) PetscCall(ReportAdd(run->report, "ppe_falls", ppe));
  if (coupled) PetscCall(ReportAdd(run->report, "coupled_falls", coupled));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Errors beside what they cost, on the screen and in the CSV file. status - ok, interrupted or
  diverged; a diverged flow is not measured.
*/
static PetscErrorCode RunReport(Run *run, const char status[], PetscBool measured)
{
  const Flow     flow = RunFlow(run);
  PetscLogDouble now;

  PetscFunctionBegin;
  run->report->t = run->clock->t;
  PetscCall(RunWriteMatrices(run));
  if (measured) PetscCall(run->scene->problem->Measure(&flow, run->report));
  PetscCall(ExpressionScopeCheck(run->scene->scope));
  PetscCall(RunCountTroubles(run));
  PetscCall(PetscTime(&now));
  if (measured) PetscCall(ReportView(run->report, now - run->started, PETSC_VIEWER_STDOUT_WORLD));
  PetscCall(ReportWrite(&flow, run->report, now - run->started, status));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* From the banner to the end. */
static PetscErrorCode RunTellAndSolve(Run *run)
{
  const Flow     flow = RunFlow(run);
  const char    *signal;
  PetscErrorCode failed;

  PetscFunctionBegin;
  PetscCall(InterruptInstall());
  PetscCall(RunBegin(run));
  PetscCall(BannerView(&flow, PETSC_VIEWER_STDOUT_WORLD));
  failed = RunSolve(run, &signal);
  if (failed == PETSC_ERR_NOT_CONVERGED || failed == PETSC_ERR_FP)
    PetscCall(RunReport(run, "diverged", PETSC_FALSE));
  PetscCall(failed);
  PetscCall(RunReport(run, signal ? "interrupted" : "ok", PETSC_TRUE));
  UserCheck(!signal,
            "interrupted by %s at t = %.6g (step %" PetscInt_FMT "); all files are complete",
            signal, (double)run->clock->t, run->clock->step);
  PetscCall(ReportCheck(run->report));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  FlowRun - Runs a flow from its scene to its report

  Collective on PETSC_COMM_WORLD.

  Errors: a flow that diverges, a signal, an error above what -check_ allows
*/
PetscErrorCode FlowRun(Scene *scene)
{
  Run       run = {.scene = scene};
  PetscBool wants_help;

  PetscFunctionBegin;
  PetscCall(PetscTime(&run.started));
  PetscCall(RunCreate(&run));
  PetscCall(OptionGiven("-help", &wants_help));
  if (!wants_help) PetscCall(RunTellAndSolve(&run));
  PetscCall(RunDestroy(&run));
  PetscFunctionReturn(PETSC_SUCCESS);
}
