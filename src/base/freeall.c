/* Frees several arrays, vectors or matrices in a call. */
#include "isph/base.h"
#include <stdarg.h>

/* FreeArrays - Frees arrays of PetscMalloc() and sets their pointers to NULL; see FreeAll(). Input:
   first - address of a pointer; more of them follow, the last one NULL. */
PetscErrorCode FreeArrays(void *first, ...)
{
  va_list more;

  PetscFunctionBegin;
  va_start(more, first);
  for (void *next = first; next; next = va_arg(more, void *)) PetscCall(PetscFree(*(void **)next));
  va_end(more);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* VecDestroyEach - Destroys vectors; see VecDestroyAll() */
PetscErrorCode VecDestroyEach(Vec *first, ...)
{
  va_list more;

  PetscFunctionBegin;
  va_start(more, first);
  for (Vec *next = first; next; next = va_arg(more, Vec *)) PetscCall(VecDestroy(next));
  va_end(more);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* MatDestroyEach - Destroys matrices; see MatDestroyAll() */
PetscErrorCode MatDestroyEach(Mat *first, ...)
{
  va_list more;

  PetscFunctionBegin;
  va_start(more, first);
  for (Mat *next = first; next; next = va_arg(more, Mat *)) PetscCall(MatDestroy(next));
  va_end(more);
  PetscFunctionReturn(PETSC_SUCCESS);
}
