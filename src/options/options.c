/* Readers of options. PETSc keeps the database. Rows of tables give name, range and default; a
   value that they do not allow ends the run with one line. */
#include "isph/options.h"
#include <errno.h>
#include <stdlib.h>
#include <string.h>

/* Open MPI copies a path with its additions to 256 characters unchecked. */
#define PATH_MAX_TYPED 200

/* Reads the text of an option, empty where there is none; collective. */
static PetscErrorCode ReadText(const char option[], const char **text, PetscBool *given)
{
  PetscFunctionBegin;
  PetscCall(PetscOptionsFindPair(NULL, NULL, option, text, given));
  if (!*given || !*text) *text = "";
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns true if a text is a number and nothing else. */
static PetscBool IsNumber(const char text[], double *number)
{
  char *end;

  *number = strtod(text, &end);
  return end != text && !*end;
}

/* OptionRangeText - Writes the range of a row, empty if it has none */
void OptionRangeText(const OptionRow *row, char text[], size_t length)
{
  text[0] = '\0';
  if (row->low == row->high) return;
  if (row->high < OPTION_HUGE)
    (void)snprintf(text, length, "%.6g to %.6g", (double)row->low, (double)row->high);
  else if (row->low == OPTION_TINY) (void)snprintf(text, length, "above 0");
  else (void)snprintf(text, length, "%.6g or more", (double)row->low);
}

/* Converts a text to a number; ends the run if it is none, or outside the range of the row. */
static PetscErrorCode CheckReal(const OptionRow *row, const char text[], PetscReal *value)
{
  char   range[64];
  double number;

  PetscFunctionBegin;
  UserCheck(IsNumber(text, &number), "%s%s%s: a number is required", row->name, *text ? " " : "",
            text);
  OptionRangeText(row, range, sizeof(range));
  UserCheck(number >= row->low && number <= row->high, "%s %s: allowed is %s", row->name, text,
            range);
  *value = number;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* OptionGetReal - Reads a number. Collective. Input/Output: value - out: the number of the user; if
   none is given, the default of the row if it is a number; otherwise unchanged. Output: given - the
   user gave the option; may be NULL. */
PetscErrorCode OptionGetReal(const OptionRow *row, PetscReal *value, PetscBool *given)
{
  const char *text;
  double      number;
  PetscBool   there;

  PetscFunctionBegin;
  PetscCall(ReadText(row->name, &text, &there));
  if (there) {
    PetscCall(CheckReal(row, text, value));
  } else if (row->standard && IsNumber(row->standard, &number)) {
    *value = number;
  }
  if (given) *given = there;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* OptionGetInt - Reads a whole number, as OptionGetReal() does */
PetscErrorCode OptionGetInt(const OptionRow *row, PetscInt *value, PetscBool *given)
{
  const PetscInt low  = (PetscInt)row->low;
  const PetscInt high = row->high < OPTION_HUGE ? (PetscInt)row->high : PETSC_INT_MAX;
  const char    *text;
  char          *end;
  double         standard;
  PetscBool      there;

  PetscFunctionBegin;
  PetscCall(ReadText(row->name, &text, &there));
  if (there) {
    errno                  = 0;
    const long long number = strtoll(text, &end, 10);

    UserCheck(end != text && *end == '\0' && errno == 0, "%s%s%s: a whole number is required",
              row->name, *text ? " " : "", text);
    UserCheck(number >= low && number <= high,
              "%s %s: allowed is %" PetscInt_FMT " to %" PetscInt_FMT, row->name, text, low, high);
    *value = (PetscInt)number;
  } else if (row->standard && IsNumber(row->standard, &standard)) {
    *value = (PetscInt)standard;
  }
  if (given) *given = there;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* OptionGetSwitch - Reads true or false; an option without a value is true; collective. Output:
   value - if the option is not given, the default of the row if it is true or false, otherwise
   unchanged; given - may be NULL. */
PetscErrorCode OptionGetSwitch(const OptionRow *row, PetscBool *value, PetscBool *given)
{
  const char *const words[] = {"", "true", "yes", "on", "1", "0", "false", "no", "off", NULL};
  const char       *text;
  PetscBool         there, known = PETSC_FALSE;

  PetscFunctionBegin;
  PetscCall(ReadText(row->name, &text, &there));
  if (!there) text = row->standard ? row->standard : "absent";
  for (PetscInt k = 0; words[k] && !known; k++) {
    PetscCall(PetscStrcasecmp(text, words[k], &known));
    if (known) *value = k < 5;
  }
  UserCheck(!there || known, "%s %s: allowed are true and false; without a value it is true",
            row->name, text);
  if (given) *given = there;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* OptionGetReals - Reads numbers separated by commas. Collective. Input: capacity - most numbers
   allowed. Output: value - the numbers; unchanged if the option is not given; n - their count; 0 if
   the option is not given; given - may be NULL. */
PetscErrorCode OptionGetReals(const OptionRow *row, PetscInt capacity, PetscReal value[],
                              PetscInt *n, PetscBool *given)
{
  const char *text;
  char       *end;
  PetscBool   there;

  PetscFunctionBegin;
  PetscCall(ReadText(row->name, &text, &there));
  UserCheck(!there || *text, "%s: numbers are required, separated by commas", row->name);
  *n = 0;
  while (*text) {
    UserCheck(*n < capacity, "%s: at most %" PetscInt_FMT " numbers are allowed", row->name,
              capacity);
    value[*n] = strtod(text, &end);
    UserCheck(end != text && (!*end || *end == ','), "%s: a number is required at '%s'", row->name,
              text);
    UserCheck(!PetscIsInfOrNanReal(value[*n]),
              "%s: number %" PetscInt_FMT " is %g, and must be finite", row->name, *n + 1,
              (double)value[*n]);
    (*n)++;
    text = *end ? end + 1 : end;
  }
  if (given) *given = there;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* OptionGetFlags - Reads words separated by commas, each for one bit. Collective. Output: flags -
   bit k for word k of the row; 0 if the option is not given. Note: an option without words chooses
   none, so that it can undo the choice of an options file. */
PetscErrorCode OptionGetFlags(const OptionRow *row, unsigned *flags)
{
  const char *text;
  char        all[512] = "";
  PetscBool   there;

  PetscFunctionBegin;
  *flags = 0;
  PetscCall(ReadText(row->name, &text, &there));
  if (!there) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; row->words[k]; k++) AppendWord(all, sizeof(all), row->words[k]);
  while (*text) {
    const size_t length = strcspn(text, ",");
    PetscBool    same   = PETSC_FALSE;

    for (PetscInt k = 0; row->words[k] && !same; k++) {
      same = strlen(row->words[k]) == length && !strncmp(row->words[k], text, length);
      if (same) *flags |= 1u << k;
    }
    UserCheck(same, "%s %.*s: no such name; choose from %s", row->name, (int)length, text, all);
    text += text[length] ? length + 1 : length;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* OptionGetText - Reads the text of an option, for callers that parse it; collective. Output: text
   - empty where the option is not given; given - may be NULL. */
PetscErrorCode OptionGetText(const OptionRow *row, size_t length, char text[], PetscBool *given)
{
  const char *typed;
  PetscBool   there;

  PetscFunctionBegin;
  PetscCall(ReadText(row->name, &typed, &there));
  UserCheck(strlen(typed) < length, "%s: it is longer than %d characters", row->name,
            (int)length - 1);
  PetscCall(PetscStrncpy(text, typed, length));
  if (given) *given = there;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* OptionGetFile - Reads a path, empty where the option is not given. Collective. Errors: refuses a
   path that is too long or has a line break, and devices, folders and the like; a symbolic link is
   read, but not written. */
PetscErrorCode OptionGetFile(const OptionRow *row, char path[PETSC_MAX_PATH_LEN])
{
  PetscBool there, ordinary;

  PetscFunctionBegin;
  PetscCall(OptionGetText(row, PETSC_MAX_PATH_LEN, path, &there));
  UserCheck(!there || path[0], "%s: a file name is required", row->name);
  UserCheck(strlen(path) <= PATH_MAX_TYPED,
            "%s: the path has %d characters, and at most %d are allowed", row->name,
            (int)strlen(path), PATH_MAX_TYPED);
  UserCheck(!strpbrk(path, "\n\r"), "%s: the path has a line break", row->name);
  if (row->file == FILE_BEGINNING) PetscFunctionReturn(PETSC_SUCCESS);
  ordinary = row->file == FILE_READ ? FileIsReadable(path) : FileIsOrdinary(path);
  PetscCall(FirstRankDecides(&ordinary));
  UserCheck(ordinary, "%s %s: it exists and is no regular file; another path is required",
            row->name, path);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* OptionGetRow - Reads the name of a row of the option's table. Collective. Input: standard - name
   of the row taken where the option is not given; NULL: the default of the option. Output: chosen -
   address of a pointer to the row (any row type). */
PetscErrorCode OptionGetRow(const OptionRow *row, const char standard[], void *chosen)
{
  const char *name;
  PetscBool   there;

  PetscFunctionBegin;
  PetscCall(ReadText(row->name, &name, &there));
  if (!there) name = standard ? standard : row->standard;
  PetscCall(TableWant(row->table, row->name, name, chosen));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* OptionTyped - Reads the text of an option as the user typed it. Collective. Input: option - its
   name, which a table must have. Output: text - empty where the option is not given or has no
   value; given - flag. */
PetscErrorCode OptionTyped(const char option[], const char **text, PetscBool *given)
{
  PetscFunctionBegin;
  PetscCheck(!OptionsAreKnown() || OptionFind(option), PETSC_COMM_WORLD, PETSC_ERR_PLIB,
             "%s is in no table of options", option);
  PetscCall(ReadText(option, text, given));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* OptionGiven - Finds out if the user gave an option; collective */
PetscErrorCode OptionGiven(const char option[], PetscBool *given)
{
  const char *text;

  PetscFunctionBegin;
  PetscCall(OptionTyped(option, &text, given));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Ends the run if PETSc cannot print a monitor as text asks, as "ascii:file::append": it has
   formats for pictures only, and other viewers and formats end in a segmentation fault. */
static PetscErrorCode CheckMonitor(const char name[], const char text[])
{
  const char *const file   = strchr(text, ':');
  const char *const format = file ? strchr(file + 1, ':') : NULL;
  const size_t      length = file ? (size_t)(file - text) : strlen(text);
  const PetscBool   plain  = !format || !format[1] || format[1] == ':';
  const PetscBool   ascii  = !length || (length == 5 && !strncmp(text, "ascii", length));
  const PetscBool   draw   = length == 4 && !strncmp(text, "draw", length);

  PetscFunctionBegin;
  UserCheck(ascii ? plain : draw && format && !strncmp(format + 1, "draw", 4),
            "%s %s: allowed are no value, ascii:file, ascii:file::append and draw::draw_lg", name,
            text);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* OptionsCheckSolvers - Refuses numbers and monitors of PETSc's solvers that their rows do not
   allow. Collective. PETSc itself accepts them and then fails, or needs more memory than there is.
   To be called before anything is read; the options stay unread, so that OptionsRefuseUnknown()
   finds them. */
PetscErrorCode OptionsCheckSolvers(void)
{
  PetscInt n;
  char   **names, **values;

  PetscFunctionBegin;
  PetscCall(PetscOptionsLeftGet(NULL, &n, &names, &values));
  for (PetscInt k = 0; k < n; k++) {
    char             name[OPTION_LENGTH];
    const char      *text = values[k] ? values[k] : "";
    const OptionRow *pattern;
    OptionRow        row;
    PetscReal        number;

    PetscCall(PetscSNPrintf(name, sizeof(name), "-%s", names[k])); /* PETSc leaves out the dash */
    pattern = OptionFind(name);
    if (!pattern) continue;
    row      = *pattern;
    row.name = name;
    if (row.kind == VALUE_MONITOR) PetscCall(CheckMonitor(name, text));
    if (row.kind == VALUE_SOLVER && row.low < row.high) PetscCall(CheckReal(&row, text, &number));
  }
  PetscCall(PetscOptionsLeftRestore(NULL, &n, &names, &values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* OptionsRefuseTogether - Ends the run if two options that contradict each other are both given.
   Collective. Input: why - the end of the sentence "-a and -b cannot both be given: why". */
PetscErrorCode OptionsRefuseTogether(const char a[], const char b[], const char why[])
{
  PetscBool has_a, has_b;

  PetscFunctionBegin;
  PetscCall(OptionGiven(a, &has_a));
  PetscCall(OptionGiven(b, &has_b));
  UserCheck(!has_a || !has_b, "%s and %s cannot both be given: %s", a, b, why);
  PetscFunctionReturn(PETSC_SUCCESS);
}
