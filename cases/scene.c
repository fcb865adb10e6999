/*
  A scene typed by the user: a box with its sides, and bodies in it. What the options of -scene_ do not say
  is at rest.
*/
#include "cases.h"

/* SceneTypedSetup - Nothing to add: the options have made the scene */
PetscErrorCode SceneTypedSetup(Scene *scene)
{
  PetscFunctionBegin;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SceneTypedWallVelocity - The velocity typed for a side of the box */
void SceneTypedWallVelocity(const Scene *scene, PetscInt side, PetscReal t, const PetscReal x[],
                            PetscReal u[])
{
  for (PetscInt a = 0; a < scene->dim; a++) u[a] = scene->side_velocity[side][a];
}

/* SceneTypedJudge - Integrals, and force and torque on each body */
PetscErrorCode SceneTypedJudge(const Flow *flow, Report *report)
{
  const Scene *scene = flow->scene;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < scene->n_bodies; k++) {
    PetscReal F[ISPH_MAX_DIM] = {0.0}, T[ISPH_MAX_DIM] = {0.0};
    char      name[32];

    PetscCall(WallForce(flow, 2 * scene->dim + k, F, T));
    PetscCall(PetscSNPrintf(name, sizeof(name), "body_%" PetscInt_FMT "_fx", k + 1));
    PetscCall(ReportAdd(report, name, F[0]));
    PetscCall(PetscSNPrintf(name, sizeof(name), "body_%" PetscInt_FMT "_fy", k + 1));
    PetscCall(ReportAdd(report, name, F[1]));
    PetscCall(PetscSNPrintf(name, sizeof(name), "body_%" PetscInt_FMT "_torque", k + 1));
    PetscCall(ReportAdd(report, name, T[2]));
  }
  PetscCall(JudgeCommon(flow, NAN, report));
  PetscFunctionReturn(PETSC_SUCCESS);
}
