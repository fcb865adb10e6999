/* Jumps of the velocity in fluids with a free surface. A fluid that meets a wall or other fluid
   stops in the time in which viscosity crosses dx, or, as it is incompressible, at once. If a step
   is longer, formulas of order 2 and 3 carry the velocity of before to later steps: after a stop
   from the velocity U BDF2 starts from -U/3, Adams-Bashforth moves the particle back by U dt/2, and
   the energy of the step errs by about the jump J. Such a step is therefore blended with a step of
   order 1. In closed flows walls change the velocity of their own layer only, and no place depends
   on it; their formulas stay. See theory.md, (surface:jump), (surface:excess), (surface:blend) and
   (surface:measure). */
#include "stages.h"

#define SMOOTH  0.06 /* largest J of a step of full order [-] */
#define SUDDEN  0.15 /* J from which on a step is of order 1 [-] */
#define SLOWEST 0.5  /* least ratio of smooth changes in steps that follow each other [-] */
#define RISE    0.1  /* of the share of order 1 above which a step is solved again [-] */
#define REST    1e-6 /* speed of a fluid at rest [U] */

#define SUMS 6

/* Computes sums over the fluid of |a u_next + b u + c u_prev|^2 for SUMS factors a, b, c, with one
   reduction [m^2/s^2]. */
static PetscErrorCode SumSquares(Flow *flow, const PetscReal factor[SUMS][3], PetscReal sum[SUMS])
{
  const PetscInt   dim = flow->scene->dim;
  const FlowState *s   = flow->state;
  PetscReal        part[SUMS * ISPH_MAX_DIM];
  Vec              v;

  PetscFunctionBegin;
  PetscCall(FlowGetWork(flow, &v));
  for (PetscInt k = 0; k < SUMS * dim; k++) {
    Vec of[] = {s->u_next[k % dim], s->u[k % dim], s->u_prev[k % dim]};

    PetscCall(VecZeroEntries(v));
    PetscCall(VecMAXPY(v, 3, factor[k / dim], of));
    PetscCall(FluidSumOwn(flow->particles, v, PETSC_TRUE, &part[k]));
  }
  PetscCall(FlowRestoreWork(flow, &v));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, part, SUMS * (PetscMPIInt)dim, MPIU_REAL, MPIU_SUM,
                             flow->particles->comm));
  PetscCall(PetscArrayzero(sum, SUMS));
  for (PetscInt k = 0; k < SUMS * dim; k++) sum[k / dim] += part[k];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the least J = |d - s e|/max(|u^{n+1}|, |u^n|, |u^{n-1}|) for SLOWEST <= s <= 1, with
   root mean squares, the change d = u^{n+1} - u^n and its extrapolation e = w (u^n - u^{n-1}). A
   velocity that decays by the factor s >= 1/2 in each step is smooth: BDF2 follows it without a
   change of sign. */
static PetscErrorCode RelativeJump(Flow *flow, PetscReal *jump)
{
  const PetscReal w               = ClockRatio(flow->clock);
  const PetscReal factor[SUMS][3] = {{1.0, 0.0, 0.0},  {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0},
                                     {1.0, -1.0, 0.0}, {0.0, w, -w},    {1.0, -1.0 - w, w}};
  PetscReal       sum[SUMS], most, product, s;

  PetscFunctionBegin;
  PetscCall(SumSquares(flow, factor, sum));
  most    = PetscMax(sum[0], PetscMax(sum[1], sum[2]));
  most    = PetscMax(most, PetscSqr(REST * flow->scene->speed) * flow->particles->weight);
  product = 0.5 * (sum[3] + sum[4] - sum[5]);
  s       = PetscMin(1.0, PetscMax(SLOWEST, sum[4] > 0.0 ? product / sum[4] : 1.0));
  *jump   = PetscSqrtReal(PetscMax(sum[3] - 2.0 * s * product + s * s * sum[4], 0.0) / most);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Measures if the velocity jumps in the step that was solved, and sets the share of order 1 in the
  formulas of the step, if it is solved again, and of the next path

    jump = min(1, max(0, (J - SMOOTH)/(SUDDEN - SMOOTH)))

  Output: again - the step is to be solved again, once, because its share was too small.
*/
static PetscErrorCode DecideJump(Flow *flow, Trial *trial, PetscBool *again)
{
  Clock    *clock = flow->clock;
  PetscReal jump  = 0.0;

  PetscFunctionBegin;
  if (trial->times > 0 || ClockRatio(clock) == 0.0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(RelativeJump(flow, &jump));
  jump             = PetscMin(1.0, PetscMax(0.0, (jump - SMOOTH) / (SUDDEN - SMOOTH)));
  *again           = jump > clock->jump + RISE;
  clock->jump_next = jump;
  if (*again) clock->jump = jump;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lowers the share for the next path, after others have used that of the step. */
static PetscErrorCode LowerShare(Flow *flow)
{
  PetscFunctionBegin;
  flow->clock->jump = PetscMin(flow->clock->jump_next, flow->clock->jump);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns true for the flows that have a share, moving particles with a free surface. */
static PetscBool MayJump(const Flow *flow)
{
  return flow->ops->cut_surface && SceneMoves(flow->scene);
}

const Judge JudgeJump = {
    .name    = "jump",
    .brief   = "a step in which the velocity jumps is solved again with a share of order 1",
    .Applies = MayJump,
    .again   = AGAIN_LAST,
    .Decide  = DecideJump,
};

/* Comes after the observers that read the share of the step. */
const Observer ObserverJump = {.Applies = MayJump, .End = LowerShare};
