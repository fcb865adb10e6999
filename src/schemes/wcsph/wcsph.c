/*
  The weakly compressible scheme: an explicit step of

    dx/dt = u,   drho/dt = -rho div u,   du/dt = -grad p/rho + (div tau)/rho + f,   p = p(rho),

  with the sums of classical SPH. No matrix is assembled; or viscosity is left to the implicit TS of
  the projection, which then has the only matrix.

  References: M. Basa, N. Quinlan, M. Lastiwka, Int. J. Numer. Meth. Fluids 60 (2009); J. Fang et
  al., Appl. Numer. Math. 59 (2009)
*/
#include "wcsph.h"

#include "schemes/stages.h"

#define CLEARANCE 0.05 /* least distance of particles from walls [dx] */

/* Returns the largest |drho/dt|/rho of the last step, in place of |div u|. */
static PetscErrorCode Compression(Flow *flow, const Vec u[], PetscReal *largest)
{
  const Wcsph *w = (const Wcsph *)flow->scheme->data;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Allreduce(&w->divergence, largest, 1, MPIU_REAL, MPIU_MAX, PETSC_COMM_WORLD));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode WcsphSetUp(Flow *flow)
{
  Wcsph       *w = (Wcsph *)flow->scheme->data;
  PetscClassId id;

  PetscFunctionBegin;
  PetscCall(PetscClassIdRegister("Wcsph", &id));
  PetscCall(PetscLogEventRegister("PairRates", id, &w->event));
  PetscCall(WcsphCreateIntegrator(flow, w));
  if (w->implicit) PetscCall(ViscosityCreate(flow, &w->visc));
  flow->scheme->Divergence  = Compression;
  flow->scheme->bound.sound = WCSPH_SOUND * w->c0;
  w->lattice                = WcsphLatticeSum(flow);
  if (!w->implicit)
    w->follows = LaplacianFollowsSlopes(&flow->ops->forms.visc, flow->ops->forms.correction->bit);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns true if the density is an unknown and walls or periods keep the volume of the fluid. */
static PetscBool KeepsVolume(const Flow *flow)
{
  const Wcsph *w = (const Wcsph *)flow->scheme->data;

  return !w->density->sums && !SceneHasFreeSurface(flow->scene) ? PETSC_TRUE : PETSC_FALSE;
}

/* Registers density and energy, and sets them from the pressure at the start; and the particles on
   free surfaces at the start, if the viscous form has another gradient beside them. */
static PetscErrorCode WcsphRegister(Flow *flow)
{
  Particles *p     = flow->particles;
  Wcsph     *w     = (Wcsph *)flow->scheme->data;
  PetscReal  least = PETSC_INFINITY;

  PetscFunctionBegin;
  PetscCall(ParticlesRegister(p, "density", 1, HALO_NONE, ENTRY_MEAN, &w->rho));
  if (KeepsVolume(flow))
    PetscCall(MemoryAddReal(&flow->scheme->memory, "fluid_volume", &w->volume));
  if (w->equation->has_energy)
    PetscCall(ParticlesRegister(p, "energy", 1, HALO_NONE, ENTRY_MEAN, &w->e));
  if (WcsphComposed(w) && WcsphComposed(w)->gradient == GRADIENT_COUPLED &&
      SceneHasFreeSurface(flow->scene))
    PetscCall(ParticlesRegister(p, "surface_start", 1, HALO_EPOCH, ENTRY_ZERO, &w->surface));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    w->rho[i] = w->equation->Density(w, p->p[i]);
    if (w->e) w->e[i] = w->e_rest;
    least = w->rho[i] > 0.0 ? PetscMin(least, w->rho[i]) : 0.0;
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &least, 1, MPIU_REAL, MPIU_MIN, p->comm));
  UserCheck(least > 0.0,
            "-sound_speed %.6g: the least pressure at the start has no density; use a larger one",
            (double)w->c0);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the volume of the fluid at its present densities [m^dim]. */
