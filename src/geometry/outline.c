/* Outlines of bodies in the plane, as polygons, and their union. */
#include "outline.h"
#include "curves.h"

#define TIGHT 1e-12 /* distance of places that are the same [extent] */

/* Computes the corners of an outline from the points of the surface and the lengths of their parts:
   exact for polygons, and around a circle. */
static PetscErrorCode FromPoints(const Body *body, PetscReal spacing, const PetscReal shift[2],
                                 Outline *o)
{
  PetscFunctionBegin;
  o->n = BodyPoints(body, spacing);
  PetscCall(PetscCalloc1(2 * o->n, &o->x));
  for (PetscInt k = 0; k < o->n; k++) {
    PetscReal       x[ISPH_MAX_DIM], normal[ISPH_MAX_DIM];
    const PetscReal half       = 0.5 * BodyPoint(body, k, spacing, x, normal);
    const PetscReal tangent[2] = {normal[1] * o->sign, -normal[0] * o->sign};

    for (PetscInt a = 0; a < 2; a++) {
      o->x[2 * k + a] += 0.5 * (x[a] + shift[a] + half * tangent[a]);
      o->x[2 * ((k + o->n - 1) % o->n) + a] += 0.5 * (x[a] + shift[a] - half * tangent[a]);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the corners of a loop of curves: the ends of curves, and between them corners of
   tangents through points on the curve. */
static PetscErrorCode FromCurves(const Body *body, PetscInt loop, PetscReal spacing,
                                 const PetscReal shift[2], Outline *o)
{
  const Border *border = BodyBorder(body);
  PetscInt      first, curves = BorderLoop(border, loop, &first);

  PetscFunctionBegin;
  o->n = 0;
  for (PetscInt k = first; k < first + curves; k++)
    o->n += ShapeLineCount(border->curve[k].length, spacing,
                           border->curve[k].from == border->curve[k].to ? 1 : 4);
  PetscCall(PetscCalloc1(2 * o->n, &o->x));
  o->n = 0;
  for (PetscInt k = first; k < first + curves; k++) {
    const Curve   *c = &border->curve[k];
    const PetscInt n = ShapeLineCount(c->length, spacing, c->from == c->to ? 1 : 4);

    for (PetscInt a = 0; a < 2; a++) o->x[2 * o->n + a] = c->a[a];
    for (PetscInt j = 0; j + 1 < n; j++) {
      for (PetscInt side = 0; side < 2; side++) {
        PetscReal x[2], t[2], speed;

        CurveAt(c, CurvePlace(c, (j + side + 0.5) / n), x, t);
        speed = PetscSqrtReal(t[0] * t[0] + t[1] * t[1]);
        for (PetscInt a = 0; a < 2; a++)
          o->x[2 * (o->n + j + 1) + a] +=
              0.5 * (x[a] + (side ? -0.5 : 0.5) * c->length / n * t[a] / speed);
      }
    }
    o->n += n;
  }
  for (PetscInt k = 0; k < o->n; k++) {
    PetscReal x[ISPH_MAX_DIM] = {o->x[2 * k], o->x[2 * k + 1]};

    PoseOut(body, x);
    for (PetscInt a = 0; a < 2; a++) o->x[2 * k + a] = x[a] + shift[a];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* OutlineCreate - Computes the corners of a loop of BodyLoops() of a body in the plane, about
   `spacing` apart on curves */
PetscErrorCode OutlineCreate(const Body *body, PetscInt loop, PetscReal spacing,
                             const PetscReal shift[2], Outline *o)
{
  PetscFunctionBegin;
  *o = (Outline){.sign = body->around ? 1.0 : -1.0};
  PetscCall(BodyBorder(body) ? FromCurves(body, loop, spacing, shift, o)
                             : FromPoints(body, spacing, shift, o));
  for (PetscInt a = 0; a < 2; a++) {
    o->lo[a] = PETSC_INFINITY;
    o->hi[a] = -PETSC_INFINITY;
    for (PetscInt k = 0; k < o->n; k++) {
      o->lo[a] = PetscMin(o->lo[a], o->x[2 * k + a]);
      o->hi[a] = PetscMax(o->hi[a], o->x[2 * k + a]);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* BodyCorners - Computes the corners of the outline of a plane body with curves, or one that is not
   where it was typed, as one polygon whose loops are joined by lines there and back; n = 0 for
   other bodies; the caller frees x */
PetscErrorCode BodyCorners(const Body *body, PetscReal spacing, PetscInt *n, PetscReal **x)
{
  const PetscReal none[2] = {0.0, 0.0};
  const PetscBool has     = BodyBorder(body) || (body->shape->plane && body->pose);
  const PetscInt  loops   = has ? BodyLoops(body) : 0;

  PetscFunctionBegin;
  *n = 0;
  *x = NULL;
  for (PetscInt loop = 0; loop < loops; loop++) {
    Outline o;

    PetscCall(OutlineCreate(body, loop, spacing, none, &o));
    PetscCall(PetscRealloc(sizeof(**x) * 2 * (size_t)(*n + o.n + 2), x));
    PetscCall(PetscArraycpy(*x + 2 * *n, o.x, 2 * o.n));
    *n += o.n;
    if (loops > 1) PetscCall(PetscArraycpy(*x + 2 * (*n)++, o.x, 2));
    if (loop > 0 && loop + 1 < loops) PetscCall(PetscArraycpy(*x + 2 * (*n)++, *x, 2));
    PetscCall(OutlineFree(&o));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* OutlineIsApart - Returns true if an outline has no part in a box */
PetscBool OutlineIsApart(const Outline *o, const PetscReal lo[2], const PetscReal hi[2])
{
  return o->lo[0] > hi[0] || o->lo[1] > hi[1] || o->hi[0] < lo[0] || o->hi[1] < lo[1];
}

/* OutlineFree - Frees an outline */
PetscErrorCode OutlineFree(Outline *o)
{
  PetscFunctionBegin;
  PetscCall(FreeAll(&o->x, &o->piece));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Places along an outline: the number of the line and the share of its length. */
typedef struct {
  PetscInt   n, capacity;
  PetscReal *at;
} Places;

static PetscErrorCode AddPlace(PetscInt line, PetscReal share, Places *places)
{
  PetscFunctionBegin;
  if (places->n == places->capacity) {
    places->capacity = 2 * places->capacity + 64;
    PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)places->capacity, &places->at));
  }
  places->at[places->n++] = line + share;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the ends of line k and its vector; returns its length. */
static PetscReal Line(const Outline *o, PetscInt k, const PetscReal **a, const PetscReal **b,
                      PetscReal d[2])
{
  *a = &o->x[2 * k];
  *b = &o->x[2 * ((k + 1) % o->n)];
  for (PetscInt e = 0; e < 2; e++) d[e] = (*b)[e] - (*a)[e];
  return PetscSqrtReal(d[0] * d[0] + d[1] * d[1]);
}

static PetscReal Cross(const PetscReal u[2], const PetscReal v[2])
{
  return u[0] * v[1] - u[1] * v[0];
}

/* Adds the place of line k of an outline that is nearest to x, if it is within `tight` of x and not
   at an end; returns true if it is within. */
static PetscErrorCode AddNear(const Outline *o, PetscInt k, const PetscReal x[2], PetscReal tight,
                              Places *places, PetscBool *meets)
{
  const PetscReal *a, *b;
  PetscReal        d[2], length = Line(o, k, &a, &b, d), r[2] = {x[0] - a[0], x[1] - a[1]}, along;

  PetscFunctionBegin;
  if (length == 0.0 || PetscAbsReal(Cross(d, r)) > tight * length)
    PetscFunctionReturn(PETSC_SUCCESS);
  along = (d[0] * r[0] + d[1] * r[1]) / length;
  if (along < -tight || along > length + tight) PetscFunctionReturn(PETSC_SUCCESS);
  *meets = PETSC_TRUE;
  if (along > tight && along < length - tight) PetscCall(AddPlace(k, along / length, places));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the places at which two outlines meet: crossings of lines, and ends of a line on another. */
static PetscErrorCode Meet(const Outline *o, const Outline *other, PetscReal tight, Places *places,
                           Places *others, PetscBool *meets)
{
  const PetscReal *a, *b, *e, *f;
  PetscReal        d[2], g[2];

  PetscFunctionBegin;
  for (PetscInt k = 0; k < o->n; k++) {
    const PetscReal length = Line(o, k, &a, &b, d);

    if (PetscMax(a[0], b[0]) < other->lo[0] - tight || PetscMin(a[0], b[0]) > other->hi[0] + tight)
      continue;
    for (PetscInt m = 0; m < other->n; m++) {
      const PetscReal width = Line(other, m, &e, &f, g), area = Cross(d, g);
      PetscReal       r[2], t, s;

      if (PetscMax(a[0], b[0]) < PetscMin(e[0], f[0]) - tight ||
          PetscMin(a[0], b[0]) > PetscMax(e[0], f[0]) + tight ||
          PetscMax(a[1], b[1]) < PetscMin(e[1], f[1]) - tight ||
          PetscMin(a[1], b[1]) > PetscMax(e[1], f[1]) + tight)
        continue;
      for (PetscInt c = 0; c < 2; c++) r[c] = e[c] - a[c];
      PetscCall(AddNear(o, k, e, tight, places, meets));
      PetscCall(AddNear(other, m, a, tight, others, meets));
      if (PetscAbsReal(area) < 1e-9 * length * width) continue;
      t = Cross(r, g) / area;
      s = Cross(r, d) / area;
      if (t * length < tight || (1.0 - t) * length < tight || s * width < tight ||
          (1.0 - s) * width < tight)
        continue;
      PetscCall(AddPlace(k, t, places));
      PetscCall(AddPlace(m, s, others));
      *meets = PETSC_TRUE;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns true if the solid with the outlines [first, last) buries x, on the line of an outline
   with the vector d; or has the same line, and is the first one with it. */
static PetscBool Buries(const Outline o[], PetscInt first, PetscInt last, const Outline *own,
                        const PetscReal x[2], const PetscReal d[2], PetscReal tight)
{
  PetscInt winding = 0;

  for (PetscInt k = first; k < last; k++) {
    for (PetscInt m = 0; m < o[k].n; m++) {
      const PetscReal *a, *b;
      PetscReal        g[2], length = Line(&o[k], m, &a, &b, g), r[2] = {x[0] - a[0], x[1] - a[1]};
      const PetscReal  left = Cross(g, r), along = g[0] * r[0] + g[1] * r[1];

      if (PetscAbsReal(left) <= tight * length && along >= 0.0 && along <= length * length &&
          PetscAbsReal(Cross(d, g)) <= 1e-6 * length * PetscSqrtReal(d[0] * d[0] + d[1] * d[1]))
        return (d[0] * g[0] + d[1] * g[1]) * own->sign * o[k].sign < 0.0 || o[k].solid < own->solid;
      if ((a[1] <= x[1]) != (b[1] <= x[1]) && (left > 0.0) == (b[1] > a[1]))
        winding += b[1] > a[1] ? 1 : -1;
    }
  }
  return (o[first].sign < 0.0) == (winding != 0);
}

/* Returns true if another solid buries x on a line of outline `own`. */
static PetscBool IsBuried(PetscInt n, const Outline o[], PetscInt own, const PetscReal x[2],
                          const PetscReal d[2], PetscReal tight)
{
  for (PetscInt first = 0, last; first < n; first = last) {
    for (last = first; last < n && o[last].solid == o[first].solid;) last++;
    if (o[first].solid != o[own].solid && Buries(o, first, last, &o[own], x, d, tight))
      return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Sets the pieces of an outline that no other solid buries; without places at which it meets
   another, a single point is enough to know. */
static PetscErrorCode SetPieces(PetscInt n, Outline o[], PetscInt own, PetscBool meets,
                                Places *places, PetscReal tight)
{
  Outline  *out    = &o[own];
  PetscInt  next   = 0;
  PetscBool buried = PETSC_FALSE;

  PetscFunctionBegin;
  PetscCall(PetscSortReal(places->n, places->at));
  PetscCall(PetscMalloc1(4 * (out->n + places->n), &out->piece));
  out->pieces = 0;
  for (PetscInt k = 0; k < out->n; k++) {
    const PetscReal *a, *b;
    PetscReal        d[2], length = Line(out, k, &a, &b, d), from = 0.0, to;

    for (; from < 1.0; from = to) {
      PetscReal *piece = &out->piece[4 * out->pieces], middle[2];

      to = next < places->n && places->at[next] < k + 1.0 ? places->at[next++] - k : 1.0;
      if ((to - from) * length <= tight) continue;
      for (PetscInt e = 0; e < 2; e++) {
        middle[e]    = a[e] + 0.5 * (from + to) * d[e];
        piece[e]     = from == 0.0 ? a[e] : a[e] + from * d[e];
        piece[2 + e] = to == 1.0 ? b[e] : a[e] + to * d[e];
      }
      if (meets || k == 0) buried = IsBuried(n, o, own, middle, d, tight);
      if (!buried) out->pieces++;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* OutlinesUnite - Sets the pieces of outlines on the border of the fluid: those in no other solid.
   Outlines of a solid stand together. A line of several solids with the fluid on the same side
   belongs to the first of them, and with the fluid on no side to none. The pieces of outlines that
   meet form closed loops together, which share a box. */
PetscErrorCode OutlinesUnite(PetscInt n, Outline o[])
{
  Places    *places;
  PetscBool *meets;
  PetscReal  extent = 0.0;
  Outline    all    = {.lo = {PETSC_INFINITY, PETSC_INFINITY}};

  PetscFunctionBegin;
  all.hi[0] = all.hi[1] = -PETSC_INFINITY;
  PetscCall(PetscCalloc2(n, &places, n, &meets));
  for (PetscInt k = 0; k < n; k++)
    for (PetscInt a = 0; a < 2; a++) extent = PetscMax(extent, o[k].hi[a] - o[k].lo[a]);
  for (PetscInt k = 0; k < n; k++) {
    for (PetscInt m = 0; m < k; m++) {
      PetscBool meet = PETSC_FALSE;

      if (o[k].solid == o[m].solid || OutlineIsApart(&o[k], o[m].lo, o[m].hi)) continue;
      PetscCall(Meet(&o[k], &o[m], TIGHT * extent, &places[k], &places[m], &meet));
      if (meet) meets[k] = meets[m] = PETSC_TRUE;
    }
  }
  for (PetscInt k = 0; k < n; k++) {
    PetscCall(SetPieces(n, o, k, meets[k], &places[k], TIGHT * extent));
    PetscCall(PetscFree(places[k].at));
    for (PetscInt a = 0; a < 2 && meets[k]; a++) {
      all.lo[a] = PetscMin(all.lo[a], o[k].lo[a]);
      all.hi[a] = PetscMax(all.hi[a], o[k].hi[a]);
    }
  }
  for (PetscInt k = 0; k < n; k++) {
    if (!meets[k]) continue;
    PetscCall(PetscArraycpy(o[k].lo, all.lo, 2));
    PetscCall(PetscArraycpy(o[k].hi, all.hi, 2));
  }
  PetscCall(PetscFree2(places, meets));
  PetscFunctionReturn(PETSC_SUCCESS);
}
