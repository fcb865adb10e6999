/*
  Rows as streams: a scheme that needs each row once gathers the stencils itself and adds up the
  terms of its equations, without storing rows or matrices.
*/
#include "assembly.h"

/*
  OperatorsStream - Gathers the stencil of each own fluid particle and calls a function with it

  Not collective. Walls are values of fits, and free surfaces have no equations.

  Input Parameters:
+ Row - reads the stencil, whose volumes it may replace
- ctx - of Row
*/
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

/*
  KernelGradients - Computes the gradient of the kernel at each neighbour, with a correction

    none:        g_k = grad_i W_ik
    shepard:     g_k = grad_i (W_ik/S),   S = sum_j V_j W_ij with the particle itself
    first_order: g_k = (sum_j V_j g_j X_j^T)^-1 g_k with the g of shepard

  Not collective. With a correction sum_j V_j g_j, which includes the particle itself, is zero, so
  sums of f_j are sums of f_j - f_i over the neighbours. With first_order linear fields are exact.
  If the neighbours do not span space, first_order is shepard, and st->regularised counts the row.

  Output Parameter:
. g - component a of neighbour k at g[a][k], room for st->capacity [m^-(dim+1)]

  Reference: M. Basa, N. Quinlan, M. Lastiwka, Int. J. Numer. Meth. Fluids 60 (2009), Eqs (22),
  (24) to (26)
*/
void KernelGradients(const CorrectionRow *correction, Stencil *st, PetscReal *g[])
{
  const PetscInt d = st->dim, n = st->n;
  PetscReal      S                                   = st->volume * st->self[0], sum[ISPH_MAX_DIM];
  PetscReal      moment[ISPH_MAX_DIM * ISPH_MAX_DIM] = {0.0}, inverse[ISPH_MAX_DIM * ISPH_MAX_DIM];

  for (PetscInt a = 0; a < d; a++)
    for (PetscInt k = 0; k < n; k++) g[a][k] = -st->X[a][k] * st->dW[k] / st->r[k];
  if (!correction || !correction->bit) return;
  for (PetscInt k = 0; k < n; k++) S += st->V[k] * st->W[k];
  for (PetscInt a = 0; a < d; a++) {
    sum[a] = 0.0;
    for (PetscInt k = 0; k < n; k++) sum[a] += st->V[k] * g[a][k];
    for (PetscInt k = 0; k < n; k++) g[a][k] = (g[a][k] - st->W[k] * sum[a] / S) / S;
  }
  if (correction->bit != CORRECTION_FIRST_ORDER) return;
  for (PetscInt a = 0; a < d; a++) {
    for (PetscInt b = 0; b < d; b++) {
      inverse[a * d + b] = a == b ? 1.0 : 0.0;
      for (PetscInt k = 0; k < n; k++) moment[a * d + b] += st->V[k] * g[a][k] * st->X[b][k];
    }
  }
  DenseEliminate(d, moment, d, inverse);
  for (PetscInt a = 0; a < d; a++) {
    if (PetscAbsReal(moment[a * d + a]) > MLS_WEAK) continue;
    st->regularised++;
    return;
  }
  for (PetscInt k = 0; k < n; k++) {
    PetscReal corrected[ISPH_MAX_DIM] = {0.0};

    for (PetscInt a = 0; a < d; a++)
      for (PetscInt b = 0; b < d; b++)
        corrected[a] += inverse[a * d + b] / moment[b * d + b] * g[b][k];
    for (PetscInt a = 0; a < d; a++) g[a][k] = corrected[a];
  }
}
