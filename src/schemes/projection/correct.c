/* The corrector of the projection: the pressure increment, and the new velocity and pressure. The
   unknowns of the pressure are a row, PressureSpace. */
#include "projection.h"

/* Returns the share of the pressure increment phi that is added to the pressure, min(1, 4
   dt/dt_wanted). An error e of the velocity gives phi of about rho e dx/dt. If a report cuts a step
   short, phi is therefore far too large for the following steps, which may be thousands of times as
   long. An incremental projection therefore adds about the phi that a step of usual length would
   have; the true change of the pressure in such a short time is small. See theory.md,
   (projection:share). */
static PetscReal PressureGain(const Flow *flow)
{
  const Projection *pr = (const Projection *)flow->scheme->data;

  return pr->row->incremental ? PetscMin(1.0, 4.0 * flow->clock->dt / flow->clock->dt_wanted) : 1.0;
}

/* Keeps u - u* of the present step for ConvectionOfCorrection(), in two parts: u* before the
   correction, with `after` the difference. */
static PetscErrorCode KeepCorrection(const FlowState *s, PetscBool after)
{
  PetscFunctionBegin;
  for (PetscInt c = 0; c < ISPH_MAX_DIM && s->correction_prev[c]; c++) {
    if (after) PetscCall(VecAYPX(s->correction_prev[c], -1.0, s->u_next[c]));
    else PetscCall(VecCopy(s->u_next[c], s->correction_prev[c]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  ProjectVelocity - Solves for the pressure increment phi from div u*, then corrects velocity and
  pressure

    u = u* - k/rho grad phi,   p = [p^n] + s (phi [- c mu div u*]),   s = PressureGain()

  Collective. k is the length of the viscous step. p^n is present in incremental projections, and
  div u* in the rotational projection. c is LaplacianDilatation(). mu is rho times the least
  viscosity of the flow: it is exact for a uniform viscosity, and stable for a varying one. With the
  local viscosity in its place, a drop 1e5 times as viscous as the fluid around it became unstable
  within 4 steps.
*/
PetscErrorCode ProjectVelocity(Flow *flow)
{
  const Projection *pr    = (const Projection *)flow->scheme->data;
  FlowState        *state = flow->state;

  PetscFunctionBegin;
  PetscCall(WallValuesSetVelocity(flow->scene, flow->particles, flow->clock->t + flow->clock->dt,
                                  pr->k / flow->scene->rho, &flow->walls));
  PetscCall(KeepCorrection(state, PETSC_FALSE));
  PetscCall(pr->space->Solve(flow));
  if (flow->scheme->failure.code) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(pr->space->Accelerate(flow, PETSC_TRUE, -pr->k / flow->scene->rho, state->u_next));
  PetscCall(KeepCorrection(state, PETSC_TRUE));
  PetscCall(VecCopy(state->p, state->p_before));
  PetscCall(pr->space->Update(flow, PressureGain(flow)));
  PetscFunctionReturn(PETSC_SUCCESS);
}
