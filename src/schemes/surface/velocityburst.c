/* Bursts. Viscous rows beside a free surface are those of fits, which are not symmetric. If few
   particles determine them, as in noses, their matrix may be nearly singular: a flow of a few
   particles hardly dissipates, and a step of any length drives it to a multiple of the largest
   speed. Pair forces dissipate in any arrangement of particles. A step with a burst is therefore
   solved again with pair forces about the particles that burst. See theory.md, (surface:burst). */
#include "surface.h"

#define BURST  4.0  /* change of a velocity in a burst over the largest speed before [-] */
#define REST   1e-6 /* speed of a fluid at rest [U] */
#define SHARE  0.2  /* of the largest change, from which on a particle is a part of the burst [-] */
#define ABOUT  2.2  /* distance from these within which particles get pair forces [dx] */
#define CALMER 0.5  /* ratio to the change before at which pair forces have ended a burst [-] */
#define MOST   3    /* largest number of solves with pair forces */

/* Changes of the velocity in a step. */
typedef struct {
  PetscReal *change;           /* of particles [m/s] */
  PetscReal  fastest, largest; /* largest speed before; largest change of a particle with a fit */
} Changes;

/* Computes the changes in the step that was solved. Rough particles have pair forces anyway; their
   changes do not tell a burst, as those that a wall stops fall onto it again in each step. */
static PetscErrorCode MeasureChanges(const Flow *flow, Changes *c)
{
  const FlowState   *s      = flow->state;
  const PetscInt     d      = flow->scene->dim;
  PetscReal          most[] = {REST * flow->scene->speed, 0.0};
  const PetscScalar *u[ISPH_MAX_DIM], *next[ISPH_MAX_DIM];

  PetscFunctionBegin;
  for (PetscInt a = 0; a < d; a++) PetscCall(VecGetArrayRead(s->u[a], &u[a]));
  for (PetscInt a = 0; a < d; a++) PetscCall(VecGetArrayRead(s->u_next[a], &next[a]));
  for (PetscInt i = 0; i < flow->particles->n_fluid; i++) {
    PetscReal before = 0.0, change = 0.0;

    for (PetscInt a = 0; a < d; a++) {
      before += PetscSqr(u[a][i]);
      change += PetscSqr(next[a][i] - u[a][i]);
    }
    c->change[i] = PetscSqrtReal(change);
    most[0]      = PetscMax(most[0], PetscSqrtReal(before));
    if (!FreeSurfaceIsRough(flow->ops->free, i)) most[1] = PetscMax(most[1], c->change[i]);
  }
  for (PetscInt a = 0; a < d; a++) PetscCall(VecRestoreArrayRead(s->u_next[a], &next[a]));
  for (PetscInt a = 0; a < d; a++) PetscCall(VecRestoreArrayRead(s->u[a], &u[a]));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, most, 2, MPIU_REAL, MPIU_MAX, flow->particles->comm));
  c->fastest = most[0];
  c->largest = most[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns true if neighbour j of own particle i is a part of the burst and near it. */
static PetscBool IsNear(const Particles *p, const PetscReal bursts[], PetscInt i, PetscInt j)
{
  if (ParticlesIsWall(p, j) || bursts[j] == 0.0) return PETSC_FALSE;
  return ParticlesSquareDistance(p, i, j) < PetscSqr(ABOUT * p->dx[i]);
}

/* Gives pair forces to the particles of the burst and to those near them, besides those that have
   them already. */
static PetscErrorCode AddPairs(Flow *flow, const Changes *c)
{
  const Particles *p    = flow->particles;
  const Neighbors *nb   = flow->neighbors;
  FreeSurface     *free = flow->ops->free;
  PetscReal       *bursts;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(ParticlesAll(p), &bursts));
  for (PetscInt i = 0; i < p->n_fluid; i++)
    bursts[i] = c->change[i] > SHARE * c->largest ? 1.0 : 0.0;
  PetscCall(ParticlesHaloField(p, bursts));
  if (!free->has_pair_forces) PetscCall(PetscCalloc1(p->n_fluid + 1, &free->has_pair_forces));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    if (bursts[i] > 0.0) free->has_pair_forces[i] = 1.0;
    for (PetscInt q = nb->row[i]; q < nb->row[i + 1] && free->has_pair_forces[i] == 0.0; q++)
      if (IsNear(p, bursts, i, nb->col[q])) free->has_pair_forces[i] = 1.0;
  }
  PetscCall(PetscFree(bursts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Assembles the matrices with the present pair forces. */
static PetscErrorCode Reassemble(Flow *flow)
{
  PetscFunctionBegin;
  OperatorsForget(flow->ops);
  PetscCall(FlowAssemble(flow));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Ends the pair forces; matrices keep them until they are assembled. */
static PetscErrorCode DropPairs(Flow *flow)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(flow->ops->free->has_pair_forces));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lets a step with a burst be solved again with pair forces about the particles that burst, until
   the velocity changes little. A burst is a change of the velocity of a particle with a fit by more
   than four times the largest speed before. If pair forces do not halve the change, it is none of
   the fits, and the first solve was right: it is done again and kept. From the second step on: the
   first may begin at rest. */
static PetscErrorCode DecideBurst(Flow *flow, Trial *trial, PetscBool *again)
{
  Changes c;

  PetscFunctionBegin;
  if (flow->clock->dt_previous == 0.0 || trial->times > MOST) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(flow->particles->n_fluid, &c.change));
  PetscCall(MeasureChanges(flow, &c));
  if (trial->times == 0) trial->first = c.largest;
  if (trial->times > 0 && c.largest > CALMER * trial->first) {
    PetscCall(DropPairs(flow));
    trial->times = MOST; /* this solve counts too, and is the last */
    *again       = PETSC_TRUE;
  } else if (trial->times < MOST && c.largest > BURST * c.fastest) {
    PetscCall(AddPairs(flow, &c));
    *again = PETSC_TRUE;
  } else if (trial->times > 0) {
    flow->clock->bursts++;
  }
  PetscCall(PetscFree(c.change));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns true for moving fluids with a free surface whose viscous rows beside it are fits. */
static PetscBool MayBurst(const Flow *flow)
{
  return SceneMoves(flow->scene) && OperatorsStressSurface(flow->ops);
}

const Judge JudgeBurst = {
    .name    = "burst",
    .brief   = "a step in which single particles burst is solved again with pair forces about them",
    .Applies = MayBurst,
    .again   = AGAIN_SOLVES,
    .Decide  = DecideBurst,
    .Treat   = Reassemble,
    .Clear   = DropPairs,
};
