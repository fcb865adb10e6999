/* Start-up of plane Couette flow from rest: the wall at y = L moves along x with U. By default the
   only physics is viscosity. The exact solution is a series for an impulsive start. */
#include "cases.h"

/* Computes wall velocities: the wall at y = L moves with U. */
static void CouetteWallVelocity(const Scene *scene, PetscInt side, PetscReal t, const PetscReal x[],
                                PetscReal u[])
{
  if (side == 3) u[0] = scene->speed;
}

/*
  Computes the start-up of plane Couette flow

    u/U = y/L + sum_n 2 (-1)^n/(n pi) sin(n pi y/L) exp(-n^2 pi^2 nu t/L^2)

  With -rheology the result is the steady flow at any t > 0.

  Reference: J. P. Morris, P. J. Fox, Y. Zhu, J. Comput. Phys. 136 (1997), Eq. (22)
*/
static void CouetteExact(const Scene *scene, PetscReal t, const PetscReal x[], PetscReal u[],
                         PetscReal *p)
{
  const PetscReal y = x[1] / scene->length, tau = scene->nu * t / PetscSqr(scene->length);
  PetscReal       sum = y;

  u[0] = u[1] = 0.0;
  if (t <= 0.0) return;
  if (!SceneIsNewtonian(scene)) { /* steady: uniform shear stress and rate */
    u[0] = scene->speed * y;
    return;
  }
  for (PetscInt n = 1; n < 2000; n++) {
    const PetscReal decay = PetscExpReal(-PetscSqr(n * PETSC_PI) * tau);

    if (decay < 1e-16) break;
    sum += (n % 2 ? -2.0 : 2.0) / (n * PETSC_PI) * PetscSinReal(n * PETSC_PI * y) * decay;
  }
  u[0] = scene->speed * sum;
}

/* Reports errors of the profile, but not relative to the local velocity: far from the moving
   wall this velocity is almost zero at first. */
static PetscErrorCode CouetteMeasure(const Flow *flow, Report *report)
{
  PetscFunctionBegin;
  PetscCall(ChannelMeasure(flow, PETSC_FALSE, report));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const CaseRow CaseCouette = {
    .name            = "couette",
    .brief           = "start-up of plane Couette flow",
    .citation        = "Morris, Fox & Zhu, J. Comput. Phys. 136 (1997)",
    .physics         = PHYSICS_VISCOSITY | PHYSICS_WALLS,
    .reynolds        = 1.0,
    .reynolds_length = 1.0,
    .t_end           = 1.0,
    .n               = 40,
    .Setup           = ChannelSetup,
    .WallVelocity    = CouetteWallVelocity,
    .Exact           = CouetteExact,
    .Measure         = CouetteMeasure,
};
