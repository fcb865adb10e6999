/* Terms of the viscous equation as callbacks of the TS of a velocity component. */
#include "viscosity.h"

/* Returns the viscous operator of component c. */
static const AffineOperator *Viscous(const Viscosity *v, PetscInt c)
{
  return &OperatorsOfVelocity(v->flow->ops, c)->visc;
}

/* Computes the wall term B u_wall of coupled components, which are a single system. */
static PetscErrorCode ApplyBoundary(Viscosity *v)
{
  PetscFunctionBegin;
  if (v->systems > 1) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt c = 0; c < v->dim; c++)
    PetscCall(VecStrideScatter(v->flow->walls.u[c], c, v->all_walls, INSERT_VALUES));
  PetscCall(MatMult(Viscous(v, 0)->B, v->all_walls, v->boundary));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Updates the wall velocities and terms to time t if they are not set, or if the wall velocity
   depends on t. */
static PetscErrorCode UpdateBoundary(Viscosity *v, PetscReal t)
{
  PetscFunctionBegin;
  if (!v->flow->walls.u[0] || v->wall_t == t) PetscFunctionReturn(PETSC_SUCCESS);
  if (!v->flow->scene->unsteady_walls && !PetscIsNanReal(v->wall_t))
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(WallValuesSetVelocity(v->flow->scene, v->flow->particles, t, v->projection_factor,
                                  &v->flow->walls));
  PetscCall(ApplyBoundary(v));
  v->wall_t = t;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Updates the wall terms to time t. For rheologies, also computes the viscosities and the viscous
   operator from the velocity u. */
static PetscErrorCode FollowStrain(Viscosity *v, PetscReal t, Vec u)
{
  PetscFunctionBegin;
  PetscCall(UpdateBoundary(v, t));
  if (!v->nonlinear) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt c = 0; c < v->dim; c++) PetscCall(VecStrideGather(u, c, v->part[c], INSERT_VALUES));
  PetscCall(OperatorsFollowStrain(v->flow->scene, v->flow->particles, &v->flow->walls, v->part,
                                  v->flow->ops));
  if (Viscous(v, 0)->B) PetscCall(ApplyBoundary(v));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the viscous term f = nu (A u + B u_wall) at time t, of component c or of all components
   in a single system. */
static PetscErrorCode ViscousTerm(Viscosity *v, PetscInt c, PetscReal t, Vec u, Vec f)
{
  PetscFunctionBegin;
  PetscCall(FollowStrain(v, t, u));
  if (v->systems > 1) {
    PetscCall(AffineApply(Viscous(v, c), u, v->flow->walls.u[c], f));
  } else {
    PetscCall(MatMult(Viscous(v, 0)->A, u, f));
    if (Viscous(v, 0)->B) PetscCall(VecAXPY(f, 1.0, v->boundary));
  }
  PetscCall(VecScale(f, v->flow->scene->nu));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds `scale` times the convective term of velocity component c, whose values are u, to f. */
static PetscErrorCode AddConvection(Viscosity *v, PetscInt c, PetscReal scale, Vec u, Vec f)
{
  Vec work, term;

  PetscFunctionBegin;
  if (!v->advecting) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FlowGetWork(v->flow, &work));
  PetscCall(FlowGetWork(v->flow, &term));
  PetscCall(ConvectionApply(v->flow, v->advecting, c, u, v->flow->walls.u[c], work, term));
  PetscCall(VecAXPY(f, scale, term));
  PetscCall(FlowRestoreWork(v->flow, &term));
  PetscCall(FlowRestoreWork(v->flow, &work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes f = force - convective term of u, of component c or of all components in a single
   system. */
static PetscErrorCode ConvectiveTerm(Viscosity *v, PetscInt c, Vec u, Vec f)
{
  PetscFunctionBegin;
  if (v->systems > 1) {
    PetscCall(VecCopy(v->force[c], f));
    PetscCall(AddConvection(v, c, -1.0, u, f));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (PetscInt k = 0; k < v->dim; k++) {
    PetscCall(VecStrideGather(u, k, v->part[0], INSERT_VALUES));
    PetscCall(VecCopy(v->force[k], v->part[1]));
    PetscCall(AddConvection(v, k, -1.0, v->part[0], v->part[1]));
    PetscCall(VecStrideScatter(v->part[1], k, f, INSERT_VALUES));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ViscosityLinearise - Linearises the stress of a rheology about a velocity; see TangentFollow();
   collective */
PetscErrorCode ViscosityLinearise(Viscosity *v, Vec u)
{
  PetscFunctionBegin;
  for (PetscInt c = 0; c < v->dim; c++) PetscCall(VecStrideGather(u, c, v->part[c], INSERT_VALUES));
  PetscCall(TangentFollow(v->tangent, v->part, &v->flow->walls));
  if (Viscous(v, 0)->B) PetscCall(ApplyBoundary(v));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes y = (shift I - nu A) x less the term of the changes of the viscosity by x. */
static PetscErrorCode Newton_Mult(Mat newton, Vec x, Vec y)
{
  Viscosity *v;
  Vec        term[ISPH_MAX_DIM];

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(newton, &v));
  PetscCall(MatMult(v->J, x, y));
  for (PetscInt c = 0; c < v->dim; c++) {
    PetscCall(VecStrideGather(x, c, v->part[c], INSERT_VALUES));
    PetscCall(FlowGetWork(v->flow, &term[c]));
    PetscCall(VecZeroEntries(term[c]));
  }
  PetscCall(TangentApplyAdd(v->tangent, -1.0, v->part, term));
  for (PetscInt c = 0; c < v->dim; c++) {
    PetscCall(VecStrideScatter(term[c], c, y, ADD_VALUES));
    PetscCall(FlowRestoreWork(v->flow, &term[c]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ViscosityCreateNewton - Creates the Jacobian of a rheology, which J preconditions; collective */
PetscErrorCode ViscosityCreateNewton(Viscosity *v)
{
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(MatGetLocalSize(v->J, &n, NULL));
  PetscCall(MatCreateShell(PetscObjectComm((PetscObject)v->J), n, n, PETSC_DETERMINE,
                           PETSC_DETERMINE, v, &v->newton));
  PetscCall(MatShellSetOperation(v->newton, MATOP_MULT, (void (*)(void))Newton_Mult));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ViscosityIFunction - Computes the residual du/dt - nu lap u; for integrators without RHSFunction,
   also subtracts the force and adds implicit convection; collective */
PetscErrorCode ViscosityIFunction(TS ts, PetscReal t, Vec u, Vec udot, Vec f, void *ctx)
{
  Component *part = (Component *)ctx;
  Viscosity *v    = part->visc;

  PetscFunctionBegin;
  PetscCall(ViscousTerm(v, part->c, t, u, f));
  PetscCall(VecAYPX(f, -1.0, udot));
  if (v->row->terms != TIME_IMPLICIT) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecAXPY(f, -1.0, v->systems == 1 ? v->all_force : v->force[part->c]));
  PetscCall(AddConvection(v, part->c, 1.0, u, f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ViscosityIJacobian - Computes P = shift I - nu A, and adds implicit convection, if the shift, the
   viscosities or the advecting velocity may be new. Collective. J is P, or a product without
   entries. The viscosities of a rheology are those of u already, see ViscosityLinearise(). */
PetscErrorCode ViscosityIJacobian(TS ts, PetscReal t, Vec u, Vec udot, PetscReal shift, Mat J,
                                  Mat P, void *ctx)
{
  Component            *part = (Component *)ctx;
  Viscosity            *v    = part->visc;
  const AffineOperator *visc = Viscous(v, part->c);
  Vec                   work;

  PetscFunctionBegin;
  if (J != P) {
    PetscCall(MatAssemblyBegin(J, MAT_FINAL_ASSEMBLY));
    PetscCall(MatAssemblyEnd(J, MAT_FINAL_ASSEMBLY));
  }
  if (!v->nonlinear && shift == v->shift && visc == v->operator_of_J)
    PetscFunctionReturn(PETSC_SUCCESS); /* keeps the preconditioner */
  PetscCall(AffineSystemSet(visc, shift, -v->flow->scene->nu, P));
  if (v->convection) {
    PetscCall(FlowGetWork(v->flow, &work));
    PetscCall(ConvectionAddMatrix(v->flow, v->advecting, part->c, v->convection, work, P));
    PetscCall(FlowRestoreWork(v->flow, &work));
  }
  v->shift         = shift;
  v->operator_of_J = visc;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ViscosityRHSFunction - Computes the force minus the convective term, plus the viscous term for
   explicit integrators; collective */
PetscErrorCode ViscosityRHSFunction(TS ts, PetscReal t, Vec u, Vec f, void *ctx)
{
  Component *part = (Component *)ctx;
  Viscosity *v    = part->visc;
  Vec        convective;

  PetscFunctionBegin;
  if (v->row->terms == TIME_IMEX) {
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
