/*
  Identities of every row of the wall table with all forms it can meet: what a fluid bounded by
  walls must reproduce exactly, on lattices and on disordered clouds, in two and three dimensions.
*/
/* RANKS: 1 2 */
#include "cloud.h"

#define JITTER 0.2 /* [dx] */

typedef struct {
  const WallRow      *wall;
  const LaplacianRow *laplacian;
  const GradientRow  *gradient;
} Forms;

static const WallRow *Wall(PetscInt k)
{
  return (const WallRow *)(const void *)TableGet(&WallTable, k);
}

static const GradientRow *Gradient(PetscInt k)
{
  return (const GradientRow *)(const void *)TableGet(&GradientTable, k);
}

/* Whether a form cannot take the roles of wall particles. */
static PetscBool Blind(unsigned properties)
{
  return (properties & FORM_FULL_SUPPORT) ? PETSC_TRUE : PETSC_FALSE;
}

/* Whether a form can do with what a treatment puts behind the wall. */
static PetscBool Meets(const WallRow *wall, PetscBool full_support)
{
  return (!wall->on_surface || !full_support) ? PETSC_TRUE : PETSC_FALSE;
}

/* Every wall treatment with every Laplacian and one gradient, and the other way round. */
static PetscInt AllForms(Forms forms[], PetscInt most)
{
  const LaplacianRow *some_laplacian = NULL;
  const GradientRow  *some_gradient  = NULL;
  PetscInt            n              = 0;

  for (PetscInt k = 0; k < LaplacianTable.count; k++)
    if (!Blind(CloudLaplacian(k)->properties)) some_laplacian = CloudLaplacian(k);
  for (PetscInt k = 0; k < GradientTable.count; k++)
    if (!Blind(Gradient(k)->properties)) some_gradient = Gradient(k);
  for (PetscInt w = 0; w < WallTable.count; w++) {
    for (PetscInt k = 0; k < LaplacianTable.count; k++) {
      if (!Meets(Wall(w), Blind(CloudLaplacian(k)->properties)) ||
          !CloudHas(CloudLaplacian(k), FORM_SAFE_IMPLICIT))
        continue;
      assert_true(n < most);
      forms[n++] = (Forms){Wall(w), CloudLaplacian(k), some_gradient};
    }
    for (PetscInt k = 0; k < GradientTable.count; k++) {
      if (!Meets(Wall(w), Blind(Gradient(k)->properties)) || Gradient(k) == some_gradient) continue;
      assert_true(n < most);
      forms[n++] = (Forms){Wall(w), some_laplacian, Gradient(k)};
    }
  }
  return n;
}

/*
  Builds the cloud of each combination, in 2D and 3D, on a lattice and on disorder, in a closed box
  or in a channel whose last axis has the walls, and lets check judge it.
*/
static void ForAllForms(PetscBool closed,
                        void (*check)(const Forms *forms, const char *where, Cloud *cloud))
{
  Forms          forms[64];
  const PetscInt n = AllForms(forms, 64);

  for (PetscInt k = 0; k < n; k++) {
    for (PetscInt dim = 2; dim <= 3; dim++) {
      for (PetscInt disorder = 0; disorder < 2; disorder++) {
        const PetscInt narrow = closed ? 4 : 7; /* 7: a periodic axis with interior rows */
        const CloudBox box    = {.cells      = {dim == 2 ? 12 : narrow, dim == 2 ? 9 : narrow, 5},
                                 .dim        = dim,
                                 .n_periodic = closed ? 0 : dim - 1,
                                 .jitter     = disorder ? JITTER : 0.0};
        char           options[256], where[256];
        Cloud          cloud;

        ASSERT_OK(PetscSNPrintf(options, sizeof(options),
                                "-wall %s -visc_laplacian %s -ppe_laplacian %s -gradient %s",
                                forms[k].wall->name, forms[k].laplacian->name,
                                forms[k].laplacian->name, forms[k].gradient->name));
        ASSERT_OK(PetscSNPrintf(where, sizeof(where), "%dD %s, %s", (int)dim,
                                disorder ? "disorder" : "lattice", options));
        ASSERT_OK(CloudCreate(&box, options, &cloud));
        CloudAssertNone("a fit was not determined", where, cloud.ops->weak_rows);
        check(&forms[k], where, &cloud);
        ASSERT_OK(CloudDestroy(&cloud));
      }
    }
  }
}

