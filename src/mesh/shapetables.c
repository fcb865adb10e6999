/* The tables of all shapes: those that are typed as numbers, and those from files. */
#include "geometry/shapes.h"
#include "mesh.h"

static const ShapeRow *const shapes[] = {&ShapeCircle,  &ShapeBox,     &ShapePolygon,
                                         &ShapeEllipse, &ShapeCapsule, &ShapeOutlines};
const Table ShapeTable = TABLE_OF_POINTERS("Shapes of bodies and fluids in 2D", shapes);

static const ShapeRow *const solids[] = {&ShapeBall,    &ShapeCuboid,   &ShapeCylinder,
                                         &ShapePrism,   &ShapeRevolved, &ShapeEllipsoid,
                                         &ShapeRounded, &ShapeCone,     &ShapeMesh};
const Table SolidTable = TABLE_OF_POINTERS("Shapes of bodies and fluids in 3D", solids);
