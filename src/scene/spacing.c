/* The spacing of particles. It is uniform; or the cells of the lattice are smaller at walls, and
   have unequal edges; or it is a function of place for particles that are not on a lattice (both:
   grading.c). On a lattice with unequal edges, the spacing of a particle is a mean of the edges of
   its cell, and its support is stretched along the axes as the cell is. */
#include "isph/scene.h"

#define GROWTH_MOST   0.25 /* largest growth of the spacing from a particle to the next [-] */
#define SPACING_LEAST 0.05 /* bounds of -spacing [dx] */
#define SPACING_MOST  4.0
#define OUTLINE_MOST  1e7 /* largest length of an outline [smallest spacing] */

enum { SPACING, WALL, GROWTH };
static const OptionRow options[] = {
    [SPACING] = OPTION(
        EXPRESSION, "-spacing",
        "spacing as an expression of x, y, z; the particles then are not on a lattice, and -n sets "
        "dx only",
        "dx", "1", .where = "flows of fixed particles; of moving particles in boxes without walls"),
    [WALL]   = OPTION(REAL, "-spacing_wall",
                      "spacing at walls; without -spacing_growth the lattice keeps its number of "
                        "particles, and the spacing grows smoothly from the walls to the middle",
                      "dx", "1", .low = 0.05, .high = 1.0,
                      .where = "flows between walls; with bodies, -spacing_growth too; of moving "
                                 "particles in -scheme projection with -pressure_points coarse"),
    [GROWTH] = OPTION(REAL, "-spacing_growth",
                      "growth of the spacing from a particle to the next, from -spacing_wall at "
                      "walls and bodies up to dx; the particles then are not on a lattice",
                      "-", "a lattice", .low = 0.01, .high = GROWTH_MOST,
                      .where = "-spacing_wall in flows of fixed particles"),
};
const OptionTable SpacingOptions = OPTIONS("Spacing", options);

/* SceneIsGraded - Returns true if particles differ in size */
PetscBool SceneIsGraded(const Scene *scene)
{
  return scene->grading.on || SceneIsMapped(scene);
}

/* SceneMovesGraded - Returns true if particles move and have a spacing that depends on place */
PetscBool SceneMovesGraded(const Scene *scene)
{
  return SceneMoves(scene) && SceneIsGraded(scene);
}

/* Returns the spacing that belongs to the edges of a cell. */
static PetscReal SpacingOfEdges(PetscInt dim, const PetscReal edge[])
{
  PetscReal sum = 0.0;

  for (PetscInt a = 0; a < dim; a++) sum += 1.0 / PetscSqr(edge[a]);
  return PetscSqrtReal(dim / sum);
}

/*
  SceneSpacing - Returns the spacing that particles created at x have [m]

    dim/dx_i^2 = sum_a 1/e_a^2,   e_a: edges of the cell at x

  or GradingSpacing() for particles that are not on a lattice. A particle has the spacing of the
  place of its creation (Particles.dx), or of its present place if it moves. Options and
  dimensionless numbers refer to the reference spacing scene->dx instead.
*/
PetscReal SceneSpacing(const Scene *scene, const PetscReal x[])
{
  PetscReal edge[ISPH_MAX_DIM];

  if (scene->grading.on) return GradingSpacing(scene, x);
  if (!SceneIsMapped(scene)) return scene->dx;
  SceneEdges(scene, x, edge);
  return SpacingOfEdges(scene->dim, edge);
}

/* SceneStretch - Computes the factors that stretch the cell at x to a cube with the edge
   SceneSpacing(), theory.md, (particles:cells) [-]. All are 1 on a uniform lattice and with
   isotropic grading. */
void SceneStretch(const Scene *scene, const PetscReal x[], PetscReal stretch[])
{
  PetscReal edge[ISPH_MAX_DIM], dx;

  for (PetscInt a = 0; a < scene->dim; a++) stretch[a] = 1.0;
  if (!SceneIsMapped(scene)) return;
  SceneEdges(scene, x, edge);
  dx = SpacingOfEdges(scene->dim, edge);
  for (PetscInt a = 0; a < scene->dim; a++) stretch[a] = dx / edge[a];
}

/* SceneSizes - Computes SceneSpacing(), SceneStretch() and SceneVolumeAt() of a graded particle at
   x [m], [-], [m^dim] */
void SceneSizes(const Scene *scene, const PetscReal x[], PetscReal *dx, PetscReal stretch[],
                PetscReal *volume)
{
  PetscReal edge[ISPH_MAX_DIM];

  SceneEdges(scene, x, edge);
  *dx     = scene->grading.on ? GradingSpacing(scene, x) : SpacingOfEdges(scene->dim, edge);
  *volume = 1.0;
  for (PetscInt a = 0; a < scene->dim; a++) {
    stretch[a] = scene->grading.on ? 1.0 : *dx / edge[a];
    *volume *= scene->grading.on ? edge[a] * (*dx / scene->dx) : edge[a];
  }
}

