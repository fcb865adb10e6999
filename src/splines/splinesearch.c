/* The search for the particles in the fits at points of quadrature: once for the points of a cell,
   which share most of their particles, then the nearest of them for each point. */
#include "splines.h"

#define FIRST_SHARE 1.3  /* particles within the first search over those wanted; mostly enough */
#define LANES       8    /* numbers that a loop treats at once; r2 is padded to a multiple */
#define SHELL_ABOVE 1.15 /* squared radii of a shell about the last fit's */
#define SHELL_BELOW 0.8
#define SAME_SUM    1e-9 /* difference of equal sums of parts */

/* Returns true if particle j takes part in the fit of component c of the velocity: fluid, and wall
   particles whose normal is along c; for all components, c = SPLINE_ALL, all wall particles. A
   boundary that does not give its velocity takes no part. Of a wall the divergence uses the normal
   velocity only. With the tangential velocity, the fits would follow the jump between a lid and a
   wall at rest, and the flow ends within a few steps. */
static inline PetscBool TakesPart(const Particles *p, PetscInt j, PetscInt c)
{
  return c == SPLINE_ALL || !ParticlesIsWall(p, j) || PetscAbsReal(p->normal[c][j]) > 0.5;
}

/* Returns true if the boundary of a wall particle gives the normal velocity. */
static PetscBool GivesVelocity(const Scene *scene, const Particles *p, PetscInt j)
{
  return BoundaryEquation(scene, (PetscInt)p->side[j], FIT_VELOCITY_NORMAL) == EQUATION_VALUE;
}

/* Returns true if the normal of a wall particle is along no axis. */
static PetscBool IsOblique(const Particles *p, PetscInt j)
{
  PetscReal most = 0.0;

  for (PetscInt a = 0; a < p->dim; a++) most = PetscMax(most, PetscAbsReal(p->normal[a][j]));
  return most < 1.0 - 1e-12;
}

/* SplineLeast - Returns the number of particles with which a fit begins: for 6, 10, 15 coefficients
   in 2D, and 10, 20, 35 in 3D; not collective */
PetscInt SplineLeast(PetscInt dim, PetscInt degree)
{
  static const PetscInt least[2][MLS_MAX_DEGREE - 1] = {{14, 22, 34}, {28, 50, NEAREST_LEAST}};

  return least[dim - 2][degree - 2];
}

/* Returns the reach of the first search [m], which mostly finds enough particles: the radius of a
   ball that holds FIRST_SHARE times as many as a fit begins with, at most the support. If there are
   bodies, which may be oblique, it is the support, see SplineIsNearOblique(). */
static PetscReal FirstReach(const Flow *flow)
{
  const OperatorForms *forms = &flow->ops->forms;
  const PetscInt       dim   = flow->scene->dim;
  const PetscReal      ball  = dim == 2 ? PETSC_PI : 4.0 / 3.0 * PETSC_PI;
  const PetscReal      size  = FIRST_SHARE * (PetscReal)SplineLeast(dim, forms->degree) / ball;
  const PetscReal      share =
      PetscPowReal(size, 1.0 / dim) / (forms->kernel->support * forms->h_over_dx);

  return forms->radius * (flow->scene->n_bodies ? 1.0 : PetscMin(1.0, share));
}

/* Lists the particles within reach of the points of a cell. Dummies stand for the nearest point of
   the wall, and only their first layer counts. */
static PetscErrorCode Gather(const Flow *flow, PetscReal reach, SplineAround *around)
{
  const Particles *p    = flow->particles;
  const WallRow   *wall = flow->ops->forms.wall;
  const PetscReal  move =
      0.5 * flow->neighbors->margin + (wall && !wall->on_surface ? p->dx[0] : 0.0);
  PetscReal centre[ISPH_MAX_DIM] = {0.0}, extent = 0.0, radius;
  PetscInt  near, n = 0, walls = 0;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < p->dim; a++) {
    for (PetscInt i = 0; i < around->m; i++) centre[a] += around->at[a][i] / around->m;
  }
  for (PetscInt i = 0; i < around->m; i++) {
    PetscReal r2 = 0.0;

    for (PetscInt a = 0; a < p->dim; a++) r2 += PetscSqr(around->at[a][i] - centre[a]);
    extent = PetscMax(extent, r2);
  }
  radius = reach + 1.0001 * PetscSqrtReal(extent);
  PetscCall(CellsFind(&flow->neighbors->cells, centre, radius + move, around->capacity, around->j,
                      &near));
  around->reach = reach;
  for (PetscInt k = 0; k < near; k++) {
    const PetscInt  j       = around->j[k];
    const PetscBool is_wall = ParticlesIsWall(p, j);
    PetscReal       x[ISPH_MAX_DIM], r2 = 0.0;

    if (is_wall && (p->depth[j] >= p->dx[j] || !GivesVelocity(flow->scene, p, j))) continue;
    if (is_wall) ParticlesWallPoint(p, j, x);
    for (PetscInt a = 0; a < p->dim; a++) {
      if (!is_wall) x[a] = p->x[a][j];
      r2 += PetscSqr(x[a] - centre[a]);
    }
    if (is_wall && r2 >= radius * radius) continue;
    for (PetscInt a = 0; a < p->dim; a++) around->x[a][n] = x[a];
    around->wall[n] = is_wall;
    around->part[n] = 1.0;
    walls += is_wall ? 1 : 0;
    around->j[n] = j;
    n += r2 < radius * radius ? 1 : 0; /* no branch: it would be mispredicted */
  }
  around->n     = n;
  around->walls = walls;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the points of the cell that begins with point `first`: in a cell the same splines are not
   zero. */
