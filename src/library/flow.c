/* The life of a flow of include/isph.h: creation from options, steps, report. Each call makes the
   options of the flow PETSc's own, and keeps the message of an error, until it returns. */
#include "isph/cases.h"
#include "isph/catalogue.h"
#include "isph/patch.h"
#include "library.h"
#include <ctype.h>
#include <string.h>

/* IsphInitialize - see isph.h. PETSc is finalised by those who have initialised it. */
PetscErrorCode IsphInitialize(void)
{
  char  name[] = "isph", quiet[] = "-no_signal_handler", skip[] = "-skip_petscrc";
  char *words[] = {name, quiet, skip, NULL}, **argv = words;
  int   argc = 3;

  if (PetscInitializeCalled) return PETSC_SUCCESS;
  PrepareMpi();
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  return PetscPushErrorHandler(PetscReturnErrorHandler, NULL);
}

/* IsphFinalize - see isph.h. */
PetscErrorCode IsphFinalize(void)
{
  return PetscInitializeCalled && !PetscFinalizeCalled ? PetscFinalize() : PETSC_SUCCESS;
}

/* CallBegin - Begins a call of the library, which CallEnd() ends in any case; collective. Errors: a
   call out of order. */
PetscErrorCode CallBegin(IsphFlow f, CallNeed need)
{
  PetscFunctionBegin;
  PetscCheck(!f->depth++, PETSC_COMM_SELF, PETSC_ERR_USER_INPUT,
             "a function of an expression calls its own flow");
  if (f->options) PetscCall(PetscOptionsPush(f->options));
  PetscCall(ErrorsKeep(&f->errors));
  UserCheck(need != NEEDS_NO_SETUP || !f->is_set_up, "the flow is set up already");
  UserCheck(need != NEEDS_FLOW || f->is_set_up, "the flow is not set up; call IsphFlowSetUp()");
  UserCheck(need != NEEDS_FLOW || !f->failed, "the flow has ended with an error");
  UserCheck(need != NEEDS_FLOW || !f->idle,
            "there is no flow: -case %s is a patch test, or nothing is computed",
            f->run.flow.scene->problem->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* CallEnd - Ends a call; returns its error after the caller's error handler has had it;
   collective */
PetscErrorCode CallEnd(IsphFlow f, PetscErrorCode failed)
{
  if (--f->depth) return failed;
  (void)snprintf(f->message, sizeof(f->message), "%s%s", f->errors.kept.message,
                 f->errors.kept.file ? f->errors.kept.hint : "");
  if (f->options) (void)PetscOptionsPop();
  return ErrorsRelease(failed, &f->errors);
}

PetscErrorCode IsphFlowCreate(IsphFlow *flow)
{
  PetscFunctionBegin;
  OptionsKnow(CatalogueOptions);
  PetscCall(PetscNew(flow));
  (*flow)->functions = (Table){"Functions", (*flow)->function, sizeof(FunctionRow), 0, NULL};
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds words to the options of a flow. The first rank reads files. */
static PetscErrorCode AddOptions(IsphFlow f, int argc, char *argv[])
{
  char sentence[2 * PETSC_MAX_PATH_LEN] = "";
  int  rank;

  PetscFunctionBegin;
  (void)MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  if (rank == 0) OptionsCheckWords("", argc, argv, sentence, sizeof(sentence));
  PetscCallMPI(MPI_Bcast(sentence, sizeof(sentence), MPI_CHAR, 0, PETSC_COMM_WORLD));
  UserCheck(!sentence[0], "%s", sentence);
  PetscCall(PetscOptionsInsertArgs(f->options, argc, argv));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode IsphFlowSetOptions(IsphFlow f, int argc, char *argv[])
{
  PetscErrorCode failed = PETSC_SUCCESS;

  if (!f->options) failed = PetscOptionsCreate(&f->options);
  if (!failed) failed = CallBegin(f, NEEDS_NO_SETUP);
  if (!failed) failed = AddOptions(f, argc, argv);
  return CallEnd(f, failed);
}

PetscErrorCode IsphFlowSetOption(IsphFlow f, const char name[], const char value[])
{
  char *words[] = {(char *)(uintptr_t)name, (char *)(uintptr_t)value};

  if (!value || OptionNamesFile(name)) return IsphFlowSetOptions(f, value ? 2 : 1, words);
  PetscCall(IsphFlowSetOptions(f, 0, NULL));
  return PetscOptionsSetValue(f->options, name, value);
}

/* Adds a function for expressions. */
static PetscErrorCode AddFunction(IsphFlow f, const char name[], IsphFunction function, void *ctx)
{
  const PetscInt  n    = f->functions.count;
  const size_t    most = sizeof(f->name[0]) - 1;
  const TableRow *same;
  PetscBool       good = isalpha((unsigned char)name[0]) ? PETSC_TRUE : PETSC_FALSE;

  PetscFunctionBegin;
  for (const char *c = name; *c; c++) good = good && (isalnum((unsigned char)*c) || *c == '_');
  PetscCall(TableFind(&f->functions, name, &same));
  UserCheck(good && strlen(name) <= most && name[1],
            "function %s: a name has 2 to %d letters, digits and _, and begins with a letter", name,
            (int)most);
  UserCheck(!same, "function %s: there is one of this name already", name);
  UserCheck(n < LIBRARY_FUNCTIONS, "function %s: at most %d are allowed", name, LIBRARY_FUNCTIONS);
  PetscCall(PetscStrncpy(f->name[n], name, sizeof(f->name[n])));
  f->function[n]     = (FunctionRow){f->name[n], "", "", function, ctx};
  f->functions.count = n + 1;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode IsphFlowSetFunction(IsphFlow f, const char name[], IsphFunction function, void *ctx)
{
  PetscErrorCode failed = CallBegin(f, NEEDS_NO_SETUP);

  if (!failed) failed = AddFunction(f, name, function, ctx);
  return CallEnd(f, failed);
}

PetscErrorCode IsphFlowSetMonitor(IsphFlow f, IsphMonitor monitor, void *ctx)
{
  f->Monitor     = monitor;
  f->monitor_ctx = ctx;
  return PETSC_SUCCESS;
}

/* Refuses options of the program, which a flow does not read. */
static PetscErrorCode RefuseProgramOptions(void)
{
  const OptionRow *row;

  PetscFunctionBegin;
  for (PetscInt k = 0; (row = OptionNext(&ProgramOptions, &k));) {
    PetscBool given;

    PetscCall(OptionGiven(row->name, &given));
    UserCheck(!given || OptionNamesFile(row->name),
              "%s: it belongs to the program isph, not to a flow of a library", row->name);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the options, creates the flow and begins it. */
static PetscErrorCode ReadAndBegin(IsphFlow f)
{
  Run      *run = &f->run;
  PetscBool viewed, help, progress;

  PetscFunctionBegin;
  f->is_set_up = PETSC_TRUE;
  PetscCall(OptionsCheckSolvers());
  if (f->options) PetscCall(RefuseProgramOptions());
  PetscCall(PluginsOpen());
  PetscCall(SceneCreate(&CaseOption, &f->functions, &run->flow.scene));
  PetscCall(SceneView(run->flow.scene, &viewed));
  PetscCall(OptionGiven("-help", &help));
  f->idle = viewed || help || run->flow.scene->problem->patch ? PETSC_TRUE : PETSC_FALSE;
  if (viewed) run->over = PETSC_TRUE;
  if (viewed || run->flow.scene->problem->patch) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(OptionGiven("-progress", &progress));
  if (f->options && !progress) PetscCall(PetscOptionsSetValue(f->options, "-progress", "none"));
  PetscCall(RunCreate(run));
  if (help) run->over = PETSC_TRUE;
  else PetscCall(RunBegin(run));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode IsphFlowSetUp(IsphFlow f)
{
  PetscErrorCode failed = CallBegin(f, NEEDS_NO_SETUP);

  if (!failed) failed = f->failed = ReadAndBegin(f);
  return CallEnd(f, failed);
}

/* Makes a step towards a time. */
static PetscErrorCode StepTowards(IsphFlow f, PetscReal until)
{
  PetscErrorCode failed = CallBegin(f, NEEDS_FLOW);

  if (!failed && !f->run.over && !f->run.signal) {
    f->run.flow.clock->until = until;
    failed = f->failed = RunStep(&f->run);
  }
  failed = CallEnd(f, failed);
  return failed || !f->Monitor ? failed : f->Monitor(f, f->monitor_ctx);
}

PetscErrorCode IsphFlowStep(IsphFlow f)
{
  return StepTowards(f, PETSC_INFINITY);
}

/* Makes the measures of a patch test, which is no flow. */
static PetscErrorCode MeasurePatch(IsphFlow f)
{
  PetscErrorCode failed = CallBegin(f, NEEDS_NOTHING);

  if (!failed) failed = f->failed = PatchRun(f->run.flow.scene);
  f->run.over = PETSC_TRUE;
  return CallEnd(f, failed);
}

PetscErrorCode IsphFlowRun(IsphFlow f, PetscReal until)
{
  const PetscReal before = PetscMin(until, PETSC_INFINITY) * (1.0 - 1e-12);
  PetscErrorCode  failed = PETSC_SUCCESS;

  if (f->idle) return f->run.over ? PETSC_SUCCESS : MeasurePatch(f);
  if (!f->is_set_up || f->failed) return StepTowards(f, until);
  while (!failed && !f->run.over && !f->run.signal && f->run.flow.clock->t < before)
    failed = StepTowards(f, until);
  return failed;
}

PetscErrorCode IsphFlowIsOver(IsphFlow f, PetscBool *over)
{
  *over = f->run.over || f->run.signal || f->failed ? PETSC_TRUE : PETSC_FALSE;
  return PETSC_SUCCESS;
}

PetscErrorCode IsphFlowView(IsphFlow f, PetscViewer viewer)
{
  PetscErrorCode failed;

  if (f->idle) return PETSC_SUCCESS;
  failed = CallBegin(f, NEEDS_FLOW);
  if (!failed) failed = RunShowBanner(&f->run, viewer);
  return CallEnd(f, failed);
}

PetscErrorCode IsphFlowReport(IsphFlow f, PetscViewer viewer)
{
  PetscErrorCode failed;

  if (f->idle || !f->run.report) return PETSC_SUCCESS;
  failed = CallBegin(f, NEEDS_NOTHING);
  if (!failed) failed = RunReport(&f->run, f->failed, viewer);
  return CallEnd(f, failed);
}

const char *IsphFlowGetError(IsphFlow f)
{
  return f->message;
}

/* Frees what a flow has, the last part last. */
static PetscErrorCode Free(IsphFlow f)
{
  PetscFunctionBegin;
  if (f->run.flow.scene) PetscCall(RunDestroy(&f->run));
  PetscCall(SceneDestroy(&f->run.flow.scene));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode IsphFlowDestroy(IsphFlow *flow)
{
  PetscErrorCode failed;

  if (!*flow) return PETSC_SUCCESS;
  failed = CallBegin(*flow, NEEDS_NOTHING);
  if (!failed) failed = Free(*flow);
  failed = CallEnd(*flow, failed);
  PetscCall(PetscOptionsDestroy(&(*flow)->options));
  PetscCall(PetscFree(*flow));
  return failed;
}
