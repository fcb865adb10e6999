/*
  The spacing of particles. It is uniform, or the cells of the lattice are smaller at walls: then
  the lattice is the product of a map along each axis, and the cells have unequal edges. The spacing
  of a particle is a mean of the edges of its cell, and its support is stretched along the axes as
  the cell is.
*/
#include "isph/scene.h"

#define GROWTH_MOST 0.25 /* largest growth of the edge from a cell to the next [-] */

static const OptionRow options[] = {
    {
        .name     = "-spacing_wall",
        .kind     = VALUE_REAL,
        .brief    = "spacing at walls; the lattice keeps its number of particles, and the spacing "
                    "grows smoothly from the walls to the middle",
        .unit     = "dx",
        .standard = "1",
        .low      = 0.05,
        .high     = 1.0,
        .where    = "flows of fixed particles between walls, without bodies",
    },
};
const OptionTable SpacingOptions = OPTIONS("Spacing", options);

/* SceneIsGraded - Returns true if cells of the lattice differ; not collective */
PetscBool SceneIsGraded(const Scene *scene)
{
  for (PetscInt a = 0; a < scene->dim; a++)
    if (scene->map[a].strength > 0.0) return PETSC_TRUE;
  return PETSC_FALSE;
}

/*
  Returns the place y in [0, 1] of a point s in [0, 1] of the uniform lattice

    y = (1 + tanh(beta (2 s - 1))/tanh beta)/2   between two walls
    y = 1 + tanh(beta (s - 1))/tanh beta         from a wall at the low end

  Reference: M. Vinokur, J. Comput. Phys. 50 (1983) 215-234
*/
static PetscReal MapForward(const LatticeMap *map, PetscReal s)
{
  const PetscReal beta = map->strength, end = PetscTanhReal(beta);

  if (map->wall[0] && map->wall[1]) return 0.5 + 0.5 * PetscTanhReal(beta * (2.0 * s - 1.0)) / end;
  return map->wall[0] ? 1.0 + PetscTanhReal(beta * (s - 1.0)) / end : PetscTanhReal(beta * s) / end;
}

/* Returns the slope dy/ds of MapForward(). */
static PetscReal MapSlope(const LatticeMap *map, PetscReal s)
{
  const PetscReal beta = map->strength;
  const PetscReal t = map->wall[0] && map->wall[1] ? 2.0 * s - 1.0 : (map->wall[0] ? s - 1.0 : s);

  return beta / (PetscTanhReal(beta) * PetscSqr(PetscCoshReal(beta * t)));
}

/* Returns the point s of the uniform lattice whose place is y; the inverse of MapForward(). */
static PetscReal MapBack(const LatticeMap *map, PetscReal y)
{
  const PetscReal beta = map->strength, end = PetscTanhReal(beta);

  if (map->wall[0] && map->wall[1]) return 0.5 + 0.5 * PetscAtanhReal((2.0 * y - 1.0) * end) / beta;
  return map->wall[0] ? 1.0 + PetscAtanhReal((y - 1.0) * end) / beta
                      : PetscAtanhReal(y * end) / beta;
}

/* Solves 2 beta/sinh(2 beta) = ratio, the slope of the map at a wall, by bisection. */
static PetscReal MapStrength(PetscReal ratio)
{
  PetscReal low = 0.0, high = 8.0; /* a ratio below 1e-5 */

  for (PetscInt k = 0; k < 60; k++) {
    const PetscReal beta = 0.5 * (low + high);

    if (2.0 * beta > ratio * PetscSinhReal(2.0 * beta)) low = beta;
    else high = beta;
  }
  return 0.5 * (low + high);
}

/* SceneLatticePlace - Returns the coordinate of a place on the lattice, given in cells from the low
   end of an axis [m]; not collective */
PetscReal SceneLatticePlace(const Scene *scene, PetscInt axis, PetscReal place)
{
  const LatticeMap *map = &scene->map[axis];

  if (map->strength == 0.0) return scene->lo[axis] + place * SceneCellSide(scene, axis);
  return scene->lo[axis] +
         (scene->hi[axis] - scene->lo[axis]) * MapForward(map, place / scene->cells[axis]);
}

/* SceneFromUniform - Returns the coordinate x of the point that has the coordinate y on the uniform
   lattice, and sets slope to dx/dy [m], [-]; not collective */
PetscReal SceneFromUniform(const Scene *scene, PetscInt axis, PetscReal y, PetscReal *slope)
{
  const LatticeMap *map    = &scene->map[axis];
  const PetscReal   length = scene->hi[axis] - scene->lo[axis], s = (y - scene->lo[axis]) / length;

  *slope = 1.0;
  if (map->strength == 0.0) return y;
  *slope = MapSlope(map, s);
  return scene->lo[axis] + length * MapForward(map, s);
}

