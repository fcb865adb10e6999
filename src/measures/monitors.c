/* Monitors: quantities measured in the course of a run. probemonitors.c and freemeasure.c define
   the kinds of monitors; monitorfile.c writes their files. */
#include "monitors.h"

#define MONITOR_NUMBERS 256 /* most numbers of an option */

enum { POINT, LINE, FLUX, FORCES, BODIES, VOLUME, EVERY, BASE };
static const OptionRow options[] = {
    [POINT] =
        OPTION(REALS, "-probe_point", "velocity and pressure at points: x,y[,z] of each point", "m",
               NULL, .where = "flows"),
    [LINE] =
        OPTION(REALS, "-probe_line",
               "velocity and pressure along lines: both ends and the number of points of each line",
               "m", NULL, .where = "flows"),
    [FLUX]   = OPTION(REALS, "-probe_flux",
                      "flux through sections: both ends of each section; in 3D a corner and "
                        "the two "
                        "corners beside it",
                      "m", NULL, .where = "flows"),
    [FORCES] = OPTION(SWITCH, "-probe_forces", "forces and torques of the fluid on each wall", NULL,
                      "false", .also = " drag lift ", .where = "flows"),
    [BODIES] = OPTION(SWITCH, "-probe_bodies",
                      "place, attitude and motion of each body; force and torque of the fluid on "
                      "it, their power and their error bars",
                      NULL, "false", .where = "flows with bodies"),
    [VOLUME] = OPTION(SWITCH, "-probe_volume", "volume inside the free surface, and its error",
                      NULL, "false", .where = "flows with a free surface"),
    [EVERY]  = OPTION(REAL, "-probe_every",
                      "rows after the first step at or past each multiple of this time, with the "
                       "time of the step; 0: after every step; steps do not change",
                      "s", "0", NOT_NEGATIVE, .where = "flows with a probe"),
    [BASE]   = OPTION(FILE, "-probe_output",
                      "beginning of the names of files: base_point.csv, base_line.csv, ...", NULL,
                      "probe", .where = "flows with a probe"),
};
const OptionTable MonitorOptions = OPTIONS("Probes", options);

/* Kinds of monitors in the order of their options. */
static const MonitorKind *const kinds[] = {
    [POINT] = &MonitorPoints,  [LINE] = &MonitorLines,    [FLUX] = &MonitorFluxes,
    [FORCES] = &MonitorForces, [BODIES] = &MonitorBodies, [VOLUME] = &MonitorVolume,
};
#define MONITOR_KINDS PETSC_STATIC_ARRAY_LENGTH(kinds)

struct Monitors {
  Monitor   of[MONITOR_KINDS];
  char      base[PETSC_MAX_PATH_LEN]; /* beginning of the file names */
  PetscReal every, last;              /* interval, 0: every step; time of the last rows [s] */
  PetscBool any;
};

/* Refuses points outside the box, except along periodic axes. The numbers of a group are
   coordinates of points; the group of a line ends with a number of points. */
