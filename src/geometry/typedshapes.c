/* Readers of shapes that are typed in numbered options, as -scene_body_1 circle,0.5,0.5,0.25. */
#include "isph/scene.h"
#include <stdlib.h>
#include <string.h>

#define SHAPE_TEXT   2048     /* room for BODY_PARAMETERS numbers with all their digits */
#define SHAPE_POINTS 20000000 /* most points on a surface: checks visit all of them */

/* OptionNumber - Makes the option row of item k from a pattern with <k> in its name; not
   collective */
void OptionNumber(const OptionRow *pattern, PetscInt k, char name[OPTION_LENGTH], OptionRow *row)
{
  char number[32];

  (void)snprintf(number, sizeof(number), "%" PetscInt_FMT, k);
  OptionFill(pattern, number, name, row);
}

/* Reads the name of a shape of a table and its numbers, as "circle,0.5,0.5,0.25". */
static PetscErrorCode ReadShape(const Scene *scene, const Table *table, const char option[],
                                const char text[], Body *body)
{
  const ShapeRow *shape;
  const char     *wrong;
  PetscReal       number[BODY_PARAMETERS];
  PetscInt        n = 0;
  char            word[SHAPE_TEXT], *next, *end;

  PetscFunctionBegin;
  UserCheck(strlen(text) < SHAPE_TEXT - 1, "%s: it is longer than %d characters", option,
            SHAPE_TEXT - 2);
  PetscCall(PetscStrncpy(word, text, sizeof(word)));
  next = strchr(word, ',');
  if (next) *next++ = '\0';
  PetscCall(TableWant(table, option, word, &shape));
  while (next && n < BODY_PARAMETERS) {
    number[n++] = strtod(next, &end);
    end += strspn(end, " ");
    UserCheck(end != next && (*end == ',' || !*end), "%s: a number is required at '%s'", option,
              next);
    next = *end ? end + 1 : NULL;
  }
  UserCheck(!next && n >= shape->fewest && n <= shape->most, "%s: a %s is %s", option, shape->name,
            shape->brief);
  for (PetscInt k = 0; k < n; k++)
    UserCheck(!PetscIsInfOrNanReal(number[k]), "%s: its numbers must be finite", option);
  wrong = BodySet(scene, shape, n, number, body);
  UserCheck(!wrong, "%s: %s", option, wrong);
  UserCheck(BodyPoints(body, BodySpacing(scene, body)) <= SHAPE_POINTS,
            "%s: its outline is longer than %d dx; a shape need not reach far beyond the box",
            option, SHAPE_POINTS);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ShapeRead - Reads the shape of item k of an option pattern; collective. Output: given - the user
   gave the option */
PetscErrorCode ShapeRead(const Scene *scene, const OptionRow *pattern, PetscInt k, Body *body,
                         PetscBool *given)
{
  char      name[OPTION_LENGTH], text[SHAPE_TEXT];
  OptionRow row;

  PetscFunctionBegin;
  OptionNumber(pattern, k, name, &row);
  PetscCall(OptionGetText(&row, sizeof(text), text, given));
  if (*given)
    PetscCall(ReadShape(scene, scene->dim == 3 ? row.table_3d : row.table, name, text, body));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ShapeReadPlane - Reads a shape of the plane, also in 3D; collective. Output: given - the user
   gave the option */
PetscErrorCode ShapeReadPlane(const Scene *scene, const OptionRow *row, Body *body,
                              PetscBool *given)
{
  char text[SHAPE_TEXT];

  PetscFunctionBegin;
  PetscCall(OptionGetText(row, sizeof(text), text, given));
  if (*given) PetscCall(ReadShape(scene, &ShapeTable, row->name, text, body));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ShapeCheckNumbers - Ends the run if an option of this pattern has a number other than 1, 2, ...,
   n; collective */
PetscErrorCode ShapeCheckNumbers(const OptionRow *pattern, PetscInt n, PetscInt most)
{
  PetscFunctionBegin;
  for (PetscInt k = 0; k <= most + 1; k++) {
    char      name[OPTION_LENGTH];
    OptionRow row;
    PetscBool given;

    if (k >= 1 && k <= n) continue;
    OptionNumber(pattern, k, name, &row);
    PetscCall(OptionGiven(name, &given));
    UserCheck(!given,
              "%s: numbers are 1, 2, ... without gaps, to at most %" PetscInt_FMT "; %" PetscInt_FMT
              " of them are given",
              name, most, n);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
