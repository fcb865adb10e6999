/*
  Creation and destruction of the particles of a run. Every array with values of particles is a
  registered field, so that migration and sorting treat all arrays alike.
*/
#include "impl.h"

static const OptionRow options[] = {
    {
        .name     = "-skin",
        .kind     = VALUE_REAL,
        .brief    = "width of the halo beyond the interaction radius; an epoch ends when "
                    "displacements have used "
                    "it up",
        .unit     = "dx",
        .standard = "4",
        .low      = 0.0,
        .high     = 100.0,
    },
};
const OptionTable ParticleOptions = OPTIONS("Particles", options);

static PetscErrorCode RegisterOwnFields(const Scene *scene, Particles *p)
{
  PetscFunctionBegin;
  PetscCall(ParticlesRegister(p, "x", p->dim, HALO_NONE, ENTRY_POSITION, p->x));
  PetscCall(ParticlesRegister(p, "u", p->dim, HALO_NONE, ENTRY_MEAN, p->u));
  PetscCall(ParticlesRegister(p, "x_epoch", p->dim, HALO_NONE, ENTRY_POSITION, p->x_epoch));
  PetscCall(ParticlesRegister(p, "dx", 1, HALO_EPOCH, ENTRY_SPACING, &p->dx));
  PetscCall(ParticlesRegister(p, "volume", 1, HALO_EPOCH, ENTRY_VOLUME, &p->volume));
  if (SceneIsMapped(scene))
    PetscCall(ParticlesRegister(p, "stretch", p->dim, HALO_EPOCH, ENTRY_STRETCH, p->stretch));
  if (SceneHas(scene, PHYSICS_PRESSURE)) {
    PetscCall(ParticlesRegister(p, "p", 1, HALO_NONE, ENTRY_MEAN, &p->p));
  }
  if (SceneViscosityVaries(scene))
    PetscCall(ParticlesRegister(p, "viscosity", 1, HALO_EPOCH, ENTRY_MEAN, &p->nu));
  if (SceneHas(scene, PHYSICS_WALLS)) {
    PetscCall(ParticlesRegister(p, "normal", p->dim, HALO_EPOCH, ENTRY_ZERO, p->normal));
    PetscCall(ParticlesRegister(p, "depth", 1, HALO_EPOCH, ENTRY_ZERO, &p->depth));
    PetscCall(ParticlesRegister(p, "side", 1, HALO_EPOCH, ENTRY_ZERO, &p->side));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the viscosities of fluid: given values, or SceneViscosity() at the positions. */
static void SetViscosities(const Scene *scene, const FluidStart *start, Particles *p)
{
  for (PetscInt i = 0; p->nu && i < p->n_fluid; i++) {
    PetscReal x[ISPH_MAX_DIM];

    for (PetscInt a = 0; a < p->dim; a++) x[a] = p->x[a][i];
    p->nu[i] = start && start->nu ? start->nu[i] : SceneViscosity(scene, x);
  }
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
  ParticlesCreate - Fills the box with fluid particles and its sides with wall particles

    x_j = lo + (j + 1/2) (hi - lo) / cells + jitter dx xi,  xi uniform in (-1, 1)^dim

  or, with -spacing_wall, at the places of SceneLatticePlace(); with isotropic grading at the places
  of CloudRelax().

  Collective on PETSC_COMM_WORLD

  Input Parameters:
+ scene      - the scene
. walls      - placement of wall particles for the wall treatment; ignored without PHYSICS_WALLS
. halo_width - largest interaction radius of any operator [m]
- start      - given positions of the fluid; NULL: the fluid fills the lattice

  Output Parameter:
. particles - the particles in their first epoch, with a filled halo; pressures are zero, velocities
              too unless start has velocities

  Options Database Key:
. -skin <4> - width of the halo beyond halo_width; half of it is the largest displacement within an
              epoch [dx]

  Note: xi is a hash of (seed, id, axis) and does not depend on the number of ranks.
*/
PetscErrorCode ParticlesCreate(const Scene *scene, WallPlacement walls, PetscReal halo_width,
                               const FluidStart *start, Particles **particles)
{
  Particles  *p;
  PetscReal   skin;
  PetscMPIInt ranks;

  PetscFunctionBegin;
  PetscCheck(halo_width > 0.0, PETSC_COMM_WORLD, PETSC_ERR_ARG_OUTOFRANGE,
             "halo_width = %g, must be positive", (double)halo_width);
  PetscCall(OptionGetReal(&options[0], &skin, NULL));

  PetscCall(PetscNew(&p));
  p->comm        = PETSC_COMM_WORLD;
  p->dim         = scene->dim;
  p->halo_width  = halo_width;
  p->cell_volume = SceneVolume(scene);
  p->skin        = skin * scene->dx;
  PetscCallMPI(MPI_Comm_size(p->comm, &ranks));
  PetscCall(PetscCalloc2(ranks, &p->cut_axis, ranks, &p->cut));
  PetscCall(PetscSFCreate(p->comm, &p->sf));
  PetscCallMPI(MPI_Type_contiguous(p->dim, MPIU_REAL, &p->vector));
  PetscCallMPI(MPI_Type_commit(&p->vector));
  PetscCall(RegisterOwnFields(scene, p));

  if (scene->grading.on || (scene->n_filled && !start)) {
    PetscCall(CreateCloud(scene, walls, p));
  } else {
    PetscCall(LatticeFill(scene, walls, start, p));
    PetscCall(LeaveBuriedWalls(scene, p));
  }
  SetViscosities(scene, start, p);
  PetscCall(ParticlesUpdateEpoch(scene, p, PETSC_TRUE, NULL));
  p->weight_start = p->weight_found = p->weight;
  *particles                        = p;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  ParticlesDestroy - Frees the particles and the arrays of all registered fields

  Collective
*/
PetscErrorCode ParticlesDestroy(Particles **particles)
{
  Particles *p = *particles;

  PetscFunctionBegin;
  if (!p) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt f = 0; f < p->n_fields; f++) {
    for (PetscInt c = 0; c < p->field[f].components; c++) {
      PetscCall(PetscFree(p->field[f].slot[c]));
    }
  }
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) PetscCall(PetscFree(p->halo_shift[a]));
  PetscCall(PetscFree(p->id));
  PetscCall(PetscFree(p->kind));
  PetscCall(PetscFree(p->row));
  PetscCall(PetscFree2(p->cut_axis, p->cut));
  PetscCall(PetscSFDestroy(&p->sf));
  PetscCallMPI(MPI_Type_free(&p->vector));
  PetscCall(PetscFree(*particles));
  PetscFunctionReturn(PETSC_SUCCESS);
}
