/*
  Openings of the box. Through an inflow fluid enters, or leaves, with a given velocity, in a part
  of the side or the whole; the rest of the side is a wall. Through an outflow fluid leaves, or
  returns,

    p given,   n.grad u = 0,

  which is exact for a flow that does not change along the normal. Moving particles enter and leave
  in src/motion/openings.c.
*/
#include "isph/scene.h"

const BoundaryRow BoundaryInflow = {
    .name       = "inflow",
    .brief      = "side through which fluid enters, or leaves, with a given velocity",
    .option     = OPTION(NAMES, "-scene_inflow",
                         "sides of the box through which fluid enters, or leaves, with the "
                             "velocity -scene_wall_<side>_velocity",
                         NULL, NULL, .also = " inlet ", .words = BoxSides, .table = &BoundaryTable,
                         .where = "-case scene"),
    .properties = BOUNDARY_PARTICLES | BOUNDARY_NO_SLIP | BOUNDARY_INFLOW,
    .equation   = {[FIT_VELOCITY_NORMAL]     = EQUATION_VALUE,
                   [FIT_VELOCITY_TANGENTIAL] = EQUATION_VALUE,
                   [FIT_PRESSURE]            = EQUATION_NORMAL_DERIVATIVE,
                   [FIT_PRESSURE_FREE]       = EQUATION_NONE},
};

static PetscReal OutflowPressure(const Scene *scene, PetscInt side, PetscReal t,
                                 const PetscReal x[])
{
  return ExpressionValue(&scene->boundary[side].pressure, 0, t, x);
}

const BoundaryRow BoundaryOutflow = {
    .name     = "outflow",
    .brief    = "side through which fluid leaves or returns: p given, n.grad u = 0",
    .citation = "R.L. Sani, P.M. Gresho, Int. J. Numer. Meth. Fluids 18 (1994) 983-1008",
    .option =
        OPTION(NAMES, "-scene_outflow",
               "sides of the box through which fluid leaves, or returns, at a given pressure; with "
               "-scene_wall_<side>_velocity they are as those of -scene_inflow",
               NULL, NULL, .also = " outlet ", .words = BoxSides, .table = &BoundaryTable,
               .where = "-case scene"),
    .properties = BOUNDARY_PARTICLES | BOUNDARY_OUTFLOW,
    .equation   = {[FIT_VELOCITY_NORMAL]     = EQUATION_NORMAL_DERIVATIVE,
                   [FIT_VELOCITY_TANGENTIAL] = EQUATION_NORMAL_DERIVATIVE,
                   [FIT_PRESSURE]            = EQUATION_VALUE,
                   [FIT_PRESSURE_FREE]       = EQUATION_VALUE},
    .Pressure   = OutflowPressure,
};

enum { OPENING, PRESSURE };
static const OptionRow options[] = {
    [PRESSURE] = OPTION(EXPRESSION, "-scene_outflow_<side>_pressure",
                        "pressure on an outflow side, of x, y[, z], t", "Pa", "0",
                        .places = BoxSides, .where = "-case scene, sides that are outflows"),
    [OPENING] =
        OPTION(SHAPE, "-scene_opening_<side>",
               "part of an inflow side through which fluid enters, the rest is a wall: a,b along "
               "the side; in 3D a shape of 2D in the axes along the side, as circle,0.5,0.5,0.1",
               "m", "the whole side", .table_3d = &ShapeTable, .places = BoxSides,
               .where = "-case scene, sides that are inflows"),
};
const OptionTable OpeningOptions = OPTIONS("Openings of typed scenes", options);

#define PARTS 8 /* of an edge of a cell, with which the open part of the cell is found in 3D */

/* SceneHasOpenings - Returns true if particles enter or leave the box */
PetscBool SceneHasOpenings(const Scene *scene)
{
  return SceneMoves(scene) &&
         (SceneHasBoundary(scene, BOUNDARY_INFLOW) || SceneHasBoundary(scene, BOUNDARY_OUTFLOW));
}

