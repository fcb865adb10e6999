/* Borders of shapes in the plane: closed loops of straight lines and arcs of ellipses. Distances,
   points dx apart, and boxes around them follow from the curves alone, so that a new shape lists
   its curves. */
#include "curves.h"

#define TRIES 48 /* angles of a whole ellipse between which nearest points are sought */
#define ROUND 1e-12

static PetscReal Dot(const PetscReal u[2], const PetscReal v[2])
{
  return u[0] * v[0] + u[1] * v[1];
}

/* Returns true if equal parts of s have equal lengths: on lines and on arcs of circles. */
static PetscBool IsEven(const Curve *c)
{
  const PetscReal p = Dot(c->p, c->p), q = Dot(c->q, c->q);

  return c->from == c->to || PetscAbsReal(p - q) < ROUND * (p + q);
}

/* CurveAt - Computes the point at s, from 0 to 1 along a curve, and the derivative by s */
void CurveAt(const Curve *c, PetscReal s, PetscReal x[2], PetscReal tangent[2])
{
  const PetscReal turn = c->to - c->from, w = c->from + s * turn;

  for (PetscInt a = 0; a < 2; a++) {
    if (turn == 0.0) {
      x[a]       = (1.0 - s) * c->a[a] + s * c->b[a];
      tangent[a] = c->b[a] - c->a[a];
    } else {
      x[a]       = c->c[a] + c->p[a] * PetscCosReal(w) + c->q[a] * PetscSinReal(w);
      tangent[a] = turn * (c->q[a] * PetscCosReal(w) - c->p[a] * PetscSinReal(w));
    }
  }
}

/* Returns the length of a curve from a node to s behind it, by Gauss' rule of three points. */
static PetscReal LengthFrom(const Curve *c, PetscInt node, PetscReal s)
{
  static const PetscReal rule[3][2] = {
      {0.1127016653792583, 5.0 / 18.0}, {0.5, 8.0 / 18.0}, {0.8872983346207417, 5.0 / 18.0}};
  const PetscReal from = (PetscReal)node / CURVE_NODES;
  PetscReal       sum  = 0.0, x[2], t[2];

  for (PetscInt k = 0; k < 3; k++) {
    CurveAt(c, from + rule[k][0] * (s - from), x, t);
    sum += rule[k][1] * (s - from) * PetscSqrtReal(Dot(t, t));
  }
  return sum;
}

/* CurvePlace - Returns s at a share of the length of a curve */
PetscReal CurvePlace(const Curve *c, PetscReal share)
{
  PetscReal low, high, s;
  PetscInt  node = 0;

  if (IsEven(c)) return share;
  while (node + 1 < CURVE_NODES && c->length_to[node + 1] < share * c->length) node++;
  low  = (PetscReal)node / CURVE_NODES;
  high = (node + 1.0) / CURVE_NODES;
  s    = 0.5 * (low + high);
  for (PetscInt k = 0; k < 60; k++) {
    const PetscReal beyond = c->length_to[node] + LengthFrom(c, node, s) - share * c->length;
    PetscReal       x[2], t[2], next;

    if (beyond > 0.0) high = s;
    else low = s;
    CurveAt(c, s, x, t);
    next = s - beyond / PetscSqrtReal(Dot(t, t));
    if (next <= low || next >= high) next = 0.5 * (low + high);
    if (PetscAbsReal(next - s) < ROUND) break;
    s = next;
  }
  return s;
}

/* Sets the length of a curve and its middle. */
static void Measure(Curve *c)
{
  PetscReal t[2];

  for (PetscInt k = 0; k < CURVE_NODES && !IsEven(c); k++)
    c->length_to[k + 1] = c->length_to[k] + LengthFrom(c, k, (k + 1.0) / CURVE_NODES);
  c->length =
      IsEven(c) ? CURVE_NODES * LengthFrom(c, 0, 1.0 / CURVE_NODES) : c->length_to[CURVE_NODES];
  CurveAt(c, CurvePlace(c, 0.5), c->middle, t);
}

/* CurveLine - Returns a straight line */
Curve CurveLine(const PetscReal a[2], const PetscReal b[2])
{
  Curve c = {.a = {a[0], a[1]}, .b = {b[0], b[1]}};

  Measure(&c);
  return c;
}

/* CurveArc - Returns an arc of an ellipse */
Curve CurveArc(const PetscReal centre[2], const PetscReal p[2], const PetscReal q[2],
               PetscReal from, PetscReal to)
{
  Curve c = {
      .c = {centre[0], centre[1]}, .p = {p[0], p[1]}, .q = {q[0], q[1]}, .from = from, .to = to};
  PetscReal t[2];

  CurveAt(&c, 0.0, c.a, t);
  CurveAt(&c, 1.0, c.b, t);
  Measure(&c);
  return c;
}

