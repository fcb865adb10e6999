/* Lists all tables of the program: tables of named rows for -catalogue, and tables of options for
   -help. */
#include "isph/catalogue.h"
#include "library.h"
#include "isph/cases.h"
#include "isph/patch.h"
#include "isph/run.h"
#include "schemes/coupled/coupled.h"
#include "schemes/projection/projection.h"
#include "schemes/wcsph/wcsph.h"

static const Table *const tables[] = {&CaseTable,
                                      &BoundaryTable,
                                      &ShapeTable,
                                      &SolidTable,
                                      &SchemeTable,
                                      &ProjectionTable,
                                      &ConvectionTable,
                                      &PressurePointsTable,
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
                                      &EquationOfStateTable,
                                      &DensityFormTable,
                                      &PressureReductionTable,
                                      &ProgressTable,
                                      &FieldTable};

const OptionTable *const CatalogueOptions[] = {
    &ProgramOptions,    &CaseOptions,      &SceneOptions,    &SpacingOptions,
    &StartOptions,      &TypedOptions,     &BodyOptions,     &FreeBodyOptions,
    &ScalarOptions,     &BoundaryOptions,  &OpeningOptions,  &RheologyOptions,
    &FrameOptions,      &TimeOptions,      &SchemeOptions,   &PressurePointsOptions,
    &ProjectionOptions, &ViscosityOptions, &WcsphOptions,    &MotionOptions,
    &ParticleOptions,   &OperatorOptions,  &GuardOptions,    &SnapshotOptions,
    &MonitorOptions,    &ReportOptions,    &ProgressOptions, &CheckpointOptions,
    &PatchOptions,      &SolverOptions,    &PluginOptions,   NULL};

/* CatalogueTable - Returns table k of named rows, NULL after the last */
const Table *CatalogueTable(PetscInt k)
{
  return k < (PetscInt)PETSC_STATIC_ARRAY_LENGTH(tables) ? tables[k] : NULL;
}

/* Lists the options that choose a row of a table. */
static void OptionsOf(const Table *table, char names[], size_t size)
{
  names[0] = '\0';
  for (PetscInt t = 0; OptionTableGet(t); t++) {
    const OptionRow *row;

    for (PetscInt k = 0; (row = OptionNext(OptionTableGet(t), &k));) {
      if (row->table == table || row->table_3d == table) AppendWord(names, size, row->name);
    }
  }
}

/* Prints the stages of a step with a scheme, in their order, and the judges that repeat them. */
static PetscErrorCode SchemeViewSteps(const SchemeRow *scheme, PetscViewer viewer)
{
  PetscFunctionBegin;
  PetscCall(PetscViewerASCIIPrintf(viewer, "\nStages of a step (-scheme %s)\n", scheme->name));
  for (const Stage *const *stage = scheme->stages; *stage; stage++)
    PetscCall(PetscViewerASCIIPrintf(viewer, "  %-16s %s\n", (*stage)->name, (*stage)->brief));
  PetscCall(PetscViewerASCIIPrintf(viewer, "\nJudges of a step (-scheme %s)\n", scheme->name));
  for (const Judge *const *judge = scheme->judges; *judge; judge++)
    PetscCall(PetscViewerASCIIPrintf(viewer, "  %-16s %s\n", (*judge)->name, (*judge)->brief));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* CatalogueView - Prints all rows that can be chosen by name, with their briefs and citations, the
   stages of steps, and the defaults by the regime. Collective on the viewer. */
PetscErrorCode CatalogueView(PetscViewer viewer)
{
  PetscMPIInt rank;
  FILE       *out;

  PetscFunctionBegin;
  PetscCall(PluginsOpen());
  PetscCallMPI(MPI_Comm_rank(PetscObjectComm((PetscObject)viewer), &rank));
  PetscCall(PetscViewerASCIIGetPointer(viewer, &out));
  PetscCall(PetscViewerASCIIPrintf(viewer, "isph %s: choices by name\n", ISPH_VERSION));
  for (PetscInt k = 0; CatalogueTable(k); k++) {
    char names[256];

    OptionsOf(CatalogueTable(k), names, sizeof(names));
    PetscCall(TableView(CatalogueTable(k), names, viewer));
  }
  if (TableCount(&FunctionTable)) PetscCall(TableView(&FunctionTable, "in expressions", viewer));
  for (PetscInt k = 0; k < SchemeTable.count; k++)
    PetscCall(SchemeViewSteps((const SchemeRow *)(const void *)TableGet(&SchemeTable, k), viewer));
  if (rank == 0) RegimePrint(out, PETSC_FALSE);
  PetscCall(ViewerCheck(viewer, "-catalogue"));
  PetscFunctionReturn(PETSC_SUCCESS);
}
