/*
  The matrix of the pressure increment on splines, A = -scale^2 D G: the product of divergence and
  gradient. Moving particles change both in each step, so A is a shell that applies one after the
  other. Fixed particles keep them, so A is computed once; its product with a vector takes about an
  eighth of the operations. On a lattice most rows repeat, see splinerepeats.c.
*/
#include "splines.h"

/* Context of the shell. */
typedef struct {
  Splines         *splines;
  const Particles *particles;
} SplineFactors;

/* Computes y = A x by the factors of A. */
static PetscErrorCode SplineMatrix(Mat A, Vec x, Vec y)
{
  SplineFactors     *factors;
  Splines           *s;
  const Particles   *p;
  const PetscScalar *in;
  PetscScalar       *out;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(A, &factors));
  s = factors->splines;
  p = factors->particles;
  PetscCall(SplinesGradient(s, x, s->fits.value));
  PetscCall(PetscArrayzero(s->fits.value + p->dim * p->n_fluid, p->dim * p->n_wall));
  PetscCall(SplinesIntegrate(p, s, y));
  PetscCall(VecScale(y, s->scale));
  PetscCall(VecGetArrayRead(x, &in));
  PetscCall(VecGetArray(y, &out));
  for (PetscInt k = 0; k < s->n_unused; k++) out[s->unused[k]] = in[s->unused[k]];
  PetscCall(VecRestoreArray(y, &out));
  PetscCall(VecRestoreArrayRead(x, &in));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Return the bounds of the entries of the fit of component a from component b at point g. */
static PetscInt First(const SplineFits *f, PetscInt a, PetscInt b, PetscInt g)
{
  return f->first[f->sets == 1 ? 0 : a][f->sets == 1 ? 0 : b][g];
}

static PetscInt Last(const SplineFits *f, PetscInt a, PetscInt b, PetscInt g)
{
  return f->last[f->sets == 1 ? 0 : a][f->sets == 1 ? 0 : b][g];
}

/* Assembles the matrix of the gradient, splines -> interlaced components over fluid [1/m]. */
static PetscErrorCode GradientMat(const Splines *s, const Particles *p, Mat *G)
{
  PetscInt *width;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(p->dim * p->n_fluid, &width));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscReal x[ISPH_MAX_DIM];

    for (PetscInt c = 0; c < p->dim; c++) x[c] = p->x[c][i];
    width[p->dim * i] = SplineRowWidth(s, &s->pressure, x);
    for (PetscInt c = 1; c < p->dim; c++) width[p->dim * i + c] = width[p->dim * i];
  }
  PetscCall(SplineMat(p->comm, p->dim * p->n_fluid, s->own.size, width, G));
  PetscCall(PetscFree(width));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscReal x[ISPH_MAX_DIM];
    SplineRow at;

    for (PetscInt c = 0; c < p->dim; c++) x[c] = p->x[c][i];
    SplineRowAt(s, &s->pressure, p, x, &at);
    for (PetscInt a = 0; a < p->dim; a++) {
      const PetscInt row = p->dim * p->row[i] + a;

      PetscCall(MatSetValues(*G, 1, &row, at.n, at.number, at.gradient[a], ADD_VALUES));
    }
  }
  PetscCall(SplineMatFinish(*G));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Assembles the matrix of the fit of component a, interlaced components over fluid -> points. */
static PetscErrorCode FitMat(const Splines *s, const Particles *p, PetscInt a, Mat *J)
{
  const SplineFits *f = &s->fits;
  PetscInt          row, *width;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(f->points, &width));
  for (PetscInt g = 0; g < f->points; g++)
    for (PetscInt b = 0; b < p->dim; b++)
      if (f->coupled || b == a) width[g] += Last(f, a, b, g) - First(f, a, b, g);
  PetscCall(SplineMat(p->comm, f->points, p->dim * p->n_fluid, width, J));
  PetscCall(PetscFree(width));
  PetscCall(MatGetOwnershipRange(*J, &row, NULL));
  for (PetscInt g = 0; g < f->points; g++, row++) {
    for (PetscInt b = 0; b < p->dim; b++) {
      if (b != a && !f->coupled) continue;
      for (PetscInt k = First(f, a, b, g); k < Last(f, a, b, g); k++) {
        if (ParticlesIsWall(p, f->j[k])) continue;
        PetscCall(MatSetValue(*J, row, p->dim * p->row[f->j[k]] + b, f->w[k], ADD_VALUES));
      }
    }
  }
  PetscCall(SplineMatFinish(*J));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the product of two matrices. PETSc's product keeps its factors; nothing needs them, and
   they are larger than the product. */
