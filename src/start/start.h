/*
  Declarations shared by the files of this folder. Each file calls only files to its right:

    fill.c | relax.c, lattice.c, irregularstart.c | givenpositions.c, wallparticles.c |
    densityplaces.c | pools.c | poollattice.c | wallrows.c
*/
#ifndef ISPH_START_START_H
#define ISPH_START_START_H

#include "isph/start.h"
#include "particles/impl.h"

/* lattice.c */
PetscErrorCode LatticeWallCount(const Scene *scene, WallPlacement walls, PetscInt *count);
PetscErrorCode LatticeWalls(const Scene *scene, WallPlacement walls, PetscInt first, PetscInt last,
                            Particles *particles, PetscInt at);
PetscErrorCode LatticeFill(const Scene *scene, WallPlacement walls, const FluidStart *start,
                           Particles *p);

/* pools.c */
typedef struct {
  const Scene *scene;
  PetscInt     n;                         /* pools; 0: the fluid fills the box */
  PetscInt     of[SCENE_MAX_FILLED];      /* pool of each filled region */
  PetscBool    lattice[SCENE_MAX_FILLED]; /* of each pool: it has a lattice */
  PetscReal    volume[SCENE_MAX_FILLED];  /* of each pool [m^dim] */
  PetscBool    relaxed;                   /* a pool has no lattice */
} Pools;
PetscErrorCode PoolsCreate(const Scene *scene, Pools *pools);
PetscBool      PoolsHold(const Pools *pools, const PetscReal x[]);

/* PoolAt - Returns the pool in which x lies deepest, and its depth below the border of the region
   there [m] */
static inline PetscInt PoolAt(const Pools *pools, const PetscReal x[], PetscReal *depth)
{
  PetscInt pool = 0;

  *depth = PETSC_NINFINITY;
  for (PetscInt k = 0; k < pools->scene->n_filled; k++) {
    const PetscReal d = SceneFilledDistance(pools->scene, k, x);

    if (d <= *depth) continue;
    *depth = d;
    pool   = pools->of[k];
  }
  return pool;
}

/* densityplaces.c */
typedef struct {
  PetscInt  n, axis[ISPH_MAX_DIM]; /* axes along which the region extends, as the box */
  PetscReal x[ISPH_MAX_DIM];       /* coordinates along the other axes [m] */
} Region;
typedef struct {
  PetscInt   dim, N, n, first; /* places of all ranks, of this rank, and the index of its first */
  PetscReal *x;                /* dim values of each [m] */
  PetscReal  volume;           /* of the region, all ranks [lattice cells] */
} Places;
void           RegionSetBox(const Scene *scene, Region *region);
void           RegionSetSide(const Scene *scene, PetscInt side, Region *region);
PetscErrorCode PlacesCreate(const Scene *scene, const Region *region, const Pools *pools,
                            Places *places);
PetscErrorCode PlacesDestroy(Places *places);

/* wallparticles.c */
typedef struct {
  PetscInt  side, index;                           /* index among the points of all ranks */
  PetscReal x[ISPH_MAX_DIM], normal[ISPH_MAX_DIM]; /* [m] */
} SurfacePoint;
typedef struct {
  PetscInt      N, n, capacity; /* points of all ranks, of this rank */
  SurfacePoint *point;
} Surfaces;
PetscErrorCode SurfacesCreate(const Scene *scene, Surfaces *surfaces);
PetscErrorCode SurfacesDestroy(Surfaces *surfaces);

/* wallrows.c */
typedef struct {
  PetscInt   N, n, capacity; /* particles of all ranks, of this rank */
  PetscInt  *index;          /* of each among those of all ranks */
  PetscReal *x;              /* dim values of each [m] */
} Rows;
PetscErrorCode RowsAdd(const Scene *scene, const PetscReal x[], Rows *rows);
PetscBool      RowsHold(const Scene *scene, const PetscReal x[]);
PetscErrorCode RowsCreate(const Scene *scene, const Surfaces *walls, Rows *rows);
PetscErrorCode RowsDestroy(Rows *rows);

/* poollattice.c */
PetscErrorCode PoolHasLattice(const Pools *pools, PetscInt pool, PetscBool *has);
PetscErrorCode PoolLattice(const Pools *pools, PetscInt pool, Rows *rows);

/* givenpositions.c */
PetscErrorCode GivenFill(const Scene *scene, const FluidStart *start, Particles *p);

/* irregularstart.c */
typedef struct {
  PetscInt  ordered; /* fluid particles that relaxation does not move: their ids are below it */
  PetscInt  relaxed; /* fluid particles that it moves */
  PetscReal volume;  /* of the fluid that fills the box [lattice cells] */
  Pools     pools;
} Cloud;
PetscErrorCode CloudFill(const Scene *scene, WallPlacement walls, Particles *p, Cloud *cloud);
PetscErrorCode CloudFinish(const Scene *scene, const Cloud *cloud, Particles *p);

/* relax.c */
PetscErrorCode CloudRelax(const Scene *scene, const Cloud *cloud, Particles *p);

#endif
