/*
  Functions that return properties of a scene: physics, dimensionless numbers and force.
  scenecreate.c creates the scene; for its lattice see spacing.c.
*/
#include "isph/scene.h"

const char *const PhysicsNames[PHYSICS_COUNT + 1] = {"viscosity", "pressure",   "convection",
                                                     "walls",     "body_force", NULL};

/* Both motions use the same arbitrary Lagrangian-Eulerian step; only the velocity of the particles
   differs. */
static const MotionRow motions[] = {
    {
        .name           = "lagrangian",
        .brief          = "particles move with the flow and are shifted",
        .citation       = "",
        .particles_move = PETSC_TRUE,
    },
    {
        .name     = "eulerian",
        .brief    = "particles stay; du/dt gains -u.grad u; operators are built once",
        .citation = "",
    },
};
const Table MotionTable = TABLE("Motions", motions);

/* ScenePlaceText - Writes the coordinates of x, separated by commas; returns the text; not
   collective */
const char *ScenePlaceText(const Scene *scene, const PetscReal x[], char text[PLACE_TEXT])
{
  if (scene->dim == 2) (void)snprintf(text, PLACE_TEXT, "%.4g, %.4g", (double)x[0], (double)x[1]);
  else
    (void)snprintf(text, PLACE_TEXT, "%.4g, %.4g, %.4g", (double)x[0], (double)x[1], (double)x[2]);
  return text;
}

/* SceneHas - Returns true if the run computes this physics */
PetscBool SceneHas(const Scene *scene, Physics what)
{
  return (scene->physics & (unsigned)what) ? PETSC_TRUE : PETSC_FALSE;
}

/* SceneReynolds - Returns the Reynolds number, with the length that the case chooses for it;
   infinite without viscosity */
PetscReal SceneReynolds(const Scene *scene)
{
  if (!SceneHas(scene, PHYSICS_VISCOSITY)) return PETSC_INFINITY;
  return scene->speed * scene->problem->reynolds_length * scene->length / scene->nu;
}

/*
  SceneIsAsPosed - Returns true if the exact solution of the case holds: the run computes all
  physics of the case and adds no body force. Added pressure or convection does not change the exact
  solution of a case without them.
*/
PetscBool SceneIsAsPosed(const Scene *scene)
{
  const unsigned posed = scene->problem->physics;

  return !(posed & ~scene->physics) && !(scene->physics & ~posed & (unsigned)PHYSICS_BODY_FORCE);
}

/* SceneMoves - Returns true if particles move with the flow */
PetscBool SceneMoves(const Scene *scene)
{
  return scene->motion && scene->motion->particles_move;
}

/* BoundaryIs - Returns true if the kind of a boundary has all given properties; not collective */
PetscBool BoundaryIs(const Scene *scene, PetscInt side, unsigned properties)
{
  return (scene->boundary[side].kind->properties & properties) == properties;
}

/* SceneIsPeriodic - Returns true if the fluid continues at both ends of an axis; not collective */
PetscBool SceneIsPeriodic(const Scene *scene, PetscInt axis)
{
  return BoundaryIs(scene, 2 * axis, BOUNDARY_CONTINUES);
}

/* SceneKeepsMomentum - Returns true if no boundary and no body force changes the momentum of the
   fluid: a periodic box without bodies; not collective */
PetscBool SceneKeepsMomentum(const Scene *scene)
{
  for (PetscInt a = 0; a < scene->dim; a++) {
    if (!SceneIsPeriodic(scene, a)) return PETSC_FALSE;
  }
  return scene->n_bodies || SceneHas(scene, PHYSICS_BODY_FORCE) ? PETSC_FALSE : PETSC_TRUE;
}

/* SceneIsDrivenInTime - Returns true if a wall's velocity or the body force depends on time */
PetscBool SceneIsDrivenInTime(const Scene *scene)
{
  return scene->unsteady_walls ||
         (scene->force.n && ExpressionUses(&scene->force, EXPRESSION_TIME));
}

/* SceneBodyForce - Computes the body force per unit mass at a position and time [m/s^2]; not
   collective */
void SceneBodyForce(const Scene *scene, PetscReal t, const PetscReal x[], PetscReal f[])
{
  for (PetscInt a = 0; a < scene->dim; a++)
    f[a] = scene->force.n ? ExpressionValue(&scene->force, a, t, x) : scene->body_force[a];
}
