/*
  Bodies, and regions with the same shapes: their geometry in the scene, with periodic images, and
  for fluid on either side of the surface.
*/
#include "shapes.h"

/*
  BodySet - Sets a body from the numbers of its shape [m]

  Not collective. The fluid is outside the body. Its centre, about which it may rotate, is the
  centroid of its area or volume. The scene gives the ends of prisms in 3D. Returns: NULL, or a
  message about the wrong numbers.
*/
const char *BodySet(const Scene *scene, const ShapeRow *shape, PetscInt n, const PetscReal number[],
                    Body *body)
{
  *body = (Body){.shape = shape, .n = n};
  for (PetscInt k = 0; k < n; k++) body->parameter[k] = number[k];
  for (PetscInt end = 0; end < 2 && shape->outline; end++)
    body->ends[end] = end ? scene->hi[2] : scene->lo[2];
  body->centre[2] = 0.5 * (body->ends[0] + body->ends[1]);
  return shape->Prepare(body);
}

/* BodyCircle - Sets a body to a circle of radius r > 0 about (x, y), in 3D to a cylinder along z
   [m]; not collective */
void BodyCircle(const Scene *scene, PetscReal x, PetscReal y, PetscReal r, Body *body)
{
  const PetscReal number[3] = {x, y, r};

  (void)BodySet(scene, scene->dim == 3 ? &ShapeCylinder : &ShapeCircle, 3, number, body);
}

/* BodyBall - Sets a body to a circle of radius r > 0, in 3D to a ball [m]; not collective */
void BodyBall(const Scene *scene, const PetscReal centre[], PetscReal r, Body *body)
{
  PetscReal number[ISPH_MAX_DIM + 1];

  for (PetscInt a = 0; a < scene->dim; a++) number[a] = centre[a];
  number[scene->dim] = r;
  (void)BodySet(scene, scene->dim == 3 ? &ShapeBall : &ShapeCircle, scene->dim + 1, number, body);
}

/* BodyPolygon - Sets a body to a polygon with 3 to 32 corners x, y [m], in 3D to the body that it
   makes with a turn about the axis z, with corners r >= 0, z; returns NULL or a fault; not
   collective */
const char *BodyPolygon(const Scene *scene, PetscInt corners, const PetscReal x[], Body *body)
{
  return BodySet(scene, scene->dim == 3 ? &ShapeRevolved : &ShapePolygon, 2 * corners, x, body);
}

/* BodySpan - Computes the least and largest coordinate of a body along an axis [m]; not
   collective */
void BodySpan(const Body *body, PetscInt axis, PetscReal span[2])
{
  body->shape->Span(body, axis, span);
}

/* BodyReachesThrough - Returns true if a body has no surface across an axis: a prism, along z; not
   collective */
PetscBool BodyReachesThrough(const Body *body, PetscInt axis)
{
  const ShapeRow *shape = body->shape;

  return axis == 2 && shape->outline && !shape->ends && !shape->revolves ? PETSC_TRUE : PETSC_FALSE;
}

/* BodyLines - Computes the coordinates of the faces of a body across an axis [m]; returns their
   number, 0 unless the axes are normal to all faces; not collective */
PetscInt BodyLines(const Body *body, PetscInt axis, PetscReal line[])
{
  const PetscInt   corners = body->n / 2;
  const PetscReal *c       = body->parameter;

  if (body->shape->round) return 0;
  for (PetscInt e = 0; e < corners; e++) {
    const PetscReal *a = &c[2 * e], *b = &c[2 * ((e + 1) % corners)];

    if (a[0] != b[0] && a[1] != b[1]) return 0;
    if (axis < 2) line[e] = a[axis];
  }
  for (PetscInt end = 0; end < 2 && axis == 2; end++) line[end] = body->ends[end];
  return axis < 2 ? corners : 2;
}

/* BodyOutline - Returns the plane shape of the outline of a body along z, or of the meridian of one
   that revolves; plane shapes are their own outline; NULL if there is none; not collective */
const ShapeRow *BodyOutline(const Scene *scene, const Body *body)
{
  return scene->dim == 2 ? body->shape : body->shape->outline;
}

