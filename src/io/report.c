/* The report: measured quantities, their errors against exact or published values, and the
   comparison of errors with -check_<quantity>. reportfile.c writes the file of -report. */
#include "isph/io.h"

enum { REPORT, CHECK };
static const OptionRow options[] = {
    [REPORT] = OPTION(FILE, "-report", "CSV file to which errors and cost of the run are appended",
                      NULL, NULL, .file = FILE_WRITTEN),
    [CHECK]  = OPTION(REAL, "-check_<quantity>",
                      "largest relative error allowed for a reported quantity, as in -check_u_min; "
                       "a larger error gives an exit status other than 0",
                      "-", NULL, NOT_NEGATIVE, .late = PETSC_TRUE),
};
const OptionTable ReportOptions = OPTIONS("Report", options);

/* ReportCreate - Creates an empty report; collective on PETSC_COMM_WORLD */
PetscErrorCode ReportCreate(Report **report)
{
  PetscFunctionBegin;
  PetscCall(PetscNew(report));
  PetscCall(OptionGetFile(&options[REPORT], (*report)->file));
  if ((*report)->file[0]) PetscCall(ReportFileCheck((*report)->file));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ReportDestroy(Report **report)
{
  PetscFunctionBegin;
  if (!*report) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FreeAll(&(*report)->quantity, report));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReportAppend(Report *report, const char name[], PetscReal value,
                                   PetscReal reference, PetscReal error)
{
  Quantity *q;

  PetscFunctionBegin;
  if (report->n == report->capacity) {
    report->capacity = 2 * report->capacity + 16;
    PetscCall(PetscRealloc(sizeof(Quantity) * (size_t)report->capacity, &report->quantity));
  }
  q = &report->quantity[report->n++];
  PetscCall(PetscStrncpy(q->name, name, sizeof(q->name)));
  q->t         = report->t;
  q->value     = value;
  q->reference = reference;
  q->error     = error;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds a measured quantity, and keeps the name of the first that is not finite. */
static PetscErrorCode ReportMeasured(Report *report, const char name[], PetscReal value,
                                     PetscReal reference, PetscReal error)
{
  PetscFunctionBegin;
  if (PetscIsInfOrNanReal(value) && !report->not_finite[0])
    PetscCall(PetscStrncpy(report->not_finite, name, sizeof(report->not_finite)));
  PetscCall(ReportAppend(report, name, value, reference, error));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ReportAdd - Adds a quantity without reference, at time report->t. All ranks add the same value.
   Input: name - as in the report file, at most 31 characters. */
PetscErrorCode ReportAdd(Report *report, const char name[], PetscReal value)
{
  PetscFunctionBegin;
  PetscCall(ReportMeasured(report, name, value, NAN, NAN));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  ReportAddReference - Adds a quantity with its exact or published value

    error = |value - reference| / scale

  All ranks add the same value. Input: scale - positive, in the unit of the quantity; usually
  |reference|.
*/
PetscErrorCode ReportAddReference(Report *report, const char name[], PetscReal value,
                                  PetscReal reference, PetscReal scale)
{
  PetscFunctionBegin;
  PetscCall(
      ReportMeasured(report, name, value, reference, PetscAbsReal(value - reference) / scale));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ReportRestore - Adds a quantity that was reported before a restart, and keeps the name of the
   first with an infinite number. Input: row - time, value, reference, error, NaN for each that is
   absent */
PetscErrorCode ReportRestore(Report *report, const char name[], const PetscReal row[4])
{
  const PetscReal now = report->t;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < 4 && !report->not_finite[0]; k++) {
    if (PetscIsInfReal(row[k]) || PetscIsNanReal(row[0]))
      PetscCall(PetscStrncpy(report->not_finite, name, sizeof(report->not_finite)));
  }
  report->t = row[0];
  PetscCall(ReportAppend(report, name, row[1], row[2], row[3]));
  report->t = now;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ReportAddMissing - Adds a quantity whose reference data are absent, so that it has no value */
PetscErrorCode ReportAddMissing(Report *report, const char name[])
{
  PetscFunctionBegin;
  PetscCall(ReportAppend(report, name, NAN, NAN, NAN));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ReportAddBeyond - Adds a relative residual, and as its error the part of it that is a fault
   [-] */
PetscErrorCode ReportAddBeyond(Report *report, const char name[], PetscReal residual,
                               PetscReal error)
{
  PetscFunctionBegin;
  PetscCall(ReportMeasured(report, name, residual, NAN, error));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ReportFind - Returns the row of a quantity at the present time; NULL: there is none */
Quantity *ReportFind(Report *report, const char name[])
{
  for (PetscInt k = report->n - 1; k >= 0 && report->quantity[k].t == report->t; k--)
    if (!strcmp(report->quantity[k].name, name)) return &report->quantity[k];
  return NULL;
}

/* ReportAddError - Adds a quantity that is itself a relative error [-] */
PetscErrorCode ReportAddError(Report *report, const char name[], PetscReal error)
{
  PetscFunctionBegin;
  PetscCall(ReportAddBeyond(report, name, error, error));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns true if the report has quantities of several times. */
static PetscBool ReportSpansTimes(const Report *report)
{
  for (PetscInt k = 1; k < report->n; k++) {
    if (report->quantity[k].t != report->quantity[0].t) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* ReportView - Prints the table of quantities, then the wall time. Collective on the viewer. Input:
   wall_seconds - duration of the run [s]. */
PetscErrorCode ReportView(const Report *report, PetscReal wall_seconds, PetscViewer viewer)
{
  const PetscBool times = ReportSpansTimes(report);

  PetscFunctionBegin;
  if (report->n) {
    PetscCall(PetscViewerASCIIPrintf(viewer, "\n%-22s", "quantity"));
    if (times) PetscCall(PetscViewerASCIIPrintf(viewer, " %10s", "t"));
    PetscCall(PetscViewerASCIIPrintf(viewer, " %14s %14s %10s\n", "value", "reference", "error %"));
  }
  for (PetscInt k = 0; k < report->n; k++) {
    const Quantity *q         = &report->quantity[k];
    char            value[32] = "-", reference[32] = "-", error[32] = "-";
    PetscBool       share; /* of a bound, no error in per cent */

    if (!PetscIsNanReal(q->value))
      PetscCall(PetscSNPrintf(value, sizeof(value), "%.6g", (double)q->value));
    if (!PetscIsNanReal(q->reference)) {
      PetscCall(PetscSNPrintf(reference, sizeof(reference), "%.6g", (double)q->reference));
    }
    PetscCall(PetscStrcmp(q->name, "balance", &share));
    if (share) PetscCall(PetscStrncpy(reference, "of its bound", sizeof(reference)));
    if (!PetscIsNanReal(q->error) && !share) {
      PetscCall(PetscSNPrintf(error, sizeof(error), "%.3g", 100.0 * (double)q->error));
    }
    PetscCall(PetscViewerASCIIPrintf(viewer, "%-22s", q->name));
    if (times) PetscCall(PetscViewerASCIIPrintf(viewer, " %10.4g", (double)q->t));
    PetscCall(PetscViewerASCIIPrintf(viewer, " %14s %14s %10s\n", value, reference, error));
  }
  PetscCall(PetscViewerASCIIPrintf(viewer, "\nwall time %.3g s\n", (double)wall_seconds));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Determines if quantity k is the last quantity of its name. */
static PetscErrorCode ReportIsLast(const Report *report, PetscInt k, PetscBool *last)
{
  PetscFunctionBegin;
  *last = PETSC_TRUE;
  for (PetscInt m = k + 1; m < report->n && *last; m++) {
    PetscBool same;

    PetscCall(PetscStrcmp(report->quantity[k].name, report->quantity[m].name, &same));
    if (same) *last = PETSC_FALSE;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Compares the errors of all quantities of a name with the tolerance; prints and counts larger
   errors. */
static PetscErrorCode ReportCheckQuantity(const Report *report, const char name[],
                                          PetscReal tolerance, PetscInt *failed)
{
  PetscFunctionBegin;
  for (PetscInt k = 0; k < report->n; k++) {
    const Quantity *q = &report->quantity[k];
    PetscBool       same;

    PetscCall(PetscStrcmp(q->name, name, &same));
    if (!same || q->error <= tolerance) continue;
    UserCheck(!PetscIsNanReal(q->error) || PetscIsNanReal(q->value),
              "-check_%s: the quantity has no reference to be compared with", name);
    PetscCall(PetscPrintf(PETSC_COMM_WORLD, "check_%s: error %.4g > %.4g at t = %.6g\n", name,
                          (double)q->error, (double)tolerance, (double)q->t));
    (*failed)++;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses a -check_<name> of a quantity that is not reported, and lists the reported quantities. */
static PetscErrorCode ReportRefuseUnknown(const char known[])
{
  PetscInt n;
  char   **names, **values, unknown[128] = "";

  PetscFunctionBegin;
  PetscCall(PetscOptionsLeftGet(NULL, &n, &names, &values));
  for (PetscInt k = 0; k < n && !unknown[0]; k++) {
    PetscBool check;

    PetscCall(PetscStrncmp(names[k], "check_", 6, &check));
    if (check) PetscCall(PetscStrncpy(unknown, names[k], sizeof(unknown)));
  }
  PetscCall(PetscOptionsLeftRestore(NULL, &n, &names, &values));
  UserCheck(!unknown[0], "-%s: the run reports no such quantity; it reports %s", unknown,
            known[0] ? known : "none");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ReportCheck - Compares errors with the tolerances of the user; collective on PETSC_COMM_WORLD.
   Called at the end of the run. */
PetscErrorCode ReportCheck(const Report *report)
{
  char     known[1024] = "";
  PetscInt failed      = 0;

  PetscFunctionBegin;
  PetscCheck(
      !report->not_finite[0], PETSC_COMM_WORLD, PETSC_ERR_FP,
      "%s is not finite: numbers of this run leave the range of the computer; choose units in "
      "which length, speed and viscosity are nearer to 1",
      report->not_finite);
  for (PetscInt k = 0; k < report->n; k++) {
    const char *name = report->quantity[k].name;
    char        option[OPTION_LENGTH];
    PetscReal   tolerance = 0.0;
    PetscBool   last, set;
    OptionRow   row;

    PetscCall(ReportIsLast(report, k, &last));
    if (!last) continue;
    AppendWord(known, sizeof(known), name);
    OptionFill(&options[CHECK], name, option, &row);
    PetscCall(OptionGetReal(&row, &tolerance, &set));
    if (set) PetscCall(ReportCheckQuantity(report, name, tolerance, &failed));
  }
  PetscCall(ReportRefuseUnknown(known));
  UserCheck(!failed, "%" PetscInt_FMT " error%s above the tolerance of -check_<quantity>", failed,
            failed == 1 ? " is" : "s are");
  PetscFunctionReturn(PETSC_SUCCESS);
}
