/* Ellipses, ellipsoids, capsules, cylinders with ends and cones. Solids have an axis of any
   direction; the points on them are on rings about it. */
#include "curves.h"

static PetscReal Dot(PetscInt dim, const PetscReal u[], const PetscReal v[])
{
  PetscReal sum = 0.0;

  for (PetscInt a = 0; a < dim; a++) sum += u[a] * v[a];
  return sum;
}

/* Returns the signed distance from an ellipse, or ellipsoid, about the origin. */
static PetscReal OvalDistance(PetscInt dim, const PetscReal e[], const PetscReal y[],
                              PetscReal normal[])
{
  PetscReal foot[3], square = 0.0, level = -1.0, length = 0.0;

  EllipseFoot(dim, e, y, foot);
  for (PetscInt a = 0; a < dim; a++) {
    square += PetscSqr(y[a] - foot[a]);
    level += PetscSqr(y[a] / e[a]);
    normal[a] = foot[a] / PetscSqr(e[a]);
    length += PetscSqr(normal[a]);
  }
  for (PetscInt a = 0; a < dim; a++) normal[a] /= PetscSqrtReal(length);
  return level < 0.0 ? -PetscSqrtReal(square) : PetscSqrtReal(square);
}

/* ---- ellipse: cx, cy, a, b[, degrees] ---- */

static const char *EllipsePrepare(Body *body)
{
  const PetscReal *c = body->parameter, w = body->n > 4 ? c[4] * PETSC_PI / 180.0 : 0.0;
  const PetscReal  p[2] = {c[2] * PetscCosReal(w), c[2] * PetscSinReal(w)},
                  q[2]  = {-c[3] * PetscSinReal(w), c[3] * PetscCosReal(w)};
  Border *border;

  if (c[2] <= 0.0 || c[3] <= 0.0) return "the half axes must be positive";
  if (PetscMax(c[2], c[3]) > 1e4 * PetscMin(c[2], c[3]))
    return "an axis is over 10000 times another";
  if (BorderMake(1, body, &border)) return "there is no memory for it";
  border->curve[0] = CurveArc(c, p, q, 0.0, 2.0 * PETSC_PI);
  for (PetscInt a = 0; a < 2; a++) body->centre[a] = c[a];
  body->extent = PetscMax(c[2], c[3]);
  return NULL;
}

static PetscReal EllipseDistance(const Body *body, const PetscReal x[], PetscReal normal[])
{
  const Curve    *c    = ((const Border *)body->data)->curve;
  const PetscReal e[2] = {body->parameter[2], body->parameter[3]},
                  r[2] = {x[0] - c->c[0], x[1] - c->c[1]},
                  y[2] = {Dot(2, r, c->p) / e[0], Dot(2, r, c->q) / e[1]};
  PetscReal       n[2];
  const PetscReal d = OvalDistance(2, e, y, n);

  for (PetscInt a = 0; a < 2; a++) normal[a] = n[0] * c->p[a] / e[0] + n[1] * c->q[a] / e[1];
  return d;
}

/* ---- capsules: two points and the radius ---- */

/* Returns the signed distance from the points less than r from a line from a to b. */
static PetscReal CapsuleFrom(PetscInt dim, const PetscReal a[], const PetscReal b[], PetscReal r,
                             const PetscReal x[], PetscReal normal[])
{
  PetscReal d[3], u[3], s, length;
  PetscInt  least = 0;

  for (PetscInt c = 0; c < dim; c++) {
    d[c] = b[c] - a[c];
    u[c] = x[c] - a[c];
  }
  s = PetscMin(PetscMax(Dot(dim, u, d) / Dot(dim, d, d), 0.0), 1.0);
  for (PetscInt c = 0; c < dim; c++) normal[c] = u[c] - s * d[c];
  length = PetscSqrtReal(Dot(dim, normal, normal));
  for (PetscInt c = 1; c < dim; c++)
    if (PetscAbsReal(d[c]) < PetscAbsReal(d[least])) least = c;
  for (PetscInt c = 0; c < dim && length == 0.0; c++) /* on the line: any normal across it */
    normal[c] = (c == least) - d[least] * d[c] / Dot(dim, d, d);
  s = PetscSqrtReal(Dot(dim, normal, normal));
  for (PetscInt c = 0; c < dim; c++) normal[c] /= s;
  return length - r;
}

