/* The CSV file of -report, to which each run appends a row for each quantity and time. Studies make
   many runs with the same file, and evaluate it with a table program. */
#include "isph/solvers.h"
#include "isph/io.h"
#include <sys/resource.h>

static const char ReportHeader[] =
    "case,dim,reynolds,scheme,projection,motion,physics,visc_laplacian,ppe_laplacian,gradient,"
    "correction,visc_ts,visc_ksp,visc_pc,ppe_ksp,ppe_pc,kernel,h_over_dx,wall,shift,jitter,seed,n,"
    "particles,ranks,dt,steps,t,wall_s,cpu_s,us_per_particle_step,visc_its,ppe_its,rss_mb,status,"
    "quantity,value,reference,error\n";

/* Part of a row: the columns before t, which are equal in all rows, or the columns after t. */
typedef struct {
  char text[1024];
} Columns;

static void ColumnWord(Columns *columns, const char word[])
{
  if (word) TextAppend(columns->text, sizeof(columns->text), word);
  TextAppend(columns->text, sizeof(columns->text), ",");
}

/* Appends a number; NaN, for "not applicable", gives an empty column. */
static void ColumnNumber(Columns *columns, PetscReal number)
{
  char word[32] = "";

  if (!PetscIsNanReal(number)) {
    (void)snprintf(word, sizeof(word), "%.10g", (double)number);
  }
  ColumnWord(columns, word);
}

/* Appends a measured number with all digits. */
static void ColumnExact(Columns *columns, PetscReal number)
{
  char word[32] = "";

  if (!PetscIsNanReal(number)) (void)snprintf(word, sizeof(word), "%.17g", (double)number);
  ColumnWord(columns, word);
}

/* Appends the active physics, joined by '+'. */
static void ColumnPhysics(Columns *columns, const Scene *scene)
{
  char word[128] = "";

  for (PetscInt k = 0; k < PHYSICS_COUNT; k++) {
    if (!SceneHas(scene, (Physics)(1u << k))) continue;
    if (word[0]) TextAppend(word, sizeof(word), "+");
    TextAppend(word, sizeof(word), PhysicsNames[k]);
  }
  ColumnWord(columns, word);
}

/* Appends the wall treatment, with '+surface' for a layer of particles on walls. */
static void ColumnWall(Columns *columns, const Operators *ops)
{
  char word[128] = "";

  if (ops->forms.wall) {
    (void)snprintf(word, sizeof(word), "%s%s", ops->forms.wall->name,
                   ops->forms.wall_surface ? "+surface" : "");
  }
  ColumnWord(columns, word);
}

/* Returns the linear solve that fills a column, NULL if the run has none. */
static const LinearSolve *FindSolve(const Flow *flow, SolveColumn column)
{
  for (PetscInt k = 0; flow->scheme && k < flow->scheme->n_solves; k++) {
    if (flow->scheme->solve[k]->column == column) return flow->scheme->solve[k];
  }
  return NULL;
}

