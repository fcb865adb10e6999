/*
  The quadratic least-squares fit of a vector. A wall gives only the normal component of the vector,
  and this equation couples the components. For the fit of a scalar see mls.c.
*/
#include "mls.h"

/* Computes the moment matrix of the vector fit; wall neighbours give equations for n.f. */
static void MlsVectorMoments(const Stencil *st, PetscReal moments[])
{
  const PetscInt d = st->dim, terms = MlsTerms(d, 2), n = d * terms;

  for (PetscInt k = 0; k < st->n; k++) {
    PetscReal phi[MLS_QUADRATIC_TERMS];

    (void)MlsEquation(st, d, 2, k, phi);
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
  DivergenceFit_Mls - Computes the divergence of a vector fit to velocities in the fluid and normal
  velocities of walls

    sum_k W_k |u_k - u_i - fit(X_k)|^2 + sum_w W_w (n.(u_w - u_i - fit(X_w)))^2 -> min,
    div u = sum_a c_a/R,   c_a: coefficient of X_a/R in component a of the fit

  with fluid neighbours k and wall neighbours w. A boundary that gives n.grad (n.u) has this
  equation in place of the last. The tangential wall velocity, which jumps at the corner of a lid,
  does not enter. Because the fit couples the components, this holds for any orientation of the
  wall.

  Output Parameters:
+ d - d[c][k] multiplies (u_k - u_i)_c of fluid neighbour k, zero for walls [1/m]
- m - m[k] multiplies n.(u_k - u_i), or n.grad (n.u), of wall neighbour k, zero for fluid [1/m]
*/
PetscErrorCode DivergenceFit_Mls(Stencil *st, PetscReal *d[], PetscReal m[])
{
  const PetscInt dim = st->dim, terms = MlsTerms(dim, 2), n = dim * terms;
  PetscReal moments[ISPH_MAX_DIM * ISPH_MAX_DIM * MLS_QUADRATIC_TERMS * MLS_QUADRATIC_TERMS] = {
      0.0};
  PetscReal copy[ISPH_MAX_DIM * ISPH_MAX_DIM * MLS_QUADRATIC_TERMS * MLS_QUADRATIC_TERMS] = {0.0};
  PetscReal c[ISPH_MAX_DIM * MLS_QUADRATIC_TERMS]                                         = {0.0};

  PetscFunctionBegin;
  MlsVectorMoments(st, moments);
  PetscCall(PetscArraycpy(copy, moments, n * n));
  MlsFactorOrRidge(n, moments, copy, &st->regularised);
  for (PetscInt a = 0; a < dim; a++) c[a * terms + a] = 1.0 / st->radius;
  DenseCholeskySolve(n, moments, c);
  for (PetscInt k = 0; k < st->n; k++) {
    PetscReal       phi[MLS_QUADRATIC_TERMS];
    const PetscReal scale = MlsEquation(st, dim, 2, k, phi);

    m[k] = 0.0;
    for (PetscInt a = 0; a < dim; a++) {
      PetscReal sum = 0.0;

      for (PetscInt t = 0; t < terms; t++) sum += phi[t] * c[a * terms + t];
      if (st->wall[k]) m[k] += scale * st->W[k] * st->normal[a][k] * sum;
      d[a][k] = st->wall[k] ? 0.0 : st->W[k] * sum;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
