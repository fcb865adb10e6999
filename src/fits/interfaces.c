/* Interfaces of fluids near a place, from the distances d_j and unit normals n_j that particles
   carry. Particle j gives the foot y_j = x_j - d_j n_j on the interface that it sees. Normals tell
   the two interfaces of a band apart, which distances alone do not: they point to opposite
   sides. */
#include "isph/fits.h"

#define RADIUS       2.5  /* of the fits [dx_j] */
#define ALONG        0.2  /* weight of the distance of a foot along the interface */
#define ALIKE        0.5  /* least product of normals of particles that see one interface */
#define AGREE        0.3  /* largest difference of their distances of the place from it [dx] */
#define RIDGE        0.01 /* of the change of the normal by a fit [dx^2] */
#define BESIDE       1.25 /* most along an interface from particles that see it [dx_i] */
#define RELAX        0.2  /* part of the way of a distance to that of its fit in a step */
#define NEXT         1.5  /* of particles of two fluids beside each other [dx_i] */
#define STRETCH_MOST 2.0  /* of distances between two steps */
#define UNKNOWN      (ISPH_MAX_DIM + 1)

/* Returns true if particle j is fluid and sees an interface. */
static PetscBool Sees(const Particles *p, PetscInt j)
{
  PetscReal n2 = 0.0;

  for (PetscInt a = 0; a < p->dim; a++) n2 += PetscSqr(p->interface_normal[a][j]);
  return n2 > 0.0 && !ParticlesIsWall(p, j);
}

/* The interface that a particle sees, from the fluid `own`. */
typedef struct {
  PetscReal r;               /* distance of the particle from the place [m] */
  PetscReal phi;             /* signed distance of the particle, positive in `own` [m] */
  PetscReal X[ISPH_MAX_DIM]; /* from the place to the particle [m] */
  PetscReal n[ISPH_MAX_DIM]; /* normal into `own` */
} Sight;

static void Look(const Particles *p, const PetscReal x[], PetscInt own, PetscInt j, Sight *sight)
{
  const PetscReal sign = (PetscInt)p->fluid[j] == own ? 1.0 : -1.0;

  sight->phi = sign * p->interface[j];
  sight->r   = 0.0;
  for (PetscInt a = 0; a < p->dim; a++) {
    sight->X[a] = p->x[a][j] - x[a];
    sight->n[a] = sign * p->interface_normal[a][j];
    sight->r += PetscSqr(sight->X[a]);
  }
  sight->r = PetscSqrtReal(sight->r);
}

/* Returns the signed distance of the place that a particle says, with the mean of its normal and
   n, which is exact to second order [m]. Output: alike - product of both normals. */
static PetscReal Told(PetscInt dim, const Sight *sight, const PetscReal n[], PetscReal *alike)
{
  PetscReal told = sight->phi;

  *alike = 0.0;
  for (PetscInt a = 0; a < dim; a++) {
    told -= 0.5 * (sight->n[a] + n[a]) * sight->X[a];
    *alike += sight->n[a] * n[a];
  }
  return told;
}

/* Sums of a linear fit in s = (1, X) of particles that see one interface. */
typedef struct {
  PetscReal A[UNKNOWN * UNKNOWN], b[UNKNOWN], sum, mean[ISPH_MAX_DIM];
} Sums;

/* Adds the equation c + delta.X = value of a particle. */
static void AddEquation(PetscInt dim, const Sight *sight, PetscReal w, PetscReal value, Sums *sums)
{
  PetscReal s[UNKNOWN] = {1.0};

  for (PetscInt a = 0; a < dim; a++) {
    s[1 + a] = sight->X[a];
    sums->mean[a] += w * sight->n[a];
  }
  sums->sum += w;
  for (PetscInt k = 0; k <= dim; k++) {
    for (PetscInt l = 0; l <= dim; l++) sums->A[k * (dim + 1) + l] += w * s[k] * s[l];
    sums->b[k] += w * s[k] * value;
  }
}

