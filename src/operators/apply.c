/*
  Products of operators with fields. A product reads the values of neighbours by their local index,
  so it needs no matrix: the values of a field are copied to the halo once, and the rows of all
  operators on this field are applied in one pass over the neighbours. Equal rows of a lattice whose
  neighbours follow each other are applied together. Operators that a wall
  treatment extends, or that couple components, are products with their matrices.
*/
#include "boundary_rows.h"

#define APPLY_MOST (ISPH_MAX_DIM + 2) /* operators in one pass: a gradient, viscosity, filter */

/* Collects the values of a field by local index, halo included. NULL stands for zeros. */
static PetscErrorCode SetValues(OperatorRows *rows, Vec f, Vec walls)
{
  const Particles *p   = rows->particles;
  const PetscInt   all = ParticlesAll(p);

  PetscFunctionBegin;
  if (all > rows->capacity) {
    rows->capacity = all + all / 8;
    PetscCall(PetscFree(rows->value));
    PetscCall(PetscMalloc1(rows->capacity, &rows->value));
  }
  PetscCall(LocalValues(p, f, walls, 1, rows->value));
  PetscCall(ParticlesHaloField(p, rows->value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the products of row i of n operators, over fluid or over walls, to sum[]. Input: weights -
   those of the row. Two partial sums of each hide the latency of additions. Inlined, so that the
   compiler knows n. */
static ISPH_INLINE void AddProducts(const Pattern *pattern, PetscInt i, PetscInt n,
                                    const PetscReal *const weights[], const PetscReal value[],
                                    PetscReal sum[])
{
  const PetscInt *local           = &pattern->local[pattern->row[i]];
  const PetscInt  last            = pattern->row[i + 1] - pattern->row[i];
  PetscReal       odd[APPLY_MOST] = {0.0};
  PetscInt        s               = 0;

  for (; s + 1 < last; s += 2) {
    const PetscReal even_value = value[local[s]], odd_value = value[local[s + 1]];

    for (PetscInt k = 0; k < n; k++) {
      sum[k] += weights[k][s] * even_value;
      odd[k] += weights[k][s + 1] * odd_value;
    }
  }
  for (PetscInt k = 0; k < n; k++) sum[k] += odd[k];
  if (s == last) return;
  for (PetscInt k = 0; k < n; k++) sum[k] += weights[k][s] * value[local[s]];
}

/* The terms of a product and its form. */
typedef struct {
  const PetscReal *a[APPLY_MOST], *b[APPLY_MOST]; /* weights of each operator */
  const PetscReal *apart[APPLY_MOST];             /* of its rows apart; NULL: a has all rows */
  PetscScalar     *y[APPLY_MOST];
  PetscBool        fluid, walls, add; /* terms over fluid and over walls; y is increased */
} Product;

/* Values of four rows of a run: in a vector register, and in an array. */
typedef PetscReal Lanes __attribute__((vector_size(4 * sizeof(PetscReal))));
typedef PetscReal Stored
    __attribute__((vector_size(4 * sizeof(PetscReal)), aligned(sizeof(PetscReal)), may_alias));
#define VECTORS (RUN_LANES / 4)

static ISPH_INLINE void LanesLoad(const PetscReal from[], Lanes to[VECTORS])
{
  for (PetscInt v = 0; v < VECTORS; v++) to[v] = ((const Stored *)from)[v];
}

/* Writes the sums of operator k to rows i and following. */
static ISPH_INLINE void LanesStore(const Lanes sum[VECTORS], PetscInt k, PetscInt i,
                                   const Product *product)
{
  Stored *y = (Stored *)(product->y[k] + i);

  for (PetscInt v = 0; v < VECTORS; v++) {
    if (product->add) y[v] += sum[v];
    else y[v] = sum[v];
  }
}

/* Computes the products of RUN_LANES rows of a run, from row i on. Sums have the same order as in
   AddProducts(). */
static ISPH_INLINE void ApplyLanes(const OperatorRows *rows, PetscInt i, PetscInt n,
                                   const Product *product)
{
  const PetscInt *local = &rows->fluid.local[rows->fluid.row[i]];
  const PetscInt  last = rows->fluid.row[i + 1] - rows->fluid.row[i], first = rows->first[i];
  PetscInt        s                        = 0;
  Lanes           sum[APPLY_MOST][VECTORS] = {{{0.0}}}, odd[APPLY_MOST][VECTORS] = {{{0.0}}};
  Lanes           even_value[VECTORS], odd_value[VECTORS];

  for (; s + 1 < last; s += 2) {
    LanesLoad(rows->value + local[s], even_value);
    LanesLoad(rows->value + local[s + 1], odd_value);
    for (PetscInt k = 0; k < n; k++) {
      for (PetscInt v = 0; v < VECTORS; v++) {
        sum[k][v] += product->a[k][first + s] * even_value[v];
        odd[k][v] += product->a[k][first + s + 1] * odd_value[v];
      }
    }
  }
  for (PetscInt k = 0; k < n; k++)
    for (PetscInt v = 0; v < VECTORS; v++) sum[k][v] += odd[k][v];
  if (s < last) {
    LanesLoad(rows->value + local[s], even_value);
    for (PetscInt k = 0; k < n; k++)
      for (PetscInt v = 0; v < VECTORS; v++) sum[k][v] += product->a[k][first + s] * even_value[v];
  }
  for (PetscInt k = 0; k < n; k++) LanesStore(sum[k], k, i, product);
}

/* Computes the products of row i. */
static ISPH_INLINE void ApplyRow(const OperatorRows *rows, PetscInt i, PetscInt n,
                                 const Product *product)
{
  const PetscReal *weights[APPLY_MOST];
  PetscReal        sum[APPLY_MOST] = {0.0};

  if (product->fluid) {
    for (PetscInt k = 0; k < n; k++) weights[k] = product->a[k] + rows->first[i];
    for (PetscInt k = 0; rows->apart[i] >= 0 && k < n; k++)
      if (product->apart[k]) weights[k] = product->apart[k] + rows->apart[i];
    AddProducts(&rows->fluid, i, n, weights, rows->value, sum);
  }
  if (product->walls) {
    for (PetscInt k = 0; k < n; k++) weights[k] = product->b[k] + rows->walls.row[i];
    AddProducts(&rows->walls, i, n, weights, rows->value, sum);
  }
  for (PetscInt k = 0; k < n; k++)
    product->y[k][i] = product->add ? product->y[k][i] + sum[k] : sum[k];
}

/* Computes the products of n operators, see ApplyRows(). Rows of runs have no walls and are not
   apart. */
static ISPH_INLINE void ApplyInline(const OperatorRows *rows, PetscInt n, const Product *product)
{
  PetscInt i = 0;

  for (PetscInt k = 0; product->fluid && k < rows->n_runs; k++) {
    const PetscInt end = rows->run[k][0] + rows->run[k][1];

    for (; i < rows->run[k][0]; i++) ApplyRow(rows, i, n, product);
    for (; i + RUN_LANES <= end; i += RUN_LANES) ApplyLanes(rows, i, n, product);
  }
  for (; i < rows->fluid.n; i++) ApplyRow(rows, i, n, product);
}

static ISPH_WIDE void ApplyProduct(const OperatorRows *rows, PetscInt n, const Product *product)
{
  switch (n) {
  case 1:
    ApplyInline(rows, 1, product);
    break;
  case 2:
    ApplyInline(rows, 2, product);
    break;
  case 3:
    ApplyInline(rows, 3, product);
    break;
  case 4:
    ApplyInline(rows, 4, product);
    break;
  default:
    ApplyInline(rows, n, product);
  }
}

/* Computes y_k = [y_k +] op_k f for n operators by their rows. Input: fluid - flag: the terms over
   fluid are added. */
static PetscErrorCode ApplyRows(PetscInt n, const AffineOperator *const op[], PetscBool fluid,
                                PetscBool add, Vec f, Vec walls, const Vec y[])
{
  OperatorRows *rows    = op[0]->rows;
  Product       product = {.fluid = fluid, .walls = walls != NULL, .add = add};

  PetscFunctionBegin;
  PetscCall(SetValues(rows, f, walls));
  for (PetscInt k = 0; k < n; k++) {
    product.a[k]     = op[k]->twin ? op[k]->twin->a : op[k]->a;
    product.b[k]     = op[k]->b;
    product.apart[k] = op[k]->twin ? op[k]->apart : NULL;
    PetscCall(VecGetArray(y[k], &product.y[k]));
  }
  ApplyProduct(rows, n, &product);
  for (PetscInt k = 0; k < n; k++) PetscCall(VecRestoreArray(y[k], &product.y[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the wall data of an operator, NULL without walls. */
static Vec WallData(const AffineOperator *op, Vec walls)
{
  const PetscBool has = op->rows ? op->rows->particles->N_wall > 0 : op->B != NULL;

  return has ? walls : NULL;
}

/*
  AffineApply - Computes the product of an operator with a field, y = A f + B e

  Collective. Input: f - values over fluid; walls - the wall data e, not read without walls.
*/
PetscErrorCode AffineApply(const AffineOperator *op, Vec f, Vec walls, Vec y)
{
  PetscFunctionBegin;
  PetscCall(AffineApplyAll(1, &op, f, walls, &y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* AffineApplyAdd - Computes y += A f + B e; collective */
PetscErrorCode AffineApplyAdd(const AffineOperator *op, Vec f, Vec walls, Vec y)
{
  const Vec e = WallData(op, walls);

  PetscFunctionBegin;
  if (op->rows) {
    PetscCall(ApplyRows(1, &op, PETSC_TRUE, PETSC_TRUE, f, e, &y));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MatMultAdd(op->A, f, y, y));
  if (e) PetscCall(MatMultAdd(op->B, e, y, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* AffineApplyWalls - Computes the part y = B e of the wall data; collective */
PetscErrorCode AffineApplyWalls(const AffineOperator *op, Vec walls, Vec y)
{
  const Vec e = WallData(op, walls);

  PetscFunctionBegin;
  if (!e) PetscCall(VecZeroEntries(y));
  else if (op->rows) PetscCall(ApplyRows(1, &op, PETSC_FALSE, PETSC_FALSE, NULL, e, &y));
  else PetscCall(MatMult(op->B, e, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  AffineApplyAll - Computes the products of n operators with the same field, y_k = A_k f + B_k e

  Collective. At most dim + 2 operators of the same Operators. One exchange of the halo and one pass
  over the neighbours serve all of them.
*/
PetscErrorCode AffineApplyAll(PetscInt n, const AffineOperator *const op[], Vec f, Vec walls,
                              const Vec y[])
{
  const AffineOperator *by_rows[APPLY_MOST];
  PetscInt              count = 0;
  Vec                   of_rows[APPLY_MOST];

  PetscFunctionBegin;
  PetscAssert(n <= APPLY_MOST, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE, "Too many operators");
  for (PetscInt k = 0; k < n; k++) {
    if (op[k]->rows) {
      by_rows[count]   = op[k];
      of_rows[count++] = y[k];
      continue;
    }
    PetscCall(MatMult(op[k]->A, f, y[k]));
    if (op[k]->B) PetscCall(MatMultAdd(op[k]->B, walls, y[k], y[k]));
  }
  if (count) {
    PetscCall(ApplyRows(count, by_rows, PETSC_TRUE, PETSC_FALSE, f, WallData(by_rows[0], walls),
                        of_rows));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
