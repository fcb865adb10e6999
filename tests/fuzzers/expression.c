/*
  Fuzzer of expressions. The first byte gives the number of components and the variables; the rest
  is the text. Values of an accepted text are finite, or the scope has a fault.
*/
#include "fuzzer.h"
#include "isph/options.h"
#include <math.h>
#include <stdlib.h>

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
  FuzzerStart();
  return 0;
}

/* Evaluates all components and their rates at positions and times with odd values among them. */
static void Evaluate(const Expression *e)
{
  const PetscReal x[][ISPH_MAX_DIM] = {{0.3, -0.7, 1.1}, {0.0}, {1e300, -1e300, 1e-300}};
  const PetscReal t[]               = {0.0, 1.5, 1e300};

  for (PetscInt c = 0; c < e->n; c++) {
    for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(t); k++) {
      FuzzerAssert(isfinite(ExpressionValue(e, c, t[k], x[k])) ? PETSC_TRUE : PETSC_FALSE,
                   "a value is not finite");
      (void)ExpressionRate(e, c, t[k], x[k], 1.0);
    }
  }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
  FuzzerInput      input  = {data, size};
  const unsigned   choice = FuzzerByte(&input);
  const PetscInt   dim = 2 + (PetscInt)(choice >> 2 & 1), most = 1 + (PetscInt)(choice & 3) % 3;
  const unsigned   allowed = choice >> 3 & 3; /* EXPRESSION_PLACE, EXPRESSION_TIME */
  char            *text    = FuzzerText(&input, 4096);
  ExpressionScope *scope;
  Expression       e;

  if (ExpressionScopeCreate(dim, NULL, &scope)) abort();
  if (ExpressionScopeDefine(scope, "nu", 0.25)) abort();
  if (!ExpressionSet(scope, "-fuzzed", text, 1, most, allowed, &e)) {
    Evaluate(&e);
    (void)ExpressionScopeCheck(scope);
  }
  if (ExpressionScopeDestroy(&scope)) abort();
  free(text);
  return 0;
}
