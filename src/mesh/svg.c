/*
  Outlines of SVG files: paths, polygons and polylines, closed if they are not. Curves become lines
  that are nearer to them than TOLERANCE. Coordinates y are turned: a drawing stands upright.
  Reference: Scalable Vector Graphics (SVG) 2, W3C 2018, chapter 9 and appendix B.2.
*/
#include "mesh.h"
#include <ctype.h>
#include <string.h>

#define TOLERANCE 1e-4 /* of lines in place of curves [largest side of the drawing] */

/* The pen that draws a path; its tolerance is infinite until the size of the drawing is known. */
typedef struct {
  MeshFile *file;
  PetscReal at[2], start[2], control[2]; /* control: of the last curve */
  PetscReal tolerance;
  char      last; /* command before, of either case as 'M' */
} Pen;

static PetscReal Number(Pen *pen)
{
  PetscReal x = 0.0;

  pen->file->at += strspn(pen->file->at, " \t\r\n,");
  if (!MeshNumber(pen->file, &x))
    MeshFail(pen->file, "a path has '%.20s' in place of a number", pen->file->at);
  return x;
}

/* Reads a flag of an arc, which may be followed by a number without a blank. */
static PetscBool Flag(Pen *pen)
{
  pen->file->at += strspn(pen->file->at, " \t\r\n,");
  if (*pen->file->at != '0' && *pen->file->at != '1') {
    MeshFail(pen->file, "a flag of an arc is 0 or 1");
    return PETSC_FALSE;
  }
  return *pen->file->at++ == '1' ? PETSC_TRUE : PETSC_FALSE;
}

/* Reads a point; of a small letter it is relative to the pen. */
static void Point(Pen *pen, PetscBool relative, PetscReal x[2])
{
  for (PetscInt a = 0; a < 2; a++) x[a] = Number(pen) + (relative ? pen->at[a] : 0.0);
}

static void LineTo(Pen *pen, const PetscReal x[2])
{
  for (PetscInt a = 0; a < 2; a++) pen->at[a] = x[a];
  MeshAddCorner(pen->file, x[0], -x[1]);
}

/* Draws a cubic curve in n lines; their error is at most max |B''|/(8 n^2). */
static void Cubic(Pen *pen, const PetscReal p[2], const PetscReal q[2], const PetscReal end[2])
{
  const PetscReal start[2] = {pen->at[0], pen->at[1]};
  PetscReal       bend     = 0.0;
  PetscInt        n;

  for (PetscInt a = 0; a < 2; a++)
    bend += PetscSqr(PetscMax(PetscAbsReal(start[a] - 2.0 * p[a] + q[a]),
                              PetscAbsReal(p[a] - 2.0 * q[a] + end[a])));
  n = 8 +
      (PetscInt)PetscMin(1e4, PetscSqrtReal(6.0 * PetscSqrtReal(bend) / (8.0 * pen->tolerance)));
  for (PetscInt k = 1; k <= n && !*pen->file->fault; k++) {
    const PetscReal t = (PetscReal)k / n, s = 1.0 - t;
    PetscReal       x[2];

    for (PetscInt a = 0; a < 2; a++)
      x[a] = k == n
                 ? end[a]
                 : s * s * s * start[a] + 3.0 * s * t * (s * p[a] + t * q[a]) + t * t * t * end[a];
    LineTo(pen, x);
  }
  for (PetscInt a = 0; a < 2; a++) pen->control[a] = q[a];
}

