/*
  The viscous operator next to a free surface, where the fluid has no tangential stress:

    t.(grad u + grad u^T) n = 0    for all tangents t of the surface with normal n.

  This condition couples the velocity components. The fit of the velocity is therefore a fit of a
  vector. Each neighbour gives the values of all components, and each surface particle s within the
  support, which may be the particle itself, gives the condition at its position:

    sum_k W_k |u_k - u_i - fit(X_k)|^2 + sum_s W_s sum_t (R t.(grad fit + grad fit^T)(X_s) n_s)^2
      -> min

  with the radius R of the support. The condition on the normal stress belongs to the pressure: p =
  2 mu n.E n. A fit that had it too would impose it twice. Walls give each component its own
  equation: its value, or n.grad u_t = 0 on planes of symmetry.
*/
#include "fits/mls.h"
#include "rows.h"

#define FIT_TERMS     MLS_QUADRATIC_TERMS /* of 3D, as many as those of cubic fits in 2D */
#define SURFACE_TERMS (ISPH_MAX_DIM * FIT_TERMS)
#define SURFACE_WIDTH 32   /* MlsWidth() of the terms and dim + 1 right-hand sides */
#define OUTERMOST     4.5  /* least share of the particle in its 2 n.E n [1/R] */
#define STEEP         36.0 /* largest sum of absolute weights of 2 n.E n [1/R] */

/* Computes the derivatives of the basis along all axes at s = X/R, times R: those of a monomial s_a
   times a lower one follow from the lower one. */
static ISPH_INLINE void BasisGradient(PetscInt dim, PetscInt degree, const PetscReal s[],
                                      PetscReal slope[][ISPH_MAX_DIM])
{
  PetscReal value[FIT_TERMS];
  PetscInt  lower = 0, t = dim;

  for (PetscInt a = 0; a < dim; a++) {
    value[a] = s[a];
    for (PetscInt b = 0; b < dim; b++) slope[a][b] = a == b ? 1.0 : 0.0;
  }
  for (PetscInt d = 2; d <= degree; d++) {
    for (PetscInt a = 0; a < dim; a++) {
      for (PetscInt q = lower; q < lower + MlsMonomials(a, d - 1); q++, t++) {
        value[t] = s[a] * value[q];
        for (PetscInt c = 0; c < dim; c++) slope[t][c] = (c == a) * value[q] + s[a] * slope[q][c];
      }
    }
    lower += MlsMonomials(dim - 1, d - 1);
  }
}

/* Adds the conditions of a surface particle at s = X/R with normal n to the normal equations. */
static ISPH_INLINE void AddCondition(PetscInt dim, PetscInt degree, PetscInt width,
                                     PetscReal weight, const PetscReal s[], const PetscReal n[],
                                     PetscReal system[])
{
  PetscReal      slope[FIT_TERMS][ISPH_MAX_DIM], tangent[2][ISPH_MAX_DIM];
  const PetscInt terms = MlsTerms(dim, degree), tangents = SurfaceTangents(dim, n, tangent);

  BasisGradient(dim, degree, s, slope);
  for (PetscInt m = 0; m < tangents; m++) {
    PetscReal row[SURFACE_WIDTH] = {0.0};

    for (PetscInt t = 0; t < terms; t++) {
      PetscReal along = 0.0, across = 0.0;

      for (PetscInt b = 0; b < dim; b++) {
        along += n[b] * slope[t][b];
        across += tangent[m][b] * slope[t][b];
      }
      for (PetscInt a = 0; a < dim; a++) row[a * terms + t] = tangent[m][a] * along + n[a] * across;
    }
    for (PetscInt p = 0; p < dim * terms; p++) {
      for (PetscInt q = p / 4 * 4; q < dim * terms; q += 4)
        for (PetscInt l = q; l < q + 4; l++) system[p * width + l] += weight * row[p] * row[l];
    }
  }
}

/* Sets the right-hand sides: for each component a that of lap u_a + bulk d(div u)/dx_a, then that
   of 2 n.E n at the particle, with its own normal. */
static ISPH_INLINE void SetColumns(const Stencil *st, PetscInt dim, PetscInt terms, PetscInt width,
                                   PetscReal bulk, PetscReal system[])
{
  const PetscReal over = 1.0 / PetscSqr(st->radius);
  const PetscInt  n    = dim * terms;
  PetscInt        t    = dim;

  for (PetscInt p = 0; p < dim; p++) {
    for (PetscInt q = 0; q <= p; q++, t++) { /* the term s_p s_q of component c */
      for (PetscInt c = 0; c < dim; c++) {
        PetscReal *column = system + (c * terms + t) * width + n;

        if (p == q) column[c] += 2.0 * over;                         /* lap u_c */
        if (c == p) column[q] += bulk * over * (p == q ? 2.0 : 1.0); /* d(du_c/dx_c)/dx_q */
        else if (c == q) column[p] += bulk * over;
      }
    }
  }
  for (PetscInt c = 0; st->kind == SURFACE_SMOOTH && c < dim; c++) {
    for (PetscInt b = 0; b < dim; b++)
      system[(c * terms + b) * width + n + dim] =
          2.0 * st->own_normal[c] * st->own_normal[b] / st->radius;
  }
}

