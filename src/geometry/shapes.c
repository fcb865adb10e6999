/* Shapes of bodies in the plane, defined by a signed distance and by points along the surface. A
   new shape is five functions, a row and an entry of the table at the end. */
#include "shapes.h"

/* ---- circle: cx, cy, r ---- */

static const char *CirclePrepare(Body *body)
{
  for (PetscInt a = 0; a < 2; a++) body->centre[a] = body->parameter[a];
  body->extent = body->parameter[2];
  return body->extent > 0.0 ? NULL : "the radius must be positive";
}

static void CircleSpan(const Body *body, PetscInt axis, PetscReal span[2])
{
  span[0] = body->centre[axis] - body->extent;
  span[1] = body->centre[axis] + body->extent;
}

static PetscReal CircleDistance(const Body *body, const PetscReal x[], PetscReal normal[])
{
  const PetscReal *c = body->parameter, dx = x[0] - c[0], dy = x[1] - c[1],
                  r = PetscSqrtReal(dx * dx + dy * dy);

  normal[0] = r > 0.0 ? dx / r : 1.0;
  normal[1] = r > 0.0 ? dy / r : 0.0;
  return r - c[2];
}

static PetscInt CircleCount(const Body *body, PetscReal dx)
{
  return ShapeLineCount(2.0 * PETSC_PI * body->parameter[2], dx, 8);
}

static PetscReal CirclePoint(const Body *body, PetscInt k, PetscReal dx, PetscReal x[],
                             PetscReal normal[])
{
  const PetscInt  n     = CircleCount(body, dx);
  const PetscReal angle = 2.0 * PETSC_PI * (k + 0.5) / n;

  normal[0] = PetscCosReal(angle);
  normal[1] = PetscSinReal(angle);
  for (PetscInt a = 0; a < 2; a++) x[a] = body->parameter[a] + body->parameter[2] * normal[a];
  return 2.0 * PETSC_PI * body->parameter[2] / n;
}

/* ---- polygon: x, y of each corner, counter-clockwise ---- */

static PetscInt Corners(const Body *body)
{
  return body->n / 2;
}

/* Gets the ends of edge e; returns its length. */
static PetscReal Edge(const Body *body, PetscInt e, const PetscReal **from, const PetscReal **to)
{
  *from = &body->parameter[2 * e];
  *to   = &body->parameter[2 * ((e + 1) % Corners(body))];
  return PetscSqrtReal(PetscSqr((*to)[0] - (*from)[0]) + PetscSqr((*to)[1] - (*from)[1]));
}

