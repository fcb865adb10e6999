/*
  Splines on all ranks: their numbers, and the matrices that do not depend on the particles. A rank
  owns the splines whose centres are in its box.
*/
#include "splines.h"

/* Computes the splines of this rank along each axis: those whose centres are in its box. */
static void OwnBlock(const Splines *s, const Particles *p, SplineBlock *own)
{
  const SplineLattice *l = &s->lattice;

  own->size = 1;
  for (PetscInt a = 0; a < l->dim; a++) {
    PetscInt index[ISPH_MAX_DIM] = {0};

    own->first[a] = own->n[a] = 0;
    for (index[a] = 0; index[a] < l->count[a]; index[a]++) {
      PetscReal x[ISPH_MAX_DIM];

      SplineCentre(l, index, x);
      if (x[a] < p->lo[a]) own->first[a] = index[a] + 1;
      else if (x[a] < p->hi[a]) own->n[a]++;
    }
    own->size *= own->n[a];
  }
}

/* SplinesGlobal - Returns the global number of a spline; not collective */
PetscInt SplinesGlobal(const Splines *s, const Particles *p, const PetscInt index[])
{
  const SplineLattice *l      = &s->lattice;
  const SplineBlock   *b      = &s->own;
  PetscBool            own    = PETSC_TRUE;
  PetscInt             number = 0;

  for (PetscInt a = 0; a < l->dim; a++) {
    if (index[a] < b->first[a] || index[a] >= b->first[a] + b->n[a]) own = PETSC_FALSE;
  }
  if (!own) {
    PetscReal x[ISPH_MAX_DIM];

    SplineCentre(l, index, x);
    b = &s->block[ParticlesRankAt(p, x)];
  }
  for (PetscInt a = l->dim - 1; a >= 0; a--) number = number * b->n[a] + index[a] - b->first[a];
  return b->start + number;
}

/* Computes the splines at a point and their global numbers. */
static void NumbersAt(const Splines *s, const Particles *p, const PetscReal x[],
                      SplineValues *values, PetscInt number[])
{
  SplinesAt(&s->lattice, x, values);
  for (PetscInt k = 0; k < values->n; k++) number[k] = SplinesGlobal(s, p, values->index[k]);
}

