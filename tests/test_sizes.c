/*
  Particles of different sizes: two particles closer than the larger of their radii are neighbours,
  a row uses radius, volume and scale of its particle, means are weighted by volume, and rows of the
  coupled system have the units of their particle. No Laplacian is symmetric.
*/
/* RANKS: 1 2 */
#include "isph/start.h"
#include "crowd.h"
#include "../src/schemes/coupled/saddle.h"

/* Scales the spacing of each particle by a factor between 0.6 and 1 that follows from its id, and
   updates the halo. */
static void Resize(const Scene *scene, Particles *p)
{
  for (PetscInt i = 0; i < ParticlesOwn(p); i++) {
    const PetscReal ratio = 0.8 + 0.2 * CrowdNoise((PetscInt)p->id[i], 5);

    p->dx[i] *= ratio;
    p->volume[i] *= PetscPowRealInt(ratio, (int)p->dim);
  }
  ASSERT_OK(ParticlesUpdateEpoch(scene, p, PETSC_TRUE, NULL));
}

static void CheckPairs(const Setting *s)
{
  const Scene *scene = &s->scene;
  Particles   *p;
  Neighbors   *nb;

  ASSERT_OK(ParticlesCreate(scene, RADIUS * scene->dx, &p));
  ASSERT_OK(ParticlesFill(scene, s->walls, NULL, p));
  ASSERT_OK(NeighborsCreate(RADIUS * scene->dx, scene->dx, &nb));
  Resize(scene, p);
  for (PetscInt step = 0; step < 4; step++) {
    ASSERT_OK(NeighborsUpdate(p, step % 2 ? 0.01 * scene->dx : 0.0, nb));
    CrowdCheckNeighbors(s, p, nb);
    CrowdMove(scene, p, 0.02 * scene->dx);
    ASSERT_OK(ParticlesUpdateHalo(p));
  }
  ASSERT_OK(NeighborsDestroy(&nb));
  ASSERT_OK(ParticlesDestroy(&p));
}

static void test_pairs(void **state)
{
  const Setting cavity   = CrowdBox("2D cavity", 2, 15, 11, 1, 0, 3);
  const Setting periodic = CrowdBox("3D periodic", 3, 7, 7, 7, 3, 0);

  (void)state;
  CheckPairs(&cavity);
  CheckPairs(&periodic);
}

/* Checks that the fit mls is exact for quadratic fields, and that rows of the pressure are -dx_i^2
   times rows of the velocity. */
static void CheckRows(const CloudBox *box, const char kernel[])
{
  Cloud     cloud;
  PetscReal error, norm;
  Mat       scaled;

  ASSERT_OK(CloudCreate(box, kernel, &cloud));
  Resize(&cloud.scene, cloud.particles);
  ASSERT_OK(CloudMove(0.0, PETSC_TRUE, 0.0, &cloud));
  for (PetscInt k = 0; k < QuadraticCount(box->dim); k++) {
    const Quadratic f = QuadraticMonomial(box->dim, k), lap = QuadraticLaplacian(&cloud, &f);

    ASSERT_OK(CloudSet(&cloud, &f, cloud.f[0]));
    ASSERT_OK(AffineApply(&cloud.ops->velocity[0].visc, cloud.f[0], NULL, cloud.y));
    ASSERT_OK(CloudError(&cloud, cloud.y, &lap, PETSC_TRUE, &error));
    CloudAssertNone("exact for quadratics", box->name, error * PetscSqr(cloud.scene.dx) > 1e-9);
  }
  ASSERT_OK(MatDuplicate(cloud.ops->velocity[0].visc.A, MAT_COPY_VALUES, &scaled));
  ASSERT_OK(MatDiagonalScale(scaled, cloud.ops->ppe_scale, NULL));
  ASSERT_OK(MatAXPY(scaled, -1.0, cloud.ops->ppe.A, SAME_NONZERO_PATTERN));
  ASSERT_OK(MatNorm(scaled, NORM_FROBENIUS, &error));
  ASSERT_OK(MatNorm(cloud.ops->ppe.A, NORM_FROBENIUS, &norm));
  CloudAssertNone("ppe = -dx_i^2 visc", box->name, error > 1e-14 * norm);
  ASSERT_OK(MatDestroy(&scaled));
  ASSERT_OK(CloudDestroy(&cloud));
}

static void test_rows(void **state)
{
  const CloudBox plane = CloudPeriodic(2, 0.2), space = CloudPeriodic(3, 0.2);

  (void)state;
  CheckRows(&plane, "-visc_laplacian mls -ppe_laplacian mls -h_over_dx 1.7");
  CheckRows(&space, "-visc_laplacian mls -ppe_laplacian mls -h_over_dx 1.7");
}

