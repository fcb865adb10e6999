/* Bodies, the domain and parts of its surface as they are typed: shapes, places and motions. The
   domain is a body with the fluid inside, the last one. */
#include "isph/scene.h"

#define ALONG      0.03 /* largest normal part of the velocity of a part of a surface [-] */
#define SAMPLES    8    /* times at which velocities are looked at */
#define ROOM       2.0  /* behind the domain [cells] */
#define LEAST_ROOM 0.25 /* the same in a box as typed [dx] */
#define FINE       0.25 /* between points of surfaces that are looked at [dx] */

enum {
  BODY,
  BODY_PLACE,
  BODY_VELOCITY,
  BODY_POSITION,
  BODY_ROTATION,
  VESSEL, /* in the order of bodies */
  VESSEL_PLACE,
  VESSEL_VELOCITY,
  VESSEL_POSITION,
  VESSEL_ROTATION,
  PART,
  PART_VELOCITY
};
static const OptionRow options[] = {
    [BODY] = OPTION(
        SHAPE, "-scene_body_<k>",
        "a solid body: circle,cx,cy,r or box,x0,y0,x1,y1 or polygon,x0,y0,...; in 3D "
        "ball,cx,cy,cz,r or box,x0,y0,z0,x1,y1,z1 or revolved,r0,z0,... about the axis z or, "
        "through the box along z, cylinder,cx,cy,r or prism,x0,y0,...; more shapes: -catalogue; "
        "shapes with ' + ', ' - ' or ' & ' between are added, cut away or intersected in their "
        "order; several bodies may be listed with semicolons; bodies are numbered 1, 2, ...",
        "m", NULL, .table = &ShapeTable, .table_3d = &SolidTable, .where = "-case scene"),
    [BODY_PLACE] =
        OPTION(REALS, "-scene_body_<k>_place",
               "way of a body from where its shape was typed, and turn about its centre: "
               "dx,dy[,degrees]; in 3D dx,dy,dz[,ax,ay,az,degrees] about ax,ay,az",
               "m", "0", .where = "-case scene, bodies that are given"),
    [BODY_VELOCITY] = OPTION(EXPRESSION, "-scene_body_<k>_velocity",
                             "velocity u,v[,w] of a body, of t; the body moves if particles move, "
                             "and else its surface alone has this velocity",
                             "m/s", "0", .where = "-case scene, bodies that are given"),
    [BODY_POSITION] = OPTION(
        EXPRESSION, "-scene_body_<k>_position",
        "position x,y[,z] of the centre of a body that moves, of t, in place of its velocity", "m",
        "from the shape and the velocity",
        .where = "-case scene, bodies that are given, particles that move"),
    [BODY_ROTATION] =
        OPTION(EXPRESSION, "-scene_body_<k>_rotation",
               "rotation rate of a body about its centre, of t: about z, in 3D also about x, y, z",
               "rad/s", "0", .where = "-case scene, bodies that are given"),
    [VESSEL] = OPTION(
        SHAPE, "-scene_domain",
        "the fluid is inside this shape, a shape as of bodies, and outside of all bodies; sides of "
        "the box that it reaches beyond cut it, the others are no boundaries",
        "m", "the box", .table = &ShapeTable, .table_3d = &SolidTable, .where = "-case scene"),
    [VESSEL_PLACE] =
        OPTION(REALS, "-scene_domain_place", "way and turn of the domain, as of a body", "m", "0",
               .where = "-case scene with -scene_domain"),
    [VESSEL_VELOCITY] = OPTION(EXPRESSION, "-scene_domain_velocity",
                               "velocity u,v[,w] of the walls of the domain, of t, as of a body",
                               "m/s", "0", .where = "-case scene with -scene_domain"),
    [VESSEL_POSITION] = OPTION(EXPRESSION, "-scene_domain_position",
                               "position x,y[,z] of the centre of a domain that moves, of t", "m",
                               "from the shape and the velocity",
                               .where = "-case scene with -scene_domain, particles that move"),
    [VESSEL_ROTATION] =
        OPTION(EXPRESSION, "-scene_domain_rotation",
               "rotation rate of the walls of the domain about its centre, of t, as of a body",
               "rad/s", "0", .where = "-case scene with -scene_domain"),
    [PART] = OPTION(
        SHAPE, "-scene_part_<k>",
        "part of the walls of the domain inside this shape, a shape as of bodies, with a velocity "
        "of its own; parts are numbered 1, 2, ..., and a later one covers an earlier one",
        "m", NULL, .table = &ShapeTable, .table_3d = &SolidTable,
        .where = "-case scene with -scene_domain"),
    [PART_VELOCITY] = OPTION(EXPRESSION, "-scene_part_<k>_velocity",
                             "velocity u,v[,w] of this part, along the surface, of x, y[, z], t",
                             "m/s", NULL, .where = "-case scene, parts that are given"),
};
const OptionTable BodyOptions = OPTIONS("Bodies and domain of typed scenes", options);

