/*
  Scenes typed on the command line: the box, its sides and bodies, velocities and a reference
  solution. All options are checked before any particle exists.
*/
#include "isph/scene.h"

enum {
  BOX,
  WALL_VELOCITY,
  BODY,
  BODY_PLACE,
  BODY_VELOCITY,
  BODY_POSITION,
  BODY_ROTATION,
  BODY_AROUND,
  FILLED,
  FLUID,
  FLUID_VISCOSITY,
  VISCOSITY_FIELD,
  START_VELOCITY,
  EXACT
};
static const OptionRow options[] = {
    [BOX] =
        {
            .name     = "-scene_box",
            .kind     = VALUE_REALS,
            .brief    = "corners of the box, x0,y0,x1,y1; in 3D x0,y0,z0,x1,y1,z1",
            .unit     = "m",
            .standard = "0,0,L,L; 0,0,0,L,L,L",
            .where    = "-case scene",
        },
    [WALL_VELOCITY] =
        {
            .name     = "-scene_wall_<side>_velocity",
            .kind     = VALUE_EXPRESSION,
            .brief    = "velocity u,v[,w] of a side of the box, of x, y[, z], t",
            .unit     = "m/s",
            .standard = "0; of an inflow that of -scene_exact; of an outflow none",
            .places   = BoxSides,
            .where    = "-case scene, sides that are walls, inflows or outflows",
        },
    [BODY] =
        {
            .name  = "-scene_body_<k>",
            .kind  = VALUE_SHAPE,
            .brief = "a solid body: circle,cx,cy,r or box,x0,y0,x1,y1 or polygon,x0,y0,...; in 3D "
                     "ball,cx,cy,cz,r or box,x0,y0,z0,x1,y1,z1 or revolved,r0,z0,... about the "
                     "axis z or, through the box along z, cylinder,cx,cy,r or prism,x0,y0,...; "
                     "more shapes: -catalogue; shapes with ' + ', ' - ' or ' & ' between are "
                     "added, cut away or intersected in their order; several bodies may be listed "
                     "with semicolons; "
                     "bodies are numbered 1, 2, ...",
            .unit  = "m",
            .table = &ShapeTable,
            .table_3d = &SolidTable,
            .where    = "-case scene",
        },
    [BODY_PLACE] =
        {
            .name     = "-scene_body_<k>_place",
            .kind     = VALUE_REALS,
            .brief    = "way of a body from where its shape was typed, and turn about its centre: "
                        "dx,dy[,degrees]; in 3D dx,dy,dz[,ax,ay,az,degrees] about ax,ay,az",
            .unit     = "m",
            .standard = "0",
            .where    = "-case scene, bodies that are given",
        },
    [BODY_VELOCITY] =
        {
            .name     = "-scene_body_<k>_velocity",
            .kind     = VALUE_EXPRESSION,
            .brief    = "velocity u,v[,w] of a body, of t; the body moves if particles move, and "
                        "else its surface alone has this velocity",
            .unit     = "m/s",
            .standard = "0",
            .where    = "-case scene, bodies that are given",
        },
    [BODY_POSITION] =
        {
            .name  = "-scene_body_<k>_position",
            .kind  = VALUE_EXPRESSION,
            .brief = "position x,y[,z] of the centre of a body that moves, of t, in place of its "
                     "velocity",
            .unit  = "m",
            .standard = "from the shape and the velocity",
            .where    = "-case scene, bodies that are given, particles that move",
        },
    [BODY_ROTATION] =
        {
            .name  = "-scene_body_<k>_rotation",
            .kind  = VALUE_EXPRESSION,
            .brief = "rotation rate of a body about its centre, of t: about z, in 3D also about x, "
                     "y, z",
            .unit  = "rad/s",
            .standard = "0",
            .where    = "-case scene, bodies that are given",
        },
    [BODY_AROUND] =
        {
            .name = "-scene_body_<k>_around",
            .kind = VALUE_SWITCH,
            .brief =
                "the fluid is inside the body; the sides of the box beyond it are then no walls",
            .standard = "false",
            .table    = &BoundaryTable,
            .where    = "-case scene, bodies that are given",
        },
    [FILLED] =
        {
            .name  = "-scene_filled_<k>",
            .kind  = VALUE_SHAPE,
            .brief = "region that the fluid fills at the start, a shape as of bodies; the rest of "
                     "the box is empty, and its border is a free surface where it is inside the "
                     "box; regions are numbered 1, 2, ... and may overlap",
            .unit  = "m",
            .standard = "the whole box",
            .table    = &ShapeTable,
            .table_3d = &SolidTable,
            .where    = "-case scene",
        },
    [FLUID] =
        {
            .name     = "-scene_fluid_<k>",
            .kind     = VALUE_SHAPE,
            .brief    = "region of another fluid at the start, a shape as of bodies; fluids are "
                        "numbered 1, 2, ..., and a later region covers an earlier one",
            .unit     = "m",
            .table    = &ShapeTable,
            .table_3d = &SolidTable,
            .where    = "-case scene",
        },
    [FLUID_VISCOSITY] =
        {
            .name  = "-scene_fluid_<k>_viscosity",
            .kind  = VALUE_REAL,
            .brief = "kinematic viscosity of another fluid; must be given",
            .unit  = "m^2/s",
            POSITIVE,
            .where = "-case scene, fluids that are given",
        },
    [VISCOSITY_FIELD] =
        {
            .name     = "-viscosity_field",
            .kind     = VALUE_EXPRESSION,
            .brief    = "kinematic viscosity outside the regions of other fluids, of x, y[, z]",
            .unit     = "m^2/s",
            .standard = "-viscosity",
            .where    = "-case scene",
        },
    [START_VELOCITY] =
        {
            .name     = "-scene_velocity",
            .kind     = VALUE_EXPRESSION,
            .brief    = "velocity u,v[,w] at the start, of x, y[, z]",
            .unit     = "m/s",
            .standard = "-scene_exact at t = 0, or rest",
            .where    = "-case scene",
        },
    [EXACT] =
        {
            .name = "-scene_exact",
            .kind = VALUE_EXPRESSION,
            .brief =
                "reference solution u,v[,w][,p], of x, y[, z], t: the flow starts from it, and "
                "errors are reported",
            .unit  = "m/s, Pa",
            .where = "-case scene",
        },
};
const OptionTable TypedOptions = OPTIONS("Typed scenes", options);

