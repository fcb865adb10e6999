/*
  Wall velocities in the row of particle i, if the velocity of a dummy w is extrapolated with the
  factor beta along the straight line from particle i through the wall. The wall velocity may vary
  along the wall:

    u_w - u_i = (u_wall,w - u_wall,i) + beta (u_wall,i - u_i).

  u_wall,w is the wall velocity at the wall point of the dummy, u_wall,i at the wall point of i. A
  linear fit along the wall to the wall neighbours of the same side gives u_wall,i. Without the
  first bracket the variation along the wall would enter the row beta times too large:
  theory.md, (walls:dummy) and (walls:datum).
*/
#include "rows/assembly.h"
#include "wall_points.h"

/* Returns true if the stencil has dummies whose velocities a factor beta extrapolates. */
static PetscBool HasWallPoints(const Stencil *st, const Operators *ops)
{
  return st->n_wall && !ops->forms.wall->on_surface;
}

/* Computes the basis of the fit along the wall at neighbour k: 1, and the tangential part of its
   offset from particle i, divided by the radius of the support. */
static void AlongWall(const Stencil *st, PetscInt k, PetscReal phi[])
{
  phi[0] = 1.0;
  (void)SplitX(st, k, &phi[1]);
  for (PetscInt a = 0; a < st->dim; a++) phi[1 + a] /= st->radius;
}

/* Computes st->share for the wall neighbours of a side: their weights in u_wall,i, the wall
   velocity at the wall point of particle i. The sum of the weights is 1. */
static void SideShares(Stencil *st, PetscInt side)
{
  const PetscInt n                                               = st->dim + 1;
  PetscReal      moment[(ISPH_MAX_DIM + 1) * (ISPH_MAX_DIM + 1)] = {0.0}, sum = 0.0;
  PetscReal      factor[(ISPH_MAX_DIM + 1) * (ISPH_MAX_DIM + 1)];
  PetscReal      at_wall_point[ISPH_MAX_DIM + 1] = {1.0}, phi[ISPH_MAX_DIM + 1];

  for (PetscInt k = 0; k < st->n; k++) {
    if (!st->wall[k] || st->side[k] != side) continue;
    AlongWall(st, k, phi);
    for (PetscInt t = 0; t < n * n; t++) moment[t] += st->W[k] * phi[t / n] * phi[t % n];
  }
  DenseCholeskyRidge(n, moment, 1e-12, factor); /* singular without ridge: X_t.n = 0 */
  DenseCholeskySolve(n, factor, at_wall_point);
  for (PetscInt k = 0; k < st->n; k++) {
    if (!st->wall[k] || st->side[k] != side) continue;
    AlongWall(st, k, phi);
    st->share[k] = 0.0;
    for (PetscInt t = 0; t < n; t++) st->share[k] += st->W[k] * phi[t] * at_wall_point[t];
    sum += st->share[k];
  }
  for (PetscInt k = 0; k < st->n; k++) {
    if (st->wall[k] && st->side[k] == side) st->share[k] /= sum;
  }
}

/* WallPointShares - Computes st->share for all wall neighbours of particle i: their weights in the
   wall velocity at the wall point of i */
void WallPointShares(const Operators *ops, Stencil *st)
{
  if (!HasWallPoints(st, ops)) return;
  for (PetscInt k = 0; k < st->n; k++)
    if (st->wall[k]) st->share[k] = PETSC_INFINITY; /* not yet computed */
  for (PetscInt k = 0; k < st->n; k++)
    if (st->wall[k] && st->share[k] == PETSC_INFINITY) SideShares(st, st->side[k]);
}

/*
  WallWeights - Converts weights w of differences u_w - u_i to weights b of u_wall,w - u_i, with the
  extrapolation at the top of this file

    b_w = w_w + share_w sum_v w_v (beta_v - 1),   v: wall neighbours of the same side

  beta_v is the factor of the extrapolation, and share_w the weight of u_wall,w in the fit for
  u_wall,i. Then sum_w b_w = sum_w beta_w w_w. If the wall treatment puts particles on the surface,
  b = w. Input: width - number of weights of each neighbour; w - weights of u_k - u_i, neighbour by
  neighbour. Returns: b for wall neighbours (other entries are undefined), valid until the next call
*/
const PetscReal *WallWeights(const Stencil *st, const Operators *ops, PetscInt width,
                             const PetscReal w[])
{
  PetscReal *excess = ops->work->excess, *b = ops->work->wall_w;

  if (!HasWallPoints(st, ops)) return w;
  for (PetscInt e = 0; e < width; e++) {
    for (PetscInt k = 0; k < st->n; k++)
      if (st->wall[k]) excess[st->side[k]] = 0.0;
    for (PetscInt k = 0; k < st->n; k++)
      if (st->wall[k]) excess[st->side[k]] += w[k * width + e] * (st->beta[k] - 1.0);
    for (PetscInt k = 0; k < st->n; k++)
      if (st->wall[k]) b[k * width + e] = w[k * width + e] + st->share[k] * excess[st->side[k]];
  }
  return b;
}
