/*
  Eigenvalues and condition number of the matrix of -L dx^2, where L is the Laplacian in a box with
  given values around it. LAPACK computes all eigenvalues of small matrices, SLEPc the extreme
  eigenvalues of large matrices.
*/
#include "isph/patch.h"
#include "spectrum.h"
#include <dlfcn.h>

#define SPECTRUM_DENSE 1000 /* largest number of rows for LAPACK */

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
  spectrum->condition = SpectrumCondition(least, most);
  PetscCall(MatDestroy(&square));
  PetscCall(MatDestroy(&whole));
  PetscFunctionReturn(PETSC_SUCCESS);
}

#if defined(ISPH_SLEPC)
/* Finds the function of the module: beside the program, as in a build tree, or in the installation;
   NULL if a rank has no module. */
static PetscErrorCode LoadSparse(SparseSpectrum **function)
{
  char              beside[PETSC_MAX_PATH_LEN], relative[PETSC_MAX_PATH_LEN];
  const char *const path[] = {beside, relative, ISPH_SLEPC_INSTALL "/" ISPH_SLEPC};
  void             *module = NULL;
  PetscMPIInt       found;

  PetscFunctionBegin;
  PetscCall(PathBesideProgram(ISPH_SLEPC, beside));
  PetscCall(PathBesideProgram(ISPH_SLEPC_RELATIVE "/" ISPH_SLEPC, relative));
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(path) && !module; k++)
    if (path[k][0]) module = dlopen(path[k], RTLD_NOW | RTLD_LOCAL);
  *function = module ? (SparseSpectrum *)dlsym(module, "SpectrumSlepc") : NULL;
  found     = *function ? 1 : 0;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &found, 1, MPI_INT, MPI_MIN, PETSC_COMM_WORLD));
  if (!found) *function = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}
#else
static PetscErrorCode LoadSparse(SparseSpectrum **function)
{
  PetscFunctionBegin;
  *function = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}
#endif

/* Computes extreme eigenvalues by SLEPc. */
static PetscErrorCode SpectrumSparse(Mat A, Spectrum *spectrum)
{
  SparseSpectrum *function;
  PetscInt        N;

  PetscFunctionBegin;
  PetscCall(MatGetSize(A, &N, NULL));
  PetscCall(LoadSparse(&function));
  UserCheck(function,
            "-patch_spectrum: %" PetscInt_FMT
            " rows need SLEPc, which is not installed; without it at most %d rows are allowed",
            N, SPECTRUM_DENSE);
  PetscCall(function(A, spectrum));
  PetscFunctionReturn(PETSC_SUCCESS);
}

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
