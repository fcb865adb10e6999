/* Corrections of the kernel for pairwise Laplacians, which read only its derivatives along the
   pair, W' and W''. A correction replaces both for each neighbour of a particle. Notation:
   laplacians.c. */
#include "rows.h"

/*
  CorrectKernel_Shepard - Computes derivatives of the kernel divided by the kernel sum

    psi_j = W_j/S,   S = sum_k V_k W_k with the particle itself
    W'  <- -(X/r).grad psi = W'/S + W (X.grad S)/(r S^2)
    W'' <- lap psi - (d-1) W'/r,
    lap psi = lap W/S - 2 grad W.grad S/S^2 - W lap S/S^2 + 2 W |grad S|^2/S^3

  A row with W'' + (d-1) W'/r is then the Laplacian of Shepard's interpolant. Reference: M. Basa, N.
  Quinlan, M. Lastiwka, Int. J. Numer. Meth. Fluids 60 (2009), Eqs (22), (23)
*/
static void CorrectKernel_Shepard(Stencil *st, PetscReal dW[], PetscReal ddW[])
{
  const PetscReal d = (PetscReal)st->dim;
  PetscReal       S = st->volume * st->self[0], lap_S = d * st->volume * st->self[2];
  PetscReal       grad_S[ISPH_MAX_DIM] = {0.0}, grad2 = 0.0;

  for (PetscInt k = 0; k < st->n; k++) {
    const PetscReal slope = st->dW[k] / st->r[k];

    S += st->V[k] * st->W[k];
    lap_S += st->V[k] * (st->ddW[k] + (d - 1.0) * slope);
    for (PetscInt a = 0; a < st->dim; a++) grad_S[a] -= st->V[k] * slope * st->X[a][k];
  }
  for (PetscInt a = 0; a < st->dim; a++) grad2 += PetscSqr(grad_S[a]);
  for (PetscInt k = 0; k < st->n; k++) {
    const PetscReal W = st->W[k], slope = st->dW[k] / st->r[k];
    PetscReal       along = 0.0, lap; /* X.grad S */

    for (PetscInt a = 0; a < st->dim; a++) along += st->X[a][k] * grad_S[a];
    lap = (st->ddW[k] + (d - 1.0) * slope) / S + (2.0 * slope * along - W * lap_S) / PetscSqr(S) +
          2.0 * W * grad2 / (S * S * S);
    dW[k]  = st->dW[k] / S + W * along / (st->r[k] * PetscSqr(S));
    ddW[k] = lap - (d - 1.0) * dW[k] / st->r[k];
  }
}

/* Computes the components of corrected gradients along the pairs, -(X/r).c/V. */
static ISPH_WIDE void AlongPairs(Stencil *st, unsigned correction, PetscReal dW[])
{
  const PetscInt n = LanesPadded(st->n);

  StencilGradients(st, correction);
  for (PetscInt k = 0; k < n; k++) dW[k] = 0.0;
  for (PetscInt a = 0; a < st->dim; a++) {
    const PetscReal *X = st->X[a], *c = st->slope[a];

    for (PetscInt k = 0; k < n; k++) dW[k] -= X[k] * c[k];
  }
  for (PetscInt k = 0; k < st->n; k++) dW[k] /= st->r[k] * st->V[k];
}

/*
  CorrectKernel_FirstOrder - Computes the derivative of the kernel along the pair from the corrected
  gradient M^-1 grad_i W

    W' <- -(X/r).M^-1 grad_i W,   M = sum_j V_j (grad_i W) X^T

  If the neighbours do not span space, M is the unit matrix, and st->regularised counts the row.
  Output: dW - corrected W'; any array except st->dW; ddW - W'' without correction; may be NULL.
  Reference: J. Bonet, T.-S. L. Lok, Comput. Methods Appl. Mech. Eng. 180 (1999) 97-115
*/
void CorrectKernel_FirstOrder(Stencil *st, PetscReal dW[], PetscReal ddW[])
{
  AlongPairs(st, CORRECTION_FIRST_ORDER, dW);
  for (PetscInt k = 0; ddW && k < st->n; k++) ddW[k] = st->ddW[k];
}

/* CorrectKernel_Mixed - Computes the derivative of Shepard's kernel along the pair from its
   corrected gradient M^-1 grad psi; W'' is left. Reference: J. Bonet, T.-S. L. Lok, Comput. Methods
   Appl. Mech. Eng. 180 (1999) 97-115; M. Basa, N. Quinlan, M. Lastiwka, Int. J. Numer. Meth. Fluids
   60 (2009), Eqs (24) to (26). */
static void CorrectKernel_Mixed(Stencil *st, PetscReal dW[], PetscReal ddW[])
{
  AlongPairs(st, CORRECTION_MIXED, dW);
  for (PetscInt k = 0; k < st->n; k++) ddW[k] = st->ddW[k];
}

static const CorrectionRow corrections[] = {
    /* name, brief, citation, bit, kernel */
    {"none", "no correction", NULL, 0, NULL},
    {"shepard", "kernel over the sum of kernels",
     "Basa, Quinlan & Lastiwka, Int. J. Numer. Meth. Fluids 60 (2009)", CORRECTION_SHEPARD,
     CorrectKernel_Shepard},
    {"first_order", "gradient times the inverse moment matrix; morris with it is corrected",
     "Bonet & Lok, Comput. Methods Appl. Mech. Eng. 180 (1999)", CORRECTION_FIRST_ORDER,
     CorrectKernel_FirstOrder},
    {"mixed", "first_order of the kernel of shepard",
     "Bonet & Lok (1999); Basa, Quinlan & Lastiwka (2009), Eqs (24) to (26)", CORRECTION_MIXED,
     CorrectKernel_Mixed},
};
const Table CorrectionTable = TABLE("Corrections of the kernel in Laplacians", corrections);
