/* Points of quadrature of the splines, in the cells of the lattice and on the boundary. */
#include "splines.h"

#define FACE_PARTS 16   /* of a face, in which its first open one is looked for */
#define INSIDE     1e-6 /* way into the fluid, of points on surfaces [cells] */
#define HALVINGS   40   /* of a part, in which a body ends */

/* SplinePointsFree - Frees the points; not collective */
PetscErrorCode SplinePointsFree(SplinePoints *points)
{
  PetscFunctionBegin;
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) {
    PetscCall(FreeAll(&points->x[a], &points->normal[a], &points->stretch[a]));
  }
  PetscCall(PetscFree3(points->weight, points->side, points->patch));
  points->n = points->capacity = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode PointsReserve(PetscInt dim, PetscInt n, SplinePoints *points)
{
  PetscFunctionBegin;
  PetscCall(SplinePointsFree(points));
  for (PetscInt a = 0; a < dim; a++) PetscCall(PetscMalloc1(n, &points->x[a]));
  PetscCall(PetscMalloc3(n, &points->weight, n, &points->side, n, &points->patch));
  for (PetscInt g = 0; g < n; g++) points->patch[g] = -1;
  points->capacity = n;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void PointsAdd(PetscInt dim, const PetscReal x[], PetscReal weight, PetscInt side,
                      SplinePoints *points)
{
  for (PetscInt a = 0; a < dim; a++) points->x[a][points->n] = x[a];
  points->weight[points->n] = weight;
  points->side[points->n++] = side;
}

/* Computes the cells that overlap the box of this rank along each axis; returns their number. */
static PetscInt OwnCells(const Splines *s, const Particles *p, PetscInt first[], PetscInt n[])
{
  const SplineLattice *l      = &s->lattice;
  PetscInt             number = 1;

  for (PetscInt a = 0; a < l->dim; a++) {
    const PetscReal from = SceneToUniform(l->scene, a, p->lo[a]);
    const PetscReal to   = SceneToUniform(l->scene, a, p->hi[a]);
    const PetscReal low  = PetscMax((from - l->lo[a]) / l->side[a], 0.0);
    const PetscReal high = PetscMin((to - l->lo[a]) / l->side[a], (PetscReal)l->cells[a]);

    first[a] = (PetscInt)low;
    n[a]     = PetscMax(0, PetscMin((PetscInt)high, l->cells[a] - 1) - first[a] + 1);
    number *= n[a];
  }
  return number;
}

/* Returns true in a cell with a whole face on the side: false in one that a body fills, and in 3D
   in one that it cuts, which has patches. */
static PetscBool HasFace(const Splines *s, const PetscReal x[])
{
  const PetscInt cell = s->bodies ? SplineCellAt(&s->lattice, x) : 0;

  if (!s->bodies) return PETSC_TRUE;
  if (s->lattice.dim == 3 && s->bodies->cut[cell] >= 0) return PETSC_FALSE;
  return s->bodies->fraction[cell] > 0.0;
}

/* Adds the points of this rank on a part of the surface of a body, three along it. Polynomials of
   degree 5 are integrated exactly. */
static void AddSurface(const Particles *p, const SplineSurface *part, Splines *s)
{
  static const PetscReal rule[3][2] = {{-0.77459666924148337704, 5.0 / 18.0},
                                       {0.0, 4.0 / 9.0},
                                       {0.77459666924148337704, 5.0 / 18.0}};

  for (PetscInt k = 0; k < 3; k++) {
    PetscReal x[ISPH_MAX_DIM] = {0.0}, inside[ISPH_MAX_DIM] = {0.0};

    for (PetscInt a = 0; a < 2; a++)
      x[a] = 0.5 * ((1.0 - rule[k][0]) * part->from[a] + (1.0 + rule[k][0]) * part->to[a]);
    for (PetscInt a = 0; a < 2; a++)
      inside[a] = x[a] - INSIDE * s->lattice.side[a] * part->normal[a];
    if (!ParticlesHolds(p, inside)) continue;
    for (PetscInt a = 0; a < 2; a++) s->boundary.normal[a][s->boundary.n] = part->normal[a];
    PointsAdd(2, x, rule[k][1] * part->length / s->scale, part->side, &s->boundary);
  }
}

/* Adds the points of this rank on a patch: its nodes, for each component of the velocity, or for
   that across a side of the box. */
static void AddPatch(const Particles *p, PetscInt number, Splines *s)
{
  const SplineLattice *l     = &s->lattice;
  const SplinePatch   *patch = &s->bodies->patches[number];
  PetscInt             cell[ISPH_MAX_DIM];
  PetscReal            centre[ISPH_MAX_DIM];

  if (patch->side < 6 && l->given[patch->side]) return;
  SplineIndex(3, NULL, l->cells, patch->cell, cell);
  for (PetscInt a = 0; a < 3; a++) centre[a] = l->lo[a] + (cell[a] + 0.5) * l->side[a];
  if (!ParticlesHolds(p, centre)) return;
  for (PetscInt e = 0; e < 12; e++) {
    const PetscInt axis = e % 3;

    if (patch->side < 6 && axis != patch->side / 2) continue;
    s->boundary.normal[axis][s->boundary.n] = 1.0;
    s->boundary.patch[s->boundary.n]        = 12 * number + e;
    PointsAdd(3, patch->x[e / 3], 1.0, patch->side, &s->boundary);
  }
}

/* Returns true if no body covers the point y along a side in 2D, in coordinates of the lattice. */
static PetscBool IsOpen(const SplineLattice *l, PetscInt side, PetscReal y)
{
  const PetscInt along           = 1 - side / 2;
  PetscReal      x[ISPH_MAX_DIM] = {0.0}, normal[ISPH_MAX_DIM], slope;
  PetscInt       nearest;

  x[side / 2] = side % 2 ? l->scene->hi[side / 2] : l->scene->lo[side / 2];
  x[along]    = SceneFromUniform(l->scene, along, y, &slope);
  return SceneDistance(l->scene, x, &nearest, normal) > 0.0;
}

/* Cuts a face of a side in 2D to the part that no body covers: without a flux through the rest, or
   an opening that a body ends between knots has a flux that differs from that of its velocity. */
static void CutFace(const SplineLattice *l, PetscInt side, PetscReal part[2])
{
  const PetscReal length = part[1] - part[0], whole[2] = {part[0], part[1]};

  for (PetscInt end = 0; end < 2; end++) {
    PetscReal covered = whole[end], open = covered, step = (end ? -length : length) / FACE_PARTS;

    for (PetscInt k = 0; k < FACE_PARTS && !IsOpen(l, side, open); k++) open += step;
    for (PetscInt k = 0; open != covered && k < HALVINGS; k++) {
      const PetscReal middle = open - 0.5 * step;

      step *= 0.5;
      if (IsOpen(l, side, middle)) open = middle;
    }
    part[end] = open;
  }
  if ((part[1] - part[0]) <= 0.0) part[1] = part[0];
}

/* Sets the points of this rank on the sides of the box that are not periodic, two along each axis
   of a cell's face, and on bodies. */
static PetscErrorCode SetBoundaryPoints(Splines *s, const Particles *p)
{
  const SplineLattice *l   = &s->lattice;
  const PetscInt       dim = l->dim, corners = 1 << (dim - 1);
  PetscInt             first[ISPH_MAX_DIM], n[ISPH_MAX_DIM], most = 0;

  PetscFunctionBegin;
  (void)OwnCells(s, p, first, n);
  for (PetscInt a = 0; a < dim; a++) {
    PetscInt faces = 2 * corners;

    for (PetscInt b = 0; b < dim; b++) faces *= b == a ? 1 : n[b];
    most += faces;
  }
  if (s->bodies) most += 3 * s->bodies->n_surface + 12 * s->bodies->n_patches;
  PetscCall(PointsReserve(dim, most, &s->boundary));
  for (PetscInt a = 0; a < dim; a++) PetscCall(PetscCalloc1(most, &s->boundary.normal[a]));
  for (PetscInt side = 0; side < 2 * dim; side++) {
    const PetscInt axis  = side / 2;
    PetscInt       faces = 1;

    if (l->periodic[axis] || l->given[side]) continue; /* the splines are zero where p is given */
    for (PetscInt b = 0; b < dim; b++) faces *= b == axis ? 1 : n[b];
    for (PetscInt f = 0; f < faces * corners; f++) {
      PetscInt  cell = f / corners, corner = f % corners;
      PetscReal x[ISPH_MAX_DIM], inside[ISPH_MAX_DIM], weight = 1.0 / corners, slope, part[2];

      for (PetscInt b = 0; b < dim; b++) {
        if (b == axis) {
          x[b]      = l->lo[b] + (side % 2 ? l->cells[b] * l->side[b] : 0.0);
          inside[b] = l->lo[b] + (side % 2 ? l->cells[b] - 0.25 : 0.25) * l->side[b];
          inside[b] = SceneFromUniform(l->scene, b, inside[b], &slope);
          continue;
        }
        part[0] = l->lo[b] + (first[b] + cell % n[b]) * l->side[b];
        part[1] = part[0] + l->side[b];
        if (dim == 2 && s->bodies) CutFace(l, side, part);
        x[b] = part[0] + (0.5 + (corner % 2 ? GAUSS : -GAUSS)) * (part[1] - part[0]);
        x[b] = inside[b] = SceneFromUniform(l->scene, b, x[b], &slope);
        weight *= slope * (part[1] - part[0]) / s->scale;
        cell /= n[b];
        corner /= 2;
      }
      if (!ParticlesHolds(p, inside) || !HasFace(s, inside)) continue;
      s->boundary.normal[axis][s->boundary.n] = side % 2 ? 1.0 : -1.0;
      PointsAdd(dim, x, weight, side, &s->boundary);
    }
  }
  for (PetscInt k = 0; s->bodies && k < s->bodies->n_surface; k++)
    AddSurface(p, &s->bodies->surface[k], s);
  for (PetscInt k = 0; s->bodies && k < s->bodies->n_patches; k++) AddPatch(p, k, s);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplinePoint - Computes a point of quadrature of a cell: a point of Gauss, or a node of a cut
   cell. Not collective. Output: x [m]; node - as SplinePoints.side. Returns: the volume of the
   point over that of a cell. */
PetscReal SplinePoint(const Splines *s, const PetscInt cell[], PetscInt corner, PetscReal x[],
                      PetscInt *node)
{
  const SplineLattice *l       = &s->lattice;
  const PetscInt       corners = 1 << l->dim;
  PetscReal            share   = 1.0 / corners;
  PetscInt             number;

  *node = -1;
  for (PetscInt a = 0; a < l->dim; a++) {
    PetscReal slope;

    x[a] = l->lo[a] + (cell[a] + 0.5 + ((corner >> a) % 2 ? GAUSS : -GAUSS)) * l->side[a];
    x[a] = SceneFromUniform(l->scene, a, x[a], &slope);
    share *= slope;
  }
  if (!s->bodies) return share;
  number = cell[0] + l->cells[0] * (cell[1] + (l->dim == 3 ? l->cells[1] * cell[2] : 0));
  if (s->bodies->cut[number] >= 0) {
    *node = corners * s->bodies->cut[number] + corner;
    SplineCutNode(l->dim, &s->bodies->cuts[s->bodies->cut[number]], corner, x);
  }
  return s->bodies->fraction[number] / corners;
}

/* Returns true if this rank has a point of quadrature: the nodes of a cut cell, which may be
   outside the box, are on the rank of its centre. */
static PetscBool SplineHolds(const Splines *s, const Particles *p, PetscInt node,
                             const PetscReal x[])
{
  const PetscInt nodes = 1 << s->lattice.dim;

  return ParticlesHolds(p, node >= 0 ? s->bodies->cuts[node / nodes].centre : x);
}

/* Sets the stretches of points inside, which many fits use. */
static PetscErrorCode SetStretches(const Scene *scene, SplinePoints *points)
{
  PetscFunctionBegin;
  if (!SceneIsGraded(scene)) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt a = 0; a < scene->dim; a++) PetscCall(PetscMalloc1(points->n, &points->stretch[a]));
  for (PetscInt g = 0; g < points->n; g++) {
    PetscReal x[ISPH_MAX_DIM] = {0.0}, stretch[ISPH_MAX_DIM], ratio;

    for (PetscInt a = 0; a < scene->dim; a++) x[a] = points->x[a][g];
    SceneStretch(scene, x, stretch);
    ratio = SceneCoarsest(scene) / SceneSpacing(scene, x);
    for (PetscInt a = 0; a < scene->dim; a++) points->stretch[a][g] = stretch[a] * ratio;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the points of this rank in the cells. */
static PetscErrorCode SetInnerPoints(Splines *s, const Particles *p)
{
  const SplineLattice *l       = &s->lattice;
  const PetscInt       corners = 1 << l->dim;
  PetscInt             first[ISPH_MAX_DIM], n[ISPH_MAX_DIM];
  const PetscInt       cells = OwnCells(s, p, first, n);

  PetscFunctionBegin;
  PetscCall(PointsReserve(l->dim, cells * corners, &s->inside));
  for (PetscInt k = 0; k < cells * corners; k++) {
    PetscInt  rest = k / corners, cell[ISPH_MAX_DIM], node;
    PetscReal x[ISPH_MAX_DIM], weight;

    for (PetscInt a = 0; a < l->dim; a++) {
      cell[a] = first[a] + rest % n[a];
      rest /= n[a];
    }
    weight = SplinePoint(s, cell, k % corners, x, &node);
    if (weight > 0.0 && SplineHolds(s, p, node, x)) PointsAdd(l->dim, x, weight, node, &s->inside);
  }
  PetscCall(SetStretches(l->scene, &s->inside));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplinePointsSet - Sets the points in the box of this rank; not collective */
PetscErrorCode SplinePointsSet(Splines *s, const Particles *p)
{
  PetscFunctionBegin;
  PetscCall(SetInnerPoints(s, p));
  PetscCall(SetBoundaryPoints(s, p));
  PetscFunctionReturn(PETSC_SUCCESS);
}
