/*
  Forces of the fluid on walls in a weak form. The powers of stress and tension are sums over the
  velocities of particles, also of walls, and what multiplies the velocity of a wall
  particle is the force on it:

    F_w = -sum_c V_c 2 mu_c E_c g_cw - sigma sum_v N_w(y_v) dA/dy_v - dt sigma sum_j K_wj u_j

  As rows reproduce constants, these forces and those on the fluid sum to zero; as they reproduce
  linear functions, so do their torques about the wall points. See theory.md, (strain:force).
*/
#include "strain.h"

/* Adds the viscous forces of own cells at their present strains. */
static void AddViscous(const Particles *p, const StrainCells *s, PetscReal rho, PetscReal force[])
{
  const PetscInt d = p->dim;

  for (PetscInt c = 0; c < s->all; c++) {
    PetscReal x[ISPH_MAX_DIM];

    if (!StrainHasCell(p, s, c, x)) continue;
    for (PetscInt a = 0; a < d; a++) {
      const PetscInt q = s->sets == 1 ? 0 : a;

      for (PetscInt e = s->first[q][c]; e < s->first[q][c + 1]; e++) {
        const PetscInt j   = s->j[q][e];
        PetscReal      sum = 0.0;

        for (PetscInt b = 0; b < d; b++) sum += s->strain[(c * d + a) * d + b] * s->g[q][b][e];
        force[d * j + a] -= 2.0 * rho * s->nu[c] * s->volume[c] * sum;
      }
    }
  }
}

/*
  StrainForces - Adds the forces of viscosity and tension of own cells on wall particles

  Collective. Input: u - velocity components over the fluid; walls have their present ones; dt - of
  the step that changed the surface [s]. Input/Output: force - component
  a on particle j at [j dim + a], by local index [N].
*/
PetscErrorCode StrainForces(const Scene *scene, const Particles *p, const Vec u[], PetscReal dt,
                            StrainCells *s, PetscReal force[])
{
  PetscReal *value[ISPH_MAX_DIM];

  PetscFunctionBegin;
  for (PetscInt a = 0; a < p->dim; a++) {
    PetscCall(PetscMalloc1(ParticlesAll(p), &value[a]));
    PetscCall(LocalValues(p, u[a], NULL, 1, value[a]));
    PetscCall(PetscArraycpy(value[a] + p->n_fluid, p->u[a] + p->n_fluid, p->n_wall));
    PetscCall(ParticlesHaloField(p, value[a]));
  }
  PetscCall(StrainOfValues(p, value, s));
  AddViscous(p, s, scene->rho, force);
  StrainTensionOnWalls(scene, p, s, value, dt, force);
  for (PetscInt a = 0; a < p->dim; a++) PetscCall(PetscFree(value[a]));
  PetscFunctionReturn(PETSC_SUCCESS);
}
