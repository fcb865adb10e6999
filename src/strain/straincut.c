/* The part of a cell that surfaces leave, which are given by distances at the corners. In 2D a
   boundary of the fluid cuts it first, then an interface of fluids, so that parts fill the cell. */
#include "geometry/cutcube.h"
#include "strain.h"

/* Sets the part to the whole cell. */
static void SetWhole(PetscInt dim, const PetscReal lo[], const PetscReal edge[], CellPart *part)
{
  part->volume = 1.0;
  for (PetscInt a = 0; a < dim; a++) part->volume *= edge[a];
  for (PetscInt side = 0; side < 2 * dim; side++) {
    part->area[side] = part->volume / edge[side / 2];
    for (PetscInt a = 0; a < dim; a++) part->at[side][a] = lo[a] + 0.5 * edge[a];
    part->at[side][side / 2] = lo[side / 2] + (side % 2 ? edge[side / 2] : 0.0);
  }
}

/* A corner of a polygon: its place over the lower corner of the cell, the distances there, and the
   edge that begins there. */
typedef struct {
  PetscReal x[2], d[2]; /* from the surface, from the interface [m] */
  PetscInt  edge;       /* side of the cell, or a surface */
} Vertex;

enum { EDGE_SURFACE = 4, EDGE_INTERFACE };
#define VERTICES 16

/* Keeps the part of a polygon of n corners with positive distances d[by]; returns its corners. */
static PetscInt Clip(PetscInt n, const Vertex from[], PetscInt by, Vertex to[])
{
  PetscInt m = 0;

  for (PetscInt e = 0; e < n; e++) {
    const Vertex   *v[2] = {&from[e], &from[(e + 1) % n]};
    const PetscReal at[] = {v[0]->d[by], v[1]->d[by]};
    const PetscReal t    = at[0] == at[1] ? 0.0 : at[0] / (at[0] - at[1]);

    if (at[0] > 0.0) to[m++] = *v[0];
    if ((at[0] > 0.0) == (at[1] > 0.0)) continue;
    for (PetscInt a = 0; a < 2; a++) {
      to[m].x[a] = v[0]->x[a] + t * (v[1]->x[a] - v[0]->x[a]);
      to[m].d[a] = v[0]->d[a] + t * (v[1]->d[a] - v[0]->d[a]);
    }
    to[m].d[by]  = 0.0;
    to[m++].edge = at[0] > 0.0 ? EDGE_SURFACE + by : v[0]->edge;
  }
  return m;
}

/* Adds a straight part of a surface between two points, unless they are the same. */
static void AddSurface(const PetscReal lo[], const Vertex *from, const Vertex *to, CellPart *part)
{
  const PetscInt k = part->n_surface;

  if (from->x[0] == to->x[0] && from->x[1] == to->x[1]) return;
  part->normal[k][0] = to->x[1] - from->x[1];
  part->normal[k][1] = from->x[0] - to->x[0];
  for (PetscInt a = 0; a < 2; a++) {
    part->place[k][a]     = lo[a] + 0.5 * (from->x[a] + to->x[a]);
    part->corner[k][0][a] = lo[a] + from->x[a];
    part->corner[k][1][a] = lo[a] + to->x[a];
  }
  part->between[part->n_surface++] = from->edge == EDGE_INTERFACE ? PETSC_TRUE : PETSC_FALSE;
}

/* Sets the part of a rectangle: a polygon, along whose edges the distances are linear. */
static void CutRectangle(const PetscReal lo[], const PetscReal edge[], const PetscReal d[],
                         const PetscReal phi[], CellPart *part)
{
  static const PetscInt ring[] = {0, 1, 3, 2}, side[] = {2, 1, 3, 0};
  Vertex                v[2][VERTICES];
  PetscReal             middle = 0.0;
  PetscInt              n = 4, m = 0, between[3], next[VERTICES];

  for (PetscInt e = 0; e < 4; e++) {
    const PetscInt c = ring[e];

    v[0][e] = (Vertex){.x    = {(c & 1) * edge[0], (c >> 1) * edge[1]},
                       .d    = {d[c], phi ? phi[c] : 1.0},
                       .edge = side[e]};
  }
  n = Clip(n, v[0], 0, v[1]);
  for (PetscInt e = 0; e < n; e++) middle += v[1][e].d[1];
  n = Clip(n, v[1], 1, v[0]);
  for (PetscInt e = 0; e < n; e++) {
    next[e] = (e + 1) % n;
    if (v[0][e].edge == EDGE_INTERFACE && m < 3) between[m++] = e;
  }
  if (m == 2 && middle < 0.0) { /* the other fluid has the middle of a saddle: two parts */
    next[between[0]] = (between[1] + 1) % n;
    next[between[1]] = (between[0] + 1) % n;
  }
  for (PetscInt e = 0; e < n; e++) {
    const Vertex  *from = &v[0][e], *to = &v[0][next[e]];
    const PetscInt s = from->edge;

    part->volume += 0.5 * (from->x[0] * to->x[1] - from->x[1] * to->x[0]);
    if (s >= EDGE_SURFACE) {
      AddSurface(lo, from, to, part);
      continue;
    }
    part->area[s] = PetscAbsReal(to->x[0] - from->x[0]) + PetscAbsReal(to->x[1] - from->x[1]);
    for (PetscInt a = 0; a < 2; a++) part->at[s][a] = lo[a] + 0.5 * (from->x[a] + to->x[a]);
  }
}