/* Gets the axes along a side, in order; returns their number. */
static PetscInt AlongSide(const Scene *scene, PetscInt side, PetscInt axis[2])
{
  PetscInt n = 0;

  for (PetscInt a = 0; a < scene->dim; a++)
    if (a != side / 2) axis[n++] = a;
  return n;
}

/* Returns the distance of a point of an inflow side from the edge of its opening, positive inside
   [m]; computes the direction out of the opening along the side. */
static PetscReal OpeningDepth(const Scene *scene, PetscInt side, const PetscReal x[],
                              PetscReal out[ISPH_MAX_DIM])
{
  const Boundary *boundary = &scene->boundary[side];
  PetscInt        axis[2];
  PetscReal       low, high, depth, at[2], normal[2];

  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) out[a] = 0.0;
  if (AlongSide(scene, side, axis) == 1) {
    low          = x[axis[0]] - boundary->opening[0];
    high         = boundary->opening[1] - x[axis[0]];
    out[axis[0]] = low < high ? -1.0 : 1.0;
    return PetscMin(low, high);
  }
  if (!boundary->hole.shape) return PETSC_INFINITY;
  for (PetscInt m = 0; m < 2; m++) at[m] = x[axis[m]];
  depth = -boundary->hole.shape->Distance(&boundary->hole, at, normal);
  for (PetscInt m = 0; m < 2; m++) out[axis[m]] = normal[m];
  return depth;
}

/* BoundaryIsOpen - Returns true if fluid passes the side at x with a given velocity */
PetscBool BoundaryIsOpen(const Scene *scene, PetscInt side, const PetscReal x[])
{
  PetscReal out[ISPH_MAX_DIM];

  return BoundaryIs(scene, side, BOUNDARY_INFLOW) && OpeningDepth(scene, side, x, out) >= 0.0;
}

/* BoundaryLetsOut - Returns true if fluid near x can leave through a boundary at time t: through an
   outflow, or with the given velocity of an inflow */
PetscBool BoundaryLetsOut(const Scene *scene, PetscInt side, PetscReal t, const PetscReal x[])
{
  PetscReal point[ISPH_MAX_DIM] = {0.0}, u[ISPH_MAX_DIM];

  if (!BoundaryIsOpen(scene, side, x)) return BoundaryIs(scene, side, BOUNDARY_OUTFLOW);
  for (PetscInt a = 0; a < scene->dim; a++) point[a] = x[a];
  point[side / 2] = side % 2 ? scene->hi[side / 2] : scene->lo[side / 2];
  SceneWallVelocity(scene, side, t, point, u);
  return SideEntering(side, u) < -PETSC_SQRT_MACHINE_EPSILON * scene->speed;
}

/* BoundaryIntoOpening - Moves a point of an inflow side into its opening */
void BoundaryIntoOpening(const Scene *scene, PetscInt side, PetscReal x[])
{
  PetscReal       out[ISPH_MAX_DIM];
  const PetscReal depth = OpeningDepth(scene, side, x, out) - SCENE_ON_SURFACE * scene->dx;

  for (PetscInt a = 0; depth < 0.0 && a < scene->dim; a++) x[a] += depth * out[a];
}

/* BoundaryOpenPart - Returns the part of a cell about x on a side through which fluid can enter
   [-]. It is exact in 2D. In 3D it is a sum over parts of the cell, each cut by the tangent of the
   edge of the opening; cells far from the edge need no parts. */
