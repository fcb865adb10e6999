/* The guard: computes the true residual after every linear solve and reports a failure in a
   sentence with a remedy. A method preconditioned by AMG can report convergence although the
   residual is as large as the right-hand side; without the guard the flow would be wrong without a
   message. */
#include "isph/solvers.h"

#define LOOSEST_RTOL 0.01 /* largest allowed tolerance of a KSP */

static const OptionRow options[] = {
    OPTION(INT, "-fallback",
           "largest number of solves in a row that fallback methods may take over (-scheme "
           "coupled keeps those that solved 2); -1: no fallback, the first failure ends the step",
           NULL, "10", .expert = PETSC_TRUE, .low = -1.0, .high = OPTION_HUGE),
};
const OptionTable GuardOptions = OPTIONS("Guard of linear solves", options);

static PetscErrorCode Guard_PostSolve(KSP ksp, Vec rhs, Vec solution, void *ctx)
{
  Guard    *guard = (Guard *)ctx;
  PetscReal residual;
  PetscBool good;

  PetscFunctionBegin;
  PetscCall(KspViewsShow(ksp, &guard->ksp_views));
  if (guard->failed) PetscFunctionReturn(PETSC_SUCCESS); /* only the first failure is reported */
  PetscCall(KSPGetConvergedReason(ksp, &guard->reason));
  PetscCall(KSPGetIterationNumber(ksp, &guard->iterations));
  SetUpCount(guard->iterations, &guard->solve.setup);
  PetscCall(SolveResidual(ksp, rhs, solution, &guard->residual, &good));
  if (guard->inner && guard->reason >= 0) good = PETSC_TRUE;
  if (good) {
    guard->solve.falls_in_a_row = 0;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  residual = guard->residual;
  if (guard->max_in_a_row >= 0) PetscCall(FallbackSolve(rhs, solution, guard, &good));
  if (!good) guard->residual = residual;
  if (!good || guard->solve.falls_in_a_row > guard->max_in_a_row) guard->failed = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Records a note if the KSP needs a symmetric matrix but the matrix is not symmetric, if the
   Laplacian can make an implicit step unstable, or if it damps constants. */
static PetscErrorCode GuardNote(KSP ksp, const LaplacianForm *form, Guard *guard)
{
  PetscBool   needs_symmetry;
  const char *type, *name = form ? form->row->name : guard->solve.name;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompareAny((PetscObject)ksp, &needs_symmetry, KSPCG, KSPFCG, KSPGROPPCG,
                                      KSPPIPECG, KSPMINRES, KSPSYMMLQ, KSPCR, ""));
  PetscCall(KSPGetType(ksp, &type));
  if (needs_symmetry && !guard->symmetric) {
    PetscCall(PetscSNPrintf(guard->solve.note, sizeof(guard->solve.note),
                            "-%sksp_type %s needs a symmetric matrix, and the matrix of %s is "
                            "unsymmetric: it may fail or be slower than gmres",
                            guard->solve.prefix, type, name));
  } else if (form && !LaplacianIs(form, FORM_SAFE_IMPLICIT) &&
             !LaplacianIs(form, FORM_DISSIPATES)) {
    PetscCall(PetscSNPrintf(guard->solve.note, sizeof(guard->solve.note),
                            "-%slaplacian %s is anti-diffusive: it amplifies modes that should "
                            "decay, and an implicit step may be singular",
                            guard->solve.prefix, name));
  } else if (form && !LaplacianIs(form, FORM_NULL_CONSTANTS)) {
    PetscCall(PetscSNPrintf(guard->solve.note, sizeof(guard->solve.note),
                            "-%slaplacian %s does not vanish for constants: uniform velocities "
                            "decay too",
                            guard->solve.prefix, name));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* GuardAttach - Attaches the guard to a KSP, after KSPSetFromOptions(). Collective. Chooses the
   unpreconditioned norm unless the user gives a norm, so that -ksp_rtol limits the true residual.
   Input: form - the Laplacian of the matrix; NULL: an unsymmetric matrix. Output: guard - solve.ksp
   is set, and solve.note if a choice of the user is allowed but unwise. */
PetscErrorCode GuardAttach(KSP ksp, const LaplacianForm *form, Guard *guard)
{
  PetscBool preonly, chosen, cholesky, icc;
  PC        pc;

  PetscFunctionBegin;
  guard->solve.ksp = ksp;
  if (!guard->best) guard->best = KSPGMRES;
  guard->symmetric = form ? LaplacianIs(form, FORM_SYMMETRIC) : PETSC_FALSE;
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PetscObjectTypeCompare((PetscObject)pc, PCICC, &icc));
  PetscCall(PetscObjectTypeCompare((PetscObject)pc, PCCHOLESKY, &cholesky));
  UserCheck(guard->symmetric || (!icc && !cholesky),
            "-%spc_type %s: the chosen form's matrix is not symmetric; use %s", guard->solve.prefix,
            icc ? PCICC : PCCHOLESKY, icc ? "ilu or bjacobi" : "lu");
  PetscCall(PetscOptionsHasName(NULL, guard->solve.prefix, "-ksp_atol", &chosen));
  UserCheck(!chosen, "-%sksp_atol: an absolute tolerance depends on units; use -%sksp_rtol",
            guard->solve.prefix, guard->solve.prefix);
  PetscCall(PCSetUseAmat(pc, PETSC_FALSE)); /* a reused preconditioner keeps its own matrix */
  PetscCall(PetscObjectTypeCompare((PetscObject)ksp, KSPPREONLY, &preonly));
  UserCheck(!preonly || !guard->approximate,
            "-%sksp_type preonly: the preconditioner is of a matrix that is made regular, or of an "
            "earlier one, and a single application leaves an error; use -%sksp_type %s, with "
            "-%spc_type lu for few iterations",
            guard->solve.prefix, guard->solve.prefix, guard->best, guard->solve.prefix);
  PetscCall(PetscOptionsHasName(NULL, guard->solve.prefix, "-ksp_norm_type", &chosen));
  if (!preonly && !chosen) PetscCall(KSPSetNormType(ksp, KSP_NORM_UNPRECONDITIONED));
  PetscCall(KSPSetPostSolve(ksp, Guard_PostSolve, guard));
  PetscCall(GuardNote(ksp, form, guard));
  PetscCall(OptionGetInt(&options[0], &guard->max_in_a_row, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* GuardOnlyMultiplies - Returns whether a shell can stand for the matrix: the solver only
   multiplies, with PCNONE or a given type that needs the diagonal, and no option shows or tests the
   matrix; collective */
PetscErrorCode GuardOnlyMultiplies(SNES snes, PCType type, const Guard *guard, PetscBool *only)
{
  const char *const shows[] = {"-snes_test_jacobian", "-snes_test_jacobian_view"};
  PetscBool         multiplies, diagonal, linear, given[2];
  PC                pc;

  PetscFunctionBegin;
  PetscCall(KSPGetPC(guard->solve.ksp, &pc));
  PetscCall(PetscObjectTypeCompareAny((PetscObject)guard->solve.ksp, &multiplies, KSPGMRES, KSPCG,
                                      KSPFGMRES, KSPBCGS, ""));
  PetscCall(PetscObjectTypeCompareAny((PetscObject)pc, &diagonal, PCNONE, type, ""));
  PetscCall(PetscObjectTypeCompareAny((PetscObject)snes, &linear, SNESKSPONLY, SNESNEWTONLS, ""));
  for (PetscInt k = 0; k < 2; k++)
    PetscCall(PetscOptionsHasName(NULL, guard->solve.prefix, shows[k], &given[k]));
  *only = multiplies && diagonal && linear && !given[0] && !given[1] &&
          !KspViewsHaveMatrix(&guard->ksp_views);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* GuardDetach - Frees the fallback solvers and viewers; collective */
PetscErrorCode GuardDetach(Guard *guard)
{
  PetscFunctionBegin;
  for (PetscInt k = 0; k < FALLBACK_LEVELS; k++) PetscCall(KSPDestroy(&guard->level[k]));
  PetscCall(KspViewsEnd(&guard->ksp_views));
  PetscCall(SolverViewEnd(&guard->ts_view));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes the advice after a failure of a method. */
static PetscErrorCode GuardRemedy(PC pc, const Guard *guard, char remedy[], size_t length)
{
  const char *best = guard->best;
  const KSP   ksp  = guard->solve.ksp;
  PetscBool   cg, is_best, robust;
  PetscReal   rtol;

  PetscFunctionBegin;
  PetscCall(KSPGetTolerances(ksp, &rtol, NULL, NULL, NULL));
  PetscCall(PetscObjectTypeCompare((PetscObject)ksp, KSPCG, &cg));
  PetscCall(PetscObjectTypeCompare((PetscObject)ksp, best, &is_best));
  PetscCall(PetscObjectTypeCompareAny((PetscObject)pc, &robust, PCHYPRE, PCSHELL, ""));
  if (PetscIsInfOrNanReal(guard->residual)) {
    PetscCall(
        PetscSNPrintf(remedy, length, "the flow is no longer finite: try a smaller -dt or -cfl"));
  } else if (guard->remedy) {
    PetscCall(PetscStrncpy(remedy, guard->remedy, length));
  } else if (cg && !guard->symmetric) {
    PetscCall(PetscSNPrintf(
        remedy, length,
        "cg needs a symmetric form, and this form is not symmetric: use -%sksp_type %s",
        guard->solve.prefix, best));
  } else if (rtol > LOOSEST_RTOL) {
    PetscCall(PetscSNPrintf(remedy, length,
                            "the tolerance given is too loose: use a smaller -%sksp_rtol",
                            guard->solve.prefix));
  } else if (!is_best || !robust) {
    PetscCall(PetscSNPrintf(remedy, length, "try -%sksp_type %s -%spc_type hypre",
                            guard->solve.prefix, best, guard->solve.prefix));
  } else {
    PetscCall(PetscSNPrintf(remedy, length,
                            "the matrix is ill-conditioned, most often because particles have "
                            "clustered: try a smaller -dt or -cfl, or a larger -%sksp_max_it",
                            guard->solve.prefix));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* GuardSolve - Solves A x = b by the chosen method, or by the fallback that is kept in its place;
   collective */
PetscErrorCode GuardSolve(Guard *guard, Vec b, Vec x)
{
  PetscBool solved = PETSC_FALSE;

  PetscFunctionBegin;
  guard->residual = 0.0;
  if (FallbackIsKept(guard)) PetscCall(FallbackSolve(b, x, guard, &solved));
  if (!solved) PetscCall(KSPSolve(guard->solve.ksp, b, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* GuardCheck - Fails the step if a solve has failed since the last check. Collective. Output:
   failure - a sentence with the step, the methods, the reason and a remedy; fatal if fallbacks were
   needed too often in a row. */
PetscErrorCode GuardCheck(Guard *guard, StepFailure *failure)
{
  const KSP ksp = guard->solve.ksp;
  char      remedy[256];
  KSPType   ksp_type;
  PCType    pc_type;
  PC        pc;

  PetscFunctionBegin;
  if (!guard->failed) PetscFunctionReturn(PETSC_SUCCESS);
  guard->failed = PETSC_FALSE;
  PetscCall(SolverNames(ksp, &ksp_type, &pc_type));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(GuardRemedy(pc, guard, remedy, sizeof(remedy)));
  if (guard->max_in_a_row >= 0 && guard->solve.falls_in_a_row > guard->max_in_a_row) {
    FailureSet(failure, PETSC_ERR_NOT_CONVERGED,
               "%s: %" PetscInt_FMT " %s solves in a row failed by %s with %s (%s) and needed a "
               "fallback; %s, or give -fallback a larger number",
               guard->where, guard->solve.falls_in_a_row, guard->solve.name, ksp_type, pc_type,
               KSPConvergedReasons[guard->reason], remedy);
    failure->fatal = PETSC_TRUE;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  FailureSet(failure, PETSC_ERR_NOT_CONVERGED,
             "%s: the %s solve by %s with %s ended with %s after %" PetscInt_FMT
             " iterations, true residual %.1e of the right-hand side; %s",
             guard->where, guard->solve.name, ksp_type, pc_type, KSPConvergedReasons[guard->reason],
             guard->iterations, (double)guard->residual, remedy);
  PetscFunctionReturn(PETSC_SUCCESS);
}