/* Returns twice the signed area of the triangle a, b, c. */
static PetscReal CrossProduct(const PetscReal a[], const PetscReal b[], const PetscReal c[])
{
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/* Returns true if two edges without a common corner cross or touch. */
static PetscBool EdgesCross(const Body *body, PetscInt e, PetscInt f)
{
  const PetscReal *a, *b, *c, *d;

  (void)Edge(body, e, &a, &b);
  (void)Edge(body, f, &c, &d);
  for (PetscInt k = 0; k < 2; k++) { /* disjoint along an axis; decides for collinear edges */
    if (PetscMax(a[k], b[k]) < PetscMin(c[k], d[k]) || PetscMax(c[k], d[k]) < PetscMin(a[k], b[k]))
      return PETSC_FALSE;
  }
  return CrossProduct(a, b, c) * CrossProduct(a, b, d) <= 0.0 &&
         CrossProduct(c, d, a) * CrossProduct(c, d, b) <= 0.0;
}

/* Checks the corners and orders them counter-clockwise; computes the centroid and the extent. */
static const char *PolygonPrepare(Body *body)
{
  PetscReal     *c = body->parameter, area = 0.0, longest = 0.0;
  const PetscInt corners = Corners(body);

  if (body->n % 2) return "a polygon has two numbers for each corner";
  for (PetscInt e = 0; e < corners; e++) {
    const PetscReal *a, *b, length = Edge(body, e, &a, &b);
    PetscReal        triangle;

    if (length == 0.0)
      return "two corners in a row are at one place; each side needs a length, and a polygon "
             "closes by itself";
    longest  = PetscMax(longest, length);
    triangle = 0.5 * CrossProduct(c, a, b);
    area += triangle;
    for (PetscInt k = 0; k < 2; k++) body->centre[k] += triangle * (c[k] + a[k] + b[k]) / 3.0;
  }
  for (PetscInt e = 0; e < corners; e++) {
    for (PetscInt f = e + 2; f < corners - (e == 0); f++) {
      if (EdgesCross(body, e, f)) return "its sides cross or touch; a polygon has one inside";
    }
  }
  if (PetscAbsReal(area) <= 1e-12 * PetscSqr(longest)) return "it has no area";
  for (PetscInt k = 0; k < 2; k++) body->centre[k] /= area;
  for (PetscInt k = 0; area < 0.0 && k < corners / 2; k++) {
    const PetscInt m = corners - 1 - k;

    for (PetscInt a = 0; a < 2; a++) {
      const PetscReal kept = c[2 * k + a];

      c[2 * k + a] = c[2 * m + a];
      c[2 * m + a] = kept;
    }
  }
  for (PetscInt k = 0; k < body->n; k++)
    body->extent = PetscMax(body->extent, PetscAbsReal(c[k] - body->centre[k % 2]));
  return NULL;
}

/* ShapeBoxPrepare - Replaces the two opposite corners of a box by its four corners, as a polygon;
   returns NULL or a fault */
const char *ShapeBoxPrepare(Body *body)
{
  PetscReal      *c      = body->parameter;
  const PetscReal box[8] = {c[0], c[1], c[2], c[1], c[2], c[3], c[0], c[3]};

  if (c[0] == c[2] || c[1] == c[3]) return "the box has no width or no height";
  for (PetscInt k = 0; k < 8; k++) c[k] = box[k];
  body->n = 8;
  return PolygonPrepare(body);
}

static void PolygonSpan(const Body *body, PetscInt axis, PetscReal span[2])
{
  span[0] = span[1] = body->parameter[axis];
  for (PetscInt k = axis; k < body->n; k += 2) {
    span[0] = PetscMin(span[0], body->parameter[k]);
    span[1] = PetscMax(span[1], body->parameter[k]);
  }
}

/* Returns the signed distance from the nearest edge; x is inside if a ray from it along the first
   axis crosses an odd number of edges. */
static PetscReal PolygonDistance(const Body *body, const PetscReal x[], PetscReal normal[])
{
  PetscReal best = PETSC_MAX_REAL, nearest[2] = {0.0}, outward[2] = {0.0}, d;
  PetscBool inside = PETSC_FALSE;

  for (PetscInt e = 0; e < Corners(body); e++) {
    const PetscReal *a, *b, length = Edge(body, e, &a, &b), tx = (b[0] - a[0]) / length,
                            ty = (b[1] - a[1]) / length;
    const PetscReal s  = PetscMin(PetscMax((x[0] - a[0]) * tx + (x[1] - a[1]) * ty, 0.0), length);
    const PetscReal px = a[0] + s * tx, py = a[1] + s * ty,
                    d2 = PetscSqr(x[0] - px) + PetscSqr(x[1] - py);

    if (d2 < best) {
      best       = d2;
      nearest[0] = px;
      nearest[1] = py;
      outward[0] = ty;
      outward[1] = -tx;
    }
    if ((a[1] > x[1]) != (b[1] > x[1]) &&
        x[0] < a[0] + (x[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]))
      inside = !inside;
  }
  d = PetscSqrtReal(best) * (inside ? -1.0 : 1.0);
  for (PetscInt a = 0; a < 2; a++)
    normal[a] = PetscAbsReal(d) > 1e-9 * body->extent ? (x[a] - nearest[a]) / d : outward[a];
  return d;
}

static PetscInt EdgeCount(const Body *body, PetscInt e, PetscReal dx)
{
  const PetscReal *a, *b;

  return ShapeLineCount(Edge(body, e, &a, &b), dx, 1);
}

static PetscInt PolygonCount(const Body *body, PetscReal dx)
{
  PetscInt n = 0;

  for (PetscInt e = 0; e < Corners(body); e++) n += EdgeCount(body, e, dx);
  return n;
}

static PetscReal PolygonPoint(const Body *body, PetscInt k, PetscReal dx, PetscReal x[],
                              PetscReal normal[])
{
  const PetscReal *a, *b;
  PetscReal        length, s;
  PetscInt         e = 0, n;

  while (k >= EdgeCount(body, e, dx)) k -= EdgeCount(body, e++, dx);
  n      = EdgeCount(body, e, dx);
  length = Edge(body, e, &a, &b);
  s      = (k + 0.5) / n;
  for (PetscInt c = 0; c < 2; c++) x[c] = (1.0 - s) * a[c] + s * b[c];
  normal[0] = (b[1] - a[1]) / length;
  normal[1] = -(b[0] - a[0]) / length;
  return length / n;
}

const ShapeRow ShapeCircle = {.name     = "circle",
                              .brief    = "cx,cy,r",
                              .plane    = PETSC_TRUE,
                              .fewest   = 3,
                              .most     = 3,
                              .round    = PETSC_TRUE,
                              .Prepare  = CirclePrepare,
                              .Span     = CircleSpan,
                              .Distance = CircleDistance,
                              .Count    = CircleCount,
                              .Point    = CirclePoint};

const ShapeRow ShapeBox = {.name     = "box",
                           .brief    = "x0,y0,x1,y1: two opposite corners",
                           .plane    = PETSC_TRUE,
                           .fewest   = 4,
                           .most     = 4,
                           .Prepare  = ShapeBoxPrepare,
                           .Span     = PolygonSpan,
                           .Distance = PolygonDistance,
                           .Count    = PolygonCount,
                           .Point    = PolygonPoint};

const ShapeRow ShapePolygon = {.name     = "polygon",
                               .brief    = "x0,y0,x1,y1,...: 3 or more corners in order",
                               .plane    = PETSC_TRUE,
                               .fewest   = 6,
                               .Prepare  = PolygonPrepare,
                               .Span     = PolygonSpan,
                               .Distance = PolygonDistance,
                               .Count    = PolygonCount,
                               .Point    = PolygonPoint};
