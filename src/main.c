/* The program: answers a request that needs no run, or else creates a scene and solves it. */
#include "isph/catalogue.h"
#include "isph/patch.h"
#include "isph/run.h"

static PetscErrorCode Solve(void)
{
  Scene *scene;

  PetscFunctionBegin;
  PetscCall(SceneCreate(&scene));
  if (scene->problem->patch) PetscCall(PatchRun(scene));
  else PetscCall(FlowRun(scene));
  PetscCall(SceneDestroy(&scene));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints the answer to a request, on the first rank. Returns PETSC_FALSE if PETSc must be
   initialised: for a run, or for PETSc's own help. */
static PetscBool Answer(Request request)
{
  int rank;

  (void)MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  if (rank == 0) {
    if (request == REQUEST_USAGE) UsagePrint(stdout);
    if (request == REQUEST_HELP || request == REQUEST_HELP_PETSC) HelpPrint(stdout);
    if (request == REQUEST_VERSION) VersionPrint(stdout);
    if (request == REQUEST_REFERENCE) ReferencePrint(stdout);
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
  PetscCall(OptionsCheckRanges());
  if (catalogue) PetscCall(CatalogueView(PETSC_VIEWER_STDOUT_WORLD));
  else if (help && request != REQUEST_HELP_PETSC) (void)Answer(REQUEST_HELP);
  else PetscCall(Solve());
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
  if (sentence[0]) (void)fprintf(stderr, "isph: %s\n", sentence);
  refused = sentence[0] ? 1 : 0;
  (void)MPI_Bcast(&refused, 1, MPI_INT, 0, MPI_COMM_WORLD);
  return refused ? PETSC_TRUE : PETSC_FALSE;
}

int main(int argc, char **argv)
{
  ErrorState     errors;
  PetscErrorCode failed;
  Request        request;

  if (MPI_Init(&argc, &argv)) return 1;
  request = CommandLineRequest(&argc, argv);
  if (Answer(request)) return MPI_Finalize();
  if (Refuse(argc, argv)) {
    (void)MPI_Finalize();
    return 1;
  }
  failed = PetscInitialize(&argc, &argv, NULL, NULL);
  if (failed) return (int)failed;
  failed = SolveOrList(request, &errors);
  if (failed) return ErrorsExit(failed, &errors);
  failed = PetscFinalize();
  (void)MPI_Finalize();
  return (int)failed;
}
