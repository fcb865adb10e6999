/* The particles at the start of a run: fills the box with fluid particles and its sides with wall
   particles, and removes walls that are buried in other walls. */
#include "start.h"

/* Sets the viscosities of fluid: given values, or SceneViscosity() at the positions. */
static void SetViscosities(const Scene *scene, const FluidStart *start, Particles *p)
{
  for (PetscInt i = 0; p->nu && i < p->n_fluid; i++) {
    PetscReal x[ISPH_MAX_DIM];

    for (PetscInt a = 0; a < p->dim; a++) x[a] = p->x[a][i];
    p->nu[i] = start && start->nu ? start->nu[i] : SceneViscosity(scene, x);
  }
}

/* Returns the number of the fluid whose fluidity 1/nu is nearest: a mean over a cell, see
   SceneViscosity(), is the mean of fluidities. */
static PetscInt FluidOfViscosity(const Scene *scene, const PetscReal x[], PetscReal nu)
{
  PetscReal best  = PETSC_INFINITY;
  PetscInt  fluid = 0;

  for (PetscInt k = 0; k < SceneFluids(scene); k++) {
    const PetscReal apart = PetscAbsReal(1.0 / SceneFluidViscosity(scene, k, x) - 1.0 / nu);

    if (apart >= best) continue;
    best  = apart;
    fluid = k;
  }
  return fluid;
}

/* Sets the fluid of each particle, and its distance from the interfaces of fluids; with given
   viscosities those tell the fluid, and InterfacesFollow() finds interfaces. */
