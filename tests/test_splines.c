/*
  The pressure on splines: they sum to 1, the divergence of a linear velocity is exact, its sum over
  all splines is the flux through the boundary whatever the velocities are, and the matrix of the
  increment has the constant as its only null vector on both sides. All this holds for the cubic
  splines of quartic fits too. The fits take most of the time, so the same splines of a box have all
  these properties tried.
*/
/* RANKS: 1 3 */
#include "splines/splines.h"
#include "cloud.h"
#include "isph/solvers.h"
#include <string.h>

/* A flow of a cloud's particles without clock or scheme, and its splines. */
typedef struct {
  Cloud   cloud;
  Scheme  scheme;
  Flow    flow;
  Splines splines;
  Vec     d;
} Fixture;

/* Input: degree - of fits. */
static void Setup(const CloudBox *box, PetscInt degree, Fixture *f)
{
  const char *options =
      degree == 4 ? "-velocity_filter 0 -mls_degree 4" : "-velocity_filter 0 -mls_degree 2";

  memset(f, 0, sizeof(*f));
  ASSERT_OK(CloudCreate(box, options, &f->cloud));
  f->flow = (Flow){.scene     = &f->cloud.scene,
                   .scheme    = &f->scheme,
                   .ops       = f->cloud.ops,
                   .particles = f->cloud.particles,
                   .neighbors = f->cloud.neighbors,
                   .walls     = f->cloud.walls};
  ASSERT_OK(SplinesSet(&f->cloud.scene, 2.0, degree, &f->splines));
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

/* Boxes whose cells of the lattice do not divide evenly, with and without walls and bodies. */
static const CloudBox boxes[] = {
    {.name = "2D box", .dim = 2, .cells = {13, 10}, .jitter = 0.2},
    {.name = "2D channel", .dim = 2, .cells = {12, 9}, .n_periodic = 1, .jitter = 0.2},
    {.name = "2D periodic", .dim = 2, .cells = {11, 12}, .n_periodic = 2, .jitter = 0.2},
    {.name = "3D box", .dim = 3, .cells = {8, 9, 7}, .jitter = 0.1},
    {.name = "2D circle", .dim = 2, .cells = {22, 19}, .jitter = 0.2, .circle = 4.3},
    {.name       = "2D circle, periodic",
     .dim        = 2,
     .cells      = {20, 21},
     .n_periodic = 2,
     .jitter     = 0.2,
     .circle     = 5.1},
    {.name = "3D cylinder", .dim = 3, .cells = {17, 16, 7}, .jitter = 0.1, .circle = 3.7},
    {.name = "2D lattice", .dim = 2, .cells = {30, 24}, .n_periodic = 1},
    {.name = "2D lattice, circle", .dim = 2, .cells = {30, 40}, .circle = 4.0},
};
#define BOXES (sizeof(boxes) / sizeof(boxes[0]))

#define QUARTIC 5 /* of them, the first, are tried with quartic fits too, which take longer */

/* No row of a matrix has more entries than space was made for: PETSc would copy the matrix for each
   such row, which took half of the time of a large box with a body. */
static void TrySpace(const CloudBox *box, Fixture *f)
{
  const Mat mats[] = {f->splines.S, f->splines.K};

  for (size_t k = 0; k < sizeof(mats) / sizeof(mats[0]); k++) {
    MatInfo info;

    if (!mats[k]) continue;
    ASSERT_OK(MatGetInfo(mats[k], MAT_GLOBAL_SUM, &info));
    CloudAssertNone("space for entries", box->name, info.mallocs > 0.0);
  }
}

static void TryUnity(const CloudBox *box, Fixture *f)
{
  PetscReal volume = 1.0, sum;

  ASSERT_OK(VecSet(f->splines.p, 1.0));
  ASSERT_OK(SplinesValue(&f->splines, f->splines.p, f->cloud.y));
  ASSERT_OK(VecShift(f->cloud.y, -1.0));
  AssertNorm("the splines sum to 1", box->name, f->cloud.y, 1e-13);
  for (PetscInt a = 0; a < box->dim; a++) ASSERT_OK(VecSet(f->cloud.f[a], 0.0));
  ASSERT_OK(SplinesAccelerate(&f->splines, f->splines.p, 1.0, f->cloud.f));
  for (PetscInt a = 0; a < box->dim; a++) {
    AssertNorm("the gradient of 1 vanishes", box->name, f->cloud.f[a], 1e-11);
    volume *= f->splines.lattice.cells[a];
  }
  ASSERT_OK(VecSum(f->splines.mass, &sum));
  CloudAssertNone("volume", box->name,
                  !f->splines.bodies && !(PetscAbsReal(sum - volume) < 1e-10 * volume));
}

/* The preconditioner is the inverse of K + c c^T: a product with the matrix and then with the
   inverse gives a vector back. */
static void TryInverse(const CloudBox *box, Fixture *f)
{
  const Splines *s = &f->splines;
  SplineInverse *inverse;
  PetscScalar   *values;
  Mat            column, A;
  Vec            x, b;

  if (s->bodies) return;
  ASSERT_OK(VecDuplicate(s->mass, &x));
  ASSERT_OK(VecDuplicate(s->mass, &b));
  ASSERT_OK(VecGetArrayWrite(x, &values));
  for (PetscInt k = 0; k < s->own.size; k++) values[k] = 1.0 / (2.0 * (s->own.start + k) + 3.0);
  ASSERT_OK(VecRestoreArrayWrite(x, &values));
  ASSERT_OK(SplineInverseCreate(s, &inverse));
  ASSERT_OK(SplineInverseNumber(s, f->cloud.particles, inverse));
  ASSERT_OK(GaugeColumn(&f->cloud.scene, PETSC_COMM_WORLD, 0, s->own.size, 1.0, &column));
  ASSERT_OK(SplineInverseColumn(s, column));
  ASSERT_OK(GaugeMatrix(s->K, column, &A));
  ASSERT_OK(MatMult(A, x, b));
  ASSERT_OK(SplineInverseApply(inverse, b, b));
  ASSERT_OK(VecAXPY(b, -1.0, x));
  AssertNorm("the inverse of the stiffness", box->name, b, 1e-11);
  ASSERT_OK(MatDestroy(&A));
  ASSERT_OK(MatDestroy(&column));
  ASSERT_OK(SplineInverseDestroy(&inverse));
  ASSERT_OK(VecDestroy(&x));
  ASSERT_OK(VecDestroy(&b));
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

static void TryLinear(const CloudBox *box, Fixture *f)
{
  PetscReal g[ISPH_MAX_DIM][ISPH_MAX_DIM] = {{0.3, -0.7, 0.2}, {0.4, 0.5, -0.6}, {0.9, 0.1, -0.2}};
  PetscReal trace                         = 0.0;

  if (box->n_periodic || box->circle > 0.0) return; /* bodies move rigidly */
  SetLinear(f, g);
  for (PetscInt a = 0; a < box->dim; a++) trace += g[a][a] / f->cloud.scene.dx;
  ASSERT_OK(SplinesDivergence(&f->flow, &f->splines, f->cloud.f, 0.0, f->d));
  ASSERT_OK(VecAXPY(f->d, -trace, f->splines.mass));
  AssertNorm("divergence of a linear velocity", box->name, f->d, 1e-11);
}

/* Sets the coefficients of all unknowns to 1 or to random numbers, the others to zero. */
static void SetUnknowns(Fixture *f, PetscRandom random)
{
  PetscScalar *p;

  if (random) ASSERT_OK(VecSetRandom(f->splines.p, random));
  else ASSERT_OK(VecSet(f->splines.p, 1.0));
  ASSERT_OK(VecGetArray(f->splines.p, &p));
  for (PetscInt k = 0; k < f->splines.n_unused; k++) p[f->splines.unused[k]] = 0.0;
  ASSERT_OK(VecRestoreArray(f->splines.p, &p));
}

/* A fluid that moves rigidly with its box and body has no divergence, also in cut cells; the circle
   is in the middle of the box. */
static void TryRigid(const CloudBox *box, Fixture *f)
{
  PetscReal g[ISPH_MAX_DIM][ISPH_MAX_DIM] = {{0.0, -0.7, 0.0}, {0.7, 0.0, 0.0}, {0.0, 0.0, 0.0}};

  if (box->n_periodic || box->circle == 0.0) return;
  f->cloud.scene.boundary[SceneBodySide(&f->cloud.scene, 0)].rotation =
      ExpressionNumber(0.7 / f->cloud.scene.dx);
  SetLinear(f, g);
  ASSERT_OK(SplinesDivergence(&f->flow, &f->splines, f->cloud.f, 0.0, f->d));
  AssertNorm("divergence of a rigid rotation", box->name, f->d, 1e-11);
  f->cloud.scene.boundary[SceneBodySide(&f->cloud.scene, 0)].rotation = ExpressionNumber(0.0);
}

static void TryConservation(const CloudBox *box, Fixture *f)
{
  PetscReal   zero[ISPH_MAX_DIM][ISPH_MAX_DIM] = {{0.0}}, sum;
  PetscRandom random;

  SetLinear(f, zero);
  ASSERT_OK(PetscRandomCreate(PETSC_COMM_WORLD, &random));
  for (PetscInt c = 0; c < box->dim; c++) ASSERT_OK(VecSetRandom(f->cloud.f[c], random));
  ASSERT_OK(SplinesDivergence(&f->flow, &f->splines, f->cloud.f, 0.0, f->d));
  ASSERT_OK(VecSum(f->d, &sum));
  CloudAssertNone("volume is conserved", box->name, !(PetscAbsReal(sum) < 1e-10));
  ASSERT_OK(SplinesMatrix(f->flow.particles, &f->splines));
  SetUnknowns(f, NULL);
  ASSERT_OK(MatMult(f->splines.A, f->splines.p, f->d));
  AssertNorm("A 1 = 0", box->name, f->d, 1e-11);
  SetUnknowns(f, random);
  ASSERT_OK(MatMult(f->splines.A, f->splines.p, f->d));
  ASSERT_OK(VecSum(f->d, &sum));
  CloudAssertNone("1^T A = 0", box->name, !(PetscAbsReal(sum) < 1e-10));
  ASSERT_OK(PetscRandomDestroy(&random));
}

/* Sets the coefficients to 2 + g.x at the centres, for which the pressure is the same function. */
static void SetLinearPressure(Fixture *f, const PetscReal g[])
{
  const SplineLattice *l = &f->splines.lattice;
  PetscScalar         *p;

  ASSERT_OK(VecGetArray(f->splines.p, &p));
  for (PetscInt k = 0; k < f->splines.own.size; k++) {
    PetscInt index[ISPH_MAX_DIM];

    (void)SplineOwn(&f->splines, k, index);
    p[k] = 2.0;
    for (PetscInt a = 0; a < l->dim; a++)
      p[k] += g[a] * (l->lo[a] + (index[a] - 0.5) * l->side[a]) / f->cloud.scene.dx;
  }
  ASSERT_OK(VecRestoreArray(f->splines.p, &p));
}

/* The pressure at a point is the sum of all ranks' parts, also on the surface of a body. */
static void TryPoints(const CloudBox *box, Fixture *f)
{
  static const PetscReal g[ISPH_MAX_DIM] = {0.3, -0.7, 0.2};

  if (box->n_periodic) return;
  SetLinearPressure(f, g);
  for (PetscInt m = 0; m < 40; m++) {
    const Scene *scene                = &f->cloud.scene;
    PetscReal    x[ISPH_MAX_DIM]      = {0.0}, exact, p;
    PetscReal    normal[ISPH_MAX_DIM] = {0.0};

    exact = 2.0;
    for (PetscInt a = 0; a < scene->dim; a++) {
      const PetscReal s = PetscMin(PetscMax(0.5 + 0.6 * ParticlesHash(1, m, a), 0.0), 1.0);

      x[a] = scene->lo[a] + s * (scene->hi[a] - scene->lo[a]);
    }
    if (scene->n_bodies && m % 2) (void)BodyPoint(SceneBody(scene, 0), m % 6, scene->dx, x, normal);
    for (PetscInt a = 0; a < scene->dim; a++) exact += g[a] * x[a] / scene->dx;
    if (scene->n_bodies && SceneDistance(scene, x, &(PetscInt){0}, normal) < -1e-12) continue;
    ASSERT_OK(SplinesPressure(&f->splines, f->flow.particles, x, &p));
    assert_int_equal(MPI_Allreduce(MPI_IN_PLACE, &p, 1, MPIU_REAL, MPIU_SUM, PETSC_COMM_WORLD), 0);
    CloudAssertNone("pressure at a point", box->name, !(PetscAbsReal(p - exact) < 1e-10));
  }
}

/* Factors of 1, s, s^2 and s^3 along each axis. */
static const PetscReal terms[ISPH_MAX_DIM][4] = {
    {1.0, 0.3, 0.7, 0.9}, {1.0, -0.2, 0.9, 0.3}, {1.0, -0.7, 1.1, -0.3}};

/* Returns the polynomial along axis a; splines of degree 2 have no cube. */
static PetscReal Polynomial(PetscInt degree, PetscInt a, PetscReal s)
{
  const PetscReal cube = degree == 3 ? terms[a][3] : 0.0;

  return terms[a][0] + s * (terms[a][1] + s * (terms[a][2] + s * cube));
}

static PetscReal PolynomialSlope(PetscInt degree, PetscInt a, PetscReal s)
{
  const PetscReal cube = degree == 3 ? terms[a][3] : 0.0;

  return terms[a][1] + s * (2.0 * terms[a][2] + 3.0 * s * cube);
}

/*
  Returns the coefficient of the spline with the centre s: for 1 and s it is 1 and s, for s^2 it is
  s^2 - H^2/4 with quadratic splines, and for s^2 and s^3 it is s^2 - H^2/3 and s^3 - s H^2 with
  cubic ones, H the distance of knots

  Reference: M. J. Marsden, J. Approx. Theory 3 (1970) 7-49
*/
static PetscReal PolynomialCoefficient(PetscInt degree, PetscInt a, PetscReal s, PetscReal H)
{
  const PetscReal square = terms[a][2], cube = degree == 3 ? terms[a][3] : 0.0;

  return Polynomial(degree, a, s) - H * H * (square / (degree == 3 ? 3.0 : 4.0) + s * cube);
}

/* Sets the coefficients to those of the product of polynomials of the axes. */
static void SetPolynomial(Fixture *f)
{
  const SplineLattice *l = &f->splines.pressure;
  PetscScalar         *p;

  ASSERT_OK(VecGetArray(f->splines.p, &p));
  for (PetscInt k = 0; k < f->splines.own.size; k++) {
    PetscInt index[ISPH_MAX_DIM];

    (void)SplineOwn(&f->splines, k, index);
    p[k] = 1.0;
    for (PetscInt a = 0; a < l->dim; a++)
      p[k] *= PolynomialCoefficient(l->degree, a, (index[a] - 0.5) * l->side[a], l->side[a]);
  }
  ASSERT_OK(VecRestoreArray(f->splines.p, &p));
}

/* Subtracts the product of polynomials, or its derivative along an axis, from a field. */
static void SubtractPolynomial(const Fixture *f, PetscInt axis, Vec field)
{
  const SplineLattice *l = &f->splines.pressure;
  const Particles     *p = f->cloud.particles;
  PetscScalar         *v;

  ASSERT_OK(VecGetArray(field, &v));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscReal exact = 1.0;

    for (PetscInt a = 0; a < l->dim; a++) {
      const PetscReal s = p->x[a][i] - l->lo[a];

      exact *= a == axis ? PolynomialSlope(l->degree, a, s) : Polynomial(l->degree, a, s);
    }
    v[i] -= exact;
  }
  ASSERT_OK(VecRestoreArray(field, &v));
}

/* Splines give polynomials of their degree, and gradients, exactly, also beside walls and bodies.
 */
static void TryPolynomials(const CloudBox *box, Fixture *f)
{
  if (box->n_periodic) return;
  SetPolynomial(f);
  ASSERT_OK(SplinesValue(&f->splines, f->splines.p, f->cloud.y));
  SubtractPolynomial(f, -1, f->cloud.y);
  AssertNorm("value of a polynomial", box->name, f->cloud.y, 1e-12);
  for (PetscInt a = 0; a < box->dim; a++) ASSERT_OK(VecSet(f->cloud.f[a], 0.0));
  ASSERT_OK(SplinesAccelerate(&f->splines, f->splines.p, 1.0, f->cloud.f));
  for (PetscInt a = 0; a < box->dim; a++) {
    SubtractPolynomial(f, a, f->cloud.f[a]);
    AssertNorm("gradient of a polynomial", box->name, f->cloud.f[a], 1e-11);
  }
}

static void test_box(void **state)
{
  const CloudBox *box    = *state;
  const PetscInt  number = (PetscInt)(box - boxes);

  for (PetscInt degree = 2; degree <= (number < QUARTIC ? 4 : 2); degree += 2) {
    Fixture f;

    Setup(box, degree, &f);
    CloudAssertNone("cubic splines of quartic fits", box->name,
                    f.splines.pressure.degree != (degree == 4 && box->circle == 0.0 ? 3 : 2));
    TrySpace(box, &f);
    TryInverse(box, &f);
    TryUnity(box, &f);
    TryLinear(box, &f);
    TryRigid(box, &f);
    TryConservation(box, &f);
    TryPoints(box, &f);
    TryPolynomials(box, &f);
    Teardown(&f);
  }
}

int main(int argc, char *argv[])
{
  struct CMUnitTest tests[BOXES];
  int               failed;

  for (size_t k = 0; k < BOXES; k++) {
    tests[k]      = (struct CMUnitTest)cmocka_unit_test_prestate(test_box, (void *)&boxes[k]);
    tests[k].name = boxes[k].name;
  }
  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  return PetscFinalize() || failed;
}
