/* CSV files of monitors: a header, then rows for each time. The file is flushed after the rows of
   each time, so that a killed run keeps them. */
#include "monitors.h"
#include <errno.h>
#include <stdlib.h>

/* Ends the run if the first rank could not write a file. Collective. */
static PetscErrorCode MonitorVerdict(const char path[], PetscBool good)
{
  PetscFunctionBegin;
  PetscCall(FirstRankDecides(&good));
  PetscCheck(good, PETSC_COMM_WORLD, PETSC_ERR_FILE_OPEN,
             "-probe_output: cannot write %s, or the disk is full", path);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* MonitorOpen - Opens a file and writes its header, on the first rank; collective */
PetscErrorCode MonitorOpen(const MonitorKind *kind, Monitor *monitor)
{
  PetscMPIInt rank;
  PetscBool   good = PETSC_TRUE;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  if (rank == 0) {
    monitor->stream = FileOpen(monitor->path, "w");
    good = monitor->stream && fprintf(monitor->stream, "t,step,%s\n", kind->header) > 0 &&
           fflush(monitor->stream) == 0;
  }
  PetscCall(MonitorVerdict(monitor->path, good));
  monitor->opened = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Copies the header and the rows up to time t to a new file, which replaces the old file and is
   opened for appending. Returns false on failure; then the old file is unchanged. */
static PetscBool KeepRows(Monitor *monitor, FILE *old, PetscReal t)
{
  char      part[PETSC_MAX_PATH_LEN + 8], line[1024];
  FILE     *kept;
  PetscBool good;

  (void)snprintf(part, sizeof(part), "%s.part", monitor->path);
  kept = FileOpen(part, "w");
  for (PetscInt k = 0; kept && fgets(line, (int)sizeof(line), old); k++) {
    const size_t length = strlen(line);

    if (length && line[length - 1] != '\n') break; /* incomplete after a kill */
    if (k && atof(line) > (double)t + 1e-9 * PetscAbsReal(t)) break;
    (void)fputs(line, kept);
  }
  if (!kept) return PETSC_FALSE;
  good = !ferror(old) && !ferror(kept);
  if (fclose(kept)) good = PETSC_FALSE;
  if (!good || !FileReplace(part, monitor->path)) {
    (void)remove(part);
    return PETSC_FALSE;
  }
  monitor->stream = FileOpen(monitor->path, "a");
  return monitor->stream ? PETSC_TRUE : PETSC_FALSE;
}

/* MonitorGoOn - Opens the file of a run that is restarted at time t [s] and removes rows of later
   times; creates the file if it is absent. Collective on PETSC_COMM_WORLD. Errors: a file that
   cannot be rewritten ends the run and stays unchanged. */
PetscErrorCode MonitorGoOn(const MonitorKind *kind, PetscReal t, Monitor *monitor)
{
  PetscMPIInt rank;
  FILE       *old;
  PetscBool   there, good;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  old   = rank == 0 ? FileOpen(monitor->path, "r") : NULL;
  there = old || (rank == 0 && errno != ENOENT);
  good  = old && KeepRows(monitor, old, t);
  if (old) (void)fclose(old);
  PetscCall(FirstRankDecides(&there));
  monitor->opened = PETSC_TRUE;
  if (there) PetscCall(MonitorVerdict(monitor->path, good));
  else PetscCall(MonitorOpen(kind, monitor));
  monitor->begins = there ? PETSC_FALSE : PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* MonitorFlush - Flushes the rows of the present time; ends the run if this fails; collective */
PetscErrorCode MonitorFlush(Monitor *monitor)
{
  PetscBool good = PETSC_TRUE;

  PetscFunctionBegin;
  if (monitor->stream) good = !ferror(monitor->stream) && fflush(monitor->stream) == 0;
  if (!good) { /* PETSc fails in its own flush of such a stream */
    (void)fclose(monitor->stream);
    monitor->stream = NULL;
  }
  PetscCall(MonitorVerdict(monitor->path, good));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* MonitorRow - Begins a row with time and step on the first rank. Returns: PETSC_FALSE if nothing
   is to be written, on other ranks. */
PetscBool MonitorRow(const Clock *clock, const Monitor *monitor)
{
  if (!monitor->stream) return PETSC_FALSE;
  (void)fprintf(monitor->stream, "%.12g,%" PetscInt_FMT, (double)clock->t, clock->step);
  return PETSC_TRUE;
}

/* MonitorVector - Writes three components of a vector; in 2D the third is zero */
void MonitorVector(const Monitor *monitor, PetscInt dim, const PetscReal v[])
{
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++)
    (void)fprintf(monitor->stream, ",%.12g", a < dim ? (double)v[a] : 0.0);
}
