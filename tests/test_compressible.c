/*
  The parts of the weakly compressible scheme: equations of state, and sums over neighbours that are
  exact where the scheme says so.
*/
/* RANKS: 1 */
#include "schemes/wcsph/wcsph.h"
#include "cloud.h"

#define ROUNDING 1e-12

/* Returns a scheme with an equation of state, rho_0 = 2 kg/m^3 and c0 = 30 m/s, at rest. */
static Wcsph AtRest(const TableRow *row, Scene *scene, Flow *flow)
{
  Wcsph w = {.equation = (const EquationOfStateRow *)(const void *)row, .c0 = 30.0, .flow = flow};

  *scene      = (Scene){.dim = 2, .rho = 2.0};
  flow->scene = scene;
  if (!w.equation->has_energy) return w;
  w.p_rest = scene->rho * PetscSqr(w.c0) / w.equation->exponent;
  w.e_rest = w.p_rest / ((w.equation->exponent - 1.0) * scene->rho);
  return w;
}

/* Each equation is zero at rest, has the density of its pressure, and for isentropic changes the
   slope dp/drho = c0^2. */
static void test_equations_of_state(void **state)
{
  (void)state;
  for (PetscInt k = 0; k < EquationOfStateTable.count; k++) {
    Scene           scene;
    Flow            flow;
    const Wcsph     w   = AtRest(TableGet(&EquationOfStateTable, k), &scene, &flow);
    const PetscReal eps = 1e-5, e = w.e_rest, p = 3.0;
    PetscReal       change = 0.0, slope;

    /* de = p/rho^2 drho without heat */
    if (w.equation->has_energy) change = w.p_rest / PetscSqr(scene.rho) * eps * scene.rho;
    slope = (w.equation->Pressure(&w, scene.rho * (1.0 + eps), e + change) -
             w.equation->Pressure(&w, scene.rho * (1.0 - eps), e - change)) /
            (2.0 * eps * scene.rho);
    print_message("%s: slope %g\n", w.equation->name, (double)slope);
    assert_true(PetscAbsReal(w.equation->Pressure(&w, scene.rho, e)) <= ROUNDING * PetscSqr(w.c0));
    assert_true(PetscAbsReal(slope - PetscSqr(w.c0)) <= 1e-7 * PetscSqr(w.c0));
    assert_true(PetscAbsReal(w.equation->Pressure(&w, w.equation->Density(&w, p), e) - p) <= 1e-10);
  }
}

/* Fills a stencil with neighbours at random places within the unit ball, and pairs with a linear
   pressure p = 3 + b.X. */
static void FillPairs(const PetscReal b[], Stencil *st, Pairs *pairs)
{
  PetscRandom random;

  ASSERT_OK(PetscRandomCreate(PETSC_COMM_SELF, &random));
  ASSERT_OK(StencilReserve(st, 30));
  ASSERT_OK(PairsReserve(st->capacity, pairs));
  st->n = 30;
  for (PetscInt k = 0; k < st->n; k++) {
    PetscReal r2 = 0.0;

    pairs->p[k]   = 3.0;
    pairs->rho[k] = 1.0;
    st->wall[k]   = PETSC_FALSE;
    for (PetscInt a = 0; a < st->dim; a++) {
      PetscReal value;

      ASSERT_OK(PetscRandomGetValueReal(random, &value));
      st->X[a][k] = value - 0.4;
      r2 += PetscSqr(st->X[a][k]);
      pairs->p[k] += b[a] * st->X[a][k];
      pairs->du[a][k] = b[a] * st->X[a][k];
    }
    st->r[k]  = PetscSqrtReal(r2);
    st->V[k]  = 0.05;
    st->W[k]  = PetscSqr(1.0 - 0.5 * r2);
    st->dW[k] = -2.0 * st->r[k] * (1.0 - 0.5 * r2);
  }
  st->radius  = 1.0;
  st->volume  = 0.05;
  st->sloped  = SLOPE_NONE;
  pairs->c    = st->slope;
  st->self[0] = 1.0;
  StencilFinish(st);
  PairsFinish(1.0, st, pairs);
  ASSERT_OK(PetscRandomDestroy(&random));
}

