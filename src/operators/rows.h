/* Row functions of the least-squares forms, listed in the tables of laplacians.c and gradients.c.
 */
#ifndef ISPH_ROWS_H
#define ISPH_ROWS_H

#include "isph/operators.h"

PetscErrorCode LaplacianRow_Mls(Stencil *stencil, PetscReal w[]);
PetscErrorCode GradientRow_Mls(Stencil *stencil, PetscReal *g[]);
PetscErrorCode DivergenceFit_Mls(Stencil *stencil, PetscReal *d[], PetscReal m[]);

#endif
