/* Decaying Taylor-Green vortices in a periodic square, an exact solution of the Navier-Stokes
   equations. In 3D the same flow is uniform along z in a cube, and exact too. */
#include "cases.h"

static PetscErrorCode TaylorGreenSetup(Scene *scene)
{
  PetscFunctionBegin;
  for (PetscInt a = 0; a < scene->dim; a++) scene->hi[a] = scene->length;
  SceneSetSides(scene, &BoundaryPeriodic);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Computes velocity and pressure, X = 2 pi x/L, Y = 2 pi y/L, k = 2 pi/L

    u = U (sin X cos Y, -cos X sin Y) exp(-2 k^2 nu t)
    p = rho U^2/4 (cos 2X + cos 2Y) exp(-4 k^2 nu t)

  Reference: G. I. Taylor, A. E. Green, Proc. R. Soc. A 158 (1937) 499-521
*/
static void TaylorGreenExact(const Scene *scene, PetscReal t, const PetscReal x[], PetscReal u[],
                             PetscReal *p)
{
  const PetscReal k = 2.0 * PETSC_PI / scene->length, X = k * x[0], Y = k * x[1];
  const PetscReal nu    = SceneHas(scene, PHYSICS_VISCOSITY) ? scene->nu : 0.0;
  const PetscReal decay = scene->speed * PetscExpReal(-2.0 * k * k * nu * t);

  u[0] = decay * PetscSinReal(X) * PetscCosReal(Y);
  u[1] = -decay * PetscCosReal(X) * PetscSinReal(Y);
  if (scene->dim == 3) u[2] = 0.0;
  *p = 0.25 * scene->rho * decay * decay * (PetscCosReal(2.0 * X) + PetscCosReal(2.0 * Y));
}

const CaseRow CaseTaylorGreen = {
    .name            = "taylor_green",
    .brief           = "decaying Taylor-Green vortices, in 3D uniform along z",
    .citation        = "Taylor & Green, Proc. R. Soc. A 158 (1937)",
    .three_d         = PETSC_TRUE,
    .physics         = NAVIER_STOKES,
    .reynolds        = 100.0,
    .reynolds_length = 1.0,
    .t_end           = 1.0,
    .n               = 50,
    .Setup           = TaylorGreenSetup,
    .Velocity        = VelocityExact,
    .Exact           = TaylorGreenExact,
    .Measure         = MeasureExact,
};