/* Appends the types of a KSP and its preconditioner; without a solve two empty columns. */
static PetscErrorCode ColumnsSolver(Columns *columns, const LinearSolve *solve)
{
  const char *ksp = NULL, *pc = NULL;

  PetscFunctionBegin;
  if (solve && solve->ksp) PetscCall(SolverNames(solve->ksp, &ksp, &pc));
  ColumnWord(columns, ksp);
  ColumnWord(columns, pc);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Appends the columns from visc_laplacian up to ppe_pc; the column of a form or solver that the run
   does not have is empty. */
static PetscErrorCode ColumnsForms(const Flow *flow, Columns *columns)
{
  const OperatorForms *forms    = &flow->ops->forms;
  const LinearSolve   *velocity = FindSolve(flow, SOLVE_VELOCITY);

  PetscFunctionBegin;
  ColumnWord(columns, forms->visc.row ? forms->visc.row->name : NULL);
  ColumnWord(columns, forms->ppe.row ? forms->ppe.row->name : NULL);
  ColumnWord(columns, FlowGradient(flow) ? FlowGradient(flow)->name : NULL);
  ColumnWord(columns, OperatorsCorrection(flow->ops));
  ColumnWord(columns, velocity ? velocity->integrator : NULL);
  PetscCall(ColumnsSolver(columns, velocity));
  PetscCall(ColumnsSolver(columns, FindSolve(flow, SOLVE_PRESSURE)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Appends the name of a table row, or an empty column. */
static void ColumnRow(Columns *columns, const void *row)
{
  ColumnWord(columns, row ? ((const TableRow *)row)->name : NULL);
}

/* Fills `columns` with the columns from case up to steps. */
static PetscErrorCode ColumnsBeforeTime(const Flow *flow, Columns *columns)
{
  const Scene  *scene  = flow->scene;
  const Scheme *scheme = flow->scheme;
  PetscMPIInt   ranks;

  PetscFunctionBegin;
  columns->text[0] = '\0';
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &ranks));
  ColumnWord(columns, scene->problem->name);
  ColumnNumber(columns, scene->dim);
  ColumnNumber(columns, scheme ? SceneReynolds(scene) : NAN);
  ColumnRow(columns, scheme ? scheme->row : NULL);
  ColumnRow(columns, scheme ? scheme->variant : NULL);
  ColumnRow(columns, scheme ? scene->motion : NULL);
  ColumnPhysics(columns, scene);
  PetscCall(ColumnsForms(flow, columns));
  ColumnWord(columns, flow->ops->forms.kernel->name);
  ColumnNumber(columns, flow->ops->forms.h_over_dx);
  ColumnWall(columns, flow->ops);
  ColumnRow(columns, flow->state ? flow->state->shift : NULL);
  ColumnNumber(columns, scene->jitter);
  ColumnNumber(columns, scene->seed);
  ColumnNumber(columns, scene->n);
  ColumnNumber(columns, flow->particles->N_fluid);
  ColumnNumber(columns, ranks);
  ColumnNumber(columns, flow->clock ? flow->clock->dt : NAN);
  ColumnNumber(columns, flow->clock ? flow->clock->step : NAN);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscReal Seconds(struct timeval time)
{
  return (PetscReal)time.tv_sec + 1e-6 * (PetscReal)time.tv_usec;
}

/* Fills `columns` with the columns from wall_s up to status, the last. Collective: cpu_s is the sum
   over all ranks, user and system, rss_mb their largest value. */
static PetscErrorCode ColumnsAfterTime(const Flow *flow, PetscReal wall_seconds,
                                       const char status[], Columns *columns)
{
  const LinearSolve *velocity = FindSolve(flow, SOLVE_VELOCITY);
  const LinearSolve *pressure = FindSolve(flow, SOLVE_PRESSURE);
  const PetscReal    steps    = flow->clock ? flow->clock->step : 0.0;
  const PetscReal    work =
      flow->clock ? (steps - flow->clock->step_first) * flow->particles->N_fluid : 0.0;
  PetscReal     rss_mb, cpu_s, visc_its = NAN, ppe_its = NAN;
  struct rusage usage;

  PetscFunctionBegin;
  columns->text[0] = '\0';
  PetscCheck(getrusage(RUSAGE_SELF, &usage) == 0, PETSC_COMM_SELF, PETSC_ERR_SYS, "getrusage()");
  rss_mb = (PetscReal)usage.ru_maxrss / 1024.0;
  cpu_s  = Seconds(usage.ru_utime) + Seconds(usage.ru_stime);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &rss_mb, 1, MPIU_REAL, MPIU_MAX, PETSC_COMM_WORLD));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &cpu_s, 1, MPIU_REAL, MPIU_SUM, PETSC_COMM_WORLD));
  if (steps > 0.0 && velocity) visc_its = velocity->iterations_sum / steps;
  if (steps > 0.0 && pressure) ppe_its = pressure->iterations_sum / steps;
  ColumnNumber(columns, wall_seconds);
  ColumnNumber(columns, cpu_s);
  ColumnNumber(columns, work > 0.0 ? 1e6 * wall_seconds / work : NAN);
  ColumnNumber(columns, visc_its);
  ColumnNumber(columns, ppe_its);
  ColumnNumber(columns, rss_mb);
  ColumnWord(columns, status);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Appends text to the file. Output: failed - reason of a failure, or NULL. */