/* Computes the norm of V L - (V L)^T over the norm of V L for the viscous Laplacian L. */
static PetscReal Unsymmetry(const Cloud *cloud)
{
  const Particles *p = cloud->particles;
  PetscReal        difference, norm;
  PetscScalar     *volume;
  Mat              L, transposed;

  ASSERT_OK(MatDuplicate(cloud->ops->velocity[0].visc.A, MAT_COPY_VALUES, &L));
  ASSERT_OK(VecGetArray(cloud->y, &volume));
  for (PetscInt i = 0; i < p->n_fluid; i++) volume[i] = p->volume[i];
  ASSERT_OK(VecRestoreArray(cloud->y, &volume));
  ASSERT_OK(MatDiagonalScale(L, cloud->y, NULL));
  ASSERT_OK(MatTranspose(L, MAT_INITIAL_MATRIX, &transposed));
  ASSERT_OK(MatAXPY(transposed, -1.0, L, UNKNOWN_NONZERO_PATTERN));
  ASSERT_OK(MatNorm(transposed, NORM_FROBENIUS, &difference));
  ASSERT_OK(MatNorm(L, NORM_FROBENIUS, &norm));
  ASSERT_OK(MatDestroy(&transposed));
  ASSERT_OK(MatDestroy(&L));
  return difference / norm;
}

/* A symmetric form remains symmetric for equal sizes only: each row has the kernel of its own
   particle. */
static void test_symmetry(void **state)
{
  const CloudBox box = CloudPeriodic(2, 0.2);
  Cloud          cloud;
  LaplacianForm *form;

  (void)state;
  ASSERT_OK(CloudCreate(&box, "-visc_laplacian morris -ppe_laplacian mls", &cloud));
  form = &cloud.ops->forms.visc;
  CloudAssertNone("declared", box.name, !LaplacianIs(form, FORM_SYMMETRIC));
  CloudAssertNone("symmetric", box.name, Unsymmetry(&cloud) > 1e-13);
  Resize(&cloud.scene, cloud.particles);
  ASSERT_OK(CloudMove(0.0, PETSC_TRUE, 0.0, &cloud));
  CloudAssertNone("unsymmetric for several sizes", box.name, Unsymmetry(&cloud) < 1e-2);
  form->graded = PETSC_TRUE;
  CloudAssertNone("not declared", box.name, LaplacianIs(form, FORM_SYMMETRIC));
  ASSERT_OK(CloudDestroy(&cloud));
}

/* Returns a f + b g. */
static Quadratic Sum(PetscReal a, const Quadratic *f, PetscReal b, const Quadratic *g)
{
  Quadratic sum = {.c = a * f->c + b * g->c};

  for (PetscInt e = 0; e < ISPH_MAX_DIM; e++) {
    sum.g[e] = a * f->g[e] + b * g->g[e];
    for (PetscInt k = 0; k < ISPH_MAX_DIM; k++) sum.H[e][k] = a * f->H[e][k] + b * g->H[e][k];
  }
  return sum;
}

/* Divides the row of each particle by its unit: T_i, or dx_i if mass is true. */
static void DivideRows(const Flow *flow, PetscBool mass, Vec v)
{
  const Particles *p = flow->particles;
  PetscScalar     *value;

  ASSERT_OK(VecGetArray(v, &value));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    const PetscReal T = SaddleTime(flow->scene->nu, flow->clock, p->dx[i]);

    /* SaddleGet() multiplies rows of mass by the unit of a pressure */
    value[i] /= mass ? PetscSqr(p->dx[i]) * flow->scene->rho / T : T;
  }
  ASSERT_OK(VecRestoreArray(v, &value));
}

/* Checks the rows for u = (f, ..., f), p = f: shift u - nu lap u + grad p/rho, and div u. */
static void CheckSaddleRows(const Cloud *cloud, const Flow *flow, const Quadratic *f,
                            PetscReal shift, const Saddle *s)
{
  const PetscInt  dim = cloud->scene.dim;
  const Quadratic lap = QuadraticLaplacian(cloud, f), zero = {0};
  Quadratic       viscous = Sum(shift, f, -cloud->scene.nu, &lap), div = zero;
  PetscReal       error;
  Vec             x, y, u[ISPH_MAX_DIM];

  for (PetscInt a = 0; a < dim; a++) u[a] = cloud->f[a];
  for (PetscInt a = 0; a < dim; a++) ASSERT_OK(CloudSet(cloud, f, u[a]));
  ASSERT_OK(CloudSet(cloud, f, cloud->y));
  ASSERT_OK(MatCreateVecs(s->A, &x, &y));
  ASSERT_OK(SaddlePut(s, u, cloud->y, x));
  ASSERT_OK(SaddleGet(s, x, u, cloud->y));
  ASSERT_OK(CloudError(cloud, cloud->y, f, PETSC_FALSE, &error));
  CloudAssertNone("pressure in its unit and back", "saddle", error > 1e-13);
  ASSERT_OK(MatMult(s->P, x, y));
  ASSERT_OK(SaddleGet(s, y, u, cloud->y));
  for (PetscInt a = 0; a < dim; a++) {
    const Quadratic slope = QuadraticDerivative(cloud, f, a);
    const Quadratic row   = Sum(1.0, &viscous, 1.0 / cloud->scene.rho, &slope);

    div = Sum(1.0, &div, 1.0, &slope);
    DivideRows(flow, PETSC_FALSE, u[a]);
    ASSERT_OK(CloudError(cloud, u[a], &row, PETSC_TRUE, &error));
    CloudAssertNone("T_i times momentum", "saddle", error > 1e-8);
  }
  DivideRows(flow, PETSC_TRUE, cloud->y);
  ASSERT_OK(CloudError(cloud, cloud->y, &div, PETSC_TRUE, &error));
  CloudAssertNone("dx_i times mass", "saddle", error > 1e-8);
  ASSERT_OK(VecDestroy(&x));
  ASSERT_OK(VecDestroy(&y));
}

