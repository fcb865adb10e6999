/* Particle concentration and its gradient, for shifting and for the pressure source of -ppe_alpha
   after Zheng, Ma & Shao (2018). */
#include "rows.h"

#define GROUP  64 /* particles whose images are treated together */
#define BEYOND 8  /* points of the integrals of a kernel beyond an opening */

/* Particles of a group, relative to particle i: itself and fluid neighbours. */
typedef struct {
  PetscInt  n;
  PetscReal X[ISPH_MAX_DIM][GROUP], V[GROUP];
} Group;

/* Images of a group that are within the support. */
typedef struct {
  PetscInt  n;
  PetscReal Y[ISPH_MAX_DIM][GROUP], V[GROUP], r[GROUP];
} Images;

/* Computes the images of a group in a combination of mirror planes. No branch depends on a
   distance. */
static ISPH_INLINE void MirrorGroup(PetscInt dim, const Stencil *st, const WallPlane planes[],
                                    PetscInt n_planes, PetscInt set, const Group *group,
                                    Images *images)
{
  images->n = 0;
  for (PetscInt k = 0; k < group->n; k++) {
    const PetscReal X[ISPH_MAX_DIM] = {group->X[0][k], group->X[1][k], group->X[2][k]};
    PetscReal       Y[ISPH_MAX_DIM], r2 = 0.0;

    MirrorImage(dim, n_planes, planes, set, X, Y);
    for (PetscInt a = 0; a < dim; a++) {
      images->Y[a][images->n] = Y[a];
      r2 += PetscSqr(Y[a]);
    }
    images->V[images->n] = group->V[k];
    images->r[images->n] = r2;
    images->n += (r2 < PetscSqr(st->radius)) & (r2 > 0.0) ? 1 : 0;
  }
  for (PetscInt k = 0; k < images->n; k++) images->r[k] = PetscSqrtReal(images->r[k]);
}

/* Adds to concentration and gradient the terms of the images of a group, for every combination of
   mirror planes. */
static void AddImages(const KernelRow *kernel, const Stencil *st, const WallPlane planes[],
                      PetscInt n_planes, const Group *group, PetscReal *concentration,
                      PetscReal gradient[])
{
  for (PetscInt set = 1; set < 1 << n_planes; set++) {
    PetscReal W[GROUP], dW[GROUP], ddW[GROUP];
    Images    images;

    if (st->dim == 2) MirrorGroup(2, st, planes, n_planes, set, group, &images);
    else MirrorGroup(3, st, planes, n_planes, set, group, &images);
    if (!images.n) continue;
    KernelEvaluateAll(kernel, st->dim, st->h, images.n, images.r, W, dW, ddW);
    for (PetscInt k = 0; k < images.n; k++) {
      const PetscReal slope = images.V[k] * dW[k] / images.r[k];

      *concentration += images.V[k] * W[k];
      for (PetscInt a = 0; a < st->dim; a++) gradient[a] -= slope * images.Y[a][k];
    }
  }
}

/* Adds the images of particle i and its fluid neighbours. */
static void ConcentrationImages(const KernelRow *kernel, const Stencil *st,
                                const WallPlane planes[], PetscInt n_planes,
                                PetscReal *concentration, PetscReal gradient[])
{
  Group group = {.n = 1, .V = {st->volume}}; /* particle i */

  for (PetscInt k = 0; k < st->n; k++) {
    for (PetscInt a = 0; a < st->dim; a++) group.X[a][group.n] = st->X[a][k];
    group.V[group.n] = st->V[k];
    group.n += st->wall[k] ? 0 : 1;
    if (group.n < GROUP) continue;
    AddImages(kernel, st, planes, n_planes, &group, concentration, gradient);
    group.n = 0;
  }
  AddImages(kernel, st, planes, n_planes, &group, concentration, gradient);
}

/* Sums the terms of particle i and its neighbours, without wall particles if images stand for them;
   inlined for each dimension. */
static ISPH_INLINE void SumAll(PetscInt d, const Stencil *st, PetscBool mirrored,
                               PetscReal *concentration, PetscReal gradient[])
{
  const PetscInt n     = LanesPadded(st->n);
  Four           total = {0.0}, sum[ISPH_MAX_DIM];

#pragma GCC unroll 3
  for (PetscInt a = 0; a < d; a++) sum[a] = (Four){0.0};
  for (PetscInt k = 0; k < n; k += 4) {
    Four V = *FourAt(st->V + k);

    for (PetscInt l = 0; mirrored && l < 4; l++)
      if (st->wall[k + l]) V[l] = 0.0;
    total += V * *FourAt(st->W + k);
    V *= *FourAt(st->dW + k) / *FourAt(st->r + k);
#pragma GCC unroll 3
    for (PetscInt a = 0; a < d; a++) sum[a] -= V * *FourAt(st->X[a] + k);
  }
  for (PetscInt a = 0; a < d; a++) gradient[a] = FourSum(&sum[a]);
  *concentration = st->volume * st->self[0] + FourSum(&total);
}