static PetscErrorCode ReportAppendFile(const char path[], const char text[], const char **failed)
{
  FILE *stream;
  long  size;
  int   status;

  PetscFunctionBegin;
  *failed = NULL;
  stream  = FileOpen(path, "a");
  if (!stream) {
    *failed = "cannot be written";
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  status = fseek(stream, 0, SEEK_END);
  size   = ftell(stream);
  if (!status && !size) status = fputs(ReportHeader, stream) < 0;
  if (!status && text[0]) status = fputs(text, stream) < 0;
  if (fclose(stream) || status) *failed = "cannot be written completely";
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Compares the columns of an existing file with the columns that this program writes. */
static PetscErrorCode ReportFileIsOurs(const char path[], const char **failed)
{
  char      line[sizeof(ReportHeader)] = "";
  FILE     *stream                     = FileOpen(path, "r");
  PetscBool same;

  PetscFunctionBegin;
  *failed = NULL;
  if (!stream) PetscFunctionReturn(PETSC_SUCCESS);
  if (fgets(line, (int)sizeof(line), stream)) {
    PetscCall(PetscStrcmp(line, ReportHeader, &same));
    if (!same) *failed = "is no report file, or has other columns";
  }
  (void)fclose(stream);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Ends the run on all ranks if the first rank could not write the file. */
static PetscErrorCode ReportFileVerdict(const char path[], const char failed[])
{
  char sentence[64] = "";

  PetscFunctionBegin;
  if (failed) PetscCall(PetscStrncpy(sentence, failed, sizeof(sentence)));
  PetscCallMPI(MPI_Bcast(sentence, (PetscMPIInt)sizeof(sentence), MPI_CHAR, 0, PETSC_COMM_WORLD));
  PetscCheck(!sentence[0], PETSC_COMM_WORLD, PETSC_ERR_FILE_OPEN, "-report %s: the file %s", path,
             sentence);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ReportFileCheck - Ends the run at its start if its report could not be written; collective on
   PETSC_COMM_WORLD. A new file gets its header. */
PetscErrorCode ReportFileCheck(const char path[])
{
  PetscMPIInt rank;
  const char *failed = NULL;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  if (rank == 0) PetscCall(ReportFileIsOurs(path, &failed));
  if (rank == 0 && !failed) PetscCall(ReportAppendFile(path, "", &failed));
  PetscCall(ReportFileVerdict(path, failed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ReportWrite - Appends the run to the CSV file of -report, a row for each quantity and time;
   without the option it does nothing. Collective on PETSC_COMM_WORLD; the first rank writes. Input:
   flow - the present flow; report - if empty, as after a diverged run, a row without quantity is
   written; wall_seconds - duration of the run so far, set-up included [s]; status - ok, diverged or
   interrupted. Notes: the column particles counts fluid particles; visc_its and ppe_its are means
   per step; for the coupled scheme the columns visc_ts, visc_ksp, visc_pc and visc_its describe the
   coupled solve. */
PetscErrorCode ReportWrite(const Flow *flow, const Report *report, PetscReal wall_seconds,
                           const char status[])
{
  const char    *path = report->file;
  const PetscInt rows = PetscMax(1, report->n);
  const size_t   room = (size_t)rows * (2 * sizeof(Columns) + 256);
  Columns        before, after;
  PetscMPIInt    rank;
  const char    *failed = NULL;
  char          *text, row[2 * sizeof(Columns) + 256];

  PetscFunctionBegin;
  if (!path[0]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  PetscCall(ColumnsBeforeTime(flow, &before));
  PetscCall(ColumnsAfterTime(flow, wall_seconds, status, &after));
  PetscCall(PetscCalloc1(room, &text));
  for (PetscInt k = 0; k < rows; k++) {
    const Quantity none = {
        .name = "", .t = report->t, .value = NAN, .reference = NAN, .error = NAN};
    const Quantity *q    = report->n ? &report->quantity[k] : &none;
    Columns         time = {""}, numbers = {""};

    ColumnNumber(&time, q->t);
    ColumnExact(&numbers, q->value);
    ColumnNumber(&numbers, q->reference);
    ColumnExact(&numbers, q->error);
    PetscCall(PetscSNPrintf(row, sizeof(row), "%s%s%s%s,%s", before.text, time.text, after.text,
                            q->name, numbers.text));
    row[strlen(row) - 1] = '\n'; /* in place of the last comma */
    TextAppend(text, room, row);
  }
  if (rank == 0) PetscCall(ReportFileIsOurs(path, &failed));
  if (rank == 0 && !failed) PetscCall(ReportAppendFile(path, text, &failed));
  PetscCall(PetscFree(text));
  PetscCall(ReportFileVerdict(path, failed));
  PetscFunctionReturn(PETSC_SUCCESS);
}
