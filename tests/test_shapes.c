/*
  Shapes of bodies in 2D and 3D. Compares distances with the distance from the nearest of many
  surface points, normals with gradients of the distance, and lengths or areas with the perimeter or
  the surface; surface points must have the distance zero. Prisms reach through a box of height 1.
*/
/* RANKS: 1 */
#include "cloud.h"
#include <string.h>

static const struct {
  PetscInt    dim;
  const char *shape;
  PetscReal   surface, volume; /* per height of a prism */
  PetscReal   close;           /* relative errors of both */
  PetscBool   bound;           /* the distance is a lower bound beside edges */
} samples[] = {
    {2, "circle,0.1,-0.2,0.7", 1.4 * PETSC_PI, 0.49 * PETSC_PI, 1e-7, PETSC_FALSE},
    {2, "box,-0.5,-0.25,0.75,0.5", 4.0, 0.9375, 1e-9, PETSC_FALSE},
    {2, "box,0.75,0.5,-0.5,-0.25", 4.0, 0.9375, 1e-9, PETSC_FALSE},
    {2, "polygon,0,0,3,0,0,4", 12.0, 6.0, 1e-9, PETSC_FALSE},
    {2, "polygon,0,4,3,0,0,0", 12.0, 6.0, 1e-9, PETSC_FALSE},            /* clockwise */
    {2, "polygon,0,0,2,0,2,1,1,1,1,2,0,2", 8.0, 3.0, 1e-9, PETSC_FALSE}, /* L */
    {2, "ellipse,0.1,-0.2,0.8,0.3,30", 3.636686278316855, 0.24 * PETSC_PI, 1e-6, PETSC_FALSE},
    {2, "ellipse,0,0,0.1,1", 4.063974180100896, 0.1 * PETSC_PI, 1e-3, PETSC_FALSE},
    {2, "capsule,-0.3,-0.1,0.3,0.7,0.25", 2.0 + 0.5 * PETSC_PI, 0.5 + 0.0625 * PETSC_PI, 1e-6,
     PETSC_FALSE},
    /* compounds: a T whose parts share a line, a box with a round end, a ring, a lens, a bite */
    {2, "box,0,0,1,0.2 + box,0.4,0,0.6,1", 4.0, 0.36, 1e-9, PETSC_FALSE},
    {2, "box,0,0,1,0.2 + circle,1,0.1,0.1", 2.2 + 0.1 * PETSC_PI, 0.2 + 0.005 * PETSC_PI, 1e-6,
     PETSC_FALSE},
    {2, "circle,0,0,1 - circle,0,0,0.5", 3.0 * PETSC_PI, 0.75 * PETSC_PI, 1e-6, PETSC_FALSE},
    {2, "circle,0,0,1 & circle,1,0,1", 4.0 / 3.0 * PETSC_PI, 1.2283696986087567, 1e-6, PETSC_FALSE},
    {2, "box,-1,-1,1,1 - ellipse,1,0,0.5,0.25", 7.5 + 1.2110560275684595, 4.0 - PETSC_PI / 16.0,
     1e-6, PETSC_FALSE},
    {3, "ball,0.1,-0.2,0.05,0.4", 0.64 * PETSC_PI, 0.256 / 3.0 * PETSC_PI, 1e-4, PETSC_FALSE},
    {3, "box,0.75,-0.25,0.3,-0.5,0.5,-0.2", 2.0 * (1.25 * 0.75 + 1.25 * 0.5 + 0.375), 0.46875, 1e-9,
     PETSC_FALSE},
    {3, "cylinder,0.1,-0.2,0.7", 1.4 * PETSC_PI, 0.49 * PETSC_PI, 1e-7, PETSC_FALSE},
    {3, "prism,0,0,0.6,0,0,0.8", 2.4, 0.24, 1e-9, PETSC_FALSE},
    /* a pipe, a cone from the point 0 with a base on the axis, and a cone with the base below */
    {3, "revolved,0.2,-0.3,0.6,-0.3,0.6,0.1,0.2,0.1", 1.28 * PETSC_PI, 0.128 * PETSC_PI, 1e-4,
     PETSC_FALSE},
    {3, "revolved,0,0,0.3,0.4,0,0.4", 0.24 * PETSC_PI, 0.012 * PETSC_PI, 1e-3, PETSC_FALSE},
    {3, "revolved,0.3,-0.4,0,0,0,-0.4", 0.24 * PETSC_PI, 0.012 * PETSC_PI, 1e-3, PETSC_FALSE},
    {3, "ellipsoid,0.1,0,0,0.5,0.3,0.2", 1.347751767249036, 0.04 * PETSC_PI, 1e-3, PETSC_FALSE},
    {3, "capsule,-0.1,0.1,0,0.2,0.5,0,0.25", 0.5 * PETSC_PI, 0.03125 * PETSC_PI + PETSC_PI / 48.0,
     1e-4, PETSC_FALSE},
    {3, "cylinder,-0.1,0.1,0,0.2,0.5,0,0.25", 0.375 * PETSC_PI, 0.03125 * PETSC_PI, 1e-4,
     PETSC_FALSE},
    {3, "cone,0,0,0,0,0,0.4,0.4,0.1", 0.42 * PETSC_PI, 0.028 * PETSC_PI, 1e-4, PETSC_FALSE},
    {3, "cone,0,0,0,0,0.4,0,0.3,0", 0.24 * PETSC_PI, 0.012 * PETSC_PI, 1e-3, PETSC_FALSE},
    {3, "cylinder,0,0,0.5 - cylinder,0.2,0,0.1", 1.2 * PETSC_PI, 0.24 * PETSC_PI, 1e-6,
     PETSC_FALSE},
    {3, "box,-0.5,-0.5,-0.5,0.5,0.5,0.5 + ball,0.5,0,0,0.3", 6.0 + 0.09 * PETSC_PI,
     1.0 + 0.018 * PETSC_PI, 5e-3, PETSC_TRUE},
    {3, "box,-0.5,-0.5,-0.5,0.5,0.5,0.5 & ball,0.5,0,0,0.3", 0.27 * PETSC_PI, 0.018 * PETSC_PI,
     1e-2, PETSC_TRUE},
    {3, "box,-0.5,-0.5,-0.5,0.5,0.5,0.5 - cylinder,0,0,-1,0,0,1,0.2", 6.0 + 0.32 * PETSC_PI,
     1.0 - 0.04 * PETSC_PI, 5e-3, PETSC_TRUE},
};

