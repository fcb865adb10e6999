/*
  Interfaces of fluids: distances from them at the start are those of the geometry, also where the
  border of a region ends at a wall, is covered by another region, or has periodic images. Planes
  from the distances of disordered particles are exact for straight interfaces, and of second order
  for curved ones; moving particles carry the interface with the fluid.
*/
/* RANKS: 1 2 */
#include <string.h>
#include "isph/start.h"
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

#define BORDER 4096 /* most points of `border` */

static PetscReal border[2 * BORDER]; /* points across which the fluid changes */
static PetscInt  n_border;

static void FindBorder(const Scene *scene)
{
  n_border = 0;
  for (PetscInt k = 0; k < scene->n_regions; k++) {
    const PetscInt points = BodyPoints(&scene->region[k], 1e-3);

    for (PetscInt q = 0; q < points; q++) {
      PetscReal y[ISPH_MAX_DIM] = {0.0}, n[ISPH_MAX_DIM], in[ISPH_MAX_DIM], out[ISPH_MAX_DIM];

      (void)BodyPoint(&scene->region[k], q, 1e-3, y, n);
      for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) {
        in[a]  = y[a] - 1e-6 * n[a];
        out[a] = y[a] + 1e-6 * n[a];
      }
      if (SceneFluidAt(scene, in) == SceneFluidAt(scene, out)) continue;
      assert_true(n_border < BORDER);
      for (PetscInt a = 0; a < 2; a++) border[2 * n_border + a] = y[a];
      n_border++;
    }
  }
}

/* Returns the distance from the nearest point of the border. */
static PetscReal ExactCovered(const PetscReal x[])
{
  PetscReal best = 1.0;

  for (PetscInt k = 0; k < n_border; k++)
    best = PetscMin(best, PetscSqr(border[2 * k] - x[0]) + PetscSqr(border[2 * k + 1] - x[1]));
  return PetscSqrtReal(best);
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
  FindBorder(&scene);
  CheckDistances(&scene, "disc on a square", 0.05 * scene.dx, ExactCovered);
}

/* As CloudAssertNone(), on this rank alone. */
static void AssertNone(const char *what, const char *where, PetscBool wrong)
{
  if (wrong) print_error("%s: %s: wrong\n", where, what);
  assert_false(wrong);
}

#define MOST 512 /* particles near a place */

/* Fills a scene with disordered particles, and finds the plane at random places up to `near` from
   the interface: gives the largest error of the offset, and of the fluid on each side. */
static void CheckPlanes(Scene *scene, const char *what, PetscReal near,
                        PetscReal (*Exact)(const PetscReal x[]), PetscReal *error)
{
  const WallPlacement walls = {0};
  Particles          *p;
  Cells               cells = {0};

  scene->jitter = 0.3;
  scene->seed   = 2;
  *error        = 0.0;
  assert_int_equal(ParticlesCreate(scene, 2.6 * scene->dx, &p), 0);
  assert_int_equal(ParticlesFill(scene, walls, NULL, p), 0);
  assert_int_equal(CellsBuild(p, 2.5 * scene->dx, &cells), 0);
  for (PetscInt k = 0; k < POINTS; k++) {
    PetscReal      x[ISPH_MAX_DIM] = {0.0};
    PetscInt       list[MOST], n;
    InterfacePlane plane;

    for (PetscInt a = 0; a < scene->dim; a++)
      x[a] = 0.5 * (scene->lo[a] + scene->hi[a]) +
             0.499 * (scene->hi[a] - scene->lo[a]) * ParticlesHash(1, k, a);
    if (!ParticlesHolds(p, x) || Exact(x) > near) continue;
    assert_int_equal(CellsFind(&cells, x, 2.5 * scene->dx, MOST, list, &n), 0);
    AssertNone("plane", what, (PetscBool)!InterfaceNear(p, x, n, list, &plane));
    AssertNone("fluid", what,
               Exact(x) > *error && plane.fluid[plane.offset < 0.0] != SceneFluidAt(scene, x));
    *error = PetscMax(*error, PetscAbsReal(PetscAbsReal(plane.offset) - Exact(x)));
  }
  assert_int_equal(MPI_Allreduce(MPI_IN_PLACE, error, 1, MPIU_REAL, MPIU_MAX, PETSC_COMM_WORLD), 0);
  assert_int_equal(CellsFree(&cells), 0);
  assert_int_equal(ParticlesDestroy(&p), 0);
}

static PetscReal ExactBand(const PetscReal x[])
{
  return PetscAbsReal(PetscAbsReal(0.8 * x[1] - 0.6 * x[0] - 0.1) - 0.025);
}

/* Adds a band of the thickness dx along the line of ExactSlope(). */
static void AddBand(Scene *scene)
{
  const PetscReal ends[] = {-1.0, -0.625 - 0.03125, 2.0,  1.625 - 0.03125,
                            2.0,  1.625 + 0.03125,  -1.0, -0.625 + 0.03125};

  AddPolygon(scene, 4, ends);
}

static PetscReal ExactBall(const PetscReal x[])
{
  PetscReal r2 = 0.0;

  for (PetscInt a = 0; a < 3; a++) r2 += PetscSqr(x[a] - 0.5);
  return PetscAbsReal(PetscSqrtReal(r2) - 0.25);
}

static PetscReal ExactCircle(const PetscReal x[])
{
  return PetscAbsReal(PetscSqrtReal(PetscSqr(x[0] - 0.5) + PetscSqr(x[1] - 0.5)) - 0.25);
}

