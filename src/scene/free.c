/*
  Free surfaces: the fluid ends there and has no stress,

    sigma n = 0:   t.(grad u + grad u^T) n = 0,   p = 2 mu n.E n,

  with the outward normal n and tangents t. A side of the box or a body around the fluid is the
  place of the surface at the start; later the particles on it carry it (freesurface.c).
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
                   [FIT_PRESSURE]            = EQUATION_VALUE,
                   [FIT_PRESSURE_FREE]       = EQUATION_NONE},
};

/* SceneAddFree - Adds a free surface, whose shape the caller sets; returns its boundary; not
   collective */
Boundary *SceneAddFree(Scene *scene)
{
  Boundary *boundary = SceneAddBody(scene);

  boundary->kind = &BoundaryFree;
  return boundary;
}

/* SceneHasFreeShape - Returns true if a free surface is a shape, not a side of the box; not
   collective */
PetscBool SceneHasFreeShape(const Scene *scene)
{
  for (PetscInt k = 0; k < scene->n_bodies; k++)
    if (BoundaryIs(scene, SceneBodySide(scene, k), BOUNDARY_FREE)) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* SceneHasFreeSurface - Returns true if the fluid has a free surface; not collective */
PetscBool SceneHasFreeSurface(const Scene *scene)
{
  return SceneHasBoundary(scene, BOUNDARY_FREE);
}
