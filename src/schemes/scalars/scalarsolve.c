/* The step of a scalar by PETSc's TS: V dc/dt = A c + B c_w + given + V s(c). */
#include "scalars.h"

#define RTOL  1e-9 /* of the linear solves: of what boundaries give and the fluid gains */
#define NUDGE 1e-6 /* of the value, for the slope of a source */

/* Evaluates the source of own particles for values c of the scalar, and its slope ds/dc. */
static PetscErrorCode SetSource(Scalar *s, PetscReal t, Vec values)
{
  const Flow        *flow   = s->flow;
  const Scalars     *all    = flow->state->scalars;
  const Particles   *p      = flow->particles;
  const Expression  *given  = &s->given->source;
  const PetscReal   *volume = ScalarVolumes(flow);
  const PetscScalar *own;
  PetscScalar       *source, *slope;

  PetscFunctionBegin;
  PetscCall(VecGetArrayRead(values, &own));
  PetscCall(VecGetArray(s->source, &source));
  PetscCall(VecGetArray(s->slope, &slope));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    const PetscReal g = all->g ? all->g[i] : 0.0, h = NUDGE * (1.0 + PetscAbsReal(own[i]));
    const PetscInt  c               = ScalarFluid(given, p->fluid ? (PetscInt)p->fluid[i] : 0);
    PetscReal       x[ISPH_MAX_DIM] = {0.0}, field[SCALARS_MOST] = {0.0};
    PetscReal      *mine = &field[s - all->scalar];

    for (PetscInt a = 0; a < p->dim; a++) x[a] = p->x[a][i];
    for (PetscInt k = 0; k < all->n; k++) field[k] = all->scalar[k].all[i];
    *mine     = own[i];
    source[i] = volume[i] * ExpressionOf(given, c, t, x, field, g);
    if (!s->is_nonlinear) continue;
    *mine    = own[i] + h;
    slope[i] = (volume[i] * ExpressionOf(given, c, t, x, field, g) - source[i]) / h;
  }
  PetscCall(VecRestoreArray(s->slope, &slope));
  PetscCall(VecRestoreArray(s->source, &source));
  PetscCall(VecRestoreArrayRead(values, &own));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes f = A c + B c_w + given + V s(c). */