/* SceneToUniform - Returns the coordinate on the uniform lattice of a point at x, or of the nearest
   end of the axis if x is outside the box, the inverse of SceneFromUniform() [m]; not collective */
PetscReal SceneToUniform(const Scene *scene, PetscInt axis, PetscReal x)
{
  const LatticeMap *map    = &scene->map[axis];
  const PetscReal   length = scene->hi[axis] - scene->lo[axis];

  if (map->strength == 0.0) return x;
  return scene->lo[axis] +
         length * MapBack(map, PetscMin(PetscMax((x - scene->lo[axis]) / length, 0.0), 1.0));
}

/* SceneCellSide - Returns the mean edge of the cells of the lattice along an axis [m]; it equals dx
   if the length of the box is a multiple of dx */
PetscReal SceneCellSide(const Scene *scene, PetscInt axis)
{
  return (scene->hi[axis] - scene->lo[axis]) / scene->cells[axis];
}

/* SceneEdges - Computes the edges of a cell of the lattice that is centred at x, or that is nearest
   to x in the half of a cell beside a side of the box [m]; not collective */
void SceneEdges(const Scene *scene, const PetscReal x[], PetscReal edge[])
{
  for (PetscInt a = 0; a < scene->dim; a++) {
    const LatticeMap *map    = &scene->map[a];
    const PetscReal   length = scene->hi[a] - scene->lo[a], half = 0.5 / scene->cells[a];
    PetscReal         s = (x[a] - scene->lo[a]) / length;

    edge[a] = SceneCellSide(scene, a);
    if (map->strength == 0.0) continue;
    s       = MapBack(map, PetscMin(PetscMax(s, 0.0), 1.0));
    s       = PetscMin(PetscMax(s, half), 1.0 - half);
    edge[a] = length * (MapForward(map, s + half) - MapForward(map, s - half));
  }
}

/*
  SceneSpacing - Returns the spacing that particles created at x have [m]

    dim/dx_i^2 = sum_a 1/e_a^2,   e_a: edges of the cell at x

  A particle keeps the spacing of the place of its creation (Particles.dx). Options and
  dimensionless numbers refer to the reference spacing scene->dx instead.
*/
PetscReal SceneSpacing(const Scene *scene, const PetscReal x[])
{
  PetscReal edge[ISPH_MAX_DIM], sum = 0.0;

  if (!SceneIsGraded(scene)) return scene->dx;
  SceneEdges(scene, x, edge);
  for (PetscInt a = 0; a < scene->dim; a++) sum += 1.0 / PetscSqr(edge[a]);
  return PetscSqrtReal(scene->dim / sum);
}

/*
  SceneStretch - Computes the factors that stretch the cell at x to a cube with the edge
  SceneSpacing(), docs/theory.md, (139) [-]

  Not collective. All are 1 on a uniform lattice.
*/
void SceneStretch(const Scene *scene, const PetscReal x[], PetscReal stretch[])
{
  const PetscReal dx = SceneSpacing(scene, x);
  PetscReal       edge[ISPH_MAX_DIM];

  SceneEdges(scene, x, edge);
  for (PetscInt a = 0; a < scene->dim; a++) stretch[a] = SceneIsGraded(scene) ? dx / edge[a] : 1.0;
}

/* BodySpacing - Returns the spacing of points on the surface of a body, SceneSpacing() at its
   centre [m] */
PetscReal BodySpacing(const Scene *scene, const Body *body)
{
  const PetscReal x[ISPH_MAX_DIM] = {body->centre[0], body->centre[1]};

  return SceneSpacing(scene, x);
}

/* SceneCoarsest - Returns the largest edge of a cell anywhere, which bounds supports [m] */
PetscReal SceneCoarsest(const Scene *scene)
{
  PetscReal most = 0.0;

  if (!SceneIsGraded(scene)) return scene->dx;
  for (PetscInt a = 0; a < scene->dim; a++) most = PetscMax(most, scene->map[a].most);
  return most;
}

/* SceneFinest - Returns the smallest edge of a cell anywhere, which bounds time steps [m] */
PetscReal SceneFinest(const Scene *scene)
{
  PetscReal least = PETSC_MAX_REAL;

  if (!SceneIsGraded(scene)) return scene->dx;
  for (PetscInt a = 0; a < scene->dim; a++) least = PetscMin(least, scene->map[a].least);
  return least;
}

/* SceneTolerance - Returns the reference length of geometric tolerances [m] */
PetscReal SceneTolerance(const Scene *scene)
{
  return SceneFinest(scene);
}

