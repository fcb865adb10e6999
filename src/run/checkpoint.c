/*
  Checkpoints: all that a run needs to go on as if it had not stopped, in one HDF5 file, written under
  another name and renamed when it is complete. Writing one starts an epoch in the run itself, so that
  the run and one restarted from the file are alike to the last bit on as many ranks.
*/
#include "impl.h"
#include "isph/hdf5file.h"
#include <string.h>

#define CHECKPOINT_FORMAT 1 /* to be raised when what is in the file changes */
#define CLOCK_NUMBERS     9
#define STATS_NUMBERS     12

struct Checkpoints {
  char      path[PETSC_MAX_PATH_LEN];    /* empty: none are written */
  char      restart[PETSC_MAX_PATH_LEN]; /* empty: the run starts from the beginning */
  PetscReal every;                       /* between checkpoints; 0: at the end only [s] */
  PetscReal last;                        /* time of the last one, or of the start [s] */
  PetscInt  step;                        /* of the last one; -1: none */
};

/*
  CheckpointsCreate - Reads what is to be written and restarted from

  Collective on PETSC_COMM_WORLD.

  Options Database Keys:
+ -checkpoint file.h5 - written at the end, on SIGTERM and SIGINT, and
. -checkpoint_every T - at every multiple of T [s]
- -restart file.h5    - go on from there, on any number of ranks

  Errors: a place that cannot be written ends the run
*/
PetscErrorCode CheckpointsCreate(Checkpoints **checkpoints)
{
  Checkpoints *c;
  PetscBool    every, good;
  char         part[PETSC_MAX_PATH_LEN];

  PetscFunctionBegin;
  PetscCall(PetscNew(&c));
  c->step = -1;
  PetscOptionsBegin(PETSC_COMM_WORLD, NULL, "Checkpoints", "");
  PetscCall(OptionFile("-checkpoint", "File to restart from later", c->path));
  PetscCall(OptionReal("-checkpoint_every",
                       "Time between checkpoints; by default one at the end or a signal [s]",
                       1e-300, 1e300, &c->every, &every));
  PetscCall(OptionFile("-restart", "Checkpoint to go on from", c->restart));
  PetscOptionsEnd();
  UserCheck(!every || c->path[0], "-checkpoint_every: there is no -checkpoint");
  if (c->path[0]) {
    PetscCall(PetscSNPrintf(part, sizeof(part), "%s.part", c->path));
    PetscCall(FileReserve(part, 1, &good));
    PetscCheck(good, PETSC_COMM_WORLD, PETSC_ERR_FILE_OPEN, "-checkpoint %s: cannot write there",
               c->path);
  }
  *checkpoints = c;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CheckpointsDestroy(Checkpoints **checkpoints)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(*checkpoints));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Numbers of clock and scheme, to the file or from it. */
static void PackNumbers(const Run *run, double clock[], double stats[])
{
  const Clock     *c           = run->clock;
  const Scheme    *scheme      = run->scheme;
  const StepStats *s           = &scheme->stats;
  const double     c_numbers[] = {c->t,       c->dt,  c->dt_previous, c->step, c->next_report,
                                  c->retries, c->cut, c->patience,    c->good};
  const double     s_numbers[] = {s->speed_max,
                                  s->kinetic_energy,
                                  s->divergence,
                                  s->change[0],
                                  s->change[1],
                                  s->change[2],
                                  s->visc_its,
                                  s->ppe_its,
                                  s->visc_its_sum,
                                  s->ppe_its_sum,
                              scheme->visc ? *ViscosityFalls(scheme->visc) : 0,
                              scheme->ppe ? *PressureFalls(scheme->ppe) : 0};

  for (PetscInt k = 0; k < CLOCK_NUMBERS; k++) clock[k] = c_numbers[k];
  for (PetscInt k = 0; k < STATS_NUMBERS; k++) stats[k] = s_numbers[k];
}

