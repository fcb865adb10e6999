/* Outlines of bodies in the plane, as polygons, and their clipping. */
#include "outline.h"
#include "curves.h"

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
   `spacing` apart on curves; not collective */
PetscErrorCode OutlineCreate(const Body *body, PetscInt loop, PetscReal spacing,
                             const PetscReal shift[2], Outline *o)
{
  PetscFunctionBegin;
  o->sign = body->around ? 1.0 : -1.0;
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

/* BodyCorners - Computes the corners of the outline of a plane body with curves, or one that is
   not where it was typed, as one polygon whose loops are joined by lines there and back; n = 0
   for other bodies; the caller frees x; not collective */
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
    for (PetscInt a = 0; a < 2 && loop > 0; a++) {
      (*x)[2 * *n + a]       = o.x[a];
      (*x)[2 * (*n + 1) + a] = (*x)[a];
    }
    if (loop > 0) *n += 2;
    PetscCall(PetscFree(o.x));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* OutlineIsApart - Returns true if an outline has no part in a box; not collective */
PetscBool OutlineIsApart(const Outline *o, const PetscReal lo[2], const PetscReal hi[2])
{
  return o->lo[0] > hi[0] || o->lo[1] > hi[1] || o->hi[0] < lo[0] || o->hi[1] < lo[1];
}

/* OutlineClip - Clips a polygon of n corners to s x_axis >= s limit; returns the number of corners.
   Parts that are not connected are joined by lines along the limit, whose areas cancel. */
PetscInt OutlineClip(PetscInt n, const PetscReal x[], PetscInt axis, PetscReal s, PetscReal limit,
                     PetscReal out[])
{
  PetscInt m = 0;

  for (PetscInt k = 0; k < n; k++) {
    const PetscReal *a = &x[2 * k], *b = &x[2 * ((k + 1) % n)];
    const PetscReal  da = s * (a[axis] - limit), db = s * (b[axis] - limit);

    if (da >= 0.0) {
      out[2 * m]       = a[0];
      out[2 * m++ + 1] = a[1];
    }
    if ((da >= 0.0) != (db >= 0.0)) {
      out[2 * m + axis]       = limit;
      out[2 * m++ + 1 - axis] = a[1 - axis] + da / (da - db) * (b[1 - axis] - a[1 - axis]);
    }
  }
  return m;
}
