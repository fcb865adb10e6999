/* Wall particles of scenes whose spacing is a function of place, or whose fluid does not fill the
   box. On a curve, a side of the box or a body in 2D, each particle has the same share of the
   number of particles int dl/s. */
#include "start.h"

#define FINE 64.0 /* points along the smallest spacing, among which particles are chosen */

/* A curve of walls in 2D: a side of the box, or the surface of a body. */
typedef struct {
  const Scene *scene;
  const Body  *body; /* NULL: side of the box */
  PetscInt     side, points;
  PetscReal    step; /* between points [m] */
} Curve;

static void CurveSet(const Scene *scene, PetscInt side, Curve *curve)
{
  const PetscInt a = 1 - side / 2; /* along a side of the box */

  *curve      = (Curve){.scene = scene, .body = BoundaryBody(scene, side), .side = side};
  curve->step = SceneFinest(scene) / FINE;
  if (curve->body) {
    curve->points = BodyPoints(curve->body, curve->step);
  } else {
    curve->points = (PetscInt)PetscCeilReal((scene->hi[a] - scene->lo[a]) / curve->step);
    curve->step   = (scene->hi[a] - scene->lo[a]) / curve->points;
  }
}

/* Computes point k of a curve and the normal; returns the length that the point represents [m]. */
static PetscReal CurvePoint(const Curve *curve, PetscInt k, PetscReal x[], PetscReal normal[])
{
  const Scene   *scene = curve->scene;
  const PetscInt a     = 1 - curve->side / 2;
  PetscReal      length;

  for (PetscInt b = 0; b < ISPH_MAX_DIM; b++) normal[b] = x[b] = 0.0;
  if (curve->body) return BodyPoint(curve->body, k, curve->step, x, normal);
  length        = curve->step;
  x[a]          = scene->lo[a] + (k + 0.5) * length;
  x[1 - a]      = curve->side % 2 ? scene->hi[1 - a] : scene->lo[1 - a];
  normal[1 - a] = curve->side % 2 ? -1.0 : 1.0;
  return length;
}

/* Returns the integral of dl/s along a curve. */
static PetscReal CurveNumber(const Curve *curve)
{
  PetscReal sum = 0.0, x[ISPH_MAX_DIM], normal[ISPH_MAX_DIM];

  for (PetscInt k = 0; k < curve->points; k++) {
    const PetscReal length = CurvePoint(curve, k, x, normal);

    sum += length / SceneSpacing(curve->scene, x);
  }
  return sum;
}

