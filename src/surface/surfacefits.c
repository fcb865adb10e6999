/*
  Quadratic fits of a free surface through its particles, which give normals, depths and curvatures.

  Weights of the fit are (1 - r^2/R^2)^2, with the radius R of the support. With a surface tension
  they are (1 - r^2/R^2) exp(-r^2/(2 dx^2)). The curvature then has the sign of the displacement for
  waves of any length along particles 0.8 to 1.4 dx apart. The wider weights give the shortest waves
  the wrong sign, and surface tension lets them grow: theory.md, (surface:kernel). Outflows, and
  walls along which the fluid slides, mirror the surface; with surface tension walls without slip do
  too.
*/
#include "surfacefits.h"

#define ALIGNED   0.3 /* least n_i.n_j of particles in a fit */
#define RESIDUAL  0.3 /* root mean square of the fit above which the surface is rough [dx] */
#define CURVATURE 0.5 /* likewise of c [1/dx] */
#define FIT_TERMS 6
#define MEANS     2 /* means of curvatures over neighbours, for surface tension */

/* Planes of walls near a particle, and the same planes through the particle, which turn normals. */
typedef struct {
  PetscInt  n;
  WallPlane plane[WALL_PLANES], turn[WALL_PLANES];
} Mirrors;

/* Normal equations of a fit of the surface, in units of the radius of the support. */
typedef struct {
  PetscReal M[FIT_TERMS * FIT_TERMS], c[FIT_TERMS], squares, weights;
} FitSums;

/* SurfaceTangents - Computes the unit tangents t of a surface with the unit normal n, one in 2D and
   two in 3D; returns their number; not collective */
PetscInt SurfaceTangents(PetscInt dim, const PetscReal n[], PetscReal t[][ISPH_MAX_DIM])
{
  PetscInt  least = 0;
  PetscReal length;

  if (dim == 2) {
    t[0][0] = -n[1];
    t[0][1] = n[0];
    return 1;
  }
  for (PetscInt a = 1; a < 3; a++) least = PetscAbsReal(n[a]) < PetscAbsReal(n[least]) ? a : least;
  length = PetscSqrtReal(1.0 - PetscSqr(n[least]));
  for (PetscInt a = 0; a < 3; a++) t[0][a] = ((a == least) - n[least] * n[a]) / length;
  for (PetscInt a = 0; a < 3; a++) {
    const PetscInt b = (a + 1) % 3, c = (a + 2) % 3;

    t[1][a] = n[b] * t[0][c] - n[c] * t[0][b];
  }
  return 2;
}

/* Returns the weight of a particle at the distance sqrt(r2) [R], with the spacing dx [R]. */
static PetscReal FitWeight(const FreeSurface *free, PetscReal dx, PetscReal r2)
{
  return (1.0 - r2) * (free->tension > 0.0 ? PetscExpReal(-0.5 * r2 / PetscSqr(dx)) : 1.0 - r2);
}

/* Computes the basis of a fit at s. */
static void FitBasis(PetscInt dim, const PetscReal s[], PetscReal phi[])
{
  PetscInt t = 0;

  phi[t++] = 1.0;
  for (PetscInt m = 0; m < dim - 1; m++) phi[t++] = s[m];
  for (PetscInt m = 0; m < dim - 1; m++) {
    for (PetscInt q = 0; q <= m; q++) phi[t++] = s[m] * s[q];
  }
}

/* Sets the planes of walls in which surface particles near particle i have images: with surface
   tension all, otherwise sides along which the fluid slides. */
static void FindMirrors(const Scene *scene, const Particles *p, const FreeSurface *free, PetscInt i,
                        PetscReal R, Mirrors *mirrors)
{
  PetscReal x[ISPH_MAX_DIM];
  PetscInt  n;

  mirrors->n = 0;
  for (PetscInt a = 0; a < p->dim; a++) x[a] = p->x[a][i];
  SceneWallPlanes(scene, x, R, mirrors->plane, &n);
  for (PetscInt k = 0; k < n; k++)
    if (free->tension > 0.0 || !BoundaryIs(scene, mirrors->plane[k].side, BOUNDARY_NO_SLIP))
      mirrors->plane[mirrors->n++] = mirrors->plane[k];
  for (PetscInt k = 0; k < mirrors->n; k++) {
    mirrors->turn[k]          = mirrors->plane[k];
    mirrors->turn[k].distance = 0.0;
  }
}

