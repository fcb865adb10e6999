/* Bodies of a scene, and regions with the same shapes: set from numbers or typed in numbered
   options, as -scene_body_1 circle,0.5,0.5,0.25; distances from them, with periodic images, for
   fluid on either side of the surface. */
#include "geometry/shapes.h"
#include "isph/scene.h"
#include <stdlib.h>
#include <string.h>

#define BEYOND       16 /* numbers tried behind the last */
#define TOO_LARGE    "%s: its outline is longer than %d dx; a shape need not reach beyond the box"
#define SHAPE_POINTS 20000000 /* most points on a surface: checks visit all of them */

/* Reads the numbers of a shape, separated by commas. */
static PetscErrorCode ReadNumbers(Scene *scene, const ShapeRow *shape, const char option[],
                                  const char text[], Body *body)
{
  const char *wrong, *next = *text ? text : NULL;
  PetscReal  *number;
  PetscInt    n = 0;
  char       *end;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(strlen(text) + 1, &number));
  while (next) {
    number[n] = strtod(next, &end);
    end += strspn(end, " ");
    UserCheck(end != next && (*end == ',' || !*end), "%s: a number is required at '%.40s'", option,
              next);
    UserCheck(!PetscIsInfOrNanReal(number[n]), "%s: its numbers must be finite", option);
    n++;
    next = *end ? end + 1 : NULL;
  }
  UserCheck(n >= shape->fewest && (n <= shape->most || !shape->most), "%s: a %s is %s", option,
            shape->name, shape->brief);
  wrong = BodySet(scene, shape, n, number, body);
  UserCheck(!wrong, "%s: %s", option, wrong);
  PetscCall(PetscFree(number));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses a solid in a box that has too many points, before they are computed. */
static PetscErrorCode CheckSize(const Scene *scene, const char option[], const Body *body)
{
  const PetscReal dx = BodySpacing(scene, body);
  PetscReal       edge[ISPH_MAX_DIM], area = 0.0;

  PetscFunctionBegin;
  if (body->shape->plane || BodyReachesThrough(body, 2)) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) edge[a] = (body->hi[a] - body->lo[a]) / dx;
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) area += 2.0 * edge[a] * edge[(a + 1) % 3];
  UserCheck(area < 2.0 * SHAPE_POINTS, TOO_LARGE, option, SHAPE_POINTS);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the name of a shape of a table and its numbers, as "circle,0.5,0.5,0.25", or its text. */
