/*
  Particles: plain arrays, distributed over ranks, and the rows of their neighbours.

  Local storage of every array:  own fluid | own wall | halo fluid | halo wall

  Ownership, order and global numbers are constant during an EPOCH. An epoch ends when a particle
  has moved half a skin from its position at the start of the epoch. Only then particles migrate,
  are sorted by cell and get new numbers; every registered field is permuted in the same way, and
  the halo is rebuilt.
*/
#ifndef ISPH_PARTICLES_H
#define ISPH_PARTICLES_H

#include "isph/scene.h"

extern const OptionTable ParticleOptions;

#define PARTICLES_MAX_FIELDS 24

/* Values of a field that the halo needs. */
typedef enum {
  HALO_NONE,  /* none: own values only */
  HALO_EPOCH, /* copied when an epoch starts (it does not change within one) */
} HaloPolicy;

/* Default value of a field for particles of ParticlesInsert(). */
typedef enum {
  ENTRY_ZERO,
  ENTRY_MEAN,     /* mean of the fluid within halo_width, weighted by distance */
  ENTRY_NEAREST,  /* value of the nearest fluid within halo_width */
  ENTRY_POSITION, /* position of the particle */
  ENTRY_SPACING,  /* SceneSpacing() */
  ENTRY_STRETCH,  /* SceneStretch() */
  ENTRY_VOLUME,   /* SceneVolumeAt() */
} EntryPolicy;

typedef struct {
  const char *name;
  PetscInt    components;
  HaloPolicy  halo;
  EntryPolicy entry;
  PetscReal **slot; /* component pointers of the registrant, kept valid: slot[c][i], i < capacity */
} Field;

/* The kind of a particle. Fluid kinds have a row in every equation and are stored with the fluid;
   wall kinds have given values and are stored with the walls. */
typedef enum { PARTICLE_FLUID, PARTICLE_WALL, PARTICLE_KINDS } ParticleKind;
typedef struct {
  const char *name;
  PetscBool   is_wall;
} ParticleKindRow;
extern const ParticleKindRow ParticleKinds[PARTICLE_KINDS];

#define LINE_PASSED 9.0 /* Particles.wetness once the line of a free surface has passed by */

#define PARTICLES_MAX_ID ((PetscInt64)1 << 53) /* records hold ids as real numbers */

