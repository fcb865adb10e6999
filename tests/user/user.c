/* Runs the flow of the command line, as isph does, and says that it has. */
#include <isph/cases.h>
#include <isph/catalogue.h>
#include <isph/run.h>

int main(int argc, char **argv)
{
  Scene *scene;

  OptionsKnow(CatalogueOptions);
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  PetscCall(SceneCreate(&CaseOption, &scene));
  PetscCall(FlowRun(scene));
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "Re = %g\n", (double)SceneReynolds(scene)));
  PetscCall(SceneDestroy(&scene));
  return (int)PetscFinalize();
}
