/* Rows of particles beside walls, and their entries in the operators. */
#ifndef ISPH_BOUNDARY_ROWS_H
#define ISPH_BOUNDARY_ROWS_H

#include "isph/walls.h"

#define OPERATORS_COUNT (2 + 4 * ISPH_MAX_DIM + ISPH_MAX_DIM * ISPH_MAX_DIM)
void OperatorsList(Operators *ops, AffineOperator *all[OPERATORS_COUNT]);

/* Returns the weights of row i over walls, NULL without walls. */
static inline PetscReal *RowOverWalls(const Operators *ops, const AffineOperator *op, PetscInt i)
{
  return ops->forms.wall ? op->b + op->width * ops->rows.walls.row[i] : NULL;
}

/* Sets a row of an operator to zero, and returns its weights over fluid and over walls. */
static inline void EmptyRow(const Operators *ops, PetscInt i, const AffineOperator *op,
                            PetscReal **a, PetscReal **b)
{
  const PetscInt *fluid = ops->rows.fluid.row, *walls = ops->rows.walls.row;

  *a = AffineRow(&ops->rows, op, i);
  *b = RowOverWalls(ops, op, i);
  for (PetscInt s = 0; s < (fluid[i + 1] - fluid[i]) * op->width; s++) (*a)[s] = 0.0;
  for (PetscInt s = 0; *b && s < (walls[i + 1] - walls[i]) * op->width; s++) (*b)[s] = 0.0;
}

void WeighByViscosity(const Scene *scene, const Particles *particles, const Stencil *stencil,
                      PetscReal w[]);
void AddRow_Velocity(const Stencil *stencil, const Operators *ops, PetscInt diagonal,
                     const PetscReal w[], AffineOperator *op);
void KeepBlockRow(const Stencil *stencil, PetscInt diagonal, const PetscReal w[], Operators *ops);
PetscErrorCode AssembleViscousBlock(const Scene *scene, const Particles *particles, Operators *ops);
PetscErrorCode AddRows_Pressure(const Scene *scene, Stencil *stencil, PetscInt diagonal,
                                Operators *ops);
PetscErrorCode AddRows_GradientWithoutWalls(const Scene *scene, Stencil *stencil, PetscInt diagonal,
                                            Operators *ops);
PetscErrorCode AddRow_PressureFilter(const Scene *scene, Stencil *stencil, PetscInt diagonal,
                                     Operators *ops);
PetscErrorCode AddRows_Divergence(const Scene *scene, Stencil *stencil, PetscInt diagonal,
                                  Operators *ops);

#endif