/* Sets the weights of wall neighbours with equations of derivatives to zero: a side along which the
   fluid slides has n.grad u_t = 0. */
static ISPH_INLINE void DropDerivatives(const Stencil *st, PetscReal w[])
{
  for (PetscInt k = 0; st->slips && k < st->n; k++)
    if (st->wall[k] && st->equation[k] == EQUATION_NORMAL_DERIVATIVE) w[k] = 0.0;
}

/* Computes the rows of a fit with the conditions of the surface; returns PETSC_FALSE if the points
   do not determine it. */
static ISPH_INLINE PetscBool SurfaceFit(Stencil *st, PetscInt dim, PetscInt degree, PetscReal bulk,
                                        PetscReal w[])
{
  const PetscInt terms = MlsTerms(dim, degree), n = dim * terms, width = MlsWidth(n + dim + 1);
  PetscReal      moments[FIT_TERMS * FIT_TERMS], s[ISPH_MAX_DIM] = {0.0};
  PetscReal      system[SURFACE_TERMS * SURFACE_WIDTH];

  for (PetscInt e = 0; e < n * width; e++) system[e] = 0.0;
  for (PetscInt c = 0; c < dim; c++) {
    if (c == 0 || st->slips) {
      if (st->slips) StencilSetVelocity(st->scene, c, st);
      MlsBasis(st, dim, degree);
      MlsMoments(st, terms, st->fit.W, terms, moments);
    }
    for (PetscInt e = 0; e < terms * terms; e++)
      system[(c * terms + e / terms) * width + c * terms + e % terms] = moments[e];
  }
  if (st->kind == SURFACE_SMOOTH)
    AddCondition(dim, degree, width, st->self[0], s, st->own_normal, system);
  for (PetscInt k = 0; k < st->n; k++) {
    PetscReal normal[ISPH_MAX_DIM];

    if (!st->surface[k]) continue;
    for (PetscInt a = 0; a < dim; a++) {
      s[a]      = st->X[a][k] / st->radius;
      normal[a] = st->normal[a][k];
    }
    AddCondition(dim, degree, width, st->W[k], s, normal, system);
  }
  SetColumns(st, dim, terms, width, bulk, system);
  if (!MlsEliminate(n, width, st->weak, system)) return PETSC_FALSE;
  for (PetscInt c = 0; c < dim; c++) {
    if (st->slips) {
      StencilSetVelocity(st->scene, c, st);
      MlsBasis(st, dim, degree);
    }
    for (PetscInt a = 0; a < dim; a++) {
      MlsWeights(st, terms, width, system + c * terms * width + n + a, st->fit.value);
      DropDerivatives(st, st->fit.value);
      for (PetscInt k = 0; k < st->n; k++) w[(k * dim + a) * dim + c] = st->fit.value[k];
    }
    if (st->kind != SURFACE_SMOOTH) continue;
    MlsWeights(st, terms, width, system + c * terms * width + n + dim, st->normal_strain[c]);
    DropDerivatives(st, st->normal_strain[c]);
  }
  return PETSC_TRUE;
}

/* Returns true if the pressure p = 2 mu n.E n holds the surface particle. Its own motion along n
   has a share of 2 n.E n near that of a difference to the fluid beneath: 5/R to 9/R on even and
   disordered surfaces, with sums of absolute weights of 15/R to 35/R. If particles crowd on the
   surface, one may lie below the others. Its share is small or negative then, and its pressure
   drives it further in the direction in which it moves. */
static PetscBool HoldsSurface(const Stencil *st)
{
  PetscReal share = 0.0, sum = 0.0;

  if (st->kind != SURFACE_SMOOTH) return PETSC_TRUE;
  for (PetscInt c = 0; c < st->dim; c++) {
    for (PetscInt k = 0; k < st->n; k++) {
      share -= st->own_normal[c] * st->normal_strain[c][k];
      sum += PetscAbsReal(st->normal_strain[c][k]);
    }
  }
  return share * st->radius >= OUTERMOST && sum * st->radius <= STEEP;
}

/* Computes the row of a fit; returns PETSC_FALSE if the points do not determine it, or if the
   particle is not held by its surface. The fit of a particle on the surface is quadratic: along the
   normal there are three layers of particles within the support. */
static ISPH_WIDE PetscBool FittedRow(Stencil *st, PetscReal bulk, PetscReal w[])
{
  const PetscBool cubic = st->surface_degree == 3 && st->kind == SURFACE_INSIDE;

  st->fit.wanted = 0; /* overwrites the basis of the fit */
  if (cubic && SurfaceFit(st, 2, 3, bulk, w)) return PETSC_TRUE;
  return (st->dim == 2 ? SurfaceFit(st, 2, 2, bulk, w) : SurfaceFit(st, 3, 2, bulk, w)) &&
         HoldsSurface(st);
}

/* Computes the row by pair forces with the factor of the particle alone, and without pressure on
   the surface. */
