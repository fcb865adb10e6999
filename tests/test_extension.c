/*
  Wall treatments that extend the velocity of the fluid to dummies, with and without wall particles
  on the surface. Each treatment is exact for the fields of its claims and for no others, behind
  sides, edges and a curved wall, on any number of ranks.
*/
/* RANKS: 1 3 */
#include "walled.h"

/* Claims: velocities that a treatment continues exactly beyond the wall. test_claims compares this
   list with the table of wall treatments. */
static const struct {
  const char *name;
  PetscBool   linear, quadratic; /* any linear, any quadratic field, walls moving with it */
  PetscBool   parabola;          /* between two walls of equal velocity */
} claims[] = {
    {"mirror", PETSC_TRUE, PETSC_FALSE, PETSC_FALSE},
    {"linear", PETSC_TRUE, PETSC_FALSE, PETSC_FALSE},
    {"quadratic", PETSC_TRUE, PETSC_TRUE, PETSC_TRUE},
    {"global_quadratic", PETSC_FALSE, PETSC_FALSE, PETSC_TRUE},
    {"adami", PETSC_FALSE, PETSC_FALSE, PETSC_FALSE},
    {"dummy_linear", PETSC_TRUE, PETSC_FALSE,
     PETSC_FALSE}, /* linear along the normal; with the surface layer only */
};
#define N_CLAIMS ((PetscInt)PETSC_STATIC_ARRAY_LENGTH(claims))

/* Forms exact for quadratic fields on any arrangement, then forms exact for linear fields. */
static const char *const exact[][2] = {{"mls", "mls"}, {"schwaiger", "corrected"}};

static const void *Row(const Table *table, const char name[])
{
  const TableRow *row;

  ASSERT_OK(TableFind(table, name, &row));
  assert_non_null(row);
  return row;
}

static PetscInt ClaimOf(const WalledForms *forms)
{
  for (PetscInt k = 0; k < N_CLAIMS; k++) {
    PetscBool same;

    ASSERT_OK(PetscStrcmp(claims[k].name, forms->wall->name, &same));
    if (same) return k;
  }
  return -1;
}

/* Calls check for every treatment, with and without wall particles on the surface. */
static void ForAllTreatments(const CloudBox *box, size_t pair, WalledCheck check)
{
  for (PetscInt k = 0; k < N_CLAIMS; k++) {
    WalledForms forms = {.wall      = Row(&WallTable, claims[k].name),
                         .laplacian = Row(&LaplacianTable, exact[pair][0]),
                         .gradient  = Row(&GradientTable, exact[pair][1])};

    if (forms.wall->Check && box->n_periodic != box->dim - 1) continue;
    for (PetscInt surface = forms.wall->Extend ? 0 : 1; surface < 2; surface++) {
      forms.surface = surface ? PETSC_TRUE : PETSC_FALSE;
      WalledForOne(&forms, box, check);
    }
  }
}

/* Calls check for closed boxes or for channels, in 2D and 3D, on lattices (in 3D for closed boxes
   only) and on disordered particles. */
static void ForAllBoxes(PetscBool closed, size_t pair, WalledCheck check)
{
  for (PetscInt dim = 2; dim <= 3; dim++) {
    for (PetscInt disorder = dim == 3 && !closed ? 1 : 0; disorder < 2; disorder++) {
      const CloudBox box = {.cells      = {dim == 2 ? 12 : 6, dim == 2 ? 9 : 6, 6},
                            .dim        = dim,
                            .n_periodic = closed ? 0 : dim - 1,
                            .jitter     = disorder ? WALLED_JITTER : 0.0};

      ForAllTreatments(&box, pair, check);
    }
  }
}

static void test_claims(void **state)
{
  (void)state;
  for (PetscInt k = 0; k < WallTable.count; k++) {
    const WalledForms forms = {.wall = WalledWall(k)};

    CloudAssertNone("not in the list of claims", forms.wall->name,
                    forms.wall->Extend && ClaimOf(&forms) < 0);
  }
}

