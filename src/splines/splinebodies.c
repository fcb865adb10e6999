/*
  Bodies in the lattice of the splines. The surface of a body in the plane is an outline of straight
  pieces. A cell that it cuts has

  - points with signed weights, by which polynomials of degree 4 are integrated exactly over its
    fluid: in triangles between the centre of the cell and the pieces of outlines, see
    OutlinesUnite();
  - four nodes c +- sqrt(2 l_a) e_a, with the centroid c of the fluid, its principal second moments
    l_a and their axes e_a. The velocity in the cell is a linear function of its values there.

  The divergence of a linear velocity is then exact to rounding. All this follows from the scene
  alone, so that it is the same on all ranks. For 3D see splinesolids.c.
*/
#include "splines.h"
#include "geometry/outline.h"

#define WHOLE 1e-10 /* of a cell, that counts neither as fluid nor as solid */
#define OPEN  1e-6  /* of a cell, by which its fluid may be wrong */

/* Computes the corners of a cell of the plane [m]. */
static void SplineCell(const SplineLattice *l, PetscInt cell, PetscReal lo[2], PetscReal hi[2])
{
  for (PetscInt a = 0; a < 2; a++) {
    const PetscInt index = a == 0 ? cell % l->cells[0] : cell / l->cells[0];

    lo[a] = l->lo[a] + index * l->side[a];
    hi[a] = l->lo[a] + (index + 1) * l->side[a];
  }
}

/* Adds the points of a triangle of signed area, a rule of degree 4: D. A. Dunavant, Int. J. Numer.
   Meth. Eng. 21 (1985) 1129-1148. */
static void AddTriangle(const PetscReal c[], const PetscReal a[], const PetscReal b[],
                        PetscReal sign, PetscReal cell, SplineBodies *s)
{
  static const PetscReal rule[2][2] = {{0.44594849091596488632, 0.22338158967801146570},
                                       {0.09157621350977074346, 0.10995174365532186764}};
  const PetscReal        area =
      0.5 * ((a[0] - c[0]) * (b[1] - c[1]) - (a[1] - c[1]) * (b[0] - c[0])) / cell;

  if (area == 0.0) return;
  for (PetscInt k = 0; k < 6; k++) {
    const PetscReal  near = rule[k / 3][0], far = 1.0 - 2.0 * near;
    const PetscReal *corner[3] = {c, a, b};
    PetscReal        x[2]      = {0.0, 0.0};

    for (PetscInt m = 0; m < 3; m++) {
      for (PetscInt e = 0; e < 2; e++) x[e] += (m == k % 3 ? far : near) * corner[m][e];
    }
    for (PetscInt e = 0; e < 2; e++) s->x[e][s->n_points] = x[e];
    s->weight[s->n_points++] = sign * rule[k / 3][1] * area;
  }
}

static PetscErrorCode PointsReserve(PetscInt more, SplineBodies *s)
{
  PetscFunctionBegin;
  if (s->n_points + more <= s->capacity) PetscFunctionReturn(PETSC_SUCCESS);
  s->capacity = 2 * (s->n_points + more);
  for (PetscInt a = 0; a < 2; a++)
    PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)s->capacity, &s->x[a]));
  PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)s->capacity, &s->weight));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the points between the centre of a cell and a line from a to b, whose parts outside the cell
   are moved to its border along the axes. */