/* Draws an arc of an ellipse from its end points. */
static void Arc(Pen *pen, PetscReal r[2], PetscReal degrees, PetscBool large, PetscBool sweep,
                const PetscReal end[2])
{
  const PetscReal w = degrees * PETSC_PI / 180.0, cs = PetscCosReal(w), sn = PetscSinReal(w);
  const PetscReal d[2] = {0.5 * (pen->at[0] - end[0]), 0.5 * (pen->at[1] - end[1])};
  const PetscReal m[2] = {0.5 * (pen->at[0] + end[0]), 0.5 * (pen->at[1] + end[1])};
  const PetscReal rx = PetscAbsReal(r[0]), ry = PetscAbsReal(r[1]);
  const PetscReal u      = rx > 0.0 ? (cs * d[0] + sn * d[1]) / rx : 0.0,
                  v      = ry > 0.0 ? (cs * d[1] - sn * d[0]) / ry : 0.0;
  const PetscReal square = u * u + v * v, grow = PetscMax(1.0, PetscSqrtReal(square));
  const PetscReal far =
      (large == sweep ? -1.0 : 1.0) * PetscSqrtReal(PetscMax(0.0, PetscSqr(grow) / square - 1.0));
  PetscReal from, turn;
  PetscInt  n;

  if (square == 0.0 || rx == 0.0 || ry == 0.0) {
    LineTo(pen, end);
    return;
  }
  /* in circles of radius `grow`: the centre is far (v, -u), the ends are (u, v) and -(u, v) */
  from = PetscAtan2Real(v + far * u, u - far * v);
  turn = PetscAtan2Real(-v + far * u, -u - far * v) - from;
  if (sweep && turn < 0.0) turn += 2.0 * PETSC_PI;
  if (!sweep && turn > 0.0) turn -= 2.0 * PETSC_PI;
  n = 8 + (PetscInt)PetscMin(1e4, PetscAbsReal(turn) * PetscSqrtReal(grow * PetscMax(rx, ry) /
                                                                     (8.0 * pen->tolerance)));
  for (PetscInt k = 1; k <= n && !*pen->file->fault; k++) {
    const PetscReal angle = from + turn * k / n;
    const PetscReal x     = rx * (far * v + grow * PetscCosReal(angle)),
                    y     = ry * (-far * u + grow * PetscSinReal(angle));
    const PetscReal to[2] = {m[0] + cs * x - sn * y, m[1] + sn * x + cs * y};

    LineTo(pen, k == n ? end : to);
  }
}

/* Draws a curve of the commands C, S, Q and T. */
static void Bend(Pen *pen, char command, PetscBool relative)
{
  const PetscBool cubic = command == 'C' || command == 'S';
  const PetscBool smooth =
      cubic ? pen->last == 'C' || pen->last == 'S' : pen->last == 'Q' || pen->last == 'T';
  PetscReal p[2], q[2], end[2];

  for (PetscInt a = 0; a < 2; a++) p[a] = smooth ? 2.0 * pen->at[a] - pen->control[a] : pen->at[a];
  if (command == 'C' || command == 'Q') Point(pen, relative, p);
  if (cubic) Point(pen, relative, q);
  Point(pen, relative, end);
  if (cubic) {
    Cubic(pen, p, q, end);
    return;
  }
  {
    PetscReal first[2];

    for (PetscInt a = 0; a < 2; a++) {
      first[a] = (pen->at[a] + 2.0 * p[a]) / 3.0;
      q[a]     = (end[a] + 2.0 * p[a]) / 3.0;
    }
    Cubic(pen, first, q, end);
  }
  for (PetscInt a = 0; a < 2; a++) pen->control[a] = p[a];
}

/* Draws an item of a command. */
static void Draw(Pen *pen, char command, PetscBool relative)
{
  PetscReal x[2] = {pen->at[0], pen->at[1]}, r[2], degrees;
  PetscBool large, sweep;

  switch (command) {
  case 'H':
  case 'V':
    x[command == 'V'] = Number(pen) + (relative ? x[command == 'V'] : 0.0);
    LineTo(pen, x);
    break;
  case 'C':
  case 'S':
  case 'Q':
  case 'T':
    Bend(pen, command, relative);
    break;
  case 'A':
    for (PetscInt a = 0; a < 2; a++) r[a] = Number(pen);
    degrees = Number(pen);
    large   = Flag(pen);
    sweep   = Flag(pen);
    Point(pen, relative, x);
    Arc(pen, r, degrees, large, sweep, x);
    break;
  default:
    if (command == 'M') MeshEndLoop(pen->file);
    Point(pen, relative, x);
    LineTo(pen, x);
    for (PetscInt a = 0; a < 2 && command == 'M'; a++) pen->start[a] = x[a];
  }
}

