/* Scalars of -case scene: their options. */
#include "isph/quantities.h"
#include <ctype.h>
#include <string.h>

enum { NAME, START, DIFFUSIVITY, SOURCE, EXACT, VALUE, FLUX, EXCHANGE };
static const OptionRow options[] = {
    [NAME]        = OPTION(WORD, "-scene_scalar_<k>_name",
                           "name of scalar 1, 2, ... that the fluid carries, such as T: "
                                  "expressions, "
                                  "files and the report have it",
                           NULL, NULL, .also = " temperature dye ", .where = "-case scene"),
    [START]       = OPTION(EXPRESSION, "-scene_scalar_<k>_start",
                           "values of a scalar at the start, of x, y[, z]", NULL,
                           "-scene_scalar_<k>_exact at t = 0, or 0",
                           .where = "-case scene, scalars that have a name"),
    [DIFFUSIVITY] = OPTION(EXPRESSION, "-scene_scalar_<k>_diffusivity",
                           "diffusivity of a scalar, of x, y[, z], t and the scalars; one for all "
                           "fluids, or one of each fluid 0, 1, ...",
                           "m^2/s", "0: particles carry it exactly",
                           .where = "-case scene, scalars that have a name"),
    [SOURCE] =
        OPTION(EXPRESSION, "-scene_scalar_<k>_source",
               "source of a scalar per time, of x, y[, z], t, the scalars and the strain rate g = "
               "sqrt(2 E:E): nu*g^2/cp heats by friction; one for all fluids, or one of each",
               "1/s", "0", .where = "-case scene, scalars that have a name"),
    [EXACT] = OPTION(EXPRESSION, "-scene_scalar_<k>_exact",
                     "reference solution of a scalar, of x, y[, z], t: errors are reported", NULL,
                     NULL, .where = "-case scene, scalars that have a name"),
    [VALUE] =
        OPTION(WORD, "-scene_scalar_<k>_value",
               "values at boundaries, of x, y[, z], t, as \"left: 1; body_1: sin(t)\"; the place "
               "walls stands for all boundaries",
               NULL, "no boundary gives one", .where = "-case scene, scalars that have a name"),
    [FLUX]     = OPTION(WORD, "-scene_scalar_<k>_flux",
                        "flux through boundaries into the fluid, D n.grad c, n out of the "
                            "fluid, of x, "
                            "y[, z], t, as \"bottom: 0.1\"",
                        "m/s", "0", .where = "-case scene, scalars that have a name"),
    [EXCHANGE] = OPTION(WORD, "-scene_scalar_<k>_exchange",
                        "exchange through boundaries, D n.grad c = h (c_outside - c): h and "
                        "c_outside, of x, y[, z], t, as \"top: 0.5,20\"",
                        "m/s", "0", .where = "-case scene, scalars that have a name"),
};
const OptionTable ScalarOptions = OPTIONS("Scalars", options);

