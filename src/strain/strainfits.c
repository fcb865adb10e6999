/*
  Rows of the velocity at points: sums over the particles' velocities by least squares. Inside, and
  beside walls whose velocity is given, a row is the fit of the nearest particles and points of
  walls. On a wall it interpolates the velocity of the wall.

  Beside an interface the stiffer fluid has fits of its own particles. The other fluid sees it as a
  wall: its fits have points of the interface, where the velocity is that of the stiffer fluid. So
  particles of a thin fluid have no part in strains of a stiff one, whose stresses would decide on
  their velocities.
*/
#include "isph/fits.h"
#include "strain.h"

#define FIT_ROOM        640  /* particles around a point, at most */
#define SEARCH          1.0  /* a search for a point serves others so near [dx] */
#define FOOT_DEPTH      1.0  /* particles so near to an interface mark a point on it [dx] */
#define WALL_REACH      2.5  /* particles of a wall about a point on it [dx] */
#define RIDGE_LINEAR    5e-8 /* of their normal equations, over the sum of weights */
#define RIDGE_QUADRATIC 5e-5
#define WALL_RIDGE      1e-13 /* of the normal equations, over their trace: points are in a plane */

/* StrainPointAdd - Adds a point; not collective */
PetscErrorCode StrainPointAdd(PetscInt dim, const PetscReal x[], PetscInt fluid, PetscInt side,
                              StrainPoints *points)
{
  PetscFunctionBegin;
  if (points->n == points->room) {
    points->room = 2 * points->room + 256;
    for (PetscInt a = 0; a < dim; a++)
      PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)points->room, &points->x[a]));
    PetscCall(PetscRealloc(sizeof(PetscInt) * (size_t)points->room, &points->fluid));
    PetscCall(PetscRealloc(sizeof(PetscInt) * (size_t)points->room, &points->side));
  }
  for (PetscInt a = 0; a < dim; a++) points->x[a][points->n] = x[a];
  points->fluid[points->n]  = fluid;
  points->side[points->n++] = side;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StrainPointsFree(StrainPoints *points)
{
  PetscFunctionBegin;
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) PetscCall(PetscFree(points->x[a]));
  PetscCall(FreeAll(&points->fluid, &points->side));
  points->n = points->room = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StrainRowsFree(StrainRows *rows)
{
  PetscFunctionBegin;
  PetscCall(FreeAll(&rows->start, &rows->j, &rows->w));
  rows->n = rows->rows = rows->capacity = rows->room = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds an entry to the last row. */
static PetscErrorCode AddEntry(PetscInt j, PetscReal w, StrainRows *rows)
{
  PetscFunctionBegin;
  if (rows->n == rows->capacity) {
    rows->capacity = 2 * rows->capacity + 1024;
    PetscCall(PetscRealloc(sizeof(PetscInt) * (size_t)rows->capacity, &rows->j));
    PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)rows->capacity, &rows->w));
  }
  rows->j[rows->n]   = j;
  rows->w[rows->n++] = w;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Ends a row. */
