/*
  The level of the concentration of particles at which the free surface of strain cells is,

    C(x) = sum_j V_j W(|x - x_j|),   C = tau such that the cells have the volume sum_j V_j,

  with mirror images in walls, and how it moves with the particles. Source:
  docs/developers/theory.md, (strain:level), (strain:angle) and (strain:motion).
*/
#include "strain.h"

#define LEVEL_MOST  40   /* steps */
#define SHARE_STEPS 16   /* of a quadrature of the kernel */
#define LEVEL_CLOSE 1e-7 /* error of the volume at which they end, over it */
#define SLOPE_STEP  1e-4 /* of differences of the parts behind walls, over the radius */

/* Returns the kernel of the concentration, wendland_c2, at its centre [1/m^dim]. */
static PetscReal WholeWeight(PetscInt dim, PetscReal R)
{
  return dim == 2 ? 7.0 / PETSC_PI / PetscSqr(R) : 21.0 / (2.0 * PETSC_PI) / (R * R * R);
}

/* Returns it at the distance X. */
static PetscReal WeightAt(PetscInt dim, PetscReal R, const PetscReal X[])
{
  PetscReal r2 = 0.0, q;

  for (PetscInt a = 0; a < dim; a++) r2 += PetscSqr(X[a]);
  q = PetscSqrtReal(r2) / R;
  return q < 1.0 ? WholeWeight(dim, R) * NearestWeight(q) : 0.0;
}

/* Return the integrals of the kernel times q^k from q to 1, over its value at 0. */
static PetscReal Beyond(PetscInt k, PetscReal q)
{
  static const PetscReal c[] = {1.0, 0.0, -10.0, 20.0, -15.0, 4.0};
  PetscReal              sum = 0.0, power = PetscPowRealInt(PetscMin(q, 1.0), (int)k + 1);

  for (PetscInt e = 0; e < 6; e++, power *= PetscMin(q, 1.0))
    sum += c[e] * (1.0 - power) / (PetscReal)(k + e + 1);
  return sum;
}

/*
  Computes the part of the kernel that is behind a wall at the distance z < R, and on the fluid's
  side of a plane through the centre of the kernel that meets the wall at the contact angle; and the
  part behind the wall of what the kernel loses if the surface is curved, and has this angle on the
  wall. Then a surface of uniform curvature, which has the same level everywhere, has it beside the
  wall. Input: contact - cosine of the angle.

    a_0 = int W dV,   a_1 = int (s^2 - 2 s s_0) W ds/int s^2 W ds,   s_0 the way to the wall

  In 3D directions beta turn about the normal of the contact line.
*/
static void PartBehind(PetscInt dim, PetscReal contact, PetscReal z, PetscReal R, PetscReal part[2])
{
  const PetscReal from = z / R, most = PetscAcosReal(from), lean = PetscAsinReal(contact);
  const PetscReal across = (PetscMin(lean, most) + most) / SHARE_STEPS;
  const PetscReal way    = from / PetscMax(PetscCosReal(lean), PETSC_SMALL);
  const PetscReal whole  = dim == 2 ? 7.0 / PETSC_PI : 21.0 / (2.0 * PETSC_PI);
  const PetscInt  n      = dim == 2 ? 1 : SHARE_STEPS;

  part[0] = part[1] = 0.0;
  for (PetscInt m = 0; m < n; m++) {
    const PetscReal step = dim == 2 ? 1.0 : PETSC_PI / n;
    const PetscReal beta = dim == 2 ? 1.0 : PetscSinReal((m + 0.5) * step);

    for (PetscInt k = 0; k < (across > 0.0 ? SHARE_STEPS : 0); k++)
      part[0] += whole * step * across * (dim == 2 ? 1.0 : beta) *
                 Beyond(dim - 1, from / (beta * PetscCosReal((k + 0.5) * across - most)));
    part[1] += step * (Beyond(dim, way / beta) - 2.0 * way * beta * Beyond(dim - 1, way / beta)) /
               ((dim == 2 ? 2.0 : 2.0 * PETSC_PI) * Beyond(dim, 0.0));
  }
}

/* The part of walls in the concentration at a place. */
typedef struct {
  PetscInt  n;
  WallPlane plane[WALL_PLANES], turn[WALL_PLANES]; /* of mirror images; through the place */
  PetscReal behind[2];                             /* sums of a_0 and a_1 of walls with an angle */
} WallsAround;

