/* Particles around the points of quadrature in a cell of the splines. */
#ifndef ISPH_SPLINESEARCH_H
#define ISPH_SPLINESEARCH_H

#include "splines.h"

#define SPLINE_ALL     (-1) /* components of the velocity */
#define SPLINE_NEAREST 84   /* most particles with which a fit begins */

/* Points of quadrature in a cell, and the particles around them in ascending order. */
typedef struct {
  PetscInt  m;                            /* number of points */
  PetscReal at[ISPH_MAX_DIM][POINT_FITS]; /* the points [m] */
  /* of the axes about each point; stretched cells have the largest edge of all cells [-] */
  PetscReal  stretch[ISPH_MAX_DIM][POINT_FITS];
  PetscReal  reach; /* distance from each point within which all particles are listed [m] */
  PetscInt   n, walls, capacity, *j;
  PetscReal *x[ISPH_MAX_DIM]; /* positions; of wall particles: their points on the wall [m] */
  PetscBool *wall;
  PetscReal *r2,
      *part; /* of a point: squared distances, stretched [m^2], and shares in the number wanted */
  PetscInt *found; /* particles of a fit, numbers in this list */
  PetscReal last2; /* squared radius of the last fit [m^2]; 0: none */
} SplineAround;

PetscInt       SplineLeast(PetscInt dim, PetscInt degree);
PetscErrorCode SplineAroundCreate(const Flow *flow, SplineAround *around);
PetscErrorCode SplineAroundFree(SplineAround *around);
PetscErrorCode SplineAroundSet(const Flow *flow, const Splines *s, PetscInt first,
                               SplineAround *around);
PetscErrorCode SplineNearest(const Flow *flow, PetscInt i, PetscInt c, PetscInt wanted,
                             SplineAround *around, PetscReal *reach, PetscInt *n, PetscReal *R,
                             PetscBool *found);
PetscBool      SplineIsNearOblique(const Flow *flow, PetscInt i, const SplineAround *around);
PetscBool SplineFitIsShared(const Particles *p, PetscInt i, PetscInt a, PetscInt b, PetscReal R,
                            const SplineAround *around);

#endif