/* CurvePart - Returns the part of a curve from one s to another, turned if `to` is less */
Curve CurvePart(const Curve *c, PetscReal from, PetscReal to)
{
  const PetscReal turn = c->to - c->from;
  PetscReal       a[2], b[2], t[2];

  CurveAt(c, from, a, t);
  CurveAt(c, to, b, t);
  if (turn == 0.0) return CurveLine(a, b);
  return CurveArc(c->c, c->p, c->q, c->from + from * turn, c->from + to * turn);
}

/*
  EllipseFoot - Computes the point nearest to y on an ellipse or ellipsoid about the origin with the
  half axes e along the coordinates

    x_i = e_i^2 y_i/(e_i^2 + t),   sum (e_i y_i/(e_i^2 + t))^2 = 1,   t > -e_m^2

  e_m is the shortest half axis, on the side of y. The sum decreases and is convex, so that Newton's
  method from the left does not overshoot. If y_m = 0, y may be nearer to a point with x_m > 0, at t
  = -e_m^2. Reference: D. Eberly, Distance from a point to an ellipse, an ellipsoid, or a
  hyperellipsoid, Geometric Tools, 2013.
*/
void EllipseFoot(PetscInt dim, const PetscReal e[], const PetscReal y[], PetscReal foot[])
{
  PetscInt  m = -1;
  PetscReal t, inside = 1.0;

  for (PetscInt i = 0; i < dim; i++)
    if (m < 0 || e[i] < e[m]) m = i;
  for (PetscInt i = 0; i < dim && y[m] == 0.0; i++) {
    const PetscReal denominator = PetscSqr(e[i]) - PetscSqr(e[m]);

    foot[i] = 0.0;
    if (y[i] == 0.0) continue;
    foot[i] = denominator > 0.0 ? PetscSqr(e[i]) * y[i] / denominator : PETSC_INFINITY;
    inside -= PetscSqr(foot[i] / e[i]);
  }
  if (y[m] == 0.0 && inside >= 0.0) {
    foot[m] = e[m] * PetscSqrtReal(inside);
    return;
  }
  for (PetscInt i = 0; i < dim; i++) /* the shortest axis with y_i > 0 */
    if (y[i] != 0.0 && (y[m] == 0.0 || e[i] < e[m])) m = i;
  t = -PetscSqr(e[m]) + e[m] * PetscAbsReal(y[m]);
  for (PetscInt k = 0; k < 200; k++) {
    PetscReal sum = -1.0, slope = 0.0, before = t;

    for (PetscInt i = 0; i < dim; i++) {
      if (y[i] == 0.0) continue;
      sum += PetscSqr(e[i] * y[i] / (PetscSqr(e[i]) + t));
      slope -= 2.0 * PetscSqr(e[i] * y[i] / (PetscSqr(e[i]) + t)) / (PetscSqr(e[i]) + t);
    }
    t -= sum / slope;
    if (t <= before) break;
  }
  for (PetscInt i = 0; i < dim; i++)
    foot[i] = y[i] == 0.0 ? 0.0 : PetscSqr(e[i]) * y[i] / (PetscSqr(e[i]) + t);
}

/* Returns s of the angle w on an arc; beyond 1 if it is not on it. */
static PetscReal PlaceOf(const Curve *c, PetscReal w)
{
  const PetscReal turn = c->to - c->from, whole = 2.0 * PETSC_PI / PetscAbsReal(turn);
  const PetscReal s = (w - c->from) / turn;

  return s - whole * PetscFloorReal(s / whole);
}

/* Returns (X(s) - x).X'(s), zero at points nearest to x and farthest from it. */
static PetscReal Slope(const Curve *c, const PetscReal x[2], PetscReal s)
{
  PetscReal y[2], t[2];

  CurveAt(c, s, y, t);
  return (y[0] - x[0]) * t[0] + (y[1] - x[1]) * t[1];
}

static PetscReal Square(const Curve *c, const PetscReal x[2], PetscReal s)
{
  PetscReal y[2], t[2];

  CurveAt(c, s, y, t);
  return PetscSqr(y[0] - x[0]) + PetscSqr(y[1] - x[1]);
}

