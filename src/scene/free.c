/*
  Free surfaces: the fluid ends there and has no stress,

    sigma n = 0:   t.(grad u + grad u^T) n = 0,   p = 2 mu n.E n,

  with the outward normal n and tangents t. At the start they are the borders of the regions that
  the fluid fills, as far as they are inside the box and outside other regions and bodies.
*/
#include "isph/scene.h"

#define LOOK_MOST 4e7 /* points at which regions are looked at */

/* SceneAddFilled - Adds a region that the fluid fills at the start, whose shape the caller sets;
   returns the shape */
Body *SceneAddFilled(Scene *scene)
{
  return &scene->filled[scene->n_filled++];
}

/* SceneFillUpTo - Lets the fluid fill the box up to some sides, bits of their numbers, which are
   free surfaces at the start: beyond each the box goes on for its own length, and ends without a
   boundary */
void SceneFillUpTo(Scene *scene, unsigned sides)
{
  PetscReal end[2][ISPH_MAX_DIM];
  PetscInt  n = 0;

  for (PetscInt side = 0; side < 2 * scene->dim; side++) {
    const PetscInt  a      = side / 2;
    const PetscReal length = scene->hi[a] - scene->lo[a];

    end[side % 2][a] = side % 2 ? scene->hi[a] : scene->lo[a];
    if (sides >> side & 1) n++;
    else end[side % 2][a] += side % 2 ? length : -length; /* beyond the box */
  }
  if (!n) return;
  BodyBox(scene, end[0], end[1], SceneAddFilled(scene));
  for (PetscInt a = 0; a < scene->dim; a++) {
    const PetscReal length = scene->hi[a] - scene->lo[a];

    if (sides >> (2 * a) & 1) scene->lo[a] -= length;
    if (sides >> (2 * a + 1) & 1) scene->hi[a] += length;
  }
  for (PetscInt side = 0; side < 2 * scene->dim; side++)
    if (sides >> side & 1) SceneSetSide(scene, side, &BoundaryNone);
}

/* SceneFilledDistance - Returns the distance of x from the border of a region that the fluid fills
   at the start, positive in the fluid [m] */
PetscReal SceneFilledDistance(const Scene *scene, PetscInt region, const PetscReal x[])
{
  PetscReal normal[ISPH_MAX_DIM];

  return -BodyDistance(scene, &scene->filled[region], x, normal);
}

/* Returns true if a filled region, or a body, is at a place in the box. */
static PetscBool IsTaken(const Scene *scene, const PetscReal x[])
{
  PetscInt side;

  for (PetscInt k = 0; k < scene->n_filled; k++)
    if (SceneFilledDistance(scene, k, x) >= -SCENE_ON_SURFACE * scene->dx) return PETSC_TRUE;
  return scene->n_bodies && SceneFluidDistance(scene, x, &side) < 0.0;
}

/* SceneDropFullRegions - Removes the regions that the fluid fills at the start if they leave no
   room in the box: such a fluid has no free surface. All ranks do the same. Looks at points dx/2
   apart, unless they are more than LOOK_MOST. */
void SceneDropFullRegions(Scene *scene)
{
  PetscReal n[ISPH_MAX_DIM] = {1.0, 1.0, 1.0};
  size_t    count;

  if (scene->n_filled == 0) return;
  for (PetscInt a = 0; a < scene->dim; a++)
    n[a] = PetscCeilReal(2.0 * (scene->hi[a] - scene->lo[a]) / scene->dx);
  if (n[0] * n[1] * n[2] > LOOK_MOST) return;
  count = (size_t)(n[0] * n[1] * n[2]);
  for (size_t k = 0; k < count; k++) {
    PetscReal x[ISPH_MAX_DIM] = {0.0};
    size_t    rest            = k;

    for (PetscInt a = 0; a < scene->dim; a++) {
      const size_t i = rest % (size_t)n[a];

      x[a] = scene->lo[a] + ((PetscReal)i + 0.5) / n[a] * (scene->hi[a] - scene->lo[a]);
      rest /= (size_t)n[a];
    }
    if (!IsTaken(scene, x)) return;
  }
  scene->n_filled = 0;
}

/* SceneHasFreeSurface - Returns true if the fluid has a free surface */
PetscBool SceneHasFreeSurface(const Scene *scene)
{
  return scene->n_filled ? PETSC_TRUE : PETSC_FALSE;
}
