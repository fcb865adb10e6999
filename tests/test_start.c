/*
  Particles read from a file: each rank reads its share, rows of walls are skipped, velocities stay
  with their positions, and an invalid file is refused with the row and the reason.
*/
/* RANKS: 1 2 */
#include <string.h>
#include "isph/start.h"
#include "cloud.h"
#include "io/hdf5file.h"
#include "isph/run.h"

#define ROWS 10 /* of the file: two lines of five particles */

/* Contents of a file of particles, as a user may write it. */
typedef struct {
  PetscReal x[ROWS][2], u[ROWS][2];
  int       type[ROWS];
  PetscInt  rows, columns, rows_u; /* columns of position; rows_u 0: no velocities */
  PetscBool typed;
} Given;

static Given GivenLattice(void)
{
  Given given = {.rows = ROWS, .columns = 2, .rows_u = ROWS, .typed = PETSC_TRUE};

  for (PetscInt k = 0; k < ROWS; k++) {
    given.x[k][0] = (k % 5 + 0.5) / 5.0;
    given.x[k][1] = (k / 5 + 0.5) / 5.0;
    given.u[k][0] = (PetscReal)k;
    given.u[k][1] = -2.0 * (PetscReal)k;
  }
  return given;
}

static void WriteGiven(const char path[], const Given *given)
{
  Hdf5File    file;
  PetscBool   good;
  PetscMPIInt rank;

  assert_int_equal(MPI_Comm_rank(PETSC_COMM_WORLD, &rank), 0);
  assert_int_equal(Hdf5FileOpen(PETSC_COMM_WORLD, path, HDF5_COMMON, &file), 0);
  file.start = 0;
  file.N     = given->rows;
  file.own   = rank ? 0 : file.N;
  assert_int_equal(Hdf5WriteRows(&file, "position", given->columns, H5T_IEEE_F64LE,
                                 H5T_NATIVE_DOUBLE, given->x, "m"),
                   0);
  if (given->typed)
    assert_int_equal(
        Hdf5WriteRows(&file, "type", 0, H5T_STD_I32LE, H5T_NATIVE_INT, given->type, "1"), 0);
  file.N   = given->rows_u;
  file.own = rank ? 0 : file.N;
  if (given->rows_u)
    assert_int_equal(
        Hdf5WriteRows(&file, "velocity", 2, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, given->u, "m/s"), 0);
  assert_int_equal(Hdf5FileClose(&file, &good), 0);
  assert_true(good);
}

/* Creates a unit square of spacing 0.2; it may be periodic along x or have a small body. */
static void MakeScene(PetscBool periodic, PetscBool body, Scene *scene)
{
  memset(scene, 0, sizeof(*scene));
  scene->dim   = 2;
  scene->dx    = 0.2;
  scene->hi[0] = scene->hi[1] = 1.0;
  scene->cells[0] = scene->cells[1] = 5;
  scene->physics                    = PHYSICS_WALLS;
  SceneSetSides(scene, &BoundaryWall);
  if (periodic) SceneSetAxis(scene, 0, &BoundaryPeriodic);
  if (body) BodyCircle(scene, 0.5, 0.3, 0.05, &SceneAddBody(scene)->body);
}

/* Reads the file as in a run; returns the message of the error, or "". */
static void Read(Scene *scene, const char path[], FluidStart *start, char message[])
{
  char           read[PETSC_MAX_PATH_LEN];
  PetscErrorCode code;

  message[0] = '\0';
  assert_int_equal(PetscOptionsSetValue(NULL, "-particles", path), 0);
  assert_int_equal(PetscPushErrorHandler(CloudKeepMessage, message), 0);
  code = StartRead(scene, start, read);
  assert_int_equal(PetscPopErrorHandler(), 0);
  assert_int_equal(PetscOptionsClearValue(NULL, "-particles"), 0);
  assert_true(code ? message[0] != '\0' : !strcmp(read, path));
}

static void test_none(void **state)
{
  Scene      scene;
  FluidStart start;
  char       path[PETSC_MAX_PATH_LEN];

  (void)state;
  MakeScene(PETSC_FALSE, PETSC_FALSE, &scene);
  assert_int_equal(StartRead(&scene, &start, path), 0);
  assert_int_equal(start.N, 0);
  assert_int_equal(path[0], 0);
}

/* Skips rows 2 and 7, which are walls; the other rows keep their order over the ranks. */
static void test_share(void **state)
{
  const PetscInt kept[ROWS - 2] = {0, 1, 3, 4, 5, 6, 8, 9};
  Scene          scene;
  FluidStart     start;
  Given          given = GivenLattice();
  char           message[512];

  (void)state;
  given.type[2] = given.type[7] = 1;
  MakeScene(PETSC_FALSE, PETSC_FALSE, &scene);
  WriteGiven("share.h5", &given);
  Read(&scene, "share.h5", &start, message);
  assert_string_equal(message, "");
  assert_int_equal(start.N, ROWS - 2);
  for (PetscInt i = 0; i < start.n; i++) {
    const PetscInt row = kept[start.first + i];

    for (PetscInt a = 0; a < 2; a++) {
      assert_true(start.x[2 * i + a] == given.x[row][a]);
      assert_true(start.u[2 * i + a] == given.u[row][a]);
    }
  }
  assert_int_equal(StartFree(&start), 0);
}

