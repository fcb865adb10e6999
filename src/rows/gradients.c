/* Gradients as weighted sums of differences f_j - f_i, and their table; divergences use the same
   weights. A new gradient needs a row function and a table row here. */
#include "rows.h"

/*
  GradientRow_Plain - Computes the SPH gradient of differences

    (df/dx_a)_i = sum_j V_j (dW/dx_a)_i (f_j - f_i)

  Properties: exact for constants. The gradient of a linear field has an error of order 1 on
  disordered particles; on a lattice it is wrong by a constant factor near 1. Reference: J. J.
  Monaghan, Rep. Prog. Phys. 68 (2005) 1703-1759
*/
static PetscErrorCode GradientRow_Plain(Stencil *st, PetscReal *g[])
{
  PetscFunctionBegin;
  for (PetscInt a = 0; a < st->dim; a++) {
    for (PetscInt k = 0; k < st->n; k++) g[a][k] = -st->V[k] * st->X[a][k] * st->dW[k] / st->r[k];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  GradientRow_Corrected - Computes the first-order consistent SPH gradient

    (grad f)_i = M^-1 sum_j V_j grad_i W (f_j - f_i),   M = sum_j V_j (grad_i W) X^T

  Properties: exact for linear fields on any arrangement of particles. Reference: J. Bonet, T.-S. L.
  Lok, Comput. Methods Appl. Mech. Eng. 180 (1999) 97-115
*/
static PetscErrorCode GradientRow_Corrected(Stencil *st, PetscReal *g[])
{
  PetscReal inverse[ISPH_MAX_DIM * ISPH_MAX_DIM];

  PetscFunctionBegin;
  for (PetscInt k = 0; k < st->n; k++) g[0][k] = -st->V[k] * st->dW[k] / st->r[k];
  if (!MomentInverse(st, g[0], inverse)) st->regularised++;
  for (PetscInt k = 0; k < st->n; k++) {
    const PetscReal scale = g[0][k];

    for (PetscInt a = 0; a < st->dim; a++) {
      PetscReal sum = 0.0;

      for (PetscInt b = 0; b < st->dim; b++) sum += inverse[a * st->dim + b] * st->X[b][k];
      g[a][k] = scale * sum;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const GradientRow gradients[] = {
    /* name, brief, citation, properties, row, divergence with normal components */
    {"plain", "SPH gradient of differences", "Monaghan, Rep. Prog. Phys. 68 (2005)",
     FORM_NULL_CONSTANTS | FORM_FULL_SUPPORT, GradientRow_Plain, NULL},
    {"corrected", "exact for linear fields by the inverse moment matrix",
     "Bonet & Lok, Comput. Methods Appl. Mech. Eng. 180 (1999)",
     FORM_NULL_CONSTANTS | FORM_EXACT_LINEAR | FORM_FULL_SUPPORT, GradientRow_Corrected, NULL},
    {"mls", "quadratic moving least squares with boundary conditions in the fit",
     "Liu & Gu, Meshfree Methods (2005); Kuhnert (1999)",
     FORM_NULL_CONSTANTS | FORM_EXACT_LINEAR | FORM_EXACT_QUADRATIC, GradientRow_Mls,
     DivergenceFit_Mls},
};

static PetscErrorCode GradientDescribe(const TableRow *row, char text[], size_t length)
{
  PetscFunctionBegin;
  PetscCall(FormDescribe(((const GradientRow *)(const void *)row)->properties, text, length));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const Table GradientTable =
    TABLE_DESCRIBED("Gradients and divergences", gradients, GradientDescribe);
