/*
  Fits of the velocity of particles at the points of quadrature of the splines. Walls take part with
  their normal velocity: beside walls along the axes in the fit of one component, beside oblique
  walls in a fit of all components together. The points of a cell share most of their particles and
  are treated together.
*/
#include "splines.h"

/* Particles in a fit, for 6 and 10 coefficients. */
#define FIT_NEAREST_2D  14
#define FIT_NEAREST_3D  28
#define FIT_MOST        3   /* times as many if their weights are large */
#define FIT_LARGEST_SUM 2.5 /* of absolute weights; 1.2 to 1.6 on a lattice */
#define FIT_FIRST_REACH 0.8 /* of the first search, over the support; mostly enough */

#define ALL (-1) /* components of the velocity */

#define LANES 8 /* numbers that a loop treats at once; arrays are padded to a multiple */

/* Points of quadrature in a cell, and the particles around them in ascending order. */
typedef struct {
  PetscInt   first, m; /* the points */
  PetscReal  reach;    /* distance from each point within which all particles are listed [m] */
  PetscInt   n, walls, capacity, *j;
  PetscReal *x[ISPH_MAX_DIM]; /* positions; of wall particles: their points on the wall [m] */
  PetscBool *wall;
  PetscReal *r2, *part; /* of a point: squared distances [m^2], and shares in the number wanted */
  PetscInt  *found;     /* particles of a fit, numbers in this list */
} Around;

#define FIT_CAPACITY ((FIT_MOST + 1) * FIT_NEAREST_3D)

/* Fits of a component at the points of a cell; the arrays are those of PointFits(). */
typedef struct {
  PetscInt  n[POINT_FITS]; /* particles in each */
  PetscReal R[POINT_FITS]; /* [m] */
  PetscInt  j[POINT_FITS * FIT_CAPACITY];
  PetscReal s[ISPH_MAX_DIM][POINT_FITS * FIT_CAPACITY];
  PetscReal W[POINT_FITS * FIT_CAPACITY], w[POINT_FITS * FIT_CAPACITY];
} Fits;

/* A fit of all components at a point; the arrays are those of VectorFit(). */
typedef struct {
  PetscInt  n, j[ISPH_MAX_DIM * FIT_CAPACITY];
  PetscReal s[ISPH_MAX_DIM][ISPH_MAX_DIM * FIT_CAPACITY], W[ISPH_MAX_DIM * FIT_CAPACITY];
  PetscReal w[ISPH_MAX_DIM * ISPH_MAX_DIM][ISPH_MAX_DIM * FIT_CAPACITY];
  PetscBool wall[ISPH_MAX_DIM * FIT_CAPACITY];
  PetscReal normal[ISPH_MAX_DIM][ISPH_MAX_DIM * FIT_CAPACITY];
} CoupledFit;

/*
  Returns true if particle j takes part in the fit of component c of the velocity: fluid, and wall
  particles whose normal is along c; for all components, c = ALL, all wall particles.

  Of a wall the divergence uses the normal velocity only. With the tangential velocity, the fits
  would follow the jump between a lid and a wall at rest, and the flow ends within a few steps.
*/
static inline PetscBool TakesPart(const Particles *p, PetscInt j, PetscInt c)
{
  return c == ALL || !ParticlesIsWall(p, j) || PetscAbsReal(p->normal[c][j]) > 0.5 ? PETSC_TRUE
                                                                                   : PETSC_FALSE;
}

/* Returns true if the normal of a wall particle is along no axis. */
static PetscBool IsOblique(const Particles *p, PetscInt j)
{
  PetscReal most = 0.0;

  for (PetscInt a = 0; a < p->dim; a++) most = PetscMax(most, PetscAbsReal(p->normal[a][j]));
  return most < 1.0 - 1e-12 ? PETSC_TRUE : PETSC_FALSE;
}

/* Returns the number of particles with which a fit begins. */
static inline PetscInt LeastParticles(PetscInt dim)
{
  return dim == 2 ? FIT_NEAREST_2D : FIT_NEAREST_3D;
}

