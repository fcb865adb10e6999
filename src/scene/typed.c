/*
  Scenes typed on the command line: the box, its sides and bodies from options, checked so that a mistake
  is told before a particle exists.
*/
#include "isph/scene.h"
#include <stdlib.h>
#include <string.h>

/* n numbers of an option, all or none. */
static PetscErrorCode ReadNumbers(PetscOptionItems *PetscOptionsObject, const char option[],
                                  const char text[], PetscInt n, PetscReal number[],
                                  PetscBool *given)
{
  PetscInt got = n;

  PetscFunctionBegin;
  PetscCall(PetscOptionsRealArray(option, text, "", number, &got, given));
  UserCheck(!*given || got == n, "%s: %" PetscInt_FMT " numbers are wanted, got %" PetscInt_FMT,
            option, n, got);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* "circle,0.5,0.5,0.25": the shape's word, then its numbers. */
static PetscErrorCode ReadShape(const char option[], const char text[], Body *body)
{
  const TableRow *row;
  const ShapeRow *shape;
  PetscReal       number[BODY_NUMBERS];
  PetscInt        n = 0;
  char            word[512], *next, *end;

  PetscFunctionBegin;
  PetscCall(PetscStrncpy(word, text, sizeof(word)));
  next = strchr(word, ',');
  if (next) *next++ = '\0';
  PetscCall(TableFind(&ShapeTable, word, &row));
  UserCheck(row, "%s %s: no such shape; choose one of circle, box, polygon", option, word);
  shape = (const ShapeRow *)(const void *)row;
  while (next && n < BODY_NUMBERS) {
    number[n++] = strtod(next, &end);
    UserCheck(end != next && (*end == ',' || !*end), "%s: a number is wanted at '%s'", option,
              next);
    next = *end ? end + 1 : NULL;
  }
  UserCheck(!next && n >= shape->fewest && n <= shape->most && (n % 2 == 0 || shape->most == 3),
            "%s: a %s is %s", option, shape->name, shape->brief);
  UserCheck(n != 3 || number[2] > 0.0, "%s: the radius must be positive, got %.6g", option,
            (double)number[2]);
  BodySet(body, shape, n, number);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Bodies 1, 2, ... as far as they are given. */
static PetscErrorCode ReadBodies(PetscOptionItems *PetscOptionsObject, Scene *scene)
{
  PetscFunctionBegin;
  for (PetscInt k = 1; k <= SCENE_MAX_BODIES; k++) {
    Body     *body = &scene->body_of[scene->n_bodies];
    char      option[64], text[512] = "";
    PetscBool given;

    PetscCall(PetscSNPrintf(option, sizeof(option), "-scene_body_%" PetscInt_FMT, k));
    PetscCall(PetscOptionsString(option,
                                 "A body: circle,cx,cy,r | box,x0,y0,x1,y1 | polygon,x0,y0,...", "",
                                 text, text, sizeof(text), &given));
    if (!given) break;
    PetscCall(ReadShape(option, text, body));
    PetscCall(PetscSNPrintf(option, sizeof(option), "-scene_body_%" PetscInt_FMT "_velocity", k));
    PetscCall(ReadNumbers(PetscOptionsObject, option, "Velocity of its surface [m/s]", 2,
                          body->velocity, &given));
    PetscCall(PetscSNPrintf(option, sizeof(option), "-scene_body_%" PetscInt_FMT "_rotation", k));
    PetscCall(OptionReal(option, "Rotation rate of its surface about its centre [rad/s]", -1e100,
                         1e100, &body->rotation, NULL));
    PetscCall(PetscSNPrintf(option, sizeof(option), "-scene_body_%" PetscInt_FMT "_around", k));
    PetscCall(
        PetscOptionsBool(option, "The fluid is inside it", "", body->around, &body->around, NULL));
    if (body->around) scene->bare = PETSC_TRUE;
    scene->n_bodies++;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Surfaces keep apart by what a fit needs between them. */
static PetscErrorCode CheckGaps(const Scene *scene)
{
  PetscFunctionBegin;
  for (PetscInt k = 0; k < scene->n_bodies; k++) {
    const Body *body = &scene->body_of[k];

    for (PetscInt q = 0; q < BodyPoints(body, scene->dx); q++) {
      PetscReal x[ISPH_MAX_DIM], normal[ISPH_MAX_DIM], gap = PETSC_INFINITY, other[ISPH_MAX_DIM];

      (void)BodyPoint(body, q, scene->dx, x, normal);
      for (PetscInt m = 0; m < scene->n_bodies; m++) {
        if (m != k) gap = PetscMin(gap, BodyDistance(scene, &scene->body_of[m], x, other));
      }
      for (PetscInt a = 0; a < 2 && !scene->bare; a++) {
        if (!scene->periodic[a])
          gap = PetscMin(gap, PetscMin(x[a] - scene->lo[a], scene->hi[a] - x[a]));
      }
      UserCheck(
          gap >= 4.0 * scene->dx,
          "-scene_body_%" PetscInt_FMT
          ": at (%.4g, %.4g) it is %.3g from another wall; less than 4 dx = %.3g, or overlapping; "
          "use a larger -n",
          k + 1, (double)x[0], (double)x[1], (double)gap, (double)(4.0 * scene->dx));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  SceneReadTyped - The scene of -case scene

  Collective, between PetscOptionsBegin() and PetscOptionsEnd().

  Options Database Keys:
+ -scene_box x0,y0,x1,y1           - corners [m]; by default the unit square
. -scene_periodic x,y              - axes that are periodic
. -scene_wall_<side>_velocity u,v  - of the sides left, right, bottom, top [m/s]
. -scene_body_<k> shape,...        - bodies 1, 2, ...
. -scene_body_<k>_velocity u,v     - of its surface [m/s]
. -scene_body_<k>_rotation w       - of its surface [rad/s]
- -scene_body_<k>_around           - the fluid is inside; the box then has no walls of its own

  Errors: what is no shape, bodies that overlap or leave gaps of less than 4 dx
*/
PetscErrorCode SceneReadTyped(PetscOptionItems *PetscOptionsObject, Scene *scene)
{
  const char *const axes[2] = {"x", "y"}, *const sides[4] = {"left", "right", "bottom", "top"};
  PetscReal box[4] = {0.0, 0.0, scene->length, scene->length};
  unsigned  periodic;
  PetscBool given;

  PetscFunctionBegin;
  PetscCall(ReadNumbers(PetscOptionsObject, "-scene_box", "Corners of the box: x0,y0,x1,y1 [m]", 4,
                        box, &given));
  PetscCall(OptionFlags("-scene_periodic", "Periodic axes", axes, 2, &periodic));
  for (PetscInt a = 0; a < 2; a++) {
    scene->lo[a]       = box[a];
    scene->hi[a]       = box[2 + a];
    scene->periodic[a] = (periodic & (1u << a)) ? PETSC_TRUE : PETSC_FALSE;
    UserCheck(box[2 + a] - box[a] >= 4.0 * scene->dx,
              "-scene_box: it is %.4g wide along %s; at least 4 dx = %.4g is allowed",
              (double)(box[2 + a] - box[a]), axes[a], (double)(4.0 * scene->dx));
  }
  for (PetscInt side = 0; side < 4; side++) {
    char option[64];

    if (scene->periodic[side / 2]) continue;
    PetscCall(PetscSNPrintf(option, sizeof(option), "-scene_wall_%s_velocity", sides[side]));
    PetscCall(ReadNumbers(PetscOptionsObject, option, "Velocity of a side of the box [m/s]", 2,
                          scene->side_velocity[side], &given));
  }
  PetscCall(ReadBodies(PetscOptionsObject, scene));
  PetscCall(CheckGaps(scene));
  PetscFunctionReturn(PETSC_SUCCESS);
}