/* Computes the position X of image `set` of particle j relative to particle i [R], and its square
   r2; set 0 is the particle. Returns false if it does not take part in the fit of i. */
static PetscBool TakesPart(const Particles *p, const FreeSurface *free, const Mirrors *mirrors,
                           PetscInt i, PetscInt j, PetscInt set, PetscReal R, PetscReal X[],
                           PetscReal *r2)
{
  const PetscReal *normal  = &free->normal[i * p->dim];
  PetscReal        aligned = 0.0, from[ISPH_MAX_DIM], turned[ISPH_MAX_DIM];

  *r2 = 0.0;
  if (ParticlesIsWall(p, j)) return PETSC_FALSE;
  if (free->kind[j] != SURFACE_SMOOTH && free->kind[j] != SURFACE_ROUGH) return PETSC_FALSE;
  for (PetscInt a = 0; a < p->dim; a++) from[a] = p->x[a][j] - p->x[a][i];
  MirrorImage(p->dim, mirrors->n, mirrors->plane, set, from, X);
  MirrorImage(p->dim, mirrors->n, mirrors->turn, set, &free->normal[j * p->dim], turned);
  for (PetscInt a = 0; a < p->dim; a++) {
    X[a] /= R;
    *r2 += PetscSqr(X[a]);
    aligned += turned[a] * normal[a];
  }
  return *r2 < 1.0 && aligned > ALIGNED;
}

/* Adds a particle at X [R], r2 = |X|^2, to the sums of a fit. */
static void AddToFit(PetscInt d, PetscInt terms, PetscReal W, const PetscReal X[],
                     const PetscReal normal[], PetscReal t[][ISPH_MAX_DIM], FitSums *sums)
{
  PetscReal s[2] = {0.0}, eta = 0.0, phi[FIT_TERMS];

  for (PetscInt a = 0; a < d; a++) {
    eta += X[a] * normal[a];
    for (PetscInt m = 0; m < d - 1; m++) s[m] += X[a] * t[m][a];
  }
  FitBasis(d, s, phi);
  for (PetscInt u = 0; u < terms; u++) {
    for (PetscInt v = 0; v < terms; v++) sums->M[u * terms + v] += W * phi[u] * phi[v];
    sums->c[u] += W * phi[u] * eta;
  }
  sums->squares += W * PetscSqr(eta);
  sums->weights += W;
}

/* SurfaceFitAt - Fits the surface about own particle i in the frame of its normal; sets its new
   normal, its depth and free->curvature; returns SURFACE_ROUGH if no smooth surface passes there;
   not collective */
