/* The run of a flow: declarations shared by the files of this folder. */
#ifndef ISPH_RUN_IMPL_H
#define ISPH_RUN_IMPL_H

#include "isph/run.h"

/* checkpoint.c */
PetscErrorCode CheckpointsCreate(Checkpoints **checkpoints);
PetscErrorCode CheckpointsDestroy(Checkpoints **checkpoints);
PetscErrorCode CheckpointsUpdate(PetscBool final, Run *run);
PetscErrorCode CheckpointsRestart(Run *run, PetscBool *restarted);

/* outputnames.c */
PetscErrorCode RunCheckOutputs(void);

#endif
