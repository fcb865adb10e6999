/* Scenes typed on the command line: the box, its sides and bodies, velocities and a reference
   solution. All options are checked before any particle exists. Bodies are in typedbodies.c. */
#include "isph/scene.h"

enum {
  BOX,
  WALL_VELOCITY,
  FREE,
  WALL_ANGLE,
  FILLED,
  FLUID,
  FLUID_VISCOSITY,
  FLUID_DENSITY,
  FLUID_TENSION,
  VISCOSITY_FIELD,
  TENSION_FIELD,
  START_VELOCITY,
  EXACT
};
static const OptionRow options[] = {
    [BOX] = OPTION(REALS, "-scene_box", "corners of the box, x0,y0,x1,y1; in 3D x0,y0,z0,x1,y1,z1",
                   "m", "0,0,L,L; 0,0,0,L,L,L", .where = "-case scene"),
    [WALL_VELOCITY] =
        OPTION(EXPRESSION, "-scene_wall_<side>_velocity",
               "velocity u,v[,w] of a side of the box, of x, y[, z], t", "m/s",
               "0; of an inflow that of -scene_exact; of an outflow none", .places = BoxSides,
               .where = "-case scene, sides that are walls, inflows or outflows"),
    [FREE]       = OPTION(NAMES, "-scene_free",
                          "sides of the box that are free surfaces at the start; the box goes "
                                "on for its "
                                "own length beyond them, and is empty there",
                          NULL, NULL, .words = BoxSides, .where = "-case scene"),
    [WALL_ANGLE] = OPTION(
        REAL, "-scene_wall_<side>_angle",
        "contact angle of the free surface with a side of the box, in the fluid", "degrees", "90",
        .low = 30.0, .high = 150.0, .places = BoxSides,
        .where =
            "-case scene, sides that are walls, -surface_tension and -visc_laplacian weak_stress"),
    [FILLED] = OPTION(SHAPE, "-scene_filled_<k>",
                      "region that the fluid fills at the start, a shape as of bodies; the rest of "
                      "the box is empty, and its border is a free surface where it is inside the "
                      "box; regions are numbered 1, 2, ... and may overlap",
                      "m", "the whole box", .table = &ShapeTable, .table_3d = &SolidTable,
                      .where = "-case scene"),
    [FLUID] =
        OPTION(SHAPE, "-scene_fluid_<k>",
               "region of another fluid at the start, a shape as of bodies; fluids are numbered 1, "
               "2, ..., and a later region covers an earlier one",
               "m", NULL, .table = &ShapeTable, .table_3d = &SolidTable, .where = "-case scene"),
    [FLUID_VISCOSITY] =
        OPTION(REAL, "-scene_fluid_<k>_viscosity", "kinematic viscosity of another fluid", "m^2/s",
               "-viscosity; must be given unless a density or a tension is", POSITIVE,
               .where = "-case scene, fluids that are given"),
    [FLUID_DENSITY] = OPTION(REAL, "-scene_fluid_<k>_density", "density of another fluid", "kg/m^3",
                             "-density", POSITIVE, .where = "-case scene, fluids that are given"),
    [FLUID_TENSION] = OPTION(
        REAL, "-scene_fluid_<k>_tension",
        "tension of the surface between this fluid and all others; it meets walls at 90 degrees",
        "N/m", "0", POSITIVE, .where = "-case scene, fluids that are given"),
    [VISCOSITY_FIELD] =
        OPTION(EXPRESSION, "-viscosity_field",
               "kinematic viscosity outside the regions of other fluids, of x, y[, z] and the "
               "scalars; of t and the strain rate g too, if there are no such regions",
               "m^2/s", "-viscosity", .where = "-case scene"),
    [TENSION_FIELD] =
        OPTION(EXPRESSION, "-surface_tension_field",
               "tension of the free surface, of x, y[, z], t and the scalars, which pulls along it "
               "where it varies (Marangoni); -surface_tension is its largest value",
               "N/m", "-surface_tension", .where = "-case scene, free surfaces with a tension"),
    [START_VELOCITY] =
        OPTION(EXPRESSION, "-scene_velocity", "velocity u,v[,w] at the start, of x, y[, z]", "m/s",
               "-scene_exact at t = 0, or rest", .where = "-case scene"),
    [EXACT] = OPTION(EXPRESSION, "-scene_exact",
                     "reference solution u,v[,w][,p], of x, y[, z], t: the flow starts from it, "
                     "and errors are reported",
                     "m/s, Pa", NULL, .where = "-case scene"),
};
const OptionTable TypedOptions = OPTIONS("Typed scenes", options);

