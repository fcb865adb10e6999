/* Quantities of a velocity that several stages need: rows of mass, divergence, and values of all
   particles; the start of an implicit step, and that of a run. */
#include "isph/flow.h"

#define START_TOLD 0.05 /* change of a given start that is told, relative [-] */

/* FlowDivergence - Computes the divergence of a velocity u, which the equations of mass make zero
   [1/s]; collective */
PetscErrorCode FlowDivergence(const Flow *flow, const Vec u[], Vec div)
{
  PetscFunctionBegin;
  PetscCall(VecZeroEntries(div));
  for (PetscInt c = 0; c < flow->scene->dim; c++)
    PetscCall(AffineApplyAdd(&flow->ops->div[c], u[c], flow->walls.u[c], div));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FlowAllVelocities - Creates an array of the velocity components u of all particles, halo
   included, by [i dim + a]; free with PetscFree(); collective */
PetscErrorCode FlowAllVelocities(const Flow *flow, const Vec u[], PetscReal **all)
{
  const Particles *p = flow->particles;
  const PetscInt   d = p->dim;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(ParticlesAll(p) * d, all));
  for (PetscInt a = 0; a < d; a++) {
    const PetscScalar *v;

    PetscCall(VecGetArrayRead(u[a], &v));
    for (PetscInt i = 0; i < p->n_fluid; i++) (*all)[i * d + a] = PetscRealPart(v[i]);
    PetscCall(VecRestoreArrayRead(u[a], &v));
  }
  PetscCall(ParticlesHaloVectors(p, *all));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* HistoryStart - Sets u_next to the start of an implicit step, HistoryStartWeights(). Collective.
   Input: history - flag: BDF if earlier velocities are known; otherwise backward Euler, with start
   = u^n and k = dt. Output: dt - length k of the step from this start [s]. */
PetscErrorCode HistoryStart(Flow *flow, PetscBool history, PetscReal *dt)
{
  FlowState *s = flow->state;
  PetscReal  weight[HISTORY];

  PetscFunctionBegin;
  *dt = flow->clock->dt;
  if (history) *dt *= HistoryStartWeights(flow->clock, weight);
  for (PetscInt a = 0; a < flow->scene->dim; a++) {
    PetscCall(VecCopy(s->u[a], s->u_next[a]));
    if (!history) continue;
    PetscCall(VecAXPBY(s->u_next[a], weight[1], weight[0], s->u_prev[a]));
    if (weight[2] != 0.0) PetscCall(VecAXPY(s->u_next[a], weight[2], s->u_before[a]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FlowGiveStart - Sets u_next to the velocity at the start of a run. Collective. Output: moves -
   flag: it is not zero everywhere, and the scheme must make it free of divergence: otherwise the
   pressure of the first step is this impulse over dt. */
PetscErrorCode FlowGiveStart(Flow *flow, PetscBool *moves)
{
  const FlowState *s = flow->state;
  PetscScalar      square;

  PetscFunctionBegin;
  *moves = PETSC_FALSE;
  for (PetscInt a = 0; a < flow->scene->dim; a++) {
    PetscCall(VecCopy(s->u[a], s->u_next[a]));
    PetscCall(VecDot(s->u[a], s->u[a], &square)); /* VecNorm() may know that of earlier values */
    if (square > 0.0) *moves = PETSC_TRUE;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FlowTakeStart - Makes u_next, which is free of divergence, the velocity at the start of a run,
   and says so if the given one was far from it. Collective. The caller has the flow begin anew. */
PetscErrorCode FlowTakeStart(Flow *flow)
{
  const FlowState *s     = flow->state;
  PetscReal        given = 0.0, change = 0.0, part;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < flow->scene->dim; a++) {
    PetscCall(VecDot(s->u[a], s->u[a], &part));
    given += part;
    PetscCall(VecAXPY(s->u[a], -1.0, s->u_next[a]));
    PetscCall(VecDot(s->u[a], s->u[a], &part));
    change += part;
    PetscCall(VecCopy(s->u_next[a], s->u[a]));
    PetscCall(VecCopy(s->u_next[a], s->u_prev[a]));
    if (s->u_before[a]) PetscCall(VecCopy(s->u_next[a], s->u_before[a]));
  }
  if (change > PetscSqr(START_TOLD) * given)
    PetscCall(SayLine("start: the given velocity is not free of divergence, or crosses walls; what "
                      "frees it changes it by %.2g (relative, root mean square)",
                      (double)PetscSqrtReal(change / given)));
  PetscFunctionReturn(PETSC_SUCCESS);
}
