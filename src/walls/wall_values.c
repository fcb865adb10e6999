/* Values at boundaries: data of the velocity and the pressure at each own wall particle. Their
   vectors multiply the matrices B of the operators. */
#include "isph/walls.h"

/* WallValuesFree - Frees the vectors; collective */
PetscErrorCode WallValuesFree(WallValues *walls)
{
  PetscFunctionBegin;
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) PetscCall(VecDestroy(&walls->u[a]));
  PetscCall(VecDestroyAll(&walls->p, &walls->p_step));
  walls->epoch = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* WallValuesRenumber - Creates the vectors for the present numbering of wall particles. Collective
   on the particles' communicator. Does nothing within an epoch or without walls; new vectors are
   zero. */
PetscErrorCode WallValuesRenumber(const Scene *scene, const Particles *p, WallValues *walls)
{
  PetscFunctionBegin;
  if (!SceneHas(scene, PHYSICS_WALLS) || walls->epoch == p->epoch)
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(WallValuesFree(walls));
  for (PetscInt a = 0; a < scene->dim; a++) PetscCall(WallVec(p, &walls->u[a]));
  PetscCall(WallVec(p, &walls->p));
  PetscCall(WallVec(p, &walls->p_step));
  walls->epoch = p->epoch;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  WallValuesSetVelocity - Sets the velocity of the own wall particles at time t

    u_w = u_wall(t) + projection_factor p_step n

  u_wall is evaluated at the wall point of the particle; the particle stores it too. The second term
  is for the predicted velocity: the projection will change its normal component by
  -projection_factor n.grad phi, and n.grad phi of the pressure increment phi is p_step. See
  theory.md, (projection:dirichlet). It is absent if the boundary gives the pressure itself. The
  datum of a component whose equation is n.grad u_c is zero. Input: projection_factor - time step of
  the projection over density; 0 gives the wall velocity itself [m^3 s/kg]. Output: walls - u, and
  speed_bound, which never decreases; particles - velocities of wall particles.
*/
PetscErrorCode WallValuesSetVelocity(const Scene *scene, Particles *p, PetscReal t,
                                     PetscReal projection_factor, WallValues *walls)
{
  PetscReal       *u[ISPH_MAX_DIM];
  const PetscReal *gain = NULL;

  PetscFunctionBegin;
  if (!SceneHas(scene, PHYSICS_WALLS)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecGetArrayRead(walls->p_step, &gain));
  for (PetscInt a = 0; a < scene->dim; a++) PetscCall(VecGetArray(walls->u[a], &u[a]));
  for (PetscInt k = 0; k < p->n_wall; k++) {
    const PetscInt  i        = p->n_fluid + k;
    const PetscInt  side     = (PetscInt)p->side[i];
    const Equation  pressure = BoundaryEquation(scene, side, FIT_PRESSURE);
    const PetscReal step     = pressure == EQUATION_NORMAL_DERIVATIVE ? gain[k] : 0.0;
    PetscReal       x[ISPH_MAX_DIM], velocity[ISPH_MAX_DIM], normal[ISPH_MAX_DIM], bound;

    ParticlesWallPoint(p, i, x);
    SceneWallVelocity(scene, side, t, x, velocity);
    for (PetscInt a = 0; a < scene->dim; a++) {
      p->u[a][i] = velocity[a];
      u[a][k]    = velocity[a] + projection_factor * step * p->normal[a][i];
      if (BoundaryVelocityEquation(scene, side, a) == EQUATION_NORMAL_DERIVATIVE) u[a][k] = 0.0;
      normal[a] = p->normal[a][i];
    }
    bound              = SceneWallSpeedBound(scene, side, x, normal, velocity);
    walls->speed_bound = PetscMax(walls->speed_bound, bound);
  }
  PetscCall(VecRestoreArrayRead(walls->p_step, &gain));
  for (PetscInt a = 0; a < scene->dim; a++) PetscCall(VecRestoreArray(walls->u[a], &u[a]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the pressure datum of the boundary at own wall particle w. */
static PetscReal FullPressure(const Scene *scene, const Particles *p, PetscInt w, PetscReal t)
{
  const PetscInt i = p->n_fluid + w;
  PetscReal      x[ISPH_MAX_DIM], normal[ISPH_MAX_DIM];

  ParticlesWallPoint(p, i, x);
  for (PetscInt a = 0; a < scene->dim; a++) normal[a] = p->normal[a][i];
  return SceneWallPressure(scene, (PetscInt)p->side[i], t, x, normal);
}

/* WallValuesSetPressure - Sets the pressure data of the own wall particles at time t. Input: share
   - of the full data, less the level of the scene for values; the pressure of a flow that starts
   from the level has no gradient yet [-]. Output: walls - p; p_step is zero. */
PetscErrorCode WallValuesSetPressure(const Scene *scene, const Particles *p, PetscReal t,
                                     PetscReal share, WallValues *walls)
{
  PetscScalar *value;

  PetscFunctionBegin;
  if (!walls->p) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecGetArray(walls->p, &value));
  for (PetscInt w = 0; w < p->n_wall; w++) {
    const PetscInt  side  = (PetscInt)p->side[p->n_fluid + w];
    const PetscBool given = BoundaryEquation(scene, side, FIT_PRESSURE) == EQUATION_VALUE;
    const PetscReal rest  = given ? scene->level : 0.0;

    value[w] = rest + share * (FullPressure(scene, p, w, t) - rest);
  }
  PetscCall(VecRestoreArray(walls->p, &value));
  PetscCall(VecZeroEntries(walls->p_step));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* WallValuesStepPressure - Sets p_step to the change from p to the full data at time t */
PetscErrorCode WallValuesStepPressure(const Scene *scene, const Particles *p, PetscReal t,
                                      WallValues *walls)
{
  const PetscScalar *value;
  PetscScalar       *step;

  PetscFunctionBegin;
  if (!walls->p) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecGetArrayRead(walls->p, &value));
  PetscCall(VecGetArray(walls->p_step, &step));
  for (PetscInt w = 0; w < p->n_wall; w++) step[w] = FullPressure(scene, p, w, t) - value[w];
  PetscCall(VecRestoreArrayRead(walls->p, &value));
  PetscCall(VecRestoreArray(walls->p_step, &step));
  PetscFunctionReturn(PETSC_SUCCESS);
}
