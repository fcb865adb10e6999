/* The run of a flow: from its scene to its report. */
#ifndef ISPH_RUN_H
#define ISPH_RUN_H

#include "isph/io.h"

extern const OptionTable StartOptions, CheckpointOptions;

/*
  FlowRun - Runs the flow of a scene of SceneCreate(), with banner, steps, files and report

  Collective on PETSC_COMM_WORLD. The options of clock, scheme, operators and outputs are read here;
  an option that nothing reads is refused.

  Errors: PETSC_ERR_USER_INPUT for a refused option, a failed -check_<quantity> or a signal;
  PETSC_ERR_FP for a flow that diverged; PETSC_ERR_NOT_CONVERGED for a failed solve; for all codes
  see docs/reference/exit-status.md
*/
PetscErrorCode FlowRun(Scene *scene);

/* Start with the particles of -particles. */
PetscErrorCode StartRead(Scene *scene, FluidStart *start, char path[]);
PetscErrorCode StartFree(FluidStart *start);
PetscErrorCode StartCheck(const Scene *scene, const char path[], const Particles *particles,
                          Neighbors *neighbors);

#endif