static PetscErrorCode PairRow(Stencil *st, PetscReal w[])
{
  const PetscReal own = Factor_PairwiseStress(st);

  PetscFunctionBegin;
  for (PetscInt k = 0; k < st->n; k++) st->factor[k] = own;
  for (PetscInt c = 0; c < st->dim; c++) PetscCall(PetscArrayzero(st->normal_strain[c], st->n));
  PetscCall(LaplacianRow_PairwiseStress(st, w));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  LaplacianRow_SurfaceMls - Computes the divergence of the viscous stress by a fit of the velocity
  with zero tangential stress on free surfaces; couples velocity components

    (lap u + grad div u)_a = sum_k sum_c w_k,ac (u_k - u_i)_c

  The same fit gives 2 n.E n at a surface particle, st->normal_strain. Without a surface particle
  within the support this is the fit of mls.c for each component. Rough and isolated particles,
  those whose neighbours do not determine the fit, and those that HoldsSurface() excludes have no 2
  mu n.E n, and the pair forces of stress.c, which need no normal and whose traction on the surface
  is zero. Properties: exact for quadratic velocities that satisfy the condition at the surface
  particles; no force on rigid motions; not symmetric. Wall neighbours give the wall velocity.
  Reference: J. Kuhnert, PhD thesis, Kaiserslautern 1999 (boundary conditions as equations of fits)
*/
PetscErrorCode LaplacianRow_SurfaceMls(Stencil *st, PetscReal w[])
{
  const PetscInt d = st->dim;

  PetscFunctionBegin;
  if (st->kind == SURFACE_ROUGH || st->kind == SURFACE_ISOLATED) {
    PetscCall(LaplacianRow_PairwiseStress(st, w));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (st->has_pair_forces) {
    PetscCall(PairRow(st, w));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (st->beside_smooth_surface || st->slips) {
    if (FittedRow(st, 1.0, w)) PetscFunctionReturn(PETSC_SUCCESS);
  } else {
    PetscCall(LaplacianRow_Mls(st, st->fit.value));
    for (PetscInt e = 0; e < st->n * d * d; e++)
      w[e] = e % (d * d) % (d + 1) ? 0.0 : st->fit.value[e / (d * d)];
    if (st->fit.degree == st->degree) PetscFunctionReturn(PETSC_SUCCESS);
  }
  st->regularised++;
  PetscCall(PairRow(st, w));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* LaplacianRow_SurfaceStress - Computes lap u + 2 grad div u for a varying viscosity; couples
   velocity components. Weights multiplied by the mean viscosities of pairs give div(2 nu E) +
   grad(nu div u), as those of stress.c: theory.md, (viscosity:varying). Rows are those of a fit of
   each component. If the particle or a neighbour is on a free surface, the row has pair forces with
   the factor of the particle, whose traction on the surface is zero, and the surface has no
   pressure: theory.md, (surface:pairs). A condition in the fit would be that of the weighted
   differences nu_ik (u_k - u_i), whose gradient is not the stress. */
PetscErrorCode LaplacianRow_SurfaceStress(Stencil *st, PetscReal w[])
{
  PetscFunctionBegin;
  if (!st->beside_surface) {
    if (FittedRow(st, 2.0, w)) PetscFunctionReturn(PETSC_SUCCESS);
    st->regularised++;
  }
  PetscCall(PairRow(st, w));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The form mls of fluids with a free surface. */
const LaplacianRow LaplacianSurface = {
    .name       = "mls",
    .brief      = "quadratic moving least squares; no tangential stress on the free surface",
    .citation   = "Liu & Gu, Meshfree Methods (2005); Kuhnert (1999)",
    .properties = FORM_NULL_CONSTANTS | FORM_EXACT_LINEAR | FORM_SAFE_IMPLICIT | FORM_COUPLES,
    .Row        = LaplacianRow_SurfaceMls,
    .Factor     = Factor_PairwiseStress,
    .grad_div   = 2.0,
};

/* The same for a varying viscosity. */
const LaplacianRow LaplacianSurfaceStress = {
    .name     = "mls",
    .brief    = "the stress by quadratic moving least squares; no tangential stress on the free "
                "surface",
    .citation = "Liu & Gu, Meshfree Methods (2005); Kuhnert (1999)",
    .properties =
        FORM_NULL_CONSTANTS | FORM_EXACT_LINEAR | FORM_SAFE_IMPLICIT | FORM_VARYING | FORM_COUPLES,
    .Row    = LaplacianRow_SurfaceStress,
    .Factor = Factor_PairwiseStress,
};

/* LaplacianFitsSurface - Returns true if the form has the conditions of a free surface in its
   fits */
PetscBool LaplacianFitsSurface(const LaplacianForm *form)
{
  return form->row == &LaplacianSurface || form->row == &LaplacianSurfaceStress;
}

/* OperatorsStressSurface - Returns true if the rows of div on free surfaces give the pressure 2 mu
   n.E n of the velocity */
PetscBool OperatorsStressSurface(const Operators *ops)
{
  return ops->free && ops->forms.visc.row == &LaplacianSurface;
}