/*
  Adds the equations of all particles that see the interface with the normal n at the distance
  `offset` from the place

    phi_j - (n_j - n)/2.X_j - n.X_j = c + delta.X_j

  which a quadratic phi satisfies with c = phi and n + delta between n and its gradient.
*/
static void SumSights(const Particles *p, const PetscReal front[], const PetscReal x[],
                      PetscInt own, PetscInt count, const PetscInt list[], const PetscReal n[],
                      PetscReal offset, Sums *sums)
{
  *sums = (Sums){.sum = 0.0};
  for (PetscInt k = 0; k < count; k++) {
    const PetscInt  j = list[k];
    const PetscReal R = RADIUS * p->dx[j];
    PetscReal       told, alike;
    Sight           sight;

    if (!Sees(p, j) || (front && !front[j])) continue;
    Look(p, x, own, j, &sight);
    told = Told(p->dim, &sight, n, &alike);
    if (sight.r >= R || alike < ALIKE || PetscAbsReal(told - offset) > AGREE * p->dx[j]) continue;
    AddEquation(p->dim, &sight, PetscSqr(1.0 - PetscSqr(sight.r / R)), told, sums);
  }
}

/* Solves for c and delta; a ridge keeps delta zero in directions without particles. */
static void SolveSums(PetscInt dim, PetscReal dx, Sums *sums)
{
  for (PetscInt a = 1; a <= dim; a++)
    sums->A[a * (dim + 1) + a] += RIDGE * sums->sum * PetscSqr(dx);
  if (DenseCholesky(dim + 1, sums->A)) {
    sums->b[0] /= sums->sum;
    for (PetscInt a = 1; a <= dim; a++) sums->b[a] = 0.0;
    return;
  }
  DenseCholeskySolve(dim + 1, sums->A, sums->b);
}

/* Fits the plane of the interface with the normal n at the distance `offset`: gives its distance d
   from the place and its normal; returns false, and changes neither, without particles. */
static PetscBool FitPlane(const Particles *p, const PetscReal front[], const PetscReal x[],
                          PetscInt own, PetscInt count, const PetscInt list[], PetscReal offset,
                          PetscReal *d, PetscReal n[])
{
  PetscReal mean[ISPH_MAX_DIM] = {0.0}, length = 0.0;
  Sums      sums;

  SumSights(p, front, x, own, count, list, n, offset, &sums);
  if (sums.sum == 0.0) return PETSC_FALSE;
  for (PetscInt a = 0; a < p->dim; a++) mean[a] = sums.mean[a] / sums.sum;
  SumSights(p, front, x, own, count, list, mean, offset, &sums);
  if (sums.sum == 0.0) return PETSC_FALSE;
  SolveSums(p->dim, p->dx[list[0]], &sums);
  for (PetscInt a = 0; a < p->dim; a++) {
    n[a] = mean[a] + 2.0 * sums.b[1 + a];
    length += PetscSqr(n[a]);
  }
  length = PetscSqrtReal(length);
  for (PetscInt a = 0; a < p->dim; a++) n[a] /= length;
  *d = sums.b[0] / length;
  return PETSC_TRUE;
}

/* Finds the particle that sees the interface nearest to the place, by the distances of its plane
   and of its foot along it; -1 if none sees any. Output: nearest - the nearest fluid particle, or
   -1. */
static PetscInt FindLeader(const Particles *p, const PetscReal x[], PetscInt count,
                           const PetscInt list[], PetscInt *nearest)
{
  PetscReal best = PETSC_INFINITY, least = PETSC_INFINITY;
  PetscInt  leader = -1;

  *nearest = -1;
  for (PetscInt k = 0; k < count; k++) {
    const PetscInt j = list[k];
    PetscReal      plane, alike, along2, apart;
    Sight          sight;

    if (ParticlesIsWall(p, j)) continue;
    Look(p, x, (PetscInt)p->fluid[j], j, &sight);
    if (sight.r < least) *nearest = j;
    least = PetscMin(least, sight.r);
    if (!Sees(p, j) || sight.r >= RADIUS * p->dx[j]) continue;
    plane  = Told(p->dim, &sight, sight.n, &alike);
    along2 = PetscSqr(sight.r) - PetscSqr(sight.phi - plane);
    apart  = PetscSqr(plane) + PetscSqr(ALONG) * along2;
    if (apart >= best) continue;
    best   = apart;
    leader = j;
  }
  return leader;
}

