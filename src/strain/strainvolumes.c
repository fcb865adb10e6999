/* Volumes of the cells below a free surface: each piece of the fluid, and each fluid, has that of
   its particles. See theory.md, (strain:level), (strain:pieces) and (strain:fluids). */
#include "strain.h"

#define SHIFT_MOST   0.5 /* of interfaces to the volumes of their fluids [dx] */
#define SHIFT_ROUNDS 4   /* over three fluids and more */
#define PASSES       0.5 /* change of the concentration on a wall by a line that moves by dx [-] */

/* The concentration at the corners of the block, by pieces of the fluid. */
typedef struct {
  PetscReal *C;     /* concentration */
  PetscInt  *first; /* parts of corner k: [first[k], first[k + 1]); NULL: there is one piece */
  PetscInt  *piece;
  PetscReal *part; /* of a piece, over all of them */
} Concentrations;

/* Cells whose volumes StrainLevels() compares with those of particles: of pieces of the fluid below
   levels of the concentration, or of a fluid whose interface is shifted. */
typedef struct {
  const Scene         *scene;
  const StrainLattice *l;
  StrainNodes         *corners;
  Concentrations       of;
  PetscInt             pieces; /* with levels of their own */
  PetscInt             fluid;  /* whose interface is shifted; -1: pieces have levels */
  PetscReal           *shift;  /* of each fluid into the others [m] */
  PetscReal           *whole;  /* of each piece: volume of cells that no level changes [m^dim] */
  PetscInt             n, *cell, *piece; /* cells that levels change; the piece of each */
} Volumes;

/* Returns the fluid at a corner if fluids are shifted, and its distance from the interface. */
static PetscInt Shifted(const Volumes *v, PetscInt k, PetscReal *phi)
{
  const PetscInt fluid = v->corners->fluid[k], other = v->corners->other[k];

  *phi = v->corners->phi[k] + v->shift[fluid] - v->shift[other];
  if (*phi >= 0.0) return fluid;
  *phi = -*phi;
  return other;
}

/* Sets the depths of corners below the levels of the concentration, or lets the fluid give way. */
static void SetLevels(const Volumes *v, const PetscReal level[])
{
  if (v->fluid >= 0) v->shift[v->fluid] = -level[0];
  for (PetscInt k = 0; v->fluid < 0 && k < v->corners->all; k++) {
    PetscReal at = v->of.first ? 0.0 : level[0];

    for (PetscInt e = v->of.first ? v->of.first[k] : 0; v->of.first && e < v->of.first[k + 1]; e++)
      at += v->of.part[e] * level[v->of.piece[e]];
    v->corners->depth[k] =
        StrainDepth(v->scene, v->of.C[k] - (v->of.C[k] > 0.0 ? at : LEVEL_PLANE));
  }
}

/* Returns the volume of a cell at the levels that are set. */
static PetscReal VolumeOf(const Volumes *v, PetscInt k)
{
  PetscReal  d[CELL_CORNERS], phi[CELL_CORNERS];
  StrainCell cell;
  CellPart   part;

  StrainCellSet(v->scene, v->l, k, &cell);
  StrainDistancesIn(v->l, v->corners, &cell, d);
  for (PetscInt c = 0; v->fluid >= 0 && c < 1 << v->l->dim; c++)
    if (Shifted(v, cell.node[c], &phi[c]) != v->fluid) phi[c] = -phi[c];
  StrainCut(v->l->dim, cell.lo, v->l->edge, d, v->fluid < 0 ? NULL : phi, &part);
  return part.volume;
}

/* Returns the piece that has the largest part in the concentration around a cell. */
static PetscInt PieceOf(const Volumes *v, PetscInt k)
{
  PetscReal  best = 0.0;
  PetscInt   of   = 0;
  StrainCell cell;

  if (!v->of.first) return 0;
  StrainCellSet(v->scene, v->l, k, &cell);
  for (PetscInt c = 0; c < 1 << v->l->dim; c++) {
    for (PetscInt e = v->of.first[cell.node[c]]; e < v->of.first[cell.node[c] + 1]; e++) {
      const PetscReal part = v->of.part[e] * v->of.C[cell.node[c]];

      if (part <= best) continue;
      best = part;
      of   = v->of.piece[e];
    }
  }
  return of;
}

