/* Bodies, and regions with the same shapes: their extent, faces, thickness, the points on their
   surface, and their moments by the divergence theorem. */
#include "shapes.h"

#define POINTS 60.0 /* along the extent of a body, in the coarser of two sums of moments */

/* BodySetBox - Sets the box around the outline of a body, infinite along axes along which it has no
   end */
void BodySetBox(Body *body)
{
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) {
    PetscReal       span[2] = {-PETSC_INFINITY, PETSC_INFINITY};
    const PetscBool has_no_end =
        body->shape->plane ? (PetscBool)(a == 2) : BodyReachesThrough(body, a);

    if (!has_no_end) body->shape->Span(body, a, span);
    body->lo[a] = span[0];
    body->hi[a] = span[1];
  }
}

/* BodyNumbers - Sets a body from n numbers of its shape [m], which `store` will own; returns NULL
   or a fault */
const char *BodyNumbers(const ShapeRow *shape, PetscInt n, const PetscReal number[],
                        BodyStore *store, Body *body)
{
  const char *fault;

  body->shape = shape;
  body->n     = n;
  body->store = store;
  if (PetscMalloc1(2 * n + 8, &body->parameter)) return "there is no memory for its numbers";
  if (BodyStoreAdd(body->parameter, store)) return "there is no memory for its numbers";
  (void)PetscArraycpy(body->parameter, number, n);
  fault = shape->Prepare(body);
  if (!fault) BodySetBox(body);
  return fault;
}

/* BodyWithin - Returns the signed distance of x from the outline of a body, positive outside [m]. A
   distance that is certainly larger than `most` may be returned as any number larger than it,
   without a normal: first the distance from the box around the body is tried. */
PetscReal BodyWithin(const Body *body, const PetscReal x[], PetscReal most, PetscReal normal[])
{
  const PetscReal sure = most + 1e-9 * body->extent; /* with the rounding of distances */

  for (PetscInt a = 0; a < (body->shape->plane ? 2 : ISPH_MAX_DIM) && most < PETSC_INFINITY; a++) {
    const PetscReal far = PetscMax(body->lo[a] - x[a], x[a] - body->hi[a]);

    if (far > sure) return far;
  }
  if (body->shape->Within) return body->shape->Within(body, x, most, normal);
  return body->shape->Distance(body, x, normal);
}

/* BodySpan - Computes the least and largest coordinate of a body along an axis [m]; of a body that
   has turned, those of the box around it that turned with it */
void BodySpan(const Body *body, PetscInt axis, PetscReal span[2])
{
  PetscReal middle[ISPH_MAX_DIM] = {0.0}, reach = 0.0;
  PetscBool flat; /* it has turned about z at most */

  if (!body->pose && body->hi[axis] < PETSC_INFINITY) {
    span[0] = body->lo[axis];
    span[1] = body->hi[axis];
    return;
  }
  body->shape->Span(body, axis, span);
  if (!body->pose) return;
  flat = body->pose->turn[1] == 0.0 && body->pose->turn[2] == 0.0;
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) {
    PetscReal side[2], half[ISPH_MAX_DIM] = {0.0};

    if (flat && (a == 2) != (axis == 2)) continue;
    body->shape->Span(body, a, side);
    middle[a] = 0.5 * (side[0] + side[1]);
    half[a]   = 0.5 * (side[1] - side[0]);
    PoseTurn(body->pose, PETSC_FALSE, half);
    reach += PetscAbsReal(half[axis]);
  }
  PoseOut(body, middle);
  span[0] = middle[axis] - reach;
  span[1] = middle[axis] + reach;
}

/* BodyReachesThrough - Returns true if a body has no surface across an axis: a prism, along z */
PetscBool BodyReachesThrough(const Body *body, PetscInt axis)
{
  const ShapeRow *shape = body->shape;

  return axis == 2 && shape->outline && !shape->ends && !shape->revolves;
}

