/*
  Undoing a step: the registry of fields as it was before, with the little that a flow is made of
  besides. Everything else is made anew from that.
*/
#include "isph/schemes.h"

struct Undo {
  PetscReal *record; /* own particles, see ParticlesPack() */
  PetscInt   n, capacity, epoch;
  Clock      clock;
  StepStats  stats;
  PetscReal  number[SCHEME_NUMBERS];
};

PetscErrorCode UndoCreate(Undo **undo)
{
  PetscFunctionBegin;
  PetscCall(PetscNew(undo));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode UndoDestroy(Undo **undo)
{
  PetscFunctionBegin;
  if (!*undo) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscFree((*undo)->record));
  PetscCall(PetscFree(*undo));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* UndoSave - Keeps the flow as it is, in place of what was kept before; not collective */
PetscErrorCode UndoSave(const Clock *clock, const Particles *p, const Scheme *scheme, Undo *undo)
{
  const PetscInt size = ParticlesOwn(p) * ParticlesRecordWidth(p);

  PetscFunctionBegin;
  if (size > undo->capacity) {
    PetscCall(PetscFree(undo->record));
    undo->capacity = size + size / 8;
    PetscCall(PetscMalloc1(undo->capacity, &undo->record));
  }
  PetscCall(ParticlesPack(p, undo->record));
  PetscCall(PetscArraycpy(undo->number, scheme->number, SCHEME_NUMBERS));
  undo->n     = ParticlesOwn(p);
  undo->epoch = p->epoch;
  undo->clock = *clock;
  undo->stats = scheme->stats;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  UndoRestore - Goes back to the flow that was kept

  Collective. Within an epoch particles are where they were; else a new one begins, and owners and
  order may be others than before.
*/
PetscErrorCode UndoRestore(const Scene *scene, const Undo *undo, Clock *clock, Particles *p,
                           Neighbors *nb, Operators *ops, Scheme *scheme)
{
  PetscFunctionBegin;
  *clock        = undo->clock;
  scheme->stats = undo->stats;
  PetscCall(PetscArraycpy(scheme->number, undo->number, SCHEME_NUMBERS));
  if (undo->epoch == p->epoch) PetscCall(ParticlesUnpack(p, undo->record));
  else PetscCall(ParticlesReplace(scene, p, undo->n, undo->record));
  PetscCall(scheme->row->Begin(scene, clock, p, nb, ops, scheme));
  PetscFunctionReturn(PETSC_SUCCESS);
}
