/*
  Values at walls: velocity and wall pressure gradient of each own wall particle. Their vectors
  multiply the matrices B of the operators.
*/
#include "isph/operators.h"

/* WallValuesFree - Frees the vectors; collective */
PetscErrorCode WallValuesFree(WallValues *walls)
{
  PetscFunctionBegin;
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) PetscCall(VecDestroy(&walls->u[a]));
  PetscCall(VecDestroy(&walls->dpdn));
  PetscCall(VecDestroy(&walls->dpdn_step));
  walls->epoch = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  WallValuesRenumber - Creates the vectors for the present numbering of wall particles

  Collective on the particles' communicator. Does nothing within an epoch or without walls; new
  vectors are zero.
*/
PetscErrorCode WallValuesRenumber(const Scene *scene, const Particles *p, WallValues *walls)
{
  PetscFunctionBegin;
  if (!SceneHas(scene, PHYSICS_WALLS) || walls->epoch == p->epoch)
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(WallValuesFree(walls));
  for (PetscInt a = 0; a < scene->dim; a++) PetscCall(WallVec(p, &walls->u[a]));
  PetscCall(WallVec(p, &walls->dpdn));
  PetscCall(WallVec(p, &walls->dpdn_step));
  walls->epoch = p->epoch;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  WallValuesSetVelocity - Sets the velocity of the own wall particles at time t

    u_w = u_wall(t) + projection_factor dpdn_step n

  Not collective. u_wall is evaluated at the wall point of the particle; the particle stores it too.
  The second term is for the predicted velocity: the projection will change its normal component by
  -projection_factor n.grad phi, and n.grad phi of the pressure increment phi is dpdn_step. See
  docs/theory.md, (88).

  Input Parameter:
. projection_factor - time step of the projection over density; 0 gives the wall velocity itself
                      [m^3 s/kg]

  Output Parameters:
+ walls     - u, and speed_bound, which never decreases
- particles - velocities of wall particles
*/
PetscErrorCode WallValuesSetVelocity(const Scene *scene, Particles *p, PetscReal t,
                                     PetscReal projection_factor, WallValues *walls)
{
  PetscReal       *u[ISPH_MAX_DIM];
  const PetscReal *dpdn = NULL;

  PetscFunctionBegin;
  if (!SceneHas(scene, PHYSICS_WALLS)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecGetArrayRead(walls->dpdn_step, &dpdn));
  for (PetscInt a = 0; a < scene->dim; a++) PetscCall(VecGetArray(walls->u[a], &u[a]));
  for (PetscInt k = 0; k < p->n_wall; k++) {
    const PetscInt i    = p->n_fluid + k;
    const PetscInt side = (PetscInt)p->side[i];
    PetscReal      x[ISPH_MAX_DIM], velocity[ISPH_MAX_DIM], normal[ISPH_MAX_DIM], bound;

    ParticlesWallPoint(p, i, x);
    SceneWallVelocity(scene, side, t, x, velocity);
    for (PetscInt a = 0; a < scene->dim; a++) {
      p->u[a][i] = velocity[a];
      u[a][k]    = velocity[a] + projection_factor * dpdn[k] * p->normal[a][i];
      normal[a]  = p->normal[a][i];
    }
    bound              = SceneWallSpeedBound(scene, side, x, normal, velocity);
    walls->speed_bound = PetscMax(walls->speed_bound, bound);
  }
  PetscCall(VecRestoreArrayRead(walls->dpdn_step, &dpdn));
  for (PetscInt a = 0; a < scene->dim; a++) PetscCall(VecRestoreArray(walls->u[a], &u[a]));
  PetscFunctionReturn(PETSC_SUCCESS);
}
