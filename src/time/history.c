/* Formulas in time for steps of unequal lengths, from the velocities u^n, u^{n-1}, u^{n-2} of a
   particle: the start of an implicit step, the path of a particle, and extrapolation. Their order
   is ClockOrder(). */
#include "isph/time.h"

/* Computes the weights of u^n, u^{n-1}, u^{n-2} in u^n + s u' + c u'', with the first and second
   divided differences u' and u'' of the first n of these velocities. */
static void PastWeights(const Clock *clock, PetscInt n, PetscReal s, PetscReal c,
                        PetscReal weight[HISTORY])
{
  const PetscReal a = clock->dt_previous, b = clock->dt_before;
  const PetscReal first = n > 1 ? s / a : 0.0, second = n > 2 ? c / (a + b) : 0.0;

  weight[0] = 1.0 + first;
  weight[1] = -first;
  weight[2] = 0.0;
  if (n < 3) return;
  weight[0] += second / a;
  weight[1] -= second / a + second / b;
  weight[2] = second / b;
}

/* Blends weights of earlier velocities and the length of a step over dt with those of order 1;
   returns the length. */
static PetscReal Blend(PetscReal jump, PetscReal length, PetscReal weight[HISTORY])
{
  for (PetscInt k = 0; k < HISTORY; k++) weight[k] *= 1.0 - jump;
  weight[0] += jump;
  return jump + (1.0 - jump) * length;
}

/* HistoryAhead - Computes the weights of earlier values in their extrapolation to t^n + at dt.
   Output: weight - of u^n, u^{n-1} and u^{n-2} [-]. See theory.md, (time:extrapolation). */
void HistoryAhead(const Clock *clock, PetscReal at, PetscReal weight[HISTORY])
{
  const PetscReal s = at * clock->dt;

  PastWeights(clock, ClockOrder(clock), s, s * (s + clock->dt_previous), weight);
}

/* HistoryPredict - Computes the weights of the last n velocities in their extrapolation to t^{n+1}.
   Input: n - 2 or 3, all known. Output: weight - of u^n, u^{n-1} and u^{n-2} [-]. */
void HistoryPredict(const Clock *clock, PetscInt n, PetscReal weight[HISTORY])
{
  PastWeights(clock, n, clock->dt, clock->dt * (clock->dt + clock->dt_previous), weight);
}

/* HistoryPath - Computes the weights of earlier velocities in the displacement of a step over dt.
   The formula of Adams and Bashforth: the mean of HistoryAhead() over the step, blended with u^n
   after a jump (velocityjump.c). Output: weight - of u^n, u^{n-1} and u^{n-2} [-]. See theory.md,
   (motion:step) and (time:extrapolation). */
void HistoryPath(const Clock *clock, PetscReal weight[HISTORY])
{
  const PetscReal dt = clock->dt;

  PastWeights(clock, ClockOrder(clock), 0.5 * dt, dt * (dt / 3.0 + 0.5 * clock->dt_previous),
              weight);
  (void)Blend(clock->jump, 1.0, weight);
}

/* Computes the weights of earlier velocities in the start of a step of backward Euler that is a
   step of BDF; returns its length over dt. */
static PetscReal StartWeights(const Clock *clock, PetscReal weight[HISTORY])
{
  const PetscReal w = ClockRatio(clock), a = clock->dt, b = a + clock->dt_previous,
                  c = b + clock->dt_before, k = 1.0 / (1.0 / a + 1.0 / b + 1.0 / c);

  weight[0] = PetscSqr(1.0 + w) / (1.0 + 2.0 * w);
  weight[1] = -w * w / (1.0 + 2.0 * w);
  weight[2] = 0.0;
  if (ClockOrder(clock) < 3) return (1.0 + w) / (1.0 + 2.0 * w);
  HistoryPredict(clock, 3, weight);
  weight[0] *= k / a;
  weight[1] *= k / b;
  weight[2] *= k / c;
  return k / a;
}

/*
  HistoryStartWeights - Computes the weights of u^n, u^{n-1}, u^{n-2} in the start of an implicit
  step of BDF, and returns its length k over dt

    BDF2, w = ClockRatio():  start = ((1+w)^2 u^n - w^2 u^{n-1})/(1+2w),  k = dt (1+w)/(1+2w)
    BDF3, equal steps:       start = (18 u^n - 9 u^{n-1} + 2 u^{n-2})/11,  k = 6 dt/11

  A backward Euler step of length k from this start is a step of BDF: theory.md, (time:start) and
  (time:bdf3). In a jump both are blended with order 1: (surface:blend).
*/
PetscReal HistoryStartWeights(const Clock *clock, PetscReal weight[HISTORY])
{
  return Blend(clock->jump, StartWeights(clock, weight), weight);
}
