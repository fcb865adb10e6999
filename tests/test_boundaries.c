/*
  Kinds of boundaries: their equations in rows, in 2D and 3D, and the constant of the pressure. The
  kind `open` stands for an outflow: it gives the pressure and a velocity without normal derivative.
*/
/* RANKS: 1 2 */
#include <string.h>
#include "cloud.h"
#include "isph/schemes.h"
#include "isph/solvers.h"

#define RIGHT 1 /* the open side */

/* The manufactured pressure, cos(1.3 pi X) cos(pi Y) + 2, with X, Y from 0 to 1 in the box [Pa] */
#define WAVE_X (1.3 * PETSC_PI)
#define WAVE_Y PETSC_PI

static PetscReal Manufactured(const Scene *scene, const PetscReal x[])
{
  PetscReal X[2];

  for (PetscInt a = 0; a < 2; a++) X[a] = (x[a] - scene->lo[a]) / (scene->hi[a] - scene->lo[a]);
  return PetscCosReal(WAVE_X * X[0]) * PetscCosReal(WAVE_Y * X[1]) + 2.0;
}

static PetscReal OpenPressure(const Scene *scene, PetscInt side, PetscReal t, const PetscReal x[])
{
  return Manufactured(scene, x);
}

static const BoundaryRow open_side = {
    .name       = "open",
    .brief      = "gives the pressure; n.grad u = 0",
    .citation   = "",
    .option     = {.name = "-scene_open"},
    .properties = BOUNDARY_PARTICLES,
    .equation   = {[FIT_VELOCITY_NORMAL]     = EQUATION_NORMAL_DERIVATIVE,
                   [FIT_VELOCITY_TANGENTIAL] = EQUATION_NORMAL_DERIVATIVE,
                   [FIT_PRESSURE]            = EQUATION_VALUE,
                   [FIT_PRESSURE_FREE]       = EQUATION_VALUE},
    .Pressure   = OpenPressure,
};

/* The row of a kind in the table. */
static const BoundaryRow *Kind(const char name[])
{
  const TableRow *row;

  assert_int_equal(TableFind(&BoundaryTable, name, &row), 0);
  assert_non_null(row);
  return (const BoundaryRow *)(const void *)row;
}

/* A disordered box with one other side than walls, which is the right one. */
static CloudBox BoxWith(const BoundaryRow *kind, PetscInt dim, PetscBool free)
{
  return (CloudBox){.name                 = kind->name,
                    .dim                  = dim,
                    .cells                = {8, 9, 7},
                    .jitter               = 0.2,
                    .kind                 = {[RIGHT] = kind},
                    .grad_p_without_walls = free};
}

/* Sets the data of a field to the values or normal derivatives that the boundaries give. */
static void SetData(Cloud *cloud, const Quadratic *f, FitQuantity quantity, Vec e)
{
  const Particles *p = cloud->particles;
  PetscReal       *value;

  ASSERT_OK(CloudSetSlope(cloud, f, e));
  ASSERT_OK(VecGetArray(e, &value));
  for (PetscInt k = 0; k < p->n_wall; k++) {
    const PetscInt i = p->n_fluid + k;
    PetscReal      x[ISPH_MAX_DIM];

    for (PetscInt a = 0; a < p->dim; a++) x[a] = p->x[a][i];
    switch (BoundaryEquation(&cloud->scene, (PetscInt)p->side[i], quantity)) {
    case EQUATION_NONE:
      value[k] = 1e3; /* must not matter */
      break;
    case EQUATION_VALUE:
      value[k] = QuadraticAt(cloud, f, x);
      break;
    case EQUATION_NORMAL_DERIVATIVE:
      break;
    }
  }
  ASSERT_OK(VecRestoreArray(e, &value));
}

/* Fails unless y equals the expected field up to 1e-8/dx^power. */
static void AssertField(const char *what, const Cloud *cloud, const Quadratic *expected,
                        PetscInt power)
{
  PetscReal error;

  ASSERT_OK(CloudError(cloud, cloud->y, expected, PETSC_FALSE, &error));
  CloudAssertNone(what, cloud->scene.boundary[RIGHT].kind->name,
                  !(error * PetscPowRealInt(cloud->scene.dx, power) <= 1e-8));
}