PetscReal BoundaryOpenPart(const Scene *scene, PetscInt side, const PetscReal x[])
{
  const PetscReal *opening = scene->boundary[side].opening;
  PetscInt         axis[2];
  PetscReal        sum = 0.0, out[ISPH_MAX_DIM];

  if (!BoundaryIs(scene, side, BOUNDARY_INFLOW)) return 0.0;
  if (AlongSide(scene, side, axis) == 1) {
    const PetscReal half = 0.5 * SceneCellSide(scene, axis[0]), at = x[axis[0]];

    sum = PetscMin(at + half, opening[1]) - PetscMax(at - half, opening[0]);
    return PetscMax(0.5 * sum / half, 0.0);
  }
  sum = OpeningDepth(scene, side, x, out);
  if (PetscAbsReal(sum) > 0.5 * (SceneCellSide(scene, axis[0]) + SceneCellSide(scene, axis[1])))
    return sum > 0.0 ? 1.0 : 0.0;
  sum = 0.0;
  for (PetscInt k = 0; k < PARTS * PARTS; k++) {
    PetscReal y[ISPH_MAX_DIM], part = 0.0;

    y[side / 2] = x[side / 2];
    for (PetscInt m = 0; m < 2; m++) {
      part       = SceneCellSide(scene, axis[m]) / PARTS;
      y[axis[m]] = x[axis[m]] + ((m ? k / PARTS : k % PARTS) - 0.5 * (PARTS - 1)) * part;
    }
    sum += PetscMin(PetscMax(0.5 + OpeningDepth(scene, side, y, out) / part, 0.0), 1.0);
  }
  return sum / (PARTS * PARTS);
}

/*
  InflowPressureSlope - Returns the share of viscosity and convection in n.grad p on an inflow
  [Pa/m]

    rho (nu lap_s u_n - u_s.grad_s u_n + u_n div_s u_s),   s: along the side

  The last term is -u_n du_n/dn by div u = 0; d^2 u_n/dn^2 is not known and left out. The
  derivatives are centred differences over 1e-3 of the side, at points this far from its ends.
*/
PetscReal InflowPressureSlope(const Scene *scene, PetscInt side, PetscReal t, const PetscReal x[])
{
  const Expression *velocity = &scene->boundary[side].velocity;
  const PetscInt    normal   = side / 2;
  PetscInt          axis[2];
  const PetscInt    n  = AlongSide(scene, side, axis);
  const PetscReal   nu = SceneHas(scene, PHYSICS_VISCOSITY) ? SceneViscosityAt(scene, x) : 0.0;
  const PetscReal   convects = SceneHas(scene, PHYSICS_CONVECTION) ? 1.0 : 0.0;
  PetscReal         sum      = 0.0;

  if (!BoundaryIsOpen(scene, side, x)) return 0.0;
  for (PetscInt m = 0; m < n; m++) {
    const PetscInt  along = axis[m];
    const PetscReal step  = 1e-3 * (scene->hi[along] - scene->lo[along]);
    PetscReal       u[3][2]; /* normal component, and that along this axis */

    for (PetscInt k = 0; k < 3; k++) {
      PetscReal at[ISPH_MAX_DIM] = {0.0};

      for (PetscInt a = 0; a < scene->dim; a++) at[a] = x[a];
      if (!SceneIsPeriodic(scene, along))
        at[along] = PetscMin(PetscMax(at[along], scene->lo[along] + step), scene->hi[along] - step);
      at[along] += (k - 1) * step;
      u[k][0] = ExpressionValue(velocity, normal, t, at);
      u[k][1] = ExpressionValue(velocity, along, t, at);
    }
    sum += nu * (u[2][0] - 2.0 * u[1][0] + u[0][0]) / PetscSqr(step);
    sum += convects * (u[1][0] * (u[2][1] - u[0][1]) - u[1][1] * (u[2][0] - u[0][0])) * 0.5 / step;
  }
  return (side % 2 ? -1.0 : 1.0) * scene->rho * sum;
}

