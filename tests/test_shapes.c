/*
  Shapes of bodies. Compares distances with the distance from the nearest of many surface points,
  normals with gradients of the distance, and lengths with the perimeter; surface points must have
  the distance zero.
*/
/* RANKS: 1 */
#include "cloud.h"

static const struct {
  const char *shape;
  PetscInt    n;
  PetscReal   number[12], perimeter;
} samples[] = {
    {"circle", 3, {0.1, -0.2, 0.7}, 1.4 * PETSC_PI},
    {"box", 4, {-0.5, -0.25, 0.75, 0.5}, 4.0},
    {"box", 4, {0.75, 0.5, -0.5, -0.25}, 4.0},
    {"polygon", 6, {0.0, 0.0, 3.0, 0.0, 0.0, 4.0}, 12.0},
    {"polygon", 6, {0.0, 4.0, 3.0, 0.0, 0.0, 0.0}, 12.0}, /* clockwise */
    {"polygon", 12, {0.0, 0.0, 2.0, 0.0, 2.0, 1.0, 1.0, 1.0, 1.0, 2.0, 0.0, 2.0}, 8.0}, /* an L */
};

static void Make(size_t k, PetscBool around, Scene *scene, Body *body)
{
  const ShapeRow *row;

  ASSERT_OK(PetscMemzero(scene, sizeof(*scene)));
  scene->dim = 2;
  SceneSetSides(scene, &BoundaryWall);
  ASSERT_OK(TableWant(&ShapeTable, "test", samples[k].shape, &row));
  assert_null(BodySet(body, row, samples[k].n, samples[k].number));
  body->around = around;
}

static void test_surface(void **state)
{
  (void)state;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(samples); k++) {
    const PetscReal dx  = 0.01;
    PetscReal       sum = 0.0;
    Scene           scene;
    Body            body;

    Make(k, PETSC_FALSE, &scene, &body);
    for (PetscInt q = 0; q < BodyPoints(&body, dx); q++) {
      PetscReal x[ISPH_MAX_DIM], normal[ISPH_MAX_DIM], out[ISPH_MAX_DIM], found[ISPH_MAX_DIM];

      sum += BodyPoint(&body, q, dx, x, normal);
      CloudAssertNone("on the surface", samples[k].shape,
                      PetscAbsReal(BodyDistance(&scene, &body, x, found)) > 1e-12);
      for (PetscInt a = 0; a < 2; a++) out[a] = x[a] + 1e-3 * normal[a];
      CloudAssertNone("normal outward", samples[k].shape,
                      PetscAbsReal(BodyDistance(&scene, &body, out, found) - 1e-3) > 1e-9);
    }
    CloudAssertNone("perimeter", samples[k].shape,
                    PetscAbsReal(sum / samples[k].perimeter - 1.0) > 1e-9);
  }
}

/* BodySpan() contains all surface points and exceeds them by at most dx. */
static void test_span(void **state)
{
  (void)state;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(samples); k++) {
    const PetscReal dx     = 0.001;
    PetscReal       low[2] = {PETSC_MAX_REAL, PETSC_MAX_REAL},
              high[2]      = {-PETSC_MAX_REAL, -PETSC_MAX_REAL};
    Scene scene;
    Body  body;

    Make(k, PETSC_FALSE, &scene, &body);
    for (PetscInt q = 0; q < BodyPoints(&body, dx); q++) {
      PetscReal x[ISPH_MAX_DIM], normal[ISPH_MAX_DIM];

      (void)BodyPoint(&body, q, dx, x, normal);
      for (PetscInt a = 0; a < 2; a++) {
        low[a]  = PetscMin(low[a], x[a]);
        high[a] = PetscMax(high[a], x[a]);
      }
    }
    for (PetscInt a = 0; a < 2; a++) {
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

  (void)state;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(bodies); k++) {
    const ShapeRow *row;
    Body            body;
    PetscReal       place[2], thin;

    ASSERT_OK(TableWant(&ShapeTable, "test", bodies[k].shape, &row));
    assert_null(BodySet(&body, row, bodies[k].n, bodies[k].number));
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
    best = PetscMin(best, PetscSqr(x[0] - y[0]) + PetscSqr(x[1] - y[1]));
  }
  return PetscSqrtReal(best);
}

static void test_distance(void **state)
{
  (void)state;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(samples); k++) {
    for (PetscInt around = 0; around < 2; around++) {
      const PetscReal dx = 0.005, step = 1e-6;
      Scene           scene;
      Body            body;

      Make(k, around ? PETSC_TRUE : PETSC_FALSE, &scene, &body);
      for (PetscInt q = 0; q < 60; q++) {
        PetscReal x[2], n[ISPH_MAX_DIM], m[ISPH_MAX_DIM], d;

        for (PetscInt a = 0; a < 2; a++)
          x[a] = body.centre[a] + 1.6 * body.extent * ParticlesHash(5, q, a);
        d = BodyDistance(&scene, &body, x, n);
        CloudAssertNone("distance", samples[k].shape,
                        PetscAbsReal(PetscAbsReal(d) - Nearest(&body, dx, x)) > 0.6 * dx);
        for (PetscInt a = 0; a < 2; a++) x[a] += step * n[a];
        CloudAssertNone("normal is the distance's gradient", samples[k].shape,
                        PetscAbsReal(BodyDistance(&scene, &body, x, m) - d - step) > 1e-3 * step);
      }
    }
  }
}

/* In a periodic box the distance is the distance from the nearest image, also for a drop whose
   centroid is far from its tip. */
static void test_images(void **state)
{
  const PetscReal drop[8] = {0.1, 0.4, 0.85, 0.5, 0.1, 0.6, 0.05, 0.5};
  const ShapeRow *row;
  Scene           plain, periodic;
  Body            body;

  (void)state;
  ASSERT_OK(PetscMemzero(&plain, sizeof(plain)));
  plain.dim   = 2;
  plain.hi[0] = plain.hi[1] = 1.0;
  SceneSetSides(&plain, &BoundaryWall);
  periodic = plain;
  SceneSetSides(&periodic, &BoundaryPeriodic);
  ASSERT_OK(TableWant(&ShapeTable, "test", "polygon", &row));
  assert_null(BodySet(&body, row, 8, drop));
  for (PetscInt q = 0; q < 200; q++) {
    PetscReal x[2], least = PETSC_INFINITY, d, n[ISPH_MAX_DIM];

    for (PetscInt a = 0; a < 2; a++) x[a] = 0.5 + 0.5 * ParticlesHash(5, q, a);
    for (PetscInt image = 0; image < 9; image++) {
      const PetscReal y[2] = {x[0] + image % 3 - 1, x[1] + image / 3 - 1};

      least = PetscMin(least, BodyDistance(&plain, &body, y, n));
    }
    d = BodyDistance(&periodic, &body, x, n);
    CloudAssertNone("image", "polygon", PetscAbsReal(d - least) > 1e-12);
  }
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
