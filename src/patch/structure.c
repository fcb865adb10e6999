/* Structure of the matrix of the Laplacian in a patch test: row sums, signs, symmetry and size. */
#include "isph/patch.h"

/* Sums over the entries of own matrix rows. */
typedef struct {
  PetscReal *row_sum;        /* sum of each row */
  PetscReal  weights, wrong; /* sums of |weights| off the diagonal: of all, of negative weights */
} RowSums;

static PetscErrorCode AddRows(Mat M, PetscBool fluid, RowSums *sums)
{
  PetscInt start, end;

  PetscFunctionBegin;
  PetscCall(MatGetOwnershipRange(M, &start, &end));
  for (PetscInt i = start; i < end; i++) {
    const PetscInt    *col;
    const PetscScalar *value;
    PetscInt           n;

    PetscCall(MatGetRow(M, i, &n, &col, &value));
    for (PetscInt k = 0; k < n; k++) {
      sums->row_sum[i - start] += value[k];
      if (fluid && col[k] == i) continue;
      sums->weights += PetscAbsReal(value[k]);
      if (value[k] < 0.0) sums->wrong -= value[k];
    }
    PetscCall(MatRestoreRow(M, i, &n, &col, &value));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes |A - A^T|/|A| in the Frobenius norm. */
static PetscErrorCode Asymmetry(Mat A, PetscReal *asymmetry)
{
  Mat       T;
  PetscReal difference, norm;

  PetscFunctionBegin;
  PetscCall(MatTranspose(A, MAT_INITIAL_MATRIX, &T));
  PetscCall(MatAXPY(T, -1.0, A, DIFFERENT_NONZERO_PATTERN));
  PetscCall(MatNorm(T, NORM_FROBENIUS, &difference));
  PetscCall(MatNorm(A, NORM_FROBENIUS, &norm));
  PetscCall(MatDestroy(&T));
  *asymmetry = norm > 0.0 ? difference / norm : 0.0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AddSize(Mat M, PetscReal *entries, PetscReal *bytes)
{
  MatInfo info;

  PetscFunctionBegin;
  PetscCall(MatGetInfo(M, MAT_GLOBAL_SUM, &info));
  *entries += info.nz_used;
  /* a value and a column for each entry */
  *bytes += info.nz_used * (PetscReal)(sizeof(PetscScalar) + sizeof(PetscInt));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* PatchStructure - Reports the structure of the Laplacian L, L f = A f + B f_around, with A over
   the particles in the box and B over the particles around it. Collective. Reports row_sum_max, the
   largest |sum_j L_ij| dx^2; asymmetry, |A - A^T|/|A| (all particles have equal volumes);
   wrong_sign_share, the share of negative weights in the sum of all |weights| off the diagonal;
   nnz, the number of entries of A and B; and their memory_mb [MB]. */
PetscErrorCode PatchStructure(const Patch *patch, Report *report)
{
  const AffineOperator *L    = &patch->ops->velocity[0].visc;
  const PetscReal       dx2  = PetscSqr(patch->scene->dx);
  const PetscInt        n    = patch->particles->n_fluid;
  RowSums               sums = {NULL, 0.0, 0.0};
  PetscReal             part[2], worst = 0.0, asymmetry = 0.0, entries = 0.0, bytes = 0.0;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(n, &sums.row_sum));
  PetscCall(AddRows(L->A, PETSC_TRUE, &sums));
  PetscCall(AddRows(L->B, PETSC_FALSE, &sums));
  for (PetscInt i = 0; i < n; i++) worst = PetscMax(worst, dx2 * PetscAbsReal(sums.row_sum[i]));
  PetscCall(PetscFree(sums.row_sum));
  part[0] = sums.wrong;
  part[1] = sums.weights;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, part, 2, MPIU_REAL, MPIU_SUM, PETSC_COMM_WORLD));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &worst, 1, MPIU_REAL, MPIU_MAX, PETSC_COMM_WORLD));
  PetscCall(Asymmetry(L->A, &asymmetry));
  PetscCall(AddSize(L->A, &entries, &bytes));
  PetscCall(AddSize(L->B, &entries, &bytes));
  PetscCall(ReportAddError(report, "row_sum_max", worst));
  PetscCall(ReportAddError(report, "asymmetry", asymmetry));
  PetscCall(ReportAddError(report, "wrong_sign_share", part[0] / part[1]));
  PetscCall(ReportAdd(report, "nnz", entries));
  PetscCall(ReportAdd(report, "memory_mb", bytes / 1e6));
  PetscFunctionReturn(PETSC_SUCCESS);
}