/* A file may hold positions only; positions outside a periodic box are wrapped into it. */
static void test_places(void **state)
{
  Scene      scene;
  FluidStart start;
  Given      given = GivenLattice();
  char       message[512];

  (void)state;
  given.rows_u = 0;
  given.typed  = PETSC_FALSE;
  given.x[0][0] -= 1.0;
  MakeScene(PETSC_TRUE, PETSC_FALSE, &scene);
  WriteGiven("places.h5", &given);
  Read(&scene, "places.h5", &start, message);
  assert_string_equal(message, "");
  assert_int_equal(start.N, ROWS);
  assert_null(start.u);
  if (start.n && start.first == 0) assert_true(PetscAbsReal(start.x[0] - 0.1) < 1e-15);
  assert_int_equal(StartFree(&start), 0);
}

/* Requires that a file is refused with the given words in the message. */
static void Refused(Scene *scene, const Given *given, const char *words)
{
  FluidStart start;
  char       message[512];

  WriteGiven("bad.h5", given);
  Read(scene, "bad.h5", &start, message);
  assert_non_null(strstr(message, words));
}

static void test_refusals(void **state)
{
  Scene scene, with_body;
  Given given;

  (void)state;
  MakeScene(PETSC_FALSE, PETSC_FALSE, &scene);
  MakeScene(PETSC_FALSE, PETSC_TRUE, &with_body);
  given = GivenLattice();
  Refused(&with_body, &given, "row 7 is inside a body");
  given.x[3][1] = 1.0;
  Refused(&scene, &given, "row 3 is not inside the box");
  given.u[1][0] = NAN;
  Refused(&scene, &given, "row 1 is not finite");
  given = GivenLattice();
  for (PetscInt k = 0; k < ROWS; k++) given.type[k] = 1;
  Refused(&scene, &given, "there is no fluid in it");
  given         = GivenLattice();
  given.columns = 3;
  given.rows    = 6;
  Refused(&scene, &given, "2 columns");
  given        = GivenLattice();
  given.rows_u = 4;
  Refused(&scene, &given, "must have the rows of 'position'");
}

/* Particles have the positions and velocities of the file on the ranks that own the positions; the
   walls are unchanged. */
static void test_particles(void **state)
{
  const WallPlacement walls = {0};
  Scene               scene;
  FluidStart          start;
  Given               given = GivenLattice();
  Particles          *p;
  char                message[512];

  (void)state;
  MakeScene(PETSC_FALSE, PETSC_FALSE, &scene);
  WriteGiven("begin.h5", &given);
  Read(&scene, "begin.h5", &start, message);
  assert_int_equal(ParticlesCreate(&scene, 0.5, &p), 0);
  assert_int_equal(ParticlesFill(&scene, walls, &start, p), 0);
  assert_int_equal(StartFree(&start), 0);
  assert_int_equal(p->N_fluid, ROWS);
  assert_int_equal(p->N_lattice, 25);
  assert_int_equal(p->N_wall, 20);
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    for (PetscInt a = 0; a < 2; a++) {
      assert_true(p->x[a][i] == given.x[p->id[i]][a]);
      assert_true(p->u[a][i] == given.u[p->id[i]][a]);
    }
  }
  assert_int_equal(ParticlesDestroy(&p), 0);
}

/* StartCheck() refuses two particles at nearly the same place, even on different ranks, and
   particles that do not fill the box. */
static void test_closest(void **state)
{
  const WallPlacement walls = {0};
  Scene               scene;

  (void)state;
  MakeScene(PETSC_FALSE, PETSC_FALSE, &scene);
  for (PetscInt wrong = 0; wrong < 4; wrong++) {
    FluidStart     start;
    Given          given = GivenLattice();
    Particles     *p;
    Neighbors     *nb;
    PetscErrorCode code;
    char           message[512];

    if (wrong == 1) given.x[4][0] = given.x[3][0] + 0.001;
    WriteGiven("closest.h5", &given);
    Read(&scene, "closest.h5", &start, message);
    assert_int_equal(ParticlesCreate(&scene, 0.5, &p), 0);
    assert_int_equal(ParticlesFill(&scene, walls, &start, p), 0);
    assert_int_equal(NeighborsCreate(0.5, scene.dx, &nb), 0);
    if (wrong < 2) p->N_lattice = ROWS; /* as if they filled the box, which has room for 25 */
    if (wrong == 3) { /* as if they had half of the volume of a region that they fill */
      p->weight *= 2.0 * ROWS * SceneVolumeAt(&scene, given.x[0]) / (p->weight * p->cell_volume);
      scene.n_filled = 1;
    }
    assert_int_equal(PetscPushErrorHandler(CloudKeepMessage, message), 0);
    code = StartCheck(&scene, "closest.h5", p, nb);
    assert_int_equal(PetscPopErrorHandler(), 0);
    assert_int_equal(code ? 1 : 0, wrong ? 1 : 0);
    if (wrong == 1) assert_non_null(strstr(message, "0.005 dx apart"));
    if (wrong >= 2) assert_non_null(strstr(message, "times the volume of the fluid"));
    assert_int_equal(NeighborsDestroy(&nb), 0);
    assert_int_equal(StartFree(&start), 0);
    assert_int_equal(ParticlesDestroy(&p), 0);
  }
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_none),      cmocka_unit_test(test_share),
      cmocka_unit_test(test_places),    cmocka_unit_test(test_refusals),
      cmocka_unit_test(test_particles), cmocka_unit_test(test_closest),
  };
  int failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
  return PetscFinalize() || failed ? 1 : 0;
}
