/*
  Viscosities that follow the strain rate in the coupled scheme. With a given viscosity nu_m of each
  particle the system is linear. Its velocity has the viscosities nu(g(u)), and the residual of the
  iteration is f_m = log nu(g(u)) - log nu_m. The next viscosities follow by the secant method of
  two iterations, in the direction of least residual,

    log nu_{m+1} = log nu_m + f_m - a (log nu_m + f_m - log nu_{m-1} - f_{m-1}),
    a = f_m.(f_m - f_{m-1})/|f_m - f_{m-1}|^2

  Picard's iteration has a = 0. In a flow with given stresses it multiplies f by 1 - n for a power
  law of exponent n, and diverges for n > 2. The secant method finds 1/n as length of the step.

  Reference: D. G. Anderson, J. ACM 12 (1965) 547-560, with one earlier iteration
*/
#include "coupled.h"

#define LONGEST 4.0 /* largest |a| */

/* CoupledMixBegin - Prepares the iteration for the n_fluid particles of this rank; not
   collective */
PetscErrorCode CoupledMixBegin(PetscInt n, ViscosityMix *mix)
{
  PetscFunctionBegin;
  *mix = (ViscosityMix){.n = n};
  PetscCall(PetscMalloc3(n, &mix->given, n, &mix->followed, n, &mix->residual));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* CoupledMixEnd - Frees the iteration; not collective */
PetscErrorCode CoupledMixEnd(ViscosityMix *mix)
{
  PetscFunctionBegin;
  PetscCall(PetscFree3(mix->given, mix->followed, mix->residual));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes a, from the residuals log nu(g(u)) - log nu_m of this iteration and of the last. Input:
   nu - viscosities of the present velocity [m^2/s]. */
static PetscErrorCode MixFactor(const Particles *p, const ViscosityMix *mix, PetscReal *factor)
{
  PetscReal sum[2] = {0.0, 0.0};

  PetscFunctionBegin;
  *factor = 0.0;
  if (mix->iterations < 2) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt i = 0; i < mix->n; i++) {
    const PetscReal f = PetscLogReal(p->nu[i]) - mix->given[i], change = f - mix->residual[i];

    sum[0] += f * change;
    sum[1] += PetscSqr(change);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 2, MPIU_REAL, MPIU_SUM, p->comm));
  if (sum[1] > 0.0) *factor = PetscMin(PetscMax(sum[0] / sum[1], -LONGEST), LONGEST);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  CoupledFollowStrain - Computes the viscosities of the next iteration from a velocity, and updates
  the viscous operator

  Collective. Input: u - velocity components of the last iteration [m/s]. Output: viscosities of the
  particles [m^2/s]; wall velocities are those at the time of the solve. The first iteration takes
  the viscosities of u.
*/
PetscErrorCode CoupledFollowStrain(Flow *flow, const Vec u[], ViscosityMix *mix)
{
  const Rheology *law = &flow->scene->rheology;
  Particles      *p   = flow->particles;
  PetscReal       a;

  PetscFunctionBegin;
  PetscCall(OperatorsFollowStrain(flow->scene, p, &flow->walls, u, flow->ops));
  PetscCall(MixFactor(p, mix, &a));
  for (PetscInt i = 0; i < mix->n; i++) {
    const PetscReal followed = PetscLogReal(p->nu[i]);
    PetscReal       next     = followed;

    if (a != 0.0) next -= a * (followed - mix->followed[i]);
    if (mix->iterations > 0) mix->residual[i] = followed - mix->given[i];
    mix->followed[i] = followed;
    mix->given[i]    = next;
    if (a != 0.0) {
      p->nu[i]      = PetscMin(PetscMax(PetscExpReal(next), law->low), law->high);
      mix->given[i] = PetscLogReal(p->nu[i]);
    }
  }
  mix->iterations++;
  if (a == 0.0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ParticlesHaloField(p, p->nu));
  PetscCall(OperatorsScaleViscosity(flow->scene, p, flow->ops));
  PetscFunctionReturn(PETSC_SUCCESS);
}
