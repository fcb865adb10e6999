/*
  Fits of the velocity of particles at the points of quadrature of the splines. Walls take part with
  their normal velocity: beside walls along the axes in the fit of one component, beside oblique
  walls in a fit of all components together.
*/
#include "splines.h"

/* Particles in a fit, for 6 and 10 coefficients. */
#define FIT_NEAREST_2D  14
#define FIT_NEAREST_3D  28
#define FIT_MOST        3   /* times as many if their weights are large */
#define FIT_LARGEST_SUM 2.5 /* of absolute weights; 1.2 to 1.6 on a lattice */

#define ALL (-1) /* components of the velocity */

/* Particles about a point of quadrature, and their weights in the fits. */
typedef struct {
  PetscInt   n, walls; /* number, and wall particles found */
  PetscBool  oblique;  /* a wall within reach is oblique to the axes */
  PetscInt   capacity, *j, *near;
  PetscReal *s[ISPH_MAX_DIM], *r, *W;
  PetscReal *w[ISPH_MAX_DIM * ISPH_MAX_DIM]; /* of component b in the fit of a: a dim + b */
  PetscBool *wall;
  PetscReal *normal[ISPH_MAX_DIM]; /* of wall particles, into the fluid */
} Around;

/*
  Returns true if particle j takes part in the fit of component c of the velocity: fluid, and wall
  particles whose normal is along c; for all components, c = ALL, all wall particles.

  Of a wall the divergence uses the normal velocity only. With the tangential velocity, the fits
  would follow the jump between a lid and a wall at rest, and the flow ends within a few steps.
  Dummies stand for the nearest point of the wall, and only their first layer counts.
*/
static PetscBool TakesPart(const Particles *p, PetscInt j, PetscInt c)
{
  if (!ParticlesIsWall(p, j)) return PETSC_TRUE;
  if (p->depth[j] >= p->dx[j]) return PETSC_FALSE;
  return c == ALL || PetscAbsReal(p->normal[c][j]) > 0.5 ? PETSC_TRUE : PETSC_FALSE;
}

/* Returns true if the normal of a wall particle is along no axis. */
static PetscBool IsOblique(const Particles *p, PetscInt j)
{
  PetscReal most = 0.0;

  for (PetscInt a = 0; a < p->dim; a++) most = PetscMax(most, PetscAbsReal(p->normal[a][j]));
  return most < 1.0 - 1e-12 ? PETSC_TRUE : PETSC_FALSE;
}

/* Position of particle j relative to x; that of a wall particle is its point on the wall. */
static PetscReal Offset(const Particles *p, PetscInt j, const PetscReal x[], PetscReal X[])
{
  PetscReal r2 = 0.0;

  if (ParticlesIsWall(p, j)) ParticlesWallPoint(p, j, X);
  for (PetscInt a = 0; a < p->dim; a++) {
    X[a] = (ParticlesIsWall(p, j) ? X[a] : p->x[a][j]) - x[a];
    r2 += PetscSqr(X[a]);
  }
  return PetscSqrtReal(r2);
}

/* Inserts particle j at the distance r into the list of the nearest, at most `most` + 1. */
static void Insert(PetscInt j, PetscReal r, PetscInt most, Around *around)
{
  PetscInt q;

  if (around->n > most && r >= around->r[most]) return;
  for (q = PetscMin(around->n, most); q > 0 && around->r[q - 1] > r; q--) {
    around->r[q] = around->r[q - 1];
    around->j[q] = around->j[q - 1];
  }
  around->r[q] = r;
  around->j[q] = j;
  around->n    = PetscMin(around->n + 1, most + 1);
}

