/*
  What a dummy says of its wall in the row of particle i. Its velocity lies on the line through the
  fluid and the wall, whose velocity may vary along it:

    u_w - u_i = (u_wall,w - u_wall,i) + beta (u_wall,i - u_i),

  u_wall,w the wall's velocity at the foot of the dummy, u_wall,i that at the foot of i. The latter
  is a linear fit along the wall through the wall neighbours of its side; without it rows would see
  the variation along the wall beta-fold.
*/
#include "assembly.h"
#include "boundary_rows.h"

/* Whether walls speak through dummies whose values follow from their beta. */
static PetscBool HasWallPoints(const Stencil *st, const Operators *ops)
{
  return st->n_wall && !ops->forms.wall->on_surface && !ops->forms.wall->Extend ? PETSC_TRUE
                                                                                : PETSC_FALSE;
}

/* The terms of the fit at neighbour k: 1, and X_t over the support's radius. */
static void AlongWall(const Stencil *st, PetscInt k, PetscReal phi[])
{
  phi[0] = 1.0;
  (void)SplitX(st, k, &phi[1]);
  for (PetscInt a = 0; a < st->dim; a++) phi[1 + a] /= st->radius;
}

/* Shares of the wall neighbours of one side in the velocity at the foot; they sum up to 1. */
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
  DenseCholeskyRidge(n, moment, 1e-12, factor); /* nothing varies along the normal */
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

/* WallPointShares - Fills share of all wall neighbours that are dummies; not collective */
void WallPointShares(const Operators *ops, Stencil *st)
{
  PetscBool done[SCENE_MAX_BOUNDARIES] = {PETSC_FALSE};

  if (!HasWallPoints(st, ops)) return;
  for (PetscInt k = 0; k < st->n; k++) {
    if (!st->wall[k] || done[st->side[k]]) continue;
    SideShares(st, st->side[k]);
    done[st->side[k]] = PETSC_TRUE;
  }
}

/*
  WallWeights - Weights of wall data for those of u_w - u_i

    b_w = w_w + share_w sum_v w_v (beta_v - 1),   v over the wall neighbours of w's side

  of dummies, whose sum is that of beta w; other walls have their own value, or are given one
  afterwards: b = w.

  Not collective.

  Input Parameters:
+ width - entries of each neighbour's weight
- w     - of u_k - u_i, neighbour by neighbour

  Returns: b, to be read for wall neighbours only; good until the next call
*/
const PetscReal *WallWeights(const Stencil *st, const Operators *ops, PetscInt width,
                             const PetscReal w[])
{
  PetscReal excess[SCENE_MAX_BOUNDARIES] = {0.0}, *b = ops->work->wall_w;

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
