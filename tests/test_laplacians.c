/*
  Identities of every row of the Laplacian table, on lattices and on disordered clouds, in 2D and
  3D: a form has the properties that it declares, and no others.
*/
/* RANKS: 1 2 */
#include "cloud.h"

/* Returns the largest error of the Laplacian over monomials [first, last), in units of 1/dx^2. */
static PetscReal MonomialError(const Cloud *cloud, PetscInt first, PetscInt last)
{
  PetscReal error, largest = 0.0;

  for (PetscInt k = first; k < last; k++) {
    const Quadratic f = QuadraticMonomial(cloud->scene.dim, k), lap = QuadraticLaplacian(cloud, &f);

    ASSERT_OK(CloudSet(cloud, &f, cloud->f[0]));
    ASSERT_OK(AffineApply(&cloud->ops->velocity[0].visc, cloud->f[0], NULL, cloud->y));
    ASSERT_OK(CloudError(cloud, cloud->y, &lap, PETSC_TRUE, &error));
    largest = PetscMax(largest, error * PetscSqr(cloud->scene.dx));
  }
  return largest;
}

/* Checks on all rows that constants have no Laplacian, unless the form declares otherwise, and that
   the pressure operator is -dx^2 times the viscous operator. */
static void CheckRows(const LaplacianRow *form, const char *where, const Cloud *cloud)
{
  const PetscReal dx2 = PetscSqr(cloud->scene.dx);
  const Quadratic one = {.c = 1.0}, zero = {0};
  PetscReal       error, norm;
  Mat             difference;

  ASSERT_OK(CloudSet(cloud, &one, cloud->f[0]));
  ASSERT_OK(AffineApply(&cloud->ops->velocity[0].visc, cloud->f[0], NULL, cloud->y));
  ASSERT_OK(CloudError(cloud, cloud->y, &zero, PETSC_FALSE, &error));
  CloudAssertNone("null_constants of visc", where,
                  (error * dx2 > 1e-13) == CloudHas(form, FORM_NULL_CONSTANTS));
  ASSERT_OK(AffineApply(&cloud->ops->ppe, cloud->f[0], NULL, cloud->y));
  ASSERT_OK(CloudError(cloud, cloud->y, &zero, PETSC_FALSE, &error));
  CloudAssertNone("row sums of ppe", where, error > 1e-13);
  CloudAssertNone("a fit was not determined", where, cloud->ops->regularised_rows);
  if (!CloudHas(form, FORM_SAFE_IMPLICIT)) return;

  ASSERT_OK(MatDuplicate(cloud->ops->ppe.A, MAT_COPY_VALUES, &difference));
  ASSERT_OK(MatAXPY(difference, dx2, cloud->ops->velocity[0].visc.A, SAME_NONZERO_PATTERN));
  ASSERT_OK(MatNorm(difference, NORM_FROBENIUS, &error));
  ASSERT_OK(MatNorm(cloud->ops->ppe.A, NORM_FROBENIUS, &norm));
  ASSERT_OK(MatDestroy(&difference));
  CloudAssertNone("ppe = -dx^2 visc", where, error > 1e-14 * norm);
}

static void CheckDeclared(const LaplacianRow *form, const char *where, const Cloud *cloud)
{
  const PetscInt  dim       = cloud->scene.dim;
  const PetscReal linear    = MonomialError(cloud, 0, dim),
                  asymmetry = CloudAsymmetry(cloud->ops->velocity[0].visc.A),
                  quadratic = MonomialError(cloud, dim, QuadraticCount(dim));

  if (CloudHas(form, FORM_SYMMETRIC))
    CloudAssertNone("declared symmetric", where, asymmetry > 1e-13);
  if (CloudHas(form, FORM_EXACT_LINEAR))
    CloudAssertNone("declared exact_linear", where, linear > 1e-9);
  if (CloudHas(form, FORM_EXACT_QUADRATIC))
    CloudAssertNone("declared exact_quadratic", where, quadratic > 1e-8);
  if (cloud->scene.jitter == 0.0) {
    /* odd moments vanish: any form that weights neighbours by distance only is exact */
    CloudAssertNone("linear fields on a lattice", where, linear > 1e-9);
    return;
  }
  /* theory.md, (rows:asymmetry): at this jitter asymmetries are 0.018 or more, errors 0.15 or more
   */
  if (!CloudHas(form, FORM_SYMMETRIC))
    CloudAssertNone("symmetric, undeclared", where, asymmetry < 1e-3);
  if (!CloudHas(form, FORM_EXACT_LINEAR))
    CloudAssertNone("exact_linear, undeclared", where, linear < 1e-3);
  if (!CloudHas(form, FORM_EXACT_QUADRATIC))
    CloudAssertNone("exact_quadratic, undeclared", where, quadratic < 1e-3);
}

/* Checks new clouds, then the same clouds after moves, some of which start an epoch. */
static void Declared(PetscInt dim)
{
  for (PetscInt k = 0; k < CloudScalarForms(); k++) {
    const LaplacianRow *form = CloudLaplacian(k);

    for (PetscReal jitter = 0.0; jitter < 0.3; jitter += 0.25) {
      const CloudBox box = CloudPeriodic(dim, jitter);
      Cloud          cloud;
      char           where[128];

      ASSERT_OK(PetscSNPrintf(where, sizeof(where), "%s, %s", form->name, box.name));
      CloudCreateForm(&box, "", form, &cloud);
      CheckRows(form, where, &cloud);
      CheckDeclared(form, where, &cloud);
      for (PetscInt move = 0; move < 3 && jitter > 0.0; move++) {
        ASSERT_OK(CloudMove(0.03, move % 2 == 0, 0.01 * move, &cloud));
        CheckRows(form, where, &cloud);
        CheckDeclared(form, where, &cloud);
      }
      ASSERT_OK(CloudDestroy(&cloud));
    }
  }
}

