/* A closed box of fluid at rest under gravity: it must stay so. g = U^2/L along the last axis. */
#include "cases.h"

PetscErrorCode HydrostaticSetup(Scene *scene)
{
  PetscFunctionBegin;
  for (PetscInt a = 0; a < scene->dim; a++) scene->hi[a] = scene->length;
  scene->body[scene->dim - 1] = -PetscSqr(scene->speed) / scene->length;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* HydrostaticExact - u = 0, p = rho g (L/2 - height) */
void HydrostaticExact(const Scene *scene, PetscReal t, const PetscReal x[], PetscReal u[],
                      PetscReal *p)
{
  const PetscInt up = scene->dim - 1;

  for (PetscInt a = 0; a < scene->dim; a++) u[a] = 0.0;
  *p = scene->rho * scene->body[up] * (x[up] - 0.5 * scene->length);
}

/*
  HydrostaticJudge - Pressure against the exact one, and speed_over_gdt: the largest speed over what
  gravity would give in one step, g dt
*/
PetscErrorCode HydrostaticJudge(const Flow *flow, Report *report)
{
  const Scene    *scene = flow->scene;
  const PetscReal fall  = PetscAbsReal(scene->body[scene->dim - 1]) * flow->clock->dt;

  PetscFunctionBegin;
  if (fall > 0.0)
    PetscCall(ReportAddError(report, "speed_over_gdt", flow->scheme->stats.speed_max / fall));
  PetscCall(ExactJudge(flow, report));
  PetscFunctionReturn(PETSC_SUCCESS);
}
