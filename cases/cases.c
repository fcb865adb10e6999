/* The table of cases, in the order of -catalogue. A new case needs a file with its row at the end,
   a name here, and an .opts file. */
#include "cases.h"
#include "isph/cases.h"

#define CASES(ROW)                                                                                 \
  ROW(CaseCavity)                                                                                  \
  ROW(CaseCavityCylinder)                                                                          \
  ROW(CaseTaylorCouette)                                                                           \
  ROW(CaseTaylorGreen)                                                                             \
  ROW(CaseCouette)                                                                                 \
  ROW(CasePoiseuille)                                                                              \
  ROW(CaseHydrostatic)                                                                             \
  ROW(CaseStokesCylinders)                                                                         \
  ROW(CaseStokesSpheres)                                                                           \
  ROW(CaseDropMode)                                                                                \
  ROW(CaseStandingWave)                                                                            \
  ROW(CaseGravityCurrent)                                                                          \
  ROW(CaseScene)                                                                                   \
  ROW(CasePatch)

#define DECLARE(row) extern const CaseRow row;
CASES(DECLARE)

#define ADDRESS(row) &row,
static const CaseRow *const cases[]   = {CASES(ADDRESS)};
const Table                 CaseTable = TABLE_OF_POINTERS("Cases", cases);

const OptionRow CaseOption =
    OPTION(NAME, "-case", "flow or patch test to compute", NULL, "cavity", .table = &CaseTable);
static const OptionRow *const options[]   = {&CaseOption};
const OptionTable             CaseOptions = OPTIONS_ELSEWHERE("Case", options);
