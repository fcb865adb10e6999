/* The cells of a rank, cut by bodies and by interfaces of fluids, and the gradient of the velocity
   in each. A cell of two fluids is two cells. Thin cells at a free surface have the gradient of a
   group (straingroups.c). On an interface both fluids have the velocity of the stiffer one. Behind
   a wall that slips a layer of cells has the velocity of the fluid on the wall and, at the slip
   length behind it, that of the wall: theory.md, (strain:slip). */
#include "strain.h"

#define LEAST_MASS 0.3 /* of a particle, over its volume */

/* StrainEdge - Returns the edge of the cells of the velocity [dx]; not collective */
PetscReal StrainEdge(const Scene *scene)
{
  return scene->dim == 3 && SceneHasFreeSurface(scene) ? CELL_IN_SPACE : CELL_EDGE;
}

/* StrainReach - Returns the largest distance of a particle that assembly reads for the rows of
   another [m]: both have a part in a cell, through points of interfaces if there are; not
   collective */
PetscReal StrainReach(const Scene *scene)
{
  const PetscReal foot  = SceneFluids(scene) > 1 ? FIT_REACH + 1.0 : 0.0;
  const PetscReal cells = SceneHasFreeSurface(scene) ? 2.0 + GROUP_REACH : 2.0;

  return (2.0 * FIT_REACH + cells * StrainEdge(scene) + foot) * SceneCoarsest(scene);
}

/* Lists the fluids of a cell; returns their number. */
static PetscInt FluidsOf(PetscInt dim, const StrainNodes *corners, const StrainCell *cell,
                         PetscInt fluid[])
{
  PetscInt n = 0;

  if (!corners->fluid) {
    fluid[0] = 0;
    return 1;
  }
  for (PetscInt c = 0; c < 1 << dim; c++) {
    const PetscInt f = corners->fluid[cell->node[c]];
    PetscInt       k = 0;

    while (k < n && fluid[k] != f) k++;
    if (k == n) fluid[n++] = f;
  }
  return n;
}

/* Rows of the velocity on sides of cells, and on surfaces in them. */
typedef struct {
  StrainPoints points;
  PetscInt    *side; /* point of the side 2 a of cell k in fluid slot q at [(a all + k) 2 + q] */
  PetscInt     all;  /* places of sides */
} Sides;

/* Returns the stiffest of the fluids of a cell other than its own; -1: none. */
static PetscInt StiffestOf(const Scene *scene, PetscInt n, const PetscInt fluid[], PetscInt own)
{
  PetscInt best = -1;

  for (PetscInt k = 0; k < n; k++) {
    if (fluid[k] == own) continue;
    if (best < 0 || StrainIsStiffer(scene, fluid[k], best)) best = fluid[k];
  }
  return best;
}

/* Returns the boundary of the box that a side of a cell is on; -1: none. */
static PetscInt BoxSide(const Scene *scene, const StrainLattice *l, const StrainCell *cell,
                        PetscInt side)
{
  const PetscInt a = side / 2, index = l->first[a] + cell->cell[a];

  if (SceneIsPeriodic(scene, a)) return -1;
  if (side % 2 ? index == l->cells[a] - 1 : index == 0) return side;
  return -1;
}

