/*
  Forms for comparison, as a shared object for -library: the cubic fit beside quadratic ones,
  the corrected kernel under the name of its paper, second derivatives of the kernel with
  differences of velocities, and two Laplacians that correct the errors of disordered particles.
*/
#include "isph/plugin.h"
#include "rows/rows.h"

/*
  LaplacianRow_Mls3 - Computes the Laplacian of the cubic fit, or of the quadratic fit if the points
  do not determine the cubic fit; st->regularised counts such rows

  Properties: exact for cubic fields, so of order 2 on disordered particles too; not symmetric; uses
  the wall neighbours' equations.
*/
static PetscErrorCode LaplacianRow_Mls3(Stencil *st, PetscReal w[])
{
  const PetscInt degree = st->degree;

  PetscFunctionBegin;
  st->degree = 3;
  PetscCall(LaplacianRow_Mls(st, w));
  st->degree = degree;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  LaplacianRow_Corrected - Computes the Laplacian of Morris, Fox & Zhu with the corrected kernel
  gradient

    (lap f)_i = sum_j 2 V_j X.(M^-1 grad_i W)/r^2 (f_j - f_i),   M = sum_j V_j (grad_i W) X^T

  Properties: exact for |x - x_i|^2; linear fields have an error O(1/dx) on disordered particles. It
  is morris with -correction first_order.

  Reference: G. Oger et al., J. Comput. Phys. 225 (2007); X. Zheng, Q. Ma, S. Shao, Water 10 (2018),
  VISC-04
*/
static PetscErrorCode LaplacianRow_Corrected(Stencil *st, PetscReal w[])
{
  PetscFunctionBegin;
  CorrectKernel_FirstOrder(st, w, NULL);
  for (PetscInt k = 0; k < st->n; k++) w[k] = -2.0 * st->V[k] * w[k] / st->r[k];
  PetscFunctionReturn(PETSC_SUCCESS);
}

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
static PetscErrorCode LaplacianRow_FatehiManzari(Stencil *st, PetscReal w[])
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

/*
  LaplacianRow_Lsph - Computes the renormalised meshless Laplacian

    (lap f)_i = 2d sum_j c_j (f_j - f_i) / sum_j c_j r^2,   c_j = V_j W (1 - X.B o),
    o = sum_j V_j W X,   B = (sum_j V_j W X X^T)^-1

  Properties: exact for linear fields and |x - x_i|^2; error O(1) for other quadratic fields on
  disordered particles.

  Reference: J. Basic, N. Degiuli, D. Ban, J. Comput. Phys. 354 (2018) 269-287
*/
static PetscErrorCode LaplacianRow_Lsph(Stencil *st, PetscReal w[])
{
  const PetscInt d = st->dim;
  PetscReal      B[ISPH_MAX_DIM * ISPH_MAX_DIM], o[ISPH_MAX_DIM] = {0.0}, Bo[ISPH_MAX_DIM] = {0.0},
                                            sum = 0.0;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < st->n; k++) {
    w[k] = st->V[k] * st->W[k];
    for (PetscInt a = 0; a < d; a++) o[a] += w[k] * st->X[a][k];
  }
  if (MomentInverse(st, w, B)) {
    for (PetscInt a = 0; a < d; a++) {
      for (PetscInt b = 0; b < d; b++) Bo[a] += B[a * d + b] * o[b];
    }
  } else {
    st->regularised++;
  }
  for (PetscInt k = 0; k < st->n; k++) {
    PetscReal dot = 0.0;

    for (PetscInt a = 0; a < d; a++) dot += st->X[a][k] * Bo[a];
    w[k] *= 1.0 - dot;
    sum += w[k] * PetscSqr(st->r[k]);
  }
  for (PetscInt k = 0; k < st->n; k++) w[k] *= 2.0 * (PetscReal)d / sum;
  PetscFunctionReturn(PETSC_SUCCESS);
}

#define DIFFERENCES                                                                                \
  (FORM_NULL_CONSTANTS | FORM_FULL_SUPPORT | FORM_SYMMETRIC | FORM_MOMENTUM | FORM_COUPLES)

#define ADAPTED                                                                                    \
  (FORM_NULL_CONSTANTS | FORM_EXACT_LINEAR | FORM_SAFE_IMPLICIT | FORM_VARYING | FORM_FULL_SUPPORT)

static const LaplacianRow laplacians[] = {
    {"mls3", "cubic moving least squares, second order on disorder too",
     "Liu & Gu, Meshfree Methods (2005); Kuhnert (1999)",
     FORM_NULL_CONSTANTS | FORM_EXACT_LINEAR | FORM_EXACT_QUADRATIC | FORM_SAFE_IMPLICIT |
         FORM_VARYING,
     0, LaplacianRow_Mls3, NULL, 0.0, NULL, PETSC_FALSE},
    {"corrected", "morris with -correction first_order under another name (VISC-04)",
     "Oger et al., J. Comput. Phys. 225 (2007)",
     FORM_NULL_CONSTANTS | FORM_FULL_SUPPORT | FORM_SAFE_IMPLICIT | FORM_VARYING, 0,
     LaplacianRow_Corrected, NULL, 0.0, NULL, PETSC_FALSE},
    {"direct_difference", "direct with differences of velocities; anti-diffusive, for comparison",
     "Basa, Quinlan & Lastiwka, Int. J. Numer. Meth. Fluids 60 (2009)", DIFFERENCES,
     CORRECTION_SHEPARD, LaplacianRow_DirectDifference, NULL, 1.0 / 3.0, NULL, PETSC_FALSE},
    {"fatehi_manzari", "exact for quadratics by a matrix per particle",
     "Fatehi & Manzari, Comput. Math. Appl. 61 (2011)", ADAPTED | FORM_EXACT_QUADRATIC, 0,
     LaplacianRow_FatehiManzari, NULL, 0.0, NULL, PETSC_FALSE},
    {"lsph", "renormalised meshless Laplacian", "Basic, Degiuli & Ban, J. Comput. Phys. 354 (2018)",
     ADAPTED, 0, LaplacianRow_Lsph, NULL, 0.0, NULL, PETSC_FALSE},
};

static const PluginRows rows[]     = {{&LaplacianTable, TABLE("Laplacians", laplacians)}};
const Plugin            IsphPlugin = PLUGIN(rows);
