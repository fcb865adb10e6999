/*
  Shapes of bodies in the plane, defined by a signed distance and by points along the surface. A new
  shape is five functions and a row of the table at the end.
*/
#include "isph/scene.h"

/* Returns the number of points dx apart on a line, at least `fewest`; bounded, so that a body can
   add up its lines. */
static PetscInt LineCount(PetscReal length, PetscReal dx, PetscInt fewest)
{
  const PetscReal most = (PetscReal)(PETSC_INT_MAX / BODY_PARAMETERS);

  return PetscMax(fewest, (PetscInt)PetscMin(PetscFloorReal(length / dx + 0.5), most));
}

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
  return LineCount(2.0 * PETSC_PI * body->parameter[2], dx, 8);
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
static PetscReal Turn(const PetscReal a[], const PetscReal b[], const PetscReal c[])
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
  return Turn(a, b, c) * Turn(a, b, d) <= 0.0 && Turn(c, d, a) * Turn(c, d, b) <= 0.0 ? PETSC_TRUE
                                                                                      : PETSC_FALSE;
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
    triangle = 0.5 * Turn(c, a, b);
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

/* Replaces the two opposite corners of a box by its four corners, as a polygon. */
static const char *BoxPrepare(Body *body)
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

  return LineCount(Edge(body, e, &a, &b), dx, 1);
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

static const ShapeRow shapes[] = {
    {
        .name     = "circle",
        .brief    = "cx,cy,r",
        .citation = "",
        .fewest   = 3,
        .most     = 3,
        .round    = PETSC_TRUE,
        .Prepare  = CirclePrepare,
        .Span     = CircleSpan,
        .Distance = CircleDistance,
        .Count    = CircleCount,
        .Point    = CirclePoint,
    },
    {
        .name     = "box",
        .brief    = "x0,y0,x1,y1: two opposite corners",
        .citation = "",
        .fewest   = 4,
        .most     = 4,
        .Prepare  = BoxPrepare,
        .Span     = PolygonSpan,
        .Distance = PolygonDistance,
        .Count    = PolygonCount,
        .Point    = PolygonPoint,
    },
    {
        .name     = "polygon",
        .brief    = "x0,y0,x1,y1,...: 3 to 32 corners in order",
        .citation = "",
        .fewest   = 6,
        .most     = BODY_PARAMETERS,
        .Prepare  = PolygonPrepare,
        .Span     = PolygonSpan,
        .Distance = PolygonDistance,
        .Count    = PolygonCount,
        .Point    = PolygonPoint,
    },
};
const Table ShapeTable = TABLE("Shapes of bodies and fluids", shapes);

/*
  BodySet - Sets a body from the numbers of its shape [m]

  Not collective. The fluid is outside the body. Its centre, about which it may rotate, is the
  centroid of its area. Returns: NULL, or a message about the wrong numbers.
*/
const char *BodySet(Body *body, const ShapeRow *shape, PetscInt n, const PetscReal number[])
{
  *body = (Body){.shape = shape, .n = n};
  for (PetscInt k = 0; k < n; k++) body->parameter[k] = number[k];
  return shape->Prepare(body);
}

/* BodyCircle - Sets a body to a circle of radius r > 0 about (x, y) [m]; not collective */
void BodyCircle(Body *body, PetscReal x, PetscReal y, PetscReal r)
{
  const PetscReal number[3] = {x, y, r};

  (void)BodySet(body, &shapes[0], 3, number);
}

/* BodyPolygon - Sets a body to a polygon with 3 to 32 corners x, y [m]; returns NULL or a fault;
   not collective */
const char *BodyPolygon(Body *body, PetscInt corners, const PetscReal x[])
{
  return BodySet(body, &shapes[2], 2 * corners, x);
}

/* BodySpan - Computes the least and largest coordinate of a body along an axis of the plane, or
   along any axis if it revolves [m] */
void BodySpan(const Body *body, PetscInt axis, PetscReal span[2])
{
  body->shape->Span(body, body->revolves ? axis / 2 : axis, span);
  if (body->revolves && axis < 2) span[0] = -span[1];
}

/* BodyLines - Computes the coordinates of the corners of a body along an axis of the plane [m];
   returns their number, 0 unless all edges are lines along the axes; not collective */
PetscInt BodyLines(const Body *body, PetscInt axis, PetscReal line[])
{
  if (body->shape->round || body->revolves) return 0;
  for (PetscInt e = 0; e < Corners(body); e++) {
    const PetscReal *a, *b;

    (void)Edge(body, e, &a, &b);
    if (a[0] != b[0] && a[1] != b[1]) return 0;
    line[e] = a[axis];
  }
  return Corners(body);
}