static PetscErrorCode AddLine(const PetscReal lo[2], const PetscReal hi[2], const PetscReal a[2],
                              const PetscReal b[2], PetscReal sign, SplineBodies *s)
{
  const PetscReal centre[2] = {0.5 * (lo[0] + hi[0]), 0.5 * (lo[1] + hi[1])};
  const PetscReal area      = (hi[0] - lo[0]) * (hi[1] - lo[1]);
  PetscReal       t[6]      = {0.0, 1.0}, from[2], to[2];
  PetscInt        n         = 2;

  PetscFunctionBegin;
  for (PetscInt e = 0; e < 4; e++) {
    const PetscReal limit = e % 2 ? hi[e / 2] : lo[e / 2], x = a[e / 2], y = b[e / 2];

    if ((x < limit) != (y < limit)) t[n++] = (limit - x) / (y - x);
  }
  PetscCall(PetscSortReal(n, t));
  PetscCall(PointsReserve(6 * n, s));
  for (PetscInt k = 0; k < n; k++) {
    for (PetscInt e = 0; e < 2; e++) {
      from[e] = to[e];
      to[e]   = PetscMin(PetscMax(k + 1 < n ? a[e] + t[k] * (b[e] - a[e]) : b[e], lo[e]), hi[e]);
    }
    if (k > 0) AddTriangle(centre, from, to, sign, area, s);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the points of the fluid in a cell; returns its share of the cell. */
static PetscErrorCode AddCell(const SplineLattice *l, PetscInt cell, PetscInt n,
                              const Outline outline[], PetscReal base, SplineBodies *s,
                              PetscReal *fraction)
{
  PetscReal lo[2], hi[2];

  PetscFunctionBegin;
  s->n_points = 0;
  SplineCell(l, cell, lo, hi);
  if (base != 0.0) {
    const PetscReal corner[5][2] = {
        {lo[0], lo[1]}, {hi[0], lo[1]}, {hi[0], hi[1]}, {lo[0], hi[1]}, {lo[0], lo[1]}};

    for (PetscInt k = 0; k < 4; k++) PetscCall(AddLine(lo, hi, corner[k], corner[k + 1], base, s));
  }
  for (PetscInt k = 0; k < n; k++) {
    if (OutlineIsApart(&outline[k], lo, hi)) continue;
    for (PetscInt m = 0; m < outline[k].pieces; m++)
      PetscCall(AddLine(lo, hi, &outline[k].piece[4 * m], &outline[k].piece[4 * m + 2],
                        outline[k].sign, s));
  }
  *fraction = 0.0;
  for (PetscInt g = 0; g < s->n_points; g++) *fraction += s->weight[g];
  UserCheck(PetscAbsReal(*fraction - 0.5) < 0.5 + OPEN,
            "-scene_body_<k>: near (%.6g, %.6g) surfaces of bodies that touch do not close; move "
            "one of them a little",
            (double)lo[0], (double)lo[1]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the nodes of a cut cell from the moments of its fluid. */
static void SetNodes(const SplineBodies *s, PetscReal fraction, PetscReal h2, SplineCut *cut)
{
  PetscReal m[3] = {0.0}, mean, spread, root[2];

  for (PetscInt a = 0; a < 2; a++) {
    cut->centre[a] = 0.0;
    for (PetscInt g = 0; g < s->n_points; g++) cut->centre[a] += s->weight[g] * s->x[a][g];
    cut->centre[a] /= fraction;
  }
  for (PetscInt g = 0; g < s->n_points; g++) {
    const PetscReal X = s->x[0][g] - cut->centre[0], Y = s->x[1][g] - cut->centre[1];

    m[0] += s->weight[g] * X * X / fraction;
    m[1] += s->weight[g] * X * Y / fraction;
    m[2] += s->weight[g] * Y * Y / fraction;
  }
  mean    = 0.5 * (m[0] + m[2]);
  spread  = PetscSqrtReal(PetscSqr(0.5 * (m[0] - m[2])) + PetscSqr(m[1]));
  root[0] = mean + spread;
  root[1] = mean - spread;
  for (PetscInt a = 0; a < 2; a++) {
    const PetscReal angle = 0.5 * PetscAtan2Real(2.0 * m[1], m[0] - m[2]) + 0.5 * PETSC_PI * a;
    const PetscReal reach = root[a] > 1e-10 * h2 ? PetscSqrtReal(2.0 * root[a]) : 0.0;

    cut->reach[a][0] = reach * PetscCosReal(angle);
    cut->reach[a][1] = reach * PetscSinReal(angle);
  }
}

/*
  Sets the integrals of a cut cell: the linear function of a node is

    1/4 +- (x - c).e_a/(2 sqrt(2 l_a))

  with the sign of the node along each principal axis e_a, and the spread l_a along it.
*/
static void SetIntegrals(const SplineLattice *l, const SplineBodies *s, SplineCut *cut)
{
  for (PetscInt g = 0; g < s->n_points; g++) {
    const PetscReal x[2] = {s->x[0][g], s->x[1][g]};
    SplineValues    at;

    SplinesAt(l, x, &at);
    for (PetscInt node = 0; node < 4; node++) {
      const PetscReal *reach = cut->reach[node / 2], sign = node % 2 ? 1.0 : -1.0;
      const PetscReal  square = PetscSqr(reach[0]) + PetscSqr(reach[1]);
      PetscReal        share  = 0.25;

      for (PetscInt a = 0; square > 0.0 && a < 2; a++)
        share += 0.5 * sign * (x[a] - cut->centre[a]) * reach[a] / square;
      for (PetscInt k = 0; k < at.n; k++) {
        PetscReal *integral = cut->integral + 3 * SPLINES_IN_PLANE * node + k;

        integral[0] += s->weight[g] * share * at.value[k];
        for (PetscInt a = 0; a < 2; a++)
          integral[(1 + a) * SPLINES_IN_PLANE] += s->weight[g] * share * at.gradient[a][k];
      }
    }
  }
}

/* Computes the fluid in all cells of the plane. Cells farther from all surfaces than their corners
   are whole or empty. */
static PetscErrorCode SetCells(const Scene *scene, const SplineLattice *l, PetscInt n,
                               const Outline outline[], PetscReal base, SplineBodies *s)
{
  const PetscInt  cells = l->cells[0] * l->cells[1];
  const PetscReal half  = 0.5 * PetscSqrtReal(PetscSqr(l->side[0]) + PetscSqr(l->side[1]));

  PetscFunctionBegin;
  for (PetscInt c = 0; c < cells; c++) {
    PetscReal lo[2], hi[2], x[ISPH_MAX_DIM] = {0.0}, normal[ISPH_MAX_DIM], distance;
    PetscInt  nearest;

    SplineCell(l, c, lo, hi);
    for (PetscInt a = 0; a < 2; a++) x[a] = 0.5 * (lo[a] + hi[a]);
    distance       = SceneDistance(scene, x, &nearest, normal);
    s->fraction[c] = distance > 0.0 ? 1.0 : 0.0;
    s->cut[c]      = PetscAbsReal(distance) > 1.1 * half ? SPLINE_FAR : SPLINE_NEAR;
    if (s->cut[c] == SPLINE_FAR) continue;
    PetscCall(AddCell(l, c, n, outline, base, s, &s->fraction[c]));
    if (s->fraction[c] > WHOLE && s->fraction[c] < 1.0 - WHOLE) {
      SplineCut *cut;

      PetscCall(SplineCutAdd(2, s, &cut));
      s->cut[c] = s->n_cut - 1;
      SetNodes(s, s->fraction[c], l->side[0] * l->side[1], cut);
      SetIntegrals(l, s, cut);
      continue;
    }
    s->fraction[c] = s->fraction[c] < 0.5 ? 0.0 : 1.0;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the part of a piece of surface from a to b in a cell, without its upper sides unless it is
   the last one. */
static PetscErrorCode AddSurface(const PetscReal a[], const PetscReal b[], const SplineLattice *l,
                                 PetscInt cell, PetscInt side, PetscReal sign, SplineBodies *s)
{
  const PetscReal d[2] = {b[0] - a[0], b[1] - a[1]};
  PetscReal       lo[2], hi[2];
  PetscReal       from = 0.0, to = 1.0, length;
  SplineSurface  *part;

  PetscFunctionBegin;
  SplineCell(l, cell, lo, hi);
  for (PetscInt e = 0; e < 2; e++) {
    const PetscInt  index = e == 0 ? cell % l->cells[0] : cell / l->cells[0];
    const PetscBool last  = index == l->cells[e] - 1 && !l->periodic[e];

    if (d[e] == 0.0) {
      if (a[e] < lo[e] || (last ? a[e] > hi[e] : a[e] >= hi[e])) PetscFunctionReturn(PETSC_SUCCESS);
      continue;
    }
    from = PetscMax(from, ((d[e] > 0.0 ? lo[e] : hi[e]) - a[e]) / d[e]);
    to   = PetscMin(to, ((d[e] > 0.0 ? hi[e] : lo[e]) - a[e]) / d[e]);
  }
  if (from >= to) PetscFunctionReturn(PETSC_SUCCESS);
  if (s->n_surface == s->surface_capacity) {
    s->surface_capacity = 2 * s->surface_capacity + 256;
    PetscCall(PetscRealloc(sizeof(*s->surface) * (size_t)s->surface_capacity, &s->surface));
  }
  part   = &s->surface[s->n_surface++];
  length = PetscSqrtReal(d[0] * d[0] + d[1] * d[1]);
  *part  = (SplineSurface){.cell = cell, .side = side, .length = (to - from) * length};
  for (PetscInt e = 0; e < 2; e++) {
    part->from[e] = a[e] + from * d[e];
    part->to[e]   = a[e] + to * d[e];
  }
  part->normal[0] = sign * d[1] / length;
  part->normal[1] = -sign * d[0] / length;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the parts of the pieces of an outline in the cells of the lattice. */
static PetscErrorCode DivideOutline(const SplineLattice *l, const Outline *o, PetscInt side,
                                    SplineBodies *s)
{
  PetscFunctionBegin;
  for (PetscInt k = 0; k < o->pieces; k++) {
    const PetscReal *a = &o->piece[4 * k], *b = &o->piece[4 * k + 2];
    PetscInt         first[2], last[2];

    if (a[0] == b[0] && a[1] == b[1]) continue;
    for (PetscInt e = 0; e < 2; e++) {
      first[e] = (PetscInt)PetscFloorReal((PetscMin(a[e], b[e]) - l->lo[e]) / l->side[e]) - 1;
      last[e]  = (PetscInt)PetscFloorReal((PetscMax(a[e], b[e]) - l->lo[e]) / l->side[e]) + 1;
      first[e] = PetscMax(first[e], 0);
      last[e]  = PetscMin(last[e], l->cells[e] - 1);
    }
    for (PetscInt j = first[1]; j <= last[1]; j++) {
      for (PetscInt i = first[0]; i <= last[0]; i++)
        PetscCall(AddSurface(a, b, l, j * l->cells[0] + i, side, o->sign, s));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the shift of image k of a body in a periodic box, which a body that moves may have left;
   false if it is no image. */
static PetscBool ImageShift(const Scene *scene, const Body *body, PetscInt k, PetscReal shift[2])
{
  const PetscInt step[2] = {k % 3 - 1, k / 3 - 1};

  for (PetscInt a = 0; a < 2; a++) {
    if (step[a] && !SceneIsPeriodic(scene, a)) return PETSC_FALSE;
    shift[a] = step[a] * (scene->hi[a] - scene->lo[a]);
    if (body->pose && SceneIsPeriodic(scene, a))
      shift[a] -= (scene->hi[a] - scene->lo[a]) *
                  PetscFloorReal((body->pose->x[a] - scene->lo[a]) / (scene->hi[a] - scene->lo[a]));
  }
  return PETSC_TRUE;
}

/* Sets the fluid and the surfaces in the cells of the plane. */
static PetscErrorCode SetPlane(const SplineLattice *l, SplineBodies *s)
{
  const Scene    *scene   = l->scene;
  const PetscReal spacing = 0.25 * PetscMin(l->side[0], l->side[1]);
  Outline        *outline;
  PetscReal       base = 1.0;
  PetscInt        n = 0, loops = 0;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < scene->n_bodies; k++) loops += BodyLoops(SceneBody(scene, k));
  PetscCall(PetscMalloc1(9 * loops, &outline));
  for (PetscInt k = 0; k < scene->n_bodies; k++) {
    const Body *body = SceneBody(scene, k);

    if (body->around) base = 0.0;
    for (PetscInt image = 0; image < 9 * BodyLoops(body); image++) {
      PetscReal shift[2];

      if (!ImageShift(scene, body, image / BodyLoops(body), shift)) continue;
      PetscCall(OutlineCreate(body, image % BodyLoops(body), spacing, shift, &outline[n]));
      outline[n].solid = 9 * k + image / BodyLoops(body);
      if (OutlineIsApart(&outline[n], scene->lo, scene->hi)) PetscCall(OutlineFree(&outline[n]));
      else n++;
    }
  }
  PetscCall(OutlinesUnite(n, outline));
  for (PetscInt k = 0; k < n; k++)
    PetscCall(DivideOutline(l, &outline[k], SceneBodySide(scene, outline[k].solid / 9), s));
  PetscCall(SetCells(scene, l, n, outline, base, s));
  for (PetscInt k = 0; k < n; k++) PetscCall(OutlineFree(&outline[k]));
  PetscCall(PetscFree(outline));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineBodiesCreate - Computes the fluid in the cells of a lattice with bodies. Not collective.
   Output: bodies - NULL for a scene without bodies. */
PetscErrorCode SplineBodiesCreate(const Scene *scene, const SplineLattice *lattice,
                                  SplineBodies **bodies)
{
  PetscInt      cells = 1;
  SplineBodies *s;

  PetscFunctionBegin;
  *bodies = NULL;
  if (!scene->n_bodies) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscNew(&s));
  for (PetscInt a = 0; a < lattice->dim; a++) cells *= lattice->cells[a];
  PetscCall(PetscMalloc2(cells, &s->fraction, cells, &s->cut));
  PetscCall(lattice->dim == 3 ? SplineSolidsSet(lattice, s) : SetPlane(lattice, s));
  *bodies = s;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineBodiesDestroy - Frees the fluid in cells; not collective */
PetscErrorCode SplineBodiesDestroy(SplineBodies **bodies)
{
  SplineBodies *s = *bodies;

  PetscFunctionBegin;
  if (!s) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscFree2(s->fraction, s->cut));
  for (PetscInt k = 0; k < s->n_cut; k++) PetscCall(PetscFree(s->cuts[k].integral));
  PetscCall(FreeAll(&s->cuts, &s->patches));
  for (PetscInt a = 0; a < 2; a++) PetscCall(PetscFree(s->x[a]));
  PetscCall(FreeAll(&s->weight, &s->surface, bodies));
  PetscFunctionReturn(PETSC_SUCCESS);
}
