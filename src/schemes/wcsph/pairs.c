/* Sums over the neighbours of a particle i. Neighbour k has pressure p_k, density rho_k, velocity
   difference du_k = u_k - u_i, and c_k = V_k grad_i W_k, with the chosen correction. */
#include "wcsph.h"

#define MIRROR 2.0 /* factor of u_wall - u_i in the velocity of a mirror image */

/* PairsReserve - Makes room for the neighbours of a stencil */
PetscErrorCode PairsReserve(PetscInt capacity, Pairs *pairs)
{
  PetscFunctionBegin;
  if (capacity <= pairs->capacity) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PairsFree(pairs));
  pairs->capacity = capacity;
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) PetscCall(PetscMalloc1(capacity, &pairs->du[a]));
  PetscCall(PetscMalloc3(capacity, &pairs->p, capacity, &pairs->rho,
                         ISPH_MAX_DIM * ISPH_MAX_DIM * capacity, &pairs->w));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* PairsFinish - Ends the arrays of the pairs in neighbours without volume, of the density rho and
   the velocity of the particle */
void PairsFinish(PetscReal rho, const Stencil *st, Pairs *pairs)
{
  for (PetscInt k = st->n; k < LanesPadded(st->n); k++) {
    pairs->p[k]   = 0.0;
    pairs->rho[k] = rho;
    for (PetscInt a = 0; a < st->dim; a++) pairs->du[a][k] = 0.0;
  }
}

/* PairsFree - Frees the arrays */
PetscErrorCode PairsFree(Pairs *pairs)
{
  PetscFunctionBegin;
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) PetscCall(PetscFree(pairs->du[a]));
  PetscCall(PetscFree3(pairs->p, pairs->rho, pairs->w));
  pairs->capacity = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds up the sums of PairsSum() in one pass; inlined for each dimension and each form of the
   pressure force. */
static ISPH_INLINE void SumAll(PetscInt d, PetscBool by_sums, const Stencil *st, const Pairs *pairs,
                               const PairTerms *own, PairSums *sums)
{
  const PetscReal  ratio = own->p / PetscSqr(own->rho), over = 1.0 / own->rho, rho_i = own->rho;
  const PetscReal  self = own->corrected ? 2.0 * own->p * over : 0.0;
  const PetscReal  more = own->corrected ? -own->p : own->p;
  const PetscReal *r = st->r, *radial = st->radial;
  const PetscInt   n   = LanesPadded(st->n);
  Four             div = {0.0}, diffusion = {0.0}, lap[ISPH_MAX_DIM], push[ISPH_MAX_DIM];

#pragma GCC unroll 3
  for (PetscInt a = 0; a < d; a++) lap[a] = push[a] = (Four){0.0};
  for (PetscInt k = 0; k < n; k += 4) {
    const Four rho = *FourAt(pairs->rho + k), p = *FourAt(pairs->p + k), distance = *FourAt(r + k);
    const Four force = by_sums ? p / rho + rho * ratio - self : over * (p + more);
    Four       along = {0.0};

#pragma GCC unroll 3
    for (PetscInt a = 0; a < d; a++) {
      const Four c = *FourAt(pairs->c[a] + k);

      div += *FourAt(pairs->du[a] + k) * c;
      along += *FourAt(st->X[a] + k) * c;
      push[a] -= force * c;
    }
    diffusion += *FourAt(radial + k) * (rho - rho_i);
    along *= 2.0 / (distance * distance);
#pragma GCC unroll 3
    for (PetscInt a = 0; a < d; a++) lap[a] += along * *FourAt(pairs->du[a] + k);
  }
  sums->divergence = FourSum(&div);
  sums->diffusion  = 2.0 * FourSum(&diffusion);
  for (PetscInt a = 0; a < d; a++) {
    sums->laplacian[a] = FourSum(&lap[a]);
    sums->pressure[a]  = FourSum(&push[a]);
  }
}

/* Returns the part of the divergence by velocities of dummies beyond those of mirror images. */
static PetscReal BeyondMirror(const Stencil *st, const Pairs *pairs)
{
  PetscReal sum = 0.0;

  for (PetscInt q = 0; q < st->n_wall; q++) {
    const PetscInt k = st->walls[q];

    if (st->beta[k] <= MIRROR) continue;
    for (PetscInt a = 0; a < st->dim; a++)
      sum += (1.0 - MIRROR / st->beta[k]) * pairs->du[a][k] * pairs->c[a][k];
  }
  return sum;
}

