/* Particles that enter through openings in a step; openings.c, backflow.c and
   entrants.c. */
#ifndef ISPH_ENTRANTS_H
#define ISPH_ENTRANTS_H

#include "isph/motion.h"

/* A particle that enters, as all ranks know it. */
typedef struct {
  PetscReal x[ISPH_MAX_DIM];     /* position [m] */
  PetscReal slope[ISPH_MAX_DIM]; /* n.grad u there, on the rank that holds it [1/s] */
  PetscReal side;                /* a whole number */
} Entrant;
#define ENTRANT_NUMBERS ((PetscInt)(sizeof(Entrant) / sizeof(PetscReal)))

/* The particles that enter in a step: first the share of a rank, then of all ranks. */
typedef struct {
  const Flow *flow;
  PetscInt    n, capacity;
  Entrant    *entrant;
  PetscInt   *of;  /* those that this rank inserts */
  PetscReal   far; /* largest depth that fluid has entered in the step [length of the box] */
} Entrants;

PetscErrorCode EntrantsAdd(const Particles *particles, PetscInt w, PetscReal distance,
                           Entrants *entrants);
PetscErrorCode EntrantsGather(MPI_Comm comm, Entrants *all);
PetscErrorCode EntrantsInsert(Flow *flow, Entrants *all);
PetscErrorCode EntrantsFindReturning(Flow *flow, Entrants *entrants);
void           EntrantsDropCrowded(const Scene *scene, Entrants *entrants);

#endif
