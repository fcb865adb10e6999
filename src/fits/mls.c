/*
  Moving least squares. The fit about particle i is a polynomial that interpolates f_i,

    f(x_i + X) - f_i = sum_t c_t phi_t(X/R),   phi(s) = s_a, s_a s_b (b <= a), ...,

  with the radius R of the support. On graded lattices X and R are those of the stretched axes about
  the particle, and derivatives have the factor Stencil.stretch for each axis. Each neighbour k
  gives an equation for the coefficients c_t, which minimise sum_k W_k (residual of the equation of
  k)^2. A fluid neighbour gives its value. A wall neighbour gives its boundary condition: f =
  f_wall, n.grad f = g, or n.f = n.f_wall for vectors (mlsvector.c). The fit is exact for
  polynomials of its degree.

  A row of an operator is a linear functional of the coefficients, sum_t b_t c_t. Its weights are
  w_k = W_k sum_t x_t phi_t with the solution x of M x = b, M = sum_k W_k phi_k phi_k^T. One fit
  solves for the rows of all operators together. Row functions copy the rows while the equations of
  the neighbours stay.

  Reference: G. R. Liu & Y. T. Gu, An Introduction to Meshfree Methods, Springer 2005, ch. 3;
  boundary conditions as equations of the fit: J. Kuhnert, PhD thesis, Kaiserslautern 1999 (finite
  pointsets).
*/
#include "mls.h"

/* Sets the right-hand side of lap f = 2/R^2 sum_a s_a^2 c_aa, c_aa the coefficient of (X_a/R)^2 and
   s_a the stretch of the axis. */
static ISPH_INLINE void LaplacianColumn(const Stencil *st, PetscInt dim, PetscInt width,
                                        PetscReal b[])
{
  for (PetscInt a = 0; a < dim; a++)
    b[(dim + a * (a + 1) / 2 + a) * width] = 2.0 * PetscSqr(st->stretch[a]) / PetscSqr(st->radius);
}

/* Sets the right-hand side m = sum_k W_k phi_k of the filter, with neighbours k that give a value:
   only values determine the constant of a fit. Returns W(0) + sum_k W_k. */
static ISPH_INLINE PetscReal FilterColumn(const Stencil *st, PetscInt terms, PetscInt width,
                                          PetscReal m[])
{
  const PetscInt stride = st->capacity, n = LanesPadded(st->n);
  PetscReal     *value = st->fit.value, sum = st->self[0];

  for (PetscInt k = 0; k < n; k++) value[k] = st->fit.W[k];
  for (PetscInt k = 0; st->n_wall && k < st->n; k++)
    if (st->equation[k] == EQUATION_NORMAL_DERIVATIVE) value[k] = 0.0;
  for (PetscInt k = 0; k < st->n; k++) sum += value[k];
  for (PetscInt t = 0; t < terms; t++) m[t * width] = LanesSum(n, value, st->fit.phi + t * stride);
  return sum;
}

/* Computes the row of the filter from the solution c of M c = m; sum: from FilterColumn(). */
static ISPH_INLINE void FilterWeights(const Stencil *st, PetscInt terms, PetscInt width,
                                      PetscReal sum, const PetscReal m[], const PetscReal c[],
                                      PetscReal w[])
{
  MlsWeights(st, terms, width, c, w);
  for (PetscInt t = 0; t < terms; t++) sum -= m[t] * c[t * width];
  for (PetscInt k = 0; k < st->n; k++) {
    const PetscReal value = st->equation[k] == EQUATION_VALUE ? st->W[k] : 0.0;

    w[k] = (w[k] - value) / sum;
  }
}

/* Sets the row of a Laplacian that needs no more than a neighbour, 2 d sum_k W_k (f_k - f_i) over
   sum_k W_k r_k^2; exact for |X|^2. */
static ISPH_INLINE void LaplacianOfDistances(Stencil *st)
{
  PetscReal sum = 0.0;

  for (PetscInt k = 0; k < st->n; k++) {
    st->fit.laplacian[k] = st->equation[k] == EQUATION_VALUE ? 2.0 * st->dim * st->W[k] : 0.0;
    sum += st->fit.laplacian[k] * PetscSqr(st->r[k]);
  }
  for (PetscInt k = 0; k < st->n && sum > 0.0; k++) st->fit.laplacian[k] *= 2.0 * st->dim / sum;
}

/* Computes all rows of the fit of a degree for the present equations of the neighbours. Returns:
   PETSC_FALSE if the neighbours do not determine a fit of a degree above the least one,
   st->least_degree. A fit of the least degree is regularised then, see MlsSolve(), and
   st->regularised counts it. */
