/* The checkpoint file: declarations for writing it and for restarts. */
#ifndef ISPH_RUN_CHECKPOINT_H
#define ISPH_RUN_CHECKPOINT_H

#include "impl.h"
#include "io/hdf5file.h"

#define CHECKPOINT_FORMAT 23 /* version of the layout of the file */

/* An entry of numbers that identify a scene in the file; a restart refuses a file with other
   numbers. Each entry is a row of the table in identity.c. */
#define SCENE_ENTRY_MAX (2 * ISPH_MAX_DIM)
typedef struct {
  const char *name;      /* of the data set */
  PetscInt    n;         /* numbers, at most SCENE_ENTRY_MAX */
  PetscReal   tolerance; /* of their difference [SceneTolerance()]; 0: they must be equal */
  const char *refusal;   /* sentence for a file with other numbers */
  PetscErrorCode (*Compute)(const Scene *scene, double value[]);
} SceneEntry;

struct Checkpoints {
  char      path[PETSC_MAX_PATH_LEN];    /* empty: no checkpoints */
  char      restart[PETSC_MAX_PATH_LEN]; /* empty: no restart */
  PetscReal every;                       /* time between checkpoints; 0: at the end only [s] */
  PetscReal last;                        /* time of the last checkpoint, or of the start [s] */
  PetscInt  step;                        /* step of the last checkpoint; -1: none */
};

PetscErrorCode    CheckpointMemory(const Memory *memory, char names[], size_t length);
PetscErrorCode    CheckpointRecord(const Particles *particles, char names[], size_t length);
const SceneEntry *CheckpointSceneEntry(PetscInt k);
void              CheckpointSumNumbers(PetscInt n, const double numbers[], uint64_t *sum);
void              CheckpointSumText(const char text[], uint64_t *sum);
PetscErrorCode    CheckpointSumRecords(PetscInt n, PetscInt width, const PetscReal record[],
                                       uint64_t *sum);
PetscErrorCode    CheckpointSumKept(PetscInt start, PetscInt n, const PetscReal values[],
                                    uint64_t *sum);

#endif