/* Returns s of the nearest point of a part of an ellipse without the nearest point of the whole. */
static PetscReal NearestInPart(const Curve *c, const PetscReal x[2])
{
  const PetscInt n    = 2 + (PetscInt)(TRIES * PetscAbsReal(c->to - c->from) / (2.0 * PETSC_PI));
  PetscReal      best = Square(c, x, 0.0) <= Square(c, x, 1.0) ? 0.0 : 1.0;

  for (PetscInt k = 0; k < n; k++) {
    PetscReal low = (PetscReal)k / n, high = (k + 1.0) / n;

    if (Slope(c, x, low) > 0.0 || Slope(c, x, high) < 0.0) continue;
    for (PetscInt i = 0; i < 50; i++) {
      const PetscReal middle = 0.5 * (low + high);

      if (Slope(c, x, middle) < 0.0) low = middle;
      else high = middle;
    }
    if (Square(c, x, low) < Square(c, x, best)) best = low;
  }
  return best;
}

/* CurveNearest - Returns the square of the distance of x from a curve, or any number larger than
   `most` if it is larger [m^2]. Output: s - of the nearest point */
PetscReal CurveNearest(const Curve *c, const PetscReal x[2], PetscReal most, PetscReal *s)
{
  const PetscReal r[2]   = {x[0] - c->c[0], x[1] - c->c[1]};
  const PetscReal off[2] = {x[0] - c->middle[0], x[1] - c->middle[1]};
  const PetscReal bound  = PetscSqrtReal(Dot(off, off)) - (0.5 + ROUND) * c->length;

  *s = 0.0;
  if (bound > 0.0 && PetscSqr(bound) > most) return PetscSqr(bound);
  if (c->from == c->to) {
    const PetscReal d[2] = {c->b[0] - c->a[0], c->b[1] - c->a[1]},
                    u[2] = {x[0] - c->a[0], x[1] - c->a[1]};

    *s = PetscMin(PetscMax(Dot(u, d) / Dot(d, d), 0.0), 1.0);
    return Square(c, x, *s);
  }
  if (IsEven(c)) {
    *s = PlaceOf(c, PetscAtan2Real(Dot(r, c->q), Dot(r, c->p)));
    if (*s > 1.0) *s = Square(c, x, 0.0) <= Square(c, x, 1.0) ? 0.0 : 1.0;
  } else {
    const PetscReal e[2] = {PetscSqrtReal(Dot(c->p, c->p)), PetscSqrtReal(Dot(c->q, c->q))};
    const PetscReal y[2] = {Dot(r, c->p) / e[0], Dot(r, c->q) / e[1]};
    PetscReal       foot[2], square;

    EllipseFoot(2, e, y, foot);
    *s     = PlaceOf(c, PetscAtan2Real(foot[1] / e[1], foot[0] / e[0]));
    square = PetscSqr(foot[0] - y[0]) + PetscSqr(foot[1] - y[1]);
    if (*s > 1.0 && square > most) return square; /* no part of the ellipse is nearer */
    if (*s > 1.0) *s = NearestInPart(c, x);
  }
  return Square(c, x, *s);
}

