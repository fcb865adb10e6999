/* The life of the set-up of a preconditioner, by one rule for all solvers: it lasts until the
   unknowns are numbered anew, until the shift of the matrix has changed, or until a solve takes
   half as many iterations again as the first one with it. Particles move by less than a spacing
   with one numbering. */
#include "isph/solvers.h"

#define SHIFT_CHANGE 1.5 /* largest ratio of shifts with one set-up */
#define FEW          2   /* more iterations that are no reason for a set-up */

/* SetUpHolds - Returns true if the set-up serves for a matrix with a numbering and a shift; not
   collective, the same on all ranks. Input: numbering - stamp; shift - any unit, 0 if steady. */
PetscBool SetUpHolds(const SetUp *s, PetscInt numbering, PetscReal shift)
{
  if (!s->exists || s->numbering != numbering) return PETSC_FALSE;
  if (shift > SHIFT_CHANGE * s->shift || s->shift > SHIFT_CHANGE * shift) return PETSC_FALSE;
  return s->last <= s->first + s->first / 2 + FEW;
}

/* SetUpRenew - Notes that the preconditioner is set up anew */
void SetUpRenew(PetscInt numbering, PetscReal shift, LinearSolve *solve)
{
  solve->setup = (SetUp){.exists = PETSC_TRUE, .numbering = numbering, .shift = shift};
  solve->setups++;
}

/* SetUpCount - Notes the iterations of a solve */
void SetUpCount(PetscInt iterations, SetUp *s)
{
  s->last = iterations;
  if (s->first == 0) s->first = iterations;
}
