/*
  Fluids of different density, and the tension of their interfaces, in a pressure on splines.

  A smooth pressure has no kink at an interface, where its gradient jumps from rho_1 a to rho_2 a.
  So the inertia of particles is the mean density of the splines, and weights act where the
  pressure can balance them: with the shares C^k of fluid k,

    C^k_q = sum_i V_i c^k_i psi_q(x_i)/W_q,  W_q = sum_i V_i psi_q(x_i),  rho_q = sum_k rho_k C^k_q
    rho(x_i) du_i/dt = -grad p + rho_i f - sum_k sum_q L^k_q (c^k_i - C^k_q) grad psi_q(x_i) + ...
    L^k_q = sigma_k kappa^k(y_q) - (rho_k - rho_0) f.(y_q - x_q)
    kappa^k_q = 1/W_q d/dC^k_q int |grad C^k| dV

  c^k_i is the share of fluid k in a particle: 1 or 0, but in cells that an interface cut at the
  start. y_q is the point of the surface C^k = 1/2 nearest to the centre x_q of a spline. kappa is
  the derivative of the area, and has its value at y_q. The second term moves the weight of fluid k,
  in excess of fluid 0, onto its surface. A constant L^k has the force L^k grad C^k, which the
  gradient of a spline balances exactly: so have a round drop and layers at rest. Far from
  interfaces the force is rho_k f.

  Source: theory.md, (densities:share), (densities:momentum) and (densities:jump). The derivative of
  the area is that of K. A. Brakke, Exp. Math. 1 (1992) 141-165.
*/
#include "splines.h"

#define SHARE_LEAST 1e-9 /* of a fluid in a spline: below it the spline has one fluid */
#define MARCH       0.25 /* step of the search for a surface [edges of a cell] */
#define MARCHES     16
#define REFINEMENTS 48
#define SLOPE_LEAST 1e-2 /* gradients of shares below it have no direction [1/edge of a cell] */

