/*
  Particles on free surfaces, their normals and curvatures, from the present positions. Sums over
  neighbours tell where fluid is missing,

    S = sum_j V_j grad_i W_ij,   B = sum_j V_j X (x) grad_j W_ij,   X = x_j - x_i,

  S vanishes and B is the unit matrix inside the fluid; walls act by mirror images. A candidate is
  on the surface if no neighbour is in the cone about n_0 = -S/|S|, or if the concentration
  sum_j V_j W_ij lacks nearly as much as on a plane surface. Normals n are those of a quadratic fit
  through the surface particles nearby, in the frame of n_0:

    y.n_0 = a + b_m s_m + c_mq s_m s_q,   n = (n_0 - b_m t_m)/|..|,   s_m = y.t_m

  A normal from S has an error on disordered particles that does not fall with dx, and so has the
  stress that a row with this normal gives to the fluid.

  Weights of the fit are (1 - r^2/R^2)^2, with the radius R of the support. With a surface tension
  they are (1 - r^2/R^2) exp(-r^2/(2 dx^2)). The curvature then has the sign of the displacement for
  waves of any length along particles 0.8 to 1.4 dx apart. The wider weights give the shortest waves
  the wrong sign, and surface tension lets them grow: docs/theory.md, (163). Walls mirror the
  surface.

  Reference: S. Marrone, A. Colagrossi, D. Le Touze, G. Graziani, J. Comput. Phys. 229 (2010)
  3652-3663
*/
#include "assembly.h"
#include "rows.h"

#define CANDIDATE   0.35 /* least |S| over its value dx/2 below a plane */
#define SPARSE      0.3  /* least eigenvalue of B below which a particle is a candidate */
#define VOID        0.7  /* least 1 - C over its value there of a particle that is on the surface */
#define CONE        0.743 /* cosine of half the angle of the cone, 42 degrees */
#define CONE_LENGTH 2.0   /* [dx] */
#define ALIGNED     0.3   /* least n_i.n_j of particles in a fit */
#define BESIDE      1.2   /* distance to a rough particle at which a surface is rough too [dx] */
#define OFF_WALLS   2.0   /* distance from wall particles from which on this holds [dx] */
#define RESIDUAL    0.3   /* root mean square of the fit above which the surface is rough [dx] */
#define CURVATURE   0.5   /* likewise of c [1/dx] */
#define BELOW       0.15  /* depth below the fit from which on a particle is inside [dx] */
#define WET         1.3   /* distance of fluid from a wall particle that it touches [dx] */
#define CLOSE       1.9   /* distance of neighbours that a particle must have [dx] */
#define FIT_TERMS   6
#define MEANS       2 /* means of curvatures over neighbours, for surface tension */

/* Neighbours of a particle and their images in walls. */
typedef struct {
  PetscReal S[ISPH_MAX_DIM], B[ISPH_MAX_DIM * ISPH_MAX_DIM], C; /* C: concentration */
  PetscInt  close;
} Sums;

/* The sums at the distance dx/2 from the plane that bounds a half-space of fluid. */
typedef struct {
  PetscReal S, C;
} PlaneSums;

/* Planes of walls near a particle, and the same planes through the particle, which turn normals. */
typedef struct {
  PetscInt  n;
  WallPlane plane[SCENE_MAX_BOUNDARIES], turn[SCENE_MAX_BOUNDARIES];
} Mirrors;

/* Normal equations of a fit of the surface, in units of the radius of the support. */
typedef struct {
  PetscReal M[FIT_TERMS * FIT_TERMS], c[FIT_TERMS], squares, weights;
} FitSums;

/* Results of fits by own particle: the normal, and the depth of the particle below the fit [m]. */
typedef struct {
  PetscReal *normal, *depth;
} Fits;

