/* All tables of the program with their papers: what -catalogue prints and the README quotes. */
#include "isph/patch.h"

/*
  CatalogueView - Lists everything that can be chosen by name, with what it is and who published it

  Collective on the viewer
*/
PetscErrorCode CatalogueView(PetscViewer viewer)
{
  const Table *const tables[] = {&CaseTable,
                                 &ShapeTable,
                                 &SchemeTable,
                                 &ProjectionTable,
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
                                 &FieldTable};

  PetscFunctionBegin;
  PetscCall(PetscViewerASCIIPrintf(viewer, "isph %s: what can be chosen by name\n", ISPH_VERSION));
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(tables); k++) {
    PetscCall(TableView(tables[k], viewer));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
