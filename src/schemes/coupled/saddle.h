/* The matrix of velocity and pressure; see saddle.c. */
#ifndef ISPH_SCHEMES_SADDLE_H
#define ISPH_SCHEMES_SADDLE_H

#include "isph/schemes.h"

/*
  Blocks of the scaled system. Vectors hold on each rank the velocities of its particles, components
  next to each other, then their pressures, so that any PETSc vector will do.
*/
typedef struct {
  PetscInt  dim, n;     /* own particles */
  PetscReal step;       /* T: momentum is multiplied by it [s] */
  PetscReal unit;       /* of pressures, rho dx/T [Pa s/m] */
  PetscReal shift;      /* in F; NaN: F is not yet made [1/s] */
  Mat       viscous;    /* T (-nu L + v.grad), dim N x dim N [-] */
  Mat       F, G, D;    /* T shift + viscous; dx grad; dx div [-] */
  Mat       C;          /* residual of a quadratic fit of the pressure [-] */
  Mat       A, P;       /* [F G; D C + c c^T] and [F G; D C] */
  Mat       gauge;      /* c of GaugeColumn() */
  PetscInt  assemblies; /* stamp of the operators in them */
} Saddle;

PetscErrorCode SaddleAssemble(const Scene *scene, const Particles *particles, const Operators *ops,
                              PetscReal step, const Vec advecting[], Saddle *saddle);
PetscErrorCode SaddleSetShift(PetscReal shift, Saddle *saddle);
PetscErrorCode SaddleFree(Saddle *saddle);
PetscErrorCode SaddleFlatten(Mat nest, Mat *flat);
PetscErrorCode SaddlePut(const Saddle *saddle, Vec u[], Vec p, Vec x);
PetscErrorCode SaddleGet(const Saddle *saddle, Vec x, Vec u[], Vec p);
PetscErrorCode SaddleAdd(const Saddle *saddle, PetscInt c, PetscReal scale, Vec part, Vec x);

#endif
