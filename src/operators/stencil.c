/*
  The stencil: storage for one particle's neighbourhood. OperatorsAssemble() fills it, row functions
  read it.
*/
#include "isph/operators.h"

/*
  StencilCreate - An empty stencil

  Not collective. Input: dim, the radius of the kernel's support, and the length that scales
  equations of derivatives in least-squares fits [m].
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

/* StencilReserve - Makes room for n neighbours; what the stencil held is lost */
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
  StencilSetRole - Says what the wall neighbours mean in the fits that follow

  Not collective. Keeps the factored fit where it stays the same: in rows that see no wall, and
  between roles that particles behind walls do not tell apart.
*/
void StencilSetRole(Stencil *st, Role role)
{
  const PetscBool apart = st->fits_walls || role == ROLE_NONE || st->role == ROLE_NONE;

  if (st->n_wall && apart && role != st->role) st->fit.valid = PETSC_FALSE;
  st->role = role;
}
