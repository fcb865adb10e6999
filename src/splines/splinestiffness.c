/* The stiffness of the splines, for the preconditioner, and their mass. The points of quadrature
   are those of the velocity; in cut cells the integrals are approximate. */
#include "splines.h"

/* Computes the cells in the support of a spline; returns their number. */
static PetscInt SplineSupport(const Splines *s, const PetscInt index[], PetscInt first[],
                              PetscInt n[])
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

/* Computes cell k of a block of cells, first axis fastest; returns false outside the box. */
static PetscBool SplineBlockCell(const SplineLattice *l, const PetscInt first[], const PetscInt n[],
                                 PetscInt k, PetscInt cell[])
{
  SplineIndex(l->dim, first, n, k, cell);
  for (PetscInt a = 0; a < l->dim; a++) {
    if (l->periodic[a]) cell[a] = (cell[a] + 2 * l->cells[a]) % l->cells[a];
    if (cell[a] < 0 || cell[a] >= l->cells[a]) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* The extended splines in a cell, and the products of the splines that they consist of. */
typedef struct {
  PetscInt  n, number[SPLINES_EXTENDED];
  PetscBool own[SPLINES_EXTENDED];                         /* an own unknown */
  PetscReal part[SPLINES_AT_QUADRATIC][SPLINES_EXTENDED];  /* of spline k in extended spline e */
  PetscReal mass[1 << ISPH_MAX_DIM][SPLINES_AT_QUADRATIC]; /* psi, at the points of the cell */
  PetscReal K[SPLINES_AT_QUADRATIC][SPLINES_AT_QUADRATIC]; /* int scale^2 grad psi . grad psi */
  PetscReal M[SPLINES_AT_QUADRATIC][SPLINES_AT_QUADRATIC]; /* int psi psi */
} Element;

/* Lists the extended splines at a point; returns false if no own unknown is among them. */
static PetscBool ListParts(const Splines *s, const Particles *p, const SplineValues *at, Element *e)
{
  const PetscInt n    = SplinesAtPoint(&s->lattice);
  PetscBool      mine = PETSC_FALSE;

  e->n = 0;
  for (PetscInt k = 0; k < n; k++) {
    const SplineSlave *slave = SplineSlaveAt(s, at->index[k]);
    PetscInt           own[ISPH_MAX_DIM];

    for (PetscInt m = 0; m < (slave ? slave->n : 1); m++) {
      const PetscInt number = SplinesGlobal(s, p, slave ? slave->master[m] : at->index[k]);
      const PetscInt place  = number - s->own.start;
      PetscInt       f      = 0;

      while (f < e->n && e->number[f] != number) f++;
      if (f == e->n) {
        e->number[f] = number;
        e->own[f]    = place >= 0 && place < s->own.size && SplineOwn(s, place, own);
        for (PetscInt i = 0; i < n; i++) e->part[i][f] = 0.0;
        mine = mine || e->own[f];
        e->n++;
      }
      e->part[k][f] += slave ? slave->weight[m] : 1.0;
    }
  }
  return mine;
}

/* Computes point `corner` of a cell; returns its weight, or 0 unless it is in the cell or, with
   `only` of 0 or more, the point of this number outside. Nodes of cut cells may be outside. */
static PetscReal PointOf(const Splines *s, PetscInt c, PetscInt corner, PetscInt only,
                         PetscReal x[])
{
  PetscInt  cell[ISPH_MAX_DIM], node;
  PetscReal weight;
  PetscBool inside;

  SplineIndex(s->lattice.dim, NULL, s->lattice.cells, c, cell);
  weight = SplinePoint(s, cell, corner, x, &node);
  inside = node < 0 || SplineCellAt(&s->lattice, x) == c;
  return (only < 0 ? inside : corner == only && !inside) ? weight : 0.0;
}

/* Integrates the products of the splines over points of a cell; those of gradients over the
   density. Input: density - of all splines; NULL: uniform. */
static void Integrate(const Splines *s, const Particles *p, PetscInt c, PetscInt only,
                      const PetscScalar density[], Element *e)
{
  const SplineLattice *l = &s->lattice;
  const PetscInt       n = SplinesAtPoint(l);

  for (PetscInt k = 0; k < n * n; k++) e->K[k / n][k % n] = e->M[k / n][k % n] = 0.0;
  for (PetscInt corner = 0; corner < 1 << l->dim; corner++) {
    PetscReal       x[ISPH_MAX_DIM];
    const PetscReal weight = PointOf(s, c, corner, only, x);
    PetscReal       rho    = 1.0, slope[ISPH_MAX_DIM];
    SplineValues    at;

    SplinesAt(l, x, &at);
    if (density) rho = SplineSumAt(s, p, density, x, slope);
    for (PetscInt k = 0; k < n; k++) {
      e->mass[corner][k] = weight * at.value[k];
      for (PetscInt m = 0; weight > 0.0 && m < n; m++) {
        PetscReal sum = 0.0;

        for (PetscInt a = 0; a < l->dim; a++) sum += at.gradient[a][k] * at.gradient[a][m];
        e->K[k][m] += weight * PetscSqr(s->scale) * sum / rho;
        e->M[k][m] += weight * at.value[k] * at.value[m];
      }
    }
  }
}

/* Computes the products of extended spline f with all. */
static void ExtendRow(PetscInt n, const Element *e, PetscInt f,
                      const PetscReal product[][SPLINES_AT_QUADRATIC], PetscReal row[])
{
  PetscReal half[SPLINES_AT_QUADRATIC] = {0.0};

  for (PetscInt g = 0; g < e->n; g++) row[g] = 0.0;
  for (PetscInt k = 0; k < n; k++)
    for (PetscInt m = 0; e->part[k][f] != 0.0 && m < n; m++)
      half[m] += e->part[k][f] * product[k][m];
  for (PetscInt m = 0; m < n; m++)
    for (PetscInt g = 0; g < e->n; g++) row[g] += half[m] * e->part[m][g];
}

/* Adds the products of the splines at points of a cell to the rows of own splines: the stiffness
   and, unless it is NULL, M, the integrals of products of values; adds their values to the mass. */
static PetscErrorCode AddPoints(Splines *s, const Particles *p, PetscInt c, PetscInt only,
                                const PetscScalar density[], Element *e, Mat M, PetscReal mass[])
{
  const PetscInt n = SplinesAtPoint(&s->lattice), points = 1 << s->lattice.dim;
  PetscInt       first = PetscMax(only, 0);
  PetscReal      x[ISPH_MAX_DIM], row[SPLINES_EXTENDED];
  SplineValues   at;

  PetscFunctionBegin;
  while (first < points && PointOf(s, c, first, only, x) <= 0.0) first++;
  if (first == points) PetscFunctionReturn(PETSC_SUCCESS);
  SplinesAt(&s->lattice, x, &at);
  if (!ListParts(s, p, &at, e)) PetscFunctionReturn(PETSC_SUCCESS);
  Integrate(s, p, c, only, density, e);
  for (PetscInt f = 0; f < e->n; f++) {
    if (!e->own[f]) continue;
    for (PetscInt k = 0; k < n * points; k++)
      if (e->part[k % n][f] != 0.0)
        mass[e->number[f] - s->own.start] += e->part[k % n][f] * e->mass[k / n][k % n];
    ExtendRow(n, e, f, e->K, row);
    PetscCall(MatSetValues(s->K, 1, &e->number[f], e->n, e->number, row, ADD_VALUES));
    if (!M) continue;
    ExtendRow(n, e, f, e->M, row);
    PetscCall(MatSetValues(M, 1, &e->number[f], e->n, e->number, row, ADD_VALUES));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the products of the splines in all cells. */
static PetscErrorCode AddCells(Splines *s, const Particles *p, const PetscScalar density[], Mat M,
                               PetscReal mass[])
{
  PetscInt cells = 1;
  Element *e;

  PetscFunctionBegin;
  PetscCall(PetscNew(&e));
  for (PetscInt a = 0; a < s->lattice.dim; a++) cells *= s->lattice.cells[a];
  for (PetscInt c = 0; c < cells; c++) {
    const PetscInt outside = s->bodies && s->bodies->cut[c] >= 0 ? 1 << s->lattice.dim : 0;

    for (PetscInt only = -1; only < outside; only++)
      PetscCall(AddPoints(s, p, c, only, density, e, M, mass));
  }
  PetscCall(PetscFree(e));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the number of entries in the rows of own splines: the splines that are not zero in a
   cell of their supports. Work: seen - one number for each spline, zeros at first. */
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

/* SplineUnusedRows - Adds the equation phi = 0 of own splines that are no unknowns to a matrix */
PetscErrorCode SplineUnusedRows(const Splines *s, Mat A)
{
  PetscFunctionBegin;
  for (PetscInt k = 0; k < s->n_unused; k++) {
    const PetscInt row = s->own.start + s->unused[k];

    PetscCall(MatSetValue(A, row, row, 1.0, ADD_VALUES));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineStiffness - Assembles the stiffness K and the mass; collective. Each rank computes its rows
   from all cells in the supports of its splines, so that sums have the same order in every run. */
PetscErrorCode SplineStiffness(Splines *s, const Particles *p)
{
  const SplineBlock *b = &s->own;
  PetscInt          *width, *seen;
  PetscReal         *mass;
  Mat                M = NULL;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(b->size, &width));
  PetscCall(PetscCalloc1(s->lattice.N, &seen));
  RowWidths(s, seen, width);
  PetscCall(SplineMat(p->comm, b->size, b->size, width, &s->K));
  if (s->bodies || s->has_products) PetscCall(SplineMat(p->comm, b->size, b->size, width, &M));
  PetscCall(FreeAll(&width, &seen));
  PetscCall(VecCreateMPI(p->comm, b->size, PETSC_DETERMINE, &s->mass));
  PetscCall(PetscMalloc1(b->size, &s->unused));
  s->n_unused = 0;
  PetscCall(PetscCalloc1(b->size, &mass));
  PetscCall(AddCells(s, p, NULL, M, mass));
  for (PetscInt k = 0; k < b->size; k++) {
    PetscInt index[ISPH_MAX_DIM];

    if (!SplineOwn(s, k, index)) s->unused[s->n_unused++] = k;
    else PetscCall(VecSetValue(s->mass, b->start + k, mass[k], INSERT_VALUES));
  }
  PetscCall(SplineUnusedRows(s, s->K));
  if (M) PetscCall(SplineUnusedRows(s, M));
  PetscCall(PetscFree(mass));
  PetscCall(SplineMatFinish(s->K));
  if (M) PetscCall(SplineMatFinish(M));
  if (s->bodies) PetscCall(SetAbsoluteMass(s, M));
  if (SplineSideGives(&s->lattice)) { /* the equations of others lose the numbers of the side */
    PetscCall(SplineClear(s, PETSC_TRUE, 1.0, s->K));
    if (M) PetscCall(SplineClear(s, PETSC_TRUE, 1.0, M));
  }
  if (s->has_products) s->M = M;
  else PetscCall(MatDestroy(&M));
  PetscCall(VecAssemblyBegin(s->mass));
  PetscCall(VecAssemblyEnd(s->mass));
  s->products++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineStiffnessFollow - Assembles the stiffness with the present densities, int scale^2/rho
   grad psi . grad psi; collective */
PetscErrorCode SplineStiffnessFollow(Splines *s, const Particles *p)
{
  SplineMixture     *m = &s->mixture;
  const PetscScalar *density;
  PetscReal         *mass;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(s->own.size, &mass));
  PetscCall(VecScatterBegin(m->collect, m->density, m->all, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecScatterEnd(m->collect, m->density, m->all, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecGetArrayRead(m->all, &density));
  PetscCall(MatZeroEntries(s->K));
  PetscCall(AddCells(s, p, density, NULL, mass));
  PetscCall(VecRestoreArrayRead(m->all, &density));
  PetscCall(SplineUnusedRows(s, s->K));
  PetscCall(SplineMatFinish(s->K));
  PetscCall(PetscFree(mass));
  s->products++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- sums over strain cells ---- */

/* SplineProductMat - Computes the product of two matrices, without the factors that PETSc's product
   keeps: they are larger, and nothing needs them; collective */
PetscErrorCode SplineProductMat(Mat left, Mat right, Mat *product)
{
  PetscFunctionBegin;
  PetscCall(MatMatMult(left, right, MAT_INITIAL_MATRIX, PETSC_DEFAULT, product));
  PetscCall(MatProductClear(*product));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineGathered - Multiplies the transpose of P by T; collective */
PetscErrorCode SplineGathered(Mat P, Mat T, Mat *D)
{
  Mat transposed;

  PetscFunctionBegin;
  PetscCall(MatTranspose(P, MAT_INITIAL_MATRIX, &transposed));
  PetscCall(SplineProductMat(transposed, T, D));
  PetscCall(MatDestroy(&transposed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineCellVolumes - Creates the vector of the volumes of own cells; collective */
PetscErrorCode SplineCellVolumes(const Particles *p, const StrainCells *cells, Mat all, Vec *volume)
{
  PetscInt     row = 0;
  PetscScalar *m;
  PetscReal    x[ISPH_MAX_DIM];

  PetscFunctionBegin;
  PetscCall(MatCreateVecs(all, NULL, volume));
  PetscCall(VecGetArrayWrite(*volume, &m));
  for (PetscInt c = 0; c < cells->n; c++)
    if (StrainHasCell(p, cells, c, x)) m[row++] = cells->volume[c];
  PetscCall(VecRestoreArrayWrite(*volume, &m));
  PetscFunctionReturn(PETSC_SUCCESS);
}
