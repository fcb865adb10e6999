/*
  Forces of strain cells on particles: what multiplies their velocities in the power of stress. They
  are those of the momentum equation that is solved. The pressure has such forces where a free
  surface cuts the cells; elsewhere the momentum equation has its gradient at particles.
*/
#include "isph/forces.h"
#include "isph/strain.h"

/* CellForces - Computes the forces of own strain cells on particles; collective. Output: force -
   component a on particle j at [j dim + a], by local index, to be freed by PetscFree() [N]. */
PetscErrorCode CellForces(const Flow *flow, PetscReal **force)
{
  const Particles *p = flow->particles;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(p->dim * ParticlesAll(p), force));
  PetscCall(
      StrainForces(flow->scene, p, flow->state->u, flow->clock->dt, flow->ops->strain, *force));
  if (flow->ops->cut_surface && flow->clock->step > 0)
    PetscCall(flow->scheme->PressOnWalls(flow, *force + p->dim * p->n_fluid));
  PetscFunctionReturn(PETSC_SUCCESS);
}
