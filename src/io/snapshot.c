/* Snapshots: each is an HDF5 file, which is written under another name and renamed when it is
   complete. An index lists them for ParaView. Complete files stay readable even if the run is
   killed. */
#include "snapshot.h"
#include "isph/options.h"
#include <string.h>
#include <unistd.h>

enum { OUTPUT, OUTPUT_EVERY, SCENE_VIEW };
static const OptionRow options[] = {
    [OUTPUT] = OPTION(FILE, "-output",
                      "snapshots for ParaView: file.h5 gives file_0000.h5, file_0001.h5, ... and "
                      "their index file.xdmf",
                      NULL, NULL, .where = "flows"),
    [OUTPUT_EVERY] =
        OPTION(REAL, "-output_every", "snapshots at each multiple of this time, where steps end",
               "s", "start and end only", POSITIVE, .where = "flows"),
    [SCENE_VIEW] = OPTION(FILE, "-scene_view",
                          "writes the sides of the box and the bodies at t = 0 to a file for "
                          "ParaView, scene.vtp, and computes nothing",
                          NULL, NULL, .where = "flows", .file = FILE_WRITTEN),
};
const OptionTable SnapshotOptions = OPTIONS("Snapshots", options);

struct Snapshots {
  char      base[PETSC_MAX_PATH_LEN]; /* given path without .h5; empty: no snapshots */
  PetscReal every;                    /* time between snapshots; 0: start and end only [s] */
  Snapshot *done;
  PetscInt  n, capacity, step; /* number of complete snapshots; step of the last of them */
};

