/* The walls of a scene by number and by name: sides of the box, then bodies. */
#include "isph/scene.h"

/* Sides of the box by number, 2 axis + (0 low, 1 high). */
const char *const SideNames[2 * ISPH_MAX_DIM] = {"left", "right", "bottom", "top", "back", "front"};

/* SceneWallCount - Returns how many numbers of walls there are: sides of the box, then bodies;
   not collective */
PetscInt SceneWallCount(const Scene *scene)
{
  return 2 * scene->dim + scene->n_bodies;
}

/* SceneIsWall - Returns true if the wall of a number exists; not collective */
PetscBool SceneIsWall(const Scene *scene, PetscInt side)
{
  if (!SceneHas(scene, PHYSICS_WALLS)) return PETSC_FALSE;
  if (side >= 2 * scene->dim) return PETSC_TRUE;
  return scene->no_box_walls || scene->periodic[side / 2] ? PETSC_FALSE : PETSC_TRUE;
}

/* SceneWallName - Writes the name of a wall, "left" or "body_1", in WALL_NAME letters; not
   collective */
void SceneWallName(const Scene *scene, PetscInt side, char name[])
{
  if (side < 2 * scene->dim) (void)snprintf(name, WALL_NAME, "%s", SideNames[side]);
  else (void)snprintf(name, WALL_NAME, "body_%d", (int)(side - 2 * scene->dim + 1));
}
