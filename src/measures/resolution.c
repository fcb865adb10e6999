/*
  The resolution of a flow: an estimate of the error of its velocity from its gradients. It is
  computed for reports only.

  The error of gradients, relative to the gradients, is estimated by the difference of two fits.
  Errors of the convective term grow while the flow amplifies them, until viscosity has spread
  them.
*/
#include "isph/io.h"

#define SHARE     0.25        /* relative error of the velocity over that of its gradients [-] */
#define SPREADING (1.0 / 3.0) /* time in which viscosity spreads errors [(U/G)^2/nu] */
#define AT_REST   1e-6        /* a velocity below this is no flow [U] */
#define UNIFORM   1e-6        /* gradients below this are rounding [velocity/L] */
#define SLAB      512         /* particles whose gradients are kept at once */
#define LAYER     1.5         /* thickness of a sheared layer over the mean of D in it [-] */
#define WIDTH     1.4         /* by which fits widen a layer [dx] */

/* Sums over all fluid particles, weighted by volume, for a single MPI reduction. */
typedef struct {
  PetscReal u2, nu;               /* of |u|^2 [m^2/s^2] and of the viscosity [m^2/s] */
  PetscReal gradient, difference; /* of |grad u| and its difference between two fits [1/s] */
  PetscReal rate;                 /* of |A A|^(1/2), A = grad u [1/s] */
} Sums;

/* Returns Frobenius' norm of a dim x dim matrix. */
static PetscReal Norm(PetscInt dim, const PetscReal A[])
{
  PetscReal sum = 0.0;

  for (PetscInt t = 0; t < dim * dim; t++) sum += PetscSqr(A[t]);
  return PetscSqrtReal(sum);
}

/* Returns |A A|^(1/2) for a dim x dim matrix A by rows with the norm |A|. Division by |A| keeps the
   product in the range of the computer in any units. */
static PetscReal AmplificationRate(PetscInt dim, const PetscReal A[], PetscReal norm)
{
  PetscReal square[ISPH_MAX_DIM * ISPH_MAX_DIM] = {0.0};

  if (!(norm > 0.0)) return 0.0;
  for (PetscInt a = 0; a < dim; a++) {
    for (PetscInt b = 0; b < dim; b++) {
      for (PetscInt c = 0; c < dim; c++)
        square[a * dim + b] += (A[a * dim + c] / norm) * (A[c * dim + b] / norm);
    }
  }
  return norm * PetscSqrtReal(Norm(dim, square));
}

/* Adds the terms of own fluid particle i with the gradient A to the sums. */
static void AddParticle(const Flow *flow, PetscInt i, const PetscReal A[], PetscReal difference,
                        Sums *sums)
{
  const Particles *p      = flow->particles;
  const PetscReal  weight = ParticlesWeight(p, i), norm = Norm(p->dim, A);

  for (PetscInt c = 0; c < p->dim; c++) sums->u2 += weight * PetscSqr(p->u[c][i]);
  sums->nu += weight * (p->nu ? p->nu[i] : flow->scene->nu);
  sums->gradient += weight * norm;
  sums->difference += weight * difference;
  sums->rate += weight * AmplificationRate(p->dim, A, norm);
}

/* Broadcasts the position of the particle with the largest difference of any rank, wrapped into a
   periodic box. Input: i - the particle of this rank, or -1 without particles. */
