/* The run of a flow: from its scene to its report. */
#ifndef ISPH_RUN_H
#define ISPH_RUN_H

#include "isph/io.h"

extern const OptionTable StartOptions, CheckpointOptions;

PetscErrorCode FlowRun(Scene *scene);

/* Start with the particles of -particles. */
PetscErrorCode StartRead(Scene *scene, FluidStart *start, char path[]);
PetscErrorCode StartFree(FluidStart *start);
PetscErrorCode StartCheck(const Scene *scene, const char path[], const Particles *particles,
                          Neighbors *neighbors);

#endif
