static const char help[] =
    "isph: incompressible viscous flow by Smoothed Particle Hydrodynamics.\n\n"
    "  du/dt = -grad p/rho + nu lap u + f,   div u = 0\n\n"
    "Viscosity is advanced implicitly by a PETSc TS (prefix -visc_), the pressure Poisson equation "
    "is\n"
    "solved by a KSP (prefix -ppe_); or both at once by a field split (-scheme coupled, prefix "
    "-coupled_).\nExamples:\n\n"
    "  isph -options_file options/cavity.opts -reynolds 1000 -t_end 40 -visc_ts_type arkimex\n"
    "  isph -case cavity -reynolds 0.01 -motion eulerian -scheme coupled -steady\n\n"
    "-catalogue lists cases, operators, walls, schemes and integrators with their papers.\n\n";

#include "isph/catalogue.h"
#include "isph/options.h"
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

static PetscErrorCode SolveOrList(ErrorState *errors)
{
  PetscBool catalogue;

  PetscFunctionBegin;
  PetscCall(ErrorsInstall(errors));
  PetscCall(OptionGiven("-catalogue", &catalogue));
  if (catalogue) PetscCall(CatalogueView(PETSC_VIEWER_STDOUT_WORLD));
  else PetscCall(Solve());
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Answers a request that needs no run, on the first rank. */
static void Answer(Request request)
{
  int rank;

  (void)MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  if (rank) return;
  if (request == REQUEST_USAGE) UsagePrint(stdout);
  if (request == REQUEST_VERSION) VersionPrint(stdout);
}

/* Refuses words that PETSc would pass over or meet with a traceback. */
static PetscBool Refuse(int argc, char **argv)
{
  char sentence[2 * PETSC_MAX_PATH_LEN];
  int  rank;

  CommandLineCheck(argc, argv, sentence, sizeof(sentence));
  (void)MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  if (sentence[0] && rank == 0) (void)fprintf(stderr, "isph: %s\n", sentence);
  return sentence[0] ? PETSC_TRUE : PETSC_FALSE;
}

int main(int argc, char **argv)
{
  ErrorState     errors;
  PetscErrorCode failed;
  Request        request;

  if (MPI_Init(&argc, &argv)) return 1;
  request = CommandLineRequest(&argc, argv);
  if (request == REQUEST_USAGE || request == REQUEST_VERSION) {
    Answer(request);
    return MPI_Finalize();
  }
  if (Refuse(argc, argv)) {
    (void)MPI_Finalize();
    return 1;
  }
  failed = PetscInitialize(&argc, &argv, NULL, help);
  if (failed) return (int)failed;
  failed = SolveOrList(&errors);
  if (failed) return ErrorsExit(failed, &errors);
  failed = PetscFinalize();
  (void)MPI_Finalize();
  return (int)failed;
}