/* Returns the reach of the first search [m]. Bodies may be oblique, which a point must know of
   within its support. */
static inline PetscReal FirstReach(const Flow *flow)
{
  return flow->ops->forms.radius * (flow->scene->n_bodies ? 1.0 : FIT_FIRST_REACH);
}

/* Lists the particles within reach of the points of a cell. Dummies stand for the nearest point of
   the wall, and only their first layer counts. */
static PetscErrorCode Gather(const Flow *flow, const SplinePoints *at, PetscReal reach,
                             Around *around)
{
  const Particles *p    = flow->particles;
  const WallRow   *wall = flow->ops->forms.wall;
  const PetscReal  move =
      0.5 * flow->neighbors->margin + (wall && !wall->on_surface ? p->dx[0] : 0.0);
  PetscReal centre[ISPH_MAX_DIM] = {0.0}, extent = 0.0, radius;
  PetscInt  near;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < p->dim; a++) {
    for (PetscInt i = 0; i < around->m; i++) centre[a] += at->x[a][around->first + i] / around->m;
  }
  for (PetscInt i = 0; i < around->m; i++) {
    PetscReal r2 = 0.0;

    for (PetscInt a = 0; a < p->dim; a++) r2 += PetscSqr(at->x[a][around->first + i] - centre[a]);
    extent = PetscMax(extent, r2);
  }
  radius = reach + 1.0001 * PetscSqrtReal(extent);
  PetscCall(CellsFind(&flow->neighbors->cells, centre, radius + move, around->capacity, around->j,
                      &near));
  around->n = around->walls = 0;
  around->reach             = reach;
  for (PetscInt k = 0; k < near; k++) {
    const PetscInt  j       = around->j[k];
    const PetscBool is_wall = ParticlesIsWall(p, j);
    PetscReal       x[ISPH_MAX_DIM], r2 = 0.0;

    if (is_wall && p->depth[j] >= p->dx[j]) continue;
    if (is_wall) ParticlesWallPoint(p, j, x);
    for (PetscInt a = 0; a < p->dim; a++) {
      if (!is_wall) x[a] = p->x[a][j];
      r2 += PetscSqr(x[a] - centre[a]);
    }
    if (r2 >= radius * radius) continue;
    for (PetscInt a = 0; a < p->dim; a++) around->x[a][around->n] = x[a];
    around->wall[around->n] = is_wall;
    around->part[around->n] = 1.0;
    around->walls += is_wall ? 1 : 0;
    around->j[around->n++] = j;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the squared distances of all particles from point i. */
static void SetDistances(PetscInt dim, const SplinePoints *at, PetscInt i, Around *around)
{
  PetscReal *r2 = around->r2;

  for (PetscInt k = 0; k < around->n; k++) r2[k] = 0.0;
  for (PetscInt k = around->n; k % LANES; k++) r2[k] = PETSC_INFINITY;
  for (PetscInt a = 0; a < dim; a++) {
    const PetscReal  x = at->x[a][around->first + i];
    const PetscReal *y = around->x[a];

    for (PetscInt k = 0; k < around->n; k++) r2[k] += PetscSqr(y[k] - x);
  }
}

/* Returns the sum of the parts of the particles nearer than sqrt(limit). */
static PetscReal SumWithin(const Around *around, PetscReal limit)
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

/* Returns the least squared distance of at least `low`, at most `high`. */
static PetscReal LeastBeyond(const Around *around, PetscReal low, PetscReal high)
{
  const PetscReal *r2 = around->r2;
  PetscReal        least[LANES];

  for (PetscInt i = 0; i < LANES; i++) least[i] = high;
  for (PetscInt k = 0; k < around->n; k += LANES) {
#pragma omp simd
    for (PetscInt i = 0; i < LANES; i++) {
      const PetscReal beyond = r2[k + i] < low ? high : r2[k + i];

      least[i] = beyond < least[i] ? beyond : least[i];
    }
  }
  for (PetscInt i = 1; i < LANES; i++) least[0] = PetscMin(least[0], least[i]);
  return least[0];
}

/*
  Returns the squared radius of a fit of `wanted` particles, the nearest: the squared distance of
  the next, at most reach^2

  Interpolation brackets it: in the plane, the number grows in proportion to the squared distance.
  If the number jumps beyond `wanted`, because distances are equal or parts are not, the radius is
  the second distance of the jump and beyond.
*/
static PetscReal SquaredRadius(const Around *around, PetscReal wanted, PetscReal reach,
                               PetscBool *found)
{
  const PetscReal all = PetscSqr(reach);
  PetscReal       low = 0.0, high = all, below = 0.0, above = SumWithin(around, all);
  PetscReal       next[2] = {all, all};

  *found = above + 1e-9 >= wanted ? PETSC_TRUE : PETSC_FALSE;
  if (!*found) return all;
  while (high - low > 1e-14 * high) {
    const PetscReal share  = (wanted + 0.5 - below) / (above - below);
    const PetscReal middle = low + PetscMax(0.1, PetscMin(share, 0.9)) * (high - low);
    const PetscReal sum    = SumWithin(around, middle);

    if (PetscAbsReal(sum - wanted) < 1e-9) return LeastBeyond(around, middle, all);
    if (sum < wanted) {
      low   = middle;
      below = sum;
    } else {
      high  = middle;
      above = sum;
    }
  }
  for (PetscInt k = 0; k < around->n; k++) {
    if (around->r2[k] < low || around->r2[k] >= next[1]) continue;
    next[1] = PetscMax(next[0], around->r2[k]);
    next[0] = PetscMin(next[0], around->r2[k]);
  }
  return next[1];
}

/*
  Finds the particles for the fit of component c at point i: the nearest of them, `wanted`. In a fit
  of all components a wall particle has one equation of dim and counts as such a part of a particle.
  The search begins with the reach given. It reaches further, up to the reach of the halo, while it
  finds too few.

  Output: n - their number; R - radius [m]; found - PETSC_FALSE if there are fewer within reach.
*/
static PetscErrorCode FindNearest(const Flow *flow, const SplinePoints *at, PetscInt i, PetscInt c,
                                  PetscInt wanted, Around *around, PetscReal *reach, PetscInt *n,
                                  PetscReal *R, PetscBool *found)
{
  const Particles *p      = flow->particles;
  const PetscReal  radius = flow->ops->forms.radius;
  const PetscReal  most   = PetscMax(radius, p->halo_width + 0.5 * p->skin);
  PetscReal        r2;

  PetscFunctionBegin;
  while (PETSC_TRUE) {
    if (*reach > around->reach) PetscCall(Gather(flow, at, *reach, around));
    SetDistances(p->dim, at, i, around);
    for (PetscInt k = 0; around->walls && k < around->n; k++) {
      around->part[k] = around->wall[k] && c == ALL ? 1.0 / p->dim : 1.0;
      if (around->wall[k] && !TakesPart(p, around->j[k], c)) around->r2[k] = PETSC_INFINITY;
    }
    r2 = SquaredRadius(around, wanted, *reach, found);
    if (*reach < radius && r2 >= PetscSqr(*reach)) *reach = radius;
    else if (*found || *reach >= most) break;
    else *reach = PetscMin(1.15 * *reach, most);
  }
  *n = 0;
  for (PetscInt k = 0; k < around->n; k++) {
    around->found[*n] = k;
    *n += around->r2[k] < r2 ? 1 : 0;
  }
  *R = PetscSqrtReal(r2);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the weight of a particle at the distance r, over the radius. */
static inline PetscReal FitWeight(PetscReal r)
{
  return PetscSqr(PetscSqr(1.0 - r)) * (1.0 + 4.0 * r);
}

/* Fills the arrays of the fit at point i with the particles found. */
static void FillFit(const Particles *p, const SplinePoints *at, PetscInt i, const Around *around,
                    Fits *f)
{
  const PetscInt  m       = 1 << p->dim;
  const PetscReal inverse = 1.0 / f->R[i];

  for (PetscInt e = 0; e < f->n[i]; e++) {
    const PetscInt k = around->found[e];

    f->j[e * m + i] = around->j[k];
    f->W[e * m + i] = FitWeight(PetscSqrtReal(around->r2[k]) * inverse);
    for (PetscInt a = 0; a < p->dim; a++)
      f->s[a][e * m + i] = (around->x[a][k] - at->x[a][around->first + i]) * inverse;
  }
}

/* Returns the largest number of particles in a fit, and pads the others with the weight zero. */
static PetscInt PadFits(PetscInt dim, Fits *f)
{
  const PetscInt m       = 1 << dim;
  PetscInt       longest = 0;

  for (PetscInt i = 0; i < m; i++) longest = PetscMax(longest, f->n[i]);
  for (PetscInt i = 0; i < m; i++) {
    for (PetscInt k = f->n[i]; k < longest; k++) {
      f->W[k * m + i] = 0.0;
      for (PetscInt a = 0; a < dim; a++) f->s[a][k * m + i] = 0.0;
    }
  }
  return longest;
}

/* Returns the sum of the absolute weights of fit i. */
static PetscReal SumOfWeights(PetscInt m, PetscInt i, const Fits *f)
{
  PetscReal sum = 0.0;

  for (PetscInt k = 0; k < f->n[i]; k++) sum += PetscAbsReal(f->w[k * m + i]);
  return sum;
}

/* Returns the largest sum of the absolute weights of a component. */
static PetscReal LargestSum(PetscInt dim, const CoupledFit *f)
{
  PetscReal largest = 0.0;

  for (PetscInt a = 0; a < dim; a++) {
    PetscReal sum = 0.0;

    for (PetscInt b = 0; b < dim; b++) {
      for (PetscInt k = 0; k < f->n; k++) sum += PetscAbsReal(f->w[a * dim + b][k]);
    }
    largest = PetscMax(largest, sum);
  }
  return largest;
}

/* Sets the weights of a coupled fit to those of a mean. */
static void SetCoupledMean(PetscInt dim, CoupledFit *f)
{
  PetscReal sum = 0.0;

  for (PetscInt k = 0; k < f->n; k++) sum += f->W[k];
  for (PetscInt k = 0; k < f->n; k++) {
    for (PetscInt e = 0; e < dim * dim; e++) f->w[e][k] = e % (dim + 1) ? 0.0 : f->W[k] / sum;
  }
}

/*
  Returns true if a fit of `wanted` particles needs more

  The nearest particles may lie near a conic section, on which a quadratic function vanishes. Then
  the weights are large and amplify the velocities: a fit of 14 with a sum of 22 spoilt the flow of
  64 x 64 particles within a step.

  Input: found - so many are within reach; sum - of the absolute weights, infinity without a fit.
*/
static PetscBool TakesMore(PetscInt dim, PetscInt wanted, PetscBool found, PetscReal sum)
{
  return found && sum > FIT_LARGEST_SUM && wanted < FIT_MOST * LeastParticles(dim) ? PETSC_TRUE
                                                                                   : PETSC_FALSE;
}

/* Sets the weights of fit i to those of a mean. */
static void SetMean(PetscInt m, PetscInt i, Fits *f)
{
  PetscReal sum = 0.0;

  for (PetscInt k = 0; k < f->n[i]; k++) sum += f->W[k * m + i];
  for (PetscInt k = 0; k < f->n[i]; k++) f->w[k * m + i] = f->W[k * m + i] / sum;
}

/* Computes the fits of component c at the points of a cell that have a flag. */
static PetscErrorCode FitComponent(Flow *flow, const SplinePoints *at, PetscInt c,
                                   const PetscBool todo[], Around *around, Fits *f)
{
  const Particles *p = flow->particles;
  const PetscInt   m = 1 << p->dim, least = LeastParticles(p->dim);
  PetscReal       *s[ISPH_MAX_DIM], reach[POINT_FITS];
  PetscInt         wanted[POINT_FITS], left = 0; /* wanted 0: the fit is done */
  PetscBool        fits[POINT_FITS], found[POINT_FITS];

  PetscFunctionBegin;
  for (PetscInt a = 0; a < p->dim; a++) s[a] = f->s[a];
  for (PetscInt i = 0; i < m; i++) {
    f->n[i]   = 0;
    wanted[i] = i < around->m && todo[i] ? least : 0;
    reach[i]  = FirstReach(flow);
    left += wanted[i] ? 1 : 0;
  }
  while (left) {
    for (PetscInt i = 0; i < m; i++) {
      if (!wanted[i]) continue;
      PetscCall(
          FindNearest(flow, at, i, c, wanted[i], around, &reach[i], &f->n[i], &f->R[i], &found[i]));
      FillFit(p, at, i, around, f);
    }
    PointFits(p->dim, PadFits(p->dim, f), s, f->W, f->w, fits);
    for (PetscInt i = 0; i < m; i++) {
      if (!wanted[i]) continue;
      if (TakesMore(p->dim, wanted[i], found[i],
                    fits[i] ? SumOfWeights(m, i, f) : PETSC_INFINITY)) {
        wanted[i] += least / 3;
      } else {
        wanted[i] = 0;
        left--;
      }
    }
  }
  for (PetscInt i = 0; i < m; i++) { /* flags of the last pass, which computes all fits */
    if (!f->n[i] || fits[i]) continue;
    flow->ops->regularised_rows++;
    SetMean(m, i, f);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the fit of all components at point i of a cell, see FitComponent(). */
static PetscErrorCode FitCoupled(Flow *flow, const SplinePoints *at, PetscInt i, Around *around,
                                 CoupledFit *f)
{
  const Particles *p   = flow->particles;
  const PetscInt   dim = p->dim;
  PetscReal       *s[ISPH_MAX_DIM], *normal[ISPH_MAX_DIM], *w[ISPH_MAX_DIM * ISPH_MAX_DIM];
  PetscReal        reach = FirstReach(flow), R = reach, size;
  PetscInt         wanted = LeastParticles(dim);
  PetscBool        found;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < dim; a++) {
    s[a]      = f->s[a];
    normal[a] = f->normal[a];
  }
  for (PetscInt e = 0; e < dim * dim; e++) w[e] = f->w[e];
  for (size = PETSC_INFINITY;; wanted += LeastParticles(dim) / 3) {
    PetscCall(FindNearest(flow, at, i, ALL, wanted, around, &reach, &f->n, &R, &found));
    for (PetscInt e = 0; e < f->n; e++) {
      const PetscInt k = around->found[e];

      f->j[e]    = around->j[k];
      f->wall[e] = around->wall[k];
      f->W[e]    = FitWeight(PetscSqrtReal(around->r2[k]) / R);
      for (PetscInt a = 0; a < dim; a++) {
        f->s[a][e]      = (around->x[a][k] - at->x[a][around->first + i]) / R;
        f->normal[a][e] = f->wall[e] ? p->normal[a][f->j[e]] : 0.0;
      }
    }
    size = VectorFit(dim, f->n, s, f->W, f->wall, normal, w) ? LargestSum(dim, f) : PETSC_INFINITY;
    if (!TakesMore(dim, wanted, found, size)) break;
  }
  if (size < PETSC_INFINITY) PetscFunctionReturn(PETSC_SUCCESS);
  flow->ops->regularised_rows++;
  SetCoupledMean(dim, f);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns true if an oblique wall is within the support about point i of a cell. */
static PetscBool IsNearOblique(const Flow *flow, const SplinePoints *at, PetscInt i,
                               const Around *around)
{
  const Particles *p = flow->particles;

  for (PetscInt k = 0; around->walls && k < around->n; k++) {
    PetscReal r2 = 0.0;

    if (!around->wall[k] || !IsOblique(p, around->j[k])) continue;
    for (PetscInt a = 0; a < p->dim; a++)
      r2 += PetscSqr(around->x[a][k] - at->x[a][around->first + i]);
    if (r2 < PetscSqr(flow->ops->forms.radius)) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Returns true if the fits of components a and b at point i are the same: no wall particle within
   the radius of the first takes part in one of them only. */
static PetscBool FitIsShared(const Particles *p, const SplinePoints *at, PetscInt i, PetscInt a,
                             PetscInt b, PetscReal R, const Around *around)
{
  for (PetscInt k = 0; around->walls && k < around->n; k++) {
    PetscReal r2 = 0.0;

    if (!around->wall[k]) continue;
    if (TakesPart(p, around->j[k], a) == TakesPart(p, around->j[k], b)) continue;
    for (PetscInt c = 0; c < p->dim; c++)
      r2 += PetscSqr(around->x[c][k] - at->x[c][around->first + i]);
    if (r2 < PetscSqr(R)) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* Fits at the points of a cell. */
typedef struct {
  PetscInt   sets;    /* components with fits of their own: 1 if boundaries make no difference */
  PetscBool  coupled; /* fits of a component have entries of the others */
  PetscBool  oblique[POINT_FITS];              /* point i has a coupled fit */
  PetscInt   shared[ISPH_MAX_DIM][POINT_FITS]; /* component whose fit serves component c */
  Fits       component[ISPH_MAX_DIM];
  CoupledFit all[POINT_FITS];
} CellFits;

/* Computes all fits in a cell. Beside walls each component has a fit of its own; elsewhere they
   share it. Beside walls oblique to the axes there is a fit of all components together. */
static PetscErrorCode FitCell(Flow *flow, const SplinePoints *at, Around *around, CellFits *f)
{
  const Particles *p = flow->particles;

  PetscFunctionBegin;
  PetscCall(Gather(flow, at, FirstReach(flow), around));
  for (PetscInt i = 0; i < around->m; i++) f->oblique[i] = IsNearOblique(flow, at, i, around);
  for (PetscInt c = 0; c < f->sets; c++) {
    PetscBool todo[POINT_FITS];

    for (PetscInt i = 0; i < around->m; i++) {
      f->shared[c][i] = c;
      for (PetscInt b = c - 1; b >= 0 && !f->oblique[i]; b--) {
        if (f->shared[b][i] == b && FitIsShared(p, at, i, b, c, f->component[b].R[i], around))
          f->shared[c][i] = b;
      }
      todo[i] = !f->oblique[i] && f->shared[c][i] == c ? PETSC_TRUE : PETSC_FALSE;
    }
    PetscCall(FitComponent(flow, at, c, todo, around, &f->component[c]));
  }
  for (PetscInt i = 0; i < around->m; i++)
    if (f->oblique[i]) PetscCall(FitCoupled(flow, at, i, around, &f->all[i]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds a row of n weights to the rows of a component: w[k step] of particle j[k step]. */
static PetscErrorCode AddRow(const Particles *p, PetscInt n, PetscInt step, const PetscInt j[],
                             const PetscReal w[], SplineEntries *fluid, SplineEntries *walls)
{
  PetscFunctionBegin;
  PetscCall(SplineEntriesReserve(n, fluid));
  PetscCall(SplineEntriesReserve(n, walls));
  for (PetscInt k = 0; k < n; k++) {
    const PetscInt q = j[k * step];

    SplineEntriesAdd(p->row[q], w[k * step], ParticlesIsWall(p, q) ? walls : fluid);
  }
  SplineEntriesEnd(fluid);
  SplineEntriesEnd(walls);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the rows of the points of a cell. */
static PetscErrorCode AddRows(const Particles *p, const Around *around, const CellFits *f,
                              Splines *s)
{
  const PetscInt m = 1 << p->dim;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < around->m; i++) {
    for (PetscInt a = 0; a < f->sets; a++) {
      const Fits *fit = &f->component[f->shared[a][i]];

      for (PetscInt b = 0; b < p->dim; b++) {
        if (a != b && !f->coupled) continue;
        if (f->oblique[i]) {
          PetscCall(AddRow(p, f->all[i].n, 1, f->all[i].j, f->all[i].w[a * p->dim + b],
                           &s->from_fluid[a][b], &s->from_walls[a][b]));
        } else {
          PetscCall(AddRow(p, a == b ? fit->n[i] : 0, m, &fit->j[i], &fit->w[i],
                           &s->from_fluid[a][b], &s->from_walls[a][b]));
        }
      }
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the points of the cell that begins with point `first`: those within 3/4 of a cell of it. */
static void NextCell(const Splines *s, PetscInt first, Around *around)
{
  const SplinePoints *at = &s->inside;
  PetscInt            m  = 1;

  for (; m < 1 << s->lattice.dim && first + m < at->n; m++) {
    PetscBool near = PETSC_TRUE;

    for (PetscInt a = 0; a < s->lattice.dim; a++) {
      if (PetscAbsReal(at->x[a][first + m] - at->x[a][first]) > 0.75 * s->lattice.side[a])
        near = PETSC_FALSE;
    }
    if (!near) break;
  }
  around->first = first;
  around->m     = m;
}

/* SplineFitsAssemble - Assembles J and W; collective */
PetscErrorCode SplineFitsAssemble(Flow *flow, Splines *s)
{
  const Particles    *p      = flow->particles;
  const SplinePoints *at     = &s->inside;
  Around              around = {.capacity = flow->neighbors->cells.n + LANES};
  CellFits           *f;

  PetscFunctionBegin;
  PetscCall(PetscNew(&f));
  f->sets    = SceneHas(flow->scene, PHYSICS_WALLS) ? p->dim : 1;
  f->coupled = s->bodies ? PETSC_TRUE : PETSC_FALSE;
  PetscCall(PetscMalloc5(around.capacity, &around.j, around.capacity, &around.wall, around.capacity,
                         &around.r2, around.capacity, &around.part, around.capacity,
                         &around.found));
  for (PetscInt a = 0; a < p->dim; a++) PetscCall(PetscMalloc1(around.capacity, &around.x[a]));
  for (PetscInt a = 0; a < f->sets; a++) {
    for (PetscInt b = 0; b < p->dim; b++) {
      PetscCall(MatDestroy(&s->J[a][b]));
      PetscCall(MatDestroy(&s->W[a][b]));
      PetscCall(SplineEntriesBegin(at->n, &s->from_fluid[a][b]));
      PetscCall(SplineEntriesBegin(at->n, &s->from_walls[a][b]));
    }
  }
  for (PetscInt first = 0; first < at->n; first += around.m) {
    NextCell(s, first, &around);
    PetscCall(FitCell(flow, at, &around, f));
    PetscCall(AddRows(p, &around, f, s));
  }
  for (PetscInt a = 0; a < f->sets; a++) {
    for (PetscInt b = 0; b < p->dim; b++) {
      if (a != b && !f->coupled) continue;
      PetscCall(SplineEntriesMat(p->comm, &s->from_fluid[a][b], p->n_fluid, &s->J[a][b]));
      if (flow->ops->forms.wall)
        PetscCall(SplineEntriesMat(p->comm, &s->from_walls[a][b], p->n_wall, &s->W[a][b]));
    }
  }
  for (PetscInt a = 0; a < p->dim; a++) PetscCall(PetscFree(around.x[a]));
  PetscCall(PetscFree5(around.j, around.wall, around.r2, around.part, around.found));
  PetscCall(PetscFree(f));
  PetscFunctionReturn(PETSC_SUCCESS);
}
