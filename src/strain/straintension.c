/*
  The tension of the facets of the strain cells, with the corners y_v: the derivative of their areas
  A_f by the velocities of the corners. It sums to zero over each body of fluid, with its torque:

    F_i = -sum_f sigma_f sum_v Y_vi^T dA_f/dy_v,   u(y_v) = sum_i Y_vi u_i

  with the matrices of strainmotion.c. A corner on an outflow is where the side cuts the surface: it
  slides along the side, and the surface beyond pulls at the fluid. A step dt changes it by the part
  of the second derivative that has no negative eigenvalue,

    dF_i = -dt sigma sum_j K_ij u_j,   K_ij = sum of int (grad_s Y_i^T n).(grad_s Y_j^T n)

  Source: docs/developers/theory.md, (strain:tension) and (strain:marangoni). Derivatives of the
  area are those of K. A. Brakke, Exp. Math. 1 (1992) 141-165, the change in a step that of S.
  Hysing, Int. J. Numer. Meth. Fluids 51 (2006) 659-672.
*/
#include "strain.h"

/* StrainSetTension - Sets the tension of facets of the free surface to the mean of that at their
   corners, by the fits of the velocity without walls. Not collective. Input: sigma - of the fluid
   particles, by local index [N/m]. */
void StrainSetTension(const Particles *p, const PetscReal sigma[], StrainCells *cells)
{
  StrainSurface *s = &cells->surface;

  for (PetscInt f = 0; f < s->n; f++) {
    PetscReal mean = 0.0;

    for (PetscInt v = 0; v < p->dim && !s->between[f]; v++) {
      PetscReal best = 0.0, value = 0.0;

      for (PetscInt q = 0; q < cells->sets; q++) {
        const PetscInt row    = (s->first + s->corner[f * p->dim + v]) * cells->sets + q;
        PetscReal      sum[2] = {0.0};

        for (PetscInt e = s->rows.start[row]; e < s->rows.start[row + 1]; e++) {
          if (ParticlesIsWall(p, s->rows.j[e])) continue;
          sum[0] += s->rows.w[e];
          sum[1] += s->rows.w[e] * sigma[s->rows.j[e]];
        }
        if (sum[0] <= best) continue;
        best  = sum[0];
        value = sum[1] / sum[0];
      }
      mean += PetscMax(value, 0.0) / p->dim;
    }
    if (!s->between[f]) s->tension[f] = mean;
  }
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

/* Returns the outflow on which a corner is, or -1. */
static PetscInt OutflowAt(const Scene *scene, const PetscReal x[])
{
  for (PetscInt side = 0; side < 2 * scene->dim; side++)
    if (BoundaryIs(scene, side, BOUNDARY_OUTFLOW) && StrainOnSide(scene, side, x)) return side;
  return -1;
}

/* Computes the derivative of the energy of facet f over its tension by its corner v; returns the
   side of WetSlope(). Output: wet - of WetSlope(); beyond - the part along the normal of an
   outflow, which the surface beyond bears. */
static PetscInt EnergySlope(const Scene *scene, const StrainSurface *s, PetscInt f,
                            const FacetShape *shape, PetscInt v, PetscReal slope[], PetscReal wet[],
                            PetscReal *beyond)
{
  const PetscInt   d       = scene->dim;
  const PetscReal *x       = &s->x[f * d * d];
  const PetscInt   side    = WetSlope(scene, s->between[f], x, shape, v, wet);
  const PetscInt   outflow = OutflowAt(scene, &x[v * d]);

  *beyond = 0.0;
  for (PetscInt a = 0; a < d; a++) slope[a] = shape->area * shape->slope[v][a] - wet[a];
  if (outflow < 0) return side;
  *beyond            = slope[outflow / 2];
  slope[outflow / 2] = 0.0;
  return side;
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
      PetscReal      slope[ISPH_MAX_DIM], wet[ISPH_MAX_DIM], beyond;

      (void)EnergySlope(scene, s, f, &shape, v, slope, wet, &beyond);
      for (PetscInt e = s->motion.start[k]; e < s->motion.start[k + 1]; e++)
        for (PetscInt c = 0; c < d * d && s->motion.j[e] < p->n_fluid; c++)
          force[d * s->motion.j[e] + c % d] -=
              s->tension[f] * s->motion.w[e * d * d + c] * slope[c / d];
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds a force along the normal of an outflow to its particle nearest to a place. */
static void AddBeyond(const Scene *scene, const Particles *p, const PetscReal x[], PetscReal pull,
                      PetscReal force[])
{
  const PetscInt side  = OutflowAt(scene, x);
  PetscReal      least = PETSC_INFINITY;
  PetscInt       best  = -1;

  for (PetscInt w = p->n_fluid; w < ParticlesAll(p); w++) {
    PetscReal y[ISPH_MAX_DIM], r2 = 0.0;

    if (!ParticlesIsWall(p, w) || (PetscInt)p->side[w] != side) continue;
    ParticlesWallPoint(p, w, y);
    for (PetscInt a = 0; a < p->dim; a++) r2 += PetscSqr(y[a] - x[a]);
    if (r2 < least) best = w;
    least = PetscMin(least, r2);
  }
  if (best >= 0) force[p->dim * best + side / 2] += pull;
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
    PetscReal      wet[ISPH_MAX_DIM], energy[ISPH_MAX_DIM], beyond;
    const PetscInt side = EnergySlope(scene, s, f, shape, v, energy, wet, &beyond);
    const PetscInt on   = row + (cells->sets == 1 ? 0 : PetscMax(side, 0) / 2);

    if (beyond != 0.0) AddBeyond(scene, p, &s->x[(f * d + v) * d], -tension * beyond, force);
    for (PetscInt a = 0; a < d; a++) {
      PetscReal change = 0.0;

      for (PetscInt b = 0; b < d; b++) change += shape->normal[a] * shape->slope[v][b] * slope[b];
      for (PetscInt e = s->motion.start[k]; e < s->motion.start[k + 1]; e++)
        for (PetscInt b = 0; b < d && ParticlesIsWall(p, s->motion.j[e]); b++)
          force[d * s->motion.j[e] + b] -=
              tension * s->motion.w[(e * d + a) * d + b] * (shape->area * change + energy[a]);
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