static PetscErrorCode SetFluids(const Scene *scene, const FluidStart *start, Particles *p)
{
  InterfacePoints points;

  PetscFunctionBegin;
  if (!p->fluid) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(InterfacePointsCreate(scene, &points));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscReal x[ISPH_MAX_DIM] = {0.0}, normal[ISPH_MAX_DIM];
    PetscInt  other;

    for (PetscInt a = 0; a < p->dim; a++) x[a] = p->x[a][i];
    if (start && start->nu) {
      p->fluid[i]     = (PetscReal)FluidOfViscosity(scene, x, start->nu[i]);
      p->interface[i] = INTERFACE_REACH * p->dx[i];
      if (p->share) p->share[i] = 1.0;
      continue;
    }
    p->fluid[i] = (PetscReal)SceneFluidAt(scene, x);
    if (p->share) {
      p->share[i] = SceneShare(scene, x, &other);
      p->other[i] = (PetscReal)other;
    }
    p->interface[i] = SceneInterface(scene, &points, x, INTERFACE_REACH * p->dx[i], normal);
    for (PetscInt a = 0; a < p->dim; a++) p->interface_normal[a][i] = normal[a];
  }
  PetscCall(InterfacePointsDestroy(&points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Removes the new wall particles on surfaces that are buried in another boundary. */
static PetscErrorCode LeaveBuriedWalls(const Scene *scene, Particles *p)
{
  const PetscInt own = ParticlesOwn(p);
  PetscInt       n   = 0;
  RecordColumns  columns;
  PetscReal     *record;

  PetscFunctionBegin;
  if (!scene->n_bodies || !SceneHas(scene, PHYSICS_WALLS)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(ParticlesRecordWidth(p), &record));
  PetscCall(RecordsBegin(p, &columns));
  for (PetscInt i = p->n_fluid; i < own; i++) {
    const PetscInt to              = p->n_fluid + n;
    PetscReal      x[ISPH_MAX_DIM] = {0.0};

    for (PetscInt a = 0; a < p->dim; a++) x[a] = p->x[a][i];
    if (p->depth[i] == 0.0 && SceneIsBuried(scene, (PetscInt)p->side[i], x)) continue;
    RecordPack(p, &columns, i, record);
    RecordUnpack(&columns, record, to);
    p->id[to]   = p->id[i];
    p->kind[to] = p->kind[i];
    n++;
  }
  PetscCall(RecordsEnd(&columns));
  PetscCall(PetscFree(record));
  p->n_wall = n;
  PetscCallMPI(MPI_Allreduce(&n, &p->N_wall, 1, MPIU_INT, MPI_SUM, p->comm));
  p->N_start[1] = p->N_wall;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns true if fluid is at x, in a filled region from `first` on and in none before it. */
static PetscBool IsFirst(const Scene *scene, PetscInt first, const PetscReal x[])
{
  PetscReal normal[ISPH_MAX_DIM];
  PetscInt  body;

  for (PetscInt k = 0; k < first; k++)
    if (SceneFilledDistance(scene, k, x) >= 0.0) return PETSC_FALSE;
  if (scene->n_filled && SceneFilledDistance(scene, first, x) < 0.0) return PETSC_FALSE;
  return SceneDistance(scene, x, &body, normal) > 0.0;
}

/* ParticlesExpect - Estimates the number of fluid particles at the start by the midpoint rule in
   the box around each filled region, or in that of the scene */
PetscReal ParticlesExpect(const Scene *scene)
{
  const PetscInt points = scene->dim == 2 ? 64 : 24;
  PetscReal      number = 0.0;

  for (PetscInt k = 0; k < PetscMax(scene->n_filled, 1); k++) {
    PetscReal span[ISPH_MAX_DIM][2], volume = 1.0;
    PetscInt  n = 1;

    for (PetscInt a = 0; a < scene->dim; a++) {
      span[a][0] = scene->lo[a];
      span[a][1] = scene->hi[a];
      if (scene->n_filled) BodySpan(&scene->filled[k], a, span[a]);
      span[a][0] = PetscMax(span[a][0], scene->lo[a]);
      span[a][1] = PetscMin(span[a][1], scene->hi[a]);
      volume *= PetscMax(span[a][1] - span[a][0], 0.0) / points;
      n *= points;
    }
    for (PetscInt q = 0; q < n; q++) {
      PetscReal x[ISPH_MAX_DIM] = {0.0};
      PetscInt  rest            = q;

      for (PetscInt a = 0; a < scene->dim; a++, rest /= points)
        x[a] = span[a][0] + (span[a][1] - span[a][0]) * (rest % points + 0.5) / points;
      if (IsFirst(scene, k, x)) number += volume / SceneVolumeAt(scene, x);
    }
  }
  return number;
}

/* Creates particles whose spacing is a function of place, or that do not fill the box. */
static PetscErrorCode CreateCloud(const Scene *scene, WallPlacement walls, Particles *p)
{
  Cloud cloud;

  PetscFunctionBegin;
  PetscCall(CloudFill(scene, walls, p, &cloud));
  PetscCall(LeaveBuriedWalls(scene, p));
  PetscCall(ParticlesUpdateEpoch(scene, p, PETSC_TRUE, NULL));
  if (cloud.relaxed) PetscCall(CloudRelax(scene, &cloud, p));
  PetscCall(CloudFinish(scene, &cloud, p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  ParticlesFill - Fills the box with fluid particles and its sides with wall particles

    x_j = lo + (j + 1/2) (hi - lo) / cells + jitter dx xi,  xi uniform in (-1, 1)^dim

  or, with -spacing_wall, at the places of SceneLatticePlace(); with isotropic grading at the places
  of CloudRelax(). Collective. Input: scene - the scene; walls - placement of wall particles for the
  wall treatment; ignored without PHYSICS_WALLS; start - given positions of the fluid; NULL: the
  fluid fills the lattice. Input/Output: p - in: empty, of ParticlesCreate(); out: the particles in
  their first epoch, with a filled halo; pressures are zero, velocities too unless start has
  velocities. Note: xi is a hash of (seed, id, axis) and does not depend on the number of ranks.
*/
PetscErrorCode ParticlesFill(const Scene *scene, WallPlacement walls, const FluidStart *start,
                             Particles *p)
{
  PetscFunctionBegin;
  if (scene->grading.on || (scene->n_filled && !start)) {
    PetscCall(CreateCloud(scene, walls, p));
  } else {
    PetscCall(LatticeFill(scene, walls, start, p));
    PetscCall(LeaveBuriedWalls(scene, p));
  }
  SetViscosities(scene, start, p);
  PetscCall(SetFluids(scene, start, p));
  PetscCall(ParticlesUpdateEpoch(scene, p, PETSC_TRUE, NULL));
  p->weight_start = p->weight_resized = p->weight;
  PetscFunctionReturn(PETSC_SUCCESS);
}
