/*
  The scalar Laplacians, rows on differences f_j - f_i, and their table. A new form is one row
  function and one row here. Notation: X = x_j - x_i, r = |X|, W' = dW/dr < 0, grad_i W = -(X/r) W'.
*/
#include "rows.h"

/*
  LaplacianRow_Morris - Laplacian of Morris, Fox & Zhu: finite difference times kernel gradient

    (lap f)_i = sum_j -2 V_j (W'/r) (f_j - f_i)

  Properties: symmetric with equal volumes; consistent on a lattice only, error O(1/dx) on disorder.

  Reference: J. P. Morris, P. J. Fox, Y. Zhu, J. Comput. Phys. 136 (1997) 214-226
*/
static PetscErrorCode LaplacianRow_Morris(Stencil *st, PetscReal w[])
{
  PetscFunctionBegin;
  for (PetscInt k = 0; k < st->n; k++) w[k] = -2.0 * st->V[k] * st->dW[k] / st->r[k];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* M^-1 grad_i W for neighbour k. */
static inline void CorrectedKernelGradient(const Stencil *st, const PetscReal inverse[], PetscInt k,
                                           PetscReal gradient[])
{
  for (PetscInt a = 0; a < st->dim; a++) {
    gradient[a] = 0.0;
    for (PetscInt b = 0; b < st->dim; b++) {
      gradient[a] -= inverse[a * st->dim + b] * st->X[b][k] * st->dW[k] / st->r[k];
    }
  }
}

/*
  LaplacianRow_Corrected - Morris's Laplacian with first-order corrected kernel gradient

    (lap f)_i = sum_j 2 V_j X.(M^-1 grad_i W)/r^2 (f_j - f_i)

  Properties: exact for |x - x_i|^2; linear fields leave an error O(1/dx) on disorder.

  Reference: G. Oger et al., J. Comput. Phys. 225 (2007); X. Zheng, Q. Ma, S. Shao, Water 10 (2018),
  VISC-04
*/
static PetscErrorCode LaplacianRow_Corrected(Stencil *st, PetscReal w[])
{
  PetscReal inverse[ISPH_MAX_DIM * ISPH_MAX_DIM], gradient[ISPH_MAX_DIM];

  PetscFunctionBegin;
  if (!MomentInverse(st, inverse)) st->weak++;
  for (PetscInt k = 0; k < st->n; k++) {
    PetscReal dot = 0.0;

    CorrectedKernelGradient(st, inverse, k, gradient);
    for (PetscInt a = 0; a < st->dim; a++) dot += st->X[a][k] * gradient[a];
    w[k] = 2.0 * st->V[k] * dot / PetscSqr(st->r[k]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  LaplacianRow_Schwaiger - Laplacian freed from the error of linear fields

    (lap f)_i = tr(M^-1)/d { 2 sum_j V_j (f_i - f_j) W'/r - 2 g_i . sum_j V_j grad_i W },
    g_i = M^-1 sum_j V_j (f_j - f_i) grad_i W

  Properties: exact for linear fields; error O(1) in general quadratics on disorder.

  Reference: H. F. Schwaiger, Int. J. Numer. Meth. Eng. 75 (2008) 647-671, signs as corrected here
*/
static PetscErrorCode LaplacianRow_Schwaiger(Stencil *st, PetscReal w[])
{
  PetscReal inverse[ISPH_MAX_DIM * ISPH_MAX_DIM], gradient[ISPH_MAX_DIM];
  PetscReal sum[ISPH_MAX_DIM] = {0.0}, trace = 0.0;

  PetscFunctionBegin;
  if (!MomentInverse(st, inverse)) st->weak++;
  for (PetscInt a = 0; a < st->dim; a++) {
    trace += inverse[a * st->dim + a] / st->dim;
    for (PetscInt k = 0; k < st->n; k++) sum[a] -= st->V[k] * st->X[a][k] * st->dW[k] / st->r[k];
  }
  for (PetscInt k = 0; k < st->n; k++) {
    PetscReal dot = 0.0;

    CorrectedKernelGradient(st, inverse, k, gradient);
    for (PetscInt a = 0; a < st->dim; a++) dot += gradient[a] * sum[a];
    w[k] = -2.0 * trace * st->V[k] * (st->dW[k] / st->r[k] + dot);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

#define SYM_MAX (ISPH_MAX_DIM * (ISPH_MAX_DIM + 1) / 2)

/*
  The symmetric matrix B of Fatehi & Manzari, packed (a >= b, off-diagonal entries counted once):
  solves  sum_k V_k W' (B:ee) [-X_a X_b/r + (X/r).G^ab] = delta_ab,  G^ab = M^-1 sum V X_a X_b
  grad_i W.
*/
static PetscErrorCode FatehiManzariMatrix(const Stencil *st, const PetscReal inverse[],
                                          PetscReal B[])
{
  const PetscInt d = st->dim, n = d * (d + 1) / 2;
  PetscReal      G[SYM_MAX][ISPH_MAX_DIM] = {{0.0}}, lhs[SYM_MAX][SYM_MAX + 1] = {{0.0}},
            gradient[ISPH_MAX_DIM];

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
            lhs[s][q] += st->V[k] * st->dW[k] * (e == f ? 1.0 : 2.0) * st->X[e][k] * st->X[f][k] /
                         (r * r) * bracket;
          }
        }
      }
    }
  }
  for (PetscInt a = 0, s = 0; a < d; a++) {
    for (PetscInt b = 0; b <= a; b++, s++) lhs[s][n] = a == b ? 1.0 : 0.0;
  }
  for (PetscInt p = 0; p < n; p++) { /* Gauss with partial pivoting: the matrix is not symmetric */
    PetscInt best = p;

    for (PetscInt s = p + 1; s < n; s++)
      best = PetscAbsReal(lhs[s][p]) > PetscAbsReal(lhs[best][p]) ? s : best;
    for (PetscInt q = 0; q <= n; q++) {
      const PetscReal swap = lhs[p][q];

      lhs[p][q]    = lhs[best][q];
      lhs[best][q] = swap;
    }
    for (PetscInt s = 0; s < n; s++) {
      const PetscReal factor = s == p || lhs[p][p] == 0.0 ? 0.0 : lhs[s][p] / lhs[p][p];

      for (PetscInt q = p; q <= n; q++) lhs[s][q] -= factor * lhs[p][q];
    }
  }
  for (PetscInt s = 0; s < n; s++) B[s] = lhs[s][s] == 0.0 ? 0.0 : lhs[s][n] / lhs[s][s];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  LaplacianRow_FatehiManzari - Laplacian with the gradient's error removed and a matrix B_i chosen
  so that quadratics are exact

    (lap f)_i = 2 sum_j V_j W' (B_i : ee) [ (f_i - f_j)/r - e.g_i ],   e = (x_i - x_j)/r

  Properties: exact for quadratics on any arrangement; not symmetric.

  Reference: R. Fatehi, M. T. Manzari, Comput. Math. Appl. 61 (2011) 482-498
*/
static PetscErrorCode LaplacianRow_FatehiManzari(Stencil *st, PetscReal w[])
{
  const PetscInt d = st->dim;
  PetscReal      inverse[ISPH_MAX_DIM * ISPH_MAX_DIM], B[SYM_MAX], gradient[ISPH_MAX_DIM];
  PetscReal      Q[ISPH_MAX_DIM] = {0.0};

  PetscFunctionBegin;
  if (!MomentInverse(st, inverse)) st->weak++;
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

static const LaplacianRow laplacians[] = {
    /* name, brief, citation, symmetric, exact: linear, quadratic, full support, row */
    {"morris", "finite difference times kernel gradient (VISC-01, model E)",
     "Morris, Fox & Zhu, J. Comput. Phys. 136 (1997)", PETSC_TRUE, PETSC_FALSE, PETSC_FALSE,
     PETSC_TRUE, LaplacianRow_Morris},
    {"corrected", "morris with first-order corrected gradient (VISC-04)",
     "Oger et al., J. Comput. Phys. 225 (2007)", PETSC_FALSE, PETSC_FALSE, PETSC_FALSE, PETSC_TRUE,
     LaplacianRow_Corrected},
    {"schwaiger", "morris freed from the error of linear fields (VISC-03)",
     "Schwaiger, Int. J. Numer. Meth. Eng. 75 (2008)", PETSC_FALSE, PETSC_TRUE, PETSC_FALSE,
     PETSC_TRUE, LaplacianRow_Schwaiger},
    {"fatehi_manzari", "exact for quadratics by a matrix per particle",
     "Fatehi & Manzari, Comput. Math. Appl. 61 (2011)", PETSC_FALSE, PETSC_TRUE, PETSC_TRUE,
     PETSC_TRUE, LaplacianRow_FatehiManzari},
    {"mls", "quadratic moving least squares, takes boundary conditions in the fit",
     "Liu & Gu, Meshfree Methods (2005); Kuhnert (1999)", PETSC_FALSE, PETSC_TRUE, PETSC_TRUE,
     PETSC_FALSE, LaplacianRow_Mls},
};
const Table LaplacianTable = TABLE("-visc_laplacian, -ppe_laplacian", "Laplacians", laplacians);
