/*
  The energy balance of moving fluids with a free surface: per mass, from places and velocities of
  the particles,

    |u|^2/2 + D <= |u(0)|^2/2 + sigma A(0)/M + W,   W = sum_i m_i int f.dx_i/M,
    D = int 2 nu <E:E> dt,

  in flight less the least energy that the surface can have, for walls at rest. |u| is the root mean
  square. A fluid that breaks the balance has velocities or a height that neither the start nor the
  body force gives. The bound on the speed of full boxes does not hold here: a fluid that falls
  touches no wall that slows it. See theory.md, (surface:energy).
*/
#include "isph/balance.h"
#include "isph/strain.h"

#define HEIGHT   0.05 /* error of the height at which particles of a fluid at rest are [dx] */
#define LOST     2.0  /* energy of a flow that is lost over the most that it can have [-] */
#define ROUNDING 1e-6 /* speed of a fluid at rest [U] */

/* EnergyWork - Returns the work of the body force, and of a tension that varies, on own particle i,
   whose path in a step is `path` [m], over the mass of a particle of weight 1 of fluid 0
   [m^2/s^2] */
PetscReal EnergyWork(const Flow *flow, PetscInt i, const PetscReal path[])
{
  const Particles *p    = flow->particles;
  PetscReal        work = 0.0, middle[ISPH_MAX_DIM], f[ISPH_MAX_DIM] = {0.0};

  if (!SceneHasFreeSurface(flow->scene)) return 0.0;
  for (PetscInt a = 0; a < p->dim; a++) middle[a] = p->x[a][i] + 0.5 * path[a];
  if (SceneHas(flow->scene, PHYSICS_BODY_FORCE))
    SceneBodyForce(flow->scene, flow->clock->t + 0.5 * flow->clock->dt, middle, f);
  for (PetscInt a = 0; a < p->dim && flow->scene->tension_field.n; a++) {
    const PetscScalar *tension;

    PetscCallAbort(p->comm, VecGetArrayRead(flow->state->interface[a], &tension));
    f[a] += PetscRealPart(tension[i]);
    PetscCallAbort(p->comm, VecRestoreArrayRead(flow->state->interface[a], &tension));
  }
  for (PetscInt a = 0; a < p->dim; a++) work += f[a] * path[a];
  return ParticlesWeight(p, i) * (ParticlesDensity(flow->scene, p, i) / flow->scene->rho) * work;
}

/* Returns the mass of the fluid over that of a particle of weight 1 of fluid 0 [-]. */
static PetscReal Mass(const Flow *flow)
{
  return flow->particles->weight * (flow->scheme->stats.density / flow->scene->rho);
}

/* EnergyAddWork - Adds the sum of EnergyWork() over the own particles to the balance; collective */
PetscErrorCode EnergyAddWork(Flow *flow, PetscReal work)
{
  PetscFunctionBegin;
  if (!SceneHasFreeSurface(flow->scene)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &work, 1, MPIU_REAL, MPIU_SUM, flow->particles->comm));
  flow->scheme->energy.work += work / Mass(flow);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the sum of V_c/V nu_c/nu 2 E:E over own cells of a weak form [1/s^2]. */