/* In the middle of the band, where another interface is about as near, planes are not looked at. */
static void test_planes(void **state)
{
  const PetscReal slope[] = {-1.0, -0.625, 2.0, 1.625, 2.0, 4.0, -1.0, 4.0};
  Scene           scene;
  PetscReal       error;

  (void)state;
  MakeScene(PETSC_FALSE, &scene);
  AddPolygon(&scene, 4, slope);
  CheckPlanes(&scene, "slope", 1.25 * scene.dx, ExactSlope, &error);
  CloudAssertNone("exact", "slope", error > 1e-12);
  MakeScene(PETSC_FALSE, &scene);
  AddBand(&scene);
  CheckPlanes(&scene, "band", 0.45 * scene.dx, ExactBand, &error);
  CloudAssertNone("exact", "band", error > 1e-12);
}

/* Errors fall by at least 3 when the spacing is halved. */
static void test_curved(void **state)
{
  const PetscReal middle[] = {0.5, 0.5, 0.5};

  (void)state;
  for (PetscInt dim = 2; dim <= 3; dim++) {
    PetscReal error[2];

    for (PetscInt finer = 0; finer < 2; finer++) {
      Scene scene;

      MakeScene(PETSC_FALSE, &scene);
      scene.dim   = dim;
      scene.hi[2] = 1.0;
      for (PetscInt a = 0; a < dim; a++) scene.cells[a] = (dim == 2 ? 20 : 12) * (1 + finer);
      scene.dx = 1.0 / scene.cells[0];
      SceneSetSides(&scene, &BoundaryWall);
      BodyBall(&scene, middle, 0.25, &scene.region[scene.n_regions++]);
      CheckPlanes(&scene, dim == 2 ? "disc" : "ball", scene.dx, dim == 2 ? ExactCircle : ExactBall,
                  &error[finer]);
    }
    CloudAssertNone("order", dim == 2 ? "disc" : "ball", error[1] > error[0] / 3.0);
  }
}

/* Returns the distance of x from a disc about (0.5, 0.5) that a strain of 1 has sheared; periodic
   along x. */
static PetscReal ShearedDistance(const PetscReal x[])
{
  PetscReal best = PETSC_INFINITY;

  for (PetscInt k = 0; k < 2000; k++) {
    const PetscReal angle = 2.0 * PETSC_PI * k / 2000.0;
    const PetscReal y     = 0.5 + 0.25 * PetscSinReal(angle);
    PetscReal       d     = x[0] - (0.5 + 0.25 * PetscCosReal(angle) + y);

    d -= PetscFloorReal(d + 0.5);
    best = PetscMin(best, PetscSqr(d) + PetscSqr(x[1] - y));
  }
  return PetscSqrtReal(best);
}

/* Particles carry the interface through a shear: those within 1.5 dx err by 0.1 dx in the mean. */
static void test_shear(void **state)
{
  const WallPlacement walls  = {0};
  const PetscInt      steps  = 50;
  PetscReal           sum[2] = {0.0};
  Scene               scene;
  Particles          *p;
  Neighbors          *nb;

  (void)state;
  MakeScene(PETSC_TRUE, &scene);
  scene.dx       = 1.0 / 32.0;
  scene.cells[0] = scene.cells[1] = 32;
  BodyCircle(&scene, 0.5, 0.5, 0.25, &scene.region[scene.n_regions++]);
  assert_int_equal(ParticlesCreate(&scene, 2.6 * scene.dx, &p), 0);
  assert_int_equal(ParticlesFill(&scene, walls, NULL, p), 0);
  assert_int_equal(NeighborsCreate(2.6 * scene.dx, scene.dx, &nb), 0);
  for (PetscInt step = 0; step < steps; step++) {
    for (PetscInt i = 0; i < p->n_fluid; i++) p->x[0][i] += p->x[1][i] / steps;
    assert_int_equal(ParticlesUpdateEpoch(&scene, p, PETSC_TRUE, NULL), 0);
    assert_int_equal(NeighborsUpdate(p, 0.0, nb), 0);
    assert_int_equal(InterfacesFollow(p, nb), 0);
  }
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscReal x[ISPH_MAX_DIM] = {0.0};

    for (PetscInt a = 0; a < 2; a++)
      x[a] = p->x[a][i] - p->interface[i] * p->interface_normal[a][i];
    if (p->interface[i] > 1.5 * scene.dx) continue;
    sum[0] += PetscSqr(ShearedDistance(x) / scene.dx);
    sum[1] += 1.0;
  }
  assert_int_equal(MPI_Allreduce(MPI_IN_PLACE, sum, 2, MPIU_REAL, MPIU_SUM, PETSC_COMM_WORLD), 0);
  CloudAssertNone("number", "shear", sum[1] < 120.0);
  CloudAssertNone("place", "shear", PetscSqrtReal(sum[0] / sum[1]) > 0.1);
  assert_int_equal(NeighborsDestroy(&nb), 0);
  assert_int_equal(ParticlesDestroy(&p), 0);
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_straight), cmocka_unit_test(test_disc),
      cmocka_unit_test(test_covered),  cmocka_unit_test(test_planes),
      cmocka_unit_test(test_curved),   cmocka_unit_test(test_shear),
  };
  int failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
  return PetscFinalize() || failed ? 1 : 0;
}
