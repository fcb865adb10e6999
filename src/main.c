/* The program: answers a request that needs no run, or else runs a flow of the library. */
#include "isph.h"
#include "isph/catalogue.h"
#include "isph/regime.h"
#include "isph/run.h"

/* Prints the log of -log_view, before PETSc would without looking for a full disk. */
static PetscErrorCode ViewLog(void)
{
  PetscViewer       viewer;
  PetscViewerFormat format;
  PetscBool         given;

  PetscFunctionBegin;
  PetscCall(PetscOptionsCreateViewer(PETSC_COMM_WORLD, NULL, NULL, "-log_view", &viewer, &format,
                                     &given));
  if (!given || !viewer) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscViewerPushFormat(viewer, format));
  PetscCall(PetscLogView(viewer));
  PetscCall(PetscViewerPopFormat(viewer));
  PetscCall(ViewerCheck(viewer, "-log_view"));
  PetscCall(PetscViewerDestroy(&viewer));
  PetscCall(PetscOptionsClearValue(NULL, "-log_view"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Runs the flow of PETSc's options. A failed step is reported too. */
static PetscErrorCode Solve(void)
{
  const PetscViewer out = PETSC_VIEWER_STDOUT_WORLD;
  PetscErrorCode    failed;
  IsphFlow          flow;

  PetscFunctionBegin;
  PetscCall(InterruptInstall());
  PetscCall(IsphFlowCreate(&flow));
  PetscCall(IsphFlowSetUp(flow));
  PetscCall(IsphFlowView(flow, out));
  failed = IsphFlowRun(flow, PETSC_INFINITY);
  PetscCall(IsphFlowReport(flow, out));
  PetscCall(failed);
  PetscCall(IsphFlowDestroy(&flow));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints the answer to a request, on the first rank. Input: word - of -help; NULL: none. Returns
   PETSC_FALSE if PETSc must be initialised: for a run, or for PETSc's own help. */
static PetscBool Answer(Request request, const char word[])
{
  int rank;

  (void)MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  if (rank == 0) {
    if (request == REQUEST_USAGE) UsagePrint(stdout);
    if (request == REQUEST_HELP && word) HelpSearch(stdout, word);
    else if (request == REQUEST_HELP || request == REQUEST_HELP_PETSC) HelpPrint(stdout);
    if (request == REQUEST_VERSION) VersionPrint(stdout);
    if (request == REQUEST_REFERENCE) {
      ReferencePrint(stdout);
      RegimePrint(stdout, PETSC_TRUE);
    }
    (void)fflush(stdout);
  }
  return request == REQUEST_RUN || request == REQUEST_HELP_PETSC ? PETSC_FALSE : PETSC_TRUE;
}

/* Solves the scene, unless an options file or the environment requests the catalogue or help. */
static PetscErrorCode SolveOrList(Request request, ErrorState *errors)
{
  PetscBool catalogue, help;

  PetscFunctionBegin;
  PetscCall(ErrorsInstall(errors));
  PetscCall(OptionGiven("-catalogue", &catalogue));
  PetscCall(OptionGiven("-help", &help));
  if (catalogue) PetscCall(CatalogueView(PETSC_VIEWER_STDOUT_WORLD));
  else if (help && request != REQUEST_HELP_PETSC) (void)Answer(REQUEST_HELP, NULL);
  else PetscCall(Solve());
  PetscCall(ViewLog());
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses options that PETSc would ignore or answer with a traceback. Files and environment are the
   first rank's, as in PETSc. */
static PetscBool Refuse(int argc, char **argv)
{
  char sentence[2 * PETSC_MAX_PATH_LEN] = "";
  int  rank, refused;

  (void)MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  if (rank == 0) OptionsCheck(argc, argv, sentence, sizeof(sentence));
  if (sentence[0]) ErrorPrint(sentence, "");
  refused = sentence[0] ? 1 : 0;
  (void)MPI_Bcast(&refused, 1, MPI_INT, 0, MPI_COMM_WORLD);
  return refused ? PETSC_TRUE : PETSC_FALSE;
}

/* Ends MPI; returns the exit status, which tells also if standard output could be written. */
static int Finish(int status)
{
  (void)MPI_Finalize();
  if (status || (!fflush(stdout) && !ferror(stdout))) return status;
  ErrorPrint("standard output cannot be written, or the disk is full", "");
  return PETSC_ERR_FILE_WRITE;
}

int main(int argc, char **argv)
{
  ErrorState     errors;
  PetscErrorCode failed;
  const char    *word;
  Request        request;

  /* A line of an error is one write: mpiexec mixes the writes of the ranks. */
  (void)setvbuf(stderr, NULL, _IOLBF, BUFSIZ);
  OptionsKnow(CatalogueOptions);
  PrepareMpi();
  if (MPI_Init(&argc, &argv)) return 1;
  request = CommandLineRequest(&argc, argv, &word);
  if (Answer(request, word)) return Finish(0);
  if (Refuse(argc, argv)) return Finish(1);
  failed = PetscInitialize(&argc, &argv, NULL, NULL);
  if (failed) return (int)failed;
  failed = SolveOrList(request, &errors);
  if (failed) return ErrorsExit(failed, &errors);
  failed = PetscFinalize();
  return Finish((int)failed);
}