static PetscErrorCode CellPower(const Flow *flow, const Vec u[], PetscReal *power)
{
  const Particles *p     = flow->particles;
  StrainCells     *cells = flow->ops->strain;

  PetscFunctionBegin;
  *power = 0.0;
  PetscCall(StrainOfVelocity(p, u, flow->walls.u, cells));
  for (PetscInt c = 0; c < cells->all; c++) {
    PetscReal x[ISPH_MAX_DIM];

    if (StrainHasCell(p, cells, c, x))
      *power += cells->volume[c] / p->cell_volume * cells->nu[c] / flow->scene->nu *
                PetscSqr(cells->rate[c]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the energy per mass that viscosity takes in the step, if the velocity is u, between
   walls at rest [m^2/s^2]; zero, which loosens the bound, without cells. */
static PetscErrorCode Dissipation(Flow *flow, const Vec u[], PetscReal *energy)
{
  PetscFunctionBegin;
  *energy = 0.0;
  if (!flow->ops->strain) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(CellPower(flow, u, energy));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, energy, 1, MPIU_REAL, MPIU_SUM, flow->particles->comm));
  *energy *= flow->scene->nu * flow->clock->dt / Mass(flow);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns twice the least energy of the surface over the mass of fluid that touches nothing: that
   of one circle or ball [m^2/s^2]; 0, which loosens the balance, if it touches something. */
static PetscReal LeastTension(const Flow *flow)
{
  const Scene    *scene  = flow->scene;
  const PetscReal volume = flow->particles->weight * flow->particles->cell_volume;
  const PetscReal area   = scene->dim == 2 ? 2.0 * PetscSqrtReal(PETSC_PI * volume)
                                           : cbrt(36.0 * PETSC_PI * volume * volume);

  if (flow->scheme->sheet.flight.on == 0.0 || SceneHasBoundary(scene, BOUNDARY_CONTINUES) ||
      scene->tension_field.n)
    return 0.0;
  return 2.0 * scene->tension * area / (flow->scheme->stats.density * volume);
}

/* Adds the balance at the end of a step to the largest gain. Input: rms - of the velocity [m/s];
   given - twice the energy per mass of start and work [m^2/s^2]. */
static void NoteGain(const Flow *flow, PetscReal rms, PetscReal given)
{
  const SpeedBound *b      = &flow->scheme->bound;
  EnergyBalance    *e      = &flow->scheme->energy;
  const PetscReal   driven = PetscSqrtReal(PetscMax(given, 0.0)) + b->walls;
  const PetscReal   noise  = PetscSqr(ROUNDING * flow->scene->speed);
  PetscReal         excess = PetscSqr(rms) + 2.0 * e->dissipated - given, gain;

  if (b->walls > 0.0) excess = PetscSqr(rms) - PetscSqr(driven);
  excess += LeastTension(flow);
  e->most = PetscMax(e->most, PetscSqr(driven));
  gain    = excess / (e->most + 2.0 * b->force * flow->scene->dx + noise);
  if (!(excess > 0.0) || !(gain > e->gain)) return;
  e->gain   = gain;
  e->gain_t = flow->clock->t + flow->clock->dt;
}

/*
  EnergyBound - Returns the bound on the root mean square of the velocity at the end of a step, and
  notes the largest gain of energy so far

    |u| <= sqrt(2 (|u|(0)^2 + 2 W + l + F dx/10)) + max wall speed bound,   F = max |f|

  Collective. The bound allows twice the energy, because fluid that hits a wall or other fluid may
  gain energy for some steps and lose it again, which the gain records. W is of second order for the
  velocities of the particles, except after a start from rest: in the first step the force acts, but
  no particle moves. The lag l of the work is (F dt)^2 then, and later the largest F dt |change of
  |u|| of a step. Moving walls give energy, so that the gain has no dissipation with them. Input:
  before - root mean square of the velocity at the start of the step [m/s]. Output: bound - without
  the share for discretisation [m/s].
*/
PetscErrorCode EnergyBound(Flow *flow, PetscReal before, PetscReal *bound)
{
  const SpeedBound *b     = &flow->scheme->bound;
  EnergyBalance    *e     = &flow->scheme->energy;
  const PetscReal   rms   = FlowRmsSpeed(flow);
  const PetscReal   force = b->force, kick = force * flow->clock->dt;
  PetscReal         given, dissipated;

  PetscFunctionBegin;
  PetscCall(Dissipation(flow, flow->state->u_next, &dissipated));
  e->dissipated += dissipated;
  given = PetscSqr(b->start) + 2.0 * e->work;
  given += flow->clock->step == 0 ? PetscSqr(kick) : e->lag;
  *bound = given + 2.0 * HEIGHT * force * flow->scene->dx;
  *bound = PetscSqrtReal(LOST * PetscMax(*bound, 0.0)) + b->walls;
  NoteGain(flow, rms, given);
  e->lag = PetscMax(e->lag, kick * PetscAbsReal(rms - before));
  PetscFunctionReturn(PETSC_SUCCESS);
}