/* BodyLines - Computes the coordinates of the faces of a body across an axis [m]; returns their
   number, 0 unless the axes are normal to all faces */
PetscInt BodyLines(const Body *body, PetscInt axis, PetscReal line[])
{
  const PetscInt   corners = body->n / 2;
  const PetscReal *c       = body->parameter;
  const ShapeRow  *plane   = body->shape->plane ? body->shape : body->shape->outline;

  if (body->shape->round || !plane || plane->Distance != ShapePolygon.Distance) return 0;
  for (PetscInt e = 0; e < corners; e++) {
    const PetscReal *a = &c[2 * e], *b = &c[2 * ((e + 1) % corners)];

    if (a[0] != b[0] && a[1] != b[1]) return 0;
    if (axis < 2) line[e] = a[axis];
  }
  for (PetscInt end = 0; end < 2 && axis == 2; end++) line[end] = body->ends[end];
  return axis < 2 ? corners : 2;
}

/* BodyThickness - Returns the least thickness of a body between opposite surfaces [m]. Searches
   inwards in steps of dx/4 from surface points dx apart. The two surfaces at the tip of a wedge
   count as opposite only if its angle is less than about 50 degrees. Input: limit - largest
   distance of the search. Output: place - surface point at the least thickness. Returns: limit if
   the body is nowhere thinner, and for bodies around the fluid. */
PetscReal BodyThickness(const Body *body, PetscReal dx, PetscReal limit,
                        PetscReal place[ISPH_MAX_DIM])
{
  const PetscInt points   = body->around ? 0 : BodyPoints(body, dx);
  PetscReal      thinnest = limit;
  Body           typed    = *body;

  typed.pose = NULL;
  for (PetscInt k = 0; k < points; k++) {
    PetscReal x[ISPH_MAX_DIM], out[ISPH_MAX_DIM], y[ISPH_MAX_DIM], other[ISPH_MAX_DIM] = {0.0};
    PetscReal beyond = -1.0;

    (void)BodyPoint(&typed, k, dx, x, out);
    for (PetscReal s = 0.25 * dx; beyond <= 0.0 && s < limit + 0.25 * dx; s += 0.25 * dx) {
      PetscReal along = 0.0;

      for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) y[a] = x[a] - s * out[a];
      beyond = body->shape->Distance(body, y, other);
      for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) along += other[a] * out[a];
      if (beyond <= 0.0 || s - beyond >= thinnest || along > -0.6) continue;
      thinnest = s - beyond;
      for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) place[a] = x[a];
      PoseOut(body, place);
    }
  }
  return thinnest;
}

/* BodyPoints - Returns the number of surface points dx apart */
PetscInt BodyPoints(const Body *body, PetscReal dx)
{
  return body->shape->Count(body, dx);
}

/* BodyPoint - Computes point k of the BodyPoints() points on the surface of a body. Output: x - the
   point [m]; normal - into the fluid. Returns: the length of surface that belongs to the point [m],
   its area in 3D [m^2]. */
PetscReal BodyPoint(const Body *body, PetscInt k, PetscReal dx, PetscReal x[], PetscReal normal[])
{
  PetscReal length;

  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) x[a] = normal[a] = 0.0;
  length = body->shape->Point(body, k, dx, x, normal);
  PoseOut(body, x);
  if (body->pose) PoseTurn(body->pose, PETSC_FALSE, normal);
  for (PetscInt a = 0; body->around && a < ISPH_MAX_DIM; a++) normal[a] = -normal[a];
  return length;
}

/* Computes volume, first moments and second moments about a place from the points dx apart:

     V = 1/d sum r.n dA,   int r_i dV = 1/(d+1) sum r_i r.n dA,
     int r_i r_j dV = 1/(d+2) sum r_i r_j r.n dA */
