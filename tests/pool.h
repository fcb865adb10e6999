/* Fluid with a free surface, for tests of the particles on it. */
#ifndef POOL_H
#define POOL_H

#include "crowd.h"

typedef struct {
  Setting       s;
  Particles    *p;
  Neighbors    *nb;
  OperatorForms forms;
  FreeSurface   free;
} Pool;

void     PoolFill(PetscReal jitter, Pool *pool);
void     PoolFind(Pool *pool);
void     PoolEmpty(Pool *pool);
PetscInt PoolCount(const Pool *pool, SurfaceKind kind, PetscBool (*on)(const Pool *, PetscInt),
                   PetscBool is);

#endif
