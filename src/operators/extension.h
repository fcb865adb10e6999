/* One row of the extension of the fluid's velocity to the particles behind walls. */
#ifndef ISPH_EXTENSION_H
#define ISPH_EXTENSION_H

#include "isph/operators.h"

/* What a row function reads of wall particle w, and what it writes. */
struct Extension {
  const Scene     *scene;
  const Particles *particles;
  const Cells     *cells;
  PetscReal        margin; /* of the cells' positions [m] */
  const KernelRow *kernel;
  PetscInt         dim, side;         /* the wall it belongs to: WallPlane.side */
  PetscReal        dx, radius, depth; /* [m] */
  PetscReal        x[ISPH_MAX_DIM];   /* the wall particle [m] */
  PetscReal wall_point[ISPH_MAX_DIM]; /* of its normal, on the wall or the plane beyond it [m] */
  PetscReal edge[ISPH_MAX_DIM];       /* the point of the box nearest to that [m] */
  PetscReal normal[ISPH_MAX_DIM];     /* there, into the fluid */

  PetscInt   n, *j;           /* fluid near by: local indices */
  PetscReal *s[ISPH_MAX_DIM]; /* where it is, in the coordinates of the fit [reach of the fit] */
  PetscReal *q, *weight; /* distance from the centre of the fit, and weight in it [the same], [-] */
  PetscReal *e;          /* the row: E_wj */
  PetscInt   regularised; /* fits that their points did not determine */
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