static void Sum(const Body *body, PetscInt dim, const PetscReal about[], PetscReal dx,
                PetscReal sum[10])
{
  const PetscInt points = body->shape->Count(body, dx);

  for (PetscInt e = 0; e < 10; e++) sum[e] = 0.0;
  for (PetscInt k = 0; k < points; k++) {
    PetscReal       x[3] = {0.0}, n[3] = {0.0}, out = 0.0;
    const PetscReal area = body->shape->Point(body, k, dx, x, n);

    for (PetscInt a = 0; a < dim; a++) {
      x[a] -= about[a];
      out += x[a] * n[a] * area;
    }
    sum[0] += out / dim;
    for (PetscInt a = 0; a < dim; a++) sum[1 + a] += x[a] * out / (dim + 1.0);
    for (PetscInt e = 0; e < 6; e++) { /* xx yy zz xy yz zx */
      const PetscInt i = e % 3, j = e < 3 ? i : (i + 1) % 3;

      if (i < dim && j < dim) sum[4 + e] += x[i] * x[j] * out / (dim + 2.0);
    }
  }
}

/* BodyFindMoments - Computes the area or volume of a body as it was typed, its centroid and its
   second moments int x_i x_j dV about the centroid. Two sums over points on the surface, of
   spacings h = extent/60 and h/2, are extrapolated to h = 0: exact for polygons and boxes, of order
   4 for smooth surfaces on which points are on rings or curves; solids with edges where parts meet
   have an error of about h/extent times the length of these edges in the extent. For solids that
   reach through the box all is per length, in the plane. Output: moments; error - the difference of
   the sums of the volume, in the volume. */
void BodyFindMoments(const Body *body, BodyMoments *moments)
{
  const PetscInt  dim = body->shape->plane || BodyReachesThrough(body, 2) ? 2 : 3;
  const PetscReal h   = body->extent / POINTS;
  PetscReal       coarse[10], fine[10], length = 1.0;

  if (body->shape->Moments) {
    body->shape->Moments(body, moments);
    return;
  }
  *moments = (BodyMoments){.volume = 0.0};
  Sum(body, dim, body->centre, h, coarse);
  Sum(body, dim, body->centre, 0.5 * h, fine);
  if (dim == 2 && !body->shape->plane) length = body->ends[1] - body->ends[0];
  moments->error = PetscAbsReal(fine[0] / coarse[0] - 1.0);
  for (PetscInt e = 0; e < 10; e++) fine[e] = (4.0 * fine[e] - coarse[e]) / (3.0 * length);
  moments->volume = fine[0];
  for (PetscInt a = 0; a < 3; a++)
    moments->centroid[a] = body->centre[a] + (a < dim ? fine[1 + a] / fine[0] : 0.0);
  for (PetscInt e = 0; e < 6; e++) {
    const PetscInt i = e % 3, j = e < 3 ? i : (i + 1) % 3;

    moments->second[i][j] = moments->second[j][i] =
        fine[4 + e] - fine[1 + i] * fine[1 + j] / fine[0];
  }
}

/* SurfaceTangents - Computes the unit tangents t of a surface with the unit normal n, one in 2D and
   two in 3D; returns their number; not collective */
PetscInt SurfaceTangents(PetscInt dim, const PetscReal n[], PetscReal t[][ISPH_MAX_DIM])
{
  PetscInt  least = 0;
  PetscReal length;

  if (dim == 2) {
    t[0][0] = -n[1];
    t[0][1] = n[0];
    return 1;
  }
  for (PetscInt a = 1; a < 3; a++) least = PetscAbsReal(n[a]) < PetscAbsReal(n[least]) ? a : least;
  length = PetscSqrtReal(1.0 - PetscSqr(n[least]));
  for (PetscInt a = 0; a < 3; a++) t[0][a] = ((a == least) - n[least] * n[a]) / length;
  for (PetscInt a = 0; a < 3; a++) {
    const PetscInt b = (a + 1) % 3, c = (a + 2) % 3;

    t[1][a] = n[b] * t[0][c] - n[c] * t[0][b];
  }
  return 2;
}
