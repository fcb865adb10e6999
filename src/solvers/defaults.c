/* Defaults of linear solvers, set in the options database so that options of the user take
   precedence, and renewal of a preconditioner for a new matrix. */
#include "isph/solvers.h"
#include <strings.h>

/* OptionDefault - Sets an option in the database unless it is given; name: with its dash */
PetscErrorCode OptionDefault(const char prefix[], const char name[], const char value[])
{
  char      option[128];
  PetscBool given;

  PetscFunctionBegin;
  PetscCall(PetscOptionsHasName(NULL, prefix, name, &given));
  if (given) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscSNPrintf(option, sizeof(option), "-%s%s", prefix, name + 1));
  PetscCall(PetscOptionsSetValue(NULL, option, value));
  PetscCall(
      PetscOptionsHasName(NULL, prefix, name, &given)); /* counts it as read: no user gave it */
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FactorDefault - Chooses MUMPS for the factors of LU, where PETSc has it: it takes pivots, and a
   third of the time of PETSc's own; name: the option of the package, with its dash */
PetscErrorCode FactorDefault(const char prefix[], const char name[])
{
  PetscFunctionBegin;
  if (PetscDefined(HAVE_MUMPS)) PetscCall(OptionDefault(prefix, name, MATSOLVERMUMPS));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses interpolations that need the number of unknowns of a block: without it hypre ends in a
   segmentation fault. */
static PetscErrorCode RefuseBlocks(const char prefix[])
{
  const char *const name     = "-pc_hypre_boomeramg_interp_type";
  char              type[64] = "";

  PetscFunctionBegin;
  PetscCall(PetscOptionsGetString(NULL, prefix, name, type, sizeof(type), NULL));
  UserCheck(strncasecmp(type, "block", 5),
            "-%s%s %s: it is for blocks of unknowns, which this matrix has not; use ext+i", prefix,
            name + 1, type);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns true if the solver of a prefix is BoomerAMG: by default, or by options. */
static PetscErrorCode IsBoomerAmg(const char prefix[], PetscBool *amg)
{
  char type[32] = PCHYPRE, method[32] = "boomeramg";

  PetscFunctionBegin;
  PetscCall(PetscOptionsGetString(NULL, prefix, "-pc_type", type, sizeof(type), NULL));
  PetscCall(PetscStrcmp(type, PCHYPRE, amg));
  if (!*amg) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscOptionsGetString(NULL, prefix, "-pc_hypre_type", method, sizeof(method), NULL));
  PetscCall(PetscStrcmp(method, "boomeramg", amg));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* AmgDefaults - Sets the parameters of BoomerAMG that measurements found best, unless they are
   given. Collective on PETSC_COMM_WORLD. Input: aggressive - number of levels with aggressive
   coarsening; such levels make pressure solves faster but double the iterations of velocity
   solves. */
PetscErrorCode AmgDefaults(const char prefix[], const char aggressive[])
{
  PetscBool amg;

  PetscFunctionBegin;
  PetscCall(IsBoomerAmg(prefix, &amg));
  if (!amg) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(OptionDefault(prefix, "-pc_hypre_boomeramg_coarsen_type", "PMIS"));
  PetscCall(OptionDefault(prefix, "-pc_hypre_boomeramg_interp_type", "ext+i"));
  PetscCall(RefuseBlocks(prefix));
  PetscCall(OptionDefault(prefix, "-pc_hypre_boomeramg_P_max", "4"));
  PetscCall(OptionDefault(prefix, "-pc_hypre_boomeramg_agg_nl", aggressive));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  AmgDiagonal - Raises small diagonal entries of the matrix of a preconditioner, by which sweeps of
  AMG divide

    a_ii <- max(a_ii, sum_{j != i} |a_ij| / 2)

  Collective. For matrices of particles: there only fits of the Laplacian whose particles lie on one
  side have such entries, also negative ones; theory.md, (solvers:diagonal). Matrices of splines
  have right ones.
*/
PetscErrorCode AmgDiagonal(Mat A)
{
  PetscScalar *entry;
  PetscInt     first, n;
  Vec          diagonal;

  PetscFunctionBegin;
  PetscCall(MatCreateVecs(A, NULL, &diagonal));
  PetscCall(MatGetDiagonal(A, diagonal));
  PetscCall(MatGetOwnershipRange(A, &first, NULL));
  PetscCall(VecGetLocalSize(diagonal, &n));
  PetscCall(VecGetArray(diagonal, &entry));
  for (PetscInt i = 0; i < n; i++) {
    const PetscScalar *a;
    PetscInt           count;
    PetscReal          others = -PetscAbsScalar(entry[i]);

    PetscCall(MatGetRow(A, first + i, &count, NULL, &a));
    for (PetscInt k = 0; k < count; k++) others += PetscAbsScalar(a[k]);
    PetscCall(MatRestoreRow(A, first + i, &count, NULL, &a));
    entry[i] = PetscMax(entry[i], 0.5 * others);
  }
  PetscCall(VecRestoreArray(diagonal, &entry));
  PetscCall(MatDiagonalSet(A, diagonal, INSERT_VALUES));
  PetscCall(VecDestroy(&diagonal));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets limits of PETSc's AMG by which its coarse levels are on fewer ranks, unless they are given:
   they send a third less messages. */
static PetscErrorCode GamgDefaults(const char prefix[])
{
  PetscFunctionBegin;
  PetscCall(OptionDefault(prefix, "-pc_gamg_process_eq_limit", "2000"));
  PetscCall(OptionDefault(prefix, "-pc_gamg_coarse_eq_limit", "200"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* PoissonSolver - Creates the KSP of a Poisson equation, with the options of the guard's prefix,
   and attaches the guard. Collective on PETSC_COMM_WORLD. The default method is cg for a symmetric
   form, otherwise fgmres. Input: rtol - default tolerance; type - default preconditioner; PCHYPRE:
   BoomerAMG with the parameters of AmgDefaults(); PCGAMG: with GamgDefaults(). Input/Output: guard
   - in: name and prefix; out: attached to solve.ksp, which the caller destroys. */
PetscErrorCode PoissonSolver(const LaplacianForm *form, PetscReal rtol, PCType type, Guard *guard)
{
  PetscBool amg, gamg;
  KSP       ksp;
  PC        pc;

  PetscFunctionBegin;
  PetscCall(PetscStrcmp(type, PCHYPRE, &amg));
  if (amg) PetscCall(AmgDefaults(guard->solve.prefix, "1"));
  PetscCall(PetscStrcmp(type, PCGAMG, &gamg));
  if (gamg) PetscCall(GamgDefaults(guard->solve.prefix));
  PetscCall(KSPCreate(PETSC_COMM_WORLD, &ksp));
  PetscCall(KSPSetOptionsPrefix(ksp, guard->solve.prefix));
  PetscCall(KSPSetType(ksp, form && LaplacianIs(form, FORM_SYMMETRIC) ? KSPCG : KSPFGMRES));
  PetscCall(KSPSetTolerances(ksp, rtol, 0.0, PETSC_CURRENT, 500));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PCSetType(pc, type));
  PetscCall(KspViewsTake(guard->solve.prefix, &guard->ksp_views));
  PetscCall(KSPSetFromOptions(ksp));
  guard->best = KSPFGMRES;
  PetscCall(GuardAttach(ksp, form, guard));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SolverRenewPC - Prepares a preconditioner for a matrix of another pattern or size. Collective.
   PCReset() suffices for all types except gamg, whose coarse levels keep their old sizes (PETSc
   3.18). */
PetscErrorCode SolverRenewPC(KSP ksp)
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

/* SolverAttachShell - Gives a block of a field split a shell as preconditioner, unless the user has
   chosen another type for it. Collective. Input: block - its number; name - of the shell; ctx - its
   context. */
PetscErrorCode SolverAttachShell(PC fieldsplit, PetscInt block, const char name[], void *ctx,
                                 PetscErrorCode (*Apply)(PC, Vec, Vec))
{
  KSP      *sub;
  PetscBool shell;
  PC        pc;

  PetscFunctionBegin;
  PetscCall(PCFieldSplitGetSubKSP(fieldsplit, NULL, &sub));
  PetscCall(KSPGetPC(sub[block], &pc));
  PetscCall(PetscObjectTypeCompare((PetscObject)pc, PCSHELL, &shell));
  if (shell) {
    PetscCall(PCShellSetContext(pc, ctx));
    PetscCall(PCShellSetApply(pc, Apply));
    PetscCall(PCShellSetName(pc, name));
  }
  PetscCall(PetscFree(sub));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SolverSetUpGamg - Sets up PETSc's AMG so that sums have the same order in every run. Collective.
   Does nothing for other preconditioners. The default algorithm for the coarse matrices P^T A P
   adds the parts of other ranks in the order in which they arrive (PETSc 3.18), and runs on four
   ranks differed in their last digits. Matrices of one rank do not have the other algorithm. */
PetscErrorCode SolverSetUpGamg(KSP ksp)
{
  const char *const algorithm = "-matptap_via";
  PetscBool         gamg;
  PetscMPIInt       ranks;
  PC                pc;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(PetscObjectComm((PetscObject)ksp), &ranks));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PetscObjectTypeCompare((PetscObject)pc, PCGAMG, &gamg));
  if (!gamg || ranks == 1) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscOptionsSetValue(NULL, algorithm, "allatonce")); /* a user cannot give it */
  PetscCall(KSPSetUp(ksp));
  PetscCall(PetscOptionsClearValue(NULL, algorithm));
  PetscFunctionReturn(PETSC_SUCCESS);
}