static void test_declared_2d(void **state)
{
  (void)state;
  Declared(2);
}

static void test_declared_3d(void **state)
{
  (void)state;
  Declared(3);
}

/*
  Computes the least real part of the eigenvalues of -L dx^2 on a periodic cloud of one rank, L:
  Laplacian, and the number of eigenvalues that do not exceed rounding. A zero eigenvalue belongs to
  the constants.
*/
static void LeastEigenvalue(const Cloud *cloud, PetscReal *least, PetscInt *not_positive)
{
  const PetscInt n = cloud->particles->N_fluid;
  PetscReal     *re, *im;
  KSP            ksp;
  PC             pc;

  ASSERT_OK(PetscMalloc2(n, &re, n, &im));
  ASSERT_OK(KSPCreate(PETSC_COMM_WORLD, &ksp));
  ASSERT_OK(KSPSetOperators(ksp, cloud->ops->velocity[0].visc.A, cloud->ops->velocity[0].visc.A));
  ASSERT_OK(KSPGetPC(ksp, &pc));
  ASSERT_OK(PCSetType(pc, PCNONE));
  ASSERT_OK(KSPSetUp(ksp));
  ASSERT_OK(KSPComputeEigenvaluesExplicitly(ksp, n, re, im));
  *least        = PETSC_MAX_REAL;
  *not_positive = 0;
  for (PetscInt k = 0; k < n; k++) {
    const PetscReal value = -re[k] * PetscSqr(cloud->scene.dx);

    *least = PetscMin(*least, value);
    if (value < 1e-9) (*not_positive)++;
  }
  ASSERT_OK(KSPDestroy(&ksp));
  ASSERT_OK(PetscFree2(re, im));
}

/*
  Tests the property safe_implicit: all eigenvalues of -L except the zero of the constants have
  positive real parts on disordered clouds of jitter 0.25 dx and 0.5 dx. A form without this
  property has an eigenvalue below -0.05/dx^2 on each cloud: theory.md, (rows:modes), the last
  table.
*/
static void test_safe_implicit(void **state)
{
  PetscMPIInt ranks;

  (void)state;
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  if (ranks > 1) return;
  for (PetscInt m = 0; m < CloudScalarForms(); m++) {
    const LaplacianRow *form = CloudLaplacian(m);

    for (PetscInt dim = 2; dim <= 3; dim++) {
      for (PetscReal jitter = 0.25; jitter < 0.6; jitter += 0.25) {
        const PetscInt side = dim == 2 ? 14 : 6;
        const CloudBox box  = {
             .dim = dim, .cells = {side, side, side}, .n_periodic = dim, .jitter = jitter};
        PetscReal least;
        PetscInt  not_positive;
        Cloud     cloud;

        CloudCreateForm(&box, "", form, &cloud);
        LeastEigenvalue(&cloud, &least, &not_positive);
        if (CloudHas(form, FORM_SAFE_IMPLICIT))
          CloudAssertNone("safe_implicit", form->name, not_positive != 1);
        else CloudAssertNone("safe_implicit, undeclared", form->name, least > -0.05);
        ASSERT_OK(CloudDestroy(&cloud));
      }
    }
  }
}

/*
  Particles drift and crowd together while the margin of the neighbour list grows. The numbers of
  rows and of entries of a rank exceed the allocated storage at different times (a fault would be
  found by the sanitizers), and row sums stay zero.
*/
static void test_reassembly(void **state)
{
  const CloudBox  box = {.dim = 2, .cells = {20, 17, 1}, .n_periodic = 2, .jitter = 0.25};
  const Quadratic one = {.c = 1.0}, zero = {0};
  Cloud           cloud;
  PetscReal       error;

  (void)state;
  ASSERT_OK(CloudCreate(&box, "", &cloud));
  for (PetscInt move = 0; move < 24; move++) {
    const Particles *p = cloud.particles;

    for (PetscInt i = 0; i < p->n_fluid; i++) {
      const PetscReal phase =
          (p->x[0][i] - cloud.scene.lo[0]) / (cloud.scene.hi[0] - cloud.scene.lo[0]);

      p->x[0][i] += 0.05 * cloud.scene.dx * (2.0 - PetscSinReal(2.0 * PETSC_PI * phase));
    }
    ASSERT_OK(CloudMove(0.02, move % 2, 5e-4 * move, &cloud));
    ASSERT_OK(CloudSet(&cloud, &one, cloud.f[0]));
    ASSERT_OK(AffineApply(&cloud.ops->velocity[0].visc, cloud.f[0], NULL, cloud.y));
    ASSERT_OK(CloudError(&cloud, cloud.y, &zero, PETSC_FALSE, &error));
    CloudAssertNone("row sums", "crowded", error * PetscSqr(cloud.scene.dx) > 1e-12);
  }
  ASSERT_OK(CloudDestroy(&cloud));
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_declared_2d),
      cmocka_unit_test(test_declared_3d),

      cmocka_unit_test(test_safe_implicit),
      cmocka_unit_test(test_reassembly),
  };
  int failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
  return PetscFinalize() || failed ? 1 : 0;
}
