/* Cells of particles as polygons: areas of cut polygons, and of segments of a parabola. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <cmocka.h>
#include "../src/geometry/cellpolygon.h"

#define TOLERANCE 1e-13

/* A disc cut by the bisectors to the eight nearest points of a lattice is a square. */
static void test_lattice(void **state)
{
  const PetscReal dx = 0.1;
  Polygon         cell;

  (void)state;
  PolygonDisc(1.2 * dx, &cell);
  assert_true(PetscAbsReal(PolygonArea(&cell) / (PETSC_PI * PetscSqr(1.2 * dx)) - 1.0) < TOLERANCE);
  for (PetscInt k = 0; k < 9; k++) {
    const PetscReal x[2] = {dx * (k % 3 - 1), dx * (k / 3 - 1)};

    if (k != 4) PolygonCut(x, 0.5 * (PetscSqr(x[0]) + PetscSqr(x[1])), &cell);
  }
  assert_true(PetscAbsReal(PolygonArea(&cell) / PetscSqr(dx) - 1.0) < TOLERANCE);
}

/* Cuts through the origin leave a half and a quarter; one beyond all corners leaves nothing. */
static void test_halves(void **state)
{
  const PetscReal across[2] = {0.6, 0.8}, along[2] = {0.8, -0.6};
  PetscReal       all;
  Polygon         disc;

  (void)state;
  PolygonDisc(2.0, &disc);
  all = PolygonArea(&disc);
  PolygonCut(across, 3.0, &disc);
  assert_true(PetscAbsReal(PolygonArea(&disc) / all - 1.0) < TOLERANCE);
  PolygonCut(across, 0.0, &disc);
  assert_true(PetscAbsReal(PolygonArea(&disc) / all - 0.5) < TOLERANCE);
  PolygonCut(along, 0.0, &disc);
  assert_true(PetscAbsReal(PolygonArea(&disc) / all - 0.25) < TOLERANCE);
  PolygonCut(along, -3.0, &disc);
  assert_true(disc.n == 0 && PolygonArea(&disc) == 0.0);
  PolygonCut(along, 0.0, &disc);
  assert_true(disc.n == 0);
}

/* A square of side 2 cut in half by the line y = 0: between the line and y = -k x^2/2 lies
   int_{-1}^{1} k x^2/2 dx = k/3. */
static void test_segment(void **state)
{
  const PetscReal e[4][2] = {{1.0, 0.0}, {-1.0, 0.0}, {0.0, 1.0}, {0.0, -1.0}}, k = 0.3;
  Polygon         square;

  (void)state;
  PolygonDisc(5.0, &square);
  for (PetscInt side = 0; side < 4; side++) PolygonCut(e[side], 1.0, &square);
  PolygonCut(e[2], 0.0, &square);
  assert_true(PetscAbsReal(PolygonArea(&square) - 2.0) < TOLERANCE);
  assert_true(PetscAbsReal(PolygonSegment(e[2], k, 1e-12, &square) - k / 3.0) < TOLERANCE);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_lattice),
      cmocka_unit_test(test_halves),
      cmocka_unit_test(test_segment),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
