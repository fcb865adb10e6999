/*
  Particles at the start of a run if the spacing is a function of place. Fluid is created at the
  places of places.c and relaxed by relax.c; wall particles lie on surfaces. No particle is behind a
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
+ p      - the particles; ids are given to the fluid first, in the order of places
- volume - of the fluid [lattice cells]
*/
PetscErrorCode CloudFill(const Scene *scene, Particles *p, PetscReal *volume)
{
  Region   region;
  Places   places;
  Surfaces walls;

  PetscFunctionBegin;
  RegionSetBox(scene, &region);
  PetscCall(PlacesCreate(scene, &region, &places));
  PetscCall(SurfacesCreate(scene, &walls));
  UserCheck(places.N > 0, "the bodies leave no room for fluid at dx = %.4g", (double)scene->dx);
  p->N_lattice = p->N_fluid = p->N_start[0] = places.N;
  p->N_wall = p->N_start[1] = walls.N;
  p->n_fluid                = places.n;
  p->n_wall                 = walls.n;
  p->next_id                = (PetscInt64)p->N_fluid + p->N_wall;
  PetscCall(ParticlesReserve(p, ParticlesOwn(p)));
  for (PetscInt i = 0; i < places.n; i++) {
    for (PetscInt a = 0; a < p->dim; a++) p->x[a][i] = places.x[i * p->dim + a];
    p->id[i]   = places.first + i;
    p->kind[i] = PARTICLE_FLUID;
    SetSize(scene, p, i);
  }
  for (PetscInt k = 0; k < walls.n; k++) WallParticle(scene, &walls.point[k], p, places.n + k);
  *volume = places.volume;
  PetscCall(SurfacesDestroy(&walls));
  PetscCall(PlacesDestroy(&places));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  CloudFinish - Sets the sizes of particles at their last places; the volumes of the fluid add up to
  its volume

  Collective. Input: volume - of the fluid [lattice cells]
*/
PetscErrorCode CloudFinish(const Scene *scene, PetscReal volume, Particles *p)
{
  PetscReal sum = 0.0;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    SetSize(scene, p, i);
    sum += p->volume[i];
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPIU_REAL, MPIU_SUM, p->comm));
  for (PetscInt i = 0; i < p->n_fluid; i++) p->volume[i] *= volume * p->cell_volume / sum;
  PetscFunctionReturn(PETSC_SUCCESS);
}
