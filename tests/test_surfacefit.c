/*
  The fit of a velocity with zero tangential stress on a free surface: exact for quadratic
  velocities without this stress, and no force on rigid motions, on disordered half-spaces.
*/
/* RANKS: 1 */
#include "../src/rows/rows.h"
#include "crowd.h"

#define NEIGHBOURS 125 /* most */

/* Appends the particle of an even lattice whose cell has the given number, displaced at random; on
   the surface along it only. The last axis of the frame is the normal. */
static void AddParticle(PetscInt dim, PetscReal depth, PetscReal frame[][ISPH_MAX_DIM], PetscInt id,
                        const PetscInt cell[], Stencil *st)
{
  const PetscInt k  = st->n;
  PetscReal      r2 = 0.0, y[ISPH_MAX_DIM];

  for (PetscInt a = 0; a < dim; a++)
    y[a] = st->dx * (cell[a] + 0.2 * (2.0 * ParticlesHash(1, id, a) - 1.0));
  st->surface[k] = cell[dim - 1] * st->dx - depth > -0.5 * st->dx ? PETSC_TRUE : PETSC_FALSE;
  if (st->surface[k]) y[dim - 1] = depth;
  for (PetscInt a = 0; a < dim; a++) {
    st->X[a][k]      = 0.0;
    st->normal[a][k] = frame[dim - 1][a];
    for (PetscInt b = 0; b < dim; b++) st->X[a][k] += frame[b][a] * y[b];
    r2 += PetscSqr(y[a]);
  }
  st->r[k]        = PetscSqrtReal(r2);
  st->wall[k]     = PETSC_FALSE;
  st->equation[k] = EQUATION_VALUE;
  if (r2 < PetscSqr(st->radius)) st->n++;
}

/* Fills a stencil with disordered particles in a half-space, whose surface is `depth` (0 or dx)
   above the particle. */
static void HalfSpace(PetscInt dim, PetscReal h_over_dx, PetscReal depth,
                      PetscReal frame[][ISPH_MAX_DIM], Stencil *st)
{
  const KernelRow *kernel = (const KernelRow *)(const void *)TableGet(&KernelTable, 0);
  const PetscInt   top    = depth > 0.0 ? 1 : 0;

  ASSERT_OK(StencilReserve(st, NEIGHBOURS));
  StencilSetSize(kernel, h_over_dx, 0.1, st);
  st->n                     = 0;
  st->beside_smooth_surface = PETSC_TRUE;
  for (PetscInt a = 0; a < dim; a++) st->own_normal[a] = frame[dim - 1][a];
  st->kind = depth == 0.0 ? SURFACE_SMOOTH : SURFACE_INSIDE;
  for (PetscInt id = 0; id < (dim == 2 ? 25 : 125); id++) {
    const PetscInt digits[] = {id % 5 - 2, id / 5 % 5 - 2, id / 25 % 5 - 2};
    PetscInt       off      = 0;

    for (PetscInt a = 0; a < dim; a++) off += PetscAbsInt(digits[a]);
    if (off > 0 && digits[dim - 1] <= top) AddParticle(dim, depth, frame, id, digits, st);
  }
  KernelEvaluateAll(kernel, dim, st->h, st->n, st->r, st->W, st->dW, st->ddW);
}

/* A velocity in the frame of the surface: tangents first, the normal and the height last. */
typedef void (*TestFlow)(PetscInt dim, const PetscReal y[], PetscReal u[]);

static void Rotation(PetscInt dim, const PetscReal y[], PetscReal u[])
{
  for (PetscInt a = 0; a < dim; a++) u[a] = 0.0;
  u[0]       = y[dim - 1];
  u[dim - 1] = -y[0];
}

/* Without tangential stress at height 0: u = (y0^2 + y_n^2, [y0 y1], -2 y0 y_n + y_n^2). */
static void Quadratic1(PetscInt dim, const PetscReal y[], PetscReal u[])
{
  const PetscReal h = y[dim - 1];

  u[0] = PetscSqr(y[0]) + PetscSqr(h);
  if (dim == 3) u[1] = y[0] * y[1];
  u[dim - 1] = -2.0 * y[0] * h + PetscSqr(h);
}

/* The same with shear: u = (y0 y_n, [0], -y0^2/2). */
static void Quadratic2(PetscInt dim, const PetscReal y[], PetscReal u[])
{
  for (PetscInt a = 0; a < dim; a++) u[a] = 0.0;
  u[0]       = y[0] * y[dim - 1];
  u[dim - 1] = -0.5 * PetscSqr(y[0]);
}

