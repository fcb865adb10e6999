/* Shapes in the plane and in space, and what they share. */
#ifndef ISPH_GEOMETRY_SHAPES_H
#define ISPH_GEOMETRY_SHAPES_H

#include "isph/geometry.h"

extern const ShapeRow ShapeCircle, ShapeBox, ShapePolygon; /* shapes.c */
extern const ShapeRow ShapeBall, ShapeCuboid, ShapeCylinder, ShapePrism,
    ShapeRevolved; /* solids.c */
extern const ShapeRow ShapeEllipse, ShapeCapsule, ShapeEllipsoid, ShapeRounded,
    ShapeCone; /* ovals.c */

void      PrismSpan(const Body *body, PetscInt axis, PetscReal span[2]);
PetscReal PrismDistance(const Body *body, const PetscReal x[], PetscReal normal[]);
PetscInt  PrismCount(const Body *body, PetscReal dx);
PetscReal PrismPoint(const Body *body, PetscInt k, PetscReal dx, PetscReal x[], PetscReal normal[]);
PetscInt  ShapeLineCount(PetscReal length, PetscReal dx, PetscInt fewest);
const char *ShapeBoxPrepare(Body *body);

#endif
