/* Shapes of bodies in space, defined as the shapes in the plane: by a signed distance and by points
   on the surface, each of which represents an area of about dx^2. A prism along z has an outline,
   which is a shape in the plane; it reaches through the whole box, but for a box, which has
   ends. */
#include "shapes.h"

/* Returns a product of numbers of points as a PetscInt; one that is too large for any run stays too
   large. */
static PetscInt Product(PetscReal n, PetscReal m)
{
  return (PetscInt)PetscMin(n * m, (PetscReal)(PETSC_INT_MAX / 4));
}

/* ---- prisms along z: the numbers of the outline ---- */

static const char *PrismPrepare(Body *body)
{
  if (body->shape == &ShapeCylinder && body->n > 3) {
    body->shape = &ShapeCone;
    return body->n == 7 ? ShapeCone.Prepare(body) : "a cylinder has 3 numbers, or 7 with ends";
  }
  return body->shape->outline->Prepare(body);
}

/* PrismSpan - Computes BodySpan() of a prism along z */
void PrismSpan(const Body *body, PetscInt axis, PetscReal span[2])
{
  if (axis < 2) body->shape->outline->Span(body, axis, span);
  for (PetscInt end = 0; end < 2 && axis == 2; end++) span[end] = body->ends[end];
}

/* PrismDistance - Computes the distance from a prism that has no ends */
PetscReal PrismDistance(const Body *body, const PetscReal x[], PetscReal normal[])
{
  normal[2] = 0.0;
  return body->shape->outline->Distance(body, x, normal);
}

static PetscInt PrismLayers(const Body *body, PetscReal dx)
{
  return ShapeLineCount(body->ends[1] - body->ends[0], dx, 1);
}

/* PrismCount - Returns the number of points on a prism without its ends */
PetscInt PrismCount(const Body *body, PetscReal dx)
{
  return Product(body->shape->outline->Count(body, dx), PrismLayers(body, dx));
}

/* PrismPoint - Computes point k on a prism without its ends */
PetscReal PrismPoint(const Body *body, PetscInt k, PetscReal dx, PetscReal x[], PetscReal normal[])
{
  const PetscInt  n      = body->shape->outline->Count(body, dx);
  const PetscReal height = (body->ends[1] - body->ends[0]) / PrismLayers(body, dx);

  normal[2] = 0.0;
  x[2]      = body->ends[0] + (k / n + 0.5) * height;
  return height * body->shape->outline->Point(body, k % n, dx, x, normal);
}

/* ---- box: two opposite corners; a prism with ends ---- */

static const char *BoxPrepare(Body *body)
{
  PetscReal      *c      = body->parameter;
  const PetscReal z[2]   = {c[2], c[5]};
  const PetscReal box[4] = {c[0], c[1], c[3], c[4]};
  const char     *fault;

  if (z[0] == z[1]) return "the box has no depth along z";
  for (PetscInt k = 0; k < 4; k++) c[k] = box[k];
  fault           = ShapeBoxPrepare(body);
  body->ends[0]   = PetscMin(z[0], z[1]);
  body->ends[1]   = PetscMax(z[0], z[1]);
  body->centre[2] = 0.5 * (z[0] + z[1]);
  body->extent    = PetscMax(body->extent, 0.5 * (body->ends[1] - body->ends[0]));
  return fault;
}

static PetscReal BoxDistance(const Body *body, const PetscReal x[], PetscReal normal[])
{
  const PetscReal outline = PrismDistance(body, x, normal);
  const PetscReal high = x[2] - body->ends[1], low = body->ends[0] - x[2],
                  end   = PetscMax(high, low);
  const PetscReal along = high >= low ? 1.0 : -1.0,
                  r     = PetscSqrtReal(outline * outline + end * end);

  if (outline > 0.0 && end > 0.0) {
    for (PetscInt a = 0; a < 2; a++) normal[a] *= outline / r;
    normal[2] = along * end / r;
    return r;
  }
  if (end <= outline) return outline;
  normal[0] = normal[1] = 0.0;
  normal[2]             = along;
  return end;
}

/* Returns the numbers of points along both edges of an end of a box. */
static PetscInt EndCount(const Body *body, PetscReal dx, PetscInt n[2])
{
  for (PetscInt a = 0; a < 2; a++) {
    PetscReal span[2];

    PrismSpan(body, a, span);
    n[a] = ShapeLineCount(span[1] - span[0], dx, 1);
  }
  return Product(n[0], n[1]);
}

static PetscInt BoxCount(const Body *body, PetscReal dx)
{
  PetscInt n[2];

  return Product(1.0, (PetscReal)PrismCount(body, dx) + 2.0 * EndCount(body, dx, n));
}

