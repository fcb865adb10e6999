/*
  Facets: pieces of a wall or of a section, about dx wide, over which forces and fluxes are sums. In
  flows with a free surface the wet parts of facets count. A film has few particles across: with
  facets that are wet or dry as a whole its flux would jump by a third.
*/
#include "monitors.h"

/* Parts of a facet along each direction, wet or dry. */
#define PARTS_2D 16
#define PARTS_3D 4

static PetscErrorCode FacetsCreate(PetscInt dim, PetscInt n, Facets *f)
{
  PetscFunctionBegin;
  *f = (Facets){.n = n, .dim = dim};
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

/* Copies facet k to the place `to`, which is not behind it. */
static void FacetsCopy(PetscInt k, PetscInt to, Facets *f)
{
  for (PetscInt a = 0; a < f->dim; a++) {
    f->x[to * f->dim + a]      = f->x[k * f->dim + a];
    f->normal[to * f->dim + a] = f->normal[k * f->dim + a];
  }
  f->area[to] = f->area[k];
}

/* Returns the share of cell i of the lattice along an axis that lies in the box, and its middle
   [cells]. Cells of particles on a free side have the other half outside. */
static PetscReal ShareInBox(const Scene *scene, PetscInt axis, PetscInt i, PetscReal *middle)
{
  const PetscInt  last = scene->cells[axis] - 1;
  const PetscReal low  = i == 0 && BoundaryIs(scene, 2 * axis, BOUNDARY_FREE) ? 0.5 : 0.0;
  const PetscReal high = i == last && BoundaryIs(scene, 2 * axis + 1, BOUNDARY_FREE) ? 0.5 : 0.0;

  *middle = i + 0.5 * (low + 1.0 - high);
  return 1.0 - low - high;
}

/* Sets the facets of a side of the box to the lattice cells on it. */
static void SetSide(const Scene *scene, PetscInt side, Facets *f)
{
  const PetscInt axis = side / 2, dim = scene->dim;

  for (PetscInt k = 0; k < f->n; k++) {
    PetscReal edge[ISPH_MAX_DIM], middle;
    PetscInt  index = k;

    f->area[k] = 1.0;
    for (PetscInt a = 0; a < dim; a++) {
      f->normal[k * dim + a] = a == axis ? (side % 2 ? -1.0 : 1.0) : 0.0;
      f->x[k * dim + a]      = side % 2 ? scene->hi[a] : scene->lo[a];
      if (a == axis) continue;
      f->area[k] *= ShareInBox(scene, a, index % scene->cells[a], &middle);
      f->x[k * dim + a] = SceneLatticePlace(scene, a, middle);
      index /= scene->cells[a];
    }
    SceneEdges(scene, &f->x[k * dim], edge);
    for (PetscInt a = 0; a < dim; a++) f->area[k] *= a == axis ? 1.0 : edge[a];
  }
}

/* FacetsOfWall - Creates the facets of a wall, a side of the box or a body, but for those that are
   buried in another boundary; not collective. Free with FacetsFree(). */
PetscErrorCode FacetsOfWall(const Scene *scene, PetscInt side, Facets *f)
{
  const PetscInt dim  = scene->dim;
  const Body    *body = BoundaryBody(scene, side);
  PetscInt       n = 1, kept = 0;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < dim; a++) n *= a == side / 2 ? 1 : scene->cells[a];
  PetscCall(FacetsCreate(dim, body ? BodyPoints(body, BodySpacing(scene, body)) : n, f));
  if (!body) SetSide(scene, side, f);
  for (PetscInt k = 0; k < f->n; k++) {
    PetscReal x[ISPH_MAX_DIM], normal[ISPH_MAX_DIM];

    if (body) f->area[k] = BodyPoint(body, k, BodySpacing(scene, body), x, normal);
    for (PetscInt a = 0; body && a < dim; a++) {
      f->x[k * dim + a]      = x[a];
      f->normal[k * dim + a] = normal[a];
    }
    if (scene->n_bodies && SceneIsBuried(scene, side, &f->x[k * dim])) continue;
    FacetsCopy(k, kept++, f);
  }
  f->n = kept;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  FacetsOfSection - Creates the facets of a section, at most dx wide, whose middles lie off bodies

  Not collective. Input: corner - both ends in 2D, in 3D a corner and its two neighbours [m]. In 2D
  the normal is the vector between the ends turned to the right, in 3D the cross product of the two
  sides. Free with FacetsFree().
*/
PetscErrorCode FacetsOfSection(const Scene *scene, const PetscReal corner[], Facets *f)
{
  const PetscInt dim                   = scene->dim;
  PetscReal      side[2][ISPH_MAX_DIM] = {{0.0}}, across[ISPH_MAX_DIM], area = 0.0;
  PetscInt       n[2] = {1, 1}, kept = 0;

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
    if (!ProbeInBody(scene, &f->x[k * dim])) FacetsCopy(k, kept++, f);
  }
  f->n = kept;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets x to the middles of the parts of a facet, which is taken as a square. */
static void SetParts(const Facets *f, PetscInt k, PetscInt parts, PetscReal x[])
{
  const PetscInt  dim = f->dim, n = dim == 2 ? PARTS_2D : PARTS_3D;
  const PetscReal edge = dim == 2 ? f->area[k] : PetscSqrtReal(f->area[k]);
  PetscReal       t[2][ISPH_MAX_DIM];

  (void)SurfaceTangents(dim, &f->normal[k * dim], t);
  for (PetscInt q = 0; q < parts; q++) {
    for (PetscInt a = 0; a < dim; a++) {
      x[q * dim + a] = f->x[k * dim + a] + ((q % n + 0.5) / n - 0.5) * edge * t[0][a];
      if (dim == 3) x[q * dim + a] += ((q / n + 0.5) / n - 0.5) * edge * t[1][a];
    }
  }
}

/*
  FacetsKeepWet - Reduces facets to their parts inside the free surface

  Collective. Middles become those of the wet parts. Facets without wet parts are left out. Nothing
  changes in a flow without a free surface.
*/
PetscErrorCode FacetsKeepWet(const Flow *flow, Facets *f)
{
  const PetscInt dim = f->dim, parts = dim == 2 ? PARTS_2D : PARTS_3D * PARTS_3D;
  PetscInt       kept = 0;
  PetscReal     *x;
  PetscBool     *dry;

  PetscFunctionBegin;
  if (!flow->ops->free) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc2(f->n * parts * dim, &x, f->n * parts, &dry));
  for (PetscInt k = 0; k < f->n; k++) SetParts(f, k, parts, &x[k * parts * dim]);
  PetscCall(ProbeDry(flow, f->n * parts, x, dry));
  for (PetscInt k = 0; k < f->n; k++) {
    PetscReal middle[ISPH_MAX_DIM] = {0.0};
    PetscInt  wet                  = 0;

    for (PetscInt q = k * parts; q < (k + 1) * parts; q++) {
      if (dry[q]) continue;
      wet++;
      for (PetscInt a = 0; a < dim; a++) middle[a] += x[q * dim + a];
    }
    if (wet == 0) continue;
    for (PetscInt a = 0; wet < parts && a < dim; a++) f->x[k * dim + a] = middle[a] / wet;
    f->area[k] *= (PetscReal)wet / parts;
    FacetsCopy(k, kept++, f);
  }
  f->n = kept;
  PetscCall(PetscFree2(x, dry));
  PetscFunctionReturn(PETSC_SUCCESS);
}
