/* The true residual of a linear solve, used by guard and fallbacks. */
#include "isph/guard.h"

#define RESIDUAL_SLACK 10.0 /* accepted true residual divided by the tolerance */
#define RESIDUAL_WORST 0.1  /* largest true residual accepted with any tolerance */

/*
  SolveResidual - Computes the true residual |b - A x|/|b| of a solve

  Collective. Output: good - flag: the method reports success, and the residual is at most ten times
  its tolerance and at most 0.1.
*/
PetscErrorCode SolveResidual(KSP ksp, Vec b, Vec x, PetscReal *residual, PetscBool *good)
{
  KSPConvergedReason reason;
  PetscReal          rtol, norm_b, norm_r;
  Mat                A;
  Vec                r;

  PetscFunctionBegin;
  PetscCall(KSPGetConvergedReason(ksp, &reason));
  PetscCall(KSPGetTolerances(ksp, &rtol, NULL, NULL, NULL));
  PetscCall(KSPGetOperators(ksp, &A, NULL));
  PetscCall(VecDuplicate(b, &r));
  PetscCall(MatMult(A, x, r));
  PetscCall(VecAYPX(r, -1.0, b));
  PetscCall(VecNorm(r, NORM_2, &norm_r));
  PetscCall(VecNorm(b, NORM_2, &norm_b));
  PetscCall(VecDestroy(&r));
  *residual = norm_b > 0.0 ? norm_r / norm_b : norm_r;
  *good     = reason >= 0 && norm_r <= PetscMin(RESIDUAL_SLACK * rtol, RESIDUAL_WORST) * norm_b
                  ? PETSC_TRUE
                  : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}
