/* The checkpoint file: what writing it and restarting from it share. */
#ifndef ISPH_RUN_CHECKPOINT_H
#define ISPH_RUN_CHECKPOINT_H

#include "impl.h"
#include "isph/hdf5file.h"

#define CHECKPOINT_FORMAT 7                      /* to be raised when the file's contents change */
#define SCENE_NUMBERS     (2 * ISPH_MAX_DIM + 3) /* the last: spacing, bodies, viscosities */

struct Checkpoints {
  char      path[PETSC_MAX_PATH_LEN];    /* empty: none are written */
  char      restart[PETSC_MAX_PATH_LEN]; /* empty: the run starts from the beginning */
  PetscReal every;                       /* between checkpoints; 0: at the end only [s] */
  PetscReal last;                        /* time of the last one, or of the start [s] */
  PetscInt  step;                        /* of the last one; -1: none */
};

PetscErrorCode CheckpointMemory(const Memory *memory, char names[], size_t length);
PetscErrorCode CheckpointRecord(const Particles *particles, char names[], size_t length);
PetscErrorCode CheckpointScene(const Scene *scene, double box[SCENE_NUMBERS]);
void           CheckpointSumNumbers(PetscInt n, const double numbers[], uint64_t *sum);
void           CheckpointSumText(const char text[], uint64_t *sum);
PetscErrorCode CheckpointSumRecords(PetscInt n, PetscInt width, const PetscReal record[],
                                    uint64_t *sum);

#endif
