/* Fits of several particles at once. */
#ifndef ISPH_MLSBATCH_H
#define ISPH_MLSBATCH_H

#include "isph/fits.h"

#define MLS_BATCH 4 /* most particles, a vector of AVX2 */

typedef struct MlsBatch MlsBatch;

PetscErrorCode MlsBatchCreate(PetscInt dim, MlsBatch **batch);
PetscErrorCode MlsBatchDestroy(MlsBatch **batch);
PetscErrorCode MlsFitBatch(PetscInt degree, PetscInt count, Stencil *const stencil[],
                           MlsBatch *batch);

#endif
