/*
  Control of the volume inside a free surface that moves. Each particle owns a volume v_i, at first
  that of its cell V_i (cellvolume.c), and the flow should keep it. It does not: the surface sinks
  where particles from inside join it, displacements that are no velocity raise it, and particles
  crowd on it where it shortens. Neighbours exchange their excess e_i = V_i - v_i, so that only its
  mean over the support remains, and the equations of mass take this mean back:

    v_i    <- v_i - sum_j E_ij (c_i + c_j)/2 dt (e_j - e_i) w_ij/W,
    div u_j = -sum_i rate c_i e_i w_ij/(sum_k V_k w_ik),   j and k inside, w = (1 - r^2/R^2)^2,

  with the shear rate c_i about the particle, c^2 = d (d + 2) <(e.(u_k - u_i)/r)^2>, which is
  sqrt(2 E:E) of a uniform strain and zero for rigid motions, the radius R of the support and the
  sum W of w over a lattice. The difference of two velocities lies in the thinner of two fluids,
  with the factor 2 nu_k/(nu_i + nu_k) in that of i, and so do sources. `rate` is
  -surface_volume_rate. E_ij is larger between particles whose supports have no surface: their cells
  fluctuate, and no volume is lost there. See theory.md, (surface:exchange), (surface:mass) and
  (surface:rate).
*/
#include "surface.h"

#define GRID     3      /* points of the cells along dx */
#define EXCHANGE 20.0   /* exchanged share per unit of shear [-] */
#define BELOW    1000.0 /* the same between particles below the surface; 20 left noise in films */
#define MOST     0.3    /* largest share of an excess that a step exchanges or takes back [-] */
#define LEAST    0.3    /* least part of a support that counts as inside: less than one layer [-] */
#define LARGEST  0.2    /* largest excess that counts, over the volume of the particle [-] */

static const OptionRow options[] = {
    OPTION(REAL, "-surface_volume_rate",
           "share of an error of the volume at a free surface that the equations of mass take back "
           "while the fluid is sheared by 1; 0: no control of the volume",
           "-", "0.5", .expert = PETSC_TRUE, .low = 0.0, .high = 10.0,
           .where = "flows with a free surface that moves"),
};
const OptionTable SurfaceVolumeOptions = OPTIONS("Volume of fluids with a free surface", options);

/* Values of a step, of all particles. */
typedef struct {
  PetscReal *shear;  /* c [1/s] */
  PetscReal *excess; /* e; zero for isolated particles [m^dim] */
  PetscReal *share;  /* rate c e/(sum_k V_k w_ik) [1/s] */
  PetscReal *below;  /* 1 if no particle of the support is on the surface, 0 otherwise */
} Values;

