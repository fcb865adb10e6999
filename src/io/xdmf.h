/* The index of a run's snapshots for ParaView. */
#ifndef ISPH_IO_XDMF_H
#define ISPH_IO_XDMF_H

#include "isph/io.h"

/* A complete snapshot on disk. */
typedef struct {
  PetscInt  number; /* number in the name of its file */
  PetscReal t;      /* [s] */
  PetscInt  N;      /* number of particles */
} Snapshot;

PetscErrorCode XdmfWrite(const char base[], const Particles *particles, PetscInt n,
                         const Snapshot snapshots[], PetscBool *good);

#endif