static PetscErrorCode FindPlace(const Flow *flow, PetscInt i, PetscReal difference, PetscReal x[])
{
  const Scene     *scene   = flow->scene;
  const Particles *p       = flow->particles;
  PetscReal        largest = difference;
  PetscMPIInt      rank, owner;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(p->comm, &rank));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPIU_REAL, MPIU_MAX, p->comm));
  owner = i >= 0 && difference == largest ? rank : PETSC_MPI_INT_MAX;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &owner, 1, MPI_INT, MPI_MIN, p->comm));
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) x[a] = 0.0;
  if (owner == PETSC_MPI_INT_MAX) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt a = 0; rank == owner && a < p->dim; a++) {
    const PetscReal period = scene->hi[a] - scene->lo[a];

    x[a] = p->x[a][i];
    if (SceneIsPeriodic(scene, a)) x[a] -= period * PetscFloorReal((x[a] - scene->lo[a]) / period);
  }
  PetscCallMPI(MPI_Bcast(x, ISPH_MAX_DIM, MPIU_REAL, owner, p->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The particle with the largest difference of gradients. */
typedef struct {
  PetscInt  i;
  PetscReal difference; /* [1/s] */
} Worst;

/* Adds the terms of the own particles to the sums, and finds the worst particle. Only the gradients
   of a slab, and the rows of neighbours of fixed particles in it, are kept at once: those of all
   particles would be the peak of the run's memory. */
static PetscErrorCode AddParticles(const Flow *flow, Sums *sums, Worst *worst)
{
  const Particles   *p       = flow->particles;
  const PetscInt     entries = p->dim * p->dim;
  GradientComparison of      = {.first = 0};

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(SLAB * entries, &of.gradient, SLAB, &of.difference));
  for (; of.first < p->n_fluid; of.first += SLAB) {
    of.count = PetscMin(SLAB, p->n_fluid - of.first);
    PetscCall(NeighborsFindRows(p, of.first, of.count, flow->neighbors));
    PetscCall(OperatorsCompareGradients(flow->scene, p, flow->neighbors, flow->ops, &of));
    for (PetscInt k = 0; k < of.count; k++) {
      AddParticle(flow, of.first + k, &of.gradient[k * entries], of.difference[k], sums);
      if (of.difference[k] <= worst->difference) continue;
      *worst = (Worst){of.first + k, of.difference[k]};
    }
  }
  PetscCall(PetscFree2(of.gradient, of.difference));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the relative errors of the velocity from the sums, see ResolutionEstimate(). */
static void SetErrors(const Flow *flow, const Sums *sums, Resolution *resolution)
{
  const Scene    *scene = flow->scene;
  const Clock    *clock = flow->clock;
  const PetscReal total = flow->particles->weight, u = PetscSqrtReal(sums->u2 / total);
  const PetscReal gradient = sums->gradient / total, nu = sums->nu / total;
  const PetscReal rate = sums->rate / total;
  const PetscReal turn = PetscMax(clock->dt, clock->dt_previous) * rate;
  PetscReal       time = ClockMoment(clock), growth = 1.0;

  resolution->error = resolution->path = 0.0;
  if (!(u > AT_REST * scene->speed) || !(gradient * scene->length > UNIFORM * u)) return;
  if (SceneHas(scene, PHYSICS_VISCOSITY))
    time = PetscMin(time, SPREADING * PetscSqr(u / gradient) / nu);
  if (SceneHas(scene, PHYSICS_CONVECTION) && rate > 0.0) growth += rate * time;
  resolution->error = SHARE * sums->difference / sums->gradient * growth;
  if (!SceneMoves(scene)) return;
  resolution->path = (clock->order > 1 ? PetscSqr(turn) / 3.0 : 0.5 * turn) * rate * time;
}

/* Returns the steepest fall of a positive quantity from particle i to a neighbour, over their
   distance; 0 at its minimum. Input: value - by local index. */
static PetscReal SteepestFall(const Flow *flow, const PetscReal value[], PetscInt i)
{
  const Particles *p     = flow->particles;
  const Pattern   *fluid = &flow->ops->rows.fluid;
  PetscReal        slope = 0.0;

  for (PetscInt s = fluid->row[i]; s < fluid->row[i + 1]; s++) {
    const PetscInt j      = fluid->local[s];
    PetscReal      square = 0.0;

    for (PetscInt a = 0; a < p->dim; a++) square += PetscSqr(p->x[a][j] - p->x[a][i]);
    if (value[j] < value[i]) slope = PetscMax(slope, (value[i] - value[j]) / PetscSqrtReal(square));
  }
  return slope;
}

/*
  Computes the thickness of the sheared layers of a fluid that yields [dx], and the excess of the
  mean stress over the yield stress, both weighted by the dissipation w

    N^2 = (3/2 sum w D/sum w)^2 - WIDTH^2,   D_i = min_j r_ij g_i/(g_i - g_j),   w = tau g

  Between a wall and a rigid part the strain rate falls linearly to zero at the distance D, so that
  3/2 of the mean of D is the thickness of the layer. The fits of g widen it. D is at most the
  radius of the support. With the exact velocity of channels N errs by at most 10 % up to 3. If no
  particle yields, but the stress half a spacing beyond one would, the layers lie between particles
  and walls: then N has its least value, 1/2.
*/
static PetscErrorCode LayerThickness(const Flow *flow, Resolution *resolution)
{
  const Particles *p     = flow->particles;
  const Rheology  *r     = &flow->scene->rheology;
  const PetscReal  yield = r->parameter[RHEOLOGY_YIELD];
  PetscReal       *rate, *tau, sum[3] = {0.0, 0.0, 0.0}, most[2] = {0.0, 0.0};

  PetscFunctionBegin;
  resolution->layer = resolution->excess = 0.0;
  if (!r->row || !(r->row->takes & RHEOLOGY_BIT(RHEOLOGY_YIELD)))
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc2(ParticlesAll(p), &rate, ParticlesAll(p), &tau));
  PetscCall(OperatorsStrainRate(flow->ops, p, flow->state->u, flow->walls.u, rate));
  PetscCall(ParticlesHaloField(p, rate));
  for (PetscInt i = 0; i < ParticlesAll(p); i++)
    tau[i] = RheologyViscosity(r, NULL, rate[i]) * rate[i];
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    const PetscReal w    = ParticlesWeight(p, i) * tau[i] * rate[i];
    const PetscReal fall = PetscMax(SteepestFall(flow, rate, i), rate[i] / flow->ops->forms.radius);

    if (!(rate[i] > 0.0)) continue;
    most[0] = PetscMax(most[0], tau[i]);
    most[1] = PetscMax(most[1], tau[i] + 0.5 * p->dx[i] * SteepestFall(flow, tau, i));
    sum[0] += w * rate[i] / fall / p->dx[i];
    sum[1] += w;
    sum[2] += w * tau[i];
  }
  PetscCall(PetscFree2(rate, tau));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 3, MPIU_REAL, MPIU_SUM, p->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, most, 2, MPIU_REAL, MPIU_MAX, p->comm));
  if (!(sum[1] > 0.0)) PetscFunctionReturn(PETSC_SUCCESS);
  resolution->excess = PetscAbsReal(1.0 - yield * sum[1] / sum[2]);
  resolution->layer =
      PetscSqrtReal(PetscMax(PetscSqr(LAYER * sum[0] / sum[1]) - PetscSqr(WIDTH), 0.25));
  if (most[0] < yield && most[1] > yield) resolution->layer = 0.5;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  ResolutionEstimate - Estimates the error of the velocity

    E = 1/4 <|grad_3 u - grad_2 u|>/<|grad_3 u|> (1 + a T),   a = <|A A|^(1/2)>,
    T = min(t, (U/G)^2/(3 nu)),   A = grad_3 u,   G = <|A|>,   U = <|u|^2>^(1/2)

  Collective. <.> is the mean over the fluid, weighted by volume; grad_2 and grad_3 are gradients of
  a quadratic and of a cubic fit, see OperatorsCompareGradients(). Moving particles turn with the
  flow, and steps of order 2 err by dt^2 a^3/3 of it per time, those of order 1 by dt a^2/2. The
  formulas are theory.md, (forces:space). A fluid at rest or in uniform motion has no error. Output:
  resolution - both errors, the place where the gradients of both fits differ most, and the
  thickness of sheared layers.
*/
PetscErrorCode ResolutionEstimate(const Flow *flow, Resolution *resolution)
{
  const Particles *p     = flow->particles;
  Sums             sums  = {.u2 = 0.0};
  Worst            worst = {-1, -1.0};

  PetscFunctionBegin;
  /* fixed particles keep no rows of neighbours */
  if (SceneMoves(flow->scene)) PetscCall(NeighborsUpdate(p, 0.0, flow->neighbors));
  else PetscCall(NeighborsSearch(p, flow->neighbors));
  PetscCall(ParticlesHaloComponents(p, p->u));
  PetscCall(AddParticles(flow, &sums, &worst));
  if (!SceneMoves(flow->scene)) PetscCall(NeighborsRelease(flow->neighbors));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &sums, (PetscMPIInt)(sizeof(sums) / sizeof(PetscReal)),
                             MPIU_REAL, MPIU_SUM, p->comm));
  SetErrors(flow, &sums, resolution);
  PetscCall(FindPlace(flow, worst.i, worst.difference, resolution->x));
  PetscCall(LayerThickness(flow, resolution));
  PetscFunctionReturn(PETSC_SUCCESS);
}
