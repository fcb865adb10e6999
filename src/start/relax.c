/*
  Relaxation of particles whose spacing is a function of place. Pairs repel each other, in distances
  relative to their spacings, until the particles are evenly spread:

    v_i <- B v_i + A sum_j (s_ij/dx_i)^(d-1) f(r_ij/s_ij) (x_i - x_j)/r_ij,   x_i <- x_i + dx_i v_i,
    s_ij = (dx_i + dx_j)/2,   f(q) = (1 - q/Q)^2 for q < Q

  The factor (s_ij/dx_i)^(d-1) makes the stress of a cloud uniform if r_ij/s_ij is: the cloud comes
  to rest with the wanted spacing. Walls act by mirror images of the particles. Sums are whole
  numbers, so places do not depend on the number of ranks.

  Reference: B. Fornberg, N. Flyer, Comput. Math. Appl. 69 (2015) 531-544
*/
#include "start.h"

#define STEPS     100  /* as even as 400 steps with B = 0 */
#define RANGE     1.8  /* Q: range of the repulsion [spacings] */
#define RATE      0.5  /* A */
#define MEMORY    0.9  /* B */
#define STEP_MOST 0.15 /* largest displacement along an axis in a step [dx_i] */
#define CLEARANCE 0.3  /* least distance from walls [dx_i] */
#define UNIT      1e15 /* of sums in whole numbers */

/* Sums of the displacement of a particle [1/UNIT]. */
typedef struct {
  PetscInt64 d[ISPH_MAX_DIM];
} Push;

/* Adds the repulsion by a particle of spacing dx at the distance X = x_i - x_j. */
static void AddPush(PetscInt dim, const PetscReal X[], PetscReal own, PetscReal dx, Push *push)
{
  const PetscReal s = 0.5 * (own + dx), weight = dim == 3 ? PetscSqr(s / own) : s / own;
  PetscReal       r2 = 0.0, r, f;

  for (PetscInt a = 0; a < dim; a++) r2 += X[a] * X[a];
  if (r2 >= PetscSqr(RANGE * s) || r2 == 0.0) return;
  r = PetscSqrtReal(r2);
  f = weight * PetscSqr(1.0 - r / (RANGE * s)) / r;
  for (PetscInt a = 0; a < dim; a++) push->d[a] += (PetscInt64)(UNIT * f * X[a]);
}

/* Adds the repulsion by the mirror image, in a plane at the distance d from particle i, of a
   particle at the distance X = x_i - x_j. */
static void AddImage(PetscInt dim, const WallPlane *plane, const PetscReal X[], PetscReal own,
                     PetscReal dx, Push *push)
{
  PetscReal height = plane->distance, Y[ISPH_MAX_DIM];

  for (PetscInt a = 0; a < dim; a++) height -= plane->normal[a] * X[a];
  for (PetscInt a = 0; a < dim; a++) Y[a] = X[a] + 2.0 * height * plane->normal[a];
  AddPush(dim, Y, own, dx, push);
}

/* Adds the plane of the free border of the filled region that is deepest at x. */
static void AddBorder(const Scene *scene, const PetscReal x[], PetscReal reach, WallPlane planes[],
                      PetscInt *n)
{
  PetscReal most = -PETSC_INFINITY, normal[ISPH_MAX_DIM] = {0.0};

  if (!scene->n_filled) return;
  for (PetscInt k = 0; k < scene->n_filled; k++) {
    PetscReal       out[ISPH_MAX_DIM];
    const PetscReal depth = -BodyDistance(scene, &scene->filled[k], x, out);

    if (depth <= most) continue;
    most = depth;
    for (PetscInt a = 0; a < scene->dim; a++) normal[a] = out[a];
  }
  if (most >= reach || *n == WALL_PLANES) return;
  for (PetscInt k = 0; k < *n; k++)
    if (PetscAbsReal(planes[k].distance - most) < 1e-6 * scene->dx) return; /* a wall is there */
  planes[*n].distance = most;
  for (PetscInt a = 0; a < scene->dim; a++) planes[*n].normal[a] = -normal[a];
  (*n)++;
}

/* Computes the displacement v of fluid particle i in a step [dx_i], which is stored as its
   velocity. */
