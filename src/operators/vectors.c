/* Vectors over fluid or wall particles. Their type is VECSTANDARD, which works with any matrix
   type. */
#include "isph/operators.h"

/* Creates a vector of `size` values at each of n particles, with its own storage. */
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
  FluidVec - Creates a vector of a scalar over the own fluid particles

  Collective. Input: array - particle field that becomes the storage of the vector; NULL: the vector
  allocates its storage. The vector is valid for the present epoch.
*/
PetscErrorCode FluidVec(const Particles *p, PetscReal array[], Vec *v)
{
  PetscFunctionBegin;
  PetscCall(VecOfSize(p->comm, p->n_fluid, array, v));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  FluidSum - Sums f, or f^2 if `squared`, over the fluid of all ranks, weighted by ParticlesWeight()

  Collective. The sum divided by particles->weight is the mean over the volume of the fluid.
*/
PetscErrorCode FluidSum(const Particles *p, Vec f, PetscBool squared, PetscReal *sum)
{
  const PetscScalar *value;
  PetscReal          own = 0.0;

  PetscFunctionBegin;
  PetscCall(VecGetArrayRead(f, &value));
  for (PetscInt i = 0; i < p->n_fluid; i++)
    own += ParticlesWeight(p, i) * (squared ? PetscSqr(value[i]) : value[i]);
  PetscCall(VecRestoreArrayRead(f, &value));
  PetscCallMPI(MPI_Allreduce(&own, sum, 1, MPIU_REAL, MPIU_SUM, p->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FluidRemoveMean - Subtracts the mean over the volume of the fluid; collective */
PetscErrorCode FluidRemoveMean(const Particles *p, Vec f)
{
  PetscReal sum;

  PetscFunctionBegin;
  PetscCall(FluidSum(p, f, PETSC_FALSE, &sum));
  PetscCall(VecShift(f, -sum / p->weight));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* WallVec - Creates a vector of a scalar over the own wall particles, valid for the present epoch;
   collective */
PetscErrorCode WallVec(const Particles *p, Vec *v)
{
  PetscFunctionBegin;
  PetscCall(VecOfSize(p->comm, p->n_wall, NULL, v));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* VelocityVec - Creates a vector of dim interlaced components over the own fluid particles;
   collective */
PetscErrorCode VelocityVec(const Particles *p, Vec *v)
{
  PetscFunctionBegin;
  PetscCall(VecOfBlocks(p->comm, p->n_fluid, p->dim, v));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* WallVelocityVec - Creates a vector of dim components over the own wall particles; collective */
PetscErrorCode WallVelocityVec(const Particles *p, Vec *v)
{
  PetscFunctionBegin;
  PetscCall(VecOfBlocks(p->comm, p->n_wall, p->dim, v));
  PetscFunctionReturn(PETSC_SUCCESS);
}
