/* Boundaries of the fluid: the table of their kinds, and the functions that answer questions about
   them and give their data; distances are in distances.c. The sides of the box have the numbers 2
   axis + (0 low, 1 high); the bodies follow. */
#include "isph/scene.h"

#define SURFACE_STEP 1e-4 /* along a surface, for its curvature [dx] */

const BoundaryRow BoundaryWall = {
    .name       = "wall",
    .brief      = "solid surface without slip; the default for the sides of a box, and of bodies",
    .properties = BOUNDARY_PARTICLES | BOUNDARY_CONFINES | BOUNDARY_NO_SLIP,
    .equation   = {[FIT_VELOCITY_NORMAL]     = EQUATION_VALUE,
                   [FIT_VELOCITY_TANGENTIAL] = EQUATION_VALUE,
                   [FIT_PRESSURE]            = EQUATION_NORMAL_DERIVATIVE,
                   [FIT_PRESSURE_FREE]       = EQUATION_NONE},
};
const BoundaryRow BoundaryPeriodic = {
    .name       = "periodic",
    .brief      = "fluid that leaves through one side comes in through the opposite one",
    .option     = OPTION(NAMES, "-scene_periodic", "periodic axes of the box", NULL, NULL,
                         .words = BoxAxes, .table = &BoundaryTable, .where = "-case scene"),
    .properties = BOUNDARY_CONTINUES,
};
/* A side of the box inside a solid at rest: with zero velocity in the solid it has no slip. */
const BoundaryRow BoundaryNone = {
    .name       = "none",
    .brief      = "side in the solid of a body around the fluid, or beyond a free surface",
    .properties = BOUNDARY_NO_SLIP,
};

/* The kinds in the order of -catalogue; a kind defined in a file of its own is added here too. */
#define KINDS(ROW)                                                                                 \
  ROW(BoundaryWall)                                                                                \
  ROW(BoundaryPeriodic)                                                                            \
  ROW(BoundarySymmetry) ROW(BoundarySlip) ROW(BoundaryInflow) ROW(BoundaryOutflow) ROW(BoundaryNone)

#define DECLARE(row) extern const BoundaryRow row;
KINDS(DECLARE)

#define ADDRESS(row) &row,
static const BoundaryRow *const kinds[] = {KINDS(ADDRESS)};

#define OPTION_OF(row) &(row).option,
static const OptionRow *const options[] = {KINDS(OPTION_OF)};

const Table       BoundaryTable   = TABLE_OF_POINTERS("Kinds of boundaries", kinds);
const OptionTable BoundaryOptions = OPTIONS_ELSEWHERE("Sides of typed scenes", options);

const char *const BoxAxes[]  = {"x", "y", "z", NULL};
const char *const BoxSides[] = {"left", "right", "bottom", "top", "back", "front", NULL};

/* Reserves room for the sides of the box and n boundaries; ends the run if there is no memory. */
static void Reserve(Scene *scene, PetscInt n)
{
  const PetscInt had = scene->boundary_capacity, sides = 2 * ISPH_MAX_DIM;

  if (n <= had && had) return;
  scene->boundary_capacity = PetscMax(2 * n, sides + 2);
  PetscCallAbort(
      PETSC_COMM_SELF,
      PetscRealloc(sizeof(*scene->boundary) * (size_t)scene->boundary_capacity, &scene->boundary));
  (void)PetscArrayzero(scene->boundary + had, scene->boundary_capacity - had);
}

/* SceneFreeShapes - Frees the boundaries and the memory of all shapes of a scene */
PetscErrorCode SceneFreeShapes(Scene *scene)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(scene->boundary));
  PetscCall(BodyStoreFree(&scene->store));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SceneSetSide - Sets the kind of one side of the box */
void SceneSetSide(Scene *scene, PetscInt side, const BoundaryRow *kind)
{
  Reserve(scene, side + 1);
  scene->boundary[side].kind = kind;
}

