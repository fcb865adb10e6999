/*
  What the files of this stage share: storage, the first lattice, decomposition, migration and halo.
*/
#ifndef ISPH_PARTICLES_IMPL_H
#define ISPH_PARTICLES_IMPL_H

#include "isph/particles.h"

/* particles.c */
PetscErrorCode ParticlesReserve(Particles *p, PetscInt n);

/* epoch.c */
PetscErrorCode ParticlesLargestMove(const Particles *p, PetscReal *const from[], PetscReal *move);

/* lattice.c */
PetscErrorCode LatticeFill(const Scene *scene, WallPlacement walls, const FluidStart *start,
                           Particles *p);

/* decompose.c */
PetscErrorCode ParticlesDecompose(const Scene *scene, Particles *p, PetscInt owner[]);

/* migrate.c */
PetscErrorCode ParticlesMigrate(const Scene *scene, Particles *p, const PetscInt owner[]);

/* halo.c */
PetscErrorCode HaloBuild(const Scene *scene, Particles *p);

/* exchange.c */
PetscErrorCode ExchangeItems(MPI_Comm comm, MPI_Datatype unit, PetscInt width,
                             const PetscInt n_to[], const void *send, PetscMPIInt *n_sources,
                             PetscMPIInt **source, PetscInt **n_from, void *recv);

#endif