static void SetPoints(const Splines *s, PetscInt first, SplineAround *around)
{
  const SplinePoints *points = &s->inside;
  const PetscInt     *cell   = s->inside_at.base;
  const PetscInt      dim    = s->lattice.dim;
  PetscInt            m      = 0;

  for (; m < 1 << dim && first + m < points->n && cell[first + m] == cell[first]; m++) {
    for (PetscInt a = 0; a < dim; a++) {
      around->at[a][m]      = points->x[a][first + m];
      around->stretch[a][m] = points->stretch[a] ? points->stretch[a][first + m] : 1.0;
    }
  }
  around->m = m;
}

/* SplineAroundSet - Sets the points of the cell that begins with point `first`, and the particles
   around them; not collective */
PetscErrorCode SplineAroundSet(const Flow *flow, const Splines *s, PetscInt first,
                               SplineAround *around)
{
  PetscFunctionBegin;
  SetPoints(s, first, around);
  PetscCall(Gather(flow, FirstReach(flow), around));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineAroundCreate - Allocates the lists; not collective */
PetscErrorCode SplineAroundCreate(const Flow *flow, SplineAround *around)
{
  const PetscInt n = flow->neighbors->cells.n + LANES;

  PetscFunctionBegin;
  *around = (SplineAround){.capacity = n};
  PetscCall(PetscMalloc5(n, &around->j, n, &around->wall, n, &around->r2, n, &around->part, n,
                         &around->found));
  for (PetscInt a = 0; a < flow->scene->dim; a++) PetscCall(PetscMalloc1(n, &around->x[a]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineAroundFree - Frees the lists; not collective */
PetscErrorCode SplineAroundFree(SplineAround *around)
{
  PetscFunctionBegin;
  PetscCall(PetscFree5(around->j, around->wall, around->r2, around->part, around->found));
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) PetscCall(PetscFree(around->x[a]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the squared distances of all particles from point i. */
static ISPH_INLINE void SetDistances(PetscInt dim, PetscInt i, SplineAround *around)
{
  PetscReal *r2 = around->r2;

  for (PetscInt k = around->n; k % LANES; k++) r2[k] = PETSC_INFINITY;
  for (PetscInt a = 0; a < dim; a++) {
    const PetscReal  x = around->at[a][i], stretch = around->stretch[a][i];
    const PetscReal *y = around->x[a];

    for (PetscInt k = 0; k < around->n; k++)
      r2[k] = (a ? r2[k] : 0.0) + PetscSqr(stretch * (y[k] - x));
  }
}

/* Returns the sum of the parts of the particles nearer than sqrt(limit). */
static ISPH_INLINE PetscReal SumWithin(const SplineAround *around, PetscReal limit)
{
  const PetscReal *r2 = around->r2, *part = around->part;
  PetscReal        sum[LANES] = {0.0}, total = 0.0;

  for (PetscInt k = 0; k < around->n; k += LANES) {
#pragma omp simd
    for (PetscInt i = 0; i < LANES; i++) sum[i] += r2[k + i] < limit ? part[k + i] : 0.0;
  }
  for (PetscInt i = 0; i < LANES; i++) total += sum[i];
  return total;
}

/* Lists the particles nearer than sqrt(limit) in around->found; returns their number. */
static ISPH_INLINE PetscInt ListNearer(PetscReal limit, SplineAround *around)
{
  const PetscReal *r2   = around->r2;
  const PetscInt   all  = around->n;
  PetscInt        *list = around->found, n = 0;

  for (PetscInt k = 0; k < all; k++) {
    list[n] = k;
    n += r2[k] < limit ? 1 : 0;
  }
  return n;
}

/* Lists the particles of squared distances in [low, high) in ascending order; returns their
   number. */
static ISPH_INLINE PetscInt ListBetween(PetscReal low, PetscReal high, SplineAround *around)
{
  const PetscReal *r2   = around->r2;
  const PetscInt   all  = around->n;
  PetscInt        *list = around->found, n = 0;

  for (PetscInt k = 0; k < all; k++) { /* no branch: it would be mispredicted */
    list[n] = k;
    n += (r2[k] >= low) & (r2[k] < high) ? 1 : 0;
  }
  for (PetscInt k = 1; k < n; k++) {
    const PetscInt moved = list[k];
    PetscInt       q     = k;

    for (; q > 0 && r2[list[q - 1]] > r2[moved]; q--) list[q] = list[q - 1];
    list[q] = moved;
  }
  return n;
}

/* Returns the squared radius of a fit of `wanted` particles, the nearest: the squared distance of
   the next, at most reach^2. A shell about the wanted number of particles is found first, by a
   guess on which the result does not depend, and its particles are sorted. The number of particles
   grows in proportion to the volume of the ball. */
static ISPH_INLINE PetscReal SquaredRadius(PetscInt dim, PetscReal wanted, PetscReal reach,
                                           SplineAround *around, PetscBool *found)
{
  const PetscReal all = PetscSqr(reach), guess = around->last2;
  PetscReal       high = PetscMin(all, guess > 0.0 ? SHELL_ABOVE * guess : 0.5 * all);
  PetscReal       low, below, sum = SumWithin(around, high);
  PetscInt        n, k = 0;

  while (sum + SAME_SUM < wanted + 1.0 && high < all) {
    const PetscReal share = (wanted + 4.0) / PetscMax(sum, 1.0);

    high = PetscMin(all, high * PetscMax(SHELL_ABOVE, dim == 2 ? share : PetscSqrtReal(share)));
    sum  = SumWithin(around, high);
  }
  *found = sum + SAME_SUM < wanted ? PETSC_FALSE : PETSC_TRUE;
  if (!*found) return all;
  for (low = SHELL_BELOW * high; (below = SumWithin(around, low)) + SAME_SUM >= wanted;
       low *= SHELL_BELOW)
    if (below + SAME_SUM >= wanted + 1.0) high = low;
  n = ListBetween(low, high, around);
  while (k < n && below + SAME_SUM < wanted) below += around->part[around->found[k++]];
  return k < n ? around->r2[around->found[k]] : high;
}

/* SplineNearest - Finds the particles for the fit of component c at point i: the `wanted` nearest.
   Not collective. In a fit of all components, c = SPLINE_ALL, a wall particle has one equation of
   dim and counts as such a part of a particle. The search begins with the reach given, or a usual
   one. It reaches further, up to the reach of the halo, while it finds too few. Output:
   around->found; n - their number; R - radius: the distance of the next, or the reach [m]; found -
   PETSC_FALSE if there are fewer within reach. */
ISPH_WIDE PetscErrorCode SplineNearest(const Flow *flow, PetscInt i, PetscInt c, PetscInt wanted,
                                       SplineAround *around, PetscReal *reach, PetscInt *n,
                                       PetscReal *R, PetscBool *found)
{
  const Particles *p      = flow->particles;
  const PetscReal  radius = flow->ops->forms.radius;
  const PetscReal  most   = PetscMax(radius, p->halo_width + 0.5 * p->skin);
  PetscReal        r2;

  PetscFunctionBegin;
  *reach = PetscMax(*reach, FirstReach(flow));
  while (PETSC_TRUE) {
    if (*reach > around->reach) PetscCall(Gather(flow, *reach, around));
    SetDistances(p->dim, i, around);
    for (PetscInt k = 0; around->walls && k < around->n; k++) {
      around->part[k] = around->wall[k] && c == SPLINE_ALL ? 1.0 / p->dim : 1.0;
      if (around->wall[k] && !TakesPart(p, around->j[k], c)) around->r2[k] = PETSC_INFINITY;
    }
    r2 = SquaredRadius(p->dim, wanted, *reach, around, found);
    if (*reach < radius && r2 >= PetscSqr(*reach)) *reach = radius;
    else if (*found || *reach >= most) break;
    else *reach = PetscMin(1.15 * *reach, most);
  }
  *n            = ListNearer(r2, around);
  *R            = PetscSqrtReal(r2);
  around->last2 = r2;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineIsNearOblique - Returns true if an oblique wall is within the support about point i of the
   cell; not collective */
PetscBool SplineIsNearOblique(const Flow *flow, PetscInt i, const SplineAround *around)
{
  const Particles *p = flow->particles;

  for (PetscInt k = 0; around->walls && k < around->n; k++) {
    PetscReal r2 = 0.0;

    if (!around->wall[k] || !IsOblique(p, around->j[k])) continue;
    for (PetscInt a = 0; a < p->dim; a++) r2 += PetscSqr(around->x[a][k] - around->at[a][i]);
    if (r2 < PetscSqr(flow->ops->forms.radius)) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* SplineFitIsShared - Returns true if the fits of components a and b at point i are the same: no
   wall particle within the radius R of the first takes part in one of them only; not collective */
PetscBool SplineFitIsShared(const Particles *p, PetscInt i, PetscInt a, PetscInt b, PetscReal R,
                            const SplineAround *around)
{
  for (PetscInt k = 0; around->walls && k < around->n; k++) {
    PetscReal r2 = 0.0;

    if (!around->wall[k]) continue;
    if (TakesPart(p, around->j[k], a) == TakesPart(p, around->j[k], b)) continue;
    for (PetscInt c = 0; c < p->dim; c++)
      r2 += PetscSqr(around->stretch[c][i] * (around->x[c][k] - around->at[c][i]));
    if (r2 < PetscSqr(R)) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}
