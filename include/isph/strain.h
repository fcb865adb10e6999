/*
  Strains of small cells, for the viscous force of a variable viscosity. The box is divided into
  cells that bodies and interfaces of fluids cut. The mean velocity gradient of a cell follows from
  the velocities on its faces, which are fits of the particles' velocities,

    V_c (grad u)_c = sum over faces of u n^T A,   F_i = -(1/V_i) d/du_i sum_c V_c nu_c E_c:E_c

  with E_c the symmetric part. See theory.md, (viscosity:cells) and those up to (viscosity:error).
*/
#ifndef ISPH_STRAIN_H
#define ISPH_STRAIN_H

#include "isph/rows.h"

#define CELL_EDGE     0.5 /* of a cell [dx] */
#define CELL_IN_SPACE 0.8 /* the same in fluids with a free surface in 3D: a quarter of the cells */
#define WIDER_FITS    1.2 /* radius of wide fits at a free surface over that of the run's */
#define STRAIN_TENSOR (ISPH_MAX_DIM * ISPH_MAX_DIM)

/* Rows of sums over particles by local index: sum_k w[k] u_j[k], k in [start[r], start[r + 1]). */
typedef struct {
  PetscInt   n, rows, capacity, room, *start, *j;
  PetscReal *w;
} StrainRows;

/* The same with a vector or a matrix for each particle: `size` numbers at w[k size]. */
typedef struct {
  PetscInt   size, n, room, *start, *j;
  PetscReal *w;
} StrainBlocks;

/* The cells of a rank: a block of the lattice. In periodic directions it continues beyond sides. */
typedef struct {
  PetscInt   dim, cells[ISPH_MAX_DIM]; /* of the whole lattice */
  PetscReal  edge[ISPH_MAX_DIM];       /* of a cell [m] */
  PetscInt   first[ISPH_MAX_DIM], n[ISPH_MAX_DIM];
  PetscReal *distance; /* of the corners of the block from bodies; NULL: none [m] */
} StrainLattice;

/* The particles that share a cell with own fluid particle i: [start[i], start[i + 1]). */
typedef struct {
  PetscInt  n, room, *start;
  PetscInt *local, *slot; /* local index, and place among the columns of i */
} StrainList;

/* The quantity of the fits: the velocity, or a scalar. */
typedef struct {
  PetscInt  sets;   /* components with equations of their own at boundaries: 1 or dim */
  PetscBool normal; /* walls along the axes give their normal velocity only; then sets is dim */
  const PetscBool *gives; /* of a scalar: boundaries that give its value; NULL: the velocity */
  PetscBool        wide;  /* fits at a free surface are WIDER_FITS times as wide */
  PetscBool        cut;   /* the cells end at the free surface, of a scalar the last boundary */
} StrainQuantity;

/* Parts of boundaries that do not give the value of a scalar, each with a row of its value. */
typedef struct {
  PetscInt   n, room, *side, *row; /* parts, the boundary of each, and its row */
  PetscReal *normal,
      *x; /* dim values of each: out of the fluid, times area [m^(dim-1)]; centroid */
  StrainRows rows;
} StrainBorder;

/* Facets of the free surface and of interfaces of fluids, which both fluids have, and the sides of
   the box that the fluid wets. */
typedef struct {
  PetscReal    wet[2 * ISPH_MAX_DIM]; /* areas of sides in own cells [m^(dim-1)] */
  PetscInt     n, room;
  PetscReal   *x;                /* their dim corners, dim numbers each [m] */
  PetscInt    *fluid;            /* whose fits have their velocity */
  PetscBool   *between;          /* they are of an interface */
  PetscReal   *tension;          /* [N/m] */
  PetscInt    *corner;           /* their numbers, dim of each; facets side by side share them */
  PetscInt     n_wet, room_wet;  /* corners of parts of bodies in the fluid */
  PetscReal   *wet_x;            /* dim numbers each [m] */
  PetscInt    *wet_body;         /* their boundaries */
  PetscInt     first, n_corners; /* point of corner 0, the last points; all corners */
  PetscBool   *on_level;         /* a corner is on the free surface, not on interfaces only */
  StrainRows   rows;             /* of the velocity at points: `sets` of each */
  StrainBlocks motion;           /* of the velocity of corners, see strainmotion.c */
  PetscReal   *depth;            /* of corners, of the layer below that the level feels [m] */
  StrainBlocks layer;            /* corners of cells, each with its weight and its place */
} StrainSurface;

typedef struct StrainCells StrainCells;