/* SceneSetAxis - Sets the kind of both sides of the box along an axis */
void SceneSetAxis(Scene *scene, PetscInt axis, const BoundaryRow *kind)
{
  for (PetscInt end = 0; end < 2; end++) SceneSetSide(scene, 2 * axis + end, kind);
}

/* SceneSetSides - Sets the kind of all sides of the box */
void SceneSetSides(Scene *scene, const BoundaryRow *kind)
{
  for (PetscInt a = 0; a < scene->dim; a++) SceneSetAxis(scene, a, kind);
}

/* SceneAddBody - Adds a body that is a wall at rest; returns its boundary, valid until the next is
   added */
Boundary *SceneAddBody(Scene *scene)
{
  const PetscInt side = SceneBodySide(scene, scene->n_bodies++);

  Reserve(scene, side + 1);
  scene->boundary[side] = (Boundary){.kind = &BoundaryWall};
  return &scene->boundary[side];
}

/* SceneBodySide - Returns the number of body k among the boundaries */
PetscInt SceneBodySide(const Scene *scene, PetscInt k)
{
  return 2 * scene->dim + k;
}

/* SceneBoundaries - Returns the number of boundaries */
PetscInt SceneBoundaries(const Scene *scene)
{
  return SceneBodySide(scene, scene->n_bodies);
}

/* SceneBody - Returns the geometry of body k */
const Body *SceneBody(const Scene *scene, PetscInt k)
{
  return &scene->boundary[SceneBodySide(scene, k)].body;
}

/* BoundaryBody - Returns the geometry of a body, NULL for a side of the box */
const Body *BoundaryBody(const Scene *scene, PetscInt side)
{
  return side < SceneBodySide(scene, 0) ? NULL : &scene->boundary[side].body;
}

/* BoundaryEquation - Returns the equation that a boundary adds to the fit of a quantity */
Equation BoundaryEquation(const Scene *scene, PetscInt side, FitQuantity quantity)
{
  return scene->boundary[side].kind->equation[quantity];
}

/* BoundaryVelocityEquation - Returns the equation that a boundary adds to the fit of velocity
   component c. A side of the box distinguishes the normal from the tangential components. A body
   uses its equation for the normal velocity for all components. */
Equation BoundaryVelocityEquation(const Scene *scene, PetscInt side, PetscInt c)
{
  const PetscBool normal = BoundaryBody(scene, side) || c == side / 2;

  return BoundaryEquation(scene, side, normal ? FIT_VELOCITY_NORMAL : FIT_VELOCITY_TANGENTIAL);
}

/* SceneWallName - Writes the name of a boundary, such as "left", "body_1" or "domain", to an array
   of WALL_NAME characters */
void SceneWallName(const Scene *scene, PetscInt side, char name[])
{
  const PetscInt body = side - SceneBodySide(scene, 0);

  if (body < 0) (void)snprintf(name, WALL_NAME, "%s", BoxSides[side]);
  else if (BoundaryBody(scene, side)->around) (void)snprintf(name, WALL_NAME, "domain");
  else (void)snprintf(name, WALL_NAME, "body_%d", (int)body + 1);
}