/* A linear pressure has its exact gradient with mixed and first_order, for both densities; a
   constant one has none with shepard. */
static void test_pressure_force(void **state)
{
  const PetscReal b[] = {2.0, -1.0, 0.5}, none[ISPH_MAX_DIM] = {0.0};

  (void)state;
  for (PetscInt dim = 2; dim <= 3; dim++) {
    Stencil *st;
    Pairs    pairs = {0};

    ASSERT_OK(StencilCreate(dim, &st));
    for (int sums = 0; sums < 2; sums++) {
      const PairTerms own = {.by_sums = sums, .corrected = PETSC_TRUE, .rho = 1.0, .p = 3.0};
      PairSums        exact, constant;

      FillPairs(b, st, &pairs);
      StencilGradients(st, CORRECTION_MIXED);
      PairsSum(st, &pairs, &own, &exact);
      assert_true(PetscAbsReal(exact.divergence - (b[0] + b[1] + (dim == 3 ? b[2] : 0.0))) <
                  ROUNDING);
      FillPairs(none, st, &pairs);
      StencilGradients(st, CORRECTION_SHEPARD);
      PairsSum(st, &pairs, &own, &constant);
      for (PetscInt a = 0; a < dim; a++) {
        assert_true(PetscAbsReal(exact.pressure[a] + b[a]) < ROUNDING);
        assert_true(PetscAbsReal(constant.pressure[a]) < ROUNDING);
      }
    }
    ASSERT_OK(PairsFree(&pairs));
    ASSERT_OK(StencilDestroy(&st));
  }
}

/* Artificial viscosity acts between particles that approach only, and slows them. */
static void test_artificial_viscosity(void **state)
{
  const PetscReal apart[] = {1.0, 1.0}, together[] = {-1.0, -1.0}, alpha_beta[] = {1.0, 2.0};
  PetscReal       a[2][ISPH_MAX_DIM] = {{0.0}};
  Stencil        *st;
  Pairs           pairs = {0};

  (void)state;
  ASSERT_OK(StencilCreate(2, &st));
  st->h = 0.5;
  FillPairs(apart, st, &pairs);
  StencilGradients(st, 0);
  ArtificialViscosity(st, &pairs, alpha_beta, 10.0, 1.0, a[0]);
  FillPairs(together, st, &pairs);
  st->n = 1;
  StencilFinish(st);
  StencilGradients(st, 0);
  ArtificialViscosity(st, &pairs, alpha_beta, 10.0, 1.0, a[1]);
  assert_true(a[0][0] == 0.0 && a[0][1] == 0.0);
  assert_true(a[1][0] * st->X[0][0] + a[1][1] * st->X[1][0] < 0.0); /* away from the neighbour */
  ASSERT_OK(PairsFree(&pairs));
  ASSERT_OK(StencilDestroy(&st));
}

/* The kernel sum of a lattice: of the cubic spline at h = dx the particle itself, four neighbours
   at dx and four at sqrt(2) dx, 10/(7 pi) (1 + 4/4 + 4 (2 - sqrt 2)^3/4). */
static void test_lattice_sum(void **state)
{
  const PetscReal exact =
      10.0 / (7.0 * PETSC_PI) * (2.0 + PetscPowRealInt(2.0 - PetscSqrtReal(2.0), 3));
  const TableRow *row;
  Scene           scene = {.dim = 2};
  Operators       ops   = {.forms = {.h_over_dx = 1.0}};
  const Flow      flow  = {.scene = &scene, .ops = &ops};

  (void)state;
  ASSERT_OK(TableFind(&KernelTable, "cubic_spline", &row));
  ops.forms.kernel = (const KernelRow *)(const void *)row;
  assert_true(PetscAbsReal(WcsphLatticeSum(&flow) - exact) < ROUNDING);
}

int main(int argc, char *argv[])
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_equations_of_state),
      cmocka_unit_test(test_pressure_force),
      cmocka_unit_test(test_artificial_viscosity),
      cmocka_unit_test(test_lattice_sum),
  };

  int failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  return PetscFinalize() || failed;
}
