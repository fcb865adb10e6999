/*
  The wall pressure gradient of the projection from the momentum equation, n.grad p = rho n.(f - a),
  with the acceleration a of the wall. The pressure of a run that starts from p = 0 has only a share
  of this full gradient. The increment of each step has the gradient that the pressure lacks, and
  the share grows to 1. See docs/theory.md, (87).
*/
#include "projection.h"

/* Returns n.grad p = rho n.(f - a) at own wall particle w [Pa/m]. */
static PetscReal WallPressureGradient(const Scene *scene, const Particles *p, PetscInt w,
                                      PetscReal t)
{
  const PetscInt i    = p->n_fluid + w;
  PetscReal      full = 0.0, x[ISPH_MAX_DIM], acceleration[ISPH_MAX_DIM], force[ISPH_MAX_DIM];

  ParticlesWallPoint(p, i, x);
  SceneWallAcceleration(scene, (PetscInt)p->side[i], t, x, acceleration);
  SceneBodyForce(scene, t, x, force);
  for (PetscInt a = 0; a < scene->dim; a++)
    full += scene->rho * (force[a] - acceleration[a]) * p->normal[a][i];
  return full;
}

/* Sets the wall gradient of the pressure to a share of the full gradient at time t, and its gain in
   the step to zero. */
static PetscErrorCode SetGradient(Flow *flow, PetscReal t, PetscReal share)
{
  WallValues  *walls = &flow->walls;
  PetscScalar *dpdn;

  PetscFunctionBegin;
  if (!walls->dpdn) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecGetArray(walls->dpdn, &dpdn));
  for (PetscInt w = 0; w < flow->particles->n_wall; w++)
    dpdn[w] = share * WallPressureGradient(flow->scene, flow->particles, w, t);
  PetscCall(VecRestoreArray(walls->dpdn, &dpdn));
  PetscCall(VecZeroEntries(walls->dpdn_step));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the gain of the wall gradient in the step to time t: the full gradient minus the gradient of
   p^n. */
static PetscErrorCode SetGradientStep(Flow *flow, PetscReal t)
{
  WallValues        *walls = &flow->walls;
  const PetscScalar *dpdn;
  PetscScalar       *step;

  PetscFunctionBegin;
  if (!walls->dpdn) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecGetArrayRead(walls->dpdn, &dpdn));
  PetscCall(VecGetArray(walls->dpdn_step, &step));
  for (PetscInt w = 0; w < flow->particles->n_wall; w++)
    step[w] = WallPressureGradient(flow->scene, flow->particles, w, t) - dpdn[w];
  PetscCall(VecRestoreArrayRead(walls->dpdn, &dpdn));
  PetscCall(VecRestoreArray(walls->dpdn_step, &step));
  PetscFunctionReturn(PETSC_SUCCESS);
}

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
  PetscCall(
      SetGradient(flow, GradientTime(pr, clock->t, clock->dt_previous), pr->wall_slope_share));
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
  PetscCall(SetGradientStep(flow, GradientTime(pr, clock->t + clock->dt, clock->dt)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* WallGradientCorrect - Sets the wall gradient of p^{n+1}; collective */
PetscErrorCode WallGradientCorrect(Flow *flow)
{
  Projection  *pr    = (Projection *)flow->scheme->data;
  const Clock *clock = flow->clock;

  PetscFunctionBegin;
  pr->wall_slope_share += PressureGain(flow) * (1.0 - pr->wall_slope_share);
  PetscCall(
      SetGradient(flow, GradientTime(pr, clock->t + clock->dt, clock->dt), pr->wall_slope_share));
  PetscFunctionReturn(PETSC_SUCCESS);
}
