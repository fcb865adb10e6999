/* Vectors over the particles of this rank: of the standard type, so that they meet any matrix. */
#include "isph/operators.h"

/* With storage of its own: `size` values at each of n particles. */
static PetscErrorCode VecOfBlocks(MPI_Comm comm, PetscInt n, PetscInt size, Vec *v)
{
  PetscFunctionBegin;
  PetscCall(VecCreate(comm, v));
  PetscCall(VecSetSizes(*v, size * n, PETSC_DETERMINE));
  PetscCall(VecSetBlockSize(*v, size));
  PetscCall(VecSetType(*v, VECSTANDARD));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode VecOfSize(MPI_Comm comm, PetscInt n, PetscReal array[], Vec *v)
{
  PetscMPIInt size;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(comm, &size));
  if (!array) {
    PetscCall(VecOfBlocks(comm, n, 1, v));
  } else if (size == 1) {
    PetscCall(VecCreateSeqWithArray(comm, 1, n, array, v));
  } else {
    PetscCall(VecCreateMPIWithArray(comm, 1, n, PETSC_DECIDE, array, v));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  FluidVec - Vector of one scalar over the own fluid particles

  Collective. Input: array - a particle field to be seen through the vector, or NULL for storage of
  its own. Valid for the present epoch.
*/
PetscErrorCode FluidVec(const Particles *p, PetscReal array[], Vec *v)
{
  PetscFunctionBegin;
  PetscCall(VecOfSize(p->comm, p->n_fluid, array, v));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* VecRemoveMean - v less its mean: the gauge of pressures; collective */
PetscErrorCode VecRemoveMean(Vec v)
{
  PetscScalar sum;
  PetscInt    N;

  PetscFunctionBegin;
  PetscCall(VecGetSize(v, &N));
  PetscCall(VecSum(v, &sum));
  PetscCall(VecShift(v, -sum / (PetscReal)N));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* WallVec - Vector of one scalar over the own wall particles; collective, valid for the epoch */
PetscErrorCode WallVec(const Particles *p, Vec *v)
{
  PetscFunctionBegin;
  PetscCall(VecOfSize(p->comm, p->n_wall, NULL, v));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* VelocityVec - Vector of dim components at each own fluid particle, its components together;
   collective */
PetscErrorCode VelocityVec(const Particles *p, Vec *v)
{
  PetscFunctionBegin;
  PetscCall(VecOfBlocks(p->comm, p->n_fluid, p->dim, v));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* WallVelocityVec - The same over the own wall particles; collective */
PetscErrorCode WallVelocityVec(const Particles *p, Vec *v)
{
  PetscFunctionBegin;
  PetscCall(VecOfBlocks(p->comm, p->n_wall, p->dim, v));
  PetscFunctionReturn(PETSC_SUCCESS);
}
