/* The matrix of the coupled system; see saddle.c. */
#ifndef ISPH_SCHEMES_SADDLE_H
#define ISPH_SCHEMES_SADDLE_H

#include "isph/solvers.h"

/* Blocks of the scaled system. On each rank a vector holds the velocities of its particles, with
   interlaced components, and then their pressures, so that standard PETSc vectors suffice. */
typedef struct {
  PetscInt  dim, n, n_p; /* own particles; pressures of this rank: own particles or splines */
  PetscReal step;        /* T of the reference spacing, factor of the momentum equation [s] */
  PetscReal unit;        /* rho dx/T of the reference spacing, unit of pressures [Pa s/m] */
  PetscReal level;       /* pressure whose unknown is zero, see SceneSetLevel() [Pa] */
  Vec       time;        /* T_i/T of each particle [-] */
  Vec       length;      /* dx_i/dx of each particle [-] */
  Vec       viscosity;   /* nu_i/nu of each pressure [-] */
  Vec       mass;        /* factor of the rows of div over dx [-] */
  Vec       pressure;    /* unit of each pressure over `unit` [-] */
  Vec       constant;    /* numbers of splines that make the pressure 1; NULL: all are 1 [-] */
  PetscBool repeats;     /* F is a MATMAIJ; chosen before the assembly */
  PetscReal shift;       /* shift in F; NaN: F is out of date [1/s] */
  Vec       diagonal;    /* of F, or of `component`, for shift 0 [-] */
  Mat       component;   /* the block of each component in F, a MATMAIJ; NULL: F is no such [-] */
  Mat       viscous;     /* nu_0 times it is -F, which has products only; NULL: F has entries */
  Vec       rows;        /* of such an F: T_i [s] */
  PetscReal nu;          /* of such an F: nu_0 [m^2/s] */
  Mat       F, G, D;     /* T_i (shift - nu L + v.grad); T_i grad dx_j/T_j; dx_i div [-] */
  Mat       C;           /* residual of a quadratic fit of the pressure, T_i/dx_i C dx_j/T_j [-] */
  Mat       P;           /* [F G; D C] */
  Mat       A;           /* [F G; D C + c c^T], P itself without c */
  Mat       gauge;       /* c of GaugeColumn(), NULL for a determined pressure */
  PetscInt  assemblies;  /* stamp of the operators in the blocks */
} Saddle;

PetscReal      SaddleTime(PetscReal nu, const Clock *clock, PetscReal dx);
PetscErrorCode SaddleAssemble(const Flow *flow, const Vec advecting[], Saddle *saddle);
PetscErrorCode SaddleSetShift(const Particles *particles, PetscReal shift, Saddle *saddle);
PetscErrorCode SaddleFree(Saddle *saddle);
PetscErrorCode SaddleFlatten(Mat P, Mat *flat);
PetscErrorCode SaddlePut(const Saddle *saddle, Vec u[], Vec p, Vec x);
PetscErrorCode SaddleGet(const Saddle *saddle, Vec x, Vec u[], Vec p);
PetscErrorCode SaddleAdd(const Saddle *saddle, PetscInt c, PetscReal scale, Vec part, Vec x);

/* saddlesplines.c */
PetscErrorCode SaddleOnSplines(const Flow *flow, Vec momentum, Saddle *saddle);
PetscErrorCode SaddleAddGiven(const Saddle *saddle, PetscReal t, const Splines *splines, Vec b);

#endif
