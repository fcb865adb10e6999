/*
  The free surface of the fluid in the strain cells: facets with the corners y_v on the level of the
  concentration. The tension is the derivative of the area A by the velocities of its corners. It
  sums to zero over each body of fluid, with its torque:

    F_i = -sigma sum_v Y_vi^T dA/dy_v,   u(y_v) = sum_i Y_vi u_i

  with the matrices of strainmotion.c. A step dt changes it by the part of the second derivative
  that has no negative eigenvalue,

    dF_i = -dt sigma sum_j K_ij u_j,   K_ij = sum of int (grad_s Y_i^T n).(grad_s Y_j^T n)

  Source: docs/developers/theory.md, (strain:tension). Derivatives of the area are those of K. A.
  Brakke, Exp. Math. 1 (1992) 141-165, the change in a step that of S. Hysing, Int. J. Numer. Meth.
  Fluids 51 (2006) 659-672.
*/
#include "strain.h"

#define SAME_PLACE 1e-6 /* corners so near are the same, over the edge of a cell */

/* StrainFacetAdd - Adds a facet; not collective. Input: x - its dim corners, in the order that
   turns its normal out of the fluid; fluid - whose fits have its velocity; between - it is of an
   interface of fluids. */
PetscErrorCode StrainFacetAdd(PetscInt dim, const PetscReal x[][ISPH_MAX_DIM], PetscInt fluid,
                              PetscBool between, PetscReal tension, StrainSurface *s)
{
  PetscFunctionBegin;
  if (s->n == s->room) {
    s->room = 2 * s->room + 256;
    PetscCall(PetscRealloc(sizeof(PetscInt) * (size_t)(s->room * dim), &s->corner));
    PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)(s->room * dim * dim), &s->x));
    PetscCall(PetscRealloc(sizeof(PetscInt) * (size_t)s->room, &s->fluid));
    PetscCall(PetscRealloc(sizeof(PetscBool) * (size_t)s->room, &s->between));
    PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)s->room, &s->tension));
  }
  for (PetscInt e = 0; e < dim * dim; e++) s->x[s->n * dim * dim + e] = x[e / dim][e % dim];
  s->fluid[s->n]     = fluid;
  s->between[s->n]   = between;
  s->tension[s->n++] = tension;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* StrainWetAdd - Adds the dim corners x of a part of a body that fluid wets; not collective */
