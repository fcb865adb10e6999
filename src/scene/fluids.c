/*
  Viscosity that varies in space: fluids in regions of the scene, or a function of place. A particle
  takes the viscosity at its first position and keeps it.
*/
#include "isph/scene.h"

#define SAMPLES 8 /* along each side of a particle's cell */

/* SceneViscosityVaries - Returns true if each particle has its own viscosity; not collective */
PetscBool SceneViscosityVaries(const Scene *scene)
{
  return scene->n_regions || scene->nu_field.n || !SceneIsNewtonian(scene) ? PETSC_TRUE
                                                                           : PETSC_FALSE;
}

/* SceneViscosityAt - Returns the kinematic viscosity at a place at the start [m^2/s]; not
   collective */
PetscReal SceneViscosityAt(const Scene *scene, const PetscReal x[])
{
  PetscReal nu = scene->nu_field.n ? ExpressionValue(&scene->nu_field, 0, 0.0, x) : scene->nu;

  for (PetscInt k = 0; k < scene->n_regions; k++) {
    PetscReal normal[ISPH_MAX_DIM];

    if (BodyDistance(scene, &scene->region[k], x, normal) <= 0.0) nu = scene->region_nu[k];
  }
  return nu;
}

/* Returns true if x lies in the fluid at the start, or on its boundary or free surface. */
static PetscBool IsInFluid(const Scene *scene, const PetscReal x[])
{
  PetscInt side;

  if (SceneFluidDistance(scene, x, &side) < 0.0) return PETSC_FALSE;
  if (SceneDistanceTo(scene, BOUNDARY_FREE, x, &side) < 0.0) return PETSC_FALSE;
  for (PetscInt k = 0; k < scene->n_filled; k++)
    if (SceneFilledDistance(scene, k, x) >= 0.0) return PETSC_TRUE;
  return scene->n_filled ? PETSC_FALSE : PETSC_TRUE;
}

/* Returns true if the border of a region may cut the lattice cell around x. */
static PetscBool InterfaceCuts(const Scene *scene, const PetscReal x[])
{
  PetscReal square = 0.0, normal[ISPH_MAX_DIM];

  for (PetscInt a = 0; a < scene->dim; a++) square += PetscSqr(0.5 * SceneCellSide(scene, a));
  for (PetscInt k = 0; k < scene->n_regions; k++) {
    if (PetscSqr(BodyDistance(scene, &scene->region[k], x, normal)) < square) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/*
  SceneViscosity - Returns the kinematic viscosity of a particle that starts at x [m^2/s]

    1/nu = mean of 1/nu over the fluid part of the lattice cell around x

  Not collective. The harmonic mean gives layers the right shear resistance wherever an interface
  cuts the lattice, because resistances in series add. In other cells the viscosity is that at x.
  For a fluid that is not Newtonian the result is the viscosity at the strain rate U/L, the first
  guess of the iteration.

  Reference: S. V. Patankar, Numerical Heat Transfer and Fluid Flow (1980), section 4.2-3
*/
PetscReal SceneViscosity(const Scene *scene, const PetscReal x[])
{
  const PetscInt samples = SAMPLES * SAMPLES * (scene->dim == 3 ? SAMPLES : 1);
  PetscReal      sum     = 0.0;
  PetscInt       n       = 0;

  if (!SceneIsNewtonian(scene))
    return RheologyViscosity(&scene->rheology, scene->speed / scene->length);
  if (!InterfaceCuts(scene, x)) return SceneViscosityAt(scene, x);
  for (PetscInt s = 0; s < samples; s++) {
    PetscReal y[ISPH_MAX_DIM];
    PetscInt  index = s;

    for (PetscInt a = 0; a < scene->dim; a++) {
      y[a] = x[a] + SceneCellSide(scene, a) * ((index % SAMPLES + 0.5) / SAMPLES - 0.5);
      index /= SAMPLES;
    }
    if (!IsInFluid(scene, y)) continue;
    sum += 1.0 / SceneViscosityAt(scene, y);
    n++;
  }
  return n ? n / sum : SceneViscosityAt(scene, x);
}

/*
  SceneBoundViscosity - Finds the least and largest viscosity at the centres of lattice cells; for
  a fluid that is not Newtonian, copies the bounds of its rheology

  Collective. The viscosity of a particle may lie outside these bounds, because it is a mean over a
  cell and because the particle may start at another place; SceneBoundGivenViscosity() corrects the
  bounds. Output: scene->nu_low, scene->nu_high. Errors: a field that is not positive ends the run.
*/
PetscErrorCode SceneBoundViscosity(Scene *scene)
{
  PetscInt cells;

  PetscFunctionBegin;
  scene->nu_low = scene->nu_high = scene->nu;
  if (!SceneIsNewtonian(scene)) {
    scene->nu_low  = scene->rheology.low;
    scene->nu_high = scene->rheology.high;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (!SceneViscosityVaries(scene)) PetscFunctionReturn(PETSC_SUCCESS);
  scene->nu_low  = PETSC_MAX_REAL;
  scene->nu_high = 0.0;
  PetscCall(SceneCountCells(scene->dim, scene->cells, &cells));
  for (PetscInt c = 0; c < cells; c++) {
    PetscReal x[ISPH_MAX_DIM], nu;
    PetscInt  index = c;
    char      place[PLACE_TEXT];

    for (PetscInt a = 0; a < scene->dim; a++) {
      x[a] = scene->lo[a] + ((PetscReal)(index % scene->cells[a]) + 0.5) * SceneCellSide(scene, a);
      index /= scene->cells[a];
    }
    if (!IsInFluid(scene, x)) continue;
    nu = SceneViscosityAt(scene, x);
    if (nu <= 0.0) PetscCall(ExpressionScopeCheck(scene->scope)); /* 0 may stand for NaN */
    UserCheck(nu > 0.0, "-viscosity_field: it is %.6g at (%s), and must be positive", (double)nu,
              ScenePlaceText(scene, x, place));
    scene->nu_low  = PetscMin(scene->nu_low, nu);
    scene->nu_high = PetscMax(scene->nu_high, nu);
  }
  if (scene->nu_high == 0.0) { /* no centre is in the fluid */
    scene->nu_low  = scene->nu;
    scene->nu_high = scene->nu;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  SceneBoundGivenViscosity - Finds the least and largest viscosity of the particles at the start

  Collective. Input: nu - viscosities of the n particles of this rank [m^2/s]; if n is 0 on all
  ranks, the bounds stay. Output: scene->nu_low, scene->nu_high. Errors: a viscosity that is not
  positive ends the run.
*/
PetscErrorCode SceneBoundGivenViscosity(PetscInt n, const PetscReal nu[], Scene *scene)
{
  PetscReal bound[2] = {-PETSC_MAX_REAL, 0.0};

  PetscFunctionBegin;
  for (PetscInt i = 0; i < n; i++) {
    bound[0] = PetscMax(bound[0], -nu[i]);
    bound[1] = PetscMax(bound[1], nu[i]);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, bound, 2, MPIU_REAL, MPIU_MAX, PETSC_COMM_WORLD));
  if (bound[0] == -PETSC_MAX_REAL) PetscFunctionReturn(PETSC_SUCCESS);
  if (bound[0] >= 0.0) PetscCall(ExpressionScopeCheck(scene->scope));
  UserCheck(bound[0] < 0.0,
            "-viscosity_field: it is %.6g where a particle starts, and must be positive",
            (double)-bound[0]);
  scene->nu_low  = -bound[0];
  scene->nu_high = bound[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}
