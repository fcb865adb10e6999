/* Creeping flow through a square array of cylinders: a cylinder in a periodic cell of side L,
   driven by a body force. The drag is compared with a series solution. Option -solid_fraction sets
   the solid fraction. */
#include "cases.h"

/*
  Returns the drag of a cylinder of the array, divided by mu U with the superficial velocity U, from
  a series for small solid fractions c

    F/(mu U) = 4 pi/(-ln(c)/2 - 0.738 + c - 0.887 c^2 + 2.038 c^3)

  Here the series only scales the force, so that velocities are of order U for any fraction.

  Reference: A. S. Sangani, A. Acrivos, Int. J. Multiphase Flow 8 (1982) 193-206
*/
static PetscReal DiluteDrag(PetscReal c)
{
  return 4.0 * PETSC_PI / (-0.5 * PetscLogReal(c) - 0.738 + c - 0.887 * c * c + 2.038 * c * c * c);
}

/* Returns the drag over mu U from the table of the multipole expansion in the same paper; NaN for
   fractions that are not in the table. */
static PetscReal TabulatedDrag(PetscReal c)
{
  static const PetscReal table[][2] = {{0.05, 15.56}, {0.1, 24.83},  {0.2, 51.53},
                                       {0.3, 102.90}, {0.4, 217.89}, {0.5, 532.55}};

  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(table); k++) {
    if (PetscAbsReal(table[k][0] - c) < 1e-9) return table[k][1];
  }
  return NAN;
}

/* Sets the box, the cylinder, and the force f = nu U/L^2 times DiluteDrag(), so that velocities are
   of order U. */
static PetscErrorCode StokesCylindersSetup(Scene *scene)
{
  const PetscReal middle = 0.5 * scene->length,
                  radius = scene->length * PetscSqrtReal(scene->solid_fraction / PETSC_PI);

  PetscFunctionBegin;
  for (PetscInt a = 0; a < scene->dim; a++) scene->hi[a] = scene->length;
  SceneSetSides(scene, &BoundaryPeriodic);
  BodyCircle(scene, middle, middle, radius, &SceneAddBody(scene)->body);
  scene->body_force[0] =
      scene->nu * scene->speed / PetscSqr(scene->length) * DiluteDrag(scene->solid_fraction);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reports the drag divided by mu U, and the traction on the cylinder. */
static PetscErrorCode StokesCylindersMeasure(const Flow *flow, Report *report)
{
  const Scene *scene = flow->scene;

  PetscFunctionBegin;
  PetscCall(
      MeasureArray(flow, scene->rho * scene->nu, TabulatedDrag(scene->solid_fraction), report));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const CaseRow CaseStokesCylinders = {
    .name            = "stokes_cylinders",
    .brief           = "creeping flow through a square array of cylinders",
    .citation        = "Sangani & Acrivos, Int. J. Multiphase Flow 8 (1982)",
    .physics         = PHYSICS_VISCOSITY | PHYSICS_PRESSURE | PHYSICS_WALLS | PHYSICS_BODY_FORCE,
    .reynolds        = 1.0,
    .reynolds_length = 1.0,
    .t_end           = 1.0,
    .n               = 50,
    .Setup           = StokesCylindersSetup,
    .Measure         = StokesCylindersMeasure,
    .solid_fraction  = 0.1,
};
