/*
  The lattice of B-splines: its cells, and the values of the splines at a point.

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

/* SplineLatticeSet - Sets the cells and quadratic splines of a lattice over the box. Not
   collective. Input: ratio - edge of a cell over the spacing of the particles [-]. Notes: along an
   axis, spline i has its centre at (i - 1/2) cells from the low side; those next to a side extend
   beyond the box. In a periodic direction i + 1 replaces i, modulo the cells. */
PetscErrorCode SplineLatticeSet(const Scene *scene, PetscReal ratio, SplineLattice *lattice)
{
  PetscFunctionBegin;
  lattice->scene  = scene;
  lattice->degree = 2;
  lattice->dim    = scene->dim;
  for (PetscInt a = 0; a < scene->dim; a++) {
    const PetscReal length = scene->hi[a] - scene->lo[a];

    lattice->periodic[a] = SceneIsPeriodic(scene, a);
    lattice->cells[a]    = PetscMax(1, (PetscInt)(length / (ratio * scene->dx) + 0.5));
    lattice->count[a]    = lattice->cells[a] + (lattice->periodic[a] ? 0 : 2);
    lattice->lo[a]       = scene->lo[a];
    lattice->side[a]     = length / lattice->cells[a];
    for (PetscInt side = 2 * a; side < 2 * a + 2; side++)
      lattice->given[side] = BoundaryEquation(scene, side, FIT_PRESSURE) == EQUATION_VALUE;
  }
  PetscCall(SceneCountCells(scene->dim, lattice->count, &lattice->N));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineNatural - Returns the number of a spline in the order of the lattice, first axis fastest */
PetscInt SplineNatural(const SplineLattice *lattice, const PetscInt index[])
{
  PetscInt number = 0;

  for (PetscInt a = lattice->dim - 1; a >= 0; a--) number = number * lattice->count[a] + index[a];
  return number;
}

/* SplineIndex - Computes the index of spline k along each axis, first axis fastest, in a block of n
   splines along each axis that begins with `first` (NULL: with 0) */
void SplineIndex(PetscInt dim, const PetscInt first[], const PetscInt n[], PetscInt k,
                 PetscInt index[])
{
  for (PetscInt a = 0; a < dim; a++) {
    index[a] = (first ? first[a] : 0) + k % n[a];
    k /= n[a];
  }
}

/* Returns the centre of a spline along an axis of the uniform lattice [m]. */
static PetscReal CentreAlong(const SplineLattice *lattice, PetscInt a, PetscInt index)
{
  return lattice->lo[a] + (index + (lattice->periodic[a] ? 0.5 : -0.5)) * lattice->side[a];
}

/* SplineCentre - Computes the centre of a spline, which may be outside the box [m] */
void SplineCentre(const SplineLattice *lattice, const PetscInt index[], PetscReal x[])
{
  PetscReal slope;

  for (PetscInt a = 0; a < lattice->dim; a++)
    x[a] = SceneFromUniform(lattice->scene, a, CentreAlong(lattice, a, index[a]), &slope);
}

/* SplinePlace - Computes the centre of a spline, moved into the box if it is outside: the rank that
   has this point owns the spline [m] */
void SplinePlace(const SplineLattice *lattice, const PetscInt index[], PetscReal x[])
{
  for (PetscInt a = 0; a < lattice->dim; a++) {
    const PetscReal quarter = 0.25 * lattice->side[a];
    PetscReal       y       = CentreAlong(lattice, a, index[a]), slope;

    y    = PetscMax(y, lattice->lo[a] + quarter);
    y    = PetscMin(y, lattice->lo[a] + lattice->cells[a] * lattice->side[a] - quarter);
    x[a] = SceneFromUniform(lattice->scene, a, y, &slope);
  }
}

/* Returns the distance of the first knot from the low side in edges of cells. */
static PetscReal FirstKnot(const SplineLattice *lattice)
{
  return lattice->degree == 3 ? 0.5 : 0.0;
}

/* SplineFirstAlong - Returns the first spline along an axis that is not zero at a distance from the
   low side in edges of cells. Not collective. Indices continue beyond periodic sides. Beyond the
   last knots at a wall the polynomials of the adjacent piece continue. Therefore as many cubic
   splines as quadratic ones suffice: their coefficients outside are extrapolated cubically
   ("not-a-knot"). */
PetscInt SplineFirstAlong(const SplineLattice *lattice, PetscInt a, PetscReal distance)
{
  const PetscInt piece = (PetscInt)PetscFloorReal(distance - FirstKnot(lattice));

  if (lattice->periodic[a]) return piece - 1;
  return PetscMin(PetscMax(piece, 0), lattice->count[a] - lattice->degree - 1);
}

/* SplinePlaceAlong - Computes the first spline that is not zero at a position along an axis, the
   place t between two knots, from 0 to 1 except beyond the last knots, and the inverse of their
   distance [1/m]; not collective */
void SplinePlaceAlong(const SplineLattice *lattice, PetscInt a, PetscReal x, PetscInt *first,
                      PetscReal *t, PetscReal *per_edge)
{
  const PetscReal y        = SceneToUniform(lattice->scene, a, x);
  const PetscReal distance = (y - lattice->lo[a]) / lattice->side[a];
  PetscReal       slope;

  *first = SplineFirstAlong(lattice, a, distance);
  *t     = distance - FirstKnot(lattice) - (*first + (lattice->periodic[a] ? 1 : 0));
  (void)SceneFromUniform(lattice->scene, a, y, &slope);
  *per_edge = 1.0 / (slope * lattice->side[a]);
}

/*
  SplinesAt - Computes values and gradients of the splines that are not zero at a point

    psi(x) = prod_a b(s_a),   b = (1 - t)^2/2, 1/2 + t - t^2, t^2/2

  Not collective. t is the position between two knots along an axis of the uniform lattice. The
  knots of quadratic splines are the sides of cells, and the three polynomials belong to the splines
  centred in the cell below, in the cell and above it. See SplineBasis() for cubic splines.
*/
void SplinesAt(const SplineLattice *lattice, const PetscReal x[], SplineValues *values)
{
  const PetscInt dim = lattice->dim, m = lattice->degree + 1;
  PetscInt       first[ISPH_MAX_DIM];
  PetscReal      b[ISPH_MAX_DIM][SPLINES_ALONG], slope[ISPH_MAX_DIM][SPLINES_ALONG];

  for (PetscInt a = 0; a < dim; a++) {
    PetscReal t, per_edge;

    SplinePlaceAlong(lattice, a, x[a], &first[a], &t, &per_edge);
    SplineBasis(lattice->degree, t, per_edge, b[a], slope[a]);
  }
  values->n = SplinesAtPoint(lattice);
  for (PetscInt k = 0; k < values->n; k++) {
    const PetscInt digit[ISPH_MAX_DIM] = {k % m, k / m % m, k / (m * m)};

    values->value[k] = 1.0;
    for (PetscInt a = 0; a < dim; a++) {
      const PetscInt count = lattice->count[a];

      values->index[k][a] = first[a] + digit[a];
      if (lattice->periodic[a]) values->index[k][a] = (values->index[k][a] % count + count) % count;
      values->value[k] *= b[a][digit[a]];
      values->gradient[a][k] = 1.0;
      for (PetscInt c = 0; c < dim; c++)
        values->gradient[a][k] *= c == a ? slope[c][digit[c]] : b[c][digit[c]];
    }
  }
}

/* SplineSideGives - Returns true if a side gives the pressure; not collective */
PetscBool SplineSideGives(const SplineLattice *l)
{
  for (PetscInt side = 0; side < 2 * l->dim; side++)
    if (l->given[side]) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* SplineIsGiven - Returns true if the number of a spline is given by a side, the first in order;
   not collective */
PetscBool SplineIsGiven(const SplineLattice *l, const PetscInt index[], PetscInt *side)
{
  for (*side = 0; *side < 2 * l->dim; (*side)++) {
    const PetscInt a = *side / 2;

    if (l->given[*side] && index[a] == (*side % 2 ? l->count[a] - 1 : 0)) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* ---- the inverse of the stiffness ---- */

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
