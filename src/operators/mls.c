/*
  Moving least squares. The fit about particle i is a polynomial that interpolates f_i,

    f(x_i + X) - f_i = sum_t c_t phi_t(X/R),   phi(s) = s_a, s_a s_b (b <= a), ...,

  with the radius R of the support. Each neighbour k gives an equation for the coefficients c_t,
  which minimise sum_k W_k (residual of the equation of k)^2. A fluid neighbour gives its value. A
  wall neighbour gives its boundary condition: f = f_wall, n.grad f = g, or n.f = n.f_wall for
  vectors (mlsvector.c). The fit is exact for polynomials of its degree.

  Reference: G. R. Liu & Y. T. Gu, An Introduction to Meshfree Methods, Springer 2005, ch. 3;
  boundary conditions as equations of the fit: J. Kuhnert, PhD thesis, Kaiserslautern 1999 (finite
  pointsets).
*/
#include "mls.h"

/*
  MlsFactorOrRidge - Factors a moment matrix; if the points do not determine the fit, adds a
  multiple of the unit matrix and counts the fit

  Not collective. Input: copy - copy of the moments, because the factor overwrites them.
*/
void MlsFactorOrRidge(PetscInt n, PetscReal moments[], const PetscReal copy[],
                      PetscInt *regularised)
{
  if (!DenseCholesky(n, moments)) return;
  (*regularised)++;
  DenseCholeskyRidge(n, copy, 1e-8, moments);
}

/* Computes the moment matrix sum_k W_k phi_k phi_k^T; inlined, so that the compiler knows dim and
   degree. */
static inline void MlsMomentsInline(const Stencil *st, PetscInt dim, PetscInt degree,
                                    PetscReal moments[])
{
  const PetscInt terms = MlsTerms(dim, degree);
  PetscReal      phi[MLS_MAX_TERMS], sum[MLS_MAX_TERMS * (MLS_MAX_TERMS + 1) / 2];
  PetscInt       s = 0;

  for (PetscInt e = 0; e < terms * (terms + 1) / 2; e++) sum[e] = 0.0;
  for (PetscInt k = 0; k < st->n; k++) {
    PetscInt e = 0;

    (void)MlsEquation(st, dim, degree, k, phi);
    for (PetscInt t = 0; t < terms; t++) {
      const PetscReal weighted = st->W[k] * phi[t];

      for (PetscInt q = 0; q <= t; q++) sum[e++] += weighted * phi[q];
    }
  }
  for (PetscInt t = 0; t < terms; t++) {
    for (PetscInt q = 0; q <= t; q++) moments[t * terms + q] = moments[q * terms + t] = sum[s++];
  }
}

static void MlsMoments(const Stencil *st, PetscInt degree, PetscReal moments[])
{
  if (st->dim == 2 && degree == 2) MlsMomentsInline(st, 2, 2, moments);
  else if (st->dim == 2) MlsMomentsInline(st, 2, 3, moments);
  else if (degree == 2) MlsMomentsInline(st, 3, 2, moments);
  else MlsMomentsInline(st, 3, 3, moments);
}

/*
  Factors the moment matrix of the cubic fit for the present equations of the neighbours.

  Returns: PETSC_FALSE if the neighbours do not determine the fit
*/
static PetscBool MlsFactorCubic(const Stencil *st, MlsFit *fit)
{
  fit->degree = 3;
  fit->terms  = MlsTerms(st->dim, 3);
  MlsMoments(st, 3, fit->factor);
  return DenseCholesky(fit->terms, fit->factor) ? PETSC_FALSE : PETSC_TRUE;
}

/* Factors the moment matrix of the quadratic fit for the present equations of the neighbours,
   unless st->fit is valid. */
