/*
  The tension of the free surface of strain cells: its force, its energy, and its change in a step,
  which makes the viscous matrix stiffer. Source: docs/developers/theory.md, (strain:tension)
*/
#include "isph/flow.h"
#include "isph/quantities.h"
#include "isph/strain.h"
#include <string.h>

/* Adds a matrix to one that may have products only. */
static PetscErrorCode AddMatrix(Mat X, Mat *Y)
{
  PetscBool products;
  Mat       sum;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)*Y, MATSHELL, &products));
  if (!products) {
    PetscCall(SparseAdd(X, Y));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MatCreateComposite(PetscObjectComm((PetscObject)X), 2, (Mat[]){*Y, X}, &sum));
  PetscCall(MatDestroy(Y));
  *Y = sum;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the area of the sides across an axis [m^(dim-1)]. */
static PetscReal BoxArea(const Scene *scene, PetscInt axis)
{
  PetscReal area = 1.0;

  for (PetscInt a = 0; a < scene->dim; a++) area *= a == axis ? 1.0 : scene->hi[a] - scene->lo[a];
  return area;
}

/* Sets a tension that varies to that of the present places and scalars of the particles.
   Collective. Errors: a value out of bounds ends the run. */
static PetscErrorCode SetVarying(Flow *flow)
{
  const Scene     *scene                = flow->scene;
  const Particles *p                    = flow->particles;
  const PetscReal *scalar[SCALARS_MOST] = {NULL};
  PetscReal       *sigma, most[2] = {0.0, 0.0}; /* beyond the bounds */

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(ParticlesAll(p) + 1, &sigma));
  for (PetscInt k = 0; k < scene->n_scalars; k++)
    for (PetscInt f = 0; f < p->n_fields; f++)
      if (!strcmp(p->field[f].name, scene->scalar[k].name)) scalar[k] = *p->field[f].slot;
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscReal x[ISPH_MAX_DIM] = {0.0}, field[SCALARS_MOST] = {0.0};

    for (PetscInt a = 0; a < p->dim; a++) x[a] = p->x[a][i];
    for (PetscInt k = 0; k < scene->n_scalars; k++)
      field[k] = scalar[k] ? scalar[k][i] : ScalarAtStart(&scene->scalar[k], x);
    sigma[i] = ExpressionOf(&scene->tension_field, 0, flow->clock->t, x, field, 0.0);
    most[0]  = PetscMax(most[0], -sigma[i]);
    most[1]  = PetscMax(most[1], sigma[i]);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, most, 2, MPIU_REAL, MPIU_MAX, p->comm));
  PetscCall(ExpressionScopeCheck(scene->scope));
  UserCheck(most[0] <= 0.0 && most[1] <= scene->tension * (1.0 + PETSC_SQRT_MACHINE_EPSILON),
            "-surface_tension_field: it is %.6g N/m at t = %.6g; allowed is 0 to -surface_tension, "
            "%.6g",
            (double)(most[0] > 0.0 ? -most[0] : most[1]), (double)flow->clock->t,
            (double)scene->tension);
  PetscCall(ParticlesHaloField(p, sigma));
  StrainSetTension(p, sigma, flow->ops->strain);
  PetscCall(PetscFree(sigma));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns true if a surface or an interface has tension. Output: mass - of particles in the cells,
   of each component [m^dim]. */
static PetscBool HasTension(const Flow *flow, PetscReal *mass[])
{
  const Scene       *scene = flow->scene;
  const StrainCells *cells = flow->ops->strain;
  PetscBool          has   = scene->tension > 0.0;

  for (PetscInt a = 0; a < scene->dim; a++) mass[a] = cells->mass[cells->sets == 1 ? 0 : a];
  for (PetscInt k = 0; k < scene->n_regions; k++) has = has || scene->region_tension[k] > 0.0;
  return has;
}

/* FlowSurfaceTension - Computes the force of the tension of the free surface and of interfaces.
   Collective. Output: state->interface - force per unit mass [m/s^2]; state->tension_energy, zero
   if the tension varies, which has none. */
PetscErrorCode FlowSurfaceTension(Flow *flow)
{
  const Scene       *scene = flow->scene;
  const Particles   *p     = flow->particles;
  const StrainCells *cells = flow->ops->strain;
  PetscReal         *force, *mass[ISPH_MAX_DIM], sum[2] = {0.0}; /* energy, mass */
  const PetscBool    has = HasTension(flow, mass);
  PetscScalar       *to;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < p->dim; a++)
    if (!has && flow->state->interface[a]) PetscCall(VecZeroEntries(flow->state->interface[a]));
  if (!has) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FlowStateRenumber(flow));
  if (scene->tension_field.n) PetscCall(SetVarying(flow));
  PetscCall(PetscCalloc1(p->dim * p->n_fluid, &force));
  PetscCall(StrainTension(scene, p, cells, force, &sum[0]));
  for (PetscInt a = 0; a < p->dim; a++) {
    PetscReal most;

    PetscCall(VecGetArrayWrite(flow->state->interface[a], &to));
    for (PetscInt i = 0; i < p->n_fluid; i++)
      to[i] = force[p->dim * i + a] / (scene->rho * mass[a][i]);
    PetscCall(VecRestoreArrayWrite(flow->state->interface[a], &to));
    if (!scene->tension_field.n) continue;
    PetscCall(VecNorm(flow->state->interface[a], NORM_INFINITY, &most)); /* it drives the flow */
    flow->scheme->bound.force_step = PetscMax(flow->scheme->bound.force_step, most);
  }
  PetscCall(PetscFree(force));
  for (PetscInt i = 0; i < p->n_fluid; i++) sum[1] += scene->rho * mass[0][i];
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 2, MPIU_REAL, MPIU_SUM, p->comm));
  for (PetscInt side = 0; side < 2 * p->dim; side++) /* dry walls that fluid wets have energy */
    sum[0] +=
        scene->tension * PetscMax(scene->boundary[side].contact, 0.0) * BoxArea(scene, side / 2);
  flow->state->tension_energy = scene->tension_field.n ? 0.0 : 2.0 * sum[0] / sum[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FlowTensionMatrix - Adds the change of the tension in a step to the viscous matrix. Collective,
   once for each assembly. */
PetscErrorCode FlowTensionMatrix(Flow *flow)
{
  const Scene     *scene = flow->scene;
  const Particles *p     = flow->particles;
  AffineOperator  *visc  = &flow->ops->velocity[0].visc;
  PetscReal       *mass[ISPH_MAX_DIM];
  Mat              K;

  PetscFunctionBegin;
  if (!HasTension(flow, mass)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(StrainTensionMatrix(p, flow->ops->strain, &K));
  PetscCall(VelocityRowsDivide(p, mass, -flow->clock->dt / (scene->rho * scene->nu), K));
  if (SceneViscosityVaries(scene) && p->dim == 2) {
    PetscCall(PetscObjectReference((PetscObject)K));
    flow->ops->cut_part[0] = visc->A;
    flow->ops->cut_part[1] = K;
    PetscCall(MatDuplicate(flow->ops->cut_part[0], MAT_COPY_VALUES, &visc->A));
  }
  PetscCall(AddMatrix(K, &visc->A));
  PetscCall(MatDestroy(&K));
  PetscFunctionReturn(PETSC_SUCCESS);
}