/* Adds a neighbour at the distance X to the sums. */
static void AddNeighbour(const KernelRow *kernel, PetscInt dim, PetscReal h, PetscReal V,
                         const PetscReal X[], Sums *sums)
{
  PetscReal r = 0.0, w[3];

  for (PetscInt a = 0; a < dim; a++) r += PetscSqr(X[a]);
  r = PetscSqrtReal(r);
  if (r >= kernel->support * h) return;
  KernelEvaluate(kernel, dim, h, r, w);
  sums->C += V * w[0];
  for (PetscInt a = 0; a < dim && r > 0.0; a++) {
    sums->S[a] -= V * w[1] * X[a] / r;
    for (PetscInt b = 0; b < dim; b++) sums->B[a * dim + b] -= V * w[1] * X[a] * X[b] / r;
  }
}

/* Computes the sums of own particle i. */
static void SumsOf(const Scene *scene, const Particles *p, const Neighbors *nb,
                   const OperatorForms *forms, PetscInt i, Sums *sums)
{
  const PetscReal h = forms->h_over_dx * p->dx[i];
  const PetscInt  d = p->dim;
  WallPlane       planes[SCENE_MAX_BOUNDARIES];
  PetscReal       x[ISPH_MAX_DIM];
  PetscInt        n_planes;

  *sums = (Sums){.close = 0};
  for (PetscInt a = 0; a < d; a++) x[a] = p->x[a][i];
  SceneWallPlanes(scene, x, forms->radius, planes, &n_planes);
  for (PetscInt q = nb->row[i] - 1; q < nb->row[i + 1]; q++) {
    const PetscInt j  = q < nb->row[i] ? i : nb->col[q];
    PetscReal      r2 = 0.0, X[ISPH_MAX_DIM];

    if (ParticlesIsWall(p, j)) continue;
    for (PetscInt a = 0; a < d; a++) {
      X[a] = p->x[a][j] - x[a];
      r2 += PetscSqr(X[a]);
    }
    if (r2 > 0.0 && r2 < PetscSqr(CLOSE * p->dx[i])) sums->close++;
    AddNeighbour(forms->kernel, d, h, p->volume[j], X, sums);
    for (PetscInt set = 1; set < 1 << n_planes; set++) {
      PetscReal Y[ISPH_MAX_DIM];

      MirrorImage(d, n_planes, planes, set, X, Y);
      AddNeighbour(forms->kernel, d, h, p->volume[j], Y, sums);
    }
  }
}

/* Returns int W dA over a plane at a distance, by the midpoint rule [1/m]. */
static PetscReal PlaneIntegral(const KernelRow *kernel, PetscInt dim, PetscReal h,
                               PetscReal distance)
{
  const PetscInt  n    = 200;
  const PetscReal step = kernel->support * h / n;
  PetscReal       sum  = 0.0;

  for (PetscInt k = 0; k < n; k++) {
    const PetscReal s = (k + 0.5) * step, r = PetscSqrtReal(PetscSqr(s) + PetscSqr(distance));
    PetscReal       w[3];

    if (r >= kernel->support * h) break;
    KernelEvaluate(kernel, dim, h, r, w);
    sum += w[0] * step * (dim == 2 ? 2.0 : 2.0 * PETSC_PI * s);
  }
  return sum;
}

/* Computes |S| = int W dA over the plane, and C = 1/2 + the integral of |S| from the plane to the
   particle, by Simpson's rule. */
static void ComputePlane(const KernelRow *kernel, PetscInt dim, PetscReal h, PetscReal dx,
                         PlaneSums *plane)
{
  plane->S = PlaneIntegral(kernel, dim, h, 0.5 * dx);
  plane->C = 0.5 + dx / 12.0 *
                       (PlaneIntegral(kernel, dim, h, 0.0) +
                        4.0 * PlaneIntegral(kernel, dim, h, 0.25 * dx) + plane->S);
}

