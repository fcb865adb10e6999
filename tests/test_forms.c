/*
  Laplacians on stencils made by hand: their dependence on the equations of wall neighbours, and the
  effect of kernel corrections.
*/
/* RANKS: 1 */
#include "cloud.h"

#define SIDE 5   /* points along each axis */
#define MOST 125 /* SIDE^3 */

/* Creates a stencil of disordered points around the origin with mean spacing 1; the first `walls`
   points are wall particles. */
static Stencil *Made(PetscInt dim, PetscReal h, PetscInt walls)
{
  const KernelRow *kernel = (const KernelRow *)(const void *)TableGet(&KernelTable, 2);
  Stencil         *st;
  PetscInt         cells = 1;

  ASSERT_OK(StencilCreate(dim, &st));
  StencilSetSize(kernel, h, 1.0, st);
  ASSERT_OK(StencilReserve(st, MOST));
  st->volume = 1.0;
  for (PetscInt a = 0; a < dim; a++) cells *= SIDE;
  for (PetscInt c = 0; c < cells; c++) {
    PetscReal X[ISPH_MAX_DIM], r = 0.0, w[3];
    PetscInt  index = c;

    for (PetscInt a = 0; a < dim; a++, index /= SIDE) {
      X[a] = (PetscReal)(index % SIDE - SIDE / 2) + 0.25 * ParticlesHash(7, c, a);
      r += PetscSqr(X[a]);
    }
    r = PetscSqrtReal(r);
    if (c == cells / 2 || r >= st->radius) continue; /* the particle itself is at the origin */
    KernelEvaluate(kernel, dim, h, r, w);
    for (PetscInt a = 0; a < dim; a++) {
      st->X[a][st->n]      = X[a];
      st->normal[a][st->n] = a == 0 ? 0.6 : (a == 1 ? 0.8 : 0.0);
    }
    st->r[st->n]        = r;
    st->V[st->n]        = 1.0;
    st->W[st->n]        = w[0];
    st->dW[st->n]       = w[1];
    st->ddW[st->n]      = w[2];
    st->wall[st->n]     = st->n_wall < walls ? PETSC_TRUE : PETSC_FALSE;
    st->side[st->n]     = 0;
    st->equation[st->n] = EQUATION_VALUE;
    if (st->wall[st->n]) st->n_wall++;
    st->n++;
  }
  StencilFinish(st);
  st->fits_walls = walls ? PETSC_TRUE : PETSC_FALSE;
  return st;
}

static LaplacianForm Form(const char name[], const char correction[])
{
  LaplacianForm   form = {0};
  const TableRow *row;

  ASSERT_OK(TableFind(&LaplacianTable, name, &row));
  assert_non_null(row);
  form.row = (const LaplacianRow *)(const void *)row;
  ASSERT_OK(TableFind(&CorrectionTable, correction, &row));
  assert_non_null(row);
  if (((const CorrectionRow *)(const void *)row)->Kernel)
    form.correction = (const CorrectionRow *)(const void *)row;
  return form;
}

/* Returns the largest error of the Laplacian over f = X_a and f = X_a X_b; wall particles give
   n.grad f instead of f. */
static PetscReal SlopeError(const Stencil *st, const PetscReal w[])
{
  PetscReal worst = 0.0;

  for (PetscInt a = 0; a < st->dim; a++) {
    for (PetscInt b = -1; b <= a; b++) {
      PetscReal lap = 0.0;

      for (PetscInt k = 0; k < st->n; k++) {
        const PetscReal Xa = st->X[a][k], na = st->normal[a][k];
        const PetscReal Xb = b < 0 ? 1.0 : st->X[b][k], nb = b < 0 ? 0.0 : st->normal[b][k];

        lap += w[k] * (st->wall[k] ? na * Xb + Xa * nb : Xa * Xb);
      }
      worst = PetscMax(worst, PetscAbsReal(lap - (a == b ? 2.0 : 0.0)));
    }
  }
  return worst;
}

/* A form with FORM_FULL_SUPPORT ignores the equations of walls. Any other form is exact with given
   n.grad f at walls too. */
