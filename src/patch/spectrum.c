/* Eigenvalues and condition number of the matrix of -L dx^2, where L is the Laplacian in a box with
   given values around it. */
#include "isph/patch.h"

#define SPECTRUM_MOST 1000 /* rows, of whose matrix LAPACK computes all eigenvalues */

/* Computes the least and the largest real part of the eigenvalues of a sequential matrix. */
static PetscErrorCode AllEigenvalues(Mat A, PetscReal *least, PetscReal *most)
{
  PetscReal *re, *im;
  PetscInt   n;
  KSP        ksp;
  PC         pc;

  PetscFunctionBegin;
  PetscCall(MatGetSize(A, &n, NULL));
  PetscCall(PetscMalloc2(n, &re, n, &im));
  PetscCall(KSPCreate(PETSC_COMM_SELF, &ksp));
  PetscCall(KSPSetOperators(ksp, A, A));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PCSetType(pc, PCNONE));
  PetscCall(KSPSetUp(ksp));
  PetscCall(KSPComputeEigenvaluesExplicitly(ksp, n, re, im));
  *least = PETSC_MAX_REAL;
  *most  = PETSC_MIN_REAL;
  for (PetscInt k = 0; k < n; k++) {
    *least = PetscMin(*least, re[k]);
    *most  = PetscMax(*most, re[k]);
  }
  PetscCall(KSPDestroy(&ksp));
  PetscCall(PetscFree2(re, im));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* PatchSpectrum - Reports eigenvalues and condition number of -L dx^2 over the box, L: Laplacian.
   Collective. Reports eig_min and eig_max, the least and largest real part of the eigenvalues [-],
   and condition, the largest singular value divided by the least [-]. LAPACK computes all
   eigenvalues, redundantly on every rank. */
PetscErrorCode PatchSpectrum(const Patch *patch, Report *report)
{
  const PetscReal dx2 = PetscSqr(patch->scene->dx);
  const PetscInt  N   = patch->particles->N_fluid;
  Mat             A, square;
  PetscReal       eigenvalue[2], least, most;
  PetscMPIInt     ranks;

  PetscFunctionBegin;
  UserCheck(N <= SPECTRUM_MOST,
            "-patch_spectrum: the matrix has %" PetscInt_FMT " rows, allowed are at most %d; use a "
            "smaller -n, or -patch_spectrum false",
            N, SPECTRUM_MOST);
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &ranks));
  PetscCall(MatCreateRedundantMatrix(patch->ops->velocity[0].visc.A, ranks, MPI_COMM_NULL,
                                     MAT_INITIAL_MATRIX, &A));
  PetscCall(MatScale(A, -dx2));
  PetscCall(AllEigenvalues(A, &eigenvalue[0], &eigenvalue[1]));
  PetscCall(MatTransposeMatMult(A, A, MAT_INITIAL_MATRIX, PETSC_DETERMINE, &square));
  PetscCall(AllEigenvalues(square, &least, &most));
  PetscCall(MatDestroyAll(&square, &A));
  PetscCall(ReportAdd(report, "eig_min", eigenvalue[0]));
  PetscCall(ReportAdd(report, "eig_max", eigenvalue[1]));
  PetscCall(
      ReportAdd(report, "condition", least > 0.0 ? PetscSqrtReal(most / least) : PETSC_INFINITY));
  PetscFunctionReturn(PETSC_SUCCESS);
}