/* Finds or adds the point of a side of a cell's part. */
static PetscErrorCode SidePoint(const Scene *scene, const StrainLattice *l, const StrainCell *cell,
                                PetscInt side, PetscInt fluid, const PetscReal x[], Sides *sides,
                                PetscInt *point)
{
  const PetscInt a = side / 2;
  PetscInt       k = 0;

  PetscFunctionBegin;
  for (PetscInt b = l->dim - 1; b >= 0; b--)
    k = k * (l->n[b] + 1) + cell->cell[b] + (b == a && side % 2 ? 1 : 0);
  k = 2 * (a * sides->all + k);
  while (sides->side[k] >= 0 && sides->points.fluid[sides->side[k]] != fluid && !(k & 1)) k++;
  if (sides->side[k] < 0 || sides->points.fluid[sides->side[k]] != fluid) {
    sides->side[k] = sides->points.n;
    PetscCall(StrainPointAdd(l->dim, x, fluid, BoxSide(scene, l, cell, side), &sides->points));
  }
  *point = sides->side[k];
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AddFacet(PetscInt dim, PetscInt point, PetscInt set, const PetscReal normal[],
                               PetscReal volume, Facets *f)
{
  PetscFunctionBegin;
  if (f->n == f->room) {
    f->room = 2 * f->room + 1024;
    PetscCall(PetscRealloc(sizeof(Facet) * (size_t)f->room, &f->facet));
  }
  f->facet[f->n].point = point;
  f->facet[f->n].set   = set;
  for (PetscInt a = 0; a < dim; a++) f->facet[f->n].normal[a] = normal[a] / volume;
  f->n++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the value at x of a function that is linear along the edges of a cell. */
static PetscReal ValueAt(const StrainLattice *l, const StrainCell *cell,
                         const PetscReal of_corner[], const PetscReal x[])
{
  PetscReal sum = 0.0;

  for (PetscInt c = 0; c < 1 << l->dim; c++) {
    PetscReal weight = of_corner[cell->node[c]];

    for (PetscInt a = 0; a < l->dim; a++) {
      const PetscReal t = (x[a] - cell->lo[a]) / l->edge[a];

      weight *= (c >> a) & 1 ? t : 1.0 - t;
    }
    sum += weight;
  }
  return sum;
}

/* Adds the facets of a part of a cell. */
static PetscErrorCode AddPart(const Scene *scene, const StrainCell *cell,
                              const StrainNodes *corners, PetscInt n_fluids,
                              const PetscInt fluids[], PetscInt fluid,
                              const StrainQuantity *quantity, const CellPart *part, StrainCells *s,
                              Sides *sides, Facets *facets)
{
  const StrainLattice *l     = &s->lattice;
  const PetscInt       other = StiffestOf(scene, n_fluids, fluids, fluid);
  const PetscInt       stiff = other >= 0 && StrainIsStiffer(scene, other, fluid) ? other : fluid;
  PetscInt             point = 0;

  PetscFunctionBegin;
  for (PetscInt side = 0; side < 2 * l->dim; side++) {
    PetscReal normal[ISPH_MAX_DIM] = {0.0};

    if (part->area[side] <= 0.0) continue;
    normal[side / 2] = side % 2 ? part->area[side] : -part->area[side];
    PetscCall(SidePoint(scene, l, cell, side, fluid, part->at[side], sides, &point));
    PetscCall(AddFacet(l->dim, point, -1, normal, part->volume, facets));
  }
  for (PetscInt k = 0; k < part->n_surface; k++) {
    const PetscBool between = part->between[k];
    const PetscInt  of      = between ? stiff : fluid;
    PetscInt        body    = -1;

    if (l->distance && !between) (void)StrainBodiesDistance(scene, part->place[k], &body);
    if (body >= 0 && corners->depth && /* the facet is on the less deep of them */
        ValueAt(l, cell, l->distance, part->place[k]) >=
            ValueAt(l, cell, corners->depth, part->place[k]))
      body = -1;
    if (quantity->cut && !quantity->gives && body < 0) {
      const PetscReal tension = !between ? scene->tension
                                : fluid  ? scene->region_tension[fluid - 1]
                                         : 0.0;

      for (PetscInt v = 0; v < l->dim; v++) /* corners have no points yet */
        PetscCall(AddFacet(l->dim, -1 - (s->surface.n * l->dim + v), -1, part->normal[k],
                           part->volume * l->dim, facets));
      PetscCall(StrainFacetAdd(l->dim, part->corner[k], of, between, tension, &s->surface));
      continue;
    }
    if (quantity->cut && !quantity->gives)
      PetscCall(StrainWetAdd(l->dim, part->corner[k], body, &s->surface));
    if (corners->depth && body < 0 && !between && quantity->gives) body = SceneBoundaries(scene);
    point = sides->points.n;
    PetscCall(StrainPointAdd(l->dim, part->place[k], of, body, &sides->points));
    PetscCall(AddFacet(l->dim, point, -1, part->normal[k], part->volume, facets));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes room for a further cell. */
static PetscErrorCode CellsReserve(PetscInt dim, StrainCells *s, Facets *facets)
{
  PetscFunctionBegin;
  if (s->all + 1 < s->capacity) PetscFunctionReturn(PETSC_SUCCESS);
  s->capacity = 2 * s->capacity + 1024;
  PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)s->capacity, &s->volume));
  PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)s->capacity, &s->nu));
  PetscCall(PetscRealloc(sizeof(PetscInt) * (size_t)s->capacity, &s->fluid));
  PetscCall(PetscRealloc(sizeof(PetscInt) * (size_t)s->capacity, &s->beside));
  for (PetscInt a = 0; a < dim; a++)
    PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)s->capacity, &s->centre[a]));
  PetscCall(PetscRealloc(sizeof(PetscInt) * (size_t)s->capacity, &facets->first));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the areas of sides of the box in the last cell, if this rank has it. */