static PetscErrorCode CreateVectors(const Splines *s, SplineMixture *m)
{
  PetscFunctionBegin;
  PetscCall(SplineMixtureFree(m));
  PetscCall(VecDuplicate(s->mass, &m->volume));
  PetscCall(VecDuplicate(s->mass, &m->share));
  PetscCall(VecDuplicate(s->mass, &m->density));
  PetscCall(VecDuplicate(s->mass, &m->potential));
  PetscCall(VecScatterCreateToAll(s->mass, &m->collect, &m->all));
  m->numbering = s->numbering;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the sums of V_i psi_q(x_i) over the particles of a fluid, over all if it is negative. */
static PetscErrorCode SumVolumes(const Particles *p, Splines *s, PetscInt fluid, Vec sum)
{
  SplineWindow       *w     = &s->window;
  const SplinePlaces *at    = &s->at;
  const PetscInt      plane = p->dim == 3 ? w->n[0] * w->n[1] : 0;

  PetscFunctionBegin;
  PetscCall(PetscArrayzero(w->value, w->size));
  for (PetscInt i = 0; i < at->n; i++) {
    const PetscReal share = fluid < 0 ? 1.0 : ParticlesFluidShare(p, i, fluid);
    PetscReal       b[ISPH_MAX_DIM][SPLINES_ALONG] = {{0.0}}, slope[SPLINES_ALONG];

    if (share == 0.0) continue;
    for (PetscInt a = 0; a < p->dim; a++)
      SplineBasis(2, at->t[a][i], at->per_edge[a][i], b[a], slope);
    if (p->dim == 2) b[2][0] = 1.0;
    for (PetscInt k = 0; k < (p->dim == 3 ? 27 : 9); k++)
      w->value[at->base[i] + k / 9 * plane + k / 3 % 3 * w->n[0] + k % 3] +=
          share * ParticlesWeight(p, i) * p->cell_volume * b[0][k % 3] * b[1][k / 3 % 3] *
          b[2][k / 9];
  }
  PetscCall(SplineWindowSum(w, sum));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the share of a fluid in all splines, and keeps all of them on each rank. */
static PetscErrorCode SetShare(const Particles *p, PetscInt fluid, Splines *s)
{
  SplineMixture *m = &s->mixture;

  PetscFunctionBegin;
  PetscCall(SumVolumes(p, s, fluid, m->share));
  PetscCall(VecPointwiseDivide(m->share, m->share, m->volume));
  PetscCall(VecScatterBegin(m->collect, m->share, m->all, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecScatterEnd(m->collect, m->share, m->all, INSERT_VALUES, SCATTER_FORWARD));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Moves a point along the gradient of the share to the surface on which it is a half, by steps and
   then Newton's method between bounds; returns false if there is none near it. */
static PetscBool MoveToSurface(const Splines *s, const Particles *p, const PetscScalar all[],
                               PetscReal x[])
{
  PetscReal       n[ISPH_MAX_DIM], slope[ISPH_MAX_DIM], from[ISPH_MAX_DIM], size = 0.0;
  PetscReal       low = 0.0, high = 0.0, d = 0.0, last = -1.0;
  const PetscReal start = SplineSumAt(s, p, all, x, n) - 0.5;

  for (PetscInt a = 0; a < p->dim; a++) {
    size += n[a] * n[a];
    from[a] = x[a];
  }
  if (size == 0.0) return PETSC_FALSE;
  for (PetscInt a = 0; a < p->dim; a++) n[a] *= (start > 0.0 ? -1.0 : 1.0) / PetscSqrtReal(size);
  for (PetscInt k = 0; k < MARCHES + REFINEMENTS; k++) {
    PetscReal value, along = 0.0;

    if (high == 0.0 && k == MARCHES) return PETSC_FALSE;
    if (high == 0.0) d = low + MARCH * s->scale;
    else if (d <= low || d >= high) d = 0.5 * (low + high);
    if (d == last) break;
    for (PetscInt a = 0; a < p->dim; a++) x[a] = from[a] + d * n[a];
    value = SplineSumAt(s, p, all, x, slope) - 0.5;
    for (PetscInt a = 0; a < p->dim; a++) along += slope[a] * n[a];
    if (value * start > 0.0) low = d;
    else high = d;
    last = d;
    d -= along != 0.0 ? value / along : 0.0;
  }
  return PETSC_TRUE;
}

/* Sets the potential to sigma kappa, and adds the energy of the surface [J]. */
static PetscErrorCode SetTension(const Particles *p, PetscReal sigma, Splines *s, PetscReal *energy)
{
  SplineMixture  *m     = &s->mixture;
  const PetscReal least = SLOPE_LEAST / s->scale;
  PetscReal      *n;
  PetscScalar     area;

  PetscFunctionBegin;
  PetscCall(VecZeroEntries(m->potential));
  if (sigma == 0.0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(p->dim * s->inside.n, &n));
  PetscCall(SplinesGradientAtPoints(s, m->share, n));
  for (PetscInt g = 0; g < s->inside.n; g++) {
    PetscReal size = PetscSqr(least);

    for (PetscInt a = 0; a < p->dim; a++) size += PetscSqr(n[p->dim * g + a]);
    for (PetscInt a = 0; a < p->dim; a++) n[p->dim * g + a] /= PetscSqrtReal(size);
  }
  PetscCall(SplinesIntegrateField(s, n, m->potential));
  PetscCall(VecDot(m->share, m->potential, &area));
  *energy += sigma * PetscRealPart(area) * PetscPowReal(s->scale, (PetscReal)(p->dim - 1));
  PetscCall(PetscFree(n));
  PetscCall(VecScale(m->potential, sigma * PetscPowReal(s->scale, (PetscReal)(p->dim - 1))));
  PetscCall(VecPointwiseDivide(m->potential, m->potential, m->volume));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the mean of the potentials of splines around a point of the surface, with the weights
   C (1 - C) psi: far from the surface the direction of the gradient is not sure. */
static PetscReal MeanAt(const Splines *s, const Particles *p, const PetscScalar share[],
                        const PetscScalar potential[], const PetscReal x[])
{
  PetscReal sum = 0.0, weights = 0.0;
  SplineRow at;

  SplineRowAt(s, &s->lattice, p, x, &at);
  for (PetscInt k = 0; k < at.n; k++) {
    const PetscReal C = share[at.number[k]], w = PetscMax(C * (1.0 - C), 0.0) * at.value[k];

    sum += w * potential[at.number[k]];
    weights += w;
  }
  return weights > 0.0 ? sum / weights : 0.0;
}

/* Gives splines beside the surface of a fluid the potential at its nearest point, and adds the
   weight of the fluid in excess of fluid 0. */
static PetscErrorCode MovePotential(const Particles *p, const PetscReal excess[], Splines *s)
{
  SplineMixture     *m = &s->mixture;
  const PetscScalar *share, *all;
  PetscScalar       *potential;
  Vec                every;

  PetscFunctionBegin;
  PetscCall(VecDuplicate(m->all, &every));
  PetscCall(VecScatterBegin(m->collect, m->potential, every, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecScatterEnd(m->collect, m->potential, every, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecGetArrayRead(m->all, &share));
  PetscCall(VecGetArrayRead(every, &all));
  PetscCall(VecGetArray(m->potential, &potential));
  for (PetscInt k = 0; k < s->own.size; k++) {
    const PetscReal C = share[s->own.start + k];
    PetscInt        index[ISPH_MAX_DIM];
    PetscReal       x[ISPH_MAX_DIM] = {0.0}, y[ISPH_MAX_DIM];

    if (!SplineOwn(s, k, index) || C < SHARE_LEAST || C > 1.0 - SHARE_LEAST) continue;
    SplineCentre(&s->lattice, index, x);
    PetscCall(PetscArraycpy(y, x, p->dim));
    if (!MoveToSurface(s, p, share, y)) continue;
    potential[k] = MeanAt(s, p, share, all, y);
    for (PetscInt a = 0; a < p->dim; a++) potential[k] -= excess[a] * (y[a] - x[a]);
  }
  PetscCall(VecRestoreArray(m->potential, &potential));
  PetscCall(VecRestoreArrayRead(every, &all));
  PetscCall(VecRestoreArrayRead(m->all, &share));
  PetscCall(VecDestroy(&every));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the force of the surface of a fluid to those of particles [N/m^3]. */
static PetscErrorCode AddSurfaceForce(const Particles *p, PetscInt fluid, Splines *s,
                                      PetscReal force[])
{
  SplineMixture *m = &s->mixture;

  PetscFunctionBegin;
  PetscCall(SplinesGradient(s, m->potential, s->fits.value));
  for (PetscInt i = 0; i < p->n_fluid; i++)
    for (PetscInt a = 0; a < p->dim; a++)
      force[p->dim * i + a] -= ParticlesFluidShare(p, i, fluid) * s->fits.value[p->dim * i + a];
  PetscCall(VecPointwiseMult(m->potential, m->potential, m->share));
  PetscCall(SplinesGradient(s, m->potential, s->fits.value));
  for (PetscInt k = 0; k < p->dim * p->n_fluid; k++) force[k] += s->fits.value[k];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the inertia of particles from the densities of splines. */
static PetscErrorCode SetInertia(Flow *flow, Splines *s)
{
  SplineMixture     *m = &s->mixture;
  const PetscScalar *from;
  Vec                work;

  PetscFunctionBegin;
  PetscCall(FlowGetWork(flow, &work));
  PetscCall(SplinesValue(s, m->density, work));
  PetscCall(PetscFree(m->inertia));
  PetscCall(PetscMalloc1(s->at.n, &m->inertia));
  PetscCall(VecGetArrayRead(work, &from));
  PetscCall(PetscArraycpy(m->inertia, from, s->at.n));
  PetscCall(VecRestoreArrayRead(work, &from));
  PetscCall(FlowRestoreWork(flow, &work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplinesMix - Computes the inertia of particles, rho(x_i)/rho_0, and the forces of interfaces for
   the present positions; divides the rows of viscous matrices by the inertia. Collective. Does
   nothing without a mixture, see SceneMixes(), below a free surface, where each fluid has splines
   of its own, or if positions are those of the last call. Output: mixture.inertia [-];
   state->interface, the force per unit mass less f [m/s^2]. */
PetscErrorCode SplinesMix(Flow *flow, Splines *s)
{
  const Scene     *scene   = flow->scene;
  const Particles *p       = flow->particles;
  SplineMixture   *m       = &s->mixture;
  const Mat        rows[2] = {flow->ops->velocity[0].visc.A, flow->ops->velocity[0].visc.B};
  PetscReal       *force, f[ISPH_MAX_DIM] = {0.0}, energy = 0.0, mean;
  PetscScalar     *to;

  PetscFunctionBegin;
  if (!SceneMixes(scene) || s->in_cells || m->assemblies == s->assemblies)
    PetscFunctionReturn(PETSC_SUCCESS);
  m->assemblies = s->assemblies;
  PetscCall(FlowStateRenumber(flow));
  if (m->numbering != s->numbering) PetscCall(CreateVectors(s, m));
  if (SceneHas(scene, PHYSICS_BODY_FORCE))
    SceneBodyForce(scene, flow->clock->t + flow->clock->dt, scene->lo, f);
  PetscCall(PetscCalloc1(p->dim * p->n_fluid, &force));
  PetscCall(SumVolumes(p, s, -1, m->volume));
  PetscCall(VecSet(m->density, 1.0));
  for (PetscInt k = 1; k < SceneFluids(scene); k++) {
    const PetscReal excess = SceneFluidDensity(scene, k) - 1.0;
    PetscReal       weight[ISPH_MAX_DIM];

    for (PetscInt a = 0; a < p->dim; a++) weight[a] = scene->rho * excess * f[a];
    PetscCall(SetShare(p, k, s));
    PetscCall(VecAXPY(m->density, excess, m->share));
    PetscCall(SetTension(p, scene->region_tension[k - 1], s, &energy));
    PetscCall(MovePotential(p, weight, s));
    PetscCall(AddSurfaceForce(p, k, s, force));
  }
  PetscCall(SetInertia(flow, s));
  PetscCall(VecDot(m->density, m->volume, &mean));
  flow->state->tension_energy = 2.0 * energy / (scene->rho * mean);
  for (PetscInt a = 0; a < p->dim; a++) {
    PetscCall(VecGetArrayWrite(flow->state->interface[a], &to));
    for (PetscInt i = 0; i < p->n_fluid; i++)
      to[i] = (ParticlesDensity(scene, p, i) * f[a] + force[p->dim * i + a]) /
                  (scene->rho * m->inertia[i]) -
              f[a];
    PetscCall(VecRestoreArrayWrite(flow->state->interface[a], &to));
  }
  PetscCall(PetscFree(force));
  PetscCall(SplineStiffnessFollow(s, p));
  for (PetscInt w = 0; w < 2; w++)
    if (rows[w]) PetscCall(SplinesDivideRows(s, p, rows[w]));
  PetscFunctionReturn(PETSC_SUCCESS);
}