/* VolumesCreate - Reads the option, for schemes with equations of mass; collective */
PetscErrorCode VolumesCreate(Flow *flow)
{
  FlowState *s = flow->state;

  PetscFunctionBegin;
  if (!SceneHasFreeSurface(flow->scene) || !SceneMoves(flow->scene))
    PetscFunctionReturn(PETSC_SUCCESS);
  s->volume_rate = 0.5;
  PetscCall(OptionGetReal(&options[0], &s->volume_rate, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* VolumesRegister - Adds the field of the volumes that particles own, if they are controlled;
   collective */
PetscErrorCode VolumesRegister(Flow *flow)
{
  FlowState *s = flow->state;

  PetscFunctionBegin;
  if (s->volume_rate == 0.0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ParticlesRegister(flow->particles, "owned_volume", 1, HALO_NONE, ENTRY_ZERO,
                              &s->owned_volume));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns w of particle j at own particle i, zero beyond the support. Output: X - their distance;
   r2 - its square. */
static PetscReal Weight(const Flow *flow, PetscInt i, PetscInt j, PetscReal X[], PetscReal *r2)
{
  const Particles *p = flow->particles;

  *r2 = 0.0;
  for (PetscInt a = 0; a < p->dim; a++) {
    X[a] = p->x[a][j] - p->x[a][i];
    *r2 += PetscSqr(X[a]);
  }
  return PetscSqr(PetscMax(0.0, 1.0 - *r2 / PetscSqr(flow->ops->forms.radius)));
}

/* Returns the strain rate in the half of particle i of the line to particle j, over its mean: both
   halves have the same stress. A stiff part takes and gives no volume. */
static PetscReal OwnStrain(const Particles *p, PetscInt i, PetscInt j)
{
  return p->nu ? 2.0 * p->nu[j] / (p->nu[i] + p->nu[j]) : 1.0;
}

/* Returns the sum W of w over a lattice with the spacing dx [-]. */
static PetscReal LatticeWeight(const Flow *flow)
{
  const PetscReal R = flow->ops->forms.radius / flow->scene->dx;

  return flow->scene->dim == 2 ? PETSC_PI * R * R / 3.0
                               : 32.0 * PETSC_PI * PetscPowRealInt(R, 3) / 105.0;
}

/* Returns the shear rate about own particle i [1/s]. Input: u - of all particles, by
   [i dim + a]. */
static PetscReal ShearRate(const Flow *flow, const PetscReal u[], PetscInt i)
{
  const Particles *p   = flow->particles;
  const Neighbors *nb  = flow->neighbors;
  const PetscInt   d   = p->dim;
  PetscReal        sum = 0.0, weights = 0.0;

  for (PetscInt q = nb->row[i]; q < nb->row[i + 1]; q++) {
    const PetscInt  j = nb->col[q];
    PetscReal       X[ISPH_MAX_DIM], r2, along = 0.0;
    const PetscReal w = ParticlesIsWall(p, j) ? 0.0 : Weight(flow, i, j, X, &r2);

    if (w == 0.0 || r2 < PetscSqr(0.1 * p->dx[i])) continue;
    for (PetscInt a = 0; a < d; a++) along += X[a] * (u[j * d + a] - u[i * d + a]);
    sum += w * PetscSqr(OwnStrain(p, i, j) * along / r2);
    weights += w;
  }
  return weights > 0.0 ? PetscSqrtReal(d * (d + 2.0) * sum / weights) : 0.0;
}

/* Sets shear, excess and place of own particles. At the start a particle owns its cell, and later
   the volume with which it has entered. Isolated particles have no excess. Particles beside an
   opening, whose cells end at its side, have no shear: their excess waits. */
static PetscErrorCode FindExcess(Flow *flow, Values *v)
{
  const Particles *p     = flow->particles;
  PetscReal       *owned = flow->state->owned_volume, *u;

  PetscFunctionBegin;
  PetscCall(FlowAllVelocities(flow, flow->state->u, &u));
  PetscCall(FlowCellVolumes(flow, GRID, v->excess));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    if (owned[i] == 0.0) owned[i] = flow->clock->step == 0 ? v->excess[i] : p->volume[i];
    if (flow->ops->free->kind[i] == SURFACE_ISOLATED) v->excess[i] = owned[i];
    else if (!FreeSurfaceOpenings(flow->scene, p, flow->neighbors, i))
      v->shear[i] = ShearRate(flow, u, i);
    v->below[i] = OperatorsBesideSurface(flow->ops, i) ? 0.0 : 1.0;
    v->excess[i] -= owned[i];
  }
  PetscCall(PetscFree(u));
  PetscCall(ParticlesHaloField(p, v->excess));
  PetscCall(ParticlesHaloField(p, v->shear));
  PetscCall(ParticlesHaloField(p, v->below));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the excess of own particle i after its exchange with its neighbours [m^dim]. Input:
   lattice - W. Output: inside - sum_k V_k w_ik over the particles inside [m^dim]. */
static PetscReal Exchange(const Flow *flow, const Values *v, PetscReal lattice, PetscInt i,
                          PetscReal *inside)
{
  const Particles   *p    = flow->particles;
  const Neighbors   *nb   = flow->neighbors;
  const FreeSurface *free = flow->ops->free;
  PetscReal          sum  = 0.0;

  *inside = FreeSurfaceHolds(free, i) ? 0.0 : p->volume[i];
  for (PetscInt q = nb->row[i]; q < nb->row[i + 1]; q++) {
    const PetscInt j = nb->col[q];
    PetscReal      X[ISPH_MAX_DIM], r2, w, rate;

    if (ParticlesIsWall(p, j)) continue;
    w = Weight(flow, i, j, X, &r2);
    if (!FreeSurfaceHolds(free, j)) *inside += p->volume[j] * w * OwnStrain(p, j, i);
    if (v->shear[j] == 0.0) continue;
    rate = 0.5 * (v->shear[i] + v->shear[j]);
    rate *= v->below[i] * v->below[j] > 0.0 ? BELOW : EXCHANGE;
    w *= PetscMin(MOST, rate * flow->clock->dt);
    sum += w / lattice * (v->excess[j] - v->excess[i]);
  }
  return v->excess[i] + sum;
}

/* Exchanges the excess and sets the shares. Excess beyond LARGEST waits, and so does a part where
   few particles are inside: the tips of the arms of a turning square burst without these limits. */
static PetscErrorCode SetShares(Flow *flow, Values *v)
{
  const Particles *p       = flow->particles;
  FlowState       *s       = flow->state;
  const PetscReal  dt      = flow->clock->dt;
  const PetscReal  lattice = LatticeWeight(flow);

  PetscFunctionBegin;
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscReal left, inside;

    if (v->shear[i] == 0.0) continue;
    left = Exchange(flow, v, lattice, i, &inside);
    s->owned_volume[i] += v->excess[i] - left;
    inside      = PetscMax(inside, LEAST * lattice * p->volume[i]);
    left        = PetscMax(-LARGEST * p->volume[i], PetscMin(LARGEST * p->volume[i], left));
    v->share[i] = PetscMin(MOST, s->volume_rate * v->shear[i] * dt) * left / (dt * inside);
  }
  PetscCall(ParticlesHaloField(p, v->share));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the divergence that own particle j should have [1/s]. */
static PetscReal DivergenceSource(const Flow *flow, const Values *v, PetscInt j)
{
  const Particles *p      = flow->particles;
  const Neighbors *nb     = flow->neighbors;
  PetscReal        source = 0.0;

  for (PetscInt q = nb->row[j] - 1; q < nb->row[j + 1]; q++) {
    const PetscInt i = q < nb->row[j] ? j : nb->col[q];
    PetscReal      X[ISPH_MAX_DIM], r2;

    if (!ParticlesIsWall(p, i) && v->share[i] != 0.0)
      source -= v->share[i] * Weight(flow, j, i, X, &r2) * OwnStrain(p, j, i);
  }
  return source;
}

/* VolumesControl - Sets the divergence that takes the excess of volume back, state->source.
   Collective. Input: neighbours and kinds at the present positions. The work of the pressure on it
   enters the balance of energy. A fluid that fills its box has no control: the sources of
   fluctuating cells would drive a flow through its openings. */
PetscErrorCode VolumesControl(Flow *flow)
{
  const Particles *p    = flow->particles;
  FlowState       *s    = flow->state;
  PetscReal        work = 0.0;
  PetscScalar     *source;
  Values           v;

  PetscFunctionBegin;
  if (!flow->ops->free->exists) {
    PetscCall(VecZeroEntries(s->source));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscCalloc4(ParticlesAll(p), &v.shear, ParticlesAll(p), &v.excess, ParticlesAll(p),
                         &v.share, ParticlesAll(p), &v.below));
  PetscCall(FindExcess(flow, &v));
  PetscCall(SetShares(flow, &v));
  PetscCall(VecGetArrayWrite(s->source, &source));
  for (PetscInt j = 0; j < p->n_fluid; j++) {
    source[j] = FreeSurfaceHolds(flow->ops->free, j) ? 0.0 : DivergenceSource(flow, &v, j);
    work += ParticlesWeight(p, j) * PetscRealPart(source[j]) * (p->p[j] - flow->scene->outside);
  }
  PetscCall(VecRestoreArrayWrite(s->source, &source));
  PetscCall(PetscFree4(v.shear, v.excess, v.share, v.below));
  PetscCall(EnergyAddWork(flow, work * flow->clock->dt / flow->scene->rho));
  PetscFunctionReturn(PETSC_SUCCESS);
}
