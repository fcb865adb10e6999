/* The coupled step: a solve for velocity and pressure together, either in time or steady, with
   iterations for steady convection and for viscosities that follow the strain rate. A step without
   earlier velocities has two stages, so that it is of order 2 as the steps after it. A step in
   which the velocity jumps is solved again with a larger share of order 1 (velocityjump.c).
   Velocities given at the start are made free of divergence. */
#include "coupled.h"

#define PICARD_MOST 50 /* largest number of iterations of steady convection or a rheology */
/* Change of u in the last iteration, relative to |u|, or to |u| + U in time. */
#define PICARD_CHANGE 1e-6
#define PICARD_SHARE  1e-2  /* of the residual that a solve of steady convection leaves */
#define PICARD_RTOL   1e-10 /* least tolerance of such a solve, unless a smaller one is given */
#define TELL_EVERY    2.0   /* seconds from which on a steady solve tells what it does */
#define STAGE_RATIO   (1.0 + PETSC_SQRT2) /* (1 - g)/g of the stages, g = 1 - 1/sqrt(2) */

/* Returns the pressure among the unknowns: that of the splines, or of the particles. */
static Vec Pressure(const Flow *flow)
{
  return flow->scheme->splines ? flow->scheme->splines->all : flow->state->p;
}

/* Solves the linear system, or that of the next iteration for a rheology, starting from the present
   unknowns. */
