/* Fallbacks of a linear solve: if the true residual of the chosen method is not small enough, other
   methods solve the same system, from the cheapest to the most robust. Each fallback is printed and
   counted. */
#include "isph/solvers.h"

#define RESIDUAL_SLACK 10.0 /* accepted true residual divided by the tolerance */
#define RESIDUAL_WORST 0.1  /* largest true residual accepted with any tolerance */
#define KEPT_FROM      2    /* solves in a row by fallbacks, from which they are kept */
#define KEPT_FOR       16   /* solves, until the chosen method is tried again */

/* SolveResidual - Computes the true residual |b - A x|/|b| of a solve. Collective. Output: good -
   flag: the method reports success, and the residual is at most ten times its tolerance and at most
   0.1. */
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
  *good     = reason >= 0 && norm_r <= PetscMin(RESIDUAL_SLACK * rtol, RESIDUAL_WORST) * norm_b;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SolverNames - Returns the types of a KSP and its preconditioner, the name of a shell */
PetscErrorCode SolverNames(KSP ksp, const char **type, const char **pc)
{
  PetscBool is_shell;
  PC        inner;

  PetscFunctionBegin;
  PetscCall(KSPGetType(ksp, type));
  PetscCall(KSPGetPC(ksp, &inner));
  PetscCall(PCGetType(inner, pc));
  PetscCall(PetscObjectTypeCompare((PetscObject)inner, PCSHELL, &is_shell));
  if (is_shell) PetscCall(PCShellGetName(inner, pc));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The fallback methods in their order; they use the matrix of the preconditioner. */
static const struct {
  const char *ksp, *pc;
  PetscInt    most;   /* largest number of rows; 0: any */
  PetscBool   nested; /* suits nested matrices, after flattening */
} levels[FALLBACK_LEVELS] = {
    {KSPGMRES, PCHYPRE, 0, PETSC_FALSE},
    {KSPGMRES, PCBJACOBI, 0, PETSC_FALSE},
    {KSPFGMRES, PCLU, 20000, PETSC_TRUE},
};

#define FLAT_MOST 6 /* times as many rows of a flat system have factors of the same size */

/* Returns the largest number of rows for a fallback; 0: any. */
static PetscInt MostRows(PetscInt k, const Guard *guard)
{
  return guard->flat ? FLAT_MOST * levels[k].most : levels[k].most;
}

/* Creates the solver of a fallback when it is first needed. */
static PetscErrorCode FallbackLevel(PetscInt k, Guard *guard)
{
  PC pc;

  PetscFunctionBegin;
  if (guard->level[k]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(KSPCreate(PETSC_COMM_WORLD, &guard->level[k]));
  PetscCall(KSPSetType(guard->level[k], levels[k].ksp));
  PetscCall(KSPGMRESSetRestart(guard->level[k], 60));
  PetscCall(KSPSetPCSide(guard->level[k], PC_RIGHT)); /* iterates on the true residual */
  PetscCall(KSPGetPC(guard->level[k], &pc));
  PetscCall(PCSetType(pc, levels[k].pc));
  if (PetscDefined(HAVE_MUMPS) && levels[k].most)
    PetscCall(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Checks if a fallback is the failed method itself, is too expensive, or needs a parallel
   factorisation that this PETSc lacks. */
static PetscErrorCode FallbackSkips(const Guard *guard, PetscInt k, PetscInt rows, PetscBool nested,
                                    PetscBool *skips)
{
  const KSP   ksp = guard->solve.ksp;
  PetscBool   same_ksp, same_pc;
  PetscMPIInt ranks;
  PC          pc;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &ranks));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PetscObjectTypeCompare((PetscObject)ksp, levels[k].ksp, &same_ksp));
  PetscCall(PetscObjectTypeCompare((PetscObject)pc, levels[k].pc, &same_pc));
  *skips = (same_ksp && same_pc) || (levels[k].most && rows > MostRows(k, guard)) ||
           (nested && !levels[k].nested) ||
           (levels[k].most && ranks > 1 && !PetscDefined(HAVE_MUMPS));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FallbackIsKept - Returns true if fallbacks solve in place of the chosen method, which has failed
   in KEPT_FROM solves in a row; it is tried again after KEPT_FOR solves. Not collective. The count
   is in the memory of the run, so that a restarted run takes the same methods. */
PetscBool FallbackIsKept(const Guard *guard)
{
  const PetscInt falls = guard->solve.falls_in_a_row;

  return guard->keeps && falls >= KEPT_FROM && falls < KEPT_FROM + KEPT_FOR;
}

/* Prints and counts a solve by a fallback. A kept one is counted only. */
static PetscErrorCode Count(PetscInt k, PetscBool kept, Guard *guard)
{
  KSPType ksp_type;
  PCType  pc_type;
  char    stays[64] = "";

  PetscFunctionBegin;
  guard->solve.falls++;
  if (guard->keeps && !kept) {
    guard->solve.falls_in_a_row = PetscMin(guard->solve.falls_in_a_row, KEPT_FROM - 1);
  }
  guard->solve.falls_in_a_row++;
  if (kept) PetscFunctionReturn(PETSC_SUCCESS);
  if (FallbackIsKept(guard))
    PetscCall(
        PetscSNPrintf(stays, sizeof(stays), ", and is kept for the next %d solves", KEPT_FOR));
  PetscCall(SolverNames(guard->solve.ksp, &ksp_type, &pc_type));
  PetscCall(SayLine("%s: the %s solve by %s with %s ended with %s; %s with %s solved it%s",
                    guard->where, guard->solve.name, ksp_type, pc_type,
                    KSPConvergedReasons[guard->reason], levels[k].ksp, levels[k].pc, stays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FallbackSolve - Solves A x = b again by fallbacks, until the true residual is small enough.
   Collective. Input: b - the right-hand side; guard - guard of the failed solver, which has the
   matrices and the tolerance. Output: x - the solution, if solved; solved - PETSC_FALSE if no
   method reached a small true residual, or if the residual of the failed solver is not finite.
   Notes: each fallback that is not kept is printed; guard->solve.falls counts all fallbacks, and
   falls_in_a_row those since the last success of the chosen method, or of those that are kept since
   it was last tried. */
PetscErrorCode FallbackSolve(Vec b, Vec x, Guard *guard, PetscBool *solved)
{
  const KSP       ksp  = guard->solve.ksp;
  const PetscBool kept = FallbackIsKept(guard);
  Mat             A, P, flat = NULL;
  PetscInt        rows;
  PetscBool       nested = PETSC_FALSE;
  PetscReal       rtol;

  PetscFunctionBegin;
  *solved = PETSC_FALSE;
  if (PetscIsInfOrNanReal(guard->residual)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(KSPGetTolerances(ksp, &rtol, NULL, NULL, NULL));
  PetscCall(KSPGetOperators(ksp, &A, &P));
  PetscCall(MatGetSize(A, &rows, NULL));
  if (guard->Flatten) {
    PetscCall(PetscObjectTypeCompare((PetscObject)P, MATNEST, &nested));
    if (!nested || rows <= MostRows(FALLBACK_LEVELS - 1, guard))
      PetscCall(guard->Flatten(P, &flat));
  }
  for (PetscInt k = 0; k < FALLBACK_LEVELS && !*solved; k++) {
    PetscBool skips = PETSC_FALSE;

    PetscCall(FallbackSkips(guard, k, rows, nested, &skips));
    if (skips) continue;
    PetscCall(FallbackLevel(k, guard));
    PetscCall(KSPReset(guard->level[k]));
    PetscCall(KSPSetTolerances(guard->level[k], rtol, 0.0, PETSC_CURRENT, 1000));
    PetscCall(KSPSetOperators(guard->level[k], A, flat ? flat : P));
    PetscCall(KSPSolve(guard->level[k], b, x));
    PetscCall(SolveResidual(guard->level[k], b, x, &guard->residual, solved));
    if (kept) PetscCall(KSPGetIterationNumber(guard->level[k], &guard->iterations));
    if (*solved) PetscCall(Count(k, kept, guard));
  }
  PetscCall(MatDestroy(&flat));
  PetscFunctionReturn(PETSC_SUCCESS);
}
