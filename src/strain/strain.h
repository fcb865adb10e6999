/* Parts of the strain cells: cuts of cells, and rows of the velocity on their faces. */
#ifndef ISPH_STRAIN_PARTS_H
#define ISPH_STRAIN_PARTS_H

#include "isph/strain.h"

#define FIT_REACH     3.3 /* largest radius of a fit [dx] */
#define CELL_SIDES    (2 * ISPH_MAX_DIM)
#define CELL_CORNERS  (1 << ISPH_MAX_DIM)
#define CELL_SURFACES 12 /* parts of the surface in a cell, at most */

/* The part of a cell with positive distances at its corners, first axis fastest. */
typedef struct {
  PetscReal volume;                                         /* [m^dim] */
  PetscReal area[CELL_SIDES], at[CELL_SIDES][ISPH_MAX_DIM]; /* of its sides, 2 a and 2 a + 1 */
  PetscInt  n_surface;                                      /* parts of the surface */
  PetscReal normal[CELL_SURFACES][ISPH_MAX_DIM];            /* out of the part, times area */
  PetscReal place[CELL_SURFACES][ISPH_MAX_DIM];             /* their centroids [m] */
} CellPart;

void StrainCut(PetscInt dim, const PetscReal lo[], const PetscReal edge[], const PetscReal d[],
               CellPart *part);

/* StrainIsStiffer - Returns true if fluid a gives the velocity on its interface with b; not
   collective */
static inline PetscBool StrainIsStiffer(const Scene *scene, PetscInt a, PetscInt b)
{
  const PetscReal nu[] = {SceneFluidViscosity(scene, a, NULL), SceneFluidViscosity(scene, b, NULL)};

  return nu[0] > nu[1] || (nu[0] == nu[1] && a > b);
}

/* Points at which rows of the velocity are wanted. */
typedef struct {
  PetscInt   n, room;
  PetscReal *x[ISPH_MAX_DIM]; /* [m] */
  PetscInt  *fluid;           /* of the fit */
  PetscInt  *side;            /* number of the boundary that the point is on; -1: none */
} StrainPoints;

PetscErrorCode StrainPointAdd(PetscInt dim, const PetscReal x[], PetscInt fluid, PetscInt side,
                              StrainPoints *points);
PetscErrorCode StrainPointsFree(StrainPoints *points);

/* Data for the rows of points. */
typedef struct {
  const Scene     *scene;
  const Particles *p;
  const Neighbors *nb;
  PetscInt         degree, sets;
  PetscBool        normal; /* see StrainQuantity */
  const PetscBool *gives;
  PetscInt        *foot; /* by local index: row of the velocity on the interface there; -1: none */
  StrainRows       feet; /* rows of feet, sets for each */
} StrainFits;

PetscErrorCode StrainFeet(StrainFits *fits);
PetscErrorCode StrainRowsOf(StrainFits *fits, const StrainPoints *points, StrainRows *rows);
PetscErrorCode StrainRowsFree(StrainRows *rows);

#endif
