/* Quantities of fluids with a free surface, beside those of norms.c. The volume inside the surface
   is that of the strain cells, and of single particles, which have none. */
#include "isph/balance.h"
#include "isph/strain.h"
#include "monitors.h"

/* Computes the volume inside the free surface [m^dim]. Collective. Output: volume - of the cells
   and of single particles; mass - sum of the volumes of the particles, and of the fluid that waits
   at inflows for the next ones, its reference. */
static PetscErrorCode FluidVolume(const Flow *flow, PetscReal *volume, PetscReal *mass)
{
  const Particles   *p     = flow->particles;
  const StrainCells *cells = flow->ops->strain;
  PetscReal          sum[] = {0.0, 0.0};

  PetscFunctionBegin;
  for (PetscInt c = 0; c < cells->n; c++) {
    PetscReal x[ISPH_MAX_DIM];

    if (StrainHasCell(p, cells, c, x)) sum[0] += cells->volume[c];
  }
  for (PetscInt i = 0; i < p->n_fluid; i++)
    if (cells->apart[i]) sum[0] += p->volume[i];
  for (PetscInt i = 0; i < ParticlesOwn(p); i++) sum[1] += StrainVolumeOf(flow->scene, p, i);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 2, MPIU_REAL, MPIU_SUM, p->comm));
  *volume = sum[0];
  *mass   = sum[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses a flow without a free surface. */
static PetscErrorCode PrepareVolume(Flow *flow, const Monitor *monitor)
{
  PetscFunctionBegin;
  (void)monitor;
  UserCheck(
      flow->ops->cut_surface,
      "-probe_volume: this flow has no free surface of strain cells; without a surface the volume "
      "is that of the box, and -scheme wcsph has none");
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

/* Adds mass, first moments, momentum and angular momentum of own particles to the sums; extends
   [-x_min, x_max, -y_min, ...] of the fluid, but not to single particles outside its surface. */
static void AddMoments(const Flow *flow, const PetscScalar *const u[], PetscReal sum[],
                       PetscReal extent[])
{
  const Particles *p = flow->particles;
  const PetscInt   d = p->dim;

  for (PetscInt i = 0; i < p->n_fluid; i++) {
    const PetscReal m = p->volume[i] * ParticlesDensity(flow->scene, p, i);

    sum[0] += m;
    for (PetscInt a = 0; a < d; a++) {
      const PetscInt b = (a + 1) % d;

      sum[1 + a] += m * p->x[a][i];
      sum[4 + a] += m * (PetscReal)PetscRealPart(u[a][i]);
      sum[7 + a] += m * PetscRealPart(p->x[a][i] * u[b][i] - p->x[b][i] * u[a][i]);
      if (flow->ops->cut_surface && flow->ops->strain->apart[i]) continue;
      extent[2 * a]     = PetscMax(extent[2 * a], -p->x[a][i]);
      extent[2 * a + 1] = PetscMax(extent[2 * a + 1], p->x[a][i]);
    }
  }
}

/* Extends the fluid to the corners of the surface. */
static void AddSurface(PetscInt d, const StrainSurface *surface, PetscReal extent[])
{
  for (PetscInt k = 0; k < surface->n * d * d; k++) {
    if (surface->between[k / (d * d)]) continue;
    extent[2 * (k % d)]     = PetscMax(extent[2 * (k % d)], -surface->x[k]);
    extent[2 * (k % d) + 1] = PetscMax(extent[2 * (k % d) + 1], surface->x[k]);
  }
}

/*
  MeasureFree - Computes the quantities of fluids with a free surface

    angular_momentum = |sum_i rho V_i (x_i - X) x u_i| [kg m^2/s], X: centre of mass; in 2D with its
    sign, per metre of depth; x_min, x_max, y_min, ...: of the surface and the particles in it,
    without a surface of all particles [m]; fluid_volume, inside the surface, its reference the
    volume of the particles [m^dim]

  Collective. Nothing without a free surface. In a periodic box the angular momentum, and the
  extents along a periodic direction, have no meaning and are left out.
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
  if (!SceneHasFreeSurface(flow->scene)) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt e = 0; e < 2 * d; e++) extent[e] = -PETSC_INFINITY;
  for (PetscInt a = 0; a < d; a++) PetscCall(VecGetArrayRead(flow->state->u[a], &u[a]));
  AddMoments(flow, u, sum, extent);
  if (flow->ops->cut_surface) AddSurface(d, &flow->ops->strain->surface, extent);
  for (PetscInt a = 0; a < d; a++) PetscCall(VecRestoreArrayRead(flow->state->u[a], &u[a]));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 10, MPIU_REAL, MPIU_SUM, flow->particles->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, extent, 2 * (PetscMPIInt)d, MPIU_REAL, MPIU_MAX,
                             flow->particles->comm));
  for (PetscInt a = 0; a < d; a++) {
    const PetscInt b = (a + 1) % d;

    L[a] = sum[7 + a] - (sum[1 + a] * sum[4 + b] - sum[1 + b] * sum[4 + a]) / sum[0];
    size += PetscSqr(L[a]);
    if (SceneIsPeriodic(flow->scene, a)) periodic = PETSC_TRUE;
  }
  if (!periodic)
    PetscCall(ReportAdd(report, "angular_momentum", d == 2 ? L[0] : PetscSqrtReal(size)));
  for (PetscInt e = 0; e < 2 * d; e++) {
    if (SceneIsPeriodic(flow->scene, e / 2)) continue;
    PetscCall(PetscSNPrintf(name, sizeof(name), "%c_%s", "xyz"[e / 2], e % 2 ? "max" : "min"));
    PetscCall(ReportAdd(report, name, e % 2 ? extent[e] : -extent[e]));
  }
  if (!flow->ops->cut_surface) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FluidVolume(flow, &volume, &mass));
  PetscCall(ReportAddReference(report, "fluid_volume", volume, mass, mass));
  BalanceSet(BALANCE_VOLUME, volume / mass - 1.0, PetscAbsReal(volume / mass - 1.0), flow->clock->t,
             &flow->scheme->sheet);
  PetscFunctionReturn(PETSC_SUCCESS);
}
