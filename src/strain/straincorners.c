/* Distances at the corners of the strain cells: from bodies, from the interfaces of fluids by the
   planes that particles carry, and below the free surface, the level of the concentration. Below a
   free surface cells have the volume of the particles, all of them and those of each fluid. See
   theory.md, (viscosity:cells), (strain:level) and (strain:fluids). */
#include "strain.h"

#define NODE_REACH 1.5 /* particles that decide on the interface at a corner [dx] */

/* Sets the block of cells in which own particles have a part; returns true if it is a new one. */
static PetscBool SetBlock(const Scene *scene, const Particles *p, PetscReal edge, StrainLattice *l)
{
  const PetscReal cells   = SceneHasFreeSurface(scene) ? 1.0 + GROUP_REACH : 1.0;
  const PetscReal reach   = (FIT_REACH + cells * edge) * scene->dx;
  PetscBool       changed = PETSC_FALSE;

  l->dim = p->dim;
  for (PetscInt a = 0; a < p->dim; a++) {
    const PetscReal length = scene->hi[a] - scene->lo[a];
    PetscInt        first, last;

    l->cells[a] = PetscMax(1, (PetscInt)(length / (edge * scene->dx) + 0.5));
    l->edge[a]  = length / l->cells[a];
    first = (PetscInt)PetscFloorReal((PetscMax(p->lo[a], scene->lo[a]) - reach - scene->lo[a]) /
                                     l->edge[a]);
    last  = (PetscInt)PetscFloorReal((PetscMin(p->hi[a], scene->hi[a]) + reach - scene->lo[a]) /
                                     l->edge[a]);
    if (!SceneIsPeriodic(scene, a)) {
      first = PetscMax(first, 0);
      last  = PetscMin(last, l->cells[a] - 1);
    }
    if (l->first[a] != first || l->n[a] != last - first + 1) changed = PETSC_TRUE;
    l->first[a] = first;
    l->n[a]     = last - first + 1;
  }
  return changed;
}

/* Computes the place of a corner [m]; in periodic directions it may be outside the box. */
void StrainCornerPlace(const Scene *scene, const StrainLattice *l, const PetscInt index[],
                       PetscReal x[])
{
  for (PetscInt a = 0; a < l->dim; a++) x[a] = scene->lo[a] + (l->first[a] + index[a]) * l->edge[a];
}

/* Computes the indices of corner k. */
void StrainCornerIndex(const StrainLattice *l, PetscInt k, PetscInt index[])
{
  for (PetscInt a = 0; a < l->dim; a++) {
    index[a] = k % (l->n[a] + 1);
    k /= l->n[a] + 1;
  }
}

PetscInt StrainCornerCount(const StrainLattice *l)
{
  PetscInt n = 1;

  for (PetscInt a = 0; a < l->dim; a++) n *= l->n[a] + 1;
  return n;
}

/* Computes the distance of x from the bodies, positive in the fluid [m]; body - the nearest. */
PetscReal StrainBodiesDistance(const Scene *scene, const PetscReal x[], PetscInt *body)
{
  PetscReal best = PETSC_INFINITY, y[ISPH_MAX_DIM], normal[ISPH_MAX_DIM];

  for (PetscInt a = 0; a < scene->dim; a++) y[a] = x[a];
  SceneIntoBox(scene, y);
  *body = -1;
  for (PetscInt s = 2 * scene->dim; s < SceneBoundaries(scene); s++) {
    const PetscReal d = BodyDistance(scene, BoundaryBody(scene, s), y, normal);

    if (d < best) *body = s;
    best = PetscMin(best, d);
  }
  return best;
}