static ISPH_WIDE void SumNeighbors(const Stencil *st, PetscBool mirrored, PetscReal *concentration,
                                   PetscReal gradient[])
{
  mirrored = mirrored && st->n_wall;
  if (st->dim == 2) SumAll(2, st, mirrored, concentration, gradient);
  else SumAll(3, st, mirrored, concentration, gradient);
}

/* Finds the mirror planes near particle i; their distances are along stretched axes. Returns their
   number. */
static PetscInt StretchedPlanes(const Scene *scene, const Stencil *st, const PetscReal x[],
                                WallPlane planes[])
{
  PetscReal least = st->stretch[0];
  PetscInt  n     = 0;

  for (PetscInt a = 1; a < st->dim; a++) least = PetscMin(least, st->stretch[a]);
  SceneWallPlanes(scene, x, st->radius / least, planes, &n);
  for (PetscInt k = 0; k < n && SceneIsMapped(scene); k++) { /* normals are along axes */
    for (PetscInt a = 0; a < st->dim; a++)
      if (planes[k].normal[a] != 0.0) planes[k].distance *= st->stretch[a];
  }
  return n;
}

/*
  Adds the fluid beyond an opening, which has no particles: a half space of concentration 1 at the
  distance d along the unit vector -n,

    C += int_{z > d} W dV,   grad C -= n int_{z = d} W dA.

  Images in the side would keep particles in the box, as a wall does, and have whatever
  concentration is there; this fluid lets that of the box neither grow nor fall.
*/
static void AddBeyond(const KernelRow *kernel, const Stencil *st, const WallPlane *plane,
                      PetscReal *concentration, PetscReal gradient[])
{
  const PetscReal d    = PetscMax(plane->distance, 0.0);
  const PetscReal step = PetscSqrtReal(PetscMax(PetscSqr(st->radius) - d * d, 0.0)) / BEYOND;
  PetscReal       s[BEYOND], r[BEYOND], W[BEYOND], dW[BEYOND], ddW[BEYOND], part = 0.0, area = 0.0;

  for (PetscInt k = 0; k < BEYOND; k++) {
    s[k] = (k + 0.5) * step;
    r[k] = PetscSqrtReal(d * d + s[k] * s[k]);
  }
  KernelEvaluateAll(kernel, st->dim, st->h, BEYOND, r, W, dW, ddW);
  for (PetscInt k = 0; k < BEYOND; k++) { /* the shell between r and r + dr, dr = s ds/r */
    const PetscReal ring = st->dim == 2 ? 2.0 * step : 2.0 * PETSC_PI * s[k] * step;
    const PetscReal cap  = st->dim == 2 ? s[k] * PetscAcosReal(d / r[k]) : r[k] - d;

    area += W[k] * ring;
    part += W[k] * ring * cap;
  }
  *concentration += part;
  for (PetscInt a = 0; a < st->dim; a++) gradient[a] -= area * plane->normal[a];
}

/* Takes the openings out of the planes near particle i and adds the fluid beyond them. */
static void AddOpenings(const Scene *scene, const KernelRow *kernel, const Stencil *st,
                        const PetscReal x[], WallPlane planes[], PetscInt *n,
                        PetscReal *concentration, PetscReal gradient[])
{
  PetscInt kept = 0;

  for (PetscInt k = 0; k < *n; k++) {
    if (BoundaryIs(scene, planes[k].side, BOUNDARY_OUTFLOW) ||
        BoundaryIsOpen(scene, planes[k].side, x))
      AddBeyond(kernel, st, &planes[k], concentration, gradient);
    else planes[kept++] = planes[k];
  }
  *n = kept;
}

/*
  ConcentrationRow - Computes the concentration at particle i and its gradient

    C_i = sum_j V_j W_ij,   grad C_i = sum_j V_j grad_i W_ij

  j runs over fluid neighbours, i itself, and the particles that continue the fluid beyond walls:
  mirror images if wall particles lie on the surface, otherwise the dummies: theory.md,
  (particles:concentration). Input: x - position of particle i [m]; mirrored - flag: mirror images,
  not wall particles, represent the fluid beyond walls. Output: concentration - value near 1 [-];
  gradient - [1/m].
*/
void ConcentrationRow(const Scene *scene, const KernelRow *kernel, const Stencil *st,
                      const PetscReal x[], PetscBool mirrored, PetscReal *concentration,
                      PetscReal gradient[])
{
  PetscReal sum[ISPH_MAX_DIM] = {0.0}, stretched = 1.0;
  WallPlane planes[WALL_PLANES];
  PetscInt  n_planes = 0;

  SumNeighbors(st, mirrored, concentration, sum);
  if (mirrored && st->n_wall) n_planes = StretchedPlanes(scene, st, x, planes);
  if (!SceneHasFreeSurface(scene))
    AddOpenings(scene, kernel, st, x, planes, &n_planes, concentration, sum);
  if (n_planes) ConcentrationImages(kernel, st, planes, n_planes, concentration, sum);
  for (PetscInt a = 0; a < st->dim; a++) stretched *= st->stretch[a];
  *concentration *= stretched;
  for (PetscInt a = 0; a < st->dim; a++) gradient[a] = stretched * st->stretch[a] * sum[a];
}
