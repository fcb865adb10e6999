/* The body force on the fluid. */
#include "isph/flow.h"
#include "isph/strain.h"

/* Stores the largest body force, for the limit of the step and the speed bound. */
static void NoteForce(Scheme *scheme, PetscReal square)
{
  scheme->stats.force_max  = PetscSqrtReal(square);
  scheme->bound.force_step = PetscMax(scheme->bound.force_step, scheme->stats.force_max);
}

/* Returns component a of a force f that acts on own particle i. With a free surface of strain cells
   it acts on the fluid that moves with the particle, on which the pressure acts, so that fluid at
   rest stays at rest. Beside a wall the rest is held by the wall. */
static PetscReal ForceOn(const Flow *flow, PetscInt i, PetscInt a, const PetscReal f[])
{
  const StrainCells *cells = flow->ops->cut_surface ? flow->ops->strain : NULL;
  const PetscInt     d     = flow->scene->dim;
  PetscReal          sum   = 0.0;

  for (PetscInt b = 0; b < d && cells; b++) sum += f[b] * cells->weight[b * d + a][i];
  return cells ? sum / cells->mass[cells->sets == 1 ? 0 : a][i] : f[a];
}

/* AddBodyForce - Adds the body force f(x, t) on the own fluid and stores its largest value.
   Collective. A uniform force on all of the fluid needs no loop over particles. Input: t - time
   [s]; force - vectors over the fluid [m/s^2]; NULL: only the largest value is computed. Output:
   flow - stats.force_max and bound.force_step of the scheme [m/s^2]. */
PetscErrorCode AddBodyForce(Flow *flow, PetscReal t, Vec force[])
{
  const Scene     *scene = flow->scene;
  const Particles *p     = flow->particles;
  PetscScalar     *g[ISPH_MAX_DIM];
  PetscReal        most = 0.0;

  PetscFunctionBegin;
  for (PetscInt a = 0; force && a < scene->dim && flow->state->interface[a]; a++)
    PetscCall(VecAXPY(force[a], 1.0, flow->state->interface[a]));
  if (!SceneHas(scene, PHYSICS_BODY_FORCE)) PetscFunctionReturn(PETSC_SUCCESS);
  if (!scene->force.n && !flow->ops->cut_surface) {
    PetscReal f[ISPH_MAX_DIM];

    SceneBodyForce(scene, t, scene->lo, f);
    for (PetscInt a = 0; a < scene->dim; a++) {
      if (force) PetscCall(VecShift(force[a], f[a]));
      most += PetscSqr(f[a]);
    }
    NoteForce(flow->scheme, most);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (PetscInt a = 0; a < scene->dim && force; a++) PetscCall(VecGetArray(force[a], &g[a]));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscReal x[ISPH_MAX_DIM], f[ISPH_MAX_DIM], square = 0.0;

    for (PetscInt a = 0; a < scene->dim; a++) x[a] = p->x[a][i];
    SceneBodyForce(scene, t, x, f);
    for (PetscInt a = 0; a < scene->dim; a++) {
      if (force) g[a][i] += ForceOn(flow, i, a, f);
      square += PetscSqr(f[a]);
    }
    most = PetscMax(most, square);
  }
  for (PetscInt a = 0; a < scene->dim && force; a++) PetscCall(VecRestoreArray(force[a], &g[a]));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPIU_REAL, MPIU_MAX, p->comm));
  NoteForce(flow->scheme, most);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* NoteUnbalancedForce - Lowers the stored largest body force to that of a force per mass which
   contains the gradient of the pressure, f - grad p/rho. Collective. The part of f that the
   pressure balances moves no particle and limits no step. A free surface that moves keeps f: its
   waves have the frequency sqrt(|f| k), however small the sum is. */
PetscErrorCode NoteUnbalancedForce(Flow *flow, const Vec force[])
{
  const Scene       *scene = flow->scene;
  const PetscScalar *f[ISPH_MAX_DIM];
  PetscReal          most = 0.0;

  PetscFunctionBegin;
  if (SceneHasFreeSurface(scene) && SceneMoves(scene)) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt a = 0; a < scene->dim; a++) PetscCall(VecGetArrayRead(force[a], &f[a]));
  for (PetscInt i = 0; i < flow->particles->n_fluid; i++) {
    PetscReal square = 0.0;

    for (PetscInt a = 0; a < scene->dim; a++) square += PetscSqr(f[a][i]);
    most = PetscMax(most, square);
  }
  for (PetscInt a = 0; a < scene->dim; a++) PetscCall(VecRestoreArrayRead(force[a], &f[a]));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPIU_REAL, MPIU_MAX, flow->particles->comm));
  flow->scheme->stats.force_max = PetscMin(flow->scheme->stats.force_max, PetscSqrtReal(most));
  PetscFunctionReturn(PETSC_SUCCESS);
}
