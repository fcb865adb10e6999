/*
  Identities of the velocity beside walls, for every wall treatment and all forms that work with
  it, on lattices and on disordered clouds, in 2D and 3D; and the refused pairs of
  forms and walls.
*/
/* RANKS: 1 2 */
#include "walled.h"

/* Checks that fluid and walls in the same translation under uniform pressure have no force, no
   gradient and no divergence. */
static void CheckConstants(const WalledForms *forms, const char *where, Cloud *cloud)
{
  const Operators *ops  = cloud->ops;
  const Quadratic  zero = {0}, u[3] = {{.c = 1.0}, {.c = -0.7}, {.c = 0.4}};

  WalledSetVelocity(cloud, u);
  ASSERT_OK(AffineApply(&ops->velocity[0].visc, cloud->f[0], cloud->walls.u[0], cloud->y));
  WalledAssert("lap of constants", where, cloud, cloud->y, &zero, 2, 1e-12);
  for (PetscInt a = 0; a < cloud->scene.dim; a++) {
    ASSERT_OK(AffineApply(&ops->velocity[0].grad_u[a], cloud->f[0], cloud->walls.u[0], cloud->y));
    WalledAssert("grad u of constants", where, cloud, cloud->y, &zero, 1, 1e-12);
    ASSERT_OK(AffineApply(&ops->grad_p[a], cloud->f[0], cloud->e, cloud->y));
    WalledAssert("grad p of constants", where, cloud, cloud->y, &zero, 1, 1e-12);
  }
  ASSERT_OK(AffineApply(&ops->ppe, cloud->f[0], cloud->e, cloud->y));
  WalledAssert("ppe of constants", where, cloud, cloud->y, &zero, 0, 1e-12);
  ASSERT_OK(CloudDivergence(cloud, cloud->y));
  WalledAssert("div of constants", where, cloud, cloud->y, &zero, 1, 1e-12);
}

/* Checks that u = (y, 0) between a wall and a moving lid has no viscous force, no divergence, and
   the exact gradient. */
static void CheckCouette(const WalledForms *forms, const char *where, Cloud *cloud)
{
  const Operators *ops  = cloud->ops;
  const PetscInt   last = cloud->scene.dim - 1;
  const PetscBool  even = cloud->scene.jitter == 0.0 ? PETSC_TRUE : PETSC_FALSE;
  const Quadratic  zero = {0};
  Quadratic        u[3] = {{.c = 0.3}};

  u[0].g[last] = 1.0;
  WalledSetVelocity(cloud, u);
  if (even || (forms->laplacian->properties & FORM_EXACT_LINEAR)) {
    ASSERT_OK(AffineApply(&ops->velocity[0].visc, cloud->f[0], cloud->walls.u[0], cloud->y));
    WalledAssert("lap u of Couette flow", where, cloud, cloud->y, &zero, 2, 1e-9);
  }
  for (PetscInt a = 0; a <= last && (forms->gradient->properties & FORM_EXACT_LINEAR); a++) {
    const Quadratic exact = QuadraticDerivative(cloud, &u[0], a);

    ASSERT_OK(AffineApply(&ops->velocity[0].grad_u[a], cloud->f[0], cloud->walls.u[0], cloud->y));
    WalledAssert("grad u of Couette flow", where, cloud, cloud->y, &exact, 1, 1e-9);
  }
  if (even || (forms->gradient->properties & FORM_EXACT_LINEAR)) {
    ASSERT_OK(CloudDivergence(cloud, cloud->y));
    WalledAssert("div u of Couette flow", where, cloud, cloud->y, &zero, 1, 1e-9);
  }
}

/* Checks that any linear flow in a closed box whose walls move with it has no viscous force and the
   exact gradient. */
static void CheckLinearFlow(const WalledForms *forms, const char *where, Cloud *cloud)
{
  const Operators *ops  = cloud->ops;
  const Quadratic  zero = {0};

  for (PetscInt k = 0; k < cloud->scene.dim; k++) {
    const Quadratic u[3] = {QuadraticMonomial(cloud->scene.dim, k)};

    WalledSetVelocity(cloud, u);
    if (forms->laplacian->properties & FORM_EXACT_LINEAR) {
      ASSERT_OK(AffineApply(&ops->velocity[0].visc, cloud->f[0], cloud->walls.u[0], cloud->y));
      WalledAssert("lap of linear flow", where, cloud, cloud->y, &zero, 2, 1e-8);
    }
    for (PetscInt a = 0; a < cloud->scene.dim; a++) {
      const Quadratic exact = QuadraticDerivative(cloud, &u[0], a);

      if (!(forms->gradient->properties & FORM_EXACT_LINEAR)) continue;
      ASSERT_OK(AffineApply(&ops->velocity[0].grad_u[a], cloud->f[0], cloud->walls.u[0], cloud->y));
      WalledAssert("grad of linear flow", where, cloud, cloud->y, &exact, 1, 1e-8);
    }
  }
}