static void FindWalls(const Scene *scene, PetscReal R, const PetscReal x[], WallsAround *walls)
{
  WallPlane all[WALL_PLANES];
  PetscInt  n = 0;

  walls->n         = 0;
  walls->behind[0] = walls->behind[1] = 0.0;
  if (SceneHas(scene, PHYSICS_WALLS)) SceneWallPlanes(scene, x, R, all, &n);
  for (PetscInt k = 0; k < n; k++) {
    const PetscReal contact = scene->boundary[all[k].side].contact;
    const PetscBool through = BoundaryIs(scene, all[k].side, BOUNDARY_OUTFLOW); /* images follow */
    PetscReal       one[2];

    if (contact == 0.0) {
      walls->plane[walls->n]         = all[k];
      walls->turn[walls->n]          = all[k];
      walls->turn[walls->n].distance = 0.0;
      for (PetscInt a = 0; a < scene->dim && through; a++) walls->turn[walls->n].normal[a] = 0.0;
      walls->n++;
      continue;
    }
    PartBehind(scene->dim, contact, PetscMax(all[k].distance, 0.0), R, one);
    walls->behind[0] += one[0];
    walls->behind[1] += one[1];
  }
}

/* Returns the walls of `walls->plane`, as bits, in which a particle at the offset X from x has a
   mirror image. Beside an edge of a body the plane goes on where the body does not: images fill
   bodies, not the fluid or the void beyond, which the level would enter. Fluid that waits at an
   inflow takes the place of images there. */
static PetscInt ImagesOf(const Scene *scene, const WallsAround *walls, const PetscReal x[],
                         const PetscReal X[])
{
  PetscInt in = 0;

  for (PetscInt k = 0; k < walls->n; k++) {
    const WallPlane *plane = &walls->plane[k];
    const Body      *body  = BoundaryBody(scene, plane->side);
    PetscReal        y[ISPH_MAX_DIM], normal[ISPH_MAX_DIM], height = plane->distance;

    for (PetscInt a = 0; a < scene->dim; a++) height += X[a] * plane->normal[a];
    for (PetscInt a = 0; a < scene->dim; a++) y[a] = x[a] + X[a] - 2.0 * height * plane->normal[a];
    SceneIntoBox(scene, y);
    if (body ? height > 0.0 && BodyDistance(scene, body, y, normal) <= 0.0
             : !BoundaryIsOpen(scene, plane->side, y))
      in |= 1 << k;
  }
  return in;
}

/* StrainWaits - Returns true if fluid enters at wall particle w. Not collective. Output: x - its
   place on the inflow [m]; length - of the fluid there since the last particle [m]. */
PetscBool StrainWaits(const Scene *scene, const Particles *p, PetscInt w, PetscReal x[],
                      PetscReal *length)
{
  if (!p->entered || !ParticlesIsWall(p, w) || p->depth[w] > p->dx[w]) return PETSC_FALSE;
  ParticlesWallPoint(p, w, x);
  *length = p->entered[w];
  return BoundaryOpenPart(scene, (PetscInt)p->side[w], x) > 0.0;
}

/* Sets body m of fluid that particle j stands for: its own or, if it is a wall particle of an
   inflow, the m-th of those that wait there, see openings.c. Returns false past the last. Output:
   X - offset from x [m]; volume [m^dim]. */
static PetscBool BodyOf(const Scene *scene, const Particles *p, PetscInt j, PetscInt m,
                        const PetscReal x[], PetscReal X[], PetscReal *volume)
{
  PetscReal at[ISPH_MAX_DIM] = {0.0}, way;

  if (ParticlesIsWall(p, j)) {
    if (!StrainWaits(scene, p, j, at, &way)) return PETSC_FALSE;
    way -= (m + 0.5) * SceneCellSide(scene, (PetscInt)p->side[j] / 2);
    *volume = p->cell_volume * BoundaryOpenPart(scene, (PetscInt)p->side[j], at);
    for (PetscInt a = 0; a < p->dim; a++) X[a] = at[a] + way * p->normal[a][j] - x[a];
    return way > -LEVEL_REACH * scene->dx;
  }
  for (PetscInt a = 0; a < p->dim; a++) X[a] = p->x[a][j] - x[a];
  *volume = p->volume[j];
  return m == 0;
}

/* Returns the concentration with the parts behind walls. Input: C - with mirror images only. */
static PetscReal WithAngles(const WallsAround *walls, PetscReal C)
{
  return (C + walls->behind[0] - 0.5 * walls->behind[1]) / (1.0 - walls->behind[1]);
}

