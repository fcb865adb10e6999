/*
  Bodies of any shape in the lattice of the splines in 3D. A cell near a surface is divided into 4^3
  cubes, and the distance from the bodies is linear in tetrahedra of each, see geometry/cutcube.c.
  The surface is then a closed polyhedron, and integrals over the fluid and over the surface are
  exact for it: those of the splines, which are polynomials in a cell, follow from the moments

    int t_x^i t_y^j t_z^k dV,   int t_x^i t_y^j t_z^k n dA,   i, j, k = 0 to 3,

  with the place t in the cell, from 0 to 1. The divergence of a linear velocity is exact to
  rounding. A cell has eight nodes c +- r_x +- r_y +- r_z: r_a is along a principal axis of the
  moments about the centroid c, and its square the principal moment. In a whole cell they are the
  points of Gauss.
*/
#include "splines.h"
#include "geometry/cutcube.h"

#define CUBES   4 /* along an edge of a cell */
#define NODES   (CUBES + 1)
#define SMALL   1e-10 /* of a cell, that counts neither as fluid nor as solid */
#define MOMENTS 64
#define LINEAR  4 /* linear functions: 1, t_x, t_y, t_z */

/* Moments of a part of the boundary in a cell, with the three components of n dA. */
typedef struct {
  PetscInt  side;
  PetscReal moment[ISPH_MAX_DIM][MOMENTS];
} Patch;

typedef struct {
  PetscReal distance[NODES * NODES * NODES]; /* [m] */
  PetscReal fluid[MOMENTS];
  PetscInt  n_patches;
  Patch     patch[WALL_PLANES];
} Cell;

/* Adds the moments of a point. */
static void AddPoint(const PetscReal t[3], PetscReal weight, PetscReal moment[MOMENTS])
{
  PetscReal power[3][4];

  for (PetscInt a = 0; a < 3; a++) {
    power[a][0] = 1.0;
    for (PetscInt e = 1; e < 4; e++) power[a][e] = power[a][e - 1] * t[a];
  }
  for (PetscInt k = 0; k < MOMENTS; k++)
    moment[k] += weight * power[0][k % 4] * power[1][k / 4 % 4] * power[2][k / 16];
}

/* Adds the moments of a cube that is all fluid. */
static void AddCube(const PetscReal lo[3], PetscReal moment[MOMENTS])
{
  const PetscReal edge = 1.0 / CUBES;

  for (PetscInt k = 0; k < 8; k++) {
    PetscReal t[3];

    for (PetscInt a = 0; a < 3; a++) t[a] = lo[a] + (0.5 + ((k >> a) % 2 ? GAUSS : -GAUSS)) * edge;
    AddPoint(t, 0.125 * edge * edge * edge, moment);
  }
}

/* Adds the moments of a tetrahedron by a rule of degree 6: P. Keast, Comput. Methods Appl. Mech.
   Eng. 55 (1986) 339-348. A point is the sum of its coordinates times the corners. */
static void AddTetrahedron(PetscReal x[4][3], PetscReal moment[MOMENTS])
{
  static const PetscReal rule[4][4] = {
      {0.214602871259151684, 0.214602871259151684, 0.356191386222544953, 0.0399227502581679010},
      {0.0406739585346113397, 0.0406739585346113397, 0.877978124396165982, 0.0100772110553206572},
      {0.322337890142275646, 0.322337890142275646, 0.0329863295731730594, 0.0553571815436543906},
      {0.0636610018750175299, 0.269672331458315867, 0.603005664791649076, 0.0482142857142857489}};
  PetscReal edge[3][3], volume;

  for (PetscInt e = 0; e < 9; e++) edge[e / 3][e % 3] = x[e / 3 + 1][e % 3] - x[0][e % 3];
  volume = edge[0][0] * (edge[1][1] * edge[2][2] - edge[1][2] * edge[2][1]) -
           edge[0][1] * (edge[1][0] * edge[2][2] - edge[1][2] * edge[2][0]) +
           edge[0][2] * (edge[1][0] * edge[2][1] - edge[1][1] * edge[2][0]);
  volume = PetscAbsReal(volume) / 6.0;
  if (volume == 0.0) return;
  for (PetscInt k = 0; k < 16; k++) { /* corners with the second and the third coordinate */
    const PetscInt second = k / 4, third = k % 4;

    for (PetscInt r = 0; r < 4; r++) {
      PetscReal t[3] = {0.0};

      if ((second == third) != (r < 3)) continue;
      for (PetscInt e = 0; e < 12; e++) {
        const PetscInt  corner = e / 3;
        const PetscReal share  = corner == third ? rule[r][2] : rule[r][corner == second ? 1 : 0];

        t[e % 3] += share * x[corner][e % 3];
      }
      AddPoint(t, rule[r][3] * volume, moment);
    }
  }
}

