/*
  Declared properties of all Laplacians on a ball of disordered fluid in empty space, with equal
  volumes: forces without a sum, forces without a torque, and dissipation of all velocities. A form
  has the properties that it declares, and no others.
*/
/* RANKS: 1 2 */
#include "cloud.h"

/* Computes the viscous forces of the velocity u, by components or in a block. */
static void Force(const Cloud *cloud, const LaplacianRow *form, Vec u, Vec force)
{
  const Mat A = cloud->ops->velocity[0].visc.A;

  if (CloudHas(form, FORM_COUPLES)) {
    ASSERT_OK(MatMult(A, u, force));
    return;
  }
  for (PetscInt c = 0; c < cloud->scene.dim; c++) {
    ASSERT_OK(VecStrideGather(u, c, cloud->f[0], INSERT_VALUES));
    ASSERT_OK(MatMult(A, cloud->f[0], cloud->y));
    ASSERT_OK(VecStrideScatter(cloud->y, c, force, INSERT_VALUES));
  }
}

/* Returns the largest product of forces with the translations (rotate false) or rotations of the
   cloud, over the norms of both. */
static PetscReal Moment(const Cloud *cloud, Vec force, Vec rigid, PetscBool rotate)
{
  const PetscInt dim     = cloud->scene.dim;
  PetscReal      largest = 0.0, size, norm;

  ASSERT_OK(VecNorm(force, NORM_2, &size));
  for (PetscInt a = 0; a < dim; a++) {
    for (PetscInt b = 0; b <= (rotate ? a - 1 : 0); b++) {
      Quadratic   motion[ISPH_MAX_DIM] = {{0}};
      PetscScalar moment;

      motion[a].c = rotate ? 0.0 : 1.0;
      if (rotate) {
        motion[a].g[b] = 1.0;
        motion[b].g[a] = -1.0;
      }
      CloudSetVelocity(cloud, motion, rigid);
      ASSERT_OK(VecDot(force, rigid, &moment));
      ASSERT_OK(VecNorm(rigid, NORM_2, &norm));
      largest = PetscMax(largest, PetscAbsScalar(moment) / (size * norm));
    }
  }
  return largest;
}

/* Declared sums vanish to rounding; undeclared ones are larger. */
static void CheckSums(const Cloud *cloud, const LaplacianRow *form)
{
  PetscScalar *value;
  PetscInt     first, last;
  Vec          u, force, rigid;

  ASSERT_OK(VelocityVec(cloud->particles, &u));
  ASSERT_OK(VecDuplicate(u, &force));
  ASSERT_OK(VecDuplicate(u, &rigid));
  ASSERT_OK(VecGetOwnershipRange(u, &first, &last));
  ASSERT_OK(VecGetArrayWrite(u, &value));
  for (PetscInt k = first; k < last; k++) value[k - first] = ParticlesHash(5, k, 0);
  ASSERT_OK(VecRestoreArrayWrite(u, &value));
  Force(cloud, form, u, force);
  for (PetscInt k = 0; k < 2; k++) {
    const FormProperty property = k ? FORM_ANGULAR : FORM_MOMENTUM;
    const PetscReal    moment   = Moment(cloud, force, rigid, k ? PETSC_TRUE : PETSC_FALSE);

    if (CloudHas(form, property))
      CloudAssertNone(FormPropertyNames[k ? 9 : 8], form->name, moment > 1e-13);
    else CloudAssertNone("moment, undeclared", form->name, moment < 1e-5);
  }
  ASSERT_OK(VecDestroy(&u));
  ASSERT_OK(VecDestroy(&force));
  ASSERT_OK(VecDestroy(&rigid));
}

/* Returns the largest eigenvalue of the symmetric part of L dx^2, on one rank: the largest gain of
   energy of a velocity. */
static PetscReal LargestGain(const Cloud *cloud)
{
  PetscReal *re, *im, largest = -PETSC_MAX_REAL;
  PetscInt   rows;
  Mat        S;
  KSP        ksp;
  PC         pc;

  ASSERT_OK(MatTranspose(cloud->ops->velocity[0].visc.A, MAT_INITIAL_MATRIX, &S));
  ASSERT_OK(MatAXPY(S, 1.0, cloud->ops->velocity[0].visc.A, DIFFERENT_NONZERO_PATTERN));
  ASSERT_OK(MatGetSize(S, &rows, NULL));
  ASSERT_OK(PetscMalloc2(rows, &re, rows, &im));
  ASSERT_OK(KSPCreate(PETSC_COMM_WORLD, &ksp));
  ASSERT_OK(KSPSetOperators(ksp, S, S));
  ASSERT_OK(KSPGetPC(ksp, &pc));
  ASSERT_OK(PCSetType(pc, PCNONE));
  ASSERT_OK(KSPSetUp(ksp));
  ASSERT_OK(KSPComputeEigenvaluesExplicitly(ksp, rows, re, im));
  for (PetscInt e = 0; e < rows; e++)
    largest = PetscMax(largest, 0.5 * re[e] * PetscSqr(cloud->scene.dx));
  ASSERT_OK(KSPDestroy(&ksp));
  ASSERT_OK(MatDestroy(&S));
  ASSERT_OK(PetscFree2(re, im));
  return largest;
}

static void test_conservation(void **state)
{
  PetscMPIInt ranks;

  (void)state;
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  for (PetscInt k = 0; k < LaplacianTable.count; k++) {
    const LaplacianRow *form = CloudLaplacian(k);

    if (form->composed) continue; /* has no matrix */
    if (form->weak) continue;     /* its cells fill the box, and its masses are not volumes */
    for (PetscInt dim = 2; dim <= 3; dim++) {
      Cloud cloud = CloudFree(form, dim);

      CheckSums(&cloud, form);
      if (dim == 2 && ranks == 1) {
        const PetscReal gain = LargestGain(&cloud);

        if (CloudHas(form, FORM_DISSIPATES))
          CloudAssertNone("dissipates", form->name, gain > 1e-12);
        else CloudAssertNone("dissipates, undeclared", form->name, gain < 1e-3);
      }
      ASSERT_OK(CloudDestroy(&cloud));
    }
  }
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_conservation)};
  int                     failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
  return PetscFinalize() || failed ? 1 : 0;
}
