/*
  The pressure on splines: they sum to 1, the divergence of a linear velocity is exact, its sum over
  all splines is the flux through the boundary whatever the velocities are, and the matrix of the
  increment has the constant as its only null vector on both sides.
*/
/* RANKS: 1 2 3 */
#include "schemes/projection/splines.h"
#include "cloud.h"
#include <string.h>

/* A flow of a cloud's particles without clock or scheme, and its splines. */
typedef struct {
  Cloud   cloud;
  Scheme  scheme;
  Flow    flow;
  Splines splines;
  Vec     d;
} Fixture;

static void Setup(const CloudBox *box, Fixture *f)
{
  memset(f, 0, sizeof(*f));
  ASSERT_OK(CloudCreate(box, "-velocity_filter 0", &f->cloud));
  f->flow = (Flow){.scene     = &f->cloud.scene,
                   .scheme    = &f->scheme,
                   .ops       = f->cloud.ops,
                   .particles = f->cloud.particles,
                   .neighbors = f->cloud.neighbors,
                   .walls     = f->cloud.walls};
  ASSERT_OK(SplineLatticeSet(&f->cloud.scene, 2.0, &f->splines.lattice));
  f->splines.scale = 1.0;
  for (PetscInt a = 0; a < box->dim; a++) f->splines.scale *= f->splines.lattice.side[a];
  f->splines.scale = PetscPowReal(f->splines.scale, 1.0 / box->dim);
  ASSERT_OK(
      VecCreateMPI(PETSC_COMM_WORLD, PETSC_DECIDE, f->splines.lattice.N, &f->splines.natural));
  ASSERT_OK(SplinesAssemble(&f->flow, &f->splines));
  ASSERT_OK(VecDuplicate(f->splines.mass, &f->d));
}

static void Teardown(Fixture *f)
{
  ASSERT_OK(VecDestroy(&f->d));
  ASSERT_OK(SplinesFree(&f->splines));
  ASSERT_OK(CloudDestroy(&f->cloud));
}

static void AssertNorm(const char *what, const char *where, Vec v, PetscReal tolerance)
{
  PetscReal norm;

  ASSERT_OK(VecNorm(v, NORM_INFINITY, &norm));
  CloudAssertNone(what, where, !(norm <= tolerance));
}

/* Boxes whose cells of the lattice do not divide evenly, with and without walls. */
static const CloudBox boxes[] = {
    {.name = "2D box", .dim = 2, .cells = {13, 10}, .jitter = 0.2},
    {.name = "2D channel", .dim = 2, .cells = {12, 9}, .n_periodic = 1, .jitter = 0.2},
    {.name = "2D periodic", .dim = 2, .cells = {11, 12}, .n_periodic = 2, .jitter = 0.2},
    {.name = "3D box", .dim = 3, .cells = {8, 9, 7}, .jitter = 0.1},
};
#define BOXES (sizeof(boxes) / sizeof(boxes[0]))

static void test_unity(void **state)
{
  (void)state;
  for (size_t b = 0; b < BOXES; b++) {
    Fixture   f;
    PetscReal volume = 1.0, sum;

    Setup(&boxes[b], &f);
    ASSERT_OK(VecSet(f.splines.p, 1.0));
    ASSERT_OK(MatMult(f.splines.V, f.splines.p, f.cloud.y));
    ASSERT_OK(VecShift(f.cloud.y, -1.0));
    AssertNorm("the splines sum to 1", boxes[b].name, f.cloud.y, 1e-13);
    for (PetscInt a = 0; a < boxes[b].dim; a++) {
      ASSERT_OK(MatMult(f.splines.G[a], f.splines.p, f.cloud.y));
      AssertNorm("the gradient of 1 vanishes", boxes[b].name, f.cloud.y, 1e-11);
      volume *= f.splines.lattice.cells[a];
    }
    ASSERT_OK(VecSum(f.splines.mass, &sum));
    CloudAssertNone("volume", boxes[b].name, !(PetscAbsReal(sum - volume) < 1e-10 * volume));
    Teardown(&f);
  }
}

