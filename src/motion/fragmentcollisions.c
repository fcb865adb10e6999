/*
  Collisions of fragments. On a rough surface no equation of mass keeps particles apart, and two
  that come close spoil the fits about them. A pair within CONTACT dx of which one is rough or
  isolated therefore loses the velocity at which it approaches,

    u_i += V_j/(V_i + V_j) e min(0, e.(u_j - u_i)),   e = (x_j - x_i)/r,

  as two bodies in an inelastic collision. Momentum and angular momentum stay, and energy does not
  grow. Pairs that are nearer than that are moved apart: in the nose of a current on a wall
  particles would pile up, and two in one place are lost when they become smooth again. See
  theory.md, (surface:collision) and (surface:apart).

  Reference: S. Koshizuka, Y. Oka, Nucl. Sci. Eng. 123 (1996) 421-434, there for all particles
*/
#include "isph/motion.h"

#define CONTACT 0.7 /* distance of centres [dx] */

/* Computes the change of the velocity of own particle i; u: of all particles, by [i dim + a]. */
static void Collide(const Flow *flow, const PetscReal u[], PetscInt i, PetscReal change[])
{
  const Particles *p     = flow->particles;
  const Neighbors *nb    = flow->neighbors;
  const PetscBool  rough = FreeSurfaceIsRough(flow->ops->free, i);
  const PetscReal *V     = p->volume;
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
    for (PetscInt a = 0; a < d; a++) change[a] += V[j] / (V[i] + V[j]) * approach / r2 * X[a];
  }
}

/* Adds half of the displacement that brings each pair of rough particle i and a fluid particle
   nearer than CONTACT dx to this distance. */
static void Separate(const Particles *p, const Neighbors *nb, PetscInt i, PetscReal apart[])
{
  for (PetscInt q = nb->row[i]; q < nb->row[i + 1]; q++) {
    const PetscInt j  = nb->col[q];
    PetscReal      r2 = 0.0, share, X[ISPH_MAX_DIM];

    if (ParticlesIsWall(p, j)) continue;
    for (PetscInt a = 0; a < p->dim; a++) {
      X[a] = p->x[a][j] - p->x[a][i];
      r2 += PetscSqr(X[a]);
    }
    if (r2 == 0.0 || r2 >= PetscSqr(CONTACT * p->dx[i])) continue;
    share = 0.5 * (CONTACT * p->dx[i] / PetscSqrtReal(r2) - 1.0);
    for (PetscInt a = 0; a < p->dim; a++) apart[a] -= share * X[a];
  }
}

/*
  FlowSeparate - Computes displacements that bring rough particles and their neighbours to the
  distance CONTACT dx

    s_i = -sum_j e (CONTACT dx - r)/2,   e = (x_j - x_i)/r

  Input: neighbours at the present positions. Output: apart - of own particles, by [i dim + a], zero
  for those that are not rough [m].
*/
void FlowSeparate(const Flow *flow, PetscReal apart[])
{
  const Particles *p = flow->particles;

  for (PetscInt i = 0; i < p->n_fluid; i++) {
    for (PetscInt a = 0; a < p->dim; a++) apart[i * p->dim + a] = 0.0;
    if (flow->ops->free->kind[i] == SURFACE_ROUGH)
      Separate(p, flow->neighbors, i, &apart[i * p->dim]);
  }
}

/* FlowCollide - Changes the new velocity u_next by collisions of fragments of a free surface that
   moves; nothing without rough particles; collective */
PetscErrorCode FlowCollide(Flow *flow)
{
  const Particles *p = flow->particles;
  const PetscInt   d = p->dim;
  PetscScalar     *v[ISPH_MAX_DIM];
  PetscReal       *u;

  PetscFunctionBegin;
  if (!flow->ops->free->has_rough) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FlowAllVelocities(flow, flow->state->u_next, &u));
  for (PetscInt a = 0; a < d; a++) PetscCall(VecGetArray(flow->state->u_next[a], &v[a]));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscReal change[ISPH_MAX_DIM] = {0.0};

    Collide(flow, u, i, change);
    for (PetscInt a = 0; a < d; a++) v[a][i] += change[a];
  }
  for (PetscInt a = 0; a < d; a++) PetscCall(VecRestoreArray(flow->state->u_next[a], &v[a]));
  PetscCall(PetscFree(u));
  PetscFunctionReturn(PETSC_SUCCESS);
}
