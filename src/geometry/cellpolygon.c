/* Polygons: cells of particles in 2D, exactly. See cellvolume.c. */
#include "cellpolygon.h"

/* PolygonDisc - Sets a polygon with the area of a disc about the origin. Input: radius [m]. */
void PolygonDisc(PetscReal radius, Polygon *polygon)
{
  const PetscReal step  = 2.0 * PETSC_PI / POLYGON_DISC;
  const PetscReal scale = radius * PetscSqrtReal(step / PetscSinReal(step));

  polygon->n = POLYGON_DISC;
  for (PetscInt k = 0; k < POLYGON_DISC; k++) {
    polygon->x[k][0] = scale * PetscCosReal(k * step);
    polygon->x[k][1] = scale * PetscSinReal(k * step);
  }
}

/* PolygonCut - Keeps the part n.X <= most of a convex polygon, which gains at most one corner; one
   with POLYGON_MOST - 1 corners stays as it is */
void PolygonCut(const PetscReal n[2], PetscReal most, Polygon *polygon)
{
  Polygon   old;
  PetscReal beyond[POLYGON_MOST], largest = -PETSC_INFINITY; /* n.X - most of the corners */

  for (PetscInt k = 0; k < polygon->n; k++) {
    beyond[k] = n[0] * polygon->x[k][0] + n[1] * polygon->x[k][1] - most;
    largest   = PetscMax(largest, beyond[k]);
  }
  if (!(largest > 0.0) || polygon->n + 1 == POLYGON_MOST) return;
  old        = *polygon;
  polygon->n = 0;
  for (PetscInt k = 0; k < old.n; k++) {
    const PetscInt   last = k > 0 ? k - 1 : old.n - 1;
    const PetscReal *a = old.x[last], *b = old.x[k];

    if (beyond[last] * beyond[k] < 0.0) {
      const PetscReal share = beyond[last] / (beyond[last] - beyond[k]);

      for (PetscInt e = 0; e < 2; e++) polygon->x[polygon->n][e] = a[e] + share * (b[e] - a[e]);
      polygon->n++;
    }
    if (beyond[k] > 0.0) continue;
    for (PetscInt e = 0; e < 2; e++) polygon->x[polygon->n][e] = b[e];
    polygon->n++;
  }
}

/* PolygonArea - Returns the area of a polygon [m^2] */
PetscReal PolygonArea(const Polygon *polygon)
{
  PetscReal sum = 0.0;

  for (PetscInt k = 0; k < polygon->n; k++) {
    const PetscReal *a = polygon->x[k], *b = polygon->x[k + 1 < polygon->n ? k + 1 : 0];

    sum += a[0] * b[1] - a[1] * b[0];
  }
  return 0.5 * sum;
}

/* PolygonSegment - Returns int k s^2/2 ds along the corners of a polygon on the line n.X = 0, with
   the distance s from the origin: the area between the line and a parabola of curvature k [m^2].
   Input: tie - distance that is rounding [m]. */
PetscReal PolygonSegment(const PetscReal n[2], PetscReal k, PetscReal tie, const Polygon *polygon)
{
  PetscReal least = 0.0, most = 0.0;

  for (PetscInt c = 0; c < polygon->n; c++) {
    const PetscReal *x = polygon->x[c], s = n[0] * x[1] - n[1] * x[0];

    if (PetscAbsReal(n[0] * x[0] + n[1] * x[1]) > tie) continue;
    least = PetscMin(least, s);
    most  = PetscMax(most, s);
  }
  return k * (PetscPowRealInt(most, 3) - PetscPowRealInt(least, 3)) / 6.0;
}
