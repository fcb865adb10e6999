/* Shared by cases with an exact solution: their quantities, and a start from the solution. */
#include "cases.h"

/* MeasureExact - Reports the quantities of every case, and error norms against the exact solution
   if the run has the physics and the constant viscosity of the case. Collective. */
PetscErrorCode MeasureExact(const Flow *flow, Report *report)
{
  const Scene *scene = flow->scene;

  PetscFunctionBegin;
  if (SceneIsAsPosed(scene) && SceneIsNewtonian(scene)) PetscCall(NormsExact(flow, report));
  PetscCall(MeasureCommon(flow, NAN, report));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* VelocityExact - Computes the velocity of the exact solution, for cases that start from it */
void VelocityExact(const Scene *scene, PetscReal t, const PetscReal x[], PetscReal u[])
{
  PetscReal p;

  scene->problem->Exact(scene, t, x, u, &p);
}
