/*
  The pressure of the coupled system on B-splines, whose lattice is coarser than the particles:

    [ T (shift - nu L)   dx G  ] [u]   [T f         ]
    [ dx D               c c^T ] [q] = [- dx D_w u_w]

  G is the gradient of the splines at the particles, D u + D_w u_w the weak divergence of splines.h.
  The splines have no mode on the grid that G does not see, so no block C is needed. Splines without
  fluid have the equation q = 0, and the numbers that sides give theirs. For particles of several
  sizes or viscosities q has the unit rho dx_q/T_q, with means of dx_i/T_i over the particles that
  have a part in D; see theory.md, (coupled:splines).
*/
#include "saddle.h"
#include "splines/splines.h"

/* Replaces the entries of a matrix by their magnitudes. */
static PetscErrorCode MakeAbsolute(Mat A)
{
  PetscInt     n_parts = 1;
  Mat          part[2] = {A, NULL};
  PetscBool    spread;
  PetscScalar *entry;
  MatInfo      info;

  PetscFunctionBegin;
  PetscCall(PetscObjectBaseTypeCompare((PetscObject)A, MATMPIAIJ, &spread));
  if (spread) PetscCall(MatMPIAIJGetSeqAIJ(A, &part[0], &part[1], NULL));
  if (spread) n_parts = 2;
  for (PetscInt k = 0; k < n_parts; k++) {
    PetscCall(MatGetInfo(part[k], MAT_LOCAL, &info));
    PetscCall(MatSeqAIJGetArray(part[k], &entry));
    for (PetscInt e = 0; e < (PetscInt)info.nz_used; e++) entry[e] = PetscAbsScalar(entry[e]);
    PetscCall(MatSeqAIJRestoreArray(part[k], &entry));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns true if all particles have the same size and viscosity. */
static PetscBool IsUniform(const Flow *flow)
{
  return !flow->particles->nu && SceneFinest(flow->scene) == SceneCoarsest(flow->scene);
}

/* Computes for each spline the means of numbers of particles, with the magnitudes of D as weights;
   splines without fluid have 1. */
static PetscErrorCode MeansOnSplines(const Particles *p, const Saddle *s, PetscInt n,
                                     const Vec of_particles[], Vec *means[])
{
  Mat                weights;
  Vec                rows, sum;
  const PetscScalar *all;
  PetscScalar       *mean;

  PetscFunctionBegin;
  PetscCall(MatDuplicate(s->D, MAT_COPY_VALUES, &weights));
  PetscCall(MakeAbsolute(weights));
  PetscCall(MatCreateVecs(weights, NULL, &sum));
  PetscCall(MatGetRowSum(weights, sum));
  for (PetscInt k = 0; k < n; k++) {
    PetscCall(VecDuplicate(sum, means[k]));
    PetscCall(VelocityVecRepeat(p, of_particles[k], &rows));
    PetscCall(MatMult(weights, rows, *means[k]));
    PetscCall(VecDestroy(&rows));
    PetscCall(VecGetArrayRead(sum, &all));
    PetscCall(VecGetArray(*means[k], &mean));
    for (PetscInt q = 0; q < s->n_p; q++) mean[q] = all[q] > 0.0 ? mean[q] / all[q] : 1.0;
    PetscCall(VecRestoreArray(*means[k], &mean));
    PetscCall(VecRestoreArrayRead(sum, &all));
  }
  PetscCall(VecDestroy(&sum));
  PetscCall(MatDestroy(&weights));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SaddleOnSplines - Creates the blocks G, D and C of a pressure on splines and its units; on entry
   the units are those of the particles. Collective. Input: momentum - T_i/T of momentum rows. */
PetscErrorCode SaddleOnSplines(const Flow *flow, Vec momentum, Saddle *s)
{
  const Splines  *sp             = flow->scheme->splines;
  const PetscReal dx             = flow->scene->dx;
  const Vec       of_particles[] = {s->pressure, s->viscosity};
  Vec             pressure, viscosity, diagonal;

  PetscFunctionBegin;
  s->n_p = sp->fluids * sp->own.size;
  PetscCall(SplinesBlocks(flow->particles, sp, &s->G, &s->D));
  if (IsUniform(flow)) {
    PetscCall(VecDuplicate(sp->all, &pressure));
    PetscCall(VecSet(pressure, 1.0));
    PetscCall(VecDuplicate(pressure, &viscosity));
    PetscCall(VecCopy(pressure, viscosity));
  } else {
    PetscCall(
        MeansOnSplines(flow->particles, s, 2, of_particles, (Vec *[]){&pressure, &viscosity}));
  }
  PetscCall(VecDestroyAll(&s->pressure, &s->viscosity, &s->mass));
  s->pressure  = pressure;
  s->viscosity = viscosity;
  PetscCall(VecDuplicate(sp->all, &s->mass));
  PetscCall(VecSet(s->mass, 1.0));
  PetscCall(MatDiagonalScale(s->G, momentum, s->pressure));
  PetscCall(MatScale(s->G, dx));
  PetscCall(MatScale(s->D, dx));
  PetscCall(VecDuplicate(s->mass, &s->constant));
  PetscCall(VecDuplicate(s->mass, &diagonal));
  PetscCall(VecSet(s->constant, 1.0));
  PetscCall(VecZeroEntries(diagonal));
  for (PetscInt k = 0; k < sp->n_unused; k++) {
    const PetscInt row = sp->fluids * sp->own.start + sp->unused[k];
    PetscInt       index[ISPH_MAX_DIM], side;

    (void)SplineOwn(sp, sp->unused[k], index);
    PetscCall(VecSetValue(diagonal, row, 1.0, INSERT_VALUES));
    if (SplineIsGiven(&sp->lattice, index, &side))
      PetscCall(VecSetValue(s->constant, row, 2.0, INSERT_VALUES));
  }
  for (PetscInt k = 0; sp->slave && k < s->n_p; k++)
    if (sp->slave[k])
      PetscCall(VecSetValue(diagonal, sp->fluids * sp->own.start + k, 1.0, INSERT_VALUES));
  PetscCall(VecAssemblyBegin(s->constant));
  PetscCall(VecAssemblyEnd(s->constant));
  PetscCall(VecAssemblyBegin(diagonal));
  PetscCall(VecAssemblyEnd(diagonal));
  PetscCall(MatCreateAIJ(flow->particles->comm, s->n_p, s->n_p, PETSC_DETERMINE, PETSC_DETERMINE, 1,
                         NULL, 0, NULL, &s->C));
  PetscCall(MatDiagonalSet(s->C, diagonal, INSERT_VALUES));
  PetscCall(VecDestroy(&diagonal));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SaddleAddGiven - Adds the numbers that sides give at time t to their rows of b; not collective */
PetscErrorCode SaddleAddGiven(const Saddle *s, PetscReal t, const Splines *sp, Vec b)
{
  const PetscScalar *number, *unit, *constant;
  PetscScalar       *to;

  PetscFunctionBegin;
  if (!SplineSideGives(&sp->lattice)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecSet(sp->b, 0.0));
  PetscCall(SplinesGivePressure(t, PETSC_FALSE, sp, sp->b));
  PetscCall(VecGetArrayRead(sp->b, &number));
  PetscCall(VecGetArrayRead(s->pressure, &unit));
  PetscCall(VecGetArrayRead(s->constant, &constant));
  PetscCall(VecGetArray(b, &to));
  for (PetscInt k = 0; k < s->n_p; k++)
    if (constant[k] > 1.0)
      to[s->dim * s->n + k] = (number[k] - s->level * constant[k]) / (s->unit * unit[k]);
  PetscCall(VecRestoreArray(b, &to));
  PetscCall(VecRestoreArrayRead(s->constant, &constant));
  PetscCall(VecRestoreArrayRead(s->pressure, &unit));
  PetscCall(VecRestoreArrayRead(sp->b, &number));
  PetscFunctionReturn(PETSC_SUCCESS);
}