/* Rows of the pressure are exact for quadratic fields, those of a free wall slope too. */
static void CheckPressure(const Quadratic *f, FitQuantity quantity, Cloud *cloud)
{
  const Operators *ops  = cloud->ops;
  const Quadratic  zero = {0};

  ASSERT_OK(CloudSet(cloud, f, cloud->f[0]));
  SetData(cloud, f, quantity, cloud->e);
  for (PetscInt a = 0; a < cloud->scene.dim; a++) {
    const Quadratic slope = QuadraticDerivative(cloud, f, a);

    ASSERT_OK(AffineApply(&ops->grad_p[a], cloud->f[0], cloud->e, cloud->y));
    AssertField("grad p", cloud, &slope, 1);
  }
  if (quantity == FIT_PRESSURE) {
    const Quadratic lap = QuadraticLaplacian(cloud, f);

    ASSERT_OK(AffineApply(&ops->ppe, cloud->f[0], cloud->e, cloud->y));
    ASSERT_OK(VecScale(cloud->y, -1.0 / PetscSqr(cloud->scene.dx)));
    AssertField("lap p", cloud, &lap, 2);
  } else {
    ASSERT_OK(AffineApply(&ops->filter_p, cloud->f[0], cloud->e, cloud->y));
    AssertField("residual of the fit", cloud, &zero, 0);
  }
}

/* Rows of each velocity component are exact for quadratic fields. */
static void CheckVelocity(const Quadratic *f, Cloud *cloud)
{
  for (PetscInt c = 0; c < cloud->scene.dim; c++) {
    const VelocityOperators *of  = OperatorsOfVelocity(cloud->ops, c);
    const Quadratic          lap = QuadraticLaplacian(cloud, f);

    ASSERT_OK(CloudSet(cloud, f, cloud->f[0]));
    SetData(cloud, f, c == 0 ? FIT_VELOCITY_NORMAL : FIT_VELOCITY_TANGENTIAL, cloud->e);
    ASSERT_OK(AffineApply(&of->visc, cloud->f[0], cloud->e, cloud->y));
    AssertField("lap u", cloud, &lap, 2);
    for (PetscInt a = 0; a < cloud->scene.dim; a++) {
      const Quadratic slope = QuadraticDerivative(cloud, f, a);

      ASSERT_OK(AffineApply(&of->grad_u[a], cloud->f[0], cloud->e, cloud->y));
      AssertField("grad u", cloud, &slope, 1);
    }
  }
}

/* The divergence of a velocity with one component is exact for quadratic fields. */
static void CheckDivergence(const Quadratic *f, Cloud *cloud)
{
  const Quadratic zero = {0};

  for (PetscInt c = 0; c < cloud->scene.dim; c++) {
    const Quadratic slope = QuadraticDerivative(cloud, f, c);

    for (PetscInt b = 0; b < cloud->scene.dim; b++) {
      ASSERT_OK(CloudSet(cloud, b == c ? f : &zero, cloud->f[b]));
      SetData(cloud, b == c ? f : &zero, FIT_VELOCITY_NORMAL, cloud->walls.u[b]);
    }
    ASSERT_OK(CloudDivergence(cloud, cloud->y));
    AssertField("div u", cloud, &slope, 1);
  }
}

/* Walls, symmetry and an open side give their equations to the same rows, in 2D and 3D. The columns
   of a divergence hold the same equation for all components, so a symmetry enters by u.n alone. */
static void test_rows(void **state)
{
  const BoundaryRow *kinds[] = {Kind("wall"), Kind("symmetry"), &open_side};
  Cloud              cloud;

  (void)state;
  for (PetscInt run = 0; run < 12; run++) {
    const PetscBool free = run % 2 ? PETSC_TRUE : PETSC_FALSE;
    const CloudBox  box  = BoxWith(kinds[run / 2 % 3], run / 6 + 2, free);

    ASSERT_OK(CloudCreate(&box, "", &cloud));
    CloudAssertNone("a fit was not determined", box.name, cloud.ops->regularised_rows);
    for (PetscInt k = 0; k < QuadraticCount(box.dim); k++) {
      const Quadratic f = QuadraticMonomial(box.dim, k);

      CheckPressure(&f, free ? FIT_PRESSURE_FREE : FIT_PRESSURE, &cloud);
      if (!free) CheckVelocity(&f, &cloud);
      if (!free) CheckDivergence(&f, &cloud);
    }
    ASSERT_OK(CloudDestroy(&cloud));
  }
}

/* Data of an open side: the pressure that it gives, and no normal derivative of the velocity, which
   a projection does not change. Walls keep rho n.(f - a) and their velocity. */
