/*
  The matrix of the pressure increment on splines, A = -scale^2 D G: the product of divergence and
  gradient. Moving particles change both in each step, so A is a shell that applies one after the
  other. Fixed particles keep them, so A is computed once; its product with a vector takes about an
  eighth of the operations.
*/
#include "splines.h"

/* Computes y = A x by the factors of A. */
static PetscErrorCode SplineMatrix(Mat A, Vec x, Vec y)
{
  Splines           *s;
  const PetscScalar *in;
  PetscScalar       *out;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(A, &s));
  PetscCall(VecZeroEntries(y));
  for (PetscInt b = 0; b < s->lattice.dim; b++) {
    PetscCall(MatMult(s->G[b], x, s->fluid));
    for (PetscInt a = 0; a < s->lattice.dim; a++) {
      const Mat J = SplineFit(s, s->J, a, b);

      if (!J) continue;
      PetscCall(MatMult(J, s->fluid, s->points));
      PetscCall(MatMultTransposeAdd(s->T[a], s->points, y, y));
    }
  }
  PetscCall(VecScale(y, s->scale));
  PetscCall(VecGetArrayRead(x, &in));
  PetscCall(VecGetArray(y, &out));
  for (PetscInt k = 0; k < s->n_unused; k++) out[s->unused[k]] = in[s->unused[k]];
  PetscCall(VecRestoreArray(y, &out));
  PetscCall(VecRestoreArrayRead(x, &in));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Adds scale times T[a]^T J[a][b] G[b], summed over b, to A; creates A at the first call

  MatTransposeMatMult() would add the parts of other ranks in the order in which they arrive, and
  runs would differ in their last digits.
*/
static PetscErrorCode AddProducts(const Splines *s, PetscInt a, Mat *A)
{
  Mat fit = NULL, transposed, part;

  PetscFunctionBegin;
  for (PetscInt b = 0; b < s->lattice.dim; b++) {
    const Mat J = SplineFit(s, s->J, a, b);

    if (!J) continue;
    PetscCall(MatMatMult(J, s->G[b], MAT_INITIAL_MATRIX, PETSC_DEFAULT, &part));
    if (!fit) {
      fit = part;
      continue;
    }
    PetscCall(MatAXPY(fit, 1.0, part, DIFFERENT_NONZERO_PATTERN));
    PetscCall(MatDestroy(&part));
  }
  PetscCall(MatTranspose(s->T[a], MAT_INITIAL_MATRIX, &transposed));
  PetscCall(MatMatMult(transposed, fit, MAT_INITIAL_MATRIX, PETSC_DEFAULT, &part));
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
static PetscErrorCode SplineProduct(Splines *s)
{
  Vec          diagonal;
  PetscScalar *d;

  PetscFunctionBegin;
  PetscCall(MatDestroy(&s->A));
  for (PetscInt a = 0; a < s->lattice.dim; a++) PetscCall(AddProducts(s, a, &s->A));
  if (s->bodies) {
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

/*
  SplinesMatrix - Creates the matrix of the pressure increment for the present particles

  Collective.
*/
PetscErrorCode SplinesMatrix(Flow *flow, Splines *s)
{
  const PetscBool product = SceneMoves(flow->scene) ? PETSC_FALSE : PETSC_TRUE;
  const PetscInt  own = s->own.size, all = s->lattice.N;

  PetscFunctionBegin;
  if (s->fluid_epoch != flow->particles->epoch) {
    PetscCall(VecDestroy(&s->fluid));
    PetscCall(FluidVec(flow->particles, NULL, &s->fluid));
    s->fluid_epoch = flow->particles->epoch;
  }
  if (product && s->product != s->assemblies) PetscCall(SplineProduct(s));
  s->product = s->assemblies;
  if (s->A) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MatCreateShell(flow->particles->comm, own, own, all, all, s, &s->A));
  PetscCall(MatShellSetOperation(s->A, MATOP_MULT, (void (*)(void))SplineMatrix));
  PetscFunctionReturn(PETSC_SUCCESS);
}
