/* What the files of this stage share: everything a run of a flow owns. */
#ifndef ISPH_RUN_IMPL_H
#define ISPH_RUN_IMPL_H

#include "isph/run.h"

typedef struct Checkpoints Checkpoints;

/* In the order of their making. */
typedef struct {
  Scene         *scene;
  Clock         *clock;
  Operators     *ops;
  Scheme        *scheme;
  Particles     *particles;
  Neighbors     *neighbors;
  Snapshots     *snapshots;
  Monitors      *monitors;
  Progress      *progress;
  Report        *report;
  MatrixFile    *visc_matrix, *ppe_matrix;
  Checkpoints   *checkpoints;
  Undo          *undo;    /* NULL: steps are not retried */
  PetscLogDouble started; /* wall clock [s] */
} Run;

/* checkpoint.c */
PetscErrorCode CheckpointsCreate(const Scheme *scheme, Checkpoints **checkpoints);
PetscErrorCode CheckpointsDestroy(Checkpoints **checkpoints);
PetscErrorCode CheckpointsUpdate(PetscBool final, Run *run);
PetscErrorCode CheckpointsRestart(Run *run, PetscBool *restarted);

/* interrupt.c */
PetscErrorCode InterruptInstall(void);
PetscErrorCode InterruptCheck(const char **signal);

#endif
