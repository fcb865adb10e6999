/* The guard of linear solves; see guard.c. */
#ifndef ISPH_GUARD_H
#define ISPH_GUARD_H

#include "isph/schemes.h"

typedef struct {
  const char        *what;      /* "viscous" or "pressure" */
  const char        *prefix;    /* "visc_" or "ppe_" */
  PetscBool          symmetric; /* the matrix is */
  PetscBool          failed;    /* a solve since the last GuardCheck() */
  PetscReal          residual;  /* true, relative, of the solve that failed or else of the last */
  KSPConvergedReason reason;
  PetscInt           iterations;
} Guard;

PetscErrorCode GuardAttach(KSP ksp, PetscBool symmetric, Guard *guard);
PetscErrorCode GuardCheck(KSP ksp, const Clock *clock, Guard *guard);
PetscErrorCode GuardRenewPC(KSP ksp);
PetscErrorCode OptionDefault(const char prefix[], const char name[], const char value[]);

#endif
