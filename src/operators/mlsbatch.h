/* Fits of several particles at once. */
#ifndef ISPH_MLSBATCH_H
#define ISPH_MLSBATCH_H

#include "isph/operators.h"

typedef struct MlsBatch MlsBatch;

PetscErrorCode MlsBatchCreate(MlsBatch **batch);
PetscErrorCode MlsBatchDestroy(MlsBatch **batch);
PetscErrorCode MlsFitBatch(PetscInt degree, PetscInt count, Stencil *const stencil[],
                           MlsBatch *batch);

#endif