/* Finds the nearest particle of another fluid beyond a plane; -1 if there is none. */
static PetscInt FindBeyond(const Particles *p, const PetscReal x[], PetscInt count,
                           const PetscInt list[], const InterfacePlane *plane)
{
  PetscReal best  = PETSC_INFINITY;
  PetscInt  other = -1;

  for (PetscInt k = 0; k < count; k++) {
    const PetscInt j      = list[k];
    PetscReal      height = plane->offset, r2 = 0.0;

    if (ParticlesIsWall(p, j) || (PetscInt)p->fluid[j] == plane->fluid[0]) continue;
    for (PetscInt a = 0; a < p->dim; a++) {
      height += plane->normal[a] * (p->x[a][j] - x[a]);
      r2 += PetscSqr(p->x[a][j] - x[a]);
    }
    if (height > 0.0 || r2 >= best) continue;
    best  = r2;
    other = j;
  }
  return other;
}

/*
  InterfaceNear - Finds the interface of two fluids nearest to a place, as a plane

    offset + normal.(y - x) = 0,   positive in plane->fluid[0], negative in plane->fluid[1]

  A fit over the particles within 2.5 dx that see the same interface as the one to which x is
  nearest: exact for straight interfaces, however the particles lie and however thin a fluid is
  between two of them; of second order for curved ones. Input: p - the particles; x - the place [m];
  list - `count` local indices near it; walls are left out. Output: plane - with an interface its
  plane; without, both fluids are that of the nearest particle. Returns: true if there is an
  interface, that is, if particles see it and fluid beyond it is near. The fluid at x is
  plane->fluid[plane->offset < 0].
*/
PetscBool InterfaceNear(const Particles *p, const PetscReal x[], PetscInt count,
                        const PetscInt list[], InterfacePlane *plane)
{
  PetscInt  nearest, leader = FindLeader(p, x, count, list, &nearest), own, other;
  PetscReal offset, alike;
  Sight     sight;

  own    = nearest < 0 ? 0 : (PetscInt)p->fluid[nearest];
  *plane = (InterfacePlane){.fluid = {own, own}, .offset = PETSC_INFINITY};
  if (leader < 0) return PETSC_FALSE;
  own = (PetscInt)p->fluid[leader];
  Look(p, x, own, leader, &sight);
  offset = Told(p->dim, &sight, sight.n, &alike);
  for (PetscInt a = 0; a < p->dim; a++) plane->normal[a] = sight.n[a];
  if (!FitPlane(p, NULL, x, own, count, list, offset, &plane->offset, plane->normal))
    return PETSC_FALSE;
  plane->fluid[0] = own;
  other           = FindBeyond(p, x, count, list, plane);
  plane->fluid[1] = other < 0 ? own : (PetscInt)p->fluid[other];
  return !(other < 0);
}

/* InterfacesUpdateHalo - Copies distances from interfaces and normals to the halo; collective */
PetscErrorCode InterfacesUpdateHalo(Particles *p)
{
  PetscFunctionBegin;
  if (!p->fluid) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ParticlesHaloField(p, p->interface));
  PetscCall(ParticlesHaloComponents(p, p->interface_normal));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The interface that particle i sees at its new place. */
typedef struct {
  PetscReal d, n[ISPH_MAX_DIM]; /* [m], [-] */
} Seen;

/* Returns true if particle i sees an interface that the fluids around its foot bear out: more of
   them are on their sides of it than are not. Such particles carry the place of an interface, and
   others take it from them. */
