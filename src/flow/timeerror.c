/* Control of the step length by the error in time (-dt_adapt error). A polynomial through earlier
   velocities of a particle predicts u^{n+1}. Its error and the error of BDF are multiples of the
   same derivative of u, so that the difference of both velocities gives the error of the step
   (Milne's device). A step whose error is too large is undone and repeated, and a
   proportional-integral controller chooses the length of the next step. */
#include "isph/flow.h"

#define START_SHARE 64.0 /* length of the first step: the limit of other reasons over this number */
#define FLOOR_SHARE 1e-3 /* steps below this share of the limit of other reasons are kept */
#define TARGET      0.7  /* error that the controller aims at, over its tolerance */
#define GROWTH      2.0  /* largest ratio of steps; BDF2 is stable up to 1 + sqrt(2) */
#define SHRINKAGE   0.2  /* smallest ratio of steps */
#define DEADBAND    1.2  /* steps grow by at least this ratio */
#define EXPONENT_I  0.3  /* of the integral part, over the order of the error */
#define EXPONENT_P  0.4  /* of the proportional part */

/* TimeErrorStart - Sets the length of the first step, before which no error is known; collective */
PetscErrorCode TimeErrorStart(Flow *flow)
{
  StepLimit limit;

  PetscFunctionBegin;
  if (!flow->clock->adapt->estimates) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SchemeLimit(flow, &limit));
  flow->clock->control.dt = limit.dt / START_SHARE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Computes the weights of u^n, u^{n-1}, u^{n-2} in the predictor P, and the share C of u - P that is
  the error of the step

    P = w_0 u^n + w_1 u^{n-1} + w_2 u^{n-2},   C = k/(k + t^{n+1} - t^m)

  P is the polynomial through the velocities at t^n ... t^m, with m = n-2 for BDF2 and n-1 for
  backward Euler; k is the length of HistoryStart(). See theory.md, (time:prediction) and
  (time:error).
*/
static void SetPredictor(const Clock *clock, PetscReal weight[HISTORY], PetscReal *share)
{
  const PetscInt  n = clock->order == 1 ? 2 : 3;
  const PetscReal b = clock->dt + clock->dt_previous, c = b + clock->dt_before;
  const PetscReal w = ClockRatio(clock), k = clock->dt * (1.0 + w) / (1.0 + 2.0 * w);

  HistoryPredict(clock, n, weight);
  *share = k / (k + (n == 2 ? b : c));
}

/* Computes the error of the step of each particle, C (u^{n+1} - P) [m/s]. */
static PetscErrorCode SetError(const Flow *flow, Vec error[])
{
  const FlowState *s = flow->state;
  PetscReal        weight[HISTORY], share;

  PetscFunctionBegin;
  SetPredictor(flow->clock, weight, &share);
  for (PetscInt a = 0; a < flow->scene->dim; a++) {
    Vec               earlier[3] = {s->u[a], s->u_prev[a], s->u_before[a]};
    const PetscScalar factor[3]  = {-share * weight[0], -share * weight[1], -share * weight[2]};

    PetscCall(VecCopy(s->u_next[a], error[a]));
    PetscCall(VecScale(error[a], share));
    PetscCall(VecMAXPY(error[a], 3, factor, earlier));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the root mean square of the error of the step over the fluid, with moving particles of
   its smooth solenoidal part only [m/s]. */
static PetscErrorCode EstimateError(Flow *flow, PetscReal *norm)
{
  const PetscInt dim = flow->scene->dim;
  PetscReal      sum = 0.0;
  Vec            error[ISPH_MAX_DIM];

  PetscFunctionBegin;
  for (PetscInt a = 0; a < dim; a++) PetscCall(FlowGetWork(flow, &error[a]));
  PetscCall(SetError(flow, error));
  if (SceneMoves(flow->scene)) {
    PetscCall(SolenoidalNorm(flow->scene, flow->particles, error, norm));
  } else {
    for (PetscInt a = 0; a < dim; a++) {
      PetscReal part;

      PetscCall(FluidSum(flow->particles, error[a], PETSC_TRUE, &part));
      sum += part;
    }
    *norm = PetscSqrtReal(sum / flow->particles->weight);
  }
  for (PetscInt a = 0; a < dim; a++) PetscCall(FlowRestoreWork(flow, &error[a]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Fails the step because of its error; ratio: error over its tolerance. The failure has no
   sentence, because the step is always repeated. */
static void RejectStep(Flow *flow, PetscReal ratio, PetscReal order, PetscReal least)
{
  const PetscReal change = PetscMax(SHRINKAGE, PetscPowReal(TARGET / ratio, 1.0 / order));

  flow->scheme->failure = (StepFailure){.code    = PETSC_ERR_NOT_CONVERGED,
                                        .dt_next = PetscMax(least, change * flow->clock->dt)};
}

/*
  TimeErrorCheck - Estimates the error of a step, fails the step if it is too large, and otherwise
  chooses the length of the next step

    r = C |u^{n+1} - P|/(rtol max(|u|, U/10))
    dt' = dt min(2, max(0.2, (0.7/r)^(0.3/q) (r'/r)^(0.4/q))),   q = 1 + min(2, -time_order)

  Collective. |u| is the largest root mean square so far, and r' the ratio of the last good step.
  Steps double in length until enough earlier velocities are known. The velocity at the start counts
  as unknown, because the first step may change it by any amount. Steps of a thousandth of the limit
  of other reasons are kept, because a jump of the velocity has the same error in any step. With
  -time_order 3 the error is that of BDF2, above that of the step. See theory.md, (time:ratio).
  Reference: K. Gustafsson, ACM Trans. Math. Softw. 17 (1991) 533-554
*/
PetscErrorCode TimeErrorCheck(Flow *flow)
{
  Clock          *clock   = flow->clock;
  StepControl    *control = &clock->control;
  const PetscReal order   = PetscMin(clock->order, 2) + 1.0;
  PetscReal       error, ratio, growth;
  StepLimit       limit;

  PetscFunctionBegin;
  control->speed = PetscMax(control->speed, FlowRmsSpeed(flow));
  if (clock->step <= PetscMin(clock->order, 2)) {
    control->dt = GROWTH * clock->dt;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(EstimateError(flow, &error));
  PetscCall(SchemeLimit(flow, &limit));
  ratio = error / (control->rtol * PetscMax(control->speed, 0.1 * flow->scene->speed));
  if (ratio > 1.0 && clock->dt > FLOOR_SHARE * limit.dt) {
    RejectStep(flow, ratio, order, FLOOR_SHARE * limit.dt);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  ratio  = PetscMax(ratio, 1e-6);
  growth = PetscPowReal(TARGET / ratio, EXPONENT_I / order);
  if (control->last > 0.0) growth *= PetscPowReal(control->last / ratio, EXPONENT_P / order);
  growth = PetscMin(GROWTH, PetscMax(SHRINKAGE, growth));
  if (growth > 1.0 && growth < DEADBAND) growth = 1.0;
  control->dt   = PetscMax(growth * clock->dt, FLOOR_SHARE * limit.dt);
  control->last = ratio;
  PetscFunctionReturn(PETSC_SUCCESS);
}
