/*
  Creates a checked Scene from options: chooses the case, switches physics, reads numbers and
  refuses impossible values. Nothing here depends on particles or solvers.
*/
#include "isph/scene.h"

const char *const PhysicsNames[PHYSICS_COUNT] = {"viscosity", "pressure", "convection", "walls",
                                                 "body_force"};

/* SceneHas - Returns true if the run computes this physics */
PetscBool SceneHas(const Scene *scene, Physics what)
{
  return (scene->physics & (unsigned)what) ? PETSC_TRUE : PETSC_FALSE;
}

/* SceneReynolds - Returns U L/nu with the lengths of the case; infinite without viscosity */
PetscReal SceneReynolds(const Scene *scene)
{
  if (!SceneHas(scene, PHYSICS_VISCOSITY)) return PETSC_INFINITY;
  return scene->speed * scene->problem->reynolds_length * scene->length / scene->nu;
}

/* SceneCellReynolds - Returns U dx/nu with the least viscosity; infinite without viscosity */
PetscReal SceneCellReynolds(const Scene *scene)
{
  if (!SceneHas(scene, PHYSICS_VISCOSITY)) return PETSC_INFINITY;
  return scene->speed * scene->dx / scene->nu_low;
}

/*
  SceneIsAsPosed - Returns true if the exact solution of the case holds: no physics of the case is
  left out, and no force added. Added pressure or convection does not change the exact solution of a
  case without them.
*/
PetscBool SceneIsAsPosed(const Scene *scene)
{
  const unsigned posed = scene->problem->physics;

  return !(posed & ~scene->physics) && !(scene->physics & ~posed & (unsigned)PHYSICS_BODY_FORCE)
             ? PETSC_TRUE
             : PETSC_FALSE;
}

/* SceneMoves - Returns true if particles move with the flow */
PetscBool SceneMoves(const Scene *scene)
{
  return scene->motion && scene->motion->particles_move ? PETSC_TRUE : PETSC_FALSE;
}

/* SceneCellSide - Returns the side of a lattice cell along an axis; it is dx if the box is a whole
   number of dx long [m] */
PetscReal SceneCellSide(const Scene *scene, PetscInt axis)
{
  return (scene->hi[axis] - scene->lo[axis]) / scene->cells[axis];
}

/*
  SceneSpacing - Returns the particle spacing wanted at x [m]

  It is uniform today. A particle takes it when it is made and keeps its own afterwards
  (Particles.dx); dimensionless numbers and options are in units of the reference spacing scene->dx.
*/
PetscReal SceneSpacing(const Scene *scene, const PetscReal x[])
{
  (void)x;
  return scene->dx;
}

/* BodySpacing - Returns the spacing of points on a body's surface, wanted at its centre [m] */
PetscReal BodySpacing(const Scene *scene, const Body *body)
{
  const PetscReal x[ISPH_MAX_DIM] = {body->centre[0], body->centre[1]};

  return SceneSpacing(scene, x);
}

/* SceneCoarsest - Returns the largest spacing wanted anywhere, which bounds kernel radii [m] */
PetscReal SceneCoarsest(const Scene *scene)
{
  return scene->dx;
}

/* SceneFinest - Returns the smallest spacing wanted anywhere, which bounds steps [m] */
PetscReal SceneFinest(const Scene *scene)
{
  return scene->dx;
}

/* SceneTolerance - Returns the reference length of geometric tolerances [m] */
PetscReal SceneTolerance(const Scene *scene)
{
  return SceneFinest(scene);
}

/* SceneVolume - Returns the volume of a cell of the lattice of the reference spacing [m^dim] */
PetscReal SceneVolume(const Scene *scene)
{
  PetscReal volume = 1.0;

  for (PetscInt a = 0; a < scene->dim; a++) volume *= SceneCellSide(scene, a);
  return volume;
}

/* SceneVolumeAt - Returns the volume of a particle made at x [m^dim] */
PetscReal SceneVolumeAt(const Scene *scene, const PetscReal x[])
{
  const PetscReal ratio  = SceneSpacing(scene, x) / scene->dx;
  PetscReal       volume = SceneVolume(scene);

  for (PetscInt a = 0; a < scene->dim; a++) volume *= ratio;
  return volume;
}

