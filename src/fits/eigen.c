/*
  The dense eigenproblem K v = lambda M v, as of an axis of splines, with K and M symmetric and M
  positive definite. With M = L L^T it becomes the standard problem of L^-1 K L^-T, which is made
  tridiagonal by reflections and then diagonal by rotations. All matrices are stored row by row, and
  rotations and reflections combine rows.

  Reference: G. H. Golub, C. F. Van Loan, Matrix Computations, 4th edition, Johns Hopkins University
  Press (2013), algorithms 8.3.1 to 8.3.3
*/
#include "isph/fits.h"

#define MOST_SWEEPS 60 /* of rotations for an eigenvalue, on average; about 2 are usual */

/* Replaces the columns of X by the solutions of L Y = X, or of L^T Y = X; L has few entries. */
static void Substitute(PetscInt n, const PetscReal L[], PetscBool transposed, PetscReal X[])
{
  for (PetscInt k = 0; k < n; k++) {
    const PetscInt i   = transposed ? n - 1 - k : k;
    PetscReal     *row = &X[i * n];

    for (PetscInt m = 0; m < k; m++) {
      const PetscInt   j     = transposed ? n - 1 - m : m;
      const PetscReal  entry = transposed ? L[j * n + i] : L[i * n + j];
      const PetscReal *other = &X[j * n];

      if (entry == 0.0) continue;
      for (PetscInt c = 0; c < n; c++) row[c] -= entry * other[c];
    }
    for (PetscInt c = 0; c < n; c++) row[c] *= L[i * n + i]; /* the inverse */
  }
}

static void Transpose(PetscInt n, PetscReal X[])
{
  for (PetscInt i = 0; i < n; i++) {
    for (PetscInt j = 0; j < i; j++) {
      const PetscReal x = X[i * n + j];

      X[i * n + j] = X[j * n + i];
      X[j * n + i] = x;
    }
  }
}

/* Computes w = sum_i v_i row_i of X over rows from `first` on. */
static void CombineRows(PetscInt n, PetscInt first, const PetscReal v[], const PetscReal X[],
                        PetscReal w[])
{
  for (PetscInt c = 0; c < n; c++) w[c] = 0.0;
  for (PetscInt i = first; i < n; i++)
    for (PetscInt c = 0; c < n; c++) w[c] += v[i] * X[i * n + c];
}

/*
  Makes a symmetric matrix C tridiagonal by reflections 1 - b v v^T of rows and columns

  Output: d, e - the diagonal and the entries beside it of T = Q^T C Q; Z - the product of the
  reflections Q^T. Work: v, w - n numbers each.
*/
static void MakeTridiagonal(PetscInt n, PetscReal C[], PetscReal d[], PetscReal e[], PetscReal Z[],
                            PetscReal v[], PetscReal w[])
{
  for (PetscInt k = 0; k < n * n; k++) Z[k] = k % (n + 1) ? 0.0 : 1.0;
  for (PetscInt k = 0; k + 2 < n; k++) {
    PetscReal norm = 0.0, square, b, half = 0.0;

    for (PetscInt i = 0; i < n; i++) v[i] = i > k ? C[i * n + k] : 0.0;
    for (PetscInt i = k + 1; i < n; i++) norm += v[i] * v[i];
    norm = v[k + 1] > 0.0 ? -PetscSqrtReal(norm) : PetscSqrtReal(norm);
    v[k + 1] -= norm;
    square = 0.0;
    for (PetscInt i = k + 1; i < n; i++) square += v[i] * v[i];
    if (square == 0.0) continue;
    b = 2.0 / square;
    CombineRows(n, k + 1, v, C, w);
    for (PetscInt i = 0; i < n; i++) w[i] *= b;
    for (PetscInt i = k + 1; i < n; i++) half += 0.5 * b * w[i] * v[i];
    for (PetscInt i = 0; i < n; i++) w[i] -= half * v[i];
    for (PetscInt i = k; i < n; i++)
      for (PetscInt c = 0; c < n; c++) C[i * n + c] -= v[i] * w[c] + w[i] * v[c];
    CombineRows(n, k + 1, v, Z, w);
    for (PetscInt i = k + 1; i < n; i++)
      for (PetscInt c = 0; c < n; c++) Z[i * n + c] -= b * v[i] * w[c];
  }
  for (PetscInt i = 0; i < n; i++) d[i] = C[i * n + i];
  for (PetscInt i = 0; i + 1 < n; i++) e[i] = C[(i + 1) * n + i];
}

