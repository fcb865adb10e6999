/* Checks of a typed scene before any particle exists: contacts of bodies, regions filled at the
   start, the balance of inflow and outflow through the sides, and what stays in a turning frame. */
#include "isph/scene.h"

#define STIFF        3.0    /* ratio of viscosities */
#define UNBALANCED   2e-3   /* largest part of a flow that enters and does not leave */
#define OUTLINE_MOST 100000 /* longest outline of a filled region, which ranks sample [dx] */
#define THROUGH      1e-6   /* normal part of a tangential velocity, by rounding [-] */
#define SAMPLES      8      /* times at which two rates are compared */

enum { FRAME_ROTATION, FRAME_CENTRE };
static const OptionRow options[] = {
    [FRAME_ROTATION] = OPTION(EXPRESSION, "-frame_rotation",
                              "rotation rate of the frame of reference about z, of t", "rad/s",
                              "that of the first body that is not round", .where = "-motion frame"),
    [FRAME_CENTRE] =
        OPTION(REALS, "-frame_centre", "point x,y about which the frame turns", "m",
               "centre of that body, or the middle of the box", .where = "-motion frame"),
};
const OptionTable FrameOptions = OPTIONS("Turning frame of reference", options);

/* Refuses a body that overlaps its own periodic image, by its extent along each axis. */
static PetscErrorCode CheckImages(const Scene *scene, PetscInt k)
{
  const Body *body = SceneBody(scene, k);

  PetscFunctionBegin;
  for (PetscInt a = 0; a < scene->dim; a++) {
    PetscReal span[2], gap;

    if (BodyReachesThrough(body, a) || !SceneIsPeriodic(scene, a)) continue;
    BodySpan(body, a, span);
    gap = scene->hi[a] - scene->lo[a] - (span[1] - span[0]);
    UserCheck(gap > 0.0,
              "-scene_body_%" PetscInt_FMT ": along %c it overlaps its periodic image by %.3g m; "
              "use a larger -scene_box or a smaller body",
              k + 1, "xyz"[a], (double)-gap);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns true if two boundaries move as a single solid at time t, seen at x. */
static PetscBool MoveAlike(const Scene *scene, PetscInt side, PetscInt other, PetscReal t,
                           const PetscReal x[])
{
  const PetscInt of[2]              = {side, other};
  PetscReal      u[2][ISPH_MAX_DIM] = {{0.0}}, spin[2][ISPH_MAX_DIM] = {{0.0}}, apart = 0.0;
  PetscBool      moves = PETSC_FALSE;

  for (PetscInt k = 0; k < 2; k++) {
    PetscReal arm[ISPH_MAX_DIM], V[ISPH_MAX_DIM];

    if (!scene->boundary[of[k]].moves) continue;
    moves = PETSC_TRUE;
    if (scene->boundary[of[k]].free) return PETSC_FALSE;
    BodyMotion(scene, of[k], t, V, spin[k]);
    BodyArm(scene, BoundaryBody(scene, of[k]), x, arm);
    for (PetscInt a = 0; a < ISPH_MAX_DIM; a++)
      u[k][a] =
          V[a] + spin[k][(a + 1) % 3] * arm[(a + 2) % 3] - spin[k][(a + 2) % 3] * arm[(a + 1) % 3];
  }
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) {
    apart = PetscMax(apart, PetscAbsReal(u[0][a] - u[1][a]));
    apart = PetscMax(apart, scene->length * PetscAbsReal(spin[0][a] - spin[1][a]));
  }
  return !moves || apart <= THROUGH * scene->speed;
}

/* Returns the distance of x from a boundary [m]. */
static PetscReal DistanceOf(const Scene *scene, PetscInt side, const PetscReal x[])
{
  const Body *body = BoundaryBody(scene, side);
  PetscReal   normal[ISPH_MAX_DIM];

  return body ? BodyDistance(scene, body, x, normal) : SceneSideDistance(scene, side, x);
}

/* SceneCheckMoved - Refuses bodies that are more than `depth` > 0 in another boundary at time t, or
   with depth 0 touch one, unless both move as one solid: wall particles that others bury are
   removed at the start. Collective. For scenes with bodies that move. */
PetscErrorCode SceneCheckMoved(const Scene *scene, PetscReal t, PetscReal depth)
{
  const PetscInt first = SceneBodySide(scene, 0), all = SceneBoundaries(scene);

  PetscFunctionBegin;
  for (PetscInt pair = first * all; pair < all * all; pair++) {
    const PetscInt  side = pair / all, other = pair % all;
    const Body     *body    = BoundaryBody(scene, side);
    const PetscReal spacing = BodySpacing(scene, body);
    char            name[2][WALL_NAME], place[PLACE_TEXT];

    if (other == side || !BoundaryIs(scene, other, BOUNDARY_PARTICLES)) continue;
    if (!scene->boundary[side].moves && !scene->boundary[other].moves) continue;
    SceneWallName(scene, side, name[0]);
    SceneWallName(scene, other, name[1]);
    for (PetscInt q = 0; q < BodyPoints(body, spacing); q++) {
      PetscReal x[ISPH_MAX_DIM], normal[ISPH_MAX_DIM];

      (void)BodyPoint(body, q, spacing, x, normal);
      if (depth > 0.0 ? DistanceOf(scene, other, x) >= -depth : !SceneBuries(scene, other, side, x))
        continue;
      UserCheck(MoveAlike(scene, side, other, t, x),
                "-scene_%s: at t = %.3g s it is in %s at (%s), and they do not move as one solid; "
                "let them stay apart, or give both one motion",
                name[0], (double)t, name[1], ScenePlaceText(scene, x, place));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SceneCheckBodies - Refuses bodies without a surface in the fluid, bodies that overlap their own
   periodic images, and bodies that overlap and move apart. Collective. Bodies may touch and overlap
   each other, the domain and sides of the box: then they are one solid for the fluid, see
   SceneIsBuried(). */
PetscErrorCode SceneCheckBodies(const Scene *scene)
{
  PetscFunctionBegin;
  for (PetscInt k = 0; k < scene->n_bodies; k++) {
    const PetscInt  side    = SceneBodySide(scene, k);
    const Body     *body    = SceneBody(scene, k);
    const PetscReal spacing = BodySpacing(scene, body);
    PetscBool       wet     = PETSC_FALSE;
    char            name[WALL_NAME];

    if (!body->around) PetscCall(CheckImages(scene, k));
    for (PetscInt q = 0; q < BodyPoints(body, spacing) && !wet; q++) {
      PetscReal x[ISPH_MAX_DIM], normal[ISPH_MAX_DIM];

      (void)BodyPoint(body, q, spacing, x, normal);
      wet = SceneIsBuried(scene, side, x) ? PETSC_FALSE : PETSC_TRUE;
    }
    SceneWallName(scene, side, name);
    UserCheck(wet,
              "-scene_%s: all of its surface is in other solids or outside the fluid; leave it "
              "out or move it",
              name);
  }
  if (scene->pose) PetscCall(SceneCheckMoved(scene, 0.0, 0.0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SceneNarrowestGap - Returns the least distance of a body from another boundary that it does not
   touch, in spacings there; infinite if there is none. Looks at points dx apart. Output: between -
   both boundaries; x - a point of the first one. */
PetscReal SceneNarrowestGap(const Scene *scene, PetscInt between[2], PetscReal x[])
{
  PetscReal best = PETSC_INFINITY;

  for (PetscInt side = SceneBodySide(scene, 0); side < SceneBoundaries(scene); side++) {
    const Body     *body    = BoundaryBody(scene, side);
    const PetscReal spacing = BodySpacing(scene, body);

    for (PetscInt other = 0; other < SceneBoundaries(scene); other++) {
      PetscReal least = PETSC_INFINITY, at[ISPH_MAX_DIM];

      if (other == side || !BoundaryIs(scene, other, BOUNDARY_PARTICLES)) continue;
      for (PetscInt q = 0; q < BodyPoints(body, spacing) && least > 0.0; q++) {
        PetscReal y[ISPH_MAX_DIM], normal[ISPH_MAX_DIM], gap;

        (void)BodyPoint(body, q, spacing, y, normal);
        gap = DistanceOf(scene, other, y);
        gap = gap <= SCENE_ON_SURFACE * scene->dx ? 0.0 : gap / SceneSpacing(scene, y);
        if (gap >= least || (gap > 0.0 && SceneIsBuried(scene, side, y))) continue;
        least = gap;
        (void)PetscArraycpy(at, y, ISPH_MAX_DIM);
      }
      if (least == 0.0 || least >= best) continue;
      best       = least;
      between[0] = side;
      between[1] = other;
      (void)PetscArraycpy(x, at, ISPH_MAX_DIM);
    }
  }
  return best;
}

/* SceneCheckFilled - Refuses regions filled at the start that are thin or outside the box, that end
   on a single one of two periodic sides. Collective. A region reaches over both periodic sides of
   an axis or over none. */
PetscErrorCode SceneCheckFilled(const Scene *scene)
{
  const PetscReal least = 2.0 * SceneCoarsest(scene), slack = 1e-6 * SceneTolerance(scene);

  PetscFunctionBegin;
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

/* SceneCheckFluids - Refuses a stiff fluid with a film of thinner fluid below dx before a wall.
   Collective. The film has no particles then: the wall drags the stiff fluid itself. A disc of
   radius 0.1 and 1e5 times the viscosity, 0.9 dx below the lid of a cavity with n = 20, gets 5
   times the energy that it has with n = 80; 1.2 dx below the lid it has 0.7 times. Regions that
   reach the wall leave no film. */
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

/* SceneCheckMixture - Refuses scenes in which fluids of several densities, or interfaces with a
   tension, have no equations */
PetscErrorCode SceneCheckMixture(const Scene *scene)
{
  PetscFunctionBegin;
  if (!SceneMixes(scene)) PetscFunctionReturn(PETSC_SUCCESS);
  UserCheck(SceneMoves(scene) && SceneHas(scene, PHYSICS_PRESSURE),
            "-scene_fluid_1_density: fluids of several densities, or with a tension, move "
            "with their particles, and need a pressure; use -motion lagrangian");
  UserCheck(!SceneHasOpenings(scene),
            "-scene_fluid_1_density: fluids of several densities, or with a tension, have no "
            "inflows and outflows");
  UserCheck(!SceneIsGraded(scene) && !SceneMovesGraded(scene),
            "-scene_fluid_1_density: fluids of several densities, or with a tension, have one "
            "size of particles; leave out -spacing_ options");
  UserCheck(!scene->force.n,
            "-body_force: fluids of several densities, or with a tension, need numbers, as their "
            "weight acts on the interface");
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
  char                name[WALL_NAME];

  PetscFunctionBegin;
  SceneWallName(scene, SceneBodySide(scene, k), name);
  UserCheck(!boundary->velocity.n && boundary->rotation.n <= 1,
            "-scene_%s: with -motion frame bodies turn about the axis of the frame and do not "
            "travel; give one rate, -scene_%s_rotation",
            name, name);
  boundary->rides = ThroughSurface(scene, k, frame->centre) > THROUGH;
  if (!boundary->rides || !boundary->rotation.n) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt a = 0; a < 2; a++)
    off = PetscMax(off, PetscAbsReal(boundary->body.centre[a] - frame->centre[a]));
  UserCheck(
      off <= THROUGH * scene->dx && AreSame(scene, &boundary->rotation, &frame->rate),
      "-scene_%s_rotation: it is not round about the axis of -motion frame at (%.6g, %.6g), and "
      "turns with the frame; leave its rotation out, or use -motion lagrangian",
      name, (double)frame->centre[0], (double)frame->centre[1]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses sides of the box that are not round about the axis, unless they are in a solid. */
static PetscErrorCode CheckFrameSides(Scene *scene)
{
  PetscFunctionBegin;
  for (PetscInt side = 0; side < 2 * scene->dim; side++) {
    const BoundaryRow *kind = scene->boundary[side].kind;

    UserCheck(side >= 4 || kind == &BoundaryNone,
              "-motion frame: the %s side of the box is not round about the axis of the frame; put "
              "the fluid into a round -scene_domain, or use -motion lagrangian",
              BoxSides[side]);
    UserCheck(!(kind->properties & (BOUNDARY_INFLOW | BOUNDARY_OUTFLOW)),
              "-motion frame: %s has no fixed particles in a turning frame; allowed along z are "
              "walls, periodic sides and symmetry",
              kind->option.name);
    if (scene->boundary[side].velocity.n) scene->unsteady_walls = PETSC_TRUE;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SceneReadFrame - Reads the frame of reference of -motion frame; nothing for other motions;
   collective. To be called when sides and bodies are known. */
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
