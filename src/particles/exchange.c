/* Exchange of items between ranks when receivers do not know the senders, for migration and for
   halos. Ranks without common items do not communicate. */
#include "impl.h"

/* Sends each receiver the number of its items. Output: source - sending ranks, ascending; n_from -
   number of items from each. */
static PetscErrorCode AnnounceItems(MPI_Comm comm, const PetscInt n_to[], PetscMPIInt *n_sources,
                                    PetscMPIInt **source, PetscInt **n_from)
{
  PetscMPIInt ranks, n_targets = 0, *target;
  PetscInt   *n_items;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(comm, &ranks));
  PetscCall(PetscMalloc2(ranks, &target, ranks, &n_items));
  for (PetscMPIInt r = 0; r < ranks; r++) {
    if (n_to[r] == 0) continue;
    target[n_targets]  = r;
    n_items[n_targets] = n_to[r];
    n_targets++;
  }
  PetscCall(PetscCommBuildTwoSided(comm, 1, MPIU_INT, n_targets, target, n_items, n_sources, source,
                                   n_from));
  PetscCall(PetscSortMPIIntWithIntArray(*n_sources, *source, *n_from));
  PetscCall(PetscFree2(target, n_items));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ExchangeItems - Sends items to the ranks that need them, including this rank, and receives items.
   Collective on comm. Input: comm - communicator; unit - MPI type of the numbers in an item; width
   - count of numbers in an item; n_to - count of items for each rank of comm; send - items in the
   order of ranks. Output: n_sources - number of ranks that sent items; source - their ranks,
   ascending; free with PetscFree(); n_from - count of items from each of them; free with
   PetscFree(); recv - address of a pointer to the items in the order of source; free with
   PetscFree(). */
PetscErrorCode ExchangeItems(MPI_Comm comm, MPI_Datatype unit, PetscInt width,
                             const PetscInt n_to[], const void *send, PetscMPIInt *n_sources,
                             PetscMPIInt **source, PetscInt **n_from, void *recv)
{
  MPI_Comm     own;
  MPI_Datatype item;
  MPI_Request *request;
  PetscMPIInt  ranks, tag, bytes, n_requests = 0;
  size_t       total = 0;
  char        *in;
  const char  *out = (const char *)send;

  PetscFunctionBegin;
  PetscCall(AnnounceItems(comm, n_to, n_sources, source, n_from));
  PetscCall(PetscCommDuplicate(comm, &own, &tag));
  PetscCallMPI(MPI_Comm_size(own, &ranks));
  PetscCallMPI(MPI_Type_contiguous((PetscMPIInt)width, unit, &item));
  PetscCallMPI(MPI_Type_commit(&item));
  PetscCallMPI(MPI_Type_size(item, &bytes));
  for (PetscMPIInt s = 0; s < *n_sources; s++) total += (size_t)(*n_from)[s];
  PetscCall(PetscMalloc1(total * (size_t)bytes, &in));
  PetscCall(PetscMalloc1(*n_sources + ranks, &request));
  *(void **)recv = in;
  for (PetscMPIInt s = 0; s < *n_sources; s++) {
    PetscCallMPI(MPI_Irecv(in, (PetscMPIInt)(*n_from)[s], item, (*source)[s], tag, own,
                           &request[n_requests++]));
    in += (size_t)(*n_from)[s] * (size_t)bytes;
  }
  for (PetscMPIInt r = 0; r < ranks; r++) {
    if (n_to[r] == 0) continue;
    PetscCallMPI(MPI_Isend(out, (PetscMPIInt)n_to[r], item, r, tag, own, &request[n_requests++]));
    out += (size_t)n_to[r] * (size_t)bytes;
  }
  PetscCallMPI(MPI_Waitall(n_requests, request, MPI_STATUSES_IGNORE));
  PetscCallMPI(MPI_Type_free(&item));
  PetscCall(PetscFree(request));
  PetscCall(PetscCommDestroy(&own));
  PetscFunctionReturn(PETSC_SUCCESS);
}
