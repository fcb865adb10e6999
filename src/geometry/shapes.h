/* Shapes in the plane and in space, and what they share. */
#ifndef ISPH_SCENE_SHAPES_H
#define ISPH_SCENE_SHAPES_H

#include "isph/scene.h"

extern const ShapeRow ShapeCircle, ShapePolygon;               /* shapes.c */
extern const ShapeRow ShapeBall, ShapeCylinder, ShapeRevolved; /* solids.c */

PetscInt    ShapeLineCount(PetscReal length, PetscReal dx, PetscInt fewest);
const char *ShapeBoxPrepare(Body *body);

#endif