static void AddWet(const Scene *scene, const Particles *p, const StrainCell *cell,
                   const CellPart *part, StrainCells *s)
{
  PetscReal x[ISPH_MAX_DIM];

  if (!StrainHasCell(p, s, s->n, x)) return;
  for (PetscInt side = 0; side < 2 * p->dim; side++)
    if (BoxSide(scene, &s->lattice, cell, side) == side) s->surface.wet[side] += part->area[side];
}

/* Finds the cells and their facets. */
static PetscErrorCode FindCells(const Scene *scene, const Particles *p,
                                const StrainQuantity *quantity, const StrainNodes *corners,
                                StrainCells *s, Sides *sides, Facets *facets)
{
  const StrainLattice *l     = &s->lattice;
  const PetscInt       all   = StrainCellCount(l);
  PetscReal            whole = 1.0;

  PetscFunctionBegin;
  s->n = s->all = s->surface.n = s->surface.n_wet = 0;
  PetscCall(PetscArrayzero(s->surface.wet, 2 * ISPH_MAX_DIM));
  PetscCall(PetscMalloc1(s->capacity, &facets->first));
  for (PetscInt a = 0; a < l->dim; a++) whole *= l->edge[a];
  for (PetscInt k = 0; k < all; k++) {
    PetscInt   fluid[CELL_CORNERS], n;
    StrainCell cell;

    StrainCellSet(scene, l, k, &cell);
    n = FluidsOf(l->dim, corners, &cell, fluid);
    for (PetscInt q = 0; q < n; q++) {
      PetscReal d[CELL_CORNERS], phi[CELL_CORNERS];
      CellPart  part;

      StrainDistancesIn(l, corners, &cell, d);
      StrainCut(l->dim, cell.lo, l->edge, d, StrainPhiIn(l->dim, corners, &cell, fluid[q], phi),
                &part);
      if (part.volume < LEAST_PART * whole) continue;
      PetscCall(CellsReserve(l->dim, s, facets));
      s->volume[s->n]     = part.volume;
      s->fluid[s->n]      = fluid[q];
      facets->first[s->n] = facets->n;
      PetscCall(
          AddPart(scene, &cell, corners, n, fluid, fluid[q], quantity, &part, s, sides, facets));
      for (PetscInt a = 0; a < l->dim; a++) s->centre[a][s->n] = part.centre[a];
      AddWet(scene, p, &cell, &part, s);
      s->all = ++s->n;
    }
  }
  if (s->n) facets->first[s->n] = facets->n;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Adds the layers behind walls that slip: with the slip length l a side of the area A of a cell has
  a layer of the volume A l, whose dissipation is that of the wall,

    A l 2 nu E:E = A nu |u - U|^2/l,   grad u = (U - u) n^T/l,   n out of the fluid
*/
static PetscErrorCode AddLayers(const Scene *scene, const StrainPoints *points, StrainCells *s,
                                Facets *facets)
{
  const PetscInt d = scene->dim;

  PetscFunctionBegin;
  for (PetscInt c = 0; c < s->n; c++) {
    for (PetscInt k = facets->first[c]; k < facets->first[c + 1]; k++) {
      const PetscInt  point = facets->facet[k].point, side = point < 0 ? -1 : points->side[point];
      const PetscReal slip = side < 0 || side >= 2 * d ? 0.0 : scene->boundary[side].slip;
      PetscReal       normal[ISPH_MAX_DIM] = {0.0};

      if (slip == 0.0) continue;
      PetscCall(CellsReserve(d, s, facets));
      normal[side / 2]  = side % 2 ? 1.0 : -1.0;
      s->volume[s->all] = PetscAbsReal(facets->facet[k].normal[side / 2]) * s->volume[c] * slip;
      s->fluid[s->all]  = s->fluid[c];
      s->beside[s->all] = c;
      for (PetscInt a = 0; a < d; a++) s->centre[a][s->all] = s->centre[a][c];
      PetscCall(AddFacet(d, point, side / 2, normal, slip, facets));
      PetscCall(AddFacet(d, point, -1, normal, -slip, facets));
      facets->first[++s->all] = facets->n;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes room for n further entries of set q. */
static PetscErrorCode EntriesReserve(PetscInt dim, PetscInt q, PetscInt n, StrainCells *s)
{
  PetscFunctionBegin;
  if (s->n_entries[q] + n <= s->room[q]) PetscFunctionReturn(PETSC_SUCCESS);
  s->room[q] = 2 * s->room[q] + n + 4096;
  PetscCall(PetscRealloc(sizeof(PetscInt) * (size_t)s->room[q], &s->j[q]));
  for (PetscInt b = 0; b < dim; b++)
    PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)s->room[q], &s->g[q][b]));
  if (s->mean) PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)s->room[q], &s->mean));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds a facet on a boundary that does not give the value of a scalar. */
