/*
  The pressure Poisson equation with Neumann conditions all round: singular, solved to a small true
  residual for every form.

    (A + 1 1^T/N) phi = b,   A = -dx^2 L,   preconditioner from A + 1e-6 I

  The rank-one term makes the matrix regular: it fixes the mean of phi and takes from b the uniform
  source that no phi can answer (the left null vector of an unsymmetric L is not constant).
*/
#include "isph/guard.h"

struct Pressure {
  KSP      ksp;
  Guard    guard;
  Mat      preconditioner;      /* A + 1e-6 I as of the last set-up */
  Mat      ones;                /* N x 1, 1/sqrt(N) */
  PetscInt assemblies;          /* stamp of the operators that the KSP has */
  PetscInt epoch;               /* of the last set-up */
  PetscInt iterations, its_new; /* of the last solve, of the first after a set-up */
};

/*
  AmgDefaults - BoomerAMG as measured best for these matrices, where the user says no more

  Collective on PETSC_COMM_WORLD. Input: aggressive - levels of aggressive coarsening, which pay for
  pressures and cost velocities twice the iterations.
*/
PetscErrorCode AmgDefaults(const char prefix[], const char aggressive[])
{
  char      type[32] = PCHYPRE, method[32] = "boomeramg";
  PetscBool amg;

  PetscFunctionBegin;
  PetscCall(PetscOptionsGetString(NULL, prefix, "-pc_type", type, sizeof(type), NULL));
  PetscCall(PetscStrcmp(type, PCHYPRE, &amg));
  if (!amg) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscOptionsGetString(NULL, prefix, "-pc_hypre_type", method, sizeof(method), NULL));
  PetscCall(PetscStrcmp(method, "boomeramg", &amg));
  if (!amg) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(OptionDefault(prefix, "-pc_hypre_boomeramg_coarsen_type", "PMIS"));
  PetscCall(OptionDefault(prefix, "-pc_hypre_boomeramg_interp_type", "ext+i"));
  PetscCall(OptionDefault(prefix, "-pc_hypre_boomeramg_P_max", "4"));
  PetscCall(OptionDefault(prefix, "-pc_hypre_boomeramg_agg_nl", aggressive));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  PressureSolver - A KSP for -dx^2 L, with the options of prefix ppe_ and its guard

  Collective on PETSC_COMM_WORLD. By default cg for a symmetric form, else fgmres, with hypre
  BoomerAMG. Input: rtol - the tolerance where the user gives none; guard - with what and prefix.
