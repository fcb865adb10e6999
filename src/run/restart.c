/* Restarts a run from the file of checkpoint.c, or refuses the file. The run changes only after the
   whole file is read and verified. */
#include "checkpoint.h"
#include <string.h>

#define NAME_ROOM 33 /* letters of the name of a quantity, with its comma */

/* The contents of a file, as they are stored. */
typedef struct {
  long long  next_id;
  PetscReal *memory;
  int        n_report, n_snapshots;
  PetscReal *report, *snapshots; /* rows of 4 and 3 numbers */
  char      *names;              /* of the rows of the report, "a,b,..." */
  PetscInt   n;                  /* records on this rank */
  PetscReal *record;
  PetscReal *kept;  /* this rank's share of Scheme.kept */
  PetscBool  whole; /* the checksum is right */
} Stored;

/* Reads a table on all ranks and adds it to the checksum. A wrong number of rows or columns, or
   values that are not in the file, mark the file as failed. At least a row is allocated, with zeros
   if the table cannot be read. */
static PetscErrorCode ReadTable(Hdf5File *file, const char name[], PetscInt rows, PetscInt columns,
                                PetscReal **values, uint64_t *sum)
{
  PetscInt  N = 0, width = columns;
  PetscBool full = PETSC_TRUE;

  PetscFunctionBegin;
  if (rows) PetscCall(Hdf5CountRows(file, name, &N, &width));
  if (rows) PetscCall(Hdf5IsFull(file, name, &full));
  if (N != rows || width != columns || !full) file->failed = PETSC_TRUE;
  if (file->failed) rows = 0;
  PetscCall(PetscCalloc1((size_t)PetscMax(rows, 1) * (size_t)columns, values));
  if (!rows) PetscFunctionReturn(PETSC_SUCCESS);
  file->start = 0;
  file->own = file->N = rows;
  PetscCall(Hdf5ReadRows(file, name, columns, H5T_NATIVE_DOUBLE, *values));
  CheckpointSumNumbers(rows * columns, *values, sum);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the first word of a list, "wall,wall,symmetry", and moves next to the rest. */
static const char *NextWord(char **next)
{
  char *word = *next;

  *next += strcspn(word, ",");
  if (**next) *(*next)++ = '\0';
  return word;
}

/* Refuses a file whose run had other kinds of boundaries; SceneShapes() compares bodies. */
static PetscErrorCode CheckKinds(const Scene *scene, const char path[], Hdf5File *file)
{
  const size_t size = (size_t)SceneBoundaries(scene) * KIND_NAME;
  char         name[WALL_NAME], *kinds, *next;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(size, &kinds));
  PetscCall(Hdf5ReadText(file, "boundary_kinds", kinds, size));
  next = file->failed ? kinds + strlen(kinds) : kinds;
  for (PetscInt side = 0; side < SceneBoundaries(scene) && *next; side++) {
    const char *stored = NextWord(&next), *own = scene->boundary[side].kind->name;
    PetscBool   same;

    PetscCall(PetscStrcmp(stored, own, &same));
    SceneWallName(scene, side, name);
    UserCheck(same,
              "-restart %s: %s is of kind %s in the file and %s in this run; use the same -scene_ "
              "options",
              path, name, stored, own);
  }
  PetscCall(PetscFree(kinds));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Ends the run with a message if the file is of another version, case, kinds of boundaries or set
   of particles. Collective. */
static PetscErrorCode RestartRefuse(const Run *run, const char path[], Hdf5File *file)
{
  const Particles *p      = run->flow.particles;
  int              format = 0, dim = 0;
  long long        N_fluid = 0, N_wall = 0;
  char             version[64], problem[64];
  char             names[PARTICLES_MAX_FIELDS * 32], wanted[PARTICLES_MAX_FIELDS * 32];
  PetscBool        same;

  PetscFunctionBegin;
  PetscCall(Hdf5ReadNumber(file, "format", H5T_NATIVE_INT, &format));
  UserCheck(!file->failed, "-restart %s: is no checkpoint of isph, or is damaged", path);
  PetscCall(Hdf5ReadText(file, "version", version, sizeof(version)));
  PetscCall(Hdf5ReadText(file, "case", problem, sizeof(problem)));
  PetscCall(Hdf5ReadText(file, "record", names, sizeof(names)));
  PetscCall(Hdf5ReadNumber(file, "dim", H5T_NATIVE_INT, &dim));
  PetscCall(Hdf5ReadNumber(file, "fluid_at_start", H5T_NATIVE_LLONG, &N_fluid));
  PetscCall(Hdf5ReadNumber(file, "walls_at_start", H5T_NATIVE_LLONG, &N_wall));
  PetscCall(PetscStrcmp(version, ISPH_VERSION, &same));
  UserCheck(same && format == CHECKPOINT_FORMAT,
            "-restart %s: the file is of isph %s (format %d), this is %s (format %d)", path,
            version, format, ISPH_VERSION, CHECKPOINT_FORMAT);
  PetscCall(PetscStrcmp(problem, run->flow.scene->problem->name, &same));
  UserCheck(same, "-restart %s: the file is of case %s, this run is of case %s", path, problem,
            run->flow.scene->problem->name);
  if (dim == p->dim) PetscCall(CheckKinds(run->flow.scene, path, file));
  UserCheck(dim == p->dim && N_fluid == p->N_start[0] && N_wall == p->N_start[1],
            "-restart %s: the file's run began with %lld + %lld particles in %dD, this run "
            "with %" PetscInt_FMT " + %" PetscInt_FMT " in %" PetscInt_FMT
            "D; use the same -n, -dim and -wall",
            path, N_fluid, N_wall, dim, p->N_start[0], p->N_start[1], p->dim);
  PetscCall(CheckpointRecord(p, wanted, sizeof(wanted)));
  PetscCall(PetscStrcmp(names, wanted, &same));
  UserCheck(
      same,
      "-restart %s: its particles have other quantities than those of this run; use the same "
      "physics, -motion, -scheme, -spacing_wall, -wall_surface, -velocity_filter and -dt_adapt",
      path);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Compares the entries of the file that identify its scene with the scene of the run, refuses the
   file if they differ, and adds them to the checksum. */
static PetscErrorCode CheckScene(const Run *run, const char path[], Hdf5File *file, uint64_t *sum)
{
  const Scene      *scene = run->flow.scene;
  const SceneEntry *entry;

  PetscFunctionBegin;
  for (PetscInt k = 0; (entry = CheckpointSceneEntry(k)); k++) {
    const PetscReal most = entry->tolerance * SceneTolerance(scene);
    double          own[SCENE_ENTRY_MAX];
    PetscReal      *stored;
    PetscBool       same = PETSC_TRUE;

    PetscCall(entry->Compute(scene, own));
    PetscCall(ReadTable(file, entry->name, 1, entry->n, &stored, sum));
    for (PetscInt n = 0; n < entry->n; n++)
      same = same && PetscAbsReal(stored[n] - own[n]) <= most ? PETSC_TRUE : PETSC_FALSE;
    PetscCall(PetscFree(stored));
    UserCheck(file->failed || same, "-restart %s: %s", path, entry->refusal);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the report and the list of snapshots of the earlier run, and adds them to the checksum. */
static PetscErrorCode ReadHistory(Hdf5File *file, Stored *stored, uint64_t *sum)
{
  size_t room;

  PetscFunctionBegin;
  PetscCall(Hdf5ReadNumber(file, "n_report", H5T_NATIVE_INT, &stored->n_report));
  PetscCall(Hdf5ReadNumber(file, "n_snapshots", H5T_NATIVE_INT, &stored->n_snapshots));
  PetscCall(ReadTable(file, "report", stored->n_report, 4, &stored->report, sum));
  PetscCall(ReadTable(file, "snapshots", stored->n_snapshots, 3, &stored->snapshots, sum));
  for (PetscInt k = 0; k < stored->n_report && !file->failed; k++)
    if (!(stored->report[4 * k] >= 0.0 && stored->report[4 * k] <= PETSC_MAX_REAL))
      file->failed = PETSC_TRUE; /* the time of a row */
  for (PetscInt k = 0; k < stored->n_snapshots && !file->failed; k++) {
    const PetscReal number = stored->snapshots[3 * k], N = stored->snapshots[3 * k + 2];

    if (!(number >= 0.0 && number <= PETSC_INT_MAX && N >= 0.0 && N <= PETSC_INT_MAX))
      file->failed = PETSC_TRUE;
  }
  room = file->failed ? 2 : NAME_ROOM * (size_t)stored->n_report + 2; /* a damaged file has any */
  PetscCall(PetscCalloc1(room, &stored->names));
  PetscCall(Hdf5ReadText(file, "report_names", stored->names, room));
  CheckpointSumText(stored->names, sum);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the numbers that the run keeps from step to step, and adds them to the checksum; refuses a
   file with other names of numbers. */
static PetscErrorCode ReadMemory(const Memory *memory, const char path[], Hdf5File *file,
                                 Stored *stored, uint64_t *sum)
{
  char      names[MEMORY_MAX * 32], wanted[MEMORY_MAX * 32];
  PetscBool same;

  PetscFunctionBegin;
  PetscCall(Hdf5ReadText(file, "memory_names", names, sizeof(names)));
  CheckpointSumText(names, sum);
  PetscCall(CheckpointMemory(memory, wanted, sizeof(wanted)));
  PetscCall(PetscStrcmp(names, wanted, &same));
  UserCheck(file->failed || same,
            "-restart %s: the file has another scheme or integrator; use the same -scheme", path);
  PetscCall(ReadTable(file, "memory", 1, memory->size, &stored->memory, sum));
  if (!file->failed && !MemoryFits(memory, stored->memory)) file->failed = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads this rank's share of the records of particles, and adds the records to the checksum. */
static PetscErrorCode ReadRecords(const Particles *p, Hdf5File *file, Stored *stored, uint64_t *sum)
{
  const PetscInt width = ParticlesRecordWidth(p);
  PetscInt       rows, columns, last;
  PetscBool      full;

  PetscFunctionBegin;
  PetscCall(Hdf5CountRows(file, "particles", &rows, &columns));
  PetscCall(Hdf5IsFull(file, "particles", &full));
  if (columns != width || !full) file->failed = PETSC_TRUE;
  file->N = file->failed ? 0 : rows;
  ParticlesShare(p->comm, file->N, &file->start, &last);
  stored->n = file->own = last - file->start;
  PetscCall(PetscCalloc1((size_t)stored->n * (size_t)width + 1, &stored->record));
  if (!file->failed)
    PetscCall(Hdf5ReadRows(file, "particles", width, H5T_NATIVE_DOUBLE, stored->record));
  PetscCall(CheckpointSumRecords(stored->n, width, stored->record, sum));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads this rank's share of the state that is not on particles, and adds it to the checksum;
   refuses a file with another amount of it. */
static PetscErrorCode ReadKept(const Scheme *scheme, const char path[], Hdf5File *file,
                               Stored *stored, uint64_t *sum)
{
  long long N    = 0;
  PetscInt  rows = 0, found = 0, columns = 1, last;
  PetscBool full = PETSC_TRUE;

  PetscFunctionBegin;
  if (scheme->kept) PetscCall(VecGetSize(scheme->kept, &rows));
  PetscCall(Hdf5ReadNumber(file, "n_kept", H5T_NATIVE_LLONG, &N));
  UserCheck(file->failed || N == rows,
            "-restart %s: the file has its pressure on other points; use the same "
            "-pressure_points and -pressure_spacing",
            path);
  if (!rows) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Hdf5CountRows(file, "kept", &found, &columns));
  PetscCall(Hdf5IsFull(file, "kept", &full));
  if (found != rows || columns != 1 || !full) file->failed = PETSC_TRUE;
  PetscCall(VecGetOwnershipRange(scheme->kept, &file->start, &last));
  file->own = last - file->start;
  file->N   = rows;
  PetscCall(PetscCalloc1(file->own, &stored->kept));
  if (!file->failed) PetscCall(Hdf5ReadRows(file, "kept", 1, H5T_NATIVE_DOUBLE, stored->kept));
  PetscCall(CheckpointSumKept(file->start, file->own, stored->kept, sum));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the state of the run. */
static PetscErrorCode ReadFile(const Run *run, const char path[], Hdf5File *file, Stored *stored)
{
  double   next;
  uint64_t wanted = 0, sum = 0;

  PetscFunctionBegin;
  PetscCall(Hdf5ReadNumber(file, "next_id", H5T_NATIVE_LLONG, &stored->next_id));
  next = (double)stored->next_id;
  CheckpointSumNumbers(1, &next, &sum);
  PetscCall(CheckScene(run, path, file, &sum));
  PetscCall(ReadMemory(&run->flow.scheme->memory, path, file, stored, &sum));
  PetscCall(ReadHistory(file, stored, &sum));
  PetscCall(ReadKept(run->flow.scheme, path, file, stored, &sum));
  PetscCall(Hdf5ReadNumber(file, "checksum", H5T_NATIVE_UINT64, &wanted));
  PetscCall(ReadRecords(run->flow.particles, file, stored, &sum));
  stored->whole = sum == wanted ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gives the contents of the file to the run, except records. */
static PetscErrorCode Restore(const Stored *stored, Run *run)
{
  char *name = stored->names;

  PetscFunctionBegin;
  run->flow.particles->next_id = stored->next_id;
  MemorySet(&run->flow.scheme->memory, PETSC_TRUE, stored->memory);
  PetscCall(ClockRestart(run->flow.clock));
  if (stored->kept) {
    PetscScalar *values;
    PetscInt     n;

    PetscCall(VecGetLocalSize(run->flow.scheme->kept, &n));
    PetscCall(VecGetArrayWrite(run->flow.scheme->kept, &values));
    PetscCall(PetscArraycpy(values, stored->kept, n));
    PetscCall(VecRestoreArrayWrite(run->flow.scheme->kept, &values));
  }
  for (PetscInt k = 0; k < stored->n_report; k++) {
    char *comma = strchr(name, ',');

    if (comma) *comma = '\0';
    PetscCall(ReportRestore(run->report, name, &stored->report[4 * k]));
    name = comma ? comma + 1 : name;
  }
  PetscCall(
      SnapshotsSet(run->snapshots, stored->n_snapshots, stored->snapshots, run->flow.clock->step));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Ends the run if a record of this rank can be no particle's, or if two records of all ranks have
   the same id, although the checksum is right. Collective. */
static PetscErrorCode CheckRecords(const Run *run, const char path[], const Stored *stored)
{
  const Particles *p     = run->flow.particles;
  const PetscInt   width = ParticlesRecordWidth(p);
  PetscInt         wrong = 0, repeated;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < stored->n; i++)
    if (!ParticlesValidRecord(run->flow.scene, p, &stored->record[(size_t)i * width])) wrong++;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &wrong, 1, MPIU_INT, MPI_SUM, p->comm));
  PetscCheck(!wrong, PETSC_COMM_WORLD, PETSC_ERR_FILE_UNEXPECTED,
             "-restart %s: the file is damaged: %" PetscInt_FMT
             " of its particles have an unknown number or kind, or values out of bounds",
             path, wrong);
  PetscCall(ParticlesCountRepeated(p, stored->n, stored->record, &repeated));
  PetscCheck(!repeated, PETSC_COMM_WORLD, PETSC_ERR_FILE_UNEXPECTED,
             "-restart %s: the file is damaged: %" PetscInt_FMT
             " of its particles have the number of another",
             path, repeated);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode StoredFree(Stored *stored)
{
  PetscFunctionBegin;
  PetscCall(FreeAll(&stored->memory, &stored->report, &stored->snapshots, &stored->names,
                    &stored->record, &stored->kept));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* CheckpointsRestart - Replaces the flow at the start by the flow of the checkpoint of -restart.
   Collective on PETSC_COMM_WORLD. Output: restarted - true if -restart was given. Errors: a damaged
   file ends the run, and so does a file of another version, case, scene or number of particles. */
PetscErrorCode CheckpointsRestart(Run *run, PetscBool *restarted)
{
  Checkpoints *c      = run->checkpoints;
  const Clock *clock  = run->flow.clock;
  const char  *path   = c->restart;
  Stored       stored = {.n_report = 0, .n_snapshots = 0};
  Hdf5File     file;
  PetscBool    good;

  PetscFunctionBegin;
  *restarted = path[0] ? PETSC_TRUE : PETSC_FALSE;
  if (!path[0]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Hdf5FileOpen(PETSC_COMM_WORLD, path, HDF5_READ, &file));
  PetscCheck(file.file >= 0, PETSC_COMM_WORLD, PETSC_ERR_FILE_OPEN,
             "-restart %s: is absent, no HDF5 file, or a truncated one", path);
  PetscCall(RestartRefuse(run, path, &file));
  PetscCall(ReadFile(run, path, &file, &stored));
  PetscCall(Hdf5FileClose(&file, &good));
  PetscCheck(good && stored.whole, PETSC_COMM_WORLD, PETSC_ERR_FILE_UNEXPECTED,
             "-restart %s: the file is damaged: %s", path,
             good ? "its checksum is wrong" : "parts of it cannot be read");
  PetscCall(Restore(&stored, run));
  PetscCheck(
      clock->t >= 0.0 && clock->dt >= 0.0 && clock->dt_previous >= 0.0 &&
          run->flow.scheme->stats.speed_max >= 0.0,
      PETSC_COMM_WORLD, PETSC_ERR_FILE_UNEXPECTED,
      "-restart %s: the file is damaged: it is at t = %.6g with dt = %.6g and the speed %.6g", path,
      (double)clock->t, (double)clock->dt, (double)run->flow.scheme->stats.speed_max);
  UserCheck(clock->t <= clock->t_end * (1.0 + 1e-12),
            "-restart %s: the file is at t = %.6g, after -t_end %.6g", path, (double)clock->t,
            (double)clock->t_end);
  PetscCall(CheckRecords(run, path, &stored));
  PetscCall(ParticlesReplace(run->flow.scene, run->flow.particles, stored.n, stored.record));
  PetscCall(StoredFree(&stored));
  PetscCall(run->flow.scheme->row->Begin(&run->flow));
  c->last = clock->t;
  c->step = clock->step;
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "restart     %s: t = %.6g, step %" PetscInt_FMT "\n",
                        path, (double)clock->t, clock->step));
  PetscFunctionReturn(PETSC_SUCCESS);
}
