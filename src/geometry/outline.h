/* Outlines of bodies in the plane. */
#ifndef ISPH_GEOMETRY_OUTLINE_H
#define ISPH_GEOMETRY_OUTLINE_H

#include "isph/geometry.h"

/* A loop of the outline of a body or of one of its periodic images, with the solid, or in a domain
   the fluid, on the left. */
typedef struct {
  PetscInt   n;
  PetscReal *x;            /* corners: 2 coordinates each [m] */
  PetscReal  lo[2], hi[2]; /* box around them, and around all that it is united with [m] */
  PetscReal  sign;         /* of its area in the area of the fluid */
  PetscInt   solid;        /* number of the body and image; its loops have the same */
  PetscInt   pieces;       /* of lines on the border of the fluid */
  PetscReal *piece;        /* both ends of each: 4 coordinates [m] */
} Outline;

PetscErrorCode OutlineCreate(const Body *body, PetscInt loop, PetscReal spacing,
                             const PetscReal shift[2], Outline *o);
PetscBool      OutlineIsApart(const Outline *o, const PetscReal lo[2], const PetscReal hi[2]);
PetscErrorCode OutlinesUnite(PetscInt n, Outline o[]);
PetscErrorCode OutlineFree(Outline *o);

#endif