/* Whether y is the expected field up to tolerance/dx^power. */
static void AssertField(const char *what, const char *where, const Cloud *cloud, Vec y,
                        const Quadratic *expected, PetscInt power, PetscReal tolerance)
{
  PetscReal error;

  ASSERT_OK(CloudError(cloud, y, expected, PETSC_FALSE, &error));
  CloudAssertNone(what, where, !(error * PetscPowRealInt(cloud->scene.dx, power) <= tolerance));
}

/* Gives fluid and walls the velocity u. */
static void SetVelocity(Cloud *cloud, const Quadratic u[])
{
  for (PetscInt c = 0; c < cloud->scene.dim; c++) {
    cloud->wall_u[c] = u[c];
    ASSERT_OK(CloudSet(cloud, &u[c], cloud->f[c]));
  }
  ASSERT_OK(CloudSetWalls(cloud));
}

/* Fluid and walls in one translation under one pressure: nothing is sheared, nothing flows. */
static void CheckConstants(const Forms *forms, const char *where, Cloud *cloud)
{
  const Operators *ops  = cloud->ops;
  const Quadratic  zero = {0}, u[3] = {{.c = 1.0}, {.c = -0.7}, {.c = 0.4}};

  SetVelocity(cloud, u);
  ASSERT_OK(AffineApply(&ops->visc, cloud->f[0], ops->wall_u[0], cloud->y));
  AssertField("lap of constants", where, cloud, cloud->y, &zero, 2, 1e-12);
  for (PetscInt a = 0; a < cloud->scene.dim; a++) {
    ASSERT_OK(AffineApply(&ops->grad_u[a], cloud->f[0], ops->wall_u[0], cloud->y));
    AssertField("grad u of constants", where, cloud, cloud->y, &zero, 1, 1e-12);
    ASSERT_OK(AffineApply(&ops->grad_p[a], cloud->f[0], cloud->e, cloud->y));
    AssertField("grad p of constants", where, cloud, cloud->y, &zero, 1, 1e-12);
  }
  ASSERT_OK(AffineApply(&ops->ppe, cloud->f[0], cloud->e, cloud->y));
  AssertField("ppe of constants", where, cloud, cloud->y, &zero, 0, 1e-12);
  ASSERT_OK(CloudDivergence(cloud, cloud->y));
  AssertField("div of constants", where, cloud, cloud->y, &zero, 1, 1e-12);
}

static void test_constants(void **state)
{
  (void)state;
  ForAllForms(PETSC_TRUE, CheckConstants);
}

/* u = (y, 0) between a wall and a moving lid: no viscous force, the shear rate is that of the lid.
 */
static void CheckCouette(const Forms *forms, const char *where, Cloud *cloud)
{
  const Operators *ops  = cloud->ops;
  const PetscInt   last = cloud->scene.dim - 1;
  const PetscBool  even = cloud->scene.jitter == 0.0 ? PETSC_TRUE : PETSC_FALSE;
  const Quadratic  zero = {0};
  Quadratic        u[3] = {{.c = 0.3}};

  u[0].g[last] = 1.0;
  SetVelocity(cloud, u);
  if (even || (forms->laplacian->properties & FORM_EXACT_LINEAR)) {
    ASSERT_OK(AffineApply(&ops->visc, cloud->f[0], ops->wall_u[0], cloud->y));
    AssertField("lap u of Couette flow", where, cloud, cloud->y, &zero, 2, 1e-9);
  }
  for (PetscInt a = 0; a <= last && (forms->gradient->properties & FORM_EXACT_LINEAR); a++) {
    const Quadratic exact = QuadraticDerivative(cloud, &u[0], a);

    ASSERT_OK(AffineApply(&ops->grad_u[a], cloud->f[0], ops->wall_u[0], cloud->y));
    AssertField("grad u of Couette flow", where, cloud, cloud->y, &exact, 1, 1e-9);
  }
  if (even || (forms->gradient->properties & FORM_EXACT_LINEAR)) {
    ASSERT_OK(CloudDivergence(cloud, cloud->y));
    AssertField("div u of Couette flow", where, cloud, cloud->y, &zero, 1, 1e-9);
  }
}

static void test_couette(void **state)
{
  (void)state;
  ForAllForms(PETSC_FALSE, CheckCouette);
}