static void UnpackNumbers(const double clock[], const double stats[], Run *run)
{
  Clock     *c      = run->clock;
  Scheme    *scheme = run->scheme;
  StepStats *s      = &scheme->stats;

  c->t           = clock[0];
  c->dt          = clock[1];
  c->dt_previous = clock[2];
  c->step        = (PetscInt)clock[3];
  c->next_report = PetscMin((PetscInt)clock[4], c->n_reports);
  c->retries     = (PetscInt)clock[5];
  c->cut         = (PetscInt)clock[6];
  c->patience    = (PetscInt)clock[7];
  c->good        = (PetscInt)clock[8];

  s->speed_max      = stats[0];
  s->kinetic_energy = stats[1];
  s->divergence     = stats[2];
  for (PetscInt k = 0; k < 3; k++) s->change[k] = stats[3 + k];
  s->visc_its     = (PetscInt)stats[6];
  s->ppe_its      = (PetscInt)stats[7];
  s->visc_its_sum = (PetscInt)stats[8];
  s->ppe_its_sum  = (PetscInt)stats[9];
  if (scheme->visc) *ViscosityFalls(scheme->visc) = (PetscInt)stats[10];
  if (scheme->ppe) *PressureFalls(scheme->ppe) = (PetscInt)stats[11];
}