/* BorderMake - Gives a body a border of n curves */
PetscErrorCode BorderMake(PetscInt n, Body *body, Border **made)
{
  Border *border;

  PetscFunctionBegin;
  PetscCall(PetscNew(&border));
  PetscCall(BodyStoreAdd(border, body->store));
  PetscCall(PetscCalloc1(n, &border->curve));
  PetscCall(BodyStoreAdd(border->curve, body->store));
  border->n  = n;
  body->data = border;
  *made      = border;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* BorderLoop - Finds the curves of a closed loop of a border, in which they follow each other;
   returns their number, 0 if there is no such loop. Output: first - of the curves */
PetscInt BorderLoop(const Border *border, PetscInt loop, PetscInt *first)
{
  PetscInt from = 0, n = 0;

  for (PetscInt k = 0; k < border->n; k++) {
    const PetscReal *a = border->curve[k].a, *b = border->curve[k ? k - 1 : 0].b;
    const PetscReal  apart = PetscMax(PetscAbsReal(a[0] - b[0]), PetscAbsReal(a[1] - b[1]));

    if (k && apart > 1e-7 * border->curve[k].length && apart > 1e-7 * border->curve[k - 1].length) {
      if (loop-- == 0) break;
      from = k;
      n    = 0;
    }
    n++;
  }
  *first = from;
  return loop > 0 ? 0 : n;
}

/* BodyLoops - Returns the number of closed loops of the border of a body in the plane, or of the
   outline of a prism */
PetscInt BodyLoops(const Body *body)
{
  PetscInt n = 0, first;

  if (!BodyBorder(body)) return 1;
  while (BorderLoop(BodyBorder(body), n, &first)) n++;
  return n;
}

/* BodyBorder - Returns the curves of a body in the plane, or of the outline of a prism; NULL for
   shapes without curves */
const Border *BodyBorder(const Body *body)
{
  const ShapeRow *plane = body->shape->plane ? body->shape : body->shape->outline;

  return plane && plane->Point == BorderPoint ? (const Border *)body->data : NULL;
}

/* BorderSpan - Computes the least and largest coordinate of a border [m] */
void BorderSpan(const Body *body, PetscInt axis, PetscReal span[2])
{
  const Border *border = (const Border *)body->data;

  span[0] = PETSC_INFINITY;
  span[1] = -PETSC_INFINITY;
  for (PetscInt k = 0; k < border->n; k++) {
    const Curve    *c    = &border->curve[k];
    const PetscReal top  = PetscAtan2Real(c->q[axis], c->p[axis]);
    PetscReal       x[2] = {c->a[axis], c->b[axis]};

    for (PetscInt end = 0; end < 2 && c->from != c->to; end++) {
      const PetscReal s   = PlaceOf(c, top + end * PETSC_PI),
                      far = PetscSqrtReal(PetscSqr(c->p[axis]) + PetscSqr(c->q[axis]));

      if (s <= 1.0) x[end] = c->c[axis] + (end ? -far : far);
    }
    span[0] = PetscMin(span[0], PetscMin(PetscMin(x[0], x[1]), PetscMin(c->a[axis], c->b[axis])));
    span[1] = PetscMax(span[1], PetscMax(PetscMax(x[0], x[1]), PetscMax(c->a[axis], c->b[axis])));
  }
}

/* PartsDistance - Returns the distance from parts combined in their order: min(f, g) of a union,
   max(f, -g) of a difference, max(f, g) of an intersection [m]. Its sign is right, its size a lower
   bound. Output: normal - of the part that it is from */
PetscReal PartsDistance(const Border *border, const PetscReal x[], PetscReal normal[])
{
  PetscReal n[3] = {0.0}, d = 0.0;

  for (PetscInt k = 0; k < border->parts; k++) {
    const PetscReal sign = border->operation[k] == '-' ? -1.0 : 1.0;
    const PetscReal f    = sign * border->part[k].shape->Distance(&border->part[k], x, n);

    if (k && (border->operation[k] == '+' ? f >= d : f <= d)) continue;
    d = f;
    for (PetscInt a = 0; a < (border->part[k].shape->plane ? 2 : 3); a++) normal[a] = sign * n[a];
  }
  return d;
}

/* BorderDistance - Returns the distance of x from the nearest curve of a border [m], negative
   inside. Inside is the solid of the parts, combined in their order. Output: normal - out of the
   solid. */
PetscReal BorderDistance(const Body *body, const PetscReal x[], PetscReal normal[])
{
  const Border *border = (const Border *)body->data;
  PetscReal     best = PETSC_INFINITY, nearest = 0.0, foot[2], t[2], d;
  const Curve  *on = border->curve;

  for (PetscInt k = 0; k < border->n; k++) {
    PetscReal       s;
    const PetscReal square = CurveNearest(&border->curve[k], x, best, &s);

    if (square >= best) continue;
    best    = square;
    on      = &border->curve[k];
    nearest = s;
  }
  CurveAt(on, nearest, foot, t);
  d = PetscSqrtReal(best) * (PartsDistance(border, x, normal) < 0.0 ? -1.0 : 1.0);
  for (PetscInt a = 0; a < 2; a++)
    normal[a] = PetscAbsReal(d) > 1e-9 * body->extent
                    ? (x[a] - foot[a]) / d
                    : (a ? -t[0] : t[1]) / PetscSqrtReal(Dot(t, t));
  return d;
}

/* BorderCount - Returns the number of points dx apart on a border */
PetscInt BorderCount(const Body *body, PetscReal dx)
{
  const Border *border = (const Border *)body->data;
  PetscInt      n      = 0;

  for (PetscInt k = 0; k < border->n; k++) n += ShapeLineCount(border->curve[k].length, dx, 1);
  return n;
}

/* BorderPoint - Computes point k of a border; returns the length of its part [m] */
PetscReal BorderPoint(const Body *body, PetscInt k, PetscReal dx, PetscReal x[], PetscReal normal[])
{
  const Curve *c = ((const Border *)body->data)->curve;
  PetscReal    t[2], speed;
  PetscInt     n = ShapeLineCount(c->length, dx, 1);

  while (k >= n) {
    k -= n;
    c++;
    n = ShapeLineCount(c->length, dx, 1);
  }
  CurveAt(c, CurvePlace(c, (k + 0.5) / n), x, t);
  speed     = PetscSqrtReal(Dot(t, t));
  normal[0] = t[1] / speed;
  normal[1] = -t[0] / speed;
  return c->length / n;
}