static PetscErrorCode SparseMatrix(MPI_Comm comm, PetscInt rows, PetscInt cols, PetscInt width,
                                   Mat *A)
{
  PetscFunctionBegin;
  PetscCall(MatCreateAIJ(comm, rows, cols, PETSC_DETERMINE, PETSC_DETERMINE, width, NULL, width,
                         NULL, A));
  PetscCall(MatSetOption(*A, MAT_NEW_NONZERO_ALLOCATION_ERR, PETSC_FALSE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Finish(Mat A)
{
  PetscFunctionBegin;
  PetscCall(MatAssemblyBegin(A, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(A, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Assembles T. */
static PetscErrorCode AssembleInside(Splines *s, const Particles *p)
{
  const SplineLattice *l = &s->lattice;
  PetscInt             row;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < l->dim; a++)
    PetscCall(SparseMatrix(p->comm, s->inside.n, s->own.size, SPLINES_AT, &s->T[a]));
  PetscCall(MatGetOwnershipRange(s->T[0], &row, NULL));
  for (PetscInt g = 0; g < s->inside.n; g++, row++) {
    PetscInt     number[SPLINES_AT];
    PetscReal    x[ISPH_MAX_DIM], entry[SPLINES_AT];
    SplineValues at;

    for (PetscInt a = 0; a < l->dim; a++) x[a] = s->inside.x[a][g];
    NumbersAt(s, p, x, &at, number);
    for (PetscInt a = 0; a < l->dim; a++) {
      for (PetscInt k = 0; k < at.n; k++)
        entry[k] = s->inside.weight[g] * s->scale * at.gradient[a][k];
      PetscCall(MatSetValues(s->T[a], 1, &row, at.n, number, entry, ADD_VALUES));
    }
  }
  for (PetscInt a = 0; a < l->dim; a++) PetscCall(Finish(s->T[a]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the products of spline q with all splines at a point to the row of the stiffness, and its
   value to the mass. */
static PetscErrorCode AddProducts(Splines *s, const Particles *p, const PetscReal x[],
                                  PetscReal weight, PetscInt q, PetscReal *mass)
{
  PetscInt     number[SPLINES_AT];
  PetscReal    entry[SPLINES_AT];
  SplineValues at;

  PetscFunctionBegin;
  NumbersAt(s, p, x, &at, number);
  for (PetscInt k = 0; k < at.n; k++) {
    if (number[k] != q) continue;
    *mass += weight * at.value[k];
    for (PetscInt m = 0; m < at.n; m++) {
      PetscReal sum = 0.0;

      for (PetscInt a = 0; a < s->lattice.dim; a++) sum += at.gradient[a][k] * at.gradient[a][m];
      entry[m] = weight * PetscSqr(s->scale) * sum;
    }
    PetscCall(MatSetValues(s->K, 1, &q, at.n, number, entry, ADD_VALUES));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Assembles the stiffness K and the mass. Each rank computes its rows from all points in the
   supports of its splines, so that sums have the same order in every run. */
static PetscErrorCode AssembleStiffness(Splines *s, const Particles *p)
{
  const SplineLattice *l       = &s->lattice;
  const SplineBlock   *b       = &s->own;
  const PetscInt       corners = 1 << l->dim, cells = l->dim == 2 ? 9 : 27;

  PetscFunctionBegin;
  PetscCall(SparseMatrix(p->comm, b->size, b->size, l->dim == 2 ? 25 : 125, &s->K));
  PetscCall(VecCreateMPI(p->comm, b->size, PETSC_DETERMINE, &s->mass));
  for (PetscInt k = 0; k < b->size; k++) {
    PetscReal mass = 0.0;

    for (PetscInt m = 0; m < cells * corners; m++) {
      PetscInt  rest = k, cell = m / corners, corner = m % corners;
      PetscReal x[ISPH_MAX_DIM];
      PetscBool inside = PETSC_TRUE;

      for (PetscInt a = 0; a < l->dim; a++) {
        const PetscInt index = b->first[a] + rest % b->n[a];
        PetscInt       c     = index + cell % 3 - (l->periodic[a] ? 1 : 2);

        if (l->periodic[a]) c = (c + l->cells[a]) % l->cells[a];
        if (c < 0 || c >= l->cells[a]) inside = PETSC_FALSE;
        if (l->periodic[a] && cell % 3 >= l->cells[a]) inside = PETSC_FALSE; /* counted already */
        x[a] = l->lo[a] + (c + 0.5 + (corner % 2 ? GAUSS : -GAUSS)) * l->side[a];
        rest /= b->n[a];
        cell /= 3;
        corner /= 2;
      }
      if (inside) PetscCall(AddProducts(s, p, x, 1.0 / corners, b->start + k, &mass));
    }
    PetscCall(VecSetValue(s->mass, b->start + k, mass, INSERT_VALUES));
  }
  PetscCall(Finish(s->K));
  PetscCall(VecAssemblyBegin(s->mass));
  PetscCall(VecAssemblyEnd(s->mass));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Assembles S from the points on the boundary. */
static PetscErrorCode AssembleBoundary(Splines *s, const Particles *p)
{
  const SplineLattice *l   = &s->lattice;
  PetscBool            any = PETSC_FALSE;
  PetscInt             row;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < l->dim; a++) any = any || !l->periodic[a] ? PETSC_TRUE : PETSC_FALSE;
  if (!any) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SparseMatrix(p->comm, s->boundary.n, s->own.size, SPLINES_AT, &s->S));
  PetscCall(MatGetOwnershipRange(s->S, &row, NULL));
  for (PetscInt g = 0; g < s->boundary.n; g++, row++) {
    PetscInt     number[SPLINES_AT];
    PetscReal    x[ISPH_MAX_DIM], entry[SPLINES_AT];
    SplineValues at;

    for (PetscInt a = 0; a < l->dim; a++) x[a] = s->boundary.x[a][g];
    NumbersAt(s, p, x, &at, number);
    for (PetscInt k = 0; k < at.n; k++) entry[k] = s->boundary.weight[g] * at.value[k];
    PetscCall(MatSetValues(s->S, 1, &row, at.n, number, entry, ADD_VALUES));
  }
  PetscCall(Finish(s->S));
  PetscCall(MatCreateVecs(s->S, NULL, &s->wall_flux));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the vectors of coefficients, and takes the pressure from its kept copy. */
static PetscErrorCode CreateVectors(Splines *s, const Particles *p)
{
  const SplineBlock *b = &s->own;
  PetscInt          *natural;
  IS                 from, to;

  PetscFunctionBegin;
  PetscCall(VecDuplicate(s->mass, &s->p));
  PetscCall(VecDuplicate(s->mass, &s->phi));
  PetscCall(VecDuplicate(s->mass, &s->b));
  PetscCall(VecDuplicate(s->mass, &s->divergence));
  PetscCall(MatCreateVecs(s->T[0], NULL, &s->points));
  PetscCall(PetscMalloc1(b->size, &natural));
  for (PetscInt k = 0; k < b->size; k++) {
    PetscInt index[ISPH_MAX_DIM], rest = k;

    for (PetscInt a = 0; a < s->lattice.dim; a++) {
      index[a] = b->first[a] + rest % b->n[a];
      rest /= b->n[a];
    }
    natural[k] = SplineNatural(&s->lattice, index);
  }
  PetscCall(ISCreateStride(p->comm, b->size, b->start, 1, &from));
  PetscCall(ISCreateGeneral(p->comm, b->size, natural, PETSC_OWN_POINTER, &to));
  PetscCall(VecScatterCreate(s->p, from, s->natural, to, &s->renumber));
  PetscCall(ISDestroy(&from));
  PetscCall(ISDestroy(&to));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Frees all that depends on the numbers of the splines. */
static PetscErrorCode FreeNumbered(Splines *s)
{
  PetscFunctionBegin;
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) PetscCall(MatDestroy(&s->T[a]));
  PetscCall(MatDestroy(&s->S));
  PetscCall(MatDestroy(&s->K));
  PetscCall(MatDestroy(&s->A));
  PetscCall(VecDestroy(&s->mass));
  PetscCall(VecDestroy(&s->p));
  PetscCall(VecDestroy(&s->phi));
  PetscCall(VecDestroy(&s->b));
  PetscCall(VecDestroy(&s->divergence));
  PetscCall(VecDestroy(&s->points));
  PetscCall(VecDestroy(&s->wall_flux));
  PetscCall(VecScatterDestroy(&s->renumber));
  PetscCall(SplinePointsFree(&s->inside));
  PetscCall(SplinePointsFree(&s->boundary));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  SplinesNumber - Numbers the splines for the present boxes of the ranks, and assembles all that
  does not depend on the particles

  Collective. Does nothing unless the box of a rank has changed. Output: changed - flag.
*/
PetscErrorCode SplinesNumber(Flow *flow, Splines *s, PetscBool *changed)
{
  const Particles *p   = flow->particles;
  int              old = s->K ? 1 : 0;
  PetscMPIInt      ranks, rank;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < p->dim; a++) old = old && s->lo[a] == p->lo[a] && s->hi[a] == p->hi[a];
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &old, 1, MPI_INT, MPI_MIN, p->comm));
  *changed = old ? PETSC_FALSE : PETSC_TRUE;
  if (old) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FreeNumbered(s));
  PetscCallMPI(MPI_Comm_size(p->comm, &ranks));
  PetscCallMPI(MPI_Comm_rank(p->comm, &rank));
  if (!s->block) PetscCall(PetscMalloc1(ranks, &s->block));
  OwnBlock(s, p, &s->own);
  PetscCallMPI(MPI_Scan(&s->own.size, &s->own.start, 1, MPIU_INT, MPI_SUM, p->comm));
  s->own.start -= s->own.size;
  PetscCallMPI(MPI_Allgather(&s->own, (int)sizeof(s->own), MPI_BYTE, s->block, (int)sizeof(s->own),
                             MPI_BYTE, p->comm));
  for (PetscInt a = 0; a < p->dim; a++) {
    s->lo[a] = p->lo[a];
    s->hi[a] = p->hi[a];
  }
  PetscCall(SplinePointsSet(s, p));
  PetscCall(AssembleInside(s, p));
  PetscCall(AssembleStiffness(s, p));
  PetscCall(AssembleBoundary(s, p));
  PetscCall(CreateVectors(s, p));
  s->numbering++;
  PetscCall(SplinesBegin(s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplinesFree - Frees the splines; collective */
PetscErrorCode SplinesFree(Splines *s)
{
  PetscFunctionBegin;
  PetscCall(FreeNumbered(s));
  PetscCall(SplineRowsFree(s));
  PetscCall(VecDestroy(&s->natural));
  PetscCall(VecDestroy(&s->fluid));
  PetscCall(PetscFree(s->block));
  PetscFunctionReturn(PETSC_SUCCESS);
}
