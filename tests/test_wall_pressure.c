/*
  Identities of the pressure beside walls, for every wall treatment without extension and all forms
  that work with it, on lattices and on disordered clouds, in 2D and 3D.
*/
/* RANKS: 1 2 */
#include "walled.h"

/* Checks lap p for a given wall pressure gradient, on lattices and for forms that are exact for
   linear fields. */
static void CheckLaplacian(const Quadratic *p, const WalledForms *forms, const char *where,
                           Cloud *cloud)
{
  const PetscBool even  = cloud->scene.jitter == 0.0 ? PETSC_TRUE : PETSC_FALSE;
  const Quadratic exact = QuadraticLaplacian(cloud, p);

  if (!even && !(forms->laplacian->properties & FORM_EXACT_LINEAR)) return;
  ASSERT_OK(CloudSet(cloud, p, cloud->f[0]));
  ASSERT_OK(CloudSetSlope(cloud, p, cloud->e));
  ASSERT_OK(AffineApply(&cloud->ops->ppe, cloud->f[0], cloud->e, cloud->y));
  ASSERT_OK(VecScale(cloud->y, -1.0 / PetscSqr(cloud->scene.dx)));
  WalledAssert("lap p", where, cloud, cloud->y, &exact, 2, 1e-8);
}

/* Checks grad p for a given wall pressure gradient, for forms that are exact for linear fields. */
static void CheckGradient(const Quadratic *p, const WalledForms *forms, const char *where,
                          Cloud *cloud)
{
  if (!(forms->gradient->properties & FORM_EXACT_LINEAR)) return;
  ASSERT_OK(CloudSet(cloud, p, cloud->f[0]));
  ASSERT_OK(CloudSetSlope(cloud, p, cloud->e));
  for (PetscInt a = 0; a < cloud->scene.dim; a++) {
    const Quadratic exact = QuadraticDerivative(cloud, p, a);

    ASSERT_OK(AffineApply(&cloud->ops->grad_p[a], cloud->f[0], cloud->e, cloud->y));
    WalledAssert("grad p", where, cloud, cloud->y, &exact, 1, 1e-8);
  }
}

/* Checks the hydrostatic pressure p = rho f.x with f normal to the walls, which is exact with every
   wall treatment. */
static void CheckHydrostatic(const WalledForms *forms, const char *where, Cloud *cloud)
{
  Quadratic p = {.c = 2.0};

  p.g[cloud->scene.dim - 1] = -1.3;
  CheckLaplacian(&p, forms, where, cloud);
  CheckGradient(&p, forms, where, cloud);
}

/*
  Checks linear pressures in a closed box. Fits use the wall pressure gradient at the wall point. At
  dummies the pressure is continued along the wall with the gradient of the row, theory.md,
  (walls:pressure). A symmetric Laplacian omits this continuation, and so does a Laplacian with an
  inexact gradient: they are not checked.
*/
static void CheckLinearPressure(const WalledForms *forms, const char *where, Cloud *cloud)
{
  const PetscBool follows = !(forms->laplacian->properties & FORM_SYMMETRIC) &&
                            (forms->gradient->properties & FORM_EXACT_LINEAR);

  for (PetscInt k = 0; k < cloud->scene.dim; k++) {
    const Quadratic p = QuadraticMonomial(cloud->scene.dim, k);

    if (follows) CheckLaplacian(&p, forms, where, cloud);
    CheckGradient(&p, forms, where, cloud);
  }
}

/* Checks quadratic pressures, which are exact for fits with equations of walls. Dummies have no
   second derivative and are not checked. */
static void CheckQuadraticPressure(const WalledForms *forms, const char *where, Cloud *cloud)
{
  const PetscInt dim = cloud->scene.dim;

  if (!forms->wall->on_surface || !(forms->laplacian->properties & FORM_EXACT_QUADRATIC)) return;
  for (PetscInt k = dim; k < QuadraticCount(dim); k++) {
    const Quadratic p = QuadraticMonomial(dim, k);

    CheckLaplacian(&p, forms, where, cloud);
    CheckGradient(&p, forms, where, cloud);
  }
}

/* Checks that the matrix of a symmetric form is symmetric beside walls too. */
static void CheckSymmetry(const WalledForms *forms, const char *where, Cloud *cloud)
{
  PetscBool symmetric = PETSC_TRUE;

  if (forms->laplacian->properties & FORM_SYMMETRIC)
    ASSERT_OK(MatIsSymmetric(cloud->ops->ppe.A, 1e-12, &symmetric));
  CloudAssertNone("symmetry", where, !symmetric);
}

/* Makes all checks on the same operators, which take most of the time. */
static void CheckClosed(const WalledForms *forms, const char *where, Cloud *cloud)
{
  CheckLinearPressure(forms, where, cloud);
  CheckQuadraticPressure(forms, where, cloud);
  CheckSymmetry(forms, where, cloud);
}

static void test_channel(void **state)
{
  (void)state;
  WalledForAll(PETSC_FALSE, CheckHydrostatic);
}

static void test_closed(void **state)
{
  (void)state;
  WalledForAll(PETSC_TRUE, CheckClosed);
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_channel), cmocka_unit_test(test_closed)};
  int                     failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
  return PetscFinalize() || failed ? 1 : 0;
}