static void PushOf(const Scene *scene, Particles *p, const Neighbors *nb, PetscInt i)
{
  WallPlane       planes[WALL_PLANES];
  const PetscReal zero[ISPH_MAX_DIM] = {0.0};
  PetscReal       x[ISPH_MAX_DIM];
  PetscInt        n_planes;
  Push            push = {{0}};

  for (PetscInt a = 0; a < p->dim; a++) x[a] = p->x[a][i];
  SceneWallPlanes(scene, x, RANGE * p->dx[i], planes, &n_planes);
  AddBorder(scene, x, RANGE * p->dx[i], planes, &n_planes);
  for (PetscInt k = 0; k < n_planes; k++)
    AddImage(p->dim, &planes[k], zero, p->dx[i], p->dx[i], &push);
  for (PetscInt l = nb->row[i]; l < nb->row[i + 1]; l++) {
    const PetscInt j = nb->col[l];
    PetscReal      X[ISPH_MAX_DIM];

    if (ParticlesIsWall(p, j)) continue;
    for (PetscInt a = 0; a < p->dim; a++) X[a] = x[a] - p->x[a][j];
    AddPush(p->dim, X, p->dx[i], p->dx[j], &push);
    for (PetscInt k = 0; k < n_planes; k++)
      AddImage(p->dim, &planes[k], X, p->dx[i], p->dx[j], &push);
  }
  for (PetscInt a = 0; a < p->dim; a++) {
    const PetscReal d = MEMORY * p->u[a][i] + RATE * ((PetscReal)push.d[a] / UNIT);

    p->u[a][i] = PetscMin(PetscMax(d, -STEP_MOST), STEP_MOST);
  }
}

/* Makes a step of the relaxation. Particles of ordered rows, whose ids are below `ordered`, stay.
   Output: largest - displacement of any particle along an axis [m]. */
static PetscErrorCode Step(const Scene *scene, const Cloud *cloud, Particles *p, Neighbors *nb,
                           PetscReal *largest)
{
  const PetscInt64 ordered = cloud->ordered;
  PetscReal        most    = 0.0;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    if (p->id[i] >= ordered) PushOf(scene, p, nb, i);
  }
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscReal x[ISPH_MAX_DIM] = {0.0};

    if (p->id[i] < ordered) continue;
    for (PetscInt a = 0; a < p->dim; a++) {
      most = PetscMax(most, p->dx[i] * PetscAbsReal(p->u[a][i]));
      x[a] = p->x[a][i] + p->dx[i] * p->u[a][i];
    }
    SceneKeepOffWalls(scene, 0.0, CLEARANCE * p->dx[i], x);
    for (PetscInt a = 0; a < p->dim; a++) p->x[a][i] = x[a];
    p->dx[i] = SceneSpacing(scene, x);
  }
  PetscCallMPI(MPI_Allreduce(&most, largest, 1, MPIU_REAL, MPIU_MAX, p->comm));
  PetscCall(ParticlesUpdateEpoch(scene, p, PETSC_FALSE, NULL));
  PetscCall(ParticlesUpdateHalo(p));
  PetscCall(ParticlesHaloField(p, p->dx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* CloudRelax - Spreads the fluid evenly, with the wanted spacing. Collective. The particles are in
   an epoch; their owners and order change. Volumes do not change. Velocities are used for v and are
   zero afterwards. */
PetscErrorCode CloudRelax(const Scene *scene, const Cloud *cloud, Particles *p)
{
  const PetscReal coarsest = SceneCoarsest(scene), width = p->halo_width;
  PetscReal       largest = coarsest;
  Neighbors      *nb;

  PetscFunctionBegin;
  if (RANGE * coarsest > width) {
    p->halo_width = RANGE * coarsest;
    PetscCall(ParticlesUpdateEpoch(scene, p, PETSC_TRUE, NULL));
  }
  PetscCall(NeighborsCreate(RANGE * coarsest, coarsest, &nb));
  for (PetscInt step = 0; step < STEPS; step++) {
    PetscCall(NeighborsUpdate(p, largest, nb));
    PetscCall(Step(scene, cloud, p, nb, &largest));
  }
  for (PetscInt a = 0; a < p->dim; a++) PetscCall(PetscArrayzero(p->u[a], p->n_fluid));
  PetscCall(NeighborsDestroy(&nb));
  p->halo_width = width;
  PetscFunctionReturn(PETSC_SUCCESS);
}
