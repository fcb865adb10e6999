/* Workspace of assembly: the stencil of a particle and its weights, reused row by row. */
#ifndef ISPH_ASSEMBLY_H
#define ISPH_ASSEMBLY_H

#include "isph/rows.h"
#include "fits/mlsbatch.h"

struct Assembly {
  Stencil   *stencil;          /* the first of the batch */
  Stencil   *batch[MLS_BATCH]; /* of particles whose rows are assembled together */
  MlsBatch  *fits;             /* of several particles at once */
  PetscBool  has_fits;         /* an operator has the rows of fits of the chosen degree */
  PetscBool  fits_walls;       /* rows beside walls are made from fits too */
  PetscBool  single;           /* each column is that of a single neighbour */
  PetscBool  simple;           /* no wall neighbours; slots in the order of neighbours */
  PetscBool  shared;           /* operators that share rows do not store the present one */
  PetscInt  *like;             /* of each row: an equal earlier one, or itself; NULL: not sought */
  PetscInt  *slot;             /* slot of each neighbour, from the first of the row */
  PetscReal *w;                /* weights of a Laplacian or a filter */
  PetscReal *g[ISPH_MAX_DIM];  /* weights of a gradient */
  PetscReal *m;                /* weights of normal components in a divergence */
  PetscReal *wall_w;           /* weights of wall data, see wall_points.c */
  PetscReal *excess;           /* sum of them on each boundary */
  PetscInt   slot_capacity;    /* number of neighbours that the arrays can hold */
};

/* Returns true if an operator stores only rows apart. */
static inline PetscBool AffineShares(const AffineOperator *op)
{
  return op->twin || op->fitted;
}

/* Returns true if an operator stores the present row itself. */
static inline PetscBool StoresRow(const Operators *ops, const AffineOperator *op)
{
  return !(AffineShares(op) && ops->work->shared);
}

PetscErrorCode FindRepeats(const Scene *scene, const Particles *particles, const OperatorRows *rows,
                           PetscInt like[]);
PetscErrorCode FindRuns(const PetscInt like[], OperatorRows *rows);
PetscErrorCode GatherStencil(const Scene *scene, const Particles *particles,
                             const Neighbors *neighbors, const Operators *ops, PetscInt i,
                             Stencil *stencil);
PetscErrorCode LaplacianFactors(const Scene *scene, const Particles *particles,
                                const Neighbors *neighbors, const Operators *ops,
                                LaplacianForm *form);

#endif
