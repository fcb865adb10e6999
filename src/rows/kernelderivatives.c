/* The viscous stress by second derivatives of the kernel, with or without Shepard's correction. Of
   these forms the published one damps uniform velocities, and the others amplify some velocities,
   so they serve for comparison only. Notation: laplacians.c. */
#include "rows.h"

/* Sums of kernels over a stencil, with the particle itself. */
typedef struct {
  PetscReal value, gradient[ISPH_MAX_DIM], hessian[ISPH_MAX_DIM * ISPH_MAX_DIM];
} KernelSum;

/* Returns the entry a, b of the Hessian of W_k: X_a X_b/r^2 (W'' - W'/r) + delta_ab W'/r. */
static PetscReal Hessian(const Stencil *st, PetscInt k, PetscInt a, PetscInt b)
{
  const PetscReal slope = st->dW[k] / st->r[k];

  return st->X[a][k] * st->X[b][k] / PetscSqr(st->r[k]) * (st->ddW[k] - slope) +
         (a == b ? slope : 0.0);
}

/* Returns component a of grad_i W_k. */
static PetscReal Gradient(const Stencil *st, PetscInt k, PetscInt a)
{
  return -st->X[a][k] * st->dW[k] / st->r[k];
}

static KernelSum SumKernels(const Stencil *st)
{
  const PetscInt d   = st->dim;
  KernelSum      sum = {.value = st->volume * st->self[0]};

  for (PetscInt a = 0; a < d; a++) sum.hessian[a * d + a] = st->volume * st->self[2];
  for (PetscInt k = 0; k < st->n; k++) {
    sum.value += st->V[k] * st->W[k];
    for (PetscInt a = 0; a < d; a++) {
      sum.gradient[a] += st->V[k] * Gradient(st, k, a);
      for (PetscInt b = 0; b < d; b++) sum.hessian[a * d + b] += st->V[k] * Hessian(st, k, a, b);
    }
  }
  return sum;
}

/* Returns the entry a, b of the Hessian of psi_k = W_k/S, S: kernel sum; Basa et al. (2009), Eq.
   (23). */
static PetscReal ShepardHessian(const Stencil *st, const KernelSum *sum, PetscInt k, PetscInt a,
                                PetscInt b)
{
  const PetscReal S = sum->value, *g = sum->gradient;

  return Hessian(st, k, a, b) / S -
         (Gradient(st, k, a) * g[b] + Gradient(st, k, b) * g[a] +
          st->W[k] * sum->hessian[a * st->dim + b]) /
             PetscSqr(S) +
         2.0 * st->W[k] * g[a] * g[b] / (S * S * S);
}

/*
  LaplacianRow_DirectDifference - Computes the viscous term by second derivatives of the kernel;
  couples velocity components

    lap u + 1/3 grad div u ~ sum_k V_k (tr(H_k) I + H_k/3) (u_k - u_i),   H_k = Hessian of W_k

  With the correction shepard H_k is the Hessian of W_k over the kernel sum. Constants then vanish,
  as in differences. Properties: symmetric for equal volumes; anti-diffusive like direct_scalar.
  Reference: M. Basa, N. Quinlan, M. Lastiwka, Int. J. Numer. Meth. Fluids 60 (2009), model A, Eqs
  (6), (23), (27), (28)
*/
PetscErrorCode LaplacianRow_DirectDifference(Stencil *st, PetscReal w[])
{
  const PetscInt  d       = st->dim;
  const PetscBool shepard = st->correction & CORRECTION_SHEPARD ? PETSC_TRUE : PETSC_FALSE;
  KernelSum       sum     = {0};

  PetscFunctionBegin;
  if (shepard) sum = SumKernels(st);
  for (PetscInt k = 0; k < st->n; k++) {
    PetscReal *block = &w[k * d * d], trace = 0.0;

    for (PetscInt e = 0; e < d * d; e++) {
      const PetscInt  a = e / d, b = e % d;
      const PetscReal hessian = shepard ? ShepardHessian(st, &sum, k, a, b) : Hessian(st, k, a, b);

      block[e] = st->V[k] * hessian / 3.0;
      if (a == b) trace += st->V[k] * hessian;
    }
    for (PetscInt a = 0; a < d; a++) block[a * d + a] += trace;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  LaplacianRow_Direct - Computes the viscous term by second derivatives of the kernel as published,
  without differences; couples velocity components

    lap u + 1/3 grad div u ~ sum_k V_k (tr(H_k) I + H_k/3) u_k   with the particle itself

  The row is that of LaplacianRow_DirectDifference() with a weight of the particle's own velocity,
  the sum of all weights, which is of order 1/dx^2. With the correction shepard this sum is zero.
  Properties: the Fourier transform of -(tr(H) I + H/3) is (k^2 I + k k^T/3) times that of the
  kernel, which is positive for Wendland's kernels. With these the form damps every velocity on any
  arrangement of particles, uniform velocities too. Reference: M. Basa, N. Quinlan, M. Lastiwka,
  Int. J. Numer. Meth. Fluids 60 (2009), model A, Eqs (6), (27), (28)
*/
PetscErrorCode LaplacianRow_Direct(Stencil *st, PetscReal w[])
{
  const PetscInt d = st->dim;

  PetscFunctionBegin;
  PetscCall(LaplacianRow_DirectDifference(st, w));
  if (st->correction & CORRECTION_SHEPARD) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt a = 0; a < d; a++)
    st->own[a * d + a] = st->volume * st->self[2] * ((PetscReal)d + 1.0 / 3.0);
  for (PetscInt k = 0; k < st->n; k++) {
    for (PetscInt e = 0; e < d * d; e++) st->own[e] += w[k * d * d + e];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
