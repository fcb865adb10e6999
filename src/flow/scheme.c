/* The limit of a scheme's steps, and its lists of solves and figures for banner, report, progress
   and checkpoints. */
#include "isph/flow.h"

/* SchemeLimit - Computes the longest step that the scheme allows, with its reason; collective */
PetscErrorCode SchemeLimit(const Flow *flow, StepLimit *limit)
{
  PetscFunctionBegin;
  *limit = (StepLimit){.dt = PETSC_INFINITY, .reason = "nothing"};
  PetscCall(flow->scheme->row->Limit(flow, limit));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* LogStageGet - Registers a stage of -log_view, once in a process; collective */
PetscErrorCode LogStageGet(const char name[], PetscLogStage *stage)
{
  PetscFunctionBegin;
  PetscCall(PetscLogStageGetId(name, stage));
  if (*stage < 0) PetscCall(PetscLogStageRegister(name, stage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SchemeChooseStep - Sets dt to the usual length of steps, on which choices of solvers and the
   banner depend; collective. First steps can be shorter, see ClockShortening(). */
PetscErrorCode SchemeChooseStep(Flow *flow)
{
  StepLimit limit;

  PetscFunctionBegin;
  PetscCall(SchemeLimit(flow, &limit));
  PetscCall(ClockChoose(&limit, flow->clock));
  flow->clock->dt /= ClockShortening(flow->clock);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SchemeAddFigure - Adds a number to the report of the run. figure.value must exist as long as the
   scheme. */
PetscErrorCode SchemeAddFigure(SchemeFigure figure, Scheme *s)
{
  PetscFunctionBegin;
  PetscCheck(s->n_figures < SCHEME_MAX_FIGURES, PETSC_COMM_SELF, PETSC_ERR_PLIB,
             "%s is one more than SCHEME_MAX_FIGURES = %d", figure.name, SCHEME_MAX_FIGURES);
  s->figure[s->n_figures++] = figure;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SchemeAddSolve - Adds a linear solve to the list for banner, report, progress and checkpoints.
   Input: solve - must exist as long as the scheme. */
PetscErrorCode SchemeAddSolve(LinearSolve *solve, Scheme *s)
{
  char name[4][32];

  PetscFunctionBegin;
  PetscCheck(s->n_solves < SCHEME_MAX_SOLVES, PETSC_COMM_SELF, PETSC_ERR_PLIB,
             "The %s solve is one more than SCHEME_MAX_SOLVES = %d", solve->name,
             SCHEME_MAX_SOLVES);
  s->solve[s->n_solves++] = solve;
  PetscCall(PetscSNPrintf(name[0], sizeof(name[0]), "%siterations", solve->prefix));
  PetscCall(PetscSNPrintf(name[1], sizeof(name[1]), "%siterations_sum", solve->prefix));
  PetscCall(PetscSNPrintf(name[2], sizeof(name[2]), "%sfalls", solve->prefix));
  PetscCall(PetscSNPrintf(name[3], sizeof(name[3]), "%sfalls_in_a_row", solve->prefix));
  PetscCall(MemoryAddInt(&s->memory, name[0], &solve->iterations));
  PetscCall(MemoryAddInt(&s->memory, name[1], &solve->iterations_sum));
  PetscCall(MemoryAddCounter(&s->memory, name[2], &solve->falls));
  PetscCall(MemoryAddCounter(&s->memory, name[3], &solve->falls_in_a_row));
  PetscFunctionReturn(PETSC_SUCCESS);
}
