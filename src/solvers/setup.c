/*
  The life of the set-up of a preconditioner, by one rule for all solvers: it lasts for an epoch of
  the particles, in which they move by less than a spacing, until the shift of the matrix has
  changed, or solves take more iterations than the first one with it.
*/
#include "isph/solvers.h"

#define SHIFT_CHANGE 1.5 /* largest ratio of shifts with one set-up */
#define MORE_SOLVES  1.4 /* largest number of iterations, in units of those of the first solve, */
#define MORE_AT_MOST 2   /* plus this */

/* SetUpHolds - Returns true if the set-up serves for a matrix of the present epoch with a shift;
   not collective, the same on all ranks. Input: shift - [1/s], 0 in steady flows. */
PetscBool SetUpHolds(const SetUp *s, const Particles *p, PetscReal shift)
{
  if (!s->exists || s->epoch != p->epoch) return PETSC_FALSE;
  if (shift > SHIFT_CHANGE * s->shift || s->shift > SHIFT_CHANGE * shift) return PETSC_FALSE;
  return s->last <= MORE_SOLVES * s->first + MORE_AT_MOST ? PETSC_TRUE : PETSC_FALSE;
}

/* SetUpRenew - Notes that the preconditioner is set up anew; not collective */
void SetUpRenew(const Particles *p, PetscReal shift, LinearSolve *solve)
{
  solve->setup = (SetUp){.exists = PETSC_TRUE, .epoch = p->epoch, .shift = shift};
  solve->setups++;
}

/* SetUpCount - Notes the iterations of a solve; not collective */
void SetUpCount(PetscInt iterations, SetUp *s)
{
  s->last = iterations;
  if (s->first == 0) s->first = iterations;
}
