/* Outlines of bodies in the plane, as polygons, and their clipping. */
#include "outline.h"

/* OutlineCreate - Computes the corners of an outline from the points of the surface and the
   lengths of their parts: exact for polygons, and around a circle; not collective */
PetscErrorCode OutlineCreate(const Body *body, PetscReal spacing, const PetscReal shift[2],
                             Outline *o)
{
  PetscFunctionBegin;
  o->n    = BodyPoints(body, spacing);
  o->sign = body->around ? 1.0 : -1.0;
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