/* SceneHasBoundary - Returns true if any boundary has all the given properties */
PetscBool SceneHasBoundary(const Scene *scene, unsigned properties)
{
  for (PetscInt side = 0; side < SceneBoundaries(scene); side++)
    if (BoundaryIs(scene, side, properties)) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* SceneSlipKind - Returns the first kind of boundary whose equations in fits differ for normal and
   tangential velocity, or NULL */
const BoundaryRow *SceneSlipKind(const Scene *scene)
{
  for (PetscInt side = 0; side < SceneBoundaries(scene); side++) {
    const BoundaryRow *kind = scene->boundary[side].kind;

    if (kind->equation[FIT_VELOCITY_NORMAL] != kind->equation[FIT_VELOCITY_TANGENTIAL]) return kind;
  }
  return NULL;
}

/* SceneFitKind - Returns a kind of boundary that has other equations than a wall, NULL if there is
   none; only wall particles on the surface can meet them, in fits */
const BoundaryRow *SceneFitKind(const Scene *scene)
{
  for (PetscInt side = 0; side < SceneBoundaries(scene); side++) {
    const BoundaryRow *kind = scene->boundary[side].kind;

    for (PetscInt q = 0; q < FIT_QUANTITIES && BoundaryIs(scene, side, BOUNDARY_PARTICLES); q++)
      if (kind->equation[q] != BoundaryWall.equation[q]) return kind;
  }
  return NULL;
}

/* ScenePressureFloats - Returns true if the constant of the pressure is undetermined, because no
   boundary and no free surface gives a value of the pressure. Solvers ask through gauge.c. */
PetscBool ScenePressureFloats(const Scene *scene)
{
  if (SceneHasFreeSurface(scene)) return PETSC_FALSE;
  for (PetscInt side = 0; side < SceneBoundaries(scene); side++) {
    if (BoundaryEquation(scene, side, FIT_PRESSURE) == EQUATION_VALUE) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* SceneSetLevel - Sets the level of the pressure: the pressure outside free surfaces, or else the
   mean of the pressures at t = 0 in the middle of the sides that give one; 0 if none does.
   Tolerances of solves and rounding are relative to pressures less this level, so that a large
   constant in all given pressures, such as an atmosphere, changes no velocity. */
void SceneSetLevel(Scene *scene)
{
  PetscReal sum   = 0.0;
  PetscInt  sides = 0;

  for (PetscInt side = 0; side < SceneBodySide(scene, 0); side++) {
    const BoundaryRow *kind = scene->boundary[side].kind;
    PetscReal          x[ISPH_MAX_DIM];

    if (kind->equation[FIT_PRESSURE] != EQUATION_VALUE || !kind->Pressure) continue;
    for (PetscInt a = 0; a < scene->dim; a++) x[a] = 0.5 * (scene->lo[a] + scene->hi[a]);
    x[side / 2] = side % 2 ? scene->hi[side / 2] : scene->lo[side / 2];
    sum += kind->Pressure(scene, side, 0.0, x);
    sides++;
  }
  scene->level = !SceneHasFreeSurface(scene) && sides ? sum / (PetscReal)sides : scene->outside;
}

/* SceneIsClosedBox - Returns true if the fluid fills a box, all sides confine it and the scene has
   no body */
PetscBool SceneIsClosedBox(const Scene *scene)
{
  for (PetscInt side = 0; side < SceneBodySide(scene, 0); side++) {
    if (!BoundaryIs(scene, side, BOUNDARY_CONFINES)) return PETSC_FALSE;
  }
  return !(scene->n_bodies || scene->n_filled);
}

/* BodyGivenMotion - Computes the given velocity of the centre of a body [m/s] and its given angular
   velocity [rad/s] at time t. A given position or turn gives its rate by ExpressionRate(). A body
   that rides has the motion of the frame. */
void BodyGivenMotion(const Scene *scene, PetscInt side, PetscReal t, PetscReal u[],
                     PetscReal spin[])
{
  const Boundary *boundary = &scene->boundary[side];
  const PetscReal tau      = scene->length / scene->speed;
  const PetscBool axes     = boundary->rotation.n > 1;

  if (boundary->rides) {
    for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) u[a] = spin[a] = 0.0;
    SceneFrameVelocity(scene, t, boundary->body.centre, u);
    spin[2] = SceneFrameRate(scene, t);
    return;
  }
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) {
    u[a] = spin[a] = 0.0;
    if (a < scene->dim)
      u[a] = boundary->position.n ? ExpressionRate(&boundary->position, a, t, NULL, tau)
                                  : ExpressionValue(&boundary->velocity, a, t, NULL);
    if (boundary->turn.n) spin[a] = ExpressionRate(&boundary->turn, a, t, NULL, tau);
    else if (axes || a == 2) spin[a] = ExpressionValue(&boundary->rotation, axes ? a : 0, t, NULL);
  }
}

/* BodyGivenPose - Sets place and attitude of a body to those given for time t; others, which follow
   from velocities, stay */
void BodyGivenPose(const Scene *scene, PetscInt side, PetscReal t, Pose *pose)
{
  const Boundary *boundary = &scene->boundary[side];
  PetscReal       turn[ISPH_MAX_DIM];

  for (PetscInt a = 0; boundary->position.n && a < scene->dim; a++)
    pose->x[a] = ExpressionValue(&boundary->position, a, t, NULL);
  if (!boundary->turn.n) return;
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) {
    turn[a]           = ExpressionValue(&boundary->turn, a, t, NULL);
    pose->turn[1 + a] = 0.0;
  }
  pose->turn[0] = 1.0;
  PoseRotate(turn, pose);
}

