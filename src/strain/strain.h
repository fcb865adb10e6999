/* Parts of the strain cells: cuts of cells, and rows of the velocity on their faces. */
#ifndef ISPH_STRAIN_PARTS_H
#define ISPH_STRAIN_PARTS_H

#include "isph/strain.h"

#define FIT_REACH      3.3 /* largest radius of a fit [dx] */
#define SURFACE_RADIUS 2.5 /* of fits in fluids with a free surface [dx] */
#define GROUP_REACH    3.0 /* cells around one that decide on its group at a free surface */
#define CELL_SIDES     (2 * ISPH_MAX_DIM)
#define CELL_CORNERS   (1 << ISPH_MAX_DIM)
#define CELL_SURFACES  12 /* parts of the surface in a cell, at most */

/* Volume of a part of a cell that counts, over that of the cell. Corners so near to a surface are
   on it: the facets of a part that is left out would be lost. */
#define LEAST_PART 1e-6

#define TIE 1e-7 /* a corner so near to an interface is in the stiffer fluid [dx] */

/* The part of a cell with positive distances at its corners. */
typedef struct {
  PetscReal volume;                                            /* [m^dim] */
  PetscReal centre[ISPH_MAX_DIM];                              /* mean of its sides [m] */
  PetscReal area[CELL_SIDES], at[CELL_SIDES][ISPH_MAX_DIM];    /* of its sides, 2 a and 2 a + 1 */
  PetscInt  n_surface;                                         /* parts of the surface */
  PetscReal normal[CELL_SURFACES][ISPH_MAX_DIM];               /* out of the part, times area */
  PetscReal place[CELL_SURFACES][ISPH_MAX_DIM];                /* their centroids [m] */
  PetscReal corner[CELL_SURFACES][ISPH_MAX_DIM][ISPH_MAX_DIM]; /* their dim corners [m] */
  PetscBool between[CELL_SURFACES];                            /* they are of an interface */
} CellPart;

void StrainCut(PetscInt dim, const PetscReal lo[], const PetscReal edge[], const PetscReal d[],
               const PetscReal phi[], CellPart *part);

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
  PetscReal        radius; /* of fits at a free surface [dx] */
  const PetscBool *gives;
  const PetscBool *dry;  /* walls that the fluid does not wet, by local index; NULL: none */
  PetscInt        *foot; /* by local index: row of the velocity on the interface there; -1: none */
  StrainRows       feet; /* rows of feet, sets for each */
} StrainFits;

/* A part of the boundary of a cell: a point, whose row gives the velocity, and the area vector over
   the volume. */
typedef struct {
  PetscInt  point, set; /* set: the row of all components; -1: each has its own */
  PetscReal normal[ISPH_MAX_DIM];
} Facet;

/* Parts of the boundaries of all cells. */
typedef struct {
  PetscInt n, room, *first; /* facets of each cell begin at */
  Facet   *facet;
} Facets;

/* Groups of cells with one gradient: a cell and its thin neighbours. */
typedef struct {
  PetscInt  *lead;   /* of each cell: the cell whose number its group has */
  PetscInt  *next;   /* the next cell of the group; -1: none */
  PetscReal *volume; /* of the group with the number of a cell [m^dim] */
} StrainGroups;

/* straincorners.c */

/* Corners of the block of cells. */
typedef struct {
  PetscInt   all;
  PetscInt  *fluid; /* at each corner; NULL: one fluid */
  PetscInt  *other; /* beyond its interface; its own without */
  PetscReal *phi;   /* distance from its interface, at least 0 [m] */
  PetscReal *depth; /* below the free surface; NULL: there is none [m] */
  PetscBool *dry;   /* walls that the fluid does not wet, by local index; NULL: none */
  PetscReal *level; /* of the concentration, of the piece of each particle, by local index */
  PetscBool *apart; /* own fluid particles that no piece of the fluid has */
} StrainNodes;

/* A cell of the block. */
typedef struct {
  PetscInt  cell[ISPH_MAX_DIM], node[CELL_CORNERS];
  PetscReal lo[ISPH_MAX_DIM];
} StrainCell;

PetscErrorCode StrainNodesFind(const Scene *scene, const Particles *p, PetscReal edge,
                               StrainLattice *l, StrainNodes *corners);
PetscErrorCode StrainNodesFree(StrainNodes *corners);
void           StrainCornerPlace(const Scene *scene, const StrainLattice *l, const PetscInt index[],
                                 PetscReal x[]);
