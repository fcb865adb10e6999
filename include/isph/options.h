/* Options: tables of rows with name, kind, unit, default and range; readers that take a row; the
   command line and its files; requests that are answered without a run. */
#ifndef ISPH_OPTIONS_H
#define ISPH_OPTIONS_H

#include "isph/base.h"
#include <stdio.h>

/* The kind of an option's value. */
typedef enum {
  VALUE_SWITCH,     /* true or false; true without a value */
  VALUE_INT,        /* a whole number */
  VALUE_REAL,       /* a number */
  VALUE_REALS,      /* numbers separated by commas */
  VALUE_NAME,       /* the name of a row of a table */
  VALUE_NAMES,      /* words separated by commas */
  VALUE_FILE,       /* a path */
  VALUE_EXPRESSION, /* components separated by commas, numbers or expressions */
  VALUE_SHAPE,      /* a shape and its numbers, separated by commas */
  VALUE_WORD,       /* a word */
  VALUE_NOTHING,    /* no value */
  VALUE_VIEWER,     /* a viewer of PETSc's, as ascii:file */
  VALUE_MONITOR,    /* a viewer of a solver's monitor, as ascii:file; read by PETSc */
  VALUE_SOLVER      /* read by PETSc */
} OptionKind;

/* The use of the path of a VALUE_FILE. */
typedef enum {
  FILE_BEGINNING, /* beginning of the names of several files */
  FILE_READ,
  FILE_WRITTEN
} FileUse;

/* An option. No other table holds its name: parsing, -help, suggestions, the refusal of unused
   options and the reference page read this row. */
typedef struct {
  const char        *name;     /* as typed; <k> is a number, <word> a word of places */
  OptionKind         kind;     /* of the value */
  const char        *brief;    /* a phrase on the meaning */
  const char        *unit;     /* "m/s"; "-": a pure number; NULL: none */
  const char        *standard; /* default: a value, or a phrase; NULL: the option is absent */
  PetscReal          low;      /* least value allowed */
  PetscReal          high;     /* largest value allowed; low = high = 0: no range */
  const Table       *table;    /* the rows that the option chooses from; NULL: none */
  const Table       *table_3d; /* the rows in 3D, of VALUE_SHAPE; NULL: the same */
  const char *const *words;    /* of VALUE_NAMES or an early VALUE_VIEWER; ends with NULL */
  const char *const *places;   /* words that <word> in the name stands for; NULL: any word */
  const char        *where;    /* runs that use it, a phrase; NULL: all */
  const char        *also;     /* other names in use, between spaces: " re "; NULL: none */
  const char        *instead;  /* remedy for other runs, a phrase; NULL: none */
  PetscBool          early;    /* checked before PetscInitialize() prints a traceback */
  PetscBool          late;     /* read at the end of the run */
  PetscBool          expert;   /* for studies of the numerics */
  FileUse            file;     /* of VALUE_FILE */
} OptionRow;

/* A row: the kind without VALUE_, name, brief, unit and default; then other members by name. */
#define OPTION(type, word, phrase, of, value, ...)                                                 \
  {                                                                                                \
    .name = word, .kind = VALUE_##type, .brief = phrase, .unit = of, .standard = value,            \
    __VA_ARGS__                                                                                    \
  }

/* Bounds of ranges: OPTION_TINY stands for any positive number, OPTION_HUGE for no upper bound. */
#define OPTION_TINY 1e-300
#define OPTION_HUGE 1e300
/* clang-format off */
#define POSITIVE     .low = OPTION_TINY, .high = OPTION_HUGE
#define NOT_NEGATIVE .low = 0.0, .high = OPTION_HUGE
/* clang-format on */

/* The options that one file reads, or that rows of another table hold. */
typedef struct {
  const char             *title; /* heading in -help */
  const OptionRow        *rows;
  const OptionRow *const *elsewhere; /* in place of rows, where rows is NULL */
  PetscInt                count;
} OptionTable;
#define OPTIONS(title, rows)                                                                       \
  {                                                                                                \
    title, rows, NULL, (PetscInt)(sizeof(rows) / sizeof((rows)[0]))                                \
  }