static PetscReal BoxPoint(const Body *body, PetscInt k, PetscReal dx, PetscReal x[],
                          PetscReal normal[])
{
  const PetscInt around = PrismCount(body, dx);
  PetscInt       n[2], end;
  PetscReal      area = 1.0;

  if (k < around) return PrismPoint(body, k, dx, x, normal);
  k -= around;
  end = k / EndCount(body, dx, n);
  for (PetscInt a = 0; a < 2; a++) {
    const PetscInt index = a == 0 ? k % n[0] : k / n[0] % n[1];
    PetscReal      span[2];

    PrismSpan(body, a, span);
    x[a]      = span[0] + (index + 0.5) * (span[1] - span[0]) / n[a];
    normal[a] = 0.0;
    area *= (span[1] - span[0]) / n[a];
  }
  x[2]      = body->ends[end];
  normal[2] = end ? 1.0 : -1.0;
  return area;
}

/* ---- ball: cx, cy, cz, r ---- */

static const char *BallPrepare(Body *body)
{
  for (PetscInt a = 0; a < 3; a++) body->centre[a] = body->parameter[a];
  body->extent = body->parameter[3];
  return body->extent > 0.0 ? NULL : "the radius must be positive";
}

static void BallSpan(const Body *body, PetscInt axis, PetscReal span[2])
{
  span[0] = body->centre[axis] - body->extent;
  span[1] = body->centre[axis] + body->extent;
}

static PetscReal BallDistance(const Body *body, const PetscReal x[], PetscReal normal[])
{
  PetscReal r = 0.0;

  for (PetscInt a = 0; a < 3; a++) {
    normal[a] = x[a] - body->centre[a];
    r += PetscSqr(normal[a]);
  }
  r = PetscSqrtReal(r);
  for (PetscInt a = 0; a < 3; a++) normal[a] = r > 0.0 ? normal[a] / r : a == 0;
  return r - body->extent;
}

static PetscInt BallCount(const Body *body, PetscReal dx)
{
  return PetscMax(8, Product(4.0 * PETSC_PI, PetscSqr(body->extent / dx) + 0.5 / (4.0 * PETSC_PI)));
}

/* The points are on a spiral, a golden section of a turn and the height 2 R/N apart: R. Swinbank,
   R. J. Purser, Q. J. R. Meteorol. Soc. 132 (2006) 1769-1793. */
static PetscReal BallPoint(const Body *body, PetscInt k, PetscReal dx, PetscReal x[],
                           PetscReal normal[])
{
  const PetscReal turn = PETSC_PI * (3.0 - PetscSqrtReal(5.0));
  const PetscInt  N    = BallCount(body, dx);

  normal[2] = 1.0 - (2.0 * k + 1.0) / N;
  normal[0] = PetscSqrtReal(1.0 - PetscSqr(normal[2])) * PetscCosReal(k * turn);
  normal[1] = PetscSqrtReal(1.0 - PetscSqr(normal[2])) * PetscSinReal(k * turn);
  for (PetscInt a = 0; a < 3; a++) x[a] = body->centre[a] + body->extent * normal[a];
  return 4.0 * PETSC_PI * PetscSqr(body->extent) / N;
}

/* ---- revolved: a polygon in the plane of the distance r from the axis z and of z ---- */

/* Adds the mirror image of a meridian that has a side on the axis, which is no surface: this side
   lies then inside the polygon. Returns NULL or a fault. */
static const char *MirrorMeridian(Body *body)
{
  PetscReal     *c = body->parameter, *turned = c + body->n; /* room for the mirror image */
  const PetscInt corners = body->n / 2;
  PetscInt       first = -1, on_axis = 0;

  for (PetscInt e = 0; e < corners; e++) {
    if (c[2 * e] < 0.0) return "r is a distance from the axis, 0 or more";
    if (c[2 * e] > 0.0) continue;
    on_axis++;
    if (c[2 * ((e + corners - 1) % corners)] == 0.0) first = e;
  }
  if (on_axis > 2) return "at most two of its corners are on the axis";
  if (first < 0) return NULL;
  for (PetscInt k = 0; k < body->n; k++) turned[k] = c[(2 * first + k) % body->n];
  (void)PetscArraycpy(c, turned, body->n);
  for (PetscInt e = corners - 2; e >= 1; e--) {
    c[body->n++] = -c[2 * e];
    c[body->n++] = c[2 * e + 1];
  }
  return NULL;
}

static const char *RevolvedPrepare(Body *body)
{
  const char *fault = body->n % 2 ? NULL : MirrorMeridian(body);
  PetscReal   span[2];

  if (!fault) fault = ShapePolygon.Prepare(body);
  if (fault) return fault;
  ShapePolygon.Span(body, 1, span);
  body->centre[0] = body->centre[1] = body->extent = 0.0;
  body->centre[2]                                  = 0.5 * (span[0] + span[1]);
  for (PetscInt k = 0; k < body->n; k += 2) {
    const PetscReal r = body->parameter[k], z = body->parameter[k + 1] - body->centre[2];

    body->extent = PetscMax(body->extent, PetscSqrtReal(r * r + z * z));
  }
  return NULL;
}

static void RevolvedSpan(const Body *body, PetscInt axis, PetscReal span[2])
{
  ShapePolygon.Span(body, axis / 2, span);
  if (axis < 2) span[0] = -span[1];
}

