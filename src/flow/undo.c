/*
  Undoes a step from a copy of all registered fields and of the run's memory. All other data are
  computed from these.
*/
#include "isph/schemes.h"

struct Undo {
  PetscReal *record; /* own particles, see ParticlesPack() */
  PetscInt   n, capacity, epoch;
  PetscReal  memory[MEMORY_MAX];
  Vec        kept; /* of Scheme.kept; NULL: none */
};

/* UndoCreate - Creates an empty copy; not collective */
PetscErrorCode UndoCreate(Undo **undo)
{
  PetscFunctionBegin;
  PetscCall(PetscNew(undo));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* UndoDestroy - Frees the copy; not collective */
PetscErrorCode UndoDestroy(Undo **undo)
{
  PetscFunctionBegin;
  if (!*undo) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscFree((*undo)->record));
  PetscCall(VecDestroy(&(*undo)->kept));
  PetscCall(PetscFree(*undo));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* UndoSave - Copies the present flow over the last copy; collective */
PetscErrorCode UndoSave(const Flow *flow, Undo *undo)
{
  const Particles *p    = flow->particles;
  const PetscInt   size = ParticlesOwn(p) * ParticlesRecordWidth(p);

  PetscFunctionBegin;
  if (size > undo->capacity) {
    PetscCall(PetscFree(undo->record));
    undo->capacity = size + size / 8;
    PetscCall(PetscMalloc1(undo->capacity, &undo->record));
  }
  PetscCall(ParticlesPack(p, undo->record));
  if (flow->scheme->kept && !undo->kept) PetscCall(VecDuplicate(flow->scheme->kept, &undo->kept));
  if (undo->kept) PetscCall(VecCopy(flow->scheme->kept, undo->kept));
  MemoryGet(&flow->scheme->memory, undo->memory);
  undo->n     = ParticlesOwn(p);
  undo->epoch = p->epoch;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  UndoRestore - Restores the flow of the copy

  Collective. Within an epoch the particles keep their order; otherwise a new epoch starts, and
  owners and order may change.
*/
PetscErrorCode UndoRestore(const Undo *undo, Flow *flow)
{
  Particles *p = flow->particles;

  PetscFunctionBegin;
  MemorySet(&flow->scheme->memory, PETSC_FALSE, undo->memory);
  if (undo->kept) PetscCall(VecCopy(undo->kept, flow->scheme->kept));
  if (undo->epoch == p->epoch) PetscCall(ParticlesUnpack(p, undo->record));
  else PetscCall(ParticlesReplace(flow->scene, p, undo->n, undo->record));
  PetscCall(flow->scheme->row->Begin(flow));
  PetscFunctionReturn(PETSC_SUCCESS);
}
