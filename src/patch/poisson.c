/* The Poisson problem of a patch test: solves L f = lap f for f in the box; lap f in the box and f
   around it are exact. */
#include "isph/solvers.h"
#include "isph/patch.h"

/* Computes the right-hand side of -dx^2 A f = -dx^2 (lap f - B f_around), where L f is
   A f + B f_around. */
static PetscErrorCode PoissonSource(const Patch *patch, Vec b)
{
  PetscFunctionBegin;
  PetscCall(MatMult(patch->ops->velocity[0].visc.B, patch->f_around, b));
  PetscCall(VecAYPX(b, -1.0, patch->exact));
  PetscCall(VecScale(b, -PetscSqr(patch->scene->dx)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* PatchSolve - Solves the Poisson problem by the KSP with prefix ppe_; collective. Reports
   solution_l2 and solution_linf, the errors relative to the field; solve_its, the number of
   iterations; setup_s and solve_s, the times of KSPSetUp() and KSPSolve() [s]. */
PetscErrorCode PatchSolve(const Patch *patch, Report *report)
{
  Guard          guard   = {.solve = {.name = "Poisson", .prefix = "ppe_"}, .where = "patch test"};
  StepFailure    failure = {0};
  PetscLogDouble start, ready, end;
  PetscReal      error[2], norm[2];
  KSP            ksp;
  Mat            A;
  Vec            b, f;

  PetscFunctionBegin;
  PetscCall(PoissonSolver(&patch->ops->forms.visc, 1e-10, PCHYPRE, &guard));
  ksp                = guard.solve.ksp;
  guard.max_in_a_row = -1; /* no fallback: the chosen method is measured */
  PetscCall(OptionsRefuseUnknown(PETSC_FALSE));
  if (guard.solve.note[0])
    PetscCall(PetscPrintf(PETSC_COMM_WORLD, "unwise      %s\n", guard.solve.note));
  PetscCall(MatDuplicate(patch->ops->velocity[0].visc.A, MAT_COPY_VALUES, &A));
  PetscCall(MatScale(A, -PetscSqr(patch->scene->dx)));
  PetscCall(VecDuplicate(patch->f, &b));
  PetscCall(VecDuplicate(patch->f, &f));
  PetscCall(PoissonSource(patch, b));
  PetscCall(PetscTime(&start));
  PetscCall(KSPSetOperators(ksp, A, A));
  PetscCall(KSPSetUp(ksp));
  PetscCall(PetscTime(&ready));
  PetscCall(KSPSolve(ksp, b, f));
  PetscCall(PetscTime(&end));
  PetscCall(GuardCheck(&guard, &failure));
  PetscCheck(!failure.code, PETSC_COMM_WORLD, failure.code, "%s", failure.sentence);
  PetscCall(VecAXPY(f, -1.0, patch->f));
  PetscCall(VecNorm(f, NORM_2, &error[0]));
  PetscCall(VecNorm(f, NORM_INFINITY, &error[1]));
  PetscCall(VecNorm(patch->f, NORM_2, &norm[0]));
  PetscCall(VecNorm(patch->f, NORM_INFINITY, &norm[1]));
  PetscCall(ReportAddError(report, "solution_l2", error[0] / norm[0]));
  PetscCall(ReportAddError(report, "solution_linf", error[1] / norm[1]));
  PetscCall(ReportAdd(report, "solve_its", guard.iterations));
  PetscCall(ReportAdd(report, "setup_s", ready - start));
  PetscCall(ReportAdd(report, "solve_s", end - ready));
  PetscCall(VecDestroyAll(&f, &b));
  PetscCall(MatDestroy(&A));
  PetscCall(KSPDestroy(&ksp));
  PetscFunctionReturn(PETSC_SUCCESS);
}
