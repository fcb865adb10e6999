/* What wall neighbours mean in the rows of one particle, and the rows put in place. */
#ifndef ISPH_CLOSE_H
#define ISPH_CLOSE_H

#include "isph/operators.h"

void WeighByViscosity(const Scene *scene, const Particles *particles, const Stencil *stencil,
                      PetscReal w[]);
void CloseRow_Value(const Stencil *stencil, const Operators *ops, PetscInt diagonal,
                    const PetscReal w[], AffineOperator *op);
void KeepRow(const Stencil *stencil, PetscInt diagonal, const PetscReal w[], Operators *ops);
PetscErrorCode AssembleTogether(const Scene *scene, const Particles *particles, Operators *ops);
PetscErrorCode CloseRows_Pressure(const Scene *scene, Stencil *stencil, PetscInt diagonal,
                                  Operators *ops);
PetscErrorCode CloseRows_OneSided(const Scene *scene, Stencil *stencil, PetscInt diagonal,
                                  Operators *ops);
PetscErrorCode CloseRows_Divergence(Stencil *stencil, PetscInt diagonal, Operators *ops);

#endif
