/*
  The normal derivative of the pressure at walls, which momentum gives: n.grad p = rho n.(f - a), a
  the acceleration of the wall. The pressure has a share of it that grows with the steps; each step
  adds the change of the full value.
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

/* Sets the gradient that the pressure has at time t, a share of the full one; no step is pending.
   */
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

/* Sets the gain in the step to time t: the full gradient then less the one that p^n has. */
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

/* Returns the time of the wall gradient after a step of length dt to time t: the time at which the
   step takes its force. */
static PetscReal GradientTime(const Projection *pr, PetscReal t, PetscReal dt)
{
  return !pr->visc || pr->visc->row->end_of_step ? t : t - 0.5 * dt;
}

/* WallGradientBegin - Sets the wall gradient of the pressure as the particles carry it; collective
   */
PetscErrorCode WallGradientBegin(Flow *flow)
{
  const Projection *pr    = (const Projection *)flow->scheme->data;
  const Clock      *clock = flow->clock;

  PetscFunctionBegin;
  PetscCall(
      SetGradient(flow, GradientTime(pr, clock->t, clock->dt_previous), pr->wall_slope_share));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* WallGradientPredict - Sets the wall gradient for the step at hand: of p^n, and its gain */
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
