/* Creates a checked Scene from options: chooses the case, switches physics, reads numbers and
   refuses impossible values. Nothing here depends on particles or solvers. */
#include "isph/scene.h"

enum {
  DIM,
  RESOLUTION,
  LENGTH,
  SPEED,
  REYNOLDS,
  VISCOSITY,
  DENSITY,
  TENSION,
  SURFACE_PRESSURE,
  BODY_FORCE,
  WITH,
  WITHOUT,
  MOTION,
  JITTER,
  SEED,
  SOLID_FRACTION,
  PATCH_MARGIN
};
static const OptionRow options[] = {
    [DIM] = OPTION(INT, "-dim", "dimension of space; 3 in some cases only", NULL, "2", .low = 2,
                   .high = 3),
    [RESOLUTION] = OPTION(INT, "-n", "particles along the reference length, dx = L/n", NULL,
                          "of the case", .low = 4, .high = 100000),
    [LENGTH] = OPTION(REAL, "-length", "reference length L", "m", "1", .also = " L ", .low = 1e-50,
                      .high = 1e50, .where = "flows"),
    [SPEED]  = OPTION(REAL, "-speed", "reference speed U", "m/s", "1", .also = " U ", .low = 1e-50,
                      .high = 1e50, .where = "flows"),
    [REYNOLDS] =
        OPTION(REAL, "-reynolds", "Reynolds number U L/nu, with the length of the case for L", "-",
               "of the case", .also = " re ", .low = 1e-12, .high = 1e12, .where = "flows"),
    [VISCOSITY] =
        OPTION(REAL, "-viscosity", "kinematic viscosity nu, in place of -reynolds", "m^2/s",
               "from -reynolds", .also = " nu kinematic_viscosity mu ", POSITIVE, .where = "flows"),
    [DENSITY] = OPTION(REAL, "-density", "density rho", "kg/m^3", "1", .also = " rho ",
                       .low = 1e-50, .high = 1e50, .where = "flows"),
    [TENSION] = OPTION(REAL, "-surface_tension", "surface tension sigma", "N/m", "0", NOT_NEGATIVE,
                       .where = "flows with a free surface"),
    [SURFACE_PRESSURE] = OPTION(REAL, "-surface_pressure",
                                "pressure outside free surfaces, such as that of the atmosphere",
                                "Pa", "0", NOT_NEGATIVE, .where = "flows with a free surface"),
    [BODY_FORCE] =
        OPTION(EXPRESSION, "-body_force",
               "body force per unit mass, one component per axis; adds body_force to the physics; "
               "expressions of x, y, t in -case scene, numbers elsewhere",
               "m/s^2", "of the case", .also = " g gravity acceleration ", .where = "flows"),
    [WITH]    = OPTION(NAMES, "-with", "physics added to those of the case", NULL, NULL,
                       .words = PhysicsNames, .where = "flows"),
    [WITHOUT] = OPTION(NAMES, "-without", "physics left out of those of the case", NULL, NULL,
                       .words = PhysicsNames, .where = "flows"),
    [MOTION] =
        OPTION(NAME, "-motion", "motion of the particles", NULL, "lagrangian",
               .table = &MotionTable, .where = "flows with convection; frame with -case scene"),
    [JITTER] = OPTION(REAL, "-jitter", "largest random displacement of the lattice at the start",
                      "dx", "0", .low = 0.0, .high = 0.5),
    [SEED]   = OPTION(INT, "-seed", "seed of the jitter, of the first shift and of random fields",
                      NULL, "1", NOT_NEGATIVE),
    [SOLID_FRACTION] =
        OPTION(REAL, "-solid_fraction", "share of the box that the bodies of an array fill", "-",
               "of the case", .low = 0.001, .high = 0.6,
               .where = "arrays of bodies (-case stokes_cylinders)"),
    [PATCH_MARGIN] = OPTION(
        REAL, "-patch_margin", "width at the sides of the unit square that measurements leave out",
        "dx", "0", .expert = PETSC_TRUE, .low = 0.0, .high = 1e5, .where = "-case patch"),
};
const OptionTable SceneOptions = OPTIONS("Physics and fluid", options);