/* Reads -with and -without and checks them against the physics of the case. */
static PetscErrorCode SceneReadPhysics(OptionItems PetscOptionsObject, Scene *scene)
{
  unsigned with, without;

  PetscFunctionBegin;
  scene->physics = scene->problem->physics;
  if (scene->problem->patch) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(
      OptionFlags("-with", "Physics added to the case's own", PhysicsNames, PHYSICS_COUNT, &with));
  PetscCall(OptionFlags("-without", "Physics taken from the case's own", PhysicsNames,
                        PHYSICS_COUNT, &without));
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

/* Reads -body_force, which replaces the force of the case; no force if the physics is left out. */
static PetscErrorCode SceneReadForce(OptionItems PetscOptionsObject, Scene *scene)
{
  const char *const text = "Body force per unit mass, fx,fy[,fz]; adds to the physics; of -case "
                           "scene an expression of x, y, t [m/s^2]";
  PetscReal         force[ISPH_MAX_DIM] = {0.0}, size = 0.0;
  PetscInt          n = scene->dim;
  PetscBool         given;

  PetscFunctionBegin;
  if (scene->problem->typed) {
    PetscCall(ExpressionRead(scene->scope, "-body_force", text, n, n,
                             EXPRESSION_PLACE | EXPRESSION_TIME, &scene->force, &given));
    for (PetscInt a = 0; a < n; a++) force[a] = scene->force.value[a];
    if (!ExpressionUses(&scene->force, EXPRESSION_PLACE) &&
        !ExpressionUses(&scene->force, EXPRESSION_TIME))
      scene->force.n = 0; /* body_force holds the numbers */
  } else {
    PetscCall(OptionReals("-body_force", text, n, force, &n, &given));
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
static PetscErrorCode SceneReadFluid(OptionItems PetscOptionsObject, Scene *scene)
{
  PetscReal reynolds = scene->problem->reynolds, viscosity = 0.0;
  PetscBool set;

  PetscFunctionBegin;
  PetscCall(OptionsRefuseTogether("-reynolds", "-viscosity", "one follows from the other"));
  PetscCall(OptionReal("-reynolds", "Reynolds number U L/nu [-]", 1e-12, 1e12, &reynolds, NULL));
  scene->nu = scene->speed * scene->problem->reynolds_length * scene->length / reynolds;
  viscosity = scene->nu;
  PetscCall(
      OptionReal("-viscosity", "Kinematic viscosity nu [m^2/s]", 1e-300, 1e300, &viscosity, &set));
  if (set) scene->nu = viscosity;
  PetscCall(OptionReal("-density", "Density rho [kg/m^3]", 1e-100, 1e100, &scene->rho, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads dimension, resolution and disorder, and options of some cases only. */
static PetscErrorCode SceneReadNumbers(OptionItems PetscOptionsObject, Scene *scene)
{
  PetscFunctionBegin;
  PetscCall(OptionInt("-dim", "Space dimension", 2, 3, &scene->dim, NULL));
  UserCheck(scene->dim == 2 || scene->problem->three_d, "-dim 3: case %s is two-dimensional",
            scene->problem->name);
  if (!scene->problem->patch) {
    PetscCall(OptionReal("-length", "Reference length L [m]", 1e-100, 1e100, &scene->length, NULL));
    PetscCall(OptionReal("-speed", "Reference speed U [m/s]", 1e-100, 1e100, &scene->speed, NULL));
  }
  scene->n = scene->problem->n;
  PetscCall(OptionInt("-n", "Particles along the reference length, dx = L/N", 4, 100000, &scene->n,
                      NULL));
  scene->dx = scene->length / scene->n;
  PetscCall(OptionReal("-jitter", "Largest random displacement of the lattice at the start [dx]",
                       0.0, 0.5, &scene->jitter, NULL));
  PetscCall(OptionInt("-seed", "Seed of the jitter and of random fields", 0, PETSC_INT_MAX,
                      &scene->seed, NULL));
  scene->solid_fraction = scene->problem->solid_fraction;
  if (scene->solid_fraction > 0.0) {
    PetscCall(OptionReal("-solid_fraction", "Of an array of bodies [-]", 0.001, 0.6,
                         &scene->solid_fraction, NULL));
  }
  if (scene->problem->patch) {
    PetscCall(OptionReal("-patch_margin", "What is left out at the sides of the unit square [dx]",
                         0.0, 1e5, &scene->margin, NULL));
  } else {
    PetscCall(SceneReadFluid(PetscOptionsObject, scene));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Defines the constants of expressions: nu (zero without viscosity), rho, L and U; not
   collective. */
static PetscErrorCode SceneNameConstants(Scene *scene)
{
  const PetscReal nu = SceneHas(scene, PHYSICS_VISCOSITY) ? scene->nu : 0.0;

  PetscFunctionBegin;
  PetscCall(ExpressionScopeCreate(scene->dim, &scene->scope));
  PetscCall(ExpressionScopeDefine(scene->scope, "nu", nu));
  PetscCall(ExpressionScopeDefine(scene->scope, "rho", scene->rho));
  PetscCall(ExpressionScopeDefine(scene->scope, "L", scene->length));
  PetscCall(ExpressionScopeDefine(scene->scope, "U", scene->speed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  SceneCreate - Reads and checks the description of the flow from options

  Collective on PETSC_COMM_WORLD.

  Output Parameter:
. scene - complete: geometry in m, fluid, forces and chosen physics
  Options Database Keys:
+ -case name              - row of the table in cases/cases.c
. -dim 2|3                - space dimension
. -n N                    - particles along the reference length
. -length, -speed         - the case's L and U
. -reynolds, -viscosity   - one of the two
. -density RHO            - of the fluid
. -body_force fx,fy,fz    - per unit mass, in place of the case's own; of -case scene expressions of
                            x, y, t
. -with, -without names   - physics against the case's declaration
. -jitter J               - largest random displacement of the start lattice, in dx
. -seed S                 - of the jitter and of random fields
- -patch_margin M         - of a patch test, which reads nothing of the fluid and the physics [dx]

  and -motion, a row of its table, where there is convection
*/
PetscErrorCode SceneCreate(Scene **scene)
{
  Scene *s;

  PetscFunctionBegin;
  PetscCall(PetscNew(&s));
  s->dim    = 2;
  s->length = s->speed = s->rho = 1.0;
  s->seed                       = 1;
  PetscOptionsBegin(PETSC_COMM_WORLD, NULL, "Scene", "");
  PetscCall(TableSelect(&CaseTable, "-case", "What to compute", "cavity", &s->problem));
  PetscCall(SceneReadPhysics(PetscOptionsObject, s));
  PetscCall(SceneReadNumbers(PetscOptionsObject, s));
  SceneSetSides(s, &BoundaryWall);
  if (!s->problem->patch) PetscCall(SceneReadRheology(PetscOptionsObject, s));
  if (SceneHas(s, PHYSICS_CONVECTION)) {
    PetscCall(
        TableSelect(&MotionTable, "-motion", "Whether particles move", "lagrangian", &s->motion));
  }
  if (s->problem->typed) {
    PetscCall(SceneNameConstants(s));
    PetscCall(SceneReadTyped(PetscOptionsObject, s));
  }
  PetscCall(s->problem->Setup(s));
  UserCheck(SceneHas(s, PHYSICS_VISCOSITY) ||
                !SceneHasBoundary(s, BOUNDARY_CONFINES | BOUNDARY_NO_SLIP),
            "-without viscosity: the walls of case %s are no-slip walls", s->problem->name);
  if (!s->problem->patch) PetscCall(SceneReadForce(PetscOptionsObject, s));
  PetscOptionsEnd();
  if (s->scope && ExpressionScopeIsIdle(s->scope)) PetscCall(ExpressionScopeDestroy(&s->scope));
  for (PetscInt a = 0; a < s->dim; a++) {
    UserCheck((s->hi[a] - s->lo[a]) / s->dx < PETSC_MPI_INT_MAX / 8,
              "-n asks for more particles than fit: the box is %.6g dx wide along %c",
              (double)((s->hi[a] - s->lo[a]) / s->dx), "xyz"[a]);
    s->cells[a] = (PetscInt)PetscFloorReal((s->hi[a] - s->lo[a]) / s->dx + 0.5);
  }
  PetscCall(SceneBoundViscosity(s));
  *scene = s;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SceneDestroy(Scene **scene)
{
  PetscFunctionBegin;
  PetscCall(ExpressionScopeDestroy(&(*scene)->scope));
  PetscCall(PetscFree(*scene));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SceneIsDrivenInTime - Returns true if a wall's velocity or the body force depends on time */
PetscBool SceneIsDrivenInTime(const Scene *scene)
{
  return scene->unsteady_walls || (scene->force.n && ExpressionUses(&scene->force, EXPRESSION_TIME))
             ? PETSC_TRUE
             : PETSC_FALSE;
}

/* SceneBodyForce - Computes the body force per unit mass at a position and time [m/s^2]; not
   collective */
void SceneBodyForce(const Scene *scene, PetscReal t, const PetscReal x[], PetscReal f[])
{
  for (PetscInt a = 0; a < scene->dim; a++)
    f[a] = scene->force.n ? ExpressionValue(&scene->force, a, t, x) : scene->body_force[a];
}
