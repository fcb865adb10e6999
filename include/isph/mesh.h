/* Shapes from files, and the tables of all shapes. */
#ifndef ISPH_MESH_H
#define ISPH_MESH_H

#include "isph/geometry.h"

extern const Table ShapeTable, SolidTable; /* of the plane, and of space */

#endif
