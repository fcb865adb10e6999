/* Monitors: the kinds of monitors, which monitors.c lists, and the functions for their files. */
#ifndef ISPH_IO_MONITORS_H
#define ISPH_IO_MONITORS_H

#include "isph/io.h"
#include <stdio.h>
#include <string.h>

/* Values of the last time T, for their mean; see slidingmean.c. */
typedef struct {
  PetscInt   n, count, capacity; /* values of a time; number of times; room for times */
  PetscReal *row;                /* a time [s], then its n values, for each time */
} Window;

/* The state of a kind of monitor in a run. */
typedef struct {
  PetscBool  on, opened;
  PetscBool  begins;    /* a restarted run has created its file */
  PetscInt   n;         /* points, lines or sections */
  PetscReal *parameter; /* their coordinates, as given */
  PetscInt   n_numbers; /* number of coordinates */
  PetscBool  quiet;     /* the present call adds values to windows and writes no rows */
  PetscReal  T;         /* length of windows; 0: values of the instant [s] */
  PetscInt   n_windows;
  Window    *window; /* values to average, for each group of rows */
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
  /* number of windows; NULL: no values to average */
  PetscInt (*Windows)(const Scene *scene, const Monitor *monitor);
  /* prepares the steps of the flow; NULL: nothing to prepare */
  PetscErrorCode (*Prepare)(Flow *flow, const Monitor *monitor);
  PetscErrorCode (*Write)(const Flow *flow, Monitor *monitor);
} MonitorKind;
/* probemonitors.c */
extern const MonitorKind MonitorPoints, MonitorLines, MonitorFluxes, MonitorBudget, MonitorForces,
    MonitorBodies;
/* freemeasure.c */
extern const MonitorKind MonitorVolume;

/* monitorfile.c */
PetscErrorCode MonitorOpen(const MonitorKind *kind, Monitor *monitor);
PetscErrorCode MonitorGoOn(const MonitorKind *kind, PetscReal t, Monitor *monitor);
PetscErrorCode MonitorFlush(Monitor *monitor);
PetscBool      MonitorRow(const Clock *clock, const Monitor *monitor);
void           MonitorVector(const Monitor *monitor, PetscInt dim, const PetscReal v[]);

/* slidingmean.c */
PetscErrorCode MonitorMean(const Clock *clock, PetscInt k, PetscInt n, PetscReal value[],
                           Monitor *monitor);
PetscInt       WindowPack(const Window *window, PetscReal values[]);
PetscErrorCode WindowUnpack(PetscInt room, const PetscReal values[], Window *window,
                            PetscInt *used);
PetscErrorCode WindowFree(Window *window);

#endif
