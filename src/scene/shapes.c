/*
  Shapes of bodies in the plane, by their signed distance and by points along their surface. A new
  shape is three functions and one row.
*/
#include "isph/scene.h"

/* ---- circle: cx, cy, r ---- */

static PetscReal CircleDistance(const Body *body, const PetscReal x[], PetscReal normal[])
{
  const PetscReal *c = body->number, dx = x[0] - c[0], dy = x[1] - c[1],
                  r = PetscSqrtReal(dx * dx + dy * dy);

  normal[0] = r > 0.0 ? dx / r : 1.0;
  normal[1] = r > 0.0 ? dy / r : 0.0;
  return r - c[2];
}

static PetscInt CircleCount(const Body *body, PetscReal dx)
{
  return PetscMax(8, (PetscInt)PetscFloorReal(2.0 * PETSC_PI * body->number[2] / dx + 0.5));
}

static PetscReal CirclePoint(const Body *body, PetscInt k, PetscReal dx, PetscReal x[],
                             PetscReal normal[])
{
  const PetscInt  n     = CircleCount(body, dx);
  const PetscReal angle = 2.0 * PETSC_PI * (k + 0.5) / n;

  normal[0] = PetscCosReal(angle);
  normal[1] = PetscSinReal(angle);
  for (PetscInt a = 0; a < 2; a++) x[a] = body->number[a] + body->number[2] * normal[a];
  return 2.0 * PETSC_PI * body->number[2] / n;
}

/* ---- polygon: x, y of each corner, counter-clockwise ---- */

static PetscInt Corners(const Body *body)
{
  return body->n / 2;
}

/* Ends of edge e and its length. */
static PetscReal Edge(const Body *body, PetscInt e, const PetscReal **from, const PetscReal **to)
{
  *from = &body->number[2 * e];
  *to   = &body->number[2 * ((e + 1) % Corners(body))];
  return PetscSqrtReal(PetscSqr((*to)[0] - (*from)[0]) + PetscSqr((*to)[1] - (*from)[1]));
}

/* Nearest point of all edges; inside by the number of edges that a ray along x crosses. */
static PetscReal PolygonDistance(const Body *body, const PetscReal x[], PetscReal normal[])
{
  PetscReal best = PETSC_MAX_REAL, foot[2] = {0.0}, outward[2] = {0.0}, d;
  PetscBool inside = PETSC_FALSE;

  for (PetscInt e = 0; e < Corners(body); e++) {
    const PetscReal *a, *b, length = Edge(body, e, &a, &b), tx = (b[0] - a[0]) / length,
                            ty = (b[1] - a[1]) / length;
    const PetscReal s  = PetscMin(PetscMax((x[0] - a[0]) * tx + (x[1] - a[1]) * ty, 0.0), length);
    const PetscReal px = a[0] + s * tx, py = a[1] + s * ty,
                    d2 = PetscSqr(x[0] - px) + PetscSqr(x[1] - py);

    if (d2 < best) {
      best       = d2;
      foot[0]    = px;
      foot[1]    = py;
      outward[0] = ty;
      outward[1] = -tx;
    }
    if ((a[1] > x[1]) != (b[1] > x[1]) &&
        x[0] < a[0] + (x[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]))
      inside = !inside;
  }
  d = PetscSqrtReal(best) * (inside ? -1.0 : 1.0);
  for (PetscInt a = 0; a < 2; a++)
    normal[a] = PetscAbsReal(d) > 1e-9 * body->extent ? (x[a] - foot[a]) / d : outward[a];
  return d;
}

static PetscInt EdgeCount(const Body *body, PetscInt e, PetscReal dx)
{
  const PetscReal *a, *b;

  return PetscMax(1, (PetscInt)PetscFloorReal(Edge(body, e, &a, &b) / dx + 0.5));
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
    /* name, brief, citation, numbers: fewest, most, distance, points along the surface */
    {"circle", "cx,cy,r", "", 3, 3, CircleDistance, CircleCount, CirclePoint},
    {"box", "x0,y0,x1,y1: two opposite corners", "", 4, 4, PolygonDistance, PolygonCount,
     PolygonPoint},
    {"polygon", "x0,y0,x1,y1,...: corners in order", "", 6, BODY_NUMBERS, PolygonDistance,
     PolygonCount, PolygonPoint},
};
const Table ShapeTable = TABLE("-scene_body_<k>", "Shapes of bodies", shapes);

