/*
  Shapes of bodies in 2D and 3D. Compares distances with the distance from the nearest of many
  surface points, normals with gradients of the distance, and lengths or areas with the perimeter or
  the surface; surface points must have the distance zero. Prisms reach through a box of height 1.
*/
/* RANKS: 1 */
#include "cloud.h"

static const struct {
  PetscInt    dim;
  const char *shape;
  PetscInt    n;
  PetscReal   number[12], surface;
} samples[] = {
    {2, "circle", 3, {0.1, -0.2, 0.7}, 1.4 * PETSC_PI},
    {2, "box", 4, {-0.5, -0.25, 0.75, 0.5}, 4.0},
    {2, "box", 4, {0.75, 0.5, -0.5, -0.25}, 4.0},
    {2, "polygon", 6, {0.0, 0.0, 3.0, 0.0, 0.0, 4.0}, 12.0},
    {2, "polygon", 6, {0.0, 4.0, 3.0, 0.0, 0.0, 0.0}, 12.0}, /* clockwise */
    {2, "polygon", 12, {0.0, 0.0, 2.0, 0.0, 2.0, 1.0, 1.0, 1.0, 1.0, 2.0, 0.0, 2.0}, 8.0}, /* L */
    {3, "ball", 4, {0.1, -0.2, 0.05, 0.4}, 0.64 * PETSC_PI},
    {3, "box", 6, {0.75, -0.25, 0.3, -0.5, 0.5, -0.2}, 2.0 * (1.25 * 0.75 + 1.25 * 0.5 + 0.375)},
    {3, "cylinder", 3, {0.1, -0.2, 0.7}, 1.4 * PETSC_PI},
    {3, "prism", 6, {0.0, 0.0, 0.6, 0.0, 0.0, 0.8}, 2.4},
    /* a pipe, a cone from the point 0 with a base on the axis, and a cone with the base below */
    {3,
     "revolved",
     8,
     {0.2, -0.3, 0.6, -0.3, 0.6, 0.1, 0.2, 0.1},
     0.64 * PETSC_PI + 0.64 * PETSC_PI},
    {3, "revolved", 6, {0.0, 0.0, 0.3, 0.4, 0.0, 0.4}, 0.24 * PETSC_PI},
    {3, "revolved", 6, {0.3, -0.4, 0.0, 0.0, 0.0, -0.4}, 0.24 * PETSC_PI},
};

/* Returns the spacing of points with which a test of a sample is quick. */
static PetscReal Fine(size_t k)
{
  return samples[k].dim == 2 ? 0.005 : 0.02;
}

static void Make(size_t k, PetscBool around, Scene *scene, Body *body)
{
  const ShapeRow *row;

  ASSERT_OK(PetscMemzero(scene, sizeof(*scene)));
  scene->dim   = samples[k].dim;
  scene->lo[2] = scene->dim == 3 ? -0.4 : 0.0;
  scene->hi[2] = scene->dim == 3 ? 0.6 : 0.0;
  SceneSetSides(scene, &BoundaryWall);
  ASSERT_OK(TableWant(scene->dim == 3 ? &SolidTable : &ShapeTable, "test", samples[k].shape, &row));
  assert_null(BodySet(scene, row, samples[k].n, samples[k].number, body));
  body->around = around;
}

static void test_surface(void **state)
{
  (void)state;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(samples); k++) {
    const PetscReal dx  = Fine(k);
    PetscReal       sum = 0.0;
    Scene           scene;
    Body            body;

    Make(k, PETSC_FALSE, &scene, &body);
    for (PetscInt q = 0; q < BodyPoints(&body, dx); q++) {
      PetscReal x[ISPH_MAX_DIM], normal[ISPH_MAX_DIM], out[ISPH_MAX_DIM], found[ISPH_MAX_DIM];

      sum += BodyPoint(&body, q, dx, x, normal);
      CloudAssertNone("on the surface", samples[k].shape,
                      PetscAbsReal(BodyDistance(&scene, &body, x, found)) > 1e-12);
      for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) out[a] = x[a] + 1e-3 * normal[a];
      CloudAssertNone("normal outward", samples[k].shape,
                      PetscAbsReal(BodyDistance(&scene, &body, out, found) - 1e-3) > 1e-9);
    }
    CloudAssertNone("perimeter or area", samples[k].shape,
                    PetscAbsReal(sum / samples[k].surface - 1.0) > 1e-9);
  }
}