/* Adds the moments of a triangle times n dA by a rule of degree 8: D. A. Dunavant, Int. J. Numer.
   Meth. Eng. 21 (1985) 1129-1148. */
static void AddTriangle(PetscReal x[3][3], Patch *patch)
{
  static const PetscReal rule[5][4] = {
      {1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0, 0.144315607677787168},
      {0.459292588292723156, 0.459292588292723156, 0.0814148234145536878, 0.0950916342672846248},
      {0.170569307751760207, 0.170569307751760207, 0.658861384496479587, 0.103217370534718251},
      {0.0505472283170309755, 0.0505472283170309755, 0.898905543365938049, 0.0324584976231980803},
      {0.00839477740995760534, 0.263112829634638113, 0.728492392955404282, 0.0272303141744349943}};
  PetscReal moment[MOMENTS] = {0.0}, area[3];

  for (PetscInt a = 0; a < 3; a++) {
    const PetscInt b = (a + 1) % 3, c = (a + 2) % 3;

    area[a] = 0.5 * ((x[1][b] - x[0][b]) * (x[2][c] - x[0][c]) -
                     (x[1][c] - x[0][c]) * (x[2][b] - x[0][b]));
  }
  for (PetscInt k = 0; k < 9; k++) { /* corners with the second and the third coordinate */
    const PetscInt second = k / 3, third = k % 3;

    for (PetscInt r = k == 0 ? 0 : 1; r < 5; r++) {
      PetscReal t[3] = {0.0};

      if (r > 0 && (second == third) != (r < 4)) continue;
      for (PetscInt e = 0; e < 9; e++) {
        const PetscInt  corner = e / 3;
        const PetscReal share  = corner == third ? rule[r][2] : rule[r][corner == second ? 1 : 0];

        t[e % 3] += share * x[corner][e % 3];
      }
      AddPoint(t, rule[r][3], moment);
    }
  }
  for (PetscInt e = 0; e < 3 * MOMENTS; e++)
    patch->moment[e / MOMENTS][e % MOMENTS] += area[e / MOMENTS] * moment[e % MOMENTS];
}

/* Returns the moments of a boundary in a cell, which are zero at first. */
static Patch *PatchOf(PetscInt side, Cell *cell)
{
  Patch *patch = cell->patch;

  while (patch < cell->patch + cell->n_patches && patch->side != side) patch++;
  if (patch == cell->patch + WALL_PLANES) return patch - 1; /* of many boundaries in a cell */
  if (patch == cell->patch + cell->n_patches) {
    *patch = (Patch){.side = side};
    cell->n_patches++;
  }
  return patch;
}

/* Returns the number of the body that is nearest to the middle of a triangle in a cell. */
static PetscInt BodyAt(const SplineLattice *l, const PetscInt index[], PetscReal t[3][3])
{
  PetscReal x[ISPH_MAX_DIM], normal[ISPH_MAX_DIM];
  PetscInt  nearest;

  for (PetscInt a = 0; a < 3; a++)
    x[a] = l->lo[a] + (index[a] + (t[0][a] + t[1][a] + t[2][a]) / 3.0) * l->side[a];
  (void)SceneDistance(l->scene, x, &nearest, normal);
  return SceneBodySide(l->scene, nearest);
}

/* Adds the fluid of a cube of a cell, and the boundaries in it. */
static void AddCubeOf(const SplineLattice *l, const PetscInt index[], const PetscInt cube[],
                      Cell *cell)
{
  const PetscInt first = cube[0] + NODES * (cube[1] + NODES * cube[2]);
  PetscReal      lo[3], d[8];
  PetscInt       inside = 0;
  CubePieces     pieces;

  for (PetscInt k = 0; k < 8; k++) {
    d[k] = cell->distance[first + k % 2 + NODES * (k / 2 % 2 + NODES * (k / 4))];
    inside += d[k] > 0.0 ? 1 : 0;
  }
  if (!inside) return;
  for (PetscInt a = 0; a < 3; a++) lo[a] = (PetscReal)cube[a] / CUBES;
  if (inside == 8) {
    AddCube(lo, cell->fluid);
  } else {
    CubeCut(lo, 1.0 / CUBES, d, &pieces);
    for (PetscInt k = 0; k < pieces.n_tetrahedra; k++)
      AddTetrahedron(pieces.tetrahedron[k], cell->fluid);
    for (PetscInt k = 0; k < pieces.n_triangles; k++)
      AddTriangle(pieces.triangle[k], PatchOf(BodyAt(l, index, pieces.triangle[k]), cell));
  }
  for (PetscInt side = 0; side < 6; side++) {
    const PetscInt a = side / 2, last = l->cells[a] * CUBES - 1;

    if (l->periodic[a] || index[a] * CUBES + cube[a] != (side % 2 ? last : 0)) continue;
    CubeCutFace(lo, 1.0 / CUBES, d, side, &pieces);
    for (PetscInt k = 0; k < pieces.n_triangles; k++)
      AddTriangle(pieces.triangle[k], PatchOf(side, cell));
  }
}