SurfaceKind SurfaceFitAt(const Scene *scene, const Particles *p, const Neighbors *nb,
                         const KernelSize *kernel, const FreeSurface *free, PetscInt i,
                         SurfaceFits *fits)
{
  const PetscInt  d = p->dim, terms = d == 2 ? 3 : FIT_TERMS;
  const PetscReal R         = kernel->row->support * kernel->h_over_dx * p->dx[i];
  PetscReal      *normal    = &fits->normal[i * d];
  PetscReal      *curvature = &free->curvature[i];
  FitSums         sums      = {.squares = 0.0};
  Mirrors         mirrors;
  PetscReal       t[2][ISPH_MAX_DIM], b[FIT_TERMS], length = 1.0;

  (void)SurfaceTangents(d, normal, t);
  FindMirrors(scene, p, free, i, R, &mirrors);
  for (PetscInt q = nb->row[i] - 1; q < nb->row[i + 1]; q++) {
    const PetscInt j = q < nb->row[i] ? i : nb->col[q];

    for (PetscInt set = 0; set < 1 << mirrors.n; set++) {
      PetscReal X[ISPH_MAX_DIM], r2;

      if (TakesPart(p, free, &mirrors, i, j, set, R, X, &r2))
        AddToFit(d, terms, FitWeight(free, p->dx[i] / R, r2), X, normal, t, &sums);
    }
  }
  for (PetscInt u = 0; u < terms; u++) b[u] = sums.c[u];
  if (DenseCholesky(terms, sums.M)) return SURFACE_ROUGH;
  DenseCholeskySolve(terms, sums.M, sums.c);
  for (PetscInt u = 0; u < terms; u++) sums.squares -= b[u] * sums.c[u];
  fits->depth[i] = sums.c[0] * R;
  *curvature     = 0.0;
  for (PetscInt m = 0; m < d - 1; m++) *curvature -= 2.0 * sums.c[d + m * (m + 1) / 2 + m] / R;
  if (PetscSqrtReal(PetscMax(sums.squares, 0.0) / sums.weights) * R > RESIDUAL * p->dx[i])
    return SURFACE_ROUGH;
  if (PetscAbsReal(*curvature) > 2.0 * CURVATURE * (d - 1) / p->dx[i]) return SURFACE_ROUGH;
  for (PetscInt m = 0; m < d - 1; m++) length += PetscSqr(sums.c[1 + m]);
  length = PetscSqrtReal(length);
  for (PetscInt a = 0; a < d; a++) {
    for (PetscInt m = 0; m < d - 1; m++) normal[a] -= sums.c[1 + m] * t[m][a];
    normal[a] /= length;
  }
  return SURFACE_SMOOTH;
}

/* Returns the mean of the curvatures of own particle i and of surface particles nearby. */
static PetscReal MeanCurvature(const Scene *scene, const Particles *p, const Neighbors *nb,
                               const KernelSize *kernel, const FreeSurface *free, PetscInt i)
{
  const PetscReal R   = kernel->row->support * kernel->h_over_dx * p->dx[i];
  PetscReal       sum = 0.0, weights = 0.0;
  Mirrors         mirrors;

  FindMirrors(scene, p, free, i, R, &mirrors);
  for (PetscInt q = nb->row[i] - 1; q < nb->row[i + 1]; q++) {
    const PetscInt j = q < nb->row[i] ? i : nb->col[q];

    for (PetscInt set = 0; set < 1 << mirrors.n; set++) {
      PetscReal X[ISPH_MAX_DIM], r2, W;

      if (!TakesPart(p, free, &mirrors, i, j, set, R, X, &r2)) continue;
      W = FitWeight(free, p->dx[i] / R, r2);
      sum += W * free->curvature[j];
      weights += W;
    }
  }
  return weights > 0.0 ? sum / weights : 0.0;
}

/* SurfaceAverageCurvature - Bounds the curvatures of the fits by 1/dx, and replaces them MEANS
   times by their means over surface particles nearby, with the weights of the fit. Collective. A
   displacement y of a single particle, such as that of a particle that joins the surface where it
   stretches, changes the curvature of its fit by 0.7 y/dx^2. The means take four fifths of it.
   Rough particles take part: their curvature makes corners round. */
PetscErrorCode SurfaceAverageCurvature(const Scene *scene, const Particles *p, const Neighbors *nb,
                                       const KernelSize *kernel, FreeSurface *free)
{
  PetscReal *next;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    const PetscReal most = 2.0 * CURVATURE * (p->dim - 1) / p->dx[i];

    free->curvature[i] = PetscMin(PetscMax(free->curvature[i], -most), most);
  }
  PetscCall(PetscMalloc1(p->n_fluid, &next));
  for (PetscInt mean = 0; mean < MEANS; mean++) {
    PetscCall(ParticlesHaloField(p, free->curvature));
    for (PetscInt i = 0; i < p->n_fluid; i++)
      next[i] = FreeSurfaceHolds(free, i) ? MeanCurvature(scene, p, nb, kernel, free, i) : 0.0;
    PetscCall(PetscArraycpy(free->curvature, next, p->n_fluid));
  }
  PetscCall(PetscFree(next));
  PetscFunctionReturn(PETSC_SUCCESS);
}
