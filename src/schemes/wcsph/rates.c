/* The rates of change of positions, velocities, densities and energies, computed in one stream over
   the stencils of all particles; with -density_form summation a stream for the density comes
   first. */
#include "wcsph.h"

/* WcsphReserve - Makes room for values of all local particles */
PetscErrorCode WcsphReserve(const Flow *flow, Wcsph *w)
{
  const PetscInt n     = ParticlesAll(flow->particles);
  LocalFlow     *local = &w->local;

  PetscFunctionBegin;
  if (n <= local->capacity) PetscFunctionReturn(PETSC_SUCCESS);
  local->capacity = n + n / 8;
  for (PetscInt a = 0; a < flow->scene->dim; a++) {
    PetscCall(PetscRealloc(local->capacity * sizeof(PetscReal), &local->u[a]));
    PetscCall(PetscRealloc(local->capacity * sizeof(PetscReal), &w->start[a]));
  }
  PetscCall(PetscRealloc(local->capacity * sizeof(PetscReal), &local->rho));
  PetscCall(PetscRealloc(local->capacity * sizeof(PetscReal), &local->p));
  PetscCall(
      PetscRealloc(PACKED(flow->scene->dim) * local->capacity * sizeof(PetscReal), &local->packed));
  if (w->equation->has_energy)
    PetscCall(PetscRealloc(local->capacity * sizeof(PetscReal), &local->e));
  if (w->wall_start) PetscCall(PetscRealloc(local->capacity * sizeof(PetscInt), &local->found));
  if (flow->state->shift->Displace)
    PetscCall(PetscRealloc(WCSPH_COMPONENTS * local->capacity * sizeof(PetscReal), &w->shift));
  if (!WcsphComposed(w)) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt e = 0; e < PetscSqr(flow->scene->dim); e++)
    PetscCall(PetscRealloc(local->capacity * sizeof(PetscReal), &local->stress[e]));
  PetscCall(PetscRealloc(local->capacity * sizeof(PetscReal), &local->divergence));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* WcsphLatticeSum - Returns the kernel sum dx^d sum_j W_ij on a square lattice [-]. Masses are
   rho_0 V over this sum, so that a lattice at rest has the density rho_0 and no pressure. For the
   cubic spline at h/dx = 1.57 it is 1.0033, which would be a pressure of 0.0033 rho_0 c0^2. */
PetscReal WcsphLatticeSum(const Flow *flow)
{
  const OperatorForms *forms = &flow->ops->forms;
  const PetscInt       d     = flow->scene->dim;
  const PetscInt       m     = (PetscInt)(forms->kernel->support * forms->h_over_dx);
  const PetscInt       depth = d > 2 ? m : 0;
  PetscReal            sum   = 0.0, value[3];

  for (PetscInt a = -m; a <= m; a++) {
    for (PetscInt b = -m; b <= m; b++) {
      for (PetscInt c = -depth; c <= depth; c++) {
        const PetscReal r = PetscSqrtReal((PetscReal)(a * a + b * b + c * c));

        KernelEvaluate(forms->kernel, d, forms->h_over_dx, r, value);
        sum += value[0];
      }
    }
  }
  return sum;
}

