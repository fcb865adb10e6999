/*
  Matrices of dim x dim blocks on a pattern of particles, whose values can be computed again.
  Component b of particle j is unknown number dim j + b.
*/
#include "isph/operators.h"

static PetscErrorCode BlockRowsDestroy(void *ctx)
{
  BlockRows *rows = (BlockRows *)ctx;

  PetscFunctionBegin;
  PetscCall(PatternFree(&rows->pattern));
  PetscCall(PetscFree(rows->value));
  PetscCall(PetscFree(rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* BlockRowsGet - Returns the rows of a matrix of BlockRowsMat(), for PatternMatSet(); not
   collective */
PetscErrorCode BlockRowsGet(Mat A, BlockRows **rows)
{
  PetscContainer container;

  PetscFunctionBegin;
  PetscCall(PetscObjectQuery((PetscObject)A, "block_rows", (PetscObject *)&container));
  PetscCall(PetscContainerGetPointer(container, (void **)rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the rows of a matrix of blocks, with zeros. */
static PetscErrorCode BlockRowsCreate(const Particles *p, PetscInt entries, const Pattern *pattern,
                                      BlockRows **rows)
{
  const PetscInt d = p->dim, n = d * entries * pattern->row[p->n_fluid];
  Pattern       *blocks;
  PetscInt       q = 0;

  PetscFunctionBegin;
  PetscCall(PetscNew(rows));
  PetscCall(PetscCalloc1(n, &(*rows)->value));
  blocks = &(*rows)->pattern;
  PetscCall(PetscMalloc1(d * p->n_fluid + 1, &blocks->row));
  PetscCall(PetscMalloc1(n, &blocks->col));
  blocks->n      = d * p->n_fluid;
  blocks->row[0] = 0;
  for (PetscInt r = 0; r < blocks->n; r++) {
    const PetscInt i = r / d, first = entries == 1 ? r % d : 0;

    for (PetscInt s = pattern->row[i]; s < pattern->row[i + 1]; s++)
      for (PetscInt b = 0; b < entries; b++) blocks->col[q++] = d * pattern->col[s] + first + b;
    blocks->row[r + 1] = q;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  BlockRowsMat - Creates a matrix of dim x dim blocks on a pattern, with zeros

  Collective. The entries of a slot in each of the dim rows of a particle follow each other, and
  columns ascend. Input: entries - of a slot in a row: dim, or 1 if blocks are diagonal; columns -
  number of own particles that the columns stand for.
*/
PetscErrorCode BlockRowsMat(const Particles *p, PetscInt entries, const Pattern *pattern,
                            PetscInt columns, Mat *A)
{
  const PetscInt d = p->dim;
  BlockRows     *rows;

  PetscFunctionBegin;
  PetscCall(BlockRowsCreate(p, entries, pattern, &rows));
  PetscCall(
      PatternMat(p->comm, &rows->pattern, rows->pattern.n, d * columns, rows->value, NULL, A));
  PetscCall(MatSetBlockSizes(*A, d, d));
  PetscCall(MatKeep(*A, "block_rows", rows, BlockRowsDestroy));
  PetscFunctionReturn(PETSC_SUCCESS);
}