/* Sets centre and extent of a body between two points; returns NULL or a fault. */
static const char *SetAxis(PetscInt dim, Body *body)
{
  const PetscReal *a = body->parameter, *b = a + dim;
  PetscReal        length = 0.0;

  for (PetscInt c = 0; c < dim; c++) {
    length += PetscSqr(b[c] - a[c]);
    body->centre[c] = 0.5 * (a[c] + b[c]);
  }
  if (length == 0.0) return "its two points are at one place";
  for (PetscInt k = 2 * dim; k < body->n; k++)
    if (a[k] < 0.0 || (k == 2 * dim && a[k] == 0.0)) return "the radius must be positive";
  return NULL;
}

static const char *CapsulePrepare(Body *body)
{
  const PetscReal *a = body->parameter, *b = a + 2, r = a[4];
  const char      *fault = SetAxis(2, body);
  Border          *border;
  PetscReal        p[2], q[2], ends[4][2], length;

  if (fault) return fault;
  if (BorderMake(4, body, &border)) return "there is no memory for it";
  length = PetscSqrtReal(PetscSqr(b[0] - a[0]) + PetscSqr(b[1] - a[1]));
  for (PetscInt c = 0; c < 2; c++) {
    q[c] = r * (b[c] - a[c]) / length;
    p[c] = (c ? -1.0 : 1.0) * r * (b[1 - c] - a[1 - c]) / length; /* right of the line */
  }
  for (PetscInt c = 0; c < 2; c++) {
    ends[0][c]   = a[c] + p[c];
    ends[1][c]   = b[c] + p[c];
    ends[2][c]   = b[c] - p[c];
    ends[3][c]   = a[c] - p[c];
    body->extent = PetscMax(body->extent, 0.5 * PetscAbsReal(b[c] - a[c]) + r);
  }
  border->curve[0] = CurveLine(ends[0], ends[1]);
  border->curve[1] = CurveArc(b, p, q, 0.0, PETSC_PI);
  border->curve[2] = CurveLine(ends[2], ends[3]);
  border->curve[3] = CurveArc(a, p, q, PETSC_PI, 2.0 * PETSC_PI);
  return NULL;
}

static PetscReal CapsuleDistance(const Body *body, const PetscReal x[], PetscReal normal[])
{
  const PetscReal *a = body->parameter;

  return CapsuleFrom(2, a, a + 2, a[4], x, normal);
}

/* ---- solids with an axis ---- */

/* Sets unit vectors, the last of them from the first point of a body to the second. */
static void SetFrame(const Body *body, Solid *solid)
{
  PetscReal *e     = solid->axis[2], length;
  PetscInt   least = 0;

  for (PetscInt c = 0; c < 3; c++) {
    solid->origin[c] = body->parameter[c];
    e[c]             = body->parameter[3 + c] - body->parameter[c];
  }
  length = PetscSqrtReal(Dot(3, e, e));
  for (PetscInt c = 0; c < 3; c++) e[c] /= length;
  for (PetscInt c = 1; c < 3; c++)
    if (PetscAbsReal(e[c]) < PetscAbsReal(e[least])) least = c;
  for (PetscInt c = 0; c < 3; c++) solid->axis[0][c] = (c == least) - e[least] * e[c];
  length = PetscSqrtReal(Dot(3, solid->axis[0], solid->axis[0]));
  for (PetscInt c = 0; c < 3; c++) solid->axis[0][c] /= length;
  for (PetscInt c = 0; c < 3; c++) {
    const PetscInt i = (c + 1) % 3, j = (c + 2) % 3;

    solid->axis[1][c] = e[i] * solid->axis[0][j] - e[j] * solid->axis[0][i];
  }
}

