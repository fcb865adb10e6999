/*
  Viscosities that follow the strain rate in the coupled scheme. With a given viscosity nu_m of each
  particle the system is linear. Its velocity has the viscosities nu(g(u)), and the residual of the
  iteration is f_m = log nu(g(u)) - log nu_m. The next viscosities follow from the changes d in
  earlier iterations s, with the combination of least residual,

    log nu_{m+1} = log nu_m + f_m - sum_s a_s (d(log nu)_s + df_s),
    a: |f_m - sum_s a_s df_s| is least

  Picard's iteration has a = 0. In a flow with given stresses it multiplies f by 1 - n for a power
  law of exponent n, and diverges for n > 2. One earlier iteration finds 1/n as length of the step.
  Particles whose viscosity is at a bound can go round in circles with one, and do not with five.

  Reference: D. G. Anderson, J. ACM 12 (1965) 547-560
*/
#include "coupled.h"

#define RIDGE 1e-12 /* of the normal equations of a, over their trace */

/* CoupledMixBegin - Prepares the iteration for the n particles of this rank whose viscosity follows
   the strain rate; not collective */
PetscErrorCode CoupledMixBegin(PetscInt n, ViscosityMix *mix)
{
  PetscFunctionBegin;
  *mix = (ViscosityMix){.n = n};
  PetscCall(PetscMalloc3(n, &mix->given, n, &mix->followed, n, &mix->residual));
  for (PetscInt s = 0; s < MIX_DEPTH; s++)
    PetscCall(PetscMalloc2(n, &mix->moved[s], n, &mix->fell[s]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* CoupledMixEnd - Frees the iteration; not collective */
PetscErrorCode CoupledMixEnd(ViscosityMix *mix)
{
  PetscFunctionBegin;
  PetscCall(PetscFree3(mix->given, mix->followed, mix->residual));
  for (PetscInt s = 0; s < MIX_DEPTH; s++) PetscCall(PetscFree2(mix->moved[s], mix->fell[s]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Keeps the residual of the present velocity, whose viscosities are nu [m^2/s], and its change in
   the place of the oldest one. The first viscosities belong to a given velocity and have none. */
static void KeepResidual(const PetscReal nu[], ViscosityMix *mix)
{
  const PetscInt changes = PetscMax(mix->iterations - 1, 0), s = (changes - 1) % MIX_DEPTH;

  mix->kept = PetscMin(changes, MIX_DEPTH);
  for (PetscInt i = 0; i < mix->n; i++) {
    const PetscReal followed = PetscLogReal(nu[i]);

    if (mix->iterations > 0) {
      const PetscReal f = followed - mix->given[i];

      if (changes) mix->fell[s][i] = f - mix->residual[i];
      if (changes) mix->moved[s][i] = followed - mix->followed[i];
      mix->residual[i] = f;
    }
    mix->followed[i] = followed;
  }
  mix->iterations++;
}

static PetscReal Product(PetscInt n, const PetscReal a[], const PetscReal b[])
{
  PetscReal sum = 0.0;

  for (PetscInt i = 0; i < n; i++) sum += a[i] * b[i];
  return sum;
}

/* Computes a from the changes that are kept, by the normal equations. */
static PetscErrorCode MixFactors(MPI_Comm comm, const ViscosityMix *mix, PetscReal a[])
{
  const PetscInt k = mix->kept;
  PetscReal      sums[MIX_DEPTH * (MIX_DEPTH + 1)], factor[MIX_DEPTH * MIX_DEPTH];
  PetscMPIInt    n;

  PetscFunctionBegin;
  for (PetscInt s = 0; s < k; s++) {
    for (PetscInt t = 0; t <= s; t++)
      sums[s * k + t] = sums[t * k + s] = Product(mix->n, mix->fell[s], mix->fell[t]);
    sums[k * k + s] = Product(mix->n, mix->fell[s], mix->residual);
  }
  PetscCall(PetscMPIIntCast(k * (k + 1), &n));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sums, n, MPIU_REAL, MPIU_SUM, comm));
  for (PetscInt s = 0; s < k; s++) a[s] = sums[k * k + s];
  DenseCholeskyRidge(k, sums, RIDGE, factor);
  DenseCholeskySolve(k, factor, a);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns nu_{m+1} of particle i [m^2/s]. */
static PetscReal MixedViscosity(const Rheology *law, const ViscosityMix *mix, const PetscReal a[],
                                PetscInt i)
{
  PetscReal next = mix->followed[i];

  for (PetscInt s = 0; s < mix->kept; s++) next -= a[s] * mix->moved[s][i];
  return PetscMin(PetscMax(PetscExpReal(next), law->low), law->high);
}

/*
  CoupledFollowStrain - Computes the viscosities of the next iteration from a velocity, and updates
  the viscous operator

  Collective. Input: u - velocity components of the last iteration [m/s]. Output: viscosities of the
  particles [m^2/s]; wall velocities are those at the time of the solve. The first two iterations
  take the viscosities of u.
*/
PetscErrorCode CoupledFollowStrain(Flow *flow, const Vec u[], ViscosityMix *mix)
{
  Particles *p = flow->particles;
  PetscReal  a[MIX_DEPTH];

  PetscFunctionBegin;
  PetscCall(OperatorsFollowStrain(flow->scene, p, &flow->walls, u, flow->ops));
  KeepResidual(p->nu, mix);
  if (!mix->kept) {
    PetscCall(PetscArraycpy(mix->given, mix->followed, mix->n));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MixFactors(p->comm, mix, a));
  for (PetscInt i = 0; i < mix->n; i++) {
    p->nu[i]      = MixedViscosity(&flow->scene->rheology, mix, a, i);
    mix->given[i] = PetscLogReal(p->nu[i]);
  }
  PetscCall(ParticlesHaloField(p, p->nu));
  PetscCall(OperatorsScaleViscosity(flow->scene, p, flow->ops));
  PetscFunctionReturn(PETSC_SUCCESS);
}