typedef struct {
  MPI_Comm  comm;
  PetscInt  dim;
  PetscInt  n_fluid, n_wall;           /* own */
  PetscInt  n_halo_fluid, n_halo_wall; /* copies from other ranks, and periodic images */
  PetscInt  capacity;                  /* of every array below and of every field */
  PetscInt  N_fluid, N_wall;           /* global */
  PetscInt  N_lattice;                 /* fluid particles of a lattice in this scene */
  PetscInt  fluid_start, wall_start;   /* global numbers of the first own fluid and wall particle */
  PetscInt  N_start[2];                /* fluid and wall particles at the start of the run */
  PetscBool velocity_given;            /* velocities were given with the positions */
  PetscInt *row; /* global number among all fluid or among all wall particles */

  PetscInt64   *id;      /* permanent and never reused */
  PetscInt64    next_id; /* smallest unused id */
  ParticleKind *kind;

  PetscReal *x[ISPH_MAX_DIM]; /* positions (field) [m]; ParticlesUpdateHalo refreshes the halo */
  PetscReal *u[ISPH_MAX_DIM]; /* velocities of own particles (field) [m/s] */
  PetscReal *p;               /* pressures of own fluid (field) [Pa]; NULL: no pressure */
  PetscReal *nu;    /* kinematic viscosities of fluid (field) [m^2/s]; NULL: uniform, scene->nu */
  PetscReal *fluid; /* number of the fluid, SceneFluidAt() (field); NULL: one fluid */
  PetscReal *share; /* of this fluid in the particle, SceneShare() (field); NULL: all of it [-] */
  PetscReal *other; /* number of the fluid of the rest (field) */
  PetscReal *interface; /* distance from the nearest interface of two fluids (field) [m] */
  PetscReal *interface_normal[ISPH_MAX_DIM]; /* from there into the own fluid (field); 0: beyond
                                                INTERFACE_REACH [-] */
  PetscReal *x_epoch[ISPH_MAX_DIM];          /* own positions when the epoch started (field) [m] */
  PetscReal *normal[ISPH_MAX_DIM]; /* of wall particles, into the fluid (field); NULL: no walls */
  PetscReal *depth;                /* of wall particles below the surface [m] (field) */
  PetscReal *side;    /* of wall particles: number of the wall, a whole number (field) */
  PetscReal *entered; /* of wall particles on an inflow: length of the fluid there since the last
                         particle (field); NULL: there is none [m] */
  PetscReal *wetness; /* of wall particles: the concentration less its level in the first cells, or
                         LINE_PASSED (field); NULL: no cells end at a free surface [-] */
  PetscReal *dx;      /* spacing of each particle (field); h = h_over_dx dx [m] */
  PetscReal *stretch[ISPH_MAX_DIM]; /* SceneStretch() (field) [-]; NULL: all are 1 */
  PetscReal *volume;                /* (field) [m^dim] */
  PetscReal  cell_volume;           /* of the lattice of the reference spacing [m^dim] */
  PetscReal  weight;         /* sum of ParticlesWeight() over all fluid; N_fluid if uniform [-] */
  PetscReal  weight_start;   /* the same at the start of the run [-] */
  PetscReal  weight_resized; /* the same of the volumes that ParticlesResize() found [-] */
  Field      field[PARTICLES_MAX_FIELDS];
  PetscInt   n_fields;

  /* Ranks [a, b) are divided at m = (a + b) / 2: ranks below m own x[cut_axis[m]] < cut[m] [m] */
  PetscInt  *cut_axis;
  PetscReal *cut;
  PetscBool  redraw;                             /* the next epoch always sets new boxes */
  PetscReal  lo[ISPH_MAX_DIM], hi[ISPH_MAX_DIM]; /* the box of space this rank owns [m] */
  PetscReal  halo_width;                         /* largest interaction radius [m] */
  PetscReal  skin;                               /* [m] */
  PetscInt   epoch;                              /* counter from 1; 0 before the first epoch */
  PetscInt   moved; /* stamp of positions; ParticlesUpdateHalo() increases it */

  PetscSF      sf;                       /* own (roots) -> halo (leaves), fixed within an epoch */
  MPI_Datatype vector;                   /* dim numbers */
  PetscReal   *halo_shift[ISPH_MAX_DIM]; /* of halo particle k, added to the owner's position [m] */
} Particles;

/* Placement of wall particles for a wall treatment: a layer on the surface, or layers behind it. */
typedef struct {
  PetscInt  layers;   /* 0: one layer on the surface; k: k dummy layers from dx/2 below it */
  PetscBool surface;  /* the first of k layers is on the surface, with half a particle volume */
  PetscBool jittered; /* displaced like the fluid, which may come arbitrarily close to them */
} WallPlacement;

/* Fluid that starts at given positions instead of a lattice: the share of this rank. */
typedef struct {
  PetscInt   N, n, first; /* particles of all ranks, of this rank, and its first id */
  PetscReal *x, *u;       /* dim values of each [m], [m/s]; u NULL: velocities are the case's */
  PetscReal *nu;          /* viscosities [m^2/s]; NULL: from positions */
} FluidStart;

/* New particles of a kind: the share of this rank. */
typedef struct {
  ParticleKind     kind;
  PetscInt         n;
  const PetscReal *x; /* dim values of each, in the box of this rank [m] */
  void (*Value)(const Field *field, PetscInt k, PetscReal value[],
                void *ctx); /* NULL: default values */
  void *ctx;                /* of Value */
} NewParticles;

PetscErrorCode ParticlesCreate(const Scene *scene, PetscReal halo_width, Particles **particles);
PetscErrorCode ParticlesDestroy(Particles **particles);
PetscErrorCode ParticlesRegister(Particles *particles, const char name[], PetscInt components,
                                 HaloPolicy halo, EntryPolicy entry, PetscReal **slot);
PetscErrorCode ParticlesUpdateEpoch(const Scene *scene, Particles *particles, PetscBool force,
                                    PetscBool *started);
PetscErrorCode ParticlesUpdateHalo(Particles *particles);
PetscErrorCode ParticlesResize(const Scene *scene, Particles *particles);
void           ParticlesShare(MPI_Comm comm, PetscInt n, PetscInt *first, PetscInt *last);
PetscInt       ParticlesRecordWidth(const Particles *particles);
PetscErrorCode ParticlesPack(const Particles *particles, PetscReal record[]);
PetscErrorCode ParticlesUnpack(Particles *particles, const PetscReal record[]);
PetscBool      ParticlesValidRecord(const Scene *scene, const Particles *particles,
                                    const PetscReal record[]);
