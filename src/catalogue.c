/* The list of all tables of the program, for -catalogue and for tests. */
#include "isph/catalogue.h"
#include "isph/patch.h"

static const Table *const tables[] = {&CaseTable,
                                      &BoundaryTable,
                                      &ShapeTable,
                                      &SchemeTable,
                                      &ProjectionTable,
                                      &DtAdaptTable,
                                      &MotionTable,
                                      &RheologyTable,
                                      &ShiftTable,
                                      &KernelTable,
                                      &LaplacianTable,
                                      &CorrectionTable,
                                      &GradientTable,
                                      &WallTable,
                                      &ViscousIntegratorTable,
                                      &CoupledIntegratorTable,
                                      &SchurTable,
                                      &ProgressTable,
                                      &FieldTable};

/* CatalogueTable - Returns table k of the program, NULL after the last; not collective */
const Table *CatalogueTable(PetscInt k)
{
  return k < (PetscInt)PETSC_STATIC_ARRAY_LENGTH(tables) ? tables[k] : NULL;
}

/*
  CatalogueView - Prints all rows that can be chosen by name, with their briefs and citations

  Collective on the viewer
*/
PetscErrorCode CatalogueView(PetscViewer viewer)
{
  PetscFunctionBegin;
  PetscCall(PetscViewerASCIIPrintf(viewer, "isph %s: choices by name\n", ISPH_VERSION));
  for (PetscInt k = 0; CatalogueTable(k); k++) PetscCall(TableView(CatalogueTable(k), viewer));
  PetscFunctionReturn(PETSC_SUCCESS);
}
