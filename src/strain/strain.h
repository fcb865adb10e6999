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
  PetscReal volume;                                            /* [m^dim] */
  PetscReal centre[ISPH_MAX_DIM];                              /* mean of its sides [m] */
  PetscReal area[CELL_SIDES], at[CELL_SIDES][ISPH_MAX_DIM];    /* of its sides, 2 a and 2 a + 1 */
  PetscInt  n_surface;                                         /* parts of the surface */
  PetscReal normal[CELL_SURFACES][ISPH_MAX_DIM];               /* out of the part, times area */
  PetscReal place[CELL_SURFACES][ISPH_MAX_DIM];                /* their centroids [m] */
  PetscReal corner[CELL_SURFACES][ISPH_MAX_DIM][ISPH_MAX_DIM]; /* their dim corners [m] */
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
  PetscBool        free;   /* fits hold on a free surface */
  const PetscBool *gives;
  PetscInt        *foot; /* by local index: row of the velocity on the interface there; -1: none */
  StrainRows       feet; /* rows of feet, sets for each */
} StrainFits;

/* A part of the boundary of a cell: a point, whose row gives the velocity, and the area vector over
   the volume. */
typedef struct {
  PetscInt  point;
  PetscReal normal[ISPH_MAX_DIM];
} Facet;

/* Parts of the boundaries of all cells. */
typedef struct {
  PetscInt n, room, *first; /* facets of each cell begin at */
  Facet   *facet;
} Facets;

/* strainlevel.c */
#define LEVEL_REACH 3.0 /* radius of the kernel of the concentration [dx] */

#define LEVEL_LOW  0.2 /* bounds of its level tau */
#define LEVEL_HIGH 0.8

typedef PetscReal (*StrainVolume)(void *ctx, PetscReal tau);
PetscErrorCode StrainConcentration(const Scene *scene, const Particles *p, const Cells *cells,
                                   const PetscReal x[], PetscInt list[], PetscReal *C);
PetscErrorCode StrainLevel(const Particles *p, StrainVolume Volume, void *ctx, PetscReal *tau);
PetscErrorCode StrainSlopes(const Scene *scene, const Particles *p, const Cells *cells,
                            const PetscReal x[], PetscInt list[], PetscInt *n, PetscReal slope[],
                            PetscReal gradient[]);

/* strainmotion.c */
PetscErrorCode StrainMotion(const Scene *scene, const Particles *p, const StrainPoints *points,
                            StrainCells *cells);
PetscErrorCode StrainFluxes(const Particles *p, const StrainPoints *points, const Facets *facets,
                            StrainCells *cells);
PetscErrorCode StrainBlocksFree(StrainBlocks *blocks);

/* strainsurface.c */
PetscErrorCode StrainFacetAdd(PetscInt dim, const PetscReal x[][ISPH_MAX_DIM],
                              StrainSurface *surface);
PetscErrorCode StrainWetAdd(PetscInt dim, const PetscReal x[][ISPH_MAX_DIM], PetscInt body,
                            StrainSurface *surface);
PetscErrorCode StrainCorners(const Scene *scene, const StrainLattice *lattice,
                             StrainSurface *surface, StrainPoints *points);

/* StrainIndexAlong - Returns the index along an axis of the cell of the block at x [m], the nearest
   outside; not collective */
static inline PetscInt StrainIndexAlong(const Scene *scene, const StrainLattice *l, PetscInt a,
                                        PetscReal x)
{
  const PetscInt k = (PetscInt)PetscFloorReal((x - scene->lo[a]) / l->edge[a]) - l->first[a];

  return PetscMin(PetscMax(k, 0), l->n[a] - 1);
}

/* StrainOnSide - Returns true if a place is on a side of the box that is not periodic; not
   collective */
static inline PetscBool StrainOnSide(const Scene *scene, PetscInt side, const PetscReal x[])
{
  const PetscInt  a    = side / 2;
  const PetscReal wall = side % 2 ? scene->hi[a] : scene->lo[a];

  if (SceneIsPeriodic(scene, a)) return PETSC_FALSE;
  return PetscAbsReal(x[a] - wall) < 1e-6 * scene->dx ? PETSC_TRUE : PETSC_FALSE;
}

/* StrainDepth - Returns the depth below the surface at which the concentration exceeds its level by
   C: the slope of a plane surface is about 1.5 over the radius [m] */
static inline PetscReal StrainDepth(const Scene *scene, PetscReal C)
{
  return C * LEVEL_REACH * scene->dx / 1.5;
}

void StrainTensionOnWalls(const Scene *scene, const Particles *p, const StrainCells *cells,
                          PetscReal *const value[], PetscReal tension, PetscReal dt,
                          PetscReal force[]);
PetscErrorCode StrainOfValues(const Particles *p, PetscReal *const value[], StrainCells *cells);
PetscErrorCode StrainFeet(StrainFits *fits);
PetscErrorCode StrainRowsOf(StrainFits *fits, const StrainPoints *points, StrainRows *rows);
PetscErrorCode StrainRowsFree(StrainRows *rows);

#endif
