/*
  Laplacians on lattices: order of accuracy, second moments and closed forms, among them Table 1 of
  Zheng, Ma & Shao (2018).
*/
/* RANKS: 1 2 */
#include "cloud.h"

/*
  Returns the relative L2 error of lap f = -2 k^2 f for f = sin(k x + 1) sin(k y + 2), a wave along
  each side of the box.
*/
static PetscReal WaveError(PetscInt dim, PetscInt n, const LaplacianRow *form)
{
  const CloudBox   box = {.dim = dim, .cells = {n, n, 4}, .n_periodic = dim};
  const PetscReal *x[2];
  Cloud            cloud;
  PetscReal       *f, k, error, norm;

  CloudCreateForm(&box, "-kernel cubic_spline -h_over_dx 1.5", form, &cloud);
  k = 2.0 * PETSC_PI / (n * cloud.scene.dx);
  for (PetscInt a = 0; a < 2; a++) x[a] = cloud.particles->x[a];
  ASSERT_OK(VecGetArray(cloud.f[0], &f));
  for (PetscInt i = 0; i < cloud.particles->n_fluid; i++)
    f[i] = PetscSinReal(k * x[0][i] + 1.0) * PetscSinReal(k * x[1][i] + 2.0);
  ASSERT_OK(VecRestoreArray(cloud.f[0], &f));
  ASSERT_OK(AffineApply(&cloud.ops->velocity[0].visc, cloud.f[0], NULL, cloud.y));
  ASSERT_OK(VecNorm(cloud.f[0], NORM_2, &norm));
  ASSERT_OK(VecAXPY(cloud.y, 2.0 * k * k, cloud.f[0]));
  ASSERT_OK(VecNorm(cloud.y, NORM_2, &error));
  ASSERT_OK(CloudDestroy(&cloud));
  return error / (2.0 * k * k * norm);
}

/* On lattices every form with corrected moments has order 2. */
static void test_order_on_lattice(void **state)
{
  (void)state;
  for (PetscInt m = 0; m < CloudScalarForms(); m++) {
    const LaplacianRow *form = CloudLaplacian(m);

    for (PetscInt dim = 2; dim <= 3 && !CloudHas(form, FORM_SYMMETRIC); dim++) {
      const PetscInt  n     = dim == 2 ? 20 : 16; /* the finer lattice: 40 in 2D, 24 in 3D */
      const PetscReal ratio = dim == 2 ? 2.0 : 1.5;
      const PetscReal error = WaveError(dim, n, form);
      const PetscReal finer = WaveError(dim, (PetscInt)(ratio * n), form);
      const PetscReal order = PetscLogReal(error / finer) / PetscLogReal(ratio);

      CloudAssertNone("order 2 on a lattice", form->name, !(order > 1.9 && order < 2.1));
    }
  }
}

/*
  A form without corrected moments returns S lap |x|^2 = 2 dim S on a lattice: theory.md,
  (rows:factor). Its table gives 100 (S - 1) with one decimal for the square lattice and the cubic
  spline.
*/
static void test_second_moment(void **state)
{
  static const char *const names[3] = {"morris", "gotoh", "direct_scalar"};
  static const struct {
    PetscReal h_over_dx, percent[3];
  } known[] = {{1.0, {1.3, -0.6, -2.5}}, {1.1, {-0.3, -7.9, -15.5}}, {1.2, {-0.9, 4.4, 9.7}},
               {1.3, {1.1, 6.2, 11.3}},  {1.5, {0.7, -5.2, -11.1}},  {2.0, {-0.1, 0.1, 0.3}}};

  (void)state;
  for (size_t q = 0; q < PETSC_STATIC_ARRAY_LENGTH(known); q++) {
    for (PetscInt m = 0; m < 3; m++) {
      const CloudBox  box = CloudPeriodic(2, 0.0);
      const TableRow *row;
      Quadratic       f = {.H = {{2.0, 0.0}, {0.0, 2.0}}}, lap;
      Cloud           cloud;
      PetscReal       error;
      char            kernel[64];

      ASSERT_OK(TableFind(&LaplacianTable, names[m], &row));
      ASSERT_OK(PetscSNPrintf(kernel, sizeof(kernel), "-kernel cubic_spline -h_over_dx %g",
                              (double)known[q].h_over_dx));
      CloudCreateForm(&box, kernel, (const LaplacianRow *)(const void *)row, &cloud);
      lap = QuadraticLaplacian(&cloud, &f);
      lap.c *= 1.0 + 0.01 * known[q].percent[m];
      ASSERT_OK(CloudSet(&cloud, &f, cloud.f[0]));
      ASSERT_OK(AffineApply(&cloud.ops->velocity[0].visc, cloud.f[0], NULL, cloud.y));
      ASSERT_OK(CloudError(&cloud, cloud.y, &lap, PETSC_TRUE, &error));
      CloudAssertNone("second moment", names[m], error > 0.00055 * PetscAbsReal(lap.c));
      ASSERT_OK(CloudDestroy(&cloud));
    }
  }
}

