/*
  Particles that enter in a step: gathered on all ranks, and inserted with their values. Through an
  inflow with the velocity U they have, at the distance d before the point x_s of the side,

    u(x, t) = U(x_s, t) + g d,   g = sum_j d_j (u_j - U(x_s,j)) / sum_j d_j^2

  with the slope g of the fluid j nearby. The material has come from x - u tau at the time t - tau:
  this gives its velocities in the history. With U alone a particle errs by d du/dn.
*/
#include "entrants.h"

#define NEAR 2.0 /* distance of the fluid that gives the slope [dx] */

/* EntrantsAdd - Adds a particle at a distance from wall particle w to the share of this rank */
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
  ParticlesWallPoint(p, w, entrant->x);
  for (PetscInt a = 0; a < p->dim; a++) entrant->x[a] += distance * p->normal[a][w];
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

/* Computes the velocity of an inflow at the place x, moved to the side; returns the distance. */
static PetscReal SideVelocity(const Scene *scene, PetscInt side, PetscReal t, const PetscReal x[],
                              PetscReal u[])
{
  PetscReal point[ISPH_MAX_DIM] = {0.0};

  for (PetscInt a = 0; a < scene->dim; a++) point[a] = x[a];
  point[side / 2] = side % 2 ? scene->hi[side / 2] : scene->lo[side / 2];
  BoundaryIntoOpening(scene, side, point);
  SceneWallVelocity(scene, side, PetscMax(t, 0.0), point, u);
  return SceneSideDistance(scene, side, x);
}

/* Computes the slope at an entrant, from the fluid nearby at the start of the step. */
static PetscErrorCode FindSlope(const Flow *flow, const Cells *cells, PetscInt list[], Entrant *e)
{
  const Particles *p    = flow->particles;
  const PetscInt   side = (PetscInt)e->side;
  PetscReal        sum  = 0.0;
  PetscInt         n;

  PetscFunctionBegin;
  PetscCall(CellsFind(cells, e->x, NEAR * flow->scene->dx, cells->n, list, &n));
  for (PetscInt k = 0; k < n; k++) {
    PetscReal x[ISPH_MAX_DIM] = {0.0}, u[ISPH_MAX_DIM], d;

    if (ParticlesIsWall(p, list[k])) continue;
    for (PetscInt a = 0; a < p->dim; a++)
      x[a] = p->x[a][list[k]] - flow->clock->dt * p->u[a][list[k]];
    d = SideVelocity(flow->scene, side, flow->clock->t, x, u);
    sum += PetscSqr(d);
    for (PetscInt a = 0; a < p->dim; a++) e->slope[a] += d * (p->u[a][list[k]] - u[a]);
  }
  for (PetscInt a = 0; sum > 0.0 && a < p->dim; a++) e->slope[a] /= sum;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the velocity of entering material at the time `back` before the end of the step. */
static void EnteringVelocity(const Flow *flow, const Entrant *e, PetscReal back, PetscReal u[])
{
  const Scene    *scene = flow->scene;
  const PetscInt  side  = (PetscInt)e->side;
  const PetscReal t     = flow->clock->t + flow->clock->dt - back;
  PetscReal       x[ISPH_MAX_DIM], d = SideVelocity(scene, side, t, e->x, u);

  for (PetscInt a = 0; a < scene->dim; a++) x[a] = e->x[a] - back * (u[a] + d * e->slope[a]);
  d = SideVelocity(scene, side, t, x, u);
  for (PetscInt a = 0; a < scene->dim; a++) u[a] += d * e->slope[a];
}

/* Sets a field of entering particle k: on an inflow its velocities at their times, and
   fluid and viscosity, if it is Newtonian, are those at the place. */
static void EnteringValue(const Field *field, PetscInt k, PetscReal value[], void *ctx)
{
  const Entrants   *all        = (const Entrants *)ctx;
  const Flow       *flow       = all->flow;
  const Clock      *clock      = flow->clock;
  const Entrant    *entrant    = &all->entrant[all->of[k]];
  PetscReal *const *velocity[] = {flow->particles->u, flow->state->u_previous,
                                  flow->state->u_earlier};
  const PetscReal   back[]     = {0.0, clock->dt_previous, clock->dt_previous + clock->dt_before};

  if (!BoundaryIs(flow->scene, (PetscInt)entrant->side, BOUNDARY_INFLOW)) return;
  for (PetscInt m = 0; m < 3; m++) {
    if (field->slot[0] != velocity[m][0] || !velocity[m][0]) continue;
    EnteringVelocity(flow, entrant, clock->dt + back[m], value);
  }
  if (flow->particles->nu && field->slot[0] == flow->particles->nu && SceneIsNewtonian(flow->scene))
    value[0] = SceneViscosityAt(flow->scene, entrant->x);
  if (field->slot == &flow->particles->fluid)
    value[0] = (PetscReal)SceneFluidAt(flow->scene, entrant->x);
}

/* Computes the slopes of the velocity at the entrants of inflows on this rank; collective. */
static PetscErrorCode FindSlopes(const Flow *flow, PetscInt n, Entrants *all)
{
  Particles *p     = flow->particles;
  Cells      cells = {0};
  PetscInt  *list;

  PetscFunctionBegin;
  PetscCall(ParticlesHaloComponents(p, p->u));
  PetscCall(CellsBuild(p, NEAR * flow->scene->dx, &cells));
  PetscCall(PetscMalloc1(cells.n, &list));
  for (PetscInt k = 0; k < n; k++) {
    Entrant *entrant = &all->entrant[all->of[k]];

    if (BoundaryIs(flow->scene, (PetscInt)entrant->side, BOUNDARY_INFLOW))
      PetscCall(FindSlope(flow, &cells, list, entrant));
  }
  PetscCall(PetscFree(list));
  PetscCall(CellsFree(&cells));
  PetscFunctionReturn(PETSC_SUCCESS);
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
  PetscCall(FindSlopes(flow, added.n, all));
  added.x = x;
  PetscCall(ParticlesInsert(flow->scene, p, &added, NULL));
  PetscCall(PetscFree2(x, all->of));
  PetscFunctionReturn(PETSC_SUCCESS);
}
