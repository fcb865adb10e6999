/*
  Shapes of bodies in space, defined as the shapes in the plane: by a signed distance and by points
  on the surface, each of which represents an area of about dx^2. A prism along z has an outline,
  which is a shape in the plane; it reaches through the whole box, but for a box, which has ends.
*/
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
  return body->shape->outline->Prepare(body);
}

static void PrismSpan(const Body *body, PetscInt axis, PetscReal span[2])
{
  if (axis < 2) body->shape->outline->Span(body, axis, span);
  for (PetscInt end = 0; end < 2 && axis == 2; end++) span[end] = body->ends[end];
}

static PetscReal PrismDistance(const Body *body, const PetscReal x[], PetscReal normal[])
{
  normal[2] = 0.0;
  return body->shape->outline->Distance(body, x, normal);
}

static PetscInt PrismLayers(const Body *body, PetscReal dx)
{
  return ShapeLineCount(body->ends[1] - body->ends[0], dx, 1);
}

static PetscInt PrismCount(const Body *body, PetscReal dx)
{
  return Product(body->shape->outline->Count(body, dx), PrismLayers(body, dx));
}

static PetscReal PrismPoint(const Body *body, PetscInt k, PetscReal dx, PetscReal x[],
                            PetscReal normal[])
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

/* ---- revolved: a polygon in the plane of the distance from the axis z and of z ---- */

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

const ShapeRow ShapeRevolved = {
    .name     = "revolved",
    .brief    = "r0,z0,r1,z1,...: 3 to 32 corners in order",
    .citation = "",
    .fewest   = 6,
    .most     = BODY_PARAMETERS,
    .outline  = &ShapePolygon,
    .revolves = PETSC_TRUE,
    .Prepare  = PrismPrepare,
    .Span     = RevolvedSpan,
    .Distance = RevolvedDistance,
};

const ShapeRow ShapeBall = {
    .name     = "ball",
    .brief    = "cx,cy,cz,r",
    .citation = "",
    .fewest   = 4,
    .most     = 4,
    .round    = PETSC_TRUE,
    .Prepare  = BallPrepare,
    .Span     = BallSpan,
    .Distance = BallDistance,
    .Count    = BallCount,
    .Point    = BallPoint,
};

static const ShapeRow box = {
    .name     = "box",
    .brief    = "x0,y0,z0,x1,y1,z1: two opposite corners",
    .citation = "",
    .fewest   = 6,
    .most     = 6,
    .outline  = &ShapePolygon,
    .ends     = PETSC_TRUE,
    .Prepare  = BoxPrepare,
    .Span     = PrismSpan,
    .Distance = BoxDistance,
    .Count    = BoxCount,
    .Point    = BoxPoint,
};

const ShapeRow ShapeCylinder = {
    .name     = "cylinder",
    .brief    = "cx,cy,r: along z through the box",
    .citation = "",
    .fewest   = 3,
    .most     = 3,
    .round    = PETSC_TRUE,
    .outline  = &ShapeCircle,
    .Prepare  = PrismPrepare,
    .Span     = PrismSpan,
    .Distance = PrismDistance,
    .Count    = PrismCount,
    .Point    = PrismPoint,
};

static const ShapeRow prism = {
    .name     = "prism",
    .brief    = "x0,y0,x1,y1,...: 3 to 32 corners in order; along z through the box",
    .citation = "",
    .fewest   = 6,
    .most     = BODY_PARAMETERS,
    .outline  = &ShapePolygon,
    .Prepare  = PrismPrepare,
    .Span     = PrismSpan,
    .Distance = PrismDistance,
    .Count    = PrismCount,
    .Point    = PrismPoint,
};

static const ShapeRow *const solids[] = {&ShapeBall, &box, &ShapeCylinder, &prism};
const Table SolidTable = TABLE_OF_POINTERS("Shapes of bodies and fluids in 3D", solids);