static void test_data(void **state)
{
  const CloudBox   box = BoxWith(&open_side, 2, PETSC_FALSE);
  const PetscReal *u, *p;
  Cloud            cloud;
  PetscInt         wrong = 0;

  (void)state;
  ASSERT_OK(CloudCreate(&box, "", &cloud));
  cloud.scene.body_force[1] = 3.0;
  cloud.wall_u[0].c         = 2.0;
  ASSERT_OK(WallValuesSetPressure(&cloud.scene, cloud.particles, 0.0, 0.5, &cloud.walls));
  ASSERT_OK(WallValuesStepPressure(&cloud.scene, cloud.particles, 0.0, &cloud.walls));
  ASSERT_OK(WallValuesSetVelocity(&cloud.scene, cloud.particles, 0.0, 7.0, &cloud.walls));
  ASSERT_OK(VecGetArrayRead(cloud.walls.p_step, &p));
  ASSERT_OK(VecGetArrayRead(cloud.walls.u[0], &u));
  for (PetscInt k = 0; k < cloud.particles->n_wall; k++) {
    const PetscInt  i    = cloud.particles->n_fluid + k;
    const PetscReal x[2] = {cloud.particles->x[0][i], cloud.particles->x[1][i]};
    const PetscBool open = cloud.particles->side[i] == RIGHT ? PETSC_TRUE : PETSC_FALSE;
    const PetscReal full =
        open ? Manufactured(&cloud.scene, x) : 3.0 * cloud.particles->normal[1][i];

    if (!(PetscAbsReal(p[k] - 0.5 * full) <= 1e-12)) wrong++;
    if (u[k] != (open ? 0.0 : 2.0)) wrong++;
  }
  ASSERT_OK(VecRestoreArrayRead(cloud.walls.u[0], &u));
  ASSERT_OK(VecRestoreArrayRead(cloud.walls.p_step, &p));
  CloudAssertNone("data", "open side", wrong);
  for (PetscInt side = 0; side < 2 * box.dim; side++) { /* at rest; pressure may drive any speed */
    const PetscReal zero[ISPH_MAX_DIM] = {0.0};
    const PetscReal bound              = SceneWallSpeedBound(&cloud.scene, side, zero, zero, zero);

    CloudAssertNone("speed bound", "open side", bound != (side == RIGHT ? PETSC_INFINITY : 0.0));
  }
  ASSERT_OK(CloudDestroy(&cloud));
}

/* Solves A p = b as the projection does, b = -dx^2 lap p - B e; returns the relative L2 error. */
static PetscReal SolvePoisson(Cloud *cloud)
{
  const Scene     *scene = &cloud->scene;
  const Particles *p     = cloud->particles;
  const PetscReal *value;
  PetscReal       *b, norm[2] = {0.0}, side[2];
  Mat              column, A, preconditioner;
  Vec              work;
  KSP              ksp;
  PC               pc;

  for (PetscInt a = 0; a < 2; a++) side[a] = scene->hi[a] - scene->lo[a];
  ASSERT_OK(WallValuesSetPressure(scene, p, 0.0, 1.0, &cloud->walls));
  ASSERT_OK(VecDuplicate(cloud->y, &work));
  ASSERT_OK(VecGetArray(cloud->y, &b));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    const PetscReal x[2] = {p->x[0][i], p->x[1][i]};
    const PetscReal k2   = PetscSqr(WAVE_X / side[0]) + PetscSqr(WAVE_Y / side[1]);

    b[i] = PetscSqr(scene->dx) * k2 * (Manufactured(scene, x) - 2.0);
  }
  ASSERT_OK(VecRestoreArray(cloud->y, &b));
  ASSERT_OK(MatMult(cloud->ops->ppe.B, cloud->walls.p, work));
  ASSERT_OK(VecAXPY(cloud->y, -1.0, work));
  ASSERT_OK(GaugeColumn(scene, p->comm, 0, p->n_fluid, GAUGE_SHIFT, &column));
  ASSERT_OK(GaugeMatrix(cloud->ops->ppe.A, column, &A));
  ASSERT_OK(MatDuplicate(cloud->ops->ppe.A, MAT_COPY_VALUES, &preconditioner));
  ASSERT_OK(GaugePreconditioner(scene, GAUGE_SHIFT, preconditioner));
  ASSERT_OK(KSPCreate(PETSC_COMM_WORLD, &ksp));
  ASSERT_OK(KSPSetOperators(ksp, A, preconditioner));
  ASSERT_OK(KSPSetType(ksp, KSPFGMRES));
  ASSERT_OK(KSPSetTolerances(ksp, 1e-10, 0.0, PETSC_CURRENT, 500));
  ASSERT_OK(KSPGetPC(ksp, &pc));
  ASSERT_OK(PCSetType(pc, PCHYPRE));
  ASSERT_OK(KSPSetErrorIfNotConverged(ksp, PETSC_TRUE));
  ASSERT_OK(KSPSolve(ksp, cloud->y, work));
  ASSERT_OK(GaugeRemove(scene, p, work)); /* changes nothing: the error contains the constant */
  ASSERT_OK(VecGetArrayRead(work, &value));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    const PetscReal x[2] = {p->x[0][i], p->x[1][i]}, exact = Manufactured(scene, x);

    norm[0] += PetscSqr(value[i] - exact);
    norm[1] += PetscSqr(exact);
  }
  ASSERT_OK(VecRestoreArrayRead(work, &value));
  MPI_Allreduce(MPI_IN_PLACE, norm, 2, MPIU_REAL, MPI_SUM, PETSC_COMM_WORLD);
  ASSERT_OK(KSPDestroy(&ksp));
  ASSERT_OK(MatDestroy(&A));
  ASSERT_OK(MatDestroy(&preconditioner));
  ASSERT_OK(MatDestroy(&column));
  ASSERT_OK(VecDestroy(&work));
  return PetscSqrtReal(norm[0] / norm[1]);
}

