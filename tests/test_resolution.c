/*
  The estimated error of the velocity: the gradients of its two fits are exact for polynomials of
  their degree, beside every kind of wall, and have closed forms on a lattice.
*/
/* RANKS: 1 2 */
#include "cloud.h"
#include "isph/schemes.h"
#include "isph/io.h"

/* A field of the scaled coordinates s = (x - centre)/dx with its gradient [1/m]. */
typedef PetscReal (*Shape)(const PetscReal s[], PetscReal gradient[]);

/* Computes 1 + s_x - 2 s_y + s_x s_y + s_y^2. */
static PetscReal QuadraticField(const PetscReal s[], PetscReal g[])
{
  g[0] = 1.0 + s[1];
  g[1] = -2.0 + s[0] + 2.0 * s[1];
  g[2] = 0.0;
  return 1.0 + s[0] - 2.0 * s[1] + s[0] * s[1] + s[1] * s[1];
}

/* Computes s_x^3 - s_x s_y^2. */
static PetscReal CubicField(const PetscReal s[], PetscReal g[])
{
  g[0] = 3.0 * s[0] * s[0] - s[1] * s[1];
  g[1] = -2.0 * s[0] * s[1];
  g[2] = 0.0;
  return s[0] * s[0] * s[0] - s[0] * s[1] * s[1];
}

static void Scale(const Scene *scene, const PetscReal x[], PetscReal s[])
{
  for (PetscInt a = 0; a < scene->dim; a++)
    s[a] = (x[a] - 0.5 * (scene->lo[a] + scene->hi[a])) / scene->dx;
}

/* Sets the first component of the velocity to a field, on walls to its value at the surface, and
   the second to -2 times this field. */
static void SetVelocity(const Cloud *cloud, Shape field)
{
  const Particles *p = cloud->particles;

  for (PetscInt i = 0; i < ParticlesOwn(p); i++) {
    PetscReal x[3] = {0.0}, s[3] = {0.0}, g[3];

    for (PetscInt a = 0; a < p->dim; a++) x[a] = p->x[a][i];
    if (ParticlesIsWall(p, i)) ParticlesWallPoint(p, i, x);
    Scale(&cloud->scene, x, s);
    p->u[0][i] = field(s, g);
    p->u[1][i] = -2.0 * field(s, g);
    if (p->dim > 2) p->u[2][i] = 0.0;
  }
}

/* Checks that the gradient is exact, and the difference zero if the quadratic fit is exact too. */
static void CheckExact(const char *where, Cloud *cloud, Shape field, PetscBool quadratic)
{
  const Particles *p       = cloud->particles;
  const PetscInt   entries = p->dim * p->dim;
  PetscReal       *gradient, *difference, worst = 0.0, apart = 0.0;

  ASSERT_OK(PetscMalloc2(p->n_fluid * entries, &gradient, p->n_fluid, &difference));
  SetVelocity(cloud, field);
  for (PetscInt c = 0; c < p->dim; c++) ASSERT_OK(ParticlesHaloField(p, p->u[c]));
  ASSERT_OK(OperatorsCompareGradients(&cloud->scene, p, cloud->neighbors, cloud->ops,
                                      &(GradientComparison){0, p->n_fluid, gradient, difference}));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscReal x[3] = {0.0}, s[3] = {0.0}, g[3];

    for (PetscInt a = 0; a < p->dim; a++) x[a] = p->x[a][i];
    Scale(&cloud->scene, x, s);
    (void)field(s, g);
    for (PetscInt a = 0; a < p->dim; a++) {
      const PetscReal *row = &gradient[i * entries];

      worst = PetscMax(worst, PetscAbsReal(row[a] * cloud->scene.dx - g[a]));
      worst = PetscMax(worst, PetscAbsReal(row[p->dim + a] * cloud->scene.dx + 2.0 * g[a]));
    }
    apart = PetscMax(apart, difference[i] * cloud->scene.dx);
  }
  CloudAssertNone("gradient of the cubic fit", where, worst > 1e-8);
  if (quadratic) CloudAssertNone("no difference", where, apart > 1e-8);
  ASSERT_OK(PetscFree2(gradient, difference));
}

static void test_exact(void **state)
{
  const char *const options[] = {"", "-wall dummy_linear", "-wall dummy_linear -wall_surface"};

  (void)state;
  for (PetscInt dim = 2; dim <= 3; dim++) {
    for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(options); k++) {
      const CloudBox box = {.name = options[k], .dim = dim, .cells = {8, 9, 7}, .jitter = 0.2};
      Cloud          cloud;

      ASSERT_OK(CloudCreate(&box, options[k], &cloud));
      CheckExact(options[k], &cloud, QuadraticField, PETSC_TRUE);
      CheckExact(options[k], &cloud, CubicField, PETSC_FALSE);
      ASSERT_OK(CloudDestroy(&cloud));
    }
  }
}

/* Returns sum_k W_k f_k over the neighbours k on a square lattice, for f = Y^power sin(wave Y)^sine
   X^across. */
static PetscReal LatticeSum(const Operators *ops, PetscReal dx, PetscInt power, PetscInt across,
                            PetscBool sine, PetscReal wave)
{
  PetscReal sum = 0.0;

  for (PetscInt i = -6; i <= 6; i++) {
    for (PetscInt j = -6; j <= 6; j++) {
      const PetscReal X = dx * i, Y = dx * j;
      PetscReal       w[3];

      KernelEvaluate(ops->forms.kernel, 2, ops->forms.h, PetscSqrtReal(X * X + Y * Y), w);
      sum += w[0] * PetscPowReal(Y, (PetscReal)power) * PetscPowReal(X, (PetscReal)across) *
             (sine ? PetscSinReal(wave * Y) : 1.0);
    }
  }
  return sum;
}

