/*
  Particle shifting in a step of the weakly compressible scheme. The sweep of the first stage has
  all sums that a shift needs; the shift takes place after the last stage.
*/
#include "wcsph.h"

/* Computes du_c/dx_a of a particle from the differences of its neighbours; returns the sum of the
   squares. */
static ISPH_WIDE PetscReal VelocityGradient(const Stencil *st, const Pairs *pairs,
                                            PetscReal gradient[][ISPH_MAX_DIM])
{
  PetscReal squares = 0.0;

  for (PetscInt c = 0; c < st->dim; c++) {
    for (PetscInt a = 0; a < st->dim; a++) {
      gradient[c][a] = LanesSum(LanesPadded(st->n), pairs->du[c], pairs->c[a]);
      squares += PetscSqr(gradient[c][a]);
    }
  }
  return squares;
}

/* Computes s.grad rho of a particle of density rho; walls have this density. */
static ISPH_WIDE PetscReal Rise(const Stencil *st, const Pairs *pairs, PetscReal rho,
                                const PetscReal s[])
{
  const PetscInt n    = LanesPadded(st->n);
  PetscReal      rise = 0.0, *more = pairs->w;

  for (PetscInt k = 0; k < n; k++) more[k] = pairs->rho[k] - rho;
  for (PetscInt a = 0; a < st->dim; a++) rise += s[a] * LanesSum(n, more, pairs->c[a]);
  return rise;
}

/* Computes lap u of a particle by the pairs of Morris, Fox & Zhu. */
static ISPH_WIDE void VelocityLaplacian(const Stencil *st, const Pairs *pairs, PetscReal lap[])
{
  MomentWeights(st, PETSC_TRUE, pairs->w);
  for (PetscInt a = 0; a < st->dim; a++)
    lap[a] = 2.0 * LanesSum(LanesPadded(st->n), pairs->w, pairs->du[a]);
}

/* Returns true if the sweep of the present stage also computes the shift. */
PetscBool WcsphShifts(const Wcsph *w)
{
  return w->first_stage && w->flow->state->shift->Displace ? PETSC_TRUE : PETSC_FALSE;
}

/*
  WcsphShiftRow - Computes the displacement s of a particle, and the changes of its fields,

    s.grad u + |s|^2/(2d) lap u,   s.grad rho,   s.grad e

  Not collective. The gradients are exact for linear fields. For the second term see FlowMove().
  Input: slope - gradient of the concentration [1/m]; w->pairs. Output: w->shift, in the order of
  the unknowns.
*/
void WcsphShiftRow(Wcsph *w, Stencil *st, const PetscReal slope[])
{
  const Flow      *flow = w->flow;
  const LocalFlow *l    = &w->local;
  const PetscInt   d = st->dim, i = st->i, n = flow->particles->n_fluid;
  const Pairs     *pairs = &w->pairs;
  PetscReal        gradient[ISPH_MAX_DIM][ISPH_MAX_DIM], s[ISPH_MAX_DIM], rise[2] = {0.0}, rate;
  PetscReal        lap[ISPH_MAX_DIM], length2 = 0.0;
  PetscInt         c = 2 * d;

  StencilGradients(st, CORRECTION_FIRST_ORDER);
  rate = PetscSqrtReal(VelocityGradient(st, pairs, gradient));
  flow->state->shift->Displace(d, st->dx, flow->state->shift_strength,
                               flow->scheme->stats.speed_max, rate, flow->clock->dt, slope, s);
  rise[0] = Rise(st, pairs, l->rho[i], s);
  VelocityLaplacian(st, pairs, lap);
  for (PetscInt a = 0; a < d; a++) length2 += PetscSqr(s[a]);
  for (PetscInt k = 0; l->e && k < st->n; k++) {
    if (st->wall[k]) continue;
    for (PetscInt a = 0; a < d; a++) rise[1] += (l->e[st->j[k]] - l->e[i]) * s[a] * pairs->c[a][k];
  }
  for (PetscInt a = 0; a < d; a++) {
    w->shift[a * n + i]       = s[a];
    w->shift[(d + a) * n + i] = 0.5 * length2 / (PetscReal)d * lap[a];
    for (PetscInt b = 0; b < d; b++) w->shift[(d + a) * n + i] += s[b] * gradient[a][b];
  }
  if (!w->density->sums) w->shift[c++ * n + i] = rise[0];
  if (l->e) w->shift[c * n + i] = rise[1];
}

/* Computes the mean velocity of the fluid, by mass. */
static PetscErrorCode MeanVelocity(const Flow *flow, PetscReal mean[])
{
  PetscFunctionBegin;
  for (PetscInt a = 0; a < flow->scene->dim; a++) {
    PetscCall(FluidSum(flow->particles, flow->state->u[a], PETSC_FALSE, &mean[a]));
    mean[a] /= flow->particles->weight;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  WcsphShift - Shifts the particles

    x += s,   u += s.grad u,   rho += s.grad rho,   e += s.grad e,   s of the chosen ShiftRow

  Collective. Does nothing with -shift none. In a periodic box without forces the mean velocity
  stays. w->start moves too, because no force works along s. Positions in the halo are out of date
  afterwards.
*/
PetscErrorCode WcsphShift(Flow *flow, Wcsph *w)
{
  Particles      *p = flow->particles;
  const PetscInt  n = p->n_fluid, d = p->dim;
  const PetscBool keeps = SceneKeepsMomentum(flow->scene);
  PetscReal       before[ISPH_MAX_DIM], after[ISPH_MAX_DIM], *to[WCSPH_COMPONENTS];

  PetscFunctionBegin;
  if (!flow->state->shift->Displace) PetscFunctionReturn(PETSC_SUCCESS);
  if (keeps) PetscCall(MeanVelocity(flow, before));
  WcsphComponents(w, to);
  for (PetscInt c = 0; c < w->components; c++)
    for (PetscInt i = 0; i < n; i++) to[c][i] += w->shift[c * n + i];
  for (PetscInt a = 0; a < d; a++)
    for (PetscInt i = 0; i < n; i++) w->start[a][i] += w->shift[a * n + i];
  if (!keeps) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MeanVelocity(flow, after));
  for (PetscInt a = 0; a < d; a++) PetscCall(VecShift(flow->state->u[a], before[a] - after[a]));
  PetscFunctionReturn(PETSC_SUCCESS);
}
