/* Means over sections of the flow. */
#include "cases.h"

/*
  MeanThroughSide - Computes the mean velocity along an axis on the low side of the box across it,
  which no body cuts [m/s]

  Collective. Uses the midpoint rule on the cells of the lattice.
*/
PetscErrorCode MeanThroughSide(const Flow *flow, PetscInt axis, PetscReal *mean)
{
  const Scene   *scene = flow->scene;
  const PetscInt dim   = scene->dim;
  PetscInt       n     = 1;
  PetscReal     *x, *u;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < dim; a++) n *= a == axis ? 1 : scene->cells[a];
  PetscCall(PetscMalloc2(dim * n, &x, dim * n, &u));
  for (PetscInt k = 0; k < n; k++) {
    PetscInt index = k;

    for (PetscInt a = 0; a < dim; a++) {
      x[dim * k + a] = scene->lo[a];
      if (a == axis) continue;
      x[dim * k + a] += (index % scene->cells[a] + 0.5) * SceneCellSide(scene, a);
      index /= scene->cells[a];
    }
  }
  PetscCall(ProbePoints(flow, n, x, u, NULL));
  *mean = 0.0;
  for (PetscInt k = 0; k < n; k++) *mean += u[dim * k + axis] / n;
  PetscCall(PetscFree2(x, u));
  PetscFunctionReturn(PETSC_SUCCESS);
}
