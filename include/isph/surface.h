/* Free surfaces: the particles on them, normals, curvatures, and their contact with walls. */
#ifndef ISPH_SURFACE_H
#define ISPH_SURFACE_H

#include "isph/fits.h"

/* Free surfaces at the present positions; arrays by local index, halo included. */
typedef struct {
  PetscInt   capacity;
  PetscReal *kind;            /* SurfaceKind of fluid particles, a whole number */
  PetscReal *normal;          /* out of the fluid, at [i dim + a]; of no meaning inside */
  PetscReal *curvature;       /* sum of the principal curvatures, own particles [1/m] */
  PetscBool *at_contact_line; /* of own particles: at a contact line, but in no nose */
  PetscBool  exists;          /* a fluid particle of any rank is on the surface, or isolated */
  PetscBool  has_rough;       /* a fluid particle of any rank is rough, or paired */
  PetscReal  tension;         /* surface tension; 0: none [N/m] */
  PetscBool  fitted; /* fits of the viscous term have its condition; else pair forces everywhere */
  PetscReal *has_pair_forces; /* not 0: own particle has pair forces, see JudgeBurst; NULL: none */
} FreeSurface;

PetscErrorCode FreeSurfaceFind(const Scene *scene, const Particles *particles,
                               const Neighbors *neighbors, const KernelSize *kernel,
                               FreeSurface *free);
PetscErrorCode FreeSurfaceFree(FreeSurface *free);
PetscInt       FreeSurfaceOpenings(const Scene *scene, const Particles *particles,
                                   const Neighbors *neighbors, PetscInt i);
PetscBool      FreeSurfaceTouches(const Scene *scene, const Particles *particles,
                                  const Neighbors *neighbors, const FreeSurface *free, PetscInt i,
                                  PetscInt wall);
PetscInt       FreeSurfaceListTouched(const Scene *scene, const Particles *particles,
                                      const Neighbors *neighbors, PetscInt i, PetscReal *const x[],
                                      PetscInt list[]);
PetscInt       SurfaceTangents(PetscInt dim, const PetscReal normal[], PetscReal t[][ISPH_MAX_DIM]);
PetscInt       FreeSurfaceNearestWall(const Scene *scene, const Particles *particles,
                                      const Neighbors *neighbors, PetscInt i, PetscReal most);

/* FreeSurfaceHolds - Returns true if a fluid particle is on a free surface or isolated; free: NULL
   without free surfaces; not collective */
static inline PetscBool FreeSurfaceHolds(const FreeSurface *free, PetscInt i)
{
  return free && free->kind[i] != SURFACE_INSIDE;
}

/* FreeSurfacePressure - Returns the pressure of the surface tension at own particle i on a free
   surface; isolated particles have none [Pa]; not collective */
static inline PetscReal FreeSurfacePressure(const FreeSurface *free, PetscInt i)
{
  return free->tension == 0.0 || free->kind[i] == SURFACE_ISOLATED
             ? 0.0
             : free->tension * free->curvature[i];
}

/* FreeSurfaceIsPaired - Returns true if the present step has pair forces on own particle i in place
   of a fit, see JudgeBurst; not collective */
static inline PetscBool FreeSurfaceIsPaired(const FreeSurface *free, PetscInt i)
{
  return free->has_pair_forces && free->has_pair_forces[i] != 0.0;
}

/* FreeSurfaceIsRough - Returns true if a fluid particle is where no smooth surface passes; not
   collective */
static inline PetscBool FreeSurfaceIsRough(const FreeSurface *free, PetscInt i)
{
  return free->kind[i] == SURFACE_ROUGH || free->kind[i] == SURFACE_ISOLATED;
}

#endif
