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
            .brief    = "convective term of fixed particles",
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
            .standard = REGIME,
            .table    = &PressurePointsTable,
            .where    = "-scheme projection with pressure",
        },
    [SPACING] =
        {
            .name     = "-pressure_spacing",
            .expert   = PETSC_TRUE,
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
            .expert   = PETSC_TRUE,
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
            .expert   = PETSC_TRUE,
            .kind     = VALUE_REAL,
            .brief    = "strength of the grid-scale filter of the pressure; 0: off",
            .unit     = "-",
            .standard = REGIME,
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

/* Refuses Chorin's projection where it feeds energy into the flow. */
static PetscErrorCode RefuseGain(const Scene *scene, const ProjectionRow *row)
{
  PetscFunctionBegin;
  UserCheck(!row || row->incremental || RegimeAllows(scene->regime, REGIME_CHORIN_HOLDS),
            "-projection %s: on fixed particles between walls it feeds energy into the flow for U "
            "dx/nu above %.3g, here %.3g; use rotational or incremental, or a larger -n",
            row->name, (double)RegimeFind(scene->regime, REGIME_CHORIN_HOLDS)->range.above,
            (double)scene->regime->number[NUMBER_CELL]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the width of the box along an axis in cells of the splines. */
static PetscReal CellsAlong(const Scene *scene, PetscInt a, PetscReal spacing)
{
  return (scene->hi[a] - scene->lo[a]) / scene->dx / spacing;
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

/* Sets the facts that decide on coarse points, and chooses where the pressure is known. */
static PetscErrorCode ChoosePoints(const Scene *scene, const PressurePointsRow **chosen)
{
  static const char *const of_particles[] = {"-ppe_alpha", "-ppe_filter", "-ppe_laplacian"};
  Regime                  *regime         = scene->regime;
  PetscBool                narrow = PETSC_FALSE, asks = PETSC_FALSE, given;
  PetscInt                 degree;

  PetscFunctionBegin;
  PetscCall(OperatorsDegree(scene, &degree));
  for (PetscInt a = 0; a < scene->dim; a++)
    if (CellsAlong(scene, a, SPACING_STANDARD) < LEAST_CELLS) narrow = PETSC_TRUE;
  PetscCall(
      OptionGiven(options[POINTS].name, &given)); /* then these are read only if it uses them */
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(of_particles) && !given && !asks; k++)
    PetscCall(OptionGiven(of_particles[k], &asks));
  RegimeSetFact(regime, FACT_UNFIT, CoarseFault(scene) ? PETSC_TRUE : PETSC_FALSE);
  RegimeSetFact(regime, FACT_NARROW, narrow);
  RegimeSetFact(regime, FACT_ASKED, asks);
  PetscCall(OptionGetRow(&options[POINTS], RegimeWord(regime, REGIME_POINTS), chosen));
  RegimeSetFact(regime, FACT_COARSE, (*chosen)->coarse);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the default strength of the pressure filter [-]; collective */
static PetscErrorCode DefaultFilter(const Flow *flow, PetscReal *strength)
{
  const Clock    *clock   = flow->clock;
  const PetscReal given   = clock->dt_given * flow->scene->speed / flow->scene->dx;
  Regime         *regime  = flow->scene->regime;
  PetscBool       ordered = PETSC_FALSE;

  PetscFunctionBegin;
  PetscCall(AreOrdered(flow->scene, &ordered));
  RegimeSetFact(regime, FACT_ORDERED, ordered);
  regime->number[NUMBER_COURANT] = clock->dt_given > 0.0 ? given : clock->cfl;
  *strength                      = RegimeValue(regime, REGIME_FILTER_P);
  PetscFunctionReturn(PETSC_SUCCESS);
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
  PetscBool given;

  PetscFunctionBegin;
  PetscCall(VolumesCreate(flow));
  PetscCall(DefaultFilter(flow, &pr->filter));
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

/* Reads the options of a pressure on splines. */
static PetscErrorCode CreateOnSplines(Flow *flow, Projection *pr)
{
  Regime   *regime = flow->scene->regime;
  PetscBool given;

  PetscFunctionBegin;
  UserCheck(RegimeAllows(regime, REGIME_COARSE_HOLDS),
            "-pressure_points coarse: on fixed particles it feeds energy into the flow for U dx/nu "
            "above %.3g, here %.3g%s",
            (double)RegimeFind(regime, REGIME_COARSE_HOLDS)->range.above,
            (double)regime->number[NUMBER_DAMPING],
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
  if (SceneMoves(flow->scene) && !given)
    flow->state->velocity_filter = RegimeValue(regime, REGIME_FILTER_U);
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
  RegimeSetFact(flow->scene->regime, FACT_IMPLICIT, row->implicit);
  if (row->implicit) flow->scheme->needs |= NEED_MATRICES;
  PetscCall(OptionGiven("-cfl", &given));
  if (row->implicit && !given) {
    flow->clock->cfl = RegimeValue(flow->scene->regime, REGIME_COURANT);
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
