/*
  The mean of the pressure over the last time T before each snapshot

    m(t) = int p ds/(t - t_0) over t_0 < s < t,   t - t_0 at most T,   by the trapezoidal rule

  at fixed places. The pressure of moving particles contains noise that swings with the passage of
  particles through corners under a lid. The mean is a field of the particles. FlowMove() carries it
  like the pressure, as an Eulerian field, because the mean along the paths of particles would
  differ from it by u.grad p T/2. A scheme with a pressure that is fixed in space averages it there.
  Steps outside of the last T before a snapshot do nothing. Probes and forces have fixed points, and
  average their values themselves (src/measures/slidingmean.c).
*/
#include "isph/flow.h"

static const OptionRow options[] = {
    {
        .name     = "-pressure_average",
        .kind     = VALUE_REAL,
        .brief    = "snapshots and probes have the mean of the pressure over the last time of this "
                    "length, rows of -probe_forces the mean of the force; 0: values of the instant",
        .unit     = "s",
        .standard = "0",
        NOT_NEGATIVE,
        .where = "flows with pressure that advance in time",
    },
};
const OptionTable AverageOptions = OPTIONS("Average of the pressure", options);

/*
  AverageCreate - Reads the option of the average

  Collective on PETSC_COMM_WORLD.

  Options Database Key:
. -pressure_average T - length of the average [s]
*/
PetscErrorCode AverageCreate(Flow *flow)
{
  PressureAverage *a = &flow->state->average;
  Memory          *memory;
  PetscBool        snapshots;

  PetscFunctionBegin;
  if (!SceneHas(flow->scene, PHYSICS_PRESSURE) || flow->clock->steady_solve)
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(OptionGetReal(&options[0], &a->T, NULL));
  if (a->T == 0.0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(OptionGiven("-output", &snapshots));
  a->snapshots = snapshots;
  memory       = &flow->scheme->memory;
  PetscCall(MemoryAddReal(memory, "average_start", &a->start));
  PetscCall(MemoryAddReal(memory, "average_due", &a->due));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* AverageRegister - Adds the mean to the fields of the particles; collective */
PetscErrorCode AverageRegister(Flow *flow)
{
  PressureAverage *a = &flow->state->average;

  PetscFunctionBegin;
  if (a->T == 0.0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ParticlesRegister(flow->particles, "p_mean", 1, HALO_NONE, ENTRY_MEAN, &a->mean));
  a->standing = FlowAddStanding(&a->mean, &a->vec, flow->state);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the time of the next snapshot [s]. */
static PetscReal NextSnapshot(const Clock *clock)
{
  const PetscReal every = clock->land_every;

  if (every == 0.0) return clock->t_end;
  return PetscMin(clock->t_end, ClockNext(every, clock->t));
}

/* Adds the present pressure over a time of length dt to a mean over a time of length `length`. */
static PetscErrorCode AddPressure(Flow *flow, PetscReal length, PetscReal dt)
{
  const Particles *p    = flow->particles;
  PetscReal       *mean = flow->state->average.mean;

  PetscFunctionBegin;
  if (flow->scheme->Average) {
    PetscCall(flow->scheme->Average(flow, length, dt));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (PetscInt i = 0; i < p->n_fluid; i++)
    mean[i] = (length * mean[i] + dt * p->p[i]) / (length + dt);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Begins or continues the mean before a step: adds p^n dt/2

  The mean begins at the first step in the last T before a snapshot at a multiple of -output_every
  or at -t_end. The pressure before the first step is not a pressure of the flow, and no mean begins
  with it.
*/
static PetscErrorCode AverageBegin(Flow *flow)
{
  PressureAverage *a     = &flow->state->average;
  const Clock     *clock = flow->clock;
  PetscReal        due;

  PetscFunctionBegin;
  if (a->snapshots) {
    due = NextSnapshot(clock);
    if (a->due != due) a->due = a->start = 0.0;
    if (a->due == 0.0 && clock->step > 0 && due - clock->t <= a->T * (1.0 + 1e-9)) {
      a->due   = due;
      a->start = clock->t;
    }
    if (a->due > 0.0) PetscCall(AddPressure(flow, clock->t - a->start, 0.5 * clock->dt));
  }
  a->standing->idle = a->due > 0.0 ? PETSC_FALSE : PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Continues the mean after a step: adds p^{n+1} dt/2. */
static PetscErrorCode AverageEnd(Flow *flow)
{
  const PressureAverage *a  = &flow->state->average;
  const PetscReal        dt = flow->clock->dt;

  PetscFunctionBegin;
  if (a->due > 0.0) PetscCall(AddPressure(flow, flow->clock->t - a->start + 0.5 * dt, 0.5 * dt));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool Averages(const Flow *flow)
{
  return flow->state->average.T > 0.0;
}

/* The mean of the pressure over the last time before a snapshot. */
const Observer ObserverAverage = {
    .Applies = Averages,
    .Begin   = AverageBegin,
    .End     = AverageEnd,
};

/* AverageLength - Returns the length of the present mean [s]; 0: there is none; not collective */
PetscReal AverageLength(const Flow *flow)
{
  const PressureAverage *a = &flow->state->average;

  return a->due > 0.0 ? flow->clock->t - a->start : 0.0;
}
