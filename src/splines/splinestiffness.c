/*
  The stiffness of the splines, for the preconditioner, and their mass. The points of quadrature are
  those of the velocity; in cut cells the integrals are approximate.
*/
#include "splines.h"

/* Adds the products of spline q with all splines at a point to the rows of the stiffness and,
   unless it is NULL, of M, the integrals of products of values; adds its value to the mass. */
static PetscErrorCode AddProducts(Splines *s, const Particles *p, const PetscReal x[],
                                  PetscReal weight, PetscInt q, Mat M, PetscReal *mass)
{
  PetscReal entry[SPLINES_EXTENDED];
  SplineRow at;

  PetscFunctionBegin;
  SplineRowAt(s, &s->lattice, p, x, &at);
  for (PetscInt k = 0; k < at.n; k++) {
    if (at.number[k] != q) continue;
    *mass += weight * at.value[k];
    for (PetscInt m = 0; m < at.n; m++) {
      PetscReal sum = 0.0;

      for (PetscInt a = 0; a < s->lattice.dim; a++) sum += at.gradient[a][k] * at.gradient[a][m];
      entry[m] = weight * PetscSqr(s->scale) * sum;
    }
    PetscCall(MatSetValues(s->K, 1, &q, at.n, at.number, entry, ADD_VALUES));
    if (!M) continue;
    for (PetscInt m = 0; m < at.n; m++) entry[m] = weight * at.value[k] * at.value[m];
    PetscCall(MatSetValues(M, 1, &q, at.n, at.number, entry, ADD_VALUES));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineSupport - Computes the cells in the support of a spline; returns their number; not
   collective */
PetscInt SplineSupport(const Splines *s, const PetscInt index[], PetscInt first[], PetscInt n[])
{
  const SplineLattice *l     = &s->lattice;
  PetscInt             cells = 1;

  for (PetscInt a = 0; a < l->dim; a++) {
    PetscInt low = 0, high = 0;

    if (s->extension) {
      low  = s->extension->range[SplineNatural(l, index)].low[a];
      high = s->extension->range[SplineNatural(l, index)].high[a];
    }
    first[a] = index[a] + low - (l->periodic[a] ? 1 : 2);
    n[a]     = 3 + high - low;
    if (l->periodic[a]) n[a] = PetscMin(n[a], l->cells[a]);
    cells *= n[a];
  }
  return cells;
}

/* SplineBlockCell - Computes cell k of a block of cells of a lattice, first axis fastest; returns
   false outside the box; not collective */
PetscBool SplineBlockCell(const SplineLattice *l, const PetscInt first[], const PetscInt n[],
                          PetscInt k, PetscInt cell[])
{
  SplineIndex(l->dim, first, n, k, cell);
  for (PetscInt a = 0; a < l->dim; a++) {
    if (l->periodic[a]) cell[a] = (cell[a] + 2 * l->cells[a]) % l->cells[a];
    if (cell[a] < 0 || cell[a] >= l->cells[a]) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* Adds all points in the support of an own spline to its rows. */
static PetscErrorCode AddSupport(Splines *s, const Particles *p, PetscInt k, Mat M, PetscReal *mass)
{
  const SplineLattice *l       = &s->lattice;
  const PetscInt       corners = 1 << l->dim;
  PetscInt             index[ISPH_MAX_DIM], first[ISPH_MAX_DIM], n[ISPH_MAX_DIM], cells;

  PetscFunctionBegin;
  (void)SplineOwn(s, k, index);
  cells = SplineSupport(s, index, first, n);
  for (PetscInt m = 0; m < cells * corners; m++) {
    PetscInt  cell[ISPH_MAX_DIM], node;
    PetscReal x[ISPH_MAX_DIM], weight;

    if (!SplineBlockCell(l, first, n, m / corners, cell)) continue;
    weight = SplinePoint(s, cell, m % corners, x, &node);
    if (weight > 0.0) PetscCall(AddProducts(s, p, x, weight, s->own.start + k, M, mass));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Computes the number of entries in the rows of own splines: the splines that are not zero in a cell
  of their supports

  Work: seen - one number for each spline, zeros at first.
*/
static void RowWidths(const Splines *s, PetscInt seen[], PetscInt width[])
{
  const SplineLattice *l = &s->lattice;

  for (PetscInt k = 0; k < s->own.size; k++) {
    PetscInt index[ISPH_MAX_DIM], first[ISPH_MAX_DIM], n[ISPH_MAX_DIM], cells;

    width[k] = l->dim == 3 ? 25 * PetscMin(5, l->count[2]) : 25;
    if (!SplineOwn(s, k, index) || !s->extension) continue;
    cells    = SplineSupport(s, index, first, n);
    width[k] = 0;
    for (PetscInt c = 0; c < cells; c++) {
      PetscInt cell[ISPH_MAX_DIM], number[SPLINES_EXTENDED], found;

      if (!SplineBlockCell(l, first, n, c, cell)) continue;
      found = SplinesInCell(l, s->extension, cell, number);
      for (PetscInt e = 0; e < found; e++) {
        width[k] += seen[number[e]] == k + 1 ? 0 : 1;
        seen[number[e]] = k + 1;
      }
    }
  }
}

/* Sets the mass of splines that may be negative in places: sum_r |int psi_q psi_r|. */
static PetscErrorCode SetAbsoluteMass(Splines *s, Mat M)
{
  PetscFunctionBegin;
  for (PetscInt q = s->own.start; q < s->own.start + s->own.size; q++) {
    const PetscScalar *entry;
    PetscReal          sum = 0.0;
    PetscInt           n;

    PetscCall(MatGetRow(M, q, &n, NULL, &entry));
    for (PetscInt k = 0; k < n; k++) sum += PetscAbsScalar(entry[k]);
    PetscCall(MatRestoreRow(M, q, &n, NULL, &entry));
    PetscCall(VecSetValue(s->mass, q, sum > 0.0 ? sum : 1.0, INSERT_VALUES));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Removes the numbers that sides give from the equations of the others: K and M stay symmetric. */
static PetscErrorCode DropGiven(Splines *s, Mat M)
{
  PetscInt *row;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(s->n_unused, &row));
  for (PetscInt k = 0; k < s->n_unused; k++) row[k] = s->own.start + s->unused[k];
  PetscCall(MatZeroRowsColumns(s->K, s->n_unused, row, 1.0, NULL, NULL));
  if (M) PetscCall(MatZeroRowsColumns(M, s->n_unused, row, 1.0, NULL, NULL));
  PetscCall(PetscFree(row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineStiffness - Assembles the stiffness K and the mass; collective. Each rank computes its rows
   from all points in the supports of its splines, so that sums have the same order in every run. */
PetscErrorCode SplineStiffness(Splines *s, const Particles *p)
{
  const SplineBlock *b = &s->own;
  PetscInt          *width, *seen;
  Mat                M = NULL;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(b->size, &width));
  PetscCall(PetscCalloc1(s->lattice.N, &seen));
  RowWidths(s, seen, width);
  PetscCall(SplineMat(p->comm, b->size, b->size, width, &s->K));
  if (s->bodies || s->has_products) PetscCall(SplineMat(p->comm, b->size, b->size, width, &M));
  PetscCall(PetscFree(width));
  PetscCall(PetscFree(seen));
  PetscCall(VecCreateMPI(p->comm, b->size, PETSC_DETERMINE, &s->mass));
  PetscCall(PetscMalloc1(b->size, &s->unused));
  s->n_unused = 0;
  for (PetscInt k = 0; k < b->size; k++) {
    PetscInt  index[ISPH_MAX_DIM];
    PetscReal mass = 0.0;

    if (SplineOwn(s, k, index)) {
      PetscCall(AddSupport(s, p, k, M, &mass));
      PetscCall(VecSetValue(s->mass, b->start + k, mass, INSERT_VALUES));
    } else {
      s->unused[s->n_unused++] = k;
      PetscCall(MatSetValue(s->K, b->start + k, b->start + k, 1.0, ADD_VALUES));
      if (M) PetscCall(MatSetValue(M, b->start + k, b->start + k, 1.0, ADD_VALUES));
    }
  }
  PetscCall(SplineMatFinish(s->K));
  if (M) PetscCall(SplineMatFinish(M));
  if (s->bodies) PetscCall(SetAbsoluteMass(s, M));
  if (SplineSideGives(&s->lattice)) PetscCall(DropGiven(s, M));
  if (s->has_products) s->M = M;
  else PetscCall(MatDestroy(&M));
  PetscCall(VecAssemblyBegin(s->mass));
  PetscCall(VecAssemblyEnd(s->mass));
  PetscFunctionReturn(PETSC_SUCCESS);
}
