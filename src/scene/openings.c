/*
  Openings of the box. Through an inflow fluid enters with a given velocity, in a part of the side
  or the whole; the rest of the side is a wall. Through an outflow fluid leaves, or returns,

    p given,   n.grad u = 0,

  which is exact for a flow that does not change along the normal. Moving particles enter and leave
  in src/schemes/openings.c.
*/
#include "isph/scene.h"

const BoundaryRow BoundaryInflow = {
    .name       = "inflow",
    .brief      = "side through which fluid enters with a given velocity",
    .citation   = "",
    .option     = {.name  = "-scene_inflow",
                   .kind  = VALUE_NAMES,
                   .brief = "sides of the box through which fluid enters with the velocity "
                                "-scene_wall_<side>_velocity",
                   .words = BoxSides,
                   .table = &BoundaryTable,
                   .where = "-case scene"},
    .properties = BOUNDARY_PARTICLES | BOUNDARY_NO_SLIP | BOUNDARY_INFLOW,
    .equation   = {[FIT_VELOCITY_NORMAL]     = EQUATION_VALUE,
                   [FIT_VELOCITY_TANGENTIAL] = EQUATION_VALUE,
                   [FIT_PRESSURE]            = EQUATION_NORMAL_DERIVATIVE,
                   [FIT_PRESSURE_FREE]       = EQUATION_NONE},
};

/* Returns the pressure on an outflow side [Pa]. */
static PetscReal OutflowPressure(const Scene *scene, PetscInt side, PetscReal t,
                                 const PetscReal x[])
{
  return ExpressionValue(&scene->boundary[side].pressure, 0, t, x);
}

const BoundaryRow BoundaryOutflow = {
    .name       = "outflow",
    .brief      = "side through which fluid leaves or returns: p given, n.grad u = 0",
    .citation   = "R.L. Sani, P.M. Gresho, Int. J. Numer. Meth. Fluids 18 (1994) 983-1008",
    .option     = {.name  = "-scene_outflow",
                   .kind  = VALUE_NAMES,
                   .brief = "sides of the box through which fluid leaves",
                   .words = BoxSides,
                   .table = &BoundaryTable,
                   .where = "-case scene"},
    .properties = BOUNDARY_PARTICLES | BOUNDARY_OUTFLOW,
    .equation   = {[FIT_VELOCITY_NORMAL]     = EQUATION_NORMAL_DERIVATIVE,
                   [FIT_VELOCITY_TANGENTIAL] = EQUATION_NORMAL_DERIVATIVE,
                   [FIT_PRESSURE]            = EQUATION_VALUE,
                   [FIT_PRESSURE_FREE]       = EQUATION_VALUE},
    .Pressure   = OutflowPressure,
};

enum { OPENING, PRESSURE };
static const OptionRow options[] = {
    [PRESSURE] =
        {
            .name     = "-scene_outflow_<side>_pressure",
            .kind     = VALUE_EXPRESSION,
            .brief    = "pressure on an outflow side, of x, y, t",
            .unit     = "Pa",
            .standard = "0",
            .places   = BoxSides,
            .where    = "-case scene, sides that are outflows",
        },
    [OPENING] =
        {
            .name = "-scene_opening_<side>",
            .kind = VALUE_REALS,
            .brief =
                "part a,b of an inflow side through which fluid enters, along the side; the rest "
                "of the side is a wall",
            .unit     = "m",
            .standard = "the whole side",
            .places   = BoxSides,
            .where    = "-case scene, sides that are inflows",
        },
};
const OptionTable OpeningOptions = OPTIONS("Openings of typed scenes", options);

/* SceneHasOpenings - Returns true if particles enter or leave the box; not collective */
PetscBool SceneHasOpenings(const Scene *scene)
{
  return SceneMoves(scene) && (SceneHasBoundary(scene, BOUNDARY_INFLOW) ||
                               SceneHasBoundary(scene, BOUNDARY_OUTFLOW))
             ? PETSC_TRUE
             : PETSC_FALSE;
}

/* BoundaryIsOpen - Returns true if fluid can enter through the side at x; not collective */
PetscBool BoundaryIsOpen(const Scene *scene, PetscInt side, const PetscReal x[])
{
  return BoundaryOpenPart(scene, side, x, 0.0) > 0.0 ? PETSC_TRUE : PETSC_FALSE;
}

/*
  BoundaryOpenPart - Returns the part of a piece of a side, about x and of the given length, through
  which fluid can enter [-]

  Not collective. A piece without length is a point, whose part is 0 or 1.
*/
PetscReal BoundaryOpenPart(const Scene *scene, PetscInt side, const PetscReal x[], PetscReal length)
{
  const PetscReal *opening = scene->boundary[side].opening;
  PetscReal        open, at;

  if (!BoundaryIs(scene, side, BOUNDARY_INFLOW)) return 0.0;
  at = x[1 - side / 2];
  if (length == 0.0) return at >= opening[0] && at <= opening[1] ? 1.0 : 0.0;
  open = PetscMin(at + 0.5 * length, opening[1]) - PetscMax(at - 0.5 * length, opening[0]);
  return PetscMax(open / length, 0.0);
}

