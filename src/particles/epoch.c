/* Epochs: the criterion for the end of an epoch, and the work at the start of the next epoch. */
#include "impl.h"

/* ParticlesLargestMove - Computes the largest displacement of a particle on any rank [m].
   Collective. Input: from - earlier positions of own particles [m]. Output: move - PETSC_MAX_REAL
   if a position is not a finite number. */
PetscErrorCode ParticlesLargestMove(const Particles *p, PetscReal *const from[], PetscReal *move)
{
  PetscReal largest = 0.0;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < ParticlesOwn(p); i++) {
    PetscReal d2 = 0.0;

    for (PetscInt a = 0; a < p->dim; a++) d2 += PetscSqr(p->x[a][i] - from[a][i]);
    if (!(d2 <= largest)) largest = PetscIsInfOrNanReal(d2) ? PETSC_MAX_REAL : d2;
  }
  PetscCallMPI(MPI_Allreduce(&largest, move, 1, MPIU_REAL, MPIU_MAX, p->comm));
  if (*move < PETSC_MAX_REAL) *move = PetscSqrtReal(*move);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode WrapPeriodic(const Scene *scene, Particles *p)
{
  PetscFunctionBegin;
  for (PetscInt a = 0; a < p->dim; a++) {
    const PetscReal lo = scene->lo[a], hi = scene->hi[a], period = hi - lo;
    PetscReal      *x = p->x[a];

    if (!SceneIsPeriodic(scene, a)) continue;
    for (PetscInt i = 0; i < ParticlesOwn(p); i++) {
      if (x[i] >= lo && x[i] < hi) continue;
      x[i] -= period * PetscFloorReal((x[i] - lo) / period);
      if (!(x[i] >= lo && x[i] < hi)) x[i] = lo; /* rounding */
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  ParticlesUpdateEpoch - Starts a new epoch if a particle has moved by half of the skin

    max_i |x_i - x_i(epoch)| >= skin / 2

  Collective. Input: scene - the scene; particles - the particles, with new positions of own
  particles; force - true: starts an epoch in any case; the same on all ranks. Output: started -
  true if an epoch started; may be NULL. Notes: At the start of an epoch, positions are wrapped into
  periodic boxes, particles migrate with all registered fields, are sorted and get new numbers, and
  the halo is rebuilt. Otherwise nothing changes: then call ParticlesUpdateHalo(). Two particles
  that come closer than halo_width during the epoch were closer than halo_width + skin at its start,
  so the halos hold every such pair. Error: PETSC_ERR_FP if a position is not finite
*/
PetscErrorCode ParticlesUpdateEpoch(const Scene *scene, Particles *particles, PetscBool force,
                                    PetscBool *started)
{
  Particles *p = particles;
  PetscReal  move;
  PetscInt  *owner;
  PetscBool  due;

  PetscFunctionBegin;
  PetscCall(ParticlesLargestMove(p, p->x_epoch, &move));
  PetscCheck(move < PETSC_MAX_REAL, p->comm, PETSC_ERR_FP,
             "The flow diverged: the position of a particle is not a finite number");
  due = force || (move > 0.0 && move >= 0.5 * p->skin);
  if (started) *started = due;
  if (!due) PetscFunctionReturn(PETSC_SUCCESS);

  PetscCall(WrapPeriodic(scene, p));
  PetscCall(PetscMalloc1(ParticlesOwn(p), &owner));
  PetscCall(ParticlesDecompose(scene, p, owner));
  PetscCall(ParticlesMigrate(scene, p, owner));
  PetscCall(PetscFree(owner));
  for (PetscInt a = 0; a < p->dim; a++) {
    PetscCall(PetscArraycpy(p->x_epoch[a], p->x[a], ParticlesOwn(p)));
  }
  PetscCall(HaloBuild(scene, p));
  p->epoch++;
  PetscFunctionReturn(PETSC_SUCCESS);
}
