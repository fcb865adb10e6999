/*
  Particles at the start of a run if the spacing is a function of place, or if the fluid has a free
  surface. Fluid is created in ordered rows along walls, on free surfaces, and elsewhere at the
  places of places.c, which relax.c relaxes. Wall particles lie on surfaces; no particle is behind a
  wall.
*/
#include "impl.h"

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

/*
  CloudFill - Creates the particles of a scene with isotropic grading at their first places

  Collective. Input: p - empty particles, with all fields of this module registered.

  Output Parameters:
+ p     - the particles; ids are given to ordered rows, then to places, then to walls
- cloud - number of particles in ordered rows, and volume of the fluid
*/
PetscErrorCode CloudFill(const Scene *scene, Particles *p, Cloud *cloud)
{
  Region   region;
  Places   places;
  Surfaces walls = {0}, free;
  Rows     rows;

  PetscFunctionBegin;
  RegionSetBox(scene, &region);
  PetscCall(PlacesCreate(scene, &region, &places));
  if (SceneHas(scene, PHYSICS_WALLS)) PetscCall(SurfacesCreate(scene, BOUNDARY_PARTICLES, &walls));
  PetscCall(SurfacesCreate(scene, BOUNDARY_FREE, &free));
  PetscCall(RowsCreate(scene, &walls, &rows));
  cloud->ordered = rows.N + free.N;
  cloud->volume  = places.volume;
  p->N_lattice = p->N_fluid = p->N_start[0] = cloud->ordered + places.N;
  p->N_wall = p->N_start[1] = walls.N;
  p->n_fluid                = rows.n + free.n + places.n;
  p->n_wall                 = walls.n;
  p->next_id                = (PetscInt64)p->N_fluid + p->N_wall;
  UserCheck(p->N_fluid > 0, "the bodies leave no room for fluid at dx = %.4g", (double)scene->dx);
  PetscCall(ParticlesReserve(p, ParticlesOwn(p)));
  for (PetscInt i = 0; i < rows.n; i++)
    FluidParticle(scene, &rows.x[i * p->dim], rows.index[i], p, i);
  for (PetscInt i = 0; i < free.n; i++)
    FluidParticle(scene, free.point[i].x, rows.N + free.point[i].index, p, rows.n + i);
  for (PetscInt i = 0; i < places.n; i++)
    FluidParticle(scene, &places.x[i * p->dim], cloud->ordered + places.first + i, p,
                  rows.n + free.n + i);
  for (PetscInt k = 0; k < walls.n; k++) WallParticle(scene, &walls.point[k], p, p->n_fluid + k);
  PetscCall(RowsDestroy(&rows));
  PetscCall(SurfacesDestroy(&walls));
  PetscCall(SurfacesDestroy(&free));
  PetscCall(PlacesDestroy(&places));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  CloudFinish - Sets the sizes of particles at their last places; the volumes of the fluid add up to
  its volume

  Collective
*/
PetscErrorCode CloudFinish(const Scene *scene, const Cloud *cloud, Particles *p)
{
  PetscReal sum = 0.0;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    SetSize(scene, p, i);
    sum += p->volume[i];
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPIU_REAL, MPIU_SUM, p->comm));
  for (PetscInt i = 0; i < p->n_fluid; i++) p->volume[i] *= cloud->volume * p->cell_volume / sum;
  PetscFunctionReturn(PETSC_SUCCESS);
}
