/*
  The clock, which keeps the time and chooses the step length. Solvers take t and dt from it.
*/
#include "isph/clock.h"
#include <stdarg.h>

#define CLOCK_MAX_HALVINGS 10 /* largest number of halvings of a step */
#define CLOCK_GOOD_NEEDED  10 /* good_needed before the first failure, which doubles it */

static const DtAdaptRow adapts[] = {
    {
        .name     = "cfl",
        .brief    = "from -cfl with the present speed, and from the body force",
        .citation = "",
        .follows  = PETSC_TRUE,
    },
    {
        .name     = "none",
        .brief    = "-dt, or from -cfl with the reference speed",
        .citation = "",
    },
    {
        .name     = "retry",
        .brief    = "as cfl (or -dt); a failed step is undone and repeated with half the length",
        .citation = "",
        .follows  = PETSC_TRUE,
        .retries  = PETSC_TRUE,
    },
    {
        .name      = "error",
        .brief     = "as retry; dt also follows an estimate of the error in time, -dt_rtol, and "
                     "the period of what drives the flow",
        .citation  = "Gustafsson, ACM Trans. Math. Softw. 17 (1991)",
        .follows   = PETSC_TRUE,
        .retries   = PETSC_TRUE,
        .estimates = PETSC_TRUE,
    },
};
const Table DtAdaptTable = TABLE("Time step control", adapts);

enum {
  T_END,
  DT,
  CFL,
  DT_ADAPT,
  DT_MAX,
  DT_RTOL,
  DT_MOVE_MAX,
  MAX_STEPS,
  TIME_ORDER,
  STEADY,
  STEADY_TOL,
  REPORT_TIMES
};
static const OptionRow options[] = {
    [T_END] =
        {
            .name     = "-t_end",
            .kind     = VALUE_REAL,
            .brief    = "end of the run",
            .unit     = "s",
            .standard = "of the case, a multiple of L/U",
            NOT_NEGATIVE,
            .where = "flows",
        },
    [DT] =
        {
            .name     = "-dt",
            .kind     = VALUE_REAL,
            .brief    = "time step; 0: from -cfl",
            .unit     = "s",
            .standard = "0",
            NOT_NEGATIVE,
            .where = "flows",
        },
    [CFL] =
        {
            .name  = "-cfl",
            .kind  = VALUE_REAL,
            .brief = "time step in units of dx/U; U is the larger of the reference speed and the "
                     "present speed",
            .unit  = "-",
            .standard = PetscStringize(CLOCK_CFL),
            .low      = 1e-6,
            .high     = 1e6,
            .where    = "flows",
        },
    [DT_ADAPT] =
        {
            .name     = "-dt_adapt",
            .kind     = VALUE_NAME,
            .brief    = "control of the length of steps",
            .standard = "cfl, or none if -dt is given; error for walls or forces that depend on t",
            .table    = &DtAdaptTable,
            .where    = "flows",
        },
    [DT_MAX] =
        {
            .name     = "-dt_max",
            .kind     = VALUE_REAL,
            .brief    = "upper bound of the time step",
            .unit     = "s",
            .standard = "no bound",
            POSITIVE,
            .where = "flows without -dt",
        },
    [DT_RTOL] =
        {
            .name  = "-dt_rtol",
            .kind  = VALUE_REAL,
            .brief = "largest error of the velocity in a step (root mean square), in units of the "
                     "largest root mean square velocity so far, at least U/10",
            .unit  = "-",
            .standard = PetscStringize(CLOCK_RTOL),
            .low      = 1e-8,
            .high     = 0.1,
            .where    = "-dt_adapt error",
        },
    [DT_MOVE_MAX] =
        {
            .name     = "-dt_move_max",
            .kind     = VALUE_REAL,
            .brief    = "displacement of a particle with the flow above which a step is undone",
            .unit     = "dx",
            .standard = "0.6",
            .low      = 0.01,
            .high     = 10.0,
            .where    = "-dt_adapt retry or error",
        },
    [MAX_STEPS] =
        {
            .name     = "-max_steps",
            .kind     = VALUE_INT,
            .brief    = "number of steps after which the run stops",
            .standard = "no limit",
            NOT_NEGATIVE,
            .where = "flows",
        },
    [TIME_ORDER] =
        {
            .name     = "-time_order",
            .kind     = VALUE_INT,
            .brief    = "order of the time integration",
            .standard = "2",
            .low      = 1,
            .high     = 2,
            .where    = "flows",
        },
    [STEADY] =
        {
            .name     = "-steady",
            .kind     = VALUE_SWITCH,
            .brief    = "solve for the steady flow, without du/dt",
            .standard = "false",
            .where    = "-scheme coupled",
        },
    [STEADY_TOL] =
        {
            .name  = "-steady_tol",
            .kind  = VALUE_REAL,
            .brief = "stop when u, div u* and p change by less than this per time scale; 0: never",
            .unit  = "-",
            .standard = "0",
            .low      = 0.0,
            .high     = 1.0,
            .where    = "flows",
        },
    [REPORT_TIMES] =
        {
            .name  = "-report_times",
            .kind  = VALUE_REALS,
            .brief = "times besides the end at which quantities are reported, ascending",
            .unit  = "s",
            .where = "flows",
        },
};
const OptionTable TimeOptions = OPTIONS("Time", options);

