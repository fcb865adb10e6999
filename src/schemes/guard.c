/*
  The guard: looks at the true residual after every linear solve, whatever the method claims, and
  turns a failure into one sentence with a remedy. An AMG-preconditioned method can report
  convergence with a residual as large as the right-hand side; a flow computed from that is wrong
  without a word.
*/
#include "isph/guard.h"

/* How far the true residual may exceed what was asked, and what no tolerance of the user's makes
 * good. */
#define GUARD_SLACK 10.0
#define GUARD_WORST 0.1

static PetscErrorCode Guard_PostSolve(KSP ksp, Vec rhs, Vec solution, void *ctx)
{
  Guard    *guard = (Guard *)ctx;
  PetscReal rtol, norm_b, norm_r;
  Mat       A;
  Vec       r;

  PetscFunctionBegin;
  if (guard->failed) PetscFunctionReturn(PETSC_SUCCESS); /* the first failure is the one to tell */
  PetscCall(KSPGetConvergedReason(ksp, &guard->reason));
  PetscCall(KSPGetIterationNumber(ksp, &guard->iterations));
  PetscCall(KSPGetTolerances(ksp, &rtol, NULL, NULL, NULL));
  PetscCall(KSPGetOperators(ksp, &A, NULL));
  PetscCall(VecDuplicate(rhs, &r));
  PetscCall(MatMult(A, solution, r));
  PetscCall(VecAYPX(r, -1.0, rhs));
  PetscCall(VecNorm(r, NORM_2, &norm_r));
  PetscCall(VecNorm(rhs, NORM_2, &norm_b));
  PetscCall(VecDestroy(&r));
  guard->residual = norm_b > 0.0 ? norm_r / norm_b : norm_r;
  if (guard->reason < 0 || !(norm_r <= PetscMin(GUARD_SLACK * rtol, GUARD_WORST) * norm_b))
    guard->failed = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A note on what is legal but unwise with the chosen form. */
static PetscErrorCode GuardNote(KSP ksp, const LaplacianForm *form, Guard *guard)
{
  PetscBool   needs_symmetry;
  const char *type, *name = form->row->name;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompareAny((PetscObject)ksp, &needs_symmetry, KSPCG, KSPFCG, KSPGROPPCG,
                                      KSPPIPECG, KSPMINRES, KSPSYMMLQ, KSPCR, ""));
  PetscCall(KSPGetType(ksp, &type));
  if (needs_symmetry && !guard->symmetric) {
    PetscCall(PetscSNPrintf(guard->note, sizeof(guard->note),
                            "-%sksp_type %s wants a symmetric matrix, that of %s is not: it may "
                            "fail or take longer than gmres",
                            guard->prefix, type, name));
  } else if (!LaplacianIs(form, FORM_SAFE_IMPLICIT)) {
    PetscCall(PetscSNPrintf(guard->note, sizeof(guard->note),
                            "-%slaplacian %s is anti-diffusive: it amplifies what it should damp, "
                            "and an implicit step may be singular",
                            guard->prefix, name));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  GuardAttach - Puts the guard on a KSP; to be called after KSPSetFromOptions()

  Collective. Also asks for the unpreconditioned norm where the user did not choose one, so that
  -ksp_rtol means the true residual.

  Input Parameter:
. form - the Laplacian that the matrix is of

  Output Parameter:
. guard - its note says what is legal but unwise

  Errors: refuses Cholesky factors of a matrix that is not symmetric, and absolute tolerances
*/
PetscErrorCode GuardAttach(KSP ksp, const LaplacianForm *form, Guard *guard)
{
  PetscBool preonly, chosen, cholesky, icc;
  PC        pc;

  PetscFunctionBegin;
  guard->symmetric = LaplacianIs(form, FORM_SYMMETRIC);
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PetscObjectTypeCompare((PetscObject)pc, PCICC, &icc));
  PetscCall(PetscObjectTypeCompare((PetscObject)pc, PCCHOLESKY, &cholesky));
  UserCheck(guard->symmetric || (!icc && !cholesky),
            "-%spc_type %s: the chosen form's matrix is not symmetric; use %s", guard->prefix,
            icc ? PCICC : PCCHOLESKY, icc ? "ilu or bjacobi" : "lu");
  PetscCall(PetscOptionsHasName(NULL, guard->prefix, "-ksp_atol", &chosen));
  UserCheck(!chosen, "-%sksp_atol: an absolute tolerance depends on units; use -%sksp_rtol",
            guard->prefix, guard->prefix);
  PetscCall(PCSetUseAmat(pc, PETSC_FALSE)); /* a kept preconditioner outlives the operator */
  PetscCall(PetscObjectTypeCompare((PetscObject)ksp, KSPPREONLY, &preonly));
  PetscCall(PetscOptionsHasName(NULL, guard->prefix, "-ksp_norm_type", &chosen));
  if (!preonly && !chosen) PetscCall(KSPSetNormType(ksp, KSP_NORM_UNPRECONDITIONED));
  PetscCall(KSPSetPostSolve(ksp, Guard_PostSolve, guard));
  PetscCall(GuardNote(ksp, form, guard));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What to try instead of the method that failed. */
static PetscErrorCode GuardRemedy(KSP ksp, PC pc, const Guard *guard, char remedy[], size_t length)
{
  const char *best = guard->prefix[0] == 'p' ? KSPFGMRES : KSPGMRES;
  PetscBool   cg, is_best, amg;
  PetscReal   rtol;

  PetscFunctionBegin;
  PetscCall(KSPGetTolerances(ksp, &rtol, NULL, NULL, NULL));
  PetscCall(PetscObjectTypeCompare((PetscObject)ksp, KSPCG, &cg));
  PetscCall(PetscObjectTypeCompare((PetscObject)ksp, best, &is_best));
  PetscCall(PetscObjectTypeCompare((PetscObject)pc, PCHYPRE, &amg));
  if (PetscIsInfOrNanReal(guard->residual)) {
    PetscCall(
        PetscSNPrintf(remedy, length, "the flow is no longer finite: try a smaller -dt or -cfl"));
  } else if (cg && !guard->symmetric) {
    PetscCall(PetscSNPrintf(remedy, length,
                            "cg needs a symmetric form and this one is not: use -%sksp_type %s",
                            guard->prefix, best));
  } else if (GUARD_SLACK * rtol > GUARD_WORST) {
    PetscCall(PetscSNPrintf(remedy, length,
                            "the tolerance given is too loose: use a smaller -%sksp_rtol",
                            guard->prefix));
  } else if (!is_best || !amg) {
    PetscCall(PetscSNPrintf(remedy, length, "try -%sksp_type %s -%spc_type hypre", guard->prefix,
                            best, guard->prefix));
  } else {
    PetscCall(PetscSNPrintf(remedy, length,
                            "the matrix is out of shape, most often because particles have "
                            "clustered: try a smaller -dt or -cfl, or a larger -%sksp_max_it",
                            guard->prefix));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  GuardCheck - Ends the run where a solve failed since the last check

  Collective.

  Input Parameter:
. where - the beginning of the sentence, as ClockWhere() gives it

  Errors: PETSC_ERR_NOT_CONVERGED with the step, the methods, the reason and what to try
*/
PetscErrorCode GuardCheck(KSP ksp, const char where[], Guard *guard)
{
  const char *const *reasons = KSPConvergedReasons;
  char               remedy[256];
  KSPType            ksp_type;
  PCType             pc_type;
  PC                 pc;

  PetscFunctionBegin;
  if (!guard->failed) PetscFunctionReturn(PETSC_SUCCESS);
  guard->failed = PETSC_FALSE;
  PetscCall(KSPGetType(ksp, &ksp_type));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PCGetType(pc, &pc_type));
  PetscCall(GuardRemedy(ksp, pc, guard, remedy, sizeof(remedy)));
  PetscCheck(PETSC_FALSE, PETSC_COMM_WORLD, PETSC_ERR_NOT_CONVERGED,
             "%s: the %s solve by %s with %s ended with %s after %" PetscInt_FMT
             " iterations, true residual %.1e of the right-hand side; %s",
             where, guard->what, ksp_type, pc_type, reasons[guard->reason], guard->iterations,
             (double)guard->residual, remedy);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  GuardRenewPC - Readies a preconditioner for a matrix of another pattern or size

  Collective. A PCReset() does for all but gamg, whose coarse levels keep their old sizes
  (PETSC 3.18).
*/
PetscErrorCode GuardRenewPC(KSP ksp)
{
  PetscBool   gamg;
  const char *prefix;
  PC          pc, fresh;

  PetscFunctionBegin;
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PetscObjectTypeCompare((PetscObject)pc, PCGAMG, &gamg));
  if (!gamg) {
    PetscCall(PCReset(pc));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PCGetOptionsPrefix(pc, &prefix));
  PetscCall(PCCreate(PetscObjectComm((PetscObject)ksp), &fresh));
  PetscCall(PCSetOptionsPrefix(fresh, prefix));
  PetscCall(PCSetType(fresh, PCGAMG));
  PetscCall(PCSetFromOptions(fresh));
  PetscCall(PCSetUseAmat(fresh, PETSC_FALSE));
  PetscCall(KSPSetPC(ksp, fresh));
  PetscCall(PCDestroy(&fresh));
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
