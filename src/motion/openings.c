/*
  Moving particles leave through outflows, and enter and leave through inflows. Wall particle w of
  an inflow represents a piece of its side of length a; the fluid that has entered there since the
  last particle has the length

    q_w += s_w n.u_w(t + dt/2) dt,   s_w: open part of the piece,

  and when q_w exceeds EARLY l, with the length l = V/a of a particle of volume V, a particle enters
  at the distance q_w - l/2 from the side, and q_w falls by l. So the volume that enters is that of
  the given velocity, and the particles enter as a lattice that moves with it. They have the
  velocity of the inflow, also as their history. If fluid leaves, q_w falls to -l/2, and rises by
  l as a particle of the lattice passes the side: so q_w is the gap if the velocity turns.
*/
#include "entrants.h"

#define ROOM  40  /* points along each axis for the volume of a box with bodies */
#define EARLY 0.8 /* a particle enters at 0.3 l; later, the gap behind it would be a void */
#define LATE  0.5 /* a particle leaves where it passes the side */

/* Returns the volume of the box outside bodies, by points of a lattice [m^dim]. */
static PetscReal RoomOf(const Scene *scene)
{
  PetscReal room = 1.0, normal[ISPH_MAX_DIM];
  PetscInt  n = 1, free = 0, nearest;

  for (PetscInt a = 0; a < scene->dim; a++) {
    room *= scene->hi[a] - scene->lo[a];
    n *= ROOM;
  }
  if (scene->n_bodies == 0) return room;
  for (PetscInt k = 0; k < n; k++) {
    PetscReal x[ISPH_MAX_DIM] = {0.0};

    for (PetscInt a = 0, index = k; a < scene->dim; a++, index /= ROOM)
      x[a] = scene->lo[a] + (index % ROOM + 0.5) / ROOM * (scene->hi[a] - scene->lo[a]);
    if (SceneDistance(scene, x, &nearest, normal) > 0.0) free++;
  }
  return room * free / n;
}

/* OpeningsCreate - Prepares the counters of the volume that enters and leaves. Does nothing if
   particles cannot enter or leave. */
PetscErrorCode OpeningsCreate(Flow *flow)
{
  Openings *o      = &flow->state->openings;
  Scheme   *scheme = flow->scheme;
  const struct {
    const char *name;
    PetscReal  *value;
  } volume[] = {{"volume_in", &o->volume_in}, {"volume_out", &o->volume_out}};

  PetscFunctionBegin;
  o->open = SceneHasOpenings(flow->scene);
  if (!o->open) PetscFunctionReturn(PETSC_SUCCESS);
  if (!SceneHasBoundary(flow->scene, BOUNDARY_OUTFLOW) && !ScenePressureFloats(flow->scene))
    o->room = RoomOf(flow->scene);
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
  if (!o->open || !SceneHasBoundary(flow->scene, BOUNDARY_INFLOW))
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ParticlesRegister(flow->particles, "entered", 1, HALO_NONE, ENTRY_ZERO,
                              &flow->particles->entered));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns true if x lies beyond an opening. */
static PetscBool HasLeft(const Scene *scene, const PetscReal x[])
{
  for (PetscInt side = 0; side < 2 * scene->dim; side++) {
    if ((BoundaryIs(scene, side, BOUNDARY_OUTFLOW) || BoundaryIs(scene, side, BOUNDARY_INFLOW)) &&
        SceneSideDistance(scene, side, x) < 0.0)
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

/* Lets fluid enter or leave at own wall particle w of an inflow for the present step. */
static PetscErrorCode EnterAt(const Flow *flow, PetscInt w, Entrants *all)
{
  const Scene     *scene           = flow->scene;
  const Particles *p               = flow->particles;
  const PetscInt   side            = (PetscInt)p->side[w];
  const PetscReal  length          = SceneCellSide(scene, side / 2);
  PetscReal       *entered         = &p->entered[w];
  PetscReal        x[ISPH_MAX_DIM] = {0.0}, u[ISPH_MAX_DIM], part;

  PetscFunctionBegin;
  ParticlesWallPoint(p, w, x);
  part = BoundaryOpenPart(scene, side, x);
  if (part == 0.0 || p->depth[w] > p->dx[w]) PetscFunctionReturn(PETSC_SUCCESS);
  BoundaryIntoOpening(scene, side, x);
  SceneWallVelocity(scene, side, flow->clock->t + 0.5 * flow->clock->dt, x, u);
  *entered += part * SideEntering(side, u) * flow->clock->dt;
  all->far =
      PetscMax(all->far, PetscAbsReal(*entered) / (scene->hi[side / 2] - scene->lo[side / 2]));
  if (all->far > 1.0) PetscFunctionReturn(PETSC_SUCCESS);
  while (*entered < -LATE * length) *entered += length; /* a particle has left here */
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

/* Fails the step, and the run, if no fluid is left, or if the particles have more volume than the
   box and no outflow. */
static PetscErrorCode CheckRoom(Flow *flow)
{
  const Scene    *scene   = flow->scene;
  const PetscReal volume  = flow->particles->weight * flow->particles->cell_volume;
  StepFailure    *failure = &flow->scheme->failure;
  const PetscReal room    = flow->state->openings.room;
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
  if (room == 0.0) PetscFunctionReturn(PETSC_SUCCESS);
  if (volume <= room * (1.0 + (scene->n_bodies ? 1.0 / ROOM : PETSC_SQRT_MACHINE_EPSILON)))
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ClockWhere(flow->clock, where));
  FailureSet(failure, PETSC_ERR_USER_INPUT,
             "%s: the box is full: the fluid that has entered has the volume %.4g, the box %.4g; "
             "give -scene_outflow, a larger -scene_box or a smaller -t_end",
             where, (double)volume, (double)room);
  failure->fatal = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* OpeningsPass - Removes the particles that left the box in the present step, and inserts those
   that entered; collective. Positions are those at the end of the step, velocities still those at
   its start. An epoch starts if a particle leaves or enters. The step fails if fluid enters farther
   than the box is long. The step, and with it the run, fails if no fluid is left, or if a box
   without an outflow is full. */
PetscErrorCode OpeningsPass(Flow *flow)
{
  Openings        *o    = &flow->state->openings;
  const Particles *p    = flow->particles;
  Entrants         all  = {.flow = flow};
  PetscReal        left = 0.0;

  PetscFunctionBegin;
  PetscCall(RemoveLeft(flow, &left));
  for (PetscInt w = p->n_fluid; p->entered && w < ParticlesOwn(p); w++) {
    if (BoundaryIs(flow->scene, (PetscInt)p->side[w], BOUNDARY_INFLOW))
      PetscCall(EnterAt(flow, w, &all));
  }
  PetscCall(EntrantsFindReturning(flow, &all));
  PetscCall(EntrantsGather(p->comm, &all));
  PetscCall(CheckFar(flow, all.far));
  if (flow->scheme->failure.code) {
    PetscCall(PetscFree(all.entrant));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  EntrantsDropCrowded(flow->scene, &all);
  if (all.n) PetscCall(EntrantsInsert(flow, &all));
  o->volume_out += left;
  o->volume_in += all.n * SceneVolume(flow->scene);
  PetscCall(PetscFree(all.entrant));
  PetscCall(CheckRoom(flow));
  PetscFunctionReturn(PETSC_SUCCESS);
}
