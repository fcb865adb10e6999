/* Names of options: search in all tables, and the known name nearest to a misspelt one. main()
   hands in the tables, because those of later stages stand above this folder. */
#include "isph/options.h"
#include <ctype.h>
#include <string.h>
#include <strings.h>

static const OptionTable *const *known; /* all tables, NULL after the last */

/* OptionsKnow - Hands in all tables of options, NULL after the last, which must exist to the end of
   the program. Without them, as in tests of a part, readers take any name, but
   OptionsRefuseUnknown() knows none. */
void OptionsKnow(const OptionTable *const tables[])
{
  known = tables;
}

/* OptionsAreKnown - Returns true if OptionsKnow() has handed in the tables */
PetscBool OptionsAreKnown(void)
{
  return known ? PETSC_TRUE : PETSC_FALSE;
}

/* OptionTableGet - Returns option table k, NULL after the last */
const OptionTable *OptionTableGet(PetscInt k)
{
  return known ? known[k] : NULL;
}

/* Returns true if a name matches a pattern, in which <k> is a number and <word> one of places. As
   in PETSc, capitals and small letters are equal. */
static PetscBool Matches(const char pattern[], const char *const places[], const char name[])
{
  while (*pattern) {
    const char *const rest = *pattern == '<' ? strchr(pattern, '>') + 1 : NULL;

    if (!rest) {
      if (tolower((unsigned char)*pattern++) != tolower((unsigned char)*name++)) return PETSC_FALSE;
    } else if (!strncmp(pattern, "<k>", 3)) {
      if (!isdigit((unsigned char)*name)) return PETSC_FALSE;
      name += strspn(name, "0123456789");
      pattern = rest;
    } else if (places) {
      for (PetscInt k = 0; places[k]; k++) {
        const size_t n = strlen(places[k]);

        if (!strncasecmp(places[k], name, n) && Matches(rest, places, name + n)) return PETSC_TRUE;
      }
      return PETSC_FALSE;
    } else {
      return *name ? PETSC_TRUE : PETSC_FALSE; /* any word, at the end of the name */
    }
  }
  return *name ? PETSC_FALSE : PETSC_TRUE;
}

/* OptionNext - Returns the first option of a table from row *k on, NULL after the last, and sets *k
   to the row after it */
const OptionRow *OptionNext(const OptionTable *table, PetscInt *k)
{
  while (*k < table->count) {
    const OptionRow *row = table->rows ? &table->rows[*k] : table->elsewhere[*k];

    (*k)++;
    if (row->name) return row;
  }
  return NULL;
}

/* OptionFind - Returns the row of an option by its name, with the dash; NULL: unknown */
const OptionRow *OptionFind(const char name[])
{
  for (PetscInt t = 0; OptionTableGet(t); t++) {
    const OptionRow *row;

    for (PetscInt k = 0; (row = OptionNext(OptionTableGet(t), &k));) {
      if (Matches(row->name, row->places, name)) return row;
    }
  }
  return NULL;
}

/* OptionFill - Makes the row of one option from a pattern: -scene_body_<k> and 3 give
   -scene_body_3. Output: name - storage of the row's name, which must exist as long as the row. */
void OptionFill(const OptionRow *pattern, const char word[], char name[OPTION_LENGTH],
                OptionRow *row)
{
  const char *open = strchr(pattern->name, '<'), *close = open ? strchr(open, '>') : NULL;

  *row = *pattern;
  if (close)
    (void)snprintf(name, OPTION_LENGTH, "%.*s%s%s", (int)(open - pattern->name), pattern->name,
                   word, close + 1);
  else (void)snprintf(name, OPTION_LENGTH, "%s", pattern->name);
  row->name = name;
}

/* OptionNumber - Makes the option row of item k from a pattern with <k> in its name */
void OptionNumber(const OptionRow *pattern, PetscInt k, char name[OPTION_LENGTH], OptionRow *row)
{
  char number[32];

  (void)snprintf(number, sizeof(number), "%" PetscInt_FMT, k);
  OptionFill(pattern, number, name, row);
}

