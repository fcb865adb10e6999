/* Laplacians of a scalar as weighted sums of differences f_j - f_i, and their table. A new form
   needs a row function and a table row here. Notation: X = x_j - x_i, r = |X|, W' = dW/dr < 0,
   grad_i W = -(X/r) W', and d dimensions. */
#include "rows.h"

/* Computes the weights of LaplacianRow_Morris(). Tables hold no function that has two versions: its
   address is not unique. */
static ISPH_WIDE void MorrisWeights(const Stencil *st, PetscReal w[])
{
  const PetscReal *V = st->V, *dW = st->dW, *r = st->r;

  for (PetscInt k = 0; k < st->n; k++) w[k] = -2.0 * V[k] * dW[k] / r[k];
}

/*
  LaplacianRow_Morris - Computes the Laplacian of Morris, Fox & Zhu: finite differences along pairs
  times the kernel gradient

    (lap f)_i = sum_j -2 V_j (W'/r) (f_j - f_i)

  Properties: symmetric for equal volumes; consistent on lattices only, with an error O(1/dx) on
  disordered particles. Reference: J. P. Morris, P. J. Fox, Y. Zhu, J. Comput. Phys. 136 (1997)
  214-226
*/
static PetscErrorCode LaplacianRow_Morris(Stencil *st, PetscReal w[])
{
  PetscFunctionBegin;
  MorrisWeights(st, w);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  LaplacianRow_Gotoh - Computes the Laplacian from the kernel's Hessian along the pair

    (lap f)_i = 2/(d+2) sum_j V_j (W'' - W'/r) (f_j - f_i)

  Properties: symmetric for equal volumes; all weights positive, theory.md, (particles:convex). With
  the cubic spline the result on lattices is wrong by up to 8 %; on disordered particles the error
  is O(1/dx). Reference: X. Zheng, Q. Ma, S. Shao, Water 10 (2018), VISC-02, Eq. (16), after H.
  Gotoh et al., Appl. Ocean Res. 46 (2014) 104-115; the printed form is -(d+2)/2 times the Laplacian
*/
static PetscErrorCode LaplacianRow_Gotoh(Stencil *st, PetscReal w[])
{
  const PetscReal factor = 2.0 / (PetscReal)(st->dim + 2);

  PetscFunctionBegin;
  for (PetscInt k = 0; k < st->n; k++)
    w[k] = factor * st->V[k] * (st->ddW[k] - st->dW[k] / st->r[k]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  LaplacianRow_DirectScalar - Computes the Laplacian of the kernel

    (lap f)_i = sum_j V_j (W'' + (d-1) W'/r) (f_j - f_i)

  Properties: symmetric for equal volumes. Its weights change sign, and the matrix of -lap has
  negative eigenvalues: with spline kernels on lattices, with all kernels on disordered particles
  (theory.md, (rows:modes)). Modes that should decay then grow, so the form serves for comparison
  only. Reference: M. Basa, N. Quinlan, M. Lastiwka, Int. J. Numer. Meth. Fluids 60 (2009), model A
  for div u = 0
*/
static PetscErrorCode LaplacianRow_DirectScalar(Stencil *st, PetscReal w[])
{
  const PetscReal factor = (PetscReal)(st->dim - 1);

  PetscFunctionBegin;
  for (PetscInt k = 0; k < st->n; k++)
    w[k] = st->V[k] * (st->ddW[k] + factor * st->dW[k] / st->r[k]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  LaplacianRow_Schwaiger - Computes a Laplacian that the corrected gradient g_i makes exact for
  linear fields

    (lap f)_i = tr(M^-1)/d { 2 sum_j V_j (f_i - f_j) W'/r - 2 g_i . sum_j V_j grad_i W },
    g_i = M^-1 sum_j V_j (f_j - f_i) grad_i W,   M = sum_j V_j (grad_i W) X^T

  Properties: exact for linear fields; error O(1) for quadratic fields on disordered particles.
  Reference: H. F. Schwaiger, Int. J. Numer. Meth. Eng. 75 (2008) 647-671, with corrected signs
*/
static PetscErrorCode LaplacianRow_Schwaiger(Stencil *st, PetscReal w[])
{
  PetscReal inverse[ISPH_MAX_DIM * ISPH_MAX_DIM], gradient[ISPH_MAX_DIM];
  PetscReal sum[ISPH_MAX_DIM] = {0.0}, trace = 0.0;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < st->n; k++) w[k] = -st->V[k] * st->dW[k] / st->r[k];
  if (!MomentInverse(st, w, inverse)) st->regularised++;
  for (PetscInt a = 0; a < st->dim; a++) {
    trace += inverse[a * st->dim + a] / st->dim;
    for (PetscInt k = 0; k < st->n; k++) sum[a] += w[k] * st->X[a][k];
  }
  for (PetscInt k = 0; k < st->n; k++) {
    PetscReal dot = 0.0;

    CorrectedKernelGradient(st, inverse, k, gradient);
    for (PetscInt a = 0; a < st->dim; a++) dot += gradient[a] * sum[a];
    w[k] = 2.0 * trace * (w[k] - st->V[k] * dot);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  LaplacianFollowsSlopes - Returns true if the weights of a form follow from the corrected gradients
  of the kernel

    w_k = 2 X.c_k/r^2,   c of KernelGradients() with the same correction

  The component of c_k along the pair is -V_k W', with W' of the correction.
*/
PetscBool LaplacianFollowsSlopes(const LaplacianForm *form, unsigned correction)
{
  const unsigned own = form->correction ? form->correction->bit : 0;

  return form->row && form->row->Row == LaplacianRow_Morris && form->scale == 0.0 &&
         own == correction;
}

#define PAIRWISE  (FORM_NULL_CONSTANTS | FORM_FULL_SUPPORT)
#define DIFFUSIVE (FORM_SAFE_IMPLICIT | FORM_VARYING)
#define ADAPTED   (FORM_NULL_CONSTANTS | FORM_EXACT_LINEAR | DIFFUSIVE)
#define QUADRATIC (ADAPTED | FORM_EXACT_QUADRATIC)
#define OPPOSITE  (PAIRWISE | FORM_SYMMETRIC | FORM_MOMENTUM) /* opposite forces of a pair */
#define RADIAL    (OPPOSITE | FORM_ANGULAR | FORM_DISSIPATES | FORM_COUPLES | FORM_SAFE_IMPLICIT)
#define ENERGY    (OPPOSITE | FORM_DISSIPATES | FORM_COUPLES)
#define GRADIENTS (CORRECTION_SHEPARD | CORRECTION_FIRST_ORDER | CORRECTION_MIXED)

static const ComposedForm two_pass       = {GRADIENT_SPH, PETSC_FALSE, PETSC_FALSE};
static const ComposedForm energy_sph     = {GRADIENT_SPH, PETSC_TRUE, PETSC_TRUE};
static const ComposedForm energy_fpm     = {GRADIENT_FIRST_ORDER, PETSC_TRUE, PETSC_TRUE};
static const ComposedForm energy_coupled = {GRADIENT_COUPLED, PETSC_TRUE, PETSC_TRUE};

static const LaplacianRow laplacians[] = {
    /* name, brief, citation, properties, corrections, row, factor, grad div, composed, weak */
    {"morris", "finite difference times kernel gradient (VISC-01, model E)",
     "Morris, Fox & Zhu, J. Comput. Phys. 136 (1997)", OPPOSITE | FORM_DISSIPATES | DIFFUSIVE,
     GRADIENTS, LaplacianRow_Morris, NULL, 0.0, NULL, PETSC_FALSE},
    {"gotoh", "from the kernel's Hessian along the pair (VISC-02)",
     "Gotoh et al., Appl. Ocean Res. 46 (2014); Zheng, Ma & Shao, Water 10 (2018)",
     OPPOSITE | FORM_DISSIPATES | DIFFUSIVE, CORRECTION_SHEPARD, LaplacianRow_Gotoh, NULL, 0.0,
     NULL, PETSC_FALSE},
    {"schwaiger", "morris without the error of linear fields (VISC-03)",
     "Schwaiger, Int. J. Numer. Meth. Eng. 75 (2008)", ADAPTED | FORM_FULL_SUPPORT, 0,
     LaplacianRow_Schwaiger, NULL, 0.0, NULL, PETSC_FALSE},
    {"direct_scalar", "Laplacian of the kernel; anti-diffusive, for comparison",
     "Basa, Quinlan & Lastiwka, Int. J. Numer. Meth. Fluids 60 (2009)", OPPOSITE,
     CORRECTION_SHEPARD, LaplacianRow_DirectScalar, NULL, 0.0, NULL, PETSC_FALSE},
    {"mls", "quadratic moving least squares with boundary conditions in the fit",
     "Liu & Gu, Meshfree Methods (2005); Kuhnert (1999)", QUADRATIC, 0, LaplacianRow_Mls, NULL, 0.0,
     NULL, PETSC_FALSE},
    {"stress_mls",
     "div of the stress 2 nu E + nu (div u) I, least squares along pairs; viscosity only",
     "after Cleary & Monaghan, J. Comput. Phys. 148 (1999)",
     QUADRATIC | FORM_COUPLES | FORM_FULL_SUPPORT, 0, LaplacianRow_StressMls, NULL, 2.0, NULL,
     PETSC_FALSE},
    {"pairwise_stress",
     "the same stress by symmetric pair forces, no traction at free surfaces; viscosity only",
     "after Weiler et al., Comput. Graph. Forum 37(2) (2018)", RADIAL | FORM_VARYING, 0,
     LaplacianRow_PairwiseStress, Factor_PairwiseStress, 2.0, NULL, PETSC_FALSE},
    {"violeau", "radial pair forces by the kernel gradient (model C); viscosity only",
     "Violeau & Issa, Int. J. Numer. Meth. Fluids 53 (2007); Basa, Quinlan & Lastiwka (2009)",
     RADIAL, GRADIENTS, LaplacianRow_Violeau, NULL, 2.0, NULL, PETSC_FALSE},
    {"cleary", "the same with the factor -cleary_xi (model D); viscosity only",
     "Cleary, Appl. Math. Modelling 22 (1998); Basa, Quinlan & Lastiwka (2009)",
     RADIAL | FORM_VARYING, GRADIENTS, LaplacianRow_Cleary, NULL, 2.0, NULL, PETSC_FALSE},
    {"direct", "second derivatives of the kernel (model A); uniform flow decays, for comparison",
     "Basa, Quinlan & Lastiwka, Int. J. Numer. Meth. Fluids 60 (2009)",
     FORM_SYMMETRIC | FORM_DISSIPATES | FORM_COUPLES | FORM_FULL_SUPPORT, CORRECTION_SHEPARD,
     LaplacianRow_Direct, NULL, 1.0 / 3.0, NULL, PETSC_FALSE},
    {"two_pass", "gradient of the stress of the velocity gradient (model B); viscosity only",
     "Flebbe et al., Astrophys. J. 431 (1994); Basa, Quinlan & Lastiwka (2009)",
     PAIRWISE | FORM_COUPLES, GRADIENTS, NULL, NULL, 0.0, &two_pass, PETSC_FALSE},
    {"energy_sph", "stress of the velocity gradient, forces by its adjoint; viscosity only",
     "Fang et al., Appl. Numer. Math. 59 (2009)", ENERGY, 0, NULL, NULL, 0.0, &energy_sph,
     PETSC_FALSE},
    {"energy_fpm", "the same with gradients of first order (FPH); viscosity only",
     "Fang et al., Appl. Numer. Math. 59 (2009)", ENERGY | FORM_ANGULAR, 0, NULL, NULL, 0.0,
     &energy_fpm, PETSC_FALSE},
    {"energy_coupled", "the same, of first order beside boundaries only (CPH); viscosity only",
     "Fang et al., Appl. Numer. Math. 59 (2009)", ENERGY, 0, NULL, NULL, 0.0, &energy_coupled,
     PETSC_FALSE},
    {.name       = "weak_stress",
     .brief      = "derivative of the dissipation of small cells that bodies and interfaces cut; "
                   "viscosity only",
     .citation   = "after Chen, Wu, Yoon & You, Int. J. Numer. Meth. Eng. 50 (2001)",
     .properties = ADAPTED | FORM_COUPLES | FORM_MOMENTUM | FORM_ANGULAR | FORM_DISSIPATES,
     .weak       = PETSC_TRUE},
};

/* Appends the declared properties and the accepted corrections of a Laplacian to a text. */
static PetscErrorCode LaplacianDescribe(const TableRow *row, char text[], size_t length)
{
  const LaplacianRow *form  = (const LaplacianRow *)(const void *)row;
  const char         *comma = "; -correction ";

  PetscFunctionBegin;
  PetscCall(FormDescribe(form->properties, text, length));
  for (PetscInt k = 0; k < CorrectionTable.count; k++) {
    const CorrectionRow *correction =
        (const CorrectionRow *)(const void *)TableGet(&CorrectionTable, k);

    if (!(form->corrections & correction->bit)) continue;
    TextAppend(text, length, comma);
    TextAppend(text, length, correction->name);
    comma = ", ";
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

const Table LaplacianTable = TABLE_DESCRIBED("Laplacians", laplacians, LaplacianDescribe);
