/* Particle shifting before a step of the weakly compressible scheme. */
#include "wcsph.h"

/* Computes du_c/dx_a of a particle from the differences of its neighbours; returns the sum of the
   squares. */
static PetscReal VelocityGradient(const Stencil *st, const Pairs *pairs,
                                  PetscReal gradient[][ISPH_MAX_DIM])
{
  PetscReal squares = 0.0;

  for (PetscInt c = 0; c < st->dim; c++) {
    for (PetscInt a = 0; a < st->dim; a++) {
      const PetscReal *du = pairs->du[c], *weight = pairs->c[a];
      PetscReal        sum = 0.0;

#pragma omp simd reduction(+ : sum)
      for (PetscInt k = 0; k < st->n; k++) sum += du[k] * weight[k];
      gradient[c][a] = sum;
      squares += PetscSqr(sum);
    }
  }
  return squares;
}

/*
  Displaces a particle by s, and changes its velocity, density and energy by s.grad

  The gradients are exact for linear fields. The new values go to the fields of the particle; other
  particles read the copies of the local flow.
*/
static PetscErrorCode ShiftRowOf(Stencil *st, void *ctx)
{
  Wcsph           *w    = (Wcsph *)ctx;
  const Flow      *flow = w->flow;
  const LocalFlow *l    = &w->local;
  const PetscInt   d = st->dim, i = st->i;
  Pairs           *pairs = &w->pairs;
  PetscReal        x[ISPH_MAX_DIM], none[ISPH_MAX_DIM] = {0.0}, C, slope[ISPH_MAX_DIM];
  PetscReal        gradient[ISPH_MAX_DIM][ISPH_MAX_DIM], s[ISPH_MAX_DIM], rise[2] = {0.0}, rate;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < d; a++) x[a] = flow->particles->x[a][i];
  ConcentrationRow(flow->scene, flow->ops->forms.kernel, st, x, PETSC_FALSE, &C, slope);
  PetscCall(WcsphSetPairs(w, none, st));
  StencilGradients(st, CORRECTION_FIRST_ORDER);
  rate = PetscSqrtReal(VelocityGradient(st, pairs, gradient));
  flow->state->shift->Displace(d, st->dx, flow->state->shift_strength,
                               flow->scheme->stats.speed_max, rate, flow->clock->dt, slope, s);
  for (PetscInt k = 0; k < st->n; k++) {
    PetscReal along = 0.0;

    if (st->wall[k]) continue;
    for (PetscInt a = 0; a < d; a++) along += s[a] * pairs->c[a][k];
    rise[0] += (pairs->rho[k] - l->rho[i]) * along;
    if (l->e) rise[1] += (l->e[st->j[k]] - l->e[i]) * along;
  }
  for (PetscInt a = 0; a < d; a++) w->displacement[a][i] = s[a];
  for (PetscInt c = 0; c < d; c++)
    for (PetscInt a = 0; a < d; a++) flow->particles->u[c][i] += s[a] * gradient[c][a];
  if (!w->density->sums) w->rho[i] += rise[0];
  if (l->e) w->e[i] += rise[1];
  PetscFunctionReturn(PETSC_SUCCESS);
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
  stays. Positions in the halo are out of date afterwards.
*/
PetscErrorCode WcsphShift(Flow *flow, Wcsph *w)
{
  Particles      *p     = flow->particles;
  const PetscBool keeps = SceneKeepsMomentum(flow->scene);
  PetscReal       before[ISPH_MAX_DIM], after[ISPH_MAX_DIM];

  PetscFunctionBegin;
  if (!flow->state->shift->Displace) PetscFunctionReturn(PETSC_SUCCESS);
  if (keeps) PetscCall(MeanVelocity(flow, before));
  for (PetscInt a = 0; a < p->dim; a++) {
    PetscCall(PetscArraycpy(w->local.u[a], p->u[a], ParticlesOwn(p)));
    PetscCall(ParticlesHaloField(p, w->local.u[a]));
  }
  if (w->e) {
    PetscCall(PetscArraycpy(w->local.e, w->e, p->n_fluid));
    PetscCall(ParticlesHaloField(p, w->local.e));
  }
  PetscCall(OperatorsStream(flow->scene, p, flow->neighbors, flow->ops, ShiftRowOf, w));
  for (PetscInt a = 0; a < p->dim; a++)
    for (PetscInt i = 0; i < p->n_fluid; i++) p->x[a][i] += w->displacement[a][i];
  if (!keeps) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MeanVelocity(flow, after));
  for (PetscInt a = 0; a < p->dim; a++)
    PetscCall(VecShift(flow->state->u[a], before[a] - after[a]));
  PetscFunctionReturn(PETSC_SUCCESS);
}