/* Returns true if component c of an expression of t is not zero and keeps its value, 1+0*t. */
static PetscBool IsSteady(const Scene *scene, const Expression *e, PetscInt c)
{
  const PetscReal first = ExpressionValue(e, c, 0.0, NULL);

  for (PetscInt k = 1; k < 8; k++) {
    if (ExpressionValue(e, c, 0.37 * k * scene->length / scene->speed, NULL) != first)
      return PETSC_FALSE;
  }
  return first != 0.0;
}

/* Returns true if a component of an expression of t is not always zero. */
static PetscBool IsGiven(const Expression *e)
{
  for (PetscInt c = 0; c < e->n; c++)
    if (e->uses[c] || e->value[c] != 0.0) return PETSC_TRUE;
  return PETSC_FALSE;
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

  return boundary->position.n || IsGiven(&boundary->velocity) ||
         (turns && IsGiven(&boundary->rotation));
}

/* Reads the motion of body k. Bodies move with particles that move; else their surfaces alone. */
static PetscErrorCode ReadBodyMotion(PetscInt k, Scene *scene, Boundary *boundary)
{
  const PetscInt axes = scene->dim == 3 ? 3 : 1;
  char           name[OPTION_LENGTH];
  PetscBool      given, placed;
  OptionRow      row;

  PetscFunctionBegin;
  OptionNumber(&options[BODY_VELOCITY], k, name, &row);
  PetscCall(ExpressionGet(scene->scope, &row, scene->dim, scene->dim, EXPRESSION_TIME,
                          &boundary->velocity, &given));
  OptionNumber(&options[BODY_POSITION], k, name, &row);
  PetscCall(ExpressionGet(scene->scope, &row, scene->dim, scene->dim, EXPRESSION_TIME,
                          &boundary->position, &placed));
  UserCheck(!given || !placed, "%s and %s: one follows from the other; give one of them",
            boundary->velocity.option, name);
  UserCheck(!placed || SceneMoves(scene),
            "%s: particles stay where they are, and bodies with them; use -motion lagrangian and "
            "convection",
            name);
  OptionNumber(&options[BODY_ROTATION], k, name, &row);
  PetscCall(ExpressionGet(scene->scope, &row, 1, axes, EXPRESSION_TIME, &boundary->rotation, NULL));
  UserCheck(boundary->rotation.n != 2, "%s: one rate about z, or three about x, y, z", name);
  PetscCall(SceneReadMotionFile(scene, k, boundary));
  if (ExpressionUses(&boundary->velocity, EXPRESSION_TIME) ||
      ExpressionUses(&boundary->position, EXPRESSION_TIME) ||
      ExpressionUses(&boundary->rotation, EXPRESSION_TIME))
    scene->unsteady_walls = PETSC_TRUE;
  PetscCall(SceneReadFreedom(scene, k, boundary));
  boundary->moves = SceneMoves(scene) && (ChangesPlace(boundary) || boundary->free);
  if (!boundary->moves && !(scene->motion && scene->motion->turns))
    PetscCall(CheckSurfaceMotion(scene, boundary));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Moves and turns body k to its place. */
static PetscErrorCode ReadPlace(PetscInt k, Scene *scene, Body *body)
{
  PetscReal number[7] = {0.0}, axis[ISPH_MAX_DIM] = {0.0, 0.0, 1.0}, length = 0.0;
  PetscInt  n;
  PetscBool given;
  char      name[OPTION_LENGTH];
  OptionRow row;
  Pose     *pose;

  PetscFunctionBegin;
  OptionNumber(&options[BODY_PLACE], k, name, &row);
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

/* Gives the bodies poses, if one of them moves. */
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

/* Adds body k, with all that is given of it. */
static PetscErrorCode AddBody(PetscInt k, const Body *body, Scene *scene)
{
  Boundary *boundary = SceneAddBody(scene);
  char      name[OPTION_LENGTH];
  OptionRow row;

  PetscFunctionBegin;
  boundary->body = *body;
  PetscCall(ReadPlace(k, scene, &boundary->body));
  OptionNumber(&options[BODY_AROUND], k, name, &row);
  PetscCall(OptionGetSwitch(&row, &boundary->body.around, NULL));
  PetscCall(ReadBodyMotion(k, scene, boundary));
  for (PetscInt side = 0; boundary->body.around && side < SceneBodySide(scene, 0); side++) {
    const BoundaryRow *kind = scene->boundary[side].kind;

    if (!BoundaryIs(scene, side, BOUNDARY_PARTICLES)) continue;
    if (BodyReachesThrough(&boundary->body, side / 2)) continue;
    UserCheck(kind == &BoundaryWall,
              "%s: the sides of the box are then in the solid, which "
              "excludes %s",
              name, kind->option.name);
    SceneSetSide(scene, side, &BoundaryNone);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads bodies 1, 2, ...; an option may list several, which are numbered on. */
static PetscErrorCode ReadBodies(Scene *scene)
{
  PetscInt  first = 1, place = 0; /* the option, and the shape in its list */
  PetscBool given = PETSC_TRUE;

  PetscFunctionBegin;
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
  PetscCall(CreatePoses(scene));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the kinds of the sides of the box from the options in BoundaryTable; default: wall. */
static PetscErrorCode ReadKinds(Scene *scene)
{
  PetscFunctionBegin;
  for (PetscInt k = 0; k < BoundaryTable.count; k++) {
    const BoundaryRow *kind    = (const BoundaryRow *)(const void *)TableGet(&BoundaryTable, k);
    const PetscBool    by_axis = kind->option.words == BoxAxes;
    unsigned           chosen;

    if (!kind->option.name) continue;
    PetscCall(OptionGetFlags(&kind->option, &chosen));
    for (PetscInt side = 0; side < 2 * ISPH_MAX_DIM; side++) {
      const BoundaryRow *before = scene->boundary[side].kind;

      if (!(chosen & (1u << (by_axis ? side / 2 : side)))) continue;
      UserCheck(side < 2 * scene->dim, "%s: %s is of a box in 3D; use -dim 3", kind->option.name,
                by_axis ? BoxAxes[side / 2] : BoxSides[side]);
      UserCheck(before == &BoundaryWall, "%s and %s: both name the %s side", before->option.name,
                kind->option.name, BoxSides[side]);
      SceneSetSide(scene, side, kind);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the flow at the start and the reference solution. */
static PetscErrorCode ReadFields(Scene *scene)
{
  const PetscInt dim = scene->dim;

  PetscFunctionBegin;
  PetscCall(ExpressionGet(scene->scope, &options[START_VELOCITY], dim, dim, EXPRESSION_PLACE,
                          &scene->velocity, NULL));
  PetscCall(ExpressionGet(scene->scope, &options[EXACT], dim, dim + 1,
                          EXPRESSION_PLACE | EXPRESSION_TIME, &scene->exact, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the velocities of the sides of the box that give one. An outflow with a given velocity is
   an inflow; an inflow has that of the reference solution if it gives none. */
static PetscErrorCode ReadSides(Scene *scene)
{
  PetscFunctionBegin;
  for (PetscInt side = 0; side < 2 * scene->dim; side++) {
    Expression    *v      = &scene->boundary[side].velocity;
    const PetscInt normal = side / 2;
    char           name[OPTION_LENGTH];
    PetscBool      given;
    OptionRow      row;

    if (!BoundaryIs(scene, side, BOUNDARY_PARTICLES | BOUNDARY_NO_SLIP) &&
        !BoundaryIs(scene, side, BOUNDARY_OUTFLOW))
      continue;
    OptionFill(&options[WALL_VELOCITY], BoxSides[side], name, &row);
    PetscCall(ExpressionGet(scene->scope, &row, scene->dim, scene->dim,
                            EXPRESSION_PLACE | EXPRESSION_TIME, v, &given));
    if (given && BoundaryIs(scene, side, BOUNDARY_OUTFLOW))
      SceneSetSide(scene, side, &BoundaryInflow);
    if (!given && BoundaryIs(scene, side, BOUNDARY_INFLOW)) *v = scene->exact;
    UserCheck(v->n || !BoundaryIs(scene, side, BOUNDARY_INFLOW),
              "-scene_inflow %s: give the velocity of the fluid that enters by %s, or -scene_exact",
              BoxSides[side], name);
    if (ExpressionUses(v, EXPRESSION_TIME)) scene->unsteady_walls = PETSC_TRUE;
    UserCheck(!SceneHas(scene, PHYSICS_CONVECTION) || !BoundaryIs(scene, side, BOUNDARY_CONFINES) ||
                  (!v->uses[normal] && v->value[normal] == 0.0),
              "%s: %c is normal to that side and must be 0: with convection fluid enters through "
              "-scene_inflow only",
              name, "uvw"[normal]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the regions 1, 2, ... that the fluid fills at the start. */
static PetscErrorCode ReadFilled(Scene *scene)
{
  PetscBool given = PETSC_TRUE;

  PetscFunctionBegin;
  for (PetscInt k = 1; k <= SCENE_MAX_FILLED; k++) {
    Body body;

    PetscCall(ShapeRead(scene, &options[FILLED], k, -1, &body, &given));
    if (!given) break;
    UserCheck(BodyLoops(&body) == 1,
              "-scene_filled_%" PetscInt_FMT ": its border has %" PetscInt_FMT
              " loops; type them as regions of their own, or a hole as a region of another fluid",
              k, BodyLoops(&body));
    *SceneAddFilled(scene) = body;
  }
  PetscCall(ShapeCheckNumbers(&options[FILLED], scene->n_filled, SCENE_MAX_FILLED));
  PetscCall(SceneCheckFilled(scene));
  SceneDropFullRegions(scene);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads fluids 1, 2, ... and the viscosity elsewhere. */
static PetscErrorCode ReadFluids(Scene *scene)
{
  PetscBool given;

  PetscFunctionBegin;
  PetscCall(ExpressionGet(scene->scope, &options[VISCOSITY_FIELD], 1, 1, EXPRESSION_PLACE,
                          &scene->nu_field, NULL));
  for (PetscInt k = 1; k <= SCENE_MAX_FLUIDS; k++) {
    PetscReal *nu = &scene->region_nu[scene->n_regions];
    char       name[OPTION_LENGTH];
    OptionRow  row;

    PetscCall(ShapeRead(scene, &options[FLUID], k, -1, &scene->region[scene->n_regions], &given));
    if (!given) break;
    OptionNumber(&options[FLUID_VISCOSITY], k, name, &row);
    PetscCall(OptionGetReal(&row, nu, &given));
    UserCheck(given, "%s: the fluid's kinematic viscosity is required [m^2/s]", name);
    scene->n_regions++;
  }
  PetscCall(ShapeCheckNumbers(&options[FLUID], scene->n_regions, SCENE_MAX_FLUIDS));
  UserCheck(
      SceneIsNewtonian(scene) || (!scene->n_regions && !scene->nu_field.n),
      "-rheology %s with -scene_fluid_1 or -viscosity_field: viscosity follows the strain rate or "
      "the place, not both",
      scene->rheology.row->name);
  UserCheck(!SceneViscosityVaries(scene) || SceneHas(scene, PHYSICS_VISCOSITY),
            "-without viscosity: there are fluids of other viscosity");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  SceneReadTyped - Reads the scene of -case scene

  Collective.

  Options Database Keys:
+ -scene_box x0,y0,x1,y1           - corners [m]; by default 0,0,L,L; in 3D of 6 numbers
. -scene_periodic x,y,z            - axes that are periodic
. -scene_symmetry left,...         - sides in which the flow mirrors itself
. -scene_inflow left,...           - sides through which fluid enters, see SceneReadOpenings()
. -scene_outflow right,...         - sides through which fluid leaves
. -scene_wall_<side>_velocity u,v  - velocity of a side of the box [m/s] (x, y, t)
. -scene_body_<k> shape,...        - shape of body 1, 2, ... [m]
. -scene_body_<k>_place dx,dy,w    - way from there [m], and turn about the centre [degrees]
. -scene_body_<k>_velocity u,v     - velocity of the body, or of its surface [m/s] (t)
. -scene_body_<k>_position x,y     - position of its centre, in place of the velocity [m] (t)
. -scene_body_<k>_rotation w       - angular velocity about its centre [rad/s] (t)
. -scene_body_<k>_around           - the fluid is inside the body; sides beyond it are no walls
. -scene_filled_<k> shape,...      - region that the fluid fills at the start [m]
. -scene_fluid_<k> shape,...       - region of fluid 1, 2, ... at the start [m]
. -scene_fluid_<k>_viscosity nu    - kinematic viscosity of this fluid [m^2/s]
. -viscosity_field nu              - kinematic viscosity outside these regions [m^2/s] (x, y)
. -scene_velocity u,v              - velocity at the start [m/s] (x, y)
- -scene_exact u,v[,p]             - reference solution [m/s], [Pa] (x, y, t)

  Notes: brackets give the variables that an expression may contain, see ExpressionSet(); in 3D
  velocities have a third component, and expressions of x and y may contain z. The option
  of each kind of boundary stands in its row of BoundaryTable. A periodic box without bodies has no
  walls, so the physics `walls` is off.

  Errors: wrong shapes, bodies that overlap or leave gaps of less than 4 dx, expressions with wrong
  syntax, and velocities through a surface end the run
*/
PetscErrorCode SceneReadTyped(Scene *scene)
{
  const PetscInt dim                   = scene->dim;
  PetscReal      box[2 * ISPH_MAX_DIM] = {0.0};
  PetscInt       n;
  PetscBool      given;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < dim; a++) box[dim + a] = scene->length;
  PetscCall(OptionGetReals(&options[BOX], 2 * ISPH_MAX_DIM, box, &n, &given));
  UserCheck(!given || n == 2 * dim,
            "-scene_box: %" PetscInt_FMT " numbers are required with -dim %" PetscInt_FMT
            ", got %" PetscInt_FMT,
            2 * dim, dim, n);
  for (PetscInt a = 0; a < dim; a++) {
    scene->lo[a] = box[a];
    scene->hi[a] = box[dim + a];
    UserCheck(box[dim + a] - box[a] >= 4.0 * SceneCoarsest(scene),
              "-scene_box: it is %.4g wide along %s; at least 4 dx = %.4g is allowed",
              (double)(box[dim + a] - box[a]), BoxAxes[a], (double)(4.0 * SceneCoarsest(scene)));
  }
  PetscCall(ReadKinds(scene));
  PetscCall(ReadBodies(scene));
  PetscCall(ReadFields(scene));
  PetscCall(ReadSides(scene));
  PetscCall(SceneReadFrame(scene));
  PetscCall(SceneReadOpenings(scene));
  if (!SceneHasBoundary(scene, BOUNDARY_PARTICLES)) scene->physics &= ~(unsigned)PHYSICS_WALLS;
  PetscCall(ReadFilled(scene));
  PetscCall(SceneCheckVelocities(scene, 0.125 * scene->length / scene->speed)); /* from rest */
  PetscCall(SceneCheckInflow(scene, 0.0));
  PetscCall(ReadFluids(scene));
  PetscCall(SceneCheckFluids(scene));
  PetscFunctionReturn(PETSC_SUCCESS);
}