/*
  PairsSum - Computes the sums of continuity and momentum in one pass over the neighbours.
  divergence: div u = sum_k du_k.c_k. A dummy counts with the velocity of a mirror image, twice
  u_wall - u_i, where that of its wall treatment is larger: an extrapolation by the factor beta
  would raise the frequency of sound beside walls by beta^(1/2), and particles close to a wall would
  need shorter steps. diffusion: sum_k 2 V_k (rho_k - rho_i) (-W'/r), the Laplacian of the density;
  dummies have the density of the particle. laplacian: sum_k 2 X_k.c_k/r^2 du_k, see
  LaplacianFollowsSlopes(). pressure: the acceleration

    by_sums false:  -1/rho_i sum_k (p_k + p_i) c_k
    by_sums true:   -sum_k rho_k (p_k/rho_k^2 + p_i/rho_i^2) c_k

  Both keep the momentum without correction. With a correction of the kernel the sums include the
  particle itself, with c_i = -sum_k c_k:

    by_sums false:  -1/rho_i sum_k (p_k - p_i) c_k
    by_sums true:   -sum_k (rho_k (p_k/rho_k^2 + p_i/rho_i^2) - 2 p_i/rho_i) c_k

  Reference: M. Basa, N. Quinlan, M. Lastiwka, Int. J. Numer. Meth. Fluids 60 (2009), Eqs (8), (9);
  D. Molteni, A. Colagrossi, Comput. Phys. Commun. 180 (2009) 861-872
*/
ISPH_WIDE void PairsSum(const Stencil *st, const Pairs *pairs, const PairTerms *own, PairSums *sums)
{
  if (st->dim == 2 && own->by_sums) SumAll(2, PETSC_TRUE, st, pairs, own, sums);
  else if (st->dim == 2) SumAll(2, PETSC_FALSE, st, pairs, own, sums);
  else if (own->by_sums) SumAll(3, PETSC_TRUE, st, pairs, own, sums);
  else SumAll(3, PETSC_FALSE, st, pairs, own, sums);
  if (st->n_wall) sums->divergence -= BeyondMirror(st, pairs);
}

/*
  PairsEnergy - Computes the rate of the internal energy by the pressure [J/(kg s)]

    de/dt = -1/2 sum_k rho_k (p_k/rho_k^2 + p_i/rho_i^2) du_k.c_k

  Input: rho, p - of the particle; pressures are absolute. Reference: M. Basa, N. Quinlan, M.
  Lastiwka, Int. J. Numer. Meth. Fluids 60 (2009), Eq. (14)
*/
PetscReal PairsEnergy(const Stencil *st, const Pairs *pairs, PetscReal rho, PetscReal p)
{
  PetscReal sum = 0.0;

  for (PetscInt k = 0; k < st->n; k++) {
    PetscReal along = 0.0;

    for (PetscInt a = 0; a < st->dim; a++) along += pairs->du[a][k] * pairs->c[a][k];
    sum += (pairs->p[k] / pairs->rho[k] + pairs->rho[k] * p / PetscSqr(rho)) * along;
  }
  return -0.5 * sum;
}

/*
  ArtificialViscosity - Adds the acceleration by Monaghan's viscosity between fluid particles that
  approach each other

    sum_k rho_k (alpha c0 m - beta m^2)/rho_ik c_k,   m = h du.X/(r^2 + 0.01 h^2) < 0,
    rho_ik = (rho_i + rho_k)/2

  Input: artificial - alpha and beta [-]; rho - of the particle. Reference: J. J. Monaghan, J.
  Comput. Phys. 110 (1994); J. Fang, A. Parriaux, M. Rentschler, C. Ancey, Appl. Numer. Math. 59
  (2009) 251-271, Eqs (97) to (103)
*/
void ArtificialViscosity(const Stencil *st, const Pairs *pairs, const PetscReal artificial[],
                         PetscReal c0, PetscReal rho, PetscReal acceleration[])
{
  for (PetscInt k = 0; k < st->n; k++) {
    PetscReal along = 0.0, m, force;

    if (st->wall[k]) continue;
    for (PetscInt a = 0; a < st->dim; a++) along += pairs->du[a][k] * st->X[a][k];
    if (along >= 0.0) continue;
    m     = st->h * along / (PetscSqr(st->r[k]) + 0.01 * PetscSqr(st->h));
    force = pairs->rho[k] * (artificial[0] * c0 * m - artificial[1] * PetscSqr(m)) /
            (0.5 * (rho + pairs->rho[k]));
    for (PetscInt a = 0; a < st->dim; a++) acceleration[a] += force * pairs->c[a][k];
  }
}