/* Returns the largest error of lap u and grad u of component 0, in units of u/dx^2 and u/dx. */
static PetscReal VelocityError(const Quadratic *u, Cloud *cloud)
{
  const Operators *ops = cloud->ops;
  Quadratic        all[3], expected = QuadraticLaplacian(cloud, u);
  PetscReal        error, largest;

  for (PetscInt c = 0; c < cloud->scene.dim; c++) all[c] = *u;
  WalledSetVelocity(cloud, all);
  ASSERT_OK(AffineApply(&ops->velocity[0].visc, cloud->f[0], cloud->walls.u[0], cloud->y));
  ASSERT_OK(CloudError(cloud, cloud->y, &expected, PETSC_FALSE, &error));
  largest = error * PetscSqr(cloud->scene.dx);
  for (PetscInt a = 0; a < cloud->scene.dim; a++) {
    expected = QuadraticDerivative(cloud, u, a);
    ASSERT_OK(AffineApply(&ops->velocity[0].grad_u[a], cloud->f[0], cloud->walls.u[0], cloud->y));
    ASSERT_OK(CloudError(cloud, cloud->y, &expected, PETSC_FALSE, &error));
    largest = PetscMax(largest, error * cloud->scene.dx);
  }
  return largest;
}

/* Fails unless the error of a claimed field is rounding of fits, and the error of any other field
   is at least 1 % of u. */
static void AssertClaim(const char *what, const char *where, PetscBool claimed, PetscReal error)
{
  CloudAssertNone(what, where, claimed ? !(error <= 1e-8) : !(error >= 1e-2));
}

/* Checks that fluid and walls in the same translation have no viscous force, no gradient and no
   divergence. */
static void CheckUniform(const WalledForms *forms, const char *where, Cloud *cloud)
{
  const Quadratic u[3] = {{.c = 1.0}, {.c = 1.0}, {.c = 1.0}}, zero = {0};

  AssertClaim("uniform flow", where, PETSC_TRUE, VelocityError(&u[0], cloud));
  WalledSetVelocity(cloud, u);
  ASSERT_OK(CloudDivergence(cloud, cloud->y));
  WalledAssert("div of uniform flow", where, cloud, cloud->y, &zero, 1, 1e-11);
}

/* Checks plane Couette flow between walls of different velocity, before and after moves. */
static void CheckCouette(const WalledForms *forms, const char *where, Cloud *cloud)
{
  const PetscBool claimed = claims[ClaimOf(forms)].linear;
  const Quadratic u       = QuadraticMonomial(cloud->scene.dim, cloud->scene.dim - 1);

  AssertClaim("Couette flow", where, claimed, VelocityError(&u, cloud));
  ASSERT_OK(CloudMove(0.05, PETSC_FALSE, 0.1, cloud));
  AssertClaim("Couette flow of moved particles", where, claimed, VelocityError(&u, cloud));
  ASSERT_OK(CloudMove(0.05, PETSC_TRUE, 0.1, cloud));
  AssertClaim("Couette flow of renumbered particles", where, claimed, VelocityError(&u, cloud));
}

/* Checks all linear fields in a closed box, which has dummies behind its edges too. */
static void CheckLinear(const WalledForms *forms, const char *where, Cloud *cloud)
{
  if (!forms->wall->Extend || !claims[ClaimOf(forms)].linear) return;
  for (PetscInt k = 0; k < cloud->scene.dim; k++) {
    const Quadratic u = QuadraticMonomial(cloud->scene.dim, k);

    AssertClaim("linear velocity", where, PETSC_TRUE, VelocityError(&u, cloud));
  }
}

/* Checks the steady parabola of a channel. */
static void CheckParabola(const WalledForms *forms, const char *where, Cloud *cloud)
{
  const PetscInt  dim = cloud->scene.dim;
  const Quadratic u   = QuadraticMonomial(dim, QuadraticCount(dim) - 1);

  AssertClaim("parabola", where, claims[ClaimOf(forms)].parabola, VelocityError(&u, cloud));
}

/* Checks all quadratic fields in a closed box whose walls move with the field. */
static void CheckQuadratic(const WalledForms *forms, const char *where, Cloud *cloud)
{
  const PetscInt dim = cloud->scene.dim;

  if (!claims[ClaimOf(forms)].quadratic) return;
  for (PetscInt k = dim; k < QuadraticCount(dim); k++) {
    const Quadratic u = QuadraticMonomial(dim, k);

    AssertClaim("quadratic velocity", where, PETSC_TRUE, VelocityError(&u, cloud));
  }
}

/* Checks fluid in rigid rotation and translation, with which a cylinder inside and the walls of the
   box move. */
