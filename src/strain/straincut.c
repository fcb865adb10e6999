/* The part of a cell that a surface leaves, which is given by distances at the corners. */
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

/* Adds an edge of a polygon to its area. */
static void AddEdge(const PetscReal from[], const PetscReal to[], CellPart *part)
{
  part->volume += 0.5 * (from[0] * to[1] - from[1] * to[0]);
}

/* Adds a straight part of the surface between two points, unless they are the same. */
static void AddSurface(const PetscReal from[], const PetscReal to[], CellPart *part)
{
  const PetscInt k = part->n_surface;

  if (from[0] == to[0] && from[1] == to[1]) return;
  part->normal[k][0] = to[1] - from[1];
  part->normal[k][1] = from[0] - to[0];
  for (PetscInt a = 0; a < 2; a++) {
    part->place[k][a]     = 0.5 * (from[a] + to[a]);
    part->corner[k][0][a] = from[a];
    part->corner[k][1][a] = to[a];
  }
  part->n_surface++;
  AddEdge(from, to, part);
}

/* Sets the part of a rectangle: a polygon, along whose edges the distance is linear. Input: origin
   of the area, near the cell. */
static void CutRectangle(const PetscReal lo[], const PetscReal edge[], const PetscReal d[],
                         CellPart *part)
{
  static const PetscInt ring[] = {0, 1, 3, 2}, side[] = {2, 1, 3, 0};
  PetscReal             first[2] = {0.0}, last[2] = {0.0};
  PetscBool             begun = PETSC_FALSE;

  for (PetscInt e = 0; e < 4; e++) {
    const PetscInt  c[2]      = {ring[e], ring[(e + 1) % 4]};
    const PetscReal at[2]     = {d[c[0]], d[c[1]]};
    PetscReal       end[2][2] = {{0.0}};

    if (at[0] <= 0.0 && at[1] <= 0.0) continue;
    for (PetscInt a = 0; a < 2; a++) {
      const PetscReal x[2] = {((c[0] >> a) & 1) * edge[a], ((c[1] >> a) & 1) * edge[a]};

      for (PetscInt k = 0; k < 2; k++)
        end[k][a] = at[k] > 0.0 ? x[k] : x[0] + at[0] / (at[0] - at[1]) * (x[1] - x[0]);
      part->at[side[e]][a] = 0.5 * (end[0][a] + end[1][a]);
    }
    part->area[side[e]] = PetscAbsReal(end[1][0] - end[0][0]) + PetscAbsReal(end[1][1] - end[0][1]);
    if (begun) AddSurface(last, end[0], part);
    else
      for (PetscInt a = 0; a < 2; a++) first[a] = end[0][a];
    begun = PETSC_TRUE;
    AddEdge(end[0], end[1], part);
    for (PetscInt a = 0; a < 2; a++) last[a] = end[1][a];
  }
  if (begun) AddSurface(last, first, part);
  for (PetscInt a = 0; a < 2; a++) {
    for (PetscInt s = 0; s < 4; s++) part->at[s][a] += lo[a];
    for (PetscInt k = 0; k < part->n_surface; k++) {
      part->place[k][a] += lo[a];
      for (PetscInt v = 0; v < 2; v++) part->corner[k][v][a] += lo[a];
    }
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

/* Sets the part of a cuboid, see CubeCut(). */
static void CutCuboid(const PetscReal lo[], const PetscReal edge[], const PetscReal d[],
                      CellPart *part)
{
  static const PetscReal origin[3] = {0.0};
  CubePieces             pieces;

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

/* StrainCut - Computes the part of a cell with positive distances d at its corners, first axis
   fastest; not collective */
void StrainCut(PetscInt dim, const PetscReal lo[], const PetscReal edge[], const PetscReal d[],
               CellPart *part)
{
  PetscInt inside = 0;

  part->n_surface = 0;
  part->volume    = 0.0;
  for (PetscInt side = 0; side < 2 * dim; side++) {
    part->area[side] = 0.0;
    for (PetscInt a = 0; a < dim; a++) part->at[side][a] = 0.0;
  }
  for (PetscInt k = 0; k < 1 << dim; k++) inside += d[k] > 0.0 ? 1 : 0;
  if (inside == 1 << dim) SetWhole(dim, lo, edge, part);
  else if (inside && dim == 2) CutRectangle(lo, edge, d, part);
  else if (inside) CutCuboid(lo, edge, d, part);
  for (PetscInt a = 0; a < dim; a++) {
    PetscReal sum = 0.0, area = 0.0;

    for (PetscInt side = 0; side < 2 * dim; side++) {
      sum += part->area[side] * part->at[side][a];
      area += part->area[side];
    }
    part->centre[a] = area > 0.0 ? sum / area : lo[a] + 0.5 * edge[a];
  }
}
