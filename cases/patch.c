/* Box of the patch tests: particles at cell centres of the unit square or cube, except for a margin
   of -patch_margin spacings at its sides. src/patch/ has the tests. */
#include "cases.h"

static PetscErrorCode PatchSetup(Scene *scene)
{
  PetscFunctionBegin;
  UserCheck(scene->n - 2.0 * scene->margin >= 2.0,
            "-patch_margin %.6g: with -n %" PetscInt_FMT " at most %.6g is allowed",
            (double)scene->margin, scene->n, 0.5 * (double)scene->n - 1.0);
  for (PetscInt a = 0; a < scene->dim; a++) {
    scene->lo[a] = scene->margin * scene->dx;
    scene->hi[a] = scene->length - scene->margin * scene->dx;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

const CaseRow CasePatch = {
    .name            = "patch",
    .brief           = "patch test: errors of an operator for a given field, no flow",
    .citation        = "Zheng, Ma & Shao, Water 10 (2018)",
    .three_d         = PETSC_TRUE,
    .physics         = PHYSICS_VISCOSITY | PHYSICS_WALLS,
    .reynolds        = 1.0,
    .reynolds_length = 1.0,
    .n               = 50,
    .Setup           = PatchSetup,
    .patch           = PETSC_TRUE,
};