/* Computes the distances of the corners from the bodies. */
static PetscErrorCode SetDistances(const Scene *scene, StrainLattice *l)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(l->distance));
  if (!scene->n_bodies) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(StrainCornerCount(l), &l->distance));
  for (PetscInt k = 0; k < StrainCornerCount(l); k++) {
    PetscInt  index[ISPH_MAX_DIM], body;
    PetscReal x[ISPH_MAX_DIM];

    StrainCornerIndex(l, k, index);
    StrainCornerPlace(scene, l, index, x);
    l->distance[k] = StrainBodiesDistance(scene, x, &body);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the fluid at each corner and its distance from the interface, by the particles around. */
static PetscErrorCode SetFluids(const Scene *scene, const Particles *p, const StrainLattice *l,
                                StrainNodes *corners)
{
  const PetscReal reach = (SceneHasFreeSurface(scene) ? LEVEL_REACH : NODE_REACH) * scene->dx;
  Cells           cells = {0};
  PetscInt       *list;

  PetscFunctionBegin;
  PetscCall(CellsBuild(p, reach, &cells));
  PetscCall(PetscMalloc1(cells.n, &list));
  for (PetscInt k = 0; k < corners->all; k++) {
    PetscInt       index[ISPH_MAX_DIM], n;
    PetscReal      x[ISPH_MAX_DIM];
    InterfacePlane plane;
    PetscBool      cut;

    StrainCornerIndex(l, k, index);
    StrainCornerPlace(scene, l, index, x);
    PetscCall(CellsFind(&cells, x, reach, cells.n, list, &n));
    cut               = InterfaceNear(p, x, n, list, &plane);
    corners->fluid[k] = plane.fluid[plane.offset < 0.0];
    corners->other[k] = cut ? plane.fluid[plane.offset >= 0.0] : corners->fluid[k];
    corners->phi[k]   = cut ? PetscAbsReal(plane.offset) : reach;
    if (corners->phi[k] >= TIE * scene->dx) continue;
    corners->phi[k]   = TIE * scene->dx;
    corners->fluid[k] = plane.fluid[StrainIsStiffer(scene, plane.fluid[1], plane.fluid[0])];
  }
  PetscCall(PetscFree(list));
  PetscCall(CellsFree(&cells));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets a cell of the block by its number. */
void StrainCellSet(const Scene *scene, const StrainLattice *l, PetscInt k, StrainCell *cell)
{
  for (PetscInt a = 0; a < l->dim; a++) {
    cell->cell[a] = k % l->n[a];
    k /= l->n[a];
  }
  StrainCornerPlace(scene, l, cell->cell, cell->lo);
  for (PetscInt c = 0; c < 1 << l->dim; c++) {
    PetscInt node = 0;

    for (PetscInt a = l->dim - 1; a >= 0; a--)
      node = node * (l->n[a] + 1) + cell->cell[a] + ((c >> a) & 1);
    cell->node[c] = node;
  }
}

/* Computes the distances at the corners of a cell from the boundary of the fluids. */
void StrainDistancesIn(const StrainLattice *l, const StrainNodes *corners, const StrainCell *cell,
                       PetscReal d[])
{
  for (PetscInt c = 0; c < 1 << l->dim; c++) {
    const PetscInt node = cell->node[c];

    d[c] = l->distance ? l->distance[node] : PETSC_INFINITY;
    if (corners->depth) d[c] = PetscMin(d[c], corners->depth[node]);
    if (PetscAbsReal(d[c]) < LEAST_PART * l->edge[0]) d[c] = 0.0;
    d[c] = PetscMin(d[c], 1e3 * l->edge[0]);
  }
}

/* Computes the distances at the corners of a cell from the interface of a fluid; returns NULL if
   there is one fluid. */
const PetscReal *StrainPhiIn(PetscInt dim, const StrainNodes *corners, const StrainCell *cell,
                             PetscInt fluid, PetscReal phi[])
{
  for (PetscInt c = 0; c < 1 << dim && corners->fluid; c++) {
    const PetscInt node = cell->node[c];

    phi[c] = corners->fluid[node] == fluid ? corners->phi[node] : -corners->phi[node];
  }
  return corners->fluid ? phi : NULL;
}

/* StrainNodesFind - Sets the block of cells, and computes distances at its corners from bodies and
   from interfaces of fluids. Not collective. Input: edge - of a cell [dx]. */
PetscErrorCode StrainNodesFind(const Scene *scene, const Particles *p, PetscReal edge,
                               StrainLattice *l, StrainNodes *corners)
{
  PetscFunctionBegin;
  if (SetBlock(scene, p, edge, l) || (scene->n_bodies && !l->distance) ||
      scene->pose) /* bodies move */
    PetscCall(SetDistances(scene, l));
  corners->all = StrainCornerCount(l);
  if (p->fluid) {
    PetscCall(PetscMalloc3(corners->all, &corners->fluid, corners->all, &corners->other,
                           corners->all, &corners->phi));
    PetscCall(SetFluids(scene, p, l, corners));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StrainNodesFree(StrainNodes *corners)
{
  PetscFunctionBegin;
  PetscCall(PetscFree3(corners->fluid, corners->other, corners->phi));
  PetscCall(FreeAll(&corners->depth, &corners->dry, &corners->level, &corners->apart));
  PetscFunctionReturn(PETSC_SUCCESS);
}