/* lap p of a pressure with its normal derivative given, where the form is exact. */
static void CheckLaplacian(const Quadratic *p, const Forms *forms, const char *where, Cloud *cloud)
{
  const PetscBool even  = cloud->scene.jitter == 0.0 ? PETSC_TRUE : PETSC_FALSE;
  const Quadratic exact = QuadraticLaplacian(cloud, p);

  if (!even && !(forms->laplacian->properties & FORM_EXACT_LINEAR)) return;
  ASSERT_OK(CloudSet(cloud, p, cloud->f[0]));
  ASSERT_OK(CloudSetSlope(cloud, p, cloud->e));
  ASSERT_OK(AffineApply(&cloud->ops->ppe, cloud->f[0], cloud->e, cloud->y));
  ASSERT_OK(VecScale(cloud->y, -1.0 / PetscSqr(cloud->scene.dx)));
  AssertField("lap p", where, cloud, cloud->y, &exact, 2, 1e-8);
}

/* grad p of a pressure with its normal derivative given, where the form is exact. */
static void CheckGradient(const Quadratic *p, const Forms *forms, const char *where, Cloud *cloud)
{
  if (!(forms->gradient->properties & FORM_EXACT_LINEAR)) return;
  ASSERT_OK(CloudSet(cloud, p, cloud->f[0]));
  ASSERT_OK(CloudSetSlope(cloud, p, cloud->e));
  for (PetscInt a = 0; a < cloud->scene.dim; a++) {
    const Quadratic exact = QuadraticDerivative(cloud, p, a);

    ASSERT_OK(AffineApply(&cloud->ops->grad_p[a], cloud->f[0], cloud->e, cloud->y));
    AssertField("grad p", where, cloud, cloud->y, &exact, 1, 1e-8);
  }
}

/* What all closures see of a pressure varies along the normal: p = rho f.x, f normal to walls. */
static void CheckHydrostatic(const Forms *forms, const char *where, Cloud *cloud)
{
  Quadratic p = {.c = 2.0};

  p.g[cloud->scene.dim - 1] = -1.3;
  CheckLaplacian(&p, forms, where, cloud);
  CheckGradient(&p, forms, where, cloud);
}

/*
  Any linear pressure in a closed box: fits take n.grad p where it is, dummies follow the gradient
  of the row along the wall. They do not in the Laplacian that must stay symmetric, nor beside a
  gradient that is not exact itself.
*/
static void CheckLinearPressure(const Forms *forms, const char *where, Cloud *cloud)
{
  const PetscBool follows = !(forms->laplacian->properties & FORM_SYMMETRIC) &&
                            (forms->gradient->properties & FORM_EXACT_LINEAR);

  for (PetscInt k = 0; k < cloud->scene.dim; k++) {
    const Quadratic p = QuadraticMonomial(cloud->scene.dim, k);

    if (follows) CheckLaplacian(&p, forms, where, cloud);
    CheckGradient(&p, forms, where, cloud);
  }
}

/* A fit is exact for quadratic pressures too; dummies know no second derivative. */
static void CheckQuadraticPressure(const Forms *forms, const char *where, Cloud *cloud)
{
  const PetscInt dim = cloud->scene.dim;

  if (!forms->wall->on_surface || !(forms->laplacian->properties & FORM_EXACT_QUADRATIC)) return;
  for (PetscInt k = dim; k < QuadraticCount(dim); k++) {
    const Quadratic p = QuadraticMonomial(dim, k);

    CheckLaplacian(&p, forms, where, cloud);
    CheckGradient(&p, forms, where, cloud);
  }
}

/* A matrix that a form calls symmetric is so beside walls. */
static void CheckSymmetry(const Forms *forms, const char *where, Cloud *cloud)
{
  PetscBool symmetric = PETSC_TRUE;

  if (forms->laplacian->properties & FORM_SYMMETRIC)
    ASSERT_OK(MatIsSymmetric(cloud->ops->ppe.A, 1e-12, &symmetric));
  CloudAssertNone("symmetry", where, !symmetric);
}

static void test_pressure(void **state)
{
  (void)state;
  ForAllForms(PETSC_FALSE, CheckHydrostatic);
  ForAllForms(PETSC_TRUE, CheckLinearPressure);
  ForAllForms(PETSC_TRUE, CheckQuadraticPressure);
  ForAllForms(PETSC_TRUE, CheckSymmetry);
}

/* A lid that slides along fluid at rest moves no volume, at the corners neither: div u = 0. */
static void CheckSlidingLid(const Forms *forms, const char *where, Cloud *cloud)
{
  const PetscInt  last    = cloud->scene.dim - 1;
  const Quadratic rest[3] = {{.c = 0.0}};

  for (PetscInt c = 0; c < last; c++) cloud->slide[2 * last + 1][c] = 1.0;
  SetVelocity(cloud, rest);
  ASSERT_OK(CloudDivergence(cloud, cloud->y));
  AssertField("div u under a sliding lid", where, cloud, cloud->y, &rest[0], 1, 1e-14);
}

