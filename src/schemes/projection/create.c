/*
  The options of the projection scheme: the update of the pressure, the points on which the pressure
  is known, its filter, and the convection of fixed particles.
*/
#include "projection.h"
#include "schemes/surface/surface.h"

static const ProjectionRow projections[] = {
    {.name        = "rotational",
     .brief       = "p = p^n + phi - mu div u*: second order, accurate in the Stokes limit",
     .citation    = "Guermond, Minev & Shen, Comput. Methods Appl. Mech. Eng. 195 (2006)",
     .incremental = PETSC_TRUE,
     .rotational  = PETSC_TRUE,
     .alpha_max   = 0.4},
    {.name        = "incremental",
     .brief       = "p = p^n + phi; steady flow converges very slowly for nu dt >> L^2",
     .citation    = "van Kan, SIAM J. Sci. Stat. Comput. 7 (1986)",
     .incremental = PETSC_TRUE,
     .alpha_max   = 0.4},
    {.name      = "chorin",
     .brief     = "p = phi, no pressure in the predictor: first order",
     .citation  = "Chorin, Math. Comput. 22 (1968)",
     .alpha_max = 0.9},
};
const Table ProjectionTable = TABLE("Projections", projections);

#define SPACING_STANDARD 2.0 /* of -pressure_spacing [dx] */
#define LEAST_CELLS      2.5 /* of the splines along an axis; rounded to 3 */

static const PressurePointsRow points[] = {
    {.name = "same", .brief = "on the particles", .citation = ""},
    {.name     = "coarse",
     .brief    = "on B-splines of a coarser lattice, fixed in space: conserves volume exactly",
     .citation = "after Hoellig, Finite Element Methods with B-Splines, SIAM (2003)",
     .coarse   = PETSC_TRUE},
};
const Table PressurePointsTable = TABLE("Points of the pressure", points);

#define IMPLICIT_CFL 2.0 /* default of -cfl with implicit convection [-] */

static const ConvectionRow convections[] = {
    {.name     = "explicit",
     .brief    = "extrapolated from earlier steps, or an explicit part of the TS",
     .citation = ""},
    {.name     = "implicit",
     .brief    = "in the viscous matrix, with an extrapolated advecting velocity",
     .citation = "Baker, Dougalis & Karakashian, Math. Comput. 39 (1982)",
     .implicit = PETSC_TRUE},
};
const Table ConvectionTable = TABLE("Convection of fixed particles", convections);

enum { PROJECTION, CONVECTION, POINTS, SPACING, ALPHA, FILTER };
static const OptionRow options[] = {
    [CONVECTION] =
        {
            .name     = "-convection",
            .kind     = VALUE_NAME,
            .brief    = "convective term of fixed particles; implicit: -cfl is 2 by default",
            .standard = "explicit",
            .table    = &ConvectionTable,
            .where    = "-scheme projection with -motion eulerian, viscosity and convection",
        },
    [PROJECTION] =
        {
            .name     = "-projection",
            .kind     = VALUE_NAME,
            .brief    = "update of the pressure",
            .standard = "rotational",
            .table    = &ProjectionTable,
            .where    = "-scheme projection with pressure",
        },
    [POINTS] =
        {
            .name     = "-pressure_points",
            .kind     = VALUE_NAME,
            .brief    = "where the pressure is known",
            .standard = "coarse for moving particles, and for fixed ones without convection, up to "
                        "U dx/nu = 5 at walls, or everywhere with -spacing and -spacing_growth, or "
                        "between walls with -mls_degree 4; same in boxes "
                        "below 3 cells along an axis, and with an option of a pressure on "
                        "particles",
            .table    = &PressurePointsTable,
            .where    = "-scheme projection with pressure",
        },
    [SPACING] =
        {
            .name     = "-pressure_spacing",
            .kind     = VALUE_REAL,
            .brief    = "edge of a cell of the lattice of the pressure",
            .unit     = "dx",
            .standard = "2",
            .low      = 1.25,
            .high     = 4.0,
            .where    = "-pressure_points coarse",
        },
    [ALPHA] =
        {
            .name     = "-ppe_alpha",
            .kind     = VALUE_REAL,
            .brief    = "share of the density error in the pressure source; at most 0.4 unless "
                        "-projection chorin",
            .unit     = "-",
            .standard = "0",
            .low      = 0.0,
            .high     = 0.9,
            .where    = "-scheme projection with -pressure_points same",
        },
    [FILTER] =
        {
            .name     = "-ppe_filter",
            .kind     = VALUE_REAL,
            .brief    = "strength of the grid-scale filter of the pressure; 0: off",
            .unit     = "-",
            .standard = "1; 0.1 on lattices whose particles do not move and with -spacing and "
                        "-spacing_growth, with -convection implicit in steps above CFL 0.5 less, "
                        "as 1/dt",
            .low      = 0.0,
            .high     = 2.0,
            .where    = "-scheme projection with -pressure_points same",
        },
};
const OptionTable ProjectionOptions = OPTIONS("Projection", options);

