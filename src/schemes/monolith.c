/*
  The coupled scheme's step: where it starts, then velocity and pressure at once; in time, or steady
  by Picard iterations where there is convection.
*/
#include "coupled.h"
#include "projection.h"

#define PICARD_MOST   50   /* iterations of a steady flow */
#define PICARD_CHANGE 1e-6 /* of u in the last of them, relative */

/* One linear solve, from the unknowns as they are. */
static PetscErrorCode SolveLinear(Vec b, Coupled *c, StepFailure *failure)
{
  PetscFunctionBegin;
  PetscCall(KSPSetOperators(c->ksp, c->saddle.A, c->flat ? c->flat : c->saddle.P));
  PetscCall(KSPSetInitialGuessNonzero(c->ksp, PETSC_TRUE));
  PetscCall(KSPSolve(c->ksp, b, c->x));
  PetscCall(KSPSetInitialGuessNonzero(c->ksp, PETSC_FALSE));
  PetscCall(GuardCheck(c->ksp, &c->guard, failure));
  c->iterations += c->guard.iterations;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  A step of backward Euler from t over h: velocities at the start of a run need not be solenoidal,
  nor those of the walls theirs, and an integrator that measures its error would see no end of it.
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
  From t over dt: one step of the TS, or as many as the error wants. Those begin with the last of
  the clock's step before; in a run's first after one of dt/100 that makes the flow consistent.
*/
static PetscErrorCode AdvanceInTime(PetscReal t, PetscReal dt, PetscReal *substep, Coupled *c,
                                    StepFailure *failure)
{
  PetscReal h = dt, started = 0.0;

  PetscFunctionBegin;
  if (c->row->substeps && *substep == 0.0) {
    h = started = 0.01 * dt;
    PetscCall(StartConsistently(t, started, c, failure));
  } else if (c->row->substeps) {
    h = PetscMin(*substep, dt);
  }
  PetscCall(
      TSSetIJacobian(c->ts, c->saddle.A, c->flat ? c->flat : c->saddle.P, CoupledIJacobian, c));
  PetscCall(TSSetSolution(c->ts, c->x));
  PetscCall(TSRestartStep(c->ts));
  PetscCall(TimeStepThrough(c->ts, c->row->name, c->ksp, &c->guard, t + started, dt - started, &h,
                            &c->iterations, failure));
  if (c->row->substeps) *substep = h;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* |u - v|/|u| over all components. */
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
  (v.grad) u with v = u of the iteration before, until u stays.

  Reference: H. C. Elman, D. J. Silvester, A. J. Wathen, Finite Elements and Fast Iterative Solvers
  (2014), ch. 8
*/
static PetscErrorCode IteratePicard(const Clock *clock, Vec u[], Vec pressure, Vec advecting[],
                                    Coupled *c, StepFailure *failure)
{
  PetscReal change = PETSC_INFINITY;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < PICARD_MOST && change > PICARD_CHANGE && !failure->code; k++) {
    PetscCall(SaddleGet(&c->saddle, c->x, advecting, pressure));
    PetscCall(CoupledAssemble(clock, 0.0, advecting, c));
    PetscCall(SaddlePut(&c->saddle, advecting, pressure, c->x));
    PetscCall(CoupledRightHandSide(c, clock->t + clock->dt));
    PetscCall(SolveLinear(c->b, c, failure));
    PetscCall(SaddleGet(&c->saddle, c->x, u, NULL));
    PetscCall(RelativeChange(c->saddle.dim, u, advecting, c->part, &change));
  }
  if (change > PICARD_CHANGE) {
    FailureSet(failure, PETSC_ERR_NOT_CONVERGED,
               "-steady: u still changes by %.1e of itself after %d Picard iterations; the flow at "
               "this Reynolds number must be advanced in time (no -steady)",
               (double)change, PICARD_MOST);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Velocity and pressure at clock's t + dt, in place of the velocity where the step of length dt
  starts and a guess at the pressure.
*/
static PetscErrorCode SolveSystem(const Scene *scene, const Clock *clock, const Particles *p,
                                  PetscReal dt, Operators *ops, Scheme *scheme)
{
  Projection     *pr    = (Projection *)scheme->data;
  Coupled        *c     = scheme->coupled;
  const PetscReal end   = clock->t + clock->dt;
  const PetscReal shift = clock->steady_solve ? 0.0 : 1.0 / dt;

  PetscFunctionBegin;
  c->scene      = scene;
  c->particles  = p;
  c->ops        = ops;
  c->scheme     = scheme;
  c->force      = pr->force;
  c->stages     = c->row->substeps || clock->steady_solve;
  c->b_t        = NAN;
  c->iterations = 0;
  PetscCall(ClockWhere(clock, c->guard.where));
  PetscCall(CoupledAssemble(clock, shift, NULL, c));
  PetscCall(SaddlePut(&c->saddle, pr->star, pr->p, c->x));
  if (clock->steady_solve) {
    PetscCall(CoupledRightHandSide(c, end));
    PetscCall(SolveLinear(c->b, c, &scheme->failure));
    if (SceneHas(scene, PHYSICS_CONVECTION))
      PetscCall(IteratePicard(clock, pr->star, pr->p, pr->conv, c, &scheme->failure));
  } else {
    PetscCall(AdvanceInTime(end - dt, dt, &scheme->number[NUMBER_SUBSTEP], c, &scheme->failure));
  }
  PetscCall(SaddleGet(&c->saddle, c->x, pr->star, pr->p));
  PetscCall(VecRemoveMean(pr->p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* u^{n+1} in u*, p^{n+1}, and the divergence that u^{n+1} has. */
static PetscErrorCode CoupledSolve(const Scene *scene, const Clock *clock, Particles *p,
                                   Operators *ops, Scheme *scheme)
{
  Projection *pr = (Projection *)scheme->data;
  PetscReal   dt = clock->dt;

  PetscFunctionBegin;
  PetscCall(PetscLogEventBegin(pr->event[EVENT_COUPLED], 0, 0, 0, 0));
  if (clock->steady_solve || CoupledIntegrator(scheme->coupled)->substeps) {
    for (PetscInt a = 0; a < scene->dim; a++) PetscCall(VecCopy(pr->u[a], pr->star[a]));
  } else {
    PetscCall(PredictorStart(scene, clock, p, ops, PETSC_TRUE, 1.0, scheme, &dt));
  }
  PetscCall(VecCopy(pr->p, pr->p_before));
  PetscCall(SolveSystem(scene, clock, p, dt, ops, scheme));
  PetscCall(OperatorsSetWallVelocity(scene, p, clock->t + clock->dt, 0.0, ops));
  PetscCall(VecZeroEntries(pr->div));
  for (PetscInt a = 0; a < scene->dim; a++)
    PetscCall(AffineApplyAdd(&ops->div[a], pr->star[a], ops->wall_u[a], pr->div));
  PetscCall(PetscLogEventEnd(pr->event[EVENT_COUPLED], 0, 0, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* CoupledStep - One step of velocity and pressure together; see FlowStep() */
PetscErrorCode CoupledStep(const Scene *scene, Clock *clock, Particles *p, Neighbors *nb,
                           Operators *ops, Scheme *scheme)
{
  PetscFunctionBegin;
  PetscCall(FlowStep(scene, clock, p, nb, ops, CoupledSolve, scheme));
  PetscFunctionReturn(PETSC_SUCCESS);
}