/*
  Finds the particles for the fit of component c at x: the nearest of them, at most `most`. The
  radius R is the distance of the next. In a fit of all components a wall particle has one equation
  of dim and counts as such a part of a particle.

  Output: R [m]; found - PETSC_FALSE if there are fewer within reach.
*/
static PetscErrorCode FindNearest(const Flow *flow, const PetscReal x[], PetscReal reach,
                                  PetscInt c, PetscInt most, Around *around, PetscReal *R,
                                  PetscBool *found)
{
  const Particles *p    = flow->particles;
  const PetscReal  part = c == ALL ? 1.0 / p->dim : 1.0;
  PetscReal        sum  = 0.0;
  PetscInt         near, n = 0;

  PetscFunctionBegin;
  PetscCall(CellsFind(&flow->neighbors->cells, x, reach + 0.5 * flow->neighbors->margin + p->dx[0],
                      around->capacity, around->near, &near));
  around->walls = around->n = 0;
  around->oblique           = PETSC_FALSE;
  for (PetscInt k = 0; k < near; k++) {
    const PetscInt j = around->near[k];
    PetscReal      X[ISPH_MAX_DIM], r;

    if (ParticlesIsWall(p, j)) around->walls++;
    if (!TakesPart(p, j, ALL)) continue;
    r = Offset(p, j, x, X);
    if (r >= reach) continue;
    if (r < flow->ops->forms.radius && ParticlesIsWall(p, j) && IsOblique(p, j))
      around->oblique = PETSC_TRUE;
    if (TakesPart(p, j, c)) Insert(j, r, c == ALL ? p->dim * most : most, around);
  }
  while (n < around->n && sum + 1e-9 < most) sum += ParticlesIsWall(p, around->j[n++]) ? part : 1.0;
  *found    = sum + 1e-9 < most ? PETSC_FALSE : PETSC_TRUE;
  *R        = n < around->n ? around->r[n] : reach;
  around->n = n;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the largest sum of the absolute weights of a component. */
static PetscReal LargestSum(const Particles *p, PetscInt c, const Around *around)
{
  const PetscInt components = c == ALL ? p->dim : 1;
  PetscReal      largest    = 0.0;

  for (PetscInt a = 0; a < components; a++) {
    PetscReal sum = 0.0;

    for (PetscInt b = 0; b < components; b++) {
      for (PetscInt k = 0; k < around->n; k++)
        sum += PetscAbsReal(around->w[a * components + b][k]);
    }
    largest = PetscMax(largest, sum);
  }
  return largest;
}

/* Computes offsets and weights of the particles found, and solves the fit. Returns the sum of the
   absolute weights, or infinity if the particles do not determine the fit. */
static PetscReal TryFit(const Particles *p, const PetscReal x[], PetscReal R, PetscInt c,
                        Around *around)
{
  PetscBool fits;

  for (PetscInt k = 0; k < around->n; k++) {
    const PetscInt  j = around->j[k];
    const PetscReal r = around->r[k] / R;
    PetscReal       X[ISPH_MAX_DIM];

    (void)Offset(p, j, x, X);
    around->wall[k] = ParticlesIsWall(p, j);
    for (PetscInt a = 0; a < p->dim; a++) {
      around->s[a][k]      = X[a] / R;
      around->normal[a][k] = around->wall[k] ? p->normal[a][j] : 0.0;
    }
    around->W[k] = PetscSqr(PetscSqr(1.0 - r)) * (1.0 + 4.0 * r);
  }
  if (c == ALL) {
    fits =
        VectorFit(p->dim, around->n, around->s, around->W, around->wall, around->normal, around->w);
  } else {
    fits = PointFit(p->dim, around->n, around->s, around->W, around->w[0]);
  }
  return fits ? LargestSum(p, c, around) : PETSC_INFINITY;
}

/* Sets the weights of a mean over the particles of a fit. */
static void SetMean(const Particles *p, PetscInt c, Around *around)
{
  PetscReal sum = 0.0;

  for (PetscInt k = 0; k < around->n; k++) sum += around->W[k];
  for (PetscInt k = 0; k < around->n; k++) {
    for (PetscInt e = 0; e < (c == ALL ? p->dim * p->dim : 1); e++)
      around->w[e][k] = e % (p->dim + 1) ? 0.0 : around->W[k] / sum;
  }
}

/*
  Computes the fit of component c at x; leaves out that of a single component beside oblique walls

  The nearest particles may lie near a conic section, on which a quadratic function vanishes. Then
  the weights are large and amplify the velocities: a fit of 14 with a sum of 22 spoilt the flow of
  64 x 64 particles within a step. Such a fit takes more particles. The search reaches further, up
  to the reach of the halo, while it finds too few.
*/
static PetscErrorCode FitAt(Flow *flow, const PetscReal x[], PetscInt c, Around *around)
{
  const Particles *p      = flow->particles;
  const PetscInt   least  = p->dim == 2 ? FIT_NEAREST_2D : FIT_NEAREST_3D;
  const PetscReal  most   = PetscMax(flow->ops->forms.radius, p->halo_width + 0.5 * p->skin);
  PetscInt         wanted = least;
  PetscReal        reach = flow->ops->forms.radius, R = reach, size = PETSC_INFINITY;
  PetscBool        found = PETSC_FALSE;

  PetscFunctionBegin;
  while (PETSC_TRUE) {
    PetscCall(FindNearest(flow, x, reach, c, wanted, around, &R, &found));
    if (around->oblique && c != ALL) PetscFunctionReturn(PETSC_SUCCESS);
    if (!found && reach < most) {
      reach = PetscMin(1.15 * reach, most);
      continue;
    }
    size = TryFit(p, x, R, c, around);
    if (size <= FIT_LARGEST_SUM || wanted >= FIT_MOST * least || !found) break;
    wanted += least / 3;
  }
  if (size < PETSC_INFINITY) PetscFunctionReturn(PETSC_SUCCESS);
  flow->ops->regularised_rows++;
  SetMean(p, c, around);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AroundReserve(const Flow *flow, Around *around)
{
  const PetscInt dim = flow->scene->dim, n = dim * (FIT_MOST + 1) * FIT_NEAREST_3D + 1;

  PetscFunctionBegin;
  around->capacity = PetscMax(1, flow->neighbors->cells.n);
  PetscCall(PetscMalloc5(n, &around->j, around->capacity, &around->near, n, &around->r, n,
                         &around->W, n, &around->wall));
  for (PetscInt a = 0; a < dim; a++)
    PetscCall(PetscMalloc2(n, &around->s[a], n, &around->normal[a]));
  for (PetscInt e = 0; e < dim * dim; e++) PetscCall(PetscMalloc1(n, &around->w[e]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AroundFree(Around *around)
{
  PetscFunctionBegin;
  PetscCall(PetscFree5(around->j, around->near, around->r, around->W, around->wall));
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++)
    PetscCall(PetscFree2(around->s[a], around->normal[a]));
  for (PetscInt e = 0; e < ISPH_MAX_DIM * ISPH_MAX_DIM; e++) PetscCall(PetscFree(around->w[e]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Entries of all fits: from fluid and from walls, of component [a] from component [b]. */
typedef struct {
  PetscInt      sets;    /* components with fits of their own: 1 if boundaries make no difference */
  PetscBool     coupled; /* fits of a component have entries of the others */
  SplineEntries fluid[ISPH_MAX_DIM][ISPH_MAX_DIM], walls[ISPH_MAX_DIM][ISPH_MAX_DIM];
} FitEntries;

/* Adds the weights w of a fit to the rows of component a from component b; NULL: an empty row. */
static PetscErrorCode AddFit(const Particles *p, const Around *around, const PetscReal w[],
                             SplineEntries *fluid, SplineEntries *walls)
{
  PetscFunctionBegin;
  for (PetscInt k = 0; w && k < around->n; k++) {
    const PetscInt j = around->j[k];

    PetscCall(SplineEntriesAdd(p->row[j], w[k], ParticlesIsWall(p, j) ? walls : fluid));
  }
  fluid->row[++fluid->rows] = fluid->n;
  walls->row[++walls->rows] = walls->n;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the rows of a point. Beside walls each component has a fit of its own; elsewhere they share
   it. Beside walls oblique to the axes there is a fit of all components together. */
static PetscErrorCode AddPoint(Flow *flow, const PetscReal x[], Around *around, FitEntries *e)
{
  const Particles *p = flow->particles;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < e->sets; a++) {
    if (a == 0 || (around->walls && !around->oblique)) PetscCall(FitAt(flow, x, a, around));
    if (a == 0 && around->oblique) PetscCall(FitAt(flow, x, ALL, around));
    for (PetscInt b = 0; b < p->dim; b++) {
      const PetscReal *w = around->oblique ? around->w[a * p->dim + b] : around->w[0];

      if (a != b && !e->coupled) continue;
      PetscCall(AddFit(p, around, b != a && !around->oblique ? NULL : w, &e->fluid[a][b],
                       &e->walls[a][b]));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes the matrices of component a from component b. */
static PetscErrorCode MakeFit(const Flow *flow, PetscInt a, PetscInt b, FitEntries *e, Splines *s)
{
  const Particles *p = flow->particles;

  PetscFunctionBegin;
  PetscCall(SplineEntriesMat(p->comm, &e->fluid[a][b], p->n_fluid, &s->fluid_pattern[a][b],
                             &s->fluid_weight[a][b], &s->J[a][b]));
  if (flow->ops->forms.wall) {
    PetscCall(SplineEntriesMat(p->comm, &e->walls[a][b], p->n_wall, &s->wall_pattern[a][b],
                               &s->wall_weight[a][b], &s->W[a][b]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineFitsAssemble - Assembles J and W; collective */
PetscErrorCode SplineFitsAssemble(Flow *flow, Splines *s)
{
  const Particles    *p      = flow->particles;
  const SplinePoints *at     = &s->inside;
  FitEntries          e      = {.sets    = SceneHas(flow->scene, PHYSICS_WALLS) ? p->dim : 1,
                                .coupled = s->bodies ? PETSC_TRUE : PETSC_FALSE};
  Around              around = {0};

  PetscFunctionBegin;
  PetscCall(AroundReserve(flow, &around));
  for (PetscInt a = 0; a < e.sets; a++) {
    for (PetscInt b = 0; b < p->dim; b++) {
      if (a != b && !e.coupled) continue;
      PetscCall(PetscCalloc1(at->n + 1, &e.fluid[a][b].row));
      PetscCall(PetscCalloc1(at->n + 1, &e.walls[a][b].row));
    }
  }
  for (PetscInt g = 0; g < at->n; g++) {
    PetscReal x[ISPH_MAX_DIM];

    for (PetscInt a = 0; a < p->dim; a++) x[a] = at->x[a][g];
    PetscCall(AddPoint(flow, x, &around, &e));
  }
  for (PetscInt a = 0; a < e.sets; a++) {
    for (PetscInt b = 0; b < p->dim; b++) {
      if (a != b && !e.coupled) continue;
      PetscCall(MakeFit(flow, a, b, &e, s));
      PetscCall(SplineEntriesFree(&e.fluid[a][b]));
      PetscCall(SplineEntriesFree(&e.walls[a][b]));
    }
  }
  PetscCall(AroundFree(&around));
  PetscFunctionReturn(PETSC_SUCCESS);
}