/* BodySpacing - Returns the spacing of points for sums over the surface of a body: SceneSpacing()
   at its centre, or the smallest one of isotropic grading [m] */
PetscReal BodySpacing(const Scene *scene, const Body *body)
{
  return scene->grading.on ? scene->grading.least : SceneSpacing(scene, body->centre);
}

/* SceneCoarsest - Returns the largest spacing or edge of a cell, which bounds supports [m] */
PetscReal SceneCoarsest(const Scene *scene)
{
  PetscReal most = 0.0;

  if (scene->grading.on) return scene->grading.most;
  if (!SceneIsMapped(scene)) return scene->dx;
  for (PetscInt a = 0; a < scene->dim; a++) most = PetscMax(most, scene->map[a].most);
  return most;
}

/* SceneFinest - Returns the smallest spacing or edge of a cell anywhere, which bounds time steps
   [m] */
PetscReal SceneFinest(const Scene *scene)
{
  PetscReal least = PETSC_MAX_REAL;

  if (scene->grading.on) return scene->grading.least;
  if (!SceneIsMapped(scene)) return scene->dx;
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
   of its cell; with isotropic grading up to a common factor near 1 [m^dim] */
PetscReal SceneVolumeAt(const Scene *scene, const PetscReal x[])
{
  PetscReal edge[ISPH_MAX_DIM], volume = 1.0;

  SceneEdges(scene, x, edge);
  for (PetscInt a = 0; a < scene->dim; a++)
    volume *= scene->grading.on ? edge[a] * (GradingSpacing(scene, x) / scene->dx) : edge[a];
  return volume;
}

/*
  SceneMotionFactor - Returns the factor m of the velocity of particles at x, w = m u [-]

    m = V(x)/V_m,   V: SceneVolumeAt(), V_m: Scene.motion_volume

  It is 1 if the spacing is uniform. See theory.md, (motion:graded).
*/
PetscReal SceneMotionFactor(const Scene *scene, const PetscReal x[])
{
  return SceneIsGraded(scene) ? SceneVolumeAt(scene, x) / scene->motion_volume : 1.0;
}

/* SceneGrowth - Returns the largest growth of the spacing from a particle to the next [-] */
PetscReal SceneGrowth(const Scene *scene)
{
  return scene->grading.on ? scene->grading.growth_most : LatticeGrowth(scene);
}

/* Returns the reason why a scene has no graded lattice; NULL if there is none. */
static const char *LatticeFault(const Scene *scene)
{
  if (SceneHasFreeSurface(scene)) return "a free surface needs a uniform spacing; use 1";
  if (scene->n_bodies) return "bodies need a uniform lattice or -spacing_growth";
  if (SceneViscosityVaries(scene)) return "a viscosity that varies needs a uniform lattice; use 1";
  if (!SceneHasBoundary(scene, BOUNDARY_NO_SLIP)) return "this scene has no walls; use 1";
  return NULL;
}

/* Returns the reason why a scene has no isotropic grading; NULL if there is none. */
static const char *GradingFault(const Scene *scene)
{
  if (SceneHasFreeSurface(scene)) return "a free surface needs a uniform spacing";
  if (SceneMoves(scene) && SceneHasBoundary(scene, BOUNDARY_NO_SLIP))
    return "particles that move between walls keep the spacing of lattices only; use -spacing_wall "
           "alone, or -motion eulerian";
  if (SceneViscosityVaries(scene)) return "a viscosity that varies needs a uniform spacing";
  if (scene->n_bodies && scene->dim == 3) return "bodies in 3D need a uniform spacing";
  if (scene->jitter > 0.0) return "-jitter displaces a lattice, and there is none";
  if (scene->grading.growth > 0.0 && !SceneHasBoundary(scene, BOUNDARY_NO_SLIP))
    return "this scene has no walls";
  return NULL;
}

/* Reads -spacing_wall alone: a lattice whose cells are smaller at walls. */
static PetscErrorCode ReadLattice(Scene *scene)
{
  const char *const fault = LatticeFault(scene);
  PetscBool         given;

  PetscFunctionBegin;
  PetscCall(OptionGiven("-particles", &given));
  UserCheck(!fault, "-spacing_wall %.6g: %s", (double)scene->spacing_wall, fault);
  UserCheck(!given,
            "-spacing_wall %.6g: it belongs to a lattice, and -particles gives other places; use "
            "one of them",
            (double)scene->spacing_wall);
  scene->motion_volume = 1.0;
  for (PetscInt a = 0; a < scene->dim; a++) {
    LatticeSetMap(scene, a);
    scene->motion_volume *= LatticeMotionEdge(scene, a);
  }
  UserCheck(
      SceneGrowth(scene) <= GROWTH_MOST,
      "-spacing_wall %.6g: with -n %" PetscInt_FMT " the spacing grows by %.2g %% from a "
      "particle to the next, and at most %.2g %% is allowed; use a larger -n or -spacing_wall",
      (double)scene->spacing_wall, scene->n, (double)(100.0 * SceneGrowth(scene)),
      100.0 * GROWTH_MOST);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses outlines, of the box or of a body, that are too long for wall particles to be placed. */
static PetscErrorCode CheckOutlines(const Scene *scene)
{
  const PetscReal least = scene->grading.least;

  PetscFunctionBegin;
  for (PetscInt side = 0; side < SceneBoundaries(scene); side++) {
    const Body     *body = BoundaryBody(scene, side);
    const PetscReal length =
        body ? BodyPoints(body, scene->dx) * scene->dx : scene->hi[side / 2] - scene->lo[side / 2];

    UserCheck(length / least <= OUTLINE_MOST,
              "%s: an outline is %.2g times as long as the smallest spacing, at most %.2g is "
              "allowed; use a larger spacing or a smaller -n",
              options[scene->grading.spacing.n ? SPACING : WALL].name, (double)(length / least),
              OUTLINE_MOST);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the bounds of isotropic grading and checks them. */
static PetscErrorCode ReadGrading(Scene *scene)
{
  Grading          *g     = &scene->grading;
  const char *const fault = GradingFault(scene);
  const char *const name  = options[g->spacing.n ? SPACING : GROWTH].name;

  PetscFunctionBegin;
  UserCheck(!fault, "%s: %s", name, fault);
  PetscCall(OptionsRefuseTogether(name, "-particles", "both give the places of particles"));
  PetscCall(GradingSample(scene));
  PetscCall(ExpressionScopeCheck(scene->scope));
  UserCheck(g->least >= SPACING_LEAST * scene->dx && g->most <= SPACING_MOST * scene->dx,
            "-spacing: it is between %.3g and %.3g dx, and %.3g to %.3g is allowed; use another "
            "-n for the unit dx",
            (double)(g->least / scene->dx), (double)(g->most / scene->dx), SPACING_LEAST,
            SPACING_MOST);
  UserCheck(g->growth_most <= GROWTH_MOST * (1.0 + 1e-6),
            "%s: with -n %" PetscInt_FMT " the spacing grows by %.2g %% from a particle to the "
            "next, and at most %.2g %% is allowed; use a larger -n or smaller differences",
            name, scene->n, (double)(100.0 * g->growth_most), 100.0 * GROWTH_MOST);
  PetscCall(CheckOutlines(scene));
  g->on = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SceneReadSpacing - Reads the spacing and sets the map of the lattice along each axis, or the
   isotropic grading; collective. Boundaries and cells of the scene are known. Output:
   scene->spacing_wall, scene->map, scene->grading. */
PetscErrorCode SceneReadSpacing(Scene *scene)
{
  Grading  *g = &scene->grading;
  PetscBool given, grows;

  PetscFunctionBegin;
  scene->spacing_wall = 1.0;
  if (scene->problem->patch) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(OptionGetReal(&options[WALL], &scene->spacing_wall, NULL));
  PetscCall(OptionGiven(options[SPACING].name, &given));
  PetscCall(OptionGiven(options[GROWTH].name, &grows));
  if (given) {
    PetscCall(SceneNameConstants(scene));
    PetscCall(
        ExpressionGet(scene->scope, &options[SPACING], 1, 1, EXPRESSION_PLACE, &g->spacing, NULL));
  }
  UserCheck(scene->spacing_wall < 1.0 || !grows,
            "-spacing_growth: it is the growth from -spacing_wall, which must be given below 1");
  UserCheck(!given || grows || scene->spacing_wall == 1.0,
            "-spacing_wall %.6g: a lattice has no -spacing; give -spacing_growth too, or leave one "
            "of them out",
            (double)scene->spacing_wall);
  if (grows) PetscCall(OptionGetReal(&options[GROWTH], &g->growth, NULL));
  if (given || grows) PetscCall(ReadGrading(scene));
  else if (scene->spacing_wall < 1.0) PetscCall(ReadLattice(scene));
  PetscFunctionReturn(PETSC_SUCCESS);
}
