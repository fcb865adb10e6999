/* Outlines of bodies in the plane. */
#ifndef ISPH_GEOMETRY_OUTLINE_H
#define ISPH_GEOMETRY_OUTLINE_H

#include "isph/geometry.h"

/* The outline of a body or of one of its periodic images, counter-clockwise. */
typedef struct {
  PetscInt   n;
  PetscReal *x;            /* corners: 2 coordinates each [m] */
  PetscReal  lo[2], hi[2]; /* box around them [m] */
  PetscReal  sign;         /* of its area in the area of the fluid */
} Outline;

PetscErrorCode OutlineCreate(const Body *body, PetscInt loop, PetscReal spacing,
                             const PetscReal shift[2], Outline *o);
PetscBool      OutlineIsApart(const Outline *o, const PetscReal lo[2], const PetscReal hi[2]);
PetscInt OutlineClip(PetscInt n, const PetscReal x[], PetscInt axis, PetscReal s, PetscReal limit,
                     PetscReal out[]);

#endif