/* Computes int t^L t^(i,j,k) with the coefficients of a polynomial along each axis. */
static PetscReal Contract(const PetscReal moment[MOMENTS], PetscInt linear,
                          const PetscReal *const c[3])
{
  static const PetscInt step[LINEAR] = {0, 1, 4, 16};
  PetscReal             sum          = 0.0;

  for (PetscInt k = 0; k < 27; k++)
    sum += c[0][k % 3] * c[1][k / 3 % 3] * c[2][k / 9] *
           moment[k % 3 + 4 * (k / 3 % 3) + 16 * (k / 9) + step[linear]];
  return sum;
}

/* Computes the integrals of spline k of a cell, or of t-derivatives of it along an axis, times all
   linear functions. */
static void Integrals(const PetscReal moment[MOMENTS], PetscInt k, PetscInt axis,
                      PetscReal integral[LINEAR])
{
  static const PetscReal value[3][3] = {{0.5, -1.0, 0.5}, {0.5, 1.0, -1.0}, {0.0, 0.0, 0.5}};
  static const PetscReal slope[3][3] = {{-1.0, 1.0, 0.0}, {1.0, -2.0, 0.0}, {0.0, 1.0, 0.0}};
  const PetscInt         digit[3]    = {k % 3, k / 3 % 3, k / 9};
  const PetscReal       *c[3];

  for (PetscInt a = 0; a < 3; a++) c[a] = a == axis ? slope[digit[a]] : value[digit[a]];
  for (PetscInt linear = 0; linear < LINEAR; linear++)
    integral[linear] = Contract(moment, linear, c);
}

/* Sets the centroid and the nodes of a cut cell. */
static PetscErrorCode SetNodes(const SplineLattice *l, const PetscInt index[],
                               const PetscReal moment[MOMENTS], SplineCut *cut)
{
  static const PetscInt first[3] = {1, 4, 16};
  PetscReal             K[9], M[9]    = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0}, V[9];
  PetscReal             square[3], h2 = PetscSqr(l->side[0]);

  PetscFunctionBegin;
  for (PetscInt a = 0; a < 3; a++) {
    cut->centre[a] = l->lo[a] + (index[a] + moment[first[a]] / moment[0]) * l->side[a];
    for (PetscInt b = 0; b < 3; b++)
      K[3 * a + b] = l->side[a] * l->side[b] *
                     (moment[first[a] + first[b]] / moment[0] -
                      moment[first[a]] * moment[first[b]] / PetscSqr(moment[0]));
  }
  PetscCall(DenseEigen(3, K, M, square, V));
  for (PetscInt r = 0; r < 3; r++) {
    const PetscReal reach = square[r] > 1e-10 * h2 ? PetscSqrtReal(square[r]) : 0.0;

    for (PetscInt a = 0; a < 3; a++) cut->reach[r][a] = reach * V[3 * a + r];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the coefficients of the linear function `constant` + slope.(x - centre) of a cell. */
static void SetLinear(const SplineLattice *l, const PetscInt index[], const PetscReal centre[],
                      PetscReal constant, const PetscReal slope[3], PetscReal share[LINEAR])
{
  share[0] = constant;
  for (PetscInt a = 0; a < 3; a++) {
    share[1 + a] = slope[a] * l->side[a];
    share[0] -= share[1 + a] * ((centre[a] - l->lo[a]) / l->side[a] - index[a]);
  }
}

/* Adds factor reach/reach^2 to a slope, unless the reach is zero. */
static void AddSlope(PetscReal factor, const PetscReal reach[3], PetscReal slope[3])
{
  const PetscReal square = PetscSqr(reach[0]) + PetscSqr(reach[1]) + PetscSqr(reach[2]);

  for (PetscInt a = 0; square > 0.0 && a < 3; a++) slope[a] += factor * reach[a] / square;
}

static PetscReal Dot(const PetscReal a[LINEAR], const PetscReal b[LINEAR])
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
}

