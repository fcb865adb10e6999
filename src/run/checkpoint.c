/* Checkpoints: the state of a run in an HDF5 file, written under another name and renamed when it
   is complete. A checkpoint starts an epoch in the run itself, so that this run and a run restarted
   from the file are bitwise equal on the same number of ranks. */
#include "checkpoint.h"

enum { CHECKPOINT, CHECKPOINT_EVERY, RESTART };
static const OptionRow options[] = {
    [CHECKPOINT]       = OPTION(FILE, "-checkpoint",
                                "file to restart from, written at the end and on SIGTERM and "
                                      "SIGINT",
                                NULL, NULL, .file = FILE_WRITTEN, .where = "flows"),
    [CHECKPOINT_EVERY] = OPTION(REAL, "-checkpoint_every",
                                "checkpoints after the first step at or past each multiple of this "
                                "time; steps do not change",
                                "s", "none before the end", POSITIVE, .where = "flows"),
    [RESTART] =
        OPTION(FILE, "-restart", "checkpoint from which the run continues, on any number of ranks",
               NULL, NULL, .file = FILE_READ, .where = "flows"),
};
const OptionTable CheckpointOptions = OPTIONS("Checkpoints", options);

/*
  CheckpointsCreate - Reads the options of checkpoints and of a restart. Collective on
  PETSC_COMM_WORLD.

  Options Database Keys:
  + -checkpoint file.h5 - file written at the end, and on SIGTERM, SIGINT and SIGXCPU
  . -checkpoint_every T - write the file also after the first step at or past each multiple of T [s]
  - -restart file.h5    - file to restart from, on any number of ranks

  Errors: a path that cannot be written ends the run
*/
PetscErrorCode CheckpointsCreate(Checkpoints **checkpoints)
{
  Checkpoints *c;
  PetscBool    every, good;
  char         part[PETSC_MAX_PATH_LEN];

  PetscFunctionBegin;
  PetscCall(PetscNew(&c));
  c->step = -1;
  PetscCall(OptionGetFile(&options[CHECKPOINT], c->path));
  PetscCall(OptionGetReal(&options[CHECKPOINT_EVERY], &c->every, &every));
  PetscCall(OptionGetFile(&options[RESTART], c->restart));
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

/* CheckpointsDestroy - Frees the checkpoints; the files remain; not collective */
PetscErrorCode CheckpointsDestroy(Checkpoints **checkpoints)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(*checkpoints));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes a table of numbers that all ranks have, and adds it to the checksum. */
static PetscErrorCode WriteTable(Hdf5File *file, const char name[], PetscInt rows, PetscInt columns,
                                 const double values[], uint64_t *sum)
{
  PetscFunctionBegin;
  if (!rows) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(
      Hdf5WriteTable(file, name, rows, columns, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, values, "SI"));
  CheckpointSumNumbers(rows * columns, values, sum);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes the report and the list of snapshots so far, and adds them to the checksum. */
static PetscErrorCode WriteHistory(const Run *run, Hdf5File *file, uint64_t *sum)
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
    TextAppend(names, (size_t)(33 * n_report + 1), q->name);
    TextAppend(names, (size_t)(33 * n_report + 1), ",");
  }
  PetscCall(Hdf5WriteNumber(file, "n_report", H5T_NATIVE_INT, &n_report));
  PetscCall(Hdf5WriteText(file, "/", "report_names", names));
  CheckpointSumText(names, sum);
  PetscCall(WriteTable(file, "report", n_report, 4, rows, sum));
  SnapshotsGet(run->snapshots, &rows[4 * n_report]);
  PetscCall(Hdf5WriteNumber(file, "n_snapshots", H5T_NATIVE_INT, &n_snapshots));
  PetscCall(WriteTable(file, "snapshots", n_snapshots, 3, &rows[4 * n_report], sum));
  PetscCall(PetscFree2(rows, names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes the state of the run except the particles, and adds it to the checksum. */
static PetscErrorCode WriteState(const Run *run, Hdf5File *file, uint64_t *sum)
{
  const Particles  *p      = run->flow.particles;
  const Scene      *scene  = run->flow.scene;
  const Memory     *memory = &run->flow.scheme->memory;
  const int         format = CHECKPOINT_FORMAT, dim = (int)p->dim;
  const long long   N_fluid = p->N_start[0], N_wall = p->N_start[1], next_id = p->next_id;
  const double      next = (double)next_id;
  const SceneEntry *entry;
  double            numbers[SCENE_ENTRY_MAX], *values;
  char              names[MEMORY_MAX * 32];

  PetscFunctionBegin;
  PetscCall(Hdf5WriteNumber(file, "format", H5T_NATIVE_INT, &format));
  PetscCall(Hdf5WriteText(file, "/", "version", ISPH_VERSION));
  PetscCall(Hdf5WriteText(file, "/", "case", scene->problem->name));
  PetscCall(Hdf5WriteNumber(file, "dim", H5T_NATIVE_INT, &dim));
  PetscCall(Hdf5WriteBoundaries(scene, file));
  PetscCall(Hdf5WriteNumber(file, "fluid_at_start", H5T_NATIVE_LLONG, &N_fluid));
  PetscCall(Hdf5WriteNumber(file, "walls_at_start", H5T_NATIVE_LLONG, &N_wall));
  PetscCall(Hdf5WriteNumber(file, "next_id", H5T_NATIVE_LLONG, &next_id));
  CheckpointSumNumbers(1, &next, sum);
  PetscCall(CheckpointRecord(p, names, sizeof(names)));
  PetscCall(Hdf5WriteText(file, "/", "record", names));
  PetscCall(CheckpointMemory(memory, names, sizeof(names)));
  PetscCall(Hdf5WriteText(file, "/", "memory_names", names));
  CheckpointSumText(names, sum);
  for (PetscInt k = 0; (entry = CheckpointSceneEntry(k)); k++) {
    PetscCall(entry->Compute(scene, numbers));
    PetscCall(WriteTable(file, entry->name, 1, entry->n, numbers, sum));
  }
  PetscCall(PetscMalloc1(memory->size, &values));
  MemoryGet(memory, values);
  PetscCall(WriteTable(file, "memory", 1, memory->size, values, sum));
  PetscCall(PetscFree(values));
  PetscCall(WriteHistory(run, file, sum));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes the state of the scheme that is not on particles, and adds it to the checksum. */
static PetscErrorCode WriteKept(const Scheme *scheme, Hdf5File *file, uint64_t *sum)
{
  long long          N    = 0;
  PetscInt           rows = 0, last;
  const PetscScalar *values;

  PetscFunctionBegin;
  if (scheme->kept) PetscCall(VecGetSize(scheme->kept, &rows));
  N = rows;
  PetscCall(Hdf5WriteNumber(file, "n_kept", H5T_NATIVE_LLONG, &N));
  if (!scheme->kept) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecGetOwnershipRange(scheme->kept, &file->start, &last));
  file->own = last - file->start;
  file->N   = rows;
  PetscCall(VecGetArrayRead(scheme->kept, &values));
  PetscCall(Hdf5WriteRows(file, "kept", 1, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, values, "SI"));
  PetscCall(CheckpointSumKept(file->start, file->own, values, sum));
  PetscCall(VecRestoreArrayRead(scheme->kept, &values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes the checkpoint; the file gets its name only when it is complete. */
static PetscErrorCode WriteFile(const Run *run, const PetscReal record[], const char path[])
{
  const Particles *p   = run->flow.particles;
  const PetscInt   own = ParticlesOwn(p), width = ParticlesRecordWidth(p);
  const size_t     numbers = (size_t)(p->N_fluid + p->N_wall) * (size_t)(width + 1);
  const size_t     bytes   = 8 * numbers + (size_t)262144;
  char             part[PETSC_MAX_PATH_LEN];
  PetscBool        good;
  Hdf5File         file;
  uint64_t         sum = 0;

  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(part, sizeof(part), "%s.part", path));
  PetscCall(FileReserve(part, bytes, &good));
  if (good) {
    PetscCall(Hdf5FileOpen(PETSC_COMM_WORLD, part, HDF5_CHECKED, &file));
    if (file.file >= 0) {
      PetscCall(WriteState(run, &file, &sum));
      PetscCall(WriteKept(run->flow.scheme, &file, &sum));
      file.start = p->fluid_start + p->wall_start;
      file.own   = own;
      file.N     = p->N_fluid + p->N_wall;
      PetscCall(Hdf5WriteRows(&file, "particles", width, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, record,
                              "SI, the numbers that the attribute record names"));
      PetscCall(CheckpointSumRecords(own, width, record, &sum));
      PetscCall(Hdf5WriteNumber(&file, "checksum", H5T_NATIVE_UINT64, &sum));
    }
    PetscCall(Hdf5FileFinish(&file, part, path, &good));
  }
  PetscCheck(good, PETSC_COMM_WORLD, PETSC_ERR_FILE_OPEN,
             "-checkpoint %s: cannot be written, or the disk is full; an earlier file is unchanged",
             path);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* RunWriteCheckpoint - Writes a checkpoint, and begins an epoch unless the run ends; collective */
PetscErrorCode RunWriteCheckpoint(Run *run, const char path[], PetscBool final)
{
  const PetscInt n = ParticlesOwn(run->flow.particles);
  PetscReal     *record;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1((size_t)n * ParticlesRecordWidth(run->flow.particles), &record));
  PetscCall(ParticlesPack(run->flow.particles, record));
  PetscCall(WriteFile(run, record, path));
  if (!final) {
    PetscCall(ParticlesReplace(run->flow.scene, run->flow.particles, n, record));
    PetscCall(run->flow.scheme->row->Begin(&run->flow));
  }
  PetscCall(PetscFree(record));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* CheckpointsUpdate - Writes a checkpoint if one is due. Collective on PETSC_COMM_WORLD. Called
   after every step. Input: final - true at the end and on a signal. Notes: writing starts an epoch,
   and the scheme begins anew from the fields, as in a restarted run. Errors: a file that cannot be
   written ends the run; the last checkpoint remains. */
PetscErrorCode CheckpointsUpdate(PetscBool final, Run *run)
{
  Checkpoints *c     = run->checkpoints;
  const Clock *clock = run->flow.clock;

  PetscFunctionBegin;
  if (!c->path[0] || c->step == clock->step) PetscFunctionReturn(PETSC_SUCCESS);
  if (!final && (c->every == 0.0 || !ClockPasses(c->every, c->last, clock->t)))
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(RunWriteCheckpoint(run, c->path, final));
  c->last = clock->t;
  c->step = clock->step;
  PetscFunctionReturn(PETSC_SUCCESS);
}
