/*
  Checks of a typed scene before any particle exists: gaps between bodies, regions filled at the
  start, the balance of inflow and outflow through the sides, and what stays in a turning frame.
*/
#include "isph/scene.h"

#define STIFF        3.0    /* ratio of viscosities */
#define OPEN_CORNER  0.75   /* cosine of the least angle between a body and an opening */
#define UNBALANCED   2e-3   /* largest part of a flow that enters and does not leave */
#define OUTLINE_MOST 100000 /* longest outline of a filled region, which ranks sample [dx] */
#define THROUGH      1e-6   /* normal part of a tangential velocity, by rounding [-] */
#define SAMPLES      8      /* times at which two rates are compared */

enum { FRAME_ROTATION, FRAME_CENTRE };
static const OptionRow options[] = {
    [FRAME_ROTATION] =
        {
            .name     = "-frame_rotation",
            .kind     = VALUE_EXPRESSION,
            .brief    = "rotation rate of the frame of reference about z, of t",
            .unit     = "rad/s",
            .standard = "that of the first body that is not round",
            .where    = "-motion frame",
        },
    [FRAME_CENTRE] =
        {
            .name     = "-frame_centre",
            .kind     = VALUE_REALS,
            .brief    = "point x,y about which the frame turns",
            .unit     = "m",
            .standard = "centre of that body, or the middle of the box",
            .where    = "-motion frame",
        },
};
const OptionTable FrameOptions = OPTIONS("Turning frame of reference", options);

