/*
  Ids of all ranks in their order. The dense number of a particle, used for rows of files, is the
  number of fluid particles with smaller ids. Unlike ids it has no gaps after removals, and it
  depends neither on ranks nor on epochs. In records of a file each id must occur once.
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
  Sends ids of each rank to the ranks of their ranges. Rank r receives the ids from r share to
  (r + 1) share - 1, share = next_id / ranks + 1.

  Input Parameters:
+ n  - number of ids of this rank
- id - ids from 0 to next_id - 1

  Output Parameters:
+ sent_at    - place of each id among the n ids that this rank sends
. n_from     - number of ids received from each rank
. n_received - their sum
- received   - the ids, in the order of the sending ranks; free with PetscFree()
*/
static PetscErrorCode SendIds(const Particles *p, PetscInt n, const PetscInt64 id[],
                              PetscInt sent_at[], PetscInt n_from[], PetscInt *n_received,
                              PetscInt64 **received)
{
  PetscMPIInt ranks, n_sources, *source;
  PetscInt   *n_to, *n_of_source, *next;
  PetscInt64 *sent, share;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(p->comm, &ranks));
  share = p->next_id / ranks + 1;
  PetscCall(PetscCalloc2(ranks, &n_to, ranks + 1, &next));
  PetscCall(PetscMalloc1(n, &sent));
  for (PetscInt i = 0; i < n; i++) n_to[id[i] / share]++;
  for (PetscMPIInt r = 0; r < ranks; r++) next[r + 1] = next[r] + n_to[r];
  for (PetscInt i = 0; i < n; i++) {
    sent_at[i]       = next[id[i] / share]++;
    sent[sent_at[i]] = id[i];
  }
  PetscCall(ExchangeItems(p->comm, MPIU_INT64, 1, n_to, sent, &n_sources, &source, &n_of_source,
                          received));
  PetscCall(PetscArrayzero(n_from, ranks));
  *n_received = 0;
  for (PetscMPIInt s = 0; s < n_sources; s++) *n_received += n_from[source[s]] = n_of_source[s];
  PetscCall(PetscFree(n_of_source));
  PetscCall(PetscFree(source));
  PetscCall(PetscFree(sent));
  PetscCall(PetscFree2(n_to, next));
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
  PetscMPIInt ranks, n_replies, *replier;
  PetscInt   *n_back, *n_replied, *sent_at, n;
  PetscInt64 *received, *replies;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(p->comm, &ranks));
  PetscCall(PetscMalloc2(ranks, &n_back, p->n_fluid, &sent_at));
  PetscCall(SendIds(p, p->n_fluid, p->id, sent_at, n_back, &n, &received));
  PetscCall(NumberEntries(p->comm, n, received));
  PetscCall(ExchangeItems(p->comm, MPIU_INT64, 1, n_back, received, &n_replies, &replier,
                          &n_replied, &replies));
  for (PetscInt i = 0; i < p->n_fluid; i++) index[i] = (PetscInt)replies[sent_at[i]];
  PetscCall(PetscFree(replies));
  PetscCall(PetscFree(n_replied));
  PetscCall(PetscFree(replier));
  PetscCall(PetscFree(received));
  PetscCall(PetscFree2(n_back, sent_at));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static int CompareIds(const void *a, const void *b)
{
  const PetscInt64 k = *(const PetscInt64 *)a, l = *(const PetscInt64 *)b;

  return (k > l) - (k < l);
}

/*
  ParticlesCountRepeated - Counts the records of all ranks whose id is also the id of an earlier
  record

  Collective. Each rank sorts a range of ids.

  Input Parameters:
+ n      - number of records of this rank
- record - the records, each accepted by ParticlesValidRecord()
*/
PetscErrorCode ParticlesCountRepeated(const Particles *p, PetscInt n, const PetscReal record[],
                                      PetscInt *repeated)
{
  const PetscInt width = ParticlesRecordWidth(p);
  PetscMPIInt    ranks;
  PetscInt      *n_from, *sent_at, n_received;
  PetscInt64    *id, *received;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(p->comm, &ranks));
  PetscCall(PetscMalloc3(ranks, &n_from, n, &sent_at, n, &id));
  for (PetscInt i = 0; i < n; i++) id[i] = (PetscInt64)record[(size_t)i * width + RECORD_ID];
  PetscCall(SendIds(p, n, id, sent_at, n_from, &n_received, &received));
  if (n_received > 1) qsort(received, (size_t)n_received, sizeof(*received), CompareIds);
  *repeated = 0;
  for (PetscInt k = 1; k < n_received; k++) *repeated += received[k] == received[k - 1];
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, repeated, 1, MPIU_INT, MPI_SUM, p->comm));
  PetscCall(PetscFree(received));
  PetscCall(PetscFree3(n_from, sent_at, id));
  PetscFunctionReturn(PETSC_SUCCESS);
}
