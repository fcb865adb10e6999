/* The pair-wise Laplacian of preconditioners: compact, and an M-matrix on any particles, which
   sweeps of AMG and its interpolation are made for. The operators of fits are neither. */
#include "isph/solvers.h"

#define PAIR_REACH   1.8 /* of pairs, in units of their spacing: 8 neighbours in 2D, 26 in 3D */
#define PAIR_NEAREST 0.3 /* pairs that are closer have the weight of this distance */

/* Returns the weight of a pair at a distance, in units of its spacing. */
static PetscReal PairWeight(PetscReal r)
{
  return r < PAIR_REACH ? PetscSqr(1.0 - r / PAIR_REACH) / PetscMax(r, PAIR_NEAREST) : 0.0;
}

/* Returns the factor that makes the sum of weights times r^2 on a lattice 2 dim, that of the
   Laplacian. */
static PetscReal PairStrength(PetscInt dim)
{
  PetscReal sum = 0.0;

  for (PetscInt i = -1; i <= 1; i++)
    for (PetscInt j = -1; j <= 1; j++)
      for (PetscInt k = dim == 3 ? -1 : 0; k <= (dim == 3 ? 1 : 0); k++) {
        const PetscInt rr = i * i + j * j + k * k;

        sum += rr ? rr * PairWeight(PetscSqrtReal((PetscReal)rr)) : 0.0;
      }
  return 2.0 * dim / sum;
}

/* Returns nu_ij of a pair: the harmonic mean of their viscosities, or 1. */
static PetscReal MeanOfPair(const PetscReal nu[], PetscInt i, PetscInt j)
{
  return nu ? 2.0 * nu[i] * nu[j] / (nu[i] + nu[j]) : 1.0;
}

/* Sorts the entries of a row by their columns, and adds those of equal columns, which periodic
   images of a particle have; returns their number. */
static PetscInt SortRow(PetscInt n, PetscInt col[], PetscScalar value[])
{
  PetscInt m = 0;

  for (PetscInt a = 1; a < n; a++) {
    const PetscInt    c = col[a];
    const PetscScalar v = value[a];
    PetscInt          b = a;

    for (; b > 0 && col[b - 1] > c; b--) {
      col[b]   = col[b - 1];
      value[b] = value[b - 1];
    }
    col[b]   = c;
    value[b] = v;
  }
  for (PetscInt a = 0; a < n; a++) {
    if (m && col[a] == col[m - 1]) {
      value[m - 1] += value[a];
    } else {
      col[m]     = col[a];
      value[m++] = value[a];
    }
  }
  return m;
}

/*
  PairLaplacian - Creates the pair-wise Laplacian of a preconditioner

    (A q)_i = row_i sum_j nu_ij (dx_i/dx_ij)^2 k(r_ij/dx_ij) (q_i - q_j) + diagonal_i q_i

  which approximates -row_i dx_i^2 div(nu grad q); k has pairs up to 1.8 times their mean spacing
  dx_ij, and nu_ij is the harmonic mean of nu. Walls have no pairs. Collective. Input: row - factor
  of each row; nu - viscosity of each particle, halo included; NULL: 1; diagonal - added to the
  diagonal; NULL: 0. Output: A - on own fluid particles. Reference: J. P. Morris, P. J. Fox,
  Y. Zhu, J. Comput. Phys. 136 (1997) 214-226, for the form
*/
PetscErrorCode PairLaplacian(const Flow *flow, Vec row, const PetscReal nu[], Vec diagonal, Mat *A)
{
  Particles         *p        = flow->particles;
  Neighbors         *nb       = flow->neighbors;
  const PetscBool    keeps    = SceneMoves(flow->scene);
  const PetscReal    strength = PairStrength(p->dim);
  const PetscScalar *factor, *extra = NULL;
  SparseRows         to;

  PetscFunctionBegin;
  if (!keeps) PetscCall(NeighborsUpdate(p, 0.0, nb)); /* fixed particles keep no rows of them */
  PetscCall(SparseRowsMalloc(p->n_fluid, p->n_fluid + nb->row[p->n_fluid], &to));
  PetscCall(VecGetArrayRead(row, &factor));
  if (diagonal) PetscCall(VecGetArrayRead(diagonal, &extra));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    const PetscInt first = to.row[i];
    PetscInt       q     = first + 1;
    PetscReal      sum   = 0.0;

    for (PetscInt k = nb->row[i]; k < nb->row[i + 1]; k++) {
      const PetscInt  j  = nb->col[k];
      const PetscReal dx = 0.5 * (p->dx[i] + p->dx[j]), rr = ParticlesSquareDistance(p, i, j);
      PetscReal       a;

      if (rr >= PetscSqr(PAIR_REACH * dx) || ParticlesIsWall(p, j)) continue;
      a = strength * factor[i] * MeanOfPair(nu, i, j) * PetscSqr(p->dx[i] / dx) *
          PairWeight(PetscSqrtReal(rr) / dx);
      sum += a;
      to.col[q]     = p->row[j];
      to.value[q++] = -a;
    }
    to.col[first]   = p->row[i];
    to.value[first] = sum + (extra ? extra[i] : 0.0);
    to.row[i + 1]   = first + SortRow(q - first, &to.col[first], &to.value[first]);
  }
  if (diagonal) PetscCall(VecRestoreArrayRead(diagonal, &extra));
  PetscCall(VecRestoreArrayRead(row, &factor));
  if (!keeps) PetscCall(NeighborsRelease(nb));
  PetscCall(SparseRowsMat(p->comm, &to, p->n_fluid, A));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* PairPoisson - Creates the pair-wise matrix of -dx_i^2 lap p for the pressure on particles.
   Collective. The diagonal has the sums of rows of the operator, which are not 0 where walls have a
   pressure. */
PetscErrorCode PairPoisson(const Flow *flow, Mat *A)
{
  Vec          one, sums;
  PetscScalar *sum;

  PetscFunctionBegin;
  PetscCall(FluidVec(flow->particles, NULL, &one));
  PetscCall(FluidVec(flow->particles, NULL, &sums));
  PetscCall(VecSet(one, 1.0));
  PetscCall(AffineApply(&flow->ops->ppe, one, NULL, sums));
  PetscCall(VecGetArray(sums, &sum));
  for (PetscInt i = 0; i < flow->particles->n_fluid; i++) sum[i] = PetscMax(sum[i], 0.0);
  PetscCall(VecRestoreArray(sums, &sum));
  PetscCall(PairLaplacian(flow, one, NULL, sums, A));
  PetscCall(VecDestroyAll(&sums, &one));
  PetscFunctionReturn(PETSC_SUCCESS);
}