/* Refuses a name that is no word, or has a meaning already. */
static PetscErrorCode CheckName(const ExpressionScope *scope, const char option[],
                                const char name[])
{
  PetscBool word = isalpha((unsigned char)name[0]) ? PETSC_TRUE : PETSC_FALSE;

  PetscFunctionBegin;
  for (const char *s = name; *s; s++)
    if (!isalnum((unsigned char)*s) && *s != '_') word = PETSC_FALSE;
  UserCheck(word && strlen(name) < sizeof(((ScalarGiven *)NULL)->name),
            "%s %s: at most %d letters, digits and _ are allowed, a letter first", option, name,
            (int)sizeof(((ScalarGiven *)NULL)->name) - 1);
  UserCheck(!ExpressionScopeKnows(scope, name),
            "%s %s: expressions have this name already; choose another", option, name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Names scalars 1, 2, ... for all expressions; n - their number. */
static PetscErrorCode ReadNames(ExpressionScope *scope, ScalarGiven given[], PetscInt *n)
{
  PetscFunctionBegin;
  *n = 0;
  for (PetscInt k = 1; k <= SCALARS_MOST + 1; k++) {
    char        name[OPTION_LENGTH];
    const char *text;
    PetscBool   there;
    OptionRow   row;

    OptionNumber(&options[NAME], k, name, &row);
    PetscCall(OptionTyped(name, &text, &there));
    if (!there) continue;
    UserCheck(k == *n + 1 && k <= SCALARS_MOST,
              "%s: numbers are 1, 2, ... without gaps, to at most %d", name, SCALARS_MOST);
    PetscCall(CheckName(scope, name, text));
    PetscCall(PetscStrncpy(given[k - 1].name, text, sizeof(given[k - 1].name)));
    PetscCall(ExpressionScopeField(scope, text));
    *n = k;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads "place: expression; place: expression". Input: law - an option. */
static PetscErrorCode ReadLaw(ExpressionScope *scope, PetscInt k, ScalarLaw law, ScalarGiven *s)
{
  const PetscInt wanted = law == SCALAR_EXCHANGE ? 2 : 1;
  char           name[OPTION_LENGTH], *copy, *part;
  const char    *text;
  PetscBool      there;
  OptionRow      row;

  PetscFunctionBegin;
  OptionNumber(&options[VALUE + (PetscInt)law], k, name, &row);
  PetscCall(OptionTyped(name, &text, &there));
  if (!there) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscStrallocpy(text, &copy));
  for (char *next = copy; next; next = part) {
    char           *at = next + strspn(next, " "), *colon;
    ScalarBoundary *b;

    part = strchr(next, ';');
    if (part) *part++ = '\0';
    colon = strchr(at, ':');
    UserCheck(colon, "%s '%s': a place, a colon and an expression are required, as \"left: 1\"",
              name, at);
    *colon = '\0';
    for (char *end = colon; end > at && end[-1] == ' ';) *--end = '\0';
    PetscCall(PetscRealloc(sizeof(*b) * (size_t)(s->n_boundary + 1), &s->boundary));
    b = &s->boundary[s->n_boundary++];
    PetscCall(PetscStrncpy(b->place, at, sizeof(b->place)));
    b->law = law;
    PetscCall(ExpressionSet(scope, name, colon + 1 + strspn(colon + 1, " "), wanted, wanted,
                            EXPRESSION_PLACE | EXPRESSION_TIME, &b->of));
    UserCheck(law != SCALAR_EXCHANGE || b->of.uses[0] || b->of.value[0] >= 0.0,
              "%s %s: %.6g: allowed is 0 or more", name, b->place, (double)b->of.value[0]);
  }
  PetscCall(PetscFree(copy));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadScalar(ExpressionScope *scope, PetscInt k, ScalarGiven *s)
{
  const struct {
    PetscInt    option, most;
    unsigned    allowed;
    Expression *to;
  } part[] = {
      {START, 1, EXPRESSION_PLACE, &s->start},
      {DIFFUSIVITY, EXPRESSION_MOST, EXPRESSION_PLACE | EXPRESSION_TIME | EXPRESSION_FIELDS,
       &s->diffusivity},
      {SOURCE, EXPRESSION_MOST,
       EXPRESSION_PLACE | EXPRESSION_TIME | EXPRESSION_FIELDS | EXPRESSION_STRAIN, &s->source},
      {EXACT, 1, EXPRESSION_PLACE | EXPRESSION_TIME, &s->exact},
  };

  PetscFunctionBegin;
  for (size_t q = 0; q < PETSC_STATIC_ARRAY_LENGTH(part); q++) {
    char      name[OPTION_LENGTH];
    OptionRow row;

    OptionNumber(&options[part[q].option], k, name, &row);
    PetscCall(ExpressionGet(scope, &row, 1, part[q].most, part[q].allowed, part[q].to, NULL));
  }
  for (PetscInt c = 0; c < s->diffusivity.n; c++)
    UserCheck(s->diffusivity.uses[c] || s->diffusivity.value[c] >= 0.0,
              "%s %.6g: allowed is 0 or more", s->diffusivity.option,
              (double)s->diffusivity.value[c]);
  for (PetscInt law = 0; law < SCALAR_LAWS; law++) PetscCall(ReadLaw(scope, k, (ScalarLaw)law, s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ScalarsRead - Reads the scalars of a scene, and names them for all expressions that are set
   later. Collective on PETSC_COMM_WORLD. Output: scalars - NULL if there are none; n - their
   number. */
PetscErrorCode ScalarsRead(ExpressionScope *scope, ScalarGiven **scalars, PetscInt *n)
{
  PetscFunctionBegin;
  PetscCall(PetscCalloc1(SCALARS_MOST, scalars));
  PetscCall(ReadNames(scope, *scalars, n));
  for (PetscInt k = 0; k < *n; k++) PetscCall(ReadScalar(scope, k + 1, &(*scalars)[k]));
  if (!*n) PetscCall(PetscFree(*scalars));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ScalarAtStart - Returns a scalar at a place at the start */
PetscReal ScalarAtStart(const ScalarGiven *given, const PetscReal x[])
{
  const Expression *e = given->start.n ? &given->start : &given->exact;

  return e->n ? ExpressionValue(e, 0, 0.0, x) : 0.0;
}

/* ScalarsFree - Frees the descriptions */
PetscErrorCode ScalarsFree(ScalarGiven **scalars, PetscInt n)
{
  PetscFunctionBegin;
  for (PetscInt k = 0; k < n; k++) PetscCall(PetscFree((*scalars)[k].boundary));
  PetscCall(PetscFree(*scalars));
  PetscFunctionReturn(PETSC_SUCCESS);
}
