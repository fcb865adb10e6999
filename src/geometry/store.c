/* Memory of shapes, and the numbers of points on their lines and rings. */
#include "shapes.h"

/* BodyStoreAdd - Adds memory from PetscMalloc() to a store, which frees it */
PetscErrorCode BodyStoreAdd(void *memory, BodyStore *store)
{
  PetscFunctionBegin;
  if (store->n == store->capacity) {
    store->capacity = 2 * store->capacity + 16;
    PetscCall(PetscRealloc(sizeof(*store->block) * (size_t)store->capacity, &store->block));
  }
  store->block[store->n++] = memory;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* BodyStoreFree - Frees the memory of a store */
PetscErrorCode BodyStoreFree(BodyStore *store)
{
  PetscFunctionBegin;
  for (PetscInt k = 0; k < store->n; k++) PetscCall(PetscFree(store->block[k]));
  PetscCall(PetscFree(store->block));
  *store = (BodyStore){.n = 0};
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ShapeLineCount - Returns the number of points dx apart on a line, at least `fewest`; bounded, so
   that a body can add up its lines */
PetscInt ShapeLineCount(PetscReal length, PetscReal dx, PetscInt fewest)
{
  const PetscReal most = (PetscReal)(PETSC_INT_MAX / 64);

  return PetscMax(fewest, (PetscInt)PetscMin(PetscFloorReal(length / dx + 0.5), most));
}

/* ShapeRingCount - Returns the number of points about dx apart on a ring of radius r about the axis
   z, a multiple of four: planes of symmetry through the axis are half a spacing from them */
PetscInt ShapeRingCount(PetscReal r, PetscReal dx)
{
  return 4 * ShapeLineCount(0.5 * PETSC_PI * r, dx, 1);
}
