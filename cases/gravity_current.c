/*
  A viscous fluid that spreads over a floor without slip by its weight: half of a plane current in
  2D, a quarter of a round one in 3D, beyond planes of symmetry. It begins from Huppert's similarity
  solution of lubrication theory with the height H = L and the radius 8 H. g = U^2/L, downwards
  along the last axis.

  Reference: H. E. Huppert, J. Fluid Mech. 121 (1982) 43-58
*/
#include "cases.h"
#include "isph/strain.h"

#define RADIUS  8.0 /* front at the start [L] */
#define CORNERS 32  /* of the profile at the start */
#define SECTORS 16  /* of the quarter, in each of which the front is measured */

/* Numbers of a dimension. */
typedef struct {
  PetscReal
           front; /* eta: front eta (g Q^m t/(3 nu))^(1/e), Q the volume of the half or the whole */
  PetscInt volume;    /* m */
  PetscReal exponent; /* e */
  PetscReal height;   /* H ~ t^-height */
  PetscReal mean;     /* Q over height and length or area of the base */
  PetscReal reach;    /* box over the radius, for a decade of time */
} Current;
static const Current currents[] = {{1.411, 3, 5.0, 0.2, 0.841309, 1.7},
                                   {0.894, 3, 8.0, 0.25, 0.75, 1.4}};

/* Returns the numbers of the scene's dimension. */
static const Current *Numbers(const Scene *scene)
{
  return &currents[scene->dim - 2];
}

/* Returns the time that the similarity solution takes to reach the front at the start [s]. */
static PetscReal StartTime(const Scene *scene)
{
  const Current  *c = Numbers(scene);
  const PetscReal L = scene->length, R = RADIUS * L, g = PetscSqr(scene->speed) / L;
  const PetscReal Q = c->mean * L * (scene->dim == 2 ? R : PETSC_PI * R * R);

  return 3.0 * scene->nu * PetscPowReal(R / c->front, c->exponent) /
         (g * PetscPowRealInt(Q, c->volume));
}

/* Returns the height of the similarity solution at the start at the distance r [m]. */
static PetscReal StartHeight(const Scene *scene, PetscReal r)
{
  const PetscReal s = r / (RADIUS * scene->length);

  return scene->length * PetscPowReal(PetscMax(1.0 - s * s, 0.0), 1.0 / 3.0);
}

/* Sets the filled region: a polygon through points of the profile, whose angles are even in the
   ellipse of its axes, and corners below the floor; in 3D its half turns about the axis. */
static const char *SetProfile(Scene *scene, Body *body)
{
  const PetscReal L = scene->length, R = RADIUS * L;
  const PetscInt  first          = scene->dim == 2 ? 1 : CORNERS / 2; /* point of the profile */
  PetscReal       x[2 * CORNERS] = {scene->dim == 2 ? -R : 0.0, -L};
  PetscInt        n              = 1;

  if (scene->dim == 3) {
    x[2] = 0.0;
    x[3] = StartHeight(scene, R * PetscSinReal(0.5 * PETSC_PI / (CORNERS - 2)));
    n    = 2;
  }
  for (PetscInt k = first; k < CORNERS - 1; k++, n++) {
    x[2 * n]     = -R * PetscCosReal(PETSC_PI * (k - 0.5) / (CORNERS - 2));
    x[2 * n + 1] = StartHeight(scene, x[2 * n]);
  }
  x[2 * n]     = R;
  x[2 * n + 1] = -L;
  return BodyPolygon(scene, n + 1, x, body);
}

