/*
  The pressure of free surfaces in the viscous step. The surface has p = 2 mu n.E n, a viscous
  stress of the velocity, and its gradient is a force that opposes motion along n. With the operator
  Z u of this pressure and the gradient G the viscous term of a projection is

    nu (A u + B u_wall) - G Z u/rho

  A alone has a positive eigenvalue for each particle of the surface, and nu A - G Z/rho has none:
  theory.md, (surface:schur). With Z of the last velocity the same force is explicit. The sum of
  absolute weights of Z is up to 36/R, and steps of 0.1 dx^2/nu amplified disturbances of single
  particles: theory.md, (surface:gain).

  The product G Z has twice the entries of A: solvers that only multiply never form it. In the short
  steps of a projection they need no preconditioner: the diagonal of A alone is a worse one.
*/
#include "viscosity.h"

/* SurfaceStressFree - Frees the matrices; collective */
PetscErrorCode SurfaceStressFree(SurfaceStress *s)
{
  PetscFunctionBegin;
  if (!s) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MatDestroy(&s->Z));
  PetscCall(MatDestroy(&s->G));
  PetscCall(VecDestroy(&s->boundary));
  s->assemblies = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SurfaceStressAssemble - Creates Z and G for the present operators; collective */
PetscErrorCode SurfaceStressAssemble(const Viscosity *v)
{
  const Operators *ops   = v->flow->ops;
  const Particles *p     = v->flow->particles;
  const Scene     *scene = v->flow->scene;
  SurfaceStress   *s     = v->surface;
  const PetscReal *holds; /* the kind of particles on the surface, 0 of others */

  PetscFunctionBegin;
  if (!s || s->assemblies == ops->assemblies) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SurfaceStressFree(s));
  s->assemblies = ops->assemblies;
  holds         = ops->free->kind;
  PetscCall(AffineBlock(p, &ops->rows,
                        &(AffineLayout){1, v->dim, scene->rho * scene->nu, NULL, NULL, holds},
                        ops->div, &s->Z));
  PetscCall(AffineBlock(p, &ops->rows,
                        &(AffineLayout){v->dim, 1, -1.0 / scene->rho, NULL, NULL, holds},
                        ops->grad_p, &s->G));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SurfaceStressAdd - Adds the term of a velocity, scale times -G Z u/rho, to f; collective */
PetscErrorCode SurfaceStressAdd(const Viscosity *v, PetscReal scale, Vec u, Vec f)
{
  Vec pressure;

  PetscFunctionBegin;
  PetscCall(FlowGetWork(v->flow, &pressure));
  PetscCall(MatMult(v->surface->Z, u, pressure));
  PetscCall(VecScale(pressure, scale));
  PetscCall(MatMultAdd(v->surface->G, pressure, f, f));
  PetscCall(FlowRestoreWork(v->flow, &pressure));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the viscous operator of all components. */
static Mat Viscous(const Viscosity *v)
{
  return v->flow->ops->velocity[0].visc.A;
}

/* Computes y = shift u - (nu A - G Z/rho) u. */
static PetscErrorCode ShellMult(Mat J, Vec u, Vec y)
{
  Viscosity *v;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(J, &v));
  PetscCall(MatMult(Viscous(v), u, y));
  PetscCall(VecAXPBY(y, v->shift, -v->flow->scene->nu, u));
  PetscCall(SurfaceStressAdd(v, -1.0, u, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the matrix shift I - (nu A - G Z/rho), whose product G Z has many entries. */
static PetscErrorCode Form(const Viscosity *v, PetscReal shift, Mat *J)
{
  Mat term;

  PetscFunctionBegin;
  PetscCall(MatDuplicate(Viscous(v), MAT_COPY_VALUES, J));
  PetscCall(MatScale(*J, -v->flow->scene->nu));
  PetscCall(MatShift(*J, shift));
  PetscCall(MatMatMult(v->surface->G, v->surface->Z, MAT_INITIAL_MATRIX, PETSC_DEFAULT, &term));
  PetscCall(MatScale(term, -1.0));
  PetscCall(SparseAdd(term, J));
  PetscCall(MatDestroy(&term));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SurfaceStressFlatten - Creates a matrix with the entries of a shell; collective */
PetscErrorCode SurfaceStressFlatten(Mat J, Mat *flat)
{
  Viscosity *v;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(J, &v));
  PetscCall(Form(v, v->shift, flat));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SurfaceStressJacobian - Creates a matrix for SurfaceStressSet(): a shell, or the sum of all
   entries; collective */
PetscErrorCode SurfaceStressJacobian(Viscosity *v, Mat *J)
{
  const PetscInt n = v->dim * v->flow->particles->n_fluid;

  PetscFunctionBegin;
  if (!v->shell) {
    PetscCall(Form(v, 1.0, J));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MatCreateShell(v->flow->particles->comm, n, n, PETSC_DETERMINE, PETSC_DETERMINE, v, J));
  PetscCall(MatShellSetOperation(*J, MATOP_MULT, (void (*)(void))ShellMult));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SurfaceStressSet - Computes J = shift I - (nu A - G Z/rho); a shell reads v->shift; collective */
PetscErrorCode SurfaceStressSet(const Viscosity *v, PetscReal shift, Mat J)
{
  Mat sum;

  PetscFunctionBegin;
  if (v->shell) {
    PetscCall(MatAssemblyBegin(J, MAT_FINAL_ASSEMBLY)); /* tells solvers that J has changed */
    PetscCall(MatAssemblyEnd(J, MAT_FINAL_ASSEMBLY));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(Form(v, shift, &sum));
  PetscCall(MatCopy(sum, J, SAME_NONZERO_PATTERN));
  PetscCall(MatDestroy(&sum));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SurfaceStressBoundary - Computes the wall part of the term for the present wall velocities, the
   term of a fluid at rest; collective */
PetscErrorCode SurfaceStressBoundary(const Viscosity *v)
{
  const Scene   *scene              = v->flow->scene;
  SurfaceStress *s                  = v->surface;
  Vec            zero[ISPH_MAX_DIM] = {NULL}, rest, stress;

  PetscFunctionBegin;
  if (!s) PetscFunctionReturn(PETSC_SUCCESS);
  if (!s->boundary) PetscCall(VelocityVec(v->flow->particles, &s->boundary));
  PetscCall(FlowGetWork(v->flow, &rest));
  PetscCall(FlowGetWork(v->flow, &stress));
  PetscCall(VecZeroEntries(rest));
  for (PetscInt a = 0; a < v->dim; a++) zero[a] = rest;
  PetscCall(FlowMassRows(v->flow, zero, stress));
  PetscCall(VecScale(stress, scene->rho * scene->nu));
  PetscCall(MatMult(s->G, stress, s->boundary));
  PetscCall(FlowRestoreWork(v->flow, &stress));
  PetscCall(FlowRestoreWork(v->flow, &rest));
  PetscFunctionReturn(PETSC_SUCCESS);
}
