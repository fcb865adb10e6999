/* Terms of the coupled equations, and their right-hand side. */
#include "coupled.h"

/* CoupledForce - Sets the force per unit mass: the body force at c->end and, for fixed particles in
   time, minus the convective term extrapolated in time. Collective. */
PetscErrorCode CoupledForce(Coupled *c)
{
  Flow *flow = c->flow;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < flow->scene->dim; a++) PetscCall(VecZeroEntries(c->force[a]));
  PetscCall(AddBodyForce(flow, c->end, c->force));
  if (flow->state->has_convection && !flow->clock->steady_solve)
    PetscCall(ConvectionExtrapolate(flow, 1.0, c->force));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  CoupledSecondForce - Sets the force per unit mass of the second stage of StepFirst(), from the
  velocity u_1 of the first one in u_next

    f - N^n - weight (N_1 - N^n),   N of ConvectionExplicit() for fixed particles, otherwise 0

  Collective. CoupledForce() has set the force of the first stage, which ended at `first`, and kept
  N^n for the next step.
*/
PetscErrorCode CoupledSecondForce(Coupled *c, PetscReal first, PetscReal weight)
{
  Flow      *flow = c->flow;
  FlowState *s    = flow->state;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < flow->scene->dim; a++) PetscCall(VecZeroEntries(c->force[a]));
  PetscCall(AddBodyForce(flow, c->end, c->force));
  for (PetscInt a = 0; s->has_convection && a < flow->scene->dim; a++) {
    PetscCall(ConvectionExplicit(flow, first, s->u_next, a, c->work, c->part));
    PetscCall(VecAXPY(c->force[a], weight - 1.0, s->convection_prev[a]));
    PetscCall(VecAXPY(c->force[a], -weight, c->part));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the viscous terms of wall velocities over nu, of component a; coupled components
   share a product, which component 0 computes. */
static PetscErrorCode WallViscosity(Coupled *c, PetscInt a, Vec part)
{
  const Flow *flow = c->flow;
  const Mat   B    = flow->ops->velocity[0].visc.B;

  PetscFunctionBegin;
  if (!flow->ops->forms.wall) {
    PetscCall(VecZeroEntries(part));
  } else if (!flow->ops->forms.components_coupled) {
    PetscCall(MatMult(B, flow->walls.u[a], part));
  } else {
    for (PetscInt e = 0; a == 0 && e < c->saddle.dim; e++)
      PetscCall(VecStrideScatter(flow->walls.u[e], e, c->all_walls, INSERT_VALUES));
    if (a == 0) PetscCall(MatMult(B, c->all_walls, c->boundary));
    PetscCall(VecStrideGather(c->boundary, a, part, INSERT_VALUES));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Subtracts from a vector the terms of wall velocities in (v.grad) u_a; v is the advecting velocity
   of implicit convection. */
static PetscErrorCode AddWallConvection(Coupled *c, PetscInt a, Vec part)
{
  PetscFunctionBegin;
  if (!c->advecting || !c->flow->ops->forms.wall) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt e = 0; e < c->saddle.dim; e++) {
    PetscCall(MatMult(c->flow->ops->velocity[0].grad_u[e].B, c->flow->walls.u[a], c->work));
    PetscCall(VecPointwiseMult(c->work, c->work, c->advecting[e]));
    PetscCall(VecAXPY(part, -1.0, c->work));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Subtracts the terms of given pressures, which are counted from the level of the scene as the
   unknowns are: T_i/rho times their part of grad p in momentum rows, T_i/(rho dx_i) times their
   part of the filter C of saddle.c in rows of mass. */
static PetscErrorCode AddGivenPressure(Coupled *c, PetscReal t)
{
  const Flow   *flow = c->flow;
  const Saddle *s    = &c->saddle;

  PetscFunctionBegin;
  if (ScenePressureFloats(flow->scene) || flow->scheme->splines || !flow->walls.p)
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(WallValuesSetPressure(flow->scene, flow->particles, t, 0.0, &c->flow->walls));
  PetscCall(WallValuesStepPressure(flow->scene, flow->particles, t, &c->flow->walls));
  for (PetscInt a = 0; a < s->dim; a++) {
    PetscCall(MatMult(flow->ops->grad_p[a].B, flow->walls.p_step, c->part));
    PetscCall(SaddleAdd(s, a, -s->step / flow->scene->rho, c->part, c->b));
  }
  PetscCall(MatMult(flow->ops->filter_p.B, flow->walls.p_step, c->part));
  PetscCall(VecPointwiseDivide(c->part, c->part, s->pressure));
  PetscCall(VecPointwiseDivide(c->part, c->part, s->mass)); /* SaddleAdd() multiplies by it */
  PetscCall(SaddleAdd(s, s->dim, -1.0 / s->unit, c->part, c->b));
  PetscCall(WallValuesSetPressure(flow->scene, flow->particles, t, 1.0, &c->flow->walls));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Subtracts the terms of walls in the divergence on splines, which a fluid at rest has, and adds
   the pressures that sides give. */
static PetscErrorCode AddSplines(Coupled *c, PetscReal t)
{
  Splines *sp = c->flow->scheme->splines;

  PetscFunctionBegin;
  PetscCall(VecZeroEntries(c->part));
  PetscCall(SplinesDivergence(c->flow, sp, (Vec[]){c->part, c->part, c->part}, t, sp->b));
  PetscCall(SaddleAdd(&c->saddle, c->saddle.dim, -c->flow->scene->dx, sp->b, c->b));
  PetscCall(SaddleAddGiven(&c->saddle, t, sp, c->b));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  CoupledRightHandSide - Computes the right-hand side b at time t

    T_i (force + terms of wall velocities in nu lap u - (v.grad) u)    in momentum rows
    -dx_i (terms of wall velocities in div u)                          in rows of mass

  and subtracts the terms of given pressures. Collective. T_i and dx_i scale the rows of particle i,
  see saddle.c; v is the advecting velocity of implicit convection.
*/
PetscErrorCode CoupledRightHandSide(Coupled *c, PetscReal t)
{
  const Saddle  *s  = &c->saddle;
  const Splines *sp = c->flow->scheme->splines;

  PetscFunctionBegin;
  PetscCall(WallValuesSetVelocity(c->flow->scene, c->flow->particles, t, 0.0, &c->flow->walls));
  PetscCall(VecZeroEntries(c->b));
  for (PetscInt a = 0; a < s->dim; a++) {
    PetscCall(WallViscosity(c, a, c->part));
    PetscCall(VecAYPX(c->part, c->flow->scene->nu, c->force[a]));
    PetscCall(AddWallConvection(c, a, c->part));
    PetscCall(SaddleAdd(s, a, s->step, c->part, c->b));
    if (sp || !c->flow->ops->forms.wall) continue;
    PetscCall(MatMult(c->flow->ops->div[a].B, c->flow->walls.u[a], c->part));
    PetscCall(SaddleAdd(s, s->dim, -c->flow->scene->dx, c->part, c->b));
  }
  if (sp) PetscCall(AddSplines(c, t));
  PetscCall(AddGivenPressure(c, t));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* CoupledNumbering - Returns the stamp up to which a set-up of the preconditioner serves: a free
   surface of strain cells changes the matrix in each step; not collective */
PetscInt CoupledNumbering(const Coupled *c)
{
  return c->flow->ops->cut_surface ? c->flow->ops->assemblies : c->flow->particles->epoch;
}

/* CoupledSetShift - Sets the shift of the matrix, and reuses the preconditioner as long as it
   holds, see SetUpHolds(); collective */
PetscErrorCode CoupledSetShift(PetscReal shift, Coupled *c)
{
  LinearSolve    *solve = &c->guard.solve;
  const PetscBool keep  = SetUpHolds(&solve->setup, CoupledNumbering(c), shift);

  PetscFunctionBegin;
  PetscCall(SaddleSetShift(c->flow->particles, shift, &c->saddle));
  if (!keep && c->flat) PetscCall(SaddleFlatten(c->saddle.P, &c->flat));
  if (!keep && c->velocity.flow) PetscCall(VelocityBlockSetUp(&c->saddle, &c->velocity));
  if (!keep) SetUpRenew(CoupledNumbering(c), shift, solve);
  PetscCall(KSPSetReusePreconditioner(solve->ksp, keep));
  c->schur.viscous = c->flow->scene->nu * c->saddle.step / PetscSqr(c->flow->scene->dx);
  c->schur.inert   = shift * c->saddle.step;
  PetscFunctionReturn(PETSC_SUCCESS);
}
