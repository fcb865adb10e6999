/*
  The Schur complement of the pressure, S = C - D F^-1 G with the blocks of saddle.h, and the
  approximations of its inverse in the preconditioner. If F commutes with gradients, and C is
  neglected,

    S = sigma (-lap) (shift - nu lap)^-1,   S^-1 = nu/sigma + shift/sigma (-lap)^-1

  with the factor shift of u in du/dt, sigma = dx^2/T, and the time T of the scaling:
  theory.md, (coupled:schur), for particles of several sizes (coupled:cahouet).
*/
#include "coupled.h"

/* Applies the viscous part of S^-1 on splines to z, y = N^1/2 M^-1 N^1/2 z with the mass matrix M
   and the viscosities N over nu. */
static PetscErrorCode SplineMassApply(Schur *s, Vec z, Vec y)
{
  PetscFunctionBegin;
  PetscCall(VecPointwiseMult(s->work, z, s->root));
  PetscCall(PCApply(s->products, s->work, y));
  PetscCall(VecPointwiseMult(y, y, s->root));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Applies y = x, the limit of S^-1 (top of this file) for long steps: nu/sigma = 1, shift = 0; on
   splines the inverse of the mass matrix. Reference: H. C. Elman, D. J. Silvester, A. J. Wathen,
   Finite Elements and Fast Iterative Solvers (2014). */
static PetscErrorCode ApplyMass(Schur *s, Vec x, Vec y)
{
  PetscFunctionBegin;
  if (!s->splines) {
    PetscCall(VecCopy(x, y));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SplineMassApply(s, x, y));
  PetscCall(VecScale(y, s->viscous));
  PetscCall(VecPointwiseDivide(y, y, s->saddle->pressure));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Removes the mean over the splines if the constant of the pressure is undetermined. */
static PetscErrorCode RemoveMean(const Schur *s, Vec v)
{
  PetscScalar sum;
  PetscInt    n;

  PetscFunctionBegin;
  if (!ScenePressureFloats(s->scene)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecSum(v, &sum));
  PetscCall(VecGetSize(v, &n));
  PetscCall(VecShift(v, -sum / n));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Applies S^-1 on splines, with the stiffness K = -scale^2 lap:

     y_q = 1/U_q (viscous N^1/2 M^-1 N^1/2 x + inert (scale/dx)^2 K^-1 x)_q

   U is the unit of the pressure of a spline. */
static PetscErrorCode SplineSchurApply(Schur *s, Vec x, Vec y)
{
  const PetscReal ratio = s->splines->scale / s->scene->dx;

  PetscFunctionBegin;
  PetscCall(SplineMassApply(s, x, s->part));
  PetscCall(VecCopy(x, s->flux));
  PetscCall(RemoveMean(s, s->flux));
  PetscCall(KSPSolve(s->ksp, s->flux, y));
  PetscCall(KspViewsShow(s->ksp, &s->views));
  PetscCall(RemoveMean(s, y));
  PetscCall(VecAXPBY(y, s->viscous, s->inert * PetscSqr(ratio), s->part));
  PetscCall(VecPointwiseDivide(y, y, s->saddle->pressure));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Applies S^-1 for any step:

    y_i = T_i/dx_i (nu_i x_i/dx_i + shift (A^-1 z)_i),   z_j = dx_j x_j

  Unless a boundary gives the pressure, the matrix A is -dx_i^2 lap + 1e-6, because the Poisson
  equation alone is singular. The mean of z and the mean of the solution are then removed. The left
  null vector is not constant; without the second removal, the part of z along it would return as a
  constant 1e6 times as large.

  Reference: J. Cahouet, J.-P. Chabard, Int. J. Numer. Meth. Fluids 8 (1988) 869-895
*/
static PetscErrorCode ApplyCahouetChabard(Schur *s, Vec x, Vec y)
{
  PetscFunctionBegin;
  if (s->splines) {
    PetscCall(SplineSchurApply(s, x, y));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(VecPointwiseMult(s->work, x, s->saddle->length));
  PetscCall(GaugeRemove(s->scene, s->particles, s->work));
  PetscCall(KSPSolve(s->ksp, s->work, y));
  PetscCall(KspViewsShow(s->ksp, &s->views));
  PetscCall(GaugeRemove(s->scene, s->particles, y));
  PetscCall(VecScale(y, s->inert));
  PetscCall(VecPointwiseDivide(s->work, x, s->saddle->length));
  PetscCall(VecPointwiseMult(s->work, s->work, s->saddle->viscosity));
  PetscCall(VecAXPY(y, s->viscous, s->work));
  PetscCall(VecPointwiseDivide(y, y, s->saddle->pressure));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Schur_Apply(PC pc, Vec x, Vec y)
{
  Schur *s;

  PetscFunctionBegin;
  PetscCall(PCShellGetContext(pc, &s));
  PetscCall(s->inert == 0.0 ? ApplyMass(s, x, y) : ApplyCahouetChabard(s, x, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SchurAttach - Sets the approximation of the Schur complement as the shell of the pressure;
   collective */
PetscErrorCode SchurAttach(PC fieldsplit, Schur *s)
{
  PetscFunctionBegin;
  PetscCall(SolverAttachShell(fieldsplit, 1, "cahouet_chabard", s, Schur_Apply));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the defaults of a pressure that a layer at the surface has a part in: its entries in K are
   large and of both signs, so incomplete factors follow the cycle of AMG. Pivots that are zero, as
   of splines at particles that flew off, are shifted: one of them ends the whole solve. */
static PetscErrorCode LayerDefaults(void)
{
  PetscFunctionBegin;
  PetscCall(OptionDefault("coupled_schur_", "-pc_type", PCCOMPOSITE));
  PetscCall(OptionDefault("coupled_schur_", "-pc_composite_type", "multiplicative"));
  PetscCall(OptionDefault("coupled_schur_", "-pc_composite_pcs", "hypre,bjacobi"));
  PetscCall(AmgDefaults("coupled_schur_sub_0_", "1"));
  PetscCall(OptionDefault("coupled_schur_sub_1_", "-sub_pc_factor_shift_type", "nonzero"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SchurCreate - Creates the KSP of the Poisson equation, by default a single cycle of AMG;
   collective. Input: layer - the pressure has a layer at the surface. */
PetscErrorCode SchurCreate(PetscBool layer, Schur *s)
{
  PC pc;

  PetscFunctionBegin;
  if (layer) PetscCall(LayerDefaults());
  PetscCall(KSPCreate(PETSC_COMM_WORLD, &s->ksp));
  PetscCall(KSPSetOptionsPrefix(s->ksp, "coupled_schur_"));
  PetscCall(KSPSetType(s->ksp, KSPPREONLY));
  PetscCall(KSPGetPC(s->ksp, &pc));
  PetscCall(PCSetType(pc, PCHYPRE));
  PetscCall(AmgDefaults("coupled_schur_", "1"));
  PetscCall(KspViewsTake("coupled_schur_", &s->views));
  PetscCall(KSPSetFromOptions(s->ksp));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the preconditioners of K and M, which last as long as these matrices, and work vectors. */
static PetscErrorCode AssembleOnSplines(Schur *s)
{
  Splines *sp = s->splines;

  PetscFunctionBegin;
  PetscCall(VecDestroy(&s->root));
  PetscCall(VecDuplicate(s->saddle->viscosity, &s->root));
  PetscCall(VecCopy(s->saddle->viscosity, s->root));
  PetscCall(VecSqrtAbs(s->root));
  if (s->products && s->stamp == sp->products) PetscFunctionReturn(PETSC_SUCCESS);
  s->stamp = sp->products;
  PetscCall(VecDestroyAll(&s->flux, &s->part));
  PetscCall(VecDuplicate(s->root, &s->flux));
  PetscCall(VecDuplicate(s->root, &s->part));
  PetscCall(PCDestroy(&s->products));
  PetscCall(PCCreate(PetscObjectComm((PetscObject)sp->M), &s->products));
  PetscCall(PCSetType(s->products, PCBJACOBI));
  PetscCall(PCSetOperators(s->products, sp->M, sp->M));
  PetscCall(PCSetUp(s->products));
  PetscCall(MatDestroy(&s->poisson));
  PetscCall(MatDuplicate(sp->K, MAT_COPY_VALUES, &s->poisson));
  PetscCall(GaugePreconditioner(s->scene, GAUGE_SHIFT, s->poisson));
  PetscCall(KSPReset(s->ksp));
  PetscCall(KSPSetOperators(s->ksp, s->poisson, s->poisson));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets up the solver of the Poisson equation of particles, by the pair-wise Laplacian. */
static PetscErrorCode SetUpPoisson(const Flow *flow, Schur *s)
{
  PetscFunctionBegin;
  PetscCall(MatDestroy(&s->poisson));
  PetscCall(PairPoisson(flow, &s->poisson));
  PetscCall(GaugePreconditioner(s->scene, GAUGE_SHIFT, s->poisson));
  PetscCall(KSPReset(s->ksp));
  PetscCall(KSPSetOperators(s->ksp, s->poisson, s->poisson));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SchurAssemble - Creates the matrices of the approximation for new operators. Collective. Input:
   anew - the solver of the Poisson equation is set up anew. Notes: PETSc gets the identity, the
   limit of long steps, so that preconditioners other than shell
   (-coupled_fieldsplit_pressure_pc_type jacobi) have a matrix. */
PetscErrorCode SchurAssemble(const Flow *flow, const Saddle *saddle, PetscBool anew, Schur *s)
{
  PetscFunctionBegin;
  PetscCall(MatDestroy(&s->mass));
  PetscCall(VecDestroy(&s->work));
  PetscCall(VecDuplicate(saddle->pressure, &s->work));
  s->scene     = flow->scene;
  s->splines   = flow->scheme->splines;
  s->particles = flow->particles;
  s->saddle    = saddle;
  PetscCall(MatCreateConstantDiagonal(flow->particles->comm, saddle->n_p, saddle->n_p,
                                      PETSC_DETERMINE, PETSC_DETERMINE, 1.0, &s->mass));
  if (s->splines) PetscCall(AssembleOnSplines(s));
  else if (anew) PetscCall(SetUpPoisson(flow, s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SchurFree - Frees the approximation of S^-1; collective */
PetscErrorCode SchurFree(Schur *s)
{
  PetscFunctionBegin;
  PetscCall(MatDestroyAll(&s->mass, &s->poisson));
  PetscCall(VecDestroyAll(&s->work, &s->flux, &s->part, &s->root));
  PetscCall(PCDestroy(&s->products));
  PetscCall(KSPDestroy(&s->ksp));
  PetscCall(KspViewsEnd(&s->views));
  PetscFunctionReturn(PETSC_SUCCESS);
}
