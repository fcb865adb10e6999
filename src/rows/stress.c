/* The divergence of the viscous stress as a sum of forces between pairs of particles, along the
   line that joins them. The strengths of the forces are those of least squares (stress_mls) or of a
   kernel (pairwise_stress). A rigid motion has no force (to rounding) for any viscosities, so
   truncation errors do not accelerate a very viscous drop that rotates in a fluid of low viscosity.
   See theory.md, (viscosity:pairs) and those up to (viscosity:varying) and (viscosity:pairwise),
   (viscosity:factor) and (viscosity:dissipation). */
#include "fits/mls.h"
#include "rows.h"

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

/* Sets the weights of neighbour k to c e e^T, e = X/r. */
static void SetPairForce(const Stencil *st, PetscInt k, PetscReal c, PetscReal w[])
{
  const PetscInt d = st->dim;

  for (PetscInt e = 0; e < d * d; e++)
    w[k * d * d + e] = c * st->X[e / d][k] * st->X[e % d][k] / PetscSqr(st->r[k]);
}

/*
  LaplacianRow_StressMls - Computes the divergence of a viscous stress by forces along pairs;
  couples velocity components

    sum_k c_k e (e.(u_k - u_i)) = lap u + 2 grad div u,   e = X/r

  The strengths c_k have the least sum_k c_k^2/W_k of all strengths that make the row exact for
  quadratic u. With Kronecker's delta d_ab these conditions are

    sum_k c_k e_a e_b X_c = 0,   sum_k c_k e_a e_b X_c X_d = 2 (d_ab d_cd + d_ac d_bd + d_ad d_bc).

  Weights multiplied by the mean viscosities nu_ik of pairs (WeighByViscosity()) give div(2 nu E) +
  grad(nu div u) with the strain rate tensor E, including the terms in grad nu. The second term is a
  bulk viscosity, which does not act on solenoidal flow. Properties: exact for quadratic fields on
  any arrangement of particles; no force on rigid motions for any nu; not symmetric. Needs particles
  behind walls: if a wall cuts the stencil in half, the strengths do not damp the velocity.
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
    SetPairForce(st, k, c, w);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  LaplacianRow_Violeau - Computes the divergence of a viscous stress by the kernel gradient along
  pairs; couples velocity components

    2 (d+2) sum_k V_k (u_k - u_i).X/r^2 grad_i W ~ lap u + 2 grad div u

  The factor is exact in the continuum: theory.md, (viscosity:cleary). The published factor 8 is
  that of two dimensions. Properties: symmetric for equal volumes with forces along the pair, as
  pairwise_stress. A correction replaces grad_i W, whose direction then is not that of the pair. On
  lattices the viscosity depends on the direction of the strain: theory.md, the table below
  (viscosity:cleary). Reference: J. J. Monaghan, R. A. Gingold, J. Comput. Phys. 52 (1983) 374-389;
  D. Violeau, R. Issa, Int. J. Numer. Meth. Fluids 53 (2007) 277-304; M. Basa, N. Quinlan, M.
  Lastiwka, Int. J. Numer. Meth. Fluids 60 (2009), model C, Eq. (33), here without the term eta^2
  added to r^2
*/
PetscErrorCode LaplacianRow_Violeau(Stencil *st, PetscReal w[])
{
  const PetscInt d = st->dim;

  PetscFunctionBegin;
  StencilGradients(st, st->correction);
  for (PetscInt k = 0; k < st->n; k++) {
    const PetscReal scale = 2.0 * ((PetscReal)d + 2.0) / PetscSqr(st->r[k]);

    for (PetscInt e = 0; e < d * d; e++)
      w[k * d * d + e] = scale * st->slope[e / d][k] * st->X[e % d][k];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  LaplacianRow_Cleary - Computes the same sum for the factor xi = d + 2 of model D; -cleary_xi
  multiplies it by xi/(d+2)

    2 xi sum_k V_k (u_k - u_i).X/r^2 grad_i W

  Reference: P. W. Cleary, Appl. Math. Modelling 22 (1998) 981-993, with xi = 4.96333 from Couette
  flows; M. Basa, N. Quinlan, M. Lastiwka, Int. J. Numer. Meth. Fluids 60 (2009), model D, Eq. (34),
  with xi = 4.24 from Poiseuille flows
*/
PetscErrorCode LaplacianRow_Cleary(Stencil *st, PetscReal w[])
{
  PetscFunctionBegin;
  PetscCall(LaplacianRow_Violeau(st, w));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes V_k (W'' - W'/r) of neighbour k, which theory.md, (particles:convex), makes positive. */
static inline PetscReal PairStrength(const Stencil *st, PetscInt k)
{
  return st->V[k] * (st->ddW[k] - st->dW[k] / st->r[k]);
}

/* Factor_PairwiseStress - Returns the factor B_i of particle i: 1 inside a uniform fluid, 2 on its
   plane free surface */
PetscReal Factor_PairwiseStress(const Stencil *st)
{
  const PetscReal d   = st->dim;
  PetscReal       sum = 0.0;

  for (PetscInt k = 0; k < st->n; k++) sum += PairStrength(st, k) * PetscSqr(st->r[k]);
  return sum > 0.0 ? d * (d + 2.0) / sum : 1.0;
}

/* Keeps of the pair forces of sides along which the fluid slides the normal force by the normal
   velocity, and none of those of an outflow. */
static void DropFriction(const Stencil *st, PetscReal w[])
{
  const PetscInt d = st->dim;

  for (PetscInt k = 0; st->slips && k < st->n; k++) {
    if (!st->wall[k] || BoundaryIs(st->scene, st->side[k], BOUNDARY_NO_SLIP)) continue;
    for (PetscInt e = 0; e < d * d; e++)
      w[k * d * d + e] *= BoundaryIs(st->scene, st->side[k], BOUNDARY_OUTFLOW)
                              ? 0.0
                              : PetscAbsReal(st->normal[e / d][k] * st->normal[e % d][k]);
  }
}

/*
  LaplacianRow_PairwiseStress - Computes the divergence of a viscous stress by symmetric forces
  along pairs; couples velocity components

    sum_k c_k e (e.(u_k - u_i)) ~ lap u + 2 grad div u,   e = X/r,
    c_k = 2 V_k (W'' - W'/r) (B_i + B_k)/2,               B_i = d (d+2)/sum_k V_k (W'' - W'/r) r^2

  B makes the dissipation of u = x exact in any cloud of equal volumes with or without a free
  surface, on which the traction is zero: theory.md, (viscosity:pairwise), (viscosity:factor) and
  (viscosity:dissipation). Properties: symmetric for equal volumes, so momentum and angular momentum
  are constant; all strengths are positive; no force on rigid motions for any viscosities. On
  lattices the viscosity depends on the direction of the strain, by 5 % for h/dx = 1.3; on
  disordered particles the error is O(1/dx). Needs particles behind walls; a wall particle has the
  factor of the row. Reference: M. Weiler, D. Koschier, M. Brand, J. Bender, Comput. Graph. Forum
  37(2) (2018), there with -(d+2) W'/r in place of W'' - W'/r, after P. W. Cleary, J. J. Monaghan,
  J. Comput. Phys. 148 (1999), and with B = 1
*/
PetscErrorCode LaplacianRow_PairwiseStress(Stencil *st, PetscReal w[])
{
  PetscFunctionBegin;
  for (PetscInt k = 0; k < st->n; k++)
    SetPairForce(st, k, 2.0 * PairStrength(st, k) * st->factor[k], w);
  DropFriction(st, w);
  PetscFunctionReturn(PETSC_SUCCESS);
}
