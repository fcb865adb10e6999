/* The nonlinear solver for rheologies: a SNES of type newtonls for the residual of a TS stage. Its
   Jacobian is the matrix shift I - nu A with the present viscosities, the preconditioner, and the
   term of their changes by the velocity, which src/operators/tangent.c computes. */
#include "viscosity.h"

#define ITERATION_MOST 50 /* largest number of iterations of a stage */

/* Ends the iteration if its residual is at most -visc_snes_rtol times its scale, the force or
   tau/L, and the stresses are those of the velocity; otherwise linearises them about the velocity.
   The first residual is no scale: near a steady flow it is small, and at rest it may be that of a
   viscosity far off. */
static PetscErrorCode Test(SNES snes, PetscInt it, PetscReal x, PetscReal dx, PetscReal norm,
                           SNESConvergedReason *reason, void *ctx)
{
  Viscosity *v = (Viscosity *)ctx;
  PetscReal  rtol, force;
  PetscInt   rows;
  Vec        u;

  PetscFunctionBegin;
  PetscCall(SNESGetSolution(snes, &u));
  PetscCall(VecGetSize(u, &rows));
  PetscCall(SNESGetTolerances(snes, NULL, &rtol, NULL, NULL, NULL));
  PetscCall(VecNorm(v->all_force, NORM_2, &force));
  PetscCall(ViscosityLinearise(v, u));
  v->tolerance =
      rtol * PetscMax(force, PetscSqrtReal(rows) * v->tangent->stress / v->flow->scene->length);
  v->residual = norm;
  *reason     = SNES_CONVERGED_ITERATING;
  if (PetscIsInfOrNanReal(norm)) *reason = SNES_DIVERGED_FNORM_NAN;
  else if (norm <= v->tolerance && v->tangent->error <= STRESS_ERROR)
    *reason = SNES_CONVERGED_FNORM_ABS;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Shortens a step u - du that goes far beyond the solution, see TangentShare(). */
static PetscErrorCode Shorten(SNESLineSearch search, Vec u, Vec du, Vec next, PetscBool *du_is_new,
                              PetscBool *next_is_new, void *ctx)
{
  Viscosity *v = (Viscosity *)ctx;
  PetscReal  share;

  PetscFunctionBegin;
  for (PetscInt c = 0; c < v->dim; c++)
    PetscCall(VecStrideGather(next, c, v->part[c], INSERT_VALUES));
  PetscCall(TangentShare(v->tangent, v->part, &v->flow->walls, &share));
  *du_is_new   = PETSC_FALSE;
  *next_is_new = share < 1.0;
  if (*next_is_new) PetscCall(VecAXPBY(next, 1.0 - share, share, u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* IterationChoose - Sets defaults of the nonlinear solver, which options may change. Collective.
   Steps are full: their stresses keep the iteration from going round in circles, see
   TangentFollow(). A line search by the residual would shorten them, because the residual of a
   rigid part hides that of the others. */
PetscErrorCode IterationChoose(Viscosity *v, SNES snes)
{
  SNESLineSearch search;
  PetscBool      given, once = PETSC_FALSE;
  char           type[64];

  PetscFunctionBegin;
  PetscCall(PetscOptionsGetString(NULL, "visc_", "-snes_type", type, sizeof(type), &given));
  if (given) PetscCall(PetscStrcmp(type, SNESKSPONLY, &once));
  UserCheck(!once,
            "-visc_snes_type " SNESKSPONLY
            ": the viscosity depends on the flow, so a single solve is not enough; use newtonls");
  PetscCall(PetscOptionsHasName(NULL, "visc_", "-snes_atol", &given));
  UserCheck(!given, "-visc_snes_atol: an absolute tolerance depends on units; use -visc_snes_rtol");
  PetscCall(SNESSetType(snes, SNESNEWTONLS));
  PetscCall(SNESSetTolerances(snes, 0.0, 1e-6, 0.0, ITERATION_MOST, PETSC_INT_MAX));
  /* the first residual is no reference: viscosities at rest may be far off */
  PetscCall(SNESSetDivergenceTolerance(snes, PETSC_UNLIMITED));
  PetscCall(SNESSetApplicationContext(snes, v));
  PetscCall(SNESSetConvergenceTest(snes, Test, v, NULL));
  PetscCall(SNESGetLineSearch(snes, &search));
  PetscCall(SNESLineSearchSetType(search, SNESLINESEARCHBASIC));
  PetscCall(SNESLineSearchSetPostCheck(search, Shorten, v));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* IterationCheck - Fails the step if the nonlinear solver did not converge; collective */
PetscErrorCode IterationCheck(TS ts, const char where[], StepFailure *failure)
{
  SNESConvergedReason reason;
  Viscosity          *v;
  PetscInt            its;
  SNES                snes;

  PetscFunctionBegin;
  PetscCall(TSGetSNES(ts, &snes));
  PetscCall(SNESGetConvergedReason(snes, &reason));
  if (reason >= 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SNESGetApplicationContext(snes, (void *)&v));
  PetscCall(SNESGetIterationNumber(snes, &its));
  FailureSet(failure, PETSC_ERR_NOT_CONVERGED,
             "%s: viscosity and velocity did not converge: %s after %" PetscInt_FMT
             " iterations, residual %.1e times the tolerance, stresses off by %.1e; try a smaller "
             "-dt, or -rheology_viscosity_min and -rheology_viscosity_max closer together",
             where, SNESConvergedReasons[reason], its, (double)(v->residual / v->tolerance),
             (double)v->tangent->error);
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