/* A table of pointers to rows; rows without a name are no options. */
#define OPTIONS_ELSEWHERE(title, pointers)                                                         \
  {                                                                                                \
    title, NULL, pointers, (PetscInt)(sizeof(pointers) / sizeof((pointers)[0]))                    \
  }

/* All tables of options, which the program hands in: src/library/catalogue.c. */
void               OptionsKnow(const OptionTable *const tables[]);
PetscBool          OptionsAreKnown(void);
const OptionTable *OptionTableGet(PetscInt k);

#define OPTION_LENGTH 128 /* of a name */
const OptionRow *OptionNext(const OptionTable *table, PetscInt *k);
const OptionRow *OptionFind(const char name[]);
const OptionRow *OptionNearest(const char name[], char nearest[OPTION_LENGTH]);
void             OptionFill(const OptionRow *pattern, const char word[], char name[OPTION_LENGTH],
                            OptionRow *row);
void OptionNumber(const OptionRow *pattern, PetscInt k, char name[OPTION_LENGTH], OptionRow *row);
void OptionRangeText(const OptionRow *row, char text[], size_t length);

/* Readers, collective. A bad value ends the run with one line. given may be NULL. */
PetscErrorCode OptionGetSwitch(const OptionRow *row, PetscBool *value, PetscBool *given);
PetscErrorCode OptionGetInt(const OptionRow *row, PetscInt *value, PetscBool *given);
PetscErrorCode OptionGetReal(const OptionRow *row, PetscReal *value, PetscBool *given);
PetscErrorCode OptionGetReals(const OptionRow *row, PetscInt capacity, PetscReal value[],
                              PetscInt *n, PetscBool *given);
PetscErrorCode OptionGetFlags(const OptionRow *row, unsigned *flags);
PetscErrorCode OptionGetFile(const OptionRow *row, char path[PETSC_MAX_PATH_LEN]);
PetscErrorCode OptionGetText(const OptionRow *row, size_t length, char text[], PetscBool *given);
PetscErrorCode OptionGetRow(const OptionRow *row, const char standard[], void *chosen);

PetscErrorCode OptionTyped(const char option[], const char **text, PetscBool *given);
PetscErrorCode OptionGiven(const char option[], PetscBool *given);
PetscErrorCode OptionsCheckSolvers(void);
PetscErrorCode OptionsRefuseTogether(const char a[], const char b[], const char why[]);
PetscErrorCode OptionsRefuseUnknown(PetscBool deferred_too);

/* The request of a command line. */
typedef enum {
  REQUEST_RUN,
  REQUEST_USAGE,      /* no option at all */
  REQUEST_HELP,       /* -h, -help, --help */
  REQUEST_HELP_PETSC, /* -help petsc */
  REQUEST_VERSION,    /* -version, --version */
  REQUEST_REFERENCE   /* -options_reference */
} Request;

extern const OptionTable ProgramOptions;

Request     CommandLineRequest(int *argc, char **argv, const char **word);
void        OptionsCheckWords(const char source[], int n, char *const word[], char sentence[],
                              size_t length);
PetscBool   OptionNamesFile(const char option[]);
void        OptionsCheck(int argc, char **argv, char sentence[], size_t length);
void        UsagePrint(FILE *out);
void        HelpPrint(FILE *out);
void        HelpSearch(FILE *out, const char word[]);
PetscBool   OptionTextHas(const char text[], const char word[]);
void        ReferencePrint(FILE *out);
void        VersionPrint(FILE *out);
const char *VersionCommit(void);

/* Expressions of position and time typed by the user, such as "sin(2*pi*t), 0". muParser parses
   them once; then they can be evaluated anywhere and at any time. */