static PetscErrorCode Multiply(Mat left, Mat right, Mat *product)
{
  PetscFunctionBegin;
  PetscCall(MatMatMult(left, right, MAT_INITIAL_MATRIX, PETSC_DEFAULT, product));
  PetscCall(MatProductClear(*product));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Computes the matrix of the integrals of the velocity, sum_a T_a^T J_a with the integrals T_a along
  axis a and the fits J_a of component a: interlaced components over fluid -> splines; each J_a is
  multiplied by G first if it is given

  MatTransposeMatMult() would add the parts of other ranks in the order in which they arrive, and
  runs would differ in their last digits.
*/
static PetscErrorCode IntegralMat(const Splines *s, const Particles *p, Mat G, Mat *D)
{
  Mat T, transposed, part, J, fit;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < s->lattice.dim; a++) {
    PetscCall(FitMat(s, p, a, &J));
    fit = J;
    if (G) PetscCall(Multiply(J, G, &fit));
    if (G) PetscCall(MatDestroy(&J));
    PetscCall(SplineGradientMat(p, s, a, &T));
    PetscCall(MatTranspose(T, MAT_INITIAL_MATRIX, &transposed));
    PetscCall(MatDestroy(&T));
    PetscCall(Multiply(transposed, fit, a ? &part : D));
    PetscCall(MatDestroy(&transposed));
    PetscCall(MatDestroy(&fit));
    if (!a) continue;
    PetscCall(MatAXPY(*D, 1.0, part, DIFFERENT_NONZERO_PATTERN));
    PetscCall(MatDestroy(&part));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the rows of splines that are no unknowns to zero. */
static PetscErrorCode EmptyRows(const Splines *s, Mat A)
{
  PetscInt *row;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(s->n_unused, &row));
  for (PetscInt k = 0; k < s->n_unused; k++) row[k] = s->own.start + s->unused[k];
  PetscCall(MatZeroRows(A, s->n_unused, row, 0.0, NULL, NULL));
  PetscCall(PetscFree(row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  SplinesBlocks - Creates the matrices of gradient and divergence for the present particles, with
  interlaced components of the velocity

    G p = grad p,   D u = d of SplinesDivergence() without the terms of walls   [1/m]

  Collective. Rows of splines that are no unknowns are empty; columns are not if a side gives their
  number.
*/
PetscErrorCode SplinesBlocks(const Particles *p, const Splines *s, Mat *G, Mat *D)
{
  PetscFunctionBegin;
  PetscCall(GradientMat(s, p, G));
  PetscCall(IntegralMat(s, p, NULL, D));
  PetscCall(MatScale(*D, -1.0 / s->scale));
  if (s->extension) PetscCall(EmptyRows(s, *D));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes A; splines that are no unknowns have the equation phi = 0. */
static PetscErrorCode SplineProduct(Splines *s, const Particles *p)
{
  Mat G;

  PetscFunctionBegin;
  PetscCall(GradientMat(s, p, &G));
  PetscCall(IntegralMat(s, p, G, &s->A));
  PetscCall(MatDestroy(&G));
  PetscCall(MatScale(s->A, s->scale));
  if (!s->extension) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(EmptyRows(s, s->A));
  PetscCall(MatSetOption(s->A, MAT_NEW_NONZERO_ALLOCATION_ERR, PETSC_FALSE));
  for (PetscInt k = 0; k < s->n_unused; k++) {
    const PetscInt row = s->own.start + s->unused[k];

    PetscCall(MatSetValue(s->A, row, row, 1.0, ADD_VALUES));
  }
  PetscCall(SplineMatFinish(s->A));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FactorsDestroy(Mat A)
{
  SplineFactors *factors;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(A, &factors));
  PetscCall(PetscFree(factors));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the shell that applies the factors one after the other. */
static PetscErrorCode SplineShell(Splines *s, const Particles *p)
{
  const PetscInt own = s->own.size, all = s->lattice.N;
  SplineFactors *factors;

  PetscFunctionBegin;
  PetscCall(PetscNew(&factors));
  *factors = (SplineFactors){.splines = s, .particles = p};
  PetscCall(MatCreateShell(p->comm, own, own, all, all, factors, &s->A));
  PetscCall(MatShellSetOperation(s->A, MATOP_MULT, (void (*)(void))SplineMatrix));
  PetscCall(MatShellSetOperation(s->A, MATOP_DESTROY, (void (*)(void))FactorsDestroy));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  SplinesMatrix - Creates the matrix of the pressure increment for the present particles

  Collective. Input: multiplies - the solver needs no entries; then a single rank stores rows of
  fixed particles that repeat once.
*/
PetscErrorCode SplinesMatrix(const Particles *p, PetscBool multiplies, Splines *s)
{
  PetscMPIInt ranks;
  SplineRows *rows = NULL;

  PetscFunctionBegin;
  if (SceneMoves(s->lattice.scene)) {
    if (!s->A) PetscCall(SplineShell(s, p));
  } else if (s->product != s->assemblies) {
    PetscCallMPI(MPI_Comm_size(p->comm, &ranks));
    PetscCall(MatDestroy(&s->A));
    if (multiplies && ranks == 1) PetscCall(SplineRowsCompute(s, p, &rows));
    if (rows) PetscCall(SplineRowsShell(p->comm, rows, &s->A));
    else PetscCall(SplineProduct(s, p));
  }
  s->product = s->assemblies;
  PetscFunctionReturn(PETSC_SUCCESS);
}
