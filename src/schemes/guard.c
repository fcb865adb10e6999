/*
  The guard: looks at the true residual after every linear solve, whatever the method claims, and
  turns a failure into one sentence with a remedy. An AMG-preconditioned method can report
  convergence with a residual as large as the right-hand side; a flow computed from that is wrong
  without a word.
*/
#include "isph/guard.h"
#include <stdarg.h>

/* How far the true residual may exceed what was asked, and what no tolerance of the user's makes
 * good. */
#define GUARD_SLACK 10.0
#define GUARD_WORST 0.1

/*
  GuardMeasure - The true residual |b - A x|/|b| of a solve, and whether it is what was asked for

  Collective. Good is a method that claims success and a residual within ten times its tolerance,
  and never above 0.1.
*/
PetscErrorCode GuardMeasure(KSP ksp, Vec b, Vec x, PetscReal *residual, PetscBool *good)
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
  *good = reason >= 0 && norm_r <= PetscMin(GUARD_SLACK * rtol, GUARD_WORST) * norm_b ? PETSC_TRUE
                                                                                      : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Guard_PostSolve(KSP ksp, Vec rhs, Vec solution, void *ctx)
{
  Guard    *guard = (Guard *)ctx;
  PetscReal residual;
  PetscBool good;

  PetscFunctionBegin;
  if (guard->failed) PetscFunctionReturn(PETSC_SUCCESS); /* the first failure is the one to tell */
  PetscCall(KSPGetConvergedReason(ksp, &guard->reason));
  PetscCall(KSPGetIterationNumber(ksp, &guard->iterations));
  PetscCall(GuardMeasure(ksp, rhs, solution, &guard->residual, &good));
  if (guard->inner && guard->reason >= 0) good = PETSC_TRUE;
  if (good) {
    guard->in_a_row = 0;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  residual = guard->residual;
  if (guard->max_in_a_row >= 0) PetscCall(FallbackSolve(ksp, rhs, solution, guard, &good));
  if (!good) guard->residual = residual;
  if (!good || guard->in_a_row > guard->max_in_a_row) guard->failed = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A note on what is legal but unwise with the chosen form. */
static PetscErrorCode GuardNote(KSP ksp, const LaplacianForm *form, Guard *guard)
{
  PetscBool   needs_symmetry;
  const char *type, *name = form ? form->row->name : guard->what;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompareAny((PetscObject)ksp, &needs_symmetry, KSPCG, KSPFCG, KSPGROPPCG,
                                      KSPPIPECG, KSPMINRES, KSPSYMMLQ, KSPCR, ""));
  PetscCall(KSPGetType(ksp, &type));
  if (needs_symmetry && !guard->symmetric) {
    PetscCall(PetscSNPrintf(guard->note, sizeof(guard->note),
                            "-%sksp_type %s wants a symmetric matrix, that of %s is not: it may "
                            "fail or take longer than gmres",
                            guard->prefix, type, name));
  } else if (form && !LaplacianIs(form, FORM_SAFE_IMPLICIT)) {
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
. form - the Laplacian that the matrix is of; NULL: it is no symmetric one

  Output Parameter:
. guard - its note says what is legal but unwise

  Options Database Key:
. -fallback N - how many solves in a row may be left to the ladder

  Errors: refuses Cholesky factors of a matrix that is not symmetric, and absolute tolerances
*/
PetscErrorCode GuardAttach(KSP ksp, const LaplacianForm *form, Guard *guard)
{
  PetscBool preonly, chosen, cholesky, icc;
  PC        pc;

  PetscFunctionBegin;
  guard->symmetric = form ? LaplacianIs(form, FORM_SYMMETRIC) : PETSC_FALSE;
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
  guard->max_in_a_row = 10;
  PetscOptionsBegin(PETSC_COMM_WORLD, NULL, "Solvers", "");
  PetscCall(OptionInt("-fallback",
                      "Solves in a row that other methods may make in place of the chosen one; -1: "
                      "none, the first failure ends the step",
                      -1, PETSC_MAX_INT, &guard->max_in_a_row, NULL));
  PetscOptionsEnd();
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* GuardDetach - Frees the ladder's solvers; collective */
PetscErrorCode GuardDetach(Guard *guard)
{
  PetscFunctionBegin;
  for (PetscInt k = 0; k < FALLBACK_LEVELS; k++) PetscCall(KSPDestroy(&guard->level[k]));
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
  } else if (guard->remedy) {
    PetscCall(PetscStrncpy(remedy, guard->remedy, length));
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
  GuardCheck - Tells the step where a solve failed since the last check

  Collective.

  Output Parameter:
. failure - set to a sentence with the step, the methods, the reason and what to try; hopeless where
            the ladder had to be climbed too often in a row
*/
PetscErrorCode GuardCheck(KSP ksp, Guard *guard, StepFailure *failure)
{
  char    remedy[256];
  KSPType ksp_type;
  PCType  pc_type;
  PC      pc;

  PetscFunctionBegin;
  if (!guard->failed) PetscFunctionReturn(PETSC_SUCCESS);
  guard->failed = PETSC_FALSE;
  PetscCall(KSPGetType(ksp, &ksp_type));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PCGetType(pc, &pc_type));
  PetscCall(GuardRemedy(ksp, pc, guard, remedy, sizeof(remedy)));
  if (guard->max_in_a_row >= 0 && guard->in_a_row > guard->max_in_a_row) {
    FailureSet(
        failure, PETSC_ERR_NOT_CONVERGED,
        "%s: %" PetscInt_FMT
        " %s solves in a row were beyond %s with %s (%s) and were left to the fallback ladder; "
        "%s, or -fallback a larger number",
        guard->where, guard->in_a_row, guard->what, ksp_type, pc_type,
        KSPConvergedReasons[guard->reason], remedy);
    failure->fatal = PETSC_TRUE;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  FailureSet(failure, PETSC_ERR_NOT_CONVERGED,
             "%s: the %s solve by %s with %s ended with %s after %" PetscInt_FMT
             " iterations, true residual %.1e of the right-hand side; %s",
             guard->where, guard->what, ksp_type, pc_type, KSPConvergedReasons[guard->reason],
             guard->iterations, (double)guard->residual, remedy);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SolverNames - Types of a KSP and its preconditioner; not collective */
PetscErrorCode SolverNames(KSP ksp, const char **type, const char **pc)
{
  PC inner;

  PetscFunctionBegin;
  PetscCall(KSPGetType(ksp, type));
  PetscCall(KSPGetPC(ksp, &inner));
  PetscCall(PCGetType(inner, pc));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FailureSet - Notes what went wrong, unless something did before; not collective */
void FailureSet(StepFailure *failure, PetscErrorCode code, const char format[], ...)
{
  va_list arguments;

  if (failure->code) return;
  failure->code  = code;
  failure->fatal = PETSC_FALSE;
  va_start(arguments, format);
  (void)vsnprintf(failure->sentence, sizeof(failure->sentence), format, arguments);
  va_end(arguments);
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
