/*
  Changes of the particles between epochs: restored, replaced, inserted and removed. Each change of
  their number starts an epoch, after which whoever keeps something per particle renews it.
*/
#include "impl.h"

/*
  ParticlesUnpack - Gives the own particles the fields of records packed in the present epoch

  Collective: the halo's positions follow.
*/
PetscErrorCode ParticlesUnpack(Particles *p, const PetscReal record[])
{
  const PetscInt width = ParticlesRecordWidth(p);
  RecordColumns  columns;

  PetscFunctionBegin;
  PetscCall(RecordsBegin(p, &columns));
  for (PetscInt i = 0; i < ParticlesOwn(p); i++)
    RecordUnpack(&columns, &record[(size_t)i * width], i);
  PetscCall(RecordsEnd(&columns));
  PetscCall(ParticlesUpdateHalo(p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  ParticlesReplace - Puts records in the place of the own particles and starts an epoch

  Collective. Together the ranks give each particle once, whoever owns it afterwards: owners, order
  and numbers that follow depend on the particles and the number of ranks alone.

  Input Parameters:
+ n      - how many records this rank gives
- record - as ParticlesPack() lays them out
*/
PetscErrorCode ParticlesReplace(const Scene *scene, Particles *p, PetscInt n,
                                const PetscReal record[])
{
  PetscFunctionBegin;
  PetscCall(ParticlesStore(scene, p, n, record));
  p->redraw = PETSC_TRUE;
  PetscCall(ParticlesUpdateEpoch(scene, p, PETSC_TRUE, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}