/*
  Returns the factor S with which a form computes lap |x|^2 on a square lattice with h = dx and the
  cubic spline: theory.md, (rows:lattice), from four neighbours at dx and four at sqrt(2) dx.
*/
static PetscReal FactorAtDx(const LaplacianRow *form)
{
  const PetscReal sigma = 10.0 / (7.0 * PETSC_PI), root = PetscSqrtReal(2.0), b = 2.0 - root;
  const struct {
    const char *name;
    PetscReal   factor;
  } pairwise[] = {
      {"morris", sigma * (1.5 + 1.5 * root * b * b)},
      {"gotoh", sigma * (1.125 + 1.5 * b + 0.75 * b * b / root)},
      {"direct_scalar", sigma * (0.75 + 3.0 * b - 1.5 * b * b / root)},
  };

  assert_true(PetscAbsReal(pairwise[0].factor / 1.013099 - 1.0) < 1e-6);
  assert_true(PetscAbsReal(pairwise[1].factor / 0.993882 - 1.0) < 1e-6);
  assert_true(PetscAbsReal(pairwise[2].factor / 0.975 - 1.0) < 1e-3);
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(pairwise); k++) {
    PetscBool same;

    ASSERT_OK(PetscStrcmp(pairwise[k].name, form->name, &same));
    if (same) return pairwise[k].factor;
  }
  return CloudHas(form, FORM_SYMMETRIC) ? NAN : 1.0; /* NAN: no closed form is known */
}

/*
  Returns the error of Table 1 of X. Zheng, Q. Ma, S. Shao, Water 10 (2018): theory.md,
  (rows:printed)

    (1/M) sum |numerical - exact| / sum |exact|,   exact = 12 |x|^2,   M = (N-3)^2

  for f = x^4 + y^4 as in (rows:quartic), with nodes i dx, i = 0..N, dx = 1/N and h = dx; the sums
  are over i = 2..N-2. Output: worst - largest difference from the closed form (rows:quartic).
*/
static PetscReal ZhengError(PetscInt N, const LaplacianRow *form, PetscReal *worst)
{
  const CloudBox   box = {.dim = 2, .cells = {N + 1, N + 1, 1}, .n_periodic = 2};
  const PetscReal  dx = 1.0 / N, S = FactorAtDx(form), *lap;
  Cloud            cloud;
  const Particles *p;
  PetscReal       *f, unit, sum[3] = {0.0};

  CloudCreateForm(&box, "-kernel cubic_spline -h_over_dx 1", form, &cloud);
  p    = cloud.particles;
  unit = dx / cloud.scene.dx; /* ratio of lengths in the paper and in the cloud */
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    for (PetscInt a = 0; a < 2; a++)
      p->x[a][i] = unit * (p->x[a][i] - cloud.scene.lo[a]) - 0.5 * dx;
  }
  ASSERT_OK(VecGetArray(cloud.f[0], &f));
  for (PetscInt i = 0; i < p->n_fluid; i++)
    f[i] = PetscPowRealInt(p->x[0][i], 4) + PetscPowRealInt(p->x[1][i], 4);
  ASSERT_OK(VecRestoreArray(cloud.f[0], &f));
  ASSERT_OK(AffineApply(&cloud.ops->velocity[0].visc, cloud.f[0], NULL, cloud.y));
  *worst = 0.0;
  ASSERT_OK(VecGetArrayRead(cloud.y, &lap));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    const PetscReal x = p->x[0][i], y = p->x[1][i], exact = 12.0 * (x * x + y * y);
    const PetscReal numerical = lap[i] / PetscSqr(unit);

    if (PetscMin(x, y) < 1.5 * dx || PetscMax(x, y) > 1.0 - 1.5 * dx) continue;
    *worst = PetscMax(*worst, PetscAbsReal(numerical - S * (exact + 4.0 * dx * dx)));
    sum[0] += PetscAbsReal(numerical - exact);
    sum[1] += exact;
    sum[2] += 1.0;
  }
  ASSERT_OK(VecRestoreArrayRead(cloud.y, &lap));
  MPI_Allreduce(MPI_IN_PLACE, sum, 3, MPIU_REAL, MPI_SUM, PETSC_COMM_WORLD);
  MPI_Allreduce(MPI_IN_PLACE, worst, 1, MPIU_REAL, MPI_MAX, PETSC_COMM_WORLD);
  ASSERT_OK(CloudDestroy(&cloud));
  CloudAssertNone("nodes sampled", form->name, sum[2] != PetscSqr(N - 3.0));
  return sum[0] / sum[1] / sum[2];
}

