/* Files of shapes, and closed surfaces of triangles. */
#ifndef ISPH_MESH_MESH_H
#define ISPH_MESH_MESH_H

#include "geometry/curves.h"
#include "isph/mesh.h"

#define FAULT 200
#define TIGHT 1e-6 /* corners that are nearer to each other are joined [extent] */

/* A file that is read: its text, which ends with '\0', and the numbers that are found in it. */
typedef struct {
  char       *text;
  size_t      length;
  const char *at;       /* the next letter */
  PetscInt    n, loops; /* numbers; closed loops in the plane */
  PetscInt    capacity;
  PetscReal  *number; /* of a triangle: three corners; of a corner in the plane: x, y, loop */
  char        fault[FAULT];
} MeshFile;

/* A node of the tree of boxes: triangles from <= t < to; the first branch is the next node. The
   axes of a box follow its triangles. */
typedef struct {
  PetscReal axis[3][3], lo[3], hi[3];
  PetscInt  from, to, second; /* second branch, 0 for a leaf */
} MeshNode;

/* A closed surface of triangles with corners in counter-clockwise order as seen from outside. */
typedef struct {
  PetscInt   corners, triangles;
  PetscReal *x;                    /* of each corner [m] */
  PetscInt  *corner;               /* three of each triangle */
  PetscInt  *across;               /* triangle beyond the side from corner k to k + 1; -1: none */
  PetscReal *normal;               /* of triangles, of length 1 */
  PetscReal *around;               /* pseudonormals of corners */
  MeshNode  *node;                 /* the root is the first */
  PetscReal  lo[3], hi[3], extent; /* box around it, its longest side [m] */
  PetscInt   equal, flat, closed;  /* triangles left out, turned to others, added at holes */
  PetscReal  hole;                 /* part of the area that is added at holes [-] */
} Mesh;

extern const ShapeRow ShapeMesh, ShapeOutlines;

/* Cells of space that hold the numbers of points. */
typedef struct {
  PetscReal cell;
  PetscInt  slots, *head, *next; /* slots is a power of two */
} MeshGrid;

void           MeshFail(MeshFile *file, const char format[], ...) PETSC_ATTRIBUTE_FORMAT(2, 3);
PetscBool      MeshWord(MeshFile *file, const char word[]);
PetscBool      MeshNumber(MeshFile *file, PetscReal *x);
void           MeshSkipLine(MeshFile *file);
void           MeshAdd(MeshFile *file, PetscInt n, const PetscReal x[]);
void           MeshAddPolygon(MeshFile *file, PetscInt n, const PetscInt corner[], PetscInt corners,
                              const PetscReal x[]);
void           MeshReadStl(MeshFile *file);
void           MeshReadObj(MeshFile *file);
void           MeshAddCorner(MeshFile *file, PetscReal x, PetscReal y);
void           MeshEndLoop(MeshFile *file);
PetscErrorCode MeshFileRead(const char option[], const char path[], void (*Parse)(MeshFile *file),
                            MeshFile *file);
PetscErrorCode MeshPath(const char option[], const char text[], char **path, PetscReal *scale);
PetscErrorCode MeshCreate(MeshFile *file, BodyStore *store, Mesh *mesh);
PetscErrorCode MeshClose(Mesh *mesh, char fault[FAULT]);
PetscErrorCode MeshConnect(Mesh *mesh, PetscInt *open, PetscInt *many, PetscReal place[3]);
PetscErrorCode MeshOrient(Mesh *mesh, PetscInt part[], PetscInt *parts, PetscBool *good);
PetscErrorCode MeshTurnFlat(Mesh *mesh, PetscInt *left, PetscInt *open, PetscInt *many,
                            PetscReal place[3]);
PetscErrorCode MeshFindPinch(const Mesh *mesh, PetscInt *pinch);
void           MeshReverse(Mesh *mesh, PetscInt t);
PetscReal      MeshAlong(const MeshNode *node, PetscInt axis, const PetscReal x[]);
PetscErrorCode MeshTree(BodyStore *store, Mesh *mesh);
PetscErrorCode MeshSort(Mesh *mesh);
PetscErrorCode MeshCrossings(const Mesh *mesh, char fault[FAULT]);
PetscReal      MeshNearest(const Mesh *mesh, const PetscReal x[], PetscReal foot[3],
                           PetscReal normal[3]);
PetscReal      MeshFoot(const Mesh *mesh, PetscInt t, const PetscReal x[], PetscReal foot[3],
                        PetscInt *part);
PetscErrorCode MeshGridCreate(PetscInt n, PetscReal cell, MeshGrid *grid);
void           MeshGridAdd(MeshGrid *grid, PetscInt k, const PetscReal x[3]);
PetscInt MeshGridNearest(const MeshGrid *grid, const PetscReal points[], const PetscReal normals[],
                         const PetscReal x[3], const PetscReal normal[3], PetscReal most);
PetscErrorCode MeshGridFree(MeshGrid *grid);
PetscErrorCode MeshPoints(const Mesh *mesh, SurfacePoints *points);
PetscReal MeshTriangle(const Mesh *mesh, PetscInt t, const PetscReal *x[3], PetscReal normal[3]);

#endif