/* Returns the least eigenvalue of a symmetric matrix of size 2 or 3. */
static PetscReal LeastEigenvalue(PetscInt d, const PetscReal B[])
{
  PetscReal trace = 0.0, off = 0.0, spread = 0.0, det, angle;

  for (PetscInt a = 0; a < d; a++) trace += B[a * d + a] / d;
  for (PetscInt a = 0; a < d; a++) {
    spread += PetscSqr(B[a * d + a] - trace);
    for (PetscInt b = 0; b < a; b++) off += PetscSqr(B[a * d + b]);
  }
  if (d == 2) return trace - PetscSqrtReal(0.5 * spread + off);
  spread = PetscSqrtReal((spread + 2.0 * off) / 6.0);
  if (spread == 0.0) return trace;
  det = (B[0] - trace) * ((B[4] - trace) * (B[8] - trace) - B[5] * B[7]) -
        B[1] * (B[3] * (B[8] - trace) - B[5] * B[6]) + B[2] * (B[3] * B[7] - (B[4] - trace) * B[6]);
  det   = 0.5 * det / (spread * spread * spread);
  angle = acos(PetscMin(PetscMax(det, -1.0), 1.0)) / 3.0;
  return trace + 2.0 * spread * PetscCosReal(angle + 2.0 * PETSC_PI / 3.0);
}