/* Sets the integrals of a cut cell: the linear function of a node is
   1/8 (1 +- (x - c).r_x/r_x^2 +- (x - c).r_y/r_y^2 +- (x - c).r_z/r_z^2). */
static void SetIntegrals(const SplineLattice *l, const PetscInt index[],
                         const PetscReal moment[MOMENTS], SplineCut *cut)
{
  PetscReal share[8][LINEAR];

  for (PetscInt node = 0; node < 8; node++) {
    PetscReal slope[3] = {0.0};

    for (PetscInt r = 0; r < 3; r++)
      AddSlope((node >> r) % 2 ? 0.125 : -0.125, cut->reach[r], slope);
    SetLinear(l, index, cut->centre, 0.125, slope, share[node]);
  }
  for (PetscInt e = 0; e < 4 * SPLINES_AT_QUADRATIC; e++) {
    const PetscInt k = e % SPLINES_AT_QUADRATIC, axis = e / SPLINES_AT_QUADRATIC - 1;
    PetscReal      integral[LINEAR];

    Integrals(moment, k, axis, integral);
    for (PetscInt node = 0; node < 8; node++)
      cut->integral[node * 4 * SPLINES_AT_QUADRATIC + e] =
          Dot(share[node], integral) / (axis < 0 ? 1.0 : l->side[axis]);
  }
}

/* Sets the nodes of a patch and their linear functions. The velocity of a body is linear, and any
   four nodes c + d will do: 1/4 (1 + sum_a (x - c)_a/d_a). That of a side is any function, and the
   nodes are in the fluid: c +- sqrt(2) r, with r along the principal axes of the part of the side,
   as in cells of the plane. */