/* Reads the opening a,b of an inflow side in 2D. */
static PetscErrorCode ReadInterval(Scene *scene, PetscInt side, const OptionRow *row)
{
  PetscReal *opening = scene->boundary[side].opening;
  PetscInt   axis[2], n;
  PetscBool  given;

  PetscFunctionBegin;
  (void)AlongSide(scene, side, axis);
  opening[0] = scene->lo[axis[0]];
  opening[1] = scene->hi[axis[0]];
  if (scene->n_filled) BodySpan(&scene->filled[0], axis[0], opening); /* up to a free side */
  opening[0] = PetscMax(opening[0], scene->lo[axis[0]]);
  opening[1] = PetscMin(opening[1], scene->hi[axis[0]]);
  PetscCall(OptionGetReals(row, 2, opening, &n, &given));
  if (!given) PetscFunctionReturn(PETSC_SUCCESS);
  UserCheck(n == 2, "%s: 2 numbers are required, got %" PetscInt_FMT, row->name, n);
  UserCheck(opening[0] >= scene->lo[axis[0]] && opening[1] <= scene->hi[axis[0]] &&
                opening[1] - opening[0] >= 2.0 * scene->dx,
            "%s %.6g,%.6g: an opening is at least 2 dx = %.4g wide and inside %.6g to %.6g",
            row->name, (double)opening[0], (double)opening[1], (double)(2.0 * scene->dx),
            (double)scene->lo[axis[0]], (double)scene->hi[axis[0]]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns true if an end of an axis is a plane of symmetry. */
static PetscBool Mirrors(const Scene *scene, PetscInt axis, PetscInt end)
{
  return scene->boundary[2 * axis + end].kind == &BoundarySymmetry;
}

/* Reads the opening of an inflow side in 3D. It may reach beyond planes of symmetry. */
static PetscErrorCode ReadHole(Scene *scene, PetscInt side, const OptionRow *row)
{
  Body     *hole = &scene->boundary[side].hole;
  PetscInt  axis[2];
  PetscBool given;

  PetscFunctionBegin;
  PetscCall(ShapeReadPlane(scene, row, hole, &given));
  (void)AlongSide(scene, side, axis);
  for (PetscInt m = 0; given && m < 2; m++) {
    PetscReal span[2];

    BodySpan(hole, m, span);
    UserCheck((span[0] >= scene->lo[axis[m]] || Mirrors(scene, axis[m], 0)) &&
                  (span[1] <= scene->hi[axis[m]] || Mirrors(scene, axis[m], 1)) &&
                  span[1] - span[0] >= 2.0 * scene->dx,
              "%s: from %.6g to %.6g along %s; an opening is at least 2 dx = %.4g wide and inside "
              "%.6g to %.6g",
              row->name, (double)span[0], (double)span[1], BoxAxes[axis[m]],
              (double)(2.0 * scene->dx), (double)scene->lo[axis[m]], (double)scene->hi[axis[m]]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SceneCheckVelocities - Does SceneCheckInflow() if velocities of the sides depend on time.
   Collective. Those that do not were checked when they were read. */
PetscErrorCode SceneCheckVelocities(Scene *scene, PetscReal t)
{
  PetscBool varies = PETSC_FALSE;

  PetscFunctionBegin;
  for (PetscInt side = 0; side < 2 * scene->dim; side++)
    if (ExpressionUses(&scene->boundary[side].velocity, EXPRESSION_TIME)) varies = PETSC_TRUE;
  if (!varies) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SceneCheckInflow(scene, t));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SceneReadOpenings - Reads the openings of inflow sides, whose kinds and velocities are set, and
   the pressures of outflow sides; collective */
PetscErrorCode SceneReadOpenings(Scene *scene)
{
  PetscFunctionBegin;
  for (PetscInt side = 0; side < 2 * scene->dim; side++) {
    char      name[OPTION_LENGTH];
    OptionRow row;

    OptionFill(&options[PRESSURE], BoxSides[side], name, &row);
    if (BoundaryIs(scene, side, BOUNDARY_OUTFLOW)) {
      PetscCall(ExpressionGet(scene->scope, &row, 1, 1, EXPRESSION_PLACE | EXPRESSION_TIME,
                              &scene->boundary[side].pressure, NULL));
    }
    if (!BoundaryIs(scene, side, BOUNDARY_INFLOW)) continue;
    OptionFill(&options[OPENING], BoxSides[side], name, &row);
    PetscCall(scene->dim == 2 ? ReadInterval(scene, side, &row) : ReadHole(scene, side, &row));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
