/*
  The pressure of particles on free surfaces in the projection, p = p_0 + 2 mu n.E n + sigma kappa,
  with the pressure p_0 outside, the strain rate E, and the surface tension sigma and the curvature
  kappa of the present surface. Rough particles have no 2 mu n.E n, and isolated ones have no
  sigma kappa either.

  An incremental projection has E of u*: 2 mu n.E n is part of the viscous term, see
  surfacestress.c, the force of the predictor has the other terms, and the increment phi
  vanishes on the surface. With E of the last velocity steps of 0.1 dx^2/nu amplified disturbances
  of single particles of thin films: theory.md, (surface:gain) and (surface:predictor). Chorin's
  predictor has no pressure, and phi has E of the velocity at the start of the step.
*/
#include "projection.h"

/* Returns true if the projection adds increments to a pressure of the predictor. */
static PetscBool IsIncremental(const Flow *flow)
{
  return ((const Projection *)flow->scheme->data)->row->incremental;
}

/* Adds 2 mu n.E n of the velocity u at particles on free surfaces to p. */
static PetscErrorCode AddStress(Flow *flow, const Vec u[], Vec p)
{
  const Particles   *of = flow->particles;
  Vec                strain;
  const PetscScalar *twice;
  PetscScalar       *to;

  PetscFunctionBegin;
  PetscCall(FlowGetWork(flow, &strain));
  PetscCall(FlowMassRows(flow, u, strain));
  PetscCall(VecGetArrayRead(strain, &twice));
  PetscCall(VecGetArray(p, &to));
  for (PetscInt i = 0; i < of->n_fluid; i++) {
    const PetscReal mu = flow->scene->rho * (of->nu ? of->nu[i] : flow->scene->nu);

    if (FreeSurfaceHolds(flow->ops->free, i)) to[i] += mu * twice[i];
  }
  PetscCall(VecRestoreArray(p, &to));
  PetscCall(VecRestoreArrayRead(strain, &twice));
  PetscCall(FlowRestoreWork(flow, &strain));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets p at particles on free surfaces to the terms that do not depend on the velocity, less a
   level [Pa]. */
static PetscErrorCode SetOutside(const Flow *flow, PetscReal level, Vec p)
{
  const FreeSurface *free = flow->ops->free;
  PetscScalar       *to;

  PetscFunctionBegin;
  PetscCall(VecGetArray(p, &to));
  for (PetscInt i = 0; i < flow->particles->n_fluid; i++)
    if (FreeSurfaceHolds(free, i))
      to[i] = FreeSurfacePressure(free, i) + (flow->scene->outside - level);
  PetscCall(VecRestoreArray(p, &to));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FreePressureFirst - Sets b of the first pressure of a run on free surfaces: their pressure less
   the level of the scene, without the stress of the velocity; collective */
PetscErrorCode FreePressureFirst(const Flow *flow, Vec b)
{
  PetscFunctionBegin;
  if (flow->ops->free) PetscCall(SetOutside(flow, flow->scene->level, b));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FreePressureStart - Sets the pressure of free surfaces in the force of the predictor;
   collective */
PetscErrorCode FreePressureStart(Flow *flow)
{
  PetscFunctionBegin;
  if (flow->ops->free && IsIncremental(flow)) PetscCall(SetOutside(flow, 0.0, flow->state->p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FreePressureFollow - Adds the pressure that belongs to u*; collective */
PetscErrorCode FreePressureFollow(Flow *flow)
{
  PetscFunctionBegin;
  if (flow->ops->free && IsIncremental(flow))
    PetscCall(AddStress(flow, flow->state->u_next, flow->state->p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FreePressureIncrement - Sets b of the pressure equation on free surfaces: the increment of their
   pressure. Collective. Their rows of the equation are phi_i = b_i. */
PetscErrorCode FreePressureIncrement(Flow *flow, Vec b)
{
  PetscScalar *increment;

  PetscFunctionBegin;
  if (!flow->ops->free) PetscFunctionReturn(PETSC_SUCCESS);
  if (!IsIncremental(flow)) {
    PetscCall(SetOutside(flow, flow->scene->level, b));
    PetscCall(AddStress(flow, flow->state->u, b));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(VecGetArray(b, &increment));
  for (PetscInt i = 0; i < flow->particles->n_fluid; i++)
    if (FreeSurfaceHolds(flow->ops->free, i)) increment[i] = 0.0;
  PetscCall(VecRestoreArray(b, &increment));
  PetscFunctionReturn(PETSC_SUCCESS);
}