/* BodyMotion - Computes the velocity of the centre of a body [m/s] and its angular velocity
   [rad/s]: those given for time t, or the present ones of a free body */
void BodyMotion(const Scene *scene, PetscInt side, PetscReal t, PetscReal u[], PetscReal spin[])
{
  const Boundary *boundary = &scene->boundary[side];

  if (!boundary->free) {
    BodyGivenMotion(scene, side, t, u, spin);
    return;
  }
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) {
    u[a]    = boundary->body.pose->u[a];
    spin[a] = boundary->body.pose->spin[a];
  }
}

/* A place beside a part of the surface of the domain. */
typedef struct {
  PetscReal distance, normal[ISPH_MAX_DIM]; /* from the surface, into the fluid [m] */
  PetscReal u[ISPH_MAX_DIM], speed;         /* of the surface, along it [m/s] */
  PetscReal bend;                           /* t.(t.grad) n with t = u/|u| [1/m] */
} PartPlace;

/* ScenePart - Returns the last part of the surface of the domain that has x, NULL if none has it */
const SurfacePart *ScenePart(const Scene *scene, const PetscReal x[])
{
  const PetscReal slack = SCENE_ON_SURFACE * scene->dx;
  PetscReal       normal[ISPH_MAX_DIM];

  for (PetscInt k = scene->n_parts - 1; k >= 0; k--)
    if (BodyWithin(&scene->part[k].shape, x, slack, normal) <= slack) return &scene->part[k];
  return NULL;
}

/* Computes the motion of the part of a surface that is nearest to x; returns false if it is none.
   The component of the typed velocity through the surface is left out. */
static PetscBool FindPart(const Scene *scene, PetscInt side, PetscReal t, const PetscReal x[],
                          PartPlace *at)
{
  const Body        *body    = BoundaryBody(scene, side);
  const PetscReal    step    = SURFACE_STEP * scene->dx;
  PetscReal          through = 0.0, foot[ISPH_MAX_DIM] = {0.0};
  const SurfacePart *part;

  if (!scene->n_parts || !body || !body->around) return PETSC_FALSE;
  *at          = (PartPlace){.speed = 0.0};
  at->distance = BodyDistance(scene, body, x, at->normal);
  for (PetscInt c = 0; c < scene->dim; c++) foot[c] = x[c] - at->distance * at->normal[c];
  part = ScenePart(scene, foot);
  if (!part) return PETSC_FALSE;
  for (PetscInt c = 0; c < scene->dim; c++) {
    at->u[c] = ExpressionValue(&part->velocity, c, t, foot);
    through += at->u[c] * at->normal[c];
  }
  for (PetscInt c = 0; c < scene->dim; c++) {
    at->u[c] -= through * at->normal[c];
    at->speed += PetscSqr(at->u[c]);
  }
  at->speed = PetscSqrtReal(at->speed);
  for (PetscInt end = 0; end < 2 && at->speed > 0.0; end++) {
    PetscReal y[ISPH_MAX_DIM] = {0.0}, n[ISPH_MAX_DIM];

    for (PetscInt c = 0; c < scene->dim; c++)
      y[c] = foot[c] + (end ? step : -step) * at->u[c] / at->speed;
    (void)BodyDistance(scene, body, y, n);
    for (PetscInt c = 0; c < scene->dim; c++)
      at->bend += (end ? 0.5 : -0.5) * n[c] * at->u[c] / (at->speed * step);
  }
  return PETSC_TRUE;
}

