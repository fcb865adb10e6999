/* A scene typed by the user with the options of src/scene/typed.c: a box with its sides and bodies.
   Velocities that no option gives are zero. */
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

static PetscErrorCode AddBodyRow(const Scene *scene, PetscInt k, const char way[],
                                 const char quantity[], PetscReal value, Report *report)
{
  char name[WALL_NAME + 32], body[WALL_NAME];

  PetscFunctionBegin;
  SceneWallName(scene, SceneBodySide(scene, k), body);
  PetscCall(PetscSNPrintf(name, sizeof(name), "%s_%s%s", body, way, quantity));
  PetscCall(ReportAdd(report, name, value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reports place, attitude and motion of a body that moves. In 2D the angle is about z. */
static PetscErrorCode MeasurePose(const Scene *scene, PetscInt k, Report *report)
{
  const char *const name[3][ISPH_MAX_DIM] = {
      {"x", "y", "z"}, {"u", "v", "w"}, {"spin_x", "spin_y", "spin"}};
  const Body *body = BoundaryBody(scene, SceneBodySide(scene, k));
  const Pose *pose = body->pose;

  PetscFunctionBegin;
  if (!pose) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt a = 0; a < scene->dim; a++) {
    PetscCall(AddBodyRow(scene, k, "", name[0][a], pose->x[a], report));
    PetscCall(AddBodyRow(scene, k, "", name[1][a], pose->u[a], report));
  }
  if (scene->dim == 2)
    PetscCall(AddBodyRow(scene, k, "", "angle", 2.0 * atan2(pose->turn[3], pose->turn[0]), report));
  for (PetscInt a = scene->dim == 2 ? 2 : 0; a < ISPH_MAX_DIM; a++)
    PetscCall(AddBodyRow(scene, k, "", name[2][a], pose->spin[a], report));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reports force and torque on each body by the momentum beside it, then by tractions, and
   ForceParts(). With a free surface the force is that of tractions, and there is no difference. */
static PetscErrorCode MeasureBodies(const Flow *flow, Report *report)
{
  static const char *const names[] = {"fx", "fy", "fz", "torque_x", "torque_y", "torque"};
  static const char *const parts[] = {"force_error", "torque_error", "lubrication"};
  const Scene             *scene   = flow->scene;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < scene->n_bodies; k++) {
    PetscReal force[FORCE_WAYS][2 * ISPH_MAX_DIM], part[FORCE_WAYS];

    PetscCall(MeasurePose(scene, k, report));
    PetscCall(WallForce(flow, SceneBodySide(scene, k), force));
    for (PetscInt way = 0; way < (SceneHasFreeSurface(scene) ? 1 : 2); way++) {
      for (PetscInt a = 0; a < 2 * ISPH_MAX_DIM; a++) {
        if (scene->dim == 2 && a > 1 && a < 2 * ISPH_MAX_DIM - 1) continue;
        PetscCall(AddBodyRow(scene, k, way ? "traction_" : "", names[a], force[way][a], report));
      }
    }
    ForceParts(scene, force, part);
    for (PetscInt q = 0; q < (part[2] > 0.0 ? 3 : 2); q++)
      PetscCall(
          AddBodyRow(scene, k, "", parts[q], PetscIsNanReal(part[q]) ? 0.0 : part[q], report));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reports errors against -scene_exact, force and torque on each body, extrema of the velocity on
   the centrelines of a closed box without bodies, and the quantities of every case. */
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
