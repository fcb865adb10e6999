/* The regime of a flow: its facts and numbers, the rows that hold, and their print. Callers add the
   facts of their own options before they read a default. */
#include "isph/scene.h"
#include <stdlib.h>
#include <string.h>

/* The words of a fact for texts about rows; NULL: its absence needs no words. */
static const char *const words[FACTS][2] = {
    {"moving particles", "fixed particles"},
    {"a free surface", "no free surface"},
    {"walls", "no walls"},
    {"convection", "no convection"},
    {"a pressure", "no pressure"},
    {"a viscosity that varies", "a uniform viscosity"},
    {"a pressure or bodies", "no pressure and no body"},
    {"several sizes of particles", NULL},
    {"walls or forces that depend on t", NULL},
    {"a viscosity by the strain rate", NULL},
    {"a box below 3 cells of the pressure along an axis", NULL},
    {"-dt", NULL},
    {"-steady", NULL},
    {"several fluids", "one fluid"},
    {"-convection implicit", "explicit convection"},
    {"fixed particles on a lattice or relaxed", "moving or disordered particles"},
    {"-mls_degree 3", NULL},
    {"-mls_degree 4", NULL},
    {"Laplacians exact for quadratic functions", "other Laplacians"},
    {"a form that needs particles behind walls", "forms of fits"},
    {"-pressure_points coarse", "-pressure_points same"},
    {"-ppe_alpha, -ppe_filter or -ppe_laplacian", NULL},
    {"-velocity_filter above 1", "-velocity_filter up to 1"},
    {"-scheme wcsph", "other schemes"},
    {"-density_form summation", NULL},
    {"a shift", "no shift"},
    {"particles of several sizes on no lattice", NULL},
};

/* A number that rows compare. */
typedef struct {
  const char *name;
  const char *meaning;
  PetscBool   closed; /* ranges have their lower bound, not their upper one */
} NumberRow;
static const NumberRow numbers[NUMBERS] = {
    [NUMBER_NONE]      = {NULL, NULL, PETSC_FALSE},
    [NUMBER_CELL]      = {"U dx/nu", "the least viscosity", PETSC_FALSE},
    [NUMBER_STIFFNESS] = {"nu dt/e^2", "the largest viscosity, e the smallest edge of a cell",
                          PETSC_TRUE},
    [NUMBER_COURANT]   = {"U dt/dx", "the CFL number", PETSC_FALSE},
};

/* Returns U dx/nu with the least viscosity; infinite without viscosity. */
static PetscReal CellReynolds(const Scene *scene)
{
  if (!SceneHas(scene, PHYSICS_VISCOSITY)) return PETSC_INFINITY;
  return scene->speed * scene->dx / scene->nu_low;
}

/* RegimeSetFact - States if a fact holds */
void RegimeSetFact(Regime *regime, Fact fact, PetscBool holds)
{
  if (holds) regime->facts |= (unsigned)fact;
  else regime->facts &= ~(unsigned)fact;
}

/* RegimeCreate - Creates the regime with the facts and numbers of the scene. To be freed by the
   caller. */
