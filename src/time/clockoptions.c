/* The creation of the clock from the options of the time step and of the end of the run. */
#include "isph/time.h"

#define CLOCK_GOOD_NEEDED 10 /* good_needed before the first failure, which doubles it */

static const DtAdaptRow adapts[] = {
    {.name    = "cfl",
     .brief   = "from -cfl with the present speed, and from the body force",
     .follows = PETSC_TRUE},
    {.name = "none", .brief = "-dt, or from -cfl with the reference speed"},
    {
        .name    = "retry",
        .brief   = "as cfl (or -dt); a failed step is undone and repeated with half the length",
        .follows = PETSC_TRUE,
        .retries = PETSC_TRUE,
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
  MAX_STEPS,
  TIME_ORDER,
  STEADY,
  STEADY_TOL,
  REPORT_TIMES
};
static const OptionRow options[] = {
    [T_END] =
        OPTION(REAL, "-t_end", "end of the run", "s", "of the case, a multiple of L/U",
               .also = " tmax t_max time end_time final_time ", NOT_NEGATIVE, .where = "flows"),
    [DT] = OPTION(REAL, "-dt", "time step; 0: from -cfl", "s", "0", NOT_NEGATIVE, .where = "flows"),
    [CFL] = OPTION(
        REAL, "-cfl",
        "time step in units of dx/U; U is the larger of the reference speed and the present speed",
        "-", REGIME, .low = 1e-6, .high = 1e6, .where = "flows"),
    [DT_ADAPT]  = OPTION(NAME, "-dt_adapt", "control of the length of steps", NULL, REGIME,
                         .table = &DtAdaptTable, .where = "flows"),
    [DT_MAX]    = OPTION(REAL, "-dt_max", "upper bound of the time step", "s", "no bound", POSITIVE,
                         .where = "flows without -dt"),
    [DT_RTOL]   = OPTION(REAL, "-dt_rtol",
                         "largest error of the velocity in a step (root mean square), in units of "
                           "the largest root mean square velocity so far, at least U/10",
                         "-", PetscStringize(CLOCK_RTOL), .low = 1e-8, .high = 0.1,
                         .where = "-dt_adapt error"),
    [MAX_STEPS] = OPTION(INT, "-max_steps", "number of steps after which the run stops", NULL,
                         "no limit", NOT_NEGATIVE, .where = "flows"),
    [TIME_ORDER] = OPTION(INT, "-time_order", "order of the time integration", NULL, "2", .low = 1,
                          .high = 3, .where = "-scheme projection or coupled"),
    [STEADY] = OPTION(SWITCH, "-steady", "solve for the steady flow, without du/dt", NULL, "false",
                      .where = "-scheme coupled"),
    [STEADY_TOL] =
        OPTION(REAL, "-steady_tol",
               "stop when u, div u* and p change by less than this per time scale; 0: never", "-",
               "0", .low = 0.0, .high = 1.0, .where = "flows"),
    [REPORT_TIMES] = OPTION(REALS, "-report_times",
                            "times besides the end at which quantities are reported, ascending",
                            "s", NULL, .where = "flows"),
};
const OptionTable TimeOptions = OPTIONS("Time", options);

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
  const char *const others[] = {"-dt",       "-cfl",        "-steady_tol",   "-report_times",
                                "-dt_adapt", "-time_order", "-output_every", "-dt_max"};

  PetscFunctionBegin;
  PetscCall(OptionGetSwitch(&options[STEADY], &clock->steady_solve, NULL));
  if (!clock->steady_solve) PetscFunctionReturn(PETSC_SUCCESS);
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(others); k++)
    PetscCall(OptionsRefuseTogether("-steady", others[k], "a steady flow has no steps in time"));
  UserCheck(clock->t_end > 0.0, "-t_end 0 with -steady: nothing would be solved");
  clock->dt_given = clock->t_end;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads -dt_adapt and the options that depend on it. */
static PetscErrorCode ClockReadAdapt(const Scene *scene, Clock *c)
{
  PetscFunctionBegin;
  RegimeSetFact(scene->regime, FACT_STEP_GIVEN, c->dt_given > 0.0);
  PetscCall(
      OptionGetRow(&options[DT_ADAPT], RegimeWord(scene->regime, REGIME_DT_ADAPT), &c->adapt));
  UserCheck(c->dt_given == 0.0 || !c->adapt->follows || (c->adapt->retries && !c->adapt->estimates),
            "-dt_adapt %s and -dt cannot both be given: give %s", c->adapt->name,
            c->adapt->estimates ? "-dt_max" : "-cfl");
  if (c->adapt->estimates) PetscCall(OptionGetReal(&options[DT_RTOL], &c->control.rtol, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ClockCreate - Creates the clock and reads the options of the time step and of the end of the run;
   collective on PETSC_COMM_WORLD */
PetscErrorCode ClockCreate(const Scene *scene, Clock **clock)
{
  Clock *c;

  PetscFunctionBegin;
  PetscCall(PetscNew(&c));
  c->t_end       = scene->problem->t_end * scene->length / scene->speed;
  c->max_steps   = PETSC_INT_MAX;
  c->good_needed = CLOCK_GOOD_NEEDED;
  c->dt_max      = PETSC_INFINITY;
  c->control.dt  = PETSC_INFINITY;
  PetscCall(OptionsRefuseTogether("-dt", "-cfl", "each gives the time step"));
  PetscCall(OptionsRefuseTogether("-dt", "-dt_max", "-dt gives the time step"));
  PetscCall(OptionGetReal(&options[T_END], &c->t_end, NULL));
  UserCheck(!scene->motion_end || c->t_end <= scene->motion_end,
            "-t_end %.6g: a file of -scene_body_<k>_motion ends at %.6g s; end the run there, or "
            "add rows",
            (double)c->t_end, (double)scene->motion_end);
  PetscCall(OptionGetReal(&options[DT], &c->dt_given, NULL));
  c->cfl = RegimeValue(scene->regime, REGIME_COURANT);
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

/* ClockDropEstimate - Replaces a default of -dt_adapt error by cfl, for integrators whose error has
   no estimate; collective. Input: option, integrator - name and value of the option of the
   integrator. */
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