/* Returns the part of particle j, with its images, in the concentration at x. */
static PetscReal PartOf(const Scene *scene, const Particles *p, const WallsAround *walls,
                        const PetscReal x[], PetscInt j)
{
  PetscReal X[ISPH_MAX_DIM], Y[ISPH_MAX_DIM], volume, sum = 0.0;

  for (PetscInt m = 0; BodyOf(scene, p, j, m, x, X, &volume); m++) {
    const PetscInt in = ImagesOf(scene, walls, x, X);

    for (PetscInt set = 0; set < 1 << walls->n; set++) {
      if (set & ~in) continue;
      MirrorImage(p->dim, walls->n, walls->plane, set, X, Y);
      sum += volume * WeightAt(p->dim, LEVEL_REACH * scene->dx, Y);
    }
  }
  return sum;
}

/* StrainParts - Computes the concentration at a place from the particles around it. Not collective.
   Input: cells - of edge 3 dx at least. Output: list, n - the particles; part - of each, whose sum
   the walls there change to C. */
PetscErrorCode StrainParts(const Scene *scene, const Particles *p, const Cells *cells,
                           const PetscReal x[], PetscInt list[], PetscInt *n, PetscReal part[],
                           PetscReal *C)
{
  const PetscReal R     = LEVEL_REACH * scene->dx;
  PetscReal       whole = 0.0;
  WallsAround     walls;

  PetscFunctionBegin;
  PetscCall(CellsFind(cells, x, R, cells->n, list, n));
  if (*n) FindWalls(scene, R, x, &walls);
  for (PetscInt q = 0; q < *n; q++) {
    part[q] = PartOf(scene, p, &walls, x, list[q]);
    whole += part[q];
  }
  *C = whole > 0.0 ? WithAngles(&walls, whole) : 0.0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the mean of the levels of particles, weighted with their parts. */
static PetscReal MeanLevel(PetscInt n, const PetscInt list[], const PetscReal part[],
                           const PetscReal level[])
{
  PetscReal sum[2] = {0.0};

  for (PetscInt q = 0; q < n; q++) {
    sum[0] += part[q];
    sum[1] += part[q] * level[list[q]];
  }
  return sum[0] > 0.0 ? sum[1] / sum[0] : LEVEL_PLANE;
}

/* StrainExcess - Computes the concentration at a place less its level, the mean of the levels of
   the particles around. Not collective. Input: cells - of edge 3 dx at least; level - by local
   index; list, part - work. */
PetscErrorCode StrainExcess(const Scene *scene, const Particles *p, const Cells *cells,
                            const PetscReal level[], const PetscReal x[], PetscInt list[],
                            PetscReal part[], PetscReal *excess)
{
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(StrainParts(scene, p, cells, x, list, &n, part, excess));
  *excess -= MeanLevel(n, list, part, level);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the derivatives of W at X by X, times f. */
static void AddSlope(PetscInt dim, PetscReal R, const PetscReal X[], PetscReal f, PetscReal slope[])
{
  PetscReal r2 = 0.0, q;

  for (PetscInt a = 0; a < dim; a++) r2 += PetscSqr(X[a]);
  q = PetscSqrtReal(r2) / R;
  if (q >= 1.0) return;
  for (PetscInt a = 0; a < dim; a++)
    slope[a] -= 20.0 * f * WholeWeight(dim, R) * PetscPowRealInt(1.0 - q, 3) * X[a] / (R * R);
}

/* StrainSlopes - Computes the derivatives of the concentration less its level at a place. Not
   collective. Input: cells - of edge 3 dx at least; level - by local index; part - work. Output:
   list, n - particles around; slope - by the place of each, dim numbers [1/m]; gradient - by the
   place itself, for walls at rest [1/m]; value - the part that the particles have. Those of mirror
   images and of the parts behind walls are walls' too. */
PetscErrorCode StrainSlopes(const Scene *scene, const Particles *p, const Cells *cells,
                            const PetscReal level[], const PetscReal x[], PetscInt list[],
                            PetscReal part[], PetscInt *n, PetscReal slope[], PetscReal gradient[],
                            PetscReal *value)
{
  const PetscInt  d = p->dim;
  const PetscReal R = LEVEL_REACH * scene->dx;
  PetscReal       mean, whole = PETSC_MACHINE_EPSILON;
  WallsAround     walls;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < d; a++) gradient[a] = 0.0;
  PetscCall(StrainParts(scene, p, cells, x, list, n, part, value));
  FindWalls(scene, R, x, &walls);
  mean = MeanLevel(*n, list, part, level);
  for (PetscInt q = 0; q < *n; q++) whole += part[q];
  for (PetscInt q = 0; q < *n; q++) {
    const PetscReal f = 1.0 / (1.0 - walls.behind[1]) - (level[list[q]] - mean) / whole;
    PetscReal       X[ISPH_MAX_DIM], Y[ISPH_MAX_DIM], of[ISPH_MAX_DIM], volume;

    for (PetscInt a = 0; a < d; a++) slope[q * d + a] = 0.0;
    for (PetscInt m = 0; BodyOf(scene, p, list[q], m, x, X, &volume); m++) {
      const PetscInt in = ImagesOf(scene, &walls, x, X);

      for (PetscInt set = 0; set < 1 << walls.n; set++) {
        PetscReal by[ISPH_MAX_DIM] = {0.0};

        if (set & ~in) continue;
        MirrorImage(d, walls.n, walls.plane, set, X, Y);
        AddSlope(d, R, Y, volume * f, by);
        MirrorImage(d, walls.n, walls.turn, set, by, of);
        for (PetscInt a = 0; a < d; a++) gradient[a] -= by[a];
        for (PetscInt a = 0; a < d; a++) slope[q * d + a] += of[a];
      }
    }
  }
  *value = whole / (1.0 - walls.behind[1]);
  for (PetscInt k = 0; k < 2 * d && walls.behind[0] != 0.0; k++) { /* C with the walls elsewhere */
    const PetscReal step = k % 2 ? SLOPE_STEP * R : -SLOPE_STEP * R;
    PetscReal       y[ISPH_MAX_DIM];
    WallsAround     there;

    for (PetscInt a = 0; a < d; a++) y[a] = x[a] + (a == k / 2 ? step : 0.0);
    FindWalls(scene, R, y, &there);
    gradient[k / 2] += WithAngles(&there, whole) / (2.0 * step);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* StrainLevels - Finds levels between two bounds at which the cells of all ranks have the volumes
   of the particles, by false position in all of them at once. Collective. Input: n - pieces of the
   fluid; own - volumes of this rank's particles; Volumes - of this rank's cells at levels, each of
   which falls with its own. Output: level. */
PetscErrorCode StrainLevels(const Particles *p, PetscInt n, const PetscReal own[], PetscReal low,
                            PetscReal high, StrainVolumesAt Volumes, void *ctx, PetscReal level[])
{
  const PetscReal end[] = {low, high};
  PetscReal      *at[2], *off[2], *now, *wanted, whole = 0.0, worst = PETSC_INFINITY;
  PetscInt       *last; /* the end that has moved; -1: none, -2: no level has the volume */

  PetscFunctionBegin;
  PetscCall(
      PetscMalloc7(n, &at[0], n, &at[1], n, &off[0], n, &off[1], n, &now, n, &wanted, n, &last));
  PetscCallMPI(MPI_Allreduce(own, wanted, (int)n, MPIU_REAL, MPIU_SUM, p->comm));
  for (PetscInt e = 0; e < 2; e++) {
    for (PetscInt k = 0; k < n; k++) level[k] = at[e][k] = end[e];
    PetscCall(Volumes(ctx, level, off[e]));
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, off[e], (int)n, MPIU_REAL, MPIU_SUM, p->comm));
  }
  for (PetscInt k = 0; k < n; k++) {
    whole += wanted[k];
    off[0][k] -= wanted[k];
    off[1][k] -= wanted[k];
    last[k]  = off[0][k] > 0.0 && off[1][k] < 0.0 ? -1 : -2;
    level[k] = off[0][k] <= 0.0 ? low : high;
  }
  for (PetscInt step = 0; step < LEVEL_MOST && worst > LEVEL_CLOSE * whole; step++) {
    worst = 0.0;
    for (PetscInt k = 0; k < n; k++)
      if (last[k] > -2)
        level[k] = (off[0][k] * at[1][k] - off[1][k] * at[0][k]) / (off[0][k] - off[1][k]);
    PetscCall(Volumes(ctx, level, now));
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, now, (int)n, MPIU_REAL, MPIU_SUM, p->comm));
    for (PetscInt k = 0; k < n; k++) {
      const PetscInt e = now[k] > wanted[k] ? 0 : 1;

      if (last[k] == -2) continue;
      worst = PetscMax(worst, PetscAbsReal(now[k] - wanted[k]));
      if (e == last[k]) off[1 - e][k] *= 0.5; /* Illinois: an end must not stay for ever */
      at[e][k]  = level[k];
      off[e][k] = now[k] - wanted[k];
      last[k]   = e;
    }
  }
  PetscCall(PetscFree7(at[0], at[1], off[0], off[1], now, wanted, last));
  PetscFunctionReturn(PETSC_SUCCESS);
}
