/* Convex polygons about a particle. */
#ifndef ISPH_SCHEMES_CELLPOLYGON_H
#define ISPH_SCHEMES_CELLPOLYGON_H

#include <petscsys.h>

#define POLYGON_DISC 12 /* corners of a disc */
#define POLYGON_MOST 32 /* corners */

typedef struct {
  PetscInt  n;
  PetscReal x[POLYGON_MOST][2]; /* corners, counterclockwise, from the particle [m] */
} Polygon;

void      PolygonDisc(PetscReal radius, Polygon *polygon);
void      PolygonCut(const PetscReal n[2], PetscReal most, Polygon *polygon);
PetscReal PolygonArea(const Polygon *polygon);
PetscReal PolygonSegment(const PetscReal n[2], PetscReal k, PetscReal tie, const Polygon *polygon);

#endif
