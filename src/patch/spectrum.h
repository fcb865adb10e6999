/* Spectrum of the matrix of a patch test: the program, and its module with SLEPc. */
#ifndef ISPH_PATCH_SPECTRUM_H
#define ISPH_PATCH_SPECTRUM_H

#include "isph/petsc.h"

/* Real parts of the extreme eigenvalues, and the ratio of the extreme singular values. */
typedef struct {
  PetscReal eig_min, eig_max, condition;
} Spectrum;

/* SpectrumCondition - Returns the condition number of A from the least and the largest eigenvalue
   of A^T A; not collective */
static inline PetscReal SpectrumCondition(PetscReal least, PetscReal most)
{
  return least > 0.0 ? PetscSqrtReal(most / least) : PETSC_INFINITY;
}

typedef PetscErrorCode SparseSpectrum(Mat A, Spectrum *spectrum);
SparseSpectrum         SpectrumSlepc;

#endif
