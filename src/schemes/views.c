/*
  Views of solvers: -<prefix>ksp_view after the first solve, and -<prefix>ts_view at the end of the
  run. PETSc's own views do not serve here: PETSc 3.18 loses the viewers of a KSP after a reset for
  another number of particles, newer releases view a KSP in every step, and only TSSolve() views a
  TS, which no step calls.
*/
#include "isph/guard.h"

/*
  SolverViewTake - Creates the viewer of an option and removes the option from the database

  Collective on PETSC_COMM_WORLD. Called before PETSc reads the options of the solver.

  Input Parameters:
+ prefix - prefix of the solver's options
- name   - name of the option, such as "-ksp_view"

  Output Parameter:
. view - with viewer NULL if the option is absent
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

/* SolverViewShow - Views a solver if its option is given; collective */
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
