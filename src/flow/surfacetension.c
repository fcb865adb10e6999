/*
  The tension of the free surface of strain cells: its force, its energy, and its change in a step,
  which makes the viscous matrix stiffer. Source: docs/developers/theory.md, (strain:tension)
*/
#include "isph/flow.h"
#include "isph/strain.h"

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

/* FlowSurfaceTension - Computes the force of the tension of the free surface and of interfaces,
   and adds its change in a step to the viscous matrix. Collective. Output: state->interface - force
   per unit mass [m/s^2]; state->tension_energy. */
PetscErrorCode FlowSurfaceTension(Flow *flow)
{
  const Scene       *scene = flow->scene;
  const Particles   *p     = flow->particles;
  const StrainCells *cells = flow->ops->strain;
  AffineOperator    *visc  = &flow->ops->velocity[0].visc;
  PetscReal         *force, *mass[ISPH_MAX_DIM], sum[2] = {0.0}; /* energy, mass */
  PetscBool          has = scene->tension > 0.0;
  PetscScalar       *to;
  Mat                K;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < scene->n_regions; k++) has = has || scene->region_tension[k] > 0.0;
  for (PetscInt a = 0; a < p->dim; a++) {
    mass[a] = cells->mass[cells->sets == 1 ? 0 : a];
    if (!has && flow->state->interface[a]) PetscCall(VecZeroEntries(flow->state->interface[a]));
  }
  if (!has) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FlowStateRenumber(flow));
  PetscCall(PetscCalloc1(p->dim * p->n_fluid, &force));
  PetscCall(StrainTension(scene, p, cells, force, &sum[0]));
  for (PetscInt a = 0; a < p->dim; a++) {
    PetscCall(VecGetArrayWrite(flow->state->interface[a], &to));
    for (PetscInt i = 0; i < p->n_fluid; i++)
      to[i] = force[p->dim * i + a] / (scene->rho * mass[a][i]);
    PetscCall(VecRestoreArrayWrite(flow->state->interface[a], &to));
  }
  PetscCall(PetscFree(force));
  for (PetscInt i = 0; i < p->n_fluid; i++) sum[1] += scene->rho * mass[0][i];
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 2, MPIU_REAL, MPIU_SUM, p->comm));
  for (PetscInt side = 0; side < 2 * p->dim; side++) /* dry walls that fluid wets have energy */
    sum[0] +=
        scene->tension * PetscMax(scene->boundary[side].contact, 0.0) * BoxArea(scene, side / 2);
  flow->state->tension_energy = 2.0 * sum[0] / sum[1];
  PetscCall(StrainTensionMatrix(p, cells, &K));
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
