/*
  Pressures of free surfaces in the coupled system. There the row of mass is q - Z u = 0, the normal
  stress at the surface. Its unknown q is replaced by q - Z u, which the row gives:

    [F G; D C] [u; q] = [F + G Z, G; D + C Z, C] [u; q - Z u]

  F alone has no condition on the normal stress and an eigenvalue with negative real part for each
  particle of the surface; no Schur complement of F has a simple approximation. F + G Z has both
  conditions of the surface, and the approximations of schur.c suit its Schur complement:
  theory.md, (surface:system) and (surface:schur). The products G Z and C Z are never formed but for
  direct solvers: they have twice the entries of F.
*/
#include "saddle.h"

#define KEY_Z "isph_surface" /* of Z with the blocks */

/* SaddleCreateStress - Creates Z, the rows of -D on free surfaces; collective */
PetscErrorCode SaddleCreateStress(const Flow *flow, Saddle *s)
{
  const Operators   *ops  = flow->ops;
  const AffineLayout rows = {1,       s->dim, -flow->scene->dx,
                             s->mass, NULL,   ops->free ? ops->free->kind : NULL};

  PetscFunctionBegin;
  if (ops->free) PetscCall(AffineBlock(flow->particles, &ops->rows, &rows, ops->div, &s->Z));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The context of the product A. Its vectors take the parts of others, which lie one behind the
   other on each rank: sub-vectors would be made anew in each product, by several reductions. */
typedef struct {
  Mat P, Z;
  Vec from, stress; /* velocities; q' + Z u */
  Vec to[2], part;  /* rows of momentum and of mass; q' */
} Product;

/* Computes y = [F G; D C] (u, q' + Z u) for x = (u, q'). */
static PetscErrorCode Product_Mult(Mat A, Vec x, Vec y)
{
  Product           *a;
  Mat              **block;
  const PetscScalar *in;
  PetscScalar       *out;
  PetscInt           n;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(A, (void *)&a));
  PetscCall(MatNestGetSubMats(a->P, NULL, NULL, &block));
  PetscCall(VecGetLocalSize(a->from, &n));
  PetscCall(VecGetArrayRead(x, &in));
  PetscCall(VecGetArrayWrite(y, &out));
  PetscCall(VecPlaceArray(a->from, in));
  PetscCall(VecPlaceArray(a->part, in + n));
  PetscCall(MatMultAdd(a->Z, a->from, a->part, a->stress));
  for (PetscInt k = 0; k < 2; k++) {
    PetscCall(VecPlaceArray(a->to[k], k ? out + n : out));
    PetscCall(MatMult(block[k][0], a->from, a->to[k]));
    PetscCall(MatMultAdd(block[k][1], a->stress, a->to[k], a->to[k]));
    PetscCall(VecResetArray(a->to[k]));
  }
  PetscCall(VecResetArray(a->part));
  PetscCall(VecResetArray(a->from));
  PetscCall(VecRestoreArrayWrite(y, &out));
  PetscCall(VecRestoreArrayRead(x, &in));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Product_Destroy(Mat A)
{
  Product *a;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(A, (void *)&a));
  PetscCall(VecDestroy(&a->from));
  PetscCall(VecDestroy(&a->stress));
  PetscCall(VecDestroy(&a->part));
  for (PetscInt k = 0; k < 2; k++) PetscCall(VecDestroy(&a->to[k]));
  PetscCall(PetscFree(a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SaddleCreateProduct - Creates A in the unknowns (u, q - Z u) as a product, and keeps Z with P for
   SaddleMultiplyOut(); collective */
PetscErrorCode SaddleCreateProduct(Saddle *s)
{
  const MPI_Comm comm = PetscObjectComm((PetscObject)s->P);
  PetscInt       n, N;
  Product       *a;

  PetscFunctionBegin;
  PetscCall(PetscNew(&a));
  a->P = s->P;
  a->Z = s->Z;
  PetscCall(MatCreateVecs(s->Z, NULL, &a->stress));
  PetscCall(VecCreateMPIWithArray(comm, s->dim, s->dim * s->n, PETSC_DETERMINE, NULL, &a->from));
  PetscCall(VecCreateMPIWithArray(comm, 1, s->n_p, PETSC_DETERMINE, NULL, &a->part));
  PetscCall(VecDuplicate(a->from, &a->to[0]));
  PetscCall(VecDuplicate(a->part, &a->to[1]));
  PetscCall(MatGetLocalSize(s->P, &n, NULL));
  PetscCall(MatGetSize(s->P, &N, NULL));
  PetscCall(MatCreateShell(comm, n, n, N, N, a, &s->A));
  PetscCall(MatShellSetOperation(s->A, MATOP_MULT, (void (*)(void))Product_Mult));
  PetscCall(MatShellSetOperation(s->A, MATOP_DESTROY, (void (*)(void))Product_Destroy));
  PetscCall(PetscObjectCompose((PetscObject)s->P, KEY_Z, (PetscObject)s->Z));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SaddleMultiplyOut - Creates the blocks of A, [F + G Z, G; D + C Z, C], for direct solvers.
   Collective. Output: product - P itself without Z and with blocks of type MATAIJ. */
PetscErrorCode SaddleMultiplyOut(Mat P, Mat *product)
{
  const MPI_Comm comm = PetscObjectComm((PetscObject)P);
  Mat            Z, part, sum[2], **block;

  PetscFunctionBegin;
  PetscCall(MatNestGetSubMats(P, NULL, NULL, &block));
  PetscCall(PetscObjectQuery((PetscObject)P, KEY_Z, (PetscObject *)&Z));
  for (PetscInt k = 0; k < 2; k++) {
    PetscCall(MatConvert(block[k][0], MATAIJ, MAT_INITIAL_MATRIX, &sum[k]));
    if (!Z) continue;
    PetscCall(MatMatMult(block[k][1], Z, MAT_INITIAL_MATRIX, PETSC_DEFAULT, &part));
    PetscCall(SparseAdd(part, &sum[k]));
    PetscCall(MatDestroy(&part));
  }
  PetscCall(MatCreateNest(comm, 2, NULL, 2, NULL, (Mat[]){sum[0], block[0][1], sum[1], block[1][1]},
                          product));
  for (PetscInt k = 0; k < 2; k++) PetscCall(MatDestroy(&sum[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SaddleStress - Computes the pressures Z u of the velocity in x = (u, q); zero inside the fluid;
   collective. Output: stress - NULL without a free surface; free with VecDestroy() */
PetscErrorCode SaddleStress(const Saddle *s, Vec x, Vec *stress)
{
  IS  rows[2];
  Vec u;

  PetscFunctionBegin;
  *stress = NULL;
  if (!s->Z) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MatCreateVecs(s->Z, NULL, stress));
  PetscCall(MatNestGetISs(s->P, rows, NULL));
  PetscCall(VecGetSubVector(x, rows[0], &u));
  PetscCall(MatMult(s->Z, u, *stress));
  PetscCall(VecRestoreSubVector(x, rows[0], &u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SaddleAddTension - Adds the pressure of the surface tension to the rows of mass of b on free
   surfaces; not collective */
PetscErrorCode SaddleAddTension(const FreeSurface *surface, const Saddle *s, Vec b)
{
  const PetscScalar *unit;
  PetscScalar       *to;

  PetscFunctionBegin;
  if (!surface || surface->tension == 0.0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecGetArrayRead(s->pressure, &unit));
  PetscCall(VecGetArray(b, &to));
  for (PetscInt i = 0; i < s->n; i++) {
    if (FreeSurfaceHolds(surface, i))
      to[s->dim * s->n + i] += FreeSurfacePressure(surface, i) / (s->unit * unit[i]);
  }
  PetscCall(VecRestoreArray(b, &to));
  PetscCall(VecRestoreArrayRead(s->pressure, &unit));
  PetscFunctionReturn(PETSC_SUCCESS);
}