/* Adds the points of rings about the axis. */
static void FillRings(const Body *body, SurfacePoints *points)
{
  const Solid *solid = (const Solid *)body->data;

  for (PetscInt k = 0; k < solid->n; k++) {
    const Curve   *c     = &solid->meridian[k];
    const PetscInt rings = ShapeLineCount(c->length, points->dx, 1);

    for (PetscInt j = 0; j < rings; j++) {
      PetscReal y[2], t[2], low[2], high[2], speed, band;
      PetscInt  n;

      CurveAt(c, (j + 0.5 - 0.5 / PetscSqrtReal(3.0)) / rings, low, t);
      CurveAt(c, (j + 0.5 + 0.5 / PetscSqrtReal(3.0)) / rings, high, t);
      CurveAt(c, (j + 0.5) / rings, y, t);
      speed = PetscSqrtReal(Dot(2, t, t));
      n     = ShapeRingCount(y[0], points->dx);
      band  = PETSC_PI * (low[0] + high[0]) * c->length / rings / n;
      for (PetscInt l = 0; l < n; l++) {
        const PetscReal w    = 2.0 * PETSC_PI * (l + 0.5) / n,
                        u[2] = {PetscCosReal(w), PetscSinReal(w)};
        PetscReal x[3], normal[3];

        for (PetscInt a = 0; a < 3; a++) {
          const PetscReal out = u[0] * solid->axis[0][a] + u[1] * solid->axis[1][a];

          x[a]      = solid->origin[a] + y[0] * out + y[1] * solid->axis[2][a];
          normal[a] = (t[1] * out - t[0] * solid->axis[2][a]) / speed;
        }
        SolidAdd(x, normal, band, points);
      }
    }
  }
}

/* Computes the least and largest coordinate of circles about the axis, of a capsule at the ends of
   its line. */
static void RingsSpan(const Body *body, PetscInt axis, PetscReal span[2])
{
  const Solid    *solid = (const Solid *)body->data;
  const PetscReal e     = solid->axis[2][axis];
  const PetscBool ball  = solid->meridian[0].from != solid->meridian[0].to;

  span[0] = PETSC_INFINITY;
  span[1] = -PETSC_INFINITY;
  for (PetscInt end = 0; end < 2; end++) {
    const PetscReal r   = body->parameter[body->n > 7 ? 6 + end : 6];
    const PetscReal far = ball ? r : r * PetscSqrtReal(PetscMax(0.0, 1.0 - e * e));

    span[0] = PetscMin(span[0], body->parameter[3 * end + axis] - far);
    span[1] = PetscMax(span[1], body->parameter[3 * end + axis] + far);
  }
}

static void SetExtent(Body *body)
{
  for (PetscInt a = 0; a < 3; a++) {
    PetscReal span[2];

    RingsSpan(body, a, span);
    body->extent =
        PetscMax(body->extent, PetscMax(span[1] - body->centre[a], body->centre[a] - span[0]));
  }
}

static const char *RoundedPrepare(Body *body)
{
  const PetscReal r     = body->parameter[6];
  const char     *fault = SetAxis(3, body);
  Solid          *solid;
  PetscReal       p[2] = {r, 0.0}, q[2] = {0.0, r}, low[2] = {0.0, 0.0}, high[2], from[2], to[2];

  if (!fault) fault = SolidCreate(FillRings, body);
  if (fault) return fault;
  solid = (Solid *)body->data;
  SetFrame(body, solid);
  high[0] = 0.0;
  high[1] = 0.0;
  for (PetscInt a = 0; a < 3; a++)
    high[1] += (body->parameter[3 + a] - body->parameter[a]) * solid->axis[2][a];
  from[0] = to[0]    = r;
  from[1]            = 0.0;
  to[1]              = high[1];
  solid->n           = 3;
  solid->meridian[0] = CurveArc(low, p, q, -0.5 * PETSC_PI, 0.0);
  solid->meridian[1] = CurveLine(from, to);
  solid->meridian[2] = CurveArc(high, p, q, 0.0, 0.5 * PETSC_PI);
  SetExtent(body);
  return NULL;
}

static PetscReal RoundedDistance(const Body *body, const PetscReal x[], PetscReal normal[])
{
  const PetscReal *a = body->parameter;

  return CapsuleFrom(3, a, a + 3, a[6], x, normal);
}

static const char *ConePrepare(Body *body)
{
  const char *fault = SetAxis(3, body);
  Solid      *solid;
  PetscReal   corner[4][2] = {{0.0}}, r[2], height = 0.0, volume;

  if (!fault) fault = SolidCreate(FillRings, body);
  if (fault) return fault;
  solid = (Solid *)body->data;
  SetFrame(body, solid);
  for (PetscInt a = 0; a < 3; a++)
    height += (body->parameter[3 + a] - body->parameter[a]) * solid->axis[2][a];
  for (PetscInt end = 0; end < 2; end++) r[end] = body->parameter[body->n > 7 ? 6 + end : 6];
  corner[1][0] = r[0];
  corner[2][0] = r[1];
  corner[2][1] = corner[3][1] = height;
  for (PetscInt k = 0; k < 3; k++)
    if (k < 2 || r[1] > 0.0) solid->meridian[solid->n++] = CurveLine(corner[k], corner[k + 1]);
  volume = 4.0 * (r[0] * r[0] + r[0] * r[1] + r[1] * r[1]);
  for (PetscInt a = 0; a < 3; a++)
    body->centre[a] = solid->origin[a] + solid->axis[2][a] * height *
                                             (r[0] * r[0] + 2.0 * r[0] * r[1] + 3.0 * r[1] * r[1]) /
                                             volume;
  SetExtent(body);
  return NULL;
}

