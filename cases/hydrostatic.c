/* A closed box of fluid at rest under gravity stays at rest. g = U^2/L along the last axis. */
#include "cases.h"

static PetscErrorCode HydrostaticSetup(Scene *scene)
{
  PetscFunctionBegin;
  for (PetscInt a = 0; a < scene->dim; a++) scene->hi[a] = scene->length;
  scene->body_force[scene->dim - 1] = -PetscSqr(scene->speed) / scene->length;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes u = 0 and p = rho f.(x - middle of the box), f: force per unit mass. */
static void HydrostaticExact(const Scene *scene, PetscReal t, const PetscReal x[], PetscReal u[],
                             PetscReal *p)
{
  *p = 0.0;
  for (PetscInt a = 0; a < scene->dim; a++) {
    u[a] = 0.0;
    *p += scene->rho * scene->body_force[a] * (x[a] - 0.5 * scene->length);
  }
}

/* Reports the errors against the exact solution, and speed_over_gdt, the largest speed divided by g
   dt, the speed after a free fall of one step. */
static PetscErrorCode HydrostaticMeasure(const Flow *flow, Report *report)
{
  const Scene *scene = flow->scene;
  PetscReal    fall  = 0.0;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < scene->dim; a++) fall += PetscSqr(scene->body_force[a]);
  fall = PetscSqrtReal(fall) * flow->clock->dt;
  if (fall > 0.0)
    PetscCall(ReportAddError(report, "speed_over_gdt", flow->scheme->stats.speed_max / fall));
  PetscCall(MeasureExact(flow, report));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const CaseRow CaseHydrostatic = {
    .name            = "hydrostatic",
    .brief           = "closed box at rest under gravity",
    .three_d         = PETSC_TRUE,
    .physics         = NAVIER_STOKES | PHYSICS_WALLS | PHYSICS_BODY_FORCE,
    .reynolds        = 100.0,
    .reynolds_length = 1.0,
    .t_end           = 10.0,
    .n               = 16,
    .Setup           = HydrostaticSetup,
    .Exact           = HydrostaticExact,
    .Measure         = HydrostaticMeasure,
};