static PetscErrorCode SetPatchNodes(const SplineLattice *l, const PetscInt index[],
                                    const Patch *from, SplinePatch *patch,
                                    PetscReal share[4][LINEAR])
{
  SplineCut face = {.integral = NULL};

  PetscFunctionBegin;
  for (PetscInt a = 0; a < 3; a++) face.centre[a] = l->lo[a] + (index[a] + 0.5) * l->side[a];
  if (from->side < 6) PetscCall(SetNodes(l, index, from->moment[from->side / 2], &face));
  for (PetscInt m = 0; m < 4; m++) {
    const PetscReal sign = m % 2 ? 1.0 : -1.0, *reach = face.reach[1 + m / 2];
    PetscReal       slope[3] = {0.0};

    for (PetscInt a = 0; a < 3; a++) {
      const PetscReal step = 0.25 * (m == 0 || m == a + 1 ? 1.0 : -1.0) * l->side[a];

      patch->x[m][a] = face.centre[a] + (from->side < 6 ? PETSC_SQRT2 * sign * reach[a] : step);
      if (from->side >= 6) slope[a] = 0.25 / step;
    }
    if (from->side < 6) AddSlope(0.5 * sign / PETSC_SQRT2, reach, slope);
    SetLinear(l, index, face.centre, 0.25, slope, share[m]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the patches of a cell. */
static PetscErrorCode AddPatches(const SplineLattice *l, PetscInt number, const PetscInt index[],
                                 const Cell *cell, SplineBodies *s)
{
  const PetscReal scale = PetscPowReal(l->side[0] * l->side[1] * l->side[2], 1.0 / 3.0);

  PetscFunctionBegin;
  for (PetscInt p = 0; p < cell->n_patches; p++) {
    const PetscInt side = cell->patch[p].side;
    PetscReal      share[4][LINEAR];
    SplinePatch   *patch;

    if (side < 6 && s->cut[number] < 0) continue; /* whole faces have points */
    if (side < 6 && cell->patch[p].moment[side / 2][0] == 0.0) continue;
    if (s->n_patches == s->patch_capacity) {
      s->patch_capacity = 2 * s->patch_capacity + 64;
      PetscCall(PetscRealloc(sizeof(*s->patches) * (size_t)s->patch_capacity, &s->patches));
    }
    patch  = &s->patches[s->n_patches++];
    *patch = (SplinePatch){.cell = number, .side = side};
    PetscCall(SetPatchNodes(l, index, &cell->patch[p], patch, share));
    for (PetscInt e = 0; e < 3 * SPLINES_AT_QUADRATIC; e++) {
      const PetscInt k = e % SPLINES_AT_QUADRATIC, a = e / SPLINES_AT_QUADRATIC;
      PetscReal      integral[LINEAR];

      Integrals(cell->patch[p].moment[a], k, -1, integral);
      for (PetscInt m = 0; m < 4; m++)
        patch->integral[m][a][k] = Dot(share[m], integral) * scale / l->side[a];
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineCutAdd - Adds a cut cell with integrals of zero; not collective */
PetscErrorCode SplineCutAdd(PetscInt dim, SplineBodies *s, SplineCut **cut)
{
  const PetscInt size = dim == 3 ? 8 * 4 * SPLINES_AT_QUADRATIC : 4 * 3 * SPLINES_IN_PLANE;

  PetscFunctionBegin;
  if (s->n_cut == s->cut_capacity) {
    s->cut_capacity = 2 * s->cut_capacity + 64;
    PetscCall(PetscRealloc(sizeof(*s->cuts) * (size_t)s->cut_capacity, &s->cuts));
  }
  *cut  = &s->cuts[s->n_cut++];
  **cut = (SplineCut){.integral = NULL};
  PetscCall(PetscCalloc1(size, &(*cut)->integral));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the fluid of a cell near a surface. */
static PetscErrorCode SetCell(const SplineLattice *l, PetscInt number, Cell *cell, SplineBodies *s)
{
  const PetscInt width[3] = {NODES, NODES, NODES}, cubes[3] = {CUBES, CUBES, CUBES};
  PetscInt       index[3];

  PetscFunctionBegin;
  SplineIndex(3, NULL, l->cells, number, index);
  PetscCall(PetscArrayzero(cell->fluid, MOMENTS));
  cell->n_patches = 0;
  for (PetscInt k = 0; k < NODES * NODES * NODES; k++) {
    PetscInt  node[3], nearest;
    PetscReal x[ISPH_MAX_DIM], normal[ISPH_MAX_DIM];

    SplineIndex(3, NULL, width, k, node);
    for (PetscInt a = 0; a < 3; a++)
      x[a] = l->lo[a] + (PetscReal)(index[a] * CUBES + node[a]) / CUBES * l->side[a];
    cell->distance[k] = SceneDistance(l->scene, x, &nearest, normal);
    if (PetscAbsReal(cell->distance[k]) < SMALL * l->side[0]) cell->distance[k] = 0.0;
  }
  for (PetscInt k = 0; k < CUBES * CUBES * CUBES; k++) {
    PetscInt cube[3];

    SplineIndex(3, NULL, cubes, k, cube);
    AddCubeOf(l, index, cube, cell);
  }
  s->fraction[number] = cell->fluid[0] < 0.5 ? 0.0 : 1.0;
  if (cell->fluid[0] > SMALL && cell->fluid[0] < 1.0 - SMALL) {
    SplineCut *cut;

    PetscCall(SplineCutAdd(3, s, &cut));
    s->fraction[number] = cell->fluid[0];
    s->cut[number]      = s->n_cut - 1;
    PetscCall(SetNodes(l, index, cell->fluid, cut));
    SetIntegrals(l, index, cell->fluid, cut);
  }
  PetscCall(AddPatches(l, number, index, cell, s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineSolidsSet - Computes the fluid in all cells of a lattice in 3D. Cells farther from all
   surfaces than their corners are whole or empty. Not collective. */
PetscErrorCode SplineSolidsSet(const SplineLattice *l, SplineBodies *s)
{
  const PetscInt cells = l->cells[0] * l->cells[1] * l->cells[2];
  PetscReal      half  = 0.0;
  Cell          *cell;

  PetscFunctionBegin;
  PetscCall(PetscNew(&cell));
  for (PetscInt a = 0; a < 3; a++) half += PetscSqr(0.5 * l->side[a]);
  half = PetscSqrtReal(half);
  for (PetscInt c = 0; c < cells; c++) {
    PetscInt  index[3], nearest;
    PetscReal x[ISPH_MAX_DIM], normal[ISPH_MAX_DIM], distance;

    SplineIndex(3, NULL, l->cells, c, index);
    for (PetscInt a = 0; a < 3; a++) x[a] = l->lo[a] + (index[a] + 0.5) * l->side[a];
    distance       = SceneDistance(l->scene, x, &nearest, normal);
    s->fraction[c] = distance > 0.0 ? 1.0 : 0.0;
    s->cut[c]      = PetscAbsReal(distance) > 1.1 * half ? SPLINE_FAR : SPLINE_NEAR;
    if (s->cut[c] == SPLINE_NEAR) PetscCall(SetCell(l, c, cell, s));
  }
  PetscCall(PetscFree(cell));
  PetscFunctionReturn(PETSC_SUCCESS);
}