static PetscErrorCode BorderAdd(PetscInt dim, const StrainPoints *points, const Facet *facet,
                                PetscReal volume, StrainBorder *border)
{
  const PetscInt n = border->n;

  PetscFunctionBegin;
  if (n == border->room) {
    border->room = 2 * n + 256;
    PetscCall(PetscRealloc(sizeof(PetscInt) * (size_t)border->room, &border->side));
    PetscCall(PetscRealloc(sizeof(PetscInt) * (size_t)border->room, &border->row));
    PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)(border->room * dim), &border->normal));
    PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)(border->room * dim), &border->x));
  }
  border->side[n] = points->side[facet->point];
  border->row[n]  = facet->point;
  for (PetscInt a = 0; a < dim; a++) {
    border->normal[n * dim + a] = volume * facet->normal[a];
    border->x[n * dim + a]      = points->x[a][facet->point];
  }
  border->n++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lists the parts of boundaries that do not give the value of a scalar, and keeps the rows. */
static PetscErrorCode FindBorder(PetscInt dim, const PetscBool gives[], const StrainPoints *points,
                                 const Facets *facets, StrainRows *rows, StrainCells *s)
{
  PetscFunctionBegin;
  s->border.n = 0;
  for (PetscInt c = 0; c < s->n; c++) {
    for (PetscInt k = facets->first[c]; k < facets->first[c + 1]; k++) {
      const PetscInt side = points->side[facets->facet[k].point];

      if (side >= 0 && !gives[side])
        PetscCall(BorderAdd(dim, points, &facets->facet[k], s->volume[c], &s->border));
    }
  }
  PetscCall(StrainRowsFree(&s->border.rows));
  s->border.rows = *rows;
  *rows          = (StrainRows){.n = 0};
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the rows of a facet to the gradient of the last cell. Input: share - factor. */
static PetscErrorCode AddRows(const StrainRows *rows, const Facet *facet, PetscReal share,
                              PetscInt q, PetscInt place[], StrainCells *s)
{
  const PetscInt row = facet->point * s->sets + (facet->set < 0 ? q : facet->set);
  const PetscInt d   = s->lattice.dim;

  PetscFunctionBegin;
  PetscCall(EntriesReserve(d, q, rows->start[row + 1] - rows->start[row], s));
  for (PetscInt e = rows->start[row]; e < rows->start[row + 1]; e++) {
    const PetscInt j = rows->j[e];

    if (place[j] < 0) {
      place[j]          = s->n_entries[q]++;
      s->j[q][place[j]] = j;
      for (PetscInt b = 0; b < d; b++) s->g[q][b][place[j]] = 0.0;
      if (s->mean) s->mean[place[j]] = 0.0;
    }
    for (PetscInt b = 0; b < d; b++) s->g[q][b][place[j]] += share * rows->w[e] * facet->normal[b];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the rows of the facets of a cell's group to its gradient, and its volume to the masses.
   Input: place - by local index, -1; it is so afterwards. */
static PetscErrorCode JoinFacets(const Particles *p, const StrainRows *rows, const Facets *facets,
                                 const StrainGroups *groups, PetscInt c, PetscInt q,
                                 PetscInt place[], StrainCells *s)
{
  const PetscInt first = s->n_entries[q], d = p->dim, lead = groups->lead[c];
  PetscReal      area = 0.0;

  PetscFunctionBegin;
  s->first[q][c] = first;
  for (PetscInt m = lead; m >= 0; m = groups->next[m]) {
    const PetscReal share = s->volume[m] / groups->volume[lead];

    for (PetscInt k = facets->first[m]; k < facets->first[m + 1]; k++)
      PetscCall(AddRows(rows, &facets->facet[k], share, q, place, s));
  }
  for (PetscInt k = facets->first[c]; k < facets->first[c + 1]; k++)
    for (PetscInt b = 0; b < d; b++) area += PetscAbsReal(facets->facet[k].normal[b]);
  for (PetscInt k = facets->first[c]; s->mean && k < facets->first[c + 1]; k++) {
    const Facet *facet = &facets->facet[k];
    PetscReal    share = 0.0;

    for (PetscInt b = 0; b < d; b++) share += PetscAbsReal(facet->normal[b]) / area;
    for (PetscInt e = rows->start[facet->point]; e < rows->start[facet->point + 1]; e++)
      s->mean[place[rows->j[e]]] += share * rows->w[e];
  }
  for (PetscInt e = first; e < s->n_entries[q]; e++) place[s->j[q][e]] = -1;
  for (PetscInt k = facets->first[c]; c < s->n && k < facets->first[c + 1]; k++) {
    const Facet   *facet = &facets->facet[k];
    const PetscInt row   = facet->point * s->sets + q;
    PetscReal      share = 0.0;

    for (PetscInt b = 0; b < d; b++) share += PetscAbsReal(facet->normal[b]);
    share *= s->volume[c] / area;
    for (PetscInt e = rows->start[row]; e < rows->start[row + 1]; e++)
      if (rows->j[e] < p->n_fluid) s->mass[q][rows->j[e]] += share * rows->w[e];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Joins the facets of all cells. */
static PetscErrorCode JoinAll(const Particles *p, const StrainRows *rows, const Facets *facets,
                              const StrainGroups *groups, StrainCells *s)
{
  const PetscInt all = ParticlesAll(p);
  PetscInt      *place;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(all, &place));
  for (PetscInt j = 0; j < all; j++) place[j] = -1;
  for (PetscInt q = 0; q < s->sets; q++) {
    s->n_entries[q] = 0;
    PetscCall(PetscFree(s->mass[q]));
    PetscCall(PetscCalloc1(p->n_fluid + 1, &s->mass[q]));
    PetscCall(PetscRealloc(sizeof(PetscInt) * (size_t)(s->all + 1), &s->first[q]));
    for (PetscInt c = 0; c < s->all; c++)
      PetscCall(JoinFacets(p, rows, facets, groups, c, q, place, s));
    s->first[q][s->all] = s->n_entries[q];
    for (PetscInt i = 0; i < p->n_fluid; i++)
      s->mass[q][i] = PetscMax(s->mass[q][i], LEAST_MASS * p->volume[i]);
  }
  PetscCall(PetscFree(place));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* StrainAssemble - Computes the cells and the gradients of the velocity in them for the present
   positions. Collective if cells end at a free surface. Input: edge - of a cell [dx]; degree - of
   fits; quantity - of the fits; a scalar also has the mean of each cell, and its border.
   Input/Output: cells - NULL at first. */
PetscErrorCode StrainAssemble(const Scene *scene, const Particles *p, const Neighbors *nb,
                              PetscReal edge, PetscInt degree, const StrainQuantity *quantity,
                              StrainCells **cells)
{
  StrainFits   fits    = {.scene  = scene,
                          .normal = quantity->normal,
                          .gives  = quantity->gives,
                          .p      = p,
                          .nb     = nb,
                          .degree = PetscMin(degree, 3),
                          .free   = quantity->cut,
                          .radius = SURFACE_RADIUS * (quantity->wide ? WIDER_FITS : 1.0),
                          .sets   = quantity->sets};
  StrainNodes  corners = {.fluid = NULL};
  Sides        sides   = {.side = NULL};
  Facets       facets  = {.n = 0};
  StrainRows   rows    = {.n = 0};
  StrainGroups groups;
  StrainCells *s;

  PetscFunctionBegin;
  if (!*cells) PetscCall(PetscNew(cells));
  s       = *cells;
  s->sets = quantity->sets;
  if (quantity->gives && !s->mean) PetscCall(PetscMalloc1(PetscMax(s->room[0], 1), &s->mean));
  PetscCall(StrainNodesFind(scene, p, edge, &s->lattice, &corners));
  if (quantity->cut) PetscCall(StrainVolumes(scene, p, &s->lattice, &corners));
  fits.dry  = corners.dry;
  sides.all = corners.all;
  PetscCall(PetscMalloc1(2 * p->dim * sides.all, &sides.side));
  for (PetscInt k = 0; k < 2 * p->dim * sides.all; k++) sides.side[k] = -1;
  PetscCall(FindCells(scene, p, quantity, &corners, s, &sides, &facets));
  if (!quantity->gives && !quantity->normal) PetscCall(AddLayers(scene, &sides.points, s, &facets));
  PetscCall(StrainCorners(scene, &s->lattice, &s->surface, &sides.points));
  for (PetscInt k = 0; k < facets.n; k++)
    if (facets.facet[k].point < 0)
      facets.facet[k].point = s->surface.first + s->surface.corner[-1 - facets.facet[k].point];
  PetscCall(StrainFeet(&fits));
  PetscCall(StrainRowsOf(&fits, &sides.points, &rows));
  PetscCall(StrainGroupsCreate(s, &facets, quantity->cut, &groups));
  PetscCall(JoinAll(p, &rows, &facets, &groups, s));
  if (quantity->gives)
    PetscCall(FindBorder(p->dim, quantity->gives, &sides.points, &facets, &rows, s));
  if (quantity->cut && !quantity->gives) {
    PetscCall(StrainRowsFree(&s->surface.rows));
    s->surface.rows = rows;
    rows            = (StrainRows){.n = 0};
    for (PetscInt q = 0; q < s->sets; q++)
      for (PetscInt i = 0; i < p->n_fluid; i++)
        s->mass[q][i] = p->volume[i] * (ParticlesDensity(scene, p, i) / scene->rho);
    PetscCall(PetscFree(s->apart));
    s->apart      = corners.apart;
    corners.apart = NULL;
    PetscCall(StrainMotion(scene, p, &sides.points, &corners, s));
    PetscCall(StrainFluxes(scene, p, &sides.points, &facets, &groups, s));
    PetscCall(StrainLayer(p->dim, &sides.points, &facets, s));
  }
  PetscCall(StrainGroupsFree(&groups));
  PetscCall(StrainRowsFree(&rows));
  PetscCall(StrainRowsFree(&fits.feet));
  PetscCall(PetscFree(fits.foot));
  PetscCall(StrainNodesFree(&corners));
  PetscCall(StrainPointsFree(&sides.points));
  PetscCall(FreeAll(&sides.side, &facets.first, &facets.facet));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* StrainSolid - Computes the volume that bodies cover in cell k of the block, and its middle x;
   returns false past the last cell; not collective */
PetscBool StrainSolid(const Scene *scene, const StrainCells *s, PetscInt k, PetscReal x[],
                      PetscReal *volume)
{
  const StrainLattice *l   = &s->lattice;
  const PetscInt       all = l->distance ? StrainCellCount(l) : 0;
  PetscReal            d[CELL_CORNERS];
  StrainCell           cell;
  CellPart             part;

  if (k >= all) return PETSC_FALSE;
  StrainCellSet(scene, l, k, &cell);
  for (PetscInt c = 0; c < 1 << l->dim; c++) d[c] = -l->distance[cell.node[c]];
  StrainCut(l->dim, cell.lo, l->edge, d, NULL, &part);
  *volume = part.volume;
  for (PetscInt a = 0; a < l->dim; a++) x[a] = part.centre[a];
  return PETSC_TRUE;
}

/* StrainDestroy - Frees the cells; not collective */
PetscErrorCode StrainDestroy(StrainCells **cells)
{
  StrainCells *s = *cells;

  PetscFunctionBegin;
  if (!s) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FreeAll(&s->lattice.distance, &s->volume, &s->nu, &s->fluid, &s->beside, &s->mean,
                    &s->border.side, &s->border.row, &s->border.normal, &s->border.x));
  PetscCall(StrainRowsFree(&s->border.rows));
  PetscCall(FreeAll(&s->surface.corner, &s->surface.x, &s->surface.fluid, &s->surface.between,
                    &s->surface.tension, &s->surface.on_level, &s->surface.wet_x,
                    &s->surface.wet_body));
  PetscCall(StrainRowsFree(&s->surface.rows));
  PetscCall(StrainBlocksFree(&s->surface.motion));
  PetscCall(StrainBlocksFree(&s->surface.layer));
  PetscCall(PetscFree(s->surface.depth));
  PetscCall(StrainBlocksFree(&s->flux));
  for (PetscInt k = 0; k < STRAIN_TENSOR; k++) PetscCall(PetscFree(s->weight[k]));
  PetscCall(FreeAll(&s->apart, &s->strain, &s->rate));
  for (PetscInt q = 0; q < ISPH_MAX_DIM; q++) {
    PetscCall(FreeAll(&s->centre[q], &s->mass[q], &s->first[q], &s->j[q]));
    for (PetscInt b = 0; b < ISPH_MAX_DIM; b++) PetscCall(PetscFree(s->g[q][b]));
    PetscCall(PetscFree(s->of[q]));
    PetscCall(PetscFree2(s->at[q], s->cell[q]));
  }
  for (PetscInt w = 0; w < 2; w++) {
    PetscCall(FreeAll(&s->list[w].start, &s->list[w].local, &s->list[w].slot));
  }
  PetscCall(PetscFree(*cells));
  PetscFunctionReturn(PETSC_SUCCESS);
}
