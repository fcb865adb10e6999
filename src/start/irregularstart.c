/* Particles at the start of a run if the spacing is a function of place, or if the fluid does not
   fill the box. Ordered particles are in rows along walls, or on lattices of pools; the others are
   at the places of densityplaces.c, which relax.c relaxes. Wall particles lie on surfaces; no
   particle is behind a wall. */
#include "start.h"

/* Sets the size of local particle i for its place. */
static void SetSize(const Scene *scene, Particles *p, PetscInt i)
{
  PetscReal x[ISPH_MAX_DIM] = {0.0};

  for (PetscInt a = 0; a < p->dim; a++) x[a] = p->x[a][i];
  p->dx[i]     = SceneSpacing(scene, x);
  p->volume[i] = SceneVolumeAt(scene, x);
}

/* Writes a fluid particle to local index i. */
static void FluidParticle(const Scene *scene, const PetscReal x[], PetscInt id, Particles *p,
                          PetscInt i)
{
  for (PetscInt a = 0; a < p->dim; a++) p->x[a][i] = x[a];
  p->id[i]   = id;
  p->kind[i] = PARTICLE_FLUID;
  SetSize(scene, p, i);
}

/* Writes a wall particle to local index i. */
static void WallParticle(const Scene *scene, const SurfacePoint *point, Particles *p, PetscInt i)
{
  for (PetscInt a = 0; a < p->dim; a++) {
    p->x[a][i]      = point->x[a];
    p->normal[a][i] = point->normal[a];
  }
  p->depth[i] = 0.0;
  p->side[i]  = (PetscReal)point->side;
  p->id[i]    = (PetscInt64)p->N_fluid + point->index;
  p->kind[i]  = PARTICLE_WALL;
  SetSize(scene, p, i);
}

/* Creates the ordered particles: on lattices of pools, or in rows along walls; and the first places
   of the others. */
static PetscErrorCode Arrange(const Scene *scene, const Surfaces *walls, Cloud *cloud, Rows *rows,
                              Places *places)
{
  const Pools *pools = &cloud->pools;
  Region       region;

  PetscFunctionBegin;
  RegionSetBox(scene, &region);
  if (!pools->n) {
    PetscCall(PlacesCreate(scene, &region, NULL, places));
    PetscCall(RowsCreate(scene, walls, rows));
  } else {
    for (PetscInt pool = 0; pool < pools->n; pool++)
      if (pools->lattice[pool]) PetscCall(PoolLattice(pools, pool, rows));
    if (pools->relaxed) PetscCall(PlacesCreate(scene, &region, pools, places));
  }
  cloud->ordered = rows->N;
  cloud->relaxed = places->N;
  cloud->volume  = places->volume;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* CloudFill - Creates the particles of a scene with isotropic grading, or of a scene whose fluid
   does not fill the box, at their first places. Collective. Input: walls - placement of wall
   particles; with layers they are behind the sides of the box, otherwise on all surfaces; p - empty
   particles, with all fields of this module registered. Output: p - the particles; ids are given to
   ordered particles, then to places, then to walls; cloud - numbers of ordered and other particles,
   and volume of the fluid. */
PetscErrorCode CloudFill(const Scene *scene, WallPlacement walls, Particles *p, Cloud *cloud)
{
  Places   places   = {0};
  Surfaces surfaces = {0};
  Rows     rows     = {0};
  PetscInt layered  = 0, wall[2];

  PetscFunctionBegin;
  PetscCall(PoolsCreate(scene, &cloud->pools));
  if (SceneHas(scene, PHYSICS_WALLS)) PetscCall(SurfacesCreate(scene, &surfaces));
  PetscCall(Arrange(scene, &surfaces, cloud, &rows, &places));
  p->N_lattice = p->N_fluid = p->N_start[0] = cloud->ordered + places.N;
  if (walls.layers) PetscCall(LatticeWallCount(scene, walls, &layered));
  ParticlesShare(p->comm, layered, &wall[0], &wall[1]);
  p->N_wall = p->N_start[1] = walls.layers ? layered : surfaces.N;
  p->n_fluid                = rows.n + places.n;
  p->n_wall                 = walls.layers ? wall[1] - wall[0] : surfaces.n;
  p->next_id                = (PetscInt64)p->N_fluid + p->N_wall;
  UserCheck(p->N_fluid > 0, "the bodies leave no room for fluid at dx = %.4g", (double)scene->dx);
  PetscCall(ParticlesReserve(p, ParticlesOwn(p)));
  for (PetscInt i = 0; i < rows.n; i++)
    FluidParticle(scene, &rows.x[i * p->dim], rows.index[i], p, i);
  for (PetscInt i = 0; i < places.n; i++)
    FluidParticle(scene, &places.x[i * p->dim], cloud->ordered + places.first + i, p, rows.n + i);
  if (walls.layers) PetscCall(LatticeWalls(scene, walls, wall[0], wall[1], p, p->n_fluid));
  for (PetscInt k = 0; k < surfaces.n && !walls.layers; k++)
    WallParticle(scene, &surfaces.point[k], p, p->n_fluid + k);
  PetscCall(RowsDestroy(&rows));
  PetscCall(SurfacesDestroy(&surfaces));
  PetscCall(PlacesDestroy(&places));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gives each fluid particle its share of the volume of its pool, or, of a fluid that fills the box,
   a share in proportion to its present volume. */
static PetscErrorCode ShareVolume(const Scene *scene, const Cloud *cloud, Particles *p)
{
  const Pools *pools                 = &cloud->pools;
  PetscReal    sum[SCENE_MAX_FILLED] = {0.0}, depth;

  PetscFunctionBegin;
  for (PetscInt fill = 0; fill < 2; fill++) {
    for (PetscInt i = 0; i < p->n_fluid; i++) {
      PetscReal x[ISPH_MAX_DIM] = {0.0};
      PetscInt  pool;

      for (PetscInt a = 0; a < p->dim; a++) x[a] = p->x[a][i];
      pool = pools->n ? PoolAt(pools, x, &depth) : 0;
      if (!fill) sum[pool] += p->volume[i];
      else if (pools->n) p->volume[i] *= pools->volume[pool] / sum[pool];
      else p->volume[i] *= cloud->volume * p->cell_volume / sum[pool];
    }
    if (!fill)
      PetscCallMPI(
          MPI_Allreduce(MPI_IN_PLACE, sum, SCENE_MAX_FILLED, MPIU_REAL, MPIU_SUM, p->comm));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* CloudFinish - Sets the sizes of particles at their last places; the volumes of the fluid add up
   to its volume. Collective. */
PetscErrorCode CloudFinish(const Scene *scene, const Cloud *cloud, Particles *p)
{
  PetscFunctionBegin;
  for (PetscInt i = 0; i < p->n_fluid; i++) SetSize(scene, p, i);
  PetscCall(ShareVolume(scene, cloud, p));
  PetscFunctionReturn(PETSC_SUCCESS);
}