/*
  InflowPressureSlope - Returns the share of viscosity and convection in n.grad p on an inflow
  [Pa/m]

    rho (nu d^2 u_n/ds^2 - u_s du_n/ds + u_n du_s/ds),   s: along the side

  Not collective. The last term is -u_n du_n/dn by div u = 0; d^2 u_n/dn^2 is not known and left
  out. The derivatives are centred differences over 1e-3 of the side.
*/
PetscReal InflowPressureSlope(const Scene *scene, PetscInt side, PetscReal t, const PetscReal x[])
{
  const Expression *velocity = &scene->boundary[side].velocity;
  const PetscInt    normal = side / 2, along = 1 - normal;
  const PetscReal   step = 1e-3 * (scene->hi[along] - scene->lo[along]);
  PetscReal         u[3][2], slope[2], curve;

  if (!BoundaryIsOpen(scene, side, x)) return 0.0;
  for (PetscInt k = 0; k < 3; k++) {
    PetscReal at[ISPH_MAX_DIM] = {x[0], x[1], 0.0};

    at[along] += (k - 1) * step;
    for (PetscInt c = 0; c < 2; c++) u[k][c] = ExpressionValue(velocity, c, t, at);
  }
  for (PetscInt c = 0; c < 2; c++) slope[c] = 0.5 * (u[2][c] - u[0][c]) / step;
  curve = (u[2][normal] - 2.0 * u[1][normal] + u[0][normal]) / PetscSqr(step);
  curve *= SceneHas(scene, PHYSICS_VISCOSITY) ? SceneViscosityAt(scene, x) : 0.0;
  if (SceneHas(scene, PHYSICS_CONVECTION))
    curve += u[1][normal] * slope[along] - u[1][along] * slope[normal];
  return (side % 2 ? -1.0 : 1.0) * scene->rho * curve;
}

/* Reads the opening of an inflow side. */
static PetscErrorCode ReadOpening(Scene *scene, PetscInt side)
{
  const PetscInt along   = 1 - side / 2;
  PetscReal     *opening = scene->boundary[side].opening;
  char           name[OPTION_LENGTH];
  OptionRow      row;
  PetscInt       n;
  PetscBool      given;

  PetscFunctionBegin;
  opening[0] = scene->lo[along];
  opening[1] = scene->hi[along];
  OptionFill(&options[OPENING], BoxSides[side], name, &row);
  PetscCall(OptionGetReals(&row, 2, opening, &n, &given));
  if (!given) PetscFunctionReturn(PETSC_SUCCESS);
  UserCheck(n == 2, "%s: 2 numbers are required, got %" PetscInt_FMT, name, n);
  UserCheck(opening[0] >= scene->lo[along] && opening[1] <= scene->hi[along] &&
                opening[1] - opening[0] >= 2.0 * scene->dx,
            "%s %.6g,%.6g: an opening is at least 2 dx = %.4g wide and inside %.6g to %.6g", name,
            (double)opening[0], (double)opening[1], (double)(2.0 * scene->dx),
            (double)scene->lo[along], (double)scene->hi[along]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses an inflow whose velocity at time t leaves the box somewhere. */
static PetscErrorCode CheckEntering(const Scene *scene, PetscInt side, PetscReal t)
{
  const PetscInt   normal = side / 2, along = 1 - normal;
  const PetscReal *opening = scene->boundary[side].opening;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < 1000; k++) {
    PetscReal x[ISPH_MAX_DIM] = {0.0}, u[ISPH_MAX_DIM], entering;

    x[normal] = side % 2 ? scene->hi[normal] : scene->lo[normal];
    x[along]  = opening[0] + (k + 0.5) * (opening[1] - opening[0]) / 1000.0;
    SceneWallVelocity(scene, side, t, x, u);
    entering = side % 2 ? -u[normal] : u[normal];
    UserCheck(
        entering >= 0.0,
        "-scene_wall_%s_velocity: at (%.4g, %.4g), t = %.3g s fluid leaves through the inflow; "
        "allowed are velocities into the box; use -scene_outflow where fluid leaves",
        BoxSides[side], (double)x[0], (double)x[1], (double)t);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  SceneReadOpenings - Reads the openings of inflow sides, whose kinds and velocities are set, and
  the pressures of outflow sides

  Collective.

  Options Database Keys:
+ -scene_opening_<side> a,b      - part of the side through which fluid enters [m]
- -scene_outflow_<side>_pressure - pressure on the side [Pa] (x, y, t)

  Errors: openings that are not part of the side, and velocities out of the box end the run
*/
PetscErrorCode SceneReadOpenings(Scene *scene)
{
  PetscFunctionBegin;
  for (PetscInt side = 0; side < 4; side++) {
    char      name[OPTION_LENGTH];
    OptionRow row;

    OptionFill(&options[PRESSURE], BoxSides[side], name, &row);
    if (BoundaryIs(scene, side, BOUNDARY_OUTFLOW)) {
      PetscCall(ExpressionGet(scene->scope, &row, 1, 1, EXPRESSION_PLACE | EXPRESSION_TIME,
                              &scene->boundary[side].pressure, NULL));
    }
    if (!BoundaryIs(scene, side, BOUNDARY_INFLOW)) continue;
    PetscCall(ReadOpening(scene, side));
    PetscCall(CheckEntering(scene, side, 0.0));
    PetscCall(CheckEntering(scene, side, 0.125 * scene->length / scene->speed));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
