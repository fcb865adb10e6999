/* Flow between concentric cylinders. The inner cylinder, R1 = L/2, rotates with surface speed U;
   the outer cylinder, R2 = L, is at rest. The steady flow below the onset of vortices is exact. */
#include "cases.h"

/* Sets the cylinders, and a box with room for dummy layers behind the outer cylinder. The sides of
   the box are not walls. */
static PetscErrorCode TaylorCouetteSetup(Scene *scene)
{
  const PetscReal room = scene->length + 6.0 * scene->dx;
  Boundary       *wall;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < scene->dim; a++) {
    scene->lo[a] = -room;
    scene->hi[a] = room;
  }
  SceneSetSides(scene, &BoundaryNone);
  wall = SceneAddBody(scene);
  BodyCircle(scene, 0.0, 0.0, 0.5 * scene->length, &wall->body);
  wall->rotation = ExpressionNumber(scene->speed / (0.5 * scene->length));
  wall           = SceneAddBody(scene);
  BodyCircle(scene, 0.0, 0.0, scene->length, &wall->body);
  wall->body.around = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Computes zero velocity at the start, later the steady velocity and pressure, which the flow
  reaches after a few (R2 - R1)^2/nu

    u_theta = A r + B/r,  A = -U R1/(R2^2 - R1^2),  B = U R1 R2^2/(R2^2 - R1^2)
    p = rho (A^2 r^2/2 + 2 A B ln r - B^2/(2 r^2)) + const

  Reference: G. I. Taylor, Phil. Trans. R. Soc. A 223 (1923) 289-343
*/
static void TaylorCouetteExact(const Scene *scene, PetscReal t, const PetscReal x[], PetscReal u[],
                               PetscReal *p)
{
  const PetscReal R1 = 0.5 * scene->length, R2 = scene->length, gap = R2 * R2 - R1 * R1;
  const PetscReal A = -scene->speed * R1 / gap, B = scene->speed * R1 * R2 * R2 / gap;
  const PetscReal r2 = x[0] * x[0] + x[1] * x[1], turn = A + B / r2;

  u[0] = u[1] = *p = 0.0;
  if (t <= 0.0) return;
  u[0] = -turn * x[1];
  u[1] = turn * x[0];
  *p   = scene->rho * (0.5 * A * A * r2 + A * B * PetscLogReal(r2) - 0.5 * B * B / r2);
}

/* Reports errors against the exact solution, and the torque on the inner cylinder. Its exact value
   is -4 pi mu B per metre of depth, with B of TaylorCouetteExact(). */
static PetscErrorCode TaylorCouetteMeasure(const Flow *flow, Report *report)
{
  const Scene    *scene = flow->scene;
  const PetscReal R1 = 0.5 * scene->length, R2 = scene->length;
  const PetscReal B     = scene->speed * R1 * R2 * R2 / (R2 * R2 - R1 * R1);
  const PetscReal exact = -4.0 * PETSC_PI * scene->rho * scene->nu * B;
  PetscReal       force[FORCE_WAYS][2 * ISPH_MAX_DIM], torque;

  PetscFunctionBegin;
  PetscCall(WallForce(flow, SceneBodySide(scene, 0), force));
  torque = force[FORCE_MOMENTUM][ISPH_MAX_DIM + 2];
  if (SceneIsNewtonian(scene)) {
    PetscCall(ReportAddReference(report, "torque", torque, exact, PetscAbsReal(exact)));
  } else {
    PetscCall(ReportAdd(report, "torque", torque));
  }
  PetscCall(MeasureExact(flow, report));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const CaseRow CaseTaylorCouette = {
    .name            = "taylor_couette",
    .brief           = "between cylinders of radius L/2, turning with U, and L, at rest",
    .citation        = "Taylor, Phil. Trans. R. Soc. A 223 (1923)",
    .physics         = NAVIER_STOKES | PHYSICS_WALLS,
    .reynolds        = 10.0,
    .reynolds_length = 0.5,
    .t_end           = 20.0,
    .n               = 25,
    .Setup           = TaylorCouetteSetup,
    .Exact           = TaylorCouetteExact,
    .Measure         = TaylorCouetteMeasure,
};
