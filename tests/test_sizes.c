/*
  Particles of different sizes: two particles closer than the larger of their radii are neighbours,
  a row uses radius, volume and scale of its particle, and means are weighted by volume.
*/
/* RANKS: 1 2 3 */
#include "crowd.h"

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

  ASSERT_OK(ParticlesCreate(scene, s->walls, RADIUS * scene->dx, NULL, &p));
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

/* Weights sum up to the volume of all particles, and means are weighted by volume. */
static void test_means(void **state)
{
  const Setting s = CrowdBox("means", 2, 12, 9, 1, 2, 0);
  Particles    *p;
  Vec           f;
  PetscScalar  *value;
  PetscReal     volume, sum, plain;

  (void)state;
  ASSERT_OK(ParticlesCreate(&s.scene, s.walls, RADIUS * s.scene.dx, NULL, &p));
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
      cmocka_unit_test(test_pairs),
      cmocka_unit_test(test_rows),
      cmocka_unit_test(test_means),
  };
  int failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
  return PetscFinalize() || failed ? 1 : 0;
}
