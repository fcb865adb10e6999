/* Particles that enter in a step: gathered on all ranks, and inserted with their values. */
#include "entrants.h"

/* EntrantsAdd - Adds a particle at a distance from wall particle w to the share of this rank; not
   collective */
PetscErrorCode EntrantsAdd(const Particles *p, PetscInt w, PetscReal distance, Entrants *all)
{
  Entrant *entrant;

  PetscFunctionBegin;
  if (all->n == all->capacity) {
    all->capacity = 2 * all->capacity + 16;
    PetscCall(PetscRealloc(sizeof(*entrant) * (size_t)all->capacity, &all->entrant));
  }
  entrant  = &all->entrant[all->n++];
  *entrant = (Entrant){.side = p->side[w]};
  ParticlesWallPoint(p, w, entrant->point);
  for (PetscInt a = 0; a < p->dim; a++)
    entrant->x[a] = entrant->point[a] + distance * p->normal[a][w];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* EntrantsGather - Gives all ranks the entrants of all ranks, in the order of ranks, and the
   largest `far`; collective */
PetscErrorCode EntrantsGather(MPI_Comm comm, Entrants *all)
{
  const PetscReal own = (PetscReal)(all->n * ENTRANT_NUMBERS), tell[] = {own, all->far};
  PetscReal      *told;
  PetscMPIInt     ranks, *count, *before;
  Entrant        *gathered;
  PetscInt        total = 0;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(comm, &ranks));
  PetscCall(PetscMalloc3(ranks, &count, ranks, &before, 2 * ranks, &told));
  PetscCallMPI(MPI_Allgather(tell, 2, MPIU_REAL, told, 2, MPIU_REAL, comm));
  for (PetscMPIInt r = 0; r < ranks; r++) {
    count[r]  = (PetscMPIInt)told[2 * r];
    before[r] = (PetscMPIInt)total;
    total += count[r];
    all->far = PetscMax(all->far, told[2 * r + 1]);
  }
  PetscCall(PetscMalloc1(total / ENTRANT_NUMBERS, &gathered));
  PetscCallMPI(MPI_Allgatherv(all->entrant, (PetscMPIInt)own, MPIU_REAL, gathered, count, before,
                              MPIU_REAL, comm));
  PetscCall(PetscFree3(count, before, told));
  PetscCall(PetscFree(all->entrant));
  all->entrant = gathered;
  all->n       = total / ENTRANT_NUMBERS;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets a field of entering particle k: on an inflow velocities are those of the side at their time,
   and the viscosity of a Newtonian fluid is that at the place. */
static void EnteringValue(const Field *field, PetscInt k, PetscReal value[], void *ctx)
{
  const Entrants   *all        = (const Entrants *)ctx;
  const Flow       *flow       = all->flow;
  const Clock      *clock      = flow->clock;
  const Entrant    *entrant    = &all->entrant[all->of[k]];
  PetscReal *const *velocity[] = {flow->particles->u, flow->state->u_previous,
                                  flow->state->u_earlier};
  const PetscReal   back[]     = {0.0, clock->dt_previous, clock->dt_previous + clock->dt_before};
  PetscReal         u[ISPH_MAX_DIM];

  if (!BoundaryIs(flow->scene, (PetscInt)entrant->side, BOUNDARY_INFLOW)) return;
  for (PetscInt m = 0; m < 3; m++) {
    if (field->slot[0] != velocity[m][0] || !velocity[m][0]) continue;
    SceneWallVelocity(flow->scene, (PetscInt)entrant->side, PetscMax(clock->t - back[m], 0.0),
                      entrant->point, u);
    for (PetscInt a = 0; a < flow->scene->dim; a++) value[a] = u[a];
  }
  if (flow->particles->nu && field->slot[0] == flow->particles->nu && SceneIsNewtonian(flow->scene))
    value[0] = SceneViscosityAt(flow->scene, entrant->x);
}

/* EntrantsInsert - Inserts the entrants of all ranks; collective */
PetscErrorCode EntrantsInsert(Flow *flow, Entrants *all)
{
  Particles   *p     = flow->particles;
  NewParticles added = {.kind = PARTICLE_FLUID, .Value = EnteringValue, .ctx = all};
  PetscReal   *x;

  PetscFunctionBegin;
  PetscCall(ParticlesUpdateHalo(p));
  PetscCall(PetscMalloc2(all->n * p->dim, &x, all->n, &all->of));
  for (PetscInt k = 0; k < all->n; k++) {
    if (!ParticlesHolds(p, all->entrant[k].x)) continue;
    for (PetscInt a = 0; a < p->dim; a++) x[added.n * p->dim + a] = all->entrant[k].x[a];
    all->of[added.n++] = k;
  }
  added.x = x;
  PetscCall(ParticlesInsert(flow->scene, p, &added, NULL));
  PetscCall(PetscFree2(x, all->of));
  PetscFunctionReturn(PETSC_SUCCESS);
}
