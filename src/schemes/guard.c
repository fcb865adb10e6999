/*
  The guard: looks at the true residual after every linear solve, whatever the method claims, and
  turns a failure into one sentence with a remedy. An AMG-preconditioned method can report
  convergence with a residual as large as the right-hand side; a flow computed from that is wrong
  without a word.
*/
#include "guard.h"

/* How far the true residual may exceed what was asked before the solve counts as failed. */
#define GUARD_SLACK 10.0

static PetscErrorCode Guard_PostSolve(KSP ksp, Vec rhs, Vec solution, void *ctx)
{
  Guard    *guard = (Guard *)ctx;
  PetscReal rtol, atol, norm_b, norm_r;
  Mat       A;
  Vec       r;

  PetscFunctionBegin;
  PetscCall(KSPGetConvergedReason(ksp, &guard->reason));
  PetscCall(KSPGetIterationNumber(ksp, &guard->iterations));
  PetscCall(KSPGetTolerances(ksp, &rtol, &atol, NULL, NULL));
  PetscCall(KSPGetOperators(ksp, &A, NULL));
  PetscCall(VecDuplicate(rhs, &r));
  PetscCall(MatMult(A, solution, r));
  PetscCall(VecAYPX(r, -1.0, rhs));
  PetscCall(VecNorm(r, NORM_2, &norm_r));
  PetscCall(VecNorm(rhs, NORM_2, &norm_b));
  PetscCall(VecDestroy(&r));
  guard->residual = norm_b > 0.0 ? norm_r / norm_b : norm_r;
  if (guard->reason < 0 || !(norm_r <= GUARD_SLACK * PetscMax(rtol * norm_b, atol)))
    guard->failed = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  GuardAttach - Puts the guard on a KSP; to be called after KSPSetFromOptions()

  Collective. Also asks for the unpreconditioned norm where the user did not choose one, so that
  -ksp_rtol means the true residual.
*/
PetscErrorCode GuardAttach(KSP ksp, Guard *guard)
{
  PetscBool preonly, chosen;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)ksp, KSPPREONLY, &preonly));
  PetscCall(PetscOptionsHasName(NULL, guard->prefix, "-ksp_norm_type", &chosen));
  if (!preonly && !chosen) PetscCall(KSPSetNormType(ksp, KSP_NORM_UNPRECONDITIONED));
  PetscCall(KSPSetPostSolve(ksp, Guard_PostSolve, guard));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  GuardCheck - Ends the run where a solve failed since the last check

  Collective.

  Errors: PETSC_ERR_NOT_CONVERGED with the step, the methods, the reason and what to try
*/
PetscErrorCode GuardCheck(KSP ksp, const Clock *clock, Guard *guard)
{
  const char *const *reasons = KSPConvergedReasons;
  KSPType            ksp_type;
  PCType             pc_type;
  PC                 pc;

  PetscFunctionBegin;
  if (!guard->failed) PetscFunctionReturn(PETSC_SUCCESS);
  guard->failed = PETSC_FALSE;
  PetscCall(KSPGetType(ksp, &ksp_type));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PCGetType(pc, &pc_type));
  PetscCheck(PETSC_FALSE, PETSC_COMM_WORLD, PETSC_ERR_NOT_CONVERGED,
             "step %" PetscInt_FMT
             " (t = %.6g): the %s solve by %s with %s ended with %s after %" PetscInt_FMT
             " iterations, true residual %.1e of the right-hand side; %s -%sksp_type %s -%spc_type "
             "hypre%s",
             clock->step + 1, (double)(clock->t + clock->dt), guard->what, ksp_type, pc_type,
             reasons[guard->reason], guard->iterations, (double)guard->residual,
             PetscIsInfOrNanReal(guard->residual)
                 ? "the flow itself is no longer finite: try a smaller time step, or"
                 : "try",
             guard->prefix, guard->prefix[0] == 'p' ? "fgmres" : "gmres", guard->prefix,
             guard->reason == KSP_DIVERGED_ITS ? ", or a larger -ksp_max_it" : "");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* OptionDefault - Puts an option into the database unless the user did; name with its dash */
PetscErrorCode OptionDefault(const char prefix[], const char name[], const char value[])
{
  char      option[128];
  PetscBool given;

  PetscFunctionBegin;
  PetscCall(PetscOptionsHasName(NULL, prefix, name, &given));
  if (given) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscSNPrintf(option, sizeof(option), "-%s%s", prefix, name + 1));
  PetscCall(PetscOptionsSetValue(NULL, option, value));
  PetscFunctionReturn(PETSC_SUCCESS);
}