static PetscErrorCode MlsFactor(Stencil *st)
{
  MlsFit   *fit = &st->fit;
  PetscReal copy[MLS_QUADRATIC_TERMS * MLS_QUADRATIC_TERMS];

  PetscFunctionBegin;
  if (fit->valid) PetscFunctionReturn(PETSC_SUCCESS);
  fit->degree = 2;
  fit->terms  = MlsTerms(st->dim, 2);
  MlsMoments(st, 2, fit->factor);
  PetscCall(PetscArraycpy(copy, fit->factor, fit->terms * fit->terms));
  MlsFactorOrRidge(fit->terms, fit->factor, copy, &st->regularised);
  fit->valid = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static inline void MlsWeightsInline(const Stencil *st, PetscInt dim, PetscInt degree,
                                    const PetscReal c[], PetscReal w[])
{
  const PetscInt terms = MlsTerms(dim, degree);

  for (PetscInt k = 0; k < st->n; k++) {
    PetscReal       phi[MLS_MAX_TERMS], sum = 0.0;
    const PetscReal scale = MlsEquation(st, dim, degree, k, phi);

    for (PetscInt t = 0; t < terms; t++) sum += phi[t] * c[t];
    w[k] = scale * st->W[k] * sum;
  }
}

/*
  Computes weights w_k that give a linear functional of the coefficients c_t of a fit

    sum_t functional_t c_t = sum_k w_k (data of neighbour k)
*/
static void MlsWeights(const Stencil *st, const MlsFit *fit, const PetscReal functional[],
                       PetscReal w[])
{
  PetscReal c[MLS_MAX_TERMS];

  for (PetscInt t = 0; t < fit->terms; t++) c[t] = functional[t];
  DenseCholeskySolve(fit->terms, fit->factor, c);
  if (st->dim == 2 && fit->degree == 2) MlsWeightsInline(st, 2, 2, c, w);
  else if (st->dim == 2) MlsWeightsInline(st, 2, 3, c, w);
  else if (fit->degree == 2) MlsWeightsInline(st, 3, 2, c, w);
  else MlsWeightsInline(st, 3, 3, c, w);
}

/* Computes the weights of lap f = 2/R^2 sum_a c_aa, c_aa the coefficient of (X_a/R)^2 in a fit of
   degree 2 or 3. */
static void MlsLaplacian(const Stencil *st, const MlsFit *fit, PetscReal w[])
{
  PetscReal functional[MLS_MAX_TERMS] = {0.0};
  PetscInt  t                         = st->dim;

  for (PetscInt a = 0; a < st->dim; a++) {
    for (PetscInt b = 0; b <= a; b++, t++) {
      if (a == b) functional[t] = 2.0 / PetscSqr(st->radius);
    }
  }
  MlsWeights(st, fit, functional, w);
}

/*
  LaplacianRow_Mls - Computes the Laplacian of the quadratic fit

    lap f = 2/R^2 sum_a c_aa,   c_aa the coefficient of (X_a/R)^2

  Properties: exact for quadratic fields on any arrangement of particles; not symmetric; uses the
  wall neighbours' equations.
*/
PetscErrorCode LaplacianRow_Mls(Stencil *st, PetscReal w[])
{
  PetscFunctionBegin;
  PetscCall(MlsFactor(st));
  MlsLaplacian(st, &st->fit, w);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  LaplacianRow_Mls3 - Computes the Laplacian of the cubic fit, or of the quadratic fit if the points
  do not determine the cubic fit; st->regularised counts such rows

  Properties: exact for cubic fields, so of order 2 on disordered particles too; not symmetric; uses
  the wall neighbours' equations.
*/
PetscErrorCode LaplacianRow_Mls3(Stencil *st, PetscReal w[])
{
  MlsFit cubic;

  PetscFunctionBegin;
  if (MlsFactorCubic(st, &cubic)) {
    MlsLaplacian(st, &cubic, w);
  } else {
    st->regularised++;
    PetscCall(LaplacianRow_Mls(st, w));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* GradientRow_Mls - Computes the gradient of the quadratic fit, df/dx_a = c_a/R with the
   coefficient c_a of X_a/R; exact for quadratic fields */
PetscErrorCode GradientRow_Mls(Stencil *st, PetscReal *g[])
{
  PetscFunctionBegin;
  PetscCall(MlsFactor(st));
  for (PetscInt a = 0; a < st->dim; a++) {
    PetscReal functional[MLS_QUADRATIC_TERMS] = {0.0};

    functional[a] = 1.0 / st->radius;
    MlsWeights(st, &st->fit, functional, g[a]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the weight W of a neighbour whose equation gives a value, otherwise 0: only values
   determine the constant of a fit. */
static inline PetscReal ValueWeight(const Stencil *st, PetscInt k)
{
  return st->equation[k] == EQUATION_VALUE ? st->W[k] : 0.0;
}

/*
  FilterRow_Mls - Computes the residual of a quadratic fit with a free constant, docs/theory.md,
  (22)

    f_i - c_0 = -sum_k w_k (f_k - f_i),   w_k = W_k (1 - m.c_k)/(W(0) + sum_k W_k - m.M^-1 m),
    c_k = M^-1 phi_k,   m = sum_k W_k phi_k,   M = sum_k W_k phi_k phi_k^T

  phi_k and M are the basis at neighbour k and the moment matrix of the fit that interpolates f_i
  (top of this file). The constant c_0 is eliminated by hand. For a neighbour that gives n.grad f,
  w_k lacks the term 1, and m lacks the term of this neighbour.

  Properties: vanishes for quadratic fields on any arrangement of particles. For smooth fields it is
  of order dx^4 inside a lattice, and of order dx^3 on disordered particles and beside a boundary.
  With wendland_c2 and h/dx = 1.3 in 2D it is 0.81 f_i for a checkerboard and 0.26 f_i for stripes.
  Not symmetric.

  Reference: after C. R. Dohrmann, P. B. Bochev, Int. J. Numer. Meth. Fluids 46 (2004) 183-201
*/
PetscErrorCode FilterRow_Mls(Stencil *st, PetscReal w[])
{
  PetscReal mean[MLS_QUADRATIC_TERMS] = {0.0}, c[MLS_QUADRATIC_TERMS], phi[MLS_MAX_TERMS];
  PetscReal sum                       = st->self[0];

  PetscFunctionBegin;
  PetscCall(MlsFactor(st));
  for (PetscInt k = 0; k < st->n; k++) {
    const PetscReal weight = ValueWeight(st, k);

    (void)MlsEquation(st, st->dim, 2, k, phi);
    sum += weight;
    for (PetscInt t = 0; t < st->fit.terms; t++) mean[t] += weight * phi[t];
  }
  for (PetscInt t = 0; t < st->fit.terms; t++) c[t] = mean[t];
  DenseCholeskySolve(st->fit.terms, st->fit.factor, c);
  for (PetscInt t = 0; t < st->fit.terms; t++) sum -= mean[t] * c[t];
  for (PetscInt k = 0; k < st->n; k++) {
    const PetscReal scale = MlsEquation(st, st->dim, 2, k, phi) * st->W[k];

    w[k] = -ValueWeight(st, k) / sum;
    for (PetscInt t = 0; t < st->fit.terms; t++) w[k] += scale * phi[t] * c[t] / sum;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