static PetscErrorCode GravityCurrentSetup(Scene *scene)
{
  const PetscInt up    = scene->dim - 1;
  Body          *body  = SceneAddFilled(scene);
  const char    *fault = SetProfile(scene, body);

  PetscFunctionBegin;
  PetscCheck(!fault, PETSC_COMM_SELF, PETSC_ERR_PLIB, "profile: %s", fault);
  SceneSetSides(scene, &BoundaryNone);
  for (PetscInt a = 0; a < up; a++) {
    scene->hi[a] = Numbers(scene)->reach * RADIUS * scene->length;
    SceneSetSide(scene, 2 * a, &BoundarySymmetry);
  }
  scene->hi[up] = 1.5 * scene->length;
  SceneSetSide(scene, 2 * up, &BoundaryWall);
  scene->body_force[up] = -PetscSqr(scene->speed) / scene->length;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the velocity of the similarity solution at the start: the mean over the height is
   r/(e t), and the profile that of a film. */
static void GravityCurrentVelocity(const Scene *scene, PetscReal t, const PetscReal x[],
                                   PetscReal u[])
{
  const PetscInt  up   = scene->dim - 1;
  const PetscReal rate = 1.0 / (Numbers(scene)->exponent * StartTime(scene));
  PetscReal       r2   = 0.0, s;

  for (PetscInt a = 0; a < up; a++) r2 += PetscSqr(x[a]);
  s = PetscMin(x[up] / PetscMax(StartHeight(scene, PetscSqrtReal(r2)), 1e-9 * scene->length), 1.0);
  for (PetscInt a = 0; a < up; a++) u[a] = 1.5 * s * (2.0 - s) * rate * x[a];
  u[up] = 0.0;
}

/* Computes the mean over sectors of the distance of the outermost corner of the surface from the
   axis, and the height of the surface within H of the axis [m]. */
static PetscErrorCode MeasureCurrent(const Flow *flow, PetscReal *front, PetscReal *height)
{
  const PetscInt       dim = flow->particles->dim, up = dim - 1, sectors = dim == 2 ? 1 : SECTORS;
  const StrainSurface *surface           = &flow->ops->strain->surface;
  PetscReal            most[SECTORS + 1] = {0.0};

  PetscFunctionBegin;
  for (PetscInt k = 0; k < surface->n * dim; k++) {
    const PetscReal *x = &surface->x[k * dim], y = dim == 2 ? 0.0 : x[1];
    const PetscReal  r = PetscSqrtReal(PetscSqr(x[0]) + PetscSqr(y));
    PetscInt         s = (PetscInt)(sectors * PetscAtan2Real(y, x[0]) / (0.5 * PETSC_PI));

    s       = PetscMin(PetscMax(s, 0), sectors - 1);
    most[s] = PetscMax(most[s], r);
    if (r < flow->scene->length) most[SECTORS] = PetscMax(most[SECTORS], x[up]);
  }
  PetscCallMPI(
      MPI_Allreduce(MPI_IN_PLACE, most, SECTORS + 1, MPIU_REAL, MPIU_MAX, flow->particles->comm));
  *front = 0.0;
  for (PetscInt s = 0; s < sectors; s++) *front += most[s] / sectors;
  *height = most[SECTORS];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reports front and height beside the similarity solution, which holds for currents much wider than
   high without inertia. */
static PetscErrorCode GravityCurrentMeasure(const Flow *flow, Report *report)
{
  const Scene    *scene = flow->scene;
  const Current  *c     = Numbers(scene);
  const PetscReal age   = 1.0 + ClockMoment(flow->clock) / StartTime(scene);
  PetscReal       front, height;

  PetscFunctionBegin;
  if (!flow->ops->strain) PetscFunctionReturn(PETSC_SUCCESS); /* -scheme wcsph has no cells */
  PetscCall(MeasureCurrent(flow, &front, &height));
  PetscCall(ReportAdd(report, "age", age));
  if (SceneIsAsPosed(scene) && SceneIsNewtonian(scene) && scene->tension == 0.0) {
    const PetscReal R = RADIUS * scene->length * PetscPowReal(age, 1.0 / c->exponent);
    const PetscReal H = scene->length * PetscPowReal(age, -c->height);

    PetscCall(ReportAddReference(report, "front", front, R, R));
    PetscCall(ReportAddReference(report, "height", height, H, H));
  } else {
    PetscCall(ReportAdd(report, "front", front));
    PetscCall(ReportAdd(report, "height", height));
  }
  PetscCall(MeasureCommon(flow, NAN, report));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const CaseRow CaseGravityCurrent = {
    .name            = "gravity_current",
    .brief           = "viscous fluid that spreads over a floor, plane, or round in 3D",
    .citation        = "H. E. Huppert, J. Fluid Mech. 121 (1982) 43-58",
    .physics         = NAVIER_STOKES | PHYSICS_WALLS | PHYSICS_BODY_FORCE,
    .reynolds        = 10.0,
    .reynolds_length = 1.0,
    .t_end           = 3.6,
    .n               = 6,
    .three_d         = PETSC_TRUE,
    .Setup           = GravityCurrentSetup,
    .Velocity        = GravityCurrentVelocity,
    .Measure         = GravityCurrentMeasure,
};
