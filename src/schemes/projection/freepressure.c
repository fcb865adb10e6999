/*
  The pressure of particles on free surfaces in the projection, p = p_0 + 2 mu n.E n + sigma
  kappa, with the pressure p_0 outside, the strain rate E of the velocity at the start of the step,
  and the surface tension sigma and the curvature kappa of the present surface. It is p_0 where the
  surface is rough. The increment phi of the pressure equation has this value minus p^n, so that the
  pressure is determined.

  With a velocity of the same time any dt would be stable: that needs the coupled scheme. Here
  ProjectionFreeLimit() bounds dt: docs/theory.md, (160).
*/
#include "projection.h"

/*
  FreePressureIncrement - Sets b of the pressure equation on free surfaces: the increment of their
  pressure

  Collective. Their rows of the equation are phi_i = b_i.
*/
PetscErrorCode FreePressureIncrement(Flow *flow, Vec b)
{
  const Operators   *ops = flow->ops;
  const FlowState   *s   = flow->state;
  const Particles   *of  = flow->particles;
  Vec                strain;
  const PetscScalar *twice, *p;
  PetscScalar       *increment;

  PetscFunctionBegin;
  if (!ops->free) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FlowGetWork(flow, &strain));
  PetscCall(FlowMassRows(flow, s->u, strain));
  PetscCall(VecGetArrayRead(strain, &twice));
  PetscCall(VecGetArrayRead(s->p, &p));
  PetscCall(VecGetArray(b, &increment));
  for (PetscInt i = 0; i < of->n_fluid; i++) {
    const PetscReal mu = flow->scene->rho * (of->nu ? of->nu[i] : flow->scene->nu);

    if (FreeSurfaceHolds(ops->free, i))
      increment[i] =
          mu * twice[i] + FreeSurfacePressure(ops->free, i) + flow->scene->outside - p[i];
  }
  PetscCall(VecRestoreArray(b, &increment));
  PetscCall(VecRestoreArrayRead(s->p, &p));
  PetscCall(VecRestoreArrayRead(strain, &twice));
  PetscCall(FlowRestoreWork(flow, &strain));
  PetscFunctionReturn(PETSC_SUCCESS);
}
