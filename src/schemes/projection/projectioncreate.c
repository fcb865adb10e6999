/* The options of the projection scheme: the update of the pressure, its filter, and the convection
   of fixed particles. Those of the points of the pressure are in pressurepoints.c. */
#include "projection.h"

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

static const ConvectionRow convections[] = {
    {.name = "explicit", .brief = "extrapolated from earlier steps, or an explicit part of the TS"},
    {.name     = "implicit",
     .brief    = "in the viscous matrix, with an extrapolated advecting velocity",
     .citation = "Baker, Dougalis & Karakashian, Math. Comput. 39 (1982)",
     .implicit = PETSC_TRUE},
};
const Table ConvectionTable = TABLE("Convection of fixed particles", convections);

enum { PROJECTION, CONVECTION, ALPHA, FILTER };
static const OptionRow options[] = {
    [CONVECTION] =
        OPTION(NAME, "-convection", "convective term of fixed particles", NULL, "explicit",
               .table = &ConvectionTable,
               .where = "-scheme projection with -motion eulerian, viscosity and convection"),
    [PROJECTION] = OPTION(NAME, "-projection", "update of the pressure", NULL, "rotational",
                          .table = &ProjectionTable, .where = "-scheme projection with pressure"),
    [ALPHA]      = OPTION(REAL, "-ppe_alpha",
                          "share of the density error in the pressure source; at most 0.4 unless "
                               "-projection chorin",
                          "-", "0", .expert = PETSC_TRUE, .low = 0.0, .high = 0.9,
                          .where = "-scheme projection with -pressure_points same"),
    [FILTER] =
        OPTION(REAL, "-ppe_filter", "strength of the grid-scale filter of the pressure; 0: off",
               "-", REGIME, .expert = PETSC_TRUE, .low = 0.0, .high = 2.0,
               .where = "-scheme projection with -pressure_points same"),
};
const OptionTable ProjectionOptions = OPTIONS("Projection", options);

/* Checks if particles are fixed and evenly spread: on a lattice, or relaxed. */
static PetscErrorCode AreOrdered(const Scene *scene, PetscBool *ordered)
{
  const PetscBool lattice = scene->jitter == 0.0;
  PetscBool       given;

  PetscFunctionBegin;
  PetscCall(OptionGiven("-particles", &given));
  *ordered = !SceneMoves(scene) && !given && (lattice || scene->grading.on);
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

/* Reads the options of a pressure on the particles. */
static PetscErrorCode CreateOnParticles(Flow *flow, Projection *pr)
{
  PetscFunctionBegin;
  PetscCall(DefaultFilter(flow, &pr->filter));
  PetscCall(OptionGetReal(&options[ALPHA], &pr->alpha, NULL));
  UserCheck(pr->alpha <= pr->row->alpha_max,
            "-ppe_alpha %.6g: with -projection %s at most %.6g is stable", (double)pr->alpha,
            pr->row->name, (double)pr->row->alpha_max);
  PetscCall(OptionGetReal(&options[FILTER], &pr->filter, NULL));
  if (pr->filter > 0.0) flow->scheme->needs |= NEED_FILTER_P;
  if (pr->alpha > 0.0) flow->scheme->needs |= NEED_CONCENTRATION;
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

/* ProjectionCreate - Reads the options of the projection; collective on PETSC_COMM_WORLD */
PetscErrorCode ProjectionCreate(Flow *flow)
{
  const Scene             *scene = flow->scene;
  const PressurePointsRow *points;
  Projection              *pr;

  PetscFunctionBegin;
  PetscCall(PetscNew(&pr));
  flow->scheme->data = pr;
  UserCheck(!flow->clock->steady_solve,
            "-steady: -scheme %s advances in time; use -scheme coupled, or -steady_tol",
            flow->scheme->row->name);
  UserCheck(!SceneHasFreeSurface(scene),
            "-scheme %s: it has no condition on a free surface; use -scheme coupled",
            flow->scheme->row->name);
  PetscCall(ReadConvection(flow));
  if (SceneHas(scene, PHYSICS_PRESSURE)) {
    PetscCall(OptionGetRow(&options[PROJECTION], NULL, &pr->row));
    PetscCall(PressurePointsChoose(scene, &points));
    UserCheck(points->coarse || !SceneMovesGraded(scene),
              "-pressure_points same: flows of graded particles that move are lost with it; use "
              "coarse, with a box at least 6 dx wide, or -motion eulerian");
    if (points->coarse) PetscCall(PressureOnSplinesCreate(flow, &pr->spacing));
    else PetscCall(CreateOnParticles(flow, pr));
    flow->scheme->variant = (const TableRow *)(const void *)pr->row;
  }
  PetscCall(SteadyRefuse(flow, pr->row ? pr->row->name : NULL, pr->row && pr->row->rotational));
  PetscCall(RefuseGain(scene, pr->row));
  PetscCall(MemoryAddReal(&flow->scheme->memory, "wall_slope_share", &pr->wall_slope_share));
  PetscFunctionReturn(PETSC_SUCCESS);
}