/* Returns the distance from the meridian, at the distance from the axis and the height of x. */
static PetscReal ConeDistance(const Body *body, const PetscReal x[], PetscReal normal[])
{
  const Solid *solid = (const Solid *)body->data;
  const Curve *side = &solid->meridian[1], *on = side;
  PetscReal    y[2], u[3], foot[2], t[2], n[2], best = PETSC_INFINITY, nearest = 0.0, d;
  PetscBool    inside;

  for (PetscInt a = 0; a < 3; a++) u[a] = x[a] - solid->origin[a];
  y[1] = Dot(3, u, solid->axis[2]);
  for (PetscInt a = 0; a < 3; a++) u[a] -= y[1] * solid->axis[2][a];
  y[0]   = PetscSqrtReal(Dot(3, u, u));
  inside = y[1] > 0.0 && y[1] < side->b[1] &&
           y[0] < side->a[0] + (side->b[0] - side->a[0]) * y[1] / side->b[1];
  for (PetscInt k = 0; k < solid->n; k++) {
    PetscReal       s;
    const PetscReal square = CurveNearest(&solid->meridian[k], y, best, &s);

    if (square >= best) continue;
    best    = square;
    on      = &solid->meridian[k];
    nearest = s;
  }
  CurveAt(on, nearest, foot, t);
  d = inside ? -PetscSqrtReal(best) : PetscSqrtReal(best);
  for (PetscInt a = 0; a < 2; a++)
    n[a] = PetscAbsReal(d) > 1e-9 * body->extent ? (y[a] - foot[a]) / d
                                                 : (a ? -t[0] : t[1]) / PetscSqrtReal(Dot(2, t, t));
  for (PetscInt a = 0; a < 3; a++)
    normal[a] = n[0] * (y[0] > 0.0 ? u[a] / y[0] : solid->axis[0][a]) + n[1] * solid->axis[2][a];
  return d;
}

/* ---- ellipsoid: cx, cy, cz, a, b, c ---- */

/* Returns the angle at a share of the length of a meridian from pole to pole. */
static PetscReal Latitude(const Curve *meridian, PetscReal share)
{
  return PETSC_PI * (CurvePlace(meridian, share) - 0.5);
}

/* Adds the points of rings in planes across the half axis whose others are most alike. */
static void FillOval(const Body *body, SurfacePoints *points)
{
  const PetscReal *e = body->parameter + 3, none[2] = {0.0, 0.0};
  PetscReal        best = PETSC_INFINITY;
  PetscInt         m    = 2, i, j, rings;
  Curve            meridian;

  for (PetscInt a = 0; a < 3; a++) {
    const PetscReal unlike = PetscAbsReal(PetscLogReal(e[(a + 1) % 3] / e[(a + 2) % 3]));

    if (unlike > best) continue;
    best = unlike;
    m    = a;
  }
  i        = (m + 1) % 3;
  j        = (m + 2) % 3;
  meridian = CurveArc(none, (PetscReal[]){PetscSqrtReal(e[i] * e[j]), 0.0},
                      (PetscReal[]){0.0, e[m]}, -0.5 * PETSC_PI, 0.5 * PETSC_PI);
  rings    = ShapeLineCount(meridian.length, points->dx, 1);
  for (PetscInt k = 0; k < rings; k++) {
    const PetscReal w    = Latitude(&meridian, (k + 0.5) / rings),
                    low  = Latitude(&meridian, (PetscReal)k / rings),
                    high = Latitude(&meridian, (k + 1.0) / rings), inward = PetscCosReal(w);
    const Curve    ring = CurveArc(none, (PetscReal[]){e[i] * inward, 0.0},
                                   (PetscReal[]){0.0, e[j] * inward}, 0.0, 2.0 * PETSC_PI);
    const PetscInt n    = 4 * ShapeLineCount(0.25 * ring.length, points->dx, 1);

    for (PetscInt l = 0; l < n; l++) {
      const PetscReal f    = 2.0 * PETSC_PI * CurvePlace(&ring, (l + 0.5) / n);
      const PetscReal q[3] = {inward * PetscCosReal(f), inward * PetscSinReal(f), PetscSinReal(w)};
      PetscReal       x[3], normal[3], length = 0.0, y[2], t[2];

      for (PetscInt a = 0; a < 3; a++) {
        const PetscInt b = (i + a) % 3;

        x[b]      = body->centre[b] + e[b] * q[a];
        normal[b] = q[a] / e[b];
        length += PetscSqr(normal[b]);
      }
      length = PetscSqrtReal(length);
      for (PetscInt a = 0; a < 3; a++) normal[a] /= length;
      CurveAt(&ring, CurvePlace(&ring, (l + 0.5) / n), y, t);
      /* |X_w x X_f| = abc cos(w) |(q_i/e_i)|; cos(w) dw over the band, df = length/(n |X_f|) */
      SolidAdd(x, normal,
               e[0] * e[1] * e[2] * length * (PetscSinReal(high) - PetscSinReal(low)) * 2.0 *
                   PETSC_PI * ring.length / n / PetscSqrtReal(Dot(2, t, t)),
               points);
    }
  }
}

