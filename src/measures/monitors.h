/* Monitors: the kinds of monitors, which monitors.c lists, and the functions for their files. */
#ifndef ISPH_IO_MONITORS_H
#define ISPH_IO_MONITORS_H

#include "isph/io.h"
#include <stdio.h>
#include <string.h>

/* The state of a kind of monitor in a run. */
typedef struct {
  PetscBool  on, opened;
  PetscBool  begins;    /* a restarted run has created its file */
  PetscInt   n;         /* points, lines or sections */
  PetscReal *parameter; /* their coordinates, as given */
  char       path[PETSC_MAX_PATH_LEN];
  FILE      *stream; /* on the first rank */
} Monitor;

/* A kind of monitor: its file, and the function that writes the rows of the present time. */
typedef struct {
  const char *name;     /* name of the file, after the base and _ */
  const char *header;   /* names of the columns after "t,step" */
  PetscInt    group[2]; /* numbers for each point, line or section in 2D and 3D; 0: a switch */
  /* refuses wrong numbers of item k; NULL: accepts any in the box */
  PetscErrorCode (*Check)(const Scene *scene, const char option[], PetscInt k,
                          const PetscReal number[]);
  /* prepares the steps of the flow; NULL: nothing to prepare */
  PetscErrorCode (*Prepare)(Flow *flow, const Monitor *monitor);
  PetscErrorCode (*Write)(const Flow *flow, Monitor *monitor);
} MonitorKind;
/* probemonitors.c */
extern const MonitorKind MonitorPoints, MonitorLines, MonitorFluxes, MonitorForces, MonitorBodies;
/* freemeasure.c */
extern const MonitorKind MonitorVolume;

/* monitorfile.c */
PetscErrorCode MonitorOpen(const MonitorKind *kind, Monitor *monitor);
PetscErrorCode MonitorGoOn(const MonitorKind *kind, PetscReal t, Monitor *monitor);
PetscErrorCode MonitorFlush(Monitor *monitor);
PetscBool      MonitorRow(const Clock *clock, const Monitor *monitor);
void           MonitorVector(const Monitor *monitor, PetscInt dim, const PetscReal v[]);

#endif