static PetscBool IsFront(const Particles *p, PetscInt i, PetscInt count, const PetscInt list[],
                         const PetscReal x[])
{
  const PetscInt  own   = (PetscInt)p->fluid[i];
  const PetscReal dx    = p->dx[i];
  PetscInt        votes = 0;
  Sight           at, sight;

  if (!Sees(p, i)) return PETSC_FALSE;
  Look(p, x, own, i, &at);
  for (PetscInt k = 0; k < count; k++) {
    PetscReal height = 0.0, along2;
    PetscBool same;

    if (ParticlesIsWall(p, list[k])) continue;
    Look(p, x, own, list[k], &sight);
    for (PetscInt a = 0; a < p->dim; a++) height += at.n[a] * sight.X[a];
    along2 = PetscSqr(sight.r) - PetscSqr(height);
    if (sight.r > RADIUS * dx || along2 > PetscSqr(BESIDE * dx)) continue;
    height += at.phi;
    same = (PetscInt)p->fluid[list[k]] == own;
    if (height < 0.0 && height > -dx) votes += same ? -1 : 1;
    if (height > AGREE * dx && !same) votes--;
  }
  return votes > 0;
}

/* Brings the distance of particle i towards c/|grad phi| of a fit to the distances that it and its
   neighbours carry, and turns its normal along the gradient. */
static void Restore(const Particles *p, PetscInt i, PetscInt count, const PetscInt list[],
                    const PetscReal x[], Seen *seen)
{
  PetscReal length = 0.0;
  Sums      sums;

  SumSights(p, NULL, x, (PetscInt)p->fluid[i], count, list, seen->n, seen->d, &sums);
  AddEquation(p->dim, &(Sight){.phi = seen->d}, 1.0, seen->d, &sums);
  SolveSums(p->dim, p->dx[i], &sums);
  for (PetscInt a = 0; a < p->dim; a++) {
    seen->n[a] += sums.b[1 + a];
    length += PetscSqr(seen->n[a]);
  }
  length = PetscSqrtReal(length);
  for (PetscInt a = 0; a < p->dim; a++) seen->n[a] /= length;
  length = PetscMin(PetscMax(length, 1.0 / STRETCH_MOST), STRETCH_MOST);
  seen->d += RELAX * (PetscMax(sums.b[0] / length, 0.0) - seen->d);
}

/* Lets particle i see the nearest interface of particles at interfaces; beyond the end of their
   planes the distance is that from the end. */
static void SeeFront(const Particles *p, const PetscReal front[], PetscInt i, PetscInt count,
                     const PetscInt list[], const PetscReal x[], Seen *seen)
{
  const PetscInt own  = (PetscInt)p->fluid[i];
  PetscReal      best = INTERFACE_REACH * p->dx[i], offset = 0.0, beyond = 0.0;

  *seen = (Seen){.d = best};
  for (PetscInt k = 0; k < count; k++) {
    PetscReal told, alike, excess, d;
    Sight     sight;

    if (!front[list[k]]) continue;
    Look(p, x, own, list[k], &sight);
    told   = Told(p->dim, &sight, sight.n, &alike);
    excess = PetscSqr(sight.r) - PetscSqr(sight.phi - told);
    excess = PetscMax(PetscSqrtReal(PetscMax(excess, 0.0)) - BESIDE * p->dx[i], 0.0);
    d      = PetscSqrtReal(PetscSqr(told) + PetscSqr(excess));
    if (d >= best || (told < 0.0 && excess == 0.0)) continue;
    best = seen->d = d;
    offset         = told;
    beyond         = excess;
    for (PetscInt a = 0; a < p->dim; a++) seen->n[a] = sight.n[a];
  }
  if (best < INTERFACE_REACH * p->dx[i] && beyond == 0.0)
    FitPlane(p, front, x, own, count, list, offset, &seen->d, seen->n);
  seen->d = PetscMax(seen->d, 0.0);
}

/* Places an interface before particle i, if it sees none and another fluid is next to it: half way
   to that fluid, across the mean direction to it. */
