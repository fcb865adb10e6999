/* Walls: treatments, rows of particles beside walls, and the values that boundaries give. */
#ifndef ISPH_WALLS_H
#define ISPH_WALLS_H

#include "isph/rows.h"

extern const Table   WallTable;
extern const WallRow WallGiven; /* treatment of patch tests, not in the table */

/* Values at boundaries: the wall data e of the operators, an entry for each own wall particle, as
   its boundary gives them (SceneWallVelocity(), SceneWallPressure()). They are valid for an
   epoch. */
typedef struct {
  PetscInt  epoch;           /* epoch of the vectors; 0: no vectors */
  Vec       u[ISPH_MAX_DIM]; /* velocity [m/s], or n.grad of a component [1/s] */
  Vec       p;               /* n.grad p [Pa/m] or p [Pa] of the present pressure, as the boundary's
                                equation is */
  Vec       p_step;          /* its gain in the present step */
  PetscReal speed_bound;     /* largest speed that walls can have driven so far [m/s] */
} WallValues;

PetscErrorCode WallValuesRenumber(const Scene *scene, const Particles *particles,
                                  WallValues *walls);
PetscErrorCode WallValuesSetVelocity(const Scene *scene, Particles *particles, PetscReal t,
                                     PetscReal projection_factor, WallValues *walls);
PetscErrorCode WallValuesSetPressure(const Scene *scene, const Particles *particles, PetscReal t,
                                     PetscReal share, WallValues *walls);
PetscErrorCode WallValuesStepPressure(const Scene *scene, const Particles *particles, PetscReal t,
                                      WallValues *walls);
PetscErrorCode WallValuesFree(WallValues *walls);

#endif