/* Checks that div u = 0 in fluid at rest under a sliding lid, even at the corners. */
static void CheckSlidingLid(const WalledForms *forms, const char *where, Cloud *cloud)
{
  const PetscInt  last    = cloud->scene.dim - 1;
  const Quadratic rest[3] = {{.c = 0.0}};

  for (PetscInt c = 0; c < last; c++) cloud->slide[2 * last + 1][c] = 1.0;
  WalledSetVelocity(cloud, rest);
  ASSERT_OK(CloudDivergence(cloud, cloud->y));
  WalledAssert("div u under a sliding lid", where, cloud, cloud->y, &rest[0], 1, 1e-14);
  for (PetscInt c = 0; c < last; c++) cloud->slide[2 * last + 1][c] = 0.0;
}

/* Checks the divergence of a velocity along one axis that increases linearly along this axis; the
   walls normal to the axis move with it. */
static void CheckNormalMotion(const WalledForms *forms, const char *where, Cloud *cloud)
{
  const PetscInt last = cloud->scene.dim - 1;
  Quadratic      u[3] = {{.c = 0.0}}, exact;

  if (!(forms->gradient->properties & FORM_EXACT_LINEAR)) return;
  u[last].c       = 0.2;
  u[last].g[last] = 1.0;
  exact           = QuadraticDerivative(cloud, &u[last], last);
  WalledSetVelocity(cloud, u);
  ASSERT_OK(CloudDivergence(cloud, cloud->y));
  WalledAssert("div u of normal motion", where, cloud, cloud->y, &exact, 1, 1e-9);
}

/* Checks that rigid rotation on a lattice has no divergence, by symmetry, with any gradient. */
static void CheckRotation(const WalledForms *forms, const char *where, Cloud *cloud)
{
  const PetscInt  last = cloud->scene.dim - 1;
  const Quadratic zero = {0};
  Quadratic       u[3] = {{.c = 0.0}};
  PetscReal       error;

  if (cloud->scene.jitter > 0.0) return;
  u[0].g[last] = -1.0;
  u[last].g[0] = 1.0;
  WalledSetVelocity(cloud, u);
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
    WalledSetVelocity(cloud, u);
    ASSERT_OK(CloudDivergence(cloud, cloud->y));
    WalledAssert("div u", where, cloud, cloud->y, &exact, 1, 1e-8);
  }
}

/*
  Checks that the divergence of every linear velocity is exact in a closed box. A vector fit uses
  n.u_wall at the wall point. At dummies the normal component is continued through the wall, and the
  tangential components by the gradient of the row, theory.md, (walls:normal). This is exact if no
  factor beta of (walls:normal) reaches its bound of 10: here beta is at most 1 + 2.3/0.3, from the
  support 2.6 dx and the least distance 0.3 dx.
*/
static void CheckLinearVelocity(const WalledForms *forms, const char *where, Cloud *cloud)
{
  if (!(forms->gradient->properties & FORM_EXACT_LINEAR)) return;
  for (PetscInt k = 0; k < cloud->scene.dim; k++) AssertDivergence(k, where, cloud);
}

/* Checks that the divergence of a vector fit is exact for quadratic velocities too. */
static void CheckQuadraticVelocity(const WalledForms *forms, const char *where, Cloud *cloud)
{
  const PetscInt dim = cloud->scene.dim;

  if (!forms->wall->on_surface || !forms->gradient->DivergenceFit) return;
  for (PetscInt k = dim; k < QuadraticCount(dim); k++) AssertDivergence(k, where, cloud);
}

/* Checks that the predicted velocity has the Dirichlet value u_wall + (k/rho) (n.grad p) n,
   theory.md, (projection:dirichlet), and that the wall particle keeps the wall velocity. The last
   check of a cloud, because the wall pressure gradient stays. */
