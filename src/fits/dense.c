/* Small dense algebra for stencils, at most a few tens of rows: Cholesky factors of moment
   matrices, and elimination for unsymmetric matrices. */
#include "isph/fits.h"

/* DenseCholesky - Factors a symmetric positive definite matrix in place. Input/Output: a - n x n
   matrix by rows, of which the lower triangle is read; out: L with L L^T = a, the diagonal of L
   replaced by its inverse. Returns: 0, or 1 + the index of the first row whose pivot is at most
   1e-10 of its diagonal entry. */
PetscInt DenseCholesky(PetscInt n, PetscReal a[])
{
  for (PetscInt j = 0; j < n; j++) {
    const PetscReal diagonal = a[j * n + j];
    PetscReal       pivot    = diagonal;

    for (PetscInt k = 0; k < j; k++) pivot -= a[j * n + k] * a[j * n + k];
    if (!(pivot > 1e-10 * diagonal)) return j + 1;
    pivot        = 1.0 / PetscSqrtReal(pivot);
    a[j * n + j] = pivot;
    for (PetscInt i = j + 1; i < n; i++) {
      PetscReal sum = a[i * n + j];

      for (PetscInt k = 0; k < j; k++) sum -= a[i * n + k] * a[j * n + k];
      a[i * n + j] = sum * pivot;
    }
  }
  return 0;
}

/* DenseCholeskyRidge - Factors a symmetric matrix plus a multiple of the unit matrix. Tries the
   multiples ridge, 100 ridge, ... of the trace until the sum is positive definite. A matrix with
   NaN or infinity gives no valid factor. Input: a - n x n by rows; ridge - first multiple, divided
   by the trace. Output: factor - as from DenseCholesky(). */
void DenseCholeskyRidge(PetscInt n, const PetscReal a[], PetscReal ridge, PetscReal factor[])
{
  PetscReal trace = 0.0;

  for (PetscInt t = 0; t < n; t++) trace += a[t * n + t];
  if (!(trace > 0.0)) trace = 1.0;
  for (; ridge < 1e6; ridge *= 100.0) {
    for (PetscInt t = 0; t < n * n; t++) factor[t] = a[t];
    for (PetscInt t = 0; t < n; t++) factor[t * n + t] += ridge * trace;
    if (!DenseCholesky(n, factor)) return;
  }
}

/* DenseCholeskySolve - Solves L L^T x = b with the factor from DenseCholesky(); in: x holds b */
void DenseCholeskySolve(PetscInt n, const PetscReal factor[], PetscReal x[])
{
  for (PetscInt i = 0; i < n; i++) {
    for (PetscInt k = 0; k < i; k++) x[i] -= factor[i * n + k] * x[k];
    x[i] *= factor[i * n + i];
  }
  for (PetscInt i = n - 1; i >= 0; i--) {
    for (PetscInt k = i + 1; k < n; k++) x[i] -= factor[k * n + i] * x[k];
    x[i] *= factor[i * n + i];
  }
}

/* Exchanges columns p and q of a matrix with `rows` rows and n columns. */
static ISPH_INLINE void SwapColumns(PetscInt rows, PetscInt n, PetscReal A[], PetscInt p,
                                    PetscInt q)
{
  for (PetscInt r = 0; r < rows; r++) {
    const PetscReal kept = A[r * n + p];

    A[r * n + p] = A[r * n + q];
    A[r * n + q] = kept;
  }
}

/* Computes the result of DenseEliminate(); inlined, so that small systems have no loops. */
static ISPH_INLINE void Eliminate(PetscInt n, PetscReal A[], PetscInt rows, PetscReal B[])
{
  for (PetscInt p = 0; p < n; p++) {
    PetscInt best = p;

    for (PetscInt q = p + 1; q < n; q++)
      best = PetscAbsReal(A[p * n + q]) > PetscAbsReal(A[p * n + best]) ? q : best;
    if (A[p * n + best] == 0.0) continue;
    SwapColumns(n, n, A, p, best);
    SwapColumns(rows, n, B, p, best);
    for (PetscInt q = 0; q < n; q++) {
      const PetscReal factor = A[p * n + q] / A[p * n + p];

      if (q == p) continue;
      for (PetscInt r = p; r < n; r++) A[r * n + q] -= factor * A[r * n + p];
      for (PetscInt r = 0; r < rows; r++) B[r * n + q] -= factor * B[r * n + p];
    }
  }
}

/* DenseEliminate - Reduces the system X A = B to X D = B' with a diagonal D, by Gauss elimination
   with pivoting. Input/Output: A - n x n by rows; out: D on the diagonal, with zeros if A is
   singular; B - `rows` rows of length n; out: B', so that X_rq = B[r n + q]/D_q. */
void DenseEliminate(PetscInt n, PetscReal A[], PetscInt rows, PetscReal B[])
{
  if (n == 2 && rows == 2) Eliminate(2, A, 2, B);
  else Eliminate(n, A, rows, B);
}

/* MomentWeights - Computes the weights -V_k W'/r of the moment matrix M = sum_k V_k (grad_i W) X^T.
   Input: walls - false: the weights of wall neighbours are zero. */
ISPH_WIDE void MomentWeights(const Stencil *st, PetscBool walls, PetscReal weight[])
{
  const PetscInt n = LanesPadded(st->n);

  for (PetscInt k = 0; k < n; k++) weight[k] = -st->V[k] * st->dW[k] / st->r[k];
  for (PetscInt q = 0; !walls && q < st->n_wall; q++) weight[st->walls[q]] = 0.0;
}

/*
  MomentInverse - Inverts a second moment matrix of a stencil

    M_ab = sum_k weight_k X_a X_b

  Input: weight - weight of each neighbour; for the corrected kernel gradient those of
  MomentWeights(). Output: inverse - dim x dim by rows. Returns: PETSC_FALSE and the unit matrix if
  the neighbours do not span space
*/
PetscBool MomentInverse(const Stencil *st, const PetscReal weight[], PetscReal inverse[])
{
  const PetscInt d                              = st->dim;
  PetscReal      m[ISPH_MAX_DIM * ISPH_MAX_DIM] = {0.0};
  PetscBool      regular;

  for (PetscInt a = 0; a < d; a++) {
    for (PetscInt b = 0; b <= a; b++) {
      const PetscReal *Xa = st->X[a], *Xb = st->X[b];
      PetscReal        sum = 0.0;

#pragma omp simd reduction(+ : sum)
      for (PetscInt k = 0; k < st->n; k++) sum += weight[k] * Xa[k] * Xb[k];
      m[a * d + b] = sum;
    }
  }
  regular = DenseCholesky(d, m) ? PETSC_FALSE : PETSC_TRUE;
  for (PetscInt b = 0; b < d; b++) {
    PetscReal column[ISPH_MAX_DIM] = {0.0};

    column[b] = 1.0;
    if (regular) DenseCholeskySolve(d, m, column);
    for (PetscInt a = 0; a < d; a++) inverse[a * d + b] = column[a];
  }
  return regular;
}
