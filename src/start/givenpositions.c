/* Fluid that starts at given positions, and its volumes. */
#include "start.h"

/* GivenFill - Creates fluid at given positions. Collective. Ids are consecutive in the order of
   ranks. The particles share the volume of regions filled at the start. Input: p - with room for
   the fluid. */
PetscErrorCode GivenFill(const Scene *scene, const FluidStart *start, Particles *p)
{
  PetscReal volume = 0.0;
  Pools     pools  = {0};

  PetscFunctionBegin;
  PetscCall(PoolsCreate(scene, &pools));
  for (PetscInt pool = 0; pool < pools.n; pool++) volume += pools.volume[pool];
  for (PetscInt i = 0; i < start->n; i++) {
    p->id[i]     = start->first + i;
    p->kind[i]   = PARTICLE_FLUID;
    p->dx[i]     = SceneSpacing(scene, &start->x[i * p->dim]);
    p->volume[i] = volume > 0.0 ? volume / start->N : SceneVolumeAt(scene, &start->x[i * p->dim]);
    for (PetscInt a = 0; a < p->dim; a++) {
      p->x[a][i] = start->x[i * p->dim + a];
      if (start->u) p->u[a][i] = start->u[i * p->dim + a];
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