static void test_zheng_table_1(void **state)
{
  static const struct {
    const char *name;
    PetscInt    N;
    PetscReal   printed;
  } entries[] = {{"morris", 20, 5.00e-5}, {"morris", 40, 9.81e-6},    {"gotoh", 20, 1.68e-5},
                 {"gotoh", 40, 4.24e-6},  {"schwaiger", 20, 4.65e-6}, {"schwaiger", 40, 2.37e-7}};

  (void)state;
  for (size_t e = 0; e < PETSC_STATIC_ARRAY_LENGTH(entries); e++) {
    const TableRow *row;
    PetscReal       worst, error;

    ASSERT_OK(TableFind(&LaplacianTable, entries[e].name, &row));
    assert_non_null(row);
    error = ZhengError(entries[e].N, (const LaplacianRow *)(const void *)row, &worst);
    CloudAssertNone("printed value", row->name,
                    PetscAbsReal(error / entries[e].printed - 1.0) > 3e-3); /* three digits */
  }
}

/* Checks the closed form (rows:quartic), from which the table follows, and lap |x|^2 = 4 S on a
   lattice. */
static void test_closed_form(void **state)
{
  (void)state;
  for (PetscInt k = 0; k < CloudScalarForms(); k++) {
    const LaplacianRow *form = CloudLaplacian(k);
    const CloudBox      box  = CloudPeriodic(2, 0.0);
    Quadratic           f    = {.H = {{2.0, 0.0}, {0.0, 2.0}}}, lap;
    Cloud               cloud;
    PetscReal           error, worst;

    if (PetscIsNanReal(FactorAtDx(form))) continue;
    (void)ZhengError(20, form, &worst);
    CloudAssertNone("S (12 |x|^2 + 4 dx^2)", form->name, worst > 1e-9);
    CloudCreateForm(&box, "-kernel cubic_spline -h_over_dx 1", form, &cloud);
    lap = QuadraticLaplacian(&cloud, &f);
    lap.c *= FactorAtDx(form);
    ASSERT_OK(CloudSet(&cloud, &f, cloud.f[0]));
    ASSERT_OK(AffineApply(&cloud.ops->velocity[0].visc, cloud.f[0], NULL, cloud.y));
    ASSERT_OK(CloudError(&cloud, cloud.y, &lap, PETSC_TRUE, &error));
    CloudAssertNone("|x|^2 at h = dx", form->name, error > 1e-10 * lap.c);
    ASSERT_OK(CloudDestroy(&cloud));
  }
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_order_on_lattice), cmocka_unit_test(test_second_moment),
      cmocka_unit_test(test_zheng_table_1), cmocka_unit_test(test_closed_form)};
  int failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
  return PetscFinalize() || failed ? 1 : 0;
}
