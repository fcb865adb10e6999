/*
  Eigenvalues and condition number of the matrix of -L dx^2, where L is the Laplacian in a box with
  given values around it. LAPACK computes all eigenvalues of small matrices, SLEPc the extreme
  eigenvalues of large matrices.
*/
#include "isph/patch.h"
#if defined(ISPH_HAVE_SLEPC)
#include <slepceps.h>
#endif

#define SPECTRUM_DENSE 1000 /* largest number of rows for LAPACK */

/* Real parts of the extreme eigenvalues, and the ratio of the extreme singular values. */
typedef struct {
  PetscReal eig_min, eig_max, condition;
} Spectrum;

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

/* Returns the condition number of A from the least and the largest eigenvalue of A^T A. */
static PetscReal Condition(PetscReal least, PetscReal most)
{
  return least > 0.0 ? PetscSqrtReal(most / least) : PETSC_INFINITY;
}

/* Computes the spectrum by LAPACK, redundantly on every rank. */
static PetscErrorCode SpectrumDense(Mat A, Spectrum *spectrum)
{
  Mat         whole, square;
  PetscReal   least, most;
  PetscMPIInt ranks;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(PetscObjectComm((PetscObject)A), &ranks));
  PetscCall(MatCreateRedundantMatrix(A, ranks, MPI_COMM_NULL, MAT_INITIAL_MATRIX, &whole));
  PetscCall(AllEigenvalues(whole, &spectrum->eig_min, &spectrum->eig_max));
  PetscCall(MatTransposeMatMult(whole, whole, MAT_INITIAL_MATRIX, PETSC_DETERMINE, &square));
  PetscCall(AllEigenvalues(square, &least, &most));
  spectrum->condition = Condition(least, most);
  PetscCall(MatDestroy(&square));
  PetscCall(MatDestroy(&whole));
  PetscFunctionReturn(PETSC_SUCCESS);
}

#if defined(ISPH_HAVE_SLEPC)
/* Chooses shift and invert; its LU is redundant on every rank if this PETSc lacks a parallel LU. */
static PetscErrorCode ShiftAndInvert(EPS eps, Mat A)
{
  PetscBool parallel;
  ST        st;
  KSP       ksp;
  PC        pc;

  PetscFunctionBegin;
  PetscCall(EPSGetST(eps, &st));
  PetscCall(STSetType(st, STSINVERT));
  PetscCall(MatGetFactorAvailable(A, NULL, MAT_FACTOR_LU, &parallel));
  if (!parallel) {
    PetscCall(STGetKSP(st, &ksp));
    PetscCall(KSPSetType(ksp, KSPPREONLY));
    PetscCall(KSPGetPC(ksp, &pc));
    PetscCall(PCSetType(pc, PCREDUNDANT));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes an extreme eigenvalue: the eigenvalue nearest to 0 by shift and invert, any other by
   Krylov-Schur alone. */
static PetscErrorCode Extreme(Mat A, EPSProblemType type, EPSWhich which, PetscReal *value)
{
  const PetscBool inner = which == EPS_TARGET_MAGNITUDE ? PETSC_TRUE : PETSC_FALSE;
  EPS             eps;
  PetscScalar     re, im;
  PetscInt        found;

  PetscFunctionBegin;
  PetscCall(EPSCreate(PetscObjectComm((PetscObject)A), &eps));
  PetscCall(EPSSetOptionsPrefix(eps, "patch_"));
  PetscCall(EPSSetOperators(eps, A, NULL));
  PetscCall(EPSSetProblemType(eps, type));
  PetscCall(EPSSetDimensions(eps, 1, inner ? PETSC_DETERMINE : 60, PETSC_DETERMINE));
  PetscCall(EPSSetTolerances(eps, 1e-8, 20000));
  PetscCall(EPSSetWhichEigenpairs(eps, which));
  if (inner) {
    PetscCall(EPSSetTarget(eps, 0.0));
    PetscCall(ShiftAndInvert(eps, A));
  }
  PetscCall(EPSSetFromOptions(eps));
  PetscCall(EPSSolve(eps));
  PetscCall(EPSGetConverged(eps, &found));
  PetscCheck(found > 0, PETSC_COMM_WORLD, PETSC_ERR_NOT_CONVERGED,
             "patch test: the eigenvalue solver did not converge; try a smaller -n, or "
             "-patch_eps_max_it and -patch_eps_ncv larger");
  PetscCall(EPSGetEigenvalue(eps, 0, &re, &im));
  *value = re;
  PetscCall(EPSDestroy(&eps));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes extreme eigenvalues by SLEPc. */
static PetscErrorCode SpectrumSparse(Mat A, Spectrum *spectrum)
{
  Mat       square;
  PetscReal least, most;

  PetscFunctionBegin;
  PetscCall(SlepcInitializeNoArguments());
  PetscCall(Extreme(A, EPS_NHEP, EPS_SMALLEST_REAL, &spectrum->eig_min));
  PetscCall(Extreme(A, EPS_NHEP, EPS_LARGEST_REAL, &spectrum->eig_max));
  PetscCall(MatTransposeMatMult(A, A, MAT_INITIAL_MATRIX, PETSC_DETERMINE, &square));
  PetscCall(Extreme(square, EPS_HEP, EPS_TARGET_MAGNITUDE, &least));
  PetscCall(Extreme(square, EPS_HEP, EPS_LARGEST_REAL, &most));
  PetscCall(MatDestroy(&square));
  spectrum->condition = Condition(least, most);
  PetscCall(SlepcFinalize());
  PetscFunctionReturn(PETSC_SUCCESS);
}
#else
static PetscErrorCode SpectrumSparse(Mat A, Spectrum *spectrum)
{
  PetscInt N;

  PetscFunctionBegin;
  PetscCall(MatGetSize(A, &N, NULL));
  UserCheck(PETSC_FALSE,
            "-patch_spectrum: %" PetscInt_FMT
            " rows need SLEPc, which this build lacks; without it at most %d rows are allowed",
            N, SPECTRUM_DENSE);
  PetscFunctionReturn(PETSC_SUCCESS);
}
#endif

/*
  PatchSpectrum - Reports eigenvalues and condition number of -L dx^2 over the box, L: Laplacian

  Collective. Reports eig_min and eig_max, the least and largest real part of the eigenvalues [-],
  and condition, the largest singular value divided by the least [-]. Up to 1000 rows LAPACK
  computes all eigenvalues, for more rows SLEPc computes the extreme eigenvalues.

  Errors: more than 1000 rows without SLEPc, or an eigenvalue solver that does not converge, end the
  run
*/
PetscErrorCode PatchSpectrum(const Patch *patch, Report *report)
{
  Mat      A;
  Spectrum spectrum = {0.0, 0.0, 0.0};

  PetscFunctionBegin;
  PetscCall(MatDuplicate(patch->ops->velocity[0].visc.A, MAT_COPY_VALUES, &A));
  PetscCall(MatScale(A, -PetscSqr(patch->scene->dx)));
  if (patch->particles->N_fluid <= SPECTRUM_DENSE) PetscCall(SpectrumDense(A, &spectrum));
  else PetscCall(SpectrumSparse(A, &spectrum));
  PetscCall(MatDestroy(&A));
  PetscCall(ReportAdd(report, "eig_min", spectrum.eig_min));
  PetscCall(ReportAdd(report, "eig_max", spectrum.eig_max));
  PetscCall(ReportAdd(report, "condition", spectrum.condition));
  PetscFunctionReturn(PETSC_SUCCESS);
}
