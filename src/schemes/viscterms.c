/* The terms of the viscous equation as the TS callbacks of one velocity component. */
#include "viscosity.h"

/* Wall terms at time t; they are computed anew only where walls change their velocity. */
static PetscErrorCode UpdateBoundary(Viscosity *v, PetscReal t)
{
  PetscFunctionBegin;
  if (!v->ops->visc.B || v->wall_t == t) PetscFunctionReturn(PETSC_SUCCESS);
  if (!v->scene->unsteady_walls && !PetscIsNanReal(v->wall_t)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(OperatorsSetWallVelocity(v->scene, v->particles, t, v->slip, v->ops));
  for (PetscInt c = 0; c < v->dim; c++)
    PetscCall(MatMult(v->ops->visc.B, v->ops->wall_u[c], v->boundary[c]));
  v->wall_t = t;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* f = nu (A u + B u_wall). */
static PetscErrorCode ViscousTerm(Viscosity *v, PetscInt c, PetscReal t, Vec u, Vec f)
{
  PetscFunctionBegin;
  PetscCall(UpdateBoundary(v, t));
  PetscCall(MatMult(v->ops->visc.A, u, f));
  if (v->ops->visc.B) PetscCall(VecAXPY(f, 1.0, v->boundary[c]));
  PetscCall(VecScale(f, v->scene->nu));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* f = force - (v.grad) u. */
static PetscErrorCode ConvectiveTerm(Viscosity *v, PetscInt c, Vec u, Vec f)
{
  PetscFunctionBegin;
  if (!v->advecting) {
    PetscCall(VecCopy(v->force[c], f));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(ConvectionApply(v->scene, v->ops, v->advecting, u, v->ops->wall_u[c], v->gradient, f));
  PetscCall(VecAYPX(f, -1.0, v->force[c]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ViscosityIFunction - du/dt - nu lap u [- force, where the time kind has it here]; collective */
PetscErrorCode ViscosityIFunction(TS ts, PetscReal t, Vec u, Vec udot, Vec f, void *ctx)
{
  Component *part = (Component *)ctx;
  Viscosity *v    = part->visc;

  PetscFunctionBegin;
  PetscCall(ViscousTerm(v, part->c, t, u, f));
  PetscCall(VecAYPX(f, -1.0, udot));
  if (v->row->kind == TIME_IMPLICIT) PetscCall(VecAXPY(f, -1.0, v->force[part->c]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ViscosityIJacobian - shift I - nu A, made where the shift is new; collective */
PetscErrorCode ViscosityIJacobian(TS ts, PetscReal t, Vec u, Vec udot, PetscReal shift, Mat J,
                                  Mat P, void *ctx)
{
  Viscosity *v = ((Component *)ctx)->visc;

  PetscFunctionBegin;
  if (shift == v->shift) PetscFunctionReturn(PETSC_SUCCESS); /* and the preconditioner stays too */
  PetscCall(MatCopy(v->ops->visc.A, P, SAME_NONZERO_PATTERN));
  PetscCall(MatScale(P, -v->scene->nu));
  PetscCall(MatShift(P, shift));
  v->shift = shift;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ViscosityRHSFunction - Convection and force, and viscosity where all is explicit; collective */
PetscErrorCode ViscosityRHSFunction(TS ts, PetscReal t, Vec u, Vec f, void *ctx)
{
  Component *part = (Component *)ctx;
  Viscosity *v    = part->visc;
  Vec        convective;

  PetscFunctionBegin;
  if (v->row->kind == TIME_IMEX) {
    PetscCall(UpdateBoundary(v, t));
    PetscCall(ConvectiveTerm(v, part->c, u, f));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(VecDuplicate(f, &convective));
  PetscCall(ViscousTerm(v, part->c, t, u, f));
  PetscCall(ConvectiveTerm(v, part->c, u, convective));
  PetscCall(VecAXPY(f, 1.0, convective));
  PetscCall(VecDestroy(&convective));
  PetscFunctionReturn(PETSC_SUCCESS);
}
