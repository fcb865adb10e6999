/* The step of the weakly compressible scheme by an explicit PETSc TS. Its vector holds positions,
   velocities and, as far as they are unknowns, densities and energies of the own particles, one
   component after the other. Owners and numbers of particles are constant within a step. */
#include "wcsph.h"

/* Copies a vector of the TS to arrays. */
static PetscErrorCode CopyOut(const Wcsph *w, Vec y, PetscReal *const to[])
{
  const PetscInt     n = w->flow->particles->n_fluid;
  const PetscScalar *value;

  PetscFunctionBegin;
  PetscCall(VecGetArrayRead(y, &value));
  for (PetscInt c = 0; c < w->components; c++) PetscCall(PetscArraycpy(to[c], value + c * n, n));
  PetscCall(VecRestoreArrayRead(y, &value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Measures the largest displacement of a particle since the start of the step [dx]; infinite if a
   particle is nowhere. */
static PetscReal LargestMove(const Particles *p, const Wcsph *w)
{
  PetscReal most = 0.0;

  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscReal moved = 0.0;

    for (PetscInt a = 0; a < p->dim; a++) moved += PetscSqr(p->x[a][i] - w->start[a][i]);
    moved /= PetscSqr(p->dx[i]);
    most = moved <= PETSC_MAX_REAL ? PetscMax(most, moved) : PETSC_INFINITY;
  }
  return PetscSqrtReal(most);
}

/* Returns the smallest of some values over their value at rest; minus infinity if a value is not
   finite. NULL: no values. */
static PetscReal Smallest(PetscInt n, const PetscReal *value, PetscReal rest)
{
  PetscReal least = PETSC_INFINITY;

  for (PetscInt i = 0; value && i < n; i++)
    least = PetscAbsReal(value[i]) <= PETSC_MAX_REAL ? PetscMin(least, value[i] / rest)
                                                     : PETSC_NINFINITY;
  return least;
}

/* Fails the step if a particle has moved too far since its start, or is nowhere, or if a density or
   an internal energy is not positive. The square of the speed of sound is positive only if these
   are. Sums of the kernel always are. Input: rho, e - of own fluid, in the unknowns of the TS. */
static PetscErrorCode CheckUnknowns(Flow *flow, const Wcsph *w, const PetscReal *rho,
                                    const PetscReal *e)
{
  const Particles *p           = flow->particles;
  const char      *instability = "the flow is unstable at dt";
  PetscReal        worst[3]; /* largest, so that one reduction serves */
  char             where[CLOCK_WHERE];

  PetscFunctionBegin;
  worst[0] = LargestMove(p, w);
  worst[1] = -Smallest(p->n_fluid, w->density->sums ? NULL : rho, flow->scene->rho);
  worst[2] = -Smallest(p->n_fluid, w->equation->has_energy ? e : NULL, w->e_rest);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, worst, 3, MPIU_REAL, MPIU_MAX, p->comm));
  if (worst[0] <= WCSPH_MOVE_MOST && worst[1] < 0.0 && worst[2] < 0.0)
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ClockWhere(flow->clock, where));
  if (worst[0] > WCSPH_MOVE_MOST) {
    FailureSet(&flow->scheme->failure, PETSC_ERR_FP,
               "%s: a particle moved by %.3g dx, more than %.3g: %s = %.6g; try a smaller -dt or "
               "-acoustic_cfl",
               where, (double)worst[0], WCSPH_MOVE_MOST, instability, (double)flow->clock->dt);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  FailureSet(&flow->scheme->failure, PETSC_ERR_FP,
             "%s: %s of a particle is %.3g times that at rest, and should be positive: %s = %.6g; "
             "try a smaller -dt or -acoustic_cfl",
             where, worst[1] >= 0.0 ? "the density" : "the internal energy",
             -(double)(worst[1] >= 0.0 ? worst[1] : worst[2]), instability,
             (double)flow->clock->dt);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes dy/dt for the TS; zero once the step has failed. */
static PetscErrorCode RateFunction(TS ts, PetscReal t, Vec y, Vec rate, void *ctx)
{
  Wcsph     *w    = (Wcsph *)ctx;
  Flow      *flow = w->flow;
  Particles *p    = flow->particles;
  PetscReal *to[WCSPH_COMPONENTS];

  PetscFunctionBegin;
  PetscCall(VecZeroEntries(rate));
  if (flow->scheme->failure.code) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(WcsphReserve(flow, w));
  WcsphListUnknowns(w, p->x, w->local.u, w->local.rho, w->local.e, to);
  PetscCall(CopyOut(w, y, to));
  PetscCall(CheckUnknowns(flow, w, w->local.rho, w->local.e));
  if (flow->scheme->failure.code) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ParticlesUpdateHalo(p));
  PetscCall(NeighborsUpdate(p, flow->scheme->stats.speed_max * flow->clock->dt, flow->neighbors));
  w->t = t;
  PetscCall(VecGetArray(rate, &w->rate));
  PetscCall(WcsphRates(flow, w));
  PetscCall(VecRestoreArray(rate, &w->rate));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the predictor-corrector of the papers to PETSc's Runge-Kutta methods. */
static PetscErrorCode RegisterMidpoint(void)
{
  const PetscReal A[4] = {0.0, 0.0, 0.5, 0.0}, b[2] = {0.0, 1.0}, c[2] = {0.0, 0.5};

  PetscFunctionBegin;
  PetscCall(TSRKRegister("midpoint", 2, 2, A, b, c, NULL, 0, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* WcsphCreateIntegrator - Creates the TS; collective on PETSC_COMM_WORLD */
PetscErrorCode WcsphCreateIntegrator(Flow *flow, Wcsph *w)
{
  PetscBool given;

  PetscFunctionBegin;
  PetscCall(PetscOptionsHasName(NULL, "wcsph_", "-ts_type", &given));
  UserCheck(!given, "-wcsph_ts_type: -scheme wcsph has Runge-Kutta methods; use -wcsph_ts_rk_type");
  PetscCall(TimeOptionsRefuse("wcsph_", TSRK));
  PetscCall(RegisterMidpoint());
  PetscCall(TimeCreate("wcsph_", "flow", TSRK, PETSC_FALSE, &w->ts));
  PetscCall(TSRKSetType(w->ts, "3"));
  PetscCall(TSSetRHSFunction(w->ts, NULL, RateFunction, w));
  PetscCall(SolverViewTake("wcsph_", "-ts_view", &w->guard.ts_view));
  PetscCall(TSSetFromOptions(w->ts));
  PetscCall(TimeToleranceRefuse(w->ts, "wcsph_"));
  w->guard.solve.name = "compressible";
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the vector for the present numbering. */
static PetscErrorCode Renumber(Flow *flow, Wcsph *w)
{
  const Particles *p = flow->particles;

  PetscFunctionBegin;
  if (w->epoch == p->epoch) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecDestroy(&w->y));
  PetscCall(TSReset(w->ts));
  PetscCall(VecCreate(p->comm, &w->y));
  PetscCall(VecSetSizes(w->y, w->components * p->n_fluid, PETSC_DETERMINE));
  PetscCall(VecSetType(w->y, VECSTANDARD));
  w->epoch = p->epoch;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Copies the state of the particles to the vector. */
static PetscErrorCode CopyIn(Flow *flow, Wcsph *w)
{
  Particles   *p = flow->particles;
  PetscReal   *from[WCSPH_COMPONENTS];
  PetscScalar *value;

  PetscFunctionBegin;
  WcsphComponents(w, from);
  PetscCall(Renumber(flow, w));
  for (PetscInt a = 0; a < p->dim; a++) PetscCall(PetscArraycpy(w->start[a], p->x[a], p->n_fluid));
  PetscCall(VecGetArrayWrite(w->y, &value));
  for (PetscInt c = 0; c < w->components; c++)
    PetscCall(PetscArraycpy(value + c * p->n_fluid, from[c], p->n_fluid));
  PetscCall(VecRestoreArrayWrite(w->y, &value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* WcsphIntegrate - Advances positions, velocities, densities and energies by the clock's dt, and
   measures the largest body force. Collective. Output: positions, velocities, densities and
   energies of the particles. Sets scheme->failure if the step fails. */
PetscErrorCode WcsphIntegrate(Flow *flow)
{
  const Clock *clock = flow->clock;
  Wcsph       *w     = (Wcsph *)flow->scheme->data;
  PetscReal    dt    = clock->dt, *to[WCSPH_COMPONENTS];

  PetscFunctionBegin;
  if (SceneHas(flow->scene, PHYSICS_BODY_FORCE))
    PetscCall(AddBodyForce(flow, clock->t + clock->dt, NULL));
  PetscCall(ClockWhere(clock, w->guard.where));
  PetscCall(CopyIn(flow, w));
  w->first_stage = PETSC_TRUE;
  PetscCall(TSSetSolution(w->ts, w->y));
  PetscCall(TSRestartStep(w->ts));
  PetscCall(
      TimeStepThrough(w->ts, TSRK, &w->guard, clock->t, clock->dt, &dt, &flow->scheme->failure));
  if (flow->scheme->failure.code) PetscFunctionReturn(PETSC_SUCCESS);
  WcsphComponents(w, to);
  PetscCall(CopyOut(w, w->y, to));
  PetscCall(CheckUnknowns(flow, w, w->rho, w->e));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* WcsphFree - Shows the TS, if its option is given, and frees it with all arrays; collective */
PetscErrorCode WcsphFree(Wcsph *w)
{
  PetscFunctionBegin;
  if (w->ts) PetscCall(SolverViewShow((PetscObject)w->ts, &w->guard.ts_view));
  PetscCall(SolverViewEnd(&w->guard.ts_view));
  PetscCall(TSDestroy(&w->ts));
  PetscCall(VecDestroy(&w->y));
  PetscCall(PairsFree(&w->pairs));
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) {
    PetscCall(FreeAll(&w->start[a], &w->local.u[a]));
  }
  PetscCall(FreeAll(&w->shift, &w->local.rho, &w->local.p, &w->local.e));
  for (PetscInt e = 0; e < ISPH_MAX_DIM * ISPH_MAX_DIM; e++)
    PetscCall(PetscFree(w->local.stress[e]));
  PetscCall(FreeAll(&w->local.found, &w->local.divergence, &w->local.packed));
  PetscFunctionReturn(PETSC_SUCCESS);
}