static void test_sliding_lid(void **state)
{
  (void)state;
  ForAllForms(PETSC_TRUE, CheckSlidingLid);
}

/* Walls that move along their normal with the fluid: div s_n e_n = 1, dummies extrapolate it. */
static void CheckNormalMotion(const Forms *forms, const char *where, Cloud *cloud)
{
  const PetscInt last = cloud->scene.dim - 1;
  Quadratic      u[3] = {{.c = 0.0}}, exact;

  if (!(forms->gradient->properties & FORM_EXACT_LINEAR)) return;
  u[last].c       = 0.2;
  u[last].g[last] = 1.0;
  exact           = QuadraticDerivative(cloud, &u[last], last);
  SetVelocity(cloud, u);
  ASSERT_OK(CloudDivergence(cloud, cloud->y));
  AssertField("div u of normal motion", where, cloud, cloud->y, &exact, 1, 1e-9);
}

/* On a lattice solid body rotation has no divergence, by symmetry, whatever the gradient. */
static void CheckRotation(const Forms *forms, const char *where, Cloud *cloud)
{
  const PetscInt  last = cloud->scene.dim - 1;
  const Quadratic zero = {0};
  Quadratic       u[3] = {{.c = 0.0}};
  PetscReal       error;

  if (cloud->scene.jitter > 0.0) return;
  u[0].g[last] = -1.0;
  u[last].g[0] = 1.0;
  SetVelocity(cloud, u);
  ASSERT_OK(CloudDivergence(cloud, cloud->y));
  ASSERT_OK(CloudError(cloud, cloud->y, &zero, PETSC_TRUE, &error));
  CloudAssertNone("div u of rotation", where, !(error * cloud->scene.dx <= 1e-9));
}

static void AssertDivergence(PetscInt k, const char *where, Cloud *cloud)
{
  for (PetscInt c = 0; c < cloud->scene.dim; c++) {
    Quadratic u[3] = {{.c = 0.0}}, exact;

    u[c]  = QuadraticMonomial(cloud->scene.dim, k);
    exact = QuadraticDerivative(cloud, &u[c], c);
    SetVelocity(cloud, u);
    ASSERT_OK(CloudDivergence(cloud, cloud->y));
    AssertField("div u", where, cloud, cloud->y, &exact, 1, 1e-8);
  }
}

/*
  The divergence of every linear velocity is exact in a closed box, that of the solenoidal ones,
  strain and rotation among them, zero. A vector fit takes n.u_wall where it is. Of a dummy's
  velocity the tangential part is the row's own linear field, the normal one its extrapolation
  through the wall, exact for linear fields as long as no beta is capped: it is at most 1 + 2.3/0.3
  here, from the support 2.6 dx and the least distance 0.3 dx, the cap 10.
*/
static void CheckLinearVelocity(const Forms *forms, const char *where, Cloud *cloud)
{
  if (!(forms->gradient->properties & FORM_EXACT_LINEAR)) return;
  for (PetscInt k = 0; k < cloud->scene.dim; k++) AssertDivergence(k, where, cloud);
}

/* A vector fit is exact for quadratic velocities too. */
static void CheckQuadraticVelocity(const Forms *forms, const char *where, Cloud *cloud)
{
  const PetscInt dim = cloud->scene.dim;

  if (!forms->wall->on_surface || !forms->gradient->DivergenceFit) return;
  for (PetscInt k = dim; k < QuadraticCount(dim); k++) AssertDivergence(k, where, cloud);
}

static void test_divergence(void **state)
{
  (void)state;
  ForAllForms(PETSC_FALSE, CheckNormalMotion);
  ForAllForms(PETSC_FALSE, CheckRotation);
  ForAllForms(PETSC_TRUE, CheckLinearVelocity);
  ForAllForms(PETSC_TRUE, CheckQuadraticVelocity);
}

