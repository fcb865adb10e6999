/*
  Moving least squares, quadratic and interpolating: about particle i the fit

    f(x_i + X) - f_i = sum_t c_t phi_t(X/R),   phi = X_a, X_a X_b (a <= b),   R the support's
  radius,

  minimises sum_k W_k (equation of neighbour k)^2. Where a wall particle bears a role, its equation
  is the boundary condition: n.grad f = g, or n.f = n.f_wall for vectors. Exact for quadratics.

  Reference: G. R. Liu & Y. T. Gu, An Introduction to Meshfree Methods, Springer 2005, ch. 3;
  boundary conditions as equations of the fit: J. Kuhnert, PhD thesis, Kaiserslautern 1999 (finite
  pointsets).
*/
#include "isph/operators.h"

static inline PetscInt MlsTerms(PetscInt dim)
{
  return dim + dim * (dim + 1) / 2;
}

/* Basis at neighbour k: first the X_a, then the X_a X_b by rows of the lower triangle. */
static inline void MlsBasis(const Stencil *st, PetscInt dim, PetscInt k, PetscReal phi[])
{
  PetscReal s[ISPH_MAX_DIM];
  PetscInt  t = dim;

  for (PetscInt a = 0; a < dim; a++) phi[a] = s[a] = st->X[a][k] / st->radius;
  for (PetscInt a = 0; a < dim; a++) {
    for (PetscInt b = 0; b <= a; b++) phi[t++] = s[a] * s[b];
  }
}

/* Scaled n.grad of the basis at wall neighbour k. */
static inline void MlsBasisNormalDerivative(const Stencil *st, PetscInt dim, PetscInt k,
                                            PetscReal phi[])
{
  PetscReal s[ISPH_MAX_DIM], n[ISPH_MAX_DIM];
  PetscInt  t = dim;

  for (PetscInt a = 0; a < dim; a++) {
    s[a]   = st->X[a][k] / st->radius;
    phi[a] = n[a] = st->normal[a][k] * st->scale / st->radius;
  }
  for (PetscInt a = 0; a < dim; a++) {
    for (PetscInt b = 0; b <= a; b++) phi[t++] = n[a] * s[b] + s[a] * n[b];
  }
}

/* The left-hand side of the equation of neighbour k, and what its right-hand side is scaled by. */
static inline PetscReal MlsEquation(const Stencil *st, PetscInt dim, PetscInt k, PetscReal phi[])
{
  if (st->fits_walls && st->wall[k] && st->role == ROLE_NORMAL_DERIVATIVE) {
    MlsBasisNormalDerivative(st, dim, k, phi);
    return st->scale;
  }
  MlsBasis(st, dim, k, phi);
  return 1.0;
}

/*
  Factors a moment matrix; where the points do not determine the fit, a ridge makes it the smallest
  of the best fits and the stencil counts it.
*/
static void MlsFactorOrRidge(PetscInt n, PetscReal moments[], const PetscReal copy[],
                             PetscInt *weak)
{
  PetscReal ridge = 1e-8;

  if (!DenseCholesky(n, moments)) return;
  (*weak)++;
  for (PetscReal trace = 0.0;; ridge *= 100.0) {
    trace = 0.0;
    for (PetscInt t = 0; t < n; t++) trace += copy[t * n + t];
    for (PetscInt t = 0; t < n * n; t++) moments[t] = copy[t];
    for (PetscInt t = 0; t < n; t++) moments[t * n + t] += ridge * (trace > 0.0 ? trace : 1.0);
    if (!DenseCholesky(n, moments)) return;
  }
}

/* Moment matrix sum_k W_k phi_k phi_k^T, lower triangle; inlined with a constant dim. */
static inline void MlsMoments(const Stencil *st, PetscInt dim, PetscReal moments[])
{
  const PetscInt terms = dim + dim * (dim + 1) / 2;
  PetscReal      phi[MLS_MAX_TERMS], sum[MLS_MAX_TERMS * (MLS_MAX_TERMS + 1) / 2] = {0.0};
  PetscInt       s = 0;

  for (PetscInt k = 0; k < st->n; k++) {
    PetscInt e = 0;

    (void)MlsEquation(st, dim, k, phi);
    for (PetscInt t = 0; t < terms; t++) {
      const PetscReal weighted = st->W[k] * phi[t];

      for (PetscInt q = 0; q <= t; q++) sum[e++] += weighted * phi[q];
    }
  }
  for (PetscInt t = 0; t < terms; t++) {
    for (PetscInt q = 0; q <= t; q++) moments[t * terms + q] = moments[q * terms + t] = sum[s++];
  }
}

