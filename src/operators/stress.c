/*
  The divergence of the viscous stress as a sum of forces between pairs of particles, along the line
  that joins them. Least squares give the strengths of the forces. A rigid motion has no force (to
  rounding) for any viscosities, so truncation errors do not accelerate a very viscous drop that
  rotates in a fluid of low viscosity. See docs/theory.md, (67) to (71).
*/
#include "mls.h"

#define STRESS_TERMS 25 /* monomials of degree 3 and 4 in three dimensions */
#define STRESS_WIDTH 28 /* MlsWidth() of the terms and a right-hand side */

/* Computes the basis at neighbour k with s = X/R: s_a s_b s_c/s^2, then s_a s_b s_c s_e/s^2; 9
   terms in 2D, 25 in 3D. */
static void StressBasis(const Stencil *st, PetscInt k, PetscReal phi[])
{
  const PetscInt  d    = st->dim;
  const PetscReal over = PetscSqr(st->radius / st->r[k]);
  PetscReal       s[ISPH_MAX_DIM];
  PetscInt        t = 0;

  for (PetscInt a = 0; a < d; a++) s[a] = st->X[a][k] / st->radius;
  for (PetscInt a = 0; a < d; a++) {
    for (PetscInt b = 0; b <= a; b++) {
      for (PetscInt c = 0; c <= b; c++) phi[t++] = over * s[a] * s[b] * s[c];
    }
  }
  for (PetscInt a = 0; a < d; a++) {
    for (PetscInt b = 0; b <= a; b++) {
      for (PetscInt c = 0; c <= b; c++) {
        for (PetscInt e = 0; e <= c; e++) phi[t++] = over * s[a] * s[b] * s[c] * s[e];
      }
    }
  }
}

/* Computes the required sum_k c_k phi_k: 0 for terms of degree 3; for s_a s_b s_c s_e/s^2 twice
   `unit` for each way to divide a, b, c, e into two pairs of equal indices. */
static void StressTarget(PetscInt d, PetscReal unit, PetscReal target[])
{
  PetscInt t = 0;

  for (PetscInt n = 0; n < d * (d + 1) * (d + 2) / 6; n++) target[t++] = 0.0;
  for (PetscInt a = 0; a < d; a++) {
    for (PetscInt b = 0; b <= a; b++) {
      for (PetscInt c = 0; c <= b; c++) {
        for (PetscInt e = 0; e <= c; e++)
          target[t++] = 2.0 * unit * ((a == b && c == e) + (a == c && b == e) + (a == e && b == c));
      }
    }
  }
}

/*
  LaplacianRow_StressMls - Computes the divergence of a viscous stress by forces along pairs;
  couples velocity components

    sum_k c_k e (e.(u_k - u_i)) = lap u + 2 grad div u,   e = X/r

  The strengths c_k have the least sum_k c_k^2/W_k of all strengths that make the row exact for
  quadratic u. With Kronecker's delta d_ab these conditions are

    sum_k c_k e_a e_b X_c = 0,   sum_k c_k e_a e_b X_c X_d = 2 (d_ab d_cd + d_ac d_bd + d_ad d_bc).

  Weights multiplied by the mean viscosities nu_ik of pairs (viscous.c) give
  div(2 nu E) + grad(nu div u) with the strain rate tensor E, including the terms in grad nu. The
  second term is a bulk viscosity, which does not act on solenoidal flow.

  Properties: exact for quadratic fields on any arrangement of particles; no force on rigid motions
  for any nu; not symmetric. Needs particles behind walls: if a wall cuts the stencil in half, the
  strengths do not damp the velocity.

  Reference: forces along pairs after P. W. Cleary, J. J. Monaghan, J. Comput. Phys. 148 (1999),
  there with c_k = -2 (dim + 2) V_k W'/r. A stress from fitted second derivatives fails: on
  disordered particles its operator has an eigenvalue of the wrong sign, which accelerates a drop
  that is 1e3 times as viscous as the fluid around it.
*/
PetscErrorCode LaplacianRow_StressMls(Stencil *st, PetscReal w[])
{
  const PetscInt d = st->dim, n = d == 2 ? 9 : STRESS_TERMS;
  const PetscInt width                               = MlsWidth(n + 1);
  PetscReal      system[STRESS_TERMS * STRESS_WIDTH] = {0.0}, solved[STRESS_TERMS * STRESS_WIDTH];
  PetscReal      target[STRESS_TERMS], phi[STRESS_TERMS];

  PetscFunctionBegin;
  for (PetscInt k = 0; k < st->n; k++) {
    StressBasis(st, k, phi);
    for (PetscInt t = 0; t < n; t++) {
      const PetscReal weighted = st->W[k] * phi[t];

      for (PetscInt q = 0; q < n; q++) system[t * width + q] += weighted * phi[q];
    }
  }
  StressTarget(d, 1.0 / PetscSqr(st->radius), target);
  for (PetscInt t = 0; t < n; t++) system[t * width + n] = target[t];
  if (!MlsSolve(n, width, system, solved)) st->regularised++;
  for (PetscInt k = 0; k < st->n; k++) {
    PetscReal c = 0.0;

    StressBasis(st, k, phi);
    for (PetscInt t = 0; t < n; t++) c += st->W[k] * phi[t] * solved[t * width + n];
    for (PetscInt e = 0; e < d * d; e++)
      w[k * d * d + e] = c * st->X[e / d][k] * st->X[e % d][k] / PetscSqr(st->r[k]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
