/*
  A crowd: particles without operators, for tests of the particles and their neighbours. All ranks
  gather all particles. The spacing is 0.1; the first axes may be periodic, the others have walls.
*/
#ifndef CROWD_H
#define CROWD_H

#include "cloud.h"

#define RADIUS 2.6 /* [dx] */

typedef struct {
  const char   *name;
  Scene         scene;
  WallPlacement walls;
} Setting;

/* Positions and largest edges of the particles of all ranks by id; a removed particle has
   found = 0. */
typedef struct {
  PetscInt   n;
  PetscReal *x;     /* x[dim id + a] */
  PetscReal *found; /* number of occurrences of each id */
  PetscReal *edge;  /* largest, ParticlesLargestEdge() */
} All;

Setting   CrowdBox(const char *name, PetscInt dim, PetscInt nx, PetscInt ny, PetscInt nz,
                   PetscInt n_periodic, PetscInt layers);
void      CrowdReadSpacing(const char options[], Scene *scene);
void      CrowdGather(const Particles *p, All *all);
void      CrowdFree(All *all);
PetscReal CrowdNoise(PetscInt id, PetscInt k);
PetscReal CrowdTag(PetscInt id, PetscInt c);
void      CrowdMove(const Scene *scene, Particles *p, PetscReal length);
void      CrowdCheckParticles(const Setting *s, const Particles *p, PetscReal *const tag[]);
void      CrowdCheckNeighbors(const Setting *s, const Particles *p, const Neighbors *nb);

#endif