/* Computes the volumes of own cells at levels. */
static PetscErrorCode VolumesAt(void *ctx, const PetscReal level[], PetscReal volume[])
{
  const Volumes *v = (const Volumes *)ctx;

  PetscFunctionBegin;
  SetLevels(v, level);
  PetscCall(PetscArraycpy(volume, v->whole, v->pieces));
  for (PetscInt k = 0; k < v->n; k++)
    if (v->piece[k] < v->pieces) volume[v->piece[k]] += VolumeOf(v, v->cell[k]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the levels between two bounds at which own cells have the volumes `own`, and sets them.
   Collective. Input/Output: level - the value of single particles, at [v->pieces]; of pieces. */
static PetscErrorCode FindLevels(const Particles *p, const PetscReal own[], PetscReal low,
                                 PetscReal high, Volumes *v, PetscReal level[])
{
  const StrainLattice *l   = v->l;
  const PetscInt       all = StrainCellCount(l);
  PetscReal           *first;

  PetscFunctionBegin;
  PetscCall(PetscMalloc3(all, &v->cell, all, &v->piece, all, &first));
  PetscCall(PetscCalloc1(v->pieces, &v->whole));
  v->n = 0;
  for (PetscInt e = 0; e < 2; e++) {
    for (PetscInt k = 0; k < v->pieces; k++) level[k] = e ? high : low;
    SetLevels(v, level);
    for (PetscInt k = 0; k < all; k++) {
      PetscReal  x[ISPH_MAX_DIM], volume;
      StrainCell cell;

      if (!e) {
        first[k] = VolumeOf(v, k);
        continue;
      }
      StrainCellSet(v->scene, l, k, &cell);
      for (PetscInt a = 0; a < l->dim; a++) x[a] = cell.lo[a] + 0.5 * l->edge[a];
      if (!ParticlesHolds(p, x)) continue;
      volume = VolumeOf(v, k);
      if (volume == 0.0 && first[k] == 0.0) continue;
      v->piece[v->n] = PieceOf(v, k);
      if (volume != first[k]) v->cell[v->n++] = k;
      else if (v->piece[v->n] < v->pieces) v->whole[v->piece[v->n]] += volume;
    }
  }
  PetscCall(StrainLevels(p, v->pieces, own, low, high, VolumesAt, v, level));
  SetLevels(v, level);
  PetscCall(PetscFree(v->whole));
  PetscCall(PetscFree3(v->cell, v->piece, first));
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

/* Remembers on own wall particle j if the line of the free surface has passed by since the first
   cells. Input: excess - of the concentration there over its level. */
static void Remember(const Particles *p, PetscInt j, PetscReal excess)
{
  if (!p->wetness || j >= ParticlesOwn(p)) return;
  if (p->wetness[j] == 0.0) p->wetness[j] = excess;
  if (excess * p->wetness[j] < 0.0 && PetscAbsReal(excess - p->wetness[j]) > PASSES)
    p->wetness[j] = LINE_PASSED;
}

/* Returns true if fluid enters in a part of the cell of wall particle j, but not at its middle: a
   wall at rest there would hold the fluid that enters. */
static PetscBool IsEdge(const Scene *scene, const Particles *p, PetscInt j)
{
  PetscReal x[ISPH_MAX_DIM] = {0.0}, length;

  return StrainWaits(scene, p, j, x, &length) && !BoundaryIsOpen(scene, (PetscInt)p->side[j], x)
             ? PETSC_TRUE
             : PETSC_FALSE;
}

/* Lists walls that the fluid does not wet: those out of its level, and edges of openings, by local
   index. */
static PetscErrorCode FindDry(const Scene *scene, const Particles *p, const Cells *cells,
                              const PetscReal level[], PetscInt list[], PetscReal part[],
                              PetscBool **dry)
{
  PetscFunctionBegin;
  PetscCall(PetscCalloc1(ParticlesAll(p), dry));
  for (PetscInt j = 0; j < ParticlesAll(p); j++) {
    PetscReal x[ISPH_MAX_DIM], excess;

    if (!ParticlesIsWall(p, j)) continue;
    ParticlesWallPoint(p, j, x);
    PetscCall(StrainExcess(scene, p, cells, level, x, list, part, &excess));
    (*dry)[j] = excess < 0.0 || IsEdge(scene, p, j) ? PETSC_TRUE : PETSC_FALSE;
    Remember(p, j, excess);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* StrainVolumeOf - Returns the volume that own particle i stands for: its own or, if it is a wall
   particle of an inflow, that of the fluid that waits there [m^dim]; not collective */
PetscReal StrainVolumeOf(const Scene *scene, const Particles *p, PetscInt i)
{
  PetscReal x[ISPH_MAX_DIM] = {0.0}, length;

  if (i < p->n_fluid) return p->volume[i];
  if (!StrainWaits(scene, p, i, x, &length)) return 0.0;
  return p->cell_volume * length / SceneCellSide(scene, (PetscInt)p->side[i] / 2);
}

/* Computes the concentration at the corners. Input: piece - of each particle, by local index; NULL:
   there is one. Output: of - parts of pieces, if there are any. */
static PetscErrorCode Concentrate(const Scene *scene, const Particles *p, const Cells *cells,
                                  const StrainLattice *l, const PetscReal piece[], PetscInt list[],
                                  PetscReal part[], Concentrations *of)
{
  const PetscInt corners = StrainCornerCount(l);
  PetscInt       room = 0, end = 0;

  PetscFunctionBegin;
  if (piece) PetscCall(PetscMalloc1(corners + 1, &of->first));
  for (PetscInt k = 0; k < corners; k++) {
    PetscInt  index[ISPH_MAX_DIM], n;
    PetscReal x[ISPH_MAX_DIM], whole = 0.0;

    StrainCornerIndex(l, k, index);
    StrainCornerPlace(scene, l, index, x);
    PetscCall(StrainParts(scene, p, cells, x, list, &n, part, &of->C[k]));
    if (!piece) continue;
    of->first[k] = end;
    if (end + n > room) {
      room = 2 * room + n + 1024;
      PetscCall(PetscRealloc(sizeof(PetscInt) * (size_t)room, &of->piece));
      PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)room, &of->part));
    }
    for (PetscInt q = 0; q < n; q++) whole += part[q];
    for (PetscInt q = 0; q < n && whole > 0.0; q++) {
      PetscInt e = of->first[k];

      while (e < end && of->piece[e] != (PetscInt)piece[list[q]]) e++;
      if (e == end) {
        of->piece[e] = (PetscInt)piece[list[q]];
        of->part[e]  = 0.0;
        end++;
      }
      of->part[e] += part[q] / whole;
    }
  }
  if (piece) of->first[corners] = end;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lists the cells that have fluid at the level that is set. */
static PetscErrorCode FindWet(const Volumes *v, PetscBool **wet)
{
  const PetscInt all   = StrainCellCount(v->l);
  PetscReal      whole = 1.0;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < v->l->dim; a++) whole *= v->l->edge[a];
  PetscCall(PetscMalloc1(all, wet));
  for (PetscInt k = 0; k < all; k++)
    (*wet)[k] = VolumeOf(v, k) >= LEAST_PART * whole ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the levels of the free surface, and sets the depths of the corners below it. Collective. A
   first level, at which all cells have the volume of all particles, tells the pieces of the fluid.
   Then each piece has its own. Particles that no piece has keep the first. */
static PetscErrorCode FindSurface(const Scene *scene, const Particles *p, const StrainLattice *l,
                                  StrainNodes *corners)
{
  const PetscInt all   = ParticlesAll(p);
  Cells          cells = {0};
  Volumes        v     = {.scene = scene, .l = l, .corners = corners, .fluid = -1, .pieces = 1};
  PetscReal     *part, *piece, *level, *own, whole = 0.0, tau;
  PetscInt      *list, n, single;
  PetscBool     *wet;

  PetscFunctionBegin;
  PetscCall(CheckInside(scene, p));
  if (p->entered) PetscCall(ParticlesHaloField(p, p->entered));
  PetscCall(CellsBuild(p, LEVEL_REACH * scene->dx, &cells));
  PetscCall(
      PetscMalloc4(cells.n + 1, &list, cells.n + 1, &part, all, &piece, corners->all, &v.of.C));
  PetscCall(Concentrate(scene, p, &cells, l, NULL, list, part, &v.of));
  for (PetscInt i = 0; i < ParticlesOwn(p); i++) whole += StrainVolumeOf(scene, p, i);
  PetscCall(FindLevels(p, &whole, LEVEL_LOW, LEVEL_HIGH, &v, &tau));
  PetscCall(FindWet(&v, &wet));
  PetscCall(StrainPiecesNumber(scene, p, l, wet, piece, &n, &single));
  PetscCall(PetscMalloc2(n + 1, &level, n + 1, &own));
  PetscCall(PetscArrayzero(own, n + 1));
  for (PetscInt k = 0; k <= n; k++) level[k] = tau;
  if (n > 1 || (n == 1 && single)) {
    for (PetscInt i = 0; i < ParticlesOwn(p); i++)
      own[(PetscInt)piece[i]] += StrainVolumeOf(scene, p, i);
    v.pieces = n;
    PetscCall(Concentrate(scene, p, &cells, l, piece, list, part, &v.of));
    PetscCall(FindLevels(p, own, LEVEL_LOW, LEVEL_HIGH, &v, level));
  }
  PetscCall(PetscMalloc1(all, &corners->level));
  PetscCall(PetscMalloc1(p->n_fluid + 1, &corners->apart));
  for (PetscInt j = 0; j < all; j++) corners->level[j] = level[(PetscInt)piece[j]];
  for (PetscInt i = 0; i < p->n_fluid; i++) corners->apart[i] = (PetscInt)piece[i] == n;
  PetscCall(FindDry(scene, p, &cells, corners->level, list, part, &corners->dry));
  PetscCall(PetscFree2(level, own));
  PetscCall(PetscFree4(list, part, piece, v.of.C));
  PetscCall(FreeAll(&wet, &v.of.first, &v.of.piece, &v.of.part));
  PetscCall(CellsFree(&cells));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Shifts the interfaces of each fluid along their normals so that its cells have the volume of its
   particles: distances that particles carry drift; collective. */
static PetscErrorCode FindInterfaces(const Scene *scene, const Particles *p, const StrainLattice *l,
                                     StrainNodes *corners)
{
  const PetscReal most                        = SHIFT_MOST * scene->dx;
  const PetscInt  rounds                      = SceneFluids(scene) > 2 ? SHIFT_ROUNDS : 1;
  PetscReal       shift[SCENE_MAX_FLUIDS + 1] = {0.0};
  Volumes         v = {.scene = scene, .l = l, .corners = corners, .shift = shift, .pieces = 1};

  PetscFunctionBegin;
  for (PetscInt k = 0; k < rounds * (SceneFluids(scene) - 1); k++) {
    PetscReal own = 0.0, way;

    v.fluid = 1 + k % (SceneFluids(scene) - 1);
    for (PetscInt i = 0; i < p->n_fluid; i++)
      own += p->volume[i] * ParticlesFluidShare(p, i, v.fluid);
    PetscCall(FindLevels(p, &own, -most, most, &v, &way));
  }
  for (PetscInt k = 0; k < corners->all; k++) {
    PetscReal      phi;
    const PetscInt fluid = Shifted(&v, k, &phi);

    if (fluid != corners->fluid[k]) corners->other[k] = corners->fluid[k];
    corners->fluid[k] = fluid;
    corners->phi[k]   = PetscMax(phi, TIE * scene->dx);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* StrainVolumes - Finds the depths of the corners below the free surface, and shifts interfaces,
   such that cells have the volumes of particles; collective */
PetscErrorCode StrainVolumes(const Scene *scene, const Particles *p, const StrainLattice *l,
                             StrainNodes *corners)
{
  PetscFunctionBegin;
  PetscCall(PetscMalloc1(corners->all, &corners->depth));
  PetscCall(FindSurface(scene, p, l, corners));
  if (p->fluid) PetscCall(FindInterfaces(scene, p, l, corners));
  PetscFunctionReturn(PETSC_SUCCESS);
}
