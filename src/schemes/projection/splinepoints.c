/* Points of quadrature of the splines, in the cells of the lattice and on the sides of the box. */
#include "splines.h"

/* SplinePointsFree - Frees the points; not collective */
PetscErrorCode SplinePointsFree(SplinePoints *points)
{
  PetscFunctionBegin;
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) PetscCall(PetscFree(points->x[a]));
  PetscCall(PetscFree2(points->weight, points->side));
  points->n = points->capacity = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode PointsReserve(PetscInt dim, PetscInt n, SplinePoints *points)
{
  PetscFunctionBegin;
  PetscCall(SplinePointsFree(points));
  for (PetscInt a = 0; a < dim; a++) PetscCall(PetscMalloc1(n, &points->x[a]));
  PetscCall(PetscMalloc2(n, &points->weight, n, &points->side));
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
    const PetscReal low  = PetscMax((p->lo[a] - l->lo[a]) / l->side[a], 0.0);
    const PetscReal high = PetscMin((p->hi[a] - l->lo[a]) / l->side[a], (PetscReal)l->cells[a]);

    first[a] = (PetscInt)low;
    n[a]     = PetscMax(0, PetscMin((PetscInt)high, l->cells[a] - 1) - first[a] + 1);
    number *= n[a];
  }
  return number;
}

/* Sets the points of this rank on the sides of the box that are not periodic, two along each axis
   of a cell's face. */
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
  PetscCall(PointsReserve(dim, most, &s->boundary));
  for (PetscInt side = 0; side < 2 * dim; side++) {
    const PetscInt axis  = side / 2;
    PetscInt       faces = 1;

    if (l->periodic[axis]) continue;
    for (PetscInt b = 0; b < dim; b++) faces *= b == axis ? 1 : n[b];
    for (PetscInt f = 0; f < faces * corners; f++) {
      PetscInt  cell = f / corners, corner = f % corners;
      PetscReal x[ISPH_MAX_DIM], inside[ISPH_MAX_DIM], weight = 1.0 / corners;

      for (PetscInt b = 0; b < dim; b++) {
        if (b == axis) {
          x[b]      = l->lo[b] + (side % 2 ? l->cells[b] * l->side[b] : 0.0);
          inside[b] = l->lo[b] + (side % 2 ? l->cells[b] - 0.25 : 0.25) * l->side[b];
          continue;
        }
        x[b] =
            l->lo[b] + (first[b] + cell % n[b] + 0.5 + (corner % 2 ? GAUSS : -GAUSS)) * l->side[b];
        inside[b] = x[b];
        weight *= l->side[b] / s->scale;
        cell /= n[b];
        corner /= 2;
      }
      if (ParticlesHolds(p, inside)) PointsAdd(dim, x, weight, side, &s->boundary);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the points of this rank inside the box, two along each axis of a cell. */
static PetscErrorCode SetInnerPoints(Splines *s, const Particles *p)
{
  const SplineLattice *l       = &s->lattice;
  const PetscInt       corners = 1 << l->dim;
  PetscInt             first[ISPH_MAX_DIM], n[ISPH_MAX_DIM];
  const PetscInt       cells = OwnCells(s, p, first, n);

  PetscFunctionBegin;
  PetscCall(PointsReserve(l->dim, cells * corners, &s->inside));
  for (PetscInt k = 0; k < cells * corners; k++) {
    PetscInt  cell = k / corners, corner = k % corners;
    PetscReal x[ISPH_MAX_DIM];

    for (PetscInt a = 0; a < l->dim; a++) {
      x[a] = l->lo[a] + (first[a] + cell % n[a] + 0.5 + (corner % 2 ? GAUSS : -GAUSS)) * l->side[a];
      cell /= n[a];
      corner /= 2;
    }
    if (ParticlesHolds(p, x)) PointsAdd(l->dim, x, 1.0 / corners, -1, &s->inside);
  }
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
