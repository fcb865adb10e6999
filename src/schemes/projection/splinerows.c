/*
  Rows of the splines that depend on the positions of particles: the fit of the velocity at the
  points of quadrature, and values and gradients of the pressure at particles.
*/
#include "splines.h"

/* Particles in a fit, for 6 and 10 coefficients. */
#define FIT_NEAREST_2D  14
#define FIT_NEAREST_3D  28
#define FIT_MOST        3   /* times as many if their weights are large */
#define FIT_LARGEST_SUM 2.5 /* of absolute weights; 1.2 to 1.6 on a lattice */

/* SplineRowsFree - Frees the matrices of this file; collective */
PetscErrorCode SplineRowsFree(Splines *s)
{
  PetscFunctionBegin;
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) {
    PetscCall(MatDestroy(&s->J[a]));
    PetscCall(MatDestroy(&s->W[a]));
    PetscCall(MatDestroy(&s->G[a]));
    PetscCall(PetscFree(s->gradient[a]));
    PetscCall(PatternFree(&s->fluid_pattern[a]));
    PetscCall(PatternFree(&s->wall_pattern[a]));
    PetscCall(PetscFree(s->fluid_weight[a]));
    PetscCall(PetscFree(s->wall_weight[a]));
  }
  PetscCall(MatDestroy(&s->V));
  PetscCall(PetscFree(s->value));
  PetscCall(PatternFree(&s->at_particles));
  s->capacity = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Assembles G and V. */
