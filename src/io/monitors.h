/* What monitors.c and the files of single monitors share. */
#ifndef ISPH_IO_MONITORS_H
#define ISPH_IO_MONITORS_H

#include "isph/io.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MONITOR_KINDS 4

/* One kind of monitor in force. */
typedef struct {
  PetscBool  on, opened;
  PetscInt   n;         /* things: points, lines, sections */
  PetscReal *parameter; /* that describe them, as given */
  char       path[PETSC_MAX_PATH_LEN];
  FILE      *stream; /* on the first rank */
} Monitor;

PetscBool      MonitorRow(const Flow *flow, const Monitor *monitor, PetscInt thing);
void           MonitorVector(const Monitor *monitor, PetscInt dim, const PetscReal v[]);
PetscBool      MonitorInBody(const Scene *scene, const PetscReal x[]);
PetscErrorCode MonitorPoints(const Flow *flow, const Monitor *monitor);
PetscErrorCode MonitorLines(const Flow *flow, const Monitor *monitor);
PetscErrorCode MonitorFluxes(const Flow *flow, const Monitor *monitor);
PetscErrorCode MonitorForces(const Flow *flow, const Monitor *monitor);

#endif
