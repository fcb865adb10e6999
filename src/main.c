static const char help[] =
    "isph: incompressible viscous flow by Smoothed Particle Hydrodynamics.\n\n"
    "  du/dt = -grad p/rho + nu lap u + f,   div u = 0\n\n"
    "Viscosity is advanced implicitly by a PETSc TS (prefix -visc_), the pressure Poisson equation "
    "is\n"
    "solved by a KSP (prefix -ppe_). Example:\n\n"
    "  isph -options_file options/cavity.opts -reynolds 1000 -t_end 40 -visc_ts_type arkimex\n\n"
    "-catalogue lists cases, operators, walls, schemes and integrators with their papers.\n\n";

#include "isph/patch.h"
#include <errno.h>
#include <string.h>

/* Everything a run owns, in the order of its making. */
typedef struct {
  Scene         *scene;
  Clock         *clock;
  Operators     *ops;
  Scheme        *scheme;
  Particles     *particles;
  Neighbors     *neighbors;
  Snapshots     *snapshots;
  Progress      *progress;
  Report        *report;
  MatrixFile    *visc_matrix, *ppe_matrix;
  PetscLogDouble started; /* wall clock [s] */
} Run;

static Flow RunFlow(const Run *run)
{
  const Flow flow = {run->scene, run->particles, run->neighbors, run->ops, run->clock, run->scheme};

  return flow;
}

