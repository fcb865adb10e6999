/* Products of operators with fields. A product reads the values of neighbours by their local index,
   so it needs no matrix: the values of a field are copied to the halo once, and the rows of all
   operators on this field are applied in one pass over the neighbours. Equal rows of a lattice
   whose neighbours follow each other are applied together. Operators that a wall treatment extends,
   or that couple components, are products with their matrices. */
#include "fitted.h"

/* Collects the values of fields by local index, halo included, those of a particle one after
   another. NULL stands for zeros. */
static PetscErrorCode SetValues(OperatorRows *rows, PetscInt fields, const Vec f[],
                                const Vec walls[])
{
  const Particles *p   = rows->particles;
  const PetscInt   all = fields * ParticlesAll(p);

  PetscFunctionBegin;
  if (all > rows->capacity) {
    rows->capacity = all + all / 8;
    PetscCall(PetscFree(rows->value));
    PetscCall(PetscMalloc1(rows->capacity, &rows->value));
  }
  for (PetscInt c = 0; c < fields; c++)
    PetscCall(LocalValues(p, f[c], walls[c], fields, rows->value + c));
  if (fields == 1) PetscCall(ParticlesHaloField(p, rows->value));
  else PetscCall(ParticlesHaloVectors(p, rows->value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the products of row i of n operators, over fluid or over walls, to sum[]. Input: weights -
   those of the row. Partial sums of each hide the latency of additions. Inlined, so that the
   compiler knows n. */
static ISPH_INLINE void AddProducts(const Pattern *pattern, PetscInt i, PetscInt n,
                                    const PetscReal *const weights[], const PetscReal value[],
                                    PetscReal sum[])
{
  const PetscInt  parts                = n == 1 ? 4 : 2;
  const PetscInt *local                = &pattern->local[pattern->row[i]];
  const PetscInt  last                 = pattern->row[i + 1] - pattern->row[i];
  PetscReal       part[4][AFFINE_MOST] = {{0.0}};
  PetscInt        s                    = 0;

  for (; s + parts <= last; s += parts) {
    for (PetscInt q = 0; q < parts; q++) {
      const PetscReal f = value[local[s + q]];

      for (PetscInt k = 0; k < n; k++) part[q][k] += weights[k][s + q] * f;
    }
  }
  for (; s < last; s++)
    for (PetscInt k = 0; k < n; k++) sum[k] += weights[k][s] * value[local[s]];
  for (PetscInt q = 0; q < parts; q++)
    for (PetscInt k = 0; k < n; k++) sum[k] += part[q][k];
}

/* The terms of a product and its form. */
typedef struct {
  const PetscReal *a[AFFINE_MOST], *b[AFFINE_MOST]; /* weights of each operator */
  const PetscReal *apart[AFFINE_MOST];              /* of its rows apart; NULL: a has all rows */
  PetscScalar     *y[AFFINE_MOST];
  PetscBool        fluid, walls, add; /* terms over fluid and over walls; y is increased */
} Product;

/* Values of four rows of a run in a vector register; those in arrays are not aligned. */
typedef PetscReal Lanes __attribute__((vector_size(4 * sizeof(PetscReal))));
#define VECTORS (RUN_LANES / 4)

static ISPH_INLINE void LanesLoad(const PetscReal from[], Lanes to[VECTORS])
{
  for (PetscInt v = 0; v < VECTORS; v++) to[v] = *FourAt(from + 4 * v);
}

/* Writes the sums of operator k to rows i and following. */
static ISPH_INLINE void LanesStore(const Lanes sum[VECTORS], PetscInt k, PetscInt i,
                                   const Product *product)
{
  Four *y = (Four *)(product->y[k] + i);

  for (PetscInt v = 0; v < VECTORS; v++) {
    if (product->add) y[v] += sum[v];
    else y[v] = sum[v];
  }
}

/* Computes the products of RUN_LANES rows of a run, from row i on. Two partial sums of
   each hide the latency of additions. */
static ISPH_INLINE void ApplyLanes(const OperatorRows *rows, PetscInt i, PetscInt n,
                                   const Product *product)
{
  const PetscInt *local = &rows->fluid.local[rows->fluid.row[i]];
  const PetscInt  last = rows->fluid.row[i + 1] - rows->fluid.row[i], first = rows->first[i];
  PetscInt        s                         = 0;
  Lanes           sum[AFFINE_MOST][VECTORS] = {{{0.0}}}, odd[AFFINE_MOST][VECTORS] = {{{0.0}}};
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
  const PetscReal *weights[AFFINE_MOST];
  PetscReal        sum[AFFINE_MOST] = {0.0};

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

/* Computes y_k = [y_k +] op_k f for n operators by their stored rows. Input: fluid - flag: the
   terms over fluid are added. */
static PetscErrorCode ApplyStored(PetscInt n, const AffineOperator *const op[], PetscBool fluid,
                                  PetscBool add, Vec f, Vec walls, const Vec y[])
{
  OperatorRows *rows    = op[0]->rows;
  Product       product = {.fluid = fluid, .walls = walls != NULL, .add = add};

  PetscFunctionBegin;
  PetscCall(SetValues(rows, 1, &f, &walls));
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

/* Computes the products of the operators whose rows are made from fits, for all fields together. */
static PetscErrorCode ApplyFitted(const AffineProducts *of, PetscBool add)
{
  FittedProducts to   = {.fields = of->fields, .add = add};
  OperatorRows  *rows = NULL;
  Vec            walls[ISPH_MAX_DIM], y[ISPH_MAX_DIM][AFFINE_MOST];

  PetscFunctionBegin;
  for (PetscInt k = 0; k < of->n; k++) {
    if (!of->op[0][k]->rows || !of->op[0][k]->fitted) continue;
    rows = of->op[0][k]->rows;
    for (PetscInt c = 0; c < of->fields; c++) {
      to.op[c][to.n] = of->op[c][k];
      y[c][to.n]     = of->y[c][k];
      walls[c]       = WallData(of->op[c][k], of->walls[c]);
    }
    to.n++;
  }
  if (!to.n) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SetValues(rows, of->fields, of->f, walls));
  for (PetscInt e = 0; e < to.fields * to.n; e++)
    PetscCall(VecGetArray(y[e / to.n][e % to.n], &to.y[e / to.n][e % to.n]));
  PetscCall(FittedApply(&to, rows));
  for (PetscInt e = 0; e < to.fields * to.n; e++)
    PetscCall(VecRestoreArray(y[e / to.n][e % to.n], &to.y[e / to.n][e % to.n]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the products by rows. Input: fluid - flag: the terms over fluid are added; fields
   without them are zero over fluid. */
static PetscErrorCode ApplyRows(const AffineProducts *of, PetscBool fluid, PetscBool add)
{
  PetscFunctionBegin;
  PetscCall(ApplyFitted(of, add));
  for (PetscInt c = 0; c < of->fields; c++) {
    const AffineOperator *stored[AFFINE_MOST];
    PetscInt              n = 0;
    Vec                   y[AFFINE_MOST];

    for (PetscInt k = 0; k < of->n; k++) {
      if (!of->op[c][k]->rows || of->op[c][k]->fitted) continue;
      stored[n] = of->op[c][k];
      y[n++]    = of->y[c][k];
    }
    if (n)
      PetscCall(ApplyStored(n, stored, fluid, add, of->f[c], WallData(stored[0], of->walls[c]), y));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* AffineApply - Computes the product of an operator with a field, y = A f + B e. Collective. Input:
   f - values over fluid; walls - the wall data e, not read without walls; NULL: zero. */
PetscErrorCode AffineApply(const AffineOperator *op, Vec f, Vec walls, Vec y)
{
  PetscFunctionBegin;
  PetscCall(AffineApplyAll(1, &op, f, walls, &y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the product of one operator. */
static AffineProducts OneProduct(const AffineOperator *op, Vec f, Vec walls, Vec y)
{
  return (AffineProducts){
      .fields = 1, .n = 1, .op = {{op}}, .f = {f}, .walls = {walls}, .y = {{y}}};
}

/* AffineApplyAdd - Computes y += A f + B e; collective */
PetscErrorCode AffineApplyAdd(const AffineOperator *op, Vec f, Vec walls, Vec y)
{
  const Vec            e  = WallData(op, walls);
  const AffineProducts of = OneProduct(op, f, walls, y);

  PetscFunctionBegin;
  if (op->rows) {
    PetscCall(ApplyRows(&of, PETSC_TRUE, PETSC_TRUE));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MatMultAdd(op->A, f, y, y));
  if (e) PetscCall(MatMultAdd(op->B, e, y, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* AffineApplyWalls - Computes the part y = B e of the wall data; collective */
PetscErrorCode AffineApplyWalls(const AffineOperator *op, Vec walls, Vec y)
{
  const Vec            e  = WallData(op, walls);
  const AffineProducts of = OneProduct(op, NULL, walls, y);

  PetscFunctionBegin;
  if (!e) PetscCall(VecZeroEntries(y));
  else if (op->rows) PetscCall(ApplyRows(&of, PETSC_FALSE, PETSC_FALSE));
  else PetscCall(MatMult(op->B, e, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* AffineApplyAll - Computes the products of n operators with the same field, y_k = A_k f + B_k e.
   Collective. At most AFFINE_MOST operators of the same Operators. One exchange of the halo and one
   pass over the neighbours serve all of them. */
PetscErrorCode AffineApplyAll(PetscInt n, const AffineOperator *const op[], Vec f, Vec walls,
                              const Vec y[])
{
  AffineProducts of = {.fields = 1, .n = n, .f = {f}, .walls = {walls}};

  PetscFunctionBegin;
  PetscAssert(n <= AFFINE_MOST, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE, "Too many operators");
  for (PetscInt k = 0; k < n; k++) {
    of.op[0][k] = op[k];
    of.y[0][k]  = y[k];
  }
  PetscCall(AffineApplyFields(&of));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  AffineApplyFields - Computes the products of n operators with each of 1 or dim fields

    y_ck = A_ck f_c + B_ck e_c

  Collective. As AffineApplyAll(); operators whose rows are made from fits treat all fields in one
  pass.
*/
PetscErrorCode AffineApplyFields(const AffineProducts *of)
{
  PetscFunctionBegin;
  for (PetscInt e = 0; e < of->fields * of->n; e++) {
    const PetscInt        c = e / of->n, k = e % of->n;
    const AffineOperator *op = of->op[c][k];

    if (op->rows) continue;
    PetscCall(MatMult(op->A, of->f[c], of->y[c][k]));
    if (WallData(op, of->walls[c]))
      PetscCall(MatMultAdd(op->B, of->walls[c], of->y[c][k], of->y[c][k]));
  }
  PetscCall(ApplyRows(of, PETSC_TRUE, PETSC_FALSE));
  PetscFunctionReturn(PETSC_SUCCESS);
}
