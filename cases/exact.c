/* Quantities of cases whose only reference is an exact solution. */
#include "cases.h"

/*
  MeasureExact - Reports the quantities of every case, and error norms against the exact solution if
  the run has the physics and the constant viscosity of the case

  Collective
*/
PetscErrorCode MeasureExact(const Flow *flow, Report *report)
{
  const Scene *scene = flow->scene;

  PetscFunctionBegin;
  if (SceneIsAsPosed(scene) && SceneIsNewtonian(scene)) PetscCall(NormsExact(flow, report));
  PetscCall(MeasureCommon(flow, NAN, report));
  PetscFunctionReturn(PETSC_SUCCESS);
}
