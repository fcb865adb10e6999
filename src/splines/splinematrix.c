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

/* Assembles the matrix of the gradient along axis a, splines -> fluid [1/m]. */
static PetscErrorCode GradientMat(const Splines *s, const Particles *p, PetscInt a, Mat *G)
{
  PetscInt *width;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(p->n_fluid, &width));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscReal x[ISPH_MAX_DIM];

    for (PetscInt c = 0; c < p->dim; c++) x[c] = p->x[c][i];
    width[i] = SplineRowWidth(s, &s->pressure, x);
  }
  PetscCall(SplineMat(p->comm, p->n_fluid, s->own.size, width, G));
  PetscCall(PetscFree(width));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    const PetscInt row = p->row[i];
    PetscReal      x[ISPH_MAX_DIM];
    SplineRow      at;

    for (PetscInt c = 0; c < p->dim; c++) x[c] = p->x[c][i];
    SplineRowAt(s, &s->pressure, p, x, &at);
    PetscCall(MatSetValues(*G, 1, &row, at.n, at.number, at.gradient[a], ADD_VALUES));
  }
  PetscCall(SplineMatFinish(*G));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Assembles the matrix of the fit of component a from component b, fluid -> points. */
static PetscErrorCode FitMat(const Splines *s, const Particles *p, PetscInt a, PetscInt b, Mat *J)
{
  const SplineFits *f   = &s->fits;
  const PetscInt    set = f->sets == 1 ? 0 : a, of = f->sets == 1 ? 0 : b;
  PetscInt          row, *width;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(f->points, &width));
  for (PetscInt g = 0; g < f->points; g++) width[g] = f->last[set][of][g] - f->first[set][of][g];
  PetscCall(SplineMat(p->comm, f->points, p->n_fluid, width, J));
  PetscCall(PetscFree(width));
  PetscCall(MatGetOwnershipRange(*J, &row, NULL));
  for (PetscInt g = 0; g < f->points; g++, row++) {
    for (PetscInt k = f->first[set][of][g]; k < f->last[set][of][g]; k++) {
      if (ParticlesIsWall(p, f->j[k])) continue;
      PetscCall(MatSetValue(*J, row, p->row[f->j[k]], f->w[k], ADD_VALUES));
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
  Adds scale times T_a^T J_ab G_b, summed over b, to A; creates A at the first call

  MatTransposeMatMult() would add the parts of other ranks in the order in which they arrive, and
  runs would differ in their last digits.
*/
static PetscErrorCode AddProducts(const Splines *s, const Particles *p, PetscInt a, Mat *A)
{
  Mat fit = NULL, T, transposed, part, J, G;

  PetscFunctionBegin;
  for (PetscInt b = 0; b < s->lattice.dim; b++) {
    if (a != b && !s->fits.coupled) continue;
    PetscCall(FitMat(s, p, a, b, &J));
    PetscCall(GradientMat(s, p, b, &G));
    PetscCall(Multiply(J, G, &part));
    PetscCall(MatDestroy(&J));
    PetscCall(MatDestroy(&G));
    if (!fit) {
      fit = part;
      continue;
    }
    PetscCall(MatAXPY(fit, 1.0, part, DIFFERENT_NONZERO_PATTERN));
    PetscCall(MatDestroy(&part));
  }
  PetscCall(SplineGradientMat(p, s, a, &T));
  PetscCall(MatTranspose(T, MAT_INITIAL_MATRIX, &transposed));
  PetscCall(MatDestroy(&T));
  PetscCall(Multiply(transposed, fit, &part));
  PetscCall(MatDestroy(&transposed));
  PetscCall(MatDestroy(&fit));
  if (*A) {
    PetscCall(MatAXPY(*A, s->scale, part, DIFFERENT_NONZERO_PATTERN));
    PetscCall(MatDestroy(&part));
  } else {
    PetscCall(MatScale(part, s->scale));
    *A = part;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes A; splines that are no unknowns have the equation phi = 0. */
static PetscErrorCode SplineProduct(Splines *s, const Particles *p)
{
  Vec          diagonal;
  PetscScalar *d;
  PetscInt    *row;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < s->lattice.dim; a++) PetscCall(AddProducts(s, p, a, &s->A));
  if (s->extension) {
    PetscCall(PetscMalloc1(s->n_unused, &row));
    for (PetscInt k = 0; k < s->n_unused; k++) row[k] = s->own.start + s->unused[k];
    PetscCall(MatZeroRows(s->A, s->n_unused, row, 0.0, NULL, NULL));
    PetscCall(PetscFree(row));
    PetscCall(VecDuplicate(s->b, &diagonal));
    PetscCall(VecSet(diagonal, 0.0));
    PetscCall(VecGetArray(diagonal, &d));
    for (PetscInt k = 0; k < s->n_unused; k++) d[s->unused[k]] = 1.0;
    PetscCall(VecRestoreArray(diagonal, &d));
    PetscCall(MatSetOption(s->A, MAT_NEW_NONZERO_ALLOCATION_ERR, PETSC_FALSE));
    PetscCall(MatDiagonalSet(s->A, diagonal, ADD_VALUES));
    PetscCall(VecDestroy(&diagonal));
  }
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