/* The pressure Poisson equation with one open side has a determined solution of second order. */
static void test_poisson(void **state)
{
  const char *const forms[] = {"-ppe_laplacian mls", "-ppe_laplacian mls -mls_degree 3"};
  Cloud             cloud;

  (void)state;
  for (size_t f = 0; f < PETSC_STATIC_ARRAY_LENGTH(forms); f++) {
    PetscReal error[3], order;

    for (PetscInt k = 0; k < 3; k++) {
      CloudBox box = BoxWith(&open_side, 2, PETSC_FALSE);

      box.cells[0] = box.cells[1] = 16 << k;
      ASSERT_OK(CloudCreate(&box, forms[f], &cloud));
      error[k] = SolvePoisson(&cloud);
      ASSERT_OK(CloudDestroy(&cloud));
    }
    order = PetscLog2Real(error[0] / error[2]) / 2.0;
    ASSERT_OK(PetscPrintf(PETSC_COMM_WORLD, "%s: errors %.3e %.3e %.3e, order %.2f\n", forms[f],
                          (double)error[0], (double)error[1], (double)error[2], (double)order));
    CloudAssertNone("order below 1.8", forms[f], !(order > 1.8));
  }
}

/* The pressure floats unless a boundary gives it; for a floating one the gauge fixes the mean. */
static void test_gauge(void **state)
{
  CloudBox    box = BoxWith(&open_side, 2, PETSC_FALSE);
  Mat         column, A;
  PetscScalar mean;
  Cloud       cloud;

  (void)state;
  for (PetscInt floats = 0; floats < 2; floats++) {
    const PetscReal rest = floats ? 0.0 : 5.0;

    if (floats) box.kind[RIGHT] = Kind("symmetry");
    ASSERT_OK(CloudCreate(&box, "", &cloud));
    CloudAssertNone("floats", box.name,
                    ScenePressureFloats(&cloud.scene) != (floats ? PETSC_TRUE : PETSC_FALSE));
    ASSERT_OK(GaugeColumn(&cloud.scene, cloud.particles->comm, 0, cloud.particles->n_fluid, 1.0,
                          &column));
    ASSERT_OK(GaugeMatrix(cloud.ops->ppe.A, column, &A));
    CloudAssertNone("column", box.name, (column != NULL) != floats);
    CloudAssertNone("matrix", box.name, (A != cloud.ops->ppe.A) != floats);
    ASSERT_OK(VecSet(cloud.f[0], 5.0));
    ASSERT_OK(GaugeRemove(&cloud.scene, cloud.particles, cloud.f[0]));
    ASSERT_OK(VecMean(cloud.f[0], &mean));
    CloudAssertNone("mean", box.name, !(PetscAbsReal(mean - rest) < 1e-14));
    ASSERT_OK(MatDestroy(&A));
    ASSERT_OK(MatDestroy(&column));
    ASSERT_OK(CloudDestroy(&cloud));
  }
}

/* Dummies have the equations of walls only. */
static void test_refused(void **state)
{
  const CloudBox    box       = BoxWith(&open_side, 2, PETSC_FALSE);
  const char *const options[] = {"-wall dummy_linear", "-visc_laplacian stress_mls"};

  (void)state;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(options); k++) {
    char  message[512] = "";
    Cloud cloud;

    assert_int_equal(PetscPushErrorHandler(CloudKeepMessage, message), 0);
    assert_int_equal(CloudOperators(&box, options[k], &cloud), PETSC_ERR_USER_INPUT);
    assert_int_equal(PetscPopErrorHandler(), 0);
    assert_ptr_equal(strstr(message, "-scene_open: its equations are those of fits"), message);
  }
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_rows), cmocka_unit_test(test_data),
                                     cmocka_unit_test(test_poisson), cmocka_unit_test(test_gauge),
                                     cmocka_unit_test(test_refused)};
  int                     failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
  return PetscFinalize() || failed ? 1 : 0;
}
