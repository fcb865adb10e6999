/*
  Shapes from files. Distances, volumes and moments of surfaces of triangles are compared with exact
  ones of a ball and of a box; damaged files, which the test writes itself, are accepted if their
  solid is clear, and refused in one line if it is not.
*/
/* RANKS: 1 */
#include "cloud.h"
#include "mesh/mesh.h"
#include <stdint.h>
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
  PetscReal       area = 0.0, exact = 0.0;
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
    assert_true(PetscAbsReal(BodyDistance(&scene, &body, x, m)) < 1e-12);
    for (PetscInt q = 0; q < BodyPoints(&body, dx); q++) {
      (void)BodyPoint(&body, q, dx, y, m);
      if (q != k)
        d = PetscMin(d, PetscSqrtReal(PetscSqr(x[0] - y[0]) + PetscSqr(x[1] - y[1]) +
                                      PetscSqr(x[2] - y[2])));
    }
    assert_true(d > 0.6 * dx && part > 0.5 * dx * dx && part < 2.0 * dx * dx);
  }
  assert_true(PetscAbsReal(area / exact - 1.0) < 1e-12);
  ASSERT_OK(SceneFreeShapes(&scene));
}

/* Writes a text, or bytes, as the file. */
static void WriteBytes(size_t n, const char bytes[])
{
  FILE *stream = fopen(PATH, "wb");

  (void)fwrite(bytes, 1, n, stream);
  (void)fclose(stream);
}

/* Damages of a box of 6 x 50 triangles, by number; the solid that they leave has a known volume. */
enum {
  NONE,
  FLIPPED,
  HOLE,
  TWO_HOLES,
  TWICE,
  CRACK,
  POINT,
  CAVITY,
  APART,
  LARGE_HOLE,
  CROSSED,
  TOUCHING,
  SHEET,
  CORNER,
  FOLDED,
  MOEBIUS,
  NO_EXTENT,
  ALL_FLIPPED,
  SMALL,
  N_DAMAGES
};
static const struct {
  const char *message; /* NULL: it is accepted */
  PetscReal   volume;
} damages[N_DAMAGES] = {
    [NONE]        = {NULL, 1.0},
    [FLIPPED]     = {NULL, 1.0},
    [HOLE]        = {NULL, 1.0},
    [TWO_HOLES]   = {NULL, 1.0}, /* that share a corner */
    [TWICE]       = {NULL, 1.0},
    [CRACK]       = {NULL, 1.0}, /* a corner on the side of a neighbour */
    [POINT]       = {NULL, 1.0}, /* a triangle that is a point */
    [CAVITY]      = {NULL, 1.0 - 0.125},
    [APART]       = {NULL, 1.0 + 0.125},
    [LARGE_HOLE]  = {"open sides, of holes above 1 %", 0.0},
    [CROSSED]     = {"pairs of its triangles cross or touch", 0.0},
    [TOUCHING]    = {"touch", 0.0},
    [SHEET]       = {"more than two triangles meet", 0.0},
    [CORNER]      = {"corners in which parts touch", 0.0},
    [FOLDED]      = {"open sides", 0.0}, /* two triangles on the same corners */
    [MOEBIUS]     = {"one side only", 0.0},
    [NO_EXTENT]   = {"have no extent", 0.0},
    [ALL_FLIPPED] = {NULL, 1.0},
    [SMALL]       = {NULL, 1e-18},
};

/* Reverses the order of the corners of a triangle. */
static void Flip(PetscInt t)
{
  for (PetscInt a = 0; a < 3; a++) {
    const PetscReal kept = soup.x[t][3 + a];

    soup.x[t][3 + a] = soup.x[t][6 + a];
    soup.x[t][6 + a] = kept;
  }
}

/* Adds a band of triangles with half a turn. */
static void AddMoebius(void)
{
  for (PetscInt k = 0; k < 24; k++) {
    PetscReal x[4][3];

    for (PetscInt q = 0; q < 4; q++) {
      const PetscReal w = 2.0 * PETSC_PI * (k + q / 2) / 24.0, s = (q % 2 ? 0.3 : -0.3);
      const PetscReal r = 1.0 + s * PetscCosReal(0.5 * w);

      x[q][0] = r * PetscCosReal(w);
      x[q][1] = r * PetscSinReal(w);
      x[q][2] = s * PetscSinReal(0.5 * w);
    }
    AddTriangle(x[0], x[1], x[2]);
    AddTriangle(x[1], x[3], x[2]);
  }
}

