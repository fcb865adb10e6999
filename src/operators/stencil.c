/*
  Storage for the stencil of a particle. OperatorsAssemble() fills it, row functions read it.
*/
#include "isph/operators.h"

/*
  StencilCreate - Creates an empty stencil

  Not collective. Input: dim; radius of the support [m]; scale, the length that multiplies equations
  of derivatives in least-squares fits [m].
*/
PetscErrorCode StencilCreate(PetscInt dim, PetscReal radius, PetscReal scale, Stencil **stencil)
{
  PetscFunctionBegin;
  PetscCall(PetscNew(stencil));
  (*stencil)->dim    = dim;
  (*stencil)->radius = radius;
  (*stencil)->scale  = scale;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode StencilFree(Stencil *st)
{
  PetscFunctionBegin;
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) PetscCall(PetscFree2(st->X[a], st->normal[a]));
  PetscCall(PetscFree7(st->r, st->V, st->W, st->dW, st->ddW, st->beta, st->j));
  PetscCall(PetscFree5(st->wall, st->corrected[0], st->corrected[1], st->side, st->share));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StencilDestroy(Stencil **stencil)
{
  PetscFunctionBegin;
  if (!*stencil) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(StencilFree(*stencil));
  PetscCall(PetscFree(*stencil));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* StencilReserve - Makes room for n neighbours; the present contents are lost */
PetscErrorCode StencilReserve(Stencil *st, PetscInt n)
{
  PetscFunctionBegin;
  if (n <= st->capacity) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(StencilFree(st));
  st->capacity = 2 * n;
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) {
    PetscCall(PetscMalloc2(st->capacity, &st->X[a], st->capacity, &st->normal[a]));
  }
  PetscCall(PetscMalloc7(st->capacity, &st->r, st->capacity, &st->V, st->capacity, &st->W,
                         st->capacity, &st->dW, st->capacity, &st->ddW, st->capacity, &st->beta,
                         st->capacity, &st->j));
  PetscCall(PetscMalloc5(st->capacity, &st->wall, st->capacity, &st->corrected[0], st->capacity,
                         &st->corrected[1], st->capacity, &st->side, st->capacity, &st->share));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  StencilSetRole - Sets the role of wall neighbours in the following fits

  Not collective. Keeps the factored fit if the role does not change it: without wall neighbours,
  and for dummies, whose equations have values in both roles.
*/
void StencilSetRole(Stencil *st, Role role)
{
  const PetscBool apart = st->fits_walls || role == ROLE_NONE || st->role == ROLE_NONE;

  if (st->n_wall && apart && role != st->role) st->fit.valid = PETSC_FALSE;
  st->role = role;
}