/* Reads the kinds of the sides of the box from the options in BoundaryTable; default: wall. */
static PetscErrorCode ReadKinds(Scene *scene)
{
  PetscFunctionBegin;
  for (PetscInt k = 0; k < BoundaryTable.count; k++) {
    const BoundaryRow *kind    = (const BoundaryRow *)(const void *)TableGet(&BoundaryTable, k);
    const PetscBool    by_axis = kind->option.words == BoxAxes;
    unsigned           chosen;

    if (!kind->option.words) continue;
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

/* Reads the sides that are free surfaces at the start. */
static PetscErrorCode ReadFree(Scene *scene)
{
  unsigned chosen;

  PetscFunctionBegin;
  PetscCall(OptionGetFlags(&options[FREE], &chosen));
  for (PetscInt side = 0; side < 2 * ISPH_MAX_DIM; side++) {
    const BoundaryRow *before = scene->boundary[side].kind;

    if (!(chosen >> side & 1)) continue;
    UserCheck(side < 2 * scene->dim, "%s: %s is of a box in 3D; use -dim 3", options[FREE].name,
              BoxSides[side]);
    UserCheck(before == &BoundaryWall, "%s and %s: both name the %s side", before->option.name,
              options[FREE].name, BoxSides[side]);
  }
  SceneFillUpTo(scene, chosen);
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

/* Reads how a wall of the box meets fluid: its slip length, and its angle with a free surface. */
static PetscErrorCode ReadContact(Scene *scene, PetscInt side)
{
  Boundary *wall  = &scene->boundary[side];
  PetscReal angle = 90.0;
  char      name[OPTION_LENGTH];
  PetscBool given;
  OptionRow row;

  PetscFunctionBegin;
  OptionFill(&options[WALL_ANGLE], BoxSides[side], name, &row);
  PetscCall(OptionGetReal(&row, &angle, NULL));
  wall->contact = angle == 90.0 ? 0.0 : PetscCosReal(angle * PETSC_PI / 180.0);
  OptionFill(&BoundarySlip.option, BoxSides[side], name, &row);
  PetscCall(OptionGetReal(&row, &wall->slip, &given));
  if (given) wall->kind = &BoundarySlip;
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
    if (BoundaryIs(scene, side, BOUNDARY_CONFINES)) PetscCall(ReadContact(scene, side));
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
  const PetscInt sides = scene->n_filled;
  PetscBool      given = PETSC_TRUE;

  PetscFunctionBegin;
  for (PetscInt k = 1; k <= SCENE_MAX_FILLED; k++) {
    Body body;

    PetscCall(ShapeRead(scene, &options[FILLED], k, -1, &body, &given));
    if (!given) break;
    UserCheck(!sides, "-scene_free: the borders of -scene_filled_1 are the free surface; leave "
                      "-scene_free out");
    UserCheck(BodyLoops(&body) == 1,
              "-scene_filled_%" PetscInt_FMT ": its border has %" PetscInt_FMT
              " loops; type them as regions of their own, or a hole as a region of another fluid",
              k, BodyLoops(&body));
    *SceneAddFilled(scene) = body;
  }
  PetscCall(ShapeCheckNumbers(&options[FILLED], scene->n_filled - sides, SCENE_MAX_FILLED));
  PetscCall(SceneCheckFilled(scene));
  SceneDropFullRegions(scene);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadFluid(PetscInt k, Scene *scene)
{
  PetscReal *nu  = &scene->region_nu[k - 1];
  PetscReal  rho = scene->rho;
  PetscBool  viscous, dense, tense;
  char       name[OPTION_LENGTH];
  OptionRow  row;

  PetscFunctionBegin;
  OptionNumber(&options[FLUID_DENSITY], k, name, &row);
  PetscCall(OptionGetReal(&row, &rho, &dense));
  OptionNumber(&options[FLUID_TENSION], k, name, &row);
  PetscCall(OptionGetReal(&row, &scene->region_tension[k - 1], &tense));
  OptionNumber(&options[FLUID_VISCOSITY], k, name, &row);
  *nu = scene->nu;
  PetscCall(OptionGetReal(&row, nu, &viscous));
  UserCheck(viscous || dense || tense, "%s: the fluid's kinematic viscosity is required [m^2/s]",
            name);
  scene->region_density[k - 1] = rho / scene->rho;
  *nu *= scene->region_density[k - 1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads fluids 1, 2, ... and the viscosity elsewhere. */
static PetscErrorCode ReadFluids(Scene *scene)
{
  PetscBool given;

  PetscFunctionBegin;
  PetscCall(
      ExpressionGet(scene->scope, &options[VISCOSITY_FIELD], 1, 1,
                    EXPRESSION_PLACE | EXPRESSION_TIME | EXPRESSION_FIELDS | EXPRESSION_STRAIN,
                    &scene->nu_field, NULL));
  PetscCall(ExpressionGet(scene->scope, &options[TENSION_FIELD], 1, 1,
                          EXPRESSION_PLACE | EXPRESSION_TIME | EXPRESSION_FIELDS,
                          &scene->tension_field, NULL));
  for (PetscInt k = 1; k <= SCENE_MAX_FLUIDS; k++) {
    PetscCall(ShapeRead(scene, &options[FLUID], k, -1, &scene->region[scene->n_regions], &given));
    if (!given) break;
    PetscCall(ReadFluid(k, scene));
    scene->n_regions++;
  }
  PetscCall(ShapeCheckNumbers(&options[FLUID], scene->n_regions, SCENE_MAX_FLUIDS));
  PetscCall(SceneTypeRheology(scene));
  UserCheck(SceneIsNewtonian(scene) ||
                (!scene->n_regions && (!scene->nu_field.n || scene->rheology.typed)),
            "-rheology %s with -scene_fluid_1 or -viscosity_field: type the whole viscosity of one "
            "fluid as -viscosity_field, of x, y, t, the scalars and the strain rate g",
            scene->rheology.row->name);
  UserCheck(!SceneViscosityVaries(scene) || SceneHas(scene, PHYSICS_VISCOSITY),
            "-without viscosity: there are fluids of other viscosity");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses a box that has no room for particles. */
static PetscErrorCode CheckWidth(const Scene *scene)
{
  PetscFunctionBegin;
  for (PetscInt a = 0; a < scene->dim; a++)
    UserCheck(scene->hi[a] - scene->lo[a] >= 4.0 * SceneCoarsest(scene),
              "-scene_box: it is %.4g wide along %s; at least 4 dx = %.4g is allowed; -n counts "
              "along -length, %.4g m",
              (double)(scene->hi[a] - scene->lo[a]), BoxAxes[a],
              (double)(4.0 * SceneCoarsest(scene)), (double)scene->length);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SceneReadTyped - Reads the scene of -case scene. Collective. Notes: brackets give the variables
   that an expression may contain, see ExpressionSet(); in 3D velocities have a third component, and
   expressions of x and y may contain z. The option of each kind of boundary stands in its row of
   BoundaryTable. A periodic box without bodies has no walls, so the physics `walls` is off. */
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
  }
  PetscCall(CheckWidth(scene));
  PetscCall(ReadKinds(scene));
  PetscCall(ReadFree(scene));
  PetscCall(SceneReadBodies(given, scene));
  PetscCall(CheckWidth(scene));
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