typedef PetscErrorCode (*RowFunction)(Stencil *st, PetscReal w[]);

/* Computes the force on the particle by finite sums of the row, in the frame of the surface, and
   2 n.E n. */
static void Apply(Stencil *st, RowFunction Row, PetscReal frame[][ISPH_MAX_DIM], PetscReal depth,
                  TestFlow field, PetscReal force[], PetscReal *strain)
{
  const PetscInt dim = st->dim;
  PetscReal      w[NEIGHBOURS * 9], u0[ISPH_MAX_DIM], y0[ISPH_MAX_DIM] = {0.0};
  PetscReal      f[ISPH_MAX_DIM] = {0.0};

  y0[dim - 1] = -depth;
  field(dim, y0, u0);
  ASSERT_OK(Row(st, w));
  *strain = 0.0;
  for (PetscInt k = 0; k < st->n; k++) {
    PetscReal y[ISPH_MAX_DIM] = {0.0}, u[ISPH_MAX_DIM] = {0.0}, v[ISPH_MAX_DIM] = {0.0};

    for (PetscInt a = 0; a < dim; a++) {
      y[a] = y0[a];
      for (PetscInt b = 0; b < dim; b++) y[a] += frame[a][b] * st->X[b][k];
    }
    field(dim, y, u);
    for (PetscInt a = 0; a < dim; a++) {
      for (PetscInt b = 0; b < dim; b++) v[b] += frame[a][b] * (u[a] - u0[a]);
    }
    for (PetscInt c = 0; c < dim; c++) {
      for (PetscInt a = 0; a < dim; a++) f[a] += w[(k * dim + a) * dim + c] * v[c];
      if (st->kind == SURFACE_SMOOTH) *strain += st->normal_strain[c][k] * v[c];
    }
  }
  for (PetscInt a = 0; a < dim; a++) {
    force[a] = 0.0;
    for (PetscInt b = 0; b < dim; b++) force[a] += frame[a][b] * f[b];
  }
}

/* Sets an orthonormal frame whose last row is the normal. */
static void Frame(PetscInt dim, PetscReal frame[][ISPH_MAX_DIM])
{
  const PetscReal flat[2][2]  = {{0.8, 0.6}, {-0.6, 0.8}};
  const PetscReal solid[3][3] = {{2.0 / 3.0, -1.0 / 3.0, 2.0 / 3.0},
                                 {2.0 / 3.0, 2.0 / 3.0, -1.0 / 3.0},
                                 {-1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0}};

  for (PetscInt a = 0; a < dim; a++) {
    for (PetscInt b = 0; b < dim; b++) frame[a][b] = dim == 2 ? flat[a][b] : solid[a][b];
  }
}

static void test_fields(void **state)
{
  (void)state;
  for (PetscInt dim = 2; dim <= 3; dim++) {
    for (PetscInt layer = 0; layer <= 1; layer++) {
      const PetscReal depth = 0.1 * layer;
      PetscReal       frame[ISPH_MAX_DIM][ISPH_MAX_DIM], force[ISPH_MAX_DIM], strain;
      Stencil        *st;

      ASSERT_OK(StencilCreate(dim, &st));
      Frame(dim, frame);
      HalfSpace(dim, 1.5, depth, frame, st);
      Apply(st, LaplacianRow_SurfaceMls, frame, depth, Rotation, force, &strain);
      for (PetscInt a = 0; a < dim; a++) assert_true(PetscAbsReal(force[a]) < 1e-10);
      assert_true(PetscAbsReal(strain) < 1e-10);
      /* lap u + grad div u: lap = (4, 0, 2), div = 2 y0 [+ y0] - 2 y0 + 2 y_n */
      Apply(st, LaplacianRow_SurfaceMls, frame, depth, Quadratic1, force, &strain);
      assert_true(PetscAbsReal(force[0] - (dim == 2 ? 4.0 : 5.0)) < 1e-8);
      assert_true(PetscAbsReal(force[dim - 1] - 4.0) < 1e-8);
      if (dim == 3) assert_true(PetscAbsReal(force[1]) < 1e-8);
      assert_true(PetscAbsReal(strain) < 1e-10); /* 2 du_n/dy_n = -4 y0 + 4 y_n = 0 */
      /* lap = (0, 0, -1), div = y_n */
      Apply(st, LaplacianRow_SurfaceMls, frame, depth, Quadratic2, force, &strain);
      assert_true(PetscAbsReal(force[0]) < 1e-8 && PetscAbsReal(force[dim - 1]) < 1e-8);
      assert_int_equal(st->regularised, 0);
      ASSERT_OK(StencilDestroy(&st));
    }
  }
}

