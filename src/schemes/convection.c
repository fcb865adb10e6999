/* Convection of velocities past particles that do not move. */
#include "isph/schemes.h"

/*
  ConvectionCentral - (v.grad u)_i by the gradients as they are

  Collective. Input, output: as ConvectionApply().
*/
PetscErrorCode ConvectionCentral(PetscInt dim, const Operators *ops, const Vec v[], Vec u,
                                 Vec walls, Vec work, Vec result)
{
  PetscFunctionBegin;
  PetscCall(VecZeroEntries(result));
  for (PetscInt a = 0; a < dim; a++) {
    PetscCall(AffineApply(&ops->grad_u[a], u, walls, work));
    PetscCall(VecPointwiseMult(work, work, v[a]));
    PetscCall(VecAXPY(result, 1.0, work));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  ConvectionApply - What the flow v carries past fixed particles

    (v.grad u)_i + S max(0, |v_i|/dx - 2 nu/dx^2) (u - fit)_i

  Collective. The second term is what upwind-biased differences have over central ones: it takes
  what changes from one particle to the next in the time the flow passes dx, and is of second order,
  U dx^2 u''', on any cloud (third order on lattices). Without it (-velocity_filter 0) explicit
  steps of the first term alone feed the grid scale where viscosity does not damp it, and only there
  it acts: |v| dx/nu > 2.

  Input Parameters:
+ v     - advecting velocity over fluid [m/s]
. u     - the component that is carried, walls its wall data [m/s]
- work  - a vector to use

  Output Parameter:
. result - [m/s^2]
*/
PetscErrorCode ConvectionApply(const Scene *scene, const Operators *ops, const Vec v[], Vec u,
                               Vec walls, Vec work, Vec result)
{
  const PetscScalar *at[ISPH_MAX_DIM];
  const PetscReal    nu = SceneHas(scene, PHYSICS_VISCOSITY) ? scene->nu_low : 0.0;
  PetscScalar       *rough, *sum;
  PetscInt           n;

  PetscFunctionBegin;
  PetscCall(ConvectionCentral(scene->dim, ops, v, u, walls, work, result));
  if (!ops->filter_u.needed) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(AffineApply(&ops->filter_u, u, walls, work));
  PetscCall(VecGetLocalSize(u, &n));
  PetscCall(VecGetArray(work, &rough));
  PetscCall(VecGetArray(result, &sum));
  for (PetscInt a = 0; a < scene->dim; a++) PetscCall(VecGetArrayRead(v[a], &at[a]));
  for (PetscInt i = 0; i < n; i++) {
    PetscReal speed2 = 0.0;

    for (PetscInt a = 0; a < scene->dim; a++) speed2 += PetscSqr(at[a][i]);
    sum[i] += ops->velocity_filter / scene->dx *
              PetscMax(0.0, PetscSqrtReal(speed2) - 2.0 * nu / scene->dx) * rough[i];
  }
  for (PetscInt a = 0; a < scene->dim; a++) PetscCall(VecRestoreArrayRead(v[a], &at[a]));
  PetscCall(VecRestoreArray(result, &sum));
  PetscCall(VecRestoreArray(work, &rough));
  PetscFunctionReturn(PETSC_SUCCESS);
}