PetscErrorCode StrainWetAdd(PetscInt dim, const PetscReal x[][ISPH_MAX_DIM], PetscInt body,
                            StrainSurface *s)
{
  PetscFunctionBegin;
  if (s->n_wet + dim > s->room_wet) {
    s->room_wet = 2 * s->room_wet + 256;
    PetscCall(PetscRealloc(sizeof(PetscInt) * (size_t)s->room_wet, &s->wet_body));
    PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)(s->room_wet * dim), &s->wet_x));
  }
  for (PetscInt v = 0; v < dim; v++) {
    for (PetscInt a = 0; a < dim; a++) s->wet_x[s->n_wet * dim + a] = x[v][a];
    s->wet_body[s->n_wet++] = body;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A corner of a facet: its place in units that are small against a cell. */
typedef struct {
  PetscInt64 x[ISPH_MAX_DIM];
  PetscInt   at; /* facet times dim plus the number of the corner; -1 - number of a wet one */
} Corner;

static int ComparePlaces(const void *a, const void *b)
{
  const Corner *of[] = {(const Corner *)a, (const Corner *)b};

  for (PetscInt c = 0; c < ISPH_MAX_DIM; c++)
    if (of[0]->x[c] != of[1]->x[c]) return of[0]->x[c] < of[1]->x[c] ? -1 : 1;
  return of[0]->at < of[1]->at ? -1 : 1;
}

/* Returns the boundary of the box that a place is on; -1: none. */
static PetscInt BoxSideAt(const Scene *scene, const PetscReal x[])
{
  PetscInt side = 2 * scene->dim - 1;

  while (side >= 0 && !StrainOnSide(scene, side, x)) side--;
  return side;
}

/* Returns the end of the corners from `first` on that have its place. */
static PetscInt EndOfPlace(PetscInt n, const Corner corner[], PetscInt first)
{
  PetscInt k = first + 1;

  for (; k < n; k++)
    for (PetscInt c = 0; c < ISPH_MAX_DIM; c++)
      if (corner[k].x[c] != corner[first].x[c]) return k;
  return k;
}

/* StrainCorners - Numbers the corners of the facets, and adds their points; not collective. Cells
   side by side compute the places of their corners alike but for rounding: corners on a line of
   the lattice lie in the middle of what counts as one place. A corner that wet bodies share is on a
   contact line. The stiffest fluid at a corner gives its velocity. */
PetscErrorCode StrainCorners(const Scene *scene, const StrainLattice *l, StrainSurface *s,
                             StrainPoints *points)
{
  const PetscInt d = l->dim, all = s->n * d, n = all + s->n_wet;
  Corner        *corner;

  PetscFunctionBegin;
  s->first     = points->n;
  s->n_corners = 0;
  PetscCall(PetscCalloc1(n, &corner));
  PetscCall(PetscRealloc(sizeof(PetscBool) * (size_t)(all + 1), &s->on_level));
  for (PetscInt k = 0; k < n; k++) {
    const PetscReal *x = k < all ? &s->x[k * d] : &s->wet_x[(k - all) * d];

    corner[k].at = k < all ? k : all - 1 - k;
    for (PetscInt a = 0; a < d; a++)
      corner[k].x[a] =
          (PetscInt64)PetscFloorReal((x[a] - scene->lo[a]) / (SAME_PLACE * l->edge[a]) + 0.5);
  }
  if (n) qsort(corner, (size_t)n, sizeof(*corner), ComparePlaces);
  for (PetscInt k = 0, end; k < n; k = end) {
    PetscInt  side = -1, fluid = -1;
    PetscBool on_level = PETSC_FALSE;

    end = EndOfPlace(n, corner, k);
    for (; k < end && corner[k].at < 0; k++) side = s->wet_body[-1 - corner[k].at];
    if (k == end) continue;
    for (PetscInt q = k; q < end; q++) {
      const PetscInt f = corner[q].at / d;

      s->corner[corner[q].at] = s->n_corners;
      if (fluid < 0 || StrainIsStiffer(scene, s->fluid[f], fluid)) fluid = s->fluid[f];
      if (!s->between[f]) on_level = PETSC_TRUE;
    }
    if (BoxSideAt(scene, &s->x[corner[k].at * d]) >= 0)
      side = BoxSideAt(scene, &s->x[corner[k].at * d]);
    PetscCall(StrainPointAdd(d, &s->x[corner[k].at * d], fluid, side, points));
    s->on_level[s->n_corners++] = on_level;
  }
  PetscCall(PetscFree(corner));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns true if the centroid of a facet is in the box of this rank. Input: x - its corners. */
static PetscBool IsOwn(const Particles *p, const PetscReal x[])
{
  const PetscInt d                    = p->dim;
  PetscReal      centre[ISPH_MAX_DIM] = {0.0};

  for (PetscInt e = 0; e < d * d; e++) centre[e % d] += x[e] / d;
  return ParticlesHolds(p, centre);
}

/* Shape of a facet. */
typedef struct {
  PetscReal area, normal[ISPH_MAX_DIM];
  PetscReal slope[ISPH_MAX_DIM][ISPH_MAX_DIM]; /* gradient along it of the function of corner v */
} FacetShape;

/* Computes the shape of a facet; returns false if it has no area. */
static PetscBool ShapeOf(PetscInt dim, const PetscReal x[], FacetShape *f)
{
  PetscReal u[ISPH_MAX_DIM] = {0.0}, v[ISPH_MAX_DIM] = {0.0}, size = 0.0;

  for (PetscInt a = 0; a < dim; a++) {
    u[a] = x[dim + a] - x[a];
    v[a] = dim == 3 ? x[2 * dim + a] - x[a] : 0.0;
  }
  if (dim == 2) {
    f->normal[0] = u[1];
    f->normal[1] = -u[0];
  } else {
    for (PetscInt a = 0; a < 3; a++)
      f->normal[a] = u[(a + 1) % 3] * v[(a + 2) % 3] - u[(a + 2) % 3] * v[(a + 1) % 3];
  }
  for (PetscInt a = 0; a < dim; a++) size += PetscSqr(f->normal[a]);
  size = PetscSqrtReal(size);
  if (size == 0.0) return PETSC_FALSE;
  for (PetscInt a = 0; a < dim; a++) f->normal[a] /= size;
  f->area = dim == 2 ? size : 0.5 * size;
  if (dim == 2) {
    for (PetscInt a = 0; a < 2; a++) {
      f->slope[1][a] = u[a] / PetscSqr(size);
      f->slope[0][a] = -f->slope[1][a];
    }
    return PETSC_TRUE;
  }
  for (PetscInt a = 0; a < 3; a++) { /* n x edge over twice the area */
    const PetscInt  b = (a + 1) % 3, c = (a + 2) % 3;
    const PetscReal w[2] = {v[b] - u[b], v[c] - u[c]};

    f->slope[0][a] = (f->normal[b] * w[1] - f->normal[c] * w[0]) / size;
    f->slope[1][a] = (f->normal[c] * v[b] - f->normal[b] * v[c]) / size;
    f->slope[2][a] = (f->normal[b] * u[c] - f->normal[c] * u[b]) / size;
  }
  return PETSC_TRUE;
}

/* Computes the derivative of cos(angle) times the area of wet walls by corner v of a facet of the
   free surface with the corners x. A wet wall grows along itself, away from the fluid: in 2D by the
   way of the corner, in 3D by half of the edge of the facet on the wall times it. Returns the side
   of the box, or -1 where it is zero. */
static PetscInt WetSlope(const Scene *scene, PetscBool between, const PetscReal x[],
                         const FacetShape *f, PetscInt v, PetscReal slope[])
{
  const PetscInt d  = scene->dim;
  PetscInt       on = -1;

  for (PetscInt a = 0; a < d; a++) slope[a] = 0.0;
  for (PetscInt side = 0; side < 2 * d && !between; side++) {
    const PetscReal contact = scene->boundary[side].contact;
    const PetscReal along   = PetscSqrtReal(1.0 - PetscMin(PetscSqr(f->normal[side / 2]), 1.0));

    if (contact == 0.0 || along == 0.0 || !StrainOnSide(scene, side, &x[v * d])) continue;
    on = side;
    for (PetscInt w = 0; w < d; w++) {
      PetscReal length = 0.0;

      if (w == v ? d == 3 : d == 2) continue;
      for (PetscInt a = 0; a < d; a++) length += PetscSqr(x[w * d + a] - x[v * d + a]);
      length =
          d == 3 ? (StrainOnSide(scene, side, &x[w * d]) ? 0.5 * PetscSqrtReal(length) : 0.0) : 1.0;
      for (PetscInt a = 0; a < d; a++)
        if (a != side / 2) slope[a] += contact * length * f->normal[a] / along;
    }
  }
  return on;
}

/* StrainTension - Adds the forces of the tension of all surfaces to those of own particles. Not
   collective. Input/Output: force - component a of particle i at [i dim + a] [N]. Output: energy -
   of facets of this rank's box, less cos(angle) times that of wet walls [J]. */
PetscErrorCode StrainTension(const Scene *scene, const Particles *p, const StrainCells *cells,
                             PetscReal force[], PetscReal *energy)
{
  const StrainSurface *s = &cells->surface;
  const PetscInt       d = p->dim;

  PetscFunctionBegin;
  *energy = 0.0;
  for (PetscInt side = 0; side < 2 * d; side++)
    *energy -= scene->tension * scene->boundary[side].contact * s->wet[side];
  for (PetscInt f = 0; f < s->n; f++) {
    FacetShape shape;

    if (s->tension[f] == 0.0 || !ShapeOf(d, &s->x[f * d * d], &shape)) continue;
    if (IsOwn(p, &s->x[f * d * d])) *energy += s->tension[f] * shape.area;
    for (PetscInt v = 0; v < d; v++) {
      const PetscInt k = s->corner[f * d + v];
      PetscReal      wet[ISPH_MAX_DIM];

      (void)WetSlope(scene, s->between[f], &s->x[f * d * d], &shape, v, wet);
      for (PetscInt e = s->motion.start[k]; e < s->motion.start[k + 1]; e++)
        for (PetscInt c = 0; c < d * d && s->motion.j[e] < p->n_fluid; c++)
          force[d * s->motion.j[e] + c % d] -= s->tension[f] * s->motion.w[e * d * d + c] *
                                               (shape.area * shape.slope[v][c / d] - wet[c / d]);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the forces of a facet on wall particles. Input: slope - of u.n along the facet, times the
   step. */
static void AddFacetOnWalls(const Scene *scene, const Particles *p, const StrainCells *cells,
                            PetscInt f, const FacetShape *shape, const PetscReal slope[],
                            PetscReal force[])
{
  const StrainSurface *s       = &cells->surface;
  const PetscReal      tension = s->tension[f];
  const PetscInt       d       = p->dim;

  for (PetscInt v = 0; v < d; v++) {
    const PetscInt k = s->corner[f * d + v], row = (s->first + k) * cells->sets;
    PetscReal      wet[ISPH_MAX_DIM];
    const PetscInt side = WetSlope(scene, s->between[f], &s->x[f * d * d], shape, v, wet);
    const PetscInt on   = row + (cells->sets == 1 ? 0 : PetscMax(side, 0) / 2);

    for (PetscInt a = 0; a < d; a++) {
      PetscReal change = shape->slope[v][a];

      for (PetscInt b = 0; b < d; b++) change += shape->normal[a] * shape->slope[v][b] * slope[b];
      for (PetscInt e = s->motion.start[k]; e < s->motion.start[k + 1]; e++)
        for (PetscInt b = 0; b < d && ParticlesIsWall(p, s->motion.j[e]); b++)
          force[d * s->motion.j[e] + b] -=
              tension * s->motion.w[(e * d + a) * d + b] * (shape->area * change - wet[a]);
      for (PetscInt e = s->rows.start[on]; e < s->rows.start[on + 1] && side >= 0; e++)
        if (ParticlesIsWall(p, s->rows.j[e]))
          force[d * s->rows.j[e] + a] -= tension * s->rows.w[e] * wet[a]; /* the wall pulls */
    }
  }
}

/* StrainTensionOnWalls - Adds the forces of the tension on wall particles, and their change in a
   step, by the facets of this rank's box; not collective. Input: value - velocities by local index;
   force - component a on particle j at [j dim + a] [N]. */
void StrainTensionOnWalls(const Scene *scene, const Particles *p, const StrainCells *cells,
                          PetscReal *const value[], PetscReal dt, PetscReal force[])
{
  const StrainSurface *s = &cells->surface;
  const PetscInt       d = p->dim;

  for (PetscInt f = 0; f < s->n; f++) {
    FacetShape shape;
    PetscReal  slope[ISPH_MAX_DIM] = {0.0}; /* of the fluid alone */

    if (s->tension[f] == 0.0 || !IsOwn(p, &s->x[f * d * d]) ||
        !ShapeOf(d, &s->x[f * d * d], &shape))
      continue;
    for (PetscInt v = 0; v < d; v++) {
      const PetscInt k       = s->corner[f * d + v];
      PetscReal      through = 0.0;

      for (PetscInt e = s->motion.start[k]; e < s->motion.start[k + 1]; e++)
        for (PetscInt c = 0; c < d * d && !ParticlesIsWall(p, s->motion.j[e]); c++)
          through +=
              dt * s->motion.w[e * d * d + c] * shape.normal[c / d] * value[c % d][s->motion.j[e]];
      for (PetscInt b = 0; b < d; b++) slope[b] += shape.slope[v][b] * through;
    }
    AddFacetOnWalls(scene, p, cells, f, &shape, slope, force);
  }
}

/* Creates the matrix Y of the velocities of the corners: interlaced components over fluid ->
   interlaced components at the corners of this rank. */
static PetscErrorCode CornerVelocities(const Particles *p, const StrainSurface *s, Mat *Y)
{
  const StrainBlocks *of = &s->motion;
  const PetscInt      d = p->dim, n = d * s->n_corners;
  PetscInt           *width, first;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(n, &width));
  for (PetscInt k = 0; k < n; k++) width[k] = d * (of->start[k / d + 1] - of->start[k / d]);
  PetscCall(MatCreateAIJ(p->comm, n, d * p->n_fluid, PETSC_DETERMINE, PETSC_DETERMINE, 0, width, 0,
                         width, Y));
  PetscCall(PetscFree(width));
  PetscCall(MatGetOwnershipRange(*Y, &first, NULL));
  for (PetscInt k = 0; k < n; k++)
    for (PetscInt e = of->start[k / d]; e < of->start[k / d + 1]; e++)
      for (PetscInt b = 0; b < d && !ParticlesIsWall(p, of->j[e]); b++)
        PetscCall(MatSetValue(*Y, first + k, d * p->row[of->j[e]] + b,
                              of->w[e * d * d + k % d * d + b], ADD_VALUES));
  PetscCall(MatAssemblyBegin(*Y, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(*Y, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the matrix of the gradients of u.n along the facets of this rank's box, over components
   at the corners: sigma int (grad_s u.n) (grad_s v.n) dA. */
static PetscErrorCode CornerSlopes(const Particles *p, const StrainCells *cells, Mat *S)
{
  const StrainSurface *s = &cells->surface;
  const PetscInt       d = p->dim, n = d * s->n_corners;
  PetscInt             first;

  PetscFunctionBegin;
  PetscCall(MatCreateAIJ(p->comm, n, n, PETSC_DETERMINE, PETSC_DETERMINE, d == 2 ? 6 : 30, NULL, 0,
                         NULL, S));
  PetscCall(MatSetOption(*S, MAT_NEW_NONZERO_ALLOCATION_ERR, PETSC_FALSE));
  PetscCall(MatGetOwnershipRange(*S, &first, NULL));
  for (PetscInt f = 0; f < s->n; f++) {
    FacetShape shape;

    if (s->tension[f] == 0.0 || !IsOwn(p, &s->x[f * d * d]) ||
        !ShapeOf(d, &s->x[f * d * d], &shape))
      continue;
    for (PetscInt v = 0; v < d * d; v++) {
      const PetscInt  w[] = {v / d, v % d};
      PetscReal       dot = 0.0;
      const PetscInt *of  = &s->corner[f * d];

      for (PetscInt a = 0; a < d; a++) dot += shape.slope[w[0]][a] * shape.slope[w[1]][a];
      for (PetscInt a = 0; a < d; a++)
        for (PetscInt b = 0; b < d; b++)
          PetscCall(MatSetValue(
              *S, first + d * of[w[0]] + a, first + d * of[w[1]] + b,
              s->tension[f] * shape.area * shape.normal[a] * shape.normal[b] * dot, ADD_VALUES));
    }
  }
  PetscCall(MatAssemblyBegin(*S, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(*S, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* StrainTensionMatrix - Creates sigma K over interlaced components of fluid, see the top;
   collective */
PetscErrorCode StrainTensionMatrix(const Particles *p, const StrainCells *cells, Mat *K)
{
  Mat Y, S, back, product;

  PetscFunctionBegin;
  PetscCall(CornerVelocities(p, &cells->surface, &Y));
  PetscCall(CornerSlopes(p, cells, &S));
  PetscCall(MatMatMult(S, Y, MAT_INITIAL_MATRIX, PETSC_DEFAULT, &product));
  PetscCall(MatTranspose(Y, MAT_INITIAL_MATRIX, &back));
  PetscCall(MatMatMult(back, product, MAT_INITIAL_MATRIX, PETSC_DEFAULT, K));
  PetscCall(MatProductClear(*K));
  PetscCall(MatDestroyAll(&Y, &S, &back, &product));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds f times kernel and gradient at the distance X from i to a point. */
static void AddKernel(const KernelSize *kernel, PetscInt dim, const PetscReal X[], PetscReal f,
                      PetscReal *value, PetscReal gradient[])
{
  PetscReal r = 0.0, w[3];

  for (PetscInt a = 0; a < dim; a++) r += PetscSqr(X[a]);
  r = PetscSqrtReal(r);
  if (r >= kernel->radius) return;
  KernelEvaluate(kernel->row, dim, kernel->h, r, w);
  *value += f * w[0];
  for (PetscInt a = 0; a < dim && r > 0.0; a++) gradient[a] -= f * w[1] * X[a] / r;
}

/*
  StrainUnevenness - Computes how much denser particles are than the fluid in the cells, and the
  gradient, for shifting

    c_i - 1 = sum_j V_j W_ij - sum_c V_c W(x_i - y_c)

  Not collective. Both sums end at walls and at the free surface alike, so that shifts do not leave
  the fluid. Output: value - c of own fluid; gradient - components.
*/
PetscErrorCode StrainUnevenness(const Scene *scene, const Particles *p, const Neighbors *nb,
                                const KernelSize *kernel, const StrainCells *cells,
                                PetscReal value[], PetscReal *const gradient[])
{
  const StrainLattice *l   = &cells->lattice;
  PetscInt             all = 1, *at, *next;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < l->dim; a++) all *= l->n[a];
  PetscCall(PetscMalloc2(all, &at, cells->n, &next));
  for (PetscInt k = 0; k < all; k++) at[k] = -1;
  for (PetscInt c = 0; c < cells->n; c++) {
    PetscInt k = 0;

    for (PetscInt a = l->dim - 1; a >= 0; a--)
      k = k * l->n[a] + StrainIndexAlong(scene, l, a, cells->centre[a][c]);
    next[c] = at[k];
    at[k]   = c;
  }
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscInt  low[ISPH_MAX_DIM] = {0}, n[ISPH_MAX_DIM] = {1, 1, 1};
    PetscReal g[ISPH_MAX_DIM] = {0.0}, X[ISPH_MAX_DIM];

    value[i] = 1.0;
    for (PetscInt q = nb->row[i] - 1; q < nb->row[i + 1]; q++) {
      const PetscInt j = q < nb->row[i] ? i : nb->col[q];

      if (ParticlesIsWall(p, j)) {
        PetscReal x[ISPH_MAX_DIM] = {0.0}, length;

        if (!StrainWaits(scene, p, j, x, &length)) continue;
        for (PetscInt a = 0; a < p->dim; a++)
          X[a] = x[a] + 0.5 * length * p->normal[a][j] - p->x[a][i];
        AddKernel(kernel, p->dim, X,
                  p->cell_volume * length / SceneCellSide(scene, (PetscInt)p->side[j] / 2),
                  &value[i], g);
        continue;
      }
      for (PetscInt a = 0; a < p->dim; a++) X[a] = p->x[a][j] - p->x[a][i];
      AddKernel(kernel, p->dim, X, p->volume[j], &value[i], g);
    }
    for (PetscInt a = 0; a < p->dim; a++) {
      low[a] = StrainIndexAlong(scene, l, a, p->x[a][i] - kernel->radius);
      n[a]   = StrainIndexAlong(scene, l, a, p->x[a][i] + kernel->radius) - low[a] + 1;
    }
    for (PetscInt k = 0; k < n[0] * n[1] * n[2]; k++) {
      const PetscInt step[] = {k % n[0], k / n[0] % n[1], k / (n[0] * n[1])};
      PetscInt       cell   = 0;

      for (PetscInt a = l->dim - 1; a >= 0; a--) cell = cell * l->n[a] + low[a] + step[a];
      for (PetscInt c = at[cell]; c >= 0; c = next[c]) {
        for (PetscInt a = 0; a < p->dim; a++) X[a] = cells->centre[a][c] - p->x[a][i];
        AddKernel(kernel, p->dim, X, -cells->volume[c], &value[i], g);
      }
    }
    for (PetscInt a = 0; a < p->dim; a++) gradient[a][i] = g[a];
  }
  PetscCall(PetscFree2(at, next));
  PetscFunctionReturn(PETSC_SUCCESS);
}
