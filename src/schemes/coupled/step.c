/*
  The coupled step: a solve for velocity and pressure together, either in time, or steady with
  Picard iterations for convection. In the first step in time with substeps, a backward Euler step
  makes the velocity solenoidal before the substeps begin.
*/
#include "coupled.h"

#define PICARD_MOST   50   /* largest number of iterations of a steady flow */
#define PICARD_CHANGE 1e-6 /* relative change of u in the last iteration */

/* Solves the linear system, starting from the present unknowns. */
static PetscErrorCode SolveLinear(Vec b, Coupled *c, StepFailure *failure)
{
  PetscFunctionBegin;
  PetscCall(KSPSetOperators(c->guard.solve.ksp, c->saddle.A, c->flat ? c->flat : c->saddle.P));
  PetscCall(KSPSetInitialGuessNonzero(c->guard.solve.ksp, PETSC_TRUE));
  PetscCall(KSPSolve(c->guard.solve.ksp, b, c->x));
  PetscCall(KSPSetInitialGuessNonzero(c->guard.solve.ksp, PETSC_FALSE));
  PetscCall(GuardCheck(&c->guard, failure));
  c->guard.solve.iterations += c->guard.iterations;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Makes a backward Euler step from t over h, after which the velocity is solenoidal and agrees with
  the wall velocity. The velocity at the start of a run need not, and an integrator with error
  control would never accept a step from it.
*/
static PetscErrorCode StartConsistently(PetscReal t, PetscReal h, Coupled *c, StepFailure *failure)
{
  const PetscReal T = c->saddle.step;
  Vec             b;

  PetscFunctionBegin;
  PetscCall(CoupledSetShift(1.0 / h, c));
  PetscCall(CoupledRightHandSide(c, t + h));
  PetscCall(VecDuplicate(c->b, &b));
  PetscCall(VecCopy(c->b, b));
  if (c->convects) PetscCall(CoupledAddConvection(c, c->x, -T, b));
  PetscCall(SaddleGet(&c->saddle, c->x, c->u, NULL));
  for (PetscInt a = 0; a < c->saddle.dim; a++)
    PetscCall(SaddleAdd(&c->saddle, a, T / h, c->u[a], b));
  PetscCall(SolveLinear(b, c, failure));
  PetscCall(VecDestroy(&b));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Advances from t over dt: by a single step of the TS, or by substeps with error control if the row
  of the integrator has them. The first substep has the length of the last substep of the step
  before. In the first step of a run, StartConsistently() advances over dt/100 before the substeps.
*/
static PetscErrorCode AdvanceInTime(PetscReal t, PetscReal dt, Coupled *c, StepFailure *failure)
{
  PetscReal h = dt, started = 0.0;

  PetscFunctionBegin;
  if (c->row->substeps && c->substep == 0.0) {
    h = started = 0.01 * dt;
    PetscCall(StartConsistently(t, started, c, failure));
  } else if (c->row->substeps) {
    h = PetscMin(c->substep, dt);
  }
  PetscCall(
      TSSetIJacobian(c->ts, c->saddle.A, c->flat ? c->flat : c->saddle.P, CoupledIJacobian, c));
  PetscCall(TSSetSolution(c->ts, c->x));
  PetscCall(TSRestartStep(c->ts));
  PetscCall(
      TimeStepThrough(c->ts, c->row->name, &c->guard, t + started, dt - started, &h, failure));
  if (c->row->substeps) c->substep = h;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes |u - v|/|u| over all components. */
static PetscErrorCode RelativeChange(PetscInt dim, const Vec u[], const Vec v[], Vec work,
                                     PetscReal *change)
{
  PetscReal sum = 0.0, all = 0.0, part;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < dim; a++) {
    PetscCall(VecWAXPY(work, -1.0, v[a], u[a]));
    PetscCall(VecNorm(work, NORM_2, &part));
    sum += PetscSqr(part);
    PetscCall(VecNorm(u[a], NORM_2, &part));
    all += PetscSqr(part);
  }
  *change = all > 0.0 ? PetscSqrtReal(sum / all) : 0.0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Solves for a steady flow with convection (v.grad) u by Picard's iteration. In each iteration v is
  the velocity u of the iteration before. The last iteration changes u by at most the share
  PICARD_CHANGE.

  Reference: H. C. Elman, D. J. Silvester, A. J. Wathen, Finite Elements and Fast Iterative Solvers
  (2014), ch. 8
*/
static PetscErrorCode IteratePicard(Vec u[], Vec pressure, Vec advecting[], Coupled *c,
                                    StepFailure *failure)
{
  const Clock *clock  = c->flow->clock;
  PetscReal    change = PETSC_INFINITY;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < PICARD_MOST && change > PICARD_CHANGE && !failure->code; k++) {
    PetscCall(SaddleGet(&c->saddle, c->x, advecting, pressure));
    PetscCall(CoupledAssemble(0.0, advecting, c));
    PetscCall(SaddlePut(&c->saddle, advecting, pressure, c->x));
    PetscCall(CoupledRightHandSide(c, clock->t + clock->dt));
    PetscCall(SolveLinear(c->b, c, failure));
    PetscCall(SaddleGet(&c->saddle, c->x, u, NULL));
    PetscCall(RelativeChange(c->saddle.dim, u, advecting, c->part, &change));
  }
  if (change > PICARD_CHANGE) {
    FailureSet(failure, PETSC_ERR_NOT_CONVERGED,
               "-steady: u still changes by %.1e (relative) after %d Picard iterations; the flow "
               "at this Reynolds number must be advanced in time (no -steady)",
               (double)change, PICARD_MOST);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Solves for u_next and p at the clock's t + dt. On entry u_next is the velocity at the start of the
  step of length dt, and p an estimate of the pressure.
*/
static PetscErrorCode SolveSystem(Flow *flow, PetscReal dt, Coupled *c)
{
  const Clock    *clock   = flow->clock;
  FlowState      *s       = flow->state;
  StepFailure    *failure = &flow->scheme->failure;
  const PetscReal end     = clock->t + clock->dt;
  Vec             advecting[ISPH_MAX_DIM];

  PetscFunctionBegin;
  PetscCall(ClockWhere(clock, c->guard.where));
  PetscCall(CoupledAssemble(clock->steady_solve ? 0.0 : 1.0 / dt, NULL, c));
  PetscCall(SaddlePut(&c->saddle, s->u_next, s->p, c->x));
  if (!clock->steady_solve) {
    PetscCall(AdvanceInTime(end - dt, dt, c, failure));
  } else {
    PetscCall(CoupledRightHandSide(c, end));
    PetscCall(SolveLinear(c->b, c, failure));
  }
  if (clock->steady_solve && SceneHas(flow->scene, PHYSICS_CONVECTION)) {
    for (PetscInt a = 0; a < flow->scene->dim; a++) PetscCall(FlowGetWork(flow, &advecting[a]));
    PetscCall(IteratePicard(s->u_next, s->p, advecting, c, failure));
    c->advecting         = NULL;
    c->saddle.assemblies = -1; /* forces an assembly without convection */
    for (PetscInt a = 0; a < flow->scene->dim; a++) PetscCall(FlowRestoreWork(flow, &advecting[a]));
  }
  PetscCall(SaddleGet(&c->saddle, c->x, s->u_next, s->p));
  PetscCall(GaugeRemove(flow->scene, flow->particles, s->p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* CoupledSolve - Solves for u^{n+1} and p^{n+1}, and computes the divergence of u^{n+1};
   collective */
PetscErrorCode CoupledSolve(Flow *flow)
{
  FlowState      *s   = flow->state;
  Coupled        *c   = (Coupled *)flow->scheme->data;
  const PetscInt  dim = flow->scene->dim;
  const PetscReal end = flow->clock->t + flow->clock->dt;
  PetscReal       dt  = flow->clock->dt;
  Vec             force[ISPH_MAX_DIM];

  PetscFunctionBegin;
  PetscCall(PetscLogEventBegin(c->event, 0, 0, 0, 0));
  for (PetscInt a = 0; a < dim; a++) PetscCall(FlowGetWork(flow, &force[a]));
  c->force                  = force;
  c->stages                 = c->row->substeps || flow->clock->steady_solve;
  c->b_t                    = NAN;
  c->guard.solve.iterations = 0;
  if (c->stages) {
    for (PetscInt a = 0; a < dim; a++) PetscCall(VecCopy(s->u[a], s->u_next[a]));
  } else {
    PetscCall(HistoryStart(flow, PETSC_TRUE, &dt));
    PetscCall(CoupledForce(flow, force));
  }
  PetscCall(VecCopy(s->p, s->p_before));
  PetscCall(SolveSystem(flow, dt, c));
  PetscCall(WallValuesSetVelocity(flow->scene, flow->particles, end, 0.0, &flow->walls));
  PetscCall(FlowDivergence(flow, s->u_next, s->divergence));
  for (PetscInt a = 0; a < dim; a++) PetscCall(FlowRestoreWork(flow, &force[a]));
  PetscCall(PetscLogEventEnd(c->event, 0, 0, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}
