/* Counts ids that occur more than once in the records of all ranks. */
#include "impl.h"

/* Sends ids from 0 to next_id - 1 to the ranks of their ranges: rank r receives those from r share
   to (r + 1) share - 1, share = next_id / ranks + 1. Output: received - free with PetscFree(). */
static PetscErrorCode SendIds(const Particles *p, PetscInt n, PetscInt64 id[], PetscInt *n_received,
                              PetscInt64 **received)
{
  PetscMPIInt ranks, n_sources, *source;
  PetscInt   *n_to, *n_of_source;
  PetscInt64  share;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(p->comm, &ranks));
  share = p->next_id / ranks + 1;
  PetscCall(PetscCalloc1(ranks, &n_to));
  for (PetscInt i = 0; i < n; i++) n_to[id[i] / share]++;
  PetscCall(PetscSortInt64(n, id)); /* in the order of ranks */
  PetscCall(
      ExchangeItems(p->comm, MPIU_INT64, 1, n_to, id, &n_sources, &source, &n_of_source, received));
  *n_received = 0;
  for (PetscMPIInt s = 0; s < n_sources; s++) *n_received += n_of_source[s];
  PetscCall(FreeAll(&n_of_source, &source, &n_to));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ParticlesCountRepeated - Counts the records of all ranks whose id is also the id of an earlier
   record. Collective. Each rank sorts a range of ids. Input: n - number of records of this rank;
   record - the records, each accepted by ParticlesValidRecord(). */
PetscErrorCode ParticlesCountRepeated(const Particles *p, PetscInt n, const PetscReal record[],
                                      PetscInt *repeated)
{
  const PetscInt width      = ParticlesRecordWidth(p);
  PetscInt       n_received = 0;
  PetscInt64    *id, *received;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(n, &id));
  for (PetscInt i = 0; i < n; i++) id[i] = (PetscInt64)record[(size_t)i * width + RECORD_ID];
  PetscCall(SendIds(p, n, id, &n_received, &received));
  PetscCall(PetscSortInt64(n_received, received));
  *repeated = 0;
  for (PetscInt k = 1; k < n_received; k++) *repeated += received[k] == received[k - 1];
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, repeated, 1, MPIU_INT, MPI_SUM, p->comm));
  PetscCall(FreeAll(&received, &id));
  PetscFunctionReturn(PETSC_SUCCESS);
}