static PetscReal RevolvedDistance(const Body *body, const PetscReal x[], PetscReal normal[])
{
  const PetscReal r    = PetscSqrtReal(PetscSqr(x[0]) + PetscSqr(x[1]));
  const PetscReal y[2] = {r, x[2]};
  PetscReal       n[2];
  const PetscReal distance = ShapePolygon.Distance(body, y, n);

  normal[0] = r > 0.0 ? n[0] * x[0] / r : n[0];
  normal[1] = r > 0.0 ? n[0] * x[1] / r : 0.0;
  normal[2] = n[1];
  return distance;
}

/* A ring of points about the axis: its middle, the outward normal, and its area for each point. */
typedef struct {
  PetscReal r, z, normal[2], area;
  PetscInt  n;
} Ring;

/* Finds the ring of point k among those of all sides of the meridian that are not mirror images;
   returns the number of points on the rings before it, or of all points if they are k or fewer. */
static PetscInt FindRing(const Body *body, PetscInt k, PetscReal dx, Ring *ring)
{
  const PetscInt corners = body->n / 2;
  PetscInt       first   = 0;

  for (PetscInt e = 0; e < corners && first <= k; e++) {
    const PetscReal *a = &body->parameter[2 * e], *b = &body->parameter[2 * ((e + 1) % corners)];
    const PetscReal  dr = b[0] - a[0], dz = b[1] - a[1], side = PetscSqrtReal(dr * dr + dz * dz);
    const PetscInt   rings = ShapeLineCount(side, dx, 1);

    for (PetscInt j = 0; j < rings && a[0] + b[0] > 0.0 && first <= k; j++) {
      const PetscReal s = (j + 0.5) / rings, r = a[0] + s * dr;
      const PetscInt  n = ShapeRingCount(r, dx);

      if (k - first < n) {
        *ring      = (Ring){r, a[1] + s * dz, {dz / side, -dr / side}, 0.0, n};
        ring->area = 2.0 * PETSC_PI * r * side / rings / n;
        return first;
      }
      first = Product(1.0, (PetscReal)first + n);
    }
  }
  return first;
}

static PetscInt RevolvedCount(const Body *body, PetscReal dx)
{
  Ring none;

  return FindRing(body, PETSC_INT_MAX / 4, dx, &none);
}

static PetscReal RevolvedPoint(const Body *body, PetscInt k, PetscReal dx, PetscReal x[],
                               PetscReal normal[])
{
  Ring            ring     = {.n = 1};
  const PetscInt  first    = FindRing(body, k, dx, &ring);
  const PetscReal angle    = 2.0 * PETSC_PI * (k - first + 0.5) / ring.n;
  const PetscReal along[2] = {PetscCosReal(angle), PetscSinReal(angle)};

  for (PetscInt a = 0; a < 2; a++) {
    x[a]      = ring.r * along[a];
    normal[a] = ring.normal[0] * along[a];
  }
  x[2]      = ring.z;
  normal[2] = ring.normal[1];
  return ring.area;
}

const ShapeRow ShapeRevolved = {
    .name     = "revolved",
    .brief    = "r0,z0,r1,z1,...: a turn about the axis z of 3 or more corners in order, r >= 0",
    .fewest   = 6,
    .round    = PETSC_TRUE,
    .outline  = &ShapePolygon,
    .revolves = PETSC_TRUE,
    .Prepare  = RevolvedPrepare,
    .Span     = RevolvedSpan,
    .Distance = RevolvedDistance,
    .Count    = RevolvedCount,
    .Point    = RevolvedPoint,
};

const ShapeRow ShapeBall = {.name     = "ball",
                            .brief    = "cx,cy,cz,r",
                            .fewest   = 4,
                            .most     = 4,
                            .round    = PETSC_TRUE,
                            .Prepare  = BallPrepare,
                            .Span     = BallSpan,
                            .Distance = BallDistance,
                            .Count    = BallCount,
                            .Point    = BallPoint};

const ShapeRow ShapeCuboid = {.name     = "box",
                              .brief    = "x0,y0,z0,x1,y1,z1: two opposite corners",
                              .fewest   = 6,
                              .most     = 6,
                              .outline  = &ShapePolygon,
                              .ends     = PETSC_TRUE,
                              .Prepare  = BoxPrepare,
                              .Span     = PrismSpan,
                              .Distance = BoxDistance,
                              .Count    = BoxCount,
                              .Point    = BoxPoint};

const ShapeRow ShapeCylinder = {
    .name     = "cylinder",
    .brief    = "cx,cy,r: along z through the box; or x0,y0,z0,x1,y1,z1,r: between two points",
    .fewest   = 3,
    .most     = 7,
    .round    = PETSC_TRUE,
    .outline  = &ShapeCircle,
    .Prepare  = PrismPrepare,
    .Span     = PrismSpan,
    .Distance = PrismDistance,
    .Count    = PrismCount,
    .Point    = PrismPoint,
};

const ShapeRow ShapePrism = {
    .name     = "prism",
    .brief    = "x0,y0,x1,y1,...: 3 or more corners in order; along z through the box",
    .fewest   = 6,
    .outline  = &ShapePolygon,
    .Prepare  = PrismPrepare,
    .Span     = PrismSpan,
    .Distance = PrismDistance,
    .Count    = PrismCount,
    .Point    = PrismPoint,
};
