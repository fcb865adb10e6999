/* The index of a run's snapshots that ParaView opens. */
#ifndef ISPH_IO_XDMF_H
#define ISPH_IO_XDMF_H

#include "isph/io.h"

/* A snapshot that is complete on disk. */
typedef struct {
  PetscInt  number; /* in its file's name */
  PetscReal t;      /* [s] */
  PetscInt  N;      /* particles in it */
} Snapshot;

PetscErrorCode XdmfWrite(const char base[], const Particles *particles, PetscInt n,
                         const Snapshot snapshots[], PetscBool *good);

#endif
