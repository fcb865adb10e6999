/* Cubes cut by a surface that is given by distances at their corners. */
#ifndef ISPH_GEOMETRY_CUTCUBE_H
#define ISPH_GEOMETRY_CUTCUBE_H

#include <petscsys.h>

#define CUBE_TETRAHEDRA 18 /* most in the part of a cube with positive distances */
#define CUBE_TRIANGLES  12 /* most on the surface */

/* The part of a cube with positive distances, and the surface, whose triangles turn right about the
   direction of growing distances: their normals point out of the part. */
typedef struct {
  PetscInt  n_tetrahedra, n_triangles;
  PetscReal tetrahedron[CUBE_TETRAHEDRA][4][3], triangle[CUBE_TRIANGLES][3][3];
} CubePieces;

void CubeCut(const PetscReal lo[3], PetscReal edge, const PetscReal d[8], CubePieces *pieces);
void CubeCutFace(const PetscReal lo[3], PetscReal edge, const PetscReal d[8], PetscInt side,
                 CubePieces *pieces);

#endif
