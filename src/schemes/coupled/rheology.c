/* Viscosities that follow the strain rate in the coupled scheme. The matrix A of saddle.c has the
   viscosities of the velocity u_k, and the tangent J of the system adds the term of their changes,
   TangentApplyAdd(). An iteration solves J x = b + (J - A) x_k, preconditioned as A is. */
#include "coupled.h"

/* Subtracts T_i times the viscous term of the changes of viscosity by the velocity in x from y. */
static PetscErrorCode SubtractChanges(Coupled *c, Vec x, Vec y)
{
  const PetscInt dim = c->saddle.dim;
  Vec            term[ISPH_MAX_DIM];

  PetscFunctionBegin;
  PetscCall(SaddleGet(&c->saddle, x, c->u, NULL));
  for (PetscInt a = 0; a < dim; a++) {
    PetscCall(FlowGetWork(c->flow, &term[a]));
    PetscCall(VecZeroEntries(term[a]));
  }
  PetscCall(TangentApplyAdd(c->tangent, 1.0, c->u, term));
  for (PetscInt a = 0; a < dim; a++) {
    PetscCall(SaddleAdd(&c->saddle, a, -c->saddle.step, term[a], y));
    PetscCall(FlowRestoreWork(c->flow, &term[a]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Jacobian_Mult(Mat J, Vec x, Vec y)
{
  Coupled *c;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(J, &c));
  PetscCall(MatMult(c->saddle.A, x, y));
  PetscCall(SubtractChanges(c, x, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* CoupledJacobian - Creates the tangent J of the system for a rheology, and the right-hand side of
   the next iteration from b. Collective. Input: c->x - unknowns of the last iteration. Without a
   tangent J is A. */
PetscErrorCode CoupledJacobian(Coupled *c, Vec b, Mat *J, Vec *rhs)
{
  PetscInt n;

  PetscFunctionBegin;
  *J   = c->saddle.A;
  *rhs = b;
  PetscCall(PetscObjectReference((PetscObject)*J));
  PetscCall(PetscObjectReference((PetscObject)b));
  if (!c->tangent) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MatDestroy(J));
  PetscCall(VecDestroy(rhs));
  PetscCall(VecGetLocalSize(b, &n));
  PetscCall(MatCreateShell(PetscObjectComm((PetscObject)b), n, n, PETSC_DETERMINE, PETSC_DETERMINE,
                           c, J));
  PetscCall(MatShellSetOperation(*J, MATOP_MULT, (void (*)(void))Jacobian_Mult));
  PetscCall(VecDuplicate(b, rhs));
  PetscCall(VecCopy(b, *rhs));
  PetscCall(SubtractChanges(c, c->x, *rhs));
  PetscFunctionReturn(PETSC_SUCCESS);
}
