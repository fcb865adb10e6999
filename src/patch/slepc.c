/*
  Extreme eigenvalues of large matrices by SLEPc. This file is a module of its own, isph_slepc.so,
  which the program opens when a patch test needs it: loading SLEPc takes 3 ms, of a start of 40.
*/
#include "spectrum.h"
#include <slepceps.h>

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
  const PetscBool inner = which == EPS_TARGET_MAGNITUDE;
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

/* SpectrumSlepc - Computes extreme eigenvalues of a matrix; collective. See PatchSpectrum(). */
PetscErrorCode SpectrumSlepc(Mat A, Spectrum *spectrum)
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
  spectrum->condition = SpectrumCondition(least, most);
  PetscCall(SlepcFinalize());
  PetscFunctionReturn(PETSC_SUCCESS);
}
