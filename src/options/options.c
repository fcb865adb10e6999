/*
  Options with ranges. PETSc keeps the database; this file adds checks with messages.
*/
#include "isph/base.h"
#include <errno.h>
#include <stdlib.h>

/*
  OptionReal - Reads a real number from the command line and checks it against [low, high]

  Collective. Between PetscOptionsBegin() and PetscOptionsEnd().

  Input/Output Parameter:
. value - in: the default shown by -help; out: the given number

  Output Parameter:
. set - flag: the option is given; may be NULL

  Errors: text that is no number, or a number out of range (infinities and NaN too), ends the run
*/
PetscErrorCode OptionReal_Private(OptionItems PetscOptionsObject, const char option[],
                                  const char text[], PetscReal low, PetscReal high,
                                  PetscReal *value, PetscBool *set)
{
  char      word[128], *end;
  PetscBool given;

  PetscFunctionBegin;
  PetscCall(
      PetscOptionsGetString(NULL, PetscOptionsObject->prefix, option, word, sizeof(word), &given));
  if (given) {
    const double number = strtod(word, &end);

    UserCheck(end != word && *end == '\0', "%s %s: a number is required", option, word);
    UserCheck(number >= low && number <= high, "%s %s: allowed is %.6g to %.6g", option, word,
              (double)low, (double)high);
  }
  PetscCall(PetscOptionsReal(option, text, "", *value, value, NULL));
  if (set) *set = given;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* OptionInt - Reads a whole number from the command line, with the checks of OptionReal() */
PetscErrorCode OptionInt_Private(OptionItems PetscOptionsObject, const char option[],
                                 const char text[], PetscInt low, PetscInt high, PetscInt *value,
                                 PetscBool *set)
{
  char      word[128], *end;
  PetscBool given;

  PetscFunctionBegin;
  PetscCall(
      PetscOptionsGetString(NULL, PetscOptionsObject->prefix, option, word, sizeof(word), &given));
  if (given) {
    errno                  = 0;
    const long long number = strtoll(word, &end, 10);

    UserCheck(end != word && *end == '\0' && errno == 0, "%s %s: a whole number is required",
              option, word);
    UserCheck(number >= low && number <= high,
              "%s %s: allowed is %" PetscInt_FMT " to %" PetscInt_FMT, option, word, low, high);
  }
  PetscCall(PetscOptionsInt(option, text, "", *value, value, NULL));
  if (set) *set = given;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  OptionSwitch - Reads true or false; an option without a value is true

  Collective. Between PetscOptionsBegin() and PetscOptionsEnd(). Output: value - unchanged if the
  option is absent.

  Errors: any other word ends the run
*/
PetscErrorCode OptionSwitch_Private(OptionItems PetscOptionsObject, const char option[],
                                    const char text[], PetscBool *value)
{
  const char *const words[]  = {"", "true", "yes", "on", "1", "0", "false", "no", "off", NULL};
  char              word[64] = "";
  PetscBool         given, known = PETSC_FALSE;

  PetscFunctionBegin;
  PetscCall(PetscOptionsGetString(NULL, NULL, option, word, sizeof(word), &given));
  for (PetscInt k = 0; given && words[k] && !known; k++)
    PetscCall(PetscStrcasecmp(word, words[k], &known));
  UserCheck(!given || known, "%s %s: it is true or false, and by itself true", option, word);
  PetscCall(PetscOptionsBool(option, text, "", *value, value, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  OptionReals - Reads real numbers separated by commas

  Collective. Between PetscOptionsBegin() and PetscOptionsEnd().

  Input Parameter:
. capacity - largest number of values

  Output Parameters:
+ value - the numbers; unchanged if the option is absent
. n     - their number; 0 if the option is absent
- set   - flag: the option is given; may be NULL

  Errors: more numbers than capacity, which PETSc would drop silently; numbers that are not finite
*/
PetscErrorCode OptionReals_Private(OptionItems PetscOptionsObject, const char option[],
                                   const char text[], PetscInt capacity, PetscReal value[],
                                   PetscInt *n, PetscBool *set)
{
  PetscReal *number;
  PetscBool  given;

  PetscFunctionBegin;
  *n = capacity + 1;
  PetscCall(PetscCalloc1(capacity + 1, &number));
  PetscCall(PetscOptionsRealArray(option, text, "", number, n, &given));
  if (!given) *n = 0;
  for (PetscInt k = 0; k < PetscMin(*n, capacity); k++) value[k] = number[k];
  PetscCall(PetscFree(number));
  UserCheck(*n <= capacity, "%s: at most %" PetscInt_FMT " numbers are allowed", option, capacity);
  for (PetscInt k = 0; k < *n; k++)
    UserCheck(!PetscIsInfOrNanReal(value[k]),
              "%s: number %" PetscInt_FMT " is %g, and must be finite", option, k + 1,
              (double)value[k]);
  if (set) *set = given;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  OptionFlags - Reads names separated by commas as bits

  Collective. Input: names[k] is the word for bit k. Output: flags, 0 if the option is absent.
*/
PetscErrorCode OptionFlags_Private(OptionItems PetscOptionsObject, const char option[],
                                   const char text[], const char *const names[], PetscInt count,
                                   unsigned *flags)
{
  char     *words[16], all[512] = "", help[640];
  PetscInt  n = 16;
  PetscBool given;

  PetscFunctionBegin;
  *flags = 0;
  for (PetscInt k = 0; k < count; k++) {
    if (k) PetscCall(PetscStrlcat(all, ", ", sizeof(all)));
    PetscCall(PetscStrlcat(all, names[k], sizeof(all)));
  }
  PetscCall(PetscSNPrintf(help, sizeof(help), "%s: %s", text, all));
  PetscCall(PetscOptionsStringArray(option, help, "", words, &n, &given));
  UserCheck(!given || n > 0, "%s: names are required; choose from %s", option, all);
  for (PetscInt w = 0; w < n; w++) {
    PetscBool same = PETSC_FALSE;

    for (PetscInt k = 0; k < count && !same; k++) {
      PetscCall(PetscStrcmp(words[w], names[k], &same));
      if (same) *flags |= 1u << k;
    }
    UserCheck(same, "%s %s: no such name; choose from %s", option, words[w], all);
    PetscCall(PetscFree(words[w]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* OptionFile - Reads a path from the command line; it stays empty if the option is absent */
PetscErrorCode OptionFile_Private(OptionItems PetscOptionsObject, const char option[],
                                  const char text[], char path[PETSC_MAX_PATH_LEN])
{
  PetscBool given;

  PetscFunctionBegin;
  path[0] = '\0';
  PetscCall(PetscOptionsString(option, text, "", "", path, PETSC_MAX_PATH_LEN, &given));
  UserCheck(!given || path[0], "%s: a file name is required", option);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* OptionGiven - Returns true if an option is given */
PetscErrorCode OptionGiven(const char option[], PetscBool *given)
{
  PetscFunctionBegin;
  PetscCall(PetscOptionsHasName(NULL, NULL, option, given));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  OptionsRefuseTogether - Ends the run if two contradictory options are both given

  Collective. Input: why - the end of the sentence "-a and -b cannot both be given: why"
*/
PetscErrorCode OptionsRefuseTogether(const char a[], const char b[], const char why[])
{
  PetscBool has_a, has_b;

  PetscFunctionBegin;
  PetscCall(PetscOptionsHasName(NULL, NULL, a, &has_a));
  PetscCall(PetscOptionsHasName(NULL, NULL, b, &has_b));
  UserCheck(!has_a || !has_b, "%s and %s cannot both be given: %s", a, b, why);
  PetscFunctionReturn(PETSC_SUCCESS);
}
