/* Lid-driven square cavity with a fixed cylinder of diameter L/2 at its centre, after Zheng, Ma &
   Shao (2018), section 5.2. The reference is a body-fitted finite-volume solution. */
#include "cases.h"

static PetscErrorCode CavityCylinderSetup(Scene *scene)
{
  PetscFunctionBegin;
  PetscCall(CavitySetup(scene));
  BodyCircle(scene, 0.5 * scene->length, 0.5 * scene->length, 0.25 * scene->length,
             &SceneAddBody(scene)->body);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reports extrema and profiles of the velocity on the centrelines outside the cylinder. At Re =
   1000 the reference is a finite-volume solution at t = 40 L/U from rest, extrapolated from meshes
   of 2,176, 8,704 and 34,816 cells. */
static PetscErrorCode CavityCylinderMeasure(const Flow *flow, Report *report)
{
  const Scene    *scene    = flow->scene;
  const PetscReal time     = ClockMoment(flow->clock) * scene->speed / scene->length;
  const PetscReal reynolds = SceneIsNewtonian(scene) ? SceneReynolds(scene) : NAN;
  const PetscBool compares = PetscAbsReal(reynolds - 1000.0) < 0.1 &&
                             PetscAbsReal(time - 40.0) < 0.1 &&
                             scene->physics == scene->problem->physics;
  PetscReal energy;

  PetscFunctionBegin;
  PetscCall(CentrelineExtrema(flow, compares ? -0.31484 : NAN, compares ? 0.30706 : NAN,
                              compares ? -0.41752 : NAN, report));
  if (compares) {
    PetscCall(
        CentrelineProfile(flow, 1, 0, "cavity_cylinder_re1000_u.csv", "u_profile_l2", report));
    PetscCall(
        CentrelineProfile(flow, 0, 1, "cavity_cylinder_re1000_v.csv", "v_profile_l2", report));
  }
  PetscCall(ReferenceEnergy(
      flow, PetscAbsReal(reynolds - 1000.0) < 0.1 ? "cavity_cylinder_re1000_ke.csv" : NULL, report,
      &energy));
  PetscCall(MeasureCommon(flow, energy, report));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const CaseRow CaseCavityCylinder = {
    .name            = "cavity_cylinder",
    .brief           = "lid-driven cavity with a fixed cylinder of half its width in the middle",
    .citation        = "Zheng, Ma & Shao, Water 10 (2018)",
    .physics         = NAVIER_STOKES | PHYSICS_WALLS,
    .reynolds        = 1000.0,
    .reynolds_length = 1.0,
    .t_end           = 40.0,
    .n               = 50,
    .Setup           = CavityCylinderSetup,
    .WallVelocity    = CavityWallVelocity,
    .Measure         = CavityCylinderMeasure,
};
