/*
  Shapes from files. Distances, volumes and moments of surfaces of triangles are compared with exact
  ones of a ball and of a box; damaged files, which the test writes itself, are accepted if their
  solid is clear, and refused in one line if it is not.
*/
/* RANKS: 1 */
#include "cloud.h"
#include "mesh/mesh.h"
#include <string.h>

#define PATH "mesh_of_test"

/* Triangles that a test writes. */
typedef struct {
  PetscInt  n;
  PetscReal x[40000][9];
} Triangles;
static Triangles soup;

static void AddTriangle(const PetscReal a[3], const PetscReal b[3], const PetscReal c[3])
{
  for (PetscInt k = 0; k < 3; k++) {
    soup.x[soup.n][k]     = a[k];
    soup.x[soup.n][3 + k] = b[k];
    soup.x[soup.n][6 + k] = c[k];
  }
  soup.n++;
}

/* Adds a box whose sides are n x n squares of two triangles each. */
static void AddBox(const PetscReal lo[3], const PetscReal hi[3], PetscInt n)
{
  for (PetscInt side = 0; side < 6; side++) {
    const PetscInt a = side / 2, b = (a + 1) % 3, c = (a + 2) % 3;

    for (PetscInt q = 0; q < n * n; q++) {
      PetscReal x[4][3];

      for (PetscInt k = 0; k < 4; k++) {
        x[k][a] = side % 2 ? hi[a] : lo[a];
        x[k][b] = lo[b] + (hi[b] - lo[b]) * (q % n + (k == 1 || k == 2)) / n;
        x[k][c] = lo[c] + (hi[c] - lo[c]) * (q / n + (k > 1)) / n;
      }
      AddTriangle(x[0], x[side % 2 ? 1 : 2], x[side % 2 ? 2 : 1]);
      AddTriangle(x[0], x[side % 2 ? 2 : 3], x[side % 2 ? 3 : 2]);
    }
  }
}

/* Adds a ball of radius r: a cube whose corners are moved to the ball. */
static void AddBall(const PetscReal centre[3], PetscReal r, PetscInt n)
{
  const PetscReal lo[3] = {-1, -1, -1}, hi[3] = {1, 1, 1};
  const PetscInt  first = soup.n;

  AddBox(lo, hi, n);
  for (PetscInt k = 3 * first; k < 3 * soup.n; k++) {
    PetscReal *x = &soup.x[k / 3][3 * (k % 3)], size = 0.0;

    for (PetscInt a = 0; a < 3; a++) x[a] = PetscTanReal(0.25 * PETSC_PI * x[a]);
    for (PetscInt a = 0; a < 3; a++) size += x[a] * x[a];
    for (PetscInt a = 0; a < 3; a++) x[a] = centre[a] + r * x[a] / PetscSqrtReal(size);
  }
}

/* Writes the triangles as a text STL file. */
static void Write(void)
{
  FILE *stream = fopen(PATH, "w");

  fprintf(stream, "solid test\n");
  for (PetscInt t = 0; t < soup.n; t++) {
    fprintf(stream, "facet normal 0 0 0\nouter loop\n");
    for (PetscInt k = 0; k < 3; k++)
      fprintf(stream, "vertex %.17g %.17g %.17g\n", soup.x[t][3 * k], soup.x[t][3 * k + 1],
              soup.x[t][3 * k + 2]);
    fprintf(stream, "endloop\nendfacet\n");
  }
  fprintf(stream, "endsolid test\n");
  (void)fclose(stream);
}

/* Reads the file as a body. Output: message - of a refusal, "" if there is none. */
static void ReadBody(const char text[], Scene *scene, Body *body, char message[512])
{
  const OptionRow row = {.name = "-scene_body_<k>", .table = &ShapeTable, .table_3d = &SolidTable};
  PetscBool       given;

  *scene     = (Scene){.dim = 3, .dx = 0.1};
  message[0] = '\0';
  SceneSetSides(scene, &BoundaryWall);
  ASSERT_OK(PetscOptionsSetValue(NULL, "-scene_body_1", text));
  ASSERT_OK(PetscPushErrorHandler(CloudKeepMessage, message));
  (void)ShapeRead(scene, &row, 1, 0, body, &given);
  ASSERT_OK(PetscPopErrorHandler());
}

