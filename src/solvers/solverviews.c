/* Views of solvers: -<prefix>ksp_view, and views of the linear system, after the first solve;
   -<prefix>ts_view at the end of the run. PETSc's own views do not serve here: PETSc 3.18 loses the
   viewers of a KSP after a reset for another number of particles, newer releases view a KSP in
   every step, and only TSSolve(), which no step calls, views a TS. */
#include "isph/solvers.h"

/* SolverViewTake - Creates the viewer of an option and removes the option from the database.
   Collective on PETSC_COMM_WORLD. Called before PETSc reads the options of the solver. Input:
   prefix - prefix of the solver's options; name - name of the option, such as "-ksp_view". Output:
   view - the viewer, which is NULL if the option is absent. */
PetscErrorCode SolverViewTake(const char prefix[], const char name[], SolverView *view)
{
  char      option[128];
  PetscBool given;

  PetscFunctionBegin;
  PetscCall(PetscOptionsCreateViewer(PETSC_COMM_WORLD, NULL, prefix, name, &view->viewer,
                                     &view->format, &given));
  if (!given) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscSNPrintf(option, sizeof(option), "-%s%s", prefix, name + 1));
  PetscCall(PetscOptionsClearValue(NULL, option));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SolverViewShow - Views a solver if its option is given; collective */
PetscErrorCode SolverViewShow(PetscObject solver, const SolverView *view)
{
  PetscFunctionBegin;
  if (!view->viewer) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscViewerPushFormat(view->viewer, view->format));
  PetscCall(PetscObjectView(solver, view->viewer));
  PetscCall(PetscViewerPopFormat(view->viewer));
  PetscCall(ViewerCheck(view->viewer, "A view of a solver"));
  PetscCall(PetscViewerFlush(view->viewer));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SolverViewEnd - Closes the viewer; collective */
PetscErrorCode SolverViewEnd(SolverView *view)
{
  PetscFunctionBegin;
  PetscCall(PetscViewerDestroy(&view->viewer));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The views of KspViews, in the order of KspViewsShow(). */
enum { VIEW_MAT = 1, VIEW_PMAT = 2 };
static const char *const names[KSP_VIEWS] = {"-ksp_view", "-ksp_view_mat", "-ksp_view_pmat",
                                             "-ksp_view_rhs", "-ksp_view_solution"};

/* Views of KSPView's family that a solve here does not reach. */
static const char *const refused[] = {
    "-ksp_view_eigenvalues",          "-ksp_view_singularvalues",
    "-ksp_view_final_residual",       "-ksp_view_mat_explicit",
    "-ksp_view_diagonal_scale",       "-ksp_view_pre",
    "-ksp_compute_eigenvalues",       "-ksp_compute_singularvalues",
    "-ksp_plot_eigenvalues",          "-ksp_converged_rate",
    "-ksp_view_eigenvalues_explicit", "-ksp_view_preconditioned_operator_explicit"};

/* KspViewsTake - Creates the viewers of a KSP's options, as SolverViewTake() does. Collective.
   Errors: refuses the views that no solve here would show. */
PetscErrorCode KspViewsTake(const char prefix[], KspViews *views)
{
  PetscBool given;

  PetscFunctionBegin;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(refused); k++) {
    PetscCall(PetscOptionsHasName(NULL, prefix, refused[k], &given));
    UserCheck(!given,
              "-%s%s: solves here do not compute it; -%sksp_view_mat binary:file writes the matrix "
              "for other programs, -%sksp_monitor_true_residual shows the iterations",
              prefix, refused[k] + 1, prefix, prefix);
  }
  for (PetscInt k = 0; k < KSP_VIEWS; k++)
    PetscCall(SolverViewTake(prefix, names[k], &views->of[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* KspViewsHaveMatrix - Returns true if the entries of a matrix are to be viewed */
PetscBool KspViewsHaveMatrix(const KspViews *views)
{
  return views->of[VIEW_MAT].viewer || views->of[VIEW_PMAT].viewer;
}

/* KspViewsShow - Views a KSP and its last linear system if their options are given, and closes the
   viewers. Collective. If the matrix is A + c c^T, with a term that fixes the constant of the
   pressure, only A is viewed. */
PetscErrorCode KspViewsShow(KSP ksp, KspViews *views)
{
  PetscBool low_rank;
  Mat       A, P;
  Vec       b, x;

  PetscFunctionBegin;
  PetscCall(KSPGetOperators(ksp, &A, &P));
  PetscCall(PetscObjectTypeCompare((PetscObject)A, MATLRC, &low_rank));
  if (low_rank) PetscCall(MatLRCGetMats(A, &A, NULL, NULL, NULL));
  PetscCall(KSPGetRhs(ksp, &b));
  PetscCall(KSPGetSolution(ksp, &x));
  const PetscObject of[KSP_VIEWS] = {(PetscObject)ksp, (PetscObject)A, (PetscObject)P,
                                     (PetscObject)b, (PetscObject)x};
  for (PetscInt k = 0; k < KSP_VIEWS; k++) PetscCall(SolverViewShow(of[k], &views->of[k]));
  PetscCall(KspViewsEnd(views));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* KspViewsEnd - Closes the viewers; collective */
PetscErrorCode KspViewsEnd(KspViews *views)
{
  PetscFunctionBegin;
  for (PetscInt k = 0; k < KSP_VIEWS; k++) PetscCall(SolverViewEnd(&views->of[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}
