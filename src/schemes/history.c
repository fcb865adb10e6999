/* The start of an implicit step from earlier velocities. */
#include "step.h"

/*
  HistoryStart - Sets u_next to the start of an implicit step

    BDF2, w = ClockRatio():  start = ((1+w)^2 u^n - w^2 u^{n-1})/(1+2w),  k = dt (1+w)/(1+2w)

  Collective. A backward Euler step of length k from this start is of order 2: docs/theory.md, (99).

  Input Parameter:
. history - flag: BDF2 if u^{n-1} is known; otherwise backward Euler, with start = u^n and k = dt

  Output Parameter:
. dt - length k of the step from this start [s]
*/
PetscErrorCode HistoryStart(Flow *flow, PetscBool history, PetscReal *dt)
{
  FlowState      *s = flow->state;
  const PetscReal w = history ? ClockRatio(flow->clock) : 0.0;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < flow->scene->dim; a++) {
    PetscCall(VecCopy(s->u[a], s->u_next[a]));
    PetscCall(VecAXPBY(s->u_next[a], -w * w / (1.0 + 2.0 * w), PetscSqr(1.0 + w) / (1.0 + 2.0 * w),
                       s->u_prev[a]));
  }
  *dt = flow->clock->dt * (1.0 + w) / (1.0 + 2.0 * w);
  PetscFunctionReturn(PETSC_SUCCESS);
}
