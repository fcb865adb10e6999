/* The points of the pressure: on particles, or on splines; see pressurepoints.c. */
#ifndef ISPH_SCHEMES_PRESSUREPOINTS_H
#define ISPH_SCHEMES_PRESSUREPOINTS_H

#include "splines/splines.h"

extern const Table       PressurePointsTable;
extern const OptionTable PressurePointsOptions;

/* The points of the pressure. */
typedef struct {
  const char *name, *brief, *citation;
  PetscBool   coarse; /* on splines */
} PressurePointsRow;

PetscErrorCode PressurePointsChoose(const Scene *scene, const PressurePointsRow **chosen);
PetscErrorCode PressureOnSplinesCreate(Flow *flow, PetscReal *spacing);

#endif
