/*
  Collisions of fragments. On a rough surface no equation of mass keeps particles apart, and two
  that come close spoil the fits about them. A pair within CONTACT dx of which one is rough or
  isolated therefore loses the velocity at which it approaches,

    u_i += e min(0, e.(u_j - u_i))/2,   e = (x_j - x_i)/r,

  as two equal bodies in an inelastic collision. Momentum and angular momentum stay, and energy does
  not grow.

  Reference: S. Koshizuka, Y. Oka, Nucl. Sci. Eng. 123 (1996) 421-434, there for all particles
*/
#include "step.h"

#define CONTACT 0.7 /* distance of centres [dx] */

/* Computes the change of the velocity of own particle i; u: of all particles, by [i dim + a]. */
static void Collide(const Flow *flow, const PetscReal u[], PetscInt i, PetscReal change[])
{
  const Particles *p     = flow->particles;
  const Neighbors *nb    = flow->neighbors;
  const PetscBool  rough = FreeSurfaceIsRough(flow->ops->free, i);
  const PetscInt   d     = p->dim;

  for (PetscInt q = nb->row[i]; q < nb->row[i + 1]; q++) {
    const PetscInt j  = nb->col[q];
    PetscReal      r2 = 0.0, approach = 0.0, X[ISPH_MAX_DIM];

    if (ParticlesIsWall(p, j) || !(rough || FreeSurfaceIsRough(flow->ops->free, j))) continue;
    for (PetscInt a = 0; a < d; a++) {
      X[a] = p->x[a][j] - p->x[a][i];
      r2 += PetscSqr(X[a]);
      approach += X[a] * (u[j * d + a] - u[i * d + a]);
    }
    if (r2 == 0.0 || r2 >= PetscSqr(CONTACT * p->dx[i]) || approach >= 0.0) continue;
    for (PetscInt a = 0; a < d; a++) change[a] += 0.5 * approach / r2 * X[a];
  }
}

/* FlowCollide - Changes the new velocity u_next by collisions of fragments; nothing without free
   surfaces; collective */
PetscErrorCode FlowCollide(Flow *flow)
{
  const Particles *p = flow->particles;
  const PetscInt   d = p->dim;
  PetscScalar     *v[ISPH_MAX_DIM];
  PetscReal       *u;

  PetscFunctionBegin;
  if (!flow->ops->free || !SceneMoves(flow->scene)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(ParticlesAll(p) * d, &u));
  for (PetscInt a = 0; a < d; a++) PetscCall(VecGetArray(flow->state->u_next[a], &v[a]));
  for (PetscInt i = 0; i < p->n_fluid; i++)
    for (PetscInt a = 0; a < d; a++) u[i * d + a] = v[a][i];
  PetscCall(ParticlesHaloVectors(p, u));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscReal change[ISPH_MAX_DIM] = {0.0};

    Collide(flow, u, i, change);
    for (PetscInt a = 0; a < d; a++) v[a][i] += change[a];
  }
  for (PetscInt a = 0; a < d; a++) PetscCall(VecRestoreArray(flow->state->u_next[a], &v[a]));
  PetscCall(PetscFree(u));
  PetscFunctionReturn(PETSC_SUCCESS);
}