/* Adds a particle to this rank's share. */
static PetscErrorCode Add(PetscInt side, PetscInt index, const PetscReal x[],
                          const PetscReal normal[], Surfaces *s)
{
  PetscFunctionBegin;
  if (s->n == s->capacity) {
    s->capacity = 2 * s->capacity + 64;
    PetscCall(PetscRealloc(sizeof(*s->point) * (size_t)s->capacity, &s->point));
  }
  s->point[s->n] = (SurfacePoint){.side = side, .index = index};
  PetscCall(PetscArraycpy(s->point[s->n].x, x, ISPH_MAX_DIM));
  PetscCall(PetscArraycpy(s->point[s->n].normal, normal, ISPH_MAX_DIM));
  s->n++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds this rank's share of the particles of a curve. */
static PetscErrorCode AddCurve(const Scene *scene, PetscInt side, Surfaces *s)
{
  PetscReal number, sum = 0.0;
  PetscInt  n, m        = 0, first, last;
  Curve     curve;

  PetscFunctionBegin;
  CurveSet(scene, side, &curve);
  number = CurveNumber(&curve);
  n      = PetscMax(1, (PetscInt)PetscFloorReal(number + 0.5));
  ParticlesShare(PETSC_COMM_WORLD, n, &first, &last);
  for (PetscInt k = 0; k < curve.points && m < n; k++) {
    PetscReal x[ISPH_MAX_DIM], normal[ISPH_MAX_DIM], part;

    part = CurvePoint(&curve, k, x, normal) / SceneSpacing(scene, x);
    sum += part;
    if (sum < (m + 0.5) * number / n) continue;
    if (!curve.body) /* at the place where the sum has its value */
      x[1 - side / 2] += curve.step * (0.5 - (sum - (m + 0.5) * number / n) / part);
    if (m >= first && m < last) PetscCall(Add(side, s->N + m, x, normal, s));
    m++;
  }
  s->N += m;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds this rank's share of the particles of a side of the box in 3D: a lattice if the spacing is
   the same everywhere on it. */
static PetscErrorCode AddPlane(const Scene *scene, PetscInt side, Surfaces *s)
{
  const PetscReal even                 = scene->grading.on ? scene->grading.even[side] : scene->dx;
  PetscReal       normal[ISPH_MAX_DIM] = {0.0};
  PetscInt        count[2];
  Region          region;
  Places          places = {0};

  PetscFunctionBegin;
  normal[side / 2] = side % 2 ? -1.0 : 1.0;
  RegionSetSide(scene, side, &region);
  for (PetscInt m = 0; m < 2 && even > 0.0; m++)
    count[m] =
        PetscMax(1, (PetscInt)PetscFloorReal(
                        (scene->hi[region.axis[m]] - scene->lo[region.axis[m]]) / even + 0.5));
  if (even > 0.0) {
    PetscCall(SceneCountCells(2, count, &places.N));
    ParticlesShare(PETSC_COMM_WORLD, places.N, &places.first, &places.n);
    places.n -= places.first;
  } else {
    PetscCall(PlacesCreate(scene, &region, NULL, &places));
  }
  for (PetscInt k = 0; k < places.n; k++) {
    PetscReal x[ISPH_MAX_DIM];

    PetscCall(PetscArraycpy(x, region.x, ISPH_MAX_DIM));
    for (PetscInt m = 0; m < 2; m++) {
      const PetscInt a = region.axis[m], index = places.first + k;

      if (even > 0.0)
        x[a] = scene->lo[a] + (scene->hi[a] - scene->lo[a]) *
                                  ((m ? index / count[0] : index % count[0]) + 0.5) / count[m];
      else x[a] = places.x[k * 2 + m];
    }
    PetscCall(Add(side, s->N + places.first + k, x, normal, s));
  }
  s->N += places.N;
  PetscCall(PlacesDestroy(&places));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds this rank's share of the particles on a body in 3D, at the points of its surface. */
static PetscErrorCode AddBody(const Scene *scene, PetscInt side, Surfaces *s)
{
  const Body     *body = BoundaryBody(scene, side);
  const PetscReal dx   = BodySpacing(scene, body);
  const PetscInt  n    = BodyPoints(body, dx);
  PetscInt        first, last;

  PetscFunctionBegin;
  ParticlesShare(PETSC_COMM_WORLD, n, &first, &last);
  for (PetscInt k = first; k < last; k++) {
    PetscReal x[ISPH_MAX_DIM], normal[ISPH_MAX_DIM];

    (void)BodyPoint(body, k, dx, x, normal);
    PetscCall(Add(side, s->N + k, x, normal, s));
  }
  s->N += n;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SurfacesCreate - Creates the wall particles on all sides of the box and on all bodies. Collective
   on PETSC_COMM_WORLD. Output: s - this rank's share; free with SurfacesDestroy(). */
PetscErrorCode SurfacesCreate(const Scene *scene, Surfaces *s)
{
  PetscFunctionBegin;
  PetscCall(PetscMemzero(s, sizeof(*s)));
  for (PetscInt side = 0; side < SceneBoundaries(scene); side++) {
    if (!BoundaryIs(scene, side, BOUNDARY_PARTICLES)) continue;
    if (scene->dim == 2) PetscCall(AddCurve(scene, side, s));
    else if (BoundaryBody(scene, side)) PetscCall(AddBody(scene, side, s));
    else PetscCall(AddPlane(scene, side, s));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SurfacesDestroy - Frees the share */
PetscErrorCode SurfacesDestroy(Surfaces *s)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(s->point));
  PetscFunctionReturn(PETSC_SUCCESS);
}
