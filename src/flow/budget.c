/*
  The budget of a step: the kinetic energy that each part of the step adds, and the divergence of
  the velocity after it, by boxes. A part that changes the velocity of particle i by c adds

    rho V_i c.(u^n + u^{n+1})/2

  so that the order of the parts has no influence, and all parts add up to the change of the energy
  in the step. If the viscous step begins from a history of velocities, forces, viscosity and
  projection add rho V_i dt a.u^{n+1} with the acceleration a = c/k of an implicit step of length k.
  The rest is the energy of the time integrator. See docs/theory.md, (135) and (136).
*/
#include "isph/flow.h"

/* Values of a part of the step in a box. */
typedef struct {
  PetscReal weight;      /* sum of ParticlesWeight() [-] */
  PetscReal energy;      /* that the part added, over rho times the volume of a cell [m^2/s^2] */
  PetscReal divergence2; /* sum of weight (div u)^2 [1/s^2] */
  PetscReal most;        /* largest |div u| [1/s] */
} BoxSums;

struct Budget {
  PetscInt         n;   /* boxes; box n is the rest of the fluid */
  const PetscReal *box; /* lower and upper corners [m] */
  PetscBool        measured[STEP_PARTS];
  PetscReal       *after[STEP_PARTS]; /* u_a of particle i after a part at [i * dim + a] [m/s] */
  PetscInt         capacity;          /* particles for which these arrays have room */
  PetscReal        ratio;             /* dt over the length k of the viscous step [-] */
  BoxSums         *sums[STEP_PARTS];
};

