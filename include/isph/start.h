/* The start: fills empty particles with fluid and walls. */
#ifndef ISPH_START_H
#define ISPH_START_H

#include "isph/particles.h"

PetscReal      ParticlesExpect(const Scene *scene);
PetscErrorCode ParticlesFill(const Scene *scene, WallPlacement walls, const FluidStart *start,
                             Particles *particles);

#endif
