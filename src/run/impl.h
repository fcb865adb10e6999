/* The run of a flow: declarations shared by the files of this folder. */
#ifndef ISPH_RUN_IMPL_H
#define ISPH_RUN_IMPL_H

#include "isph/run.h"

typedef struct Checkpoints Checkpoints;

/* The stages of a run in the output of -log_view. */
typedef enum { STAGE_SETUP, STAGE_STEPS, STAGE_OUTPUT, RUN_STAGES } RunStage;

/* A run: the flow and its output. */
typedef struct {
  Flow           flow;
  Snapshots     *snapshots;
  Monitors      *monitors;
  Progress      *progress;
  Report        *report;
  Checkpoints   *checkpoints;
  MachineMemory  memory;
  PetscLogDouble started;           /* wall clock [s] */
  PetscLogStage  stage[RUN_STAGES]; /* without a log the main stage, 0 */
} Run;

/* run.c */
PetscErrorCode RunCreate(Run *run);
PetscErrorCode RunBegin(Run *run);
PetscErrorCode RunDestroy(Run *run);

/* checkpoint.c */
PetscErrorCode CheckpointsCreate(Checkpoints **checkpoints);
PetscErrorCode CheckpointsDestroy(Checkpoints **checkpoints);
PetscErrorCode CheckpointsUpdate(PetscBool final, Run *run);
PetscErrorCode CheckpointsRestart(Run *run, PetscBool *restarted);

/* outputnames.c */
PetscErrorCode RunCheckOutputs(void);

/* interrupt.c */
PetscErrorCode InterruptInstall(void);
PetscErrorCode InterruptCheck(PetscMPIInt *signal);
const char    *InterruptName(PetscMPIInt signal);

#endif
