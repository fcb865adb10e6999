/*
  Free surfaces: the fluid ends there and has no stress,

    sigma n = 0:   t.(grad u + grad u^T) n = 0,   p = 2 mu n.E n,

  with the outward normal n and tangents t. At the start they are sides of the box, or the borders
  of the regions that the fluid fills, as far as they are inside the box and outside other regions
  and bodies; later the particles on the surface carry it (freesurface.c). No side of a box with
  such regions is of this kind: each keeps its own also where the fluid is not yet.
*/
#include "isph/scene.h"

const BoundaryRow BoundaryFree = {
    .name       = "free",
    .brief      = "free surface at the start: no stress; it moves with the fluid",
    .citation   = "",
    .option     = {.name  = "-scene_free",
                   .kind  = VALUE_NAMES,
                   .brief = "sides of the box that are free surfaces at the start",
                   .words = BoxSides,
                   .table = &BoundaryTable,
                   .where = "-case scene"},
    .properties = BOUNDARY_FREE,
    .equation   = {[FIT_VELOCITY_NORMAL]     = EQUATION_NONE,
                   [FIT_VELOCITY_TANGENTIAL] = EQUATION_NONE,
                   [FIT_DIVERGENCE]          = EQUATION_NONE,
                   [FIT_PRESSURE]            = EQUATION_VALUE,
                   [FIT_PRESSURE_FREE]       = EQUATION_NONE},
};

/* SceneAddFilled - Adds a region that the fluid fills at the start, whose shape the caller sets;
   returns the shape; not collective */
Body *SceneAddFilled(Scene *scene)
{
  return &scene->filled[scene->n_filled++];
}

/* SceneFilledDistance - Returns the distance of x from the border of a region that the fluid fills
   at the start, positive in the fluid [m]; not collective */
PetscReal SceneFilledDistance(const Scene *scene, PetscInt region, const PetscReal x[])
{
  PetscReal normal[ISPH_MAX_DIM];

  return -BodyDistance(scene, &scene->filled[region], x, normal);
}

/* SceneHasFreeSurface - Returns true if the fluid has a free surface; not collective */
PetscBool SceneHasFreeSurface(const Scene *scene)
{
  return scene->n_filled || SceneHasBoundary(scene, BOUNDARY_FREE) ? PETSC_TRUE : PETSC_FALSE;
}