/*
  BodyThickness - Returns the least thickness of a body between opposite surfaces [m]

  Not collective. Searches inwards in steps of dx/4 from surface points dx apart. The two surfaces
  at the tip of a wedge count as opposite only if its angle is less than about 50 degrees. Input:
  limit - largest distance of the search. Output: place - surface point at the least thickness.
  Returns: limit if the body is nowhere thinner, and for bodies around the fluid.
*/
PetscReal BodyThickness(const Body *body, PetscReal dx, PetscReal limit, PetscReal place[2])
{
  PetscReal thinnest = limit;

  for (PetscInt k = 0; !body->around && k < BodyPoints(body, dx); k++) {
    PetscReal x[ISPH_MAX_DIM], out[ISPH_MAX_DIM], y[2], other[ISPH_MAX_DIM], beyond = -1.0;

    (void)BodyPoint(body, k, dx, x, out);
    for (PetscReal s = 0.25 * dx; beyond <= 0.0 && s < limit + 0.25 * dx; s += 0.25 * dx) {
      for (PetscInt a = 0; a < 2; a++) y[a] = x[a] - s * out[a];
      beyond = body->shape->Distance(body, y, other);
      if (beyond <= 0.0 || s - beyond >= thinnest || other[0] * out[0] + other[1] * out[1] > -0.6)
        continue;
      thinnest = s - beyond;
      place[0] = x[0];
      place[1] = x[1];
    }
  }
  return thinnest;
}

/*
  Returns the signed distance of x from the nearest periodic image of a body, positive outside its
  outline, also for a body around the fluid [m]. Output: y - x shifted by periods, so that its
  position relative to the body is the position of x relative to that image; normal - out of the
  outline.
*/
static PetscReal NearestImage(const Scene *scene, const Body *body, const PetscReal x[],
                              PetscReal y[2], PetscReal normal[])
{
  PetscReal base[2], step[2] = {0.0, 0.0}, best = PETSC_INFINITY;

  for (PetscInt a = 0; a < 2; a++) {
    const PetscReal period = scene->hi[a] - scene->lo[a];
    PetscReal       span[2], middle;

    base[a] = x[a];
    if (!SceneIsPeriodic(scene, a)) continue;
    BodySpan(body, a, span);
    middle = 0.5 * (span[0] + span[1]);
    base[a] -= period * PetscFloorReal((x[a] - middle) / period + 0.5);
    step[a] = base[a] > middle ? -period : period; /* to the image on the other side of x */
  }
  for (PetscInt image = 0; image < 4; image++) {
    const PetscReal z[2] = {base[0] + (image % 2) * step[0], base[1] + (image / 2) * step[1]};
    PetscReal       distance, n[ISPH_MAX_DIM] = {0.0};

    if ((image % 2 && step[0] == 0.0) || (image / 2 && step[1] == 0.0)) continue;
    distance = body->shape->Distance(body, z, n);
    if (distance >= best) continue;
    best = distance;
    for (PetscInt a = 0; a < 2; a++) y[a] = z[a];
    for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) normal[a] = n[a];
  }
  return best;
}

/*
  BodyArm - Computes the vector from the centre of a body to x [m]

  Not collective. In a periodic box the image of the body nearest to x is used.
*/
void BodyArm(const Scene *scene, const Body *body, const PetscReal x[], PetscReal arm[2])
{
  PetscReal normal[ISPH_MAX_DIM];

  (void)NearestImage(scene, body, x, arm, normal);
  for (PetscInt a = 0; a < 2; a++) arm[a] -= body->centre[a];
}

/*
  BodyDistance - Returns the distance from the surface of a body, positive in the fluid [m]

  Not collective. In a periodic box the nearest image of the body is used, but not of a ball
  or of a body that revolves. Output: normal - into the fluid, at the surface point nearest to x.
*/
PetscReal BodyDistance(const Scene *scene, const Body *body, const PetscReal x[],
                       PetscReal normal[])
{
  PetscReal y[2];
  PetscReal distance;

  if (body->revolves || (body->ball && scene->dim == 3)) return BodyRevolved(body, x, normal);
  distance = NearestImage(scene, body, x, y, normal);
  if (!body->around) return distance;
  for (PetscInt a = 0; a < 2; a++) normal[a] = -normal[a];
  return -distance;
}

/* BodyPoints - Returns the number of surface points dx apart; not collective */
PetscInt BodyPoints(const Body *body, PetscReal dx)
{
  return body->shape->Count(body, dx);
}

/*
  BodyPoint - Computes point k of the BodyPoints() points on the surface of a body

  Not collective. Output: x - the point [m]; normal - into the fluid. Returns: the length of surface
  that belongs to the point [m].
*/
PetscReal BodyPoint(const Body *body, PetscInt k, PetscReal dx, PetscReal x[], PetscReal normal[])
{
  PetscReal length;

  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) normal[a] = 0.0;
  length = body->shape->Point(body, k, dx, x, normal);
  for (PetscInt a = 0; body->around && a < 2; a++) normal[a] = -normal[a];
  return length;
}