static void CheckTurning(const WalledForms *forms, const char *where, Cloud *cloud)
{
  Boundary *circle = &cloud->scene.boundary[SceneBodySide(&cloud->scene, 0)];
  Quadratic u[3] = {{.c = 0.4}, {.c = -0.3}}, zero = {0};

  if (!forms->wall->Extend || !claims[ClaimOf(forms)].linear) return;
  u[0].g[1]        = -1.0;
  u[1].g[0]        = 1.0;
  circle->velocity = (Expression){.n = 2, .value = {u[0].c, u[1].c}};
  circle->rotation = ExpressionNumber(1.0 / cloud->scene.dx);
  WalledSetVelocity(cloud, u);
  for (PetscInt c = 0; c < 2; c++) {
    const Operators *ops = cloud->ops;

    ASSERT_OK(AffineApply(&ops->velocity[0].visc, cloud->f[c], cloud->walls.u[c], cloud->y));
    WalledAssert("lap u of turning fluid", where, cloud, cloud->y, &zero, 2, 1e-8);
    for (PetscInt a = 0; a < 2; a++) {
      const Quadratic slope = QuadraticDerivative(cloud, &u[c], a);

      ASSERT_OK(AffineApply(&ops->velocity[0].grad_u[a], cloud->f[c], cloud->walls.u[c], cloud->y));
      WalledAssert("grad u of turning fluid", where, cloud, cloud->y, &slope, 1, 1e-8);
    }
  }
}

/*
  Checks that the volumes of fluid and wall particles add up to the volume of the box with its wall
  layers, less the part of the cylinder behind its layers. Flat walls have no error. The volume of a
  circle on a lattice has an error of a few cells: the tolerance for two circles is 6 cells.
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

static void CheckClosed(const WalledForms *forms, const char *where, Cloud *cloud)
{
  CheckVolume(forms, where, cloud);
  CheckUniform(forms, where, cloud);
  CheckLinear(forms, where, cloud);
  CheckQuadratic(forms, where, cloud);
}

static void test_closed(void **state)
{
  (void)state;
  ForAllBoxes(PETSC_TRUE, 0, CheckClosed);
}

static void CheckChannel(const WalledForms *forms, const char *where, Cloud *cloud)
{
  CheckUniform(forms, where, cloud);
  CheckCouette(forms, where, cloud);
}

static void test_channel(void **state)
{
  (void)state;
  ForAllBoxes(PETSC_FALSE, 0, CheckParabola);
  ForAllBoxes(PETSC_FALSE, 1, CheckChannel);
}

static void CheckCylinder(const WalledForms *forms, const char *where, Cloud *cloud)
{
  CheckVolume(forms, where, cloud);
  CheckTurning(forms, where, cloud);
}

static void test_cylinder(void **state)
{
  (void)state;
  for (PetscInt disorder = 0; disorder < 2; disorder++) {
    const CloudBox box = {
        .cells = {20, 20, 1}, .dim = 2, .jitter = disorder ? WALLED_JITTER : 0.0, .circle = 4.3};

    ForAllTreatments(&box, 1, CheckCylinder);
  }
}

/* Checks that LaplacianIs() returns whether the matrix is symmetric: an extension makes the matrix
   of a symmetric form unsymmetric. */
static void CheckAsymmetry(const WalledForms *forms, const char *where, Cloud *cloud)
{
  PetscBool       symmetric;
  const PetscBool said = LaplacianIs(&cloud->ops->forms.visc, FORM_SYMMETRIC);

  ASSERT_OK(MatIsSymmetric(cloud->ops->velocity[0].visc.A, 1e-12, &symmetric));
  CloudAssertNone("symmetry told", where, said != symmetric);
}

static void test_symmetry(void **state)
{
  const CloudBox box = {.cells = {12, 9, 1}, .dim = 2, .n_periodic = 1, .jitter = WALLED_JITTER};

  (void)state;
  for (PetscInt k = 0; k < WallTable.count; k++) {
    const WalledForms forms = {.wall      = WalledWall(k),
                               .laplacian = Row(&LaplacianTable, "morris"),
                               .gradient  = Row(&GradientTable, "corrected")};

    if (!forms.wall->on_surface && !forms.wall->dynamic) WalledForOne(&forms, &box, CheckAsymmetry);
  }
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_claims),   cmocka_unit_test(test_closed),
      cmocka_unit_test(test_channel),  cmocka_unit_test(test_cylinder),
      cmocka_unit_test(test_symmetry),
  };
  int failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
  return PetscFinalize() || failed ? 1 : 0;
}
