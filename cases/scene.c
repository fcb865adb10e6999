/*
  A scene typed by the user with the options of src/scene/typed.c: a box with its sides and bodies.
  Velocities that no option gives are zero.
*/
#include "cases.h"

/* Does nothing: the options have set the scene. */
static PetscErrorCode SceneTypedSetup(Scene *scene)
{
  PetscFunctionBegin;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the velocity at the start: -scene_velocity, or else -scene_exact, or else zero. */
static void SceneTypedVelocity(const Scene *scene, PetscReal t, const PetscReal x[], PetscReal u[])
{
  const Expression *e = scene->velocity.n ? &scene->velocity : &scene->exact;

  for (PetscInt a = 0; a < scene->dim; a++) u[a] = ExpressionValue(e, a, t, x);
}

/* Computes the solution of -scene_exact; leaves p unchanged if the option has no pressure. */
static void SceneTypedExact(const Scene *scene, PetscReal t, const PetscReal x[], PetscReal u[],
                            PetscReal *p)
{
  for (PetscInt a = 0; a < scene->dim; a++) u[a] = ExpressionValue(&scene->exact, a, t, x);
  if (scene->exact.n > scene->dim) *p = ExpressionValue(&scene->exact, scene->dim, t, x);
}

/* Reports force and torque on each body. */
static PetscErrorCode MeasureBodies(const Flow *flow, Report *report)
{
  const Scene *scene = flow->scene;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < scene->n_bodies; k++) {
    PetscReal F[ISPH_MAX_DIM] = {0.0}, T[ISPH_MAX_DIM] = {0.0};
    char      name[32];

    PetscCall(WallForce(flow, SceneBodySide(scene, k), F, T));
    PetscCall(PetscSNPrintf(name, sizeof(name), "body_%" PetscInt_FMT "_fx", k + 1));
    PetscCall(ReportAdd(report, name, F[0]));
    PetscCall(PetscSNPrintf(name, sizeof(name), "body_%" PetscInt_FMT "_fy", k + 1));
    PetscCall(ReportAdd(report, name, F[1]));
    if (scene->dim == 3) {
      PetscCall(PetscSNPrintf(name, sizeof(name), "body_%" PetscInt_FMT "_fz", k + 1));
      PetscCall(ReportAdd(report, name, F[2]));
    }
    PetscCall(PetscSNPrintf(name, sizeof(name), "body_%" PetscInt_FMT "_torque", k + 1));
    PetscCall(ReportAdd(report, name, T[2]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Reports errors against -scene_exact, force and torque on each body, extrema of the velocity on the
  centrelines of a closed box without bodies, and the quantities of every case.
*/
static PetscErrorCode SceneTypedMeasure(const Flow *flow, Report *report)
{
  const Scene *scene = flow->scene;

  PetscFunctionBegin;
  if (scene->exact.n) PetscCall(NormsExact(flow, report));
  PetscCall(MeasureBodies(flow, report));
  if (SceneIsClosedBox(scene)) PetscCall(CentrelineExtrema(flow, NAN, NAN, NAN, report));
  PetscCall(MeasureCommon(flow, NAN, report));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const CaseRow CaseScene = {
    .name            = "scene",
    .brief           = "typed by -scene_ options: a box, its sides, bodies",
    .citation        = "",
    .physics         = NAVIER_STOKES | PHYSICS_WALLS,
    .reynolds        = 100.0,
    .reynolds_length = 1.0,
    .t_end           = 10.0,
    .n               = 50,
    .three_d         = PETSC_TRUE,
    .Setup           = SceneTypedSetup,
    .Velocity        = SceneTypedVelocity,
    .Exact           = SceneTypedExact,
    .Measure         = SceneTypedMeasure,
    .typed           = PETSC_TRUE,
};
