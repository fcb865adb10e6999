/* Creeping flow through a periodic array of bodies: what its cases report. */
#include "cases.h"

/* Computes the mean velocity along an axis on the low side of the box across it, which no body
   cuts, by the midpoint rule on the cells of the lattice [m/s]. */
static PetscErrorCode MeanThroughSide(const Flow *flow, PetscInt axis, PetscReal *mean)
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

/*
  MeasureArray - Reports the drag of the body of a periodic cell, driven by a body force along x

  Collective. The drag follows from the balance with the driving force, which holds in steady flow;
  the force on the body, by the momentum of the fluid and by tractions, has the driving force as its
  reference.

  Input Parameters:
+ scale - the drag is F/(scale U), with the mean velocity U through the cell
- known - the reference of the drag [-]; NaN: none
*/
PetscErrorCode MeasureArray(const Flow *flow, PetscReal scale, PetscReal known, Report *report)
{
  const Scene *scene  = flow->scene;
  PetscReal    driven = scene->rho * scene->body_force[0];
  PetscReal    mean   = 0.0, force[FORCE_WAYS][2 * ISPH_MAX_DIM];

  PetscFunctionBegin;
  for (PetscInt a = 0; a < scene->dim; a++) driven *= scene->hi[a] - scene->lo[a];
  if (!SceneIsNewtonian(scene) || SceneHas(scene, PHYSICS_CONVECTION)) known = NAN;
  PetscCall(MeanThroughSide(flow, 0, &mean));
  PetscCall(WallForce(flow, SceneBodySide(scene, 0), force));
  if (mean > 0.0) {
    PetscCall(ReportAddReference(report, "drag", driven / (scale * mean), known,
                                 PetscIsNanReal(known) ? 1.0 : known));
    /* the references have a pressure gradient in place of the force; it acts on the body too, so
       that their drag is F/(1 - c) */
    for (PetscInt way = 0; way < 2; way++)
      PetscCall(ReportAddReference(report, way == FORCE_MOMENTUM ? "force" : "traction",
                                   force[way][0] / (1.0 - scene->solid_fraction), driven, driven));
  }
  PetscCall(MeasureCommon(flow, NAN, report));
  PetscFunctionReturn(PETSC_SUCCESS);
}