/* HydrostaticRise - Computes the part of PairsSum.diffusion that belongs to a hydrostatic slope of
   the density, sum_k 2 V_k slope.X_k (-W'/r) over the fluid [kg/m^5]. Dummies have the density of
   the particle, so they have no part in it. Reference: G. Fourtakas et al., Computers & Fluids 190
   (2019) 346-361. */
PetscReal HydrostaticRise(const Stencil *st, const PetscReal slope[])
{
  PetscReal sum = 0.0;

  for (PetscInt a = 0; a < st->dim; a++) {
    PetscReal rise = 0.0;

    if (slope[a] == 0.0) continue;
    for (PetscInt k = 0; k < st->n; k++)
      if (!st->wall[k]) rise += st->radial[k] * st->X[a][k];
    sum += slope[a] * rise;
  }
  return 2.0 * sum;
}

/* Sets the values of the wall neighbours of particle i, see WcsphSetPairs(). */
static void SetWallPairs(const Wcsph *w, const PetscReal force[], Stencil *st, Pairs *pairs)
{
  const LocalFlow *l   = &w->local;
  const PetscReal  rho = l->rho[st->i];

  if (w->wall_start) {
    for (PetscInt q = 0; q < st->n_wall; q++) st->beta[st->walls[q]] = 1.0;
    return;
  }
  for (PetscInt q = 0; q < st->n_wall; q++) {
    const PetscInt k    = st->walls[q];
    PetscReal      rise = 0.0;

    for (PetscInt a = 0; a < st->dim; a++) {
      pairs->du[a][k] *= st->beta[k];
      rise += force[a] * st->X[a][k];
    }
    st->V[k] *= pairs->rho[k] / rho;
    pairs->rho[k] = rho;
    pairs->p[k]   = l->p[st->i] + rho * rise;
  }
}

/* Unpacks volume, density, pressure and velocity difference of the neighbours; inlined for each
   dimension. Input: own - packed values of the particle */
static ISPH_INLINE void Unpack(PetscInt dim, const PetscReal packed[], const PetscReal own[],
                               const Stencil *st, Pairs *pairs)
{
  PetscReal *const V = st->V, *const rho = pairs->rho, *const p = pairs->p;
  PetscReal *const du[ISPH_MAX_DIM] = {pairs->du[0], pairs->du[1], pairs->du[2]};

  for (PetscInt k = 0; k < st->n; k++) {
    const PetscReal *from = packed + PACKED(dim) * st->j[k];

    V[k]   = from[0];
    rho[k] = from[1];
    p[k]   = from[2];
    for (PetscInt a = 0; a < dim; a++) du[a][k] = from[3 + a] - own[3 + a];
  }
}

/*
  WcsphSetPairs - Sets volume, density, pressure and velocity difference of the neighbours. A dummy
  behind a wall has the density of the particle, its pressure continued by the body force f, and the
  velocity of the wall treatment:

    p_w = p_i + rho_i f.X,   u_w - u_i = beta (u_wall - u_i)

  A dummy of a dynamic wall has its own values, as fluid has. Input: force - f of ContinuingForce()
*/
ISPH_WIDE PetscErrorCode WcsphSetPairs(Wcsph *w, const PetscReal force[], Stencil *st)
{
  const LocalFlow *l     = &w->local;
  Pairs           *pairs = &w->pairs;
  const PetscReal *own   = l->packed + PACKED(st->dim) * st->i;

  PetscFunctionBegin;
  PetscCall(PairsReserve(st->capacity, pairs));
  if (st->dim == 2) Unpack(2, l->packed, own, st, pairs);
  else Unpack(3, l->packed, own, st, pairs);
  PairsFinish(l->rho[st->i], st, pairs);
  if (st->n_wall) SetWallPairs(w, force, st, pairs);
  st->volume = own[0];
  st->sloped = SLOPE_NONE;
  pairs->c   = st->slope;
  PetscFunctionReturn(PETSC_SUCCESS);
}
