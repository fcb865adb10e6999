/* Quantities of fluids with a free surface, beside those of norms.c. The volume inside the surface
   is the sum over the cells of the particles. The reference is the sum of the volumes of the
   particles, which never change. See theory.md, (surface:cell). */
#include "isph/balance.h"
#include "monitors.h"
#include "schemes/surface/surface.h"

#define GRID 4 /* points of the cells along dx */

/* FluidVolume - Computes the volume inside the free surface [m^dim]. Collective. Output: volume -
   at the places of the last step; mass - sum of the volumes of the particles, its reference. */
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
    .name = "volume", .header = "volume,error", .Prepare = PrepareVolume, .Write = WriteVolume};

/* Adds volume, first moments, momentum and angular momentum of own particles to the sums, over the
   density; extends [-x_min, x_max, -y_min, ...] of the fluid without isolated particles. */
static void AddMoments(const Flow *flow, const PetscScalar *const u[], PetscReal sum[],
                       PetscReal extent[])
{
  const Particles *p = flow->particles;
  const PetscInt   d = p->dim;

  for (PetscInt i = 0; i < p->n_fluid; i++) {
    const PetscReal V = p->volume[i];

    sum[0] += V;
    for (PetscInt a = 0; a < d; a++) {
      const PetscInt b = (a + 1) % d;

      sum[1 + a] += V * p->x[a][i];
      sum[4 + a] += V * (PetscReal)PetscRealPart(u[a][i]);
      sum[7 + a] += V * PetscRealPart(p->x[a][i] * u[b][i] - p->x[b][i] * u[a][i]);
      if (flow->ops->free->kind[i] == SURFACE_ISOLATED) continue;
      extent[2 * a]     = PetscMax(extent[2 * a], -p->x[a][i]);
      extent[2 * a + 1] = PetscMax(extent[2 * a + 1], p->x[a][i]);
    }
  }
}

/*
  MeasureFree - Computes the quantities of fluids with a free surface

    angular_momentum = |sum_i rho V_i (x_i - X) x u_i| [kg m^2/s], X: centre of mass; in 2D with its
    sign, per metre of depth; x_min, x_max, y_min, ...: where the outermost particles are, but for
    isolated ones [m]; fluid_volume, inside the surface, its reference the volume of the particles
    [m^dim]

  Collective. Nothing without a free surface. In a periodic box the angular momentum has no meaning
  and is left out.
*/
PetscErrorCode MeasureFree(const Flow *flow, Report *report)
{
  const PetscInt     d       = flow->scene->dim;
  PetscReal          sum[10] = {0.0}, size = 0.0, L[ISPH_MAX_DIM];
  PetscReal          extent[2 * ISPH_MAX_DIM] = {0.0};
  const PetscScalar *u[ISPH_MAX_DIM];
  PetscBool          periodic = PETSC_FALSE;
  PetscReal          volume, mass;
  char               name[8];

  PetscFunctionBegin;
  if (!flow->ops->free) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt e = 0; e < 2 * d; e++) extent[e] = -PETSC_INFINITY;
  for (PetscInt a = 0; a < d; a++) PetscCall(VecGetArrayRead(flow->state->u[a], &u[a]));
  AddMoments(flow, u, sum, extent);
  for (PetscInt a = 0; a < d; a++) PetscCall(VecRestoreArrayRead(flow->state->u[a], &u[a]));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 10, MPIU_REAL, MPIU_SUM, flow->particles->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, extent, 2 * (PetscMPIInt)d, MPIU_REAL, MPIU_MAX,
                             flow->particles->comm));
  for (PetscInt a = 0; a < d; a++) {
    const PetscInt b = (a + 1) % d;

    L[a] = flow->scene->rho *
           (sum[7 + a] - (sum[1 + a] * sum[4 + b] - sum[1 + b] * sum[4 + a]) / sum[0]);
    size += PetscSqr(L[a]);
    if (SceneIsPeriodic(flow->scene, a)) periodic = PETSC_TRUE;
  }
  if (!periodic)
    PetscCall(ReportAdd(report, "angular_momentum", d == 2 ? L[0] : PetscSqrtReal(size)));
  for (PetscInt e = 0; e < 2 * d; e++) {
    PetscCall(PetscSNPrintf(name, sizeof(name), "%c_%s", "xyz"[e / 2], e % 2 ? "max" : "min"));
    PetscCall(ReportAdd(report, name, e % 2 ? extent[e] : -extent[e]));
  }
  PetscCall(FluidVolume(flow, &volume, &mass));
  PetscCall(ReportAddReference(report, "fluid_volume", volume, mass, mass));
  if (SceneMoves(flow->scene) && flow->clock->bursts)
    PetscCall(ReportAdd(report, "bursts", flow->clock->bursts));
  BalanceSet(BALANCE_VOLUME, volume / mass - 1.0, PetscAbsReal(volume / mass - 1.0), flow->clock->t,
             &flow->scheme->sheet);
  PetscFunctionReturn(PETSC_SUCCESS);
}