/* scene -> operators, scheme -> particles -> neighbours -> first matrices. */
static PetscErrorCode RunCreate(Run *run)
{
  WallPlacement walls;
  PetscBool     changed;

  PetscFunctionBegin;
  PetscCall(ClockCreate(run->scene, &run->clock));
  PetscCall(OperatorsCreate(run->scene, &run->ops));
  PetscCall(SchemeCreate(run->scene, run->clock, run->ops, &run->scheme));
  PetscCall(OperatorsPlacement(run->scene, run->ops, &walls));
  PetscCall(ParticlesCreate(run->scene, walls, run->ops->radius, &run->particles));
  PetscCall(SchemeRegister(run->scene, run->particles, run->scheme));
  PetscCall(NeighborsCreate(run->ops->radius, &run->neighbors));
  PetscCall(SnapshotsCreate(run->scene, &run->snapshots));
  PetscCall(ProgressCreate(&run->progress));
  PetscCall(ReportCreate(&run->report));
  PetscCall(MatrixFileCreate("visc_", &run->visc_matrix));
  PetscCall(MatrixFileCreate("ppe_", &run->ppe_matrix));
  PetscCall(OptionsRefuseUnknown(PETSC_FALSE));
  PetscCall(NeighborsUpdate(run->particles, 0.0, run->neighbors));
  PetscCall(OperatorsAssemble(run->scene, run->particles, run->neighbors, run->ops, &changed));
  PetscCall(OperatorsSetWallVelocity(run->scene, run->particles, 0.0, 0.0, run->ops));
  PetscCall(run->scheme->row->Begin(run->scene, run->particles, run->ops, run->scheme));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode RunDestroy(Run *run)
{
  PetscFunctionBegin;
  PetscCall(MatrixFileDestroy(&run->ppe_matrix));
  PetscCall(MatrixFileDestroy(&run->visc_matrix));
  PetscCall(ReportDestroy(&run->report));
  PetscCall(ProgressDestroy(&run->progress));
  PetscCall(SnapshotsDestroy(&run->snapshots));
  PetscCall(NeighborsDestroy(&run->neighbors));
  PetscCall(ParticlesDestroy(&run->particles));
  PetscCall(SchemeDestroy(&run->scheme));
  PetscCall(OperatorsDestroy(&run->ops));
  PetscCall(ClockDestroy(&run->clock));
  PetscCall(SceneDestroy(&run->scene));
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
    PetscCall(PetscPrintf(
        PETSC_COMM_WORLD,
        "\nsteady at t = %.6g: u changes by %.1e, div u* by %.1e, p by %.1e, all below %.3g\n",
        (double)clock->t, (double)change[0], (double)change[1], (double)change[2],
        (double)clock->steady_tol));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The time loop. */
static PetscErrorCode RunSolve(Run *run)
{
  const Flow flow  = RunFlow(run);
  Clock     *clock = run->clock;
  PetscBool  over;

  PetscFunctionBegin;
  PetscCall(SnapshotsWrite(&flow, PETSC_FALSE, run->snapshots));
  PetscCall(RunIsOver(run, &over));
  while (!over) {
    PetscCall(ClockChoose(run->scene, run->scheme->stats.speed_max, clock));
    PetscCall(run->scheme->row->Step(run->scene, clock, run->particles, run->neighbors, run->ops,
                                     run->scheme));
    if (clock->step == 1) PetscCall(OptionsRefuseUnknown(PETSC_TRUE));
    PetscCall(RunIsOver(run, &over));
    if (!over && clock->next_report < clock->n_reports &&
        clock->t >= clock->report_time[clock->next_report] * (1.0 - 1e-12)) {
      run->report->t = clock->t;
      PetscCall(run->scene->problem->Judge(&flow, run->report));
      clock->next_report++;
    }
    PetscCall(SnapshotsWrite(&flow, over, run->snapshots));
    PetscCall(ProgressUpdate(&flow, over, run->progress));
  }
  if (clock->step == 0) PetscCall(OptionsRefuseUnknown(PETSC_TRUE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The matrices of the last solves, where asked for. */
static PetscErrorCode RunWriteMatrices(const Run *run)
{
  const Scheme *scheme = run->scheme;

  PetscFunctionBegin;
  PetscCall(MatrixFileWrite(run->particles, scheme->visc ? ViscosityMatrix(scheme->visc) : NULL,
                            run->visc_matrix));
  PetscCall(MatrixFileWrite(run->particles, run->ops->ppe.A, run->ppe_matrix));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Errors beside what they cost: on the screen, in the CSV file, and against -check_ tolerances. */
static PetscErrorCode RunReport(Run *run)
{
  const Flow     flow = RunFlow(run);
  PetscLogDouble now;

  PetscFunctionBegin;
  PetscCall(PetscTime(&now));
  run->report->t = run->clock->t;
  PetscCall(run->scene->problem->Judge(&flow, run->report));
  PetscCall(ReportView(run->report, now - run->started, PETSC_VIEWER_STDOUT_WORLD));
  PetscCall(ReportWrite(&flow, run->report, now - run->started, "ok"));
  PetscCall(ReportCheck(run->report));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A run that ended without its flow tells in the file of reports what happened. */
static PetscErrorCode RunReportFailure(Run *run)
{
  const Flow     flow = RunFlow(run);
  PetscLogDouble now;

  PetscFunctionBegin;
  PetscCall(PetscTime(&now));
  run->report->t = run->clock->t;
  PetscCall(RunWriteMatrices(run));
  PetscCall(ReportWrite(&flow, run->report, now - run->started, "diverged"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A flow, from its scene to its report. */
static PetscErrorCode SolveFlow(Run *run)
{
  PetscBool wants_help;

  PetscFunctionBegin;
  PetscCall(RunCreate(run));
  PetscCall(OptionGiven("-help", &wants_help));
  if (!wants_help) {
    const Flow     flow = RunFlow(run);
    PetscErrorCode failed;

    PetscCall(BannerView(&flow, PETSC_VIEWER_STDOUT_WORLD));
    failed = RunSolve(run);
    if (failed == PETSC_ERR_NOT_CONVERGED || failed == PETSC_ERR_FP)
      PetscCall(RunReportFailure(run));
    PetscCall(failed);
    PetscCall(RunWriteMatrices(run));
    PetscCall(RunReport(run));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Solve(void)
{
  Run run = {0};

  PetscFunctionBegin;
  PetscCall(PetscTime(&run.started));
  PetscCall(SceneCreate(&run.scene));
  if (run.scene->problem->patch) PetscCall(PatchRun(run.scene));
  else PetscCall(SolveFlow(&run));
  PetscCall(RunDestroy(&run));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SolveOrList(void)
{
  PetscBool catalogue;

  PetscFunctionBegin;
  PetscCall(ErrorsInstall());
  PetscCall(OptionGiven("-catalogue", &catalogue));
  if (catalogue) PetscCall(CatalogueView(PETSC_VIEWER_STDOUT_WORLD));
  else PetscCall(Solve());
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  What PETSc would pass over or meet with a traceback: a stray word, an unreadable options file.
  Returns the sentence, or an empty one.
*/
static void CheckArguments(int argc, char **argv, char sentence[], size_t length)
{
  sentence[0] = '\0';
  for (int k = 1; k < argc && !sentence[0]; k++) {
    const PetscBool word = argv[k][0] != '-' ? PETSC_TRUE : PETSC_FALSE;

    if (word && (k == 1 || argv[k - 1][0] != '-')) {
      (void)snprintf(sentence, length,
                     "%s: a stray word; options begin with a dash, e.g. -case cavity", argv[k]);
    } else if (word && strcmp(argv[k - 1], "-options_file") == 0) {
      FILE *file = fopen(argv[k], "r");

      if (file) (void)fclose(file);
      else (void)snprintf(sentence, length, "-options_file %s: %s", argv[k], strerror(errno));
    }
  }
}

int main(int argc, char **argv)
{
  char           sentence[PETSC_MAX_PATH_LEN + 128];
  int            rank;
  PetscErrorCode failed;

  if (MPI_Init(&argc, &argv)) return 1;
  (void)MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  CheckArguments(argc, argv, sentence, sizeof(sentence));
  if (sentence[0]) {
    if (rank == 0) (void)fprintf(stderr, "isph: %s\n", sentence);
    (void)MPI_Finalize();
    return 1;
  }
  failed = PetscInitialize(&argc, &argv, NULL, help);
  if (failed) return (int)failed;
  failed = SolveOrList();
  if (failed) return ErrorsExit(failed);
  failed = PetscFinalize();
  (void)MPI_Finalize();
  return (int)failed;
}