static PetscErrorCode SolveLinear(Vec b, Coupled *c, StepFailure *failure)
{
  Mat J;
  Vec rhs;

  PetscFunctionBegin;
  PetscCall(CoupledJacobian(c, b, &J, &rhs));
  PetscCall(KSPSetOperators(c->guard.solve.ksp, J, c->flat ? c->flat : c->saddle.P));
  PetscCall(KSPSetInitialGuessNonzero(c->guard.solve.ksp, PETSC_TRUE));
  PetscCall(GuardSolve(&c->guard, rhs, c->x));
  PetscCall(KSPSetInitialGuessNonzero(c->guard.solve.ksp, PETSC_FALSE));
  PetscCall(GuardCheck(&c->guard, failure));
  c->guard.solve.iterations += c->guard.iterations;
  PetscCall(VecDestroy(&rhs));
  PetscCall(MatDestroy(&J));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints an iteration of a steady flow, if it has taken long, and ends the flow if a signal asks
   for it. Input: change - of u in the iteration, relative; since - time before it, wall clock
   [s]. */
static PetscErrorCode AfterSolve(PetscInt k, PetscReal change, PetscLogDouble since, Coupled *c,
                                 StepFailure *failure)
{
  PetscLogDouble now;
  PetscMPIInt    signal;

  PetscFunctionBegin;
  PetscCall(PetscTime(&now));
  PetscCall(InterruptCheck(&signal));
  if (now - since > TELL_EVERY)
    PetscCall(SayLine("steady flow, iteration %" PetscInt_FMT ": u changes by %.1e (relative), "
                      "solved to the residual %.1e in %.0f s",
                      k, (double)change, (double)c->guard.residual, (double)(now - since)));
  if (!signal || failure->code) PetscFunctionReturn(PETSC_SUCCESS);
  FailureSet(failure, ERROR_INTERRUPTED(signal),
             "interrupted by %s in iteration %" PetscInt_FMT
             " of the steady flow, in which u still "
             "changed by %.1e (relative)",
             InterruptName(signal), k, (double)change);
  failure->fatal = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Solves the linear system of an iteration for steady convection, whose matrix the next iteration
   changes: to a share of the residual of the present unknowns. A tolerance relative to b would be
   too tight at first, and at last too loose for the change of u that ends the iteration. Output:
   tight - the tolerance was at most that of the solver. */
static PetscErrorCode SolvePicard(Vec b, Coupled *c, StepFailure *failure, PetscBool *tight)
{
  const KSP ksp = c->guard.solve.ksp;
  PetscReal rtol, share, norm_b, norm_r;
  PetscInt  most;
  Vec       r;

  PetscFunctionBegin;
  PetscCall(KSPGetTolerances(ksp, &rtol, NULL, NULL, &most));
  PetscCall(VecDuplicate(b, &r));
  PetscCall(MatMult(c->saddle.A, c->x, r));
  PetscCall(VecAYPX(r, -1.0, b));
  PetscCall(VecNorm(r, NORM_2, &norm_r));
  PetscCall(VecNorm(b, NORM_2, &norm_b));
  PetscCall(VecDestroy(&r));
  share  = norm_b > 0.0 ? PetscMin(PICARD_SHARE * norm_r / norm_b, PICARD_SHARE) : rtol;
  share  = PetscMax(share, PetscMin(rtol, PICARD_RTOL));
  *tight = share <= rtol;
  PetscCall(KSPSetTolerances(ksp, share, PETSC_CURRENT, PETSC_CURRENT, most));
  PetscCall(SolveLinear(b, c, failure));
  PetscCall(KSPSetTolerances(ksp, rtol, PETSC_CURRENT, PETSC_CURRENT, most));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Solves the linear system for the change of the present unknowns, to a share of their residual. */
static PetscErrorCode SolveChange(Vec b, Coupled *c, StepFailure *failure)
{
  Vec r, change;

  PetscFunctionBegin;
  PetscCall(VecDuplicate(b, &r));
  PetscCall(VecDuplicate(b, &change));
  PetscCall(MatMult(c->saddle.A, c->x, r));
  PetscCall(VecAYPX(r, -1.0, b));
  PetscCall(KSPSetOperators(c->guard.solve.ksp, c->saddle.A, c->flat ? c->flat : c->saddle.P));
  PetscCall(GuardSolve(&c->guard, r, change));
  PetscCall(VecAXPY(c->x, 1.0, change));
  PetscCall(GuardCheck(&c->guard, failure));
  c->guard.solve.iterations += c->guard.iterations;
  PetscCall(VecDestroyAll(&change, &r));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes a backward Euler step to c->end over h from the velocity `start`, with the present unknowns
   as guess. */
static PetscErrorCode StepEuler(PetscReal h, const Vec start[], Coupled *c, StepFailure *failure)
{
  PetscFunctionBegin;
  PetscCall(CoupledSetShift(1.0 / h, c));
  PetscCall(CoupledRightHandSide(c, c->end));
  for (PetscInt a = 0; a < c->saddle.dim; a++)
    PetscCall(SaddleAdd(&c->saddle, a, c->saddle.step / h, start[a], c->b));
  if (c->tangent) PetscCall(SolveLinear(c->b, c, failure));
  else PetscCall(SolveChange(c->b, c, failure));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes |u - v|/(|u| + U) over all components, with the root mean square |u|. Input: speed - U
   [m/s]. */
static PetscErrorCode RelativeChange(PetscInt dim, PetscReal speed, const Vec u[], const Vec v[],
                                     Vec work, PetscReal *change)
{
  PetscReal sum = 0.0, all = 0.0, part;
  PetscInt  n;

  PetscFunctionBegin;
  PetscCall(VecGetSize(work, &n));
  for (PetscInt a = 0; a < dim; a++) {
    PetscCall(VecWAXPY(work, -1.0, v[a], u[a]));
    PetscCall(VecNorm(work, NORM_2, &part));
    sum += PetscSqr(part) / n;
    PetscCall(VecNorm(u[a], NORM_2, &part));
    all += PetscSqr(part) / n;
  }
  all     = PetscSqrtReal(all) + speed;
  *change = all > 0.0 ? PetscSqrtReal(sum) / all : 0.0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Fails a step whose iteration did not converge. */
static void FailIteration(const Flow *flow, PetscReal change, const Coupled *c,
                          StepFailure *failure)
{
  if (SceneIsNewtonian(flow->scene)) {
    FailureSet(failure, PETSC_ERR_NOT_CONVERGED,
               "-steady: u still changes by %.1e (relative) after %d Picard iterations; the flow "
               "at this Reynolds number must be advanced in time (no -steady)",
               (double)change, PICARD_MOST);
    return;
  }
  FailureSet(failure, PETSC_ERR_NOT_CONVERGED,
             "%s: viscosity and velocity did not converge: u still changes by %.1e (relative) "
             "after %d iterations, stresses are off by %.1e; try a smaller -dt, -scheme "
             "projection, or -rheology_viscosity_min and -rheology_viscosity_max closer together",
             c->guard.where, (double)change, PICARD_MOST, (double)c->tangent->error);
}

/* Linearises the stresses of a rheology about the velocity v, with wall velocities at the end of
   the step. */
static PetscErrorCode Linearise(Flow *flow, const Vec v[], Coupled *c)
{
  PetscFunctionBegin;
  if (!c->tangent) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(WallValuesSetVelocity(flow->scene, flow->particles, c->end, 0.0, &flow->walls));
  PetscCall(TangentFollow(c->tangent, v, &flow->walls));
  c->saddle.assemblies = -1;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Extracts the velocity u after a solve, and shortens its change from v if that goes far beyond the
   solution, see TangentShare(). */
static PetscErrorCode TakeVelocity(Flow *flow, Vec u[], const Vec v[], Coupled *c)
{
  PetscReal share = 1.0;

  PetscFunctionBegin;
  PetscCall(SaddleGet(&c->saddle, c->x, u, NULL));
  if (c->tangent) PetscCall(TangentShare(c->tangent, u, &flow->walls, &share));
  if (share == 1.0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SaddleGet(&c->saddle, c->x, u, Pressure(flow)));
  for (PetscInt a = 0; a < c->saddle.dim; a++) PetscCall(VecAXPBY(u[a], 1.0 - share, share, v[a]));
  PetscCall(SaddlePut(&c->saddle, u, Pressure(flow), c->x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Iterates for steady convection (v.grad) u, for viscosities nu(v) of a rheology, or for both. In
   each iteration v is the velocity u of the iteration before. The last iteration changes u by at
   most the share PICARD_CHANGE, and stresses differ from those of u by at most STRESS_ERROR. Input:
   start - velocity at the start of the step of length dt; NULL: steady. Output: u. Reference: H. C.
   Elman, D. J. Silvester, A. J. Wathen, Finite Elements and Fast Iterative Solvers (2014), ch.
   8. */
static PetscErrorCode Iterate(Flow *flow, PetscReal dt, const Vec start[], Vec u[], Vec v[],
                              Coupled *c, StepFailure *failure)
{
  const Scene    *scene    = flow->scene;
  const PetscBool convects = !start && flow->state->has_convection;
  Vec             past[ISPH_MAX_DIM];
  Vec             pressure = Pressure(flow);
  PetscReal       change   = PETSC_INFINITY;
  PetscBool       tight = PETSC_TRUE, done = PETSC_FALSE;
  PetscLogDouble  since;

  PetscFunctionBegin;
  if (!SceneIsNewtonian(scene))
    PetscCall(TangentCreate(scene, flow->particles, flow->ops, &c->tangent));
  for (PetscInt a = 0; a < scene->dim && convects; a++) PetscCall(FlowGetWork(flow, &past[a]));
  PetscCall(SaddleGet(&c->saddle, c->x, v, pressure));
  PetscCall(Linearise(flow, v, c));
  for (PetscInt k = 0; k < PICARD_MOST && !done && !failure->code; k++) {
    PetscCall(PetscTime(&since));
    for (PetscInt a = 0; a < scene->dim && convects; a++) PetscCall(VecCopy(v[a], past[a]));
    if (convects) PetscCall(ConvectionPass(flow, flow->clock->t, past));
    PetscCall(CoupledAssemble(start ? 1.0 / dt : 0.0, convects ? past : NULL, c));
    PetscCall(SaddlePut(&c->saddle, v, pressure, c->x));
    if (start) {
      PetscCall(StepEuler(dt, start, c, failure));
    } else {
      PetscCall(CoupledRightHandSide(c, c->end));
      if (c->tangent) PetscCall(SolveLinear(c->b, c, failure));
      else PetscCall(SolvePicard(c->b, c, failure, &tight));
    }
    PetscCall(TakeVelocity(flow, u, v, c));
    PetscCall(RelativeChange(c->saddle.dim, start ? scene->speed : 0.0, u, v, c->part, &change));
    PetscCall(SaddleGet(&c->saddle, c->x, v, pressure));
    PetscCall(Linearise(flow, v, c));
    done = change <= PICARD_CHANGE && tight && (!c->tangent || c->tangent->error <= STRESS_ERROR);
    if (!start && !done) PetscCall(AfterSolve(k + 1, change, since, c, failure));
  }
  if (!done && !failure->code) FailIteration(flow, change, c, failure);
  PetscCall(TangentDestroy(&c->tangent));
  for (PetscInt a = 0; a < scene->dim && convects; a++) PetscCall(FlowRestoreWork(flow, &past[a]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the pressure of particles from the unknowns, and removes an undetermined constant. */
static PetscErrorCode SpreadPressure(Flow *flow)
{
  Splines *sp = flow->scheme->splines;

  PetscFunctionBegin;
  if (sp) {
    PetscCall(SplineSurfaceFill(sp, sp->all));
    PetscCall(SplinesShareOut(sp));
    PetscCall(SplinesSetJumps(flow, flow->state->u_next, sp));
    PetscCall(SplinesSpread(flow, sp));
  } else PetscCall(GaugeRemove(flow->scene, flow->particles, flow->state->p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Solves for u_next and p at c->end. On entry u_next is the velocity at the start of the step of
   length dt, and p an estimate of the pressure. */
static PetscErrorCode SolveSystem(Flow *flow, PetscReal dt, Coupled *c)
{
  const Clock    *clock   = flow->clock;
  FlowState      *s       = flow->state;
  Splines        *sp      = flow->scheme->splines;
  StepFailure    *failure = &flow->scheme->failure;
  const PetscBool steady = clock->steady_solve, newtonian = SceneIsNewtonian(flow->scene);
  const PetscBool iterates = !newtonian || (steady && flow->state->has_convection);
  Vec             u[ISPH_MAX_DIM], v[ISPH_MAX_DIM];
  PetscLogDouble  since;

  PetscFunctionBegin;
  PetscCall(PetscTime(&since));
  PetscCall(ClockWhere(clock, c->guard.where));
  PetscCall(CoupledAssemble(steady ? 0.0 : 1.0 / dt, NULL, c));
  if (sp) PetscCall(SplineLayerSet(sp, flow->scene->level, sp->all));
  PetscCall(SaddlePut(&c->saddle, s->u_next, Pressure(flow), c->x));
  if (!steady && newtonian) {
    PetscCall(StepEuler(dt, s->u_next, c, failure));
  } else if (steady) {
    PetscCall(CoupledRightHandSide(c, c->end));
    PetscCall(SolveLinear(c->b, c, failure));
    if (iterates) PetscCall(AfterSolve(0, 1.0, since, c, failure));
  }
  for (PetscInt a = 0; a < flow->scene->dim && iterates; a++) {
    PetscCall(FlowGetWork(flow, &u[a]));
    PetscCall(FlowGetWork(flow, &v[a]));
  }
  if (iterates) {
    PetscCall(Iterate(flow, dt, steady ? NULL : s->u_next, u, v, c, failure));
    c->advecting         = NULL;
    c->saddle.assemblies = -1; /* forces an assembly without convection */
  }
  for (PetscInt a = 0; a < flow->scene->dim && iterates; a++) {
    PetscCall(FlowRestoreWork(flow, &v[a]));
    PetscCall(FlowRestoreWork(flow, &u[a]));
  }
  PetscCall(SaddleGet(&c->saddle, c->x, s->u_next, Pressure(flow)));
  PetscCall(SpreadPressure(flow));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Makes a step without earlier velocities by two stages, backward Euler steps of the same length k =
  g dt, g = 1 - 1/sqrt(2)

    u_1     = u^n + k f(u_1)                                at t + k
    u^{n+1} = u^n + (1 - g)/g (u_1 - u^n) + k f(u^{n+1})    at t + dt

  The method is L-stable and of order 2, and both stages have the same matrix. Moving particles have
  their new positions in both. As those belong to the end of the step, the pressure that turns the
  paths is 1/g times too large in the first stage, and (2 - 1/g)/g = -4.8 times the true one in the
  second. Their pressure is therefore that of the whole step, (1 - g) p_1 + g p_2.

  References: R. Alexander, SIAM J. Numer. Anal. 14 (1977) 1006-1021; with convection U. M. Ascher,
  S. J. Ruuth, R. J. Spiteri, Appl. Numer. Math. 25 (1997) 151-167
*/
static PetscErrorCode StepFirst(Flow *flow, Coupled *c)
{
  FlowState      *s     = flow->state;
  const PetscBool moves = SceneMoves(flow->scene);
  const PetscReal k     = flow->clock->dt / (1.0 + STAGE_RATIO);
  Vec             first = NULL;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < flow->scene->dim; a++) PetscCall(VecCopy(s->u[a], s->u_next[a]));
  c->end = flow->clock->t + k;
  PetscCall(CoupledForce(c));
  PetscCall(SolveSystem(flow, k, c));
  if (flow->scheme->failure.code) PetscFunctionReturn(PETSC_SUCCESS);
  if (moves) {
    PetscCall(VecDuplicate(Pressure(flow), &first));
    PetscCall(VecCopy(Pressure(flow), first));
  }
  c->end = flow->clock->t + flow->clock->dt;
  PetscCall(CoupledSecondForce(c, flow->clock->t + k, PetscSqr(STAGE_RATIO)));
  for (PetscInt a = 0; a < flow->scene->dim; a++)
    PetscCall(VecAXPBY(s->u_next[a], 1.0 - STAGE_RATIO, STAGE_RATIO, s->u[a]));
  PetscCall(SolveSystem(flow, k, c));
  if (moves) {
    PetscCall(VecAXPBY(Pressure(flow), STAGE_RATIO, 1.0, first));
    PetscCall(VecScale(Pressure(flow), 1.0 / (1.0 + STAGE_RATIO)));
    PetscCall(SpreadPressure(flow));
  }
  PetscCall(VecDestroy(&first));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* CoupledStart - Keeps the pressure before the solve, and counts iterations anew; collective */
PetscErrorCode CoupledStart(Flow *flow)
{
  Coupled *c = (Coupled *)flow->scheme->data;

  PetscFunctionBegin;
  c->guard.solve.iterations = 0;
  PetscCall(VecCopy(flow->state->p, flow->state->p_before));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Notes the largest body force at the end of the step that its pressure does not balance. */
static PetscErrorCode NoteForce(Coupled *c, PetscReal end)
{
  Flow    *flow = c->flow;
  Splines *sp   = flow->scheme->splines;

  PetscFunctionBegin;
  if (flow->clock->steady_solve || !SceneHas(flow->scene, PHYSICS_BODY_FORCE))
    PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt a = 0; a < flow->scene->dim; a++) {
    PetscCall(VecZeroEntries(c->force[a]));
    if (sp) continue;
    PetscCall(AffineApply(&flow->ops->grad_p[a], flow->state->p, flow->walls.p, c->force[a]));
    PetscCall(VecScale(c->force[a], -1.0 / flow->scene->rho));
  }
  if (sp) PetscCall(SplinesAccelerate(sp, sp->all, -1.0 / flow->scene->rho, c->force));
  PetscCall(AddBodyForce(flow, end, c->force));
  PetscCall(NoteUnbalancedForce(flow, c->force));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the divergence of u_next with walls at time t. */
static PetscErrorCode Divergence(Flow *flow, PetscReal t)
{
  const FlowState *s  = flow->state;
  Splines         *sp = flow->scheme->splines;

  PetscFunctionBegin;
  PetscCall(WallValuesSetVelocity(flow->scene, flow->particles, t, 0.0, &flow->walls));
  if (!sp) {
    PetscCall(FlowDivergence(flow, s->u_next, s->divergence));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SplinesDivergence(flow, sp, s->u_next, t, sp->b));
  PetscCall(SplinesSumFluids(sp, sp->b, sp->divergence));
  PetscCall(VecPointwiseDivide(sp->divergence, sp->divergence, sp->mass));
  PetscCall(SplinesValue(sp, sp->divergence, s->divergence));
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
  for (PetscInt a = 0; a < dim; a++) PetscCall(FlowGetWork(flow, &force[a]));
  c->force = force;
  c->end   = end;
  if (flow->clock->steady_solve) {
    for (PetscInt a = 0; a < dim; a++) PetscCall(VecCopy(s->u[a], s->u_next[a]));
    PetscCall(CoupledForce(c));
    PetscCall(SolveSystem(flow, dt, c));
  } else if (flow->clock->order > 1 && ClockRatio(flow->clock) == 0.0) {
    PetscCall(StepFirst(flow, c));
  } else {
    PetscCall(HistoryStart(flow, PETSC_TRUE, &dt));
    PetscCall(CoupledForce(c));
    PetscCall(SolveSystem(flow, dt, c));
  }
  PetscCall(NoteForce(c, end));
  PetscCall(Divergence(flow, end));
  for (PetscInt a = 0; a < dim; a++) PetscCall(FlowRestoreWork(flow, &force[a]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  CoupledFreeStart - Replaces the velocity that a case or the user gives at the start by

    u - k/rho grad p,   div u = 0

  where both are discrete: a step of the length k that viscosity does not notice, at the places of
  the start. The pressure stays. Collective. Without it, the pressure of the first step is this
  impulse over dt, and a part of it follows in the second. A fluid at rest has none. Errors: the run
  ends if the solve fails.
*/
PetscErrorCode CoupledFreeStart(Flow *flow)
{
  FlowState      *s  = flow->state;
  Coupled        *c  = (Coupled *)flow->scheme->data;
  const PetscReal dt = flow->clock->dt;
  PetscBool       moves;
  Vec             p, kept = NULL, force[ISPH_MAX_DIM];

  PetscFunctionBegin;
  if (flow->clock->steady_solve) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FlowGiveStart(flow, &moves));
  if (!moves) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FlowGetWork(flow, &p));
  PetscCall(VecCopy(s->p, p));
  if (flow->scheme->kept) PetscCall(VecDuplicate(flow->scheme->kept, &kept));
  if (kept) PetscCall(VecCopy(flow->scheme->kept, kept));
  for (PetscInt a = 0; a < flow->scene->dim; a++) {
    PetscCall(FlowGetWork(flow, &force[a]));
    PetscCall(VecZeroEntries(force[a]));
  }
  c->force = force;
  c->end   = flow->clock->t;
  flow->clock->dt =
      FLOW_START_LENGTH * PetscMin(dt, PetscSqr(flow->scene->dx) / flow->scene->nu_high);
  PetscCall(SolveSystem(flow, flow->clock->dt, c));
  flow->clock->dt = dt;
  PetscCheck(!flow->scheme->failure.code, PETSC_COMM_WORLD, flow->scheme->failure.code, "%s",
             flow->scheme->failure.sentence);
  for (PetscInt a = 0; a < flow->scene->dim; a++) PetscCall(FlowRestoreWork(flow, &force[a]));
  PetscCall(FlowTakeStart(flow));
  PetscCall(VecCopy(p, s->p));
  PetscCall(FlowRestoreWork(flow, &p));
  if (kept) PetscCall(VecCopy(kept, flow->scheme->kept));
  PetscCall(VecDestroy(&kept));
  PetscCall(flow->scheme->row->Begin(flow));
  PetscFunctionReturn(PETSC_SUCCESS);
}