static PetscErrorCode ReadPart(Scene *scene, const Table *table, const char option[],
                               const char text[], Body *body)
{
  const ShapeRow *shape;
  const size_t    length = strcspn(text, ",");
  char            word[KIND_NAME];

  PetscFunctionBegin;
  PetscCall(PetscStrncpy(word, text, PetscMin(length + 1, sizeof(word))));
  PetscCall(TableWant(table, option, word, &shape));
  text += text[length] ? length + 1 : length;
  if (shape->Read) {
    *body = (Body){.shape = shape, .store = &scene->store};
    PetscCall(shape->Read(option, text, body));
    BodySetBox(body);
  } else {
    PetscCall(ReadNumbers(scene, shape, option, text, body));
  }
  PetscCall(CheckSize(scene, option, body));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the operator " + ", " - " or " & " after a part of a compound; NULL behind the last. */
static char *NextOperator(char *text)
{
  for (char *at = text; *at; at++)
    if (at[0] == ' ' && strchr("+-&", at[1]) && at[1] && at[2] == ' ') return at;
  return NULL;
}

/* Reads a shape, or a compound of shapes, as "box,0,0,1,1 - circle,0.5,0.5,0.2". */
static PetscErrorCode ReadShape(Scene *scene, const Table *table, const char option[],
                                const char text[], Body *body)
{
  char       *copy, *next, *operation;
  const char *fault = NULL;
  Body       *part;
  PetscInt    n = 0;

  PetscFunctionBegin;
  PetscCall(PetscStrallocpy(text, &copy));
  PetscCall(PetscMalloc2(strlen(text) + 1, &operation, strlen(text) / 3 + 1, &part));
  for (char *from = copy; from; from = next) {
    operation[n] = from == copy ? '+' : from[-2];
    next         = NextOperator(from);
    if (next) *next = '\0';
    if (next) next += 3;
    PetscCall(ReadPart(scene, table, option, from + strspn(from, " "), &part[n++]));
  }
  *body = part[0];
  if (n > 1) {
    *body = (Body){.store = &scene->store};
    for (PetscInt end = 0; end < 2; end++) body->ends[end] = part[0].ends[end];
    body->centre[2] = part[0].centre[2];
    PetscCall(BodyCompound(n, part, operation, body, &fault));
  }
  UserCheck(!fault, "%s: %s", option, fault);
  PetscCall(PetscFree(copy));
  PetscCall(PetscFree2(operation, part));
  UserCheck(BodyPoints(body, BodySpacing(scene, body)) <= SHAPE_POINTS, TOO_LARGE, option,
            SHAPE_POINTS);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ShapeRead - Reads the shape of item k of an option pattern; collective. Input: place - of the
   shape in a list with semicolons, from 0; -1: there is no list. Output: given - the user gave the
   option, and this shape */
PetscErrorCode ShapeRead(Scene *scene, const OptionRow *pattern, PetscInt k, PetscInt place,
                         Body *body, PetscBool *given)
{
  char        name[OPTION_LENGTH], *shape;
  const char *text;
  OptionRow   row;

  PetscFunctionBegin;
  OptionNumber(pattern, k, name, &row);
  PetscCall(OptionTyped(name, &text, given));
  for (PetscInt before = 0; *given && before < place; before++) {
    text += strcspn(text, ";");
    if (*text) text += 1 + strspn(text + 1, " ");
    else *given = PETSC_FALSE;
  }
  if (!*given) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscStrallocpy(text, &shape));
  if (place >= 0) shape[strcspn(shape, ";")] = '\0';
  PetscCall(ReadShape(scene, scene->dim == 3 ? row.table_3d : row.table, name, shape, body));
  PetscCall(PetscFree(shape));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ShapeReadPlane - Reads a shape of the plane, also in 3D; collective. Output: given - the user
   gave the option */
PetscErrorCode ShapeReadPlane(Scene *scene, const OptionRow *row, Body *body, PetscBool *given)
{
  const char *text;

  PetscFunctionBegin;
  PetscCall(OptionTyped(row->name, &text, given));
  if (*given) PetscCall(ReadShape(scene, &ShapeTable, row->name, text, body));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ShapeCheckNumbers - Ends the run if an option of this pattern has a number other than 1, 2, ...,
   n, at most `most`, 0: any number; much larger ones are options that nothing reads; collective */
PetscErrorCode ShapeCheckNumbers(const OptionRow *pattern, PetscInt n, PetscInt most)
{
  char at_most[32] = "";

  PetscFunctionBegin;
  if (most) (void)snprintf(at_most, sizeof(at_most), ", to at most %" PetscInt_FMT, most);
  for (PetscInt k = 0; k <= PetscMax(most, n + BEYOND) + 1; k++) {
    char      name[OPTION_LENGTH];
    OptionRow row;
    PetscBool given;

    if (k >= 1 && k <= n) continue;
    OptionNumber(pattern, k, name, &row);
    PetscCall(OptionGiven(name, &given));
    UserCheck(!given,
              "%s: numbers are 1, 2, ... without gaps%s; number %" PetscInt_FMT " is missing", name,
              at_most, n + 1);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* BodySet - Sets a body from the numbers of its shape [m]. The fluid is outside the body. Its
   centre, about which it may rotate, is the centroid of its area or volume. The scene gives the
   ends of prisms in 3D. Returns: NULL, or a message about the wrong numbers. */
const char *BodySet(Scene *scene, const ShapeRow *shape, PetscInt n, const PetscReal number[],
                    Body *body)
{
  *body = (Body){.shape = shape};
  for (PetscInt end = 0; end < 2 && shape->outline; end++)
    body->ends[end] = end ? scene->hi[2] : scene->lo[2];
  body->centre[2] = 0.5 * (body->ends[0] + body->ends[1]);
  return BodyNumbers(shape, n, number, &scene->store, body);
}

/* BodyCircle - Sets a body to a circle of radius r > 0 about (x, y), in 3D to a cylinder along z
   [m] */
void BodyCircle(Scene *scene, PetscReal x, PetscReal y, PetscReal r, Body *body)
{
  const PetscReal number[3] = {x, y, r};

  (void)BodySet(scene, scene->dim == 3 ? &ShapeCylinder : &ShapeCircle, 3, number, body);
}

/* BodyBox - Sets a body to the box from lo to hi [m] */
void BodyBox(Scene *scene, const PetscReal lo[], const PetscReal hi[], Body *body)
{
  PetscReal number[2 * ISPH_MAX_DIM];

  for (PetscInt a = 0; a < scene->dim; a++) {
    number[a]              = lo[a];
    number[scene->dim + a] = hi[a];
  }
  (void)BodySet(scene, scene->dim == 3 ? &ShapeCuboid : &ShapeBox, 2 * scene->dim, number, body);
}

/* BodyBall - Sets a body to a circle of radius r > 0, in 3D to a ball [m] */
void BodyBall(Scene *scene, const PetscReal centre[], PetscReal r, Body *body)
{
  PetscReal number[ISPH_MAX_DIM + 1];

  for (PetscInt a = 0; a < scene->dim; a++) number[a] = centre[a];
  number[scene->dim] = r;
  (void)BodySet(scene, scene->dim == 3 ? &ShapeBall : &ShapeCircle, scene->dim + 1, number, body);
}

/* BodyPolygon - Sets a body to a polygon with 3 or more corners x, y [m], in 3D to the body that it
   makes with a turn about the axis z, with corners r >= 0, z; returns NULL or a fault */
const char *BodyPolygon(Scene *scene, PetscInt corners, const PetscReal x[], Body *body)
{
  return BodySet(scene, scene->dim == 3 ? &ShapeRevolved : &ShapePolygon, 2 * corners, x, body);
}

/* BodyOutline - Returns the plane shape of the outline of a body along z, or of the meridian of one
   that revolves; plane shapes are their own outline; NULL if there is none */
const ShapeRow *BodyOutline(const Scene *scene, const Body *body)
{
  return scene->dim == 2 ? body->shape : body->shape->outline;
}

/* Returns the signed distance of x from the nearest periodic image of a body, positive outside its
   outline, also for a body around the fluid [m]; one that is certainly larger than `most` may be
   any larger number, without outputs. Output: y - place of x relative to that image, in the body as
   typed; normal - out of the outline, of the body as it is. */
static PetscReal NearestImage(const Scene *scene, const Body *body, const PetscReal x[],
                              PetscReal most, PetscReal y[ISPH_MAX_DIM], PetscReal normal[])
{
  PetscReal base[ISPH_MAX_DIM] = {0.0}, step[ISPH_MAX_DIM] = {0.0}, best = PETSC_INFINITY;
  PetscInt  periodic = 0; /* bits of the axes along which there are images */

  for (PetscInt a = 0; a < scene->dim; a++) {
    const PetscReal period = scene->hi[a] - scene->lo[a];
    PetscReal       span[2], middle;

    base[a] = x[a];
    if (!SceneIsPeriodic(scene, a) || BodyReachesThrough(body, a)) continue;
    BodySpan(body, a, span);
    middle = 0.5 * (span[0] + span[1]);
    base[a] -= period * PetscFloorReal((x[a] - middle) / period + 0.5);
    step[a] = base[a] > middle ? -period : period; /* to the image on the other side of x */
    periodic |= 1 << a;
  }
  for (PetscInt image = 0; image < 1 << scene->dim; image++) {
    PetscReal z[ISPH_MAX_DIM], distance, n[ISPH_MAX_DIM] = {0.0};

    if (image & ~periodic) continue;
    for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) z[a] = base[a] + (image >> a & 1) * step[a];
    PoseInto(body, z);
    distance = BodyWithin(body, z, PetscMin(most, best), n);
    if (distance >= best) continue;
    best = distance;
    if (body->pose) PoseTurn(body->pose, PETSC_FALSE, n);
    for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) {
      y[a]      = z[a];
      normal[a] = n[a];
    }
  }
  return best;
}

/* BodyArm - Computes the vector from the centre of a body to x [m]. In a periodic box the image of
   the body nearest to x is used. */
void BodyArm(const Scene *scene, const Body *body, const PetscReal x[], PetscReal arm[ISPH_MAX_DIM])
{
  PetscReal normal[ISPH_MAX_DIM];

  (void)NearestImage(scene, body, x, PETSC_INFINITY, arm, normal);
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) arm[a] -= body->centre[a];
  if (body->pose) PoseTurn(body->pose, PETSC_FALSE, arm);
}

/* BodyDistance - Returns the distance from the surface of a body, positive in the fluid [m]. In a
   periodic box the nearest image of the body is used. Output: normal - into the fluid, at the
   surface point nearest to x. */
PetscReal BodyDistance(const Scene *scene, const Body *body, const PetscReal x[],
                       PetscReal normal[])
{
  return BodyDistanceWithin(scene, body, x, PETSC_INFINITY, normal);
}

/* Returns the largest distance of x along an axis from the box around a body, or its images: the
   body is not nearer [m]. */
static PetscReal BoxDistance(const Scene *scene, const Body *body, const PetscReal x[])
{
  PetscReal far = -PETSC_INFINITY;

  for (PetscInt a = 0; a < scene->dim; a++) {
    const PetscReal half = 0.5 * (body->hi[a] - body->lo[a]), period = scene->hi[a] - scene->lo[a];
    PetscReal       from;

    if (half == PETSC_INFINITY) continue;
    from = PetscAbsReal(x[a] - body->lo[a] - half);
    if (from - half > far && SceneIsPeriodic(scene, a))
      from = PetscAbsReal(from - period * PetscFloorReal(from / period + 0.5));
    far = PetscMax(far, from - half);
  }
  return far;
}

/* BodyDistanceWithin - Returns BodyDistance(), or any number larger than `most`, without a normal,
   if the distance is certainly larger [m] */
PetscReal BodyDistanceWithin(const Scene *scene, const Body *body, const PetscReal x[],
                             PetscReal most, PetscReal normal[])
{
  PetscReal y[ISPH_MAX_DIM], distance;

  if (!body->around && !body->pose && most < PETSC_INFINITY) {
    distance = BoxDistance(scene, body, x);
    if (distance > most + SCENE_ON_SURFACE * body->extent) return distance;
  }
  distance = NearestImage(scene, body, x, body->around ? PETSC_INFINITY : most, y, normal);
  if (!body->around) return distance;
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) normal[a] = -normal[a];
  return -distance;
}