static PetscErrorCode AssembleAtParticles(const Particles *p, Splines *s)
{
  const SplineLattice *l     = &s->lattice;
  const PetscInt       width = l->dim == 2 ? 9 : 27;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < l->dim; a++) PetscCall(MatDestroy(&s->G[a]));
  PetscCall(MatDestroy(&s->V));
  PetscCall(PatternBegin(&s->at_particles, p->n_fluid, p->n_fluid * width));
  if (s->at_particles.capacity > s->capacity) {
    s->capacity = s->at_particles.capacity;
    PetscCall(PetscFree(s->value));
    PetscCall(PetscMalloc1(s->capacity, &s->value));
    for (PetscInt a = 0; a < l->dim; a++) {
      PetscCall(PetscFree(s->gradient[a]));
      PetscCall(PetscMalloc1(s->capacity, &s->gradient[a]));
    }
  }
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscInt     number[SPLINES_AT], slot[SPLINES_AT];
    PetscReal    x[ISPH_MAX_DIM];
    SplineValues at;

    for (PetscInt a = 0; a < l->dim; a++) x[a] = p->x[a][i];
    SplinesAt(l, x, &at);
    for (PetscInt k = 0; k < at.n; k++) number[k] = SplinesGlobal(s, p, at.index[k]);
    PatternRow(&s->at_particles, i, number, at.n, slot);
    for (PetscInt q = s->at_particles.row[i]; q < s->at_particles.row[i + 1]; q++) {
      s->value[q] = 0.0;
      for (PetscInt a = 0; a < l->dim; a++) s->gradient[a][q] = 0.0;
    }
    for (PetscInt k = 0; k < at.n; k++) {
      s->value[slot[k]] += at.value[k];
      for (PetscInt a = 0; a < l->dim; a++) s->gradient[a][slot[k]] += at.gradient[a][k];
    }
  }
  PetscCall(PatternMat(p->comm, &s->at_particles, p->n_fluid, s->own.size, s->value, &s->V));
  for (PetscInt a = 0; a < l->dim; a++) {
    PetscCall(
        PatternMat(p->comm, &s->at_particles, p->n_fluid, s->own.size, s->gradient[a], &s->G[a]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Particles about a point of quadrature, and their weights in the fit of a component. */
typedef struct {
  PetscInt   n, walls; /* number, and number of wall particles among them */
  PetscInt   found, capacity, *j, *near;
  PetscReal *s[ISPH_MAX_DIM], *r, *W, *w;
} Around;

/*
  Returns true if particle j takes part in the fit of component c of the velocity: fluid, and wall
  particles whose normal is along c.

  Of a wall the divergence uses the normal velocity only. With the tangential velocity, the fits
  would follow the jump between a lid and a wall at rest, and the flow ends within a few steps.
  Dummies stand for the nearest point of the wall, and only their first layer counts.
*/
static PetscBool TakesPart(const Particles *p, PetscInt j, PetscInt c)
{
  if (!ParticlesIsWall(p, j)) return PETSC_TRUE;
  return p->depth[j] < p->dx[j] && PetscAbsReal(p->normal[c][j]) > 0.5 ? PETSC_TRUE : PETSC_FALSE;
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

/* Finds the particles for the fit of component c at x: the nearest of them, at most `most`. The
   radius R is the distance of the next. */
static PetscErrorCode FindNearest(const Flow *flow, const PetscReal x[], PetscReal reach,
                                  PetscInt c, PetscInt most, Around *around, PetscReal *R)
{
  const Particles *p = flow->particles;
  PetscInt         found, n = 0;

  PetscFunctionBegin;
  PetscCall(CellsFind(&flow->neighbors->cells, x, reach + 0.5 * flow->neighbors->margin + p->dx[0],
                      around->capacity, around->near, &found));
  around->walls = 0;
  for (PetscInt k = 0; k < found; k++) {
    const PetscInt j = around->near[k];
    PetscReal      X[ISPH_MAX_DIM], r;
    PetscInt       q;

    if (ParticlesIsWall(p, j)) around->walls++;
    if (!TakesPart(p, j, c)) continue;
    r = Offset(p, j, x, X);
    if (r >= reach || (n > most && r >= around->r[most])) continue;
    for (q = PetscMin(n, most); q > 0 && around->r[q - 1] > r; q--) {
      around->r[q] = around->r[q - 1];
      around->j[q] = around->j[q - 1];
    }
    around->r[q] = r;
    around->j[q] = j;
    n            = PetscMin(n + 1, most + 1);
  }
  around->n = PetscMin(n, most);
  *R        = n > most ? around->r[most] : reach;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes offsets and weights of the particles found, and solves the fit. Returns the sum of the
   absolute weights, or infinity if the particles do not determine the fit. */
static PetscReal TryFit(const Particles *p, const PetscReal x[], PetscReal R, Around *around)
{
  PetscReal sum = 0.0;

  for (PetscInt k = 0; k < around->n; k++) {
    const PetscReal r = around->r[k] / R;
    PetscReal       X[ISPH_MAX_DIM];

    (void)Offset(p, around->j[k], x, X);
    for (PetscInt a = 0; a < p->dim; a++) around->s[a][k] = X[a] / R;
    around->W[k] = PetscSqr(PetscSqr(1.0 - r)) * (1.0 + 4.0 * r);
  }
  if (!PointFit(p->dim, around->n, around->s, around->W, around->w)) return PETSC_INFINITY;
  for (PetscInt k = 0; k < around->n; k++) sum += PetscAbsReal(around->w[k]);
  return sum;
}

/*
  Computes the fit of component c at x

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
  PetscReal        reach = flow->ops->forms.radius, R = reach, size = PETSC_INFINITY, sum = 0.0;

  PetscFunctionBegin;
  while (PETSC_TRUE) {
    PetscCall(FindNearest(flow, x, reach, c, wanted, around, &R));
    if (around->n < wanted && reach < most) {
      reach = PetscMin(1.15 * reach, most);
      continue;
    }
    size = TryFit(p, x, R, around);
    if (size <= FIT_LARGEST_SUM || wanted >= FIT_MOST * least || around->n < wanted) break;
    wanted += least / 3;
  }
  if (size < PETSC_INFINITY) PetscFunctionReturn(PETSC_SUCCESS);
  flow->ops->regularised_rows++;
  for (PetscInt k = 0; k < around->n; k++) sum += around->W[k];
  for (PetscInt k = 0; k < around->n; k++) around->w[k] = around->W[k] / sum;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AroundReserve(const Flow *flow, Around *around)
{
  const PetscInt n = (FIT_MOST + 1) * FIT_NEAREST_3D + 1;

  PetscFunctionBegin;
  around->capacity = PetscMax(1, flow->neighbors->cells.n);
  PetscCall(PetscMalloc5(n, &around->j, around->capacity, &around->near, n, &around->r, n,
                         &around->W, n, &around->w));
  for (PetscInt a = 0; a < flow->scene->dim; a++) PetscCall(PetscMalloc1(n, &around->s[a]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AroundFree(Around *around)
{
  PetscFunctionBegin;
  PetscCall(PetscFree5(around->j, around->near, around->r, around->W, around->w));
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) PetscCall(PetscFree(around->s[a]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Growing list of the entries of a matrix, row by row. */
typedef struct {
  PetscInt   n, capacity, *col, rows, *row;
  PetscReal *value;
} Entries;

static PetscErrorCode EntriesAdd(PetscInt col, PetscReal value, Entries *e)
{
  PetscFunctionBegin;
  if (e->n == e->capacity) {
    e->capacity = 2 * e->capacity + 1024;
    PetscCall(PetscRealloc(sizeof(*e->col) * (size_t)e->capacity, &e->col));
    PetscCall(PetscRealloc(sizeof(*e->value) * (size_t)e->capacity, &e->value));
  }
  e->col[e->n]     = col;
  e->value[e->n++] = value;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes the matrix of a list of entries, whose pattern and values stay with the caller. */
static PetscErrorCode EntriesMat(MPI_Comm comm, const Entries *e, PetscInt cols, Pattern *pattern,
                                 PetscReal **values, Mat *A)
{
  const PetscInt rows = e->rows;
  PetscInt      *slot, longest = 1;

  PetscFunctionBegin;
  PetscCall(MatDestroy(A));
  PetscCall(PatternBegin(pattern, rows, e->n));
  PetscCall(PetscFree(*values));
  PetscCall(PetscCalloc1(e->n, values));
  for (PetscInt i = 0; i < rows; i++) longest = PetscMax(longest, e->row[i + 1] - e->row[i]);
  PetscCall(PetscMalloc1(longest, &slot));
  for (PetscInt i = 0; i < rows; i++) {
    const PetscInt n = e->row[i + 1] - e->row[i];

    PatternRow(pattern, i, &e->col[e->row[i]], n, slot);
    for (PetscInt k = 0; k < n; k++) (*values)[slot[k]] += e->value[e->row[i] + k];
  }
  PetscCall(PetscFree(slot));
  PetscCall(PatternMat(comm, pattern, rows, cols, *values, A));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode EntriesFree(Entries *e)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(e->col));
  PetscCall(PetscFree(e->value));
  PetscCall(PetscFree(e->row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the weights of a point to the rows of a component. */
static PetscErrorCode AddFit(const Particles *p, const Around *around, Entries *fluid,
                             Entries *walls)
{
  PetscFunctionBegin;
  for (PetscInt k = 0; k < around->n; k++) {
    const PetscInt j = around->j[k];

    PetscCall(EntriesAdd(p->row[j], around->w[k], ParticlesIsWall(p, j) ? walls : fluid));
  }
  fluid->row[fluid->rows + 1] = fluid->n;
  walls->row[walls->rows + 1] = walls->n;
  fluid->rows++;
  walls->rows++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Assembles J and W. Beside walls each component has a fit of its own; elsewhere they share it. */
static PetscErrorCode AssembleFits(Flow *flow, Splines *s)
{
  const Particles    *p                   = flow->particles;
  const SplinePoints *at                  = &s->inside;
  const PetscInt      sets                = SceneHas(flow->scene, PHYSICS_WALLS) ? p->dim : 1;
  Entries             fluid[ISPH_MAX_DIM] = {{0}}, walls[ISPH_MAX_DIM] = {{0}};
  Around              around = {0};

  PetscFunctionBegin;
  PetscCall(AroundReserve(flow, &around));
  for (PetscInt c = 0; c < sets; c++) {
    PetscCall(PetscCalloc1(at->n + 1, &fluid[c].row));
    PetscCall(PetscCalloc1(at->n + 1, &walls[c].row));
  }
  for (PetscInt g = 0; g < at->n; g++) {
    PetscReal x[ISPH_MAX_DIM];

    for (PetscInt a = 0; a < p->dim; a++) x[a] = at->x[a][g];
    for (PetscInt c = 0; c < sets; c++) {
      if (c == 0 || around.walls) PetscCall(FitAt(flow, x, c, &around));
      PetscCall(AddFit(p, &around, &fluid[c], &walls[c]));
    }
  }
  for (PetscInt c = 0; c < sets; c++) {
    PetscCall(EntriesMat(p->comm, &fluid[c], p->n_fluid, &s->fluid_pattern[c], &s->fluid_weight[c],
                         &s->J[c]));
    if (flow->ops->forms.wall) {
      PetscCall(EntriesMat(p->comm, &walls[c], p->n_wall, &s->wall_pattern[c], &s->wall_weight[c],
                           &s->W[c]));
    }
    PetscCall(EntriesFree(&fluid[c]));
    PetscCall(EntriesFree(&walls[c]));
  }
  PetscCall(AroundFree(&around));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  SplinesAssemble - Assembles the matrices that depend on positions, and numbers the splines anew if
  the box of a rank has changed

  Collective. Does nothing if positions and numbering have not changed since the last assembly.
*/
PetscErrorCode SplinesAssemble(Flow *flow, Splines *s)
{
  const Particles *p = flow->particles;
  PetscBool        changed;

  PetscFunctionBegin;
  if (s->epoch == p->epoch && s->moved == p->moved) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SplinesNumber(flow, s, &changed));
  PetscCall(AssembleAtParticles(p, s));
  PetscCall(AssembleFits(flow, s));
  s->epoch = p->epoch;
  s->moved = p->moved;
  s->assemblies++;
  PetscFunctionReturn(PETSC_SUCCESS);
}
