/* The gradient of the kernel as a vector, with the corrections of -correction. Forms that couple
   velocity components need its direction, which a correction turns away from the pair. Notation:
   laplacians.c. */
#include "rows.h"

/* Computes c_k = V_k grad_i W, and M = sum_k c_k X^T on the way; inlined for each dimension. */
static ISPH_INLINE void PlainAll(PetscInt d, Stencil *st, PetscReal *const c[], PetscReal M[])
{
  const PetscReal *const X[ISPH_MAX_DIM]  = {st->X[0], st->X[1], st->X[d - 1]};
  PetscReal *const       to[ISPH_MAX_DIM] = {c[0], c[1], c[d - 1]};
  const PetscInt         n                = LanesPadded(st->n);
  const PetscReal       *V = st->V, *dW = st->dW, *r = st->r;
  PetscReal             *radial = st->radial;
  Four                   sum[ISPH_MAX_DIM * ISPH_MAX_DIM];

#pragma GCC unroll 9
  for (PetscInt e = 0; e < d * d; e++) sum[e] = (Four){0.0};
  for (PetscInt k = 0; k < n; k += 4) {
    const Four weight = -*FourAt(V + k) * *FourAt(dW + k) / *FourAt(r + k);

    *(Four *)(void *)(radial + k) = weight;
#pragma GCC unroll 3
    for (PetscInt a = 0; a < d; a++) {
      const Four slope = weight * *FourAt(X[a] + k);

      *(Four *)(void *)(to[a] + k) = slope;
#pragma GCC unroll 3
      for (PetscInt b = 0; b <= a; b++) sum[a * d + b] += slope * *FourAt(X[b] + k);
    }
  }
  for (PetscInt a = 0; a < d; a++)
    for (PetscInt b = 0; b <= a; b++) M[a * d + b] = M[b * d + a] = FourSum(&sum[a * d + b]);
}

static ISPH_WIDE void PlainGradients(Stencil *st, PetscReal *const c[], PetscReal M[])
{
  if (st->dim == 2) PlainAll(2, st, c, M);
  else PlainAll(3, st, c, M);
}

/* Computes V_k grad psi_k from V_k grad_i W, with psi_k = W_k/S and the kernel sum S. */
static ISPH_WIDE void ShepardGradients(const Stencil *st, PetscReal *c[])
{
  PetscReal S = st->volume * st->self[0];

  for (PetscInt k = 0; k < st->n; k++) S += st->V[k] * st->W[k];
  for (PetscInt a = 0; a < st->dim; a++) {
    PetscReal grad_S = 0.0;

    for (PetscInt k = 0; k < st->n; k++) grad_S += c[a][k];
    for (PetscInt k = 0; k < st->n; k++) c[a][k] = (c[a][k] - st->V[k] * st->W[k] * grad_S / S) / S;
  }
}

/* Multiplies n gradients by a matrix; inlined for each dimension. */
static ISPH_INLINE void MultiplyAll(PetscInt d, PetscInt n, const PetscReal matrix[],
                                    PetscReal *c[])
{
  PetscReal *const to[ISPH_MAX_DIM] = {c[0], c[1], c[d - 1]};

  for (PetscInt k = 0; k < n; k++) {
    PetscReal sum[ISPH_MAX_DIM] = {0.0};

    for (PetscInt a = 0; a < d; a++)
      for (PetscInt b = 0; b < d; b++) sum[a] += matrix[a * d + b] * to[b][k];
    for (PetscInt a = 0; a < d; a++) to[a][k] = sum[a];
  }
}

static ISPH_WIDE void MultiplyGradients(PetscInt d, PetscInt n, const PetscReal matrix[],
                                        PetscReal *c[])
{
  if (d == 2) MultiplyAll(2, n, matrix, c);
  else MultiplyAll(3, n, matrix, c);
}

/* Computes M = sum_k c_k X^T. */
static ISPH_WIDE void Moments(const Stencil *st, PetscReal *const c[], PetscReal M[])
{
  const PetscInt d = st->dim, n = LanesPadded(st->n);

  for (PetscInt e = 0; e < d * d; e++) M[e] = LanesSum(n, c[e / d], st->X[e % d]);
}

