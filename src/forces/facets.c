/* Facets: pieces of a wall or of a section, about dx wide, over which forces and fluxes are sums.
   The parts of a facet count that are not buried in other boundaries and, in flows with a free
   surface, wet. A film has few particles across: with facets that are wet or dry as a whole its
   flux would jump by a third, and the weight of fluid over a chamfer by a tenth. */
#include "isph/forces.h"

/* Parts of a facet along each direction, wet or dry. */
#define PARTS_2D 16
#define PARTS_3D 4
/* The same, buried or not. */
#define BURIED_2D 128
#define BURIED_3D 16

static PetscErrorCode FacetsCreate(PetscInt dim, PetscInt n, Facets *f)
{
  PetscFunctionBegin;
  *f = (Facets){.n = n, .dim = dim, .whole = 0.0};
  PetscCall(PetscMalloc3(n * dim, &f->x, n * dim, &f->normal, n, &f->area));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FacetsFree - Frees facets; not collective */
PetscErrorCode FacetsFree(Facets *f)
{
  PetscFunctionBegin;
  PetscCall(PetscFree3(f->x, f->normal, f->area));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FacetsCopy - Copies facet k to the place `to`, which is not behind it; not collective */
void FacetsCopy(PetscInt k, PetscInt to, Facets *f)
{
  for (PetscInt a = 0; a < f->dim; a++) {
    f->x[to * f->dim + a]      = f->x[k * f->dim + a];
    f->normal[to * f->dim + a] = f->normal[k * f->dim + a];
  }
  f->area[to] = f->area[k];
}

/* Sets the facets of a side of the box to the lattice cells on it. */
static void SetSide(const Scene *scene, PetscInt side, Facets *f)
{
  const PetscInt axis = side / 2, dim = scene->dim;

  for (PetscInt k = 0; k < f->n; k++) {
    PetscReal edge[ISPH_MAX_DIM];
    PetscInt  index = k;

    f->area[k] = 1.0;
    for (PetscInt a = 0; a < dim; a++) {
      f->normal[k * dim + a] = a == axis ? (side % 2 ? -1.0 : 1.0) : 0.0;
      f->x[k * dim + a]      = side % 2 ? scene->hi[a] : scene->lo[a];
      if (a == axis) continue;
      f->x[k * dim + a] = SceneLatticePlace(scene, a, index % scene->cells[a] + 0.5);
      index /= scene->cells[a];
    }
    SceneEdges(scene, &f->x[k * dim], edge);
    for (PetscInt a = 0; a < dim; a++) f->area[k] *= a == axis ? 1.0 : edge[a];
  }
}

/* Sets x to the middles of n parts along each direction of a facet, which is taken as a square, or
   as a part of equal shape of a piece of a section. */
static void SetParts(const Facets *f, PetscInt k, PetscInt n, PetscReal x[])
{
  const PetscInt  dim = f->dim, parts = dim == 2 ? n : n * n;
  const PetscReal share = f->whole > 0.0 ? f->area[k] / f->whole : f->area[k];
  const PetscReal edge  = dim == 2 ? share : PetscSqrtReal(share);
  PetscReal       t[2][ISPH_MAX_DIM];

  (void)SurfaceTangents(dim, &f->normal[k * dim], t);
  for (PetscInt a = 0; f->whole > 0.0 && a < 2 * ISPH_MAX_DIM; a++)
    t[a / ISPH_MAX_DIM][a % ISPH_MAX_DIM] = f->edge[a / ISPH_MAX_DIM][a % ISPH_MAX_DIM];
  for (PetscInt q = 0; q < parts; q++) {
    for (PetscInt a = 0; a < dim; a++) {
      x[q * dim + a] = f->x[k * dim + a] + ((q % n + 0.5) / n - 0.5) * edge * t[0][a];
      if (dim == 3) x[q * dim + a] += ((q / n + 0.5) / n - 0.5) * edge * t[1][a];
    }
  }
}

/* Reduces facet k to its parts that are not `out`, and copies it to the place `to` if it has any.
   Returns true if so. */
static PetscBool KeepParts(PetscInt k, PetscInt parts, const PetscReal x[], const PetscBool out[],
                           PetscInt to, Facets *f)
{
  PetscReal middle[ISPH_MAX_DIM] = {0.0};
  PetscInt  kept                 = 0;

  for (PetscInt q = 0; q < parts; q++) {
    if (out[q]) continue;
    kept++;
    for (PetscInt a = 0; a < f->dim; a++) middle[a] += x[q * f->dim + a];
  }
  if (kept == 0) return PETSC_FALSE;
  for (PetscInt a = 0; kept < parts && a < f->dim; a++) f->x[k * f->dim + a] = middle[a] / kept;
  f->area[k] *= (PetscReal)kept / parts;
  FacetsCopy(k, to, f);
  return PETSC_TRUE;
}

/* Returns true if x, on boundary `side` or in the fluid if it is negative, is in the solid of
   another boundary. */
static PetscBool IsBuried(const Scene *scene, PetscInt side, const PetscReal x[])
{
  PetscReal normal[ISPH_MAX_DIM];
  PetscInt  nearest;

  return side < 0 ? SceneDistance(scene, x, &nearest, normal) < 0.0 : SceneIsBuried(scene, side, x);
}

/* Returns true if x is within a distance of a boundary other than `side`. */
static PetscBool IsNearOthers(const Scene *scene, PetscInt side, const PetscReal x[],
                              PetscReal most)
{
  PetscReal least = PETSC_INFINITY, normal[ISPH_MAX_DIM];

  for (PetscInt s = 0; s < SceneBoundaries(scene); s++) {
    const Body *body = BoundaryBody(scene, s);

    if (s == side) continue;
    if (body)
      least = PetscMin(least, PetscAbsReal(BodyDistanceWithin(scene, body, x, most, normal)));
    else least = PetscMin(least, PetscAbsReal(SceneSideDistance(scene, s, x)));
  }
  return least <= most;
}

/* Reduces facets of a boundary, of a section if side is negative, to their parts that are not
   buried in another boundary. */
static PetscErrorCode KeepUnburied(const Scene *scene, PetscInt side, Facets *f)
{
  const PetscInt dim = f->dim, n = dim == 2 ? BURIED_2D : BURIED_3D, parts = dim == 2 ? n : n * n;
  PetscInt       kept = 0;
  PetscReal     *x;
  PetscBool     *out;

  PetscFunctionBegin;
  if (scene->n_bodies == 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc2(parts * dim, &x, parts, &out));
  for (PetscInt k = 0; k < f->n; k++) {
    const PetscReal size = dim == 2 ? f->area[k] : 2.0 * PetscSqrtReal(f->area[k]);

    if (!IsNearOthers(scene, side, &f->x[k * dim], size)) {
      if (!IsBuried(scene, side, &f->x[k * dim])) FacetsCopy(k, kept++, f);
      continue;
    }
    SetParts(f, k, n, x);
    for (PetscInt q = 0; q < parts; q++) out[q] = IsBuried(scene, side, &x[q * dim]);
    if (KeepParts(k, parts, x, out, kept, f)) kept++;
  }
  f->n = kept;
  PetscCall(PetscFree2(x, out));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FacetsOfBody - Creates the facets of a body, with a number of pieces along each of their edges,
   but for their parts that are buried in another boundary; not collective. Free with FacetsFree().
 */
PetscErrorCode FacetsOfBody(const Scene *scene, PetscInt side, PetscInt pieces, Facets *f)
{
  const PetscInt  dim     = scene->dim;
  const Body     *body    = BoundaryBody(scene, side);
  const PetscReal spacing = BodySpacing(scene, body) / pieces;

  PetscFunctionBegin;
  PetscCall(FacetsCreate(dim, BodyPoints(body, spacing), f));
  for (PetscInt k = 0; k < f->n; k++) {
    PetscReal x[ISPH_MAX_DIM], normal[ISPH_MAX_DIM];

    f->area[k] = BodyPoint(body, k, spacing, x, normal);
    for (PetscInt a = 0; a < dim; a++) {
      f->x[k * dim + a]      = x[a];
      f->normal[k * dim + a] = normal[a];
    }
  }
  PetscCall(KeepUnburied(scene, side, f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FacetsOfWall - Creates the facets of a wall, a side of the box or a body, but for their parts
   that are buried in another boundary; not collective. Free with FacetsFree(). */
PetscErrorCode FacetsOfWall(const Scene *scene, PetscInt side, Facets *f)
{
  PetscInt n = 1;

  PetscFunctionBegin;
  if (BoundaryBody(scene, side)) {
    PetscCall(FacetsOfBody(scene, side, 1, f));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (PetscInt a = 0; a < scene->dim; a++) n *= a == side / 2 ? 1 : scene->cells[a];
  PetscCall(FacetsCreate(scene->dim, n, f));
  SetSide(scene, side, f);
  PetscCall(KeepUnburied(scene, side, f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FacetsOfSection - Creates the facets of a section, at most dx wide, but for their parts in
   bodies. Not collective. Input: corner - both ends in 2D, in 3D a corner and its two neighbours
   [m]. In 2D the normal is the vector between the ends turned to the right, in 3D the cross product
   of the two sides. Free with FacetsFree(). */
PetscErrorCode FacetsOfSection(const Scene *scene, const PetscReal corner[], Facets *f)
{
  const PetscInt dim                   = scene->dim;
  PetscReal      side[2][ISPH_MAX_DIM] = {{0.0}}, across[ISPH_MAX_DIM], area = 0.0;
  PetscInt       n[2] = {1, 1};

  PetscFunctionBegin;
  for (PetscInt s = 0; s < dim - 1; s++) {
    PetscReal length2 = 0.0;

    for (PetscInt a = 0; a < dim; a++) {
      side[s][a] = corner[(s + 1) * dim + a] - corner[a];
      length2 += PetscSqr(side[s][a]);
    }
    n[s] = PetscMax(1, (PetscInt)PetscCeilReal(PetscSqrtReal(length2) / SceneFinest(scene) - 1e-9));
  }
  if (dim == 2) {
    across[0] = side[0][1];
    across[1] = -side[0][0];
  } else {
    for (PetscInt a = 0; a < 3; a++) {
      const PetscInt b = (a + 1) % 3, c = (a + 2) % 3;

      across[a] = side[0][b] * side[1][c] - side[0][c] * side[1][b];
    }
  }
  for (PetscInt a = 0; a < dim; a++) area += PetscSqr(across[a]);
  area = PetscSqrtReal(area);
  PetscCall(FacetsCreate(dim, n[0] * n[1], f));
  for (PetscInt k = 0; k < f->n; k++) {
    for (PetscInt a = 0; a < dim; a++) {
      f->x[k * dim + a] = corner[a] + (k % n[0] + 0.5) / n[0] * side[0][a] +
                          (dim == 3 ? (k / n[0] + 0.5) / n[1] * side[1][a] : 0.0);
      f->normal[k * dim + a] = area > 0.0 ? across[a] / area : 0.0;
    }
    f->area[k] = area / f->n;
  }
  f->whole = area / f->n;
  for (PetscInt s = 0; s < dim - 1; s++)
    for (PetscInt a = 0; a < dim; a++) f->edge[s][a] = side[s][a] / n[s];
  PetscCall(KeepUnburied(scene, -1, f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FacetsKeepWet - Reduces facets to their parts inside the free surface. Collective. Middles become
   those of the wet parts. Facets without wet parts are left out. Nothing changes in a flow without
   a free surface. */
PetscErrorCode FacetsKeepWet(const Flow *flow, Facets *f)
{
  const PetscInt dim = f->dim, n = dim == 2 ? PARTS_2D : PARTS_3D, parts = dim == 2 ? n : n * n;
  PetscInt       kept = 0;
  PetscReal     *x;
  PetscBool     *dry;

  PetscFunctionBegin;
  if (!SceneHasFreeSurface(flow->scene)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc2(f->n * parts * dim, &x, f->n * parts, &dry));
  for (PetscInt k = 0; k < f->n; k++) SetParts(f, k, n, &x[k * parts * dim]);
  PetscCall(ProbeDry(flow, f->n * parts, x, dry));
  for (PetscInt k = 0; k < f->n; k++)
    if (KeepParts(k, parts, &x[k * parts * dim], &dry[k * parts], kept, f)) kept++;
  f->n = kept;
  PetscCall(PetscFree2(x, dry));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  FacetsFlux - Computes the flux of velocity through facets along their normals, by Gauss points

    sum dA/q sum_q u(x_q).n,   q = 2 points in 2D, 4 in 3D, those that are wet,

  which is exact for a velocity of third order [m^2/s, m^3/s]. Collective. Output: flux - of all
  facets; size - sum of the magnitudes; NULL: not wanted.
*/
PetscErrorCode FacetsFlux(const Flow *flow, const Facets *f, PetscReal *flux, PetscReal *size)
{
  const PetscInt  dim = f->dim, points = dim == 2 ? 2 : 4;
  const PetscReal out = 2.0 / PetscSqrtReal(3.0); /* places of Gauss over the middles of halves */
  PetscReal      *x, *u;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(f->n * points * dim, &x, f->n * points * dim, &u));
  for (PetscInt k = 0; k < f->n; k++) {
    SetParts(f, k, 2, &x[k * points * dim]);
    for (PetscInt q = k * points * dim; q < (k + 1) * points * dim; q++)
      x[q] = f->x[k * dim + q % dim] + out * (x[q] - f->x[k * dim + q % dim]);
  }
  PetscCall(ProbePoints(flow, f->n * points, x, u, NULL));
  *flux = 0.0;
  if (size) *size = 0.0;
  for (PetscInt k = 0; k < f->n; k++) {
    PetscReal sum = 0.0;
    PetscInt  wet = 0;

    for (PetscInt q = k * points; q < (k + 1) * points; q++) {
      if (PetscIsNanReal(u[q * dim])) continue; /* dry between wet parts */
      wet++;
      for (PetscInt a = 0; a < dim; a++) sum += u[q * dim + a] * f->normal[k * dim + a];
    }
    if (wet) *flux += f->area[k] * sum / wet;
    if (wet && size) *size += f->area[k] * PetscAbsReal(sum) / wet;
  }
  PetscCall(PetscFree2(x, u));
  PetscFunctionReturn(PETSC_SUCCESS);
}
