/*
  The guard of linear solves: it looks at the true residual after each, climbs the fallback ladder
  where that is not small, and tells the step when nothing helped. See src/schemes/guard.c and
  ladder.c.
*/
#ifndef ISPH_GUARD_H
#define ISPH_GUARD_H

#include "isph/schemes.h"

#define FALLBACK_LEVELS 3 /* of the ladder, see ladder.c */

typedef struct {
  const char        *what;               /* "viscous", "pressure", ... */
  const char        *prefix;             /* "visc_", "ppe_" or "coupled_" */
  const char        *remedy;             /* what else to try; NULL: told from what was chosen */
  char               where[CLOCK_WHERE]; /* the step at hand, for messages */
  char               note[256];          /* what is unwise in the user's choice; empty: nothing */
  PetscBool          symmetric;          /* the matrix is */
  PetscBool          inner;              /* a nonlinear solver looks at the residual that counts */
  PetscInt           max_in_a_row;       /* falls in a row that are borne; -1: no ladder */
  KSP                level[FALLBACK_LEVELS]; /* of the ladder; NULL until needed */
  PetscInt           falls, in_a_row; /* solves that needed the ladder; since the last without */
  PetscBool          failed;          /* a solve since the last GuardCheck() */
  PetscReal          residual; /* true, relative, of the solve that failed or else of the last */
  KSPConvergedReason reason;   /* of the chosen method in that solve */
  PetscInt           iterations;
} Guard;

PetscErrorCode GuardAttach(KSP ksp, const LaplacianForm *form, Guard *guard);
PetscErrorCode GuardDetach(Guard *guard);
PetscErrorCode GuardMeasure(KSP ksp, Vec b, Vec x, PetscReal *residual, PetscBool *good);
PetscErrorCode GuardCheck(KSP ksp, Guard *guard, StepFailure *failure);
PetscErrorCode GuardRenewPC(KSP ksp);
PetscErrorCode SolverNames(KSP ksp, const char **type, const char **pc);
PetscErrorCode FallbackSolve(KSP ksp, Vec b, Vec x, Guard *guard, PetscBool *solved);
PetscErrorCode PressureSolver(const LaplacianForm *form, PetscReal rtol, KSP *ksp, Guard *guard);
PetscErrorCode TimeStepThrough(TS ts, const char name[], KSP ksp, Guard *guard, PetscReal t,
                               PetscReal dt, PetscReal *h, PetscInt *iterations,
                               StepFailure *failure);
PetscErrorCode AmgDefaults(const char prefix[], const char aggressive[]);
PetscErrorCode OptionDefault(const char prefix[], const char name[], const char value[]);

#endif