static void test_equations(void **state)
{
  Boundary    wall[4] = {{.kind = &BoundaryWall}};
  const Scene scene   = {.dim = 2, .boundary = wall};

  (void)state;
  for (PetscInt dim = 2; dim <= 3; dim++) {
    for (PetscInt m = 0; m < CloudScalarForms(); m++) {
      const LaplacianRow *row = (const LaplacianRow *)(const void *)TableGet(&LaplacianTable, m);
      Stencil            *st  = Made(dim, 1.3, 3);
      PetscReal           value[MOST], slope[MOST], difference = 0.0;

      StencilSetVelocity(&scene, 0, st);
      ASSERT_OK(row->Row(st, value));
      StencilSetQuantity(&scene, FIT_PRESSURE, st);
      ASSERT_OK(row->Row(st, slope));
      for (PetscInt k = 0; k < st->n; k++)
        difference = PetscMax(difference, PetscAbsReal(value[k] - slope[k]));
      if (row->properties & FORM_FULL_SUPPORT) {
        CloudAssertNone("full_support", row->name, difference != 0.0);
      } else {
        CloudAssertNone("reads equations", row->name, difference < 1e-3);
        CloudAssertNone("exact with slopes", row->name, SlopeError(st, slope) > 1e-10);
      }
      CloudAssertNone("determined", row->name, st->regularised);
      ASSERT_OK(StencilDestroy(&st));
    }
  }
}

/* Returns Shepard's interpolant sum_k W_k f_k / sum_k W_k at x, with f = 0 at the origin. */
static PetscReal Interpolant(const Stencil *st, PetscReal h, const PetscReal f[],
                             const PetscReal x[])
{
  const KernelRow *kernel = (const KernelRow *)(const void *)TableGet(&KernelTable, 2);
  PetscReal        sum = 0.0, all = 0.0, w[3];

  for (PetscInt k = -1; k < st->n; k++) { /* -1: the particle at the origin */
    PetscReal r = 0.0;

    for (PetscInt a = 0; a < st->dim; a++) r += PetscSqr(x[a] - (k < 0 ? 0.0 : st->X[a][k]));
    KernelEvaluate(kernel, st->dim, h, PetscSqrtReal(r), w);
    all += w[0];
    if (k >= 0) sum += w[0] * f[k];
  }
  return sum / all;
}

/*
  With the correction shepard, direct_scalar is the Laplacian of Shepard's interpolant. The
  reference from central differences of step 1e-4 h has an accuracy of 1e-4 only, because the third
  derivative of the kernel jumps at the particle.
*/
static void test_shepard(void **state)
{
  const PetscReal h = 1.3, step = 1e-4 * h;

  (void)state;
  for (PetscInt dim = 2; dim <= 3; dim++) {
    const LaplacianForm form = Form("direct_scalar", "shepard");
    Stencil            *st   = Made(dim, h, 0);
    PetscReal           w[MOST], f[MOST], lap = 0.0, expected = 0.0, size = 0.0;

    ASSERT_OK(LaplacianWeights(&form, st, w));
    for (PetscInt k = 0; k < st->n; k++) {
      f[k] = ParticlesHash(11, k, 0);
      lap += w[k] * f[k];
      size += PetscAbsReal(w[k]);
    }
    for (PetscInt a = 0; a < dim; a++) {
      PetscReal x[ISPH_MAX_DIM] = {0.0};

      expected -= 2.0 * Interpolant(st, h, f, x);
      x[a] = step;
      expected += Interpolant(st, h, f, x);
      x[a] = -step;
      expected += Interpolant(st, h, f, x);
    }
    expected /= PetscSqr(step);
    CloudAssertNone("Laplacian of Shepard's interpolant", form.row->name,
                    PetscAbsReal(lap - expected) > 1e-4 * size);
    ASSERT_OK(StencilDestroy(&st));
  }
}

/* A corrected kernel leaves no form symmetric. */
static void test_first_order(void **state)
{
  const LaplacianForm morris = Form("morris", "first_order");

  (void)state;
  CloudAssertNone("no longer symmetric", "morris", LaplacianIs(&morris, FORM_SYMMETRIC));
}

/* A correction applies to the forms that accept it; it is refused if no form accepts it. */
static void test_where_it_applies(void **state)
{
  const CloudBox box = {.dim = 2, .cells = {6, 6, 1}, .n_periodic = 2};
  PetscErrorCode code;
  Cloud          cloud;

  (void)state;
  ASSERT_OK(CloudOperators(&box, "-visc_laplacian morris -correction shepard", &cloud));
  CloudAssertNone("taken by morris", "shepard", cloud.ops->forms.visc.correction == NULL);
  CloudAssertNone("left by mls", "shepard", cloud.ops->forms.ppe.correction != NULL);
  ASSERT_OK(OperatorsDestroy(&cloud.ops));
  ASSERT_OK(PetscPushErrorHandler(PetscReturnErrorHandler, NULL));
  code = CloudOperators(&box, "-correction shepard", &cloud);
  ASSERT_OK(PetscPopErrorHandler());
  CloudAssertNone("refused where nothing takes it", "shepard", code != PETSC_ERR_USER_INPUT);
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_equations), cmocka_unit_test(test_shepard),
      cmocka_unit_test(test_first_order), cmocka_unit_test(test_where_it_applies)};
  int failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  return PetscFinalize() || failed ? 1 : 0;
}
