/*
  Time kinds: which TS types advance viscosity, and which callback layout each wants. One layout
  cannot serve all: explicit types refuse an IFunction, and implicit ones take an RHSFunction beside
  it with the wrong Jacobian.
*/
#include "viscosity.h"

/*
  TimeOptionsRefuse - Ends the run where an option of a TS would own time, or a theta that type has
  not

  Collective. PETSc's beuler and cn are theta schemes, whose number they would refuse only in the
  first step.
*/
PetscErrorCode TimeOptionsRefuse(const char prefix[], const char type[])
{
  const char *const refused[][2] = {
      {"ts_dt", "-dt"}, {"ts_max_time", "-t_end"}, {"ts_max_steps", "-max_steps"}};
  char      option[64];
  PetscBool given, theta;

  PetscFunctionBegin;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(refused); k++) {
    PetscCall(PetscSNPrintf(option, sizeof(option), "-%s%s", prefix, refused[k][0]));
    PetscCall(OptionGiven(option, &given));
    UserCheck(!given, "%s: time is the run's own; use %s", option, refused[k][1]);
  }
  PetscCall(PetscStrcmp(type, TSTHETA, &theta));
  PetscCall(PetscSNPrintf(option, sizeof(option), "-%sts_theta_theta", prefix));
  if (!theta) PetscCall(OptionGiven(option, &given));
  UserCheck(theta || !given, "%s: -%sts_type %s has no theta to be chosen", option, prefix, type);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  TimeStepThrough - From t over dt by steps of a TS whose solution is set

  Collective. One step, unless an adaptor takes several.

  Input Parameters:
+ name - type of the TS, for messages
- ksp  - of its solves, which the guard watches; NULL: none

  Input/Output Parameters:
+ h          - the first step; the last but for what was left of dt [s]
- iterations - of the KSP: gains those made

  Output Parameter:
. failure - set where the TS diverges, or no method reaches a small true residual
*/
PetscErrorCode TimeStepThrough(TS ts, const char name[], KSP ksp, Guard *guard, PetscReal t,
                               PetscReal dt, PetscReal *h, PetscInt *iterations,
                               StepFailure *failure)
{
  const PetscReal   end    = t + dt;
  PetscReal         now    = t, next;
  PetscInt          before = 0, after = 0;
  TSConvergedReason reason = TS_CONVERGED_ITERATING;

  PetscFunctionBegin;
  PetscCall(TSSetTime(ts, t));
  PetscCall(TSSetTimeStep(ts, *h));
  PetscCall(TSGetKSPIterations(ts, &before));
  while (end - now > 1e-10 * dt && !failure->code) {
    PetscCall(TSSetConvergedReason(ts, TS_CONVERGED_ITERATING));
    PetscCall(TSStep(ts));
    PetscCall(TSGetConvergedReason(ts, &reason));
    if (ksp) PetscCall(GuardCheck(ksp, guard, failure));
    if (ksp && guard->inner) PetscCall(IterationCheck(ts, guard->where, failure));
    if (reason < 0) {
      FailureSet(failure, PETSC_ERR_NOT_CONVERGED,
                 "%s: the %s TS %s ended with %s; try a smaller time step", guard->where,
                 guard->what, name, TSConvergedReasons[reason]);
    }
    PetscCall(TSGetTime(ts, &now));
    PetscCall(TSGetTimeStep(ts, &next));
    if (end - now > 1e-10 * dt) *h = next;
    PetscCall(TSSetTimeStep(ts, PetscMin(next, PetscMax(end - now, 1e-10 * dt))));
  }
  PetscCall(TSGetKSPIterations(ts, &after));
  *iterations += after - before;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* BDF of order 1, 2, 3, ...: coefficient of the newest force, 1, 2/3, 6/11, ... */
static PetscReal Response_Bdf(TS ts)
{
  PetscInt  order = 2;
  PetscReal sum   = 0.0;

  if (TSBDFGetOrder(ts, &order)) return 1.0;
  for (PetscInt k = 1; k <= order; k++) sum += 1.0 / (PetscReal)k;
  return 1.0 / sum;
}

static const ViscousIntegratorRow kinds[] = {
    /* name, brief, citation, kind, history, multistep, force at end, response */
    {TSBEULER,
     "backward Euler, from (4u^n - u^{n-1})/3 over 2dt/3: BDF2 with the history on particles",
     "Hairer & Wanner, Solving ODEs II (1996)", TIME_IMPLICIT, PETSC_TRUE, PETSC_FALSE, PETSC_TRUE,
     NULL},
    {TSBDF, "backward differentiation by PETSc; particles fixed",
     "Hairer & Wanner, Solving ODEs II (1996)", TIME_IMPLICIT, PETSC_FALSE, PETSC_TRUE, PETSC_TRUE,
     Response_Bdf},
    {TSCN, "Crank-Nicolson; rings on impulsively moved walls", "Crank & Nicolson (1947)",
     TIME_IMPLICIT, PETSC_FALSE, PETSC_FALSE, PETSC_FALSE, NULL},
    {TSTHETA, "theta scheme (-visc_ts_theta_theta)", "Hairer & Wanner, Solving ODEs II (1996)",
     TIME_IMPLICIT, PETSC_FALSE, PETSC_FALSE, PETSC_FALSE, NULL},
    {TSALPHA, "generalised alpha",
     "Jansen, Whiting & Hulbert, Comput. Methods Appl. Mech. Eng. 190 (2000)", TIME_IMPLICIT,
     PETSC_FALSE, PETSC_FALSE, PETSC_FALSE, NULL},
    {TSARKIMEX, "additive Runge-Kutta, viscosity implicit, convection explicit",
     "Kennedy & Carpenter, Appl. Numer. Math. 44 (2003)", TIME_IMEX, PETSC_FALSE, PETSC_FALSE,
     PETSC_FALSE, NULL},
    {TSROSW, "Rosenbrock-W, viscosity implicit, convection explicit",
     "Rang & Angermann, BIT 45 (2005)", TIME_IMEX, PETSC_FALSE, PETSC_FALSE, PETSC_FALSE, NULL},
    {TSEULER, "forward Euler", "", TIME_EXPLICIT, PETSC_FALSE, PETSC_FALSE, PETSC_FALSE, NULL},
    {TSSSP, "strong stability preserving Runge-Kutta", "Ketcheson, SIAM J. Sci. Comput. 30 (2008)",
     TIME_EXPLICIT, PETSC_FALSE, PETSC_FALSE, PETSC_FALSE, NULL},
    {TSRK, "explicit Runge-Kutta", "Bogacki & Shampine, Appl. Math. Lett. 2 (1989)", TIME_EXPLICIT,
     PETSC_FALSE, PETSC_FALSE, PETSC_FALSE, NULL},
};
const Table ViscousIntegratorTable = TABLE("-visc_ts_type", "Time integrators of viscosity", kinds);
