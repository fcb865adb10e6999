/* Fits and noses of free surfaces, for freesurface.c. */
#ifndef ISPH_SURFACEFITS_H
#define ISPH_SURFACEFITS_H

#include "isph/surface.h"

#define SURFACE_CLOSE 1.9 /* distance of neighbours that a particle must have [dx] */

/* Results by own particle: the normal, and the depth of the particle below the fit [m]. */
typedef struct {
  PetscReal *normal, *depth;
} SurfaceFits;

/* Returns a length given in dx, at most the radius of the support: rows also hold some pairs
   farther away, and which these are depends on the age of the rows. */
static inline PetscReal SurfaceReach(const Particles *p, const Neighbors *nb, PetscInt i,
                                     PetscReal length)
{
  return PetscMin(length * p->dx[i], nb->radius);
}

SurfaceKind    SurfaceFitAt(const Scene *scene, const Particles *p, const Neighbors *nb,
                            const KernelSize *kernel, const FreeSurface *free, PetscInt i,
                            SurfaceFits *fits);
PetscErrorCode SurfaceAverageCurvature(const Scene *scene, const Particles *p, const Neighbors *nb,
                                       const KernelSize *kernel, FreeSurface *free);
PetscErrorCode FreeSurfaceFindNoses(const Scene *scene, const Particles *p, const Neighbors *nb,
                                    FreeSurface *free);

/* wetwalls.c */
PetscBool FreeSurfaceIsCoveredBy(const Scene *scene, const Particles *p, const Neighbors *nb,
                                 PetscInt i, PetscInt w, const PetscReal normal[]);
void      FreeSurfaceFillOpenings(const Scene *scene, const Particles *p, const Neighbors *nb,
                                  PetscInt i, PetscReal S[]);
PetscBool FreeSurfaceIsBesideDryWall(const Scene *scene, const Particles *p, const Neighbors *nb,
                                     const FreeSurface *free, PetscInt i);

#endif