static void Damage(PetscInt k)
{
  const PetscReal one[3] = {1, 1, 1}, quarter[3] = {0.25, 0.25, 0.25}, most[3] = {0.75, 0.75, 0.75};
  PetscReal       half[3];

  soup.n = 0;
  if (k == MOEBIUS) AddMoebius();
  else AddBox(zero, one, 5);
  if (k == FLIPPED) Flip(17);
  for (PetscInt t = 0; t < soup.n && k == ALL_FLIPPED; t++) Flip(t);
  if (k == HOLE || k == TWO_HOLES) soup.n--;
  if (k == TWO_HOLES) memcpy(soup.x[soup.n - 5], soup.x[soup.n - 1], sizeof(soup.x[0]));
  if (k == TWO_HOLES) soup.n--;
  if (k == TWICE) AddTriangle(&soup.x[3][3], &soup.x[3][6], &soup.x[3][0]);
  if (k == LARGE_HOLE) soup.n -= 8;
  if (k == POINT) AddTriangle(soup.x[0], soup.x[0], soup.x[0]);
  for (PetscInt a = 0; a < 3; a++) half[a] = 0.5 * (soup.x[40][a] + soup.x[40][3 + a]);
  if (k == CRACK) {
    AddTriangle(half, &soup.x[40][3], &soup.x[40][6]);
    memcpy(&soup.x[40][3], half, sizeof(half));
  }
  if (k == CAVITY) AddBox(quarter, most, 3);
  if (k == APART) AddBox((PetscReal[]){1.5, 0, 0}, (PetscReal[]){2, 0.5, 0.5}, 3);
  if (k == CROSSED) AddBox((PetscReal[]){0.5, 0.4, 0.4}, (PetscReal[]){1.5, 0.6, 0.6}, 3);
  if (k == TOUCHING) AddBox((PetscReal[]){1, 0.4, 0.4}, (PetscReal[]){1.5, 0.6, 0.6}, 3);
  if (k == SHEET) AddBox(one, (PetscReal[]){2, 2, 0}, 5); /* they share an edge */
  if (k == CORNER) AddBox(one, (PetscReal[]){2, 2, 2}, 4);
  if (k == FOLDED) {
    soup.n = 2;
    memcpy(soup.x[1], soup.x[0], sizeof(soup.x[0]));
    Flip(1);
  }
  for (PetscInt q = 0; q < 9 * soup.n && (k == NO_EXTENT || k == SMALL); q++)
    soup.x[q / 9][q % 9] *= k == SMALL ? 1e-6 : 0.0;
}

/* Damaged surfaces have the right volume and the right sign everywhere, or are refused. */
static void test_damages(void **state)
{
  (void)state;
  for (PetscInt k = 0; k < N_DAMAGES; k++) {
    Scene       scene;
    Body        body;
    BodyMoments m;
    char        message[512], name[16];

    (void)snprintf(name, sizeof(name), "damage %d", (int)k);
    Damage(k);
    Write();
    ReadBody("file," PATH, &scene, &body, message);
    if (damages[k].message) {
      if (!strstr(message, damages[k].message)) print_error("%s\n", message);
      CloudAssertNone("refused", name, !strstr(message, damages[k].message));
      continue;
    }
    CloudAssertNone(message, name, message[0] != '\0');
    BodyFindMoments(&body, &m);
    CloudAssertNone("volume", name, PetscAbsReal(m.volume / damages[k].volume - 1.0) > 1e-9);
    for (PetscInt q = 0; q < 500 && k != SMALL; q++) {
      PetscReal x[3], n[3], far = 0.0;
      PetscBool cavity = k == CAVITY;

      for (PetscInt a = 0; a < 3; a++) {
        x[a]   = 0.5 + 0.7 * ParticlesHash(4, q, a);
        far    = PetscMax(far, PetscAbsReal(x[a] - 0.5));
        cavity = cavity && PetscAbsReal(x[a] - 0.5) < 0.25;
      }
      CloudAssertNone("sign", name,
                      (BodyDistance(&scene, &body, x, n) < 0.0) != (far < 0.5 && !cavity));
    }
    ASSERT_OK(SceneFreeShapes(&scene));
  }
}

/* Texts of files, and the message that refuses them. */
static void test_texts(void **state)
{
  static const struct {
    const char *text, *message;
  } texts[] = {
      {"", "it is empty"},
      {"hello", "it is no STL or OBJ file"},
      {"solid a\nfacet normal 0 0 0\nvertex 0 0 0\nvertex 1 0 0\n", "ends without 'endsolid'"},
      {"solid a\nvertex 0 0 0\nvertex 1 0 0\nendfacet\nendsolid\n", "a facet has no three corners"},
      {"solid a\nvertex 0 0\nvertex 1 0 0\n", "a number is required at"},
      {"solid a\nvertex 0 0 nan\nvertex 1 0 0\nvertex 0 1 0\nendsolid\n", "is not finite"},
      {"solid a\nendsolid\n", "it has no face and no outline"},
      {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "a face has corner 3, of 3"},
      {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\n", "a face has 2 corners"},
      {"v 0 0 0\nv 2 0 0\nv 0.1 0.1 0\nv 0 2 0\nf -3 -2 -1 -4\n", "is not convex"},
  };

  (void)state;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(texts); k++) {
    Scene scene;
    Body  body;
    char  message[512];

    WriteBytes(strlen(texts[k].text), texts[k].text);
    ReadBody("file," PATH, &scene, &body, message);
    if (!strstr(message, texts[k].message)) print_error("%s\n", message);
    CloudAssertNone("refused", texts[k].message, !strstr(message, texts[k].message));
  }
}

