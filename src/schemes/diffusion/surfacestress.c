/*
  The pressure of free surfaces in the viscous step. The surface has p = 2 mu n.E n, a viscous
  stress of the velocity, and its gradient is a force that opposes motion along n. With the operator
  Z u of this pressure and the gradient G the viscous term of a projection is

    nu (A u + B u_wall) - G Z u/rho

  A alone has a positive eigenvalue for each particle of the surface, and nu A - G Z/rho has none:
  docs/theory.md, (157). With Z of the last velocity the same force is explicit. The sum of absolute
  weights of Z is up to 36/R, and steps of 0.1 dx^2/nu amplified disturbances of single particles:
  docs/theory.md, (330).
*/
#include "viscosity.h"

/*
  ViscosityHoldSurface - Makes the pressure of free surfaces a part of the viscous term, if it
  depends on the velocity

  Not collective. To be called before the first step, by schemes whose other forces leave this
  pressure out. Surfaces have no such pressure where the viscosity varies, and with pair forces
  everywhere.
*/
PetscErrorCode ViscosityHoldSurface(const Flow *flow, Viscosity *v)
{
  PetscFunctionBegin;
  if (!v || !OperatorsStressSurface(flow->ops)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscNew(&v->surface));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SurfaceStressFree - Frees the matrices; collective */
PetscErrorCode SurfaceStressFree(SurfaceStress *s)
{
  PetscFunctionBegin;
  if (!s) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MatDestroy(&s->term));
  PetscCall(MatDestroy(&s->all));
  PetscCall(VecDestroy(&s->boundary));
  s->assemblies = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates Z, without entries in the rows of other particles [Pa s/m]. */
static PetscErrorCode StressCreate(const Flow *flow, Mat *Z)
{
  const Scene     *scene = flow->scene;
  const Particles *p     = flow->particles;
  PetscInt        *inner, first, n_inner = 0;

  PetscFunctionBegin;
  PetscCall(AffineBlock(p, &flow->ops->rows,
                        &(AffineLayout){1, p->dim, scene->rho * scene->nu, NULL, NULL},
                        flow->ops->div, Z));
  PetscCall(MatGetOwnershipRange(*Z, &first, NULL));
  PetscCall(PetscMalloc1(p->n_fluid, &inner));
  for (PetscInt i = 0; i < p->n_fluid; i++)
    if (!FreeSurfaceHolds(flow->ops->free, i)) inner[n_inner++] = first + i;
  PetscCall(MatZeroRows(*Z, n_inner, inner, 0.0, NULL, NULL));
  PetscCall(PetscFree(inner));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SurfaceStressAssemble - Creates the matrices for the present operators; collective */
PetscErrorCode SurfaceStressAssemble(const Viscosity *v)
{
  const Flow      *flow = v->flow;
  const Operators *ops  = flow->ops;
  const Particles *p    = flow->particles;
  SurfaceStress   *s    = v->surface;
  Mat              G, Z;

  PetscFunctionBegin;
  if (!s || s->assemblies == ops->assemblies) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SurfaceStressFree(s));
  s->assemblies = ops->assemblies;
  PetscCall(AffineBlock(p, &ops->rows,
                        &(AffineLayout){v->dim, 1, -1.0 / flow->scene->rho, NULL, NULL},
                        ops->grad_p, &G));
  PetscCall(StressCreate(flow, &Z));
  PetscCall(MatMatMult(G, Z, MAT_INITIAL_MATRIX, PETSC_DEFAULT, &s->term));
  PetscCall(MatDuplicate(ops->velocity[0].visc.A, MAT_COPY_VALUES, &s->all));
  PetscCall(MatScale(s->all, flow->scene->nu));
  PetscCall(SparseAdd(s->term, &s->all));
  PetscCall(MatDestroy(&Z));
  PetscCall(MatDestroy(&G));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes Z u of wall velocities, for a fluid at rest [Pa]. */
static PetscErrorCode StressOfWalls(Flow *flow, Vec stress)
{
  Vec          zero[ISPH_MAX_DIM] = {NULL}, rest;
  PetscScalar *value;

  PetscFunctionBegin;
  PetscCall(FlowGetWork(flow, &rest));
  PetscCall(VecZeroEntries(rest));
  for (PetscInt a = 0; a < flow->scene->dim; a++) zero[a] = rest;
  PetscCall(FlowMassRows(flow, zero, stress));
  PetscCall(FlowRestoreWork(flow, &rest));
  PetscCall(VecGetArray(stress, &value));
  for (PetscInt i = 0; i < flow->particles->n_fluid; i++)
    value[i] *= FreeSurfaceHolds(flow->ops->free, i) ? flow->scene->rho * flow->scene->nu : 0.0;
  PetscCall(VecRestoreArray(stress, &value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SurfaceStressBoundary - Computes the wall part of the term for the present wall velocities;
   collective */
PetscErrorCode SurfaceStressBoundary(const Viscosity *v)
{
  Flow          *flow = v->flow;
  SurfaceStress *s    = v->surface;
  Vec            stress, gradient;

  PetscFunctionBegin;
  if (!s) PetscFunctionReturn(PETSC_SUCCESS);
  if (!s->boundary) PetscCall(VelocityVec(flow->particles, &s->boundary));
  PetscCall(FlowGetWork(flow, &stress));
  PetscCall(FlowGetWork(flow, &gradient));
  PetscCall(StressOfWalls(flow, stress));
  for (PetscInt a = 0; a < v->dim; a++) {
    PetscCall(AffineApply(&flow->ops->grad_p[a], stress, NULL, gradient));
    PetscCall(VecScale(gradient, -1.0 / flow->scene->rho));
    PetscCall(VecStrideScatter(gradient, a, s->boundary, INSERT_VALUES));
  }
  PetscCall(FlowRestoreWork(flow, &gradient));
  PetscCall(FlowRestoreWork(flow, &stress));
  PetscFunctionReturn(PETSC_SUCCESS);
}