/* Checks the gap between a body and its own periodic image, from its extent along each axis. */
static PetscErrorCode CheckImages(const Scene *scene)
{
  PetscFunctionBegin;
  for (PetscInt k = 0; k < scene->n_bodies; k++) {
    for (PetscInt a = 0; a < scene->dim; a++) {
      const Body *body = SceneBody(scene, k);
      PetscReal   x[ISPH_MAX_DIM], span[2], gap, least;

      if (BodyReachesThrough(body, a)) continue;
      PetscCall(PetscArraycpy(x, body->centre, ISPH_MAX_DIM));
      BodySpan(body, a, span);
      x[a]  = span[1];
      least = 4.0 * SceneSpacing(scene, x);
      gap   = scene->hi[a] - scene->lo[a] - (span[1] - span[0]);
      UserCheck(!SceneIsPeriodic(scene, a) || gap >= least,
                "-scene_body_%" PetscInt_FMT
                ": along %c its periodic image is %.3g away; less than 4 dx = %.3g, or "
                "overlapping; use a larger -n",
                k + 1, "xyz"[a], (double)gap, (double)least);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns true if a body stands on a side of the box or reaches beyond it. */
static PetscBool StandsOn(const Scene *scene, const Body *body, PetscInt side)
{
  const PetscReal slack = SCENE_ON_SURFACE * scene->dx;
  PetscReal       span[2];

  BodySpan(body, side / 2, span);
  return side % 2 ? span[1] >= scene->hi[side / 2] - slack : span[0] <= scene->lo[side / 2] + slack;
}

/* Returns the gap between a point of the surface of a body and a side of the box. A body that
   stands on the side has no gap at the corner between them; there the gap is the way from the point
   to the side along the normal, which is short only in an acute corner. At openings such a corner
   is no wedge of fluid at rest, and may be acute down to OPEN_CORNER. */
static PetscReal SideGap(const Scene *scene, const Body *body, PetscInt side, const PetscReal x[],
                         const PetscReal normal[])
{
  const PetscInt  a       = side / 2;
  const PetscReal gap     = SceneSideDistance(scene, side, x);
  const PetscReal towards = side % 2 ? normal[a] : -normal[a];

  if (!StandsOn(scene, body, side)) return gap;
  if ((BoundaryIs(scene, side, BOUNDARY_INFLOW) || BoundaryIs(scene, side, BOUNDARY_OUTFLOW)) &&
      towards < OPEN_CORNER)
    return PETSC_INFINITY;
  return towards > PETSC_SMALL ? gap / towards : PETSC_INFINITY;
}

/* Computes the gap between point q of the surface of body k and the nearest other wall, negative in
   it [m]; returns false for a point that is no wall for the fluid. Output: acute - the gap is that
   of a corner with a side. */
static PetscBool BodyGap(const Scene *scene, PetscInt k, PetscInt q, PetscReal x[], PetscReal *gap,
                         PetscBool *acute)
{
  const Body *body = SceneBody(scene, k);
  PetscReal   normal[ISPH_MAX_DIM], other[ISPH_MAX_DIM];

  (void)BodyPoint(body, q, BodySpacing(scene, body), x, normal);
  if (SceneIsBuried(scene, SceneBodySide(scene, k), x)) return PETSC_FALSE;
  *gap   = PETSC_INFINITY;
  *acute = PETSC_FALSE;
  for (PetscInt m = 0; m < scene->n_bodies; m++)
    if (m != k) *gap = PetscMin(*gap, BodyDistance(scene, SceneBody(scene, m), x, other));
  for (PetscInt side = 0; side < 2 * scene->dim; side++) {
    const PetscReal to_side = SideGap(scene, body, side, x, normal);

    if (!BoundaryIs(scene, side, BOUNDARY_PARTICLES) || to_side >= *gap) continue;
    *gap   = to_side;
    *acute = StandsOn(scene, body, side);
  }
  return PETSC_TRUE;
}

/*
  SceneCheckGaps - Refuses bodies that overlap or leave gaps too narrow for least-squares fits

  Collective. A gap between surfaces, also through a periodic side, has 4 dx or more, with the
  spacing at the surface in place of dx if it differs. Bodies may stand on sides of the box.
*/
PetscErrorCode SceneCheckGaps(const Scene *scene)
{
  PetscFunctionBegin;
  PetscCall(CheckImages(scene));
  for (PetscInt k = 0; k < scene->n_bodies; k++) {
    const Body *body  = SceneBody(scene, k);
    PetscReal   worst = PETSC_INFINITY, least = 0.0, at[ISPH_MAX_DIM];
    PetscBool   corner = PETSC_FALSE;
    char        place[PLACE_TEXT];

    for (PetscInt q = 0; q < BodyPoints(body, BodySpacing(scene, body)); q++) {
      PetscReal x[ISPH_MAX_DIM], gap;
      PetscBool acute;

      if (!BodyGap(scene, k, q, x, &gap, &acute)) continue;
      if (gap >= 4.0 * SceneSpacing(scene, x) || gap >= worst) continue;
      worst  = gap;
      corner = acute;
      least  = 4.0 * SceneSpacing(scene, x);
      for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) at[a] = x[a];
    }
    UserCheck(
        worst >= 0.0,
        "-scene_body_%" PetscInt_FMT
        ": at (%s) it overlaps another wall by %.3g, at any -n; type both as one shape, such as "
        "a polygon, or leave a gap of 4 dx = %.3g",
        k + 1, ScenePlaceText(scene, at, place), (double)-worst, (double)least);
    UserCheck(
        worst >= least || !corner,
        "-scene_body_%" PetscInt_FMT
        ": at (%s) it meets a side of the box at an acute angle, at any -n; move it, or close "
        "the corner by another shape",
        k + 1, ScenePlaceText(scene, at, place));
    UserCheck(worst >= least,
              "-scene_body_%" PetscInt_FMT
              ": at (%s) it is %.3g from another wall; less than 4 dx = %.3g; use a larger -n",
              k + 1, ScenePlaceText(scene, at, place), (double)worst, (double)least);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  SceneCheckFilled - Refuses regions filled at the start that are thin or outside the box, that end
  on a single one of two periodic sides, or that stand beside -scene_free

  Collective. A region reaches over both periodic sides of an axis or over none.
*/
PetscErrorCode SceneCheckFilled(const Scene *scene)
{
  const PetscReal least = 2.0 * SceneCoarsest(scene), slack = 1e-6 * SceneTolerance(scene);

  PetscFunctionBegin;
  UserCheck(!scene->n_filled || !SceneHasBoundary(scene, BOUNDARY_FREE),
            "-scene_free: the borders of -scene_filled_1 are the free surface; leave -scene_free "
            "out");
  for (PetscInt k = 0; k < scene->n_filled; k++) {
    const ShapeRow *outline = BodyOutline(scene, &scene->filled[k]);

    UserCheck(!outline || outline->Count(&scene->filled[k], scene->dx) <= OUTLINE_MOST,
              "-scene_filled_%" PetscInt_FMT
              ": its outline is longer than %d dx; a region need not reach far beyond the box",
              k + 1, OUTLINE_MOST);
    for (PetscInt a = 0; a < scene->dim; a++) {
      PetscReal span[2], width;

      BodySpan(&scene->filled[k], a, span);
      width = PetscMin(span[1], scene->hi[a]) - PetscMax(span[0], scene->lo[a]);
      UserCheck(width >= least,
                "-scene_filled_%" PetscInt_FMT
                ": %.3g m of it are in the box along %c; at least 2 dx = %.3g is allowed; use a "
                "larger -n or another place",
                k + 1, (double)PetscMax(width, 0.0), "xyz"[a], (double)least);
      UserCheck(!SceneIsPeriodic(scene, a) ||
                    (span[0] < scene->lo[a] + slack) == (span[1] > scene->hi[a] - slack),
                "-scene_filled_%" PetscInt_FMT
                ": it reaches one of the periodic sides along %c; let it reach both or none",
                k + 1, "xyz"[a]);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  SceneCheckInflow - Refuses velocities of the sides by which inflow and outflow at time t differ,
  and sets the small difference that SceneWallVelocity() removes

    surplus = int u.n dA / int |u.n| dA,   at most UNBALANCED

  Collective. With a difference no flow without divergence exists, unless fluid passes a boundary
  that gives the pressure; without the physics `pressure` velocities need no balance. Uses the
  midpoint rule. Bodies do not contribute, because their surfaces move rigidly.
*/
PetscErrorCode SceneCheckInflow(Scene *scene, PetscReal t)
{
  PetscReal in = 0.0, through = 0.0;

  PetscFunctionBegin;
  scene->surplus = 0.0;
  if (!SceneHas(scene, PHYSICS_PRESSURE) || !ScenePressureFloats(scene))
    PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt side = 0; side < 2 * scene->dim; side++) {
    if (!BoundaryIs(scene, side, BOUNDARY_PARTICLES)) continue;
    for (PetscInt k = 0; k < SideSamples(scene, side); k++) {
      PetscReal       x[ISPH_MAX_DIM] = {0.0}, u[ISPH_MAX_DIM];
      const PetscReal piece           = SideSample(scene, side, k, x);

      if (SceneIsBuried(scene, side, x)) continue;
      SceneWallVelocity(scene, side, t, x, u);
      in += SideEntering(side, u) * piece;
      through += PetscAbsReal(SideEntering(side, u)) * piece;
    }
  }
  UserCheck(
      !(PetscAbsReal(in) > UNBALANCED * through),
      "-scene_wall_<side>_velocity: at t = %.3g s %.4g m^%d/s of fluid more %s through the sides; "
      "inflow and outflow must balance, or use -scene_outflow",
      (double)t, (double)PetscAbsReal(in), (int)scene->dim,
      in > 0.0 ? "come in than go out" : "go out than come in");
  if (PetscAbsReal(in) > PETSC_SMALL * through) scene->surplus = in / through;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the gaps between the border of region k and the boundaries: least[side], infinite where the
   border reaches the boundary or has no neighbour of much lower viscosity. */
static void FluidGaps(const Scene *scene, PetscInt k, PetscReal least[])
{
  const Body     *region  = &scene->region[k];
  const PetscReal spacing = BodySpacing(scene, region);

  for (PetscInt s = 0; s < SceneBoundaries(scene); s++) least[s] = PETSC_INFINITY;
  for (PetscInt q = 0; q < BodyPoints(region, spacing); q++) {
    PetscReal x[ISPH_MAX_DIM] = {0.0}, normal[ISPH_MAX_DIM], beyond[ISPH_MAX_DIM], gap;
    PetscInt  side;

    (void)BodyPoint(region, q, spacing, x, normal);
    gap = SceneFluidDistance(scene, x, &side);
    if (side < 0) continue;
    if (gap <= SCENE_ON_SURFACE * scene->dx) least[side] = -PETSC_INFINITY; /* no film */
    for (PetscInt a = 0; a < ISPH_MAX_DIM; a++)
      beyond[a] = x[a] + 0.5 * PetscMax(gap, 0.0) * normal[a];
    if (scene->region_nu[k] > STIFF * SceneViscosityAt(scene, beyond))
      least[side] = PetscMin(least[side], gap);
  }
  for (PetscInt s = 0; s < SceneBoundaries(scene); s++)
    if (least[s] == -PETSC_INFINITY) least[s] = PETSC_INFINITY;
}

/*
  SceneCheckFluids - Refuses a stiff fluid with a film of thinner fluid below dx before a wall

  Collective. The film has no particles then: the wall drags the stiff fluid itself. A disc of
  radius 0.1 and 1e5 times the viscosity, 0.9 dx below the lid of a cavity with n = 20, gets 5 times
  the energy that it has with n = 80; 1.2 dx below the lid it has 0.7 times. Regions that reach the
  wall leave no film.
*/
PetscErrorCode SceneCheckFluids(const Scene *scene)
{
  PetscReal *least;
  char       name[WALL_NAME];

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(SceneBoundaries(scene), &least));
  for (PetscInt k = 0; k < scene->n_regions; k++) {
    FluidGaps(scene, k, least);
    for (PetscInt side = 0; side < SceneBoundaries(scene); side++) {
      SceneWallName(scene, side, name);
      UserCheck(least[side] >= SceneCoarsest(scene),
                "-scene_fluid_%" PetscInt_FMT
                ": it is %.3g from %s, and a film of thinner fluid there needs dx = %.3g; use a "
                "larger -n, or let the fluid reach the wall",
                k + 1, (double)least[side], name, (double)SceneCoarsest(scene));
    }
  }
  PetscCall(PetscFree(least));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the largest part along the normal of a rotation of the surface of body k about a point,
   relative to its velocity; 0 for surfaces that are round about it. */
static PetscReal ThroughSurface(const Scene *scene, PetscInt k, const PetscReal centre[2])
{
  const Body     *body    = SceneBody(scene, k);
  const PetscReal spacing = BodySpacing(scene, body);
  PetscReal       most    = 0.0;

  for (PetscInt q = 0; q < BodyPoints(body, spacing); q++) {
    PetscReal x[ISPH_MAX_DIM], n[ISPH_MAX_DIM], r[2];

    (void)BodyPoint(body, q, spacing, x, n);
    for (PetscInt a = 0; a < 2; a++) r[a] = x[a] - centre[a];
    most = PetscMax(most, PetscAbsReal(n[1] * r[0] - n[0] * r[1]) / body->extent);
  }
  return most;
}

/* Returns true if two rates are the same function of t. */
static PetscBool AreSame(const Scene *scene, const Expression *a, const Expression *b)
{
  for (PetscInt k = 0; k < SAMPLES; k++) {
    const PetscReal t = 0.37 * k * scene->length / scene->speed;

    if (ExpressionValue(a, 0, t, NULL) != ExpressionValue(b, 0, t, NULL)) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* Lets body k turn with the frame unless it is round about the axis; refuses motions through its
   surface. */
static PetscErrorCode RideBody(Scene *scene, PetscInt k)
{
  const TurningFrame *frame    = scene->frame;
  Boundary           *boundary = &scene->boundary[SceneBodySide(scene, k)];
  PetscReal           off      = 0.0;

  PetscFunctionBegin;
  UserCheck(!boundary->velocity.n && boundary->rotation.n <= 1,
            "-scene_body_%" PetscInt_FMT
            ": with -motion frame bodies turn about the axis of the frame and do "
            "not travel; give one rate, -scene_body_%" PetscInt_FMT "_rotation",
            k + 1, k + 1);
  boundary->rides = ThroughSurface(scene, k, frame->centre) > THROUGH ? PETSC_TRUE : PETSC_FALSE;
  if (!boundary->rides || !boundary->rotation.n) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt a = 0; a < 2; a++)
    off = PetscMax(off, PetscAbsReal(boundary->body.centre[a] - frame->centre[a]));
  UserCheck(
      off <= THROUGH * scene->dx && AreSame(scene, &boundary->rotation, &frame->rate),
      "-scene_body_%" PetscInt_FMT "_rotation: the body is not round about the axis of -motion "
      "frame at (%.6g, %.6g), and turns with the frame; leave its rotation out, or use -motion "
      "lagrangian",
      k + 1, (double)frame->centre[0], (double)frame->centre[1]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses sides of the box that are not round about the axis, unless they are in a solid. */
static PetscErrorCode CheckFrameSides(Scene *scene)
{
  PetscFunctionBegin;
  for (PetscInt side = 0; side < 2 * scene->dim; side++) {
    const BoundaryRow *kind = scene->boundary[side].kind;

    UserCheck(
        side >= 4 || kind == &BoundaryNone,
        "-motion frame: the %s side of the box is not round about the axis of the frame; put "
        "the fluid inside a round body with -scene_body_<k>_around, or use -motion lagrangian",
        BoxSides[side]);
    UserCheck(!(kind->properties & (BOUNDARY_FREE | BOUNDARY_INFLOW | BOUNDARY_OUTFLOW)),
              "-motion frame: %s has no fixed particles in a turning frame; allowed along z are "
              "walls, periodic sides and symmetry",
              kind->option.name);
    if (scene->boundary[side].velocity.n) scene->unsteady_walls = PETSC_TRUE;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  SceneReadFrame - Reads the frame of reference of -motion frame; nothing for other motions

  Collective. To be called when sides and bodies are known.

  Options Database Keys:
+ -frame_rotation w - rate of rotation about z [rad/s] (t)
- -frame_centre x,y - a point of the axis [m]

  Errors: bodies and sides whose places in the frame would change end the run
*/
PetscErrorCode SceneReadFrame(Scene *scene)
{
  const Boundary *rotor = NULL;
  PetscInt        n     = 2;
  PetscBool       given;
  TurningFrame   *f;

  PetscFunctionBegin;
  if (!scene->motion || !scene->motion->turns) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < scene->n_bodies && !rotor; k++)
    if (ThroughSurface(scene, k, SceneBody(scene, k)->centre) > THROUGH)
      rotor = &scene->boundary[SceneBodySide(scene, k)];
  PetscCall(PetscNew(&f));
  f->t = NAN;
  for (PetscInt a = 0; a < 2; a++)
    f->centre[a] = rotor ? rotor->body.centre[a] : 0.5 * (scene->lo[a] + scene->hi[a]);
  PetscCall(ExpressionGet(scene->scope, &options[FRAME_ROTATION], 1, 1, EXPRESSION_TIME, &f->rate,
                          &given));
  if (!given && rotor) f->rate = rotor->rotation;
  UserCheck(f->rate.n, "-motion frame: the rate at which the frame turns is required; give "
                       "-frame_rotation, or -scene_body_<k>_rotation of a body that is not round");
  PetscCall(OptionGetReals(&options[FRAME_CENTRE], 2, f->centre, &n, &given));
  UserCheck(!given || n == 2, "-frame_centre: 2 numbers are required, got %" PetscInt_FMT, n);
  scene->frame = f;
  for (PetscInt k = 0; k < scene->n_bodies; k++) PetscCall(RideBody(scene, k));
  PetscCall(CheckFrameSides(scene));
  if (ExpressionUses(&f->rate, EXPRESSION_TIME)) scene->unsteady_walls = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}
