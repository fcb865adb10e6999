/*
  The stiffness of splines in a box without bodies as a sum of tensor products, and the basis that
  makes it diagonal. With the mass M_a and the stiffness K_a along axis a,

    K = scale^2 (K_x (x) M_y + M_x (x) K_y),   K_a V_a = M_a V_a L_a,   V_a^T M_a V_a = I,
    K^-1 = V (scale^2 (L_x + L_y))^-1 V^T,     V = V_x (x) V_y,

  and alike in 3D. A product with V takes n operations for each spline and axis with n splines.

  References: R. E. Lynch, J. R. Rice, D. H. Thomas, Numer. Math. 6 (1964) 185-199; for splines
  G. Sangalli, M. Tani, SIAM J. Sci. Comput. 38 (2016) A3644-A3671
*/
#include "splines.h"
#include "fits/lanemonomials.h"

#define TILE_ROWS 4 /* of a tile of a product */
#define TILE_COLS 8

/* A product of matrices C = A B, row by row. */
typedef struct {
  PetscInt         rows, inner, cols;
  const PetscReal *A, *B;
  PetscReal       *C;
} Product;

/* Computes a tile of a product. */
static ISPH_INLINE void MultiplyTile(const Product *p, PetscInt row, PetscInt col)
{
  const PetscReal *A = p->A + row * p->inner, *B = p->B + col;
  Four             sum[TILE_ROWS][TILE_COLS / 4];

  for (PetscInt e = 0; e < TILE_ROWS * TILE_COLS / 4; e++) sum[e / 2][e % 2] = (Four){0.0};
  for (PetscInt k = 0; k < p->inner; k++, B += p->cols) {
    const Four left = *FourAt(B), right = *FourAt(B + 4);

#pragma GCC unroll 4
    for (PetscInt r = 0; r < TILE_ROWS; r++) {
      sum[r][0] += A[r * p->inner + k] * left;
      sum[r][1] += A[r * p->inner + k] * right;
    }
  }
  for (PetscInt r = 0; r < TILE_ROWS; r++) {
    *(Four *)&p->C[(row + r) * p->cols + col]     = sum[r][0];
    *(Four *)&p->C[(row + r) * p->cols + col + 4] = sum[r][1];
  }
}

/* Computes a product. The last tiles overlap their neighbours, with the same results. */
static ISPH_WIDE void Multiply(const Product *p)
{
  if (p->rows < TILE_ROWS || p->cols < TILE_COLS) {
    for (PetscInt i = 0; i < p->rows; i++) {
      for (PetscInt j = 0; j < p->cols; j++) {
        PetscReal sum = 0.0;

        for (PetscInt k = 0; k < p->inner; k++)
          sum += p->A[i * p->inner + k] * p->B[k * p->cols + j];
        p->C[i * p->cols + j] = sum;
      }
    }
    return;
  }
  for (PetscInt j = 0; j < p->cols; j += TILE_COLS) {
    for (PetscInt i = 0; i < p->rows; i += TILE_ROWS)
      MultiplyTile(p, PetscMin(i, p->rows - TILE_ROWS), PetscMin(j, p->cols - TILE_COLS));
  }
}

/* SplineTensorAlong - Multiplies an axis of a block of splines by V^T, or by V. Not collective.
   Input: n - splines of the block along each axis, all of them along axis a; back - V, not V^T;
   from - a number for each spline, first axis fastest. Output: to - the products. */
void SplineTensorAlong(const SplineTensor *t, const PetscInt n[], PetscInt a, PetscBool back,
                       const PetscReal from[], PetscReal to[])
{
  const SplineAxis *axis  = &t->axis[a];
  PetscInt          inner = 1, outer = 1;

  for (PetscInt c = 0; c < a; c++) inner *= n[c];
  for (PetscInt c = a + 1; c < t->dim; c++) outer *= n[c];
  if (a == 0) {
    Multiply(&(Product){outer, axis->n, axis->n, from, back ? axis->transposed : axis->V, to});
    return;
  }
  for (PetscInt k = 0; k < outer; k++) {
    const PetscInt at = k * axis->n * inner;

    Multiply(
        &(Product){axis->n, axis->n, inner, back ? axis->V : axis->transposed, from + at, to + at});
  }
}

/* SplineTensorDivide - Divides the numbers of a block in the basis V by the eigenvalues of K, but
   for a constant that no side gives, whose eigenvalue becomes 1; not collective */
void SplineTensorDivide(const SplineTensor *t, const PetscInt first[], const PetscInt n[],
                        PetscReal value[])
{
  const PetscInt layers = t->dim == 3 ? n[2] : 1;

  for (PetscInt k = 0; k < n[1] * layers; k++) {
    const PetscInt  j = first[1] + k % n[1], m = t->dim == 3 ? first[2] + k / n[1] : 0;
    const PetscReal across = t->axis[1].lambda[j] + (t->dim == 3 ? t->axis[2].lambda[m] : 0.0);
    PetscReal      *row    = value + k * n[0];

    for (PetscInt i = 0; i < n[0]; i++)
      if (first[0] + i + j + m || !t->floats) row[i] /= t->axis[0].lambda[first[0] + i] + across;
  }
}

/* Adds the products of the splines at the points of quadrature of an axis to its stiffness and its
   mass. */
