/* Distances at the corners of the strain cells: from bodies, from the interfaces of fluids by the
   planes that particles carry, and below the free surface, the level of the concentration. Below a
   free surface cells have the volume of the particles, all of them and those of each fluid. See
   theory.md, (viscosity:cells), (strain:level) and (strain:fluids). */
#include "strain.h"

#define NODE_REACH   1.5  /* particles that decide on the interface at a corner [dx] */
#define SHIFT_MOST   0.5  /* of interfaces to the volumes of their fluids [dx] */
#define SHIFT_ROUNDS 4    /* over three fluids and more */
#define TIE          1e-7 /* a corner so near to an interface is in the stiffer fluid [dx] */

/* Sets the block of cells in which own particles have a part; returns true if it is a new one. */
static PetscBool SetBlock(const Scene *scene, const Particles *p, PetscReal edge, StrainLattice *l)
{
  PetscBool changed = PETSC_FALSE;

  l->dim = p->dim;
  for (PetscInt a = 0; a < p->dim; a++) {
    const PetscReal length = scene->hi[a] - scene->lo[a], reach = (FIT_REACH + edge) * scene->dx;
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
static void CornerPlace(const Scene *scene, const StrainLattice *l, const PetscInt index[],
                        PetscReal x[])
{
  for (PetscInt a = 0; a < l->dim; a++) x[a] = scene->lo[a] + (l->first[a] + index[a]) * l->edge[a];
}

/* Computes the indices of corner k. */
static void CornerIndex(const StrainLattice *l, PetscInt k, PetscInt index[])
{
  for (PetscInt a = 0; a < l->dim; a++) {
    index[a] = k % (l->n[a] + 1);
    k /= l->n[a] + 1;
  }
}

static PetscInt CornerCount(const StrainLattice *l)
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
  PetscCall(PetscMalloc1(CornerCount(l), &l->distance));
  for (PetscInt k = 0; k < CornerCount(l); k++) {
    PetscInt  index[ISPH_MAX_DIM], body;
    PetscReal x[ISPH_MAX_DIM];

    CornerIndex(l, k, index);
    CornerPlace(scene, l, index, x);
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

    CornerIndex(l, k, index);
    CornerPlace(scene, l, index, x);
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
  CornerPlace(scene, l, cell->cell, cell->lo);
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

/* Own cells whose volume below a level, or in a fluid that is shifted, StrainLevel() compares with
   that of particles. */
typedef struct {
  const Scene         *scene;
  const StrainLattice *l;
  StrainNodes         *corners;
  const PetscReal     *C;     /* concentration at corners */
  PetscInt             fluid; /* -1: all below the level */
  PetscReal           *shift; /* of each fluid into the others [m] */
  PetscReal            whole; /* volume of cells that no level changes [m^dim] */
  PetscInt             n, *cell;
} Volumes;

/* Returns the fluid at a corner if fluids are shifted, and its distance from the interface. */
static PetscInt Shifted(const Volumes *of, PetscInt k, PetscReal *phi)
{
  const PetscInt fluid = of->corners->fluid[k], other = of->corners->other[k];

  *phi = of->corners->phi[k] + of->shift[fluid] - of->shift[other];
  if (*phi >= 0.0) return fluid;
  *phi = -*phi;
  return other;
}

/* Sets the depths of corners below the level of the concentration, or lets the fluid give way. */
static void SetLevel(const Volumes *of, PetscReal level)
{
  if (of->fluid >= 0) of->shift[of->fluid] = -level;
  for (PetscInt k = 0; of->fluid < 0 && k < of->corners->all; k++)
    of->corners->depth[k] = StrainDepth(of->scene, of->C[k] - level);
}

/* Returns the volume of a cell at the level that is set. */
static PetscReal VolumeOf(const Volumes *of, PetscInt k)
{
  PetscReal  d[CELL_CORNERS], phi[CELL_CORNERS];
  StrainCell cell;
  CellPart   part;

  StrainCellSet(of->scene, of->l, k, &cell);
  StrainDistancesIn(of->l, of->corners, &cell, d);
  for (PetscInt c = 0; of->fluid >= 0 && c < 1 << of->l->dim; c++)
    if (Shifted(of, cell.node[c], &phi[c]) != of->fluid) phi[c] = -phi[c];
  StrainCut(of->l->dim, cell.lo, of->l->edge, d, of->fluid < 0 ? NULL : phi, &part);
  return part.volume;
}

/* Returns the volume of own cells at a level. */
static PetscReal VolumeAt(void *ctx, PetscReal level)
{
  const Volumes *of  = (const Volumes *)ctx;
  PetscReal      sum = of->whole;

  SetLevel(of, level);
  for (PetscInt k = 0; k < of->n; k++) sum += VolumeOf(of, of->cell[k]);
  return sum;
}

/* Finds the level between two bounds at which own cells have the volume `own`; collective. */
static PetscErrorCode FindLevel(const Particles *p, PetscReal own, PetscReal low, PetscReal high,
                                Volumes *of, PetscReal *level)
{
  const StrainLattice *l   = of->l;
  PetscInt             all = 1;
  PetscReal           *first;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < l->dim; a++) all *= l->n[a];
  PetscCall(PetscMalloc2(all, &of->cell, all, &first));
  of->n     = 0;
  of->whole = 0.0;
  SetLevel(of, low);
  for (PetscInt k = 0; k < all; k++) first[k] = VolumeOf(of, k);
  SetLevel(of, high);
  for (PetscInt k = 0; k < all; k++) {
    PetscReal  x[ISPH_MAX_DIM], volume;
    StrainCell cell;

    StrainCellSet(of->scene, l, k, &cell);
    for (PetscInt a = 0; a < l->dim; a++) x[a] = cell.lo[a] + 0.5 * l->edge[a];
    if (!ParticlesHolds(p, x)) continue;
    volume = VolumeOf(of, k);
    if (volume == first[k]) of->whole += volume;
    else of->cell[of->n++] = k;
  }
  PetscCall(StrainLevel(p, own, low, high, VolumeAt, of, level));
  SetLevel(of, *level);
  PetscCall(PetscFree2(of->cell, first));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Ends the run if fluid is outside the box, where there are no cells; collective. */
static PetscErrorCode CheckInside(const Scene *scene, const Particles *p)
{
  int out = 0;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < p->n_fluid; i++)
    for (PetscInt a = 0; a < p->dim; a++)
      if (!SceneIsPeriodic(scene, a) && (p->x[a][i] < scene->lo[a] || p->x[a][i] > scene->hi[a]))
        out = 1;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &out, 1, MPI_INT, MPI_MAX, p->comm));
  UserCheck(!out, "-scene_box: fluid has left the box, and below a free surface there is none "
                  "outside; give a smaller -t_end or a larger -scene_box");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lists walls that the fluid does not wet: those out of its level, by local index. */
static PetscErrorCode FindDry(const Scene *scene, const Particles *p, const Cells *cells,
                              PetscReal tau, PetscInt list[], PetscBool **dry)
{
  PetscFunctionBegin;
  PetscCall(PetscCalloc1(ParticlesAll(p), dry));
  for (PetscInt j = 0; j < ParticlesAll(p); j++) {
    PetscReal x[ISPH_MAX_DIM], C;

    if (!ParticlesIsWall(p, j)) continue;
    ParticlesWallPoint(p, j, x);
    PetscCall(StrainConcentration(scene, p, cells, x, list, &C));
    (*dry)[j] = C < tau ? PETSC_TRUE : PETSC_FALSE;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the level of the free surface, and sets the depths of the corners below it; collective. */
static PetscErrorCode FindSurface(const Scene *scene, const Particles *p, const StrainLattice *l,
                                  StrainNodes *corners)
{
  Cells     cells = {0};
  PetscInt *list;
  PetscReal tau, *C, own = 0.0, x[ISPH_MAX_DIM] = {0.0}, length;
  Volumes   of = {.scene = scene, .l = l, .corners = corners, .fluid = -1};

  PetscFunctionBegin;
  PetscCall(CheckInside(scene, p));
  if (p->entered) PetscCall(ParticlesHaloField(p, p->entered));
  PetscCall(CellsBuild(p, LEVEL_REACH * scene->dx, &cells));
  PetscCall(PetscMalloc2(cells.n + 1, &list, corners->all, &C));
  for (PetscInt k = 0; k < corners->all; k++) {
    PetscInt  index[ISPH_MAX_DIM];
    PetscReal x[ISPH_MAX_DIM];

    CornerIndex(l, k, index);
    CornerPlace(scene, l, index, x);
    PetscCall(StrainConcentration(scene, p, &cells, x, list, &C[k]));
  }
  of.C = C;
  for (PetscInt i = 0; i < p->n_fluid; i++) own += p->volume[i];
  for (PetscInt w = p->n_fluid; w < ParticlesOwn(p); w++)
    if (StrainWaits(scene, p, w, x, &length))
      own += p->cell_volume * length / SceneCellSide(scene, (PetscInt)p->side[w] / 2);
  PetscCall(FindLevel(p, own, LEVEL_LOW, LEVEL_HIGH, &of, &tau));
  PetscCall(FindDry(scene, p, &cells, tau, list, &corners->dry));
  PetscCall(PetscFree2(list, C));
  PetscCall(CellsFree(&cells));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Shifts the interfaces of each fluid along their normals so that its cells have the volume of its
   particles: distances that particles carry drift; collective. */
static PetscErrorCode SetVolumes(const Scene *scene, const Particles *p, const StrainLattice *l,
                                 StrainNodes *corners)
{
  const PetscReal most                        = SHIFT_MOST * scene->dx;
  const PetscInt  rounds                      = SceneFluids(scene) > 2 ? SHIFT_ROUNDS : 1;
  PetscReal       shift[SCENE_MAX_FLUIDS + 1] = {0.0};
  Volumes         of = {.scene = scene, .l = l, .corners = corners, .shift = shift};

  PetscFunctionBegin;
  for (PetscInt k = 0; k < rounds * (SceneFluids(scene) - 1); k++) {
    PetscReal own = 0.0, way;

    of.fluid = 1 + k % (SceneFluids(scene) - 1);
    for (PetscInt i = 0; i < p->n_fluid; i++)
      own += p->volume[i] * ParticlesFluidShare(p, i, of.fluid);
    PetscCall(FindLevel(p, own, -most, most, &of, &way));
  }
  for (PetscInt k = 0; k < corners->all; k++) {
    PetscReal      phi;
    const PetscInt fluid = Shifted(&of, k, &phi);

    if (fluid != corners->fluid[k]) corners->other[k] = corners->fluid[k];
    corners->fluid[k] = fluid;
    corners->phi[k]   = PetscMax(phi, TIE * scene->dx);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* StrainNodesFind - Sets the block of cells, and computes distances at its corners: from bodies,
   from interfaces of fluids, and below the free surface. Collective if cells end at a free surface.
   Input: edge - of a cell [dx]. */
PetscErrorCode StrainNodesFind(const Scene *scene, const Particles *p, PetscReal edge,
                               const StrainQuantity *quantity, StrainLattice *l,
                               StrainNodes *corners)
{
  PetscFunctionBegin;
  if (SetBlock(scene, p, edge, l) || (scene->n_bodies && !l->distance) ||
      scene->pose) /* bodies move */
    PetscCall(SetDistances(scene, l));
  corners->all = CornerCount(l);
  if (p->fluid) {
    PetscCall(PetscMalloc3(corners->all, &corners->fluid, corners->all, &corners->other,
                           corners->all, &corners->phi));
    PetscCall(SetFluids(scene, p, l, corners));
  }
  if (!quantity->cut) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(corners->all, &corners->depth));
  PetscCall(FindSurface(scene, p, l, corners));
  if (p->fluid) PetscCall(SetVolumes(scene, p, l, corners));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StrainNodesFree(StrainNodes *corners)
{
  PetscFunctionBegin;
  PetscCall(PetscFree3(corners->fluid, corners->other, corners->phi));
  PetscCall(FreeAll(&corners->depth, &corners->dry));
  PetscFunctionReturn(PETSC_SUCCESS);
}