/*
  SceneWallVelocity - Computes the velocity of a boundary at a point of its surface [m/s]

    u = V(t) + w(t) x (x - X)   for a body with centre X,   V(t, x) for a side of the box
    u = V(t, x) (1 + d b)       for a part of the surface of the domain

  Beside a part of the surface, at a distance d with the curvature b, the velocity is that of a
  solid that follows the surface. In a turning frame V of a side is turned into its axes. A case may
  define the velocities of the sides by a function. An inflow is at rest outside its opening; in it
  the normal velocity is (1 -+ surplus) V, - where it enters, so that no more enters than leaves,
  see SceneCheckInflow().
*/
void SceneWallVelocity(const Scene *scene, PetscInt side, PetscReal t, const PetscReal x[],
                       PetscReal u[])
{
  const Boundary  *boundary = &scene->boundary[side];
  const Body      *body     = BoundaryBody(scene, side);
  PetscReal        r[ISPH_MAX_DIM], V[ISPH_MAX_DIM], w[ISPH_MAX_DIM], y[ISPH_MAX_DIM];
  const PetscReal *place;
  PartPlace        at;

  if (FindPart(scene, side, t, x, &at)) {
    for (PetscInt c = 0; c < scene->dim; c++) u[c] = at.u[c] * (1.0 + at.distance * at.bend);
    return;
  }
  if (body) {
    BodyMotion(scene, side, t, V, w);
    BodyArm(scene, body, x, r);
    for (PetscInt c = 0; c < scene->dim; c++)
      u[c] = V[c] + (w[(c + 1) % 3] * r[(c + 2) % 3] - w[(c + 2) % 3] * r[(c + 1) % 3]);
    return;
  }
  place = SceneLaboratoryPlace(scene, t, x, y);
  for (PetscInt c = 0; c < scene->dim; c++)
    u[c] = ExpressionValue(&boundary->velocity, c, t, place);
  SceneIntoFrame(scene, t, u);
  if (scene->problem->WallVelocity) {
    scene->problem->WallVelocity(scene, side, t, x, u);
  }
  if (!BoundaryIs(scene, side, BOUNDARY_INFLOW)) return;
  u[side / 2] *= 1.0 - (SideEntering(side, u) > 0.0 ? scene->surplus : -scene->surplus);
  for (PetscInt c = 0; c < scene->dim && !BoundaryIsOpen(scene, side, x); c++) u[c] = 0.0;
}

/* Returns the second derivative of a component by differences over 1e-3 tau. */
static PetscReal SecondRate(const Expression *e, PetscInt c, PetscReal t, PetscReal tau)
{
  const PetscReal h = 1e-3 * tau, at = PetscMax(t, h);

  return (ExpressionValue(e, c, at + h, NULL) - 2.0 * ExpressionValue(e, c, at, NULL) +
          ExpressionValue(e, c, at - h, NULL)) /
         PetscSqr(h);
}

