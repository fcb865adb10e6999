/* The terms of the coupled equations as callbacks of a TS, and their right-hand side. */
#include "coupled.h"
#include "projection.h"

/* part -= the share of walls in (v.grad) u_a. */
static PetscErrorCode AddWallConvection(Coupled *c, PetscInt a, Vec part)
{
  PetscFunctionBegin;
  if (!c->advecting || !c->ops->wall) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt e = 0; e < c->saddle.dim; e++) {
    PetscCall(MatMult(c->ops->grad_u[e].B, c->ops->wall_u[a], c->work));
    PetscCall(VecPointwiseMult(c->work, c->work, c->advecting[e]));
    PetscCall(VecAXPY(part, -1.0, c->work));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* CoupledRightHandSide - b at time t: T (f + nu B u_wall) and -dx (walls in div u); collective */
PetscErrorCode CoupledRightHandSide(Coupled *c, PetscReal t)
{
  const Saddle *s = &c->saddle;

  PetscFunctionBegin;
  if (c->b_t == t) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(OperatorsSetWallVelocity(c->scene, c->particles, t, 0.0, c->ops));
  for (PetscInt a = 0; c->stages && a < s->dim; a++) PetscCall(VecZeroEntries(c->force[a]));
  if (c->stages && SceneHas(c->scene, PHYSICS_BODY_FORCE))
    PetscCall(AddBodyForce(c->scene, t, c->particles, c->force, c->scheme));
  PetscCall(VecZeroEntries(c->b));
  for (PetscInt a = 0; a < s->dim; a++) {
    PetscCall(VecZeroEntries(c->part));
    if (c->ops->wall) PetscCall(MatMult(c->ops->visc.B, c->ops->wall_u[a], c->part));
    PetscCall(VecAYPX(c->part, c->scene->nu, c->force[a]));
    PetscCall(AddWallConvection(c, a, c->part));
    PetscCall(SaddleAdd(s, a, s->step, c->part, c->b));
    if (!c->ops->wall) continue;
    PetscCall(MatMult(c->ops->div[a].B, c->ops->wall_u[a], c->part));
    PetscCall(SaddleAdd(s, s->dim, -c->scene->dx, c->part, c->b));
  }
  c->b_t = t;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* CoupledAddConvection - f += scale u.grad u, u the velocity in x; collective */
PetscErrorCode CoupledAddConvection(Coupled *c, Vec x, PetscReal scale, Vec f)
{
  const Saddle *s = &c->saddle;

  PetscFunctionBegin;
  PetscCall(SaddleGet(s, x, c->u, NULL));
  for (PetscInt a = 0; a < s->dim; a++) {
    PetscCall(
        ConvectionCentral(s->dim, c->ops, c->u, c->u[a], c->ops->wall_u[a], c->work, c->part));
    PetscCall(SaddleAdd(s, a, scale, c->part, f));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  CoupledIFunction - T du/dt + [T u.grad u] + A_0 x - b

  Collective. The Jacobian leaves convection out: rosw, a W method, keeps its order without, bdf
  iterates.
*/
PetscErrorCode CoupledIFunction(TS ts, PetscReal t, Vec x, Vec xdot, Vec f, void *ctx)
{
  Coupled           *c = (Coupled *)ctx;
  const Saddle      *s = &c->saddle;
  const PetscScalar *u, *udot;
  PetscScalar       *r;

  PetscFunctionBegin;
  PetscCall(CoupledRightHandSide(c, t));
  PetscCall(MatMult(s->A, x, f));
  PetscCall(VecAXPY(f, -1.0, c->b));
  if (c->convects) PetscCall(CoupledAddConvection(c, x, s->step, f));
  PetscCall(VecGetArrayRead(x, &u));
  PetscCall(VecGetArrayRead(xdot, &udot));
  PetscCall(VecGetArray(f, &r));
  for (PetscInt i = 0; i < s->dim * s->n; i++) r[i] += s->step * (udot[i] - s->shift * u[i]);
  PetscCall(VecRestoreArray(f, &r));
  PetscCall(VecRestoreArrayRead(xdot, &udot));
  PetscCall(VecRestoreArrayRead(x, &u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* CoupledIJacobian - The matrix, made where the shift is new; collective */
PetscErrorCode CoupledIJacobian(TS ts, PetscReal t, Vec x, Vec xdot, PetscReal shift, Mat A, Mat P,
                                void *ctx)
{
  Coupled *c = (Coupled *)ctx;

  PetscFunctionBegin;
  if (shift != c->saddle.shift) PetscCall(CoupledSetShift(shift, c));
  PetscFunctionReturn(PETSC_SUCCESS);
}
