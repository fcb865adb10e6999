/*
  Views of solvers that the user asks for: -<prefix>ksp_view after the first solve, and
  -<prefix>ts_view at the end of the run. PETSc 3.18 loses the viewers of a KSP that is reset for
  another number of particles, newer releases view it in every step, and a TS is viewed by TSSolve()
  only, which no step calls.
*/
#include "isph/guard.h"

/*
  SolverViewTake - Takes the viewer of an option, which is then gone from the database

  Collective on PETSC_COMM_WORLD. To be called before PETSc reads the options of the solver.

  Input Parameters:
+ prefix - of the solver
- name   - of the option, "-ksp_view"

  Output Parameter:
. view - viewer NULL if the option is not given
*/
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

/* SolverViewShow - Views a solver, if that was asked for; collective */
PetscErrorCode SolverViewShow(PetscObject solver, const SolverView *view)
{
  PetscFunctionBegin;
  if (!view->viewer) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscViewerPushFormat(view->viewer, view->format));
  PetscCall(PetscObjectView(solver, view->viewer));
  PetscCall(PetscViewerPopFormat(view->viewer));
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
