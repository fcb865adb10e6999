/*
  The fit of a velocity with zero tangential stress on a free surface: exact for quadratic
  velocities without this stress, and no force on rigid motions, on disordered half-spaces.
*/
/* RANKS: 1 */
#include "../src/operators/rows.h"
#include "crowd.h"

#define NEIGHBOURS 60

/* Fills a stencil with points below the plane n.x = depth; all points in a layer of dx below it are
   on the surface and are moved onto the plane. */
static void HalfSpace(PetscInt dim, PetscReal depth, const PetscReal n[], Stencil *st)
{
  const KernelRow *kernel = (const KernelRow *)(const void *)TableGet(&KernelTable, 0);

  ASSERT_OK(StencilReserve(st, NEIGHBOURS));
  StencilSetSize(kernel, 1.3, 0.1, st);
  st->n            = 0;
  st->near_surface = PETSC_TRUE;
  for (PetscInt a = 0; a < dim; a++) st->own_normal[a] = n[a];
  st->kind = depth == 0.0 ? SURFACE_SMOOTH : SURFACE_INSIDE;
  for (PetscInt id = 0; st->n < NEIGHBOURS / (dim == 2 ? 3 : 1); id++) {
    PetscReal height = -depth, r2 = 0.0, x[ISPH_MAX_DIM];

    for (PetscInt a = 0; a < dim; a++) {
      x[a] = st->radius * ParticlesHash(1, id, a);
      height += n[a] * x[a];
    }
    if (height > 0.0) continue;
    st->surface[st->n] = height > -st->dx ? PETSC_TRUE : PETSC_FALSE;
    for (PetscInt a = 0; a < dim; a++) {
      if (st->surface[st->n]) x[a] -= height * n[a];
      r2 += PetscSqr(x[a]);
    }
    if (r2 >= PetscSqr(st->radius)) continue;
    for (PetscInt a = 0; a < dim; a++) {
      st->X[a][st->n]      = x[a];
      st->normal[a][st->n] = n[a];
    }
    st->r[st->n]        = PetscSqrtReal(r2);
    st->wall[st->n]     = PETSC_FALSE;
    st->equation[st->n] = EQUATION_VALUE;
    st->n++;
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

/* Computes the force on the particle by finite sums of the row, in the frame of the surface, and
   2 n.E n. */
static void Apply(Stencil *st, PetscReal frame[][ISPH_MAX_DIM], PetscReal depth, TestFlow field,
                  PetscReal force[], PetscReal *strain)
{
  const PetscInt dim = st->dim;
  PetscReal      w[NEIGHBOURS * 9], u0[ISPH_MAX_DIM], y0[ISPH_MAX_DIM] = {0.0};
  PetscReal      f[ISPH_MAX_DIM] = {0.0};

  y0[dim - 1] = -depth;
  field(dim, y0, u0);
  ASSERT_OK(LaplacianRow_SurfaceMls(st, w));
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
      HalfSpace(dim, depth, frame[dim - 1], st);
      Apply(st, frame, depth, Rotation, force, &strain);
      for (PetscInt a = 0; a < dim; a++) assert_true(PetscAbsReal(force[a]) < 1e-10);
      assert_true(PetscAbsReal(strain) < 1e-10);
      /* lap u + grad div u: lap = (4, 0, 2), div = 2 y0 [+ y0] - 2 y0 + 2 y_n */
      Apply(st, frame, depth, Quadratic1, force, &strain);
      assert_true(PetscAbsReal(force[0] - (dim == 2 ? 4.0 : 5.0)) < 1e-8);
      assert_true(PetscAbsReal(force[dim - 1] - 4.0) < 1e-8);
      if (dim == 3) assert_true(PetscAbsReal(force[1]) < 1e-8);
      assert_true(PetscAbsReal(strain) < 1e-10); /* 2 du_n/dy_n = -4 y0 + 4 y_n = 0 */
      /* lap = (0, 0, -1), div = y_n */
      Apply(st, frame, depth, Quadratic2, force, &strain);
      assert_true(PetscAbsReal(force[0]) < 1e-8 && PetscAbsReal(force[dim - 1]) < 1e-8);
      assert_int_equal(st->regularised, 0);
      ASSERT_OK(StencilDestroy(&st));
    }
  }
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_fields)};

  int failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  return PetscFinalize() || failed ? 1 : 0;
}
