/* A row of the matrix that extends the velocity from the fluid to particles behind walls. */
#ifndef ISPH_EXTENSION_H
#define ISPH_EXTENSION_H

#include "isph/walls.h"

/* Wall particle w and the fluid near it: input and output of the row functions WallExtend_*. */
struct Extension {
  const Scene     *scene;
  const Particles *particles;
  const Cells     *cells;
  PetscReal        margin; /* twice the largest displacement since cells were built [m] */
  const KernelRow *kernel;
  PetscReal        h_over_dx;                /* [-] */
  PetscInt         dim, side;                /* side: number of its wall in Scene.boundary */
  PetscReal        dx, radius, depth;        /* [m] */
  PetscReal        x[ISPH_MAX_DIM];          /* the wall particle [m] */
  PetscReal        wall_point[ISPH_MAX_DIM]; /* on the wall or, beyond an edge, on its plane [m] */
  PetscReal        edge[ISPH_MAX_DIM];       /* point of the box nearest to the wall point [m] */
  PetscReal        normal[ISPH_MAX_DIM];     /* normal at the wall point, into the fluid */

  PetscInt   n, *j;           /* fluid nearby: number and local indices */
  PetscReal *s[ISPH_MAX_DIM]; /* positions from the origin of the fit [reach of the fit] */
  PetscReal *q, *weight;      /* distances from the centre of the fit [reach] and weights [-] */
  PetscReal *e;               /* the row: E_wj */
  PetscInt   regularised;     /* number of fits whose points did not determine them */
};

PetscErrorCode WallExtend_Mirror(Extension *extension);
PetscErrorCode WallExtend_Linear(Extension *extension);
PetscErrorCode WallExtend_Quadratic(Extension *extension);
PetscErrorCode WallExtend_GlobalQuadratic(Extension *extension);
PetscErrorCode WallExtend_Adami(Extension *extension);
PetscErrorCode WallCheck_Channel(const Scene *scene);
PetscErrorCode ExtendWalls(const Scene *scene, const Particles *particles,
                           const Neighbors *neighbors, Operators *ops);

#endif