static void CheckSlip(const WalledForms *forms, const char *where, Cloud *cloud)
{
  const Quadratic  rest[3] = {{.c = 0.0}};
  const Particles *p       = cloud->particles;
  const PetscReal *u;
  PetscInt         wrong = 0;

  WalledSetVelocity(cloud, rest);
  ASSERT_OK(VecSet(cloud->walls.p_step, 3.0));
  ASSERT_OK(WallValuesSetVelocity(&cloud->scene, cloud->particles, 0.0, 0.5, &cloud->walls));
  for (PetscInt a = 0; a < p->dim; a++) {
    ASSERT_OK(VecGetArrayRead(cloud->walls.u[a], &u));
    for (PetscInt k = 0; k < p->n_wall; k++) {
      wrong += u[k] != 1.5 * p->normal[a][p->n_fluid + k];
      wrong += p->u[a][p->n_fluid + k] != 0.0;
    }
    ASSERT_OK(VecRestoreArrayRead(cloud->walls.u[a], &u));
  }
  CloudAssertNone("slip", where, wrong);
}

/* Checks that the concentration C is uniform on a lattice, which continues behind walls. */
static void CheckConcentration(const WalledForms *forms, const char *where, Cloud *cloud)
{
  const Operators *ops   = cloud->ops;
  PetscInt         wrong = 0;
  PetscReal        C     = 0.0;

  if (cloud->scene.jitter > 0.0) return;
  for (PetscInt i = 0; i < cloud->particles->n_fluid; i++)
    C = PetscMax(C, ops->concentration.value[i]);
  MPI_Allreduce(MPI_IN_PLACE, &C, 1, MPIU_REAL, MPI_MAX, PETSC_COMM_WORLD);
  for (PetscInt i = 0; i < cloud->particles->n_fluid; i++) {
    wrong += PetscAbsReal(ops->concentration.value[i] - C) > 1e-12;
    for (PetscInt a = 0; a < cloud->scene.dim; a++)
      wrong += PetscAbsReal(ops->concentration.gradient[a][i]) * cloud->scene.dx > 1e-12;
  }
  /* the quadrature error C - 1 of a lattice is below 3 %: theory.md, (particles:lattice) */
  CloudAssertNone("concentration near 1", where, PetscAbsReal(C - 1.0) > 0.05);
  CloudAssertNone("concentration", where, wrong);
}

/* Makes all checks on the same operators, which take most of the time. */
static void CheckChannel(const WalledForms *forms, const char *where, Cloud *cloud)
{
  CheckCouette(forms, where, cloud);
  CheckNormalMotion(forms, where, cloud);
  CheckRotation(forms, where, cloud);
}

static void test_channel(void **state)
{
  (void)state;
  WalledForAll(PETSC_FALSE, CheckChannel);
}

static void CheckClosed(const WalledForms *forms, const char *where, Cloud *cloud)
{
  CheckConstants(forms, where, cloud);
  CheckLinearFlow(forms, where, cloud);
  CheckLinearVelocity(forms, where, cloud);
  CheckQuadraticVelocity(forms, where, cloud);
  CheckConcentration(forms, where, cloud);
  CheckSlidingLid(forms, where, cloud);
  CheckSlip(forms, where, cloud);
}

static void test_closed(void **state)
{
  (void)state;
  WalledForAll(PETSC_TRUE, CheckClosed);
}

/* Checks that a form that ignores the equations of walls is refused with wall particles on the
   surface, and that dummies are its default. */
static void CheckRefusal(const char *option, const TableRow *form, PetscBool full_support)
{
  const CloudBox box = {.dim = 2, .cells = {6, 6, 1}, .n_periodic = 1};
  char           options[256];

  for (PetscInt w = -1; w < WallTable.count; w++) { /* -1: the default */
    const PetscBool meets = w < 0 ? PETSC_TRUE : WalledMeets(WalledWall(w), full_support);
    PetscErrorCode  code;
    Cloud           cloud;

    ASSERT_OK(PetscSNPrintf(options, sizeof(options), "%s %s %s %s", option, form->name,
                            w < 0 ? "" : "-wall", w < 0 ? "" : WalledWall(w)->name));
    ASSERT_OK(PetscPushErrorHandler(PetscReturnErrorHandler, NULL));
    code = CloudOperators(&box, options, &cloud);
    ASSERT_OK(PetscPopErrorHandler());
    CloudAssertNone("refused", options, code != (meets ? PETSC_SUCCESS : PETSC_ERR_USER_INPUT));
    if (w < 0)
      CloudAssertNone("default", options, !WalledMeets(cloud.ops->forms.wall, full_support));
    if (!code) ASSERT_OK(OperatorsDestroy(&cloud.ops));
  }
}

