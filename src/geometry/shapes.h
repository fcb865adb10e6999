/* Shapes in the plane and in space, and what they share. */
#ifndef ISPH_GEOMETRY_SHAPES_H
#define ISPH_GEOMETRY_SHAPES_H

#include "isph/geometry.h"

extern const ShapeRow ShapeCircle, ShapePolygon;               /* shapes.c */
extern const ShapeRow ShapeBall, ShapeCylinder, ShapeRevolved; /* solids.c */

PetscInt    ShapeLineCount(PetscReal length, PetscReal dx, PetscInt fewest);
const char *ShapeBoxPrepare(Body *body);

#endif
