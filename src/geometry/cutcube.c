/*
  Cubes cut by a surface that is given by distances at their corners: six tetrahedra about the
  diagonal of a cube, in each of which the distance is linear. Neighbours have the same triangles on
  their common face, so that the surface is closed.

  References: H. W. Kuhn, IBM J. Res. Dev. 4 (1960) 518-524, for the tetrahedra; A. Doi, A. Koide,
  IEICE Trans. E74 (1991) 214-224, for the cuts
*/
#include "cutcube.h"

static void CornerOf(const PetscReal lo[3], PetscReal edge, PetscInt corner, PetscReal x[3])
{
  for (PetscInt a = 0; a < 3; a++) x[a] = lo[a] + ((corner >> a) & 1) * edge;
}

/* Computes the place between two corners at which the distance is zero. */
static void Crossing(const PetscReal x[3], PetscReal dx, const PetscReal y[3], PetscReal dy,
                     PetscReal place[3])
{
  for (PetscInt a = 0; a < 3; a++) place[a] = x[a] + dx / (dx - dy) * (y[a] - x[a]);
}

static void AddTetrahedron(const PetscReal *const corner[4], CubePieces *p)
{
  for (PetscInt e = 0; e < 12; e++)
    p->tetrahedron[p->n_tetrahedra][e / 3][e % 3] = corner[e / 3][e % 3];
  p->n_tetrahedra++;
}

/* Adds a triangle, turned so that its normal points away from a place. */
static void AddTriangle(const PetscReal *const corner[3], const PetscReal from[3], CubePieces *p)
{
  PetscReal(*x)[3] = p->triangle[p->n_triangles++], u[3], v[3], along = 0.0;

  for (PetscInt a = 0; a < 3; a++) {
    u[a] = corner[1][a] - corner[0][a];
    v[a] = corner[2][a] - corner[0][a];
  }
  for (PetscInt a = 0; a < 3; a++)
    along += (u[(a + 1) % 3] * v[(a + 2) % 3] - u[(a + 2) % 3] * v[(a + 1) % 3]) *
             (corner[0][a] - from[a]);
  for (PetscInt e = 0; e < 9; e++)
    x[e / 3][e % 3] = corner[along < 0.0 ? (3 - e / 3) % 3 : e / 3][e % 3];
}

/* Adds the tetrahedra of a prism between two triangles. */
static void AddPrism(const PetscReal *const a[3], const PetscReal *const b[3], CubePieces *p)
{
  AddTetrahedron((const PetscReal *[]){a[0], a[1], a[2], b[2]}, p);
  AddTetrahedron((const PetscReal *[]){a[0], a[1], b[1], b[2]}, p);
  AddTetrahedron((const PetscReal *[]){a[0], b[0], b[1], b[2]}, p);
}

/* Cuts a tetrahedron. */
static void Cut(PetscReal x[4][3], const PetscReal d[4], CubePieces *p)
{
  const PetscReal *in[4], *out[4];
  PetscReal        d_in[4], d_out[4], at[4][3];
  PetscInt         n = 0, m = 0;

  for (PetscInt k = 0; k < 4; k++) {
    if (d[k] > 0.0) {
      in[n]     = x[k];
      d_in[n++] = d[k];
    } else {
      out[m]     = x[k];
      d_out[m++] = d[k];
    }
  }
  if (n == 0) return;
  if (n == 4) {
    AddTetrahedron(in, p);
    return;
  }
  for (PetscInt k = 0; k < n * m; k++)
    Crossing(in[k / m], d_in[k / m], out[k % m], d_out[k % m], at[k]);
  AddTriangle((const PetscReal *[]){at[0], at[1], at[2]}, in[0], p);
  if (n == 2) AddTriangle((const PetscReal *[]){at[1], at[2], at[3]}, in[0], p);
  if (n == 1) AddTetrahedron((const PetscReal *[]){in[0], at[0], at[1], at[2]}, p);
  if (n == 3) AddPrism(in, (const PetscReal *[]){at[0], at[1], at[2]}, p);
  if (n == 2)
    AddPrism((const PetscReal *[]){in[0], at[0], at[1]}, (const PetscReal *[]){in[1], at[2], at[3]},
             p);
}

/* CubeCut - Computes the part of a cube with positive distances d at its corners, first axis
   fastest, and the surface */
void CubeCut(const PetscReal lo[3], PetscReal edge, const PetscReal d[8], CubePieces *p)
{
  p->n_tetrahedra = p->n_triangles = 0;
  for (PetscInt t = 0; t < 6; t++) {
    const PetscInt first = t % 3, second = (first + 1 + t / 3) % 3;
    const PetscInt corner[4] = {0, 1 << first, 1 << first | 1 << second, 7};
    PetscReal      x[4][3], at[4];

    for (PetscInt k = 0; k < 4; k++) {
      CornerOf(lo, edge, corner[k], x[k]);
      at[k] = d[corner[k]];
    }
    Cut(x, at, p);
  }
}

/* CubeCutFace - Computes the triangles with positive distances on a face of a cube, side 2 a or
   2 a + 1 along axis a, with normals out of the cube, as those of CubeCut() */
void CubeCutFace(const PetscReal lo[3], PetscReal edge, const PetscReal d[8], PetscInt side,
                 CubePieces *p)
{
  const PetscInt  axis = side / 2, b = 1 << (axis + 1) % 3, c = 1 << (axis + 2) % 3;
  const PetscInt  base = side % 2 ? 1 << axis : 0, middle[2] = {b, c};
  const PetscReal inside[3] = {lo[0] + 0.5 * edge, lo[1] + 0.5 * edge, lo[2] + 0.5 * edge};

  p->n_tetrahedra = p->n_triangles = 0;
  for (PetscInt t = 0; t < 2; t++) {
    const PetscInt corner[3] = {base, base | middle[t], base | b | c};
    PetscReal      x[3][3], at[4][3];
    PetscInt       n = 0;

    for (PetscInt k = 0; k < 3; k++) CornerOf(lo, edge, corner[k], x[k]);
    for (PetscInt k = 0; k < 3; k++) {
      const PetscInt  next = (k + 1) % 3;
      const PetscReal from = d[corner[k]], to = d[corner[next]];

      if (from > 0.0) {
        for (PetscInt a = 0; a < 3; a++) at[n][a] = x[k][a];
        n++;
      }
      if ((from > 0.0) != (to > 0.0)) Crossing(x[k], from, x[next], to, at[n++]);
    }
    for (PetscInt k = 2; k < n; k++)
      AddTriangle((const PetscReal *[]){at[0], at[k - 1], at[k]}, inside, p);
  }
}