/*
  BudgetCreate - Lets each step measure its budget

  Collective. Between steps only, before a restart.

  Input Parameters:
+ n   - number of boxes
- box - lower and upper corner of each box, which must live as long as the flow [m]
*/
PetscErrorCode BudgetCreate(Flow *flow, PetscInt n, const PetscReal box[])
{
  static const char *const names[] = {"shift_change", "clearance_change", "filter_change"};
  Budget                  *budget;

  PetscFunctionBegin;
  PetscCall(PetscNew(&budget));
  budget->n   = n;
  budget->box = box;
  for (PetscInt part = 0; part < STEP_PARTS; part++)
    PetscCall(PetscCalloc1(n + 1, &budget->sums[part]));
  for (PetscInt k = 0; k < CARRIED_PARTS && SceneMoves(flow->scene); k++) {
    PetscCall(ParticlesRegister(flow->particles, names[k], flow->scene->dim, HALO_NONE, ENTRY_ZERO,
                                flow->state->carried[k]));
  }
  flow->state->budget = budget;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Frees the budget; its fields belong to the particles. */
static PetscErrorCode BudgetDestroy(Flow *flow)
{
  Budget *budget = flow->state->budget;

  PetscFunctionBegin;
  for (PetscInt part = 0; part < STEP_PARTS; part++) {
    PetscCall(PetscFree(budget->after[part]));
    PetscCall(PetscFree(budget->sums[part]));
  }
  PetscCall(PetscFree(flow->state->budget));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the first box that contains particle i, or the rest. */
static PetscInt BoxOf(const Budget *budget, const Particles *p, PetscInt i)
{
  for (PetscInt k = 0; k < budget->n; k++) {
    const PetscReal *lo = &budget->box[2 * k * p->dim], *hi = lo + p->dim;
    PetscBool        inside = PETSC_TRUE;

    for (PetscInt a = 0; a < p->dim; a++)
      inside = inside && p->x[a][i] >= lo[a] && p->x[a][i] <= hi[a];
    if (inside) return k;
  }
  return budget->n;
}

/* Makes room for the velocities of n particles after each part. */
static PetscErrorCode Reserve(PetscInt n, PetscInt dim, Budget *budget)
{
  PetscFunctionBegin;
  if (n <= budget->capacity) PetscFunctionReturn(PETSC_SUCCESS);
  budget->capacity = n + n / 8;
  for (PetscInt part = 0; part < STEP_PARTS; part++) {
    PetscCall(PetscFree(budget->after[part]));
    PetscCall(PetscMalloc1((size_t)budget->capacity * (size_t)dim, &budget->after[part]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Keeps the velocity u after a part of the step, and measures its divergence. */
static PetscErrorCode MeasurePart(Flow *flow, StepPart part, const Vec u[])
{
  const Particles   *p      = flow->particles;
  Budget            *budget = flow->state->budget;
  const PetscScalar *v[ISPH_MAX_DIM], *divergence;
  Vec                work;

  PetscFunctionBegin;
  PetscCall(FlowGetWork(flow, &work));
  PetscCall(VecZeroEntries(work));
  for (PetscInt a = 0; a < p->dim; a++) {
    PetscCall(AffineApplyAdd(&OperatorsOfVelocity(flow->ops, a)->grad_u[a], u[a], flow->walls.u[a],
                             work));
    PetscCall(VecGetArrayRead(u[a], &v[a]));
  }
  PetscCall(VecGetArrayRead(work, &divergence));
  PetscCall(PetscArrayzero(budget->sums[part], budget->n + 1));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    BoxSums        *sums   = &budget->sums[part][BoxOf(budget, p, i)];
    const PetscReal weight = ParticlesWeight(p, i);

    sums->weight += weight;
    for (PetscInt a = 0; a < p->dim; a++) budget->after[part][i * p->dim + a] = v[a][i];
    sums->divergence2 += weight * PetscSqr(divergence[i]);
    sums->most = PetscMax(sums->most, PetscAbsReal(divergence[i]));
  }
  PetscCall(VecRestoreArrayRead(work, &divergence));
  for (PetscInt a = 0; a < p->dim; a++) PetscCall(VecRestoreArrayRead(u[a], &v[a]));
  PetscCall(FlowRestoreWork(flow, &work));
  budget->measured[part] = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Measures the velocity before a step of fixed particles. */
static PetscErrorCode BudgetBegin(Flow *flow)
{
  PetscFunctionBegin;
  if (SceneMoves(flow->scene)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Reserve(flow->particles->n_fluid, flow->scene->dim, flow->state->budget));
  PetscCall(MeasurePart(flow, PART_MOTION, flow->state->u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Measures the velocity before the step on the new operators, and after each part of the motion.
   The motion itself changes no velocity. All particles count in the boxes of their new places. */
static PetscErrorCode MeasureMotion(Flow *flow)
{
  const FlowState *state = flow->state;
  Vec              u[ISPH_MAX_DIM];

  PetscFunctionBegin;
  PetscCall(Reserve(flow->particles->n_fluid, flow->scene->dim, state->budget));
  for (PetscInt a = 0; a < flow->scene->dim; a++) PetscCall(FlowGetWork(flow, &u[a]));
  for (PetscInt k = -1; k < CARRIED_PARTS; k++) {
    for (PetscInt a = 0; a < flow->scene->dim; a++) {
      const PetscReal *all = state->carried[CARRIED_PARTS - 1][a];
      PetscScalar     *v;

      PetscCall(VecCopy(state->u[a], u[a]));
      PetscCall(VecGetArray(u[a], &v));
      for (PetscInt i = 0; i < flow->particles->n_fluid; i++)
        v[i] -= all[i] - (k < 0 ? 0.0 : state->carried[k][a][i]);
      PetscCall(VecRestoreArray(u[a], &v));
    }
    PetscCall(MeasurePart(flow, (StepPart)(PART_SHIFT + k), u));
  }
  for (PetscInt a = 0; a < flow->scene->dim; a++) PetscCall(FlowRestoreWork(flow, &u[a]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Measures the velocity u_next + dt f after a part of the step. */
static PetscErrorCode BudgetPart(Flow *flow, StepPart part, PetscReal dt, const Vec f[])
{
  const FlowState *state = flow->state;
  Vec              u[ISPH_MAX_DIM];

  PetscFunctionBegin;
  if (part == PART_MOTION) {
    PetscCall(MeasureMotion(flow));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (!f) {
    PetscCall(MeasurePart(flow, part, state->u_next));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  state->budget->ratio = flow->clock->dt / dt;
  for (PetscInt a = 0; a < flow->scene->dim; a++) {
    PetscCall(FlowGetWork(flow, &u[a]));
    PetscCall(VecWAXPY(u[a], dt, f[a], state->u_next[a]));
  }
  PetscCall(MeasurePart(flow, part, u));
  for (PetscInt a = 0; a < flow->scene->dim; a++) PetscCall(FlowRestoreWork(flow, &u[a]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the energies of a part, which changed the velocities from `before` to `after`. */
static void AddEnergies(const Particles *p, StepPart part, const PetscReal before[],
                        const PetscReal after[], const PetscReal end[], Budget *budget)
{
  const PetscReal *begin    = budget->after[PART_MOTION];
  const PetscBool  implicit = budget->measured[PART_TIME] && part > PART_TIME && part < PART_MEAN;

  for (PetscInt i = 0; i < p->n_fluid; i++) {
    const PetscInt  box    = BoxOf(budget, p, i);
    const PetscReal weight = ParticlesWeight(p, i);
    PetscReal       middle = 0.0, last = 0.0;

    for (PetscInt k = i * p->dim; k < (i + 1) * p->dim; k++) {
      middle += 0.5 * weight * (after[k] - before[k]) * (begin[k] + end[k]);
      last += budget->ratio * weight * (after[k] - before[k]) * end[k];
    }
    budget->sums[part][box].energy += implicit ? last : middle;
    if (implicit) budget->sums[PART_TIME][box].energy += middle - last;
  }
}

/* Computes the energies of all parts from the velocities that they left. */
static PetscErrorCode BudgetEnd(Flow *flow)
{
  Budget  *budget = flow->state->budget;
  PetscInt last = STEP_PARTS - 1, before = PART_MOTION;

  PetscFunctionBegin;
  while (last > PART_NONE && !budget->measured[last]) last--;
  for (PetscInt part = PART_SHIFT; part <= last; part++) {
    if (!budget->measured[part]) continue;
    AddEnergies(flow->particles, (StepPart)part, budget->after[before], budget->after[part],
                budget->after[last], budget);
    before = part;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool HasBudget(const Flow *flow)
{
  return flow->state->budget ? PETSC_TRUE : PETSC_FALSE;
}

/* Kinetic energy and divergence after each part of a step, in boxes. */
const Observer ObserverBudget = {
    .Applies = HasBudget,
    .Begin   = BudgetBegin,
    .After   = BudgetPart,
    .End     = BudgetEnd,
    .Destroy = BudgetDestroy,
};

/*
  BudgetGet - Computes the budget of the last step: kinetic energy that a part added in a box, and
  divergence after the part

  Collective. Output: values - invalid if `measured` is false, which it is for parts that the step
  does not have.
*/
PetscErrorCode BudgetGet(const Flow *flow, StepPart part, PetscInt box, BudgetValues *values,
                         PetscBool *measured)
{
  const Scene  *scene  = flow->scene;
  const Budget *budget = flow->state->budget;
  const BoxSums own    = budget->sums[part][box];
  PetscReal     sum[3] = {own.weight, own.divergence2, own.energy};

  PetscFunctionBegin;
  *measured = budget->measured[part] && (part != PART_MOTION || SceneMoves(scene));
  if (!*measured) PetscFunctionReturn(PETSC_SUCCESS);
  values->divergence_max = own.most;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 3, MPIU_REAL, MPIU_SUM, PETSC_COMM_WORLD));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &values->divergence_max, 1, MPIU_REAL, MPIU_MAX,
                             PETSC_COMM_WORLD));
  values->share          = sum[0] / flow->particles->weight;
  values->divergence_rms = sum[0] > 0.0 ? PetscSqrtReal(sum[1] / sum[0]) : 0.0;
  values->energy         = scene->rho * SceneVolume(scene) * sum[2];
  PetscFunctionReturn(PETSC_SUCCESS);
}
