/*
  Monitors: what is measured in the course of a run. One CSV file a kind, a header, one row
  a quantity and time, flushed row by row so that nothing written is lost.
*/
#include "monitors.h"
#include <errno.h>

#define MONITOR_NUMBERS 256 /* of one option */

/* One kind of monitor: an option, a file, the numbers given, and who writes the rows of a
   moment. */
typedef struct {
  const char *name, *text; /* of the option, and for -help */
  const char *header;      /* of the file, behind "t,step" */
  PetscInt    group[2];    /* numbers that describe one of its things, in 2D and 3D; 0: a switch */
  PetscErrorCode (*Write)(const Flow *flow, const Monitor *monitor);
} MonitorKind;

static const MonitorKind kinds[MONITOR_KINDS] = {
    {"probe_point",
     "Velocity and pressure at points: x,y[,z] of each [m]",
     "point,x,y,z,u,v,w,p",
     {2, 3},
     MonitorPoints},
    {"probe_line",
     "Velocity and pressure along lines: both ends and the number of points of each",
     "line,x,y,z,u,v,w,p",
     {5, 7},
     MonitorLines},
    {"probe_flux",
     "Flux through sections: both ends of each [m]; in 3D a corner and its two neighbours",
     "section,flux",
     {4, 9},
     MonitorFluxes},
    {"probe_forces",
     "Forces and torques of the fluid on each wall",
     "wall,fx,fy,fz,tx,ty,tz",
     {0, 0},
     MonitorForces},
};

struct Monitors {
  Monitor   of[MONITOR_KINDS];
  char      base[PETSC_MAX_PATH_LEN - 32]; /* of the files' names */
  PetscReal every, last;                   /* between rows, 0: every step; of the last ones [s] */
  PetscBool any;
};