/* Returns the spacing of points with which a test of a sample is quick. */
static PetscReal Fine(size_t k)
{
  return samples[k].dim == 2 ? 0.005 : 0.02;
}

/* Reads a shape as the option of a body does. */
static void ReadBody(const char text[], Scene *scene, Body *body)
{
  const OptionRow row = {.name = "-scene_body_<k>", .table = &ShapeTable, .table_3d = &SolidTable};
  PetscBool       given;

  ASSERT_OK(PetscOptionsSetValue(NULL, "-scene_body_1", text));
  ASSERT_OK(ShapeRead(scene, &row, 1, 0, body, &given));
  assert_true(given);
}

static struct {
  Scene scene;
  Body  body;
} made[PETSC_STATIC_ARRAY_LENGTH(samples)];

/* Makes all samples once: moments and points of solids take most of the time of these tests. */
static int MakeAll(void **state)
{
  (void)state;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(samples); k++) {
    Scene *scene = &made[k].scene;

    scene->dim   = samples[k].dim;
    scene->dx    = Fine(k);
    scene->lo[2] = scene->dim == 3 ? -0.4 : 0.0;
    scene->hi[2] = scene->dim == 3 ? 0.6 : 0.0;
    SceneSetSides(scene, &BoundaryWall);
    ReadBody(samples[k].shape, scene, &made[k].body);
  }
  return 0;
}

static int FreeAllShapes(void **state)
{
  (void)state;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(samples); k++)
    ASSERT_OK(SceneFreeShapes(&made[k].scene));
  return 0;
}