static void AddPoints(const SplineLattice *l, PetscInt a, PetscReal K[], PetscReal M[])
{
  const PetscInt n = l->count[a];

  for (PetscInt g = 0; g < 2 * l->cells[a]; g++) {
    const PetscReal y = l->lo[a] + (g / 2 + 0.5 + (g % 2 ? GAUSS : -GAUSS)) * l->side[a];
    PetscReal       t, per_edge, slope, b[SPLINES_ALONG], d[SPLINES_ALONG];
    PetscInt        first;

    SplinePlaceAlong(l, a, SceneFromUniform(l->scene, a, y, &slope), &first, &t, &per_edge);
    SplineBasis(2, t, per_edge, b, d);
    for (PetscInt e = 0; e < 9; e++) {
      const PetscInt i = (first + e / 3 + n) % n, j = (first + e % 3 + n) % n;

      K[i * n + j] += 0.5 * slope * d[e / 3] * d[e % 3];
      M[i * n + j] += 0.5 * slope * b[e / 3] * b[e % 3];
    }
  }
}

/* Subtracts an outermost spline, whose number a side gives, from the next one, and takes it out of
   the sums of a matrix but for its diagonal entry. */
static void DropOutermost(PetscInt n, PetscInt outer, PetscInt next, PetscReal A[])
{
  for (PetscInt k = 0; k < n; k++) A[next * n + k] -= A[outer * n + k];
  for (PetscInt k = 0; k < n; k++) A[k * n + next] -= A[k * n + outer];
  for (PetscInt k = 0; k < n; k++)
    if (k != outer) A[k * n + outer] = A[outer * n + k] = 0.0;
}

/* Computes the basis of an axis from its stiffness and mass; floats: it has the constant. */
static PetscErrorCode SetAxis(PetscReal scale, PetscBool floats, PetscReal K[], PetscReal M[],
                              SplineAxis *axis)
{
  const PetscInt n = axis->n;

  PetscFunctionBegin;
  PetscCall(DenseEigen(n, K, M, axis->lambda, axis->V));
  for (PetscInt k = 0; k < n; k++) {
    axis->lambda[k] = k || !floats ? PetscSqr(scale) * axis->lambda[k] : 0.0;
    for (PetscInt i = 0; i < n; i++) axis->transposed[k * n + i] = axis->V[i * n + k];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Copies the basis of an axis with the same splines. */
static PetscErrorCode CopyAxis(const SplineAxis *from, SplineAxis *axis)
{
  PetscFunctionBegin;
  PetscCall(PetscArraycpy(axis->V, from->V, axis->n * axis->n));
  PetscCall(PetscArraycpy(axis->transposed, from->transposed, axis->n * axis->n));
  PetscCall(PetscArraycpy(axis->lambda, from->lambda, axis->n));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns true if two axes have the same splines, so that their matrices are equal. */
static PetscBool AxesAgree(const SplineLattice *l, PetscInt a, PetscInt b)
{
  return l->count[a] == l->count[b] && l->side[a] == l->side[b] &&
         l->given[2 * a] == l->given[2 * b] && l->given[2 * a + 1] == l->given[2 * b + 1] &&
         l->periodic[a] == l->periodic[b] && !SceneIsMapped(l->scene);
}

/* SplineTensorSet - Computes the basis for a lattice, redundantly on every rank; not collective.
   Input: scale - edge of a cell of the same volume [m] */
PetscErrorCode SplineTensorSet(const SplineLattice *lattice, PetscReal scale, SplineTensor *t)
{
  PetscFunctionBegin;
  t->dim    = lattice->dim;
  t->floats = SplineSideGives(lattice) ? PETSC_FALSE : PETSC_TRUE;
  for (PetscInt a = 0; a < t->dim; a++) {
    SplineAxis    *axis = &t->axis[a];
    const PetscInt n    = lattice->count[a];
    PetscReal     *K, *M;

    axis->n = n;
    PetscCall(PetscMalloc3(n * n, &axis->V, n * n, &axis->transposed, n, &axis->lambda));
    if (a > 0 && AxesAgree(lattice, a, a - 1)) {
      PetscCall(CopyAxis(&t->axis[a - 1], axis));
      continue;
    }
    PetscCall(PetscCalloc2(n * n, &K, n * n, &M));
    AddPoints(lattice, a, K, M);
    for (PetscInt end = 0; end < 2; end++) {
      const PetscInt outer = end ? n - 1 : 0, next = end ? n - 2 : 1;

      if (!lattice->given[2 * a + end]) continue;
      DropOutermost(n, outer, next, K);
      DropOutermost(n, outer, next, M);
    }
    PetscCall(SetAxis(scale, !lattice->given[2 * a] && !lattice->given[2 * a + 1], K, M, axis));
    PetscCall(PetscFree2(K, M));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineTensorFree - Frees the basis; not collective */
PetscErrorCode SplineTensorFree(SplineTensor *t)
{
  PetscFunctionBegin;
  for (PetscInt a = 0; a < t->dim; a++)
    PetscCall(PetscFree3(t->axis[a].V, t->axis[a].transposed, t->axis[a].lambda));
  PetscFunctionReturn(PETSC_SUCCESS);
}
