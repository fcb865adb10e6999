/* The least-squares fit of a vector. A wall gives only the normal component of the vector, and this
   equation couples the components. For the fit of a scalar see mls.c. */
#include "mls.h"

/* Computes the moments of the vector fit, blocks (c, e) of scalar moments with the weights W_k in
   the fluid if c = e, and W_k n_c n_e at walls. */
static ISPH_INLINE void VectorMoments(Stencil *st, PetscInt dim, PetscInt terms, PetscInt width,
                                      PetscReal M[])
{
  for (PetscInt c = 0; c < dim; c++) {
    for (PetscInt e = c; e < dim; e++) {
      PetscReal *W = st->fit.value, total = 0.0;

      for (PetscInt k = 0; k < LanesPadded(st->n); k++) W[k] = c == e ? st->fit.W[k] : 0.0;
      for (PetscInt k = 0; k < st->n; k++) {
        if (st->wall[k]) W[k] = st->fit.W[k] * st->normal[c][k] * st->normal[e][k];
        total += PetscAbsReal(W[k]);
      }
      if (total > 0.0) MlsMoments(st, terms, W, width, M + c * terms * width + e * terms);
    }
  }
}

/* Computes the divergence of the fit of a degree; returns PETSC_FALSE as Fit() in mls.c. */
static ISPH_INLINE PetscBool DivergenceFit(Stencil *st, PetscInt dim, PetscInt degree,
                                           PetscReal *d[], PetscReal m[])
{
  const PetscInt terms = MlsTerms(dim, degree), n = dim * terms, width = MlsWidth(n + 1);
  PetscReal      system[MLS_VECTOR_TERMS * MLS_VECTOR_WIDTH];
  PetscReal      spare[ISPH_MAX_DIM * MLS_QUADRATIC_TERMS * MLS_QUADRATIC_VECTOR_WIDTH];
  PetscReal     *solved = degree == st->least_degree ? spare : system;

  for (PetscInt e = 0; e < n * width; e++) system[e] = 0.0;
  MlsBasis(st, dim, degree);
  VectorMoments(st, dim, terms, width, system);
  for (PetscInt a = 0; a < dim; a++)
    system[(a * terms + a) * width + n] = st->stretch[a] / st->radius;
  if (degree > st->least_degree && !MlsEliminate(n, width, st->weak, system)) return PETSC_FALSE;
  if (degree == st->least_degree && !MlsSolve(n, width, system, solved)) st->regularised++;
  for (PetscInt k = 0; k < st->n; k++) m[k] = 0.0;
  for (PetscInt a = 0; a < dim; a++) {
    MlsWeights(st, terms, width, solved + a * terms * width + n, d[a]);
    for (PetscInt k = 0; k < st->n; k++) {
      if (!st->wall[k]) continue;
      m[k] += st->normal[a][k] * d[a][k];
      d[a][k] = 0.0;
    }
  }
  return PETSC_TRUE;
}

static ISPH_WIDE PetscBool DivergenceFitOfDegree(Stencil *st, PetscInt degree, PetscReal *d[],
                                                 PetscReal m[])
{
  if (st->dim == 2 && degree == 2) return DivergenceFit(st, 2, 2, d, m);
  if (st->dim == 2) return DivergenceFit(st, 2, degree, d, m);
  return degree == 2 ? DivergenceFit(st, 3, 2, d, m) : DivergenceFit(st, 3, degree, d, m);
}

/*
  DivergenceFit_Mls - Computes the divergence of a vector fit to velocities in the fluid and normal
  velocities of walls

    sum_k W_k |u_k - u_i - fit(X_k)|^2 + sum_w W_w (n.(u_w - u_i - fit(X_w)))^2 -> min,
    div u = sum_a c_a/R,   c_a: coefficient of X_a/R in component a of the fit

  with fluid neighbours k and wall neighbours w. A boundary that gives n.grad (n.u) has this
  equation in place of the last. The tangential wall velocity, which jumps at the corner of a lid,
  does not enter. Because the fit couples the components, this holds for any orientation of the
  wall. Output: d - d[c][k] multiplies (u_k - u_i)_c of fluid neighbour k, zero for walls [1/m]; m -
  m[k] multiplies n.(u_k - u_i), or n.grad (n.u), of wall neighbour k, zero for fluid [1/m].
*/
PetscErrorCode DivergenceFit_Mls(Stencil *st, PetscReal *d[], PetscReal m[])
{
  PetscInt degree = st->degree;

  PetscFunctionBegin;
  while (!DivergenceFitOfDegree(st, degree, d, m)) degree--;
  if (degree < st->degree) st->regularised++;
  PetscFunctionReturn(PETSC_SUCCESS);
}