static void test_surface(void **state)
{
  (void)state;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(samples); k++) {
    const Scene    *scene  = &made[k].scene;
    const Body     *body   = &made[k].body;
    const PetscReal dx     = Fine(k);
    const PetscInt  points = BodyPoints(body, dx);
    PetscReal       sum    = 0.0;

    for (PetscInt q = 0; q < points; q++) {
      PetscReal x[ISPH_MAX_DIM], normal[ISPH_MAX_DIM], out[ISPH_MAX_DIM], found[ISPH_MAX_DIM];

      sum += BodyPoint(body, q, dx, x, normal);
      CloudAssertNone("on the surface", samples[k].shape,
                      PetscAbsReal(BodyDistance(scene, body, x, found)) > 1e-12);
      for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) out[a] = x[a] + 1e-3 * normal[a];
      CloudAssertNone("normal outward", samples[k].shape,
                      PetscAbsReal(BodyDistance(scene, body, out, found) - 1e-3) > 1e-9);
    }
    CloudAssertNone("perimeter or area", samples[k].shape,
                    PetscAbsReal(sum / samples[k].surface - 1.0) > samples[k].close);
  }
}

/* Volumes by the divergence theorem; the centroid; and second moments, of a turned ellipse and of
   an ellipsoid, in the axes of which they are m a^2/4 and m a^2/5. */
static void test_moments(void **state)
{
  BodyMoments m;

  (void)state;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(samples); k++) {
    const Body *body = &made[k].body;

    BodyFindMoments(body, &m);
    CloudAssertNone("volume", samples[k].shape,
                    PetscAbsReal(m.volume / samples[k].volume - 1.0) > samples[k].close);
    for (PetscInt a = 0; a < 2 && !body->shape->round; a++)
      CloudAssertNone("centroid", samples[k].shape,
                      PetscAbsReal(m.centroid[a] - body->centre[a]) > samples[k].close);
    if (k == 6) {
      const PetscReal c = 0.75, s = 0.25, big = 0.24 * PETSC_PI * 0.16,
                      small = 0.0225 * 0.24 * PETSC_PI;

      assert_true(PetscAbsReal(m.second[0][0] / (c * big + s * small) - 1.0) < 1e-5);
      assert_true(PetscAbsReal(m.second[0][1] / (PetscSqrtReal(3.0) / 4.0 * (big - small)) - 1.0) <
                  1e-5);
    }
    if (!strncmp(samples[k].shape, "ellipsoid", 9))
      for (PetscInt a = 0; a < 3; a++)
        assert_true(
            PetscAbsReal(m.second[a][a] * 5.0 / m.volume / PetscSqr(body->parameter[3 + a]) - 1.0) <
            1e-3);
  }
}

/* BodySpan() contains all surface points and exceeds them by at most dx. */
static void test_span(void **state)
{
  (void)state;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(samples); k++) {
    const Body     *body              = &made[k].body;
    const PetscReal dx                = Fine(k);
    const PetscInt  points            = BodyPoints(body, dx);
    PetscReal       low[ISPH_MAX_DIM] = {PETSC_MAX_REAL, PETSC_MAX_REAL, PETSC_MAX_REAL},
              high[ISPH_MAX_DIM]      = {-PETSC_MAX_REAL, -PETSC_MAX_REAL, -PETSC_MAX_REAL};

    for (PetscInt q = 0; q < points; q++) {
      PetscReal x[ISPH_MAX_DIM], normal[ISPH_MAX_DIM];

      (void)BodyPoint(body, q, dx, x, normal);
      for (PetscInt a = 0; a < samples[k].dim; a++) {
        low[a]  = PetscMin(low[a], x[a]);
        high[a] = PetscMax(high[a], x[a]);
      }
    }
    for (PetscInt a = 0; a < samples[k].dim; a++) {
      PetscReal span[2];

      BodySpan(body, a, span);
      CloudAssertNone("span", samples[k].shape,
                      span[0] > low[a] + 1e-12 || span[1] < high[a] - 1e-12 ||
                          (!samples[k].bound && (span[0] < low[a] - dx || span[1] > high[a] + dx)));
    }
  }
}

