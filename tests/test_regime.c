/* For each flow one row of each table of defaults holds: no gap and no overlap. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <cmocka.h>
#include "isph/scene.h"

/* Checks all combinations of the facts of a table at a number. */
static void CheckFacts(RegimeChoice choice, unsigned facts, PetscReal x)
{
  const RegimeTable *table  = &RegimeTables[choice];
  Regime             regime = {.facts = 0};
  unsigned           set    = 0;

  regime.number[table->number] = x;
  do {
    PetscInt holding = 0;

    regime.facts = set;
    for (PetscInt k = 0; k < table->count; k++)
      if (RegimeHolds(&regime, choice, &table->rows[k])) holding++;
    if (holding != 1)
      print_error("%s: %" PetscInt_FMT " rows hold for facts %x and the number %.17g\n",
                  table->option, holding, set, (double)x);
    assert_int_equal(holding, 1);
    assert_true(RegimeHolds(&regime, choice, RegimeFind(&regime, choice)));
    set = (set - facts) & facts; /* the next subset */
  } while (set);
}

/* Checks the least and the largest numbers, each bound, and the numbers beside it. */
static void test_cover(void **state)
{
  (void)state;
  for (PetscInt c = 0; c < REGIMES; c++) {
    const RegimeTable *table = &RegimeTables[c];
    unsigned           facts = 0;

    for (PetscInt k = 0; k < table->count; k++)
      facts |= table->rows[k].holds | table->rows[k].lacks;
    CheckFacts((RegimeChoice)c, facts, 0.0);
    CheckFacts((RegimeChoice)c, facts, PETSC_INFINITY);
    for (PetscInt k = 0; k < table->count; k++) {
      const PetscReal bound = PetscMax(table->rows[k].range.above, table->rows[k].range.upto);

      CheckFacts((RegimeChoice)c, facts, bound * (1.0 - PETSC_MACHINE_EPSILON));
      CheckFacts((RegimeChoice)c, facts, bound);
      CheckFacts((RegimeChoice)c, facts, bound * (1.0 + PETSC_MACHINE_EPSILON));
    }
  }
}

/* A row needs a reason, a page and, where it has a range, a number. */
static void test_rows(void **state)
{
  (void)state;
  for (PetscInt c = 0; c < REGIMES; c++) {
    const RegimeTable *table = &RegimeTables[c];

    assert_true(table->page[0] && table->count > 1);
    for (PetscInt k = 0; k < table->count; k++) {
      const RegimeRange *range = &table->rows[k].range;

      assert_true(table->rows[k].why[0]);
      assert_false(table->rows[k].holds & table->rows[k].lacks);
      assert_true(table->number || (range->above == 0.0 && range->upto == 0.0));
    }
  }
}

/* The velocity filter grows from 0 to 1, and the pressure filter falls as 1/dt. */
static void test_laws(void **state)
{
  Regime regime = {.facts = FACT_MOVES};

  (void)state;
  regime.number[NUMBER_CELL] = 40.0;
  assert_true(RegimeValue(&regime, REGIME_FILTER_U) == 0.5);
  regime.facts                  = FACT_ORDERED | FACT_IMPLICIT;
  regime.number[NUMBER_COURANT] = 2.0;
  assert_true(RegimeValue(&regime, REGIME_FILTER_P) == 0.025);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_cover),
      cmocka_unit_test(test_rows),
      cmocka_unit_test(test_laws),
  };

  return cmocka_run_group_tests(tests, NULL, NULL);
}
