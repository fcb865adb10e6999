/* Particle shifting in a step of the weakly compressible scheme. The sweep of the first stage has
   all sums that a shift needs; the shift takes place after the last stage. */
#include "wcsph.h"

/* Sums of a shift: gradients of velocity and density, and the Laplacian of the velocity by the
   pairs of Morris, Fox & Zhu. */
typedef struct {
  PetscReal u[ISPH_MAX_DIM][ISPH_MAX_DIM]; /* du_c/dx_a at [c][a] [1/s] */
  PetscReal rho[ISPH_MAX_DIM];             /* [kg/m^4] */
  PetscReal lap[ISPH_MAX_DIM];             /* [1/(m s)] */
} ShiftSums;

/* Adds up the sums of a particle of density rho in one pass; inlined for each dimension. */
static ISPH_INLINE void SumAll(PetscInt d, const Stencil *st, const Pairs *pairs, PetscReal rho,
                               ShiftSums *sums)
{
  const PetscInt n = LanesPadded(st->n);
  Four           u[ISPH_MAX_DIM * ISPH_MAX_DIM], rise[ISPH_MAX_DIM], lap[ISPH_MAX_DIM];

#pragma GCC unroll 9
  for (PetscInt e = 0; e < d * d; e++) u[e] = (Four){0.0};
#pragma GCC unroll 3
  for (PetscInt a = 0; a < d; a++) rise[a] = lap[a] = (Four){0.0};
  for (PetscInt k = 0; k < n; k += 4) {
    const Four more = *FourAt(pairs->rho + k) - rho, radial = *FourAt(st->radial + k);

#pragma GCC unroll 3
    for (PetscInt a = 0; a < d; a++) {
      const Four du = *FourAt(pairs->du[a] + k);

      rise[a] += more * *FourAt(pairs->c[a] + k);
      lap[a] += radial * du;
#pragma GCC unroll 3
      for (PetscInt b = 0; b < d; b++) u[a * d + b] += du * *FourAt(pairs->c[b] + k);
    }
  }
  for (PetscInt a = 0; a < d; a++) {
    sums->rho[a] = FourSum(&rise[a]);
    sums->lap[a] = 2.0 * FourSum(&lap[a]);
    for (PetscInt b = 0; b < d; b++) sums->u[a][b] = FourSum(&u[a * d + b]);
  }
}

static ISPH_WIDE void SumShift(const Stencil *st, const Pairs *pairs, PetscReal rho,
                               ShiftSums *sums)
{
  if (st->dim == 2) SumAll(2, st, pairs, rho, sums);
  else SumAll(3, st, pairs, rho, sums);
}

/* Returns true if the sweep of the present stage also computes the shift. */
PetscBool WcsphShifts(const Wcsph *w)
{
  return w->first_stage && w->flow->state->shift->Displace;
}

/*
  WcsphShiftRow - Computes the displacement s of a particle, and the changes of its fields,

    s.grad u + |s|^2/(2d) lap u,   s.grad rho,   s.grad e

  The gradients are exact for linear fields. For the second term see FlowMove(). Input: slope -
  gradient of the concentration [1/m]; w->pairs. Output: w->shift, in the order of the unknowns.
*/
void WcsphShiftRow(Wcsph *w, Stencil *st, const PetscReal slope[])
{
  const Flow      *flow = w->flow;
  const LocalFlow *l    = &w->local;
  const PetscInt   d = st->dim, i = st->i, n = flow->particles->n_fluid;
  const Pairs     *pairs = &w->pairs;
  ShiftSums        sums;
  PetscReal        s[ISPH_MAX_DIM], rise[2] = {0.0}, squares = 0.0, length2 = 0.0;
  PetscInt         c = 2 * d;

  StencilGradients(st, CORRECTION_FIRST_ORDER);
  SumShift(st, pairs, l->rho[i], &sums);
  for (PetscInt e = 0; e < d * d; e++) squares += PetscSqr(sums.u[e / d][e % d]);
  flow->state->shift->Displace(d, st->dx, flow->state->shift_strength,
                               flow->scheme->stats.speed_max, PetscSqrtReal(squares),
                               flow->clock->dt, slope, s);
  for (PetscInt a = 0; a < d; a++) {
    length2 += PetscSqr(s[a]);
    rise[0] += s[a] * sums.rho[a];
  }
  for (PetscInt k = 0; l->e && k < st->n; k++) {
    if (st->wall[k]) continue;
    for (PetscInt a = 0; a < d; a++) rise[1] += (l->e[st->j[k]] - l->e[i]) * s[a] * pairs->c[a][k];
  }
  for (PetscInt a = 0; a < d; a++) {
    w->shift[a * n + i]       = s[a];
    w->shift[(d + a) * n + i] = 0.5 * length2 / (PetscReal)d * sums.lap[a];
    for (PetscInt b = 0; b < d; b++) w->shift[(d + a) * n + i] += s[b] * sums.u[a][b];
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

  Collective. In a periodic box without forces the mean velocity stays. w->start moves too, because
  no force works along s. Positions in the halo are out of date afterwards.
*/
PetscErrorCode WcsphShift(Flow *flow)
{
  Wcsph          *w = (Wcsph *)flow->scheme->data;
  Particles      *p = flow->particles;
  const PetscInt  n = p->n_fluid, d = p->dim;
  const PetscBool keeps = SceneKeepsMomentum(flow->scene);
  PetscReal       before[ISPH_MAX_DIM], after[ISPH_MAX_DIM], *to[WCSPH_COMPONENTS];

  PetscFunctionBegin;
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
