/*
  The Laplacian of Fatehi and Manzari, a pairwise form with two corrections for disordered
  particles. The corrected gradient makes it exact for linear fields, and a matrix for each particle
  makes it exact for quadratic fields.
*/
#include "rows.h"

#define SYM_MAX (ISPH_MAX_DIM * (ISPH_MAX_DIM + 1) / 2)

/*
  Computes the symmetric matrix B that makes the Laplacian exact for quadratic fields, from

    sum_k V_k W' (B:ee) [-X_a X_b/r + (X/r).G^ab] = delta_ab,   e = X/r,
    G^ab = M^-1 sum_k V_k X_a X_b grad_i W,   M = sum_k V_k (grad_i W) X^T

  Input: inverse - M^-1. Output: B - its entries with a >= b.
*/
static PetscErrorCode FatehiManzariMatrix(Stencil *st, const PetscReal inverse[], PetscReal B[])
{
  const PetscInt d = st->dim, n = d * (d + 1) / 2;
  PetscReal      G[SYM_MAX][ISPH_MAX_DIM] = {{0.0}}, gradient[ISPH_MAX_DIM];
  PetscReal      A[SYM_MAX * SYM_MAX]     = {0.0}; /* row q: entry of B; column s: pair (a, b) */
  PetscBool      singular                 = PETSC_FALSE;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < st->n; k++) {
    CorrectedKernelGradient(st, inverse, k, gradient);
    for (PetscInt a = 0, s = 0; a < d; a++) {
      for (PetscInt b = 0; b <= a; b++, s++) {
        for (PetscInt c = 0; c < d; c++)
          G[s][c] += st->V[k] * st->X[a][k] * st->X[b][k] * gradient[c];
      }
    }
  }
  for (PetscInt k = 0; k < st->n; k++) {
    const PetscReal r = st->r[k];

    for (PetscInt a = 0, s = 0; a < d; a++) {
      for (PetscInt b = 0; b <= a; b++, s++) {
        PetscReal bracket = -st->X[a][k] * st->X[b][k] / r;

        for (PetscInt c = 0; c < d; c++) bracket += st->X[c][k] / r * G[s][c];
        for (PetscInt e = 0, q = 0; e < d; e++) {
          for (PetscInt f = 0; f <= e; f++, q++) {
            A[q * n + s] += st->V[k] * st->dW[k] * (e == f ? 1.0 : 2.0) * st->X[e][k] *
                            st->X[f][k] / (r * r) * bracket;
          }
        }
      }
    }
  }
  for (PetscInt a = 0, s = 0; a < d; a++) {
    for (PetscInt b = 0; b <= a; b++, s++) B[s] = a == b ? 1.0 : 0.0;
  }
  DenseEliminate(n, A, 1, B);
  for (PetscInt s = 0; s < n; s++) {
    const PetscReal pivot = A[s * n + s];

    if (pivot == 0.0) singular = PETSC_TRUE;
    B[s] = pivot == 0.0 ? 0.0 : B[s] / pivot;
  }
  if (singular) st->regularised++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  LaplacianRow_FatehiManzari - Computes a Laplacian with the corrected gradient g_i and the matrix
  B_i of FatehiManzariMatrix()

    (lap f)_i = 2 sum_j V_j W' (B_i : ee) [ (f_i - f_j)/r - e.g_i ],   e = (x_i - x_j)/r,
    g_i = M^-1 sum_j V_j (f_j - f_i) grad_i W,   M = sum_j V_j (grad_i W) X^T

  Properties: exact for quadratic fields on any arrangement of particles; not symmetric.

  Reference: R. Fatehi, M. T. Manzari, Comput. Math. Appl. 61 (2011) 482-498
*/
PetscErrorCode LaplacianRow_FatehiManzari(Stencil *st, PetscReal w[])
{
  const PetscInt d = st->dim;
  PetscReal      inverse[ISPH_MAX_DIM * ISPH_MAX_DIM], B[SYM_MAX], gradient[ISPH_MAX_DIM];
  PetscReal      Q[ISPH_MAX_DIM] = {0.0};

  PetscFunctionBegin;
  for (PetscInt k = 0; k < st->n; k++) w[k] = -st->V[k] * st->dW[k] / st->r[k];
  if (!MomentInverse(st, w, inverse)) st->regularised++;
  PetscCall(FatehiManzariMatrix(st, inverse, B));
  for (PetscInt k = 0; k < st->n; k++) {
    PetscReal bee = 0.0;

    for (PetscInt a = 0, s = 0; a < d; a++) {
      for (PetscInt b = 0; b <= a; b++, s++) {
        bee += (a == b ? 1.0 : 2.0) * B[s] * st->X[a][k] * st->X[b][k] / PetscSqr(st->r[k]);
      }
    }
    w[k] = -2.0 * st->V[k] * st->dW[k] * bee / st->r[k];
    for (PetscInt a = 0; a < d; a++) Q[a] -= w[k] * st->X[a][k];
  }
  for (PetscInt k = 0; k < st->n; k++) {
    CorrectedKernelGradient(st, inverse, k, gradient);
    for (PetscInt a = 0; a < d; a++) w[k] += st->V[k] * Q[a] * gradient[a];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
