/* Quantities of a velocity that several stages need: rows of mass, divergence, and values of all
   particles; and the start of an implicit step. */
#include "isph/flow.h"

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