/* A predicted velocity leaves the wall by slip (n.grad p) n; the particle keeps the wall's own. */
static void CheckSlip(const Forms *forms, const char *where, Cloud *cloud)
{
  const Quadratic  rest[3] = {{.c = 0.0}};
  const Particles *p       = cloud->particles;
  const PetscReal *u;
  PetscInt         wrong = 0;

  SetVelocity(cloud, rest);
  ASSERT_OK(VecSet(cloud->ops->wall_slope_step, 3.0));
  ASSERT_OK(OperatorsSetWallVelocity(&cloud->scene, p, 0.0, 0.5, cloud->ops));
  for (PetscInt a = 0; a < p->dim; a++) {
    ASSERT_OK(VecGetArrayRead(cloud->ops->wall_u[a], &u));
    for (PetscInt k = 0; k < p->n_wall; k++) {
      wrong += u[k] != 1.5 * p->normal[a][p->n_fluid + k];
      wrong += p->u[a][p->n_fluid + k] != 0.0;
    }
    ASSERT_OK(VecRestoreArrayRead(cloud->ops->wall_u[a], &u));
  }
  CloudAssertNone("slip", where, wrong);
}

/* A lattice and what stands for it behind walls is a lattice: C is the same everywhere. */
static void CheckConcentration(const Forms *forms, const char *where, Cloud *cloud)
{
  const Operators *ops   = cloud->ops;
  PetscInt         wrong = 0;
  PetscReal        C     = 0.0;

  if (cloud->scene.jitter > 0.0) return;
  for (PetscInt i = 0; i < cloud->particles->n_fluid; i++) C = PetscMax(C, ops->concentration[i]);
  MPI_Allreduce(MPI_IN_PLACE, &C, 1, MPIU_REAL, MPI_MAX, PETSC_COMM_WORLD);
  for (PetscInt i = 0; i < cloud->particles->n_fluid; i++) {
    wrong += PetscAbsReal(ops->concentration[i] - C) > 1e-12;
    for (PetscInt a = 0; a < cloud->scene.dim; a++)
      wrong += PetscAbsReal(ops->gradient_c[a][i]) * cloud->scene.dx > 1e-12;
  }
  /* the quadrature error of the lattice, a few per cent: OPERATORS.md, section 2, |S - 1| */
  CloudAssertNone("concentration near 1", where, PetscAbsReal(C - 1.0) > 0.05);
  CloudAssertNone("concentration", where, wrong);
}

static void test_wall_data(void **state)
{
  (void)state;
  ForAllForms(PETSC_TRUE, CheckSlip);
  ForAllForms(PETSC_TRUE, CheckConcentration);
}

/* A form blind to walls is refused with particles on the surface and given dummies by default. */
static void CheckRefusal(const char *option, const TableRow *form, PetscBool full_support)
{
  const CloudBox box = {.dim = 2, .cells = {6, 6, 1}};
  char           options[256];

  for (PetscInt w = -1; w < WallTable.count; w++) { /* -1: the default */
    const PetscBool meets = w < 0 ? PETSC_TRUE : Meets(Wall(w), full_support);
    PetscErrorCode  code;
    Cloud           cloud;

    ASSERT_OK(PetscSNPrintf(options, sizeof(options), "%s %s %s %s", option, form->name,
                            w < 0 ? "" : "-wall", w < 0 ? "" : Wall(w)->name));
    ASSERT_OK(PetscPushErrorHandler(PetscReturnErrorHandler, NULL));
    code = CloudOperators(&box, options, &cloud);
    ASSERT_OK(PetscPopErrorHandler());
    CloudAssertNone("refused", options, code != (meets ? PETSC_SUCCESS : PETSC_ERR_USER_INPUT));
    if (w < 0) CloudAssertNone("default", options, !Meets(cloud.ops->wall, full_support));
    if (!code) ASSERT_OK(OperatorsDestroy(&cloud.ops));
  }
}

static void test_refusals(void **state)
{
  (void)state;
  for (PetscInt k = 0; k < LaplacianTable.count; k++) {
    CheckRefusal("-visc_laplacian", TableGet(&LaplacianTable, k),
                 Blind(CloudLaplacian(k)->properties));
    if (!CloudHas(CloudLaplacian(k), FORM_SAFE_IMPLICIT)) continue;
    CheckRefusal("-ppe_laplacian", TableGet(&LaplacianTable, k),
                 Blind(CloudLaplacian(k)->properties));
  }
  for (PetscInt k = 0; k < GradientTable.count; k++)
    CheckRefusal("-gradient", TableGet(&GradientTable, k), Blind(Gradient(k)->properties));
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_constants),  cmocka_unit_test(test_couette),
      cmocka_unit_test(test_pressure),   cmocka_unit_test(test_sliding_lid),
      cmocka_unit_test(test_divergence), cmocka_unit_test(test_wall_data),
      cmocka_unit_test(test_refusals),
  };
  int failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
  return PetscFinalize() || failed ? 1 : 0;
}