/* SceneVolume - Returns the volume of a lattice cell of the reference spacing [m^dim] */
PetscReal SceneVolume(const Scene *scene)
{
  PetscReal volume = 1.0;

  for (PetscInt a = 0; a < scene->dim; a++) volume *= SceneCellSide(scene, a);
  return volume;
}

/* SceneVolumeAt - Returns the volume of a particle that is created at x, the product of the edges
   of its cell [m^dim] */
PetscReal SceneVolumeAt(const Scene *scene, const PetscReal x[])
{
  PetscReal edge[ISPH_MAX_DIM], volume = 1.0;

  SceneEdges(scene, x, edge);
  for (PetscInt a = 0; a < scene->dim; a++) volume *= edge[a];
  return volume;
}

/* SceneGrowth - Returns the largest growth of the edges of the lattice from a cell to the next [-];
   not collective */
PetscReal SceneGrowth(const Scene *scene)
{
  PetscReal growth = 0.0;

  for (PetscInt a = 0; a < scene->dim; a++) {
    const LatticeMap *map   = &scene->map[a];
    const PetscReal   sides = map->wall[0] && map->wall[1] ? 4.0 : 2.0;

    growth =
        PetscMax(growth, sides * map->strength * PetscTanhReal(map->strength) / scene->cells[a]);
  }
  return growth;
}

/* Sets the map of an axis; sides that are walls with no slip have smaller cells. */
static void SetMap(Scene *scene, PetscInt axis)
{
  LatticeMap     *map = &scene->map[axis];
  const PetscReal n   = scene->cells[axis];
  PetscReal       first, middle;

  map->least = map->most = SceneCellSide(scene, axis);
  for (PetscInt end = 0; end < 2; end++)
    map->wall[end] = BoundaryIs(scene, 2 * axis + end, BOUNDARY_NO_SLIP);
  if (!map->wall[0] && !map->wall[1]) return;
  map->strength = MapStrength(scene->spacing_wall);
  first         = map->wall[0] ? 1.0 : n;
  middle = map->wall[0] && map->wall[1] ? PetscFloorReal(0.5 * n + 0.5) : (map->wall[0] ? n : 1.0);
  map->least = SceneLatticePlace(scene, axis, first) - SceneLatticePlace(scene, axis, first - 1.0);
  map->most = SceneLatticePlace(scene, axis, middle) - SceneLatticePlace(scene, axis, middle - 1.0);
}

/* Refuses scenes that need a uniform lattice. */
static PetscErrorCode RefuseGraded(const Scene *scene)
{
  const char     *why = NULL;
  const PetscReal R   = scene->spacing_wall;
  PetscBool       given;

  PetscFunctionBegin;
  PetscCall(OptionGiven("-particles", &given));
  if (SceneMoves(scene)) why = "particles that move keep no graded lattice; use -motion eulerian";
  else if (scene->n_bodies) why = "bodies need a uniform lattice; use 1";
  else if (SceneViscosityVaries(scene))
    why = "a viscosity that varies needs a uniform lattice; use 1";
  else if (given)
    why = "it belongs to a lattice, and -particles gives other places; use one of them";
  else if (!SceneHasBoundary(scene, BOUNDARY_NO_SLIP)) why = "this scene has no walls; use 1";
  UserCheck(!why, "-spacing_wall %.6g: %s", (double)R, why);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  SceneReadSpacing - Reads the spacing at walls and sets the map of the lattice along each axis

  Collective. Boundaries and cells of the scene are known. Output: scene->spacing_wall, scene->map.

  Options Database Key:
. -spacing_wall R - spacing at walls [dx]

  Errors: scenes that need a uniform lattice, and cells that grow too fast, end the run
*/
PetscErrorCode SceneReadSpacing(Scene *scene)
{
  PetscFunctionBegin;
  scene->spacing_wall = 1.0;
  if (scene->problem->patch) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(OptionGetReal(&options[0], &scene->spacing_wall, NULL));
  if (scene->spacing_wall == 1.0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(RefuseGraded(scene));
  for (PetscInt a = 0; a < scene->dim; a++) SetMap(scene, a);
  UserCheck(
      SceneGrowth(scene) <= GROWTH_MOST,
      "-spacing_wall %.6g: with -n %" PetscInt_FMT " the spacing grows by %.2g %% from a "
      "particle to the next, and at most %.2g %% is allowed; use a larger -n or -spacing_wall",
      (double)scene->spacing_wall, scene->n, (double)(100.0 * SceneGrowth(scene)),
      100.0 * GROWTH_MOST);
  PetscFunctionReturn(PETSC_SUCCESS);
}
