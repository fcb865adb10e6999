/*
  The pressure of free surfaces in the viscous step. The surface has p = 2 mu n.E n, a viscous stress
  of the velocity, and its gradient is a force that opposes motion along n. With the operator Z u of
  this pressure and the gradient G the viscous term of a projection is

    nu (A u + B u_wall) - G Z u/rho

  A alone has a positive eigenvalue for each particle of the surface, and nu A - G Z/rho has none:
  docs/theory.md, (157). With Z of the last velocity the same force is explicit. The sum of absolute
  weights of Z is up to 36/R, and steps of 0.1 dx^2/nu amplified disturbances of single particles:
  docs/theory.md, (330).
*/
#include "../step.h"
#include "viscosity.h"
#include "isph/sparse.h"

/*
  ViscosityHoldSurface - Makes the pressure of free surfaces a part of the viscous term, if it depends
  on the velocity

  Not collective. To be called before the first step, by schemes whose other forces leave this
  pressure out. Where the viscosity varies, and with pair forces everywhere, surfaces have no such
  pressure.
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

/* Creates a vector with mu at particles on free surfaces and 0 at others. */
static PetscErrorCode SurfaceViscosity(const Flow *flow, Vec *mu)
{
  const Scene     *scene = flow->scene;
  const Particles *p     = flow->particles;
  PetscScalar     *value;

  PetscFunctionBegin;
  PetscCall(FluidVec(p, NULL, mu));
  PetscCall(VecGetArrayWrite(*mu, &value));
  for (PetscInt i = 0; i < p->n_fluid; i++)
    value[i] = FreeSurfaceHolds(flow->ops->free, i) ? scene->rho * scene->nu : 0.0;
  PetscCall(VecRestoreArrayWrite(*mu, &value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SurfaceStressAssemble - Creates the matrices for the present operators; collective */
PetscErrorCode SurfaceStressAssemble(const Viscosity *v)
{
  const Flow      *flow = v->flow;
  const Operators *ops  = flow->ops;
  const Particles *p    = flow->particles;
  SurfaceStress   *s    = v->surface;
  Vec              mu;
  Mat              G, Z;

  PetscFunctionBegin;
  if (!s || s->assemblies == ops->assemblies) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SurfaceStressFree(s));
  s->assemblies = ops->assemblies;
  PetscCall(SurfaceViscosity(flow, &mu));
  PetscCall(AffineBlock(p, &ops->rows,
                        &(AffineLayout){v->dim, 1, -1.0 / flow->scene->rho, NULL, NULL},
                        ops->grad_p, &G));
  PetscCall(AffineBlock(p, &ops->rows, &(AffineLayout){1, v->dim, 1.0, mu, NULL}, ops->div, &Z));
  PetscCall(MatMatMult(G, Z, MAT_INITIAL_MATRIX, PETSC_DEFAULT, &s->term));
  PetscCall(MatDuplicate(ops->velocity[0].visc.A, MAT_COPY_VALUES, &s->all));
  PetscCall(MatScale(s->all, flow->scene->nu));
  PetscCall(SparseAdd(s->term, &s->all));
  PetscCall(MatDestroy(&Z));
  PetscCall(MatDestroy(&G));
  PetscCall(VecDestroy(&mu));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SurfaceStressBoundary - Computes the wall part of the term for the present wall velocities;
   collective */
PetscErrorCode SurfaceStressBoundary(const Viscosity *v)
{
  Flow          *flow               = v->flow;
  SurfaceStress *s                  = v->surface;
  Vec            zero[ISPH_MAX_DIM] = {NULL}, mu, stress, gradient;

  PetscFunctionBegin;
  if (!s || !flow->walls.u[0]) PetscFunctionReturn(PETSC_SUCCESS);
  if (!s->boundary) PetscCall(VelocityVec(flow->particles, &s->boundary));
  PetscCall(FlowGetWork(flow, &zero[0]));
  PetscCall(FlowGetWork(flow, &stress));
  PetscCall(FlowGetWork(flow, &gradient));
  PetscCall(VecZeroEntries(zero[0]));
  for (PetscInt a = 1; a < v->dim; a++) zero[a] = zero[0];
  PetscCall(FlowMassRows(flow, zero, stress));
  PetscCall(SurfaceViscosity(flow, &mu));
  PetscCall(VecPointwiseMult(stress, stress, mu));
  for (PetscInt a = 0; a < v->dim; a++) {
    PetscCall(AffineApply(&flow->ops->grad_p[a], stress, NULL, gradient));
    PetscCall(VecScale(gradient, -1.0 / flow->scene->rho));
    PetscCall(VecStrideScatter(gradient, a, s->boundary, INSERT_VALUES));
  }
  PetscCall(VecDestroy(&mu));
  PetscCall(FlowRestoreWork(flow, &gradient));
  PetscCall(FlowRestoreWork(flow, &stress));
  PetscCall(FlowRestoreWork(flow, &zero[0]));
  PetscFunctionReturn(PETSC_SUCCESS);
}