static PetscErrorCode FluidVolume(const Flow *flow, const Wcsph *w, PetscReal *volume)
{
  const Particles *p = flow->particles;

  PetscFunctionBegin;
  *volume = 0.0;
  for (PetscInt i = 0; i < p->n_fluid; i++) *volume += p->volume[i] * flow->scene->rho / w->rho[i];
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, volume, 1, MPIU_REAL, MPIU_SUM, p->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Multiplies all densities by the factor that restores the volume at the start: docs/theory.md,
   (286). Errors of div u otherwise add up to a density, and a speed of sound, far from that at
   rest. */
static PetscErrorCode RestoreVolume(Flow *flow)
{
  Wcsph    *w = (Wcsph *)flow->scheme->data;
  PetscReal volume;

  PetscFunctionBegin;
  PetscCall(FluidVolume(flow, w, &volume));
  for (PetscInt i = 0; i < flow->particles->n_fluid; i++) w->rho[i] *= volume / w->volume;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes density and pressure of the particles at their present positions. */
static PetscErrorCode SetPressure(Flow *flow, Wcsph *w)
{
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

/*
  Returns the kinematic viscosity of the artificial viscosity, for the mean velocity gradient U/L,
  over that of the fluid

    h (alpha c0 + 0.4 beta h U/L)/(4 (d + 2) nu),   d = dim [-]

  This is half of the value for forces between all pairs, because pairs that separate have none:
  docs/theory.md, (218).

  Reference: J. J. Monaghan, Rep. Prog. Phys. 68 (2005) 1703-1759, for all pairs
*/
static PetscReal ArtificialShare(const Flow *flow, const Wcsph *w)
{
  const Scene    *scene = flow->scene;
  const PetscReal h     = flow->ops->forms.h;
  const PetscReal speed =
      w->artificial[0] * w->c0 + 0.4 * w->artificial[1] * h * scene->speed / scene->length;

  if (!SceneHas(scene, PHYSICS_VISCOSITY)) return 0.0;
  return h * speed / (4.0 * (scene->dim + 2) * scene->nu);
}

static PetscErrorCode WcsphBegin(Flow *flow)
{
  Wcsph *w = (Wcsph *)flow->scheme->data;

  PetscFunctionBegin;
  PetscCall(FlowBegin(flow));
  for (PetscInt i = 0; w->surface && flow->clock->step == 0 && i < flow->particles->n_fluid; i++)
    w->surface[i] = flow->ops->free->kind[i] != SURFACE_INSIDE ? 1.0 : 0.0;
  if (w->surface) PetscCall(ParticlesHaloField(flow->particles, w->surface));
  PetscCall(SetPressure(flow, w));
  if (flow->clock->step == 0 && KeepsVolume(flow)) PetscCall(FluidVolume(flow, w, &w->volume));
  w->artificial_over_nu = ArtificialShare(flow, w);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool HasForce(const Flow *flow)
{
  return SceneHas(flow->scene, PHYSICS_BODY_FORCE);
}

/* Measures the largest body force of the step. */
static PetscErrorCode MeasureForce(Flow *flow)
{
  PetscFunctionBegin;
  PetscCall(AddBodyForce(flow, flow->clock->t + flow->clock->dt, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

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
    SceneKeepOffWalls(scene, CLEARANCE * p->dx[i], x);
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

static PetscBool IsImplicit(const Flow *flow)
{
  return ((const Wcsph *)flow->scheme->data)->visc ? PETSC_TRUE : PETSC_FALSE;
}

/* Advances viscosity implicitly over the step, from the velocity that the TS has left. */
static PetscErrorCode SolveViscosity(Flow *flow)
{
  Viscosity *visc                = ((Wcsph *)flow->scheme->data)->visc;
  Vec        force[ISPH_MAX_DIM] = {NULL};

  PetscFunctionBegin;
  PetscCall(FlowAssemble(flow));
  for (PetscInt a = 0; a < flow->scene->dim; a++) {
    PetscCall(FlowGetWork(flow, &force[a]));
    PetscCall(VecZeroEntries(force[a]));
  }
  PetscCall(ViscositySolve(flow, flow->clock->dt, 0.0, force, NULL, flow->state->u_next, visc));
  for (PetscInt a = 0; a < flow->scene->dim; a++) PetscCall(FlowRestoreWork(flow, &force[a]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes density and pressure, and the largest Mach number and change of density of the run. */
static PetscErrorCode SetPressureAndMeasure(Flow *flow)
{
  const Clock *clock = flow->clock;
  Wcsph       *w     = (Wcsph *)flow->scheme->data;
  PetscReal    most  = 0.0;

  PetscFunctionBegin;
  PetscCall(SetPressure(flow, w));
  for (PetscInt i = 0; i < flow->particles->n_fluid; i++)
    most = PetscMax(most, PetscAbsReal(w->rho[i] / flow->scene->rho - 1.0));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPIU_REAL, MPIU_MAX, PETSC_COMM_WORLD));
  w->variation = PetscMax(w->variation, most);
  w->mach      = PetscMax(w->mach, flow->scheme->stats.speed_max / w->c0);
  if (flow->scheme->bound.walls > 0.0)
    w->passage = flow->scene->length / (w->c0 * (clock->t + clock->dt));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Limits the step by the diffusion of the density and by the artificial viscosity

    dt <= 0.125 h/(delta c0),   dt <= 0.5 h/(alpha c0 + 2 beta U)

  With the circles of Gershgorin the sums of PairsSum() and ArtificialViscosity() for the
  kernel Wendland C2 have no eigenvalue above 14 delta c0/h and 3.5 (alpha c0 + beta |m|)/h. These
  steps keep the product of step and eigenvalue below 2, which all Runge-Kutta methods allow.
  Particles at the distance h approach with |m| = 2 U at most.
*/
static void LimitDissipation(const Wcsph *w, PetscReal h, PetscReal pace, StepLimit *limit)
{
  const PetscReal drag = w->artificial[0] * w->c0 + 2.0 * w->artificial[1] * pace;

  if (w->diffusion > 0.0)
    StepLimitLower(limit, 0.125 * h / (w->diffusion * w->c0), "density diffusion");
  if (drag > 0.0) StepLimitLower(limit, 0.5 * h / drag, "artificial viscosity");
}

/* Limits the step by sound, dissipation, the way of particles within the halo and, unless it is
   implicit, viscosity. */
static PetscErrorCode WcsphLimit(const Flow *flow, StepLimit *limit)
{
  const Wcsph    *w    = (const Wcsph *)flow->scheme->data;
  const PetscReal pace = PetscMax(flow->scene->speed, flow->scheme->stats.speed_max);

  PetscFunctionBegin;
  PetscCall(FlowLimit(flow, limit));
  if (!flow->ops) PetscFunctionReturn(PETSC_SUCCESS);
  StepLimitLower(limit, w->courant * flow->ops->forms.h / (w->c0 + pace), "sound");
  StepLimitLower(limit, 0.75 * WCSPH_MOVE_MOST * flow->scene->dx / pace, "advection");
  LimitDissipation(w, flow->ops->forms.h, pace, limit);
  if (flow->scheme->stats.force_max > 0.0)
    StepLimitLower(limit, 0.25 * PetscSqrtReal(flow->ops->forms.h / flow->scheme->stats.force_max),
                   "the body force");
  if (!w->implicit)
    StepLimitLower(limit, ClockExplicitLimit(flow->scene, flow->ops->forms.radius), "viscosity");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns true if a rotation has no force in rows beside a free surface, which do not depend on the
   stress of dummies elsewhere. */
static PetscBool KeepsRotation(const LaplacianForm *visc)
{
  LaplacianForm free = *visc;

  free.continued = PETSC_FALSE;
  return LaplacianIs(&free, FORM_EXACT_LINEAR) || LaplacianIs(&free, FORM_ANGULAR) ? PETSC_TRUE
                                                                                   : PETSC_FALSE;
}

/* Prints a line if the viscous form brakes a motion without strain. */
static PetscErrorCode RigidView(const Flow *flow, PetscViewer viewer)
{
  const LaplacianForm *visc = &flow->ops->forms.visc;

  PetscFunctionBegin;
  if (!visc->row) PetscFunctionReturn(PETSC_SUCCESS);
  if (!LaplacianIs(visc, FORM_NULL_CONSTANTS)) {
    PetscCall(PetscViewerASCIIPrintf(
        viewer,
        "velocity not kept: -visc_laplacian %s brakes a uniform flow of disordered particles; try "
        "cleary\n",
        visc->row->name));
  } else if (SceneHasFreeSurface(flow->scene) && !KeepsRotation(visc)) {
    PetscCall(PetscViewerASCIIPrintf(
        viewer,
        "rotation not kept: -visc_laplacian %s brakes a rotation beside a free surface; try "
        "cleary or energy_fpm\n",
        visc->row->name));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints the equation of state, the integrator, and the step with its limit. */
static PetscErrorCode WcsphView(const Flow *flow, PetscViewer viewer)
{
  const Wcsph *w = (const Wcsph *)flow->scheme->data;
  StepLimit    limit;

  PetscFunctionBegin;
  PetscCall(TableViewRow("state", w->equation, viewer));
  PetscCall(PetscViewerASCIIPrintf(viewer, "%-11s c0 = %.6g m/s, U/c0 = %.3g\n", "sound",
                                   (double)w->c0, (double)(flow->scene->speed / w->c0)));
  PetscCall(TableViewRow("density", w->density, viewer));
  if (w->diffusion > 0.0)
    PetscCall(
        PetscViewerASCIIPrintf(viewer, "%-11s delta = %.3g\n", "diffusion", (double)w->diffusion));
  PetscCall(TableViewRow("reduction", w->reduction, viewer));
  if (w->artificial[0] > 0.0 || w->artificial[1] > 0.0)
    PetscCall(PetscViewerASCIIPrintf(viewer, "%-11s alpha = %.3g, beta = %.3g\n", "artificial",
                                     (double)w->artificial[0], (double)w->artificial[1]));
  PetscCall(TableViewRow("integrator", w->integrator, viewer));
  PetscCall(SchemeLimit(flow, &limit));
  PetscCall(PetscViewerASCIIPrintf(viewer, "%-11s at most %.4g s by %s\n", "step", (double)limit.dt,
                                   limit.reason));
  if (w->visc) PetscCall(ViscosityView(w->visc, viewer));
  PetscCall(RigidView(flow, viewer));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode WcsphDestroy(Flow *flow)
{
  Wcsph *w = (Wcsph *)flow->scheme->data;

  PetscFunctionBegin;
  if (!w) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ViscosityDestroy(&w->visc));
  PetscCall(WcsphFree(w));
  PetscCall(PetscFree(flow->scheme->data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const Stage force = {
    .name = "force", .brief = "largest body force", .Applies = HasForce, .Do = MeasureForce};
static const Stage integrate = {.name  = "integrate",
                                .brief = "places, velocities and densities by the TS",
                                .Do    = WcsphIntegrate};
static const Stage shift     = {
        .name = "shift", .brief = "particles evenly spread", .Applies = Shifts, .Do = WcsphShift};
static const Stage settle = {
    .name = "settle", .brief = "particles off walls, work of the force", .Do = Settle};
static const Stage rebuild = {
    .name = "rebuild", .brief = "owners and neighbours at the new places", .Do = FollowPositions};
static const Stage viscosity = {.name    = "viscosity",
                                .brief   = "implicit viscosity",
                                .Applies = IsImplicit,
                                .Do      = SolveViscosity};
static const Stage volume    = {.name    = "volume",
                                .brief   = "densities that keep the volume",
                                .Applies = KeepsVolume,
                                .Do      = RestoreVolume};
static const Stage pressure  = {
     .name = "pressure", .brief = "density and pressure, Mach number", .Do = SetPressureAndMeasure};

static const Stage *const stages[] = {&force,     &integrate,  &shift,  &settle,   &rebuild,
                                      &viscosity, &StageCheck, &volume, &pressure, NULL};

static const Judge *const judges[] = {&JudgeFailure, NULL};

const SchemeRow SchemeWcsph = {
    .name     = "wcsph",
    .brief    = "weakly compressible: density and an equation of state, no pressure matrix",
    .citation = "Monaghan, J. Comput. Phys. 110 (1994)",
    .Create   = WcsphCreate,
    .SetUp    = WcsphSetUp,
    .Register = WcsphRegister,
    .Begin    = WcsphBegin,
    .Limit    = WcsphLimit,
    .View     = WcsphView,
    .Destroy  = WcsphDestroy,
    .stages   = stages,
    .judges   = judges,
};
