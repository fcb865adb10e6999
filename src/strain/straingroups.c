/* Groups of cells at a free surface that have one gradient of the velocity. The velocities on both
   sides of a thin cell have rows of different fits. Their difference over its thickness has no
   bound, and makes the viscous matrix as stiff for velocities that vary from particle to particle.
   A thin cell and the cell beside it therefore have the gradient of both together, whose sides
   between them cancel: docs/developers/theory.md, (strain:thin). */
#include "strain.h"

#define THIN   0.1  /* share of a whole cell below which a cell is thin [-] */
#define LARGER 1e-6 /* by which a side is larger than another: ranks round differently [-] */

/* Lists the two cells of each point of a side, at [2 point]; -1: none. Input: n - points of
   sides. */
static void CellsOfSides(const StrainCells *s, const Facets *facets, PetscInt n, PetscInt of[])
{
  for (PetscInt k = 0; k < 2 * n; k++) of[k] = -1;
  for (PetscInt c = 0; c < s->n; c++) {
    for (PetscInt k = facets->first[c]; k < facets->first[c + 1]; k++) {
      const PetscInt point = facets->facet[k].point;

      if (point < n) of[2 * point + (of[2 * point] >= 0)] = c;
    }
  }
}

/* Returns the neighbour of a thin cell in the same fluid on the largest side, of those that are not
   thin; -1: none. Input: n, of - of CellsOfSides(); thin - volume [m^dim]. */
static PetscInt NeighbourOf(const StrainCells *s, const Facets *facets, PetscInt c, PetscReal thin,
                            PetscInt n, const PetscInt of[])
{
  PetscInt  best    = -1;
  PetscReal largest = 0.0;

  for (PetscInt k = facets->first[c]; k < facets->first[c + 1]; k++) {
    const Facet *facet = &facets->facet[k];
    PetscReal    area  = 0.0;
    PetscInt     other;

    if (facet->point >= n) continue;
    other = of[2 * facet->point + (of[2 * facet->point] == c)];
    for (PetscInt b = 0; b < s->lattice.dim; b++) area += PetscAbsReal(facet->normal[b]);
    if (other < 0 || s->fluid[other] != s->fluid[c] || s->volume[other] < thin) continue;
    if (area <= (1.0 + LARGER) * largest) continue;
    largest = area;
    best    = other;
  }
  return best;
}

/* StrainGroupsCreate - Creates the groups. Not collective. Input: thin - flag: thin cells join
   their neighbour; otherwise each cell is a group. */
PetscErrorCode StrainGroupsCreate(const StrainCells *s, const Facets *facets, PetscBool thin,
                                  StrainGroups *groups)
{
  const PetscInt n    = s->surface.first; /* points of sides come first */
  PetscReal      most = THIN;
  PetscInt      *of;

  PetscFunctionBegin;
  PetscCall(PetscMalloc3(s->all, &groups->lead, s->all, &groups->next, s->all, &groups->volume));
  for (PetscInt c = 0; c < s->all; c++) {
    groups->lead[c]   = c;
    groups->next[c]   = -1;
    groups->volume[c] = s->volume[c];
  }
  if (!thin) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt a = 0; a < s->lattice.dim; a++) most *= s->lattice.edge[a];
  PetscCall(PetscMalloc1(2 * n, &of));
  CellsOfSides(s, facets, n, of);
  for (PetscInt c = 0; c < s->n; c++) {
    const PetscInt lead = s->volume[c] < most ? NeighbourOf(s, facets, c, most, n, of) : -1;

    if (lead < 0) continue;
    groups->lead[c]    = lead;
    groups->next[c]    = groups->next[lead];
    groups->next[lead] = c;
    groups->volume[lead] += s->volume[c];
  }
  PetscCall(PetscFree(of));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* StrainGroupsFree - Frees the groups; not collective */
PetscErrorCode StrainGroupsFree(StrainGroups *groups)
{
  PetscFunctionBegin;
  PetscCall(PetscFree3(groups->lead, groups->next, groups->volume));
  PetscFunctionReturn(PETSC_SUCCESS);
}