/* Fills a velocity with the linear field g.s of each component, and the walls' with the same. */
static void SetLinear(Fixture *f, PetscReal g[ISPH_MAX_DIM][ISPH_MAX_DIM])
{
  Cloud          *cloud = &f->cloud;
  const PetscReal dx    = cloud->scene.dx;

  for (PetscInt c = 0; c < cloud->scene.dim; c++) {
    PetscScalar *u;

    ASSERT_OK(VecGetArray(cloud->f[c], &u));
    for (PetscInt i = 0; i < cloud->particles->n_fluid; i++) {
      u[i] = 0.0;
      for (PetscInt a = 0; a < cloud->scene.dim; a++) {
        const PetscReal centre = 0.5 * (cloud->scene.lo[a] + cloud->scene.hi[a]);

        u[i] += g[c][a] * (cloud->particles->x[a][i] - centre) / dx;
      }
    }
    ASSERT_OK(VecRestoreArray(cloud->f[c], &u));
    memset(&cloud->wall_u[c], 0, sizeof(cloud->wall_u[c]));
    for (PetscInt a = 0; a < cloud->scene.dim; a++) cloud->wall_u[c].g[a] = g[c][a];
  }
  ASSERT_OK(WallValuesSetVelocity(&cloud->scene, cloud->particles, 0.0, 0.0, &cloud->walls));
  f->flow.walls = cloud->walls;
}

static void test_linear(void **state)
{
  PetscReal g[ISPH_MAX_DIM][ISPH_MAX_DIM] = {{0.3, -0.7, 0.2}, {0.4, 0.5, -0.6}, {0.9, 0.1, -0.2}};

  (void)state;
  for (size_t b = 0; b < BOXES; b++) {
    Fixture   f;
    PetscReal trace = 0.0;

    if (boxes[b].n_periodic) continue;
    Setup(&boxes[b], &f);
    SetLinear(&f, g);
    for (PetscInt a = 0; a < boxes[b].dim; a++) trace += g[a][a] / f.cloud.scene.dx;
    ASSERT_OK(SplinesDivergence(&f.flow, &f.splines, f.cloud.f, 0.0, f.d));
    ASSERT_OK(VecAXPY(f.d, -trace, f.splines.mass));
    AssertNorm("divergence of a linear velocity", boxes[b].name, f.d, 1e-11);
    Teardown(&f);
  }
}

static void test_conservation(void **state)
{
  (void)state;
  for (size_t b = 0; b < BOXES; b++) {
    Fixture     f;
    PetscReal   zero[ISPH_MAX_DIM][ISPH_MAX_DIM] = {{0.0}}, sum;
    PetscRandom random;

    Setup(&boxes[b], &f);
    SetLinear(&f, zero);
    ASSERT_OK(PetscRandomCreate(PETSC_COMM_WORLD, &random));
    for (PetscInt c = 0; c < boxes[b].dim; c++) ASSERT_OK(VecSetRandom(f.cloud.f[c], random));
    ASSERT_OK(SplinesDivergence(&f.flow, &f.splines, f.cloud.f, 0.0, f.d));
    ASSERT_OK(VecSum(f.d, &sum));
    CloudAssertNone("volume is conserved", boxes[b].name, !(PetscAbsReal(sum) < 1e-10));
    ASSERT_OK(SplinesMatrix(&f.flow, &f.splines));
    ASSERT_OK(VecSet(f.splines.p, 1.0));
    ASSERT_OK(MatMult(f.splines.A, f.splines.p, f.d));
    AssertNorm("A 1 = 0", boxes[b].name, f.d, 1e-11);
    ASSERT_OK(VecSetRandom(f.splines.p, random));
    ASSERT_OK(MatMult(f.splines.A, f.splines.p, f.d));
    ASSERT_OK(VecSum(f.d, &sum));
    CloudAssertNone("1^T A = 0", boxes[b].name, !(PetscAbsReal(sum) < 1e-10));
    ASSERT_OK(PetscRandomDestroy(&random));
    Teardown(&f);
  }
}

int main(int argc, char *argv[])
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_unity), cmocka_unit_test(test_linear),
                                     cmocka_unit_test(test_conservation)};
  int                     failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  return PetscFinalize() || failed;
}
