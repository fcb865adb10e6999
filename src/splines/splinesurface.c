/* Surfaces of bodies in the lattice of the splines: outlines, and their parts in cells. */
#include "splines.h"

/* SplineCell - Computes the corners of a cell of the plane; not collective [m] */
void SplineCell(const SplineLattice *l, PetscInt cell, PetscReal lo[2], PetscReal hi[2])
{
  for (PetscInt a = 0; a < 2; a++) {
    const PetscInt index = a == 0 ? cell % l->cells[0] : cell / l->cells[0];

    lo[a] = l->lo[a] + index * l->side[a];
    hi[a] = l->lo[a] + (index + 1) * l->side[a];
  }
}

/* SplineOutlineCreate - Computes the corners of an outline from the points of the surface and the
   lengths of their parts: exact for polygons, and around a circle; not collective */
PetscErrorCode SplineOutlineCreate(const Body *body, PetscReal spacing, const PetscReal shift[2],
                                   SplineOutline *o)
{
  const ShapeRow *shape = body->shape->outline ? body->shape->outline : body->shape;

  PetscFunctionBegin;
  o->n    = shape->Count(body, spacing);
  o->sign = body->around ? 1.0 : -1.0;
  PetscCall(PetscCalloc1(2 * o->n, &o->x));
  for (PetscInt k = 0; k < o->n; k++) {
    PetscReal       x[ISPH_MAX_DIM], normal[ISPH_MAX_DIM];
    const PetscReal half       = 0.5 * shape->Point(body, k, spacing, x, normal);
    const PetscReal tangent[2] = {-normal[1], normal[0]};

    for (PetscInt a = 0; a < 2; a++) {
      o->x[2 * k + a] += 0.5 * (x[a] + shift[a] + half * tangent[a]);
      o->x[2 * ((k + o->n - 1) % o->n) + a] += 0.5 * (x[a] + shift[a] - half * tangent[a]);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the part of a piece of surface from a to b in a cell, without its upper sides. */
static PetscErrorCode AddSurface(const PetscReal a[], const PetscReal b[], const PetscReal lo[],
                                 const PetscReal hi[], PetscInt cell, PetscInt side, PetscReal sign,
                                 SplineBodies *s)
{
  const PetscReal d[2] = {b[0] - a[0], b[1] - a[1]};
  PetscReal       from = 0.0, to = 1.0, length;
  SplineSurface  *part;

  PetscFunctionBegin;
  for (PetscInt e = 0; e < 2; e++) {
    if (d[e] == 0.0) {
      if (a[e] < lo[e] || a[e] >= hi[e]) PetscFunctionReturn(PETSC_SUCCESS);
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

/* SplineOutlineDivide - Adds the parts of an outline in the cells of the lattice; not collective */
PetscErrorCode SplineOutlineDivide(const SplineLattice *l, const SplineOutline *o, PetscInt side,
                                   SplineBodies *s)
{
  PetscFunctionBegin;
  for (PetscInt k = 0; k < o->n; k++) {
    const PetscReal *a = &o->x[2 * k], *b = &o->x[2 * ((k + 1) % o->n)];
    PetscInt         first[2], last[2];

    if (a[0] == b[0] && a[1] == b[1]) continue;
    for (PetscInt e = 0; e < 2; e++) {
      first[e] = (PetscInt)PetscFloorReal((PetscMin(a[e], b[e]) - l->lo[e]) / l->side[e]) - 1;
      last[e]  = (PetscInt)PetscFloorReal((PetscMax(a[e], b[e]) - l->lo[e]) / l->side[e]) + 1;
      first[e] = PetscMax(first[e], 0);
      last[e]  = PetscMin(last[e], l->cells[e] - 1);
    }
    for (PetscInt j = first[1]; j <= last[1]; j++) {
      for (PetscInt i = first[0]; i <= last[0]; i++) {
        const PetscInt cell = j * l->cells[0] + i;
        PetscReal      lo[2], hi[2];

        SplineCell(l, cell, lo, hi);
        PetscCall(AddSurface(a, b, lo, hi, cell, side, o->sign, s));
      }
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