static const char *OvalPrepare(Body *body)
{
  const PetscReal *e = body->parameter + 3;

  for (PetscInt a = 0; a < 3; a++) {
    if (e[a] <= 0.0) return "the half axes must be positive";
    body->centre[a] = body->parameter[a];
    body->extent    = PetscMax(body->extent, e[a]);
  }
  for (PetscInt a = 0; a < 3; a++)
    if (body->extent > 1e4 * e[a]) return "an axis is over 10000 times another";
  return SolidCreate(FillOval, body);
}

static void OvalSpan(const Body *body, PetscInt axis, PetscReal span[2])
{
  span[0] = body->centre[axis] - body->parameter[3 + axis];
  span[1] = body->centre[axis] + body->parameter[3 + axis];
}

static PetscReal EllipsoidDistance(const Body *body, const PetscReal x[], PetscReal normal[])
{
  PetscReal y[3];

  for (PetscInt a = 0; a < 3; a++) y[a] = x[a] - body->centre[a];
  return OvalDistance(3, body->parameter + 3, y, normal);
}

const ShapeRow ShapeEllipse = {.name     = "ellipse",
                               .brief    = "cx,cy,a,b[,degrees]: half axes a along x and b, turned",
                               .plane    = PETSC_TRUE,
                               .fewest   = 4,
                               .most     = 5,
                               .Prepare  = EllipsePrepare,
                               .Span     = BorderSpan,
                               .Distance = EllipseDistance,
                               .Count    = BorderCount,
                               .Point    = BorderPoint};

const ShapeRow ShapeCapsule = {.name     = "capsule",
                               .brief    = "x0,y0,x1,y1,r: all within r of a straight line",
                               .plane    = PETSC_TRUE,
                               .fewest   = 5,
                               .most     = 5,
                               .Prepare  = CapsulePrepare,
                               .Span     = BorderSpan,
                               .Distance = CapsuleDistance,
                               .Count    = BorderCount,
                               .Point    = BorderPoint};

const ShapeRow ShapeEllipsoid = {.name     = "ellipsoid",
                                 .brief    = "cx,cy,cz,a,b,c: half axes a, b, c along x, y, z",
                                 .fewest   = 6,
                                 .most     = 6,
                                 .Prepare  = OvalPrepare,
                                 .Span     = OvalSpan,
                                 .Distance = EllipsoidDistance,
                                 .Count    = SolidCount,
                                 .Point    = SolidPoint};

const ShapeRow ShapeRounded = {.name     = "capsule",
                               .brief    = "x0,y0,z0,x1,y1,z1,r: all within r of a straight line",
                               .fewest   = 7,
                               .most     = 7,
                               .Prepare  = RoundedPrepare,
                               .Span     = RingsSpan,
                               .Distance = RoundedDistance,
                               .Count    = SolidCount,
                               .Point    = SolidPoint};

const ShapeRow ShapeCone = {
    .name     = "cone",
    .brief    = "x0,y0,z0,x1,y1,z1,r0[,r1]: radius r0 at the first point, r1 (r0) at the second",
    .fewest   = 7,
    .most     = 8,
    .Prepare  = ConePrepare,
    .Span     = RingsSpan,
    .Distance = ConeDistance,
    .Count    = SolidCount,
    .Point    = SolidPoint,
};
