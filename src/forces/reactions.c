/* Forces of strain cells on particles: what multiplies their velocities in the power of stress.
   They stand in the momentum equation that is solved. The pressure has such forces where a free
   surface cuts the cells; elsewhere the momentum equation has its gradient at particles. */
#include "isph/forces.h"
#include "isph/strain.h"

/* Adds the body force on the fluid that walls hold: the weights of their rows. */
static void AddWeight(const Flow *flow, PetscReal force[])
{
  const Particles   *p     = flow->particles;
  const StrainCells *cells = flow->ops->strain;

  if (!SceneHas(flow->scene, PHYSICS_BODY_FORCE)) return;
  for (PetscInt j = p->n_fluid; j < ParticlesAll(p); j++) {
    PetscReal x[ISPH_MAX_DIM], f[ISPH_MAX_DIM];

    if (!ParticlesIsWall(p, j)) continue;
    ParticlesWallPoint(p, j, x);
    SceneBodyForce(flow->scene, flow->clock->t, x, f);
    for (PetscInt k = 0; k < p->dim * p->dim; k++)
      force[p->dim * j + k % p->dim] += flow->scene->rho * f[k / p->dim] * cells->weight[k][j];
  }
}

/* CellForces - Computes the forces of own strain cells on particles; collective. Output: force -
   component a on particle j at [j dim + a], by local index, to be freed by PetscFree() [N]. */
PetscErrorCode CellForces(const Flow *flow, PetscReal **force)
{
  const Particles *p = flow->particles;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(p->dim * ParticlesAll(p), force));
  PetscCall(
      StrainForces(flow->scene, p, flow->state->u, flow->clock->dt, flow->ops->strain, *force));
  if (flow->ops->cut_surface) AddWeight(flow, *force);
  if (flow->ops->cut_surface && flow->clock->step > 0)
    PetscCall(flow->scheme->PressOnWalls(flow, *force + p->dim * p->n_fluid));
  PetscFunctionReturn(PETSC_SUCCESS);
}
