/* The lattice of B-splines: its cells, and the values of the splines at a point. */
#include "splines.h"

/* SplineLatticeSet - Sets the cells and quadratic splines of a lattice over the box. Not
   collective. Input: ratio - edge of a cell over the spacing of the particles [-]. Notes: along an
   axis, spline i has its centre at (i - 1/2) cells from the low side; those next to a side extend
   beyond the box. In a periodic direction i + 1 replaces i, modulo the cells. */
PetscErrorCode SplineLatticeSet(const Scene *scene, PetscReal ratio, SplineLattice *lattice)
{
  PetscFunctionBegin;
  lattice->scene  = scene;
  lattice->degree = 2;
  lattice->dim    = scene->dim;
  lattice->N      = 1;
  for (PetscInt a = 0; a < scene->dim; a++) {
    const PetscReal length = scene->hi[a] - scene->lo[a];

    lattice->periodic[a] = SceneIsPeriodic(scene, a);
    lattice->cells[a]    = PetscMax(1, (PetscInt)(length / (ratio * scene->dx) + 0.5));
    lattice->count[a]    = lattice->cells[a] + (lattice->periodic[a] ? 0 : 2);
    lattice->lo[a]       = scene->lo[a];
    lattice->side[a]     = length / lattice->cells[a];
    lattice->N *= lattice->count[a];
    for (PetscInt side = 2 * a; side < 2 * a + 2; side++)
      lattice->given[side] = BoundaryEquation(scene, side, FIT_PRESSURE) == EQUATION_VALUE;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineNatural - Returns the number of a spline in the order of the lattice, first axis fastest */
PetscInt SplineNatural(const SplineLattice *lattice, const PetscInt index[])
{
  PetscInt number = 0;

  for (PetscInt a = lattice->dim - 1; a >= 0; a--) number = number * lattice->count[a] + index[a];
  return number;
}

/* SplineIndex - Computes the index of spline k along each axis, first axis fastest, in a block of n
   splines along each axis that begins with `first` (NULL: with 0) */
void SplineIndex(PetscInt dim, const PetscInt first[], const PetscInt n[], PetscInt k,
                 PetscInt index[])
{
  for (PetscInt a = 0; a < dim; a++) {
    index[a] = (first ? first[a] : 0) + k % n[a];
    k /= n[a];
  }
}

/* Returns the centre of a spline along an axis of the uniform lattice [m]. */
static PetscReal CentreAlong(const SplineLattice *lattice, PetscInt a, PetscInt index)
{
  return lattice->lo[a] + (index + (lattice->periodic[a] ? 0.5 : -0.5)) * lattice->side[a];
}

/* SplineCentre - Computes the centre of a spline, which may be outside the box [m] */
void SplineCentre(const SplineLattice *lattice, const PetscInt index[], PetscReal x[])
{
  PetscReal slope;

  for (PetscInt a = 0; a < lattice->dim; a++)
    x[a] = SceneFromUniform(lattice->scene, a, CentreAlong(lattice, a, index[a]), &slope);
}

/* SplinePlace - Computes the centre of a spline, moved into the box if it is outside: the rank that
   has this point owns the spline [m] */
void SplinePlace(const SplineLattice *lattice, const PetscInt index[], PetscReal x[])
{
  for (PetscInt a = 0; a < lattice->dim; a++) {
    const PetscReal quarter = 0.25 * lattice->side[a];
    PetscReal       y       = CentreAlong(lattice, a, index[a]), slope;

    y    = PetscMax(y, lattice->lo[a] + quarter);
    y    = PetscMin(y, lattice->lo[a] + lattice->cells[a] * lattice->side[a] - quarter);
    x[a] = SceneFromUniform(lattice->scene, a, y, &slope);
  }
}

/* Returns the distance of the first knot from the low side in edges of cells. */
static PetscReal FirstKnot(const SplineLattice *lattice)
{
  return lattice->degree == 3 ? 0.5 : 0.0;
}

/* SplineFirstAlong - Returns the first spline along an axis that is not zero at a distance from the
   low side in edges of cells. Not collective. Indices continue beyond periodic sides. Beyond the
   last knots at a wall the polynomials of the adjacent piece continue. Therefore as many cubic
   splines as quadratic ones suffice: their coefficients outside are extrapolated cubically
   ("not-a-knot"). */
PetscInt SplineFirstAlong(const SplineLattice *lattice, PetscInt a, PetscReal distance)
{
  const PetscInt piece = (PetscInt)PetscFloorReal(distance - FirstKnot(lattice));

  if (lattice->periodic[a]) return piece - 1;
  return PetscMin(PetscMax(piece, 0), lattice->count[a] - lattice->degree - 1);
}

/* SplinePlaceAlong - Computes the first spline that is not zero at a position along an axis, the
   place t between two knots, from 0 to 1 except beyond the last knots, and the inverse of their
   distance [1/m]; not collective */
void SplinePlaceAlong(const SplineLattice *lattice, PetscInt a, PetscReal x, PetscInt *first,
                      PetscReal *t, PetscReal *per_edge)
{
  const PetscReal y        = SceneToUniform(lattice->scene, a, x);
  const PetscReal distance = (y - lattice->lo[a]) / lattice->side[a];
  PetscReal       slope;

  *first = SplineFirstAlong(lattice, a, distance);
  *t     = distance - FirstKnot(lattice) - (*first + (lattice->periodic[a] ? 1 : 0));
  (void)SceneFromUniform(lattice->scene, a, y, &slope);
  *per_edge = 1.0 / (slope * lattice->side[a]);
}

/*
  SplinesAt - Computes values and gradients of the splines that are not zero at a point

    psi(x) = prod_a b(s_a),   b = (1 - t)^2/2, 1/2 + t - t^2, t^2/2

  Not collective. t is the position between two knots along an axis of the uniform lattice. The
  knots of quadratic splines are the sides of cells, and the three polynomials belong to the splines
  centred in the cell below, in the cell and above it. See SplineBasis() for cubic splines.
*/
void SplinesAt(const SplineLattice *lattice, const PetscReal x[], SplineValues *values)
{
  const PetscInt dim = lattice->dim, m = lattice->degree + 1;
  PetscInt       first[ISPH_MAX_DIM];
  PetscReal      b[ISPH_MAX_DIM][SPLINES_ALONG], slope[ISPH_MAX_DIM][SPLINES_ALONG];

  for (PetscInt a = 0; a < dim; a++) {
    PetscReal t, per_edge;

    SplinePlaceAlong(lattice, a, x[a], &first[a], &t, &per_edge);
    SplineBasis(lattice->degree, t, per_edge, b[a], slope[a]);
  }
  values->n = SplinesAtPoint(lattice);
  for (PetscInt k = 0; k < values->n; k++) {
    const PetscInt digit[ISPH_MAX_DIM] = {k % m, k / m % m, k / (m * m)};

    values->value[k] = 1.0;
    for (PetscInt a = 0; a < dim; a++) {
      const PetscInt count = lattice->count[a];

      values->index[k][a] = first[a] + digit[a];
      if (lattice->periodic[a]) values->index[k][a] = (values->index[k][a] % count + count) % count;
      values->value[k] *= b[a][digit[a]];
      values->gradient[a][k] = 1.0;
      for (PetscInt c = 0; c < dim; c++)
        values->gradient[a][k] *= c == a ? slope[c][digit[c]] : b[c][digit[c]];
    }
  }
}
