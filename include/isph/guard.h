/* The guard of linear solves; see src/schemes/guard.c. */
#ifndef ISPH_GUARD_H
#define ISPH_GUARD_H

#include "isph/schemes.h"

typedef struct {
  const char        *what;      /* "viscous", "pressure", ... */
  const char        *prefix;    /* "visc_" or "ppe_" */
  PetscBool          symmetric; /* the matrix is */
  PetscBool          failed;    /* a solve since the last GuardCheck() */
  PetscReal          residual;  /* true, relative, of the solve that failed or else of the last */
  KSPConvergedReason reason;
  PetscInt           iterations;
  char               note[256]; /* what is unwise in the user's choice; empty: nothing */
} Guard;

PetscErrorCode GuardAttach(KSP ksp, const LaplacianForm *form, Guard *guard);
PetscErrorCode GuardCheck(KSP ksp, const char where[], Guard *guard);
PetscErrorCode GuardRenewPC(KSP ksp);
PetscErrorCode PressureSolver(const LaplacianForm *form, PetscReal rtol, KSP *ksp, Guard *guard);
PetscErrorCode OptionDefault(const char prefix[], const char name[], const char value[]);

#endif
