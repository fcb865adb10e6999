/*
  The nonlinear solver for rheologies: a SNES of type newtonls for the residual of a TS stage. Its
  Jacobian is the matrix shift I - nu A with the present viscosities, so its steps are Picard's
  iteration. With -visc_snes_mf_operator this matrix is the preconditioner of Newton's method.
*/
#include "viscosity.h"

static PetscErrorCode TakesNewton(PetscBool *newton)
{
  PetscFunctionBegin;
  *newton = PETSC_FALSE;
  PetscCall(PetscOptionsGetBool(NULL, "visc_", "-snes_mf_operator", newton, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  IterationChoose - Sets defaults of the nonlinear solver, which options may change

  Collective. Measurements with power laws of exponent 0.2 to 3 and with viscoplastic fluids decided
  the line searches. For Picard steps, the type secant (l2 before PETSc 3.24) took half the
  iterations of full steps, and converged in cases in which full steps or bt did not; it may extend
  a step. Newton steps use bt.

  Errors: refuses an absolute tolerance, a SNES type that does not iterate, and -mat_type for a
  Jacobian without entries
*/
PetscErrorCode IterationChoose(SNES snes)
{
  SNESLineSearch search;
  PetscBool      given, newton, type_given, once = PETSC_FALSE;
  char           type[64];

  PetscFunctionBegin;
  PetscCall(PetscOptionsGetString(NULL, "visc_", "-snes_type", type, sizeof(type), &given));
  if (given) PetscCall(PetscStrcmp(type, SNESKSPONLY, &once));
  UserCheck(!once,
            "-visc_snes_type " SNESKSPONLY
            ": the viscosity depends on the flow, so a single solve is not enough; use newtonls");
  PetscCall(PetscOptionsHasName(NULL, "visc_", "-snes_atol", &given));
  UserCheck(!given, "-visc_snes_atol: an absolute tolerance depends on units; use -visc_snes_rtol");
  PetscCall(TakesNewton(&newton));
  PetscCall(PetscOptionsHasName(NULL, "visc_", "-snes_mf", &given));
  PetscCall(OptionGiven("-mat_type", &type_given));
  UserCheck(!type_given || (!newton && !given),
            "-mat_type: PETSc gives it to the matrix-free Jacobian of -visc_snes_mf_operator too, "
            "which has no entries; use -visc_mat_type and -ppe_mat_type");
  PetscCall(SNESSetType(snes, SNESNEWTONLS));
  PetscCall(SNESSetTolerances(snes, 0.0, 1e-6, 0.0, 500, PETSC_INT_MAX));
  /* the first residual is no reference: viscosities at rest may be far off */
  PetscCall(SNESSetDivergenceTolerance(snes, PETSC_UNLIMITED));
  PetscCall(SNESGetLineSearch(snes, &search));
  PetscCall(SNESLineSearchSetType(search, newton ? SNESLINESEARCHBT : SNESLINESEARCHSECANT));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  IterationSetTolerance - Sets the absolute tolerance to -visc_snes_rtol times the scale of the
  residual, because near a steady flow the first residual is small

  Collective. Input: u - velocity at time t, before the step.
*/
PetscErrorCode IterationSetTolerance(Viscosity *v, PetscReal t, Vec u)
{
  PetscReal rtol, stol, scale;
  PetscInt  its, evaluations;
  SNES      snes;

  PetscFunctionBegin;
  PetscCall(TSGetSNES(v->ts[0], &snes));
  PetscCall(SNESGetTolerances(snes, NULL, &rtol, &stol, &its, &evaluations));
  PetscCall(ViscosityScale(v, t, u, v->all_force, &scale));
  PetscCall(SNESSetTolerances(snes, rtol * scale, rtol, stol, its, evaluations));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* IterationCheck - Fails the step if the nonlinear solver did not converge; collective */
PetscErrorCode IterationCheck(TS ts, const char where[], StepFailure *failure)
{
  SNESConvergedReason reason;
  PetscReal           norm, scale;
  PetscBool           newton;
  PetscInt            its;
  SNES                snes;

  PetscFunctionBegin;
  PetscCall(TSGetSNES(ts, &snes));
  PetscCall(SNESGetConvergedReason(snes, &reason));
  if (reason >= 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SNESGetFunctionNorm(snes, &norm));
  PetscCall(SNESGetIterationNumber(snes, &its));
  PetscCall(SNESGetTolerances(snes, &scale, NULL, NULL, NULL, NULL));
  PetscCall(TakesNewton(&newton));
  FailureSet(failure, PETSC_ERR_NOT_CONVERGED,
             "%s: viscosity and velocity did not converge: %s after %" PetscInt_FMT
             " iterations, residual %.1e times the tolerance; try a smaller -dt, %s "
             "-visc_snes_mf_operator, or -rheology_viscosity_min and -rheology_viscosity_max "
             "closer together",
             where, SNESConvergedReasons[reason], its, (double)(norm / scale),
             newton ? "no" : "Newton's steps with");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  IterationFallBack - Replaces the line search secant (l2 before PETSc 3.24) by full Picard steps
  after a failure: from rest this line search may go far beyond the solution and not return

  Collective. Input: failure - failure of the step. Output: again - flag: the line search was
  replaced, so the step should be repeated.
*/
PetscErrorCode IterationFallBack(Viscosity *v, const StepFailure *failure, PetscBool *again)
{
  SNESConvergedReason reason;
  SNESLineSearch      search;
  SNES                snes;

  PetscFunctionBegin;
  *again = PETSC_FALSE;
  if (!failure->code || v->row->multistep) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TSGetSNES(v->ts[0], &snes));
  PetscCall(SNESGetConvergedReason(snes, &reason));
  PetscCall(SNESGetLineSearch(snes, &search));
  PetscCall(PetscObjectTypeCompare((PetscObject)search, SNESLINESEARCHSECANT, again));
  if (reason >= 0) *again = PETSC_FALSE;
  if (!*again) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SNESLineSearchSetType(search, SNESLINESEARCHBASIC));
  PetscCall(
      SayLine("%s: viscosity and velocity did not converge with line search " SNESLINESEARCHSECANT
              ": %s; trying full Picard steps",
              v->guard.where, SNESConvergedReasons[reason]));
  v->guard.solve.falls++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* IterationGoBack - Restores the line search secant after IterationFallBack(); collective */
PetscErrorCode IterationGoBack(Viscosity *v)
{
  SNESLineSearch search;
  SNES           snes;

  PetscFunctionBegin;
  PetscCall(TSGetSNES(v->ts[0], &snes));
  PetscCall(SNESGetLineSearch(snes, &search));
  PetscCall(SNESLineSearchSetType(search, SNESLINESEARCHSECANT));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* IterationView - Prints the nonlinear solver and its line search; collective on the viewer */
PetscErrorCode IterationView(const Viscosity *v, PetscViewer viewer)
{
  SNES               inner;
  SNESLineSearch     line;
  SNESType           snes;
  SNESLineSearchType search;

  PetscFunctionBegin;
  if (!v->nonlinear || !v->guard.solve.ksp) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TSGetSNES(v->ts[0], &inner));
  PetscCall(SNESGetType(inner, &snes));
  PetscCall(SNESGetLineSearch(inner, &line));
  PetscCall(SNESLineSearchGetType(line, &search));
  PetscCall(
      PetscViewerASCIIPrintf(viewer, "%-11s SNES %s, line search %s\n", "nonlinear", snes, search));
  PetscFunctionReturn(PETSC_SUCCESS);
}
