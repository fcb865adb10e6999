/* The defect of a computed flow, and the error of the velocity that follows from it. */
#ifndef ISPH_DEFECT_H
#define ISPH_DEFECT_H

#include "isph/io.h"

/* Compact rows: a few neighbours of each own fluid particle, compressed. */
typedef struct {
  PetscInt  *row, *col, capacity; /* local indices */
  PetscReal *conductance;         /* F_ij of a pair, volumes included [1/m^2] */
  PetscReal *slope[ISPH_MAX_DIM]; /* weights of f_j - f_i in df/dx_a [1/m] */
  PetscReal *wall;                /* sum of F/V_i to boundaries that give the velocity [1/m^2] */
} CompactRows;

/* Residuals of momentum and mass at own fluid particles. */
typedef struct {
  PetscReal  *momentum[ISPH_MAX_DIM]; /* [m/s^2] */
  PetscReal  *mass;                   /* div u [1/s] */
  PetscReal  *nu;                     /* tangent viscosity of local particles [m^2/s] */
  CompactRows rows;
} Defect;

PetscErrorCode DefectCreate(const Flow *flow, Defect *defect);
PetscErrorCode DefectDestroy(Defect *defect);
PetscErrorCode DefectError(const Flow *flow, PetscReal rate, Defect *defect, PetscReal *error);

PetscErrorCode CompactRowAdd(const Flow *flow, PetscInt i, CompactRows *rows);

#endif
