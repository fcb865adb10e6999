/*
  The energy balance of moving fluids with a free surface: per mass, from places and velocities of
  the particles,

    |u|^2/2 + D <= |u(0)|^2/2 + sigma A(0)/M + W,   W = sum_i m_i int f.dx_i/M,
    D = int 2 nu <E:E> dt,

  in flight less the least energy that the surface can have, for walls at rest, with the
  dissipation of their pair forces for rough particles. |u| is the root mean square. A fluid that
  breaks the balance has velocities or a height that neither the start nor the body force gives.
  The bound on the speed of full boxes does not hold here: a fluid that falls touches no wall that
  slows it. See theory.md, (surface:energy).
*/
#include "isph/balance.h"
#include "isph/strain.h"

#define HEIGHT   0.05 /* error of the height at which particles of a fluid at rest are [dx] */
#define LOST     2.0  /* energy of a flow that is lost over the most that it can have [-] */
#define ROUNDING 1e-6 /* speed of a fluid at rest [U] */

/* EnergyWork - Returns the work of the body force on own particle i, whose path in a step is `path`
   [m], over the mass of a particle of weight 1 of fluid 0 [m^2/s^2] */
PetscReal EnergyWork(const Flow *flow, PetscInt i, const PetscReal path[])
{
  const Particles *p    = flow->particles;
  PetscReal        work = 0.0, middle[ISPH_MAX_DIM], f[ISPH_MAX_DIM];

  if (!SceneHasFreeSurface(flow->scene) || !SceneHas(flow->scene, PHYSICS_BODY_FORCE)) return 0.0;
  for (PetscInt a = 0; a < p->dim; a++) middle[a] = p->x[a][i] + 0.5 * path[a];
  SceneBodyForce(flow->scene, flow->clock->t + 0.5 * flow->clock->dt, middle, f);
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

/* Returns 2 E:E = sum_ab (d_a u_b + d_b u_a)^2/2 at own particle i [1/s^2]. Input: gradient -
   d_a u_c at [c][a]. */
static PetscReal StrainSquare(PetscInt dim, const PetscScalar *gradient[][ISPH_MAX_DIM], PetscInt i)
{
  PetscReal square = 0.0;

  for (PetscInt a = 0; a < dim; a++) {
    for (PetscInt b = 0; b < dim; b++)
      square += 0.5 * PetscSqr(gradient[b][a][i] + gradient[a][b][i]);
  }
  return square;
}

/* Returns the viscosity of particle i over that of the scene [-]. */
static PetscReal ViscosityRatio(const Flow *flow, PetscInt i)
{
  return flow->particles->nu ? flow->particles->nu[i] / flow->scene->nu : 1.0;
}

/*
  Returns the dissipation over the nu of the scene by the row of particle i,

    sum_k s_k n_ik (u_k - u_i).w_ik (u_k - u_i),   s_k = 1/2, of pair forces 1 for walls, at rest

  with the viscosity n_ik of the pair over nu. For a row of a fit this is 2 E:E + (div u)^2.

  The fit of a gradient at a particle with two or three neighbours has no meaning: it made up most
  of the dissipation of thin noses. Across a jump of the viscosity it has the velocities of both
  fluids, and its square times the larger viscosity was up to 17 times the energy of the flow. u:
  velocities of all particles, by [i dim + a] [m/s].
*/
static PetscReal PairSquare(const Flow *flow, const PetscReal u[], PetscInt i)
{
  const Operators       *ops    = flow->ops;
  const PetscInt         dim    = flow->scene->dim;
  const PetscReal        own    = ViscosityRatio(flow, i);
  const AffineOperator  *op     = &ops->velocity[0].visc;
  const Pattern *const   of[]   = {&ops->rows.fluid, &ops->rows.walls};
  const PetscReal *const w[]    = {op->a, ops->forms.wall ? op->b : NULL};
  PetscReal              sum[2] = {0.0, 0.0};

  for (PetscInt part = 0; part < 2 && w[part]; part++) {
    for (PetscInt s = of[part]->row[i]; s < of[part]->row[i + 1]; s++) {
      const PetscInt  j     = of[part]->local[s];
      const PetscReal ratio = part == 0 ? PairViscosity(own, ViscosityRatio(flow, j)) : own;
      PetscReal       difference[ISPH_MAX_DIM];

      for (PetscInt a = 0; a < dim; a++)
        difference[a] = (part == 0 ? u[j * dim + a] : 0.0) - u[i * dim + a];
      if (part == 0 && j == i) continue;
      for (PetscInt e = 0; e < dim * dim; e++)
        sum[part] += ratio * w[part][s * op->width + e] * difference[e / dim] * difference[e % dim];
    }
  }
  return 0.5 * sum[0] + (FreeSurfaceIsRough(ops->free, i) ? 1.0 : 0.5) * sum[1];
}

/* Computes the weighted sum of 2 E:E over own particles, times their viscosity over that of the
   scene, with PairSquare() for rough ones and for fluids of several viscosities. */
static PetscErrorCode SumSquares(const Flow *flow, const Vec u[],
                                 const PetscScalar *gradient[][ISPH_MAX_DIM], PetscReal *sum)
{
  const Particles *p       = flow->particles;
  const PetscBool  several = p->nu && SceneIsNewtonian(flow->scene);
  PetscReal       *all     = NULL;

  PetscFunctionBegin;
  *sum = 0.0;
  if (several || flow->ops->free->has_rough) PetscCall(FlowAllVelocities(flow, u, &all));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    const PetscReal square = several || FreeSurfaceIsRough(flow->ops->free, i)
                                 ? PairSquare(flow, all, i)
                                 : ViscosityRatio(flow, i) * StrainSquare(p->dim, gradient, i);

    *sum += ParticlesWeight(p, i) * square;
  }
  PetscCall(PetscFree(all));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the sum of SumSquares() with gradients of the velocity u [1/s^2]. */
static PetscErrorCode StrainPower(Flow *flow, const Vec u[], PetscReal *power)
{
  const Particles   *p = flow->particles;
  const PetscScalar *gradient[ISPH_MAX_DIM][ISPH_MAX_DIM];
  Vec                y[ISPH_MAX_DIM][ISPH_MAX_DIM];

  PetscFunctionBegin;
  for (PetscInt c = 0; c < p->dim; c++) {
    for (PetscInt a = 0; a < p->dim; a++) {
      PetscCall(FlowGetWork(flow, &y[c][a]));
      PetscCall(AffineApply(&OperatorsOfVelocity(flow->ops, c)->grad_u[a], u[c], flow->walls.u[c],
                            y[c][a]));
      PetscCall(VecGetArrayRead(y[c][a], &gradient[c][a]));
    }
  }
  PetscCall(SumSquares(flow, u, gradient, power));
  for (PetscInt c = 0; c < p->dim; c++) {
    for (PetscInt a = 0; a < p->dim; a++) {
      PetscCall(VecRestoreArrayRead(y[c][a], &gradient[c][a]));
      PetscCall(FlowRestoreWork(flow, &y[c][a]));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the sum of -u.(A u) over own particles for pair forces, which have no power on the
   surface [1/s^2]. */
static PetscErrorCode PairPower(const Flow *flow, const Vec u[], PetscReal *power)
{
  const Particles   *p = flow->particles;
  const Mat          A = flow->ops->velocity[0].visc.A;
  const PetscScalar *v, *f;
  Vec                x, y;

  PetscFunctionBegin;
  *power = 0.0;
  PetscCall(MatCreateVecs(A, &x, &y));
  for (PetscInt c = 0; c < p->dim; c++) PetscCall(VecStrideScatter(u[c], c, x, INSERT_VALUES));
  PetscCall(MatMult(A, x, y));
  PetscCall(VecGetArrayRead(x, &v));
  PetscCall(VecGetArrayRead(y, &f));
  for (PetscInt e = 0; e < p->n_fluid * p->dim; e++)
    *power -= ParticlesWeight(p, e / p->dim) * LaplacianShare(&flow->ops->forms.visc, e / p->dim) *
              PetscRealPart(v[e] * f[e]);
  PetscCall(VecRestoreArrayRead(x, &v));
  PetscCall(VecRestoreArrayRead(y, &f));
  PetscCall(VecDestroy(&x));
  PetscCall(VecDestroy(&y));
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
  for (PetscInt c = 0; c < cells->n; c++) {
    PetscReal x[ISPH_MAX_DIM];

    for (PetscInt a = 0; a < p->dim; a++) x[a] = cells->centre[a][c];
    if (ParticlesHolds(p, x))
      *power += cells->volume[c] / p->cell_volume * cells->nu[c] / flow->scene->nu *
                PetscSqr(cells->rate[c]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the energy per mass that viscosity takes in the step, if the velocity is u, between
   walls at rest [m^2/s^2]; zero, which loosens the bound, without assembled operators. */
static PetscErrorCode Dissipation(Flow *flow, const Vec u[], PetscReal *energy)
{
  const Particles     *p    = flow->particles;
  const LaplacianForm *form = &flow->ops->forms.visc;

  PetscFunctionBegin;
  *energy = 0.0;
  if (!form->row || flow->ops->needs & NEED_STREAMS) PetscFunctionReturn(PETSC_SUCCESS);
  if (flow->ops->strain) PetscCall(CellPower(flow, u, energy));
  else if (LaplacianIs(form, FORM_SYMMETRIC) || form->halved) PetscCall(PairPower(flow, u, energy));
  else PetscCall(StrainPower(flow, u, energy));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, energy, 1, MPIU_REAL, MPIU_SUM, p->comm));
  *energy *= flow->scene->nu * flow->clock->dt / Mass(flow);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* EnergyTension - Computes twice the energy of the surface tension over the mass of the fluid
   [m^2/s^2]; each particle on the surface has the area dx^(dim-1); collective */
PetscErrorCode EnergyTension(const Flow *flow, PetscReal *energy)
{
  const Scene     *scene = flow->scene;
  const Particles *p     = flow->particles;
  PetscReal        sum   = 0.0;

  PetscFunctionBegin;
  *energy = flow->state->tension_energy;
  if (scene->tension == 0.0 || flow->ops->cut_surface) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt i = 0; i < p->n_fluid; i++)
    if (FreeSurfaceHolds(flow->ops->free, i)) sum += SceneVolume(scene) / scene->dx;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPIU_REAL, MPIU_SUM, p->comm));
  *energy = 2.0 * scene->tension * sum / (scene->rho * p->weight * p->cell_volume);
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

  if (flow->scheme->sheet.flight.on == 0.0 || SceneHasBoundary(scene, BOUNDARY_CONTINUES))
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
