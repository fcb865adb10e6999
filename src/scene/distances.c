/* Distances of places from the boundaries of the scene: the nearest boundary, tangent planes, the
   least distance of particles from walls, and the parts of surfaces that are buried in others. */
#include "isph/scene.h"

#define SAME_WAY 0.999 /* cosine of the angle between normals of two surfaces in a place */

/* SceneDistance - Returns the distance of x from the surface of the nearest body, positive in the
   fluid [m]. Output: nearest - number of this body, -1 if there is none (then the distance is
   infinite); normal - into the fluid, at the surface point nearest to x. */
PetscReal SceneDistance(const Scene *scene, const PetscReal x[], PetscInt *nearest,
                        PetscReal normal[])
{
  PetscReal best = PETSC_INFINITY, n[ISPH_MAX_DIM];

  *nearest = -1;
  for (PetscInt k = 0; k < scene->n_bodies; k++) {
    const PetscReal distance = BodyDistanceWithin(scene, SceneBody(scene, k), x, best, n);

    if (distance >= best) continue;
    best     = distance;
    *nearest = k;
    for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) normal[a] = n[a];
  }
  return best;
}

/* SceneSideDistance - Returns the distance of x from a side of the box, positive in the box [m] */
PetscReal SceneSideDistance(const Scene *scene, PetscInt side, const PetscReal x[])
{
  const PetscInt a = side / 2;

  return side % 2 ? scene->hi[a] - x[a] : x[a] - scene->lo[a];
}

/* Returns the number of samples of a side along an axis: more than two for each particle. */
static PetscInt SamplesAlong(const Scene *scene, PetscInt side, PetscInt axis)
{
  const PetscReal least = scene->dim == 2 ? 1000.0 : 100.0;

  if (axis == side / 2) return 1;
  return (PetscInt)PetscMin(
      PetscMax(least, PetscCeilReal(2.0 * (scene->hi[axis] - scene->lo[axis]) / scene->dx)),
      4.0 * least);
}

/* SideSamples - Returns the number of points of SideSample() */
PetscInt SideSamples(const Scene *scene, PetscInt side)
{
  PetscInt n = 1;

  for (PetscInt a = 0; a < scene->dim; a++) n *= SamplesAlong(scene, side, a);
  return n;
}

/* SideSample - Computes point k of a lattice on a side of the box [m]; returns the area, or length,
   that it represents [m^(dim-1)] */
PetscReal SideSample(const Scene *scene, PetscInt side, PetscInt k, PetscReal x[])
{
  PetscReal area = 1.0;

  for (PetscInt a = 0; a < scene->dim; a++) {
    const PetscInt  n    = SamplesAlong(scene, side, a);
    const PetscReal step = (scene->hi[a] - scene->lo[a]) / n;

    x[a] = side % 2 ? scene->hi[a] : scene->lo[a];
    if (a == side / 2) continue;
    x[a] = scene->lo[a] + (k % n + 0.5) * step;
    area *= step;
    k /= n;
  }
  return area;
}

/* SideEntering - Returns the component of u into the box through a side */
PetscReal SideEntering(PetscInt side, const PetscReal u[])
{
  return side % 2 ? -u[side / 2] : u[side / 2];
}

/* SceneDistanceTo - Returns the distance of x from the nearest boundary with all the given
   properties, positive in the fluid [m]. Output: side - number of this boundary, -1 if there is
   none (then the distance is infinite). For a point on a surface the distance is zero within
   SCENE_ON_SURFACE dx. */
PetscReal SceneDistanceTo(const Scene *scene, unsigned properties, const PetscReal x[],
                          PetscInt *side)
{
  PetscReal best = PETSC_INFINITY, normal[ISPH_MAX_DIM];

  *side = -1;
  for (PetscInt s = 0; s < SceneBoundaries(scene); s++) {
    const Body *body = BoundaryBody(scene, s);
    PetscReal   distance;

    if (!BoundaryIs(scene, s, properties)) continue;
    if (body) distance = BodyDistanceWithin(scene, body, x, best, normal);
    else distance = SceneSideDistance(scene, s, x);
    if (distance >= best) continue;
    best  = distance;
    *side = s;
  }
  return best;
}

/* SceneFluidDistance - Returns SceneDistanceTo() boundaries with particles [m] */
PetscReal SceneFluidDistance(const Scene *scene, const PetscReal x[], PetscInt *side)
{
  return SceneDistanceTo(scene, BOUNDARY_PARTICLES, x, side);
}