/* A tetrahedron with legs of length 1 as a binary STL file: the volume is 1/6. */
static void test_binary(void **state)
{
  static const float   x[4][3]    = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  static const int32_t face[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  const size_t         n          = 84 + 4 * 50;
  char                 bytes[600], message[512];
  Scene                scene;
  Body                 body;
  BodyMoments          m;

  (void)state;
  memset(bytes, ' ', sizeof(bytes));
  memcpy(bytes, "solid, but binary", 17);
  memcpy(bytes + 80, &(uint32_t){4}, 4);
  for (PetscInt k = 0; k < 12; k++)
    memcpy(bytes + 84 + 50 * (k / 3) + 12 + 12 * (k % 3), x[face[k / 3][k % 3]], 12);
  WriteBytes(n, bytes);
  ReadBody("file," PATH ",2", &scene, &body, message);
  CloudAssertNone(message, "binary file", message[0] != '\0');
  BodyFindMoments(&body, &m);
  assert_true(PetscAbsReal(m.volume - 8.0 / 6.0) < 1e-12);
  ASSERT_OK(SceneFreeShapes(&scene));
  WriteBytes(n - 1, bytes);
  ReadBody("file," PATH, &scene, &body, message);
  assert_true(strstr(message, "it should have") != NULL || strstr(message, "endsolid") != NULL ||
              strstr(message, "bytes of 0") != NULL);
}

/* Outlines: areas of files, or messages that refuse them. */
static void test_outlines(void **state)
{
  static const struct {
    const char *text;
    PetscReal   area, close; /* relative error */
    const char *message;
  } files[] = {
      {"x,y\n0,0\n2,0\n2,1\n0,1\n0,0\n", 2.0, 1e-12, NULL},
      {"0 0\n4 0\n4 4\n0 4\n\n1 1\n3 1\n3 3\n1 3\n\n1.5,1.5\n2.5,1.5\n2,2.5\n", 12.5, 1e-12, NULL},
      {"POLYGON ((0 0, 4 0, 4 4, 0 4, 0 0), (1 1, 1 2, 2 2, 2 1, 1 1))", 15.0, 1e-12, NULL},
      {"MULTIPOLYGON (((0 0, 1 0, 1 1, 0 0)), ((3 0, 4 0, 4 1, 3 1, 3 0)))", 1.5, 1e-12, NULL},
      {"0,0\n2,0\n2,2\n0,2\n\n1,1\n3,1\n3,3\n1,3\n", 0.0, 0.0, "its outlines cross each other"},
      {"0,0\n1,1\n1,0\n0,1\n", 0.0, 0.0, "its sides cross or touch"},
      {"0,0\n1,0,5\n1,1\n", 0.0, 0.0, "line 2 has no two numbers"},
      {"0,0\n1,0\n1", 0.0, 0.0, "line 3 has no two numbers"},
      {"0,0\n1,inf\n1,1\n", 0.0, 0.0, "is not finite"},
      {"0,0\n1,0\n", 0.0, 0.0, "has 2 corners"},
      {"solid a\n", 0.0, 0.0, "it has no face and no outline"},
      {"POLYGON ((0 0, 1 0, 1 1, 0 0)", 0.0, 0.0, "two numbers are required"},
      {"POLYGON Z ((0 0 0, 1 0 0, 1 1 0))", 0.0, 0.0, "two numbers are required"},
      {"POLYGON ((0 0, 1 0, 1 1, 0 0)) POINT (1 1)", 0.0, 0.0, "POLYGON or MULTIPOLYGON is"},
  };

  (void)state;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(files); k++) {
    const OptionRow row   = {.name = "-scene_body_<k>", .table = &ShapeTable};
    Scene           scene = {.dim = 2, .dx = 0.1};
    Body            body;
    BodyMoments     m;
    PetscBool       given;
    char            message[512] = "";

    WriteBytes(strlen(files[k].text), files[k].text);
    ASSERT_OK(PetscOptionsSetValue(NULL, "-scene_body_1", "file," PATH));
    ASSERT_OK(PetscPushErrorHandler(CloudKeepMessage, message));
    (void)ShapeRead(&scene, &row, 1, 0, &body, &given);
    ASSERT_OK(PetscPopErrorHandler());
    if (!files[k].message && !*message) {
      BodyFindMoments(&body, &m);
      CloudAssertNone("area", files[k].text,
                      PetscAbsReal(m.volume / files[k].area - 1.0) > files[k].close);
    }
    if (files[k].message ? !strstr(message, files[k].message) : *message != '\0')
      print_error("%s\n", message);
    CloudAssertNone("message", files[k].text,
                    files[k].message ? !strstr(message, files[k].message) : *message != '\0');
    ASSERT_OK(SceneFreeShapes(&scene));
  }
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_distance), cmocka_unit_test(test_points),
      cmocka_unit_test(test_damages),  cmocka_unit_test(test_texts),
      cmocka_unit_test(test_binary),   cmocka_unit_test(test_outlines)};
  int failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  return PetscFinalize() || failed ? 1 : 0;
}