/* Returns the distance of two words of fewer than OPTION_LENGTH letters, by optimal string
   alignment: the least number of letters to insert, delete, replace or exchange with a
   neighbour. */
static PetscInt WordDistance(const char a[], const char b[])
{
  PetscInt row[3][OPTION_LENGTH] = {{0}};
  PetscInt m                     = PetscMin((PetscInt)strlen(b), OPTION_LENGTH - 1);

  for (PetscInt j = 0; j <= m; j++) row[0][j] = j;
  for (PetscInt i = 1; a[i - 1]; i++) {
    PetscInt       *now = row[i % 3];
    const PetscInt *one = row[(i + 2) % 3], *two = row[(i + 1) % 3];

    now[0] = i;
    for (PetscInt j = 1; j <= m; j++) {
      now[j] =
          PetscMin(one[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1), PetscMin(one[j], now[j - 1]) + 1);
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        now[j] = PetscMin(now[j], two[j - 2] + 1);
    }
    if (!a[i]) return now[m];
  }
  return m;
}

/* Replaces the nearest name so far if a known name is nearer; returns true if it does. */
static PetscBool Nearer(const char name[], const char known[], PetscInt *best,
                        char nearest[OPTION_LENGTH])
{
  const PetscInt distance = WordDistance(name, known);

  if (distance >= *best) return PETSC_FALSE;
  *best = distance;
  (void)snprintf(nearest, OPTION_LENGTH, "%s", known);
  return PETSC_TRUE;
}

/* Returns true if the distance of two words is small: at most a quarter of the letters, at most
   four, and fewer than all letters. */
static PetscBool IsNear(PetscInt distance, const char a[], const char b[])
{
  const PetscInt na = (PetscInt)strlen(a), nb = (PetscInt)strlen(b);
  const PetscInt most = PetscMin(4, PetscMax(1, PetscMax(na, nb) / 4));

  return distance <= most && distance < PetscMin(na, nb);
}

/* OptionTextHas - Returns true if a text, or NULL, has a word, in capitals or small letters */
PetscBool OptionTextHas(const char text[], const char word[])
{
  for (; text && *text; text++)
    if (!strncasecmp(text, word, strlen(word))) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Returns true if a row has a name, without its dash, among its other names. */
static PetscBool IsAlso(const OptionRow *row, const char name[])
{
  char word[OPTION_LENGTH];

  (void)snprintf(word, sizeof(word), " %s ", name);
  return OptionTextHas(row->also, word);
}

/* OptionNearest - Finds the known option nearest to a misspelt one, or that with this other name.
   Input: name - with its dash; <k> in patterns takes the first number in it. Output: nearest - the
   known name, with its dash. Returns: its row; NULL if no name is near. */
const OptionRow *OptionNearest(const char name[], char nearest[OPTION_LENGTH])
{
  const char      *digits = name + strcspn(name, "0123456789");
  const OptionRow *found  = NULL;
  PetscInt         best   = OPTION_LENGTH;
  char             number[8], known[OPTION_LENGTH];
  OptionRow        one;

  (void)snprintf(number, sizeof(number), "%.*s", (int)strspn(digits, "0123456789"), digits);
  for (PetscInt t = 0; OptionTableGet(t); t++) {
    const OptionRow *row;

    for (PetscInt k = 0; (row = OptionNext(OptionTableGet(t), &k));) {
      for (PetscInt q = 0; q == 0 || (row->places && row->places[q]); q++) {
        OptionFill(row, row->places ? row->places[q] : number[0] ? number : "1", known, &one);
        if (IsAlso(row, name + 1)) {
          (void)snprintf(nearest, OPTION_LENGTH, "%s", known);
          return row;
        }
        if (Nearer(name, known, &best, nearest)) found = row;
      }
    }
  }
  return found && IsNear(best, name + 1, nearest + 1) ? found : NULL;
}