/* Adds a plane, in the place of the farthest one if there is no room. */
static void AddPlane(const WallPlane *plane, WallPlane planes[WALL_PLANES], PetscInt *count)
{
  PetscInt place = *count;

  if (*count < WALL_PLANES) {
    (*count)++;
  } else {
    place = 0;
    for (PetscInt k = 1; k < WALL_PLANES; k++)
      if (planes[k].distance > planes[place].distance) place = k;
    if (plane->distance >= planes[place].distance) return;
  }
  planes[place] = *plane;
}

/* Sets the plane of a boundary within reach of x; returns false if it is farther. */
static PetscBool PlaneOf(const Scene *scene, PetscInt side, const PetscReal x[], PetscReal reach,
                         WallPlane *plane)
{
  const Body *body = BoundaryBody(scene, side);

  *plane = (WallPlane){.side = side};
  if (body) {
    plane->distance = BodyDistanceWithin(scene, body, x, reach, plane->normal);
  } else {
    plane->distance         = SceneSideDistance(scene, side, x);
    plane->normal[side / 2] = side % 2 ? -1.0 : 1.0;
  }
  return plane->distance < reach;
}

/* SceneWallPlanes - Finds the tangent planes of all boundaries with wall particles near x. Used for
   mirror images, for the minimum distance from walls, and for the extrapolation of wall velocities,
   which depend on geometry instead of particles. Input: x - a point [m]; reach - largest distance
   from x [m]. Output: planes - a plane for each boundary within reach, of the WALL_PLANES nearest
   ones if there are more; count - their number. */
void SceneWallPlanes(const Scene *scene, const PetscReal x[], PetscReal reach,
                     WallPlane planes[WALL_PLANES], PetscInt *count)
{
  *count = 0;
  if (!SceneHas(scene, PHYSICS_WALLS)) return;
  for (PetscInt side = 0; side < SceneBoundaries(scene); side++) {
    WallPlane plane;

    if (!BoundaryIs(scene, side, BOUNDARY_PARTICLES)) continue;
    if (PlaneOf(scene, side, x, reach, &plane)) AddPlane(&plane, planes, count);
  }
}

/* SceneKeepOffWalls - Moves a position that is less than `least` [m] from a boundary with wall
   particles, or behind it, to this distance, except where fluid leaves at time t */
void SceneKeepOffWalls(const Scene *scene, PetscReal t, PetscReal least, PetscReal x[])
{
  WallPlane planes[WALL_PLANES];
  PetscInt  n;

  SceneWallPlanes(scene, x, least, planes, &n);
  for (PetscInt k = 0; k < n; k++) {
    if (BoundaryLetsOut(scene, planes[k].side, t, x)) continue;
    for (PetscInt a = 0; a < scene->dim; a++)
      x[a] += (least - planes[k].distance) * planes[k].normal[a];
  }
}

/* SceneBuries - Returns true if a point of the surface of a boundary is in the solid of another
   one, or on its surface: where both have one normal the first one keeps the point. Sides without
   wall particles bury nothing. */
PetscBool SceneBuries(const Scene *scene, PetscInt other, PetscInt boundary, const PetscReal x[])
{
  const PetscReal slack = SCENE_ON_SURFACE * scene->dx;
  PetscReal       along = 0.0;
  WallPlane       own, plane;

  if (other == boundary || !BoundaryIs(scene, other, BOUNDARY_PARTICLES)) return PETSC_FALSE;
  if (!BoundaryBody(scene, boundary) && !BoundaryBody(scene, other)) return PETSC_FALSE;
  if (!PlaneOf(scene, other, x, slack, &plane)) return PETSC_FALSE;
  if (plane.distance < -slack || other < boundary) return PETSC_TRUE;
  (void)PlaneOf(scene, boundary, x, PETSC_INFINITY, &own);
  for (PetscInt a = 0; a < scene->dim; a++) along += own.normal[a] * plane.normal[a];
  return along < SAME_WAY;
}

/* SceneIsBuried - Returns true if any boundary buries a point of the surface of a boundary, which
   is then no wall for the fluid */
PetscBool SceneIsBuried(const Scene *scene, PetscInt boundary, const PetscReal x[])
{
  for (PetscInt other = 0; other < SceneBoundaries(scene); other++)
    if (SceneBuries(scene, other, boundary, x)) return PETSC_TRUE;
  return PETSC_FALSE;
}
