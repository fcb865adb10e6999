/* The wall data of the pressure in the projection: n.grad p = rho n.(f - a) of the momentum
   equation, with the acceleration a of the wall, or a pressure that the boundary gives. The
   pressure of a run that starts from p = 0 has only a share of the full data. The increment of each
   step has the data that the pressure lacks, and the share grows to 1. See theory.md,
   (projection:wall). */
#include "projection.h"

/* Returns the time at which the wall gradient is evaluated in a step of length dt to time t: the
   time of the force. */
static PetscReal GradientTime(const Projection *pr, PetscReal t, PetscReal dt)
{
  return !pr->visc || pr->visc->row->end_of_step ? t : t - 0.5 * dt;
}

/* WallGradientBegin - Sets the wall gradient of the present pressure, before a step; collective */
PetscErrorCode WallGradientBegin(Flow *flow)
{
  const Projection *pr    = (const Projection *)flow->scheme->data;
  const Clock      *clock = flow->clock;

  PetscFunctionBegin;
  PetscCall(WallValuesSetPressure(flow->scene, flow->particles,
                                  GradientTime(pr, clock->t, clock->dt_previous),
                                  pr->wall_slope_share, &flow->walls));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* WallGradientPredict - Sets the wall gradient of p^n and its gain in the step; collective */
PetscErrorCode WallGradientPredict(Flow *flow)
{
  Projection  *pr    = (Projection *)flow->scheme->data;
  const Clock *clock = flow->clock;

  PetscFunctionBegin;
  if (!pr->row->incremental) pr->wall_slope_share = 0.0;
  PetscCall(WallGradientBegin(flow));
  PetscCall(WallValuesStepPressure(flow->scene, flow->particles,
                                   GradientTime(pr, clock->t + clock->dt, clock->dt),
                                   &flow->walls));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* WallGradientCorrect - Sets the wall gradient of p^{n+1}, with the share of PressureGain();
   collective */
PetscErrorCode WallGradientCorrect(Flow *flow, PetscReal gain)
{
  Projection  *pr    = (Projection *)flow->scheme->data;
  const Clock *clock = flow->clock;

  PetscFunctionBegin;
  pr->wall_slope_share += gain * (1.0 - pr->wall_slope_share);
  PetscCall(WallValuesSetPressure(flow->scene, flow->particles,
                                  GradientTime(pr, clock->t + clock->dt, clock->dt),
                                  pr->wall_slope_share, &flow->walls));
  PetscFunctionReturn(PETSC_SUCCESS);
}