/* Inverts a matrix of order 2 without pivoting: moments of a support are symmetric, or nearly so.
   Returns the smaller of its pivots. */
static PetscReal InvertTwo(const PetscReal M[], PetscReal inverse[])
{
  const PetscReal det = M[0] * M[3] - M[1] * M[2], over = 1.0 / det;

  inverse[0] = over * M[3];
  inverse[1] = -over * M[1];
  inverse[2] = -over * M[2];
  inverse[3] = over * M[0];
  return PetscMin(PetscAbsReal(M[0]), PetscAbsReal(det / M[0]));
}

/* Inverts a matrix of order d, and changes it; returns the smallest of its pivots. */
static PetscReal InvertAny(PetscInt d, PetscReal M[], PetscReal inverse[])
{
  PetscReal least = PETSC_MAX_REAL;

  for (PetscInt e = 0; e < d * d; e++) inverse[e] = e % (d + 1) ? 0.0 : 1.0;
  DenseEliminate(d, M, d, inverse);
  for (PetscInt a = 0; a < d; a++) least = PetscMin(least, PetscAbsReal(M[a * (d + 1)]));
  for (PetscInt e = 0; e < d * d; e++) inverse[e] /= M[e % d * (d + 1)];
  return least;
}

/* Multiplies the gradients by M^-1, M = sum_k c_k X^T; if the neighbours do not span space, M is
   the unit matrix, and st->regularised counts the row. Changes M. */
static void RenormalisedGradients(Stencil *st, PetscReal M[], PetscReal *c[])
{
  const PetscInt d = st->dim;
  PetscReal      inverse[ISPH_MAX_DIM * ISPH_MAX_DIM], trace = 0.0, least;

  for (PetscInt a = 0; a < d; a++) trace += PetscAbsReal(M[a * (d + 1)]);
  least = d == 2 ? InvertTwo(M, inverse) : InvertAny(d, M, inverse);
  if (least > MLS_WEAK * trace) MultiplyGradients(d, LanesPadded(st->n), inverse, c);
  else st->regularised++;
}

/*
  KernelGradients - Computes the volume of each neighbour times the corrected gradient of its kernel

    c_k = V_k grad_i W                                        no correction
    c_k = V_k grad (W/S),   S = sum_j V_j W_j                 shepard
    c_k = M^-1 V_k grad_i W,   M = sum_j V_j (grad_i W) X^T   first_order
    c_k = M^-1 V_k grad (W/S), with M of this gradient        mixed

  The gradient of a field is sum_k c_k (f_k - f_i). Input: correction - CorrectionBit; 0: none.
  Output: c - component a of neighbour k is c[a][k] [1/m]. Notes: sets st->radial too. Reference: M.
  Basa, N. Quinlan, M. Lastiwka, Int. J. Numer. Meth. Fluids 60 (2009), Eqs (2), (22), (24) to (26);
  J. Bonet, T.-S. L. Lok, Comput. Methods Appl. Mech. Eng. 180 (1999) 97-115
*/
void KernelGradients(Stencil *st, unsigned correction, PetscReal *c[])
{
  PetscReal M[ISPH_MAX_DIM * ISPH_MAX_DIM];

  PlainGradients(st, c, M);
  if (correction & (CORRECTION_SHEPARD | CORRECTION_MIXED)) ShepardGradients(st, c);
  if (correction & CORRECTION_MIXED) Moments(st, c, M);
  if (correction & (CORRECTION_FIRST_ORDER | CORRECTION_MIXED)) RenormalisedGradients(st, M, c);
}

/* StencilGradients - Computes st->slope, the gradients of KernelGradients(), unless the stencil has
   them. Forms and sums that share a correction share its moment matrix. Code that changes the
   volumes of the neighbours sets st->sloped to SLOPE_NONE. */
void StencilGradients(Stencil *st, unsigned correction)
{
  if (st->sloped == correction) return;
  KernelGradients(st, correction, st->slope);
  st->sloped = correction;
}