/*
  BodyThickness - Returns the least thickness of a body between opposite surfaces [m]

  Not collective. Searches inwards in steps of dx/4 from surface points dx apart. The two surfaces
  at the tip of a wedge count as opposite only if its angle is less than about 50 degrees. Input:
  limit - largest distance of the search. Output: place - surface point at the least thickness.
  Returns: limit if the body is nowhere thinner, and for bodies around the fluid.
*/
PetscReal BodyThickness(const Body *body, PetscReal dx, PetscReal limit,
                        PetscReal place[ISPH_MAX_DIM])
{
  PetscReal thinnest = limit;

  for (PetscInt k = 0; !body->around && k < BodyPoints(body, dx); k++) {
    PetscReal x[ISPH_MAX_DIM], out[ISPH_MAX_DIM], y[ISPH_MAX_DIM], other[ISPH_MAX_DIM] = {0.0};
    PetscReal beyond = -1.0;

    (void)BodyPoint(body, k, dx, x, out);
    for (PetscReal s = 0.25 * dx; beyond <= 0.0 && s < limit + 0.25 * dx; s += 0.25 * dx) {
      PetscReal along = 0.0;

      for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) y[a] = x[a] - s * out[a];
      beyond = body->shape->Distance(body, y, other);
      for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) along += other[a] * out[a];
      if (beyond <= 0.0 || s - beyond >= thinnest || along > -0.6) continue;
      thinnest = s - beyond;
      for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) place[a] = x[a];
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
                              PetscReal y[ISPH_MAX_DIM], PetscReal normal[])
{
  PetscReal base[ISPH_MAX_DIM] = {0.0}, step[ISPH_MAX_DIM] = {0.0}, best = PETSC_INFINITY;
  PetscInt  periodic = 0; /* bits of the axes along which there are images */

  for (PetscInt a = 0; a < scene->dim; a++) {
    const PetscReal period = scene->hi[a] - scene->lo[a];
    PetscReal       span[2], middle;

    base[a] = x[a];
    if (!SceneIsPeriodic(scene, a) || BodyReachesThrough(body, a)) continue;
    BodySpan(body, a, span);
    middle = 0.5 * (span[0] + span[1]);
    base[a] -= period * PetscFloorReal((x[a] - middle) / period + 0.5);
    step[a] = base[a] > middle ? -period : period; /* to the image on the other side of x */
    periodic |= 1 << a;
  }
  for (PetscInt image = 0; image < 1 << scene->dim; image++) {
    PetscReal z[ISPH_MAX_DIM], distance, n[ISPH_MAX_DIM] = {0.0};

    if (image & ~periodic) continue;
    for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) z[a] = base[a] + (image >> a & 1) * step[a];
    distance = body->shape->Distance(body, z, n);
    if (distance >= best) continue;
    best = distance;
    for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) {
      y[a]      = z[a];
      normal[a] = n[a];
    }
  }
  return best;
}

/*
  BodyArm - Computes the vector from the centre of a body to x, along x and y [m]

  Not collective. In a periodic box the image of the body nearest to x is used.
*/
void BodyArm(const Scene *scene, const Body *body, const PetscReal x[], PetscReal arm[2])
{
  PetscReal y[ISPH_MAX_DIM], normal[ISPH_MAX_DIM];

  (void)NearestImage(scene, body, x, y, normal);
  for (PetscInt a = 0; a < 2; a++) arm[a] = y[a] - body->centre[a];
}

/*
  BodyDistance - Returns the distance from the surface of a body, positive in the fluid [m]

  Not collective. In a periodic box the nearest image of the body is used. Output: normal - into the
  fluid, at the surface point nearest to x.
*/
PetscReal BodyDistance(const Scene *scene, const Body *body, const PetscReal x[],
                       PetscReal normal[])
{
  PetscReal       y[ISPH_MAX_DIM];
  const PetscReal distance = NearestImage(scene, body, x, y, normal);

  if (!body->around) return distance;
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) normal[a] = -normal[a];
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
  that belongs to the point [m], its area in 3D [m^2].
*/
PetscReal BodyPoint(const Body *body, PetscInt k, PetscReal dx, PetscReal x[], PetscReal normal[])
{
  PetscReal length;

  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) x[a] = normal[a] = 0.0;
  length = body->shape->Point(body, k, dx, x, normal);
  for (PetscInt a = 0; body->around && a < ISPH_MAX_DIM; a++) normal[a] = -normal[a];
  return length;
}
