/*
  Particle concentration and its gradient, for shifting and for the pressure source of -ppe_alpha
  after Zheng, Ma & Shao (2018).
*/
#include "rows.h"

/* Adds to concentration and gradient the terms of a particle's mirror images, for every combination
   of mirror planes; X is the position of this particle relative to particle i. */
static void ConcentrationImages(const KernelRow *kernel, const Stencil *st,
                                const WallPlane planes[], PetscInt n_planes, const PetscReal X[],
                                PetscReal volume, PetscReal *concentration, PetscReal gradient[])
{
  for (PetscInt set = 1; set < 1 << n_planes; set++) {
    PetscReal Y[ISPH_MAX_DIM], r2 = 0.0, r, w[3];

    MirrorImage(st->dim, n_planes, planes, set, X, Y);
    for (PetscInt a = 0; a < st->dim; a++) r2 += PetscSqr(Y[a]);
    if (r2 >= PetscSqr(st->radius) || r2 == 0.0) continue;
    r = PetscSqrtReal(r2);
    KernelEvaluate(kernel, st->dim, st->h, r, w);
    *concentration += volume * w[0];
    for (PetscInt a = 0; a < st->dim; a++) gradient[a] -= volume * w[1] * Y[a] / r;
  }
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
  mirrored = mirrored && st->n_wall ? PETSC_TRUE : PETSC_FALSE;
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

/* Adds the plane half a spacing outside the nearest particle on a free surface, in which the fluid
   is mirrored as in a wall. */
static void AddSurfacePlane(const Stencil *st, WallPlane planes[], PetscInt *n)
{
  PetscReal nearest = st->kind == SURFACE_SMOOTH ? 0.0 : st->radius;
  PetscInt  which   = -1;

  if (!st->near_surface || *n == SCENE_MAX_BOUNDARIES) return;
  for (PetscInt k = 0; k < st->n; k++) {
    if (!st->surface[k] || st->r[k] >= nearest) continue;
    nearest = st->r[k];
    which   = k;
  }
  planes[*n].distance = 0.5 * st->dx;
  for (PetscInt a = 0; a < st->dim; a++) {
    const PetscReal normal = which < 0 ? st->own_normal[a] : st->normal[a][which];

    planes[*n].normal[a] = -normal;
    if (which >= 0) planes[*n].distance += st->X[a][which] * normal;
  }
  (*n)++;
}

/*
  ConcentrationRow - Computes the concentration at particle i and its gradient

    C_i = sum_j V_j W_ij,   grad C_i = sum_j V_j grad_i W_ij

  j runs over fluid neighbours, i itself, and the particles that continue the fluid beyond walls:
  mirror images if wall particles lie on the surface, otherwise the dummies: docs/theory.md, (10).
  Mirror images continue it beyond free surfaces too.

  Not collective.

  Input Parameters:
+ x        - position of particle i [m]
- mirrored - flag: mirror images, not wall particles, represent the fluid beyond walls

  Output Parameters:
+ concentration - value near 1 [-]
- gradient      - [1/m]
*/
void ConcentrationRow(const Scene *scene, const KernelRow *kernel, const Stencil *st,
                      const PetscReal x[], PetscBool mirrored, PetscReal *concentration,
                      PetscReal gradient[])
{
  const PetscReal origin[ISPH_MAX_DIM] = {0.0};
  PetscReal       sum[ISPH_MAX_DIM] = {0.0}, stretched = 1.0;
  WallPlane       planes[SCENE_MAX_BOUNDARIES];
  PetscInt        n_planes = 0;

  SumNeighbors(st, mirrored, concentration, sum);
  if (mirrored && st->n_wall) n_planes = StretchedPlanes(scene, st, x, planes);
  AddSurfacePlane(st, planes, &n_planes);
  if (n_planes) {
    ConcentrationImages(kernel, st, planes, n_planes, origin, st->volume, concentration, sum);
    for (PetscInt k = 0; k < st->n; k++) {
      PetscReal X[ISPH_MAX_DIM];

      if (st->wall[k]) continue;
      for (PetscInt a = 0; a < st->dim; a++) X[a] = st->X[a][k];
      ConcentrationImages(kernel, st, planes, n_planes, X, st->V[k], concentration, sum);
    }
  }
  for (PetscInt a = 0; a < st->dim; a++) stretched *= st->stretch[a];
  *concentration *= stretched;
  for (PetscInt a = 0; a < st->dim; a++) gradient[a] = stretched * st->stretch[a] * sum[a];
}
