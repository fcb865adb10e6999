/* The measures of a case that has an exact solution and no other reference. */
#include "cases.h"

/*
  MeasureExact - The quantities of a case that has Exact() and no other reference; it holds only
  for the flow as the case poses it, of a viscosity that does not follow the strain rate
*/
PetscErrorCode MeasureExact(const Flow *flow, Report *report)
{
  const Scene *scene = flow->scene;

  PetscFunctionBegin;
  if (SceneIsAsPosed(scene) && SceneIsNewtonian(scene)) PetscCall(NormsExact(flow, report));
  PetscCall(MeasureCommon(flow, NAN, report));
  PetscFunctionReturn(PETSC_SUCCESS);
}