/*
  Returns the factors of cos(wave y_i) in du/dy for u = sin(wave y) on a square lattice. Y, Y^3 and
  X^2 Y are the terms of the fits that are odd in Y and even in X; only they have coefficients.
*/
static PetscReal LatticeSlope(const Operators *ops, PetscReal dx, PetscInt terms, PetscReal wave)
{
  const PetscInt power[] = {1, 3, 1}, across[] = {0, 0, 2};
  PetscReal      A[9], b[3];

  for (PetscInt t = 0; t < terms; t++) {
    b[t] = LatticeSum(ops, dx, power[t], across[t], PETSC_TRUE, wave);
    for (PetscInt q = 0; q < terms; q++)
      A[t * terms + q] =
          LatticeSum(ops, dx, power[t] + power[q], across[t] + across[q], PETSC_FALSE, wave);
  }
  DenseEliminate(terms, A, 1, b); /* A is symmetric */
  return b[0] / A[0];
}

/* Fills a flow from a cloud without scheme. */
static void MakeFlow(Cloud *cloud, Clock *clock, Flow *flow)
{
  static const MotionRow eulerian = {.name = "eulerian"};

  cloud->scene.motion = &eulerian;
  *clock              = (Clock){.t = 1.0};
  *flow               = (Flow){.scene     = &cloud->scene,
                               .clock     = clock,
                               .ops       = cloud->ops,
                               .particles = cloud->particles,
                               .neighbors = cloud->neighbors};
}

/* In a parallel flow nothing is amplified: the estimate is a quarter of the relative difference of
   the gradients, at any time. A fluid at rest has no error. */
static void test_parallel_flow(void **state)
{
  const CloudBox box = {.name = "lattice", .dim = 2, .cells = {16, 16, 1}, .n_periodic = 2};
  PetscReal      quadratic, cubic, wave;
  Resolution     r;
  Cloud          cloud;
  Clock          clock;
  Flow           flow;

  (void)state;
  ASSERT_OK(CloudCreate(&box, "-h_over_dx 1.3", &cloud));
  MakeFlow(&cloud, &clock, &flow);
  cloud.scene.nu = 10.0; /* T is small: rounding of A A gives a rate of 1e-8/s */
  wave           = 2.0 * PETSC_PI / 1.6;
  quadratic      = LatticeSlope(cloud.ops, cloud.scene.dx, 1, wave);
  cubic          = LatticeSlope(cloud.ops, cloud.scene.dx, 3, wave);
  for (PetscInt i = 0; i < ParticlesOwn(cloud.particles); i++) {
    cloud.particles->u[0][i] = PetscSinReal(wave * cloud.particles->x[1][i]);
    cloud.particles->u[1][i] = 0.0;
  }
  ASSERT_OK(ResolutionEstimate(&flow, &r));
  CloudAssertNone("estimate", box.name,
                  PetscAbsReal(r.error / (0.25 * (cubic - quadratic) / cubic) - 1.0) > 1e-9);
  CloudAssertNone("place", box.name,
                  PetscAbsReal(PetscAbsReal(PetscCosReal(wave * r.x[1])) -
                               PetscCosReal(0.5 * wave * cloud.scene.dx)) > 1e-9);
  for (PetscInt i = 0; i < ParticlesOwn(cloud.particles); i++) cloud.particles->u[0][i] = 0.0;
  ASSERT_OK(ResolutionEstimate(&flow, &r));
  CloudAssertNone("rest", box.name, r.error != 0.0);
  ASSERT_OK(CloudDestroy(&cloud));
}

/* The estimate of a flow that amplifies errors grows linearly in time, up to a bound whose excess
   is inversely proportional to the viscosity. */
static void test_growth(void **state)
{
  const CloudBox  box  = {.name = "vortices", .dim = 2, .cells = {16, 16, 1}, .n_periodic = 2};
  const PetscReal t[]  = {0.0, 1.0, 2.0, 1e6, 1e6};
  const PetscReal nu[] = {1e-9, 1e-9, 1e-9, 1e-3, 2e-3};
  PetscReal       wave = 2.0 * PETSC_PI / 1.6, e[5];
  Cloud           cloud;
  Resolution      r;
  Clock           clock;
  Flow            flow;

  (void)state;
  ASSERT_OK(CloudCreate(&box, "", &cloud));
  MakeFlow(&cloud, &clock, &flow);
  for (PetscInt i = 0; i < ParticlesOwn(cloud.particles); i++) {
    const PetscReal x = wave * cloud.particles->x[0][i], y = wave * cloud.particles->x[1][i];

    cloud.particles->u[0][i] = PetscSinReal(x) * PetscCosReal(y);
    cloud.particles->u[1][i] = -PetscCosReal(x) * PetscSinReal(y);
  }
  for (PetscInt k = 0; k < 5; k++) {
    clock.t        = t[k];
    cloud.scene.nu = nu[k];
    ASSERT_OK(ResolutionEstimate(&flow, &r));
    e[k] = r.error;
  }
  CloudAssertNone("in time", box.name, PetscAbsReal((e[2] - e[0]) / (e[1] - e[0]) - 2.0) > 1e-9);
  CloudAssertNone("growth", box.name, !(e[1] > 2.0 * e[0]));
  CloudAssertNone("bound", box.name, PetscAbsReal((e[3] - e[0]) / (e[4] - e[0]) - 2.0) > 1e-9);
  ASSERT_OK(CloudDestroy(&cloud));
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_exact),
      cmocka_unit_test(test_parallel_flow),
      cmocka_unit_test(test_growth),
  };
  int failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
  return PetscFinalize() || failed ? 1 : 0;
}
