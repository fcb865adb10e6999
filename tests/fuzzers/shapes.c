/*
  Fuzzer of typed scenes. Each line of the input is an option of the scene and its value, as in an
  options file without quotes. The first byte gives the resolution.
*/
#include "fuzzer.h"
#include "isph/cases.h"
#include <stdlib.h>
#include <string.h>

#define MOST_LINES 40

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
  FuzzerStart();
  return 0;
}

/* Sets the options of a text; ignores lines with other options. */
static void SetOptions(char text[])
{
  char *line = strtok(text, "\n");

  for (PetscInt k = 0; line && k < MOST_LINES; k++, line = strtok(NULL, "\n")) {
    char *value = line + strcspn(line, " ");

    if (*value) *value++ = '\0';
    if (strncmp(line, "-scene_", 7) && strcmp(line, "-viscosity_field")) continue;
    if (strlen(line) < OPTION_LENGTH) (void)PetscOptionsSetValue(NULL, line, value);
  }
}

/* Reads the scene as SceneCreate() does, into a scene that this fuzzer owns. */
static PetscErrorCode ReadScene(Scene *scene)
{
  PetscFunctionBegin;
  PetscCall(SceneReadTyped(scene));
  PetscCall(scene->problem->Setup(scene));
  for (PetscInt a = 0; a < scene->dim; a++) {
    if (scene->hi[a] - scene->lo[a] > 64.0 * scene->dx) PetscFunctionReturn(PETSC_SUCCESS);
    scene->cells[a] = (PetscInt)PetscFloorReal((scene->hi[a] - scene->lo[a]) / scene->dx + 0.5);
  }
  PetscCall(SceneBoundViscosity(scene));
  PetscFunctionReturn(PETSC_SUCCESS);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
  static Scene scene;
  FuzzerInput  input = {data, size};
  const int    n     = 4 << (FuzzerByte(&input) & 3);
  char        *text  = FuzzerText(&input, 8192);

  (void)memset(&scene, 0, sizeof(scene));
  if (PetscOptionsClear(NULL)) abort();
  if (TableWant(&CaseTable, "-case", "scene", &scene.problem)) abort();
  if (TableWant(&MotionTable, "-motion", "lagrangian", &scene.motion)) abort();
  scene.dim     = 2;
  scene.n       = n;
  scene.physics = scene.problem->physics;
  scene.length = scene.speed = scene.rho = 1.0;
  scene.dx                               = 1.0 / n;
  scene.nu                               = 0.01;
  SceneSetSides(&scene, &BoundaryWall);
  if (ExpressionScopeCreate(scene.dim, NULL, &scene.scope)) abort();
  if (ExpressionScopeDefine(scene.scope, "nu", scene.nu)) abort();
  SetOptions(text);
  (void)ReadScene(&scene);
  if (ExpressionScopeDestroy(&scene.scope) || SceneFreeShapes(&scene)) abort();
  free(text);
  return 0;
}