PetscErrorCode ParticlesReplace(const Scene *scene, Particles *particles, PetscInt n,
                                const PetscReal record[]);
PetscErrorCode ParticlesInsert(const Scene *scene, Particles *particles, const NewParticles *added,
                               PetscInt64 *first);
PetscErrorCode ParticlesRemove(const Scene *scene, Particles *particles, PetscInt n,
                               const PetscInt local[]);
PetscReal      ParticlesHash(PetscInt seed, PetscInt64 id, PetscInt axis);
PetscInt       ParticlesRankAt(const Particles *particles, const PetscReal x[]);
PetscErrorCode ParticlesHaloField(const Particles *particles, PetscReal values[]);
PetscErrorCode ParticlesHaloComponents(const Particles *particles, PetscReal *const values[]);
PetscErrorCode ParticlesHaloVectors(const Particles *particles, PetscReal values[]);
PetscErrorCode ParticlesCountRepeated(const Particles *particles, PetscInt n,
                                      const PetscReal record[], PetscInt *repeated);

static inline PetscInt ParticlesOwn(const Particles *p)
{
  return p->n_fluid + p->n_wall;
}
static inline PetscInt ParticlesAll(const Particles *p)
{
  return p->n_fluid + p->n_wall + p->n_halo_fluid + p->n_halo_wall;
}
static inline PetscBool ParticlesIsWall(const Particles *p, PetscInt i)
{
  const PetscInt own = p->n_fluid + p->n_wall;
  return (i < own ? i >= p->n_fluid : i >= own + p->n_halo_fluid) ? PETSC_TRUE : PETSC_FALSE;
}

/* ParticlesSquareDistance - Returns the square of the distance of two particles [m^2]; not
   collective */
static inline PetscReal ParticlesSquareDistance(const Particles *p, PetscInt i, PetscInt j)
{
  PetscReal r2 = 0.0;

  for (PetscInt a = 0; a < p->dim; a++) r2 += PetscSqr(p->x[a][j] - p->x[a][i]);
  return r2;
}

/* Returns true if a position [m] lies in the box of this rank; the boxes of ranks do not
   overlap. */
