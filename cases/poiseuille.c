/* Start-up of plane Poiseuille flow from rest, driven by a body force along x. By default the only
   physics is viscosity and this force. The exact solution is a series for an impulsive start. */
#include "cases.h"

/* Sets the force f = 8 nu U/L^2, which drives a steady flow of largest velocity U. */
static PetscErrorCode PoiseuilleSetup(Scene *scene)
{
  PetscFunctionBegin;
  PetscCall(ChannelSetup(scene));
  scene->body_force[0] = 8.0 * scene->nu * scene->speed / PetscSqr(scene->length);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Returns the steady velocity between plates of a fluid that is not Newtonian. The shear stress is
  tau = f (d - s) at a distance s from the nearer wall, with d = L/2 and the force f, so

    u = int_(tau(y))^(tau_w) g(tau) dtau/f,

  where tau_w is the stress at the wall and g(tau) the strain rate of the ideal fluid. The midpoint
  rule computes the integral with an error of 1e-5 for the present rheologies.
*/
static PetscReal SteadyVelocity(const Scene *scene, PetscReal y)
{
  const PetscReal f = scene->body_force[0], d = 0.5 * scene->length, wall = PetscAbsReal(f) * d,
                  here  = PetscAbsReal(f * (y - d));
  const PetscInt panels = 200;
  PetscReal      sum    = 0.0;

  for (PetscInt k = 0; k < panels; k++)
    sum += RheologyRate(&scene->rheology, here + (wall - here) * (k + 0.5) / (PetscReal)panels);
  return f != 0.0 ? sum * (wall - here) / panels / f : 0.0;
}

/*
  Computes the start-up of plane Poiseuille flow, Y: distance from the middle, d = L/2

    u/U = 1 - (Y/d)^2 - 32/pi^3 sum_n (-1)^n/(2n+1)^3 cos((2n+1) pi Y/2d)
                        exp(-(2n+1)^2 pi^2 nu t/4d^2),   U = f d^2/(2 nu)

  With -rheology the result is the steady flow at any t > 0.

  Reference: M. Basa, N. Quinlan, M. Lastiwka, Int. J. Numer. Meth. Fluids 60 (2009), Eq. (36). The
  printed equation multiplies the series by (Y/d)^2, so that u = U at the wall; the series above
  satisfies the equation of motion, the wall condition and the start from rest.
*/
static void PoiseuilleExact(const Scene *scene, PetscReal t, const PetscReal x[], PetscReal u[],
                            PetscReal *p)
{
  const PetscReal d = 0.5 * scene->length, y = (x[1] - d) / d,
                  tau = scene->nu * t / PetscSqr(2.0 * d);
  PetscReal sum       = 0.0;

  u[0] = u[1] = 0.0;
  if (t <= 0.0) return;
  if (!SceneIsNewtonian(scene)) {
    u[0] = SteadyVelocity(scene, x[1]);
    return;
  }
  for (PetscInt n = 0; n < 1000; n++) {
    const PetscReal m = 2.0 * n + 1.0, decay = PetscExpReal(-PetscSqr(m * PETSC_PI) * tau);

    if (decay < 1e-16) break;
    sum += (n % 2 ? -1.0 : 1.0) / (m * m * m) * PetscCosReal(0.5 * m * PETSC_PI * y) * decay;
  }
  u[0] = scene->body_force[0] * d * d / (2.0 * scene->nu) *
         (1.0 - y * y - 32.0 / (PETSC_PI * PETSC_PI * PETSC_PI) * sum);
}

/* Reports errors of the profile, also relative to the local velocity. */
static PetscErrorCode PoiseuilleMeasure(const Flow *flow, Report *report)
{
  PetscFunctionBegin;
  PetscCall(ChannelMeasure(flow, PETSC_TRUE, report));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const CaseRow CasePoiseuille = {
    .name            = "poiseuille",
    .brief           = "start-up of plane Poiseuille flow; Re on the half width",
    .citation        = "Basa, Quinlan & Lastiwka, Int. J. Numer. Meth. Fluids 60 (2009)",
    .physics         = PHYSICS_VISCOSITY | PHYSICS_WALLS | PHYSICS_BODY_FORCE,
    .reynolds        = 0.5,
    .reynolds_length = 0.5,
    .t_end           = 0.3,
    .n               = 40,
    .Setup           = PoiseuilleSetup,
    .Exact           = PoiseuilleExact,
    .Measure         = PoiseuilleMeasure,
};