/* Ends the run on all ranks if good is false on the first rank: a file could not be written. */
static PetscErrorCode SnapshotsVerdict(const Snapshots *snapshots, const char path[],
                                       PetscBool good)
{
  PetscFunctionBegin;
  PetscCall(FirstRankDecides(&good));
  PetscCheck(good, PETSC_COMM_WORLD, PETSC_ERR_FILE_OPEN,
             "-output %s.h5: cannot write %s, or the disk is full", snapshots->base, path);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Ends the run if a file of the given size cannot be written. Collective. */
static PetscErrorCode SnapshotsReserve(const Snapshots *snapshots, const char path[], size_t bytes)
{
  PetscBool good;

  PetscFunctionBegin;
  PetscCall(FileReserve(path, bytes, &good));
  PetscCall(SnapshotsVerdict(snapshots, path, good));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SnapshotsCreate - Reads the options of snapshots and tests if files can be written; collective on
   PETSC_COMM_WORLD */
PetscErrorCode SnapshotsCreate(const Scene *scene, Snapshots **snapshots)
{
  Snapshots *s;
  PetscBool  every, h5 = PETSC_TRUE;
  size_t     length;
  char       path[PETSC_MAX_PATH_LEN];

  PetscFunctionBegin;
  PetscCall(SnapshotFieldsCheck(scene));
  PetscCall(PetscNew(&s));
  s->step = -1;
  PetscCall(OptionGetFile(&options[OUTPUT], s->base));
  PetscCall(OptionGetReal(&options[OUTPUT_EVERY], &s->every, &every));
  UserCheck(!every || s->base[0], "-output_every: there is no -output");
  if (s->base[0]) {
    PetscCall(PetscStrendswith(s->base, ".h5", &h5));
    PetscCall(PetscStrlen(s->base, &length));
    UserCheck(h5 && length > 3, "-output %s: the name must end in .h5", s->base);
    s->base[length - 3] = '\0';
    PetscCall(PetscSNPrintf(path, sizeof(path), "%s_0000.h5.part", s->base));
    PetscCall(SnapshotsReserve(s, path, 1));
  }
  *snapshots = s;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SnapshotsNeeds - Returns the operators that snapshots need, as bits of Need. These are the
   gradient of the velocity, and the concentration for the density. Most runs with moving particles
   compute both in any case. */
unsigned SnapshotsNeeds(const Snapshots *snapshots)
{
  return snapshots->base[0] ? (unsigned)(NEED_GRADIENT_U | NEED_CONCENTRATION) : 0;
}

/* SnapshotsInterval - Returns the time between snapshots [s], 0 if snapshots are written at start
   and end only */
PetscReal SnapshotsInterval(const Snapshots *snapshots)
{
  return snapshots->every;
}

PetscErrorCode SnapshotsDestroy(Snapshots **snapshots)
{
  PetscFunctionBegin;
  if (!*snapshots) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FreeAll(&(*snapshots)->done, snapshots));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes attributes that describe the run. */
static PetscErrorCode SnapshotAttributes(const Flow *flow, Hdf5File *file)
{
  const Scene *scene = flow->scene;
  const struct {
    const char *name;
    PetscReal   value;
  } numbers[] = {
      {"time", flow->clock->t},
      {"reynolds", SceneReynolds(scene)},
      {"dx", scene->dx},
      {"h", flow->ops->forms.h},
      {"nu", scene->nu},
      {"rho", scene->rho},
      {"frame_angle", SceneFrameAngle(scene, ClockMoment(flow->clock))},
  };
  const int step = (int)flow->clock->step, dim = (int)scene->dim;
  char      text[64], *options;
  unsigned  major, minor, release;

  PetscFunctionBegin;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(numbers); k++) {
    const double value = (double)numbers[k].value;

    PetscCall(Hdf5WriteNumber(file, numbers[k].name, H5T_NATIVE_DOUBLE, &value));
  }
  PetscCall(Hdf5WriteNumber(file, "step", H5T_NATIVE_INT, &step));
  PetscCall(Hdf5WriteNumber(file, "dim", H5T_NATIVE_INT, &dim));
  PetscCall(Hdf5WriteText(file, "/", "case", scene->problem->name));
  PetscCall(Hdf5WriteBoundaries(scene, file));
  PetscCall(Hdf5WriteGeometry(scene, file));
  PetscCall(Hdf5WriteText(file, "/", "version", ISPH_VERSION));
  PetscCall(Hdf5WriteText(file, "/", "commit", VersionCommit()));
  PetscCall(PetscSNPrintf(text, sizeof(text), "%d.%d.%d", PETSC_VERSION_MAJOR, PETSC_VERSION_MINOR,
                          PETSC_VERSION_SUBMINOR));
  PetscCall(Hdf5WriteText(file, "/", "petsc_version", text));
  if (H5get_libversion(&major, &minor, &release) < 0) file->failed = PETSC_TRUE;
  PetscCall(PetscSNPrintf(text, sizeof(text), "%u.%u.%u", major, minor, release));
  PetscCall(Hdf5WriteText(file, "/", "hdf5_version", text));
  PetscCall(
      Hdf5WriteText(file, "/", "units", "SI; time in s, the other units stand at their data sets"));
  PetscCall(PetscOptionsGetAll(NULL, &options));
  PetscCall(Hdf5WriteText(file, "/", "options", options));
  PetscCall(PetscFree(options));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes the file name of a snapshot, base_0000.h5 for number 0. */
static PetscErrorCode SnapshotPath(const Snapshots *s, PetscInt number,
                                   char path[PETSC_MAX_PATH_LEN])
{
  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(path, PETSC_MAX_PATH_LEN, "%s_%04d.h5", s->base, (int)number));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes a file. Output: N - particles in it. */
static PetscErrorCode SnapshotWriteFile(const Flow *flow, const Snapshots *s, const char path[],
                                        PetscInt *N)
{
  char      part[PETSC_MAX_PATH_LEN];
  Hdf5File  file;
  PetscBool good;

  PetscFunctionBegin;
  PetscCall(FlowPrepareOutput(flow));
  PetscCall(PetscSNPrintf(part, sizeof(part), "%s.part", path));
  PetscCall(SnapshotsReserve(s, part, SnapshotBytes(flow)));
  PetscCall(Hdf5FileOpen(PETSC_COMM_WORLD, part, HDF5_COMMON, &file));
  if (file.file >= 0) {
    PetscCall(SnapshotAttributes(flow, &file));
    PetscCall(SnapshotFieldsWrite(flow, &file));
    PetscCall(VtkGroupWrite(flow, &file));
  }
  PetscCall(Hdf5FileFinish(&file, part, path, &good));
  PetscCall(SnapshotsVerdict(s, path, good));
  *N = file.N;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SnapshotSave - Writes a snapshot to a file of its own, path.h5; collective */
PetscErrorCode SnapshotSave(const Flow *flow, const char path[])
{
  Snapshots s;
  PetscBool h5;
  PetscInt  N;

  PetscFunctionBegin;
  PetscCall(PetscStrncpy(s.base, path, sizeof(s.base)));
  PetscCall(PetscStrendswith(path, ".h5", &h5));
  UserCheck(h5, "%s: the name of a snapshot must end in .h5", path);
  s.base[strlen(s.base) - 3] = '\0';
  PetscCall(SnapshotWriteFile(flow, &s, path, &N));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes the next snapshot, and then the index. */
static PetscErrorCode SnapshotWrite(const Flow *flow, Snapshots *s)
{
  const PetscInt number = s->n ? s->done[s->n - 1].number + 1 : 0;
  char           path[PETSC_MAX_PATH_LEN], part[PETSC_MAX_PATH_LEN];
  PetscInt       N;
  PetscMPIInt    rank;
  PetscBool      good = PETSC_TRUE;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  PetscCall(SnapshotPath(s, number, path));
  PetscCall(SnapshotWriteFile(flow, s, path, &N));
  if (s->n == s->capacity) {
    s->capacity = 2 * s->capacity + 16;
    PetscCall(PetscRealloc(sizeof(Snapshot) * (size_t)s->capacity, &s->done));
  }
  if (rank == 0 && (flow->scene->pose || flow->scene->frame)) {
    PetscCall(PetscSNPrintf(part, sizeof(part), "%s_%04d.vtp", s->base, (int)number));
    PetscCall(SurfaceFileWrite(flow->scene, flow->clock->t, part, &good));
  }
  PetscCall(SnapshotsVerdict(s, part, good));
  s->done[s->n].number = number;
  s->done[s->n].t      = flow->clock->t;
  s->done[s->n].N      = N;
  s->n++;
  s->step = flow->clock->step;
  if (rank == 0) {
    PetscCall(XdmfWrite(s->base, flow, s->n, s->done, &good));
  }
  PetscCall(PetscSNPrintf(path, sizeof(path), "%s.xdmf", s->base));
  PetscCall(SnapshotsVerdict(s, path, good));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SnapshotsWrite - Writes a snapshot if it is due. Collective on PETSC_COMM_WORLD. Called before
   the first step, after every step and, with final, at the end. Input: flow - the present flow;
   final - true at the end of the run: writes unless this step has been written; snapshots - the
   snapshots. */
PetscErrorCode SnapshotsWrite(const Flow *flow, PetscBool final, Snapshots *snapshots)
{
  PetscBool due = final;

  PetscFunctionBegin;
  if (!snapshots->base[0] || snapshots->step == flow->clock->step)
    PetscFunctionReturn(PETSC_SUCCESS);
  if (!snapshots->n) due = PETSC_TRUE;
  else if (snapshots->every > 0.0 && !due)
    due = ClockPasses(snapshots->every, snapshots->done[snapshots->n - 1].t, flow->clock->t);
  if (due) PetscCall(SnapshotWrite(flow, snapshots));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SnapshotsCount, SnapshotsGet, SnapshotsSet - Count, copy and restore the list of complete
   snapshots for a checkpoint: number, time and number of particles of each. Not collective, except
   SnapshotsSet(). It omits files that do not exist, for example after a restart with another
   -output. */
PetscInt SnapshotsCount(const Snapshots *snapshots)
{
  return snapshots->n;
}

void SnapshotsGet(const Snapshots *snapshots, PetscReal rows[])
{
  for (PetscInt k = 0; k < snapshots->n; k++) {
    rows[3 * k]     = (PetscReal)snapshots->done[k].number;
    rows[3 * k + 1] = snapshots->done[k].t;
    rows[3 * k + 2] = (PetscReal)snapshots->done[k].N;
  }
}

PetscErrorCode SnapshotsSet(Snapshots *snapshots, PetscInt n, const PetscReal rows[], PetscInt step)
{
  PetscFunctionBegin;
  if (!snapshots->base[0]) PetscFunctionReturn(PETSC_SUCCESS);
  snapshots->n        = 0;
  snapshots->capacity = n;
  PetscCall(PetscRealloc(sizeof(Snapshot) * (size_t)PetscMax(n, 1), &snapshots->done));
  for (PetscInt k = 0; k < n; k++) {
    const Snapshot snapshot = {(PetscInt)rows[3 * k], rows[3 * k + 1], (PetscInt)rows[3 * k + 2]};
    char           path[PETSC_MAX_PATH_LEN];
    PetscBool      there;

    PetscCall(SnapshotPath(snapshots, snapshot.number, path));
    there = access(path, R_OK) == 0;
    PetscCall(FirstRankDecides(&there));
    if (there) snapshots->done[snapshots->n++] = snapshot;
  }
  snapshots->step = snapshots->n ? step : -1;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SceneView - Writes the boundaries of a scene at t = 0 if -scene_view asks for them; collective on
   PETSC_COMM_WORLD. Output: viewed - true if so: the program then ends. */
PetscErrorCode SceneView(const Scene *scene, PetscBool *viewed)
{
  char        path[PETSC_MAX_PATH_LEN];
  PetscBool   good = PETSC_TRUE;
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCall(OptionGetFile(&options[SCENE_VIEW], path));
  *viewed = path[0] ? PETSC_TRUE : PETSC_FALSE;
  if (!*viewed) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscStrendswith(path, ".vtp", &good));
  UserCheck(good, "-scene_view %s: the name must end in .vtp", path);
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  if (rank == 0) PetscCall(SurfaceFileWrite(scene, 0.0, path, &good));
  PetscCall(FirstRankDecides(&good));
  UserCheck(good, "-scene_view %s: the file cannot be written, or the disk is full", path);
  PetscCall(PetscPrintf(PETSC_COMM_WORLD,
                        "%s: the boundaries of the scene at t = 0; nothing is "
                        "computed\n",
                        path));
  for (PetscInt side = 0; side < SceneBoundaries(scene); side++) {
    char name[WALL_NAME];

    SceneWallName(scene, side, name);
    PetscCall(PetscPrintf(PETSC_COMM_WORLD, "  %2d %-10s %s\n", (int)side, name,
                          scene->boundary[side].kind->name));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
