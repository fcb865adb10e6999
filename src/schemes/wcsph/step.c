/* The stages of the weakly compressible step besides its integrator. */
#include "schemes/stages/stages.h"
#include "wcsph.h"

#define CLEARANCE 0.05 /* least distance of particles from walls [dx] */

static PetscBool Shifts(const Flow *flow)
{
  return flow->state->shift->Displace ? PETSC_TRUE : PETSC_FALSE;
}

/* Moves particles that are too close to walls, or behind them, away from the walls. */
static void KeepOffWalls(const Scene *scene, Particles *p)
{
  if (!SceneHas(scene, PHYSICS_WALLS)) return;
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscReal x[ISPH_MAX_DIM];

    for (PetscInt a = 0; a < scene->dim; a++) x[a] = p->x[a][i];
    SceneKeepOffWalls(scene, 0.0, CLEARANCE * p->dx[i], x);
    for (PetscInt a = 0; a < scene->dim; a++) p->x[a][i] = x[a];
  }
}

/* Keeps particles off walls, and adds the work of the body force in the step to the energy balance,
   from the way back. */
static PetscErrorCode Settle(Flow *flow)
{
  const Wcsph     *w    = (const Wcsph *)flow->scheme->data;
  const Particles *p    = flow->particles;
  PetscReal        work = 0.0;

  PetscFunctionBegin;
  KeepOffWalls(flow->scene, flow->particles);
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscReal back[ISPH_MAX_DIM];

    for (PetscInt a = 0; a < p->dim; a++) back[a] = w->start[a][i] - p->x[a][i];
    work -= EnergyWork(flow, i, back);
  }
  PetscCall(EnergyAddWork(flow, work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Moves owners, halo, neighbours and vectors to the new positions, and begins with u_next = u. */
static PetscErrorCode FollowPositions(Flow *flow)
{
  PetscFunctionBegin;
  PetscCall(FlowFollow(flow));
  PetscCall(FlowRebuildNeighbors(flow));
  for (PetscInt a = 0; a < flow->scene->dim; a++)
    PetscCall(VecCopy(flow->state->u[a], flow->state->u_next[a]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* WcsphKeepsVolume - Returns true if the density is an unknown and walls or periods keep the volume
   of the fluid */
PetscBool WcsphKeepsVolume(const Flow *flow)
{
  const Wcsph *w = (const Wcsph *)flow->scheme->data;

  return !w->density->sums && !SceneHasFreeSurface(flow->scene);
}

/* WcsphVolume - Computes the volume of the fluid at its present densities [m^dim]; collective */
PetscErrorCode WcsphVolume(const Flow *flow, PetscReal *volume)
{
  const Wcsph     *w = (const Wcsph *)flow->scheme->data;
  const Particles *p = flow->particles;

  PetscFunctionBegin;
  *volume = 0.0;
  for (PetscInt i = 0; i < p->n_fluid; i++) *volume += p->volume[i] * flow->scene->rho / w->rho[i];
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, volume, 1, MPIU_REAL, MPIU_SUM, p->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Multiplies all densities by the factor that restores the volume at the start: theory.md,
   (wcsph:volume). Errors of div u otherwise add up to a density, and a speed of sound, far from
   that at rest. */
static PetscErrorCode RestoreVolume(Flow *flow)
{
  Wcsph    *w = (Wcsph *)flow->scheme->data;
  PetscReal volume;

  PetscFunctionBegin;
  PetscCall(WcsphVolume(flow, &volume));
  for (PetscInt i = 0; i < flow->particles->n_fluid; i++) w->rho[i] *= volume / w->volume;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* WcsphSetPressure - Computes density and pressure of the particles at their present positions;
   collective */
PetscErrorCode WcsphSetPressure(Flow *flow)
{
  Wcsph     *w = (Wcsph *)flow->scheme->data;
  Particles *p = flow->particles;

  PetscFunctionBegin;
  PetscCall(WcsphReserve(flow, w));
  PetscCall(PetscArraycpy(w->local.rho, w->rho, p->n_fluid));
  if (w->e) PetscCall(PetscArraycpy(w->local.e, w->e, p->n_fluid));
  PetscCall(WcsphSetDensity(flow, w));
  PetscCall(PetscArraycpy(w->rho, w->local.rho, p->n_fluid));
  PetscCall(PetscArraycpy(p->p, w->local.p, p->n_fluid));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes density and pressure, and the largest Mach number and change of density of the run. */
static PetscErrorCode SetPressureAndMeasure(Flow *flow)
{
  const Clock *clock = flow->clock;
  Wcsph       *w     = (Wcsph *)flow->scheme->data;
  PetscReal    most  = 0.0;

  PetscFunctionBegin;
  PetscCall(WcsphSetPressure(flow));
  for (PetscInt i = 0; i < flow->particles->n_fluid; i++)
    most = PetscMax(most, PetscAbsReal(w->rho[i] / flow->scene->rho - 1.0));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPIU_REAL, MPIU_MAX, PETSC_COMM_WORLD));
  w->variation = PetscMax(w->variation, most);
  w->mach      = PetscMax(w->mach, flow->scheme->stats.speed_max / w->c0);
  if (flow->scheme->bound.walls > 0.0)
    w->passage = flow->scene->length / (w->c0 * (clock->t + clock->dt));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const Stage integrate = {.name  = "integrate",
                                .brief = "places, velocities and densities by the TS",
                                .Do    = WcsphIntegrate};

static const Stage shift = {
    .name = "shift", .brief = "particles evenly spread", .Applies = Shifts, .Do = WcsphShift};

static const Stage settle = {
    .name = "settle", .brief = "particles off walls, work of the force", .Do = Settle};

static const Stage rebuild = {
    .name = "rebuild", .brief = "owners and neighbours at the new places", .Do = FollowPositions};

static const Stage volume = {.name    = "volume",
                             .brief   = "densities that keep the volume",
                             .Applies = WcsphKeepsVolume,
                             .Do      = RestoreVolume};

static const Stage pressure = {
    .name = "pressure", .brief = "density and pressure, Mach number", .Do = SetPressureAndMeasure};

const Stage *const WcsphStages[] = {
    &integrate, &shift, &settle, &rebuild, &StageCheck, &volume, &pressure, NULL,
};
