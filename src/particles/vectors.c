/* Vectors over fluid or wall particles, which allocate their storage or share that of a field. */
#include "isph/particles.h"

/* Creates a vector of n values in blocks, which allocates its storage. */
static PetscErrorCode VecOfType(MPI_Comm comm, PetscInt n, PetscInt block, Vec *v)
{
  PetscFunctionBegin;
  PetscCall(VecCreate(comm, v));
  PetscCall(VecSetSizes(*v, n, PETSC_DETERMINE));
  PetscCall(VecSetBlockSize(*v, block));
  PetscCall(VecSetType(*v, VECSTANDARD));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode VecOfSize(MPI_Comm comm, PetscInt n, PetscReal array[], Vec *v)
{
  PetscMPIInt size;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(comm, &size));
  if (!array) {
    PetscCall(VecOfType(comm, n, 1, v));
  } else if (size == 1) {
    PetscCall(VecCreateSeqWithArray(comm, 1, n, array, v));
  } else {
    PetscCall(VecCreateMPIWithArray(comm, 1, n, PETSC_DECIDE, array, v));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FluidVec - Creates a vector of a scalar over the own fluid particles. Collective. Input: array -
   particle field that becomes the storage of the vector; NULL: the vector allocates its storage.
   The vector is valid for the present epoch. */
PetscErrorCode FluidVec(const Particles *p, PetscReal array[], Vec *v)
{
  PetscFunctionBegin;
  PetscCall(VecOfSize(p->comm, p->n_fluid, array, v));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FluidSumOwn - Sums f, or f^2 if `squared`, over the own fluid, weighted by ParticlesWeight() */
PetscErrorCode FluidSumOwn(const Particles *p, Vec f, PetscBool squared, PetscReal *sum)
{
  const PetscScalar *value;
  PetscReal          own = 0.0;

  PetscFunctionBegin;
  PetscCall(VecGetArrayRead(f, &value));
  for (PetscInt i = 0; i < p->n_fluid; i++)
    own += ParticlesWeight(p, i) * (squared ? PetscSqr(value[i]) : value[i]);
  PetscCall(VecRestoreArrayRead(f, &value));
  *sum = own;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FluidSum - Sums f, or f^2 if `squared`, over the fluid of all ranks, see FluidSumOwn().
   Collective. The sum divided by particles->weight is the mean over the volume of the fluid:
   theory.md, (particles:means). */
PetscErrorCode FluidSum(const Particles *p, Vec f, PetscBool squared, PetscReal *sum)
{
  PetscFunctionBegin;
  PetscCall(FluidSumOwn(p, f, squared, sum));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 1, MPIU_REAL, MPIU_SUM, p->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FluidRemoveMean - Subtracts from f its mean over the volume of the fluid; collective */
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

/* LocalValues - Collects the values of a scalar by local index, without the halo. Input: f, walls -
   values over own fluid and own wall particles; NULL: zeros; step - distance of the values of
   consecutive particles. Output: value - of the own particles. */
PetscErrorCode LocalValues(const Particles *p, Vec f, Vec walls, PetscInt step, PetscReal value[])
{
  const Vec          own[] = {f, walls};
  const PetscInt     n[]   = {p->n_fluid, p->n_wall};
  const PetscScalar *v;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < 2; value += step * n[k++]) {
    if (!own[k]) {
      for (PetscInt i = 0; i < n[k]; i++) value[step * i] = 0.0;
      continue;
    }
    PetscCall(VecGetArrayRead(own[k], &v));
    for (PetscInt i = 0; i < n[k]; i++) value[step * i] = v[i];
    PetscCall(VecRestoreArrayRead(own[k], &v));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* VelocityVec - Creates a vector of dim interlaced components over the own fluid particles;
   collective */
PetscErrorCode VelocityVec(const Particles *p, Vec *v)
{
  PetscFunctionBegin;
  PetscCall(VecOfType(p->comm, p->dim * p->n_fluid, p->dim, v));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* WallVelocityVec - Creates a vector of dim components over the own wall particles; collective */
PetscErrorCode WallVelocityVec(const Particles *p, Vec *v)
{
  PetscFunctionBegin;
  PetscCall(VecOfType(p->comm, p->dim * p->n_wall, p->dim, v));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* UnknownsVec - Creates a vector of the velocities of the own fluid particles, with interlaced
   components, and then of n pressures; collective */
PetscErrorCode UnknownsVec(const Particles *p, PetscInt n, Vec *v)
{
  PetscFunctionBegin;
  PetscCall(VecOfType(p->comm, p->dim * p->n_fluid + n, 1, v));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* VelocityRowsDivide - Multiplies the rows of velocity component a of own fluid particle i by
   factor/by[a][i]; collective */
PetscErrorCode VelocityRowsDivide(const Particles *p, PetscReal *const by[], PetscReal factor,
                                  Mat rows)
{
  PetscScalar *to;
  Vec          scale;

  PetscFunctionBegin;
  PetscCall(MatCreateVecs(rows, NULL, &scale));
  PetscCall(VecGetArrayWrite(scale, &to));
  for (PetscInt r = 0; r < p->dim * p->n_fluid; r++) to[r] = factor / by[r % p->dim][r / p->dim];
  PetscCall(VecRestoreArrayWrite(scale, &to));
  PetscCall(MatDiagonalScale(rows, scale, NULL));
  PetscCall(VecDestroy(&scale));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* VelocityVecRepeat - Creates a vector with a factor of each particle in the rows of its velocity
   components; collective */
PetscErrorCode VelocityVecRepeat(const Particles *p, Vec factor, Vec *rows)
{
  PetscFunctionBegin;
  PetscCall(VelocityVec(p, rows));
  for (PetscInt c = 0; c < p->dim; c++)
    PetscCall(VecStrideScatter(factor, c, *rows, INSERT_VALUES));
  PetscFunctionReturn(PETSC_SUCCESS);
}