/* The names of a record's numbers, "id,x:2,u:2,p:1": a file fits a run that has the same. */
static PetscErrorCode RecordNames(const Particles *p, char names[], size_t length)
{
  PetscFunctionBegin;
  PetscCall(PetscStrncpy(names, "id", length));
  for (PetscInt f = 0; f < p->n_fields; f++) {
    char part[64];

    PetscCall(PetscSNPrintf(part, sizeof(part), ",%s:%" PetscInt_FMT, p->field[f].name,
                            p->field[f].components));
    PetscCall(PetscStrlcat(names, part, length));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A sum over all records that any changed bit changes, whichever rank holds them. Collective. */
static PetscErrorCode Checksum(PetscInt n, PetscInt width, const PetscReal record[], uint64_t *sum)
{
  PetscFunctionBegin;
  *sum = 0;
  for (PetscInt i = 0; i < n; i++) {
    uint64_t hash = 14695981039346656037u; /* FNV-1a by words */

    for (PetscInt k = 0; k < width; k++) {
      uint64_t bits;

      PetscCall(PetscMemcpy(&bits, &record[(size_t)i * width + k], sizeof(bits)));
      hash = (hash ^ bits) * 1099511628211u;
      hash ^= hash >> 29;
    }
    *sum += hash;
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 1, MPI_UINT64_T, MPI_SUM, PETSC_COMM_WORLD));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A small table of numbers, the same on all ranks; the first one writes. */
static PetscErrorCode WriteTable(Hdf5File *file, const char name[], PetscInt rows, PetscInt columns,
                                 const double values[])
{
  PetscMPIInt rank;

  PetscFunctionBegin;
  if (!rows) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Comm_rank(file->comm, &rank));
  file->start = 0;
  file->own   = rank == 0 ? rows : 0;
  file->N     = rows;
  PetscCall(Hdf5WriteRows(file, name, columns, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, values, "SI"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads a table whole on all ranks; other than `rows` rows (if not negative) count as damage. */
static PetscErrorCode ReadTable(Hdf5File *file, const char name[], PetscInt rows, PetscInt columns,
                                PetscReal **values)
{
  PetscInt N, width;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(PetscMax(rows * columns, 1), values));
  if (!rows) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Hdf5CountRows(file, name, &N, &width));
  if (N != rows || width != columns) file->failed = PETSC_TRUE;
  if (file->failed) PetscFunctionReturn(PETSC_SUCCESS);
  file->start = 0;
  file->own = file->N = rows;
  PetscCall(Hdf5ReadRows(file, name, columns, H5T_NATIVE_DOUBLE, *values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What has been reported and written so far. */
static PetscErrorCode WriteHistory(const Run *run, Hdf5File *file)
{
  const Report *report   = run->report;
  const int     n_report = (int)report->n, n_snapshots = (int)SnapshotsCount(run->snapshots);
  PetscReal    *rows;
  char         *names;

  PetscFunctionBegin;
  PetscCall(PetscCalloc2(4 * n_report + 3 * n_snapshots + 1, &rows, 33 * n_report + 1, &names));
  for (PetscInt k = 0; k < n_report; k++) {
    const Quantity *q = &report->quantity[k];

    rows[4 * k]     = q->t;
    rows[4 * k + 1] = q->value;
    rows[4 * k + 2] = q->reference;
    rows[4 * k + 3] = q->error;
    PetscCall(PetscStrlcat(names, q->name, (size_t)(33 * n_report + 1)));
    PetscCall(PetscStrlcat(names, ",", (size_t)(33 * n_report + 1)));
  }
  PetscCall(Hdf5WriteNumber(file, "n_report", H5T_NATIVE_INT, &n_report));
  PetscCall(Hdf5WriteText(file, file->file, "report_names", names));
  PetscCall(WriteTable(file, "report", n_report, 4, rows));
  SnapshotsGet(run->snapshots, &rows[4 * n_report]);
  PetscCall(Hdf5WriteNumber(file, "n_snapshots", H5T_NATIVE_INT, &n_snapshots));
  PetscCall(WriteTable(file, "snapshots", n_snapshots, 3, &rows[4 * n_report]));
  PetscCall(PetscFree2(rows, names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Everything but the particles. */
static PetscErrorCode WriteState(const Run *run, uint64_t checksum, Hdf5File *file)
{
  const Particles *p      = run->particles;
  const int        format = CHECKPOINT_FORMAT, dim = (int)p->dim, N_fluid = (int)p->N_fluid,
            N_wall = (int)p->N_wall;
  double clock[CLOCK_NUMBERS], stats[STATS_NUMBERS];
  char   names[512];

  PetscFunctionBegin;
  PetscCall(RecordNames(p, names, sizeof(names)));
  PetscCall(Hdf5WriteNumber(file, "format", H5T_NATIVE_INT, &format));
  PetscCall(Hdf5WriteText(file, file->file, "version", ISPH_VERSION));
  PetscCall(Hdf5WriteText(file, file->file, "case", run->scene->problem->name));
  PetscCall(Hdf5WriteNumber(file, "dim", H5T_NATIVE_INT, &dim));
  PetscCall(Hdf5WriteNumber(file, "fluid", H5T_NATIVE_INT, &N_fluid));
  PetscCall(Hdf5WriteNumber(file, "walls", H5T_NATIVE_INT, &N_wall));
  PetscCall(Hdf5WriteText(file, file->file, "record", names));
  PetscCall(Hdf5WriteNumber(file, "checksum", H5T_NATIVE_UINT64, &checksum));
  PackNumbers(run, clock, stats);
  PetscCall(WriteTable(file, "clock", 1, CLOCK_NUMBERS, clock));
  PetscCall(WriteTable(file, "stats", 1, STATS_NUMBERS, stats));
  PetscCall(WriteTable(file, "number", 1, SCHEME_NUMBERS, run->scheme->number));
  PetscCall(WriteHistory(run, file));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The file, complete or absent. */
static PetscErrorCode WriteFile(const Run *run, const PetscReal record[], const char path[])
{
  const Particles *p   = run->particles;
  const PetscInt   own = ParticlesOwn(p), width = ParticlesRecordWidth(p);
  const size_t     bytes = (size_t)(p->N_fluid + p->N_wall) * (size_t)width * 8 + (size_t)262144;
  char             part[PETSC_MAX_PATH_LEN];
  PetscMPIInt      rank;
  PetscInt         agreed;
  PetscBool        good;
  Hdf5File         file;
  uint64_t         checksum;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  PetscCall(PetscSNPrintf(part, sizeof(part), "%s.part", path));
  PetscCall(Checksum(own, width, record, &checksum));
  PetscCall(FileReserve(part, bytes, &good));
  if (good) {
    PetscCall(Hdf5FileCreate(PETSC_COMM_WORLD, part, &file));
    if (file.file >= 0) {
      PetscCall(WriteState(run, checksum, &file));
      file.start = p->fluid_start + p->wall_start;
      file.own   = own;
      file.N     = p->N_fluid + p->N_wall;
      PetscCall(Hdf5WriteRows(&file, "particles", width, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, record,
                              "SI, the numbers that the attribute record names"));
    }
    PetscCall(Hdf5FileClose(&file, &good));
    if (rank == 0 && !good) (void)remove(part);
    if (rank == 0 && good && rename(part, path)) good = PETSC_FALSE;
  }
  agreed = good ? 1 : 0;
  PetscCallMPI(MPI_Bcast(&agreed, 1, MPIU_INT, 0, PETSC_COMM_WORLD));
  PetscCheck(agreed, PETSC_COMM_WORLD, PETSC_ERR_FILE_OPEN,
             "-checkpoint %s: cannot be written, or the disk is full; an earlier one is as it was",
             path);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  CheckpointsUpdate - Writes a checkpoint where one is due

  Collective on PETSC_COMM_WORLD. Called after every step and, with final, at the end and on a signal.

  Notes: an epoch starts and everything is made anew from the fields, as in a run that restarts

  Errors: a file that cannot be written ends the run; the one before stays
*/
PetscErrorCode CheckpointsUpdate(PetscBool final, Run *run)
{
  Checkpoints *c     = run->checkpoints;
  const Clock *clock = run->clock;
  PetscReal   *record;
  PetscInt     n;

  PetscFunctionBegin;
  if (!c->path[0] || c->step == clock->step) PetscFunctionReturn(PETSC_SUCCESS);
  if (!final) {
    if (c->every == 0.0) PetscFunctionReturn(PETSC_SUCCESS);
    /* the multiples of -checkpoint_every passed by now against by then; 1e-9 for rounding */
    if (!(PetscFloorReal(clock->t / c->every + 1e-9) > PetscFloorReal(c->last / c->every + 1e-9)))
      PetscFunctionReturn(PETSC_SUCCESS);
  }
  n = ParticlesOwn(run->particles);
  PetscCall(PetscMalloc1((size_t)n * ParticlesRecordWidth(run->particles), &record));
  PetscCall(ParticlesPack(run->particles, record));
  PetscCall(WriteFile(run, record, c->path));
  c->last = clock->t;
  c->step = clock->step;
  if (!final) {
    PetscCall(ParticlesReplace(run->scene, run->particles, n, record));
    PetscCall(run->scheme->row->Begin(run->scene, clock, run->particles, run->neighbors, run->ops,
                                      run->scheme));
  }
  PetscCall(PetscFree(record));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Ends the run with the reason why a file does not fit it. Collective. */
static PetscErrorCode RestartRefuse(const Run *run, const char path[], Hdf5File *file)
{
  int       format = 0, dim = 0, N_fluid = 0, N_wall = 0;
  char      version[64], problem[64], names[512], wanted[512];
  PetscBool same;

  PetscFunctionBegin;
  PetscCall(Hdf5ReadNumber(file, "format", H5T_NATIVE_INT, &format));
  UserCheck(!file->failed, "-restart %s: is no checkpoint of isph, or a damaged one", path);
  PetscCall(Hdf5ReadText(file, "version", version, sizeof(version)));
  PetscCall(Hdf5ReadText(file, "case", problem, sizeof(problem)));
  PetscCall(Hdf5ReadText(file, "record", names, sizeof(names)));
  PetscCall(Hdf5ReadNumber(file, "dim", H5T_NATIVE_INT, &dim));
  PetscCall(Hdf5ReadNumber(file, "fluid", H5T_NATIVE_INT, &N_fluid));
  PetscCall(Hdf5ReadNumber(file, "walls", H5T_NATIVE_INT, &N_wall));
  PetscCall(PetscStrcmp(version, ISPH_VERSION, &same));
  UserCheck(same && format == CHECKPOINT_FORMAT,
            "-restart %s: the file is of isph %s (format %d), this is %s (format %d)", path,
            version, format, ISPH_VERSION, CHECKPOINT_FORMAT);
  PetscCall(PetscStrcmp(problem, run->scene->problem->name, &same));
  UserCheck(same, "-restart %s: the file is of case %s, this run is of case %s", path, problem,
            run->scene->problem->name);
  UserCheck(dim == run->particles->dim && N_fluid == run->particles->N_fluid &&
                N_wall == run->particles->N_wall,
            "-restart %s: the file has %d + %d particles in %dD, this run %" PetscInt_FMT
            " + %" PetscInt_FMT " in %" PetscInt_FMT "D; use the same -n, -dim and -wall",
            path, N_fluid, N_wall, dim, run->particles->N_fluid, run->particles->N_wall,
            run->particles->dim);
  PetscCall(RecordNames(run->particles, wanted, sizeof(wanted)));
  PetscCall(PetscStrcmp(names, wanted, &same));
  UserCheck(same,
            "-restart %s: the file holds %s, this run needs %s; use the same physics and -motion",
            path, names, wanted);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What was reported and written before. */
static PetscErrorCode ReadHistory(Run *run, Hdf5File *file)
{
  int        n_report = 0, n_snapshots = 0;
  PetscReal *report, *snapshots;
  char      *names, *name;

  PetscFunctionBegin;
  PetscCall(Hdf5ReadNumber(file, "n_report", H5T_NATIVE_INT, &n_report));
  PetscCall(Hdf5ReadNumber(file, "n_snapshots", H5T_NATIVE_INT, &n_snapshots));
  PetscCall(PetscCalloc1((size_t)(33 * n_report + 2), &names));
  PetscCall(Hdf5ReadText(file, "report_names", names, (size_t)(33 * n_report + 2)));
  PetscCall(ReadTable(file, "report", n_report, 4, &report));
  PetscCall(ReadTable(file, "snapshots", n_snapshots, 3, &snapshots));
  name = names;
  for (PetscInt k = 0; k < n_report && !file->failed; k++) {
    char *comma = strchr(name, ',');

    if (comma) *comma = '\0';
    PetscCall(ReportRestore(run->report, name, &report[4 * k]));
    name = comma ? comma + 1 : name;
  }
  if (!file->failed)
    PetscCall(SnapshotsSet(run->snapshots, n_snapshots, snapshots, run->clock->step));
  PetscCall(PetscFree(report));
  PetscCall(PetscFree(snapshots));
  PetscCall(PetscFree(names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Clock, scheme, history and this rank's share of the records. */
static PetscErrorCode ReadFile(Run *run, Hdf5File *file, PetscInt *n, PetscReal **record,
                               PetscBool *whole)
{
  const Particles *p     = run->particles;
  const PetscInt   width = ParticlesRecordWidth(p), N = p->N_fluid + p->N_wall;
  PetscReal       *clock, *stats, *number;
  PetscMPIInt      rank, ranks;
  PetscInt         rows, columns;
  uint64_t         wanted = 0, checksum;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &ranks));
  PetscCall(ReadTable(file, "clock", 1, CLOCK_NUMBERS, &clock));
  PetscCall(ReadTable(file, "stats", 1, STATS_NUMBERS, &stats));
  PetscCall(ReadTable(file, "number", 1, SCHEME_NUMBERS, &number));
  UnpackNumbers(clock, stats, run);
  PetscCall(PetscArraycpy(run->scheme->number, number, SCHEME_NUMBERS));
  PetscCall(PetscFree(clock));
  PetscCall(PetscFree(stats));
  PetscCall(PetscFree(number));
  PetscCall(ReadHistory(run, file));
  PetscCall(Hdf5ReadNumber(file, "checksum", H5T_NATIVE_UINT64, &wanted));
  PetscCall(Hdf5CountRows(file, "particles", &rows, &columns));
  file->start = (PetscInt)((PetscInt64)N * rank / ranks);
  *n = file->own = (PetscInt)((PetscInt64)N * (rank + 1) / ranks) - file->start;
  PetscCall(PetscCalloc1((size_t)(*n * width + 1), record));
  if (rows != N || columns != width) file->failed = PETSC_TRUE;
  if (!file->failed) PetscCall(Hdf5ReadRows(file, "particles", width, H5T_NATIVE_DOUBLE, *record));
  PetscCall(Checksum(*n, width, *record, &checksum));
  *whole = checksum == wanted ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  CheckpointsRestart - Puts the flow of a checkpoint in the place of the one at the start

  Collective on PETSC_COMM_WORLD. Output: restarted - whether one was given.

  Errors: a file of another case, version or size, and one that is damaged, end the run saying which
*/
PetscErrorCode CheckpointsRestart(Run *run, PetscBool *restarted)
{
  Checkpoints *c    = run->checkpoints;
  const char  *path = c->restart;
  Hdf5File     file;
  PetscReal   *record;
  PetscInt     n;
  PetscBool    good, whole;

  PetscFunctionBegin;
  *restarted = path[0] ? PETSC_TRUE : PETSC_FALSE;
  if (!path[0]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Hdf5FileOpen(PETSC_COMM_WORLD, path, &file));
  PetscCheck(file.file >= 0, PETSC_COMM_WORLD, PETSC_ERR_FILE_OPEN,
             "-restart %s: is absent, no HDF5 file, or a truncated one", path);
  PetscCall(RestartRefuse(run, path, &file));
  PetscCall(ReadFile(run, &file, &n, &record, &whole));
  PetscCall(Hdf5FileClose(&file, &good));
  PetscCheck(good && whole, PETSC_COMM_WORLD, PETSC_ERR_FILE_UNEXPECTED,
             "-restart %s: the file is damaged: %s", path,
             good ? "its checksum does not fit" : "parts of it cannot be read");
  PetscCall(ParticlesReplace(run->scene, run->particles, n, record));
  PetscCall(PetscFree(record));
  PetscCall(run->scheme->row->Begin(run->scene, run->clock, run->particles, run->neighbors,
                                    run->ops, run->scheme));
  c->last = run->clock->t;
  c->step = run->clock->step;
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "restart     %s: t = %.6g, step %" PetscInt_FMT "\n",
                        path, (double)run->clock->t, run->clock->step));
  PetscFunctionReturn(PETSC_SUCCESS);
}
