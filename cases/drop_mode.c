/*
  A viscous drop that decays to rest: the least damped flow of mode 2 in a disc with a free surface,
  for amplitudes that leave the disc round. An exact solution with both conditions of the surface.
*/
#include "cases.h"
#include <math.h>

#define WAVE_NUMBER 2.3538876347708 /* k R, root of the determinant of the two conditions */

/* Derivative of the Bessel function J_2. */
static PetscReal SlopeOfJ2(PetscReal x)
{
  return 0.5 * (jn(1, x) - jn(3, x));
}

static PetscErrorCode DropModeSetup(Scene *scene)
{
  const PetscReal R = scene->length;
  Body           *body;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < scene->dim; a++) {
    scene->lo[a] = -1.5 * R;
    scene->hi[a] = 1.5 * R;
  }
  SceneSetSides(scene, &BoundaryNone);
  body = &SceneAddFree(scene)->body;
  BodyCircle(body, 0.0, 0.0, R);
  body->around = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Computes velocity and pressure from the stream function psi, with r in units of R

    psi = (a r^2 + b J_2(k r)) sin(2 theta) exp(-k^2 nu t/R^2)
    u_r = psi_theta/r,   u_theta = -psi_r,   p = rho nu k^2 a r^2 cos(2 theta) exp(...)
    tangential stress:   4 a + b (-2 k J_2' + (8 - k^2) J_2) = 0 at r = 1
    normal stress:       a (4 - k^2) + 4 b (k J_2' - J_2) = 0 at r = 1

  u_r is U cos(2 theta) at r = 1 and t = 0.
*/
static void DropModeExact(const Scene *scene, PetscReal t, const PetscReal x[], PetscReal u[],
                          PetscReal *p)
{
  const PetscReal k = WAVE_NUMBER, R = scene->length, J = jn(2, k), dJ = SlopeOfJ2(k);
  const PetscReal ratio = (2.0 * k * dJ - (8.0 - k * k) * J) / 4.0; /* a/b */
  const PetscReal decay = scene->speed * PetscExpReal(-k * k * scene->nu * t / (R * R));
  const PetscReal b = 0.5 * decay / (ratio + J), a = ratio * b;
  const PetscReal r      = PetscMax(PetscSqrtReal(x[0] * x[0] + x[1] * x[1]) / R, 1e-12);
  const PetscReal cosine = x[0] / (R * r), sine = x[1] / (R * r);
  const PetscReal cos2 = cosine * cosine - sine * sine, sin2 = 2.0 * sine * cosine;
  const PetscReal radial = 2.0 * (a * r + b * jn(2, k * r) / r) * cos2,
                  along  = -(2.0 * a * r + b * k * SlopeOfJ2(k * r)) * sin2;

  u[0] = radial * cosine - along * sine;
  u[1] = radial * sine + along * cosine;
  *p   = scene->rho * scene->nu * k * k * a * r * r * cos2 / R;
}

static void DropModeVelocity(const Scene *scene, PetscReal t, const PetscReal x[], PetscReal u[])
{
  PetscReal p;

  DropModeExact(scene, t, x, u, &p);
}

const CaseRow CaseDropMode = {
    .name            = "drop_mode",
    .brief           = "decay of mode 2 in a drop with a free surface",
    .citation        = "exact solution of the Stokes equations",
    .physics         = PHYSICS_VISCOSITY | PHYSICS_PRESSURE,
    .reynolds        = 1.0,
    .reynolds_length = 1.0,
    .t_end           = 0.1,
    .n               = 16,
    .Setup           = DropModeSetup,
    .Velocity        = DropModeVelocity,
    .Exact           = DropModeExact,
    .Measure         = MeasureExact,
};