static PetscErrorCode Rate(Scalar *s, PetscReal t, Vec c, Vec f)
{
  PetscFunctionBegin;
  PetscCall(MatMult(s->A, c, f));
  PetscCall(VecAXPY(f, 1.0, s->constant));
  if (!s->given->source.n) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SetSource(s, t, c));
  PetscCall(VecAXPY(f, 1.0, s->source));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Scalar_IFunction(TS ts, PetscReal t, Vec c, Vec rate, Vec f, void *ctx)
{
  Scalar *s = (Scalar *)ctx;

  PetscFunctionBegin;
  (void)ts;
  PetscCall(Rate(s, t, c, f));
  PetscCall(VecPointwiseMult(s->work, s->volume, rate));
  PetscCall(VecAYPX(f, -1.0, s->work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes J = shift V - A - V ds/dc. */
static PetscErrorCode Scalar_IJacobian(TS ts, PetscReal t, Vec c, Vec rate, PetscReal shift, Mat J,
                                       Mat P, void *ctx)
{
  Scalar *s = (Scalar *)ctx;

  PetscFunctionBegin;
  (void)ts;
  (void)rate;
  if (J != P) {
    PetscCall(MatAssemblyBegin(J, MAT_FINAL_ASSEMBLY));
    PetscCall(MatAssemblyEnd(J, MAT_FINAL_ASSEMBLY));
  }
  if (shift == s->shift && !s->is_nonlinear) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MatCopy(s->A, P, SAME_NONZERO_PATTERN));
  PetscCall(MatScale(P, -1.0));
  PetscCall(VecCopy(s->volume, s->work));
  PetscCall(VecScale(s->work, shift));
  if (s->is_nonlinear) {
    PetscCall(SetSource(s, t, c));
    PetscCall(VecAXPY(s->work, -1.0, s->slope));
  }
  PetscCall(MatDiagonalSet(P, s->work, ADD_VALUES));
  s->shift = shift;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Scalar_RHSFunction(TS ts, PetscReal t, Vec c, Vec f, void *ctx)
{
  Scalar *s = (Scalar *)ctx;

  PetscFunctionBegin;
  (void)ts;
  PetscCall(Rate(s, t, c, f));
  PetscCall(VecPointwiseDivide(f, f, s->volume));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  ScalarCreateSolver - Creates the TS of a scalar and adds its solve to the scheme

  Collective.

  Options Database Keys:
. -scalar_<k>_ts_type, -scalar_<k>_ksp_type, ... - PETSc's options of TS, SNES, KSP and PC
*/
PetscErrorCode ScalarCreateSolver(Flow *flow, Scalar *s)
{
  LinearSolve *solve = &s->guard.solve;
  const char  *type  = TSBEULER;
  char         typed[64];
  PetscBool    given;
  TSAdapt      adapt;
  SNES         snes;
  PC           pc;

  PetscFunctionBegin;
  s->flow       = flow;
  solve->name   = s->given->name;
  solve->label  = s->label;
  solve->prefix = s->prefix;
  solve->column = SOLVE_SCALAR;
  PetscCall(PetscOptionsGetString(NULL, s->prefix, "-ts_type", typed, sizeof(typed), &given));
  PetscCall(TableWant(&ViscousIntegratorTable, s->option, given ? typed : type, &s->row));
  PetscCall(TimeOptionsRefuse(s->prefix, s->row->name));
  solve->integrator = s->row->name;
  PetscCall(TSCreate(PETSC_COMM_WORLD, &s->ts));
  PetscCall(TSSetOptionsPrefix(s->ts, s->prefix));
  PetscCall(PetscObjectSetName((PetscObject)s->ts, s->given->name));
  PetscCall(TSSetProblemType(s->ts, s->is_nonlinear ? TS_NONLINEAR : TS_LINEAR));
  PetscCall(TSSetType(s->ts, s->row->name));
  PetscCall(TSSetExactFinalTime(s->ts, TS_EXACTFINALTIME_STEPOVER));
  PetscCall(TSSetMaxSteps(s->ts, PETSC_INT_MAX - 1));
  PetscCall(TSSetMaxTime(s->ts, PETSC_MAX_REAL));
  PetscCall(TSSetErrorIfStepFails(s->ts, PETSC_FALSE));
  PetscCall(TSGetAdapt(s->ts, &adapt));
  PetscCall(TSAdaptSetType(adapt, TSADAPTNONE));
  if (s->row->terms == TIME_EXPLICIT) {
    PetscCall(TSSetRHSFunction(s->ts, NULL, Scalar_RHSFunction, s));
    PetscCall(TSSetFromOptions(s->ts));
    PetscCall(SchemeAddSolve(solve, flow->scheme));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(TSSetIFunction(s->ts, NULL, Scalar_IFunction, s));
  PetscCall(TSGetSNES(s->ts, &snes));
  PetscCall(SNESSetMaxLinearSolveFailures(snes, PETSC_INT_MAX)); /* the guard handles failures */
  PetscCall(SNESSetTolerances(snes, 0.0, RTOL, RTOL, 50, PETSC_CURRENT));
  PetscCall(SNESGetKSP(snes, &solve->ksp));
  PetscCall(KSPSetType(solve->ksp, KSPGMRES));
  PetscCall(KSPSetTolerances(solve->ksp, RTOL, 0.0, PETSC_CURRENT, 1000));
  PetscCall(KSPGetPC(solve->ksp, &pc));
  PetscCall(PCSetType(pc, PCBJACOBI));
  PetscCall(KspViewsTake(s->prefix, &s->guard.ksp_views));
  PetscCall(SolverMatType(s->prefix, s->guard.mat_type, sizeof(s->guard.mat_type)));
  PetscCall(TSSetFromOptions(s->ts));
  PetscCall(TimeToleranceRefuse(s->ts, s->prefix));
  PetscCall(GuardAttach(solve->ksp, NULL, &s->guard));
  PetscCall(SchemeAddSolve(solve, flow->scheme));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the vectors for the present numbering. */
static PetscErrorCode Renumber(Scalar *s)
{
  const Particles *p = s->flow->particles;
  PetscScalar     *volume;

  PetscFunctionBegin;
  if (s->numbered == p->epoch && s->volume) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ScalarFreeVectors(s));
  PetscCall(TSReset(s->ts));
  for (Vec *v[] = {&s->volume, &s->source, &s->slope, &s->constant, &s->work, &s->next, NULL},
           **k  = v;
       *k; k++)
    PetscCall(FluidVec(p, NULL, *k));
  PetscCall(VecGetArrayWrite(s->volume, &volume));
  PetscCall(PetscArraycpy(volume, ScalarVolumes(s->flow), p->n_fluid));
  PetscCall(VecRestoreArrayWrite(s->volume, &volume));
  s->numbered = p->epoch;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ScalarFreeVectors - Frees the vectors; collective */
PetscErrorCode ScalarFreeVectors(Scalar *s)
{
  PetscFunctionBegin;
  PetscCall(VecDestroy(&s->volume));
  PetscCall(VecDestroy(&s->source));
  PetscCall(VecDestroy(&s->slope));
  PetscCall(VecDestroy(&s->constant));
  PetscCall(VecDestroy(&s->work));
  PetscCall(VecDestroy(&s->next));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes constant = B c_w + given - mean (A 1 + B 1): convection of the difference from the mean,
   so that a uniform value stays one where the divergence of the cells is not quite zero. */
static PetscErrorCode SetConstant(Scalar *s)
{
  const Particles *p = s->flow->particles;
  PetscScalar     *to;
  PetscReal        mean = 0.0;

  PetscFunctionBegin;
  if (s->flow->state->scalars->flow) {
    PetscReal amount[2];

    PetscCall(ScalarAmount(s->flow, s->c, amount));
    mean = amount[0] / amount[1];
  }
  PetscCall(VecGetArrayWrite(s->constant, &to));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    const Pattern *walls = &s->columns[1];

    to[i] = s->given_rate[i] - mean * s->one[i];
    for (PetscInt k = walls->row[i]; k < walls->row[i + 1]; k++)
      to[i] += s->entry[1][k] * s->all[walls->local[k]];
  }
  PetscCall(VecRestoreArrayWrite(s->constant, &to));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Renews the Jacobian in the solver. */
static PetscErrorCode SetJacobian(Scalar *s)
{
  PetscFunctionBegin;
  if (!s->guard.solve.ksp) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SolverRenewPC(s->guard.solve.ksp));
  PetscCall(TSSetIJacobian(s->ts, s->J, s->J, Scalar_IJacobian, s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  ScalarSolve - Advances a scalar over the step of the clock

  Collective. Sets scheme->failure if the TS diverges, or if no method reaches a small residual.
  Output: c and before, entering of the end of the step.
*/
PetscErrorCode ScalarSolve(Flow *flow, Scalar *s)
{
  const Particles *p  = flow->particles;
  const PetscReal  w  = s->row->history ? ClockRatio(flow->clock) : 0.0;
  const PetscReal  dt = flow->clock->dt * (1.0 + w) / (1.0 + 2.0 * w);
  PetscReal        h = dt, made = 0.0;
  const PetscReal  begin     = flow->clock->t + flow->clock->dt - dt;
  const PetscReal  weight[2] = {PetscSqr(1.0 + w) / (1.0 + 2.0 * w), -w * w / (1.0 + 2.0 * w)};
  PetscScalar     *next;

  PetscFunctionBegin;
  PetscCall(ScalarAssemble(flow, s));
  PetscCall(Renumber(s));
  PetscCall(ScalarValues(flow, s->c, s));
  PetscCall(SetConstant(s));
  PetscCall(SetJacobian(s));
  PetscCall(ClockWhere(flow->clock, s->guard.where));
  PetscCall(VecGetArrayWrite(s->next, &next));
  for (PetscInt i = 0; i < p->n_fluid; i++)
    next[i] = weight[0] * s->c[i] + weight[1] * s->before[i];
  PetscCall(VecRestoreArrayWrite(s->next, &next));
  s->guard.solve.iterations = 0;
  PetscCall(TSSetSolution(s->ts, s->next));
  PetscCall(TSRestartStep(s->ts));
  PetscCall(TimeStepThrough(s->ts, s->row->name, &s->guard, begin, dt, &h, &flow->scheme->failure));
  PetscCall(VecGetArray(s->next, &next));
  PetscCall(PetscArraycpy(s->before, s->c, p->n_fluid));
  PetscCall(PetscArraycpy(s->c, next, p->n_fluid));
  PetscCall(VecRestoreArray(s->next, &next));
  PetscCall(ScalarValues(flow, s->c, s));
  PetscCall(ScalarEntering(flow, s));
  if (s->given->source.n) {
    PetscCall(SetSource(s, flow->clock->t + flow->clock->dt, s->next));
    PetscCall(VecSum(s->source, &made));
  }
  PetscCall(ScalarBalanceStep(flow, weight, dt, made, s));
  PetscFunctionReturn(PETSC_SUCCESS);
}
