/* Sizes of particles that move through places of different spacing. */
#include "impl.h"

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
  the volume of the fluid; weight_found is the weight without it. Wall particles keep their sizes.
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
  PetscCallMPI(MPI_Allreduce(&sum, &p->weight_found, 1, MPIU_REAL, MPIU_SUM, p->comm));
  for (PetscInt i = 0; i < ParticlesAll(p); i++)
    if (!ParticlesIsWall(p, i)) p->volume[i] *= p->weight_start / p->weight_found;
  p->weight = p->weight_start;
  PetscFunctionReturn(PETSC_SUCCESS);
}
