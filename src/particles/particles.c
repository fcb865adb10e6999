/* Creation and destruction of particles, their sizes, and random numbers by their ids. Every array
   with values of particles is a registered field, so that migration and sorting treat all arrays
   alike. */
#include "impl.h"

static const OptionRow options[] = {
    OPTION(REAL, "-skin",
           "width of the halo beyond the interaction radius; an epoch ends when displacements have "
           "used it up",
           "dx", "4", .expert = PETSC_TRUE, .low = 0.0, .high = 100.0),
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
  if (SceneFluids(scene) > 1) {
    PetscCall(ParticlesRegister(p, "fluid", 1, HALO_EPOCH, ENTRY_NEAREST, &p->fluid));
    PetscCall(ParticlesRegister(p, "interface", 1, HALO_EPOCH, ENTRY_NEAREST, &p->interface));
    PetscCall(ParticlesRegister(p, "interface_normal", p->dim, HALO_EPOCH, ENTRY_NEAREST,
                                p->interface_normal));
  }
  if (SceneMixes(scene) || (SceneFluids(scene) > 1 && SceneHasFreeSurface(scene))) {
    PetscCall(ParticlesRegister(p, "share", 1, HALO_EPOCH, ENTRY_NEAREST, &p->share));
    PetscCall(ParticlesRegister(p, "other", 1, HALO_EPOCH, ENTRY_NEAREST, &p->other));
  }
  if (SceneHas(scene, PHYSICS_WALLS)) {
    PetscCall(ParticlesRegister(p, "normal", p->dim, HALO_EPOCH, ENTRY_ZERO, p->normal));
    PetscCall(ParticlesRegister(p, "depth", 1, HALO_EPOCH, ENTRY_ZERO, &p->depth));
    PetscCall(ParticlesRegister(p, "side", 1, HALO_EPOCH, ENTRY_ZERO, &p->side));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ParticlesCreate - Creates an empty set of particles with its fields; ParticlesFill() fills it.
   Collective on PETSC_COMM_WORLD. Input: scene - the scene; halo_width - largest interaction radius
   of any operator [m]. */
PetscErrorCode ParticlesCreate(const Scene *scene, PetscReal halo_width, Particles **particles)
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

  *particles = p;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ParticlesDestroy - Frees the particles and the arrays of all registered fields. Collective. */
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
  PetscCall(FreeAll(&p->id, &p->kind, &p->row));
  PetscCall(PetscFree2(p->cut_axis, p->cut));
  PetscCall(PetscSFDestroy(&p->sf));
  PetscCallMPI(MPI_Type_free(&p->vector));
  PetscCall(PetscFree(*particles));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets spacing, stretch and volume of local particle i for its place. */
static void Resize(const Scene *scene, Particles *p, PetscInt i)
{
  PetscReal x[ISPH_MAX_DIM] = {0.0}, stretch[ISPH_MAX_DIM];

  for (PetscInt a = 0; a < p->dim; a++) x[a] = p->x[a][i];
  SceneSizes(scene, x, &p->dx[i], stretch, &p->volume[i]);
  for (PetscInt a = 0; a < p->dim; a++)
    if (p->stretch[a]) p->stretch[a][i] = stretch[a];
}

/*
  ParticlesResize - Sets the sizes of all local fluid particles for their present places

    V_i = (sum V at the start/sum_j SceneVolumeAt(x_j)) SceneVolumeAt(x_i)

  Collective. Sets spacing, stretch and volume of own particles and of the halo. The factor keeps
  the volume of the fluid; weight_resized is the weight without it. Wall particles keep their sizes.
*/
PetscErrorCode ParticlesResize(const Scene *scene, Particles *p)
{
  PetscReal sum = 0.0;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < ParticlesAll(p); i++) {
    if (ParticlesIsWall(p, i)) continue;
    Resize(scene, p, i);
    if (i < p->n_fluid) sum += ParticlesWeight(p, i);
  }
  PetscCallMPI(MPI_Allreduce(&sum, &p->weight_resized, 1, MPIU_REAL, MPIU_SUM, p->comm));
  for (PetscInt i = 0; i < ParticlesAll(p); i++)
    if (!ParticlesIsWall(p, i)) p->volume[i] *= p->weight_start / p->weight_resized;
  p->weight = p->weight_start;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ParticlesHash - Returns a number in (-1, 1) that depends on its arguments only, not on ranks or
   order. It applies the finaliser of SplitMix64 twice. Input: axis - less than 4. Reference: G. L.
   Steele, D. Lea, C. H. Flood, OOPSLA 2014. */
PetscReal ParticlesHash(PetscInt seed, PetscInt64 id, PetscInt axis)
{
  uint64_t z = (uint64_t)seed * 0xD1342543DE82EF95u + (uint64_t)id * 4u + (uint64_t)axis;

  for (int round = 0; round < 2; round++) {
    z += 0x9E3779B97F4A7C15u;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    z ^= z >> 31;
  }
  return 2.0 * (((PetscReal)(z >> 11) + 0.5) / 9007199254740992.0) - 1.0;
}

/* ParticlesShare - Computes the range [first, last) of this rank among n items */
void ParticlesShare(MPI_Comm comm, PetscInt n, PetscInt *first, PetscInt *last)
{
  PetscMPIInt rank = 0, ranks = 1;

  (void)MPI_Comm_rank(comm, &rank);
  (void)MPI_Comm_size(comm, &ranks);
  *first = (PetscInt)((PetscInt64)n * rank / ranks);
  *last  = (PetscInt)((PetscInt64)n * (rank + 1) / ranks);
}
