/* Steps of a PETSc TS within the steps of the clock. */
#include "isph/solvers.h"

/* TimeOptionsRefuse - Refuses options by which a TS would control time, -ts_theta_theta for types
   other than theta, and -snes_type qn. Collective. The names of all releases of PETSc are refused:
   a name of another release would otherwise be reported as misspelt. PETSc's beuler and cn are
   theta methods that would refuse -ts_theta_theta in the first step only. PETSc's quasi-Newton
   method (3.18) ends there with a segmentation fault in MatSetType(). */
PetscErrorCode TimeOptionsRefuse(const char prefix[], const char type[])
{
  const char *const refused[][2] = {
      {"-ts_dt", "-dt"},
      {"-ts_time_step", "-dt"},
      {"-ts_max_time", "-t_end"},
      {"-ts_final_time", "-t_end"},
      {"-ts_time_span", "-report_times"},
      {"-ts_eval_times", "-report_times"},
      {"-ts_max_steps", "-max_steps"},
      {"-ts_run_steps", "-max_steps"},
      {"-ts_init_time", "-restart"},
  };
  PetscBool given, theta, quasi = PETSC_FALSE;
  char      snes[64];

  PetscFunctionBegin;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(refused); k++) {
    PetscCall(PetscOptionsHasName(NULL, prefix, refused[k][0], &given));
    UserCheck(!given, "-%s%s: isph controls the time; use %s", prefix, refused[k][0] + 1,
              refused[k][1]);
  }
  PetscCall(PetscOptionsGetString(NULL, prefix, "-snes_type", snes, sizeof(snes), &given));
  if (given) PetscCall(PetscStrcmp(snes, SNESQN, &quasi));
  UserCheck(!quasi, "-%ssnes_type %s: it does not work within a TS; use newtonls or anderson",
            prefix, SNESQN);
  PetscCall(PetscStrcmp(type, TSTHETA, &theta));
  PetscCall(PetscOptionsHasName(NULL, prefix, "-ts_theta_theta", &given));
  UserCheck(theta || !given, "-%sts_theta_theta: -%sts_type %s has no theta to be chosen", prefix,
            prefix, type);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* TimeToleranceRefuse - Refuses a tolerance of substeps for a TS that takes none. Collective. To be
   called after TSSetFromOptions(). */
PetscErrorCode TimeToleranceRefuse(TS ts, const char prefix[])
{
  TSAdapt   adapt;
  TSType    type;
  PetscBool fixed, given;

  PetscFunctionBegin;
  PetscCall(TSGetType(ts, &type));
  PetscCall(TSGetAdapt(ts, &adapt));
  PetscCall(PetscObjectTypeCompare((PetscObject)adapt, TSADAPTNONE, &fixed));
  PetscCall(PetscOptionsHasName(NULL, prefix, "-ts_rtol", &given));
  UserCheck(!fixed || !given,
            "-%sts_rtol: -%sts_type %s takes a single step of dt here, without a tolerance", prefix,
            prefix, type);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Runs the monitors of a TS after a step, as TSSolve() would. */
static PetscErrorCode TimeMonitor(TS ts)
{
  PetscReal t;
  PetscInt  step;
  Vec       u;

  PetscFunctionBegin;
  PetscCall(TSGetStepNumber(ts, &step));
  PetscCall(TSGetTime(ts, &t));
  PetscCall(TSGetSolution(ts, &u));
  PetscCall(TSMonitor(ts, step, t, u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* TimeCreate - Creates a TS whose time the run controls, without options; collective. Input: prefix
   - of its options; name - of what it advances; type - of the TS; linear - the rates are */
PetscErrorCode TimeCreate(const char prefix[], const char name[], const char type[],
                          PetscBool linear, TS *ts)
{
  TSAdapt adapt;

  PetscFunctionBegin;
  PetscCall(TSCreate(PETSC_COMM_WORLD, ts));
  PetscCall(TSSetOptionsPrefix(*ts, prefix));
  PetscCall(PetscObjectSetName((PetscObject)*ts, name));
  PetscCall(TSSetProblemType(*ts, linear ? TS_LINEAR : TS_NONLINEAR));
  PetscCall(TSSetType(*ts, type));
  PetscCall(TSSetExactFinalTime(*ts, TS_EXACTFINALTIME_STEPOVER));
  PetscCall(TSSetMaxSteps(*ts, PETSC_INT_MAX - 1));
  PetscCall(TSSetMaxTime(*ts, PETSC_MAX_REAL));
  PetscCall(TSSetErrorIfStepFails(*ts, PETSC_FALSE));
  PetscCall(TSGetAdapt(*ts, &adapt));
  PetscCall(TSAdaptSetType(adapt, TSADAPTNONE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* TimeStepThrough - Advances a TS from t over dt; TSSetSolution() has set its solution. Collective.
   The TS takes a single step, or several steps if a TSAdapt controls their lengths. Input: name -
   type of the TS, for messages; guard - guard of the linear solves of the TS; inactive without a
   KSP. Input/Output: h - length of the first step; out: last length before it is shortened to end
   at t + dt [s]. Output: guard - solve.iterations increases by the linear iterations of this call;
   failure - set if the TS diverges, or if no method reaches a small true residual. */
PetscErrorCode TimeStepThrough(TS ts, const char name[], Guard *guard, PetscReal t, PetscReal dt,
                               PetscReal *h, StepFailure *failure)
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
    PetscCall(TimeMonitor(ts));
    if (guard->solve.ksp) PetscCall(GuardCheck(guard, failure));
    if (guard->Check) PetscCall(guard->Check(ts, guard->where, failure));
    if (reason < 0) {
      FailureSet(failure, PETSC_ERR_NOT_CONVERGED,
                 "%s: the %s TS %s ended with %s; try a smaller time step", guard->where,
                 guard->solve.name, name, TSConvergedReasons[reason]);
    }
    PetscCall(TSGetTime(ts, &now));
    PetscCall(TSGetTimeStep(ts, &next));
    if (end - now > 1e-10 * dt) *h = next;
    PetscCall(TSSetTimeStep(ts, PetscMin(next, PetscMax(end - now, 1e-10 * dt))));
  }
  PetscCall(TSGetKSPIterations(ts, &after));
  guard->solve.iterations += after - before;
  PetscFunctionReturn(PETSC_SUCCESS);
}