struct StrainCells {
  StrainLattice lattice;
  PetscInt      sets;             /* components of the velocity with fits of their own: 1 or dim */
  PetscInt      n, all, capacity; /* cells; with the layers behind walls that slip */
  PetscReal    *volume, *nu;      /* [m^dim], [m^2/s] */
  PetscInt     *fluid;
  PetscInt     *beside; /* the cell that a layer is behind, for cell n and those after it */
  PetscReal    *centre[ISPH_MAX_DIM];
  /* gradients of component set s in cell c: entries [first[s][c], first[s][c + 1]) */
  PetscInt     *first[ISPH_MAX_DIM], *j[ISPH_MAX_DIM];
  PetscReal    *g[ISPH_MAX_DIM][ISPH_MAX_DIM]; /* weight in du/dx_b at [s][b] [1/m] */
  PetscInt      n_entries[ISPH_MAX_DIM], room[ISPH_MAX_DIM];
  PetscReal    *mean;   /* of a scalar: weights of its mean in cells, at the entries of g[0] */
  StrainBorder  border; /* of a scalar */
  StrainSurface surface;
  PetscReal    *mass[ISPH_MAX_DIM]; /* of own fluid: integral of its weight in fits of a set, times
                                    its density over that of fluid 0 with `cut` [m^dim] */
  StrainBlocks  flux; /* of cells at the surface: more than V_c (div u)_c by its motion, and by
                         their own sides if they share a gradient */
  /* force on component b for a unit of one along axis a, at [a dim + b], over the density of fluid
     0: of own fluid, and of walls in own cells; NULL: not known [m^dim] */
  PetscReal *weight[STRAIN_TENSOR];
  PetscBool *apart;   /* own fluid particles that no piece of the fluid has; NULL: not known */
  PetscReal *strain;  /* E of cell c for the last velocity: dim^2 values each [1/s] */
  PetscReal *rate;    /* sqrt(2 E:E) [1/s] */
  StrainList list[2]; /* fluid, walls */
  /* of own fluid i and set s: places in the lists of cells, [of[s][i], of[s][i + 1]) */
  PetscInt *of[ISPH_MAX_DIM], *at[ISPH_MAX_DIM], *cell[ISPH_MAX_DIM];
};

/* Returns true if this rank has a cell: if its centre lies in the box of the rank. Output: x - the
   centre [m]. */
static inline PetscBool StrainHasCell(const Particles *p, const StrainCells *cells, PetscInt c,
                                      PetscReal x[])
{
  for (PetscInt a = 0; a < p->dim; a++) x[a] = cells->centre[a][c];
  return ParticlesHolds(p, x);
}

PetscReal      StrainEdge(const Scene *scene);
PetscReal      StrainReach(const Scene *scene);
PetscErrorCode StrainAssemble(const Scene *scene, const Particles *particles, const Neighbors *nb,
                              PetscReal edge, PetscInt degree, const StrainQuantity *quantity,
                              StrainCells **cells);
PetscErrorCode StrainPlaces(const Particles *particles, StrainCells *cells);
PetscErrorCode StrainPatterns(const Particles *particles, StrainCells *cells, Pattern columns[2]);
PetscErrorCode StrainMatrices(const Scene *scene, const Particles *particles, PetscBool walls,
                              StrainCells *cells, Mat *A, Mat *B);
PetscErrorCode StrainProducts(const Scene *scene, const Particles *particles, PetscBool walls,
                              const StrainCells *cells, Mat *A);
PetscErrorCode StrainScale(const Scene *scene, const Particles *particles, const StrainCells *cells,
                           Mat A, Mat B);
PetscErrorCode StrainOfVelocity(const Particles *particles, const Vec u[], const Vec walls[],
                                StrainCells *cells);
void StrainViscosities(const Scene *scene, const Particles *particles, StrainCells *cells);
void StrainRheology(const Scene *scene, StrainCells *cells);
PetscErrorCode StrainSpread(Particles *particles, const StrainCells *cells);
void           StrainAddForce(const Particles *particles, const StrainCells *cells, PetscReal scale,
                              PetscReal *const to[]);
PetscErrorCode StrainForceError(const Scene *scene, const Particles *particles, const Neighbors *nb,
                                PetscInt degree, StrainCells *cells, PetscReal *const error[]);
void StrainSetTension(const Particles *particles, const PetscReal sigma[], StrainCells *cells);
PetscErrorCode StrainTension(const Scene *scene, const Particles *particles,
                             const StrainCells *cells, PetscReal force[], PetscReal *energy);
PetscErrorCode StrainTensionMatrix(const Particles *particles, const StrainCells *cells, Mat *K);
PetscErrorCode StrainForces(const Scene *scene, const Particles *particles, const Vec u[],
                            PetscReal dt, StrainCells *cells, PetscReal force[]);
PetscErrorCode StrainUnevenness(const Scene *scene, const Particles *particles,
                                const Neighbors *neighbors, const KernelSize *kernel,
                                const StrainCells *cells, PetscReal value[],
                                PetscReal *const gradient[]);
PetscErrorCode StrainPieces(const Scene *scene, const Particles *particles,
                            const StrainCells *cells, PetscInt fluid, PetscInt piece[]);
PetscBool StrainWaits(const Scene *scene, const Particles *particles, PetscInt w, PetscReal x[],
                      PetscReal *length);
PetscReal StrainVolumeOf(const Scene *scene, const Particles *particles, PetscInt i);
PetscBool StrainSolid(const Scene *scene, const StrainCells *cells, PetscInt k, PetscReal x[],
                      PetscReal *volume);
PetscErrorCode StrainParts(const Scene *scene, const Particles *particles, const Cells *cells,
                           const PetscReal x[], PetscInt list[], PetscInt *n, PetscReal part[],
                           PetscReal *C);
PetscErrorCode StrainDestroy(StrainCells **cells);

/* StrainOnSide - Returns true if a place is on a side of the box that is not periodic; not
   collective */
static inline PetscBool StrainOnSide(const Scene *scene, PetscInt side, const PetscReal x[])
{
  const PetscInt  a    = side / 2;
  const PetscReal wall = side % 2 ? scene->hi[a] : scene->lo[a];

  if (SceneIsPeriodic(scene, a)) return PETSC_FALSE;
  return PetscAbsReal(x[a] - wall) < 1e-6 * scene->dx ? PETSC_TRUE : PETSC_FALSE;
}

#endif