/* Sums rho_i = sum_j m_j W_ij with the particle itself; m_j: rho_0 V_j over the lattice's sum. */
static PetscErrorCode SumRow(Stencil *st, void *ctx)
{
  Wcsph          *w     = (Wcsph *)ctx;
  const PetscReal rho_0 = w->flow->scene->rho;
  PetscReal       sum   = rho_0 * st->volume * st->self[0];

  PetscFunctionBegin;
  for (PetscInt k = 0; k < st->n; k++) sum += rho_0 * st->V[k] * st->W[k];
  w->local.rho[st->i] = sum / w->lattice;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Packs the volume of the mass at the present density, density, pressure and velocity of all local
   particles. */
static void Pack(const Particles *p, PetscReal rho_0, LocalFlow *l)
{
  PetscReal *to = l->packed;

  for (PetscInt i = 0; i < ParticlesAll(p); i++, to += PACKED(p->dim)) {
    to[0] = p->volume[i] * rho_0 / l->rho[i];
    to[1] = l->rho[i];
    to[2] = l->p[i];
    for (PetscInt a = 0; a < p->dim; a++) to[3 + a] = l->u[a][i];
  }
}

/* WcsphSetDensity - Computes densities and pressures of all local particles at the present
   positions. Collective. Reads local.rho of own fluid (continuity) or computes it (summation), and
   local.e. Output: local.rho, local.p and local.e with the halo. Walls are at rest, unless they are
   dynamic. */
PetscErrorCode WcsphSetDensity(Flow *flow, Wcsph *w)
{
  const Particles *p = flow->particles;
  LocalFlow       *l = &w->local;

  PetscFunctionBegin;
  if (w->density->sums)
    PetscCall(OperatorsStream(flow->scene, p, flow->neighbors, flow->ops, SumRow, w));
  for (PetscInt i = 0; i < p->n_fluid; i++)
    l->p[i] = w->equation->Pressure(w, l->rho[i], l->e ? l->e[i] : 0.0);
  for (PetscInt i = p->n_fluid; i < ParticlesOwn(p); i++) {
    l->rho[i] = flow->scene->rho;
    if (l->e) l->e[i] = w->e_rest;
  }
  if (w->wall_start) PetscCall(WallDensities(w, l->rho));
  for (PetscInt i = p->n_fluid; i < ParticlesOwn(p); i++)
    l->p[i] = w->wall_start ? w->equation->Pressure(w, l->rho[i], w->e_rest) : 0.0;
  PetscCall(ParticlesHaloField(p, l->rho));
  PetscCall(ParticlesHaloField(p, l->p));
  if (l->e) PetscCall(ParticlesHaloField(p, l->e));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the part f of the body force with which dummies continue the pressure. The stress of a
   form of two passes is continued by its slope, which balances the body force along a wall. No
   pressure then balances this force a second time: theory.md, (wcsph:shear). */
static void ContinuingForce(const Wcsph *w, const PetscReal force[], PetscReal f[])
{
  const Scene *scene = w->flow->scene;

  for (PetscInt a = 0; a < scene->dim; a++)
    f[a] = WcsphComposed(w) && SceneIsPeriodic(scene, a) ? 0.0 : force[a];
}

/* Subtracts the mean of the neighbours' pressures from these and from the pressure of the
   particle. */
static void SubtractMean(const Stencil *st, Pairs *pairs, PetscReal *own)
{
  PetscReal mean = 0.0;

  for (PetscInt k = 0; k < st->n; k++) mean += pairs->p[k];
  if (st->n) mean /= (PetscReal)st->n;
  for (PetscInt k = 0; k < st->n; k++) pairs->p[k] -= mean;
  *own -= mean;
}

/* Adds the viscous acceleration mu/rho_i sum_k w_k du_k, with the weights of the chosen form. */
static ISPH_WIDE PetscErrorCode ViscousForce(const Wcsph *w, Stencil *st, const Pairs *pairs,
                                             PetscReal acceleration[])
{
  const Scene         *scene = w->flow->scene;
  const LaplacianForm *form  = &w->flow->ops->forms.visc;
  const PetscInt       d = st->dim, width = LaplacianWidth(form, d);
  const PetscReal      factor = scene->nu * scene->rho / w->local.rho[st->i];

  PetscFunctionBegin;
  PetscCall(LaplacianWeights(form, st, pairs->w));
  if (width == 1) {
    const PetscInt n = LanesPadded(st->n);

    for (PetscInt k = st->n; k < n; k++) pairs->w[k] = 0.0;
    for (PetscInt a = 0; a < d; a++)
      acceleration[a] += factor * LanesSum(n, pairs->w, pairs->du[a]);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (PetscInt k = 0; k < st->n; k++)
    for (PetscInt e = 0; e < d * d; e++)
      acceleration[e / d] += factor * pairs->w[k * d * d + e] * pairs->du[e % d][k];
  if (LaplacianIs(form, FORM_NULL_CONSTANTS)) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt e = 0; e < d * d; e++)
    acceleration[e / d] += factor * st->own[e] * w->local.u[e % d][st->i];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Stores the rates of a particle in the vector of the TS. */
static void StoreRates(Wcsph *w, PetscInt i, const Rates *rates)
{
  const PetscInt n = w->flow->particles->n_fluid, d = w->flow->scene->dim;
  PetscInt       c = 2 * d;

  for (PetscInt a = 0; a < d; a++) {
    w->rate[a * n + i]       = w->local.u[a][i];
    w->rate[(d + a) * n + i] = rates->u[a];
  }
  if (!w->density->sums) w->rate[c++ * n + i] = rates->rho;
  if (w->equation->has_energy) w->rate[c * n + i] = rates->e;
}

/* Computes the rate of the density from the sums over the neighbours. */
static PetscReal ContinuityRate(Wcsph *w, const Stencil *st, const PetscReal force[],
                                const PairSums *sums)
{
  const ComposedForm *composed = WcsphComposed(w);
  const PetscReal     rho      = w->local.rho[st->i];
  const PetscReal     div =
      composed && composed->transposed ? w->local.divergence[st->i] : sums->divergence;
  PetscReal slope[ISPH_MAX_DIM];

  w->divergence = PetscMax(w->divergence, PetscAbsReal(div));
  if (w->diffusion == 0.0) return -rho * div;
  for (PetscInt a = 0; a < st->dim; a++) slope[a] = rho * force[a] / PetscSqr(w->c0);
  return -rho * div + w->diffusion * st->h * w->c0 * (sums->diffusion - HydrostaticRise(st, slope));
}

/* Adds the acceleration by viscosity, and by the artificial viscosity. */
static PetscErrorCode AddViscosity(const Wcsph *w, Stencil *st, const Pairs *pairs,
                                   const PairSums *sums, PetscReal acceleration[])
{
  const Scene    *scene = w->flow->scene;
  const PetscReal rho   = w->local.rho[st->i];

  PetscFunctionBegin;
  if (w->artificial[0] > 0.0 || w->artificial[1] > 0.0)
    ArtificialViscosity(st, pairs, w->artificial, w->c0, rho, acceleration);
  if (w->follows) {
    for (PetscInt a = 0; a < st->dim; a++)
      acceleration[a] += scene->nu * scene->rho / rho * sums->laplacian[a];
  } else if (WcsphComposed(w)) {
    StressForce(w, st, acceleration);
  } else if (w->flow->ops->forms.visc.row) {
    PetscCall(ViscousForce(w, st, pairs, acceleration));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes and stores the rates of a particle from its stencil. */
static PetscErrorCode RateRow(Stencil *st, void *ctx)
{
  Wcsph              *w          = (Wcsph *)ctx;
  const Flow         *flow       = w->flow;
  const ComposedForm *composed   = WcsphComposed(w);
  const PetscBool     transposed = composed && composed->transposed;
  const unsigned      correction = transposed ? 0 : flow->ops->forms.correction->bit;
  const PetscInt      i = st->i, d = st->dim;
  Pairs              *pairs  = &w->pairs;
  const PetscBool     shifts = WcsphShifts(w);
  PetscReal           x[ISPH_MAX_DIM], force[ISPH_MAX_DIM] = {0.0};
  PetscReal           continuing[ISPH_MAX_DIM], C, slope[ISPH_MAX_DIM];
  Rates               rates = {.rho = 0.0};
  PairTerms           own   = {.by_sums   = w->density->sums,
                               .corrected = correction ? PETSC_TRUE : PETSC_FALSE,
                               .rho       = w->local.rho[i],
                               .p         = w->local.p[i] + w->p_rest};
  PairSums            sums;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < d; a++) x[a] = flow->particles->x[a][i];
  if (SceneHas(flow->scene, PHYSICS_BODY_FORCE)) SceneBodyForce(flow->scene, w->t, x, force);
  if (shifts) ConcentrationRow(flow->scene, flow->ops->forms.kernel, st, x, PETSC_FALSE, &C, slope);
  ContinuingForce(w, force, continuing);
  PetscCall(WcsphSetPairs(w, continuing, st));
  StencilGradients(st, correction);
  for (PetscInt k = 0; w->p_rest > 0.0 && k < st->n; k++) pairs->p[k] += w->p_rest;
  if (w->equation->has_energy) rates.e = PairsEnergy(st, pairs, own.rho, own.p);
  if (w->reduction->mean && !transposed) SubtractMean(st, pairs, &own.p);
  PairsSum(st, pairs, &own, &sums);
  rates.rho = ContinuityRate(w, st, force, &sums);
  for (PetscInt a = 0; a < d; a++) rates.u[a] = force[a] + (transposed ? 0.0 : sums.pressure[a]);
  PetscCall(AddViscosity(w, st, pairs, &sums, rates.u));
  StoreRates(w, i, &rates);
  if (shifts) WcsphShiftRow(w, st, slope);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  WcsphRates - Computes the rates of all own fluid particles at positions, velocities, densities and
  energies of local values

    dx/dt = u,   drho/dt = -rho div u + delta h c0 lap rho,   de/dt by the pressure,
    du/dt = -grad p/rho + (div tau)/rho + f

  Collective. Input: local.u, local.rho and local.e of own fluid; w->t. Output: w->rate, local.p.
*/
PetscErrorCode WcsphRates(Flow *flow, Wcsph *w)
{
  Particles *p = flow->particles;
  LocalFlow *l = &w->local;

  PetscFunctionBegin;
  PetscCall(PetscLogEventBegin(w->event, 0, 0, 0, 0));
  PetscCall(WallValuesSetVelocity(flow->scene, p, w->t, 0.0, &flow->walls));
  for (PetscInt a = 0; a < flow->scene->dim; a++)
    for (PetscInt i = p->n_fluid; i < ParticlesOwn(p); i++) l->u[a][i] = p->u[a][i];
  PetscCall(ParticlesHaloComponents(p, l->u));
  if (w->wall_start) PetscCall(WallVelocities(w));
  PetscCall(WcsphSetDensity(flow, w));
  Pack(p, flow->scene->rho, l);
  PetscCall(OperatorsStreamFactors(flow->scene, p, flow->neighbors, flow->ops));
  PetscCall(WcsphStresses(flow, w));
  w->divergence = 0.0;
  PetscCall(OperatorsStream(flow->scene, p, flow->neighbors, flow->ops, RateRow, w));
  w->first_stage = PETSC_FALSE;
  PetscCall(PetscLogEventEnd(w->event, 0, 0, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* WcsphAccelerate - Computes the accelerations of own fluid at the present positions [m/s^2];
   collective. Note: needs the rows of neighbours. */
PetscErrorCode WcsphAccelerate(const Flow *flow, PetscReal *const rate[])
{
  Wcsph          *w = (Wcsph *)flow->scheme->data;
  const PetscReal t = w->t, divergence = w->divergence;
  const PetscBool first = w->first_stage;
  const PetscInt  n = flow->particles->n_fluid, d = flow->scene->dim;
  PetscReal      *rates, *of[WCSPH_COMPONENTS];

  PetscFunctionBegin;
  WcsphComponents(w, of); /* their number: a restarted run may be measured before its first step */
  PetscCall(PetscCalloc1(w->components * n, &rates));
  PetscCall(WcsphReserve(w->flow, w));
  for (PetscInt a = 0; a < d; a++)
    PetscCall(PetscArraycpy(w->local.u[a], flow->particles->u[a], n));
  PetscCall(PetscArraycpy(w->local.rho, w->rho, n));
  if (w->e) PetscCall(PetscArraycpy(w->local.e, w->e, n));
  w->t           = flow->clock->t;
  w->rate        = rates;
  w->first_stage = PETSC_FALSE;
  PetscCall(WcsphRates(w->flow, w));
  for (PetscInt a = 0; a < d; a++) PetscCall(PetscArraycpy(rate[a], rates + (d + a) * n, n));
  w->t           = t;
  w->divergence  = divergence;
  w->first_stage = first;
  PetscCall(PetscFree(rates));
  PetscFunctionReturn(PETSC_SUCCESS);
}