/* Rows of the coupled system have the units of their particles, and are exact for quadratics. */
static void test_saddle(void **state)
{
  CloudBox box    = CloudPeriodic(2, 0.2);
  Clock    clock  = {.dt = 0.02};
  Saddle   s      = {0};
  Scheme   scheme = {0};
  Cloud    cloud;
  Flow     flow = {.scheme = &scheme};

  (void)state;
  box.grad_p_without_walls = PETSC_TRUE;
  ASSERT_OK(CloudCreate(&box, "-visc_laplacian mls -ppe_laplacian mls -h_over_dx 1.7", &cloud));
  Resize(&cloud.scene, cloud.particles);
  ASSERT_OK(CloudMove(0.0, PETSC_TRUE, 0.0, &cloud));
  cloud.scene.nu  = 0.3;
  cloud.scene.rho = 1.7;
  flow.scene      = &cloud.scene;
  flow.clock      = &clock;
  flow.ops        = cloud.ops;
  flow.particles  = cloud.particles;
  for (PetscInt steady = 0; steady < 2; steady++) {
    const PetscReal shift = steady ? 0.0 : 50.0;

    clock.steady_solve = steady ? PETSC_TRUE : PETSC_FALSE;
    ASSERT_OK(SaddleAssemble(&flow, NULL, &s));
    ASSERT_OK(SaddleSetShift(cloud.particles, shift, &s));
    for (PetscInt k = 0; k < QuadraticCount(box.dim); k++) {
      const Quadratic f = QuadraticMonomial(box.dim, k);

      CheckSaddleRows(&cloud, &flow, &f, shift, &s);
    }
  }
  ASSERT_OK(SaddleFree(&s));
  ASSERT_OK(CloudDestroy(&cloud));
}

/* Weights sum up to the volume of all particles, and means are weighted by volume. */
static void test_means(void **state)
{
  const Setting s = CrowdBox("means", 2, 12, 9, 1, 2, 0);
  Particles    *p;
  Vec           f;
  PetscScalar  *value;
  PetscReal     volume, sum, plain;

  (void)state;
  ASSERT_OK(ParticlesCreate(&s.scene, RADIUS * s.scene.dx, &p));
  ASSERT_OK(ParticlesFill(&s.scene, s.walls, NULL, p));
  CloudAssertNone("equal volumes weigh 1", s.name, p->weight != (PetscReal)p->N_fluid);
  Resize(&s.scene, p);
  ASSERT_OK(FluidVec(p, NULL, &f));
  ASSERT_OK(VecGetArray(f, &value));
  volume = 0.0;
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    volume += p->volume[i];
    value[i] = 2.0 + p->volume[i] / p->cell_volume;
  }
  ASSERT_OK(VecRestoreArray(f, &value));
  MPI_Allreduce(MPI_IN_PLACE, &volume, 1, MPIU_REAL, MPI_SUM, p->comm);
  CloudAssertNone("weights sum up to the volume", s.name,
                  PetscAbsReal(p->weight * p->cell_volume - volume) > 1e-13 * volume);
  ASSERT_OK(FluidRemoveMean(p, f));
  ASSERT_OK(FluidSum(p, f, PETSC_FALSE, &sum));
  ASSERT_OK(VecSum(f, &plain));
  CloudAssertNone("the weighted mean is gone", s.name, PetscAbsReal(sum) > 1e-12 * p->weight);
  CloudAssertNone("the plain mean is not", s.name, PetscAbsReal(plain) < 1e-3 * p->weight);
  ASSERT_OK(VecDestroy(&f));
  ASSERT_OK(ParticlesDestroy(&p));
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_pairs),  cmocka_unit_test(test_rows),  cmocka_unit_test(test_symmetry),
      cmocka_unit_test(test_saddle), cmocka_unit_test(test_means),
  };
  int failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
  return PetscFinalize() || failed ? 1 : 0;
}