/* Checks if particles are fixed and evenly spread: on a lattice, or relaxed. */
static PetscErrorCode AreOrdered(const Scene *scene, PetscBool *ordered)
{
  const PetscBool lattice = scene->jitter == 0.0 ? PETSC_TRUE : PETSC_FALSE;
  PetscBool       given;

  PetscFunctionBegin;
  PetscCall(OptionGiven("-particles", &given));
  *ordered =
      !SceneMoves(scene) && !given && (lattice || scene->grading.on) ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the largest mean of |div u| over a spline. */
static PetscErrorCode DivergenceOnSplines(Flow *flow, const Vec u[], PetscReal *largest)
{
  Projection *pr = (Projection *)flow->scheme->data;
  Splines    *s  = pr->splines;

  PetscFunctionBegin;
  PetscCall(SplinesDivergence(flow, s, u, flow->clock->t + flow->clock->dt, s->b));
  PetscCall(VecPointwiseDivide(s->b, s->b, s->mass));
  PetscCall(VecNorm(s->b, NORM_INFINITY, largest));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes this rank's part of the pressure at a point [Pa]. */
static PetscErrorCode PressureOnSplines(const Flow *flow, const PetscReal x[], PetscReal *p)
{
  const Projection *pr = (const Projection *)flow->scheme->data;

  PetscFunctionBegin;
  PetscCall(SplinesPressure(pr->splines, flow->particles, x, p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the pressure over dt to its mean over a time `length`. */
static PetscErrorCode AverageOnSplines(Flow *flow, PetscReal length, PetscReal dt)
{
  Projection *pr = (Projection *)flow->scheme->data;

  PetscFunctionBegin;
  PetscCall(SplinesAverage(length, dt, pr->splines, flow->state->average.vec));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Refuses Chorin's projection between walls on fixed particles if viscosity does not damp grid
  modes. The cavity (n = 32, t = 4) has 1, 7, 20, 43 % more energy than with the rotational
  projection at U dx/nu = 6, 8, 10, 12, five times as much at 31 and eight times at 312.
*/
static PetscErrorCode RefuseGain(const Scene *scene, const ProjectionRow *row)
{
  const PetscReal R = SceneCellReynolds(scene);

  PetscFunctionBegin;
  UserCheck(!row || row->incremental || SceneMoves(scene) || !SceneHas(scene, PHYSICS_WALLS) ||
                !SceneHas(scene, PHYSICS_CONVECTION) || R <= 10.0,
            "-projection %s: on fixed particles between walls it feeds energy into the flow for U "
            "dx/nu above 10, here %.3g; use rotational or incremental, or a larger -n",
            row->name, (double)R);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the width of the box along an axis in cells of the splines. */
static PetscReal CellsAlong(const Scene *scene, PetscInt a, PetscReal spacing)
{
  return (scene->hi[a] - scene->lo[a]) / scene->dx / spacing;
}

/* Returns U e/nu, which decides if viscosity damps velocities between coarse points: with the cells
   at walls on lattices. Without a lattice the coarsest particles decide: at Re = 400 flows go
   through up to 12.5, at Re = 1000 all are lost from 18 on, with 3 to 5 at walls. */
static PetscReal DampingReynolds(const Scene *scene)
{
  return scene->grading.on ? SceneCellReynolds(scene) * (SceneCoarsest(scene) / scene->dx)
                           : SceneFinestReynolds(scene);
}

/* Returns the reason why a scene has no coarse points; NULL if there is none. */
static const char *CoarseFault(const Scene *scene)
{
  if (SceneHasFreeSurface(scene)) return "its lattice does not follow a free surface; use same";
  if (SceneHasBoundary(scene, BOUNDARY_OUTFLOW))
    return "its splines have no condition for the pressure of -scene_outflow; use same";
  for (PetscInt k = 0; k < scene->n_bodies && scene->dim == 3; k++)
    if (!BodyReachesThrough(SceneBody(scene, k), 2))
      return "its lattice takes bodies in 3D that reach through the box along z; use same";
  return NULL;
}

/*
  Chooses where the pressure is known

  By default the pressure is known on coarse points. There it has no noise from moving particles,
  and no condition at walls, whose error is of first order beside driven walls. A narrow box has no
  room for these points, and an option of the pressure on particles asks for the particles. On
  fixed particles viscosity has to damp what these points cannot see, see CreateOnSplines(); the
  bound leaves room for flows that are faster than U.
*/
static PetscErrorCode ChoosePoints(const Scene *scene, const PressurePointsRow **chosen)
{
  static const char *const of_particles[] = {"-ppe_alpha", "-ppe_filter", "-ppe_laplacian"};
  const PetscBool damped = !SceneHas(scene, PHYSICS_CONVECTION) || DampingReynolds(scene) <= 5.0;
  PetscBool       coarse, given;
  PetscInt        degree;

  PetscFunctionBegin;
  PetscCall(OperatorsDegree(&degree));
  coarse = !CoarseFault(scene) &&
           (SceneMoves(scene) || (degree == 4 ? SceneHas(scene, PHYSICS_WALLS) : damped));
  for (PetscInt a = 0; a < scene->dim; a++)
    coarse = coarse && CellsAlong(scene, a, SPACING_STANDARD) >= LEAST_CELLS;
  PetscCall(OptionGiven(options[POINTS].name, &given));
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(of_particles) && !given; k++) {
    PetscBool asks;

    PetscCall(OptionGiven(of_particles[k], &asks));
    coarse = coarse && !asks;
  }
  PetscCall(OptionGetRow(&options[POINTS], coarse ? "coarse" : "same", chosen));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Returns the default strength of the pressure filter on lattices and relaxed clouds of fixed
  particles [-]

  The filter leaves a divergence in proportion to S dt, see ShareOfResidual(). Therefore the long
  steps of implicit convection take a strength that keeps S dt at its value for the CFL number 0.5.
  In the cavity at Re = 1000, n = 64, CFL number 2, t = 40, the energy has errors of -9.8, -1.7,
  -0.6, 3.3, 8.0 % for S = 0, 0.02, 0.025, 0.05, 0.1, and of 2.5 % with explicit convection.
  The strength 1 gives far more energy, beside bodies too: between lids with a cylinder, Re = 1000,
  16 % too much in place of 1.7 % on a lattice with n = 64, and 11 % in place of 0.4 % on a relaxed
  cloud of 3504 particles. A lattice that is disturbed by 0.2 dx needs it: with 0.1 the flow around
  a small cylinder at Re = 1000, n = 40, is lost.
*/
static PetscReal LatticeFilter(const Flow *flow)
{
  const Clock    *clock = flow->clock;
  const PetscReal given = clock->dt_given * flow->scene->speed / flow->scene->dx;
  const PetscReal cfl   = clock->dt_given > 0.0 ? given : clock->cfl;

  return 0.1 * (flow->state->implicit_convection ? PetscMin(1.0, CLOCK_CFL / cfl) : 1.0);
}

/* Returns true if moving particles beside a free surface have rows of fits, see FlowMove(). */
static PetscBool SurfaceNeedsFilter(const Scene *scene)
{
  return SceneHasFreeSurface(scene) && SceneMoves(scene) && SceneHas(scene, PHYSICS_VISCOSITY) &&
                 !SceneViscosityVaries(scene)
             ? PETSC_TRUE
             : PETSC_FALSE;
}

/* Reads the options of a pressure on the particles. */
static PetscErrorCode CreateOnParticles(Flow *flow, Projection *pr)
{
  PetscBool ordered = PETSC_FALSE, given;

  PetscFunctionBegin;
  PetscCall(VolumesCreate(flow));
  PetscCall(AreOrdered(flow->scene, &ordered));
  pr->filter = ordered ? LatticeFilter(flow) : 1.0;
  PetscCall(OptionGetReal(&options[ALPHA], &pr->alpha, NULL));
  UserCheck(pr->alpha <= pr->row->alpha_max,
            "-ppe_alpha %.6g: with -projection %s at most %.6g is stable", (double)pr->alpha,
            pr->row->name, (double)pr->row->alpha_max);
  PetscCall(OptionGetReal(&options[FILTER], &pr->filter, NULL));
  if (pr->filter > 0.0) flow->scheme->needs |= NEED_FILTER_P;
  PetscCall(OptionGiven("-velocity_filter", &given));
  if (SurfaceNeedsFilter(flow->scene) && (!given || flow->state->velocity_filter > 0.0))
    flow->scheme->needs |= NEED_FILTER_U;
  if (pr->alpha > 0.0) flow->scheme->needs |= NEED_CONCENTRATION;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Reads the options of a pressure on splines

  A pressure that is coarser than the particles does not act on velocities between its points. The
  velocity filter damps them, by default four times as fast as the flow can amplify them. In the
  cavity at Re = 1000, n = 32, t = 6 the energy has errors of -31, -17, -12, -7 % for S = 0, 0.6, 1,
  4, and -10 % with the pressure on particles. The filter of fixed particles
  does not act between the points: at Re = 1000, t = 4 their energy is 31 % too large for n = 50,
  and 3 % too small for n = 100.
*/
static PetscErrorCode CreateOnSplines(Flow *flow, Projection *pr)
{
  const PetscReal R = DampingReynolds(flow->scene);
  PetscBool       given;
  PetscInt        degree;

  PetscFunctionBegin;
  PetscCall(OperatorsDegree(&degree));
  UserCheck(SceneMoves(flow->scene) || !SceneHas(flow->scene, PHYSICS_CONVECTION) || R <= 15.0 ||
                degree == 4,
            "-pressure_points coarse: on fixed particles it feeds energy into the flow for U dx/nu "
            "above 15, here %.3g%s",
            (double)R,
            flow->scene->grading.on ? " for the largest spacing; use same, or a larger -n"
                                    : " at walls; use same, -mls_degree 4 on a lattice, a larger "
                                      "-n, or a smaller -spacing_wall");
  pr->spacing = SPACING_STANDARD;
  PetscCall(OptionGetReal(&options[SPACING], &pr->spacing, NULL));
  for (PetscInt a = 0; a < flow->scene->dim; a++) {
    const PetscReal cells = CellsAlong(flow->scene, a, pr->spacing);

    UserCheck(cells >= LEAST_CELLS,
              "-pressure_points coarse: the box is only %.3g cells of -pressure_spacing %.3g wide "
              "along %c, at least 3 are needed; use a larger -n",
              (double)cells, (double)pr->spacing, "xyz"[a]);
  }
  flow->scheme->needs &= ~(unsigned)NEED_PRESSURE;
  flow->scheme->Divergence = DivergenceOnSplines;
  flow->scheme->Pressure   = PressureOnSplines;
  flow->scheme->Average    = AverageOnSplines;
  PetscCall(OptionGiven("-velocity_filter", &given));
  if (SceneMoves(flow->scene) && !given) flow->state->velocity_filter = 4.0;
  if (flow->state->velocity_filter > 0.0) flow->scheme->needs |= NEED_FILTER_U;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads -convection; implicit convection takes longer steps by default. */
static PetscErrorCode ReadConvection(Flow *flow)
{
  const ConvectionRow *row;
  PetscBool            given;

  PetscFunctionBegin;
  if (!flow->state->has_convection || !SceneHas(flow->scene, PHYSICS_VISCOSITY))
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(OptionGetRow(&options[CONVECTION], NULL, &row));
  flow->state->implicit_convection = row->implicit;
  if (row->implicit) flow->scheme->needs |= NEED_MATRICES;
  PetscCall(OptionGiven("-cfl", &given));
  if (row->implicit && !given) {
    flow->clock->cfl = IMPLICIT_CFL;
    PetscCall(SchemeChooseStep(flow));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  ProjectionCreate - Reads the options of the projection

  Collective on PETSC_COMM_WORLD.

  Options Database Keys:
+ -projection name      - row of the table of projections
. -convection name      - explicit or implicit
. -pressure_points name - same or coarse, see ChoosePoints()
. -pressure_spacing H   - edge of a cell of coarse points [dx]
. -ppe_alpha A          - share of the density error in the pressure source (Zheng et al. 2018,
                          Eq. 13)
- -ppe_filter S         - strength of the pressure filter, by default 1, or 0.1 if particles stay
                          on the initial lattice or relaxed cloud; see ShareOfResidual()
*/
PetscErrorCode ProjectionCreate(Flow *flow)
{
  const Scene             *scene = flow->scene;
  const PressurePointsRow *points_row;
  Projection              *pr;

  PetscFunctionBegin;
  PetscCall(PetscNew(&pr));
  flow->scheme->data = pr;
  UserCheck(!flow->clock->steady_solve,
            "-steady: -scheme %s advances in time; use -scheme coupled, or -steady_tol",
            flow->scheme->row->name);
  UserCheck(flow->clock->dt_given <= 2.0 * ProjectionFreeLimit(scene),
            "-dt %.6g: with a free surface and -scheme %s at most %.3g s, 0.2 dx^2/nu; use -scheme "
            "coupled for longer steps",
            (double)flow->clock->dt_given, flow->scheme->row->name,
            (double)(2.0 * ProjectionFreeLimit(scene)));
  PetscCall(ReadConvection(flow));
  if (SceneHas(scene, PHYSICS_PRESSURE)) {
    PetscCall(OptionGetRow(&options[PROJECTION], NULL, &pr->row));
    PetscCall(ChoosePoints(scene, &points_row));
    UserCheck(points_row->coarse || !SceneMovesGraded(scene),
              "-pressure_points same: flows of graded particles that move are lost with it; use "
              "coarse, with a box at least 6 dx wide, or -motion eulerian");
    UserCheck(!points_row->coarse || !CoarseFault(scene), "-pressure_points coarse: %s",
              CoarseFault(scene));
    if (points_row->coarse) PetscCall(CreateOnSplines(flow, pr));
    else PetscCall(CreateOnParticles(flow, pr));
    flow->scheme->variant = (const TableRow *)(const void *)pr->row;
  }
  PetscCall(SteadyRefuse(flow, pr->row ? pr->row->name : NULL,
                         pr->row && pr->row->rotational ? PETSC_TRUE : PETSC_FALSE));
  PetscCall(RefuseGain(scene, pr->row));
  PetscCall(MemoryAddReal(&flow->scheme->memory, "wall_slope_share", &pr->wall_slope_share));
  PetscFunctionReturn(PETSC_SUCCESS);
}
