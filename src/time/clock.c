/* The clock, which keeps the time and chooses the step length. Solvers take t and dt from it. */
#include "isph/time.h"
#include <stdarg.h>

#define CLOCK_MAX_HALVINGS 10 /* largest number of halvings of a step */

/* ClockMoment - Returns the time of the current solution; for a steady solve, a time later than all
   report times [s] */
PetscReal ClockMoment(const Clock *clock)
{
  return clock->steady_solve ? PETSC_INFINITY : clock->t;
}

/* ClockDestroy - Frees the clock */
PetscErrorCode ClockDestroy(Clock **clock)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(*clock));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* StepLimitLower - Lowers a limit to dt if dt is shorter, and sets the reason */
void StepLimitLower(StepLimit *limit, PetscReal dt, const char reason[])
{
  if (!(dt < limit->dt)) return;
  limit->dt     = dt;
  limit->reason = reason;
}

/* FailureSet - Sets the reason for a failed step, unless a reason is set */
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
  const PetscReal wanted = c->until > c->t ? PetscMin(target, c->until) : target;

  if (c->land_every == 0.0) return wanted;
  return PetscMin(wanted, ClockNext(c->land_every, c->t));
}

/* ClockShortening - Returns the length of the present step over the usual one, below 1 at the start
   with -time_order 3 */
PetscReal ClockShortening(const Clock *clock)
{
  const PetscInt left = CLOCK_SHORT - clock->step;

  return clock->order > 2 && !clock->adapt->estimates && left > 0
             ? PetscPowReal(CLOCK_GROWTH, (PetscReal)-left)
             : 1.0;
}

/*
  ClockChoose - Sets dt of the next step

    dt_wanted = min((-dt, or else the scheme's limit)/2^halvings, control.dt, land_every/2^halvings)

  land_every is the interval of snapshots. dt is dt_wanted, reduced so that equal steps end exactly
  at the next report time, at the next snapshot, or at t_end. In a run of a single step dt_wanted is
  dt. With -time_order 3 the first CLOCK_SHORT steps are short and grow, because the error of the
  very first one is of order dt^2; -dt_adapt error has a start of its own. Input: limit - the
  longest step that the scheme allows.
*/
PetscErrorCode ClockChoose(const StepLimit *limit, Clock *clock)
{
  const PetscReal target = ClockTarget(clock), left = target - clock->t;
  PetscReal       dt = clock->dt_given > 0.0 ? clock->dt_given : limit->dt, share = 1.0;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < clock->halvings; k++) share *= 0.5;
  dt *= ClockShortening(clock);
  clock->limit = dt;
  dt *= share;
  dt = PetscMin(dt, clock->control.dt);
  if (clock->land_every > 0.0) dt = PetscMin(dt, share * clock->land_every);
  clock->dt_wanted = clock->step == 0 && target == clock->t_end ? PetscMin(dt, left) : dt;
  if (left > 0.0) dt = left / PetscCeilReal(left / dt * (1.0 - 1e-9));
  clock->dt = dt;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ClockRemember - Adds the clock's numbers to the memory of the run, which undo and checkpoints
   save */
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
  PetscCall(MemoryAddReal(memory, "jump", &c->jump));
  PetscCall(MemoryAddReal(memory, "control_dt", &c->control.dt));
  PetscCall(MemoryAddReal(memory, "control_last", &c->control.last));
  PetscCall(MemoryAddReal(memory, "control_speed", &c->control.speed));
  PetscCall(MemoryAddInt(memory, "rejected", &c->control.rejected));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ClockRestart - Prepares the clock after its numbers were read from a checkpoint. Finds the first
   report at or after the present time, because -report_times may differ from the earlier run. A
   checkpoint is written before the report of its time, so that this run makes it. The bound of an
   error control that this run has not ends. */
PetscErrorCode ClockRestart(Clock *c)
{
  PetscInt k = 0;

  PetscFunctionBegin;
  while (k < c->n_reports && c->report_time[k] < c->t * (1.0 - 1e-12)) k++;
  c->next_report = k;
  c->t_first     = c->t;
  c->step_first  = c->step;
  if (!c->adapt->estimates) c->control.dt = PETSC_INFINITY;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ClockAdvance - Advances the time after a good step. If failures have halved dt, it doubles again
   after good_needed good steps. */
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

/* ClockRetry - Shortens the following steps after a failed step. Collective. To be called when the
   step has been undone. A step whose error was too large is repeated with the length that the
   failure gives. After other failures the limit of dt is halved until it is shorter than the failed
   step, for which another bound may have been shorter. Output: failure - made fatal, with advice,
   if steps cannot be halved any more. Notes: each failure doubles good_needed, the number of good
   steps before dt doubles again, so that long steps are tried ever more rarely in a flow that needs
   short steps. */
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
  for (PetscReal dt = clock->dt; dt >= clock->dt && clock->halvings < CLOCK_MAX_HALVINGS;)
    dt = clock->limit * PetscPowReal(0.5, (PetscReal)++clock->halvings);
  if (clock->adapt->estimates) clock->control.dt = 0.5 * clock->dt;
  clock->retries++;
  clock->good        = 0;
  clock->good_needed = PetscMin(2 * clock->good_needed, 1000000);
  PetscCall(SayLine("%s; undone, trying dt/%" PetscInt_FMT " for %" PetscInt_FMT " steps",
                    failure->sentence, (PetscInt)1 << clock->halvings, clock->good_needed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ClockRatio - Returns w = dt/dt_previous for extrapolation in time. Returns 0, which means first
   order, in three cases: with -time_order 1, in the first step, and if w exceeds 1 + sqrt(2). For
   such w BDF2 is unstable, and the change in a very short step to a report time after an impulsive
   start would be extrapolated to a much longer step. */
PetscReal ClockRatio(const Clock *clock)
{
  const PetscReal w =
      clock->order >= 2 && clock->dt_previous > 0.0 ? clock->dt / clock->dt_previous : 0.0;

  return w <= 1.0 + PETSC_SQRT2 ? w : 0.0;
}

/* ClockOrder - Returns the order of the formulas in time of the present step. It is below
   -time_order until enough earlier velocities are known, and after a much shorter step: BDF3 is
   zero-stable up to a ratio of steps of 1.534. */
PetscInt ClockOrder(const Clock *clock)
{
  if (ClockRatio(clock) == 0.0) return 1;
  return clock->order > 2 && clock->dt_before > 0.0 && clock->dt < CLOCK_STABLE * clock->dt_previous
             ? 3
             : 2;
}

/* ClockPasses - Returns true if a multiple of `every` [s] lies in (last, now] */
PetscBool ClockPasses(PetscReal every, PetscReal last, PetscReal now)
{
  /* compares the numbers of multiples up to now and up to last; 1e-9 for rounding */
  return PetscFloorReal(now / every + 1e-9) > PetscFloorReal(last / every + 1e-9);
}

/* ClockNext - Returns the multiple of `every` [s] that follows the time t [s] */
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
