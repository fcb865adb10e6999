/*
  The projection scheme. One step, particles moving first so that all that follows is at t^{n+1}:

    x   += dr                                             ParticlesMove
    du/dt = nu lap u - (u-w).grad u - grad p^n/rho + f    -> u*          ViscositySolve
    lap phi = rho/k div u*                                               PressureSolve
    u    = u* - k/rho grad phi                                           VelocityCorrect
    p    = p^n + phi - mu div u*                                         PressureUpdate

  with k = 2dt/3 for the second-order default, a backward Euler step from (4u^n - u^{n-1})/3. w is
  the particles' velocity: u (Lagrangian) or 0 (Eulerian).
*/
#include "projection.h"

PetscErrorCode ProjectionCreate(const Scene *scene, const Clock *clock, Operators *ops,
                                Scheme *scheme)
{
  const char *const events[EVENT_COUNT] = {"ParticlesMove",  "NeighborsUpdate", "OperatorsAssem",
                                           "ViscositySolve", "PressureSolve",   "PressureUpdate",
                                           "CoupledSolve"};
  PetscClassId      class_id;
  Projection       *pr;

  PetscFunctionBegin;
  PetscCall(PetscNew(&pr));
  PetscCall(PetscClassIdRegister("Projection", &class_id));
  for (PetscInt k = 0; k < EVENT_COUNT; k++)
    PetscCall(PetscLogEventRegister(events[k], class_id, &pr->event[k]));
  pr->has_convection = scene->motion && !SceneMoves(scene) ? PETSC_TRUE : PETSC_FALSE;
  scheme->data       = pr;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Fields the scheme carries, and the case's initial values in them. */
PetscErrorCode ProjectionRegister(const Scene *scene, Particles *p, Scheme *scheme)
{
  Projection *pr   = (Projection *)scheme->data;
  PetscReal   most = 0.0; /* a pressure at the start balances the force */

  PetscFunctionBegin;
  PetscCall(ParticlesRegister(p, "u_previous", scene->dim, HALO_NONE, pr->u_previous));
  if (pr->has_convection)
    PetscCall(ParticlesRegister(p, "convection", scene->dim, HALO_NONE, pr->convection));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscReal x[ISPH_MAX_DIM], u[ISPH_MAX_DIM] = {0.0}, pressure = 0.0;

    for (PetscInt a = 0; a < scene->dim; a++) x[a] = p->x[a][i];
    if (p->velocity_given) {
      for (PetscInt a = 0; a < scene->dim; a++) u[a] = p->u[a][i];
    } else if (scene->problem->Velocity) {
      scene->problem->Velocity(scene, 0.0, x, u);
    }
    for (PetscInt a = 0; a < scene->dim; a++) {
      p->u[a][i] = pr->u_previous[a][i] = u[a];
    }
    if (p->p && scene->problem->Exact && !scene->velocity.n && !p->velocity_given)
      scene->problem->Exact(scene, 0.0, x, u, &pressure);
    if (p->p) p->p[i] = pressure;
    most = PetscMax(most, PetscAbsReal(pressure));
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPIU_REAL, MPIU_MAX, p->comm));
  scheme->number[NUMBER_BALANCE] = most > 0.0 ? 1.0 : 0.0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ProjectionFree(Projection *pr)
{
  PetscFunctionBegin;
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) {
    PetscCall(VecDestroy(&pr->u[a]));
    PetscCall(VecDestroy(&pr->u_prev[a]));
    PetscCall(VecDestroy(&pr->conv_prev[a]));
    PetscCall(VecDestroy(&pr->star[a]));
    PetscCall(VecDestroy(&pr->force[a]));
    PetscCall(VecDestroy(&pr->conv[a]));
    PetscCall(VecDestroy(&pr->rough[a]));
    for (PetscInt c = 0; c < ISPH_MAX_DIM; c++) PetscCall(VecDestroy(&pr->velocity_slope[c][a]));
  }
  PetscCall(VecDestroy(&pr->p));
  PetscCall(VecDestroy(&pr->p_before));
  PetscCall(VecDestroy(&pr->phi));
  PetscCall(VecDestroy(&pr->b));
  PetscCall(VecDestroy(&pr->div));
  PetscCall(VecDestroy(&pr->work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ProjectionDestroy(Scheme *scheme)
{
  PetscFunctionBegin;
  PetscCall(ProjectionFree((Projection *)scheme->data));
  PetscCall(PetscFree(scheme->data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Vectors over the particles as they are numbered now; nothing to do within an epoch. */
static PetscErrorCode ProjectionRenumber(const Scene *scene, const Particles *p, Scheme *scheme)
{
  Projection *pr = (Projection *)scheme->data;

  PetscFunctionBegin;
  if (pr->epoch == p->epoch) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ProjectionFree(pr));
  for (PetscInt a = 0; a < scene->dim; a++) {
    PetscCall(FluidVec(p, p->u[a], &pr->u[a]));
    PetscCall(FluidVec(p, pr->u_previous[a], &pr->u_prev[a]));
    PetscCall(FluidVec(p, NULL, &pr->star[a]));
    PetscCall(FluidVec(p, NULL, &pr->force[a]));
    if (pr->has_convection) PetscCall(FluidVec(p, pr->convection[a], &pr->conv_prev[a]));
    if (pr->has_convection) PetscCall(FluidVec(p, NULL, &pr->conv[a]));
  }
  PetscCall(FluidVec(p, NULL, &pr->work));
  if (p->p) {
    PetscCall(FluidVec(p, p->p, &pr->p));
    PetscCall(FluidVec(p, NULL, &pr->p_before));
    PetscCall(FluidVec(p, NULL, &pr->phi));
    PetscCall(FluidVec(p, NULL, &pr->b));
    PetscCall(FluidVec(p, NULL, &pr->div));
  }
  if (scheme->visc) PetscCall(ViscosityRenumber(p, scheme->visc));
  pr->epoch = p->epoch;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* n.grad p = rho n.(f - a) at own wall particle w, a the acceleration of the wall. */
static PetscReal WallPressureGradient(const Scene *scene, const Particles *p, PetscInt w,
                                      PetscReal t)
{
  const PetscInt i    = p->n_fluid + w;
  PetscReal      full = 0.0, x[ISPH_MAX_DIM], acceleration[ISPH_MAX_DIM], force[ISPH_MAX_DIM];

  ParticlesWallPoint(p, i, x);
  SceneWallAcceleration(scene, (PetscInt)p->side[i], t, x, acceleration);
  SceneBodyForce(scene, t, x, force);
  for (PetscInt a = 0; a < scene->dim; a++)
    full += scene->rho * (force[a] - acceleration[a]) * p->normal[a][i];
  return full;
}

/* Slopes that p^n has at time t, a share `had` of the full ones; a step adds nothing yet. */
static PetscErrorCode SetWallPressureGradient(const Scene *scene, const Particles *p, PetscReal t,
                                              PetscReal had, Operators *ops)
{
  PetscScalar *slope;

  PetscFunctionBegin;
  if (!ops->wall) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecGetArray(ops->wall_dpdn, &slope));
  for (PetscInt w = 0; w < p->n_wall; w++) slope[w] = had * WallPressureGradient(scene, p, w, t);
  PetscCall(VecRestoreArray(ops->wall_dpdn, &slope));
  PetscCall(VecZeroEntries(ops->wall_dpdn_step));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What the step to time t adds to them: what the full ones are then, less what p^n has. */
static PetscErrorCode SetWallPressureGradientStep(const Scene *scene, const Particles *p,
                                                  PetscReal t, Operators *ops)
{
  const PetscScalar *slope;
  PetscScalar       *step;

  PetscFunctionBegin;
  if (!ops->wall) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecGetArrayRead(ops->wall_dpdn, &slope));
  PetscCall(VecGetArray(ops->wall_dpdn_step, &step));
  for (PetscInt w = 0; w < p->n_wall; w++)
    step[w] = WallPressureGradient(scene, p, w, t) - slope[w];
  PetscCall(VecRestoreArrayRead(ops->wall_dpdn, &slope));
  PetscCall(VecRestoreArray(ops->wall_dpdn_step, &step));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The time whose slopes p has after a step of length dt that ends at t: that of the step's
   force. */
static PetscReal WallPressureGradientTime(const Scheme *scheme, PetscReal t, PetscReal dt)
{
  return !scheme->visc || ViscosityIntegrator(scheme->visc)->end_of_step ? t : t - 0.5 * dt;
}

/* Everything that follows from new positions: neighbours, matrices, vectors. */
static PetscErrorCode RebuildOperators(const Scene *scene, const Clock *clock, Particles *p,
                                       Neighbors *nb, Operators *ops, Scheme *scheme)
{
  Projection *pr = (Projection *)scheme->data;
  PetscBool   changed;

  PetscFunctionBegin;
  PetscCall(PetscLogEventBegin(pr->event[EVENT_NEIGHBORS], 0, 0, 0, 0));
  PetscCall(NeighborsUpdate(p, scheme->stats.speed_max * clock->dt, nb));
  PetscCall(PetscLogEventEnd(pr->event[EVENT_NEIGHBORS], 0, 0, 0, 0));
  PetscCall(PetscLogEventBegin(pr->event[EVENT_OPERATORS], 0, 0, 0, 0));
  PetscCall(OperatorsAssemble(scene, p, nb, ops, &changed));
  PetscCall(PetscLogEventEnd(pr->event[EVENT_OPERATORS], 0, 0, 0, 0));
  PetscCall(ProjectionRenumber(scene, p, scheme));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  ProjectionBegin - Readies everything for the flow as the particles carry it: at the start, after a
  restart, after a step was undone

  Collective. What a finished step leaves behind beside the particles' fields is made anew from
  them.
*/
PetscErrorCode ProjectionBegin(const Scene *scene, const Clock *clock, Particles *p, Neighbors *nb,
                               Operators *ops, Scheme *scheme)
{
  const Projection *pr = (const Projection *)scheme->data;

  PetscFunctionBegin;
  PetscCall(RebuildOperators(scene, clock, p, nb, ops, scheme));
  PetscCall(OperatorsSetWallVelocity(scene, p, clock->t, 0.0, ops));
  if (scheme->projection)
    PetscCall(SetWallPressureGradient(
        scene, p, WallPressureGradientTime(scheme, clock->t, clock->dt_previous),
        scheme->number[NUMBER_BALANCE], ops));
  if (!SceneIsNewtonian(scene)) PetscCall(OperatorsFollowStrain(scene, p, pr->u, ops));
  if (clock->step == 0) PetscCall(MeasureBegin(scene, p, ops, scheme));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Particles move, and ownership, neighbours and matrices follow. */
static PetscErrorCode MoveAndRebuild(const Scene *scene, const Clock *clock, Particles *p,
                                     Neighbors *nb, Operators *ops, Scheme *scheme)
{
  Projection *pr = (Projection *)scheme->data;
  PetscBool   started;

  PetscFunctionBegin;
  PetscCall(PetscLogEventBegin(pr->event[EVENT_MOVE], 0, 0, 0, 0));
  PetscCall(ParticlesMove(scene, clock, ops, p, scheme));
  PetscCall(PetscLogEventEnd(pr->event[EVENT_MOVE], 0, 0, 0, 0));
  if (scheme->failure.code) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscLogEventBegin(pr->event[EVENT_NEIGHBORS], 0, 0, 0, 0));
  PetscCall(ParticlesUpdateEpoch(scene, p, PETSC_FALSE, &started));
  if (!started) PetscCall(ParticlesUpdateHalo(p));
  PetscCall(PetscLogEventEnd(pr->event[EVENT_NEIGHBORS], 0, 0, 0, 0));
  PetscCall(RebuildOperators(scene, clock, p, nb, ops, scheme));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* u^{n+1} in u* and p^{n+1}, by the parts of a projection in turn; a failed one is the last. */
static PetscErrorCode SolveInTurn(const Scene *scene, const Clock *clock, Particles *p,
                                  Operators *ops, Scheme *scheme)
{
  Projection     *pr      = (Projection *)scheme->data;
  PetscReal      *balance = &scheme->number[NUMBER_BALANCE];
  const PetscReal before  = WallPressureGradientTime(scheme, clock->t, clock->dt_previous),
                  after   = WallPressureGradientTime(scheme, clock->t + clock->dt, clock->dt);

  PetscFunctionBegin;
  if (scheme->projection) {
    if (!scheme->projection->incremental) *balance = 0.0;
    PetscCall(SetWallPressureGradient(scene, p, before, *balance, ops));
    PetscCall(SetWallPressureGradientStep(scene, p, after, ops));
  }
  PetscCall(PetscLogEventBegin(pr->event[EVENT_VISCOSITY], 0, 0, 0, 0));
  PetscCall(PredictVelocity(scene, clock, p, ops, scheme));
  PetscCall(PetscLogEventEnd(pr->event[EVENT_VISCOSITY], 0, 0, 0, 0));
  if (scheme->failure.code) PetscFunctionReturn(PETSC_SUCCESS);
  if (scheme->projection) PetscCall(ProjectVelocity(scene, clock, p, ops, scheme));
  if (scheme->failure.code) PetscFunctionReturn(PETSC_SUCCESS);
  if (scheme->projection) {
    *balance += PressureGain(clock, scheme) * (1.0 - *balance);
    PetscCall(SetWallPressureGradient(scene, p, after, *balance, ops));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  FlowStep - One step of the clock's dt

  Collective. Where it fails, scheme->failure says how, time has not advanced and the fields are
  of no use.

  Input Parameter:
. Solve - leaves u^{n+1} in u* and p^{n+1} in p
*/
PetscErrorCode FlowStep(const Scene *scene, Clock *clock, Particles *p, Neighbors *nb,
                        Operators *ops, FlowSolve Solve, Scheme *scheme)
{
  Projection *pr = (Projection *)scheme->data;

  PetscFunctionBegin;
  scheme->failure.code = PETSC_SUCCESS;
  if (SceneMoves(scene)) PetscCall(MoveAndRebuild(scene, clock, p, nb, ops, scheme));
  if (!scheme->failure.code) PetscCall(Solve(scene, clock, p, ops, scheme));
  if (scheme->failure.code) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(OperatorsSetWallVelocity(scene, p, clock->t + clock->dt, 0.0, ops));
  PetscCall(StepMeasure(scene, clock, p, ops, scheme));
  if (scheme->failure.code) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt a = 0; a < scene->dim; a++) {
    PetscCall(VecCopy(pr->u[a], pr->u_prev[a]));
    PetscCall(VecCopy(pr->star[a], pr->u[a]));
  }
  PetscCall(ClockAdvance(clock));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ProjectionStep - One step: prediction, projection; see FlowStep() */
PetscErrorCode ProjectionStep(const Scene *scene, Clock *clock, Particles *p, Neighbors *nb,
                              Operators *ops, Scheme *scheme)
{
  PetscFunctionBegin;
  PetscCall(FlowStep(scene, clock, p, nb, ops, SolveInTurn, scheme));
  PetscFunctionReturn(PETSC_SUCCESS);
}
