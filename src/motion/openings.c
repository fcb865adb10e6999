/*
  Moving particles leave through outflows and enter through inflows. Wall particle w of an inflow
  represents a piece of its side of length a; the fluid that has entered there since the last
  particle has the length

    q_w += s_w n.u_w(t + dt/2) dt,   s_w: open part of the piece,

  and when q_w exceeds EARLY l, with the length l = V/a of a particle of volume V, a particle enters
  at the distance q_w - l/2 from the side, and q_w falls by l. So the volume that enters is that of
  the given velocity, and the particles enter as a lattice that moves with it. They have the
  velocity of the inflow, also as their history.
*/
#include "entrants.h"

#define EARLY 0.8 /* a particle enters at 0.3 l; later, the gap behind it would be a void */

/*
  OpeningsCreate - Prepares the counters of the volume that enters and leaves

  Not collective. Does nothing if particles cannot enter or leave.
*/
PetscErrorCode OpeningsCreate(Flow *flow)
{
  Openings *o      = &flow->state->openings;
  Scheme   *scheme = flow->scheme;
  const struct {
    const char *name;
    PetscReal  *value;
  } volume[] = {{"volume_in", &o->volume_in}, {"volume_out", &o->volume_out}};

  PetscFunctionBegin;
  o->there = SceneHasOpenings(flow->scene);
  if (!o->there) PetscFunctionReturn(PETSC_SUCCESS);
  UserCheck(
      !SceneMovesGraded(flow->scene),
      "-scene_inflow, -scene_outflow: graded particles that move neither enter nor leave; use "
      "-motion eulerian, or a uniform spacing");
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(volume); k++) {
    PetscCall(MemoryAddReal(&scheme->memory, volume[k].name, volume[k].value));
    PetscCall(SchemeAddFigure(
        (SchemeFigure){.name = volume[k].name, .value = volume[k].value, .most = PETSC_INFINITY},
        scheme));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* OpeningsRegister - Adds the field of the length that has entered, if there is an inflow;
   collective */
PetscErrorCode OpeningsRegister(Flow *flow)
{
  Openings *o = &flow->state->openings;

  PetscFunctionBegin;
  if (!o->there || !SceneHasBoundary(flow->scene, BOUNDARY_INFLOW))
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ParticlesRegister(flow->particles, "entered", 1, HALO_NONE, ENTRY_ZERO, &o->entered));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns true if x lies beyond an outflow. */
static PetscBool HasLeft(const Scene *scene, const PetscReal x[])
{
  for (PetscInt side = 0; side < 2 * scene->dim; side++) {
    if (BoundaryIs(scene, side, BOUNDARY_OUTFLOW) && SceneSideDistance(scene, side, x) < 0.0)
      return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Removes the particles that have left; volume: of all ranks [m^dim]. */
static PetscErrorCode RemoveLeft(Flow *flow, PetscReal *volume)
{
  Particles *p = flow->particles;
  PetscInt   n = 0, *list;
  PetscReal  x[ISPH_MAX_DIM], sum = 0.0;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(p->n_fluid, &list));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    for (PetscInt a = 0; a < p->dim; a++) x[a] = p->x[a][i];
    if (!HasLeft(flow->scene, x)) continue;
    list[n++] = i;
    sum += p->volume[i];
  }
  PetscCallMPI(MPI_Allreduce(&sum, volume, 1, MPIU_REAL, MPIU_SUM, p->comm));
  PetscCall(ParticlesRemove(flow->scene, p, n, list));
  PetscCall(PetscFree(list));
  PetscFunctionReturn(PETSC_SUCCESS);
}

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

/* Lets fluid enter at own wall particle w of an inflow for the present step. */
static PetscErrorCode EnterAt(const Flow *flow, PetscInt w, Entrants *all)
{
  const Scene     *scene           = flow->scene;
  const Particles *p               = flow->particles;
  const PetscInt   side            = (PetscInt)p->side[w];
  const PetscReal  length          = SceneCellSide(scene, side / 2);
  PetscReal       *entered         = &flow->state->openings.entered[w];
  PetscReal        x[ISPH_MAX_DIM] = {0.0}, u[ISPH_MAX_DIM], part;

  PetscFunctionBegin;
  ParticlesWallPoint(p, w, x);
  part = BoundaryOpenPart(scene, side, x);
  if (part == 0.0 || p->depth[w] > p->dx[w]) PetscFunctionReturn(PETSC_SUCCESS);
  BoundaryIntoOpening(scene, side, x);
  SceneWallVelocity(scene, side, flow->clock->t + 0.5 * flow->clock->dt, x, u);
  *entered += part * SideEntering(side, u) * flow->clock->dt;
  all->far = PetscMax(all->far, *entered / (scene->hi[side / 2] - scene->lo[side / 2]));
  if (all->far > 1.0) PetscFunctionReturn(PETSC_SUCCESS);
  for (; *entered >= EARLY * length; *entered -= length)
    PetscCall(EntrantsAdd(p, w, *entered - 0.5 * length, all));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Fails the step if fluid enters farther than the box is long. */
static PetscErrorCode CheckFar(Flow *flow, PetscReal far)
{
  char where[CLOCK_WHERE];

  PetscFunctionBegin;
  if (far <= 1.0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ClockWhere(flow->clock, where));
  FailureSet(&flow->scheme->failure, PETSC_ERR_USER_INPUT,
             "%s: in one step fluid enters %.3g times as far as the box is long; give a smaller "
             "-dt, or a lower -scene_wall_<side>_velocity of the inflow",
             where, (double)far);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gives all ranks the entrants of all ranks, in the order of ranks, and the largest `far`. */
static PetscErrorCode GatherEntrants(MPI_Comm comm, Entrants *all)
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

/* Inserts the entrants of all ranks. */
static PetscErrorCode InsertEntrants(Flow *flow, Entrants *all)
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

/* Fails the step, and the run, if no fluid is left, or if the particles have more volume than the
   box and no outflow. */
static PetscErrorCode CheckRoom(Flow *flow)
{
  const Scene    *scene   = flow->scene;
  const PetscReal volume  = flow->particles->weight * flow->particles->cell_volume;
  StepFailure    *failure = &flow->scheme->failure;
  PetscReal       room    = 1.0;
  char            where[CLOCK_WHERE];

  PetscFunctionBegin;
  if (flow->particles->N_fluid == 0) {
    PetscCall(ClockWhere(flow->clock, where));
    FailureSet(
        failure, PETSC_ERR_USER_INPUT,
        "%s: all of the fluid has left the box; give a smaller -t_end or a larger -scene_box",
        where);
    failure->fatal = PETSC_TRUE;
  }
  if (SceneHasBoundary(scene, BOUNDARY_OUTFLOW)) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt a = 0; a < scene->dim; a++) room *= scene->hi[a] - scene->lo[a];
  if (volume <= room * (1.0 + PETSC_SQRT_MACHINE_EPSILON)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ClockWhere(flow->clock, where));
  FailureSet(failure, PETSC_ERR_USER_INPUT,
             "%s: the box is full: the fluid that has entered has the volume %.4g, the box %.4g; "
             "give -scene_outflow, a larger -scene_box or a smaller -t_end",
             where, (double)volume, (double)room);
  failure->fatal = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  OpeningsPass - Removes the particles that left the box in the present step, and inserts those that
  entered

  Collective. Positions are those at the end of the step, velocities still those at its start.

  Output Parameter:
. passed - particles left or entered, so that an epoch has started

  Notes:
  The step fails if fluid enters farther than the box is long. The step, and with it the run, fails
  if no fluid is left, or if a box without an outflow is full.
*/
PetscErrorCode OpeningsPass(Flow *flow, PetscBool *passed)
{
  Openings        *o    = &flow->state->openings;
  const Particles *p    = flow->particles;
  Entrants         all  = {.flow = flow};
  PetscReal        left = 0.0;

  PetscFunctionBegin;
  *passed = PETSC_FALSE;
  if (!o->there) PetscFunctionReturn(PETSC_SUCCESS);
  if (SceneHasBoundary(flow->scene, BOUNDARY_OUTFLOW)) PetscCall(RemoveLeft(flow, &left));
  for (PetscInt w = p->n_fluid; o->entered && w < ParticlesOwn(p); w++) {
    if (BoundaryIs(flow->scene, (PetscInt)p->side[w], BOUNDARY_INFLOW))
      PetscCall(EnterAt(flow, w, &all));
  }
  PetscCall(EntrantsFindReturning(flow, &all));
  PetscCall(GatherEntrants(p->comm, &all));
  PetscCall(CheckFar(flow, all.far));
  if (flow->scheme->failure.code) {
    PetscCall(PetscFree(all.entrant));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  EntrantsDropCrowded(flow->scene, &all);
  if (all.n) PetscCall(InsertEntrants(flow, &all));
  o->volume_out += left;
  o->volume_in += all.n * SceneVolume(flow->scene);
  *passed = left > 0.0 || all.n ? PETSC_TRUE : PETSC_FALSE;
  PetscCall(PetscFree(all.entrant));
  PetscCall(CheckRoom(flow));
  PetscFunctionReturn(PETSC_SUCCESS);
}