void           StrainCornerIndex(const StrainLattice *l, PetscInt k, PetscInt index[]);
PetscInt       StrainCornerCount(const StrainLattice *l);
PetscReal      StrainBodiesDistance(const Scene *scene, const PetscReal x[], PetscInt *body);
void StrainCellSet(const Scene *scene, const StrainLattice *l, PetscInt k, StrainCell *cell);
void StrainDistancesIn(const StrainLattice *l, const StrainNodes *corners, const StrainCell *cell,
                       PetscReal d[]);
const PetscReal *StrainPhiIn(PetscInt dim, const StrainNodes *corners, const StrainCell *cell,
                             PetscInt fluid, PetscReal phi[]);

/* straingroups.c */
PetscErrorCode StrainGroupsCreate(const StrainCells *cells, const Facets *facets, PetscBool thin,
                                  StrainGroups *groups);
PetscErrorCode StrainGroupsFree(StrainGroups *groups);

/* strainlevel.c */
#define LEVEL_REACH 3.0 /* radius of the kernel of the concentration [dx] */

#define LEVEL_LOW   0.05 /* bounds of its levels */
#define LEVEL_HIGH  0.9
#define LEVEL_PLANE 0.5 /* that of a plane surface */

typedef PetscErrorCode (*StrainVolumesAt)(void *ctx, const PetscReal level[], PetscReal volume[]);
PetscErrorCode StrainLevels(const Particles *p, PetscInt n, const PetscReal own[], PetscReal low,
                            PetscReal high, StrainVolumesAt Volumes, void *ctx, PetscReal level[]);
PetscErrorCode StrainExcess(const Scene *scene, const Particles *p, const Cells *cells,
                            const PetscReal level[], const PetscReal x[], PetscInt list[],
                            PetscReal part[], PetscReal *excess);
PetscErrorCode StrainSlopes(const Scene *scene, const Particles *p, const Cells *cells,
                            const PetscReal level[], const PetscReal x[], PetscInt list[],
                            PetscReal part[], PetscInt *n, PetscReal slope[], PetscReal gradient[],
                            PetscReal *value);

/* strainmotion.c */
PetscErrorCode StrainMotion(const Scene *scene, const Particles *p, const StrainPoints *points,
                            const StrainNodes *corners, StrainCells *cells);
PetscErrorCode StrainFluxes(const Scene *scene, const Particles *p, const StrainPoints *points,
                            const Facets *facets, const StrainGroups *groups, StrainCells *cells);
PetscErrorCode StrainLayer(PetscInt dim, const StrainPoints *points, const Facets *facets,
                           StrainCells *cells);
PetscErrorCode StrainBlocksFree(StrainBlocks *blocks);

/* strainpieces.c */
PetscErrorCode StrainPiecesNumber(const Scene *scene, const Particles *p, const StrainLattice *l,
                                  const PetscBool wet[], PetscReal piece[], PetscInt *n,
                                  PetscInt *single);

/* strainvolumes.c */
PetscErrorCode StrainVolumes(const Scene *scene, const Particles *p, const StrainLattice *l,
                             StrainNodes *corners);

/* strainsurface.c */
PetscErrorCode StrainFacetAdd(PetscInt dim, const PetscReal x[][ISPH_MAX_DIM], PetscInt fluid,
                              PetscBool between, PetscReal tension, StrainSurface *surface);
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

/* StrainCellCount - Returns the number of lattice cells of the block; not collective */
static inline PetscInt StrainCellCount(const StrainLattice *l)
{
  PetscInt all = 1;

  for (PetscInt a = 0; a < l->dim; a++) all *= l->n[a];
  return all;
}

/* StrainDepth - Returns the depth below the surface at which the concentration exceeds its level by
   C: the slope of a plane surface is about 1.5 over the radius [m] */
static inline PetscReal StrainDepth(const Scene *scene, PetscReal C)
{
  return C * LEVEL_REACH * scene->dx / 1.5;
}

void StrainTensionOnWalls(const Scene *scene, const Particles *p, const StrainCells *cells,
                          PetscReal *const value[], PetscReal dt, PetscReal force[]);
PetscErrorCode StrainOfValues(const Particles *p, PetscReal *const value[], StrainCells *cells);
PetscErrorCode StrainFeet(StrainFits *fits);
PetscErrorCode StrainRowsOf(StrainFits *fits, const StrainPoints *points, StrainRows *rows);
PetscErrorCode StrainRowsFree(StrainRows *rows);

#endif
