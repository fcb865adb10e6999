/*
  Forms for comparison, as a shared object for -forms_library: the cubic fit beside quadratic ones,
  the corrected kernel under the name of its paper, and second derivatives of the kernel with
  differences of velocities.
*/
#include "rows/rows.h"

/*
  LaplacianRow_Mls3 - Computes the Laplacian of the cubic fit, or of the quadratic fit if the points
  do not determine the cubic fit; st->regularised counts such rows

  Properties: exact for cubic fields, so of order 2 on disordered particles too; not symmetric; uses
  the wall neighbours' equations.
*/
static PetscErrorCode LaplacianRow_Mls3(Stencil *st, PetscReal w[])
{
  const PetscInt degree = st->degree;

  PetscFunctionBegin;
  st->degree = 3;
  PetscCall(LaplacianRow_Mls(st, w));
  st->degree = degree;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  LaplacianRow_Corrected - Computes the Laplacian of Morris, Fox & Zhu with the corrected kernel
  gradient

    (lap f)_i = sum_j 2 V_j X.(M^-1 grad_i W)/r^2 (f_j - f_i),   M = sum_j V_j (grad_i W) X^T

  Properties: exact for |x - x_i|^2; linear fields have an error O(1/dx) on disordered particles. It
  is morris with -correction first_order.

  Reference: G. Oger et al., J. Comput. Phys. 225 (2007); X. Zheng, Q. Ma, S. Shao, Water 10 (2018),
  VISC-04
*/
static PetscErrorCode LaplacianRow_Corrected(Stencil *st, PetscReal w[])
{
  PetscFunctionBegin;
  CorrectKernel_FirstOrder(st, w, NULL);
  for (PetscInt k = 0; k < st->n; k++) w[k] = -2.0 * st->V[k] * w[k] / st->r[k];
  PetscFunctionReturn(PETSC_SUCCESS);
}

#define DIFFERENCES                                                                                \
  (FORM_NULL_CONSTANTS | FORM_FULL_SUPPORT | FORM_SYMMETRIC | FORM_MOMENTUM | FORM_COUPLES)

static const LaplacianRow laplacians[] = {
    {"mls3", "cubic moving least squares, second order on disorder too",
     "Liu & Gu, Meshfree Methods (2005); Kuhnert (1999)",
     FORM_NULL_CONSTANTS | FORM_EXACT_LINEAR | FORM_EXACT_QUADRATIC | FORM_SAFE_IMPLICIT |
         FORM_VARYING,
     0, LaplacianRow_Mls3, NULL, 0.0, NULL, PETSC_FALSE},
    {"corrected", "morris with -correction first_order under another name (VISC-04)",
     "Oger et al., J. Comput. Phys. 225 (2007)",
     FORM_NULL_CONSTANTS | FORM_FULL_SUPPORT | FORM_SAFE_IMPLICIT | FORM_VARYING, 0,
     LaplacianRow_Corrected, NULL, 0.0, NULL, PETSC_FALSE},
    {"direct_difference", "direct with differences of velocities; anti-diffusive, for comparison",
     "Basa, Quinlan & Lastiwka, Int. J. Numer. Meth. Fluids 60 (2009)", DIFFERENCES,
     CORRECTION_SHEPARD, LaplacianRow_DirectDifference, NULL, 1.0 / 3.0, NULL, PETSC_FALSE},
};

const FormsLibrary IsphForms = {FORMS_BUILD, .laplacians = TABLE("Laplacians", laplacians)};