/* Computes the rates of the velocity of a body and of its angular velocity at time t. */
static void BodyRate(const Scene *scene, PetscInt side, PetscReal t, PetscReal a[], PetscReal dw[])
{
  const Boundary   *boundary = &scene->boundary[side];
  const PetscReal   tau      = scene->length / scene->speed;
  const PetscBool   axes     = boundary->rotation.n > 1;
  const Expression *rotation = boundary->rides ? &scene->frame->rate : &boundary->rotation;

  for (PetscInt c = 0; c < scene->dim && boundary->free; c++)
    a[c] = boundary->body.pose->rate[0][c];
  for (PetscInt c = 0; c < ISPH_MAX_DIM; c++) {
    if (boundary->free) dw[c] = boundary->body.pose->rate[1][c];
    if (boundary->free) continue;
    dw[c] = axes || c == 2 ? ExpressionRate(rotation, axes ? c : 0, t, NULL, tau) : 0.0;
    if (boundary->turn.n) dw[c] = SecondRate(&boundary->turn, c, t, tau);
    if (c >= scene->dim) continue;
    a[c] = ExpressionRate(&boundary->velocity, c, t, NULL, tau);
    if (boundary->position.n) a[c] = SecondRate(&boundary->position, c, t, tau);
  }
  for (PetscInt c = 0; c < 2 && boundary->rides; c++) {
    const PetscReal *X = scene->frame->centre, *x = boundary->body.centre;
    const PetscReal  w = SceneHas(scene, PHYSICS_CONVECTION) ? SceneFrameRate(scene, t) : 0.0;

    a[c] = (c ? dw[2] : -dw[2]) * (x[1 - c] - X[1 - c]) - PetscSqr(w) * (x[c] - X[c]);
  }
}

/*
  Computes the acceleration of a boundary at a point of its surface [m/s^2]

    a = dV/dt + dw/dt x (x - X) + w x (w x (x - X))   for a body

  The last term is absent without convection, because the equation of the fluid then has no u.grad u
  either. For a side of the box the result is the normal component of dV/dt, because the pressure
  does not depend on tangential acceleration; a part of the surface of the domain has n.(u.grad) u =
  -u.(u.grad) n. Derivatives are centred differences (ExpressionRate()) over 2e-5 L/U.
*/
static void WallAcceleration(const Scene *scene, PetscInt side, PetscReal t, const PetscReal x[],
                             PetscReal a[])
{
  const Boundary *boundary = &scene->boundary[side];
  const Body     *body     = BoundaryBody(scene, side);
  const PetscReal tau      = scene->length / scene->speed;
  PetscReal r[ISPH_MAX_DIM], V[ISPH_MAX_DIM], w[ISPH_MAX_DIM], dw[ISPH_MAX_DIM], y[ISPH_MAX_DIM];
  PartPlace at;

  for (PetscInt c = 0; c < scene->dim; c++) a[c] = 0.0;
  if (!body) {
    a[side / 2] =
        ExpressionRate(&boundary->velocity, side / 2, t, SceneLaboratoryPlace(scene, t, x, y), tau);
    return;
  }
  if (FindPart(scene, side, t, x, &at)) {
    for (PetscInt c = 0; c < scene->dim && SceneHas(scene, PHYSICS_CONVECTION); c++)
      a[c] = -PetscSqr(at.speed) * at.bend * at.normal[c];
    return;
  }
  BodyMotion(scene, side, t, V, w);
  BodyRate(scene, side, t, a, dw);
  BodyArm(scene, body, x, r);
  for (PetscInt c = 0; c < scene->dim; c++) {
    a[c] += dw[(c + 1) % 3] * r[(c + 2) % 3] - dw[(c + 2) % 3] * r[(c + 1) % 3];
    for (PetscInt b = 0; b < ISPH_MAX_DIM && SceneHas(scene, PHYSICS_CONVECTION); b++)
      if (b != c) a[c] += w[c] * w[b] * r[b] - PetscSqr(w[b]) * r[c];
  }
}