static PetscErrorCode EndRow(StrainRows *rows)
{
  PetscFunctionBegin;
  if (rows->rows + 2 > rows->room) {
    rows->room = 2 * rows->room + 256;
    PetscCall(PetscRealloc(sizeof(PetscInt) * (size_t)rows->room, &rows->start));
    rows->start[0] = 0;
  }
  rows->start[++rows->rows] = rows->n;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Particles and points of interfaces around points. */
typedef struct {
  PetscInt  n, j[FIT_ROOM];            /* -1 - row of StrainFits.feet for points of interfaces */
  PetscReal x[ISPH_MAX_DIM][FIT_ROOM]; /* [m] */
} Candidates;

/* Those around a point. */
typedef struct {
  PetscInt  dim, n, j[FIT_ROOM];
  PetscReal s[ISPH_MAX_DIM][FIT_ROOM], r2[FIT_ROOM]; /* offsets and their squares [m], [m^2] */
  PetscInt  at[FIT_ROOM];                            /* the nearest first */
} Around;

/* Adds a candidate at x. */
static void AddCandidate(PetscInt dim, PetscInt j, const PetscReal x[], Candidates *from)
{
  if (from->n == FIT_ROOM) return;
  for (PetscInt a = 0; a < dim; a++) from->x[a][from->n] = x[a];
  from->j[from->n++] = j;
}

/* Sorts by distance: the squares of distances are about even, so that each has a bin of its own. */
static void SortAround(Around *around)
{
  const PetscInt n = around->n;
  PetscInt       start[FIT_ROOM + 1], bin[FIT_ROOM];
  PetscReal      most = PETSC_MACHINE_EPSILON * PETSC_MACHINE_EPSILON;

  for (PetscInt k = 0; k < n; k++) most = PetscMax(most, around->r2[k]);
  for (PetscInt k = 0; k <= n; k++) start[k] = 0;
  for (PetscInt k = 0; k < n; k++) bin[k] = (PetscInt)(around->r2[k] * ((n - 1) / most));
  for (PetscInt k = 0; k < n; k++) start[bin[k] + 1]++;
  for (PetscInt k = 1; k < n; k++) start[k] += start[k - 1];
  for (PetscInt k = 0; k < n; k++) around->at[start[bin[k]]++] = k;
  for (PetscInt k = 1; k < n; k++) {
    const PetscInt at = around->at[k];
    PetscInt       q  = k;

    for (; q > 0 && around->r2[around->at[q - 1]] > around->r2[at]; q--)
      around->at[q] = around->at[q - 1];
    around->at[q] = at;
  }
}

/* Lists the candidates within a distance of x, the nearest first. */
static void FindAround(const Candidates *from, const PetscReal x[], PetscReal reach, Around *around)
{
  const PetscInt dim = around->dim;
  PetscReal      r2[FIT_ROOM];
  PetscInt       n = 0;

  for (PetscInt k = 0; k < from->n; k++) r2[k] = PetscSqr(from->x[0][k] - x[0]);
  for (PetscInt a = 1; a < dim; a++)
    for (PetscInt k = 0; k < from->n; k++) r2[k] += PetscSqr(from->x[a][k] - x[a]);
  for (PetscInt k = 0; k < from->n; k++) {
    around->r2[n] = r2[k];
    around->j[n]  = from->j[k];
    for (PetscInt a = 0; a < dim; a++) around->s[a][n] = from->x[a][k] - x[a];
    n += r2[k] <= reach * reach ? 1 : 0;
  }
  around->n = n;
  SortAround(around);
}

/* Returns true if a wall particle gives component c of the velocity. */
static PetscBool GivesComponent(const StrainFits *f, PetscInt j, PetscInt c)
{
  const PetscBool along = f->sets > 1 && PetscAbsReal(f->p->normal[c][j]) < 0.5;

  if (f->gives) return f->gives[(PetscInt)f->p->side[j]];
  if (f->normal && PetscAbsReal(f->p->normal[c][j]) < 1e-6) return PETSC_FALSE;
  return BoundaryEquation(f->scene, (PetscInt)f->p->side[j],
                          along ? FIT_VELOCITY_TANGENTIAL : FIT_VELOCITY_NORMAL) == EQUATION_VALUE;
}

/* Computes the point of the interface nearest to a particle [m]. */
static void FootOf(const Particles *p, PetscInt j, PetscReal x[])
{
  for (PetscInt a = 0; a < p->dim; a++)
    x[a] = p->x[a][j] - p->interface[j] * p->interface_normal[a][j];
}

/* Lists the candidates for fits of component c in a fluid. Input: list - the particles around. */
static void Gather(const StrainFits *f, PetscInt fluid, PetscInt c, PetscInt n,
                   const PetscInt list[], Candidates *to)
{
  const Particles *p = f->p;

  to->n = 0;

  for (PetscInt k = 0; k < n; k++) {
    const PetscInt j = list[k];
    PetscReal      y[ISPH_MAX_DIM];
    PetscInt       code = j;

    if (ParticlesIsWall(p, j)) {
      if (p->depth[j] >= p->dx[j] || (f->dry && f->dry[j]) || !GivesComponent(f, j, c)) continue;
      ParticlesWallPoint(p, j, y);
    } else if (p->fluid && (PetscInt)p->fluid[j] != fluid) {
      if (!f->foot || f->foot[j] < 0) continue;
      if (!StrainIsStiffer(f->scene, (PetscInt)p->fluid[j], fluid)) continue;
      FootOf(p, j, y);
      code = -1 - (f->foot[j] * f->sets + (f->sets > 1 ? c : 0));
    } else {
      for (PetscInt a = 0; a < p->dim; a++) y[a] = p->x[a][j];
    }
    AddCandidate(p->dim, code, y, to);
  }
}

/* Sets the fit of the `wanted` nearest at point i. Their radius is the distance of the next, or a
   little more than that of the last. Input: ctx - particles around the points. */
static PetscErrorCode Fill(void *ctx, PetscInt i, PetscInt wanted, NearestFits *f, PetscBool *more)
{
  const Around   *around = &((const Around *)ctx)[i];
  const PetscInt  d = around->dim, m = 1 << d, n = PetscMin(around->n, wanted);
  const PetscInt *at = around->at;
  const PetscReal R  = wanted < around->n ? PetscSqrtReal(around->r2[at[wanted]])
                                          : 1.05 * PetscSqrtReal(around->r2[at[n - 1]]);

  f->n[i] = n;
  *more   = wanted < around->n;
  for (PetscInt k = 0; k < n; k++) {
    f->W[k * m + i] = NearestWeight(PetscSqrtReal(around->r2[at[k]]) / R);
    for (PetscInt a = 0; a < d; a++) f->s[a][k * m + i] = around->s[a][at[k]] / R;
  }
  return PETSC_SUCCESS;
}

/* Computes the fits at the points of a group: where the particles do not determine them, linear
   ones, at last the value of the nearest particle. Input: spare - work. */
static PetscErrorCode FitGroup(PetscInt dim, PetscInt degree, Around around[], NearestFits *g,
                               NearestFits *spare)
{
  static const PetscInt least[2][3] = {{7, 14, 21}, {11, 28, 42}};
  const PetscInt        m           = 1 << dim;
  PetscBool             todo[POINT_FITS], linear[POINT_FITS];

  PetscFunctionBegin;
  for (PetscInt i = 0; i < m; i++) todo[i] = around[i].n ? PETSC_TRUE : PETSC_FALSE;
  PetscCall(NearestFitsCompute(dim, degree, least[dim - 2][degree - 1], todo, Fill, around, g));
  for (PetscInt i = 0; i < m; i++) linear[i] = todo[i] && !g->fits[i];
  PetscCall(NearestFitsCompute(dim, 1, least[dim - 2][0], linear, Fill, around, spare));
  for (PetscInt i = 0; i < m; i++) {
    if (!linear[i]) continue;
    g->n[i] = spare->fits[i] ? spare->n[i] : 1;
    for (PetscInt k = 0; k < g->n[i]; k++)
      g->w[k * m + i] = spare->fits[i] ? spare->w[k * m + i] : 1.0;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the weight of a candidate of a fit; a point of an interface stands for its own row. */
static PetscErrorCode AddWeight(const StrainFits *f, PetscInt j, PetscReal w, StrainRows *rows)
{
  PetscFunctionBegin;
  if (j >= 0) PetscCall(AddEntry(j, w, rows));
  for (PetscInt e = j < 0 ? f->feet.start[-1 - j] : 0; j < 0 && e < f->feet.start[-j]; e++)
    PetscCall(AddEntry(f->feet.j[e], w * f->feet.w[e], rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the fit at point i of a group as a row. */
static PetscErrorCode AddFit(const StrainFits *f, PetscInt i, const Around *around,
                             const NearestFits *g, StrainRows *rows)
{
  const PetscInt m = 1 << f->p->dim;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < g->n[i]; k++)
    PetscCall(AddWeight(f, around->j[around->at[k]], g->w[k * m + i], rows));
  PetscCall(EndRow(rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the fit at a point of a fluid with a free surface: of all its particles within
   their radius, with a ridge that lowers its degree where they are few or in a row. */
static PetscErrorCode AddSurfaceFit(const StrainFits *f, const Around *around, StrainRows *rows)
{
  const PetscInt  d = f->p->dim, terms = 1 + d + d * (d + 1) / 2;
  const PetscReal R = f->radius * f->p->dx[0];
  PetscReal M[100] = {0.0}, factor[100], c[10] = {1.0}, B[FIT_ROOM][10], W[FIT_ROOM], sum = 0.0;
  PetscInt  n = 0;

  PetscFunctionBegin;
  while (n < around->n && around->r2[around->at[n]] < R * R) n++;
  if (!n) {
    if (around->n) PetscCall(AddWeight(f, around->j[around->at[0]], 1.0, rows));
    PetscCall(EndRow(rows));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (PetscInt k = 0; k < n; k++) {
    const PetscInt at = around->at[k];
    PetscInt       t  = 1 + d;

    W[k] = NearestWeight(PetscSqrtReal(around->r2[at]) / R);
    sum += W[k];
    B[k][0] = 1.0;
    for (PetscInt a = 0; a < d; a++) B[k][1 + a] = around->s[a][at] / R;
    for (PetscInt a = 0; a < d; a++)
      for (PetscInt b = a; b < d; b++) B[k][t++] = B[k][1 + a] * B[k][1 + b];
    for (PetscInt e = 0; e < terms; e++)
      for (PetscInt q = 0; q < terms; q++) M[e * terms + q] += W[k] * B[k][e] * B[k][q];
  }
  for (PetscInt e = 1; e < terms; e++)
    M[e * terms + e] += sum * (e > d ? RIDGE_QUADRATIC : RIDGE_LINEAR);
  DenseCholeskyRidge(terms, M, 0.0, factor);
  DenseCholeskySolve(terms, factor, c);
  for (PetscInt k = 0; k < n; k++) {
    PetscReal w = 0.0;

    for (PetscInt e = 0; e < terms; e++) w += c[e] * B[k][e];
    PetscCall(AddWeight(f, around->j[around->at[k]], w * W[k], rows));
  }
  PetscCall(EndRow(rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the row of the velocity on a wall at x: the linear fit of the particles of the same wall
   around x, whose weights vanish a tenth beyond the last of 2 dim: on a lattice several are as far
   as that. Input: list - the particles around x. */
static PetscErrorCode AddWallRow(const StrainFits *f, const PetscReal x[], PetscInt side,
                                 PetscInt n, const PetscInt list[], StrainRows *rows)
{
  const Particles *p = f->p;
  const PetscInt   d = p->dim, terms = d + 1;
  Around           around = {.dim = p->dim};
  Candidates       from   = {.n = 0};
  PetscReal        M[16] = {0.0}, factor[16], c[4] = {1.0}, w[FIT_ROOM], sum = 0.0, R2;
  PetscInt         near = 0;

  PetscFunctionBegin;
  for (PetscInt pass = 0; pass < 2 && !from.n; pass++) { /* dry walls if there are no others */
    for (PetscInt k = 0; k < n; k++) {
      PetscReal y[ISPH_MAX_DIM];

      if (!ParticlesIsWall(p, list[k]) || (PetscInt)p->side[list[k]] != side) continue;
      if (!pass && f->dry && f->dry[list[k]]) continue;
      ParticlesWallPoint(p, list[k], y);
      AddCandidate(d, list[k], y, &from);
    }
  }
  FindAround(&from, x, PETSC_INFINITY, &around);
  R2 = around.n ? 1.2 * around.r2[around.at[PetscMin(around.n, 2 * d) - 1]] : 0.0;
  R2 = PetscMax(R2, PETSC_SMALL * PetscSqr(p->dx[0])); /* a single wall may be at the place */
  while (near < around.n && around.r2[around.at[near]] < R2) near++;
  for (PetscInt i = 0; i < near; i++) {
    const PetscInt  k = around.at[i];
    const PetscReal W = 1.0 - around.r2[k] / R2;

    for (PetscInt e = 0; e < terms; e++)
      for (PetscInt q = 0; q < terms; q++)
        M[e * terms + q] += W * (e ? around.s[e - 1][k] / PetscSqrtReal(R2) : 1.0) *
                            (q ? around.s[q - 1][k] / PetscSqrtReal(R2) : 1.0);
  }
  DenseCholeskyRidge(terms, M, WALL_RIDGE, factor);
  DenseCholeskySolve(terms, factor, c);
  for (PetscInt i = 0; i < near; i++) {
    const PetscInt k = around.at[i];

    w[i] = c[0];
    for (PetscInt a = 0; a < d; a++) w[i] += c[1 + a] * around.s[a][k] / PetscSqrtReal(R2);
    w[i] *= 1.0 - around.r2[k] / R2;
    sum += w[i];
  }
  for (PetscInt i = 0; i < near; i++) /* a single wall has a slope by the ridge: sums are 1 */
    PetscCall(AddEntry(around.j[around.at[i]], w[i] / sum, rows));
  PetscCall(EndRow(rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns true if a boundary gives component c of the velocity at a point on it; only boundaries
   along the axes give some of them. */
static PetscBool SideGives(const StrainFits *f, PetscInt side, PetscInt c)
{
  const PetscBool along = f->sets > 1 && side < 2 * f->p->dim && side / 2 != c;

  if (f->gives) return f->gives[side];
  if (f->normal && along) return PETSC_FALSE;
  return BoundaryEquation(f->scene, side, along ? FIT_VELOCITY_TANGENTIAL : FIT_VELOCITY_NORMAL) ==
         EQUATION_VALUE;
}

/* StrainRowsOf - Computes the rows of the velocity at points: `sets` of each, one after the other;
   not collective. Input: points - at which; f - its feet if there are interfaces. */
PetscErrorCode StrainRowsOf(StrainFits *f, const StrainPoints *points, StrainRows *rows)
{
  const Particles *p   = f->p;
  const PetscInt   dim = p->dim, m = 1 << dim, most = f->nb->cells.n + 1, all = points->n * f->sets;
  const PetscReal  reach  = FIT_REACH * p->dx[0] + 0.5 * f->nb->margin;
  const PetscReal  search = p->fluid ? 0.0 : SEARCH * p->dx[0]; /* feet are not at particles */
  NearestFits     *g, *spare;
  Around           around[POINT_FITS];
  PetscReal        centre[ISPH_MAX_DIM] = {NAN}; /* of the last search */
  PetscInt        *list, *beside, found = 0, fluid = -1, component = 0;
  Candidates       from;

  PetscFunctionBegin;
  rows->n = rows->rows = 0;
  PetscCall(PetscMalloc2(most, &list, most, &beside));
  PetscCall(PetscNew(&g));
  PetscCall(PetscNew(&spare));
  for (PetscInt first = 0; first < all; first += m) {
    PetscBool on_wall[POINT_FITS];

    for (PetscInt i = 0; i < m; i++) {
      const PetscInt k = (first + i) / f->sets, c = (first + i) % f->sets;
      PetscReal      x[ISPH_MAX_DIM], apart       = 0.0;

      around[i].dim = dim;
      around[i].n   = 0;
      on_wall[i]    = PETSC_FALSE;
      if (first + i >= all) continue;
      on_wall[i] = points->side[k] >= 0 && SideGives(f, points->side[k], c);
      for (PetscInt a = 0; a < dim; a++) x[a] = points->x[a][k];
      if (on_wall[i]) continue;
      for (PetscInt a = 0; a < dim; a++) apart += PetscSqr(x[a] - centre[a]);
      if (!(apart < PetscSqr(search))) {
        PetscCall(CellsFind(&f->nb->cells, x, reach + search, most, list, &found));
        for (PetscInt a = 0; a < dim; a++) centre[a] = x[a];
        fluid = -1;
      }
      if (points->fluid[k] != fluid || c != component)
        Gather(f, points->fluid[k], c, found, list, &from);
      fluid     = points->fluid[k];
      component = c;
      FindAround(&from, x, p->fluid ? PETSC_INFINITY : reach, &around[i]);
    }
    if (!f->free) PetscCall(FitGroup(dim, f->degree, around, g, spare));
    for (PetscInt i = 0; i < m && first + i < all; i++) {
      const PetscInt k = (first + i) / f->sets;
      PetscReal      x[ISPH_MAX_DIM];
      PetscInt       n;

      if (!on_wall[i]) {
        if (f->free) PetscCall(AddSurfaceFit(f, &around[i], rows));
        else PetscCall(AddFit(f, i, &around[i], g, rows));
        continue;
      }
      for (PetscInt a = 0; a < dim; a++) x[a] = points->x[a][k];
      PetscCall(CellsFind(&f->nb->cells, x, WALL_REACH * p->dx[0], most, beside, &n));
      PetscCall(AddWallRow(f, x, points->side[k], n, beside, rows));
    }
  }
  PetscCall(PetscFree2(list, beside));
  PetscCall(FreeAll(&g, &spare));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* StrainFeet - Computes the rows of the velocity at the points of interfaces that particles of
   stiffer fluids beside them mark; not collective */
PetscErrorCode StrainFeet(StrainFits *f)
{
  const Particles *p      = f->p;
  StrainPoints     points = {0};

  PetscFunctionBegin;
  if (!p->fluid) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(ParticlesAll(p), &f->foot));
  for (PetscInt j = 0; j < ParticlesAll(p); j++) {
    PetscReal x[ISPH_MAX_DIM], length = 0.0;

    f->foot[j] = -1;
    if (ParticlesIsWall(p, j) || p->interface[j] > FOOT_DEPTH * p->dx[j]) continue;
    for (PetscInt a = 0; a < p->dim; a++) length += PetscSqr(p->interface_normal[a][j]);
    if (length < 0.5) continue;
    FootOf(p, j, x);
    f->foot[j] = points.n;
    PetscCall(StrainPointAdd(p->dim, x, (PetscInt)p->fluid[j], -1, &points));
  }
  { /* fits of a fluid beside a stiffer third one have no feet yet */
    PetscInt *foot = f->foot;

    f->foot = NULL;
    PetscCall(StrainRowsOf(f, &points, &f->feet));
    f->foot = foot;
  }
  PetscCall(StrainPointsFree(&points));
  PetscFunctionReturn(PETSC_SUCCESS);
}
