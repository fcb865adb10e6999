/*
  Pressures of free surfaces in the coupled system. There the row of mass is q - Z u = 0, the normal
  stress at the surface. Its unknown q is replaced by q - Z u, which the row gives:

    [F G; D C] [u; q] = [F + G Z, G; D + C Z, C] [u; q - Z u]

  The same row of D is -Z, and vanishes in D + C Z. F alone has no condition on the normal stress
  and an eigenvalue with negative real part for each particle of the surface; no Schur complement of
  F has a simple approximation. F + G Z has both conditions of the surface, and the approximations
  of schur.c suit its Schur complement: docs/theory.md, (156) and (157).
*/
#include "saddle.h"

/* SaddleEliminateSurface - Computes Z, adds G Z to the viscous matrix, and replaces D by D + C Z;
   collective */
PetscErrorCode SaddleEliminateSurface(const FreeSurface *surface, Saddle *s)
{
  PetscInt *outer, *inner, first, n_outer = 0, n_inner = 0; /* global numbers */
  Mat       GZ, CZ;

  PetscFunctionBegin;
  if (!surface) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MatGetOwnershipRange(s->D, &first, NULL));
  PetscCall(PetscMalloc2(s->n, &outer, s->n, &inner));
  for (PetscInt i = 0; i < s->n; i++) {
    if (FreeSurfaceHolds(surface, i)) outer[n_outer++] = first + i;
    else inner[n_inner++] = first + i;
  }
  PetscCall(MatDuplicate(s->D, MAT_COPY_VALUES, &s->Z));
  PetscCall(MatScale(s->Z, -1.0));
  PetscCall(MatZeroRows(s->Z, n_inner, inner, 0.0, NULL, NULL));
  PetscCall(MatMatMult(s->G, s->Z, MAT_INITIAL_MATRIX, PETSC_DEFAULT, &GZ));
  PetscCall(MatMatMult(s->C, s->Z, MAT_INITIAL_MATRIX, PETSC_DEFAULT, &CZ));
  PetscCall(SparseAdd(GZ, &s->viscous));
  PetscCall(SparseAdd(CZ, &s->D));
  PetscCall(MatZeroRows(s->D, n_outer, outer, 0.0, NULL, NULL));
  PetscCall(MatDestroy(&GZ));
  PetscCall(MatDestroy(&CZ));
  PetscCall(PetscFree2(outer, inner));
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
