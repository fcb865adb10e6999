/* Wall points of dummies, and wall velocities at them. */
#ifndef ISPH_WALL_POINTS_H
#define ISPH_WALL_POINTS_H

#include "isph/walls.h"

/* Splits the offset X = x_k - x_i of wall neighbour k: returns the normal component X.n, and sets
   the tangential part X_t. */
static inline PetscReal SplitX(const Stencil *st, PetscInt k, PetscReal tangent[])
{
  PetscReal height = 0.0;

  for (PetscInt a = 0; a < st->dim; a++) height += st->X[a][k] * st->normal[a][k];
  for (PetscInt a = 0; a < st->dim; a++) tangent[a] = st->X[a][k] - height * st->normal[a][k];
  return height;
}

void             WallPointShares(const Operators *ops, Stencil *stencil);
const PetscReal *WallWeights(const Stencil *stencil, const Operators *ops, PetscInt width,
                             const PetscReal w[]);

#endif