/* ClockMoment - Returns the time of the current solution; for a steady solve, a time later than all
   report times [s] */
PetscReal ClockMoment(const Clock *clock)
{
  return clock->steady_solve ? PETSC_INFINITY : clock->t;
}

/* Reads the report times; the run also reports at its end. */
static PetscErrorCode ClockReadReports(Clock *clock)
{
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(
      OptionGetReals(&options[REPORT_TIMES], CLOCK_MAX_REPORTS, clock->report_time, &n, NULL));
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

/* Reads -steady: a single step to t_end without du/dt. */
static PetscErrorCode ClockReadSteady(Clock *clock)
{
  const char *const others[] = {"-dt",       "-cfl",        "-steady_tol",      "-report_times",
                                "-dt_adapt", "-time_order", "-coupled_ts_type", "-output_every",
                                "-dt_max"};

  PetscFunctionBegin;
  PetscCall(OptionGetSwitch(&options[STEADY], &clock->steady_solve, NULL));
  if (!clock->steady_solve) PetscFunctionReturn(PETSC_SUCCESS);
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(others); k++)
    PetscCall(OptionsRefuseTogether("-steady", others[k], "a steady flow has no steps in time"));
  UserCheck(clock->t_end > 0.0, "-t_end 0 with -steady: nothing would be solved");
  clock->dt_given = clock->t_end;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads -dt_adapt and the options that depend on it. By default steps of a flow that is driven by
   functions of time follow the error in time. */
static PetscErrorCode ClockReadAdapt(const Scene *scene, Clock *c)
{
  const char *const standard = c->dt_given > 0.0            ? "none"
                               : SceneIsDrivenInTime(scene) ? "error"
                                                            : "cfl";

  PetscFunctionBegin;
  PetscCall(OptionGetRow(&options[DT_ADAPT], standard, &c->adapt));
  UserCheck(c->dt_given == 0.0 || !c->adapt->follows || (c->adapt->retries && !c->adapt->estimates),
            "-dt_adapt %s and -dt cannot both be given: give %s", c->adapt->name,
            c->adapt->estimates ? "-dt_max" : "-cfl");
  if (c->adapt->retries) PetscCall(OptionGetReal(&options[DT_MOVE_MAX], &c->move_max, NULL));
  if (c->adapt->estimates) PetscCall(OptionGetReal(&options[DT_RTOL], &c->control.rtol, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  ClockCreate - Creates the clock and reads the options of the time step and of the end of the run

  Collective on PETSC_COMM_WORLD.

  Options Database Keys:
+ -t_end T            - end of the run [s]
. -dt DT              - time step, in place of -cfl [s]
. -cfl C              - dt = C dx/max(U, largest speed); default 0.5
. -dt_adapt name      - control of the step length
. -dt_max DT          - upper bound of dt [s]
. -dt_rtol TOL        - largest error of a step with -dt_adapt error
. -dt_move_max M      - largest displacement of a particle in a step that is not retried [dx]
. -max_steps N        - stop after N steps
. -time_order 1|2     - order of the time integration
. -steady             - no du/dt: a single step to t_end with -scheme coupled
. -steady_tol TOL     - stop when u, div u* and p change by less than this per time scale
- -report_times t,... - report quantities at these times too
*/
PetscErrorCode ClockCreate(const Scene *scene, Clock **clock)
{
  Clock *c;

  PetscFunctionBegin;
  PetscCall(PetscNew(&c));
  c->t_end       = scene->problem->t_end * scene->length / scene->speed;
  c->max_steps   = PETSC_INT_MAX;
  c->move_max    = 0.6;
  c->good_needed = CLOCK_GOOD_NEEDED;
  c->dt_max      = PETSC_INFINITY;
  c->control.dt  = PETSC_INFINITY;
  PetscCall(OptionsRefuseTogether("-dt", "-cfl", "each gives the time step"));
  PetscCall(OptionsRefuseTogether("-dt", "-dt_max", "-dt gives the time step"));
  PetscCall(OptionGetReal(&options[T_END], &c->t_end, NULL));
  PetscCall(OptionGetReal(&options[DT], &c->dt_given, NULL));
  PetscCall(OptionGetReal(&options[CFL], &c->cfl, NULL));
  PetscCall(OptionGetReal(&options[DT_MAX], &c->dt_max, NULL));
  PetscCall(ClockReadAdapt(scene, c));
  PetscCall(OptionGetInt(&options[MAX_STEPS], &c->max_steps, NULL));
  PetscCall(OptionGetInt(&options[TIME_ORDER], &c->order, NULL));
  PetscCall(OptionGetReal(&options[STEADY_TOL], &c->steady_tol, NULL));
  PetscCall(ClockReadReports(c));
  PetscCall(ClockReadSteady(c));
  *clock = c;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ClockDestroy - Frees the clock; not collective */
PetscErrorCode ClockDestroy(Clock **clock)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(*clock));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* StepLimitLower - Lowers a limit to dt if dt is shorter, and sets the reason; not collective */
void StepLimitLower(StepLimit *limit, PetscReal dt, const char reason[])
{
  if (!(dt < limit->dt)) return;
  limit->dt     = dt;
  limit->reason = reason;
}

/* FailureSet - Sets the reason for a failed step, unless a reason is set; not collective */
void FailureSet(StepFailure *failure, PetscErrorCode code, const char format[], ...)
{
  va_list arguments;

  if (failure->code) return;
  failure->code    = code;
  failure->fatal   = PETSC_FALSE;
  failure->dt_next = 0.0;
  va_start(arguments, format);
  (void)vsnprintf(failure->sentence, sizeof(failure->sentence), format, arguments);
  va_end(arguments);
}

/* Returns the next time at which a step must end: a report time, a snapshot time, or t_end [s]. */
static PetscReal ClockTarget(const Clock *c)
{
  const PetscReal target =
      c->next_report < c->n_reports ? c->report_time[c->next_report] : c->t_end;

  if (c->land_every == 0.0) return target;
  return PetscMin(target, c->land_every * (PetscFloorReal(c->t / c->land_every + 1e-9) + 1.0));
}

/*
  ClockChoose - Sets dt of the next step

    dt_wanted = min((-dt, or else the scheme's limit)/2^halvings, control.dt, land_every)

  Not collective. land_every is the interval of snapshots. dt is dt_wanted, reduced so that equal
  steps end exactly at the next report time, at the next snapshot, or at t_end. In a run of a single
  step dt_wanted is dt.

  Input Parameter:
. limit - the longest step that the scheme allows
*/
PetscErrorCode ClockChoose(const StepLimit *limit, Clock *clock)
{
  const PetscReal target = ClockTarget(clock), left = target - clock->t;
  PetscReal       dt = clock->dt_given > 0.0 ? clock->dt_given : limit->dt;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < clock->halvings; k++) dt *= 0.5;
  dt = PetscMin(dt, clock->control.dt);
  if (clock->land_every > 0.0) dt = PetscMin(dt, clock->land_every);
  clock->dt_wanted = clock->step == 0 && target == clock->t_end ? PetscMin(dt, left) : dt;
  if (left > 0.0) dt = left / PetscCeilReal(left / dt * (1.0 - 1e-9));
  clock->dt = dt;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ClockRemember - Adds the clock's numbers to the memory of the run, which undo and checkpoints
   save; not collective */
PetscErrorCode ClockRemember(Clock *c, Memory *memory)
{
  PetscFunctionBegin;
  PetscCall(MemoryAddReal(memory, "t", &c->t));
  PetscCall(MemoryAddReal(memory, "dt", &c->dt));
  PetscCall(MemoryAddReal(memory, "dt_previous", &c->dt_previous));
  PetscCall(MemoryAddInt(memory, "step", &c->step));
  PetscCall(MemoryAddInt(memory, "next_report", &c->next_report));
  PetscCall(MemoryAddInt(memory, "retries", &c->retries));
  PetscCall(MemoryAddInt(memory, "halvings", &c->halvings));
  PetscCall(MemoryAddInt(memory, "good_needed", &c->good_needed));
  PetscCall(MemoryAddInt(memory, "good", &c->good));
  PetscCall(MemoryAddReal(memory, "dt_before", &c->dt_before));
  PetscCall(MemoryAddReal(memory, "control_dt", &c->control.dt));
  PetscCall(MemoryAddReal(memory, "control_last", &c->control.last));
  PetscCall(MemoryAddReal(memory, "control_speed", &c->control.speed));
  PetscCall(MemoryAddInt(memory, "rejected", &c->control.rejected));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  ClockRestart - Prepares the clock after its numbers were read from a checkpoint

  Not collective. Finds the first report at or after the present time, because -report_times may
  differ from the earlier run. A report at the present time is skipped if the earlier run has made
  it.
*/
PetscErrorCode ClockRestart(Clock *c)
{
  const PetscInt counted = c->next_report;
  PetscInt       k       = 0;

  PetscFunctionBegin;
  while (k < c->n_reports && c->report_time[k] < c->t * (1.0 - 1e-12)) k++;
  if (k < c->n_reports && c->report_time[k] <= c->t * (1.0 + 1e-12) && counted > k) k++;
  c->next_report = k;
  c->t_first     = c->t;
  c->step_first  = c->step;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  ClockAdvance - Advances the time after a good step

  Not collective. If failures have halved dt, it doubles again after good_needed good steps.
*/
PetscErrorCode ClockAdvance(Clock *clock)
{
  PetscFunctionBegin;
  clock->t += clock->dt;
  clock->dt_before   = clock->dt_previous;
  clock->dt_previous = clock->dt;
  clock->step++;
  if (clock->steady_solve) clock->steady = PETSC_TRUE;
  if (!clock->halvings) PetscFunctionReturn(PETSC_SUCCESS);
  clock->good++;
  if (clock->good >= clock->good_needed) {
    clock->halvings--;
    clock->good = 0;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  ClockRetry - Shortens the following steps after a failed step

  Collective. To be called when the step has been undone. A step whose error was too large is
  repeated with the length that the failure gives; after other failures steps are halved.

  Output Parameter:
. failure - made fatal, with advice, if steps cannot be halved any more

  Notes: each failure doubles good_needed, the number of good steps before dt doubles again, so that
  long steps are tried ever more rarely in a flow that needs short steps
*/
PetscErrorCode ClockRetry(Clock *clock, StepFailure *failure)
{
  size_t length;

  PetscFunctionBegin;
  if (failure->dt_next > 0.0) {
    clock->control.dt = failure->dt_next;
    clock->control.rejected++;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (clock->halvings >= CLOCK_MAX_HALVINGS) {
    PetscCall(PetscStrlen(failure->sentence, &length));
    (void)snprintf(failure->sentence + length, sizeof(failure->sentence) - length,
                   "; the step was halved %d times", CLOCK_MAX_HALVINGS);
    failure->fatal = PETSC_TRUE;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  clock->halvings++;
  clock->retries++;
  clock->good        = 0;
  clock->good_needed = PetscMin(2 * clock->good_needed, 1000000);
  PetscCall(SayLine("%s; undone, trying dt/%" PetscInt_FMT " for %" PetscInt_FMT " steps",
                    failure->sentence, (PetscInt)1 << clock->halvings, clock->good_needed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  ClockDropEstimate - Replaces a default of -dt_adapt error by cfl, for integrators whose error has
  no estimate

  Collective. Input: option, integrator - name and value of the option of the integrator.

  Errors: refuses -dt_adapt error if the user gave it
*/
PetscErrorCode ClockDropEstimate(Clock *clock, const char option[], const char integrator[])
{
  PetscBool given;

  PetscFunctionBegin;
  if (!clock->adapt->estimates) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(OptionGiven(options[DT_ADAPT].name, &given));
  UserCheck(!given,
            "-dt_adapt error: it estimates the error of BDF2, and %s %s is another integrator; use "
            "beuler, or -dt_adapt cfl",
            option, integrator);
  PetscCall(OptionGiven(options[DT_RTOL].name, &given));
  UserCheck(!given, "-dt_rtol: %s %s has no estimate of the error in time; use beuler", option,
            integrator);
  clock->adapt = &adapts[0];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  ClockRatio - Returns w = dt/dt_previous for extrapolation in time; not collective

  Returns 0, which means first order, in three cases: with -time_order 1, in the first step, and if
  w exceeds 1 + sqrt(2). For such w BDF2 is unstable, and the change in a very short step to a
  report time after an impulsive start would be extrapolated to a much longer step.
*/
PetscReal ClockRatio(const Clock *clock)
{
  const PetscReal w =
      clock->order == 2 && clock->dt_previous > 0.0 ? clock->dt / clock->dt_previous : 0.0;

  return w <= 1.0 + PETSC_SQRT2 ? w : 0.0;
}

/* ClockPasses - Returns true if a multiple of `every` [s] lies in (last, now] */
PetscBool ClockPasses(PetscReal every, PetscReal last, PetscReal now)
{
  /* compares the numbers of multiples up to now and up to last; 1e-9 for rounding */
  return PetscFloorReal(now / every + 1e-9) > PetscFloorReal(last / every + 1e-9) ? PETSC_TRUE
                                                                                  : PETSC_FALSE;
}

/* ClockNext - Returns the multiple of `every` [s] that follows the time t [s]; not collective */
PetscReal ClockNext(PetscReal every, PetscReal t)
{
  return every * (PetscFloorReal(t / every + 1e-9) + 1.0);
}

/* ClockWhere - Writes "step 12 (t = 0.34)" for the present step, at most CLOCK_WHERE letters */
PetscErrorCode ClockWhere(const Clock *clock, char where[])
{
  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(where, CLOCK_WHERE, "step %" PetscInt_FMT " (t = %.6g)", clock->step + 1,
                          (double)(clock->t + clock->dt)));
  PetscFunctionReturn(PETSC_SUCCESS);
}