/*
  FreeSurfaceTouches - Returns true if fluid touches a wall particle that is a neighbour of own
  fluid particle i

  Not collective. Fluid does not see a wall across a gap: there it has no friction, and the wall
  does not cover it. Only neighbours of i are searched, so that the answer needs no other rank.
*/
PetscBool FreeSurfaceTouches(const Particles *p, const Neighbors *nb, PetscInt i, PetscInt wall)
{
  const PetscReal most = PetscSqr(WET * p->dx[i]);

  for (PetscInt q = nb->row[i] - 1; q < nb->row[i + 1]; q++) {
    const PetscInt j  = q < nb->row[i] ? i : nb->col[q];
    PetscReal      r2 = 0.0;

    if (ParticlesIsWall(p, j)) continue;
    for (PetscInt a = 0; a < p->dim; a++) r2 += PetscSqr(p->x[a][j] - p->x[a][wall]);
    if (r2 < most) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Returns true if a neighbour of own particle i covers it: it is in the cone about the normal. A
   wall particle covers only fluid before it that touches it, and an isolated particle covers
   nothing. */
static PetscBool IsCovered(const Particles *p, const Neighbors *nb, const FreeSurface *free,
                           PetscInt i)
{
  const PetscReal *normal = &free->normal[i * p->dim];

  for (PetscInt q = nb->row[i]; q < nb->row[i + 1]; q++) {
    const PetscInt j  = nb->col[q];
    PetscReal      r2 = 0.0, along = 0.0, faces = 0.0;

    for (PetscInt a = 0; a < p->dim; a++) {
      const PetscReal X = p->x[a][j] - p->x[a][i];

      r2 += PetscSqr(X);
      along += X * normal[a];
      if (ParticlesIsWall(p, j)) faces += p->normal[a][j] * normal[a];
    }
    if (r2 == 0.0 || r2 >= PetscSqr(CONE_LENGTH * p->dx[i])) continue;
    if (along <= CONE * PetscSqrtReal(r2)) continue;
    if (ParticlesIsWall(p, j) ? faces < -0.5 && FreeSurfaceTouches(p, nb, i, j)
                              : free->kind[j] != SURFACE_ISOLATED)
      return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Determines if own particle i can be on the surface, and its first normal: SMOOTH is a candidate,
   ROUGH is on the surface even if it is covered. */
static SurfaceKind Candidate(const Scene *scene, const Particles *p, const Neighbors *nb,
                             const OperatorForms *forms, const PlaneSums *plane, PetscInt i,
                             PetscReal normal[])
{
  Sums      sums;
  PetscReal size = 0.0;

  SumsOf(scene, p, nb, forms, i, &sums);
  for (PetscInt a = 0; a < p->dim; a++) size += PetscSqr(sums.S[a]);
  size = PetscSqrtReal(size);
  for (PetscInt a = 0; a < p->dim; a++) normal[a] = size > 0.0 ? -sums.S[a] / size : a == 0;
  if (sums.close < 3) return SURFACE_ISOLATED;
  if (size < CANDIDATE * plane->S && LeastEigenvalue(p->dim, sums.B) > SPARSE)
    return SURFACE_INSIDE;
  return 1.0 - sums.C < VOID * (1.0 - plane->C) ? SURFACE_SMOOTH : SURFACE_ROUGH;
}

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

/* Sets the planes of walls in which surface particles near particle i have images: none without
   surface tension. */
static void FindMirrors(const Scene *scene, const Particles *p, const FreeSurface *free, PetscInt i,
                        PetscReal R, Mirrors *mirrors)
{
  PetscReal x[ISPH_MAX_DIM];

  mirrors->n = 0;
  if (free->tension == 0.0) return;
  for (PetscInt a = 0; a < p->dim; a++) x[a] = p->x[a][i];
  SceneWallPlanes(scene, x, R, mirrors->plane, &mirrors->n);
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
  return *r2 < 1.0 && aligned > ALIGNED ? PETSC_TRUE : PETSC_FALSE;
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

/* Fits the surface about own particle i in the frame of its normal; sets its new normal, its depth
   and free->curvature. Returns SURFACE_ROUGH if no smooth surface passes there. */
static SurfaceKind FitSurface(const Scene *scene, const Particles *p, const Neighbors *nb,
                              const OperatorForms *forms, const FreeSurface *free, PetscInt i,
                              Fits *fits)
{
  const PetscInt  d = p->dim, terms = d == 2 ? 3 : FIT_TERMS;
  const PetscReal R         = forms->kernel->support * forms->h_over_dx * p->dx[i];
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

/* Copies kinds and normals to the halo. */
static PetscErrorCode Exchange(const Particles *p, FreeSurface *free)
{
  PetscFunctionBegin;
  PetscCall(ParticlesHaloField(p, free->kind));
  PetscCall(ParticlesHaloVectors(p, free->normal));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns true if own particle i, on a smooth surface, is next to a rough one and off walls: beside
   a corner its fit has particles of both sides. */
static PetscBool BesideRough(const Particles *p, const Neighbors *nb, const FreeSurface *free,
                             PetscInt i)
{
  PetscBool beside = PETSC_FALSE;

  if (free->kind[i] != SURFACE_SMOOTH) return PETSC_FALSE;
  for (PetscInt q = nb->row[i]; q < nb->row[i + 1]; q++) {
    const PetscInt j  = nb->col[q];
    PetscReal      r2 = 0.0;

    for (PetscInt a = 0; a < p->dim; a++) r2 += PetscSqr(p->x[a][j] - p->x[a][i]);
    if (ParticlesIsWall(p, j)) {
      if (r2 < PetscSqr(OFF_WALLS * p->dx[i])) return PETSC_FALSE;
    } else if (free->kind[j] == SURFACE_ROUGH && r2 < PetscSqr(BESIDE * p->dx[i])) {
      beside = PETSC_TRUE;
    }
  }
  return beside;
}

/* Returns the mean of the curvatures of own particle i and of surface particles nearby. */
static PetscReal MeanCurvature(const Scene *scene, const Particles *p, const Neighbors *nb,
                               const OperatorForms *forms, const FreeSurface *free, PetscInt i)
{
  const PetscReal R   = forms->kernel->support * forms->h_over_dx * p->dx[i];
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

/*
  Bounds the curvatures of the fits by 1/dx, and replaces them MEANS times by their means over
  surface particles nearby, with the weights of the fit

  Collective. A displacement y of a single particle, such as that of a particle that joins the
  surface where it stretches, changes the curvature of its fit by 0.7 y/dx^2. The means take four
  fifths of it. Rough particles take part: their curvature makes corners round.
*/
static PetscErrorCode AverageCurvature(const Scene *scene, const Particles *p, const Neighbors *nb,
                                       const OperatorForms *forms, FreeSurface *free)
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
      next[i] = FreeSurfaceHolds(free, i) ? MeanCurvature(scene, p, nb, forms, free, i) : 0.0;
    PetscCall(PetscArraycpy(free->curvature, next, p->n_fluid));
  }
  PetscCall(PetscFree(next));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sorts out surface particles after the fits. In the projection a particle below a gap of the
   surface is inside: the pressure of the surface would sink it. In the coupled scheme it stays,
   since an exact equation of mass with neighbours on one side amplifies velocities. A particle
   beside a rough one is rough. */
static PetscErrorCode Sort(const Particles *p, const Neighbors *nb, const PetscReal depth[],
                           FreeSurface *free)
{
  PetscReal *kind;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(p->n_fluid, &kind));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    if (free->gaps && free->kind[i] == SURFACE_SMOOTH && depth[i] > BELOW * p->dx[i])
      free->kind[i] = SURFACE_INSIDE;
  }
  for (PetscInt i = 0; i < p->n_fluid; i++)
    kind[i] = BesideRough(p, nb, free, i) ? SURFACE_ROUGH : free->kind[i];
  PetscCall(PetscArraycpy(free->kind, kind, p->n_fluid));
  PetscCall(ParticlesHaloField(p, free->kind));
  PetscCall(PetscFree(kind));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  FreeSurfaceFind - Finds the particles on free surfaces, their normals and curvatures

  Collective. Input: nb - neighbours at the present positions. Output: free - arrays by local index,
  halo included; curvatures of own particles.
*/
PetscErrorCode FreeSurfaceFind(const Scene *scene, const Particles *p, const Neighbors *nb,
                               const OperatorForms *forms, FreeSurface *free)
{
  const PetscInt d = p->dim, all = ParticlesAll(p);
  PlaneSums      plane;
  Fits           fits;

  PetscFunctionBegin;
  ComputePlane(forms->kernel, d, forms->h, scene->dx, &plane); /* the spacing is uniform */
  if (all > free->capacity) {
    free->capacity = all + all / 8;
    PetscCall(PetscFree3(free->kind, free->normal, free->curvature));
    PetscCall(PetscMalloc3(free->capacity, &free->kind, free->capacity * d, &free->normal,
                           free->capacity, &free->curvature));
  }
  PetscCall(PetscArrayzero(free->kind, all));
  PetscCall(PetscArrayzero(free->normal, all * d));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    free->kind[i]      = Candidate(scene, p, nb, forms, &plane, i, &free->normal[i * d]);
    free->curvature[i] = 0.0;
  }
  PetscCall(Exchange(p, free));
  for (PetscInt i = 0; i < p->n_fluid; i++)
    if (free->kind[i] == SURFACE_SMOOTH && IsCovered(p, nb, free, i))
      free->kind[i] = SURFACE_INSIDE;
  PetscCall(Exchange(p, free));
  PetscCall(PetscMalloc2(p->n_fluid * d, &fits.normal, p->n_fluid, &fits.depth));
  for (PetscInt pass = 0; pass < 2; pass++) {
    PetscCall(PetscArraycpy(fits.normal, free->normal, p->n_fluid * d));
    for (PetscInt i = 0; i < p->n_fluid; i++)
      if (free->kind[i] == SURFACE_SMOOTH || free->kind[i] == SURFACE_ROUGH)
        free->kind[i] = FitSurface(scene, p, nb, forms, free, i, &fits);
    PetscCall(PetscArraycpy(free->normal, fits.normal, p->n_fluid * d));
    PetscCall(Exchange(p, free));
  }
  PetscCall(Sort(p, nb, fits.depth, free));
  if (free->tension > 0.0) PetscCall(AverageCurvature(scene, p, nb, forms, free));
  PetscCall(PetscFree2(fits.normal, fits.depth));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FreeSurfaceFree - Frees the arrays; not collective */
PetscErrorCode FreeSurfaceFree(FreeSurface *free)
{
  PetscFunctionBegin;
  PetscCall(PetscFree3(free->kind, free->normal, free->curvature));
  PetscFunctionReturn(PETSC_SUCCESS);
}
