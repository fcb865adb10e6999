/*
  Particles on free surfaces, their normals and curvatures, from the present positions. Sums over
  neighbours tell where fluid is missing,

    S = sum_j V_j grad_i W_ij,   B = sum_j V_j X (x) grad_i W_ij,   X = x_j - x_i,

  S vanishes and B is the unit matrix inside the fluid; walls act by mirror images. A candidate is
  on the surface if no neighbour is in the cone about n_0 = -S/|S|, or if the concentration
  sum_j V_j W_ij lacks nearly as much as on a plane surface. Normals n are those of a quadratic fit
  through the surface particles nearby, in the frame of n_0:

    y.n_0 = a + b_m s_m + c_mq s_m s_q,   n = (n_0 - b_m t_m)/|..|,   s_m = y.t_m

  A normal from S has an error on disordered particles that does not fall with dx, and so has the
  stress that a row with this normal gives to the fluid.

  Reference: S. Marrone, A. Colagrossi, D. Le Touze, G. Graziani, J. Comput. Phys. 229 (2010)
  3652-3663
*/
#include "surfacefits.h"

#define CANDIDATE   0.35 /* least |S| over its value dx/2 below a plane */
#define SPARSE      0.3  /* least eigenvalue of B below which a particle is a candidate */
#define VOID        0.7  /* least 1 - C over its value there of a particle that is on the surface */
#define CONE        0.743 /* cosine of half the angle of the cone, 42 degrees */
#define CONE_LENGTH 2.0   /* [dx] */
#define LONG_CONE   3.0   /* beside openings [dx] */
#define BESIDE      1.2   /* distance to a rough particle at which a surface is rough too [dx] */
#define OFF_WALLS   2.0   /* distance from wall particles from which on this holds [dx] */
#define BELOW       0.15  /* depth below the fit from which on a particle is inside [dx] */
#define SURFACE_WORK                                                                               \
  3.0 /* of a particle on a surface beyond one inside: docs/howto/many-ranks.md [-] */

/* Neighbours of a particle and their images in walls. */
typedef struct {
  PetscReal S[ISPH_MAX_DIM], B[ISPH_MAX_DIM * ISPH_MAX_DIM], C; /* C: concentration */
  PetscInt  close;
} Sums;