/*
  SceneWallPressure - Computes the datum of a boundary for the pressure at a point of its surface

    n.grad p = rho n.(f - a) [Pa/m],   or p [Pa] if the boundary gives its value

  f is the body force, a the acceleration of the boundary; an inflow adds InflowPressureSlope().
*/
PetscReal SceneWallPressure(const Scene *scene, PetscInt side, PetscReal t, const PetscReal x[],
                            const PetscReal normal[])
{
  const BoundaryRow *kind  = scene->boundary[side].kind;
  PetscReal          slope = 0.0, acceleration[ISPH_MAX_DIM], force[ISPH_MAX_DIM];

  if (kind->equation[FIT_PRESSURE] == EQUATION_VALUE)
    return kind->Pressure ? kind->Pressure(scene, side, t, x) : 0.0;
  WallAcceleration(scene, side, t, x, acceleration);
  SceneBodyForce(scene, t, x, force);
  for (PetscInt a = 0; a < scene->dim; a++)
    slope += scene->rho * (force[a] - acceleration[a]) * normal[a];
  if (BoundaryIs(scene, side, BOUNDARY_INFLOW)) slope += InflowPressureSlope(scene, side, t, x);
  return slope;
}

/* Returns the distance from the axis of a body along z to the farthest corner of the box [m]. */
static PetscReal Reach(const Scene *scene, const Body *body)
{
  PetscReal sum = 0.0;

  for (PetscInt a = 0; a < 2; a++)
    sum += PetscSqr(PetscMax(body->centre[a] - scene->lo[a], scene->hi[a] - body->centre[a]));
  return PetscSqrtReal(sum);
}

/* SceneWallSpeedBound - Bounds the speed of the flow that a moving wall drives [m/s]. Input: u -
   wall velocity at the surface point x. A wall that slides tangentially drags fluid at its own
   speed at most. But a very viscous fluid outside a body may rotate with it like a solid: the bound
   is then the speed of this rotation at the farthest corner of the box. A wall that moves along its
   normal can squeeze fluid through gaps at any speed, and a pressure can drive it through a
   boundary that does not confine it: the bound is infinite. */
PetscReal SceneWallSpeedBound(const Scene *scene, PetscInt side, const PetscReal x[],
                              const PetscReal normal[], const PetscReal u[])
{
  const Body *body   = BoundaryBody(scene, side);
  PetscReal   speed2 = 0.0, through = 0.0, arm[ISPH_MAX_DIM];

  if (!BoundaryIs(scene, side, BOUNDARY_CONFINES)) return PETSC_INFINITY;
  for (PetscInt a = 0; a < scene->dim; a++) {
    speed2 += PetscSqr(u[a]);
    through += body ? normal[a] * u[a] : (a == side / 2) * u[a];
  }
  if (PetscSqr(through) > 1e-6 * speed2) return PETSC_INFINITY;
  if (body && !body->around && speed2 > 0.0) {
    BodyArm(scene, body, x, arm);
    speed2 *= PetscSqr(Reach(scene, body)) / (PetscSqr(arm[0]) + PetscSqr(arm[1]));
  }
  return PetscSqrtReal(speed2);
}

/*
  SceneDecayRate - Returns a lower bound on the decay rate of a flow between walls at rest [1/s]

    d|u|/dt <= -nu (pi/W)^2 |u|,  W: smallest distance between opposite sides without slip

  |u| is the root mean square (Poincare's inequality). The bound is zero without such a pair or
  without viscosity.
*/
PetscReal SceneDecayRate(const Scene *scene)
{
  PetscReal width = PETSC_INFINITY;

  for (PetscInt a = 0; a < scene->dim; a++) {
    if (BoundaryIs(scene, 2 * a, BOUNDARY_NO_SLIP) &&
        BoundaryIs(scene, 2 * a + 1, BOUNDARY_NO_SLIP))
      width = PetscMin(width, scene->hi[a] - scene->lo[a]);
  }
  return SceneHas(scene, PHYSICS_VISCOSITY) ? scene->nu_low * PetscSqr(PETSC_PI / width) : 0.0;
}