/* BodySpan() contains all surface points and exceeds them by at most dx. */
static void test_span(void **state)
{
  (void)state;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(samples); k++) {
    const PetscReal dx                = Fine(k);
    PetscReal       low[ISPH_MAX_DIM] = {PETSC_MAX_REAL, PETSC_MAX_REAL, PETSC_MAX_REAL},
              high[ISPH_MAX_DIM]      = {-PETSC_MAX_REAL, -PETSC_MAX_REAL, -PETSC_MAX_REAL};
    Scene scene;
    Body  body;

    Make(k, PETSC_FALSE, &scene, &body);
    for (PetscInt q = 0; q < BodyPoints(&body, dx); q++) {
      PetscReal x[ISPH_MAX_DIM], normal[ISPH_MAX_DIM];

      (void)BodyPoint(&body, q, dx, x, normal);
      for (PetscInt a = 0; a < scene.dim; a++) {
        low[a]  = PetscMin(low[a], x[a]);
        high[a] = PetscMax(high[a], x[a]);
      }
    }
    for (PetscInt a = 0; a < scene.dim; a++) {
      PetscReal span[2];

      BodySpan(&body, a, span);
      CloudAssertNone("span", samples[k].shape,
                      span[0] > low[a] + 1e-12 || span[1] < high[a] - 1e-12 ||
                          span[0] < low[a] - dx || span[1] > high[a] + dx);
    }
  }
}

/* A plate, a small circle and a sharp wedge are thin; a thick box and a wide wedge are not. */
static void test_thickness(void **state)
{
  const struct {
    const char *shape;
    PetscInt    n;
    PetscReal   number[6], low, high;
  } bodies[] = {
      {"box", 4, {0.0, 0.0, 1.0, 0.0123}, 0.0123 - 1e-12, 0.0123 + 1e-12},
      {"box", 4, {0.0, 0.0, 1.0, 0.25}, 0.2, 0.2},
      {"circle", 3, {0.0, 0.0, 0.07}, 0.14 - 1e-12, 0.14 + 1e-12},
      {"polygon", 6, {0.0, 0.0, 1.0, 0.0, 0.0, 0.3}, 0.0, 0.04}, /* 17 degrees */
      {"polygon", 6, {0.0, 0.0, 1.0, 0.0, 0.5, 0.8}, 0.2, 0.2},  /* 58 and 64 degrees */
  };

  Scene scene = {.dim = 2};

  (void)state;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(bodies); k++) {
    const ShapeRow *row;
    Body            body;
    PetscReal       place[ISPH_MAX_DIM], thin;

    ASSERT_OK(TableWant(&ShapeTable, "test", bodies[k].shape, &row));
    assert_null(BodySet(&scene, row, bodies[k].n, bodies[k].number, &body));
    thin = BodyThickness(&body, 0.05, 0.2, place);
    CloudAssertNone("thickness", bodies[k].shape, thin < bodies[k].low || thin > bodies[k].high);
    body.around = PETSC_TRUE;
    assert_true(BodyThickness(&body, 0.05, 0.2, place) == 0.2);
  }
}

/* Returns the distance of x from the nearest of all surface points. */
static PetscReal Nearest(const Body *body, PetscReal dx, const PetscReal x[])
{
  PetscReal best = PETSC_MAX_REAL;

  for (PetscInt q = 0; q < BodyPoints(body, dx); q++) {
    PetscReal y[ISPH_MAX_DIM], normal[ISPH_MAX_DIM];

    (void)BodyPoint(body, q, dx, y, normal);
    best = PetscMin(best, PetscSqr(x[0] - y[0]) + PetscSqr(x[1] - y[1]) + PetscSqr(x[2] - y[2]));
  }
  return PetscSqrtReal(best);
}

