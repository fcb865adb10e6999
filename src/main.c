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
#include "isph/patch.h"
#include "isph/run.h"
#include <errno.h>
#include <string.h>

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

static PetscErrorCode SolveOrList(void)
{
  PetscBool catalogue;

  PetscFunctionBegin;
  PetscCall(ErrorsInstall());
  PetscCall(OptionGiven("-catalogue", &catalogue));
  if (catalogue) PetscCall(CatalogueView(PETSC_VIEWER_STDOUT_WORLD));
  else PetscCall(Solve());
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  What PETSc would pass over or meet with a traceback: a stray word, an unreadable options file.
  Returns the sentence, or an empty one.
*/
static void CheckArguments(int argc, char **argv, char sentence[], size_t length)
{
  sentence[0] = '\0';
  for (int k = 1; k < argc && !sentence[0]; k++) {
    const PetscBool word = argv[k][0] != '-' ? PETSC_TRUE : PETSC_FALSE;

    if (word && (k == 1 || argv[k - 1][0] != '-')) {
      (void)snprintf(sentence, length,
                     "%s: a stray word; options begin with a dash, e.g. -case cavity", argv[k]);
    } else if (word && strcmp(argv[k - 1], "-options_file") == 0) {
      FILE *file = fopen(argv[k], "r");

      if (file) (void)fclose(file);
      else (void)snprintf(sentence, length, "-options_file %s: %s", argv[k], strerror(errno));
    }
  }
}

int main(int argc, char **argv)
{
  char           sentence[PETSC_MAX_PATH_LEN + 128];
  int            rank;
  PetscErrorCode failed;

  if (MPI_Init(&argc, &argv)) return 1;
  (void)MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  CheckArguments(argc, argv, sentence, sizeof(sentence));
  if (sentence[0]) {
    if (rank == 0) (void)fprintf(stderr, "isph: %s\n", sentence);
    (void)MPI_Finalize();
    return 1;
  }
  failed = PetscInitialize(&argc, &argv, NULL, help);
  if (failed) return (int)failed;
  failed = SolveOrList();
  if (failed) return ErrorsExit(failed);
  failed = PetscFinalize();
  (void)MPI_Finalize();
  return (int)failed;
}