/* Computes the area vector of a triangle in a unit cube that is stretched to a cell. */
static void TriangleArea(PetscReal x[3][3], const PetscReal edge[], PetscReal area[])
{
  for (PetscInt a = 0; a < 3; a++) {
    const PetscInt  b = (a + 1) % 3, c = (a + 2) % 3;
    const PetscReal u[2] = {x[1][b] - x[0][b], x[1][c] - x[0][c]};
    const PetscReal v[2] = {x[2][b] - x[0][b], x[2][c] - x[0][c]};

    area[a] = 0.5 * (u[0] * v[1] - u[1] * v[0]) * edge[b] * edge[c];
  }
}

static PetscReal TriangleCentre(PetscReal x[3][3], PetscInt a)
{
  return (x[0][a] + x[1][a] + x[2][a]) / 3.0;
}

/* Returns the value at x of the numbers d of the corners of a cuboid. */
static PetscReal ValueIn(const PetscReal lo[], const PetscReal edge[], const PetscReal d[],
                         const PetscReal x[])
{
  PetscReal sum = 0.0;

  for (PetscInt c = 0; c < 8; c++) {
    PetscReal w = d[c];

    for (PetscInt a = 0; a < 3; a++) {
      const PetscReal t = (x[a] - lo[a]) / edge[a];

      w *= (c >> a) & 1 ? t : 1.0 - t;
    }
    sum += w;
  }
  return sum;
}

/* Sets the part of a cuboid, see CubeCut(). A surface is that to which its middle is nearer. */
static void CutCuboid(const PetscReal lo[], const PetscReal edge[], const PetscReal outer[],
                      const PetscReal phi[], CellPart *part)
{
  static const PetscReal origin[3] = {0.0};
  PetscReal              d[8];
  CubePieces             pieces;

  for (PetscInt c = 0; c < 8; c++) d[c] = phi ? PetscMin(outer[c], phi[c]) : outer[c];
  CubeCut(origin, 1.0, d, &pieces);
  for (PetscInt t = 0; t < pieces.n_tetrahedra; t++) {
    PetscReal(*x)[3] = pieces.tetrahedron[t], area[3], six = 0.0;

    TriangleArea(x, edge, area);
    for (PetscInt a = 0; a < 3; a++) six += 2.0 * area[a] * (x[3][a] - x[0][a]) * edge[a];
    part->volume += PetscAbsReal(six) / 6.0;
  }
  part->n_surface = pieces.n_triangles;
  for (PetscInt t = 0; t < pieces.n_triangles; t++) {
    TriangleArea(pieces.triangle[t], edge, part->normal[t]);
    for (PetscInt a = 0; a < 3; a++) {
      part->place[t][a] = lo[a] + edge[a] * TriangleCentre(pieces.triangle[t], a);
      for (PetscInt v = 0; v < 3; v++)
        part->corner[t][v][a] = lo[a] + edge[a] * pieces.triangle[t][v][a];
    }
    part->between[t] =
        phi && ValueIn(lo, edge, phi, part->place[t]) < ValueIn(lo, edge, outer, part->place[t]);
  }
  for (PetscInt side = 0; side < 6; side++) {
    PetscReal sum = 0.0, moment[3] = {0.0};

    CubeCutFace(origin, 1.0, d, side, &pieces);
    for (PetscInt t = 0; t < pieces.n_triangles; t++) {
      PetscReal area[3];

      TriangleArea(pieces.triangle[t], edge, area);
      sum += PetscAbsReal(area[side / 2]);
      for (PetscInt a = 0; a < 3; a++)
        moment[a] += PetscAbsReal(area[side / 2]) * TriangleCentre(pieces.triangle[t], a);
    }
    part->area[side] = sum;
    for (PetscInt a = 0; a < 3 && sum > 0.0; a++)
      part->at[side][a] = lo[a] + edge[a] * moment[a] / sum;
  }
}

/* StrainCut - Computes the part of a cell with positive distances d and phi at its corners, first
   axis fastest; not collective. Input: d - from outer surfaces; phi - from an interface of fluids,
   NULL: none. */
void StrainCut(PetscInt dim, const PetscReal lo[], const PetscReal edge[], const PetscReal d[],
               const PetscReal phi[], CellPart *part)
{
  PetscInt inside = 0;

  part->n_surface = 0;
  part->volume    = 0.0;
  for (PetscInt side = 0; side < 2 * dim; side++) {
    part->area[side] = 0.0;
    for (PetscInt a = 0; a < dim; a++) part->at[side][a] = 0.0;
  }
  for (PetscInt k = 0; k < 1 << dim; k++) inside += d[k] > 0.0 && (!phi || phi[k] > 0.0);
  if (inside == 1 << dim) SetWhole(dim, lo, edge, part);
  else if (dim == 2) CutRectangle(lo, edge, d, phi, part);
  else if (inside) CutCuboid(lo, edge, d, phi, part);
  for (PetscInt a = 0; a < dim; a++) {
    PetscReal sum = 0.0, area = 0.0;

    for (PetscInt side = 0; side < 2 * dim; side++) {
      sum += part->area[side] * part->at[side][a];
      area += part->area[side];
    }
    part->centre[a] = area > 0.0 ? sum / area : lo[a] + 0.5 * edge[a];
  }
}