/* Reads -with and -without and checks them against the physics of the case. */
static PetscErrorCode SceneReadPhysics(Scene *scene)
{
  unsigned with, without;

  PetscFunctionBegin;
  scene->physics = scene->problem->physics;
  if (scene->problem->patch) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(OptionGetFlags(&options[WITH], &with));
  PetscCall(OptionGetFlags(&options[WITHOUT], &without));
  for (PetscInt k = 0; k < PHYSICS_COUNT; k++) {
    UserCheck(!(with & without & (1u << k)), "-with %s and -without %s cannot both be given",
              PhysicsNames[k], PhysicsNames[k]);
  }
  UserCheck(!(without & PHYSICS_WALLS),
            "-without walls: the walls belong to the geometry of case %s", scene->problem->name);
  UserCheck(!(with & PHYSICS_WALLS) || (scene->problem->physics & PHYSICS_WALLS),
            "-with walls: case %s has none", scene->problem->name);
  scene->without = without;
  scene->physics = (scene->problem->physics | with) & ~without;
  UserCheck(SceneHas(scene, PHYSICS_VISCOSITY) || SceneHas(scene, PHYSICS_PRESSURE),
            "-without viscosity: with no pressure either nothing is left to compute");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads -body_force, which replaces the force of the case; without the physics body_force the force
   is zero. */
static PetscErrorCode SceneReadForce(Scene *scene)
{
  PetscReal force[ISPH_MAX_DIM] = {0.0}, size = 0.0;
  PetscInt  n = scene->dim;
  PetscBool given;

  PetscFunctionBegin;
  if (scene->problem->typed) {
    PetscCall(ExpressionGet(scene->scope, &options[BODY_FORCE], n, n,
                            EXPRESSION_PLACE | EXPRESSION_TIME | EXPRESSION_FIELDS, &scene->force,
                            &given));
    for (PetscInt a = 0; a < n; a++) force[a] = scene->force.value[a];
    if (!ExpressionUses(&scene->force, EXPRESSION_PLACE | EXPRESSION_TIME | EXPRESSION_FIELDS))
      scene->force.n = 0; /* body_force holds the numbers */
  } else {
    PetscCall(OptionGetReals(&options[BODY_FORCE], n, force, &n, &given));
  }
  UserCheck(!given || n == scene->dim,
            "-body_force: %" PetscInt_FMT " components are required, got %" PetscInt_FMT,
            scene->dim, n);
  UserCheck(!given || !(scene->without & PHYSICS_BODY_FORCE),
            "-body_force and -without body_force cannot both be given");
  if (given) scene->physics |= PHYSICS_BODY_FORCE;
  for (PetscInt a = 0; a < scene->dim; a++) {
    if (given) scene->body_force[a] = force[a];
    if (!SceneHas(scene, PHYSICS_BODY_FORCE)) scene->body_force[a] = 0.0;
    size += PetscAbsReal(scene->body_force[a]);
  }
  UserCheck(given || size > 0.0 || !SceneHas(scene, PHYSICS_BODY_FORCE),
            "-with body_force: case %s has none of its own; give -body_force",
            scene->problem->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the properties of the fluid; a patch test has no fluid. */
static PetscErrorCode SceneReadFluid(Scene *scene)
{
  PetscReal reynolds = scene->problem->reynolds, viscosity = 0.0;
  PetscBool set;

  PetscFunctionBegin;
  PetscCall(OptionsRefuseTogether("-reynolds", "-viscosity", "one follows from the other"));
  PetscCall(OptionGetReal(&options[REYNOLDS], &reynolds, NULL));
  scene->nu = scene->speed * scene->problem->reynolds_length * scene->length / reynolds;
  viscosity = scene->nu;
  PetscCall(OptionGetReal(&options[VISCOSITY], &viscosity, &set));
  if (set) scene->nu = viscosity;
  PetscCall(OptionGetReal(&options[DENSITY], &scene->rho, NULL));
  PetscCall(OptionGetReal(&options[TENSION], &scene->tension, NULL));
  PetscCall(OptionGetReal(&options[SURFACE_PRESSURE], &scene->outside, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses surface tension and outer pressure without a free surface. */
static PetscErrorCode RefuseTension(const Scene *scene)
{
  const OptionRow *row   = &options[scene->tension != 0.0 ? TENSION : SURFACE_PRESSURE];
  const PetscReal  value = scene->tension != 0.0 ? scene->tension : scene->outside;

  PetscFunctionBegin;
  UserCheck(value == 0.0 || SceneHasFreeSurface(scene),
            "%s %.6g: case %s has no free surface here; %s", row->name, (double)value,
            scene->problem->name,
            scene->problem->typed ? "give -scene_free or -scene_filled_1" : "allowed is 0");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads dimension, resolution, jitter and seed, and the options that only some cases have. */
static PetscErrorCode SceneReadNumbers(Scene *scene)
{
  PetscFunctionBegin;
  PetscCall(OptionGetInt(&options[DIM], &scene->dim, NULL));
  UserCheck(scene->dim == 2 || scene->problem->three_d, "-dim 3: case %s is two-dimensional",
            scene->problem->name);
  if (!scene->problem->patch) {
    PetscCall(OptionGetReal(&options[LENGTH], &scene->length, NULL));
    PetscCall(OptionGetReal(&options[SPEED], &scene->speed, NULL));
  }
  scene->n = scene->problem->n;
  PetscCall(OptionGetInt(&options[RESOLUTION], &scene->n, NULL));
  scene->dx = scene->length / scene->n;
  PetscCall(OptionGetReal(&options[JITTER], &scene->jitter, NULL));
  PetscCall(OptionGetInt(&options[SEED], &scene->seed, NULL));
  scene->solid_fraction = scene->problem->solid_fraction;
  if (scene->solid_fraction > 0.0) {
    PetscCall(OptionGetReal(&options[SOLID_FRACTION], &scene->solid_fraction, NULL));
  }
  if (scene->problem->patch) {
    PetscCall(OptionGetReal(&options[PATCH_MARGIN], &scene->margin, NULL));
  } else {
    PetscCall(SceneReadFluid(scene));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SceneNameConstants - Creates the scope of expressions with the constants nu (zero without
   viscosity), rho, L and U, unless it exists */
PetscErrorCode SceneNameConstants(Scene *scene)
{
  const PetscReal nu = SceneHas(scene, PHYSICS_VISCOSITY) ? scene->nu : 0.0;

  PetscFunctionBegin;
  if (scene->scope) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ExpressionScopeCreate(scene->dim, scene->functions, &scene->scope));
  PetscCall(ExpressionScopeDefine(scene->scope, "nu", nu));
  PetscCall(ExpressionScopeDefine(scene->scope, "rho", scene->rho));
  PetscCall(ExpressionScopeDefine(scene->scope, "L", scene->length));
  PetscCall(ExpressionScopeDefine(scene->scope, "U", scene->speed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gives expressions the scalars at the start, until a flow has them. */
static void FieldsAtStart(void *ctx, PetscReal t, const PetscReal x[], PetscReal value[])
{
  const Scene *scene = (const Scene *)ctx;

  (void)t;
  for (PetscInt k = 0; k < scene->n_scalars; k++) value[k] = ScalarAtStart(&scene->scalar[k], x);
}

/* SceneCreate - Reads and checks the description of the flow from options. Collective on
   PETSC_COMM_WORLD. Input: cases - the option that chooses the case, with the table of cases;
   functions - rows of FunctionRow for expressions; NULL: none. Output: scene - complete: geometry
   in m, fluid, forces and chosen physics. Notes: a patch test reads no options of fluid and
   physics. */
PetscErrorCode SceneCreate(const OptionRow *cases, const Table *functions, Scene **scene)
{
  PetscBool given;
  Scene    *s;

  PetscFunctionBegin;
  PetscCall(PetscNew(scene)); /* SceneDestroy() frees it if an option is refused */
  s            = *scene;
  s->functions = functions;
  s->length = s->speed = s->rho = 1.0;
  PetscCall(OptionGetRow(cases, NULL, &s->problem));
  PetscCall(SceneReadPhysics(s));
  PetscCall(SceneReadNumbers(s));
  SceneSetSides(s, &BoundaryWall);
  if (!s->problem->patch) PetscCall(SceneReadRheology(s));
  PetscCall(OptionGiven(options[MOTION].name, &given));
  if (SceneHas(s, PHYSICS_CONVECTION) || given) {
    PetscCall(OptionGetRow(&options[MOTION], NULL, &s->motion));
    UserCheck(SceneHas(s, PHYSICS_CONVECTION) || s->motion->turns,
              "-motion %s: without convection particles stay; leave -motion out, or turn the frame",
              s->motion->name);
    UserCheck(s->problem->typed || !s->motion->turns,
              "-motion %s: the walls of case %s are not those of a rotor; allowed with -case scene",
              s->motion->name, s->problem->name);
  }
  if (s->problem->typed) {
    PetscCall(SceneNameConstants(s));
    PetscCall(ScalarsRead(s->scope, &s->scalar, &s->n_scalars));
    if (s->n_scalars) ExpressionScopeFieldsAt(s->scope, FieldsAtStart, s);
    PetscCall(SceneReadTyped(s));
  }
  PetscCall(s->problem->Setup(s));
  UserCheck(SceneHas(s, PHYSICS_VISCOSITY) ||
                !SceneHasBoundary(s, BOUNDARY_CONFINES | BOUNDARY_NO_SLIP),
            "-without viscosity: the walls of case %s are no-slip walls", s->problem->name);
  if (!s->problem->patch) PetscCall(SceneReadForce(s));
  PetscCall(RefuseTension(s));
  SceneSetLevel(s);
  for (PetscInt a = 0; a < s->dim; a++) {
    UserCheck((s->hi[a] - s->lo[a]) / s->dx < PETSC_MPI_INT_MAX / 8,
              "-n asks for more particles than fit: the box is %.6g dx wide along %c",
              (double)((s->hi[a] - s->lo[a]) / s->dx), "xyz"[a]);
    s->cells[a] = SceneCellsAlong(s, a);
  }
  PetscCall(SceneReadSpacing(s));
  if (s->problem->typed) PetscCall(SceneCheckBodies(s));
  PetscCall(SceneCheckMixture(s));
  if (s->scope && ExpressionScopeIsIdle(s->scope)) PetscCall(ExpressionScopeDestroy(&s->scope));
  PetscCall(SceneBoundViscosity(s));
  PetscCall(RegimeCreate(s, &s->regime));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SceneDestroy(Scene **scene)
{
  PetscFunctionBegin;
  if (!*scene) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ScalarsFree(&(*scene)->scalar, (*scene)->n_scalars));
  PetscCall(ExpressionScopeDestroy(&(*scene)->scope));
  PetscCall(FreeAll(&(*scene)->pose, &(*scene)->regime));
  PetscCall(SceneFreeShapes(*scene));
  if ((*scene)->frame) PetscCall(PetscFree((*scene)->frame->sum));
  PetscCall(FreeAll(&(*scene)->frame, scene));
  PetscFunctionReturn(PETSC_SUCCESS);
}
