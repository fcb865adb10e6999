/* The matrix of the coupled system; see saddle.c. */
#ifndef ISPH_SCHEMES_SADDLE_H
#define ISPH_SCHEMES_SADDLE_H

#include "isph/schemes.h"

/*
  Blocks of the scaled system. On each rank a vector holds the velocities of its particles, with
  interlaced components, and then their pressures, so that standard PETSc vectors suffice.
*/
typedef struct {
  PetscInt  dim, n;     /* own particles */
  PetscReal step;       /* T, factor of the momentum equation [s] */
  PetscReal unit;       /* unit of pressures, rho dx/T [Pa s/m] */
  PetscReal shift;      /* shift in F; NaN: F is out of date [1/s] */
  Mat       viscous;    /* T (-nu L + v.grad), dim N x dim N [-] */
  Mat       F, G, D;    /* T shift + viscous; dx grad; dx div [-] */
  Mat       C;          /* residual of a quadratic fit of the pressure [-] */
  Mat       A, P;       /* [F G; D C + c c^T] and [F G; D C] */
  Mat       gauge;      /* c of GaugeColumn() */
  PetscInt  assemblies; /* stamp of the operators in the blocks */
} Saddle;

PetscErrorCode SaddleAssemble(const Scene *scene, const Particles *particles, const Operators *ops,
                              PetscReal step, const Vec advecting[], MatType type, Saddle *saddle);
PetscErrorCode SaddleSetShift(PetscReal shift, Saddle *saddle);
PetscErrorCode SaddleFree(Saddle *saddle);
PetscErrorCode SaddleFlatten(Mat nest, Mat *flat);
PetscErrorCode SaddlePut(const Saddle *saddle, Vec u[], Vec p, Vec x);
PetscErrorCode SaddleGet(const Saddle *saddle, Vec x, Vec u[], Vec p);
PetscErrorCode SaddleAdd(const Saddle *saddle, PetscInt c, PetscReal scale, Vec part, Vec x);

#endif
