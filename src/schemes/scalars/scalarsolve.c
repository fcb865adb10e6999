/* The step of a scalar by PETSc's TS: V dc/dt = A c + B c_w + given + V s(c). */
#include "scalars.h"

#define RTOL  1e-9   /* of the solves of integrators that have no balance to close */
#define LOOSE 1e-6   /* of those of others */
#define TINY  1e-300 /* residual of a solve that has nothing to do */
#define NUDGE 1e-6   /* of the value, for the slope of a source */

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

/* Computes f = A c + share (what boundaries give). */
static PetscErrorCode Rates(Scalar *s, PetscReal share, Vec c, Vec f)
{
  const PetscScalar *own;
  PetscScalar       *to;

  PetscFunctionBegin;
  PetscCall(VecGetArrayRead(c, &own));
  PetscCall(ScalarRates(s->flow, own, share, s));
  PetscCall(VecRestoreArrayRead(c, &own));
  PetscCall(VecGetArrayWrite(f, &to));
  PetscCall(PetscArraycpy(to, s->rate, s->flow->particles->n_fluid));
  PetscCall(VecRestoreArrayWrite(f, &to));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes f = A c + B c_w + given + V s(c). */
static PetscErrorCode Rate(Scalar *s, PetscReal t, Vec c, Vec f)
{
  PetscFunctionBegin;
  PetscCall(Rates(s, 1.0, c, f));
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
  PetscCall(VecPointwiseMult(s->scratch, s->volume, rate));
  PetscCall(VecAYPX(f, -1.0, s->scratch));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes y = J x. */
static PetscErrorCode ShellMult(Mat J, Vec x, Vec y)
{
  Scalar *s;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(J, (void *)&s));
  PetscCall(Rates(s, 0.0, x, y));
  PetscCall(VecPointwiseMult(s->scratch, s->work, x));
  PetscCall(VecAYPX(y, -1.0, s->scratch));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ShellGetDiagonal(Mat J, Vec diagonal)
{
  PetscScalar *value;
  Scalar      *s;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(J, (void *)&s));
  PetscCall(VecZeroEntries(diagonal));
  PetscCall(VecGetArray(diagonal, &value));
  ScalarDiagonal(s->flow, s, value);
  PetscCall(VecRestoreArray(diagonal, &value));
  PetscCall(VecAYPX(diagonal, -1.0, s->work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes J from A and the diagonal in work. */
static PetscErrorCode SetMatrix(Scalar *s, Mat J)
{
  PetscFunctionBegin;
  PetscCall(MatCopy(s->A, J, SAME_NONZERO_PATTERN));
  PetscCall(MatScale(J, -1.0));
  PetscCall(MatDiagonalSet(J, s->work, ADD_VALUES));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates a matrix with the entries of a shell, for fallbacks. */
static PetscErrorCode Flatten(Mat J, Mat *flat)
{
  Scalar *s;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(J, (void *)&s));
  PetscCall(ScalarMatrix(s->flow, s));
  PetscCall(MatDuplicate(s->A, MAT_DO_NOT_COPY_VALUES, flat));
  PetscCall(SetMatrix(s, *flat));
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
  PetscCall(VecCopy(s->volume, s->work));
  PetscCall(VecScale(s->work, shift));
  if (s->is_nonlinear) {
    PetscCall(SetSource(s, t, c));
    PetscCall(VecAXPY(s->work, -1.0, s->slope));
  }
  if (!s->shell) PetscCall(SetMatrix(s, P));
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

/* ScalarCreateSolver - Creates the TS of a scalar and adds its solve to the scheme; collective */
PetscErrorCode ScalarCreateSolver(Flow *flow, Scalar *s)
{
  LinearSolve *solve = &s->guard.solve;
  const char  *type  = TSBEULER;
  char         typed[64];
  PetscBool    given, moves = SceneMoves(flow->scene);
  PetscReal    rtol;
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
  PetscCall(TimeCreate(s->prefix, s->given->name, s->row->name, !s->is_nonlinear, &s->ts));
  if (s->row->terms == TIME_EXPLICIT) {
    s->shell = PETSC_TRUE;
    PetscCall(TSSetRHSFunction(s->ts, NULL, Scalar_RHSFunction, s));
    PetscCall(TSSetFromOptions(s->ts));
    PetscCall(SchemeAddSolve(solve, flow->scheme));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(TSSetIFunction(s->ts, NULL, Scalar_IFunction, s));
  PetscCall(TSGetSNES(s->ts, &snes));
  PetscCall(SNESSetMaxLinearSolveFailures(snes, PETSC_INT_MAX)); /* the guard handles failures */
  rtol = s->row->history ? LOOSE : RTOL;
  PetscCall(SNESSetTolerances(snes, TINY, rtol, rtol, 50, PETSC_CURRENT));
  PetscCall(SNESGetKSP(snes, &solve->ksp));
  PetscCall(KSPSetType(solve->ksp, KSPGMRES));
  PetscCall(KSPSetTolerances(solve->ksp, rtol, 0.0, PETSC_CURRENT, 1000));
  PetscCall(KSPGetPC(solve->ksp, &pc));
  PetscCall(PCSetType(pc, moves ? PCJACOBI : PCBJACOBI));
  PetscCall(KspViewsTake(s->prefix, &s->guard.ksp_views));
  PetscCall(TSSetFromOptions(s->ts));
  PetscCall(TimeToleranceRefuse(s->ts, s->prefix));
  PetscCall(GuardAttach(solve->ksp, NULL, &s->guard));
  if (moves) PetscCall(GuardOnlyMultiplies(snes, PCJACOBI, &s->guard, &s->shell));
  if (s->shell) s->guard.Flatten = Flatten;
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
  for (Vec *v[] = {&s->volume, &s->source, &s->slope, &s->scratch, &s->work, &s->next, NULL},
           **k  = v;
       *k; k++)
    PetscCall(FluidVec(p, NULL, *k));
  PetscCall(VecGetArrayWrite(s->volume, &volume));
  PetscCall(PetscArraycpy(volume, ScalarVolumes(s->flow), p->n_fluid));
  PetscCall(VecRestoreArrayWrite(s->volume, &volume));
  s->numbered = p->epoch;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ScalarFreeVectors - Frees the vectors and the Jacobian; collective */
PetscErrorCode ScalarFreeVectors(Scalar *s)
{
  PetscFunctionBegin;
  PetscCall(VecDestroyAll(&s->volume, &s->source, &s->slope, &s->scratch, &s->work, &s->next));
  PetscCall(MatDestroy(&s->J));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Renews the Jacobian in the solver. */
static PetscErrorCode SetJacobian(Scalar *s)
{
  const Particles *p = s->flow->particles;

  PetscFunctionBegin;
  if (!s->guard.solve.ksp) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SolverRenewPC(s->guard.solve.ksp));
  if (!s->J && !s->shell) PetscCall(MatDuplicate(s->A, MAT_DO_NOT_COPY_VALUES, &s->J));
  if (!s->J) {
    PetscCall(MatCreateShell(p->comm, p->n_fluid, p->n_fluid, PETSC_DETERMINE, PETSC_DETERMINE, s,
                             &s->J));
    PetscCall(MatShellSetOperation(s->J, MATOP_MULT, (void (*)(void))ShellMult));
    PetscCall(MatShellSetOperation(s->J, MATOP_GET_DIAGONAL, (void (*)(void))ShellGetDiagonal));
  }
  PetscCall(TSSetIJacobian(s->ts, s->J, s->J, Scalar_IJacobian, s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds to the solution at time t the uniform value that closes the balance of the step: the sum of
   the residual that a solver leaves would be a source. Input: start - the amount at its start. */
static PetscErrorCode CloseBalance(Scalar *s, PetscReal t, PetscReal dt, PetscReal start)
{
  PetscReal gained, amount, change;
  Vec       one, rate;

  PetscFunctionBegin;
  if (PetscAbsReal(s->shift * dt - 1.0) > 1e-12) PetscFunctionReturn(PETSC_SUCCESS); /* substeps */
  PetscCall(VecDuplicate(s->next, &one));
  PetscCall(VecDuplicate(s->next, &rate));
  PetscCall(Rate(s, t, s->next, rate));
  PetscCall(VecSum(rate, &gained));
  PetscCall(VecDot(s->volume, s->next, &amount));
  PetscCall(VecSet(one, 1.0));
  PetscCall(MatMult(s->J, one, rate));
  PetscCall(VecSum(rate, &change));
  if (change > 0.0) PetscCall(VecShift(s->next, ((start - amount) / dt + gained) / change));
  PetscCall(VecDestroyAll(&one, &rate));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Fails a step in which the source has no finite value, or in which the change z of the scalar grows
  by itself e-fold or more,

    z^T (A + V ds/dc) z >= z^T V z/h

  Beside a steady state that attracts the left side is negative, for steps of any length. Before it
  is as large as the right side Newton's iteration ends; then half of it is enough.

  Collective. Expressions had finite values before the step.
*/
static PetscErrorCode Runaway(Flow *flow, Scalar *s)
{
  PetscBool    fails = ExpressionScopeForget(flow->scene->scope);
  PetscReal    grows, amount;
  PetscScalar *change;
  char         where[CLOCK_WHERE];
  Vec          z, Jz;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &fails, 1, MPIU_BOOL, MPI_LOR, flow->particles->comm));
  if (!fails && s->J && PetscIsNormalReal(s->shift)) {
    PetscCall(VecDuplicate(s->next, &z));
    PetscCall(VecDuplicate(s->next, &Jz));
    PetscCall(VecCopy(s->next, z));
    PetscCall(VecGetArray(z, &change));
    for (PetscInt i = 0; i < flow->particles->n_fluid; i++) change[i] -= s->c[i];
    PetscCall(VecRestoreArray(z, &change));
    PetscCall(MatMult(s->J, z, Jz));
    PetscCall(VecDot(z, Jz, &grows));
    PetscCall(VecPointwiseMult(Jz, s->volume, z));
    PetscCall(VecDot(z, Jz, &amount));
    PetscCall(VecDestroyAll(&z, &Jz));
    fails = grows < (flow->scheme->failure.code ? 0.5 : 0.0) * s->shift * amount;
  }
  if (!fails) PetscFunctionReturn(PETSC_SUCCESS);
  flow->scheme->failure.code = PETSC_SUCCESS;
  PetscCall(ClockWhere(flow->clock, where));
  FailureSet(
      &flow->scheme->failure, PETSC_ERR_NOT_CONVERGED,
      "%s: %s runs away: by %s it grows e-fold within the step, and without bound if it does "
      "so with a smaller -dt too; then the flow has no steady state",
      where, s->given->name, s->given->source.option);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ScalarSolve - Advances a scalar over the step of the clock. Collective. Sets scheme->failure if
   the TS diverges, or if no method reaches a small residual. Output: c and before, entering of the
   end of the step. */
PetscErrorCode ScalarSolve(Flow *flow, Scalar *s)
{
  const Particles *p  = flow->particles;
  const PetscReal  w  = s->row->history ? ClockRatio(flow->clock) : 0.0;
  const PetscReal  dt = flow->clock->dt * (1.0 + w) / (1.0 + 2.0 * w);
  PetscReal        h = dt, made = 0.0, start;
  const PetscReal  begin     = flow->clock->t + flow->clock->dt - dt;
  const PetscReal  weight[2] = {PetscSqr(1.0 + w) / (1.0 + 2.0 * w), -w * w / (1.0 + 2.0 * w)};
  PetscScalar     *next;

  PetscFunctionBegin;
  if (s->is_nonlinear) PetscCall(ExpressionScopeCheck(flow->scene->scope));
  PetscCall(ScalarAssemble(flow, s));
  PetscCall(Renumber(s));
  PetscCall(SetJacobian(s));
  PetscCall(ClockWhere(flow->clock, s->guard.where));
  PetscCall(VecGetArrayWrite(s->next, &next));
  for (PetscInt i = 0; i < p->n_fluid; i++)
    next[i] = weight[0] * s->c[i] + weight[1] * s->before[i];
  PetscCall(VecRestoreArrayWrite(s->next, &next));
  PetscCall(VecDot(s->volume, s->next, &start));
  s->guard.solve.iterations = 0;
  PetscCall(TSSetSolution(s->ts, s->next));
  PetscCall(TSRestartStep(s->ts));
  PetscCall(TimeStepThrough(s->ts, s->row->name, &s->guard, begin, dt, &h, &flow->scheme->failure));
  if (s->is_nonlinear) PetscCall(Runaway(flow, s));
  if (flow->scheme->failure.code) PetscFunctionReturn(PETSC_SUCCESS);
  if (s->row->history) PetscCall(CloseBalance(s, flow->clock->t + flow->clock->dt, dt, start));
  PetscCall(VecGetArray(s->next, &next));
  PetscCall(PetscArraycpy(s->before, s->c, p->n_fluid));
  PetscCall(PetscArraycpy(s->c, next, p->n_fluid));
  PetscCall(VecRestoreArray(s->next, &next));
  PetscCall(ScalarEntering(flow, s));
  if (s->given->source.n) {
    PetscCall(SetSource(s, flow->clock->t + flow->clock->dt, s->next));
    PetscCall(VecSum(s->source, &made));
  }
  PetscCall(ScalarBalanceStep(flow, weight, dt, made, s));
  PetscFunctionReturn(PETSC_SUCCESS);
}
