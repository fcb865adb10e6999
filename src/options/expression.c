/* Expressions of x, y, z and t typed by the user. muParser parses and evaluates them. This file
   owns the parser handles, splits texts into components, and turns parser errors into messages of a
   single line. Plain numbers need no parser. && and || are operators of this file: muParser's own
   convert constant operands to int, so 0.5 && 1 is 0 and 41e30 is out of range. */
#include "isph/options.h"
#include <muParserDLL.h>
#include <stdlib.h>
#include <string.h>

#define SCOPE_CONSTANTS 8
#define SCOPE_PARSERS   192 /* 6 sides, 16 bodies and the fields of a scene need fewer */
#define TEXT_LENGTH     4096
#define COMPONENT_MAX   1000 /* muParser copies texts and messages to 2048 characters unchecked */

static const char *const axes[ISPH_MAX_DIM] = {"x", "y", "z"};

/* The operators && and || as functions. muParser refuses to define its own operators anew, so both
   have another name of the same length in muParser, in which ~ is the second character. */
#define OPERATOR_MARK '~'

static muFloat_t And(muFloat_t a, muFloat_t b)
{
  return a != 0.0 && b != 0.0;
}

static muFloat_t Or(muFloat_t a, muFloat_t b)
{
  return a != 0.0 || b != 0.0;
}

static const struct {
  const char *name;
  muFun2_t    Function;
  muInt_t     precedence; /* as of muParser's own operator */
} operators[] = {
    {"&~", And, 2},
    {"|~", Or, 1},
};

const Table FunctionTable = {.title = "Functions", .row_size = sizeof(FunctionRow)};

struct ExpressionScope {
  PetscInt         dim;
  const Table     *functions; /* besides FunctionTable; NULL: none */
  PetscInt         n_constants, n_parsers;
  char             name[SCOPE_CONSTANTS][16];
  PetscReal        constant[SCOPE_CONSTANTS];
  muParserHandle_t parser[SCOPE_PARSERS];
  muFloat_t        x[ISPH_MAX_DIM], t; /* position and time, read by parsers [m], [s] */
  PetscInt         n_fields;
  char             field_name[EXPRESSION_FIELDS_MOST][16];
  muFloat_t        field[EXPRESSION_FIELDS_MOST], rate; /* at the place, read by parsers */
  FieldsAt         fields;                              /* NULL: the fields are zero */
  void            *ctx;                                 /* of it */
  char             fault[512]; /* message for the first value that was not finite, or "" */
};

/* ExpressionScopeCreate - Creates a scope with the constant pi. Define other constants before the
   first expression is set. Input: dim - number of coordinates; functions - rows of FunctionRow,
   which must exist as long as the scope; NULL: none. */
