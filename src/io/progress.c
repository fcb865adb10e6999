/* The progress line: the finished share of the run, the state of the flow, the cost of a step and
   the remaining time. */
#include "isph/io.h"
#include <unistd.h>

typedef struct {
  const char *name, *brief, *citation;
  PetscBool   shown;
} ProgressRow;

static const ProgressRow progresses[] = {
    {.name  = "line",
     .brief = "a line, rewritten on a terminal, otherwise printed every 10 %",
     .shown = PETSC_TRUE},
    {.name = "none", .brief = "no progress"},
};
const Table ProgressTable = TABLE("Progress", progresses);

static const OptionRow options[] = {
    OPTION(NAME, "-progress", "lines on the progress of the run", NULL, "line",
           .table = &ProgressTable, .where = "flows"),
};
const OptionTable ProgressOptions = OPTIONS("Progress", options);

struct Progress {
  const ProgressRow *row;
  PetscBool          terminal;      /* standard output is a terminal */
  PetscReal          start, last;   /* wall clock at creation and at the last line [s] */
  PetscReal          last_fraction; /* of the run, at the last line [-] */
  size_t             width;         /* of the last line, which the next line overwrites */
  PetscInt           N;             /* particles in the first step of this process; 0: none yet */
};

/* ProgressCreate - Creates the progress line and starts its clock; collective */
PetscErrorCode ProgressCreate(Progress **progress)
{
  PetscLogDouble now;

  PetscFunctionBegin;
  PetscCall(PetscNew(progress));
  PetscCall(OptionGetRow(&options[0], NULL, &(*progress)->row));
  PetscCall(PetscTime(&now));
  (*progress)->start    = (PetscReal)now;
  (*progress)->terminal = isatty(STDOUT_FILENO) && !HasLauncher();
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ProgressDestroy(Progress **progress)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(*progress));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the finished share of the run, in time or in steps, whichever is larger. */
static PetscReal ProgressFraction(const Clock *clock, PetscReal t, PetscInt step)
{
  const PetscReal time  = clock->t_end > 0.0 ? t / clock->t_end : 0.0;
  const PetscReal steps = clock->max_steps > 0 ? (PetscReal)step / clock->max_steps : 0.0;

  return PetscMin(1.0, PetscMax(time, steps));
}

/* Writes a duration as "35 s", "12 min" or "3.4 h". */
static PetscErrorCode ProgressDuration(PetscReal seconds, char text[], size_t length)
{
  const double s = (double)seconds;

  PetscFunctionBegin;
  if (s < 100.0) PetscCall(PetscSNPrintf(text, length, "%.0f s", s));
  else if (s < 6000.0) PetscCall(PetscSNPrintf(text, length, "%.0f min", s / 60.0));
  else PetscCall(PetscSNPrintf(text, length, "%.1f h", s / 3600.0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the time that the rest of the run takes if the cost is in proportion to the number of
   particles, which changes linearly from n to N in the share `done` and goes on in the share
   `rest`. Particles enter and leave through openings. */
static PetscReal TimeLeft(PetscReal elapsed, PetscReal done, PetscReal rest, PetscReal n,
                          PetscReal N)
{
  const PetscReal end = PetscMax(0.0, N + (N - n) * rest / done);

  return elapsed * rest / done * (N + end) / (n + N);
}

/* Writes the progress line; it omits quantities that the run does not compute. */
static PetscErrorCode ProgressLine(const Flow *flow, PetscReal fraction, PetscReal elapsed,
                                   PetscInt n, char line[], size_t length)
{
  const StepStats *stats  = &flow->scheme->stats;
  const Clock     *clock  = flow->clock;
  const PetscReal  before = ProgressFraction(clock, clock->t_first, clock->step_first);
  char             part[64], left[32];
  const PetscReal  work = (PetscReal)(clock->step - clock->step_first) * flow->particles->N_fluid;

  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(line, length, "%3.0f %%  t %-8.4g step %-6" PetscInt_FMT " energy %.5e",
                          100.0 * (double)fraction, (double)clock->t, clock->step,
                          (double)stats->kinetic_energy));
  if (flow->particles->p) {
    PetscCall(PetscSNPrintf(part, sizeof(part), "  div %.1e", (double)stats->divergence));
    TextAppend(line, length, part);
  }
  for (PetscInt k = 0; k < flow->scheme->n_solves; k++) {
    PetscCall(PetscSNPrintf(part, sizeof(part), "%s%" PetscInt_FMT, k ? "+" : "  its ",
                            flow->scheme->solve[k]->iterations));
    TextAppend(line, length, part);
  }
  PetscCall(PetscSNPrintf(part, sizeof(part), "  %.3g us/particle",
                          work > 0.0 ? 1e6 * (double)(elapsed / work) : 0.0));
  TextAppend(line, length, part);
  if (fraction > before && fraction < 1.0) {
    PetscCall(ProgressDuration(TimeLeft(elapsed, fraction - before, 1.0 - fraction, (PetscReal)n,
                                        (PetscReal)flow->particles->N_fluid),
                               left, sizeof(left)));
    PetscCall(PetscSNPrintf(part, sizeof(part), "  left %s", left));
    TextAppend(line, length, part);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ProgressUpdate - Prints the progress line if it is due. The first rank prints. On a terminal the
   line replaces the last line at most four times a second, otherwise a line is printed every 10 %
   of the run. A launcher gives each rank a terminal of its own, whatever it writes to. Called after
   each step. Input: flow - the flow, with the statistics of the step; us is
   wall clock since ProgressCreate() over the particles and steps; final - true at the end of the
   run: the line is printed in any case; progress - the state of the progress line. */
PetscErrorCode ProgressUpdate(const Flow *flow, PetscBool final, Progress *progress)
{
  const PetscReal fraction = ProgressFraction(flow->clock, flow->clock->t, flow->clock->step);
  PetscLogDouble  now;
  PetscMPIInt     rank;
  PetscReal       gap;
  size_t          width;
  char            line[256];

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  if (rank || !progress->row->shown) PetscFunctionReturn(PETSC_SUCCESS);
  if (!progress->N) progress->N = PetscMax(1, flow->particles->N_fluid);
  PetscCall(PetscTime(&now));
  gap = progress->terminal ? (PetscReal)now - progress->last - 0.25
                           : fraction - progress->last_fraction - 0.1;
  if (!final && gap < 0.0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ProgressLine(flow, fraction, (PetscReal)now - progress->start, progress->N, line,
                         sizeof(line)));
  PetscCall(PetscStrlen(line, &width));
  PetscCall(PetscPrintf(PETSC_COMM_SELF, "%s%s%*s%s", progress->terminal ? "\r" : "", line,
                        width < progress->width ? (int)(progress->width - width) : 0, "",
                        progress->terminal && !final ? "" : "\n"));
  (void)fflush(stdout);
  progress->width         = progress->terminal ? width : 0;
  progress->last          = (PetscReal)now;
  progress->last_fraction = 0.1 * PetscFloorReal(10.0 * fraction + 1e-9);
  PetscFunctionReturn(PETSC_SUCCESS);
}
