/*
  The clock: the only owner of time. Solvers are told t and dt, never asked.
*/
#include "isph/schemes.h"

/*
  ClockExplicitLimit - Largest stable step of an explicit viscous term, 0.125 h^2/nu [s]

  h is half the radius of the support, for every form and kernel.
*/
PetscReal ClockExplicitLimit(const Scene *scene, PetscReal support_radius)
{
  return SceneHas(scene, PHYSICS_VISCOSITY) ? 0.125 * PetscSqr(0.5 * support_radius) / scene->nu
                                            : PETSC_INFINITY;
}

/* The times at which quantities are reported besides the end. */
static PetscErrorCode ClockReadReports(PetscOptionItems *PetscOptionsObject, Clock *clock)
{
  PetscInt n = CLOCK_MAX_REPORTS;

  PetscFunctionBegin;
  PetscCall(PetscOptionsRealArray("-report_times",
                                  "Times besides the end at which quantities are reported [s]", "",
                                  clock->report_time, &n, NULL));
  for (PetscInt k = 0; k < n; k++) {
    UserCheck(clock->report_time[k] > (k ? clock->report_time[k - 1] : 0.0),
              "-report_times: the times must be positive and ascending, got %.6g",
              (double)clock->report_time[k]);
  }
  UserCheck(n == 0 || clock->report_time[n - 1] <= clock->t_end,
            "-report_times %.6g: the run ends at -t_end %.6g",
            (double)clock->report_time[n ? n - 1 : 0], (double)clock->t_end);
  while (n > 0 && clock->report_time[n - 1] >= clock->t_end) n--; /* the end reports anyway */
  clock->n_reports = n;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  CFL number that held in every run tried: where viscosity smooths the grid scale, U dx/nu <= 5,
  twice as large as where it does not.
*/
static PetscReal ClockDefaultCfl(const Scene *scene)
{
  const PetscBool smooth =
      SceneHas(scene, PHYSICS_VISCOSITY) && scene->speed * scene->dx <= 5.0 * scene->nu;

  return smooth ? 0.5 : 0.25;
}

/*
  ClockCreate - Reads how long and in which steps to run

  Collective on PETSC_COMM_WORLD.

  Options Database Keys:
+ -t_end T            - end of the run [s]
. -dt DT              - time step [s]; or
. -cfl C              - dt = C dx/max(U, largest speed); default 0.5 where U dx/nu <= 5, else 0.25
. -max_steps N        - stop after N steps
. -steady_tol TOL     - stop when u, div u* and p change by less than this per time scale
- -report_times t,... - report quantities at these times too
*/
PetscErrorCode ClockCreate(const Scene *scene, Clock **clock)
{
  Clock *c;

  PetscFunctionBegin;
  PetscCall(PetscNew(&c));
  c->t_end     = scene->problem->t_end;
  c->cfl       = ClockDefaultCfl(scene);
  c->max_steps = PETSC_MAX_INT;
  PetscOptionsBegin(PETSC_COMM_WORLD, NULL, "Time", "");
  PetscCall(OptionsRefuseTogether("-dt", "-cfl", "one time step follows from each"));
  PetscCall(OptionReal("-t_end", "End of the run [s]", 0.0, 1e12, &c->t_end, NULL));
  PetscCall(OptionReal("-dt", "Time step [s]; 0: from -cfl", 0.0, 1e12, &c->dt_given, NULL));
  PetscCall(OptionReal("-cfl",
                       "Time step over dx/U, U the larger of reference and present speed [-]", 1e-6,
                       1e6, &c->cfl, NULL));
  PetscCall(
      OptionInt("-max_steps", "Stop after this many steps", 0, PETSC_MAX_INT, &c->max_steps, NULL));
  PetscCall(OptionReal("-steady_tol",
                       "Stop when nothing changes by more than this relative rate; 0: never [-]",
                       0.0, 1.0, &c->steady_tol, NULL));
  PetscCall(ClockReadReports(PetscOptionsObject, c));
  PetscOptionsEnd();
  PetscCall(ClockChoose(scene, scene->speed, c));
  *clock = c;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ClockDestroy(Clock **clock)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(*clock));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  ClockChoose - Sets dt of the coming step

  Not collective. Steps are evened out so that the next report time and t_end are hit exactly
without a rest that is shorter than the others.

  Input Parameter:
. speed - largest speed of the flow [m/s]
*/
PetscErrorCode ClockChoose(const Scene *scene, PetscReal speed, Clock *clock)
{
  const PetscReal target =
      clock->next_report < clock->n_reports ? clock->report_time[clock->next_report] : clock->t_end;
  const PetscReal left = target - clock->t;
  PetscReal       dt   = clock->dt_given;

  PetscFunctionBegin;
  if (dt == 0.0) dt = clock->cfl * scene->dx / PetscMax(scene->speed, speed);
  if (left > 0.0) dt = left / PetscCeilReal(left / dt * (1.0 - 1e-9));
  clock->dt = dt;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ClockWhere - "step 12 (t = 0.34)" of the step at hand, in CLOCK_WHERE letters; not collective */
PetscErrorCode ClockWhere(const Clock *clock, char where[])
{
  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(where, CLOCK_WHERE, "step %" PetscInt_FMT " (t = %.6g)", clock->step + 1,
                          (double)(clock->t + clock->dt)));
  PetscFunctionReturn(PETSC_SUCCESS);
}