/* Bits of the variables that a text may use, or that a component uses. */
typedef enum {
  EXPRESSION_PLACE  = 1 << 0, /* x, y and in 3D z [m] */
  EXPRESSION_TIME   = 1 << 1, /* t [s] */
  EXPRESSION_FIELDS = 1 << 2, /* fields of the fluid by their names, as a temperature */
  EXPRESSION_STRAIN = 1 << 3  /* g, the strain rate sqrt(2 E:E) [1/s] */
} ExpressionUse;
#define EXPRESSION_FIELDS_MOST 4
/* Gives the fields at a place and time, in the order in which they were named. */
typedef void (*FieldsAt)(void *ctx, PetscReal t, const PetscReal x[], PetscReal value[]);

/* State common to all expressions of a scene: constants, variables, parsers, and the first
   fault. */
typedef struct ExpressionScope ExpressionScope;

/* A function that expressions may call by its name, with any number of arguments. */
typedef struct {
  const char *name, *brief, *citation;
  PetscReal (*Value)(PetscInt n, const PetscReal argument[], void *ctx);
  void *ctx; /* of it */
} FunctionRow;
extern const Table FunctionTable; /* of plug-ins */

#define EXPRESSION_MOST (ISPH_MAX_DIM + 1) /* components: velocity and pressure */

/* A function of time through given values, see TimeCurveSet(). */
typedef struct {
  PetscInt         n;
  const PetscReal *t, *y; /* ascending times [s], and the values there */
  PetscReal       *slope; /* dy/dt there */
} TimeCurve;

const char *TimeCurveSet(TimeCurve *curve);
PetscReal   TimeCurveValue(const TimeCurve *curve, PetscReal t);

/* An expression: the components of an option. All members are zero if the option is absent. */
typedef struct {
  char             option[40];              /* for messages */
  PetscInt         n;                       /* components; 0: not given */
  PetscReal        value[EXPRESSION_MOST];  /* of components that are numbers */
  void            *parser[EXPRESSION_MOST]; /* of other components; NULL for numbers */
  const TimeCurve *curve[EXPRESSION_MOST];  /* of components from a file; NULL for others */
  unsigned         uses[EXPRESSION_MOST];   /* bits of ExpressionUse */
  ExpressionScope *scope;
} Expression;

PetscErrorCode ExpressionScopeCreate(PetscInt dim, const Table *functions, ExpressionScope **scope);
PetscErrorCode ExpressionScopeDefine(ExpressionScope *scope, const char name[], PetscReal value);
PetscErrorCode ExpressionScopeField(ExpressionScope *scope, const char name[]);
PetscBool      ExpressionScopeKnows(const ExpressionScope *scope, const char name[]);
void           ExpressionScopeFieldsAt(ExpressionScope *scope, FieldsAt fields, void *ctx);
PetscErrorCode ExpressionScopeDestroy(ExpressionScope **scope);
PetscBool      ExpressionScopeIsIdle(const ExpressionScope *scope);
PetscErrorCode ExpressionScopeCheck(const ExpressionScope *scope);
PetscBool      ExpressionScopeForget(ExpressionScope *scope);

PetscErrorCode ExpressionSet(ExpressionScope *scope, const char option[], const char text[],
                             PetscInt fewest, PetscInt most, unsigned allowed, Expression *e);
PetscErrorCode ExpressionGet(ExpressionScope *scope, const OptionRow *option, PetscInt fewest,
                             PetscInt most, unsigned allowed, Expression *e, PetscBool *given);
Expression     ExpressionNumber(PetscReal value);
PetscBool      ExpressionIsGiven(const Expression *e);
PetscBool      ExpressionUses(const Expression *e, unsigned what);
PetscReal      ExpressionProbe(const Expression *e, PetscInt c, PetscReal t, const PetscReal x[]);
PetscReal      ExpressionValue(const Expression *e, PetscInt c, PetscReal t, const PetscReal x[]);
void ExpressionFields(const Expression *e, PetscReal t, const PetscReal x[], PetscReal value[]);
void ExpressionBlame(const Expression *e, PetscInt c, PetscReal value, const char must[]);
PetscReal ExpressionOf(const Expression *e, PetscInt c, PetscReal t, const PetscReal x[],
                       const PetscReal field[], PetscReal g);
PetscReal ExpressionRate(const Expression *e, PetscInt c, PetscReal t, const PetscReal x[],
                         PetscReal tau);

#endif