/* Draws the path of an attribute up to its quotation mark. */
static void Path(Pen *pen, char command, char quote)
{
  PetscBool relative = PETSC_FALSE;

  while (!*pen->file->fault) {
    pen->file->at += strspn(pen->file->at, " \t\r\n,");
    if (*pen->file->at == quote) break;
    if (isalpha((unsigned char)*pen->file->at)) {
      relative = islower((unsigned char)*pen->file->at) ? PETSC_TRUE : PETSC_FALSE;
      command  = (char)toupper((unsigned char)*pen->file->at++);
      if (!strchr("MLHVCSQTAZ", command))
        MeshFail(pen->file, "a path has the command '%c'", pen->file->at[-1]);
    } else if (command == 'Z') {
      MeshFail(pen->file, "a path has '%.20s' in place of a command", pen->file->at);
    }
    if (command == 'Z') {
      MeshEndLoop(pen->file);
      for (PetscInt a = 0; a < 2; a++) pen->at[a] = pen->start[a];
      pen->last = 'Z';
      continue;
    }
    if (pen->last == 'Z' && command != 'M') MeshAddCorner(pen->file, pen->at[0], -pen->at[1]);
    Draw(pen, command, relative);
    pen->last = command;
    if (command == 'M') command = 'L';
  }
  MeshEndLoop(pen->file);
}

/* Draws all elements. */
static void DrawAll(Pen *pen)
{
  static const struct {
    const char *element, *attribute;
  } known[] = {{"path", " d="}, {"polygon", " points="}, {"polyline", " points="}};
  static const char *const refused[] = {"rect",     "circle", "ellipse", "line",   "use",   "text",
                                        "clipPath", "mask",   "pattern", "marker", "symbol"};
  MeshFile                *file      = pen->file;

  file->at = file->text;
  while ((file->at = strchr(file->at, '<')) && !*file->fault) {
    const char  *element = ++file->at, *end = strchr(element, '>');
    const size_t n = strcspn(element, " \t\r\n/>");

    if (!strncmp(element, "!--", 3)) end = strstr(element, "-->");
    if (!end) MeshFail(file, "an element does not end: a part of the file is missing");
    for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(refused); k++)
      if (n == strlen(refused[k]) && !strncmp(element, refused[k], n))
        MeshFail(file, "it has <%s>; convert all objects to paths", refused[k]);
    for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(known) && !*file->fault; k++) {
      const char *attribute = element + n, *letter;

      if (n != strlen(known[k].element) || strncmp(element, known[k].element, n)) continue;
      for (; attribute < end; attribute++) { /* blanks before an attribute may be ends of lines */
        letter = isspace((unsigned char)*attribute) ? attribute + 1 : NULL;
        if (letter && !strncmp(letter, known[k].attribute + 1, strlen(known[k].attribute) - 1))
          break;
      }
      if (attribute >= end) continue;
      file->at  = attribute + strlen(known[k].attribute) + 1;
      pen->last = 'Z';
      for (PetscInt a = 0; a < 2; a++) pen->at[a] = pen->start[a] = 0.0;
      Path(pen, k ? 'M' : 'Z', file->at[-1]);
    }
    if (end) file->at = end;
  }
}

/* MeshReadSvg - Reads the outlines of an SVG file; not collective */
void MeshReadSvg(MeshFile *file)
{
  Pen       pen  = {.file = file, .tolerance = PETSC_INFINITY};
  PetscReal size = 0.0;

  for (const char *at = file->text; (at = strstr(at, "transform=")); at++)
    if (isspace((unsigned char)at[-1]))
      MeshFail(file, "it has a transform; apply transforms to the paths before it is written");
  DrawAll(&pen);
  for (PetscInt a = 0; a < 2; a++) {
    PetscReal lo = PETSC_INFINITY, hi = -PETSC_INFINITY;

    for (PetscInt k = a; k < file->n; k += 3) {
      lo = PetscMin(lo, file->number[k]);
      hi = PetscMax(hi, file->number[k]);
    }
    size = PetscMax(size, hi - lo);
  }
  file->n = file->loops = 0;
  pen.tolerance         = TOLERANCE * size;
  if (!*file->fault) DrawAll(&pen);
}