/* Does an implicit QR step with the shift of Wilkinson for rows l to m of a tridiagonal matrix. */
static void Sweep(PetscInt n, PetscInt l, PetscInt m, PetscReal d[], PetscReal e[], PetscReal Z[])
{
  const PetscReal half = 0.5 * (d[m - 1] - d[m]),
                  root = PetscSqrtReal(half * half + e[m - 1] * e[m - 1]);
  PetscReal x = d[l] - d[m] + PetscSqr(e[m - 1]) / (half + (half < 0.0 ? -root : root)), z = e[l];

  for (PetscInt k = l; k < m; k++) {
    const PetscReal r = PetscSqrtReal(x * x + z * z), c = r > 0.0 ? x / r : 1.0,
                    s = r > 0.0 ? z / r : 0.0;
    const PetscReal a = d[k], b = e[k], g = d[k + 1];
    PetscReal      *low = &Z[k * n], *high = &Z[(k + 1) * n];

    if (k > l) e[k - 1] = r;
    d[k]     = c * c * a + 2.0 * c * s * b + s * s * g;
    d[k + 1] = s * s * a - 2.0 * c * s * b + c * c * g;
    e[k]     = c * s * (g - a) + (c * c - s * s) * b;
    if (k + 1 < m) {
      x = e[k];
      z = s * e[k + 1];
      e[k + 1] *= c;
    }
    for (PetscInt i = 0; i < n; i++) {
      const PetscReal below = low[i];

      low[i]  = c * below + s * high[i];
      high[i] = c * high[i] - s * below;
    }
  }
}

static PetscBool IsSmall(const PetscReal d[], const PetscReal e[], PetscInt k)
{
  return PetscAbsReal(e[k]) <=
         PETSC_MACHINE_EPSILON * (PetscAbsReal(d[k]) + PetscAbsReal(d[k + 1]));
}

/* Makes a tridiagonal matrix diagonal and applies the rotations to the rows of Z; returns false if
   they do not converge. */
static PetscBool MakeDiagonal(PetscInt n, PetscReal d[], PetscReal e[], PetscReal Z[])
{
  PetscInt m = n - 1;

  for (PetscInt sweeps = 0; m > 0; sweeps++) {
    PetscInt l = m - 1;

    if (IsSmall(d, e, l)) {
      m--;
      continue;
    }
    if (sweeps > MOST_SWEEPS * n) return PETSC_FALSE;
    while (l > 0 && !IsSmall(d, e, l - 1)) l--;
    Sweep(n, l, m, d, e, Z);
  }
  return PETSC_TRUE;
}

/* Moves the least eigenvalue and its vector to the first place. */
static void PutLeastFirst(PetscInt n, PetscReal d[], PetscReal Z[])
{
  PetscInt  least = 0;
  PetscReal x;

  for (PetscInt k = 1; k < n; k++)
    if (d[k] < d[least]) least = k;
  x        = d[0];
  d[0]     = d[least];
  d[least] = x;
  for (PetscInt i = 0; i < n; i++) {
    x                = Z[i];
    Z[i]             = Z[least * n + i];
    Z[least * n + i] = x;
  }
}

/*
  DenseEigen - Solves K V = M V diag(lambda), V^T M V = 1, for n x n matrices

  Not collective.

  Input Parameters:
. K, M - symmetric; destroyed

  Output Parameters:
+ lambda - eigenvalues, the least first
- V      - eigenvectors in columns
*/
PetscErrorCode DenseEigen(PetscInt n, PetscReal K[], PetscReal M[], PetscReal lambda[],
                          PetscReal V[])
{
  PetscReal *e, *v, *w;

  PetscFunctionBegin;
  PetscCheck(!DenseCholesky(n, M), PETSC_COMM_SELF, PETSC_ERR_LIB,
             "The mass of splines is singular");
  for (PetscInt side = 0; side < 2; side++) {
    Substitute(n, M, PETSC_FALSE, K);
    Transpose(n, K);
  }
  PetscCall(PetscMalloc3(n, &e, n, &v, n, &w));
  MakeTridiagonal(n, K, lambda, e, V, v, w);
  PetscCheck(MakeDiagonal(n, lambda, e, V), PETSC_COMM_SELF, PETSC_ERR_LIB,
             "The eigenvalues of splines do not converge");
  PetscCall(PetscFree3(e, v, w));
  PutLeastFirst(n, lambda, V);
  Transpose(n, V);
  Substitute(n, M, PETSC_TRUE, V);
  PetscFunctionReturn(PETSC_SUCCESS);
}