static void SeeOther(const Particles *p, PetscInt i, PetscInt count, const PetscInt list[],
                     const PetscReal x[], Seen *seen)
{
  const PetscInt own  = (PetscInt)p->fluid[i];
  PetscReal      best = NEXT * p->dx[i], n[ISPH_MAX_DIM] = {0.0}, length = 0.0;

  for (PetscInt pass = 0; pass < 2; pass++) {
    for (PetscInt k = 0; k < count; k++) {
      PetscReal height = 0.0;
      Sight     sight;

      Look(p, x, own, list[k], &sight);
      if (ParticlesIsWall(p, list[k]) || (PetscInt)p->fluid[list[k]] == own ||
          sight.r > NEXT * p->dx[i])
        continue;
      for (PetscInt a = 0; a < p->dim; a++) {
        height -= n[a] * sight.X[a];
        n[a] -= pass ? 0.0 : sight.X[a] / PetscSqr(sight.r);
      }
      if (pass) best = PetscMin(best, height);
    }
    for (PetscInt a = 0; !pass && a < p->dim; a++) length += PetscSqr(n[a]);
    if (length == 0.0) return;
    for (PetscInt a = 0; !pass && a < p->dim; a++) n[a] /= PetscSqrtReal(length);
  }
  seen->d = 0.5 * PetscMax(best, 0.0);
  for (PetscInt a = 0; a < p->dim; a++) seen->n[a] = n[a];
}

/*
  InterfacesFollow - Renews the distances of moved particles from interfaces

    d += RELAX (phi/|grad phi| - d)

  Collective. An interface is material, so that a particle carries its signed distance phi; where
  the flow strains the fluid, phi is a distance no more, but still zero on the interface. Particles
  at an interface go to the value of a fit over its gradient, see SumSights(), a part of the way in
  each step: a value of their own alone, divided by the gradient of their neighbours, would drift to
  zero or grow. The others take their distance from particles at interfaces, and forget it if there
  are none. Input: nb - neighbours at the new places. The halo is out of date on exit.
*/
PetscErrorCode InterfacesFollow(Particles *p, const Neighbors *nb)
{
  PetscReal *front;
  Seen      *all;

  PetscFunctionBegin;
  if (!p->fluid) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(InterfacesUpdateHalo(p));
  PetscCall(PetscMalloc1(p->n_fluid, &all));
  PetscCall(PetscCalloc1(ParticlesAll(p), &front));
  for (PetscInt pass = 0; pass < 2; pass++) {
    for (PetscInt i = 0; i < p->n_fluid; i++) {
      const PetscInt *list = &nb->col[nb->row[i]], count = nb->row[i + 1] - nb->row[i];
      PetscReal       x[ISPH_MAX_DIM] = {0.0};

      for (PetscInt a = 0; a < p->dim; a++) x[a] = p->x[a][i];
      if (!pass) {
        front[i] = IsFront(p, i, count, list, x) ? 1.0 : 0.0;
        continue;
      }
      all[i].d = p->interface[i];
      for (PetscInt a = 0; a < p->dim; a++) all[i].n[a] = p->interface_normal[a][i];
      if (front[i]) Restore(p, i, count, list, x, &all[i]);
      else SeeFront(p, front, i, count, list, x, &all[i]);
      if (all[i].d == INTERFACE_REACH * p->dx[i]) SeeOther(p, i, count, list, x, &all[i]);
    }
    if (!pass) PetscCall(ParticlesHaloField(p, front));
  }
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    p->interface[i] = all[i].d;
    for (PetscInt a = 0; a < p->dim; a++) p->interface_normal[a][i] = all[i].n[a];
  }
  PetscCall(FreeAll(&front, &all));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* InterfaceSlip - Changes the distance of particle i by a displacement against the fluid, `slip`
   [m]; no particle crosses an interface */
void InterfaceSlip(Particles *p, PetscInt i, const PetscReal slip[])
{
  PetscReal d = p->interface[i];

  for (PetscInt a = 0; a < p->dim; a++) d += p->interface_normal[a][i] * slip[a];
  p->interface[i] = PetscMax(d, 0.0);
}
