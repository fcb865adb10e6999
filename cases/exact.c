/* Quantities of cases whose only reference is an exact solution. */
#include "cases.h"

/*
  MeasureExact - Reports error norms against the exact solution of the case, if the run has the
  physics and the constant viscosity of the case
*/
PetscErrorCode MeasureExact(const Flow *flow, Report *report)
{
  const Scene *scene = flow->scene;

  PetscFunctionBegin;
  if (SceneIsAsPosed(scene) && SceneIsNewtonian(scene)) PetscCall(NormsExact(flow, report));
  PetscCall(MeasureCommon(flow, NAN, report));
  PetscFunctionReturn(PETSC_SUCCESS);
}
