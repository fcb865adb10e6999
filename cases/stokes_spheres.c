/* Creeping flow through a simple cubic array of spheres: a sphere in a periodic cube of side L,
   driven by a body force along x. The drag is compared with a series solution. Option
   -solid_fraction sets the solid fraction. */
#include "cases.h"

#define GAP 4.0 /* least gap between spheres, as between bodies of typed scenes [dx] */

/* Returns the radius of the sphere [m]. */
static PetscReal Radius(const Scene *scene)
{
  return scene->length * cbrt(0.75 * scene->solid_fraction / PETSC_PI);
}

/*
  Returns the drag of a sphere of the array over 6 pi mu a U, with the radius a and the superficial
  velocity U

    K = 1/(1 - 1.7601 c^(1/3) + c - 1.5593 c^2 + 3.9799 c^(8/3) - 3.0734 c^(10/3))

  It is within 0.1 % of the table of A. A. Zick, G. M. Homsy, J. Fluid Mech. 115 (1982) 13-26 up to
  c = 0.125, which has 2.008, 2.810 and 4.292 at 0.027, 0.064 and 0.125. At 0.216 the table has
  7.442, 0.8 % more.

  Reference: A. S. Sangani, A. Acrivos, Int. J. Multiphase Flow 8 (1982) 343-360
*/
static PetscReal SeriesDrag(PetscReal c)
{
  const PetscReal q = cbrt(c);

  return 1.0 / (1.0 - 1.7601 * q + c - 1.5593 * c * c + 3.9799 * PetscPowRealInt(q, 8) -
                3.0734 * PetscPowRealInt(q, 10));
}

#define SERIES_MOST 0.125 /* largest solid fraction for which the series is a reference */

/* Sets the box, the sphere, and the force with which the superficial velocity is U. */
static PetscErrorCode StokesSpheresSetup(Scene *scene)
{
  const PetscReal a         = Radius(scene);
  const PetscReal centre[3] = {0.5 * scene->length, 0.5 * scene->length, 0.5 * scene->length};

  PetscFunctionBegin;
  UserCheck(scene->dim == 3, "-case stokes_spheres: it is a flow in 3D; use -dim 3");
  UserCheck(scene->length - 2.0 * a >= GAP * scene->dx,
            "-solid_fraction %.4g: the spheres are %.3g dx apart, and at least %.0f dx are needed; "
            "use a larger -n",
            (double)scene->solid_fraction, (double)((scene->length - 2.0 * a) / scene->dx), GAP);
  for (PetscInt k = 0; k < 3; k++) scene->hi[k] = scene->length;
  SceneSetSides(scene, &BoundaryPeriodic);
  BodyBall(scene, centre, a, &SceneAddBody(scene)->body);
  scene->body_force[0] = 6.0 * PETSC_PI * scene->nu * a * scene->speed *
                         SeriesDrag(scene->solid_fraction) / PetscPowRealInt(scene->length, 3);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reports the drag over 6 pi mu a U, and the traction on the sphere. */
static PetscErrorCode StokesSpheresMeasure(const Flow *flow, Report *report)
{
  const Scene    *scene = flow->scene;
  const PetscReal c     = scene->solid_fraction;

  PetscFunctionBegin;
  PetscCall(MeasureArray(flow, 6.0 * PETSC_PI * scene->rho * scene->nu * Radius(scene),
                         c <= SERIES_MOST ? SeriesDrag(c) : NAN, report));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const CaseRow CaseStokesSpheres = {
    .name            = "stokes_spheres",
    .brief           = "creeping flow through a cubic array of spheres, -dim 3",
    .citation        = "Zick & Homsy, J. Fluid Mech. 115 (1982)",
    .physics         = PHYSICS_VISCOSITY | PHYSICS_PRESSURE | PHYSICS_WALLS | PHYSICS_BODY_FORCE,
    .reynolds        = 1.0,
    .reynolds_length = 1.0,
    .t_end           = 1.0,
    .n               = 24,
    .three_d         = PETSC_TRUE,
    .Setup           = StokesSpheresSetup,
    .Measure         = StokesSpheresMeasure,
    .solid_fraction  = 0.064,
};
