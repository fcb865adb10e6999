/*
  The file of a monitor: CSV, a header, one row a quantity and time, flushed row by row so that
  nothing written is lost.
*/
#include "monitors.h"
#include <errno.h>
#include <stdlib.h>

/* Ends the run where a file could not be written. Collective. */
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
    monitor->stream = fopen(monitor->path, "w");
    good = monitor->stream && fprintf(monitor->stream, "t,step,%s\n", kind->header) > 0 &&
                   fflush(monitor->stream) == 0
               ? PETSC_TRUE
               : PETSC_FALSE;
  }
  PetscCall(MonitorVerdict(monitor->path, good));
  monitor->opened = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Copies the header and the rows up to time t to a new file, which then takes the old one's place
  and is open. Returns whether that went well; if not, the old file is as it was.
*/
static PetscBool KeepRows(Monitor *monitor, FILE *old, PetscReal t)
{
  char      part[PETSC_MAX_PATH_LEN + 8], line[512];
  FILE     *kept;
  PetscBool good;

  (void)snprintf(part, sizeof(part), "%s.part", monitor->path);
  kept = fopen(part, "w");
  for (PetscInt k = 0; kept && fgets(line, (int)sizeof(line), old); k++) {
    const size_t length = strlen(line);

    if (length && line[length - 1] != '\n') break; /* cut off by a kill */
    if (k && atof(line) > (double)t + 1e-9 * PetscAbsReal(t)) break;
    (void)fputs(line, kept);
  }
  if (!kept) return PETSC_FALSE;
  good = !ferror(old) && !ferror(kept) ? PETSC_TRUE : PETSC_FALSE;
  if (fclose(kept)) good = PETSC_FALSE;
  if (!good || rename(part, monitor->path)) {
    (void)remove(part);
    return PETSC_FALSE;
  }
  monitor->stream = fopen(monitor->path, "a");
  return monitor->stream ? PETSC_TRUE : PETSC_FALSE;
}

/*
  MonitorGoOn - Opens the file of the run that is restarted, without the rows after time t [s]; a
  file that is absent begins anew

  Collective on PETSC_COMM_WORLD. Errors: a file that cannot be rewritten ends the run and stays as
  it is
*/
PetscErrorCode MonitorGoOn(const MonitorKind *kind, PetscReal t, Monitor *monitor)
{
  PetscMPIInt rank;
  FILE       *old;
  PetscBool   there, good;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  old   = rank == 0 ? fopen(monitor->path, "r") : NULL;
  there = old || (rank == 0 && errno != ENOENT) ? PETSC_TRUE : PETSC_FALSE;
  good  = old && KeepRows(monitor, old, t) ? PETSC_TRUE : PETSC_FALSE;
  if (old) (void)fclose(old);
  PetscCall(FirstRankDecides(&there));
  monitor->opened = PETSC_TRUE;
  if (there) PetscCall(MonitorVerdict(monitor->path, good));
  else PetscCall(MonitorOpen(kind, monitor));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* MonitorFlush - Flushes the rows of a moment, or ends the run if they cannot be written;
   collective */
PetscErrorCode MonitorFlush(Monitor *monitor)
{
  PetscBool good = PETSC_TRUE;

  PetscFunctionBegin;
  if (monitor->stream)
    good = !ferror(monitor->stream) && fflush(monitor->stream) == 0 ? PETSC_TRUE : PETSC_FALSE;
  if (!good) { /* PETSc would stumble over a stream that cannot be flushed */
    (void)fclose(monitor->stream);
    monitor->stream = NULL;
  }
  PetscCall(MonitorVerdict(monitor->path, good));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  MonitorRow - Begins a row on the first rank: time and step; not collective

  Returns PETSC_FALSE on the other ranks, which write nothing.
*/
PetscBool MonitorRow(const Flow *flow, const Monitor *monitor)
{
  if (!monitor->stream) return PETSC_FALSE;
  (void)fprintf(monitor->stream, "%.12g,%" PetscInt_FMT, (double)flow->clock->t, flow->clock->step);
  return PETSC_TRUE;
}

/* MonitorVector - Adds the components of a vector to a row, and zeros up to three; not
   collective */
void MonitorVector(const Monitor *monitor, PetscInt dim, const PetscReal v[])
{
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++)
    (void)fprintf(monitor->stream, ",%.12g", a < dim ? (double)v[a] : 0.0);
}