/* Makes the row of an option of body k; k = 0: of the domain. */
static void OptionOf(PetscInt option, PetscInt k, char name[OPTION_LENGTH], OptionRow *row)
{
  OptionNumber(&options[k ? option : option + VESSEL - BODY], k, name, row);
}

/* Returns true if component c of an expression of t is not zero and keeps its value, 1+0*t. */
static PetscBool IsSteady(const Scene *scene, const Expression *e, PetscInt c)
{
  const PetscReal first = ExpressionValue(e, c, 0.0, NULL);

  for (PetscInt k = 1; k < SAMPLES; k++) {
    if (ExpressionValue(e, c, 0.37 * k * scene->length / scene->speed, NULL) != first)
      return PETSC_FALSE;
  }
  return first != 0.0;
}

/* Refuses a steady motion of a body beside particles that stay where they are: it would carry fluid
   through the surface. A motion that depends on t may be small compared with the body. */
static PetscErrorCode CheckSurfaceMotion(const Scene *scene, const Boundary *boundary)
{
  const Expression *v = &boundary->velocity, *w = &boundary->rotation;

  PetscFunctionBegin;
  if (!SceneHas(scene, PHYSICS_CONVECTION)) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt a = 0; a < scene->dim; a++)
    UserCheck(!IsSteady(scene, v, a),
              "%s with -motion %s: particles stay where they are, and the body with them; a steady "
              "velocity would carry fluid through its surface; use -motion lagrangian",
              v->option, scene->motion->name);
  for (PetscInt c = 0; c < w->n; c++)
    UserCheck(
        boundary->body.shape->round || !IsSteady(scene, w, c),
        "%s with -motion %s: particles stay where they are, and a %s with them; a steady "
        "rotation would carry fluid through its surface; use -motion lagrangian, or frame in a "
        "round vessel",
        w->option, scene->motion->name, boundary->body.shape->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns true if the motion of a body changes its place or attitude. */
static PetscBool ChangesPlace(const Boundary *boundary)
{
  const PetscBool turns = boundary->rotation.n > 1 || !boundary->body.shape->round;

  return boundary->position.n || ExpressionIsGiven(&boundary->velocity) ||
         (turns && ExpressionIsGiven(&boundary->rotation));
}

/* Reads the motion of body k, or of the domain. Bodies move with particles that move; else their
   surfaces alone. */
static PetscErrorCode ReadBodyMotion(PetscInt k, Scene *scene, Boundary *boundary)
{
  const PetscInt axes = scene->dim == 3 ? 3 : 1;
  char           name[OPTION_LENGTH];
  PetscBool      given, placed;
  OptionRow      row;

  PetscFunctionBegin;
  OptionOf(BODY_VELOCITY, k, name, &row);
  PetscCall(ExpressionGet(scene->scope, &row, scene->dim, scene->dim, EXPRESSION_TIME,
                          &boundary->velocity, &given));
  OptionOf(BODY_POSITION, k, name, &row);
  PetscCall(ExpressionGet(scene->scope, &row, scene->dim, scene->dim, EXPRESSION_TIME,
                          &boundary->position, &placed));
  UserCheck(!given || !placed, "%s and %s: one follows from the other; give one of them",
            boundary->velocity.option, name);
  UserCheck(!placed || SceneMoves(scene),
            "%s: particles stay where they are, and bodies with them; use -motion lagrangian and "
            "convection",
            name);
  OptionOf(BODY_ROTATION, k, name, &row);
  PetscCall(ExpressionGet(scene->scope, &row, 1, axes, EXPRESSION_TIME, &boundary->rotation, NULL));
  UserCheck(boundary->rotation.n != 2, "%s: one rate about z, or three about x, y, z", name);
  if (k) PetscCall(SceneReadMotionFile(scene, k, boundary));
  if (ExpressionUses(&boundary->velocity, EXPRESSION_TIME) ||
      ExpressionUses(&boundary->position, EXPRESSION_TIME) ||
      ExpressionUses(&boundary->rotation, EXPRESSION_TIME))
    scene->unsteady_walls = PETSC_TRUE;
  if (k) PetscCall(SceneReadFreedom(scene, k, boundary));
  boundary->moves = SceneMoves(scene) && (ChangesPlace(boundary) || boundary->free);
  if (!boundary->moves && !(scene->motion && scene->motion->turns))
    PetscCall(CheckSurfaceMotion(scene, boundary));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Moves and turns body k, or the domain, to its place. */
static PetscErrorCode ReadPlace(PetscInt k, Scene *scene, Body *body)
{
  PetscReal number[7] = {0.0}, axis[ISPH_MAX_DIM] = {0.0, 0.0, 1.0}, length = 0.0;
  PetscInt  n;
  PetscBool given;
  char      name[OPTION_LENGTH];
  OptionRow row;
  Pose     *pose;

  PetscFunctionBegin;
  OptionOf(BODY_PLACE, k, name, &row);
  PetscCall(OptionGetReals(&row, 7, number, &n, &given));
  if (!given) PetscFunctionReturn(PETSC_SUCCESS);
  UserCheck(n == scene->dim || n == (scene->dim == 2 ? 3 : 7),
            "%s: it has %" PetscInt_FMT " numbers; way and turn are dx,dy[,degrees], in 3D "
            "dx,dy,dz[,ax,ay,az,degrees]",
            name, n);
  for (PetscInt a = 0; a < 3 && n == 7; a++) axis[a] = number[3 + a];
  for (PetscInt a = 0; a < 3; a++) length += PetscSqr(axis[a]);
  UserCheck(length > 0.0, "%s: the axis 0,0,0 has no direction", name);
  UserCheck(!BodyReachesThrough(body, 2) ||
                (axis[0] == 0.0 && axis[1] == 0.0 && (scene->dim == 2 || number[2] == 0.0)),
            "%s: a %s that reaches through the box stays along z", name, body->shape->name);
  PetscCall(PetscNew(&pose));
  PetscCall(BodyStoreAdd(pose, body->store));
  PoseStart(body, pose);
  for (PetscInt a = 0; a < scene->dim; a++) pose->x[a] += number[a];
  for (PetscInt a = 0; a < 3; a++)
    axis[a] *= number[scene->dim == 2 ? 2 : 6] * PETSC_PI / 180.0 / PetscSqrtReal(length);
  PoseRotate(axis, pose);
  body->pose = pose;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gives the bodies poses, if any of them moves. */
static PetscErrorCode CreatePoses(Scene *scene)
{
  PetscFunctionBegin;
  for (PetscInt k = 0; k < scene->n_bodies; k++) {
    Boundary *boundary = &scene->boundary[SceneBodySide(scene, k)];

    if (!boundary->moves && !boundary->free) continue;
    if (!scene->pose) PetscCall(PetscCalloc1(scene->n_bodies, &scene->pose));
    if (boundary->body.pose) scene->pose[k] = *boundary->body.pose; /* that of its place */
    else PoseStart(&boundary->body, &scene->pose[k]);
    boundary->body.pose = &scene->pose[k];
    BodyGivenPose(scene, SceneBodySide(scene, k), 0.0, &scene->pose[k]);
    BodyGivenMotion(scene, SceneBodySide(scene, k), 0.0, scene->pose[k].u, scene->pose[k].spin);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AddBody(PetscInt k, const Body *body, Scene *scene)
{
  Boundary *boundary = SceneAddBody(scene);

  PetscFunctionBegin;
  boundary->body = *body;
  PetscCall(ReadPlace(k, scene, &boundary->body));
  PetscCall(ReadBodyMotion(k, scene, boundary));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lets a side of the box be no boundary if the domain ends inside it. */
static PetscErrorCode CutSide(const Body *domain, PetscInt side, Scene *scene)
{
  const BoundaryRow *kind  = scene->boundary[side].kind;
  const PetscReal    slack = SCENE_ON_SURFACE * scene->dx;
  PetscReal          span[2];

  PetscFunctionBegin;
  if (BodyReachesThrough(domain, side / 2)) PetscFunctionReturn(PETSC_SUCCESS);
  BodySpan(domain, side / 2, span);
  UserCheck(kind != &BoundaryPeriodic,
            "-scene_domain: it ends along %s, which -scene_periodic excludes; allowed are axes "
            "along which it reaches through the box",
            BoxAxes[side / 2]);
  if (side % 2 ? span[1] > scene->hi[side / 2] + slack : span[0] < scene->lo[side / 2] - slack)
    PetscFunctionReturn(PETSC_SUCCESS);
  UserCheck((side % 2 ? scene->hi[side / 2] - span[1] : span[0] - scene->lo[side / 2]) >=
                LEAST_ROOM * scene->dx,
            "-scene_box: it leaves less than %g dx behind -scene_domain on the %s side; leave "
            "-scene_box out, give more room, or let it cut the domain",
            LEAST_ROOM, BoxSides[side]);
  UserCheck(kind == &BoundaryWall,
            "%s %s: -scene_domain ends inside that side; type it so that it reaches beyond the "
            "side, which cuts it, and give -scene_box",
            kind->option.name, BoxSides[side]);
  SceneSetSide(scene, side, &BoundaryNone);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the shape and the place of the domain; without -scene_box the box has whole cells across
   it, and ROOM of them behind it. */
static PetscErrorCode ReadDomain(PetscBool boxed, Scene *scene, Body *domain, PetscBool *given)
{
  PetscFunctionBegin;
  PetscCall(ShapeRead(scene, &options[VESSEL], 0, -1, domain, given));
  if (!*given) PetscFunctionReturn(PETSC_SUCCESS);
  domain->around = PETSC_TRUE;
  PetscCall(ReadPlace(0, scene, domain));
  for (PetscInt a = 0; !boxed && a < scene->dim; a++) {
    PetscReal span[2], room;

    if (BodyReachesThrough(domain, a)) continue;
    BodySpan(domain, a, span);
    room = (span[1] - span[0]) /
           PetscMax(1.0, PetscFloorReal((span[1] - span[0]) / scene->dx + 0.5)) * ROOM;
    scene->lo[a] = span[0] - room;
    scene->hi[a] = span[1] + room;
  }
  for (PetscInt side = 0; side < SceneBodySide(scene, 0); side++)
    PetscCall(CutSide(domain, side, scene));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses part k if no surface of the domain is in it, or if its velocity would carry fluid through
   the surface. */
static PetscErrorCode CheckPart(const Scene *scene, PetscInt k)
{
  const PetscInt     side  = SceneBodySide(scene, scene->n_bodies - 1);
  const Body        *body  = BoundaryBody(scene, side);
  const SurfacePart *part  = &scene->part[k - 1];
  PetscInt           found = 0;

  PetscFunctionBegin;
  for (PetscInt q = 0; q < BodyPoints(body, FINE * scene->dx); q++) {
    PetscReal x[ISPH_MAX_DIM], normal[ISPH_MAX_DIM];

    (void)BodyPoint(body, q, FINE * scene->dx, x, normal);
    if (ScenePart(scene, x) != part) continue;
    found++;
    for (PetscInt m = 0; m < SAMPLES; m++) {
      const PetscReal t       = 0.37 * m * scene->length / scene->speed;
      PetscReal       through = 0.0, size = 0.0;
      char            place[PLACE_TEXT];

      for (PetscInt a = 0; a < scene->dim; a++) {
        const PetscReal u = ExpressionValue(&part->velocity, a, t, x);

        through += u * normal[a];
        size = PetscMax(size, PetscAbsReal(u));
      }
      UserCheck(PetscAbsReal(through) <= ALONG * size,
                "%s: at (%s) it is %.3g m/s through the surface; velocities along the surface "
                "alone are allowed; fluid enters through -scene_inflow",
                part->velocity.option, ScenePlaceText(scene, x, place), (double)through);
    }
  }
  UserCheck(found, "-scene_part_%" PetscInt_FMT ": no surface of -scene_domain is in it", k);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads parts 1, 2, ... of the surface of the domain. */
static PetscErrorCode ReadParts(Scene *scene)
{
  const PetscInt  side = SceneBodySide(scene, scene->n_bodies - 1);
  const Boundary *last = scene->n_bodies ? &scene->boundary[side] : NULL;
  PetscBool       given;

  PetscFunctionBegin;
  for (PetscInt k = 1; k <= SCENE_MAX_PARTS; k++) {
    SurfacePart *part = &scene->part[k - 1];
    char         name[OPTION_LENGTH];
    OptionRow    row;

    PetscCall(ShapeRead(scene, &options[PART], k, -1, &part->shape, &given));
    if (!given) break;
    UserCheck(last && last->body.around && !last->moves && !(scene->motion && scene->motion->turns),
              "-scene_part_%" PetscInt_FMT ": it is for the walls of -scene_domain, which stay in "
              "their place",
              k);
    OptionNumber(&options[PART_VELOCITY], k, name, &row);
    PetscCall(ExpressionGet(scene->scope, &row, scene->dim, scene->dim,
                            EXPRESSION_PLACE | EXPRESSION_TIME, &part->velocity, &given));
    UserCheck(given, "%s: the velocity of this part is required [m/s]", name);
    if (ExpressionUses(&part->velocity, EXPRESSION_TIME)) scene->unsteady_walls = PETSC_TRUE;
    scene->n_parts = k;
  }
  PetscCall(ShapeCheckNumbers(&options[PART], scene->n_parts, SCENE_MAX_PARTS));
  for (PetscInt k = 1; k <= scene->n_parts; k++) PetscCall(CheckPart(scene, k));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SceneReadBodies - Reads bodies 1, 2, ..., the domain, and the parts of its surface; an option of
   a body may list several, which are numbered on. Collective. Input: boxed - -scene_box is given;
   otherwise the box follows from the domain. The options are those of SceneReadTyped(). */
PetscErrorCode SceneReadBodies(PetscBool boxed, Scene *scene)
{
  PetscInt  first = 1, place = 0; /* the option, and the shape in its list */
  PetscBool given = PETSC_TRUE, has_domain;
  Body      domain;

  PetscFunctionBegin;
  PetscCall(ReadDomain(boxed, scene, &domain, &has_domain));
  while (given || place) {
    Body body;

    if (!given) {
      first = scene->n_bodies + 1;
      place = 0;
    }
    PetscCall(ShapeRead(scene, &options[BODY], first, place, &body, &given));
    if (!given) continue;
    PetscCall(AddBody(scene->n_bodies + 1, &body, scene));
    place++;
  }
  PetscCall(ShapeCheckNumbers(&options[BODY], scene->n_bodies, 0));
  if (has_domain) PetscCall(AddBody(0, &domain, scene));
  UserCheck(boxed || !has_domain || !scene->boundary[SceneBoundaries(scene) - 1].moves,
            "-scene_domain: it moves, and the box of its particles stays; give -scene_box with "
            "room for all its places");
  PetscCall(CreatePoses(scene));
  PetscCall(ReadParts(scene));
  PetscFunctionReturn(PETSC_SUCCESS);
}
