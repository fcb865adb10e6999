/*
  The volume inside free surfaces: the sum over the cells of the particles. The reference is the sum
  of the volumes of the particles, which never change. See docs/theory.md, (158).
*/
#include "monitors.h"
#include "schemes/surface/surface.h"

#define GRID 4 /* points of the cells along dx */

/*
  FluidVolume - Computes the volume inside the free surface [m^dim]

  Collective. Output: volume - at the places of the last step; mass - sum of the volumes of the
  particles, its reference.
*/
PetscErrorCode FluidVolume(const Flow *flow, PetscReal *volume, PetscReal *mass)
{
  const PetscInt n   = flow->particles->n_fluid;
  PetscReal      sum = 0.0, *cell;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(n, &cell));
  /* fixed particles keep no lists of neighbours */
  PetscCall(NeighborsUpdate(flow->particles, 0.0, flow->neighbors));
  PetscCall(FlowCellVolumes(flow, GRID, cell));
  for (PetscInt i = 0; i < n; i++) sum += cell[i];
  if (!SceneMoves(flow->scene)) PetscCall(NeighborsRelease(flow->neighbors));
  PetscCall(PetscFree(cell));
  PetscCallMPI(MPI_Allreduce(&sum, volume, 1, MPIU_REAL, MPIU_SUM, flow->particles->comm));
  *mass = flow->particles->weight * flow->particles->cell_volume;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses a flow without a free surface. */
static PetscErrorCode PrepareVolume(Flow *flow, const Monitor *monitor)
{
  PetscFunctionBegin;
  (void)monitor;
  UserCheck(flow->ops->free,
            "-probe_volume: this flow has no free surface, and its volume is that of the box");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes the volume and its error. */
static PetscErrorCode WriteVolume(const Flow *flow, Monitor *monitor)
{
  PetscReal volume, mass;

  PetscFunctionBegin;
  PetscCall(FluidVolume(flow, &volume, &mass));
  if (MonitorRow(flow->clock, monitor))
    (void)fprintf(monitor->stream, ",%.12g,%.6g\n", (double)volume, (double)(volume / mass - 1.0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const MonitorKind MonitorVolume = {
    .name    = "volume",
    .header  = "volume,error",
    .Prepare = PrepareVolume,
    .Write   = WriteVolume,
};