static PetscErrorCode CheckInBox(const Scene *scene, const char option[], PetscInt group,
                                 PetscInt n, const PetscReal number[])
{
  PetscFunctionBegin;
  for (PetscInt k = 0; k < n; k++) {
    const PetscInt  place = k % group, a = place % scene->dim;
    const PetscReal slack = 1e-9 * SceneTolerance(scene);

    if (place >= group / scene->dim * scene->dim || SceneIsPeriodic(scene, a)) continue;
    UserCheck(number[k] >= scene->lo[a] - slack && number[k] <= scene->hi[a] + slack,
              "%s: %c = %.6g lies outside the box, which reaches from %.6g to %.6g", option,
              "xyz"[a], (double)number[k], (double)scene -> lo[a], (double)scene -> hi[a]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the numbers of an option; they must form complete points, lines or sections. */
static PetscErrorCode MonitorRead(const Scene *scene, const OptionRow *row, const MonitorKind *kind,
                                  Monitor *monitor)
{
  const char    *option                  = row->name;
  const PetscInt group                   = kind->group[scene->dim - 2];
  PetscReal      number[MONITOR_NUMBERS] = {0.0};
  PetscInt       n;
  PetscBool      given;

  PetscFunctionBegin;
  if (!group) {
    PetscCall(OptionGetSwitch(row, &monitor->on, NULL));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(OptionGetReals(row, MONITOR_NUMBERS, number, &n, &given));
  if (!given) PetscFunctionReturn(PETSC_SUCCESS);
  UserCheck(n > 0 && n % group == 0,
            "%s: each item has %" PetscInt_FMT " numbers in %" PetscInt_FMT "D, got %" PetscInt_FMT,
            option, group, scene->dim, n);
  PetscCall(CheckInBox(scene, option, group, n, number));
  for (PetscInt k = 0; k < n / group && kind->Check; k++)
    PetscCall(kind->Check(scene, option, k, &number[k * group]));
  monitor->on = PETSC_TRUE;
  monitor->n  = n / group;
  PetscCall(PetscMalloc1(n, &monitor->parameter));
  PetscCall(PetscArraycpy(monitor->parameter, number, n));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* MonitorsCreate - Reads the options of monitors; collective on PETSC_COMM_WORLD */
PetscErrorCode MonitorsCreate(Flow *flow, Monitors **monitors)
{
  const Scene *scene = flow->scene;
  Monitors    *m;

  PetscFunctionBegin;
  PetscCall(PetscNew(&m));
  m->last = PETSC_NINFINITY;
  for (size_t k = 0; k < MONITOR_KINDS; k++) {
    PetscCall(MonitorRead(scene, &options[k], kinds[k], &m->of[k]));
    m->any = m->any || m->of[k].on;
  }
  if (m->any) {
    PetscCall(OptionGetFile(&options[BASE], m->base));
    if (!m->base[0]) PetscCall(PetscStrncpy(m->base, options[BASE].standard, sizeof(m->base)));
    PetscCall(OptionGetReal(&options[EVERY], &m->every, NULL));
  }
  for (size_t k = 0; k < MONITOR_KINDS; k++) {
    if (!m->of[k].on) continue;
    if (kinds[k]->Prepare) PetscCall(kinds[k]->Prepare(flow, &m->of[k]));
    PetscCall(
        PetscSNPrintf(m->of[k].path, sizeof(m->of[k].path), "%s_%s.csv", m->base, kinds[k]->name));
  }
  *monitors = m;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MonitorsDestroy(Monitors **monitors)
{
  PetscFunctionBegin;
  if (!*monitors) PetscFunctionReturn(PETSC_SUCCESS);
  for (size_t k = 0; k < MONITOR_KINDS; k++) {
    Monitor *monitor = &(*monitors)->of[k];

    if (monitor->stream) (void)fclose(monitor->stream);
    PetscCall(PetscFree(monitor->parameter));
  }
  PetscCall(PetscFree(*monitors));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* MonitorsRestart - Opens the files of a run that is restarted and removes rows later than its
   checkpoint; creates absent files. Collective on PETSC_COMM_WORLD. Input: t - time of the
   checkpoint [s]. Errors: a file that cannot be continued ends the run and stays unchanged. */
PetscErrorCode MonitorsRestart(PetscReal t, Monitors *m)
{
  PetscFunctionBegin;
  for (size_t k = 0; k < MONITOR_KINDS; k++) {
    if (m->of[k].on) PetscCall(MonitorGoOn(kinds[k], t, &m->of[k]));
  }
  m->last = t;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* MonitorsWrite - Writes the rows of the present time, if they are due; collective on
   PETSC_COMM_WORLD. Called at the start and after every step. */
PetscErrorCode MonitorsWrite(const Flow *flow, Monitors *m)
{
  const PetscReal t = flow->clock->t;
  PetscBool       due;

  PetscFunctionBegin;
  if (!m->any) PetscFunctionReturn(PETSC_SUCCESS);
  due = m->every == 0.0 || m->last == PETSC_NINFINITY ? PETSC_TRUE
                                                      : ClockPasses(m->every, m->last, t);
  if (!due) PetscFunctionReturn(PETSC_SUCCESS);
  m->last = t;
  for (size_t k = 0; k < MONITOR_KINDS; k++) {
    Monitor *monitor = &m->of[k];

    if (!monitor->on) continue;
    PetscCall(FlowPrepareOutput(flow));
    if (!monitor->opened) PetscCall(MonitorOpen(kinds[k], monitor));
    PetscCall(kinds[k]->Write(flow, monitor));
    PetscCall(MonitorFlush(monitor));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* MonitorsBegin - Writes the rows of the present time to files that a restarted run has created, as
   at the start of any other run; collective */
PetscErrorCode MonitorsBegin(const Flow *flow, Monitors *m)
{
  PetscFunctionBegin;
  for (size_t k = 0; k < MONITOR_KINDS; k++) {
    Monitor *monitor = &m->of[k];

    if (!monitor->on || !monitor->begins) continue;
    PetscCall(FlowPrepareOutput(flow));
    PetscCall(kinds[k]->Write(flow, monitor));
    PetscCall(MonitorFlush(monitor));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