PetscErrorCode RegimeCreate(const Scene *scene, Regime **regime)
{
  const PetscReal cell = CellReynolds(scene);
  Regime         *r;

  PetscFunctionBegin;
  PetscCall(PetscNew(&r));
  RegimeSetFact(r, FACT_MOVES, SceneMoves(scene));
  RegimeSetFact(r, FACT_SURFACE, SceneHasFreeSurface(scene));
  RegimeSetFact(r, FACT_WALLS, SceneHas(scene, PHYSICS_WALLS));
  RegimeSetFact(r, FACT_CONVECTION, scene->motion ? PETSC_TRUE : PETSC_FALSE);
  RegimeSetFact(r, FACT_PRESSURE, SceneHas(scene, PHYSICS_PRESSURE));
  RegimeSetFact(r, FACT_VARIES, SceneViscosityVaries(scene));
  RegimeSetFact(r, FACT_CURVED, SceneHas(scene, PHYSICS_PRESSURE) || scene->n_bodies);
  RegimeSetFact(r, FACT_GRADED, SceneIsMapped(scene) || scene->grading.on);
  RegimeSetFact(r, FACT_CLOUD, scene->grading.on);
  RegimeSetFact(r, FACT_DRIVEN, SceneIsDrivenInTime(scene));
  RegimeSetFact(r, FACT_NONLINEAR, SceneIsNewtonian(scene) ? PETSC_FALSE : PETSC_TRUE);
  RegimeSetFact(r, FACT_FLUIDS, SceneFluids(scene) > 1);
  RegimeSetFact(r, FACT_MIXES, SceneMixes(scene));
  r->number[NUMBER_CELL] = cell;
  *regime                = r;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* RegimeHolds - Returns true if a row of a choice holds */
PetscBool RegimeHolds(const Regime *regime, RegimeChoice choice, const RegimeRow *row)
{
  const RegimeNumber number = RegimeTables[choice].number;
  const PetscReal    x      = regime->number[number];
  const PetscBool    closed = numbers[number].closed;

  if ((regime->facts & row->holds) != row->holds || regime->facts & row->lacks) return PETSC_FALSE;
  if (row->range.above > 0.0 && (closed ? x < row->range.above : x <= row->range.above))
    return PETSC_FALSE;
  return row->range.upto > 0.0 && (closed ? x >= row->range.upto : x > row->range.upto)
             ? PETSC_FALSE
             : PETSC_TRUE;
}

/* RegimeFind - Returns the row that holds for a choice */
const RegimeRow *RegimeFind(const Regime *regime, RegimeChoice choice)
{
  const RegimeTable *table = &RegimeTables[choice];
  const RegimeRow   *found = NULL;

  for (PetscInt k = 0; k < table->count && !found; k++)
    if (RegimeHolds(regime, choice, &table->rows[k])) found = &table->rows[k];
  return found;
}

/* RegimeWord - Reads a default that is a name */
const char *RegimeWord(Regime *regime, RegimeChoice choice)
{
  regime->asked |= 1U << choice;
  return RegimeFind(regime, choice)->value;
}

/* Computes the value of a row for a number. */
static PetscReal ValueOf(const RegimeRow *row, PetscReal x)
{
  const PetscReal value = strtod(row->value, NULL);

  if (row->range.law == VALUE_RAMP)
    return (x - row->range.above) / (row->range.upto - row->range.above) * value;
  return row->range.law == VALUE_INVERSE ? value * (row->range.above / x) : value;
}

/* RegimeValue - Reads a default that is a number */
PetscReal RegimeValue(Regime *regime, RegimeChoice choice)
{
  regime->asked |= 1U << choice;
  return ValueOf(RegimeFind(regime, choice), regime->number[RegimeTables[choice].number]);
}

/* RegimeAllows - Returns true if the flow allows a choice */
PetscBool RegimeAllows(Regime *regime, RegimeChoice choice)
{
  return RegimeFind(regime, choice)->value ? PETSC_TRUE : PETSC_FALSE;
}

/* Writes the range of a number as "up to 5", "above 5" or "above 5 up to 20", empty without one. */
static void RangeText(PetscReal above, PetscReal upto, PetscBool closed, char text[64])
{
  char part[32] = "";

  text[0] = '\0';
  if (above > 0.0) (void)snprintf(text, 64, closed ? " at least %g" : " above %g", (double)above);
  if (upto > 0.0) (void)snprintf(part, 32, closed ? " below %g" : " up to %g", (double)upto);
  TextAppend(text, 64, part);
}

/* Appends a default to a list of options, unless the user gave the option. */
static PetscErrorCode AppendOption(const Regime *regime, const RegimeTable *table,
                                   const RegimeRow *row, char options[], size_t size)
{
  const PetscReal value = ValueOf(row, regime->number[table->number]);
  char            text[64];
  PetscBool       given;

  PetscFunctionBegin;
  PetscCall(OptionGiven(table->option, &given));
  if (given) PetscFunctionReturn(PETSC_SUCCESS);
  (void)snprintf(text, sizeof(text), "%.3g", (double)value);
  TextAppend(options, size, options[0] ? " " : ": ");
  TextAppend(options, size, table->option);
  TextAppend(options, size, " ");
  TextAppend(options, size, row->range.law == VALUE_CONSTANT ? row->value : text);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* RegimeView - Prints the regime as a line of the banner: the range of U dx/nu in which no default
   changes, and the defaults that hold, as options. Collective on the viewer. Options that the user
   gave are left out. */
PetscErrorCode RegimeView(const Regime *regime, PetscViewer viewer)
{
  const PetscReal cell  = regime->number[NUMBER_CELL];
  PetscReal       above = 0.0, upto = PETSC_INFINITY;
  char            options[256] = "", range[64];

  PetscFunctionBegin;
  for (PetscInt k = 0; k < REGIMES; k++) {
    const RegimeTable *table = &RegimeTables[k];
    const RegimeRow   *row   = RegimeFind(regime, (RegimeChoice)k);

    if (!table->shown || !(regime->asked & 1U << k)) continue;
    PetscCall(AppendOption(regime, table, row, options, sizeof(options)));
    if (regime->number[table->number] != cell) continue;
    above = PetscMax(above, row->range.above);
    if (row->range.upto > 0.0) upto = PetscMin(upto, row->range.upto);
  }
  RangeText(above, upto < PETSC_INFINITY ? upto : 0.0, PETSC_FALSE, range);
  PetscCall(PetscViewerASCIIPrintf(viewer, "%-11s %s, ", "regime",
                                   regime->facts & FACT_MOVES ? "moving" : "fixed"));
  if (cell < PETSC_INFINITY)
    PetscCall(PetscViewerASCIIPrintf(viewer, "U dx/nu = %.3g%s%s\n", (double)cell, range, options));
  else PetscCall(PetscViewerASCIIPrintf(viewer, "no viscosity%s\n", options));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes the flows of a row: facts, then the range of the number. */
static void FlowsText(const RegimeTable *table, const RegimeRow *row, char text[], size_t size)
{
  const NumberRow *number = &numbers[table->number];
  char             range[64], part[96] = "";

  text[0] = '\0';
  for (PetscInt k = 0; k < FACTS; k++) {
    const unsigned bit = 1U << k;

    if (row->holds & bit) AppendWord(text, size, words[k][0]);
    else if (row->lacks & bit && words[k][1]) AppendWord(text, size, words[k][1]);
  }
  RangeText(row->range.above, row->range.upto, number->closed, range);
  if (range[0]) {
    (void)snprintf(part, sizeof(part), "%s%s", number->name, range);
    AppendWord(text, size, part);
  }
  if (!text[0]) TextAppend(text, size, "others");
}

static void ValueText(const RegimeRow *row, char text[], size_t size)
{
  const PetscReal value =
      row->range.law == VALUE_INVERSE ? strtod(row->value, NULL) * row->range.above : 0.0;

  if (row->range.law == VALUE_RAMP) (void)snprintf(text, size, "0 to %s, linear", row->value);
  else if (row->range.law == VALUE_INVERSE)
    (void)snprintf(text, size, "%g dx/(U dt)", (double)value);
  else (void)snprintf(text, size, "%s", row->value ? row->value : "refused");
}

/* RegimePrint - Prints the table of defaults that depend on the flow. Needs neither PETSc nor MPI
   to be initialized. Input: markdown - with reasons and pages of the manual, otherwise for
   -catalogue. */
void RegimePrint(FILE *out, PetscBool markdown)
{
  (void)fputs(markdown ? "\n## Defaults by the regime\n\n" : "\nDefaults by the regime\n", out);
  if (markdown)
    (void)fputs(
        "A default that depends on the flow is a row of this table. The first row of an option\n"
        "whose flows have the facts, and whose number is in the range, holds.\n",
        out);
  for (PetscInt k = 1; k < NUMBERS; k++)
    (void)fprintf(out, markdown ? "%s- %s: %s.\n" : "%s  %s: %s\n", k == 1 && markdown ? "\n" : "",
                  numbers[k].name, numbers[k].meaning);
  if (markdown)
    (void)fputs("\n| option | default | flows | reason | measured |\n"
                "| --- | --- | --- | --- | --- |\n",
                out);
  for (PetscInt k = 0; k < REGIMES; k++) {
    const RegimeTable *table = &RegimeTables[k];

    if (!markdown) (void)fprintf(out, "  %s\n", table->option);
    for (PetscInt q = 0; q < table->count; q++) {
      const RegimeRow *row = &table->rows[q];
      char             flows[512], value[64];

      FlowsText(table, row, flows, sizeof(flows));
      ValueText(row, value, sizeof(value));
      if (markdown)
        (void)fprintf(out, "| %s | %s | %s | %s | [%.*s](../%s) |\n", q ? "" : table->option, value,
                      flows, row->why, (int)strcspn(table->page, "."), table->page, table->page);
      else (void)fprintf(out, "    %-14s %s\n", value, flows);
    }
  }
}
