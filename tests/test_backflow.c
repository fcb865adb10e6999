/*
  Particles that return through outflows: where two outflows meet, both find the same void, and one
  particle enters.
*/
#include "cloud.h"
#include "../src/motion/entrants.h"

#define DX 0.1

/* In units of dx: (0.35, 0.5) and (0.5, 0.35) return in a corner and are 0.21 apart, (0.35, 1.5) is
   1 from the first. The last two enter through the inflow, which no return may stop. */
static void test_corner(void **state)
{
  const BoundaryRow outflow  = {.properties = BOUNDARY_OUTFLOW};
  const BoundaryRow inflow   = {.properties = BOUNDARY_INFLOW};
  Boundary          side[4]  = {{.kind = &outflow}, {.kind = &inflow}, {.kind = &outflow}};
  Scene             scene    = {.dim = 2, .dx = DX, .boundary = side};
  Entrant           places[] = {{.x = {0.35 * DX, 0.5 * DX}, .side = 0},
                                {.x = {0.5 * DX, 0.35 * DX}, .side = 2},
                                {.x = {0.35 * DX, 1.5 * DX}, .side = 0},
                                {.x = {0.4 * DX, 0.4 * DX}, .side = 1},
                                {.x = {0.4 * DX, 0.5 * DX}, .side = 1}};
  Entrants          entrants = {.n = 5, .entrant = places};

  (void)state;
  EntrantsDropCrowded(&scene, &entrants);
  assert_int_equal(entrants.n, 4);
  assert_true(places[0].x[1] == 0.5 * DX);
  assert_true(places[1].x[1] == 1.5 * DX);
  assert_true(places[2].side == 1 && places[3].side == 1);
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_corner)};
  int                     failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  return PetscFinalize() || failed;
}
