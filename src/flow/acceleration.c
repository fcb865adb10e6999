/*
  The acceleration of the last step, and the error of steps in time. Both are for the estimate of
  errors in reports.

    a = (u^{n+1} - start)/k,   start and k of HistoryStart()

  is the rate Du/Dt that the formula of the step has solved for, so that the momentum equation with
  a has no error in time. BDF2 leaves dt^2/3 u''' in this equation, and backward Euler dt/2 u''. A
  residual that alternates as the flow does acts for the time |u'|/|u''|, so that the error of the
  velocity is about

    e = dt^2/3 |u''|   or   e = dt/2 |u'|,

  or what decay leaves of it from earlier steps. The velocity of moving particles has a noise, whose
  second derivative is no error: their u' and u'' are those of the root mean square of u, and of a
  particle that the strain of the flow turns, see src/measures/trust.c.
*/
#include "isph/flow.h"

#define SAMPLE 16  /* steps from one measurement of the error in time to the next */
#define ALIKE  1.5 /* largest ratio of two rates of one decay [-] */

/* Keeps the rate of component a of a step whose formula has these weights and this length. */
static PetscErrorCode KeepRate(const Flow *flow, PetscInt a, const PetscReal weight[HISTORY],
                               PetscReal k)
{
  const FlowState   *s    = flow->state;
  PetscReal         *rate = s->acceleration.rate[a];
  const PetscScalar *next, *now, *earlier, *first = NULL;

  PetscFunctionBegin;
  PetscCall(VecGetArrayRead(s->u_next[a], &next));
  PetscCall(VecGetArrayRead(s->u[a], &now));
  PetscCall(VecGetArrayRead(s->u_prev[a], &earlier));
  if (s->u_before[a]) PetscCall(VecGetArrayRead(s->u_before[a], &first));
  for (PetscInt i = 0; i < flow->particles->n_fluid; i++) {
    const PetscReal start = weight[0] * now[i] + weight[1] * earlier[i];

    rate[i] = (next[i] - start - (first ? weight[2] * first[i] : 0.0)) / k;
  }
  if (first) PetscCall(VecRestoreArrayRead(s->u_before[a], &first));
  PetscCall(VecRestoreArrayRead(s->u_prev[a], &earlier));
  PetscCall(VecRestoreArrayRead(s->u[a], &now));
  PetscCall(VecRestoreArrayRead(s->u_next[a], &next));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the squares of u' and u'' over the last two steps of component a to sum. */
static PetscErrorCode AddDerivatives(const Flow *flow, PetscInt a, PetscReal sum[2])
{
  const FlowState   *s  = flow->state;
  const PetscReal    dt = flow->clock->dt, before = flow->clock->dt_previous;
  const PetscScalar *next, *now, *earlier;

  PetscFunctionBegin;
  PetscCall(VecGetArrayRead(s->u_next[a], &next));
  PetscCall(VecGetArrayRead(s->u[a], &now));
  PetscCall(VecGetArrayRead(s->u_prev[a], &earlier));
  for (PetscInt i = 0; i < flow->particles->n_fluid; i++) {
    const PetscReal first = (next[i] - now[i]) / dt;
    const PetscReal second =
        before > 0.0 ? 2.0 * (first - (now[i] - earlier[i]) / before) / (dt + before) : first / dt;

    sum[0] += ParticlesWeight(flow->particles, i) * PetscSqr(first);
    sum[1] += ParticlesWeight(flow->particles, i) * PetscSqr(second);
  }
  PetscCall(VecRestoreArrayRead(s->u_prev[a], &earlier));
  PetscCall(VecRestoreArrayRead(s->u[a], &now));
  PetscCall(VecRestoreArrayRead(s->u_next[a], &next));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes |u'| and |u''| of the present step: of the velocity of fixed particles, of its root mean
   square with moving ones. In the first step u'' is u'/dt. */
static PetscErrorCode Derivatives(const Flow *flow, PetscReal derivative[2])
{
  const Acceleration *acceleration = &flow->state->acceleration;
  const PetscReal     dt = flow->clock->dt, before = flow->clock->dt_previous;
  const PetscReal    *speed = acceleration->speed;

  PetscFunctionBegin;
  derivative[0] = derivative[1] = 0.0;
  if (SceneMoves(flow->scene)) {
    derivative[0] = (FlowRmsSpeed(flow) - speed[0]) / dt;
    derivative[1] = derivative[0] / dt;
    if (before > 0.0)
      derivative[1] = 2.0 * (derivative[0] - (speed[0] - speed[1]) / before) / (dt + before);
    for (PetscInt k = 0; k < 2; k++) derivative[k] = PetscAbsReal(derivative[k]);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (PetscInt a = 0; a < flow->scene->dim; a++) PetscCall(AddDerivatives(flow, a, derivative));
  PetscCallMPI(
      MPI_Allreduce(MPI_IN_PLACE, derivative, 2, MPIU_REAL, MPIU_SUM, flow->particles->comm));
  for (PetscInt k = 0; k < 2; k++)
    derivative[k] = PetscSqrtReal(derivative[k] / flow->particles->weight);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the error of the present steps to what decay has left of the earlier one, after `span`. The
   error of a flow that decays, with u'' = -d u' and u' = -d u, keeps its sign: it decays with the
   flow, and grows beside it by d in a time. Otherwise the residual alternates, and errors decay by
   walls, with the flow, and by their own details. */
static void AddError(const Flow *flow, PetscReal error, const PetscReal derivative[2],
                     PetscReal span, Acceleration *acceleration)
{
  const PetscReal speed = FlowRmsSpeed(flow), before = acceleration->speed[0];
  const PetscReal rate = derivative[0] > 0.0 ? derivative[1] / derivative[0] : 0.0;
  const PetscReal d =
      speed > 0.0 && before > speed ? (before / speed - 1.0) / flow->clock->dt : 0.0;

  if (flow->clock->step < 2) acceleration->time_error = 0.0; /* the first step knows no u'' */
  if (d > 0.0 && rate > d / ALIKE && rate < ALIKE * d) {
    acceleration->time_error *= PetscExpReal(-d * span);
    acceleration->time_error += error * d * span;
  } else {
    acceleration->time_error *= PetscExpReal(-(SceneDecayRate(flow->scene) + rate + d) * span);
  }
  acceleration->time_error = PetscMax(acceleration->time_error, error);
}

/* AccelerationKeep - Keeps the rate of the present step, from u_next, for AccelerationGet();
   collective */
PetscErrorCode AccelerationKeep(const Flow *flow)
{
  PetscReal       weight[HISTORY];
  const PetscReal k = flow->clock->dt * HistoryStartWeights(flow->clock, weight);

  PetscFunctionBegin;
  for (PetscInt a = 0; a < flow->scene->dim; a++) PetscCall(KeepRate(flow, a, weight, k));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AccelerationEnd(Flow *flow)
{
  const Clock  *clock        = flow->clock;
  Acceleration *acceleration = &flow->state->acceleration;
  PetscReal     derivative[2];

  PetscFunctionBegin;
  PetscCall(AccelerationKeep(flow));
  if (clock->step < SAMPLE || clock->step % SAMPLE == 0) {
    const PetscReal now = clock->t + clock->dt;
    PetscReal       error;

    PetscCall(Derivatives(flow, derivative));
    error = clock->order > 1 ? PetscSqr(clock->dt) / 3.0 * derivative[1]
                             : 0.5 * clock->dt * derivative[0];
    AddError(flow, error, derivative, now - acceleration->sampled, acceleration);
    acceleration->sampled = now;
  }
  acceleration->speed[1] = acceleration->speed[0];
  acceleration->speed[0] = FlowRmsSpeed(flow);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Notes the speed at the start of the run. */
static PetscErrorCode AccelerationBegin(Flow *flow)
{
  PetscReal *speed = flow->state->acceleration.speed;

  PetscFunctionBegin;
  if (flow->clock->step == 0) speed[0] = speed[1] = FlowRmsSpeed(flow);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool Advances(const Flow *flow)
{
  return !(flow->clock->steady_solve || flow->scheme->Accelerate);
}

/* The acceleration of particles in the last step, and the error in time. */
const Observer ObserverAcceleration = {
    .Applies = Advances,
    .Begin   = AccelerationBegin,
    .End     = AccelerationEnd,
};

/* AccelerationGet - Computes Du/Dt of own fluid by components; zero before the first step and in a
   steady solve [m/s^2]; collective */
PetscErrorCode AccelerationGet(const Flow *flow, PetscReal *const rate[])
{
  PetscReal *const *last = flow->state->acceleration.rate;
  const PetscInt    n    = flow->particles->n_fluid;

  PetscFunctionBegin;
  if (flow->scheme->Accelerate) {
    PetscCall(flow->scheme->Accelerate(flow, rate));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (PetscInt a = 0; a < flow->scene->dim; a++) {
    if (last[a]) PetscCall(PetscArraycpy(rate[a], last[a], n));
    else PetscCall(PetscArrayzero(rate[a], n));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* AccelerationRegister - Adds the acceleration to the fields of the particles; collective */
PetscErrorCode AccelerationRegister(Flow *flow)
{
  PetscFunctionBegin;
  if (!Advances(flow)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ParticlesRegister(flow->particles, "acceleration", flow->scene->dim, HALO_NONE,
                              ENTRY_MEAN, flow->state->acceleration.rate));
  if (SceneMoves(flow->scene) && flow->state->velocity_filter > 0.0)
    PetscCall(ParticlesRegister(flow->particles, "filtered", flow->scene->dim, HALO_NONE,
                                ENTRY_ZERO, flow->state->acceleration.filtered));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* AccelerationRemember - Adds the error in time to the memory of the run */
PetscErrorCode AccelerationRemember(Flow *flow)
{
  Acceleration *acceleration = &flow->state->acceleration;
  Memory       *memory       = &flow->scheme->memory;

  PetscFunctionBegin;
  if (!Advances(flow)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MemoryAddReal(memory, "time_error", &acceleration->time_error));
  PetscCall(MemoryAddReal(memory, "time_error_at", &acceleration->sampled));
  PetscCall(MemoryAddReal(memory, "speed_last", &acceleration->speed[0]));
  PetscCall(MemoryAddReal(memory, "speed_before", &acceleration->speed[1]));
  PetscFunctionReturn(PETSC_SUCCESS);
}
