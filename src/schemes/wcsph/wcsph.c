/*
  The weakly compressible scheme: an explicit step of

    dx/dt = u,   drho/dt = -rho div u,   du/dt = -grad p/rho + (div tau)/rho + f,   p = p(rho),

  with the sums of classical SPH. No matrix is assembled.

  References: M. Basa, N. Quinlan, M. Lastiwka, Int. J. Numer. Meth. Fluids 60 (2009); J. Fang et
  al., Appl. Numer. Math. 59 (2009)
*/
#include "schemes/stages/stages.h"
#include "wcsph.h"

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
  UserCheck(!flow->ops->forms.wall || !flow->ops->forms.wall->dynamic || w->density->sums,
            "-wall %s: densities of its walls are sums over the fluid, which needs -density_form "
            "summation",
            flow->ops->forms.wall->name);
  flow->scheme->Divergence  = Compression;
  flow->scheme->bound.sound = WCSPH_SOUND * w->c0;
  w->lattice                = WcsphLatticeSum(flow);
  w->follows = LaplacianFollowsSlopes(&flow->ops->forms.visc, flow->ops->forms.correction->bit);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Registers density and energy, and sets them from the pressure at the start; and the particles
   beside free surfaces at the start, if the viscous form has another gradient there. */
static PetscErrorCode WcsphRegister(Flow *flow)
{
  Particles *p     = flow->particles;
  Wcsph     *w     = (Wcsph *)flow->scheme->data;
  PetscReal  least = PETSC_INFINITY;

  PetscFunctionBegin;
  PetscCall(ParticlesRegister(p, "density", 1, HALO_NONE, ENTRY_MEAN, &w->rho));
  if (WcsphKeepsVolume(flow))
    PetscCall(MemoryAddReal(&flow->scheme->memory, "fluid_volume", &w->volume));
  if (w->equation->has_energy)
    PetscCall(ParticlesRegister(p, "energy", 1, HALO_NONE, ENTRY_MEAN, &w->e));
  if (WcsphComposed(w) && WcsphComposed(w)->gradient == GRADIENT_COUPLED &&
      SceneHasFreeSurface(flow->scene))
    PetscCall(ParticlesRegister(p, "surface_start", 1, HALO_NONE, ENTRY_ZERO, &w->surface));
  if (flow->ops->forms.wall && flow->ops->forms.wall->dynamic)
    PetscCall(ParticlesRegister(p, "wall_start", 1, HALO_NONE, ENTRY_ZERO, &w->wall_start));
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

/*
  Returns the kinematic viscosity of the artificial viscosity, for the mean velocity gradient U/L,
  over that of the fluid

    h (alpha c0 + 0.4 beta h U/L)/(4 (d + 2) nu),   d = dim [-]

  This is half of the value for forces between all pairs, because pairs that separate have none:
  theory.md, (wcsph:viscosity).

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
  if (w->surface && flow->clock->step == 0) PetscCall(WcsphFindSurface(flow, w));
  PetscCall(WcsphReserve(flow, w));
  if (w->wall_start && flow->clock->step == 0) PetscCall(WallStart(w));
  PetscCall(WcsphSetPressure(flow));
  if (flow->clock->step == 0 && WcsphKeepsVolume(flow)) PetscCall(WcsphVolume(flow, &w->volume));
  w->artificial_over_nu = ArtificialShare(flow, w);
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

/* Limits the step by sound, dissipation, the way of particles within the halo and viscosity. */
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
  StepLimitLower(limit, ClockExplicitLimit(flow->scene, flow->ops->forms.radius), "viscosity");
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool KeepsRotation(const LaplacianForm *visc)
{
  return LaplacianIs(visc, FORM_EXACT_LINEAR) || LaplacianIs(visc, FORM_ANGULAR);
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
  PetscCall(SchemeLimit(flow, &limit));
  PetscCall(PetscViewerASCIIPrintf(viewer, "%-11s at most %.4g s by %s\n", "dt", (double)limit.dt,
                                   limit.reason));
  PetscCall(RigidView(flow, viewer));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode WcsphDestroy(Flow *flow)
{
  Wcsph *w = (Wcsph *)flow->scheme->data;

  PetscFunctionBegin;
  if (!w) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(WcsphFree(w));
  PetscCall(PetscFree(flow->scheme->data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

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
    .stages   = WcsphStages,
    .judges   = judges,
    .memory   = {{1.5, 1.5, 1.5, 1.5}, {3.5, 3.5, 3.5, 3.5}},
};