PetscErrorCode ExpressionScopeCreate(PetscInt dim, const Table *functions, ExpressionScope **scope)
{
  PetscFunctionBegin;
  PetscCall(PetscNew(scope));
  (*scope)->dim       = dim;
  (*scope)->functions = functions;
  PetscCall(ExpressionScopeDefine(*scope, "pi", PETSC_PI));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ExpressionScopeDefine - Defines a constant for all expressions set later */
PetscErrorCode ExpressionScopeDefine(ExpressionScope *scope, const char name[], PetscReal value)
{
  PetscFunctionBegin;
  PetscCheck(scope->n_constants < SCOPE_CONSTANTS, PETSC_COMM_SELF, PETSC_ERR_PLIB,
             "no room for the constant %s", name);
  PetscCall(PetscStrncpy(scope->name[scope->n_constants], name, sizeof(scope->name[0])));
  scope->constant[scope->n_constants++] = value;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ExpressionScopeField - Names a field that expressions set later may use */
PetscErrorCode ExpressionScopeField(ExpressionScope *scope, const char name[])
{
  PetscFunctionBegin;
  PetscCheck(scope->n_fields < EXPRESSION_FIELDS_MOST, PETSC_COMM_SELF, PETSC_ERR_PLIB,
             "no room for the field %s", name);
  PetscCall(PetscStrncpy(scope->field_name[scope->n_fields++], name, sizeof(scope->field_name[0])));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ExpressionScopeKnows - Returns true if a name has a meaning in expressions already */
PetscBool ExpressionScopeKnows(const ExpressionScope *scope, const char name[])
{
  PetscBool known = !strcmp(name, "x") || !strcmp(name, "y") || !strcmp(name, "z") ||
                    !strcmp(name, "t") || !strcmp(name, "g");

  for (PetscInt k = 0; k < scope->n_constants; k++)
    if (!strcmp(name, scope->name[k])) known = PETSC_TRUE;
  for (PetscInt k = 0; k < scope->n_fields; k++)
    if (!strcmp(name, scope->field_name[k])) known = PETSC_TRUE;
  return known;
}

/* ExpressionScopeFieldsAt - Sets the function that gives the fields at a place and time */
void ExpressionScopeFieldsAt(ExpressionScope *scope, FieldsAt fields, void *ctx)
{
  scope->fields = fields;
  scope->ctx    = ctx;
}

/* ExpressionScopeDestroy - Destroys a scope with all its expressions */
PetscErrorCode ExpressionScopeDestroy(ExpressionScope **scope)
{
  PetscFunctionBegin;
  if (!*scope) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < (*scope)->n_parsers; k++) mupRelease((*scope)->parser[k]);
  PetscCall(PetscFree(*scope));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ExpressionScopeIsIdle - Returns true if all expressions of a scope are plain numbers, so that the
   scope is not needed */
PetscBool ExpressionScopeIsIdle(const ExpressionScope *scope)
{
  return scope->n_parsers ? PETSC_FALSE : PETSC_TRUE;
}

/* ExpressionScopeForget - Forgets a value that was not finite; returns true if there was one on
   this rank */
PetscBool ExpressionScopeForget(ExpressionScope *scope)
{
  const PetscBool fault = scope && scope->fault[0];

  if (fault) scope->fault[0] = '\0';
  return fault;
}

/* ExpressionScopeCheck - Ends the run if an expression had an infinite value or NaN on any rank;
   collective on PETSC_COMM_WORLD. Input: scope - may be NULL if there are no expressions. */
PetscErrorCode ExpressionScopeCheck(const ExpressionScope *scope)
{
  PetscMPIInt rank, first;
  char        fault[sizeof(scope->fault)];

  PetscFunctionBegin;
  if (!scope) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  first = scope->fault[0] ? rank : PETSC_MPI_INT_MAX;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_INT, MPI_MIN, PETSC_COMM_WORLD));
  if (first == PETSC_MPI_INT_MAX) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscStrncpy(fault, scope->fault, sizeof(fault)));
  PetscCallMPI(MPI_Bcast(fault, sizeof(fault), MPI_CHAR, first, PETSC_COMM_WORLD));
  UserCheck(PETSC_FALSE, "%s", fault);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Renames the operators && and || of a text to their names in muParser. */
static void RenameOperators(char text[])
{
  for (char *s = text; *s; s++) {
    if ((*s == '&' || *s == '|') && s[1] == *s) *++s = OPERATOR_MARK;
  }
}

/* Renames the operators of a text or a message of muParser to && and ||. */
static void RestoreOperators(char text[])
{
  for (char *s = text; *s; s++) {
    if (s[0] == '&' || s[0] == '|') s[1] = s[1] == OPERATOR_MARK ? s[0] : s[1];
  }
}

static muFloat_t CallFunction(void *row, const muFloat_t *argument, muInt_t n)
{
  const FunctionRow *f = (const FunctionRow *)row;

  return f->Value((PetscInt)n, argument, f->ctx);
}

/* Gives a parser the functions of a table. Their values are not taken for constant. */
static void DefineFunctions(const Table *table, muParserHandle_t parser)
{
  for (PetscInt k = 0; table && k < TableCount(table); k++) {
    void *row = (void *)(uintptr_t)TableGet(table, k);

    mupDefineMultFunUserData(parser, TableGet(table, k)->name, CallFunction, row, PETSC_FALSE);
  }
}

/* Creates a parser with the constants of the scope and the allowed variables. */
static PetscErrorCode ParserCreate(ExpressionScope *scope, unsigned allowed,
                                   muParserHandle_t *parser)
{
  PetscFunctionBegin;
  PetscCheck(scope->n_parsers < SCOPE_PARSERS, PETSC_COMM_SELF, PETSC_ERR_PLIB,
             "no room for another expression");
  *parser = scope->parser[scope->n_parsers++] = mupCreate(muBASETYPE_FLOAT);
  for (PetscInt k = 0; k < scope->n_constants; k++)
    mupDefineConst(*parser, scope->name[k], scope->constant[k]);
  for (PetscInt a = 0; a < scope->dim && (allowed & EXPRESSION_PLACE); a++)
    mupDefineVar(*parser, axes[a], &scope->x[a]);
  if (allowed & EXPRESSION_TIME) mupDefineVar(*parser, "t", &scope->t);
  for (PetscInt k = 0; k < scope->n_fields && (allowed & EXPRESSION_FIELDS); k++)
    mupDefineVar(*parser, scope->field_name[k], &scope->field[k]);
  if (allowed & EXPRESSION_STRAIN) mupDefineVar(*parser, "g", &scope->rate);
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(operators); k++)
    mupDefineOprt(*parser, operators[k].name, operators[k].Function, operators[k].precedence,
                  muOPRT_ASCT_LEFT, PETSC_TRUE);
  DefineFunctions(&FunctionTable, *parser);
  DefineFunctions(scope->functions, *parser);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lists the names that a text may contain, "x, y, t, pi, nu". */
static void AllowedNames(const ExpressionScope *scope, unsigned allowed, char names[],
                         size_t length)
{
  names[0] = '\0';
  for (PetscInt a = 0; a < scope->dim && (allowed & EXPRESSION_PLACE); a++)
    AppendWord(names, length, axes[a]);
  if (allowed & EXPRESSION_TIME) AppendWord(names, length, "t");
  for (PetscInt k = 0; k < scope->n_fields && (allowed & EXPRESSION_FIELDS); k++)
    AppendWord(names, length, scope->field_name[k]);
  if (allowed & EXPRESSION_STRAIN) AppendWord(names, length, "g");
  for (PetscInt k = 0; k < scope->n_constants; k++) AppendWord(names, length, scope->name[k]);
}

/* Returns true if a text has an assignment, "x = 3", which muParser would execute. */
static PetscBool Assigns(const char text[])
{
  for (const char *s = strchr(text, '='); s; s = strchr(s, '=')) {
    const PetscBool compares = s[1] == '=' || (s > text && strchr("<>!", s[-1]));

    if (!compares) return PETSC_TRUE;
    s += s[1] == '=' ? 2 : 1;
  }
  return PETSC_FALSE;
}

/* Returns the variables in a parsed component, as bits of ExpressionUse. */
static unsigned ParserUses(const ExpressionScope *scope, muParserHandle_t parser)
{
  const int count = mupGetExprVarNum(parser);
  unsigned  uses  = 0;

  for (int k = 0; k < count; k++) {
    const muChar_t *name;
    muFloat_t      *variable;

    mupGetExprVar(parser, (unsigned)k, &name, &variable);
    if (variable == &scope->t) uses |= EXPRESSION_TIME;
    else if (variable == &scope->rate) uses |= EXPRESSION_STRAIN;
    else if (variable >= scope->field && variable < scope->field + EXPRESSION_FIELDS_MOST)
      uses |= EXPRESSION_FIELDS;
    else uses |= EXPRESSION_PLACE;
  }
  return uses;
}

/* Copies the text of a parser, at most size - 1 letters, without the space that muParser
   appends. */
static void ParserText(muParserHandle_t parser, char text[], size_t size)
{
  size_t length;

  (void)snprintf(text, size, "%s", mupGetExpr(parser));
  length = strlen(text);
  while (length && text[length - 1] == ' ') text[--length] = '\0';
  RestoreOperators(text);
}

/* Copies muParser's message without its full stop; adds the position, counted from 0. */
static PetscErrorCode ParserComplaint(muParserHandle_t parser, char text[], size_t size)
{
  size_t length;

  PetscFunctionBegin;
  PetscCall(PetscStrncpy(text, mupGetErrorMsg(parser), size));
  PetscCall(PetscStrlen(text, &length));
  if (length && text[length - 1] == '.') text[--length] = '\0';
  if (!strstr(text, "position") && mupGetErrorPos(parser) >= 0)
    (void)snprintf(text + length, size - length, " at position %d", mupGetErrorPos(parser));
  RestoreOperators(text);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Appends a component to an expression: a number, or a parser if its text is not a number. */
static PetscErrorCode SetComponent(ExpressionScope *scope, const char text[], unsigned allowed,
                                   Expression *e)
{
  const PetscInt   c = e->n;
  char            *end, names[256], complaint[256], renamed[COMPONENT_MAX + 1];
  muParserHandle_t parser;

  PetscFunctionBegin;
  e->value[c] = strtod(text, &end);
  while (end != text && *end == ' ') end++;
  if (end == text || *end) {
    UserCheck(strlen(text) <= COMPONENT_MAX,
              "%s: component %" PetscInt_FMT " is longer than %d characters", e->option, c + 1,
              COMPONENT_MAX);
    AllowedNames(scope, allowed, names, sizeof(names));
    UserCheck(!Assigns(text), "%s '%s': = cannot assign a value here; == compares", e->option,
              text);
    UserCheck(!strchr(text, OPERATOR_MARK), "%s '%s': %c is no operator", e->option, text,
              OPERATOR_MARK);
    PetscCall(PetscStrncpy(renamed, text, sizeof(renamed)));
    RenameOperators(renamed);
    PetscCall(ParserCreate(scope, allowed, &parser));
    mupSetExpr(parser, renamed);
    e->value[c] = mupEval(parser);
    PetscCall(ParserComplaint(parser, complaint, sizeof(complaint)));
    UserCheck(!mupError(parser), "%s '%s': %s; names are %s, and functions as sin, exp, min",
              e->option, text, complaint, names);
    e->uses[c] = ParserUses(scope, parser);
    if (e->uses[c]) {
      e->value[c]  = 0.0;
      e->parser[c] = parser;
      e->scope     = scope;
    } else {
      mupRelease(scope->parser[--scope->n_parsers]);
    }
  }
  UserCheck(e->uses[c] || !PetscIsInfOrNanReal(e->value[c]), "%s '%s': is not finite", e->option,
            text);
  e->n++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Ends a component at the first comma outside brackets; returns the next component, or NULL. */
static char *SplitComponent(char text[])
{
  PetscInt depth = 0;

  for (char *s = text; *s; s++) {
    if (*s == '(') depth++;
    if (*s == ')') depth--;
    if (*s != ',' || depth > 0) continue;
    *s = '\0';
    return s + 1;
  }
  return NULL;
}

/* ExpressionSet - Sets an expression from the text of its components, "sin(pi*y), 0". Collective on
   PETSC_COMM_WORLD. Input: option - name of the option, for messages; fewest, most - allowed
   numbers of components; allowed - bits of ExpressionUse. Output: e - valid as long as the scope
   exists. */
PetscErrorCode ExpressionSet(ExpressionScope *scope, const char option[], const char text[],
                             PetscInt fewest, PetscInt most, unsigned allowed, Expression *e)
{
  char     parts[TEXT_LENGTH], *next = parts, wanted[32];
  PetscInt n = 0;

  PetscFunctionBegin;
  *e = (Expression){.n = 0};
  PetscCall(PetscStrncpy(e->option, option, sizeof(e->option)));
  PetscCall(PetscStrncpy(parts, text, sizeof(parts)));
  for (char *s = parts; s; s = SplitComponent(s)) n++;
  PetscCall(PetscSNPrintf(wanted, sizeof(wanted),
                          fewest < most ? "%" PetscInt_FMT " to %" PetscInt_FMT : "%" PetscInt_FMT,
                          fewest, most));
  UserCheck(n >= fewest && n <= most, "%s %s: %s components are required, got %" PetscInt_FMT,
            option, text, wanted, n);
  PetscCall(PetscStrncpy(parts, text, sizeof(parts)));
  while (next) {
    char *part = next;

    next = SplitComponent(part);
    while (*part == ' ') part++;
    PetscCall(SetComponent(scope, part, allowed, e));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ExpressionGet - Reads an option and sets an expression from its text by ExpressionSet().
   Collective. Output: e - unchanged if the option is not given; given - may be NULL. */
PetscErrorCode ExpressionGet(ExpressionScope *scope, const OptionRow *option, PetscInt fewest,
                             PetscInt most, unsigned allowed, Expression *e, PetscBool *given)
{
  char      typed[TEXT_LENGTH];
  PetscBool there;

  PetscFunctionBegin;
  PetscCall(OptionGetText(option, sizeof(typed), typed, &there));
  UserCheck(!there || typed[0],
            "%s: an expression is required; text that begins with - and a letter needs brackets",
            option->name);
  if (there) PetscCall(ExpressionSet(scope, option->name, typed, fewest, most, allowed, e));
  if (given) *given = there;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ExpressionNumber - Returns a constant expression with a single component */
Expression ExpressionNumber(PetscReal value)
{
  return (Expression){.n = 1, .value = {value}};
}

/* ExpressionIsGiven - Returns true if a component is not always zero */
PetscBool ExpressionIsGiven(const Expression *e)
{
  for (PetscInt c = 0; c < e->n; c++)
    if (e->uses[c] || e->value[c] != 0.0) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* ExpressionUses - Returns true if any component depends on the given variables, position or
   time */
PetscBool ExpressionUses(const Expression *e, unsigned what)
{
  for (PetscInt c = 0; c < e->n; c++) {
    if (e->uses[c] & what) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* ExpressionProbe - Returns component c at a position and time, also if its value is not finite. x
   may be NULL for expressions of time alone. For values that the flow does not depend on; see
   ExpressionValue(). */
PetscReal ExpressionProbe(const Expression *e, PetscInt c, PetscReal t, const PetscReal x[])
{
  ExpressionScope *scope = e->scope;

  if (e->curve[c]) return TimeCurveValue(e->curve[c], t);
  if (!e->parser[c]) return e->value[c];
  if (e->uses[c] & EXPRESSION_FIELDS && scope->fields && x) {
    PetscReal value[EXPRESSION_FIELDS_MOST];

    ExpressionFields(e, t, x, value); /* may evaluate other expressions */
    for (PetscInt k = 0; k < scope->n_fields; k++) scope->field[k] = value[k];
  }
  for (PetscInt a = 0; a < scope->dim && x; a++) scope->x[a] = x[a];
  scope->t = t;
  return mupEval(e->parser[c]);
}

/* ExpressionValue - Returns component c at a position and time; zero if the expression is not set.
   x may be NULL for expressions of time alone. For a value that is not finite the function returns
   zero and records the fault for ExpressionScopeCheck(). */
PetscReal ExpressionValue(const Expression *e, PetscInt c, PetscReal t, const PetscReal x[])
{
  ExpressionScope *scope = e->scope;
  const PetscReal  value = ExpressionProbe(e, c, t, x);

  if (!PetscIsInfOrNanReal(value)) return value;
  if (!scope->fault[0]) {
    char text[301];

    ParserText(e->parser[c], text, sizeof(text));
    if (x) {
      (void)snprintf(scope->fault, sizeof(scope->fault),
                     "%s '%s': is not finite at x = %.6g, y = %.6g, t = %.6g", e->option, text,
                     scope->x[0], scope->x[1], (double)t);
    } else {
      (void)snprintf(scope->fault, sizeof(scope->fault), "%s '%s': is not finite at t = %.6g",
                     e->option, text, (double)t);
    }
  }
  return 0.0;
}

/* ExpressionBlame - Records for ExpressionScopeCheck() that the last value of component c is not
   allowed. Input: must - the condition, as "must be positive" */
void ExpressionBlame(const Expression *e, PetscInt c, PetscReal value, const char must[])
{
  ExpressionScope *scope = e->scope;
  char             text[301];

  if (!scope || scope->fault[0]) return;
  ParserText(e->parser[c], text, sizeof(text));
  (void)snprintf(scope->fault, sizeof(scope->fault),
                 "%s '%s': it is %.6g at x = %.6g, y = %.6g, t = %.6g, and %s", e->option, text,
                 (double)value, scope->x[0], scope->x[1], scope->t, must);
}

/* ExpressionFields - Computes the present fields at a place and time */
void ExpressionFields(const Expression *e, PetscReal t, const PetscReal x[], PetscReal value[])
{
  if (e->scope && e->scope->fields) e->scope->fields(e->scope->ctx, t, x, value);
}

/* ExpressionOf - Returns component c at a position and time for given values of the fields and of
   the strain rate g, as ExpressionValue() */
PetscReal ExpressionOf(const Expression *e, PetscInt c, PetscReal t, const PetscReal x[],
                       const PetscReal field[], PetscReal g)
{
  ExpressionScope *scope = e->scope;
  FieldsAt         fields;
  PetscReal        value;

  if (!e->parser[c]) return e->value[c];
  fields        = scope->fields;
  scope->fields = NULL;
  scope->rate   = g;
  for (PetscInt k = 0; k < scope->n_fields; k++) scope->field[k] = field[k];
  value         = ExpressionValue(e, c, t, x);
  scope->fields = fields;
  return value;
}

/* ExpressionRate - Returns the time derivative of component c by a centred difference, [f(t + 1e-5
   tau) - f(t - 1e-5 tau)]/(2e-5 tau). Input: tau - time in which the expression changes [s]. For an
   oscillation of angular frequency w the relative error is (1e-5 w tau)^2/6. The expression is
   never evaluated at negative times. */
PetscReal ExpressionRate(const Expression *e, PetscInt c, PetscReal t, const PetscReal x[],
                         PetscReal tau)
{
  const PetscReal before = PetscMax(t - 1e-5 * tau, 0.0), after = t + 1e-5 * tau;

  if (!(e->uses[c] & EXPRESSION_TIME)) return 0.0;
  return (ExpressionValue(e, c, after, x) - ExpressionValue(e, c, before, x)) / (after - before);
}
