/*
  Compact rows of the particles: a Laplacian and a gradient over the nearest neighbours, for the
  error that a defect makes. They serve all forms, schemes and wall treatments alike. The Laplacian
  is symmetric,

    V_i (lap f)_i = sum_j F_ij (f_j - f_i),   F_ij = c (V_i w(q_ij) + V_j w(q_ji))/r_ij^2,
    w(q) = (1 - (q/Q)^2)^2,

  with q_ij the distance in spacings of i, V the weight of a particle and c that of a lattice. The
  gradient is exact for linear fields.
*/
#include "defect.h"

#define REACH 1.8  /* Q: all neighbours around a particle of a lattice, diagonal ones too [dx] */
#define CLOSE 0.1  /* least distance of a boundary [dx] */
#define RIDGE 1e-3 /* for particles with neighbours on one line only [-] */

/* Returns w at a squared distance. */
static PetscReal PairWeight(PetscReal q2)
{
  return q2 < PetscSqr(REACH) ? PetscSqr(1.0 - q2 / PetscSqr(REACH)) : 0.0;
}

/* Returns c: sum_j F_ij X_a^2 = 1 on a lattice. */
static PetscReal LatticeFactor(PetscInt dim)
{
  const PetscInt n   = dim == 3 ? 27 : 9;
  PetscReal      sum = -PairWeight(0.0);

  for (PetscInt k = 0; k < n; k++) {
    const PetscInt a = k % 3 - 1, b = k / 3 % 3 - 1, c = dim == 3 ? k / 9 - 1 : 0;

    sum += PairWeight((PetscReal)(a * a + b * b + c * c));
  }
  return dim / sum;
}

static PetscErrorCode Reserve(PetscInt dim, PetscInt n, CompactRows *rows)
{
  PetscFunctionBegin;
  if (n <= rows->capacity) PetscFunctionReturn(PETSC_SUCCESS);
  rows->capacity = n + n / 4;
  PetscCall(PetscRealloc(sizeof(PetscInt) * (size_t)rows->capacity, &rows->col));
  PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)rows->capacity, &rows->conductance));
  for (PetscInt a = 0; a < dim; a++)
    PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)rows->capacity, &rows->slope[a]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns sum F/V_i of particle i to boundaries that give the velocity: 1/(2 d dx) at the distance
   d < dx, so that 2 F is that of a cell beside a wall at d = dx/2 */
static PetscReal WallConductance(const Flow *flow, PetscInt i)
{
  const Scene     *scene = flow->scene;
  const Particles *p     = flow->particles;
  WallPlane        planes[WALL_PLANES];
  PetscReal        x[ISPH_MAX_DIM] = {0.0}, sum = 0.0;
  PetscInt         n = 0;

  for (PetscInt a = 0; a < p->dim; a++) x[a] = p->x[a][i];
  if (SceneHas(scene, PHYSICS_WALLS)) SceneWallPlanes(scene, x, p->dx[i], planes, &n);
  for (PetscInt k = 0; k < n; k++) {
    if (!BoundaryIs(scene, planes[k].side, BOUNDARY_NO_SLIP) &&
        !BoundaryIs(scene, planes[k].side, BOUNDARY_INFLOW))
      continue;
    sum += 0.5 / (PetscMax(planes[k].distance, CLOSE * p->dx[i]) * p->dx[i]);
  }
  return sum;
}

/* Returns the square of the distance of particles i and j in spacings of i. */
static PetscReal Distance2(const Particles *p, PetscInt i, const PetscReal X[])
{
  PetscReal q2 = 0.0;

  for (PetscInt a = 0; a < p->dim; a++) q2 += PetscSqr(ParticlesStretch(p, a, i) * X[a] / p->dx[i]);
  return q2;
}

/* Adds fluid neighbour j to the row that ends at k, and its offset X, times w, to slope; adds w X X
   to M. Returns the new end. Both particles of a pair compute the same conductance. */
static PetscInt AddNeighbor(const Particles *p, PetscInt i, PetscInt j, PetscReal c, PetscInt k,
                            CompactRows *rows, PetscReal M[])
{
  PetscReal X[ISPH_MAX_DIM], r2 = 0.0, w, other, share;

  for (PetscInt a = 0; a < p->dim; a++) {
    X[a] = p->x[a][j] - p->x[a][i];
    r2 += PetscSqr(X[a]);
  }
  w     = PairWeight(Distance2(p, i, X));
  other = PairWeight(Distance2(p, j, X));
  share = ParticlesWeight(p, i) * w + ParticlesWeight(p, j) * other;
  if (!(share > 0.0) || !(r2 > 0.0)) return k;
  rows->col[k]         = j;
  rows->conductance[k] = c * share / r2;
  for (PetscInt a = 0; a < p->dim; a++) {
    rows->slope[a][k] = w * X[a];
    for (PetscInt b = 0; b < p->dim; b++) M[a * p->dim + b] += w * X[a] * X[b];
  }
  return k + 1;
}

/* CompactRowAdd - Sets the row of own particle i; those before it are set. Note: needs its row of
   neighbours. */
PetscErrorCode CompactRowAdd(const Flow *flow, PetscInt i, CompactRows *rows)
{
  const Particles *p                              = flow->particles;
  const Neighbors *nb                             = flow->neighbors;
  const PetscInt   dim                            = p->dim;
  const PetscReal  c                              = LatticeFactor(dim);
  PetscReal        M[ISPH_MAX_DIM * ISPH_MAX_DIM] = {0.0};
  PetscInt         k                              = rows->row[i];

  PetscFunctionBegin;
  PetscCall(Reserve(dim, k + nb->row[i + 1] - nb->row[i], rows));
  rows->wall[i] = WallConductance(flow, i);
  for (PetscInt q = nb->row[i]; q < nb->row[i + 1]; q++) {
    if (!ParticlesIsWall(p, nb->col[q])) k = AddNeighbor(p, i, nb->col[q], c, k, rows, M);
  }
  for (PetscInt a = 0; a < dim; a++) M[a * dim + a] += RIDGE * PetscSqr(p->dx[i]);
  rows->row[i + 1] = k;
  for (k = rows->row[i]; k < rows->row[i + 1]; k++) {
    PetscReal A[ISPH_MAX_DIM * ISPH_MAX_DIM], X[ISPH_MAX_DIM];

    PetscCall(PetscArraycpy(A, M, dim * dim));
    for (PetscInt a = 0; a < dim; a++) X[a] = rows->slope[a][k];
    DenseEliminate(dim, A, 1, X);
    for (PetscInt a = 0; a < dim; a++) rows->slope[a][k] = X[a] / A[a * dim + a];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