static inline PetscBool ParticlesHolds(const Particles *p, const PetscReal x[])
{
  for (PetscInt a = 0; a < p->dim; a++) {
    if (x[a] < p->lo[a] || x[a] >= p->hi[a]) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* Returns the weight of particle i in means, norms and sums: its volume divided by the volume of
   a lattice cell, theory.md, (particles:means) [-]. */
static inline PetscReal ParticlesWeight(const Particles *p, PetscInt i)
{
  return p->volume[i] / p->cell_volume;
}

/* Returns the share of fluid k in particle i [-]. */
static inline PetscReal ParticlesFluidShare(const Particles *p, PetscInt i, PetscInt k)
{
  if ((PetscInt)p->fluid[i] == k) return p->share[i];
  return (PetscInt)p->other[i] == k ? 1.0 - p->share[i] : 0.0;
}

/* Returns the density of particle i [kg/m^3]. */
static inline PetscReal ParticlesDensity(const Scene *scene, const Particles *p, PetscInt i)
{
  if (!p->share) return scene->rho;
  return scene->rho * (p->share[i] * SceneFluidDensity(scene, (PetscInt)p->fluid[i]) +
                       (1.0 - p->share[i]) * SceneFluidDensity(scene, (PetscInt)p->other[i]));
}

/* Returns SceneMotionFactor() at the place of graded particle i, from its volume [-]. */
static inline PetscReal ParticlesMotionFactor(const Scene *scene, const Particles *p, PetscInt i)
{
  return p->volume[i] * (p->weight_resized / p->weight_start) / scene->motion_volume;
}

/* Returns the factor by which axis a is stretched about particle i, SceneStretch() [-]. */
static inline PetscReal ParticlesStretch(const Particles *p, PetscInt a, PetscInt i)
{
  return p->stretch[a] ? p->stretch[a][i] : 1.0;
}

/* Returns the largest edge of the cell of particle i, to which its support is in proportion [m]. */
static inline PetscReal ParticlesLargestEdge(const Particles *p, PetscInt i)
{
  PetscReal least = ParticlesStretch(p, 0, i);

  for (PetscInt a = 1; a < p->dim; a++) least = PetscMin(least, ParticlesStretch(p, a, i));
  return p->dx[i] / least;
}

/* Computes the surface point above wall particle i; beyond an edge, the point on the continued
   plane of the side [m]. */
static inline void ParticlesWallPoint(const Particles *p, PetscInt i, PetscReal x[])
{
  for (PetscInt a = 0; a < p->dim; a++) x[a] = p->x[a][i] + p->depth[i] * p->normal[a][i];
}

/* Cells of a uniform grid over local particles; particles of a cell are contiguous in the list. */
typedef struct {
  PetscInt   dim;
  PetscReal  origin[ISPH_MAX_DIM], size; /* [m] */
  PetscInt   count[ISPH_MAX_DIM];        /* cells along each axis */
  PetscInt  *start;           /* of each cell in list, count[0] fastest; one more at end */
  PetscInt  *list;            /* local particle indices, ascending in each cell */
  PetscReal *x[ISPH_MAX_DIM]; /* positions in the order of list [m] */
  PetscInt   n, capacity, cells_capacity;
} Cells;

PetscErrorCode CellsBuild(const Particles *particles, PetscReal size, Cells *cells);
PetscErrorCode CellsFree(Cells *cells);
PetscErrorCode CellsFind(const Cells *cells, const PetscReal x[], PetscReal radius, PetscInt max,
                         PetscInt list[], PetscInt *count);

/* Neighbours of own fluid particle i: col[row[i]] ... col[row[i+1]-1], local indices in ascending
   order without i. Pairs closer than the larger of their radii are neighbours; radii are in
   proportion to the largest edges of cells. With a Verlet margin the rows also hold pairs slightly
   beyond the radius, so readers must skip r >= radius. The cells hold positions at the time the
   rows were built: probes call CellsFind() with radius + margin / 2 and skip likewise. */
typedef struct {
  PetscReal  radius;  /* the largest [m] */
  PetscReal  spacing; /* largest edge of the cells of particles that have it [m] */
  PetscReal  slope;   /* largest change of a radius over the displacement of its particle; set by
                       the caller if particles change their sizes [-] */
  PetscReal  margin;  /* of the present rows [m] */
  PetscInt  *row, *col;
  PetscInt   row_capacity, col_capacity;
  PetscReal *x_built[ISPH_MAX_DIM]; /* own positions when rows with a margin were built [m] */
  PetscReal *reach2;       /* in the order of the cells' list: squares of radius + margin [m^2];
                              NULL except during a search */
  PetscInt   epoch, moved; /* stamps of the particles when the rows were built; 0: no rows */
  PetscInt   builds;       /* number of row constructions, a measure of cost */
  Cells      cells;
} Neighbors;

PetscErrorCode NeighborsCreate(PetscReal radius, PetscReal spacing, Neighbors **neighbors);
PetscErrorCode NeighborsDestroy(Neighbors **neighbors);
PetscErrorCode NeighborsRelease(Neighbors *neighbors);
PetscErrorCode NeighborsUpdate(const Particles *particles, PetscReal step_length,
                               Neighbors *neighbors);
PetscErrorCode NeighborsSearch(const Particles *particles, Neighbors *neighbors);
PetscErrorCode NeighborsFindRows(const Particles *particles, PetscInt first, PetscInt count,
                                 Neighbors *neighbors);

/* Vectors over own fluid or own wall particles; array NULL: the vector allocates its storage. */
PetscErrorCode FluidVec(const Particles *particles, PetscReal array[], Vec *v);
PetscErrorCode WallVec(const Particles *particles, Vec *v);
PetscErrorCode LocalValues(const Particles *particles, Vec f, Vec walls, PetscInt step,
                           PetscReal value[]);
PetscErrorCode FluidSumOwn(const Particles *p, Vec f, PetscBool squared, PetscReal *sum);
PetscErrorCode FluidSum(const Particles *particles, Vec f, PetscBool squared, PetscReal *sum);
PetscErrorCode FluidRemoveMean(const Particles *particles, Vec f);
PetscErrorCode VelocityVec(const Particles *particles, Vec *v);
PetscErrorCode VelocityVecRepeat(const Particles *particles, Vec factor, Vec *v);
PetscErrorCode VelocityRowsDivide(const Particles *particles, PetscReal *const by[],
                                  PetscReal factor, Mat rows);
PetscErrorCode WallVelocityVec(const Particles *particles, Vec *v);
PetscErrorCode UnknownsVec(const Particles *particles, PetscInt n, Vec *v);

#endif