/* A plate, a small circle and a sharp wedge are thin; a thick box and a wide wedge are not. */
static void test_thickness(void **state)
{
  const struct {
    const char *shape;
    PetscReal   low, high;
  } bodies[] = {
      {"box,0,0,1,0.0123", 0.0123 - 1e-12, 0.0123 + 1e-12},
      {"box,0,0,1,0.25", 0.2, 0.2},
      {"circle,0,0,0.07", 0.14 - 1e-12, 0.14 + 1e-12},
      {"polygon,0,0,1,0,0,0.3", 0.0, 0.04},  /* 17 degrees */
      {"polygon,0,0,1,0,0.5,0.8", 0.2, 0.2}, /* 58 and 64 degrees */
      {"box,0,0,1,1 - box,0.05,0.05,2,0.95", 0.05 - 1e-12, 0.05 + 1e-12},
  };

  Scene scene = {.dim = 2, .dx = 0.05};

  (void)state;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(bodies); k++) {
    Body      body;
    PetscReal place[ISPH_MAX_DIM], thin;

    ReadBody(bodies[k].shape, &scene, &body);
    thin = BodyThickness(&body, 0.05, 0.2, place);
    CloudAssertNone("thickness", bodies[k].shape, thin < bodies[k].low || thin > bodies[k].high);
    body.around = PETSC_TRUE;
    assert_true(BodyThickness(&body, 0.05, 0.2, place) == 0.2);
  }
}

/* Copies the surface points of a body, which the caller frees. */
static PetscReal *Places(const Body *body, PetscReal dx, PetscInt *n)
{
  PetscReal *places;

  *n = BodyPoints(body, dx);
  ASSERT_OK(PetscMalloc1(3 * *n, &places));
  for (PetscInt q = 0; q < *n; q++) {
    PetscReal normal[ISPH_MAX_DIM];

    (void)BodyPoint(body, q, dx, &places[3 * q], normal);
  }
  return places;
}

/* Returns the distance of x from the nearest of n places. */
static PetscReal Nearest(PetscInt n, const PetscReal places[], const PetscReal x[])
{
  PetscReal best = PETSC_MAX_REAL;

  for (PetscInt q = 0; q < n; q++) {
    const PetscReal *y = &places[3 * q];

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
      const Scene    *scene = &made[k].scene;
      Body            body  = made[k].body;
      PetscReal      *places;
      PetscInt        points;

      body.around = around ? PETSC_TRUE : PETSC_FALSE;
      places      = Places(&body, dx, &points);
      for (PetscInt q = 0; q < 60; q++) {
        PetscReal x[ISPH_MAX_DIM] = {0.0}, n[ISPH_MAX_DIM], m[ISPH_MAX_DIM], d, near;

        for (PetscInt a = 0; a < scene->dim; a++)
          x[a] = body.centre[a] + 1.6 * body.extent * ParticlesHash(5, q, a);
        if (BodyReachesThrough(&body, 2)) x[2] = 0.1 + 0.4 * ParticlesHash(5, q, 2);
        d    = BodyDistance(scene, &body, x, n);
        near = Nearest(points, places, x);
        CloudAssertNone("distance", samples[k].shape,
                        PetscAbsReal(d) - near > 0.8 * dx ||
                            (!samples[k].bound && near - PetscAbsReal(d) > 0.8 * dx));
        CloudAssertNone("distance within a bound", samples[k].shape,
                        BodyDistanceWithin(scene, &body, x, 0.1, m) != d && d <= 0.1);
        for (PetscInt a = 0; a < scene->dim; a++) x[a] += step * n[a];
        CloudAssertNone("normal is the distance's gradient", samples[k].shape,
                        PetscAbsReal(BodyDistance(scene, &body, x, m) - d - step) > 1e-3 * step);
      }
      ASSERT_OK(PetscFree(places));
    }
  }
}

/* In a periodic box the distance is the distance from the nearest image, also for a drop whose
   centroid is far from its tip, and along z for a ball. */