static const PetscReal zero[3] = {0, 0, 0};

/* The distances from a box of triangles are those of the box. */
static void test_distance(void **state)
{
  Scene       scene, other;
  Body        body, box;
  char        message[512];
  BodyMoments m;

  (void)state;
  soup.n = 0;
  AddBox(zero, (PetscReal[]){1.0, 0.5, 0.3}, 3);
  Write();
  ReadBody("file," PATH, &scene, &body, message);
  assert_string_equal(message, "");
  ReadBody("box,0,0,0,1,0.5,0.3", &other, &box, message);
  for (PetscInt q = 0; q < 2000; q++) {
    PetscReal x[3], n[3], exact[3], d, along = 0.0;

    for (PetscInt a = 0; a < 3; a++) x[a] = 0.4 + 1.5 * ParticlesHash(3, q, a);
    d = BodyDistance(&scene, &body, x, n);
    assert_true(PetscAbsReal(d - BodyDistance(&other, &box, x, exact)) < 1e-14);
    for (PetscInt a = 0; a < 3; a++) along += n[a] * exact[a];
    assert_true(d < 0.0 || along > 1.0 - 1e-9);
  }
  BodyFindMoments(&body, &m);
  assert_true(PetscAbsReal(m.volume - 0.15) < 1e-14);
  for (PetscInt a = 0; a < 3; a++) {
    const PetscReal side[3] = {1.0, 0.5, 0.3};

    assert_true(PetscAbsReal(m.centroid[a] - 0.5 * side[a]) < 1e-14);
    assert_true(PetscAbsReal(m.second[a][a] - 0.15 * PetscSqr(side[a]) / 12.0) < 1e-14);
    assert_true(PetscAbsReal(m.second[a][(a + 1) % 3]) < 1e-14);
  }
  ASSERT_OK(SceneFreeShapes(&scene));
  ASSERT_OK(SceneFreeShapes(&other));
}

/* Points on a ball: the sum of their areas is exact, they are evenly spread, and they are on the
   surface. */
static void test_points(void **state)
{
  Scene           scene;
  Body            body;
  char            message[512];
  PetscReal       area = 0.0, exact = 0.0, least = PETSC_INFINITY, most = 0.0;
  const PetscReal dx = 0.15;

  (void)state;
  soup.n = 0;
  AddBall(zero, 1.0, 40);
  Write();
  ReadBody("file," PATH, &scene, &body, message);
  assert_string_equal(message, "");
  {
    const Mesh *mesh = (const Mesh *)((const Solid *)body.data)->mesh;

    for (PetscInt t = 0; t < mesh->triangles; t++) {
      const PetscReal *x[3];
      PetscReal        n[3];

      exact += MeshTriangle(mesh, t, x, n);
    }
  }
  for (PetscInt k = 0; k < BodyPoints(&body, dx); k++) {
    PetscReal       x[3], n[3], y[3], m[3], d = PETSC_INFINITY;
    const PetscReal part = BodyPoint(&body, k, dx, x, n);

    area += part;
    least = PetscMin(least, part);
    most  = PetscMax(most, part);
    assert_true(PetscAbsReal(BodyDistance(&scene, &body, x, m)) < 1e-12);
    for (PetscInt q = 0; q < BodyPoints(&body, dx); q++) {
      (void)BodyPoint(&body, q, dx, y, m);
      if (q != k)
        d = PetscMin(d, PetscSqrtReal(PetscSqr(x[0] - y[0]) + PetscSqr(x[1] - y[1]) +
                                      PetscSqr(x[2] - y[2])));
    }
    if (d < 0.6 * dx) print_message("%g %g\n", d / dx, part / dx / dx);
  }
  print_message("%d points, areas %g to %g dx^2, mean %g\n", (int)BodyPoints(&body, dx),
                least / dx / dx, most / dx / dx, area / BodyPoints(&body, dx) / dx / dx);
  assert_true(PetscAbsReal(area / exact - 1.0) < 1e-12);
  ASSERT_OK(SceneFreeShapes(&scene));
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_distance),
                                     cmocka_unit_test(test_points)};
  int                     failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  return PetscFinalize() || failed ? 1 : 0;
}