/*
  MlsFactor - Makes the stencil's fit ready for its present role

  Not collective. Does nothing where the fit is already valid.
*/
PetscErrorCode MlsFactor(Stencil *st)
{
  PetscReal copy[MLS_MAX_TERMS * MLS_MAX_TERMS];

  PetscFunctionBegin;
  if (st->fit.valid) PetscFunctionReturn(PETSC_SUCCESS);
  st->fit.terms = MlsTerms(st->dim);
  if (st->dim == 2) MlsMoments(st, 2, st->fit.factor);
  else MlsMoments(st, 3, st->fit.factor);
  PetscCall(PetscArraycpy(copy, st->fit.factor, st->fit.terms * st->fit.terms));
  MlsFactorOrRidge(st->fit.terms, st->fit.factor, copy, &st->weak);
  st->fit.valid = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static inline void MlsWeightsInline(const Stencil *st, PetscInt dim, const PetscReal c[],
                                    PetscReal w[])
{
  const PetscInt terms = dim + dim * (dim + 1) / 2;

  for (PetscInt k = 0; k < st->n; k++) {
    PetscReal       phi[MLS_MAX_TERMS], sum = 0.0;
    const PetscReal scale = MlsEquation(st, dim, k, phi);

    for (PetscInt t = 0; t < terms; t++) sum += phi[t] * c[t];
    w[k] = scale * st->W[k] * sum;
  }
}

/*
  MlsWeights - Weights of a functional of the fit

    sum_t functional_t c_t = sum_k w_k (right-hand side of neighbour k)

  Not collective. Input: functional - one number for each basis function, in scaled coordinates X/R.
*/
PetscErrorCode MlsWeights(Stencil *st, const PetscReal functional[], PetscReal w[])
{
  PetscReal c[MLS_MAX_TERMS];

  PetscFunctionBegin;
  PetscCall(MlsFactor(st));
  for (PetscInt t = 0; t < st->fit.terms; t++) c[t] = functional[t];
  DenseCholeskySolve(st->fit.terms, st->fit.factor, c);
  if (st->dim == 2) MlsWeightsInline(st, 2, c, w);
  else MlsWeightsInline(st, 3, c, w);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  LaplacianRow_Mls - Laplacian of the quadratic fit, lap f = 2/R^2 sum_a c_aa

  Properties: exact for quadratics on any arrangement; not symmetric; takes wall roles.
*/
PetscErrorCode LaplacianRow_Mls(Stencil *st, PetscReal w[])
{
  PetscReal functional[MLS_MAX_TERMS] = {0.0};
  PetscInt  t                         = st->dim;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < st->dim; a++) {
    for (PetscInt b = 0; b <= a; b++, t++) {
      if (a == b) functional[t] = 2.0 / PetscSqr(st->radius);
    }
  }
  PetscCall(MlsWeights(st, functional, w));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* GradientRow_Mls - Gradient of the quadratic fit, df/dx_a = c_a/R; exact for quadratics */
PetscErrorCode GradientRow_Mls(Stencil *st, PetscReal *g[])
{
  PetscFunctionBegin;
  for (PetscInt a = 0; a < st->dim; a++) {
    PetscReal functional[MLS_MAX_TERMS] = {0.0};

    functional[a] = 1.0 / st->radius;
    PetscCall(MlsWeights(st, functional, g[a]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Moment matrix of the vector fit: components coupled by the equations n.f of wall neighbours. */
static void MlsVectorMoments(const Stencil *st, PetscReal moments[])
{
  const PetscInt d = st->dim, terms = MlsTerms(d), n = d * terms;

  for (PetscInt k = 0; k < st->n; k++) {
    PetscReal phi[MLS_MAX_TERMS];

    MlsBasis(st, d, k, phi);
    for (PetscInt c = 0; c < d; c++) {
      for (PetscInt e = 0; e < d; e++) {
        const PetscReal couple =
            st->wall[k] ? st->normal[c][k] * st->normal[e][k] : (c == e ? 1.0 : 0.0);

        if (couple == 0.0) continue;
        for (PetscInt t = 0; t < terms; t++) {
          const PetscReal weighted = couple * st->W[k] * phi[t];

          for (PetscInt q = 0; q < terms; q++)
            moments[(c * terms + t) * n + e * terms + q] += weighted * phi[q];
        }
      }
    }
  }
}

/*
  DivergenceFit_Mls - Divergence of a vector fit that sees of each wall only its normal velocity

    div u = sum_c c_c,c/R,  least: sum_k W_k |u_k - u_i - fit|^2 + sum_w W_w (n.(u_w - u_i - fit))^2

  over fluid neighbours k and wall neighbours w.

  The wall's tangential velocity (a lid's jump at a corner) is none of the divergence's business;
  the fit couples the components so that this holds for any orientation of the wall.

  Output Parameters:
+ d - d[c][k] multiplies (u_k - u_i)_c of fluid neighbour k, zero for walls [1/m]
- m - m[k] multiplies n.(u_k - u_i) of wall neighbour k, zero for fluid [1/m]
*/
PetscErrorCode DivergenceFit_Mls(Stencil *st, PetscReal *d[], PetscReal m[])
{
  const PetscInt dim = st->dim, terms = MlsTerms(dim), n = dim * terms;
  PetscReal      moments[ISPH_MAX_DIM * ISPH_MAX_DIM * MLS_MAX_TERMS * MLS_MAX_TERMS] = {0.0};
  PetscReal      copy[ISPH_MAX_DIM * ISPH_MAX_DIM * MLS_MAX_TERMS * MLS_MAX_TERMS];
  PetscReal      c[ISPH_MAX_DIM * MLS_MAX_TERMS] = {0.0};

  PetscFunctionBegin;
  MlsVectorMoments(st, moments);
  PetscCall(PetscArraycpy(copy, moments, n * n));
  MlsFactorOrRidge(n, moments, copy, &st->weak);
  for (PetscInt a = 0; a < dim; a++) c[a * terms + a] = 1.0 / st->radius;
  DenseCholeskySolve(n, moments, c);
  for (PetscInt k = 0; k < st->n; k++) {
    PetscReal phi[MLS_MAX_TERMS];

    MlsBasis(st, dim, k, phi);
    m[k] = 0.0;
    for (PetscInt a = 0; a < dim; a++) {
      PetscReal sum = 0.0;

      for (PetscInt t = 0; t < terms; t++) sum += phi[t] * c[a * terms + t];
      if (st->wall[k]) m[k] += st->W[k] * st->normal[a][k] * sum;
      d[a][k] = st->wall[k] ? 0.0 : st->W[k] * sum;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