/* The sums at the distance dx/2 from the plane that bounds a half-space of fluid. */
typedef struct {
  PetscReal S, C;
} PlaneSums;

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
                   const KernelSize *kernel, PetscInt i, Sums *sums)
{
  const PetscReal h = kernel->h_over_dx * p->dx[i];
  const PetscInt  d = p->dim;
  WallPlane       planes[WALL_PLANES];
  PetscReal       x[ISPH_MAX_DIM];
  PetscInt        n_planes;

  *sums = (Sums){.close = 0};
  for (PetscInt a = 0; a < d; a++) x[a] = p->x[a][i];
  SceneWallPlanes(scene, x, kernel->radius, planes, &n_planes);
  for (PetscInt q = nb->row[i] - 1; q < nb->row[i + 1]; q++) {
    const PetscInt j  = q < nb->row[i] ? i : nb->col[q];
    PetscReal      r2 = 0.0, X[ISPH_MAX_DIM];

    if (ParticlesIsWall(p, j)) continue;
    for (PetscInt a = 0; a < d; a++) {
      X[a] = p->x[a][j] - x[a];
      r2 += PetscSqr(X[a]);
    }
    if (r2 > 0.0 && r2 < PetscSqr(SurfaceReach(p, nb, i, SURFACE_CLOSE))) sums->close++;
    AddNeighbour(kernel->row, d, h, p->volume[j], X, sums);
    for (PetscInt set = 1; set < 1 << n_planes; set++) {
      PetscReal Y[ISPH_MAX_DIM];

      MirrorImage(d, n_planes, planes, set, X, Y);
      AddNeighbour(kernel->row, d, h, p->volume[j], Y, sums);
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

/* Returns true if a neighbour of own particle i covers it: it is in the cone about the normal. The
   cone is longer beside openings, where rows of particles leave gaps. An isolated particle covers
   nothing. */
static PetscBool IsCovered(const Scene *scene, const Particles *p, const Neighbors *nb,
                           const FreeSurface *free, PetscInt i)
{
  const PetscReal *normal = &free->normal[i * p->dim];
  const PetscReal  length = FreeSurfaceOpenings(scene, p, nb, i) ? LONG_CONE : CONE_LENGTH;

  for (PetscInt q = nb->row[i]; q < nb->row[i + 1]; q++) {
    const PetscInt j  = nb->col[q];
    PetscReal      r2 = 0.0, along = 0.0;

    for (PetscInt a = 0; a < p->dim; a++) {
      const PetscReal X = p->x[a][j] - p->x[a][i];

      r2 += PetscSqr(X);
      along += X * normal[a];
    }
    if (r2 == 0.0 || r2 >= PetscSqr(SurfaceReach(p, nb, i, length))) continue;
    if (along <= CONE * PetscSqrtReal(r2)) continue;
    if (ParticlesIsWall(p, j) ? FreeSurfaceIsCoveredBy(scene, p, nb, i, j, normal)
                              : free->kind[j] != SURFACE_ISOLATED)
      return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Determines if own particle i can be on the surface, and its first normal: SMOOTH is a candidate,
   ROUGH is on the surface even if it is covered. */
static SurfaceKind CandidateKind(const Scene *scene, const Particles *p, const Neighbors *nb,
                                 const KernelSize *kernel, const PlaneSums *plane, PetscInt i,
                                 PetscReal normal[])
{
  const PetscInt openings = FreeSurfaceOpenings(scene, p, nb, i);
  Sums           sums;
  PetscReal      size = 0.0;

  SumsOf(scene, p, nb, kernel, i, &sums);
  if (openings) FreeSurfaceFillOpenings(scene, p, nb, i, sums.S);
  for (PetscInt a = 0; a < p->dim; a++) size += PetscSqr(sums.S[a]);
  size = PetscSqrtReal(size);
  for (PetscInt a = 0; a < p->dim; a++) normal[a] = size > 0.0 ? -sums.S[a] / size : a == 0;
  if (sums.close + openings < 3) return SURFACE_ISOLATED;
  if (size < CANDIDATE * plane->S && LeastEigenvalue(p->dim, sums.B) > SPARSE)
    return SURFACE_INSIDE;
  return openings || 1.0 - sums.C < VOID * (1.0 - plane->C) ? SURFACE_SMOOTH : SURFACE_ROUGH;
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
    const PetscInt  j  = nb->col[q];
    const PetscReal r2 = ParticlesSquareDistance(p, i, j);

    if (ParticlesIsWall(p, j)) {
      if (r2 < PetscSqr(SurfaceReach(p, nb, i, OFF_WALLS))) return PETSC_FALSE;
    } else if (free->kind[j] == SURFACE_ROUGH && r2 < PetscSqr(SurfaceReach(p, nb, i, BESIDE))) {
      beside = PETSC_TRUE;
    }
  }
  return beside;
}

/* Sorts out surface particles after the fits. Particles in noses are rough, and so are particles
   beside a rough one. A particle below a gap of the surface is inside: the pressure of the surface
   would sink it. With pair forces everywhere it stays on the surface: an equation of mass there
   stiffens thin jets, which then do not fold. */
static PetscErrorCode ClassifyParticles(const Scene *scene, const Particles *p, const Neighbors *nb,
                                        const PetscReal depth[], FreeSurface *free)
{
  PetscReal *kind;

  PetscFunctionBegin;
  PetscCall(FreeSurfaceFindNoses(scene, p, nb, free));
  PetscCall(ParticlesHaloField(p, free->kind)); /* rough particles of noses on other ranks */
  for (PetscInt i = 0; free->fitted && i < p->n_fluid; i++) {
    if (free->kind[i] == SURFACE_SMOOTH && depth[i] > BELOW * p->dx[i])
      free->kind[i] = SURFACE_INSIDE;
  }
  PetscCall(PetscMalloc1(p->n_fluid, &kind));
  for (PetscInt i = 0; i < p->n_fluid; i++)
    kind[i] = BesideRough(p, nb, free, i) ? SURFACE_ROUGH : free->kind[i];
  PetscCall(PetscArraycpy(free->kind, kind, p->n_fluid));
  PetscCall(ParticlesHaloField(p, free->kind));
  PetscCall(PetscFree(kind));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds out if a particle of any rank is on the surface, and if any is rough or paired: steps
   without them exchange no velocities for pair forces. Sets the work of particles. */
static PetscErrorCode FindOnAnyRank(const Particles *p, FreeSurface *free)
{
  PetscMPIInt any[2] = {0, 0};

  PetscFunctionBegin;
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    if (p->work) p->work[i] = FreeSurfaceHolds(free, i) ? SURFACE_WORK : 0.0;
    if (FreeSurfaceHolds(free, i)) any[0] = 1;
    if (FreeSurfaceIsRough(free, i) || FreeSurfaceIsPaired(free, i)) any[1] = 1;
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, any, 2, MPI_INT, MPI_MAX, p->comm));
  free->exists    = any[0] ? PETSC_TRUE : PETSC_FALSE;
  free->has_rough = any[1] ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FreeSurfaceFind - Finds the particles on free surfaces, their normals and curvatures. Collective.
   Input: nb - neighbours at the present positions. Output: free - arrays by local index, halo
   included; curvatures of own particles. */
PetscErrorCode FreeSurfaceFind(const Scene *scene, const Particles *p, const Neighbors *nb,
                               const KernelSize *kernel, FreeSurface *free)
{
  const PetscInt d = p->dim, all = ParticlesAll(p);
  PlaneSums      plane;
  SurfaceFits    fits;

  PetscFunctionBegin;
  ComputePlane(kernel->row, d, kernel->h, scene->dx, &plane); /* the spacing is uniform */
  if (all > free->capacity) {
    free->capacity = all + all / 8;
    PetscCall(PetscFree4(free->kind, free->normal, free->curvature, free->at_contact_line));
    PetscCall(PetscMalloc4(free->capacity, &free->kind, free->capacity * d, &free->normal,
                           free->capacity, &free->curvature, free->capacity,
                           &free->at_contact_line));
  }
  PetscCall(PetscArrayzero(free->kind, all));
  PetscCall(PetscArrayzero(free->normal, all * d));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    free->kind[i]      = CandidateKind(scene, p, nb, kernel, &plane, i, &free->normal[i * d]);
    free->curvature[i] = 0.0;
  }
  PetscCall(Exchange(p, free));
  for (PetscInt i = 0; i < p->n_fluid; i++)
    if (free->kind[i] == SURFACE_SMOOTH && IsCovered(scene, p, nb, free, i))
      free->kind[i] = SURFACE_INSIDE;
  PetscCall(Exchange(p, free));
  PetscCall(PetscMalloc2(p->n_fluid * d, &fits.normal, p->n_fluid, &fits.depth));
  for (PetscInt pass = 0; pass < 2; pass++) {
    PetscCall(PetscArraycpy(fits.normal, free->normal, p->n_fluid * d));
    for (PetscInt i = 0; i < p->n_fluid; i++)
      if (free->kind[i] == SURFACE_SMOOTH || free->kind[i] == SURFACE_ROUGH)
        free->kind[i] = SurfaceFitAt(scene, p, nb, kernel, free, i, &fits);
    PetscCall(PetscArraycpy(free->normal, fits.normal, p->n_fluid * d));
    PetscCall(Exchange(p, free));
  }
  PetscCall(ClassifyParticles(scene, p, nb, fits.depth, free));
  PetscCall(FindOnAnyRank(p, free));
  if (free->tension > 0.0) PetscCall(SurfaceAverageCurvature(scene, p, nb, kernel, free));
  PetscCall(PetscFree2(fits.normal, fits.depth));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FreeSurfaceFree - Frees the arrays; not collective */
PetscErrorCode FreeSurfaceFree(FreeSurface *free)
{
  PetscFunctionBegin;
  PetscCall(PetscFree4(free->kind, free->normal, free->curvature, free->at_contact_line));
  PetscFunctionReturn(PETSC_SUCCESS);
}