/* The stress for a varying viscosity: exact lap u + 2 grad div u inside; beside a surface forces
   along pairs, which rotate nothing, and no pressure. */
static void test_stress(void **state)
{
  (void)state;
  for (PetscInt dim = 2; dim <= 3; dim++) {
    const PetscReal depth = 0.1;
    PetscReal       frame[ISPH_MAX_DIM][ISPH_MAX_DIM], force[ISPH_MAX_DIM], strain;
    Stencil        *st;

    ASSERT_OK(StencilCreate(dim, &st));
    Frame(dim, frame);
    HalfSpace(dim, 1.5, depth, frame, st);
    for (PetscInt k = 0; k < st->n; k++) {
      st->surface[k] = PETSC_FALSE;
      st->V[k]       = dim == 3 ? 1e-3 : 1e-2;
    }
    st->beside_smooth_surface = st->beside_surface = PETSC_FALSE;
    /* grad div of Quadratic1: ([1] e_0 + 2 e_n) in 3D, 2 e_n in 2D */
    Apply(st, LaplacianRow_SurfaceStress, frame, depth, Quadratic1, force, &strain);
    assert_true(PetscAbsReal(force[0] - (dim == 2 ? 4.0 : 6.0)) < 1e-8);
    assert_true(PetscAbsReal(force[dim - 1] - 6.0) < 1e-8);
    Apply(st, LaplacianRow_SurfaceStress, frame, depth, Quadratic2, force, &strain);
    assert_true(PetscAbsReal(force[0]) < 1e-8 && PetscAbsReal(force[dim - 1] - 1.0) < 1e-8);
    st->beside_surface = PETSC_TRUE;
    st->kind           = SURFACE_SMOOTH;
    Apply(st, LaplacianRow_SurfaceStress, frame, depth, Rotation, force, &strain);
    for (PetscInt a = 0; a < dim; a++) assert_true(PetscAbsReal(force[a]) < 1e-10);
    Apply(st, LaplacianRow_SurfaceStress, frame, depth, Quadratic1, force, &strain);
    assert_true(strain == 0.0);
    assert_int_equal(st->regularised, 0);
    ASSERT_OK(StencilDestroy(&st));
  }
}

/* A surface particle that lies below its surface has pair forces and no pressure: 2 n.E n would
   fall if it moved outwards. */
static void test_sunk(void **state)
{
  const KernelRow *kernel = (const KernelRow *)(const void *)TableGet(&KernelTable, 0);

  (void)state;
  for (PetscInt dim = 2; dim <= 3; dim++) {
    PetscReal frame[ISPH_MAX_DIM][ISPH_MAX_DIM], w[NEIGHBOURS * 9];
    Stencil  *st;

    ASSERT_OK(StencilCreate(dim, &st));
    Frame(dim, frame);
    HalfSpace(dim, 1.5, 0.0, frame, st);
    for (PetscInt k = 0; k < st->n; k++) {
      PetscReal r2 = 0.0;

      st->V[k] = st->dx * st->dx * (dim == 3 ? st->dx : 1.0);
      for (PetscInt a = 0; a < dim; a++) {
        st->X[a][k] += 0.6 * st->dx * frame[dim - 1][a];
        r2 += PetscSqr(st->X[a][k]);
      }
      st->r[k] = PetscSqrtReal(r2);
    }
    st->volume = st->V[0];
    KernelEvaluateAll(kernel, dim, st->h, st->n, st->r, st->W, st->dW, st->ddW);
    ASSERT_OK(LaplacianRow_SurfaceMls(st, w));
    assert_int_equal(st->regularised, 1);
    for (PetscInt k = 0; k < st->n; k++) {
      for (PetscInt c = 0; c < dim; c++) assert_true(st->normal_strain[c][k] == 0.0);
    }
    ASSERT_OK(StencilDestroy(&st));
  }
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_fields), cmocka_unit_test(test_stress),
                                     cmocka_unit_test(test_sunk)};

  int failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  return PetscFinalize() || failed ? 1 : 0;
}