static void test_distance(void **state)
{
  (void)state;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(samples); k++) {
    for (PetscInt around = 0; around < 2; around++) {
      const PetscReal dx = Fine(k), step = 1e-6;
      Scene           scene;
      Body            body;

      Make(k, around ? PETSC_TRUE : PETSC_FALSE, &scene, &body);
      for (PetscInt q = 0; q < 60; q++) {
        PetscReal x[ISPH_MAX_DIM] = {0.0}, n[ISPH_MAX_DIM], m[ISPH_MAX_DIM], d;

        for (PetscInt a = 0; a < scene.dim; a++)
          x[a] = body.centre[a] + 1.6 * body.extent * ParticlesHash(5, q, a);
        if (BodyReachesThrough(&body, 2)) x[2] = 0.1 + 0.4 * ParticlesHash(5, q, 2);
        d = BodyDistance(&scene, &body, x, n);
        CloudAssertNone("distance", samples[k].shape,
                        PetscAbsReal(PetscAbsReal(d) - Nearest(&body, dx, x)) > 0.8 * dx);
        for (PetscInt a = 0; a < scene.dim; a++) x[a] += step * n[a];
        CloudAssertNone("normal is the distance's gradient", samples[k].shape,
                        PetscAbsReal(BodyDistance(&scene, &body, x, m) - d - step) > 1e-3 * step);
      }
    }
  }
}

/* In a periodic box the distance is the distance from the nearest image, also for a drop whose
   centroid is far from its tip, and along z for a ball. */
static void CheckImages(PetscInt dim, const char *shape, PetscInt numbers, const PetscReal number[])
{
  const Table    *table = dim == 3 ? &SolidTable : &ShapeTable;
  const ShapeRow *row;
  Scene           plain, periodic;
  Body            body;

  ASSERT_OK(PetscMemzero(&plain, sizeof(plain)));
  plain.dim = dim;
  for (PetscInt a = 0; a < dim; a++) plain.hi[a] = 1.0;
  SceneSetSides(&plain, &BoundaryWall);
  periodic                   = plain;
  periodic.boundary          = NULL;
  periodic.boundary_capacity = 0;
  SceneSetSides(&periodic, &BoundaryPeriodic);
  ASSERT_OK(TableWant(table, "test", shape, &row));
  assert_null(BodySet(&plain, row, numbers, number, &body));
  for (PetscInt q = 0; q < 200; q++) {
    PetscReal x[ISPH_MAX_DIM] = {0.0}, least = PETSC_INFINITY, d, n[ISPH_MAX_DIM];

    for (PetscInt a = 0; a < dim; a++) x[a] = 0.5 + 0.5 * ParticlesHash(5, q, a);
    for (PetscInt image = 0; image < (dim == 3 ? 27 : 9); image++) {
      const PetscReal y[ISPH_MAX_DIM] = {x[0] + image % 3 - 1, x[1] + image / 3 % 3 - 1,
                                         x[2] + (dim == 3 ? image / 9 - 1 : 0)};

      least = PetscMin(least, BodyDistance(&plain, &body, y, n));
    }
    d = BodyDistance(&periodic, &body, x, n);
    CloudAssertNone("image", shape, PetscAbsReal(d - least) > 1e-12);
  }
}

static void test_images(void **state)
{
  const PetscReal drop[8] = {0.1, 0.4, 0.85, 0.5, 0.1, 0.6, 0.05, 0.5};
  const PetscReal ball[4] = {0.2, 0.5, 0.9, 0.3};

  (void)state;
  CheckImages(2, "polygon", 8, drop);
  CheckImages(3, "prism", 8, drop);
  CheckImages(3, "ball", 4, ball);
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_surface), cmocka_unit_test(test_span), cmocka_unit_test(test_thickness),
      cmocka_unit_test(test_distance), cmocka_unit_test(test_images)};
  int failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  return PetscFinalize() || failed ? 1 : 0;
}
