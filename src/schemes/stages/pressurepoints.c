/* The points of the pressure, which schemes share: the choice between particles and splines, the
   options of splines, and what a scheme with splines answers about its pressure. */
#include "pressurepoints.h"

#define SPACING_STANDARD 2.0 /* of -pressure_spacing [dx] */
#define LEAST_CELLS      2.5 /* of the splines along an axis; rounded to 3 */

static const PressurePointsRow points[] = {
    {.name = "same", .brief = "on the particles"},
    {.name     = "coarse",
     .brief    = "on B-splines of a coarser lattice, fixed in space: conserves volume exactly",
     .citation = "after Hoellig, Finite Element Methods with B-Splines, SIAM (2003)",
     .coarse   = PETSC_TRUE},
};
const Table PressurePointsTable = TABLE("Points of the pressure", points);

enum { POINTS, SPACING };
static const OptionRow options[] = {
    [POINTS]  = OPTION(NAME, "-pressure_points", "where the pressure is known", NULL, REGIME,
                       .table = &PressurePointsTable,
                       .where = "-scheme projection with pressure, or coupled"),
    [SPACING] = OPTION(REAL, "-pressure_spacing", "edge of a cell of the lattice of the pressure",
                       "dx", "2", .expert = PETSC_TRUE, .low = 1.25, .high = 4.0,
                       .where = "-pressure_points coarse"),
};
const OptionTable PressurePointsOptions = OPTIONS("Points of the pressure", options);

/* Computes the largest mean of |div u| over a spline. */
static PetscErrorCode DivergenceOnSplines(Flow *flow, const Vec u[], PetscReal *largest)
{
  Splines *s = flow->scheme->splines;
  Vec      mean;

  PetscFunctionBegin;
  PetscCall(SplinesDivergence(flow, s, u, flow->clock->t + flow->clock->dt, s->b));
  PetscCall(VecDuplicate(s->mass, &mean));
  PetscCall(SplinesSumFluids(s, s->b, mean));
  PetscCall(VecPointwiseDivide(mean, mean, s->mass));
  PetscCall(VecNorm(mean, NORM_INFINITY, largest));
  PetscCall(VecDestroy(&mean));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes this rank's part of the pressure at a point [Pa]. */
static PetscErrorCode PressureOnSplines(const Flow *flow, const PetscReal x[], PetscReal *p)
{
  PetscFunctionBegin;
  PetscCall(SplinesPressure(flow->scheme->splines, flow->particles, x, p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the forces of the pressure on own wall particles. */
static PetscErrorCode PressOnWalls(const Flow *flow, PetscReal force[])
{
  PetscFunctionBegin;
  PetscCall(SplinesPressOnWalls(flow->scheme->splines, flow->scheme->splines->all, force));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the width of the box along an axis in cells of the splines. */
static PetscReal CellsAlong(const Scene *scene, PetscInt a, PetscReal spacing)
{
  return (scene->hi[a] - scene->lo[a]) / scene->dx / spacing;
}

/* PressurePointsChoose - Reads -pressure_points, and sets the facts that decide on its default;
   collective. Errors: refuses coarse points where they have no conditions. */
PetscErrorCode PressurePointsChoose(const Scene *scene, const PressurePointsRow **chosen)
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
  RegimeSetFact(regime, FACT_NARROW, narrow);
  RegimeSetFact(regime, FACT_ASKED, asks);
  PetscCall(OptionGetRow(&options[POINTS], RegimeWord(regime, REGIME_POINTS), chosen));
  RegimeSetFact(regime, FACT_COARSE, (*chosen)->coarse);
  UserCheck((*chosen)->coarse || !SceneMixes(scene),
            "-pressure_points same: it has one density, and no tension of interfaces; use coarse, "
            "with a box at least 6 dx wide");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* PressureOnSplinesCreate - Reads the options of a pressure on splines, and gives the scheme the
   answers of splines. Collective. Output: spacing - edge of a cell of the splines, for
   SplinesCreate() [dx]. Errors: refuses boxes that are too narrow. */
PetscErrorCode PressureOnSplinesCreate(Flow *flow, PetscReal *spacing)
{
  PetscBool given = PETSC_TRUE;

  PetscFunctionBegin;
  *spacing = SPACING_STANDARD;
  PetscCall(OptionGetReal(&options[SPACING], spacing, NULL));
  for (PetscInt a = 0; a < flow->scene->dim; a++) {
    const PetscReal cells = CellsAlong(flow->scene, a, *spacing);

    UserCheck(cells >= LEAST_CELLS,
              "-pressure_points coarse: the box is only %.3g cells of -pressure_spacing %.3g wide "
              "along %c, at least 3 are needed; use a larger -n",
              (double)cells, (double)*spacing, "xyz"[a]);
  }
  flow->scheme->needs &= ~(unsigned)NEED_PRESSURE;
  flow->scheme->Divergence   = DivergenceOnSplines;
  flow->scheme->Pressure     = PressureOnSplines;
  flow->scheme->PressOnWalls = PressOnWalls;
  if (flow->state->has_convection || SceneMoves(flow->scene))
    PetscCall(OptionGiven("-velocity_filter", &given));
  if (!given && !SceneHasFreeSurface(flow->scene)) /* it would not keep momentum */
    flow->state->velocity_filter = RegimeValue(flow->scene->regime, REGIME_FILTER_U);
  if (flow->state->velocity_filter > 0.0) flow->scheme->needs |= NEED_FILTER_U;
  PetscFunctionReturn(PETSC_SUCCESS);
}
