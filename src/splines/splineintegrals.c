/*
  The volume part of the divergence: the velocity at the points of quadrature by the fits of
  splinefits.c, and its integrals with the gradients of the splines,

    d_q = scale sum_g V_g grad psi_q(x_g) . u_g,   V_g: volume over that of a cell.

  No matrix is stored: the splines at a point are products of polynomials, and a node of a cut cell
  has a small table. The sums are collected in the window, whose entries beside bodies go to their
  masters.
*/
#include "splines.h"

/* SplineFitsFree - Frees the fits; not collective */
PetscErrorCode SplineFitsFree(SplineFits *f)
{
  PetscFunctionBegin;
  PetscCall(FreeAll(&f->j, &f->w, &f->value));
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) {
    for (PetscInt b = 0; b < ISPH_MAX_DIM; b++)
      PetscCall(PetscFree2(f->first[a][b], f->last[a][b]));
  }
  f->n = f->capacity = f->points = f->value_capacity = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineFitsReserve - Makes room for the velocities of all local particles; not collective */
PetscErrorCode SplineFitsReserve(const Particles *p, SplineFits *f)
{
  const PetscInt all = ParticlesAll(p);

  PetscFunctionBegin;
  if (all <= f->value_capacity) PetscFunctionReturn(PETSC_SUCCESS);
  f->value_capacity = all + all / 8;
  PetscCall(PetscFree(f->value));
  PetscCall(PetscMalloc1(p->dim * f->value_capacity, &f->value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the sum of entries [first, last) times the values of component b. */
static ISPH_INLINE PetscReal Sum(PetscInt dim, const SplineFits *f, PetscInt first, PetscInt last,
                                 PetscInt b)
{
  PetscReal sum = 0.0;

  for (PetscInt k = first; k < last; k++) sum += f->w[k] * f->value[dim * f->j[k] + b];
  return sum;
}

/* Returns true if all components at point g have the fit of the first. */
static PetscBool SplineFitIsSingle(PetscInt dim, const SplineFits *f, PetscInt g)
{
  for (PetscInt a = 1; a < f->sets; a++)
    if (f->first[a][a][g] != f->first[0][0][g]) return PETSC_FALSE;
  return f->coupled && f->last[0][1][g] > f->first[0][1][g] ? PETSC_FALSE : PETSC_TRUE;
}

/* Computes the velocity at point g if all components have the same fit. Two partial sums of each
   hide the latency of additions. */
static ISPH_INLINE void SharedVelocity(PetscInt dim, const SplineFits *f, PetscInt g, PetscReal u[])
{
  const PetscInt   n = f->last[0][0][g] - f->first[0][0][g], *j = f->j + f->first[0][0][g];
  const PetscReal *w = f->w + f->first[0][0][g], *value = f->value;
  PetscReal        odd[ISPH_MAX_DIM] = {0.0};
  PetscInt         k                 = 0;

  for (; k + 1 < n; k += 2) {
    const PetscReal *even_value = value + dim * j[k], *odd_value = value + dim * j[k + 1];

    for (PetscInt a = 0; a < dim; a++) {
      u[a] += w[k] * even_value[a];
      odd[a] += w[k + 1] * odd_value[a];
    }
  }
  for (PetscInt a = 0; a < dim; a++) {
    u[a] += odd[a];
    if (k < n) u[a] += w[k] * value[dim * j[k] + a];
  }
}

/* Computes the velocity at point g from f->value. */
static ISPH_INLINE void Velocity(PetscInt dim, const SplineFits *f, PetscInt g, PetscReal u[])
{
  for (PetscInt a = 0; a < dim; a++) u[a] = 0.0;
  if (SplineFitIsSingle(dim, f, g)) {
    SharedVelocity(dim, f, g, u);
    return;
  }
  for (PetscInt a = 0; a < dim; a++) {
    u[a] = Sum(dim, f, f->first[a][a][g], f->last[a][a][g], a);
    for (PetscInt b = 0; f->coupled && b < dim; b++)
      if (b != a) u[a] += Sum(dim, f, f->first[a][b][g], f->last[a][b][g], b);
  }
}

/* Entries of splines, whose rows and planes follow each other by `row` and `plane`. */
typedef struct {
  PetscInt   row, plane;
  PetscReal *value;
} SplineBlockSum;

/* Adds the gradients of the splines at a point times u to the block, from the polynomials b and
   their derivatives d along each axis. */
static ISPH_INLINE void AddRegular(PetscInt dim, PetscReal b[][SPLINES_ALONG],
                                   PetscReal d[][SPLINES_ALONG], const PetscReal u[],
                                   SplineBlockSum to)
{
  for (PetscInt m = 0; m < (dim == 3 ? 3 : 1); m++) {
    for (PetscInt j = 0; j < 3; j++) {
      PetscReal *value = to.value + m * to.plane + j * to.row;
      PetscReal  along = u[0] * b[1][j], across = u[1] * d[1][j];

      if (dim == 3) {
        along *= b[2][m];
        across = across * b[2][m] + u[2] * b[1][j] * d[2][m];
      }
      for (PetscInt e = 0; e < 3; e++) value[e] += along * d[0][e] + across * b[0][e];
    }
  }
}

/* Adds the integrals of a node of a cut cell times u to the block. */
static ISPH_INLINE void AddNode(PetscInt dim, const PetscReal *integral, const PetscReal u[],
                                SplineBlockSum to)
{
  const PetscInt n = dim == 3 ? SPLINES_AT_QUADRATIC : SPLINES_IN_PLANE;

  for (PetscInt k = 0; k < n; k++) {
    PetscReal sum = integral[n + k] * u[0] + integral[2 * n + k] * u[1];

    if (dim == 3) sum += integral[3 * n + k] * u[2];
    to.value[k / 9 * to.plane + k / 3 % 3 * to.row + k % 3] += sum;
  }
}

/* Adds the gradients of the splines at point g times the volume and u to a block. Inlined, so that
   the compiler knows the dimension. */
static ISPH_INLINE void AddPoint(PetscInt dim, const Splines *s, PetscInt g, const PetscReal u[],
                                 SplineBlockSum to)
{
  const SplinePlaces *place = &s->inside_at;
  const PetscInt      node  = s->inside.side[g];
  PetscReal b[ISPH_MAX_DIM][SPLINES_ALONG], d[ISPH_MAX_DIM][SPLINES_ALONG], weighted[ISPH_MAX_DIM];

  if (node >= 0) {
    const PetscInt n = dim == 3 ? SPLINES_AT_QUADRATIC : SPLINES_IN_PLANE, nodes = 1 << dim;

    AddNode(dim, s->bodies->cuts[node / nodes].integral + node % nodes * (1 + dim) * n, u, to);
    return;
  }
  for (PetscInt a = 0; a < dim; a++)
    SplineBasis(2, place->t[a][g], place->per_edge[a][g], b[a], d[a]);
  for (PetscInt a = 0; a < dim; a++) weighted[a] = s->inside.weight[g] * u[a];
  AddRegular(dim, b, d, weighted, to);
}

/* Adds the integrals of a field with values `field` at the points, or of the velocity in f->value,
   to the window. Inlined, so that the compiler knows the dimension. */
static ISPH_INLINE void IntegrateInline(PetscInt dim, Splines *s, const PetscReal field[])
{
  const SplineWindow *w  = &s->window;
  SplineBlockSum      to = {.row = w->n[0], .plane = dim == 3 ? w->n[0] * w->n[1] : 0};

  for (PetscInt g = 0; g < s->inside.n; g++) {
    PetscReal u[ISPH_MAX_DIM];

    if (!field) Velocity(dim, &s->fits, g, u);
    for (PetscInt a = 0; field && a < dim; a++) u[a] = field[dim * g + a];
    to.value = w->value + s->inside_at.base[g];
    AddPoint(dim, s, g, u, to);
  }
}

static ISPH_WIDE void IntegrateWide(Splines *s, const PetscReal field[])
{
  if (s->lattice.dim == 2) IntegrateInline(2, s, field);
  else IntegrateInline(3, s, field);
}

/* SplinesIntegrateField - Computes the integrals of SplinesIntegrate() of a field whose component a
   at point g is u[g dim + a]; collective */
PetscErrorCode SplinesIntegrateField(Splines *s, const PetscReal u[], Vec d)
{
  PetscFunctionBegin;
  PetscCall(PetscArrayzero(s->window.value, s->window.size));
  IntegrateWide(s, u);
  PetscCall(SplineWindowSum(&s->window, d));
  PetscCall(VecScale(d, s->scale));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  SplinesIntegrate - Computes the integrals of the gradients of the splines with the velocity

    d_q = scale int grad psi_q . u dV   over the volume of a cell

  Collective. Input: velocities of own particles in s->fits.value.
*/
PetscErrorCode SplinesIntegrate(const Particles *p, Splines *s, Vec d)
{
  PetscFunctionBegin;
  PetscCall(ParticlesHaloVectors(p, s->fits.value));
  PetscCall(SplinesIntegrateField(s, NULL, d));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lists the splines that make entry k of the block at point g, and their weights; returns their
   number. */
static PetscInt ListEntries(const Splines *s, PetscInt g, PetscInt k, PetscReal value,
                            PetscInt number[], PetscReal entry[])
{
  const SplineWindow *w = &s->window;
  const PetscInt q = s->inside_at.base[g] + k / 9 * w->n[0] * w->n[1] + k / 3 % 3 * w->n[0] + k % 3;
  const PetscInt from = w->start[q], n = w->start[q + 1] - from;

  for (PetscInt e = 0; e < n; e++) {
    number[e] = w->number[w->source[from + e]];
    entry[e]  = w->weight[from + e] * value;
  }
  return n;
}

/* SplineGradientMat - Creates the matrix of the integrals along axis a, points x splines: entries
   scale V_g dpsi_q/dx_a; collective */
PetscErrorCode SplineGradientMat(const Particles *p, const Splines *s, PetscInt a, Mat *T)
{
  const PetscInt  n                  = SplinesAtPoint(&s->lattice);
  const PetscReal unit[ISPH_MAX_DIM] = {a == 0, a == 1, a == 2};
  PetscInt        row, *width, number[SPLINES_EXTENDED];
  PetscReal       entry[SPLINES_EXTENDED];

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(s->inside.n, &width));
  for (PetscInt g = 0; g < s->inside.n; g++)
    for (PetscInt k = 0; k < n; k++) width[g] += ListEntries(s, g, k, 0.0, number, entry);
  PetscCall(SplineMat(p->comm, s->inside.n, s->own.size, width, T));
  PetscCall(PetscFree(width));
  PetscCall(MatGetOwnershipRange(*T, &row, NULL));
  for (PetscInt g = 0; g < s->inside.n; g++, row++) {
    PetscReal            value[SPLINES_AT_QUADRATIC] = {0.0};
    const SplineBlockSum to      = {.row = 3, .plane = SPLINES_IN_PLANE, .value = value};
    PetscInt             entries = 0;

    AddPoint(s->lattice.dim, s, g, unit, to);
    for (PetscInt k = 0; k < n; k++)
      entries += ListEntries(s, g, k, s->scale * value[k], number + entries, entry + entries);
    PetscCall(MatSetValues(*T, 1, &row, entries, number, entry, ADD_VALUES));
  }
  PetscCall(SplineMatFinish(*T));
  PetscFunctionReturn(PETSC_SUCCESS);
}