static void test_refusals(void **state)
{
  (void)state;
  for (PetscInt k = 0; k < CloudScalarForms(); k++) {
    CheckRefusal("-visc_laplacian", TableGet(&LaplacianTable, k),
                 WalledBlind(CloudLaplacian(k)->properties));
    if (!CloudHas(CloudLaplacian(k), FORM_SAFE_IMPLICIT)) continue;
    CheckRefusal("-ppe_laplacian", TableGet(&LaplacianTable, k),
                 WalledBlind(CloudLaplacian(k)->properties));
  }
  for (PetscInt k = 0; k < GradientTable.count; k++)
    CheckRefusal("-gradient", TableGet(&GradientTable, k),
                 WalledBlind(WalledGradient(k)->properties));
}

/*
  Checks that the volumes of fluid and dummies add up to the volume of the box with its wall layers,
  less the part of the cylinder behind its layers. Flat walls have no error. The volume of a circle
  on a lattice has an error of a few cells: the tolerance for two circles is 6 cells.
*/
static void CheckVolume(const WalledForms *forms, const char *where, Cloud *cloud)
{
  const Scene     *scene  = &cloud->scene;
  const Particles *p      = cloud->particles;
  const PetscReal  layers = PetscCeilReal(cloud->ops->forms.radius / scene->dx - 1e-9),
                  dv      = SceneVolume(scene);
  PetscReal sum[2] = {p->n_fluid * dv, 0.0}, box = dv, frame = dv, hole = 0.0;

  for (PetscInt i = p->n_fluid; i < ParticlesOwn(p); i++) {
    const PetscBool of_body = BoundaryBody(scene, (PetscInt)p->side[i]) ? PETSC_TRUE : PETSC_FALSE;

    sum[of_body ? 0 : 1] += p->volume[i];
  }
  MPI_Allreduce(MPI_IN_PLACE, sum, 2, MPIU_REAL, MPI_SUM, PETSC_COMM_WORLD);
  for (PetscInt a = 0; a < scene->dim; a++) {
    box *= scene->cells[a];
    frame *= scene->cells[a] + 2.0 * layers - (forms->surface ? 1.0 : 0.0);
  }
  if (scene->n_bodies)
    hole = PETSC_PI * PetscSqr(SceneBody(scene, 0)->parameter[2] - layers * scene->dx);
  CloudAssertNone("volume of the frame", where, PetscAbsReal(sum[1] - (frame - box)) > 1e-9 * box);
  if (!forms->surface) return; /* dummies alone leave a gap at curved walls */
  CloudAssertNone("volume inside", where,
                  PetscAbsReal(sum[0] - (box - hole)) > (scene->n_bodies ? 6.0 : 1e-9) * dv);
}

static void test_volume(void **state)
{
  const TableRow *row[3];

  (void)state;
  ASSERT_OK(TableFind(&WallTable, "dummy_linear", &row[0]));
  ASSERT_OK(TableFind(&LaplacianTable, "schwaiger", &row[1]));
  ASSERT_OK(TableFind(&GradientTable, "corrected", &row[2]));
  for (PetscInt k = 0; k < 6; k++) {
    const CloudBox    box   = {.cells  = {k / 2 < 1 ? 20 : 8, k / 2 < 1 ? 20 : 6, 6},
                               .dim    = k / 2 < 2 ? 2 : 3,
                               .circle = k / 2 < 1 ? 4.3 : 0.0};
    const WalledForms forms = {.wall      = (const WallRow *)(const void *)row[0],
                               .surface   = k % 2 ? PETSC_TRUE : PETSC_FALSE,
                               .laplacian = (const LaplacianRow *)(const void *)row[1],
                               .gradient  = (const GradientRow *)(const void *)row[2]};

    WalledForOne(&forms, &box, CheckVolume);
  }
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_channel), cmocka_unit_test(test_closed),
                                     cmocka_unit_test(test_refusals),
                                     cmocka_unit_test(test_volume)};
  int                     failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
  return PetscFinalize() || failed ? 1 : 0;
}
