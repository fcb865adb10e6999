/*
  Dense numbers of fluid particles, used for rows of files. The dense number of a particle is the
  number of fluid particles with smaller ids. Unlike ids it has no gaps after removals, and it
  depends neither on ranks nor on epochs.
*/
#include "impl.h"

/* A received id and its index in the array of received ids. */
typedef struct {
  PetscInt64 id;
  PetscInt   place;
} Entry;

static int CompareEntries(const void *a, const void *b)
{
  const PetscInt64 k = ((const Entry *)a)->id, l = ((const Entry *)b)->id;

  return (k > l) - (k < l);
}

/* Replaces n ids by their dense numbers. All ids of a rank must exceed all ids of lower ranks. */
static PetscErrorCode NumberEntries(MPI_Comm comm, PetscInt n, PetscInt64 id[])
{
  Entry   *entry;
  PetscInt first = 0;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Exscan(&n, &first, 1, MPIU_INT, MPI_SUM, comm));
  PetscCall(PetscMalloc1(n, &entry));
  for (PetscInt k = 0; k < n; k++) entry[k] = (Entry){id[k], k};
  if (n > 1) qsort(entry, (size_t)n, sizeof(*entry), CompareEntries);
  for (PetscInt k = 0; k < n; k++) id[entry[k].place] = first + k;
  PetscCall(PetscFree(entry));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  ParticlesNumberById - Numbers the fluid of all ranks in the order of ids, from 0 on without gaps

  Collective. Each rank numbers a range of ids: it receives the ids from their owners, and sends the
  numbers back.

  Output Parameter:
. index - number of each own fluid particle
*/
PetscErrorCode ParticlesNumberById(const Particles *p, PetscInt index[])
{
  PetscMPIInt ranks, n_sources, n_replies, *source, *replier;
  PetscInt   *n_to, *n_from, *n_back, *n_replied, *next, *sent_at, n = 0;
  PetscInt64 *sent, *received, *replies, share;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(p->comm, &ranks));
  share = p->next_id / ranks + 1;
  PetscCall(PetscCalloc3(ranks, &n_to, ranks, &n_back, ranks + 1, &next));
  PetscCall(PetscMalloc2(p->n_fluid, &sent, p->n_fluid, &sent_at));
  for (PetscInt i = 0; i < p->n_fluid; i++) n_to[p->id[i] / share]++;
  for (PetscMPIInt r = 0; r < ranks; r++) next[r + 1] = next[r] + n_to[r];
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    sent_at[i]       = next[p->id[i] / share]++;
    sent[sent_at[i]] = p->id[i];
  }
  PetscCall(
      ExchangeItems(p->comm, MPIU_INT64, 1, n_to, sent, &n_sources, &source, &n_from, &received));
  for (PetscMPIInt s = 0; s < n_sources; s++) n += n_back[source[s]] = n_from[s];
  PetscCall(NumberEntries(p->comm, n, received));
  PetscCall(ExchangeItems(p->comm, MPIU_INT64, 1, n_back, received, &n_replies, &replier,
                          &n_replied, &replies));
  for (PetscInt i = 0; i < p->n_fluid; i++) index[i] = (PetscInt)replies[sent_at[i]];
  PetscCall(PetscFree(replies));
  PetscCall(PetscFree(n_replied));
  PetscCall(PetscFree(replier));
  PetscCall(PetscFree(received));
  PetscCall(PetscFree(n_from));
  PetscCall(PetscFree(source));
  PetscCall(PetscFree2(sent, sent_at));
  PetscCall(PetscFree3(n_to, n_back, next));
  PetscFunctionReturn(PETSC_SUCCESS);
}
