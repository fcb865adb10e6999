/* Rows as streams: a scheme that needs each row once gathers the stencils itself and adds up the
   terms of its equations, without storing rows or matrices. */
#include "assembly.h"

/* OperatorsStream - Gathers the stencil of each own fluid particle and calls a function with it.
   Walls are values of fits, and free surfaces have no equations. Input: Row - reads the stencil,
   whose volumes it may replace; ctx - of Row. */
PetscErrorCode OperatorsStream(const Scene *scene, const Particles *p, const Neighbors *nb,
                               const Operators *ops, StreamRow Row, void *ctx)
{
  Stencil *st = ops->work->stencil;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscCall(GatherStencil(scene, p, nb, ops, i, st));
    PetscCall(Row(st, ctx));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* OperatorsStreamFactors - Computes the factors of the viscous form, which its rows read, at the
   present positions. Collective. Does nothing if the form has none. */
PetscErrorCode OperatorsStreamFactors(const Scene *scene, const Particles *p, const Neighbors *nb,
                                      Operators *ops)
{
  PetscFunctionBegin;
  PetscCall(LaplacianFactors(scene, p, nb, ops, &ops->forms.visc));
  PetscFunctionReturn(PETSC_SUCCESS);
}
