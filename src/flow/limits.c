/* Limits of the time step that schemes share. */
#include "isph/flow.h"

#define PERIOD_STEPS 20.0 /* least number of steps in a period of walls or forces */

/*
  ClockExplicitLimit - Returns the largest stable step of an explicit viscous term [s]

    dt = 0.125 h^2/(largest nu),   h half the smallest radius of a support, for every form
*/
PetscReal ClockExplicitLimit(const Scene *scene, PetscReal support_radius)
{
  return SceneHas(scene, PHYSICS_VISCOSITY)
             ? 0.125 * PetscSqr(0.5 * support_radius * SceneFinest(scene) / SceneCoarsest(scene)) /
                   scene->nu_high
             : PETSC_INFINITY;
}

/* Returns t_v + sqrt(t_v^2 + t_c^2), the longest step of waves of inertia that viscosity slows. */
static PetscReal WaveStep(PetscReal viscous, PetscReal square)
{
  return viscous + PetscSqrtReal(PetscSqr(viscous) + square);
}

/*
  CapillaryLimit - Returns the longest step of moving particles with surface tension; infinity
  without it [s]

    dt = t_v + sqrt(t_v^2 + t_c^2),   t_c^2 = rho dx^3/(4 pi sigma),   t_v = mu dx/(4 sigma)

  The pressure sigma kappa belongs to the positions at which the step solves for the velocity. t_c
  bounds capillary waves of inertia, t_v those that viscosity slows. For small displacements steps
  are stable up to about ten times this limit: theory.md, (surface:step). Surfaces whose particles
  are disordered by large displacements need shorter steps. Reference: C. Galusinski, P. Vigneaux,
  J. Comput. Phys. 227 (2008) 6140-6164
*/
PetscReal CapillaryLimit(const Scene *scene)
{
  const PetscReal sigma = scene->tension, dx = scene->dx;
  PetscReal       viscous;

  if (sigma == 0.0 || !SceneMoves(scene)) return PETSC_INFINITY;
  viscous = SceneHas(scene, PHYSICS_VISCOSITY) ? 0.25 * scene->rho * scene->nu * dx / sigma : 0.0;
  return WaveStep(viscous, scene->rho * dx * dx * dx / (4.0 * PETSC_PI * sigma));
}

/*
  InterfaceLimit - Returns the longest step of moving fluids of several densities, or whose
  interfaces have a tension; infinity without them [s]

    tension   t_c^2 = (rho_a + rho_b) dx^3/(4 pi sigma),    t_v = mu dx/(4 sigma)
    weight    t_c^2 = (rho_a + rho_b) dx/(pi |rho_a - rho_b| f),   t_v = mu/(|rho_a - rho_b| f dx)

  As in CapillaryLimit(); the lightest pair of fluids and the least viscosity mu count. The weight
  is that of gravity waves as long as two particles.
*/
PetscReal InterfaceLimit(const Scene *scene)
{
  const PetscReal dx = scene->dx;
  const PetscReal mu = SceneHas(scene, PHYSICS_VISCOSITY) ? scene->rho * scene->nu_low : 0.0;
  PetscReal       f = 0.0, limit = PETSC_INFINITY;

  for (PetscInt a = 0; a < scene->dim; a++) f += PetscSqr(scene->body_force[a]);
  f = PetscSqrtReal(f);
  for (PetscInt k = 1; SceneMixes(scene) && k < SceneFluids(scene); k++) {
    const PetscReal sigma = scene->region_tension[k - 1];

    for (PetscInt m = 0; m < k; m++) {
      const PetscReal a      = scene->rho * SceneFluidDensity(scene, k);
      const PetscReal b      = scene->rho * SceneFluidDensity(scene, m),
                      weight = PetscAbsReal(a - b) * f;

      if (sigma > 0.0)
        limit = PetscMin(limit, WaveStep(0.25 * mu * dx / sigma,
                                         (a + b) * dx * dx * dx / (4.0 * PETSC_PI * sigma)));
      if (weight > 0.0)
        limit = PetscMin(limit, WaveStep(mu / (weight * dx), (a + b) * dx / (PETSC_PI * weight)));
    }
  }
  return limit;
}

/* Returns the largest speed of the surface of a body that moves, at time t [m/s]. */
static PetscReal BodySpeed(const Scene *scene, PetscReal t)
{
  PetscReal most = 0.0;

  for (PetscInt k = 0; scene->pose && k < scene->n_bodies; k++) {
    const PetscInt side = SceneBodySide(scene, k);
    PetscReal      u[ISPH_MAX_DIM], spin[ISPH_MAX_DIM], u2 = 0.0, spin2 = 0.0;

    if (!scene->boundary[side].moves) continue;
    BodyMotion(scene, side, t, u, spin);
    for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) {
      u2 += PetscSqr(u[a]);
      spin2 += PetscSqr(spin[a]);
    }
    most = PetscMax(most,
                    PetscSqrtReal(u2) + PetscSqrtReal(spin2) * BoundaryBody(scene, side)->extent);
  }
  return most;
}

/*
  FlowLimit - Limits the step by advection, by bodies that move, by the body force, by surface
  tension, and by the period of the driving

    dt <= C dx/U,   dt <= C/(g |(u_a/e_a)_i|),   dt <= max(sqrt(C e/|f|), C e r/|f|)

  C is the CFL number, dx the reference spacing, e_a the edges of the cell of a particle, e the
  smallest of all edges, and f the body force. g = 1, or g = max(m, 1 - m) for graded particles that
  move with the factor m of SceneMotionFactor(). A force alone moves a particle by f dt^2 in a step,
  or by f dt/r if walls at rest slow the flow at the rate r (SceneDecayRate()); so very viscous
  flows need no short steps. With -dt_adapt none only the reference speed U is used. With -dt_adapt
  error a period of walls or forces takes at least PERIOD_STEPS steps. -dt_max bounds all steps.
*/
PetscErrorCode FlowLimit(const Flow *flow, StepLimit *limit)
{
  const Scene     *scene = flow->scene;
  const Clock     *clock = flow->clock;
  const StepStats *stats = &flow->scheme->stats;
  const PetscReal  way   = clock->cfl * SceneFinest(scene);

  PetscFunctionBegin;
  StepLimitLower(limit, clock->dt_max, "-dt_max");
  StepLimitLower(limit, CapillaryLimit(scene), "surface tension");
  StepLimitLower(limit, InterfaceLimit(scene), "waves of interfaces");
  if (scene->pose)
    StepLimitLower(limit, way / BodySpeed(scene, clock->t + clock->dt), "the motion of bodies");
  if (!clock->adapt->follows) {
    StepLimitLower(limit, way / scene->speed, "advection with U");
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  StepLimitLower(limit, clock->cfl * scene->dx / PetscMax(scene->speed, stats->pace_max),
                 "advection");
  if (SceneHas(scene, PHYSICS_CONVECTION) && stats->force_max > 0.0) {
    StepLimitLower(limit,
                   PetscMax(PetscSqrtReal(way / stats->force_max),
                            way * SceneDecayRate(scene) / stats->force_max),
                   "the body force");
  }
  if (clock->adapt->estimates) {
    const PetscReal period = SceneDrivingPeriod(scene, clock->t, PERIOD_STEPS * limit->dt,
                                                0.1 * clock->control.rtol * scene->speed);

    StepLimitLower(limit, period / PERIOD_STEPS, "the period of walls or forces");
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
