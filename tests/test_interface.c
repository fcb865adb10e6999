/*
  Interfaces of fluids: distances from them at the start are those of the geometry, also where the
  border of a region ends at a wall, is covered by another region, or has periodic images.
*/
/* RANKS: 1 */
#include <string.h>
#include "cloud.h"

#define POINTS 2000

/* Creates a unit square with walls, 20 particles along a side; it may be periodic along x. */
static void MakeScene(PetscBool periodic, Scene *scene)
{
  memset(scene, 0, sizeof(*scene));
  scene->dim   = 2;
  scene->dx    = 0.05;
  scene->hi[0] = scene->hi[1] = 1.0;
  scene->cells[0] = scene->cells[1] = 20;
  scene->physics                    = PHYSICS_WALLS;
  SceneSetSides(scene, &BoundaryWall);
  if (periodic) SceneSetAxis(scene, 0, &BoundaryPeriodic);
}

static void AddPolygon(Scene *scene, PetscInt corners, const PetscReal x[])
{
  assert_null(BodyPolygon(scene, corners, x, &scene->region[scene->n_regions++]));
}

/* Compares distances within 0.2 with those of `Exact`, at random places. */
static void CheckDistances(const Scene *scene, const char *what, PetscReal tolerance,
                           PetscReal (*Exact)(const PetscReal x[]))
{
  InterfacePoints points;

  assert_int_equal(InterfacePointsCreate(scene, &points), 0);
  for (PetscInt k = 0; k < POINTS; k++) {
    PetscReal x[ISPH_MAX_DIM] = {0.0}, y[ISPH_MAX_DIM] = {0.0}, normal[ISPH_MAX_DIM], d, step;

    for (PetscInt a = 0; a < 2; a++) x[a] = 0.5 + 0.499 * ParticlesHash(1, k, a);
    d = SceneInterface(scene, &points, x, 0.2, normal);
    CloudAssertNone("distance", what, PetscAbsReal(d - PetscMin(0.2, Exact(x))) > tolerance);
    if (d == 0.2) continue;
    step = 0.9 * d; /* towards the interface: the fluid stays, and so much nearer is it */
    for (PetscInt a = 0; a < 2; a++) y[a] = x[a] - step * normal[a];
    if (SceneSideDistance(scene, 0, y) < 0.0 || SceneSideDistance(scene, 1, y) < 0.0) continue;
    CloudAssertNone("normal", what, PetscAbsReal(Exact(y) - (d - step)) > tolerance);
    CloudAssertNone("fluid", what, SceneFluidAt(scene, x) != SceneFluidAt(scene, y));
  }
  assert_int_equal(InterfacePointsDestroy(&points), 0);
}

static PetscReal ExactLayer(const PetscReal x[])
{
  return PetscAbsReal(x[1] - 0.513);
}

static PetscReal ExactSlope(const PetscReal x[])
{
  return PetscAbsReal(0.8 * x[1] - 0.6 * x[0] - 0.1);
}

/* Straight interfaces end at walls: their distance is that from the line, and edges of regions on
   walls or beyond do not count. */
static void test_straight(void **state)
{
  const PetscReal layer[] = {0.0, 0.513, 1.0, 0.513, 1.0, 1.0, 0.0, 1.0};
  const PetscReal slope[] = {0.0, 0.125, 1.0, 0.875, 1.0, 1.0, 0.0, 1.0};
  Scene           scene;

  (void)state;
  for (PetscInt periodic = 0; periodic < 2; periodic++) {
    MakeScene((PetscBool)periodic, &scene);
    AddPolygon(&scene, 4, layer);
    CheckDistances(&scene, periodic ? "periodic layer" : "layer", 1e-12, ExactLayer);
  }
  MakeScene(PETSC_FALSE, &scene);
  AddPolygon(&scene, 4, slope);
  CheckDistances(&scene, "slope", 1e-12, ExactSlope);
}

static PetscReal ExactDisc(const PetscReal x[])
{
  PetscReal best = 1.0;

  for (PetscInt image = -1; image < 2; image++)
    best = PetscMin(
        best,
        PetscAbsReal(PetscSqrtReal(PetscSqr(x[0] - image - 0.1) + PetscSqr(x[1] - 0.5)) - 0.25));
  return best;
}

static void test_disc(void **state)
{
  Scene scene;

  (void)state;
  MakeScene(PETSC_TRUE, &scene);
  BodyCircle(&scene, 0.1, 0.5, 0.25, &scene.region[scene.n_regions++]);
  CheckDistances(&scene, "disc across a periodic side", 1e-12, ExactDisc);
}

static Scene *covered; /* scene of ExactCovered() */

/* Returns the distance from the nearest of many points across which the fluid changes. */
static PetscReal ExactCovered(const PetscReal x[])
{
  PetscReal best = 1.0;

  for (PetscInt k = 0; k < covered->n_regions; k++) {
    for (PetscInt q = 0; q < BodyPoints(&covered->region[k], 1e-3); q++) {
      PetscReal y[ISPH_MAX_DIM] = {0.0}, n[ISPH_MAX_DIM], in[ISPH_MAX_DIM], out[ISPH_MAX_DIM];
      PetscReal r2;

      (void)BodyPoint(&covered->region[k], q, 1e-3, y, n);
      r2 = PetscSqr(y[0] - x[0]) + PetscSqr(y[1] - x[1]);
      if (r2 >= best * best) continue;
      for (PetscInt a = 0; a < 2; a++) {
        in[a]  = y[a] - 1e-6 * n[a];
        out[a] = y[a] + 1e-6 * n[a];
      }
      if (SceneFluidAt(covered, in) != SceneFluidAt(covered, out)) best = PetscSqrtReal(r2);
    }
  }
  return best;
}

/* A disc covers a corner of a square; the interface ends where the fluid does not change. */
static void test_covered(void **state)
{
  const PetscReal square[] = {0.2, 0.2, 0.6, 0.2, 0.6, 0.6, 0.2, 0.6};
  Scene           scene;

  (void)state;
  MakeScene(PETSC_FALSE, &scene);
  AddPolygon(&scene, 4, square);
  BodyCircle(&scene, 0.6, 0.55, 0.12, &scene.region[scene.n_regions++]);
  covered = &scene;
  CheckDistances(&scene, "disc on a square", 0.05 * scene.dx, ExactCovered);
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_straight),
      cmocka_unit_test(test_disc),
      cmocka_unit_test(test_covered),
  };
  int failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  return PetscFinalize() || failed ? 1 : 0;
}
