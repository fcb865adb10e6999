/* The attempts of a step. Judges see the solution of a step and repeat a part of it with another
   treatment: the last solve, all solves, or the whole step in a shorter time. This file alone saves
   and restores what a step begins with: all registered fields, the numbers of the run's memory, and
   what a scheme keeps off the particles. All other data are computed from these. */
#include "isph/flow.h"

struct Attempt {
  const Judge *judge[SCHEME_MAX_JUDGES]; /* those that apply */
  Trial        trial[SCHEME_MAX_JUDGES]; /* in the present step */
  PetscInt     n_judges;
  PetscInt     first, last; /* stages that solve */
  PetscBool    saves[AGAIN_KINDS];

  PetscReal *record; /* own particles before the step, see ParticlesPack() */
  PetscInt   n, capacity, epoch;
  PetscReal *memory;
  Vec        kept; /* of Scheme.kept; NULL: none */

  Vec        p; /* before the solves, a work vector; NULL: not saved [Pa] */
  Vec        kept_solve;
  PetscReal *memory_solve;
};

/* AttemptArrange - Chooses the judges of the steps of a run. Collective. scheme->stage has the
   stages. */
PetscErrorCode AttemptArrange(Flow *flow)
{
  Scheme  *s = flow->scheme;
  Attempt *a;

  PetscFunctionBegin;
  PetscCall(PetscNew(&a));
  s->attempt = a;
  PetscCall(PetscMalloc2(s->memory.size, &a->memory, s->memory.size, &a->memory_solve));
  for (const Judge *const *judge = s->row->judges; *judge; judge++) {
    if (!(*judge)->Applies(flow)) continue;
    PetscCheck(a->n_judges < SCHEME_MAX_JUDGES, PETSC_COMM_SELF, PETSC_ERR_PLIB,
               "%s is one more than SCHEME_MAX_JUDGES = %d", (*judge)->name, SCHEME_MAX_JUDGES);
    a->judge[a->n_judges++]   = *judge;
    a->saves[(*judge)->again] = PETSC_TRUE;
  }
  a->first = -1;
  for (PetscInt k = 0; k < s->n_stages; k++) {
    if (!s->stage[k]->solves) continue;
    if (a->first < 0) a->first = k;
    a->last = k;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* AttemptDestroy - Frees the copies; collective */
PetscErrorCode AttemptDestroy(Attempt **attempt)
{
  PetscFunctionBegin;
  if (!*attempt) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscFree2((*attempt)->memory, (*attempt)->memory_solve));
  PetscCall(PetscFree((*attempt)->record));
  PetscCall(VecDestroyAll(&(*attempt)->kept, &(*attempt)->kept_solve));
  PetscCall(PetscFree(*attempt));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Copies what a scheme keeps off the particles over the last copy. */
static PetscErrorCode CopyKept(const Scheme *scheme, Vec *copy)
{
  PetscFunctionBegin;
  if (!scheme->kept) PetscFunctionReturn(PETSC_SUCCESS);
  if (!*copy) PetscCall(VecDuplicate(scheme->kept, copy));
  PetscCall(VecCopy(scheme->kept, *copy));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Copies the present flow over the last copy. */
static PetscErrorCode SaveStep(const Flow *flow, Attempt *a)
{
  const Particles *p    = flow->particles;
  const PetscInt   size = ParticlesOwn(p) * ParticlesRecordWidth(p);

  PetscFunctionBegin;
  if (size > a->capacity) {
    PetscCall(PetscFree(a->record));
    a->capacity = size + size / 8;
    PetscCall(PetscMalloc1(a->capacity, &a->record));
  }
  PetscCall(ParticlesPack(p, a->record));
  PetscCall(CopyKept(flow->scheme, &a->kept));
  MemoryGet(&flow->scheme->memory, a->memory);
  a->n     = ParticlesOwn(p);
  a->epoch = p->epoch;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Restores the flow before the step. Within an epoch the particles keep their order; otherwise a
   new epoch starts, and owners and order may change. */
static PetscErrorCode RestoreStep(Flow *flow, const Attempt *a)
{
  Particles *p = flow->particles;

  PetscFunctionBegin;
  MemorySet(&flow->scheme->memory, PETSC_FALSE, a->memory);
  if (a->kept) PetscCall(VecCopy(a->kept, flow->scheme->kept));
  if (a->epoch == p->epoch) PetscCall(ParticlesUnpack(p, a->record));
  else PetscCall(ParticlesReplace(flow->scene, p, a->n, a->record));
  PetscCall(flow->scheme->row->Begin(flow));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Copies what solves begin with and change, besides u_next. */
static PetscErrorCode SaveSolves(Flow *flow, Attempt *a)
{
  PetscFunctionBegin;
  PetscCall(FlowGetWork(flow, &a->p));
  PetscCall(VecCopy(flow->state->p, a->p));
  PetscCall(CopyKept(flow->scheme, &a->kept_solve));
  MemoryGet(&flow->scheme->memory, a->memory_solve);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode RestoreSolves(Flow *flow, const Attempt *a)
{
  PetscFunctionBegin;
  PetscCall(VecCopy(a->p, flow->state->p));
  if (a->kept_solve) PetscCall(VecCopy(a->kept_solve, flow->scheme->kept));
  MemorySet(&flow->scheme->memory, PETSC_FALSE, a->memory_solve);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Asks the judges of steps or of solves, in their order, until the first of them repeats a part of
   the step. The start of that part is restored, and earlier judges count from 0 again. Output:
   verdict - this judge; NULL: the solution is kept. */
static PetscErrorCode Ask(Flow *flow, PetscBool steps, const Judge **verdict)
{
  Attempt *a = flow->scheme->attempt;

  PetscFunctionBegin;
  *verdict = NULL;
  for (PetscInt j = 0; j < a->n_judges && !*verdict; j++) {
    const Judge *judge = a->judge[j];
    PetscBool    again = PETSC_FALSE;

    if ((judge->again == AGAIN_SHORTER) != steps) continue;
    PetscCall(judge->Decide(flow, &a->trial[j], &again));
    if (!again) continue;
    *verdict = judge;
    a->trial[j].times++;
    for (PetscInt i = 0; i < j; i++) a->trial[i].times = 0;
    if (judge->again == AGAIN_SHORTER) PetscCall(RestoreStep(flow, a));
    if (judge->again == AGAIN_SOLVES) PetscCall(RestoreSolves(flow, a));
    if (judge->Treat) PetscCall(judge->Treat(flow));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* AttemptNext - Sets the stage that follows a stage of a step: the next one, or an earlier one if a
   judge repeats solves. Collective. Input/Output: k - number of the stage in scheme->stage. */
PetscErrorCode AttemptNext(Flow *flow, PetscInt *k)
{
  Attempt       *a     = flow->scheme->attempt;
  const PetscInt done  = (*k)++;
  const Judge   *again = NULL;

  PetscFunctionBegin;
  if (flow->scheme->failure.code) PetscFunctionReturn(PETSC_SUCCESS);
  if (done == a->last) PetscCall(Ask(flow, PETSC_FALSE, &again));
  if (again) *k = again->again == AGAIN_LAST ? a->last : a->first;
  else if (*k == a->first && a->saves[AGAIN_SOLVES]) PetscCall(SaveSolves(flow, a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Ends the treatments of judges of steps or of solves. */
static PetscErrorCode EndTreatments(Flow *flow, PetscBool steps)
{
  Attempt *a = flow->scheme->attempt;

  PetscFunctionBegin;
  for (PetscInt j = 0; j < a->n_judges; j++) {
    if ((a->judge[j]->again == AGAIN_SHORTER) != steps) continue;
    if (a->trial[j].times > 0 && a->judge[j]->Clear) PetscCall(a->judge[j]->Clear(flow));
    a->trial[j] = (Trial){0};
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* AttemptBegin - Saves what a step begins with, if it may be repeated; collective */
PetscErrorCode AttemptBegin(Flow *flow)
{
  Attempt *a = flow->scheme->attempt;

  PetscFunctionBegin;
  if (a->saves[AGAIN_SHORTER]) PetscCall(SaveStep(flow, a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* AttemptEnd - Ends the treatments of the solves of a step, and asks the judges of steps; they end
   theirs when the step is kept. Collective. Output: again - flag: the flow before the step is
   restored, and the step is to be repeated. */
PetscErrorCode AttemptEnd(Flow *flow, PetscBool *again)
{
  const Judge *verdict;

  PetscFunctionBegin;
  PetscCall(FlowRestoreWork(flow, &flow->scheme->attempt->p));
  PetscCall(EndTreatments(flow, PETSC_FALSE));
  PetscCall(Ask(flow, PETSC_TRUE, &verdict));
  *again = verdict && !flow->scheme->failure.fatal;
  if (!*again) PetscCall(EndTreatments(flow, PETSC_TRUE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool Retries(const Flow *flow)
{
  return flow->clock->adapt->retries;
}

static PetscErrorCode DecideFailure(Flow *flow, Trial *trial, PetscBool *again)
{
  const StepFailure *failure = &flow->scheme->failure;

  PetscFunctionBegin;
  (void)trial;
  *again = failure->code && !failure->fatal;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Shorten(Flow *flow)
{
  PetscFunctionBegin;
  PetscCall(ClockRetry(flow->clock, &flow->scheme->failure));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const Judge JudgeFailure = {
    .name    = "failure",
    .brief   = "a step that fails, or has too large an error in time, is repeated in shorter steps",
    .Applies = Retries,
    .again   = AGAIN_SHORTER,
    .Decide  = DecideFailure,
    .Treat   = Shorten,
};
