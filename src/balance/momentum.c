/*
  The momentum of a flow that conserves it. The rows of grad p, of the viscous term and of
  convection conserve momentum only to their truncation error, and so do the filter and the
  interpolation of velocities to shifted positions. The mean of their changes is therefore taken out
  of each step.

  The sum of V u over disordered particles is a poor integral of u: its error changes as particles
  move, and a flow that keeps this sum would be wrong. The integral is exact here for smooth fields.
*/
#include "isph/balance.h"

#define HARMONICS 3                   /* along each axis, in 2D; 2 in 3D */
#define MODES     (2 * HARMONICS + 1) /* 1, cos and sin of each harmonic */
#define TERMS     125                 /* at least MODES^2, 5^3 */

/* Computes the products psi_q of 1, sqrt(2) cos, sqrt(2) sin, ... along all axes at x; psi_0 = 1.
   Returns their number. */
static PetscInt SetModes(const Scene *scene, const PetscReal x[], PetscReal psi[])
{
  const PetscInt harmonics = scene->dim == 2 ? HARMONICS : HARMONICS - 1;
  PetscInt       n         = 1;

  psi[0] = 1.0;
  for (PetscInt a = 0; a < scene->dim; a++) {
    const PetscReal phase = 2.0 * PETSC_PI * (x[a] - scene->lo[a]) / (scene->hi[a] - scene->lo[a]);
    const PetscReal c = PetscCosReal(phase), s = PetscSinReal(phase);
    PetscReal       cosine = PETSC_SQRT2, sine = 0.0; /* of k phase, times sqrt(2) */
    const PetscInt  lower = n;

    for (PetscInt k = 1; k <= harmonics; k++) {
      const PetscReal turned = c * cosine - s * sine;

      sine   = s * cosine + c * sine;
      cosine = turned;
      for (PetscInt q = 0; q < lower; q++) psi[n++] = cosine * psi[q];
      for (PetscInt q = 0; q < lower; q++) psi[n++] = sine * psi[q];
    }
  }
  return n;
}

/* Adds weight psi_q to n sums. */
static ISPH_WIDE void AddModes(PetscInt n, PetscReal weight, const PetscReal psi[], PetscReal sum[])
{
  for (PetscInt q = 0; q < n; q++) sum[q] += weight * psi[q];
}

/*
  FlowMeanVelocity - Computes the mean of a velocity over a periodic box [m/s]

    mean = sum_i V_i w_i u_i/sum_i V_i w_i,   w_i = 1 - sum_q e_q psi_q(x_i),
    e_q  = sum_i V_i psi_q(x_i)/sum_i V_i

  Collective. psi_q are harmonics of the box, whose integrals vanish; e_q are the errors of their
  integrals by the volumes of particles. The mean is exact for a constant, and to first order in e_q
  for psi_q. On a lattice w_i is 1. See theory.md, (motion:mean). Input: u - components of the
  velocity at the particles [m/s].
*/
PetscErrorCode FlowMeanVelocity(const Flow *flow, const Vec u[], PetscReal mean[])
{
  const Scene       *scene = flow->scene;
  const Particles   *p     = flow->particles;
  const PetscScalar *value[ISPH_MAX_DIM];
  PetscReal          psi[TERMS], sum[(1 + ISPH_MAX_DIM) * TERMS] = {0.0};
  const PetscInt     n = SetModes(scene, scene->lo, psi);

  PetscFunctionBegin;
  for (PetscInt a = 0; a < scene->dim; a++) PetscCall(VecGetArrayRead(u[a], &value[a]));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    const PetscReal weight = ParticlesWeight(p, i);
    PetscReal       x[ISPH_MAX_DIM];

    for (PetscInt a = 0; a < scene->dim; a++) x[a] = p->x[a][i];
    SetModes(scene, x, psi);
    AddModes(n, weight, psi, sum);
    for (PetscInt a = 0; a < scene->dim; a++)
      AddModes(n, weight * PetscRealPart(value[a][i]), psi, &sum[(1 + a) * TERMS]);
  }
  for (PetscInt a = 0; a < scene->dim; a++) PetscCall(VecRestoreArrayRead(u[a], &value[a]));
  PetscCallMPI(
      MPI_Allreduce(MPI_IN_PLACE, sum, (1 + ISPH_MAX_DIM) * TERMS, MPIU_REAL, MPIU_SUM, p->comm));
  for (PetscInt a = 0; a < scene->dim; a++) {
    const PetscReal *product = &sum[(1 + a) * TERMS];
    PetscReal        weight  = p->weight;

    mean[a] = product[0];
    for (PetscInt q = 1; q < n; q++) {
      weight -= PetscSqr(sum[q]) / p->weight;
      mean[a] -= sum[q] * product[q] / p->weight;
    }
    mean[a] /= weight;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* MomentumKeep - Measures the mean velocity before a step, state->mean; collective */
PetscErrorCode MomentumKeep(Flow *flow)
{
  PetscFunctionBegin;
  PetscCall(FlowMeanVelocity(flow, flow->state->u, flow->state->mean));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* MomentumRestore - Shifts u^{n+1} of a flow that conserves its momentum to the mean velocity
   before the step, state->mean. Collective. The shift is uniform: it changes neither divergence nor
   vorticity. It is of the order of the truncation error of the rows. */
PetscErrorCode MomentumRestore(Flow *flow)
{
  const PetscReal *mean = flow->state->mean;
  PetscReal        now[ISPH_MAX_DIM];

  PetscFunctionBegin;
  PetscCall(FlowMeanVelocity(flow, flow->state->u_next, now));
  for (PetscInt a = 0; a < flow->scene->dim; a++)
    PetscCall(VecShift(flow->state->u_next[a], mean[a] - now[a]));
  PetscFunctionReturn(PETSC_SUCCESS);
}