/* Ends the run where a file could not be written. Collective. */
static PetscErrorCode MonitorVerdict(const char path[], PetscBool good)
{
  PetscFunctionBegin;
  PetscCall(FirstRankDecides(&good));
  PetscCheck(good, PETSC_COMM_WORLD, PETSC_ERR_FILE_OPEN,
             "-probe_output: cannot write %s, or the disk is full", path);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Points lie in the box; a periodic one goes on. A group is of points, a line's with one number
   more. */
static PetscErrorCode CheckInBox(const Scene *scene, const char option[], PetscInt group,
                                 PetscInt n, const PetscReal number[])
{
  PetscFunctionBegin;
  for (PetscInt k = 0; k < n; k++) {
    const PetscInt  place = k % group, a = place % scene->dim;
    const PetscReal slack = 1e-9 * scene->dx;

    if (place >= group / scene->dim * scene->dim || scene->periodic[a]) continue;
    UserCheck(number[k] >= scene->lo[a] - slack && number[k] <= scene->hi[a] + slack,
              "%s: %c = %.6g lies outside the box, which reaches from %.6g to %.6g", option,
              "xyz"[a], (double)number[k], (double)scene -> lo[a], (double)scene -> hi[a]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The numbers of one option, whole groups of them. */
static PetscErrorCode MonitorRead(OptionItems PetscOptionsObject, const Scene *scene,
                                  const MonitorKind *kind, Monitor *monitor)
{
  const PetscInt group                   = kind->group[scene->dim - 2];
  PetscReal      number[MONITOR_NUMBERS] = {0.0};
  PetscInt       n;
  PetscBool      given;
  char           option[64];

  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(option, sizeof(option), "-%s", kind->name));
  if (!group) {
    PetscCall(OptionSwitch(option, kind->text, &monitor->on));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(OptionReals(option, kind->text, MONITOR_NUMBERS, number, &n, &given));
  if (!given) PetscFunctionReturn(PETSC_SUCCESS);
  UserCheck(n > 0 && n % group == 0,
            "%s: %" PetscInt_FMT " numbers describe each in %" PetscInt_FMT "D, got %" PetscInt_FMT,
            option, group, scene->dim, n);
  PetscCall(CheckInBox(scene, option, group, n, number));
  for (PetscInt k = 0; k < n / group && kind->Write == MonitorPoints; k++)
    UserCheck(!MonitorInBody(scene, &number[k * group]),
              "%s: point %" PetscInt_FMT " at (%.6g, %.6g) lies in a body", option, k,
              (double)number[k * group], (double)number[k * group + 1]);
  monitor->on = PETSC_TRUE;
  monitor->n  = n / group;
  PetscCall(PetscMalloc1(n, &monitor->parameter));
  PetscCall(PetscArraycpy(monitor->parameter, number, n));
  for (PetscInt k = 0; k < monitor->n && kind->Write == MonitorLines; k++) {
    const PetscReal points = number[k * group + group - 1];

    UserCheck(points >= 2.0 && points <= 1e6 && points == PetscFloorReal(points),
              "%s: the number of points of a line must be a whole one from 2 to 1000000, got %.6g",
              option, (double)points);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Opens a file and writes its header, on the first rank. */
static PetscErrorCode MonitorOpen(const MonitorKind *kind, Monitor *monitor)
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
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  MonitorsCreate - Reads what is to be monitored

  Collective on PETSC_COMM_WORLD.

  Options Database Keys:
+ -probe_point x,y,...          - points
. -probe_line x0,y0,x1,y1,n,... - lines with n points each
. -probe_flux x0,y0,x1,y1,...   - sections; the flux counts to the right of the way from end to end
. -probe_forces                 - on each wall
. -probe_every T                - between rows; by default every step [s]
- -probe_output base            - files base_point.csv, base_line.csv, base_flux.csv,
                                  base_forces.csv

  Errors: numbers that do not make whole things end the run
*/
PetscErrorCode MonitorsCreate(const Scene *scene, Monitors **monitors)
{
  Monitors *m;

  PetscFunctionBegin;
  PetscCall(PetscNew(&m));
  m->last = PETSC_NINFINITY;
  PetscOptionsBegin(PETSC_COMM_WORLD, NULL, "Monitors", "");
  for (PetscInt k = 0; k < MONITOR_KINDS; k++) {
    PetscCall(MonitorRead(PetscOptionsObject, scene, &kinds[k], &m->of[k]));
    m->any = m->any || m->of[k].on ? PETSC_TRUE : PETSC_FALSE;
  }
  if (m->any) {
    PetscCall(PetscStrncpy(m->base, "probe", sizeof(m->base)));
    PetscCall(PetscOptionsString("-probe_output", "Beginning of the monitors' file names", "",
                                 m->base, m->base, sizeof(m->base), NULL));
    PetscCall(OptionReal("-probe_every", "Time between rows of the monitors; 0: every step [s]",
                         0.0, 1e300, &m->every, NULL));
  }
  PetscOptionsEnd();
  for (PetscInt k = 0; k < MONITOR_KINDS; k++) {
    if (!m->of[k].on) continue;
    PetscCall(PetscSNPrintf(m->of[k].path, sizeof(m->of[k].path), "%s_%s.csv", m->base,
                            kinds[k].name + strlen("probe_")));
  }
  *monitors = m;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MonitorsDestroy(Monitors **monitors)
{
  PetscFunctionBegin;
  if (!*monitors) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < MONITOR_KINDS; k++) {
    if ((*monitors)->of[k].stream) (void)fclose((*monitors)->of[k].stream);
    PetscCall(PetscFree((*monitors)->of[k].parameter));
  }
  PetscCall(PetscFree(*monitors));
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
  MonitorsRestart - Goes on with the files of the run that is restarted, without what it wrote after
  the checkpoint; files that are absent begin anew

  Collective on PETSC_COMM_WORLD. Input: t - of the checkpoint [s]. Errors: a file that cannot be
  gone on with ends the run and stays as it is
*/
PetscErrorCode MonitorsRestart(PetscReal t, Monitors *m)
{
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  for (PetscInt k = 0; k < MONITOR_KINDS; k++) {
    FILE     *old;
    PetscBool there, good;

    if (!m->of[k].on) continue;
    old   = rank == 0 ? fopen(m->of[k].path, "r") : NULL;
    there = old || (rank == 0 && errno != ENOENT) ? PETSC_TRUE : PETSC_FALSE;
    good  = old && KeepRows(&m->of[k], old, t) ? PETSC_TRUE : PETSC_FALSE;
    if (old) (void)fclose(old);
    PetscCall(FirstRankDecides(&there));
    m->of[k].opened = PETSC_TRUE;
    if (there) PetscCall(MonitorVerdict(m->of[k].path, good));
    else PetscCall(MonitorOpen(&kinds[k], &m->of[k]));
  }
  m->last = t;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  MonitorsWrite - Adds the rows of the present moment, where they are due

  Collective on PETSC_COMM_WORLD. Called at the start and after every step.

  Errors: a file that cannot be written ends the run; what is in it stays
*/
PetscErrorCode MonitorsWrite(const Flow *flow, Monitors *m)
{
  const PetscReal t = flow->clock->t;

  PetscFunctionBegin;
  if (!m->any) PetscFunctionReturn(PETSC_SUCCESS);
  if (m->every > 0.0 && m->last > PETSC_NINFINITY && !ClockPasses(m->every, m->last, t))
    PetscFunctionReturn(PETSC_SUCCESS);
  m->last = t;
  for (PetscInt k = 0; k < MONITOR_KINDS; k++) {
    Monitor  *monitor = &m->of[k];
    PetscBool good    = PETSC_TRUE;

    if (!monitor->on) continue;
    if (!monitor->opened) PetscCall(MonitorOpen(&kinds[k], monitor));
    monitor->opened = PETSC_TRUE;
    PetscCall(kinds[k].Write(flow, monitor));
    if (monitor->stream)
      good = !ferror(monitor->stream) && fflush(monitor->stream) == 0 ? PETSC_TRUE : PETSC_FALSE;
    if (!good) { /* PETSc would stumble over what cannot be flushed */
      (void)fclose(monitor->stream);
      monitor->stream = NULL;
    }
    PetscCall(MonitorVerdict(monitor->path, good));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  MonitorRow - Begins a row on the first rank: t, step and the number of the thing

  Returns: PETSC_FALSE on the other ranks, which write nothing
*/
PetscBool MonitorRow(const Flow *flow, const Monitor *monitor, PetscInt thing)
{
  if (!monitor->stream) return PETSC_FALSE;
  (void)fprintf(monitor->stream, "%.12g,%" PetscInt_FMT ",%" PetscInt_FMT, (double)flow->clock->t,
                flow->clock->step, thing);
  return PETSC_TRUE;
}

/* MonitorVector - Adds the components of a vector to a row, zero for those there are not */
void MonitorVector(const Monitor *monitor, PetscInt dim, const PetscReal v[])
{
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++)
    (void)fprintf(monitor->stream, ",%.12g", a < dim ? (double)v[a] : 0.0);
}
