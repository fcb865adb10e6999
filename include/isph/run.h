/* The run of a flow: from its scene to its report. */
#ifndef ISPH_RUN_H
#define ISPH_RUN_H

#include "isph/io.h"

extern const OptionTable StartOptions, CheckpointOptions;

typedef struct Checkpoints Checkpoints;

/* The stages of a run in the output of -log_view. */
typedef enum { STAGE_SETUP, STAGE_STEPS, STAGE_OUTPUT, RUN_STAGES } RunStage;

/* A run: the flow and its output. Its functions are collective on PETSC_COMM_WORLD. Their errors
   are PETSC_ERR_USER_INPUT for a refused option, a failed -check_<quantity> or a signal,
   PETSC_ERR_FP for a flow that diverged, PETSC_ERR_NOT_CONVERGED for a failed solve; for all codes
   see docs/reference/exit-status.md */
typedef struct {
  Flow           flow;
  Snapshots     *snapshots;
  Monitors      *monitors;
  Progress      *progress;
  Report        *report;
  Checkpoints   *checkpoints;
  MachineMemory  memory;
  PetscBool      over;              /* the end is reached, or the flow is steady */
  PetscBool      checked;           /* every option has been read */
  PetscMPIInt    signal;            /* that ends the run early; 0: none */
  PetscLogDouble started;           /* wall clock [s] */
  PetscLogStage  stage[RUN_STAGES]; /* without a log the main stage, 0 */
} Run;

PetscErrorCode RunCreate(Run *run);
PetscErrorCode RunBegin(Run *run);
PetscErrorCode RunStep(Run *run);
PetscErrorCode RunMeasure(Run *run);
PetscErrorCode RunShowBanner(Run *run, PetscViewer viewer);
PetscErrorCode RunReport(Run *run, PetscErrorCode failed, PetscViewer viewer);
PetscErrorCode RunDestroy(Run *run);
PetscErrorCode RunWriteCheckpoint(Run *run, const char path[], PetscBool final);

/* Start with the particles of -particles. */
PetscErrorCode StartRead(Scene *scene, FluidStart *start, char path[]);
PetscErrorCode StartFree(FluidStart *start);
PetscErrorCode StartCheck(const Scene *scene, const char path[], const Particles *particles,
                          Neighbors *neighbors);

#endif