/* Corners of a box as those of a polygon, and any polygon counter-clockwise. */
static void BodyOrder(Body *body)
{
  PetscReal *c = body->number, area = 0.0;

  if (body->n == 4) {
    const PetscReal box[8] = {c[0], c[1], c[2], c[1], c[2], c[3], c[0], c[3]};

    for (PetscInt k = 0; k < 8; k++) c[k] = box[k];
    body->n = 8;
  }
  for (PetscInt e = 0; e < Corners(body); e++) {
    const PetscReal *a, *b;

    (void)Edge(body, e, &a, &b);
    area += a[0] * b[1] - a[1] * b[0];
  }
  for (PetscInt k = 0; area < 0.0 && k < Corners(body) / 2; k++) {
    const PetscInt m = Corners(body) - 1 - k;

    for (PetscInt a = 0; a < 2; a++) {
      const PetscReal kept = c[2 * k + a];

      c[2 * k + a] = c[2 * m + a];
      c[2 * m + a] = kept;
    }
  }
}

/*
  BodySet - Makes a body of its shape's numbers [m]

  Not collective. The body is at rest, the fluid around it. Its centre, which it rotates about, is a
  circle's centre or the middle of the corners.
*/
void BodySet(Body *body, const ShapeRow *shape, PetscInt n, const PetscReal number[])
{
  *body = (Body){.shape = shape, .n = n};
  for (PetscInt k = 0; k < n; k++) body->number[k] = number[k];
  if (n == 3) {
    body->centre[0] = number[0];
    body->centre[1] = number[1];
    body->extent    = number[2];
    return;
  }
  BodyOrder(body);
  for (PetscInt k = 0; k < body->n; k++) body->centre[k % 2] += body->number[k] / Corners(body);
  for (PetscInt k = 0; k < body->n; k++)
    body->extent = PetscMax(body->extent, PetscAbsReal(body->number[k] - body->centre[k % 2]));
}

/* BodySpan - From where to where a body reaches along an axis of the plane [m] */
void BodySpan(const Body *body, PetscInt axis, PetscReal span[2])
{
  if (body->n == 3) {
    span[0] = body->centre[axis] - body->extent;
    span[1] = body->centre[axis] + body->extent;
    return;
  }
  span[0] = span[1] = body->number[axis];
  for (PetscInt k = axis; k < body->n; k += 2) {
    span[0] = PetscMin(span[0], body->number[k]);
    span[1] = PetscMax(span[1], body->number[k]);
  }
}

/*
  BodyArm - Where x is, seen from a body's centre [m]

  Not collective. In a periodic box of the body's images that nearest to x counts.
*/
void BodyArm(const Scene *scene, const Body *body, const PetscReal x[], PetscReal arm[2])
{
  for (PetscInt a = 0; a < 2; a++) {
    const PetscReal period = scene->hi[a] - scene->lo[a];

    arm[a] = x[a] - body->centre[a];
    if (scene->periodic[a]) arm[a] -= period * PetscFloorReal(arm[a] / period + 0.5);
  }
}

/*
  BodyDistance - Distance from a body's surface, positive in the fluid [m]

  Not collective. Of a body in a periodic box the nearest image counts. Output: normal - of the surface at
  its point nearest to x, into the fluid.
*/
PetscReal BodyDistance(const Scene *scene, const Body *body, const PetscReal x[],
                       PetscReal normal[])
{
  PetscReal y[2], distance;

  BodyArm(scene, body, x, y);
  for (PetscInt a = 0; a < 2; a++) y[a] += body->centre[a];
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) normal[a] = 0.0;
  distance = body->shape->Distance(body, y, normal);
  if (!body->around) return distance;
  for (PetscInt a = 0; a < 2; a++) normal[a] = -normal[a];
  return -distance;
}

/* BodyPoints - How many points dx apart a body's surface has; not collective */
PetscInt BodyPoints(const Body *body, PetscReal dx)
{
  return body->shape->Count(body, dx);
}

/*
  BodyPoint - Point k of a surface

  Not collective. Output: x; normal - into the fluid. Returns: the length of surface it stands for [m].
*/
PetscReal BodyPoint(const Body *body, PetscInt k, PetscReal dx, PetscReal x[], PetscReal normal[])
{
  PetscReal length;

  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) normal[a] = 0.0;
  length = body->shape->Point(body, k, dx, x, normal);
  for (PetscInt a = 0; body->around && a < 2; a++) normal[a] = -normal[a];
  return length;
}

/* SceneDistance - Distance of x from the nearest body, and which; infinite without bodies [m] */
PetscReal SceneDistance(const Scene *scene, const PetscReal x[], PetscInt *nearest,
                        PetscReal normal[])
{
  PetscReal best = PETSC_INFINITY, n[ISPH_MAX_DIM];

  *nearest = -1;
  for (PetscInt k = 0; k < scene->n_bodies; k++) {
    const PetscReal distance = BodyDistance(scene, &scene->body_of[k], x, n);

    if (distance >= best) continue;
    best     = distance;
    *nearest = k;
    for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) normal[a] = n[a];
  }
  return best;
}
