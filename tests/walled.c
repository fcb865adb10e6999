/* Lists the combinations of walled.h and creates their clouds. */
#include "walled.h"

const WallRow *WalledWall(PetscInt k)
{
  return (const WallRow *)(const void *)TableGet(&WallTable, k);
}

const GradientRow *WalledGradient(PetscInt k)
{
  return (const GradientRow *)(const void *)TableGet(&GradientTable, k);
}

/* WalledBlind - Returns true if a form ignores the equations of wall particles */
PetscBool WalledBlind(unsigned properties)
{
  return (properties & FORM_FULL_SUPPORT) ? PETSC_TRUE : PETSC_FALSE;
}

/* WalledMeets - Returns true if a form works with the particles that a treatment places, and their
   density is not that of a scheme */
PetscBool WalledMeets(const WallRow *wall, PetscBool full_support)
{
  return !wall->dynamic && (!wall->on_surface || !full_support) ? PETSC_TRUE : PETSC_FALSE;
}

/* Lists each wall treatment with every Laplacian and a fixed gradient, then with a fixed Laplacian
   and every gradient; returns the number of combinations. */
static PetscInt AllForms(WalledForms forms[], PetscInt most)
{
  const LaplacianRow *some_laplacian = NULL;
  const GradientRow  *some_gradient  = NULL;
  PetscInt            n              = 0;

  for (PetscInt k = 0; k < CloudScalarForms(); k++)
    if (!WalledBlind(CloudLaplacian(k)->properties)) some_laplacian = CloudLaplacian(k);
  for (PetscInt k = 0; k < GradientTable.count; k++)
    if (!WalledBlind(WalledGradient(k)->properties)) some_gradient = WalledGradient(k);
  for (PetscInt w = 0; w < WallTable.count; w++) {
    const WallRow *wall = WalledWall(w);

    for (PetscInt k = 0; k < CloudScalarForms(); k++) {
      if (!WalledMeets(wall, WalledBlind(CloudLaplacian(k)->properties)) ||
          !CloudHas(CloudLaplacian(k), FORM_SAFE_IMPLICIT))
        continue;
      assert_true(n < most);
      forms[n++] = (WalledForms){wall, PETSC_FALSE, CloudLaplacian(k), some_gradient};
    }
    for (PetscInt k = 0; k < GradientTable.count; k++) {
      if (!WalledMeets(wall, WalledBlind(WalledGradient(k)->properties)) ||
          WalledGradient(k) == some_gradient)
        continue;
      assert_true(n < most);
      forms[n++] = (WalledForms){wall, PETSC_FALSE, some_laplacian, WalledGradient(k)};
    }
  }
  return n;
}

/* WalledForOne - Creates the cloud of a combination, fails if a fit is singular, and calls check */
void WalledForOne(const WalledForms *forms, const CloudBox *box, WalledCheck check)
{
  char  options[256], where[320];
  Cloud cloud;

  ASSERT_OK(PetscSNPrintf(options, sizeof(options),
                          "-wall %s%s -visc_laplacian %s -ppe_laplacian %s -gradient %s",
                          forms->wall->name,
                          forms->wall->on_surface ? ""
                          : forms->surface        ? " -wall_surface"
                                                  : " -wall_surface 0",
                          forms->laplacian->name, forms->laplacian->name, forms->gradient->name));
  ASSERT_OK(PetscSNPrintf(where, sizeof(where), "%dD %s, %s", (int)box->dim,
                          box->jitter > 0.0 ? "disorder" : "lattice", options));
  ASSERT_OK(CloudCreate(box, options, &cloud));
  CloudAssertNone("a fit was not determined", where, cloud.ops->regularised_rows);
  check(forms, where, &cloud);
  ASSERT_OK(CloudDestroy(&cloud));
}

/*
  WalledForAll - Calls check for every combination in 2D and 3D, on a lattice and on disordered
  particles, in a closed box or in a channel with walls on the last axis
*/
void WalledForAll(PetscBool closed, WalledCheck check)
{
  WalledForms    forms[64];
  const PetscInt n = AllForms(forms, 64);

  for (PetscInt k = 0; k < n; k++) {
    for (PetscInt dim = 2; dim <= 3; dim++) {
      for (PetscInt disorder = 0; disorder < 2; disorder++) {
        const PetscInt narrow = closed ? 4 : 7; /* 7: room for interior rows on a periodic axis */
        const CloudBox box    = {.cells      = {dim == 2 ? 12 : narrow, dim == 2 ? 9 : narrow, 5},
                                 .dim        = dim,
                                 .n_periodic = closed ? 0 : dim - 1,
                                 .jitter     = disorder ? WALLED_JITTER : 0.0};

        WalledForOne(&forms[k], &box, check);
      }
    }
  }
}

/* WalledAssert - Fails unless y equals the expected field up to tolerance/dx^power */
void WalledAssert(const char *what, const char *where, const Cloud *cloud, Vec y,
                  const Quadratic *expected, PetscInt power, PetscReal tolerance)
{
  PetscReal error;

  ASSERT_OK(CloudError(cloud, y, expected, PETSC_FALSE, &error));
  CloudAssertNone(what, where, !(error * PetscPowRealInt(cloud->scene.dx, power) <= tolerance));
}

/* WalledSetVelocity - Sets the velocity of fluid and walls to u */
void WalledSetVelocity(Cloud *cloud, const Quadratic u[])
{
  for (PetscInt c = 0; c < cloud->scene.dim; c++) {
    cloud->wall_u[c] = u[c];
    ASSERT_OK(CloudSet(cloud, &u[c], cloud->f[c]));
  }
  ASSERT_OK(CloudSetWalls(cloud));
}