*/
PetscErrorCode PressureSolver(const LaplacianForm *form, PetscReal rtol, KSP *ksp, Guard *guard)
{
  PC pc;

  PetscFunctionBegin;
  PetscCall(AmgDefaults("ppe_", "1"));
  PetscCall(KSPCreate(PETSC_COMM_WORLD, ksp));
  PetscCall(KSPSetOptionsPrefix(*ksp, guard->prefix));
  PetscCall(KSPSetType(*ksp, LaplacianIs(form, FORM_SYMMETRIC) ? KSPCG : KSPFGMRES));
  PetscCall(KSPSetTolerances(*ksp, rtol, 0.0, PETSC_DEFAULT, 500));
  PetscCall(KSPGetPC(*ksp, &pc));
  PetscCall(PCSetType(pc, PCHYPRE));
  PetscCall(KSPSetFromOptions(*ksp));
  PetscCall(GuardAttach(*ksp, form, guard));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  PressureCreate - The KSP of the pressure equation

  Collective on PETSC_COMM_WORLD.

  Options Database Keys:
. -ppe_ksp_type, -ppe_pc_type, ... - any of PETSc's, see PressureSolver()
*/
PetscErrorCode PressureCreate(const Operators *ops, Pressure **ppe)
{
  Pressure *s;

  PetscFunctionBegin;
  PetscCall(PetscNew(&s));
  s->guard.what   = "pressure";
  s->guard.prefix = "ppe_";
  PetscCall(PressureSolver(&ops->ppe_form, 1e-5, &s->ksp, &s->guard));
  *ppe = s;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PressureDestroy(Pressure **ppe)
{
  PetscFunctionBegin;
  if (!*ppe) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(GuardDetach(&(*ppe)->guard));
  PetscCall(KSPDestroy(&(*ppe)->ksp));
  PetscCall(MatDestroy(&(*ppe)->preconditioner));
  PetscCall(MatDestroy(&(*ppe)->ones));
  PetscCall(PetscFree(*ppe));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The column of ones for the present numbering. */
static PetscErrorCode PressureRenumber(const Particles *p, Pressure *s)
{
  PetscFunctionBegin;
  PetscCall(KSPReset(s->ksp));
  PetscCall(MatDestroy(&s->preconditioner));
  PetscCall(MatDestroy(&s->ones));
  PetscCall(MatCreateDense(p->comm, p->n_fluid, PETSC_DECIDE, PETSC_DETERMINE, 1, NULL, &s->ones));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscCall(MatSetValue(s->ones, p->fluid_start + i, 0,
                          1.0 / PetscSqrtReal((PetscReal)p->N_fluid), INSERT_VALUES));
  }
  PetscCall(MatAssemblyBegin(s->ones, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(s->ones, MAT_FINAL_ASSEMBLY));
  s->epoch = p->epoch;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Hands new matrices to the KSP. The preconditioner is kept until particles are renumbered or the
  iterations have grown by half: positions change it little, a renumbering destroys it.
*/
static PetscErrorCode PressureUpdateMatrices(const Particles *p, const Operators *ops, Pressure *s)
{
  const PetscBool worn = s->iterations > s->its_new + s->its_new / 2 + 2 ? PETSC_TRUE : PETSC_FALSE;
  PetscBool       rebuild = worn;
  Mat             A;

  PetscFunctionBegin;
  if (s->assemblies == ops->assemblies) PetscFunctionReturn(PETSC_SUCCESS);
  if (s->epoch != p->epoch) {
    PetscCall(PressureRenumber(p, s));
    rebuild = PETSC_TRUE;
  }
  if (rebuild) {
    PetscCall(GuardRenewPC(s->ksp));
    PetscCall(MatDestroy(&s->preconditioner));
    PetscCall(MatDuplicate(ops->ppe.A, MAT_COPY_VALUES, &s->preconditioner));
    PetscCall(MatShift(s->preconditioner, 1e-6));
    s->its_new = 0;
  }
  PetscCall(MatCreateLRC(ops->ppe.A, s->ones, NULL, s->ones, &A));
  PetscCall(KSPSetReusePreconditioner(s->ksp, rebuild ? PETSC_FALSE : PETSC_TRUE));
  PetscCall(KSPSetOperators(s->ksp, A, s->preconditioner));
  PetscCall(MatDestroy(&A));
  s->assemblies = ops->assemblies;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  PressureSolve - Solves A phi = b, A = -dx^2 lap with n.grad phi already in b

  Collective.

  Output Parameters:
+ phi     - of mean zero [Pa]
- failure - set where no method reaches a small true residual
*/
PetscErrorCode PressureSolve(const Clock *clock, const Particles *p, const Operators *ops, Vec b,
                             Vec phi, Pressure *s, StepFailure *failure)
{
  PetscReal norm;

  PetscFunctionBegin;
  PetscCall(PressureUpdateMatrices(p, ops, s));
  PetscCall(VecNorm(b, NORM_2, &norm));
  s->iterations = 0;
  if (norm == 0.0) {
    PetscCall(VecZeroEntries(phi));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(ClockWhere(clock, s->guard.where));
  PetscCall(KSPSolve(s->ksp, b, phi));
  PetscCall(GuardCheck(s->ksp, &s->guard, failure));
  s->iterations = s->guard.iterations;
  if (s->its_new == 0) s->its_new = s->iterations;
  PetscCall(VecRemoveMean(phi));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* PressureNames - Types of the KSP and its preconditioner; not collective */
PetscErrorCode PressureNames(const Pressure *s, const char **ksp, const char **pc)
{
  PetscFunctionBegin;
  PetscCall(SolverNames(s->ksp, ksp, pc));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* PressureFalls - How many solves the fallback ladder has made */
PetscInt *PressureFalls(Pressure *s)
{
  return &s->guard.falls;
}

/* PressureNote - What is unwise in the choice of solver and form, or "" */
const char *PressureNote(const Pressure *s)
{
  return s->guard.note;
}

/* PressureIterations - Iterations of the last solve */
PetscInt PressureIterations(const Pressure *s)
{
  return s->iterations;
}
