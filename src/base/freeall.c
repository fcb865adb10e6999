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

/* ObjectsDestroy - Destroys vectors or matrices; see VecDestroyAll() and MatDestroyAll() */
PetscErrorCode ObjectsDestroy(void *first, ...)
{
  va_list more;

  PetscFunctionBegin;
  va_start(more, first);
  for (void *next = first; next; next = va_arg(more, void *))
    PetscCall(PetscObjectDestroy((PetscObject *)next));
  va_end(more);
  PetscFunctionReturn(PETSC_SUCCESS);
}