static void CheckImages(PetscInt dim, const char *shape)
{
  Scene plain, periodic;
  Body  body;

  ASSERT_OK(PetscMemzero(&plain, sizeof(plain)));
  plain.dim = dim;
  plain.dx  = 0.05;
  for (PetscInt a = 0; a < dim; a++) plain.hi[a] = 1.0;
  SceneSetSides(&plain, &BoundaryWall);
  periodic                   = plain;
  periodic.boundary          = NULL;
  periodic.boundary_capacity = 0;
  SceneSetSides(&periodic, &BoundaryPeriodic);
  ReadBody(shape, &plain, &body);
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
  (void)state;
  CheckImages(2, "polygon,0.1,0.4,0.85,0.5,0.1,0.6,0.05,0.5");
  CheckImages(2, "circle,0.1,0.5,0.2 - box,0.1,0.1,0.3,0.9");
  CheckImages(3, "prism,0.1,0.4,0.85,0.5,0.1,0.6,0.05,0.5");
  CheckImages(3, "ball,0.2,0.5,0.9,0.3");
}

/* A list of bodies is read one by one, and ends. */
static void test_list(void **state)
{
  const OptionRow row   = {.name = "-scene_body_<k>", .table = &ShapeTable};
  Scene           scene = {.dim = 2, .dx = 0.1};
  Body            body[3];
  PetscBool       given;

  (void)state;
  ASSERT_OK(PetscOptionsSetValue(NULL, "-scene_body_1", "circle,0,0,1; box,0,0,1,2"));
  for (PetscInt k = 0; k < 3; k++) {
    ASSERT_OK(ShapeRead(&scene, &row, 1, k, &body[k], &given));
    assert_true(given == (k < 2));
  }
  assert_string_equal(body[0].shape->name, "circle");
  assert_true(body[1].parameter[5] == 2.0);
  ASSERT_OK(SceneFreeShapes(&scene));
}

/* Compounds of which nothing is left, or whose parts cannot be combined, are refused. */
static void test_refused(void **state)
{
  const struct {
    PetscInt    dim;
    const char *shape, *message;
  } refused[] = {
      {2, "circle,0,0,1 - circle,0,0,2", "nothing is left"},
      {2, "box,0,0,1,1 & box,2,0,3,1", "nothing is left"},
      {3, "ball,0,0,0,1 - box,-2,-2,-2,2,2,2", "nothing is left"},
      {3, "ball,0,0,0,1 + cylinder,0,0,0.5", "give all ends"},
      {2, "ellipse,0,0,1,0", "half axes must be positive"},
      {2, "capsule,0,0,0,0,1", "two points are at one place"},
      {3, "cone,0,0,0,1,0,0,-1", "radius must be positive"},
      {2, "circle,0,0,1 + ", "a name is required"},
  };

  (void)state;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(refused); k++) {
    const OptionRow row = {
        .name = "-scene_body_<k>", .table = &ShapeTable, .table_3d = &SolidTable};
    Scene          scene = {.dim = refused[k].dim, .dx = 0.1};
    Body           body;
    PetscBool      given;
    char           message[512] = "";
    PetscErrorCode code;

    ASSERT_OK(PetscOptionsSetValue(NULL, "-scene_body_1", refused[k].shape));
    ASSERT_OK(PetscPushErrorHandler(CloudKeepMessage, message));
    code = ShapeRead(&scene, &row, 1, 0, &body, &given);
    ASSERT_OK(PetscPopErrorHandler());
    CloudAssertNone("refused", refused[k].shape, !code);
    if (!strstr(message, refused[k].message)) print_error("%s\n", message);
    CloudAssertNone("message", refused[k].shape, !strstr(message, refused[k].message));
    ASSERT_OK(SceneFreeShapes(&scene));
  }
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_surface),   cmocka_unit_test(test_span),
      cmocka_unit_test(test_thickness), cmocka_unit_test(test_distance),
      cmocka_unit_test(test_images),    cmocka_unit_test(test_moments),
      cmocka_unit_test(test_list),      cmocka_unit_test(test_refused)};
  int failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, MakeAll, FreeAllShapes);
  return PetscFinalize() || failed ? 1 : 0;
}