static ISPH_INLINE PetscBool Fit(Stencil *st, PetscInt dim, PetscInt degree)
{
  const PetscInt terms = MlsTerms(dim, degree), width = MlsWidth(terms + dim + 2), filter = terms,
                 laplacian = terms + 1, gradient = terms + 2;
  PetscReal system[MLS_MAX_TERMS * MLS_MAX_WIDTH], spare[MLS_MAX_TERMS * MLS_MAX_WIDTH];
  PetscReal m[MLS_MAX_TERMS], *solved = degree == st->least_degree ? spare : system, sum;

  for (PetscInt e = 0; e < terms * width; e++) system[e] = 0.0;
  MlsBasis(st, dim, degree);
  MlsMoments(st, terms, st->fit.W, width, system);
  sum = FilterColumn(st, terms, width, system + filter);
  for (PetscInt t = 0; t < terms; t++) m[t] = system[t * width + filter];
  if (degree > 1) LaplacianColumn(st, dim, width, system + laplacian);
  for (PetscInt a = 0; a < dim; a++) system[a * width + gradient + a] = st->stretch[a] / st->radius;
  if (degree > st->least_degree && !MlsEliminate(terms, width, st->weak, system))
    return PETSC_FALSE;
  if (degree == st->least_degree && !MlsSolve(terms, width, system, solved)) st->regularised++;
  FilterWeights(st, terms, width, sum, m, solved + filter, st->fit.filter);
  if (degree > 1) MlsWeights(st, terms, width, solved + laplacian, st->fit.laplacian);
  else LaplacianOfDistances(st);
  for (PetscInt a = 0; a < dim; a++)
    MlsWeights(st, terms, width, solved + gradient + a, st->fit.gradient[a]);
  return PETSC_TRUE;
}

/* Fits of a degree. All but the usual one share a copy of the code: each takes seconds to
   compile. */
static ISPH_WIDE PetscBool FitOfDegree(Stencil *st, PetscInt degree)
{
  if (degree != 2) return st->dim == 2 ? Fit(st, 2, degree) : Fit(st, 3, degree);
  return st->dim == 2 ? Fit(st, 2, 2) : Fit(st, 3, 2);
}

/* Computes the rows of a fit, unless they are valid. If the neighbours do not determine a degree,
   takes the next lower one; st->regularised counts such fits. */
static void MlsFitRows(Stencil *st, PetscInt degree)
{
  if (st->fit.wanted == degree && !st->fit.fitted) return;
  st->fit.fitted = PETSC_FALSE;
  st->fit.wanted = st->fit.degree = degree;
  while (!FitOfDegree(st, st->fit.degree)) st->fit.degree--;
  if (st->fit.degree < degree) st->regularised++;
}

/*
  LaplacianRow_Mls - Computes the Laplacian of the fit of degree st->degree

    lap f = 2/R^2 sum_a c_aa,   c_aa the coefficient of (X_a/R)^2

  Properties: exact for polynomials of the degree on any arrangement of particles; not symmetric;
  uses the wall neighbours' equations.
*/
PetscErrorCode LaplacianRow_Mls(Stencil *st, PetscReal w[])
{
  PetscFunctionBegin;
  if (st->fit.wanted != st->degree) MlsFitRows(st, st->degree); /* coefficients are enough */
  PetscCall(PetscArraycpy(w, st->fit.laplacian, st->n));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* GradientRow_Mls - Computes the gradient of the fit of degree st->degree, df/dx_a = c_a/R with the
   coefficient c_a of X_a/R; exact for polynomials of the degree */
PetscErrorCode GradientRow_Mls(Stencil *st, PetscReal *g[])
{
  PetscFunctionBegin;
  MlsFitRows(st, st->degree);
  for (PetscInt a = 0; a < st->dim; a++) PetscCall(PetscArraycpy(g[a], st->fit.gradient[a], st->n));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* GradientRow_MlsDegree - Computes the gradient of the fit of a degree, or of a lower one if the
   points do not determine it; determined: they do */
PetscErrorCode GradientRow_MlsDegree(Stencil *st, PetscInt degree, PetscReal *g[],
                                     PetscBool *determined)
{
  PetscFunctionBegin;
  MlsFitRows(st, degree);
  *determined = st->fit.degree == degree;
  for (PetscInt a = 0; a < st->dim; a++) PetscCall(PetscArraycpy(g[a], st->fit.gradient[a], st->n));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  FilterRow_Mls - Computes the residual of a fit with a free constant, theory.md, (rows:residual);
  its degree is the largest even one up to st->degree

    f_i - c_0 = -sum_k w_k (f_k - f_i),   w_k = W_k (1 - m.c_k)/(W(0) + sum_k W_k - m.M^-1 m),
    c_k = M^-1 phi_k,   m = sum_k W_k phi_k,   M = sum_k W_k phi_k phi_k^T

  phi_k and M are the basis at neighbour k and the moment matrix of the fit that interpolates f_i
  (top of this file). The constant c_0 is eliminated by hand. For a neighbour that gives n.grad f,
  w_k lacks the term 1, and m lacks the term of this neighbour. Properties: vanishes for polynomials
  of the degree on any arrangement of particles. With quadratic fits it is of order dx^4 for smooth
  fields inside a lattice, and of order dx^3 on disordered particles and beside a boundary; with
  wendland_c2 and h/dx = 1.3 in 2D it is 0.81 f_i for a checkerboard and 0.26 f_i for stripes. Not
  symmetric. Reference: after C. R. Dohrmann, P. B. Bochev, Int. J. Numer. Meth. Fluids 46 (2004)
  183-201
*/
PetscErrorCode FilterRow_Mls(Stencil *st, PetscReal w[])
{
  PetscFunctionBegin;
  MlsFitRows(st, st->degree - st->degree % 2);
  PetscCall(PetscArraycpy(w, st->fit.filter, st->n));
  PetscFunctionReturn(PETSC_SUCCESS);
}
