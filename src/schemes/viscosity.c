/*
  Viscosity by PETSc's TS: one scalar system for each velocity component,

    du_c/dt = nu (A u_c + B u_wall,c) - (v.grad) u_c + force_c,

  the same matrix and the same KSP for all; one system for all components where a form couples them
  or the viscosity follows their strain rate. Where each term enters is the time kind's choice
  (integrators.c); v is the advecting velocity of particles that do not move, given for the whole
  step.
*/
#include "viscosity.h"

/* The clock owns time and the history is on particles: what contradicts that is refused. */
static PetscErrorCode RefuseTimeOptions(const ViscousIntegratorRow *row)
{
  PetscReal theta = 0.5;
  PetscBool given;

  PetscFunctionBegin;
  PetscCall(TimeOptionsRefuse("visc_", row->name));
  PetscCall(OptionGiven("-visc_ts_adapt_type", &given));
  UserCheck(!given || !row->multistep,
            "-visc_ts_adapt_type: %s shares its steps with the projection; use a one-step type "
            "such as arkimex",
            row->name);
  PetscCall(PetscOptionsGetReal(NULL, NULL, "-visc_ts_theta_theta", &theta, NULL));
  UserCheck(theta > 0.0 && theta <= 1.0, "-visc_ts_theta_theta %.6g: allowed is more than 0 to 1",
            (double)theta);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  The linear solver: a preconditioner as strong as the step is stiff. nu dt/dx^2 below 2 is met by
  Jacobi, up to 200 by block Jacobi with ILU(0), beyond by AMG.
*/
static PetscErrorCode ViscosityCreateSolver(const Scene *scene, PetscReal dt, const Operators *ops,
                                            Viscosity *v)
{
  const PetscReal stiffness = scene->nu_high * dt / PetscSqr(scene->dx);
  PetscBool       symmetric;
  SNES            snes;
  PC              pc;

  PetscFunctionBegin;
  PetscCall(TSGetSNES(v->ts[0], &snes));
  PetscCall(SNESGetKSP(snes, &v->ksp));
  symmetric = LaplacianIs(&ops->visc_form, FORM_SYMMETRIC) && !v->nonlinear;
  PetscCall(KSPSetType(v->ksp, symmetric ? KSPCG : KSPGMRES));
  PetscCall(KSPSetTolerances(v->ksp, v->nonlinear ? 1e-3 : 1e-7, 0.0, PETSC_DEFAULT, 1000));
  PetscCall(KSPGetPC(v->ksp, &pc));
  PetscCall(PCSetType(pc, stiffness < 2.0 ? PCJACOBI : stiffness < 200.0 ? PCBJACOBI : PCHYPRE));
  for (PetscInt c = 0; c < v->systems; c++) {
    PetscCall(TSGetSNES(v->ts[c], &snes));
    if (c) PetscCall(SNESSetKSP(snes, v->ksp));
    PetscCall(SNESSetMaxLinearSolveFailures(snes, PETSC_MAX_INT)); /* the guard sees to those */
  }
  if (v->nonlinear) PetscCall(IterationChoose(snes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  ViscosityCreate - The integrators of the viscous term

  Collective on PETSC_COMM_WORLD.

  Input Parameter:
. dt - first time step, for the choice of a preconditioner [s]

  Options Database Keys:
. -visc_ts_type, -visc_ksp_type, -visc_pc_type, ... - any TS, SNES, KSP or PC option of PETSc's

  Errors: TS types that are no row of ViscousIntegratorTable, and options that would give time to
  the TS
*/
PetscErrorCode ViscosityCreate(const Scene *scene, PetscReal dt, const Operators *ops,
                               Viscosity **visc)
{
  Viscosity *v;

  PetscFunctionBegin;
  PetscCall(PetscNew(&v));
  v->dim          = scene->dim;
  v->systems      = ops->components_coupled ? 1 : scene->dim;
  v->nonlinear    = SceneIsNewtonian(scene) ? PETSC_FALSE : PETSC_TRUE;
  v->scene        = scene;
  v->guard.what   = "viscous";
  v->guard.prefix = "visc_";
  v->guard.inner  = v->nonlinear;
  PetscOptionsBegin(PETSC_COMM_WORLD, NULL, "Viscosity", "");
  PetscCall(TableSelect(&ViscousIntegratorTable, "-visc_ts_type", "Time integrator of viscosity",
                        TSBEULER, &v->row));
  PetscOptionsEnd();
  PetscCall(RefuseTimeOptions(v->row));
  for (PetscInt c = 0; c < v->systems; c++) {
    v->component[c].visc = v;
    v->component[c].c    = c;
    PetscCall(TSCreate(PETSC_COMM_WORLD, &v->ts[c]));
    PetscCall(TSSetOptionsPrefix(v->ts[c], "visc_"));
    PetscCall(TSSetProblemType(v->ts[c], v->nonlinear ? TS_NONLINEAR : TS_LINEAR));
    PetscCall(TSSetType(v->ts[c], v->row->name));
    PetscCall(TSSetExactFinalTime(v->ts[c], TS_EXACTFINALTIME_STEPOVER));
    PetscCall(TSSetMaxSteps(v->ts[c], PETSC_MAX_INT - 1));
    PetscCall(TSSetMaxTime(v->ts[c], PETSC_MAX_REAL));
    PetscCall(TSSetErrorIfStepFails(v->ts[c], PETSC_FALSE));
    if (v->row->kind != TIME_IMPLICIT) {
      PetscCall(TSSetRHSFunction(v->ts[c], NULL, ViscosityRHSFunction, &v->component[c]));
    }
    if (v->row->kind != TIME_EXPLICIT) {
      PetscCall(TSSetIFunction(v->ts[c], NULL, ViscosityIFunction, &v->component[c]));
    }
  }
  if (v->row->kind != TIME_EXPLICIT) PetscCall(ViscosityCreateSolver(scene, dt, ops, v));
  for (PetscInt c = 0; c < v->systems; c++) {
    TSAdapt adapt;

    PetscCall(TSGetAdapt(v->ts[c], &adapt));
    PetscCall(TSAdaptSetType(adapt, TSADAPTNONE));
    PetscCall(TSSetFromOptions(v->ts[c]));
  }
  if (v->ksp) PetscCall(GuardAttach(v->ksp, &ops->visc_form, &v->guard));
  *visc = v;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ViscosityFree(Viscosity *v)
{
  PetscFunctionBegin;
  for (PetscInt c = 0; c < v->systems; c++) PetscCall(VecDestroy(&v->boundary[c]));
  PetscCall(VecDestroy(&v->gradient));
  PetscCall(VecDestroy(&v->work));
  PetscCall(VecDestroy(&v->all));
  PetscCall(VecDestroy(&v->all_force));
  PetscCall(VecDestroy(&v->all_walls));
  for (PetscInt c = 0; c < v->dim; c++) PetscCall(VecDestroy(&v->part[c]));
  PetscCall(MatDestroy(&v->J));
  v->assemblies = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ViscosityDestroy(Viscosity **visc)
{
  PetscFunctionBegin;
  if (!*visc) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ViscosityFree(*visc));
  PetscCall(GuardDetach(&(*visc)->guard));
  for (PetscInt c = 0; c < (*visc)->systems; c++) PetscCall(TSDestroy(&(*visc)->ts[c]));
  PetscCall(PetscFree(*visc));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ViscosityRenumber - Forgets what belongs to an old numbering, TS history included; collective */
PetscErrorCode ViscosityRenumber(const Particles *p, Viscosity *v)
{
  PetscFunctionBegin;
  PetscCall(ViscosityFree(v));
  for (PetscInt c = 0; c < v->systems; c++) {
    PetscCall(TSReset(v->ts[c]));
    if (v->systems > 1) PetscCall(FluidVec(p, NULL, &v->boundary[c]));
  }
  PetscCall(FluidVec(p, NULL, &v->gradient));
  PetscCall(FluidVec(p, NULL, &v->work));
  if (v->systems > 1) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VelocityVec(p, &v->boundary[0]));
  PetscCall(VelocityVec(p, &v->all));
  PetscCall(VelocityVec(p, &v->all_force));
  PetscCall(WallVelocityVec(p, &v->all_walls));
  for (PetscInt c = 0; c < v->dim; c++) PetscCall(FluidVec(p, NULL, &v->part[c]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A Jacobian of the pattern that the operators have now; a preconditioner of the old pattern goes.
 */
static PetscErrorCode ViscosityUpdateJacobian(Viscosity *v)
{
  PetscFunctionBegin;
  if (!v->ksp || v->assemblies == v->ops->assemblies) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(GuardRenewPC(v->ksp));
  PetscCall(MatDestroy(&v->J));
  if (v->nonlinear) {
    SNES snes;

    PetscCall(TSGetSNES(v->ts[0], &snes)); /* -visc_snes_mf_operator is set up for the new one */
    PetscCall(SNESReset(snes));
  }
  PetscCall(MatDuplicate(v->ops->visc.A, MAT_DO_NOT_COPY_VALUES, &v->J));
  for (PetscInt c = 0; c < v->systems; c++) {
    PetscCall(TSSetIJacobian(v->ts[c], v->J, v->J, ViscosityIJacobian, &v->component[c]));
  }
  v->shift      = NAN;
  v->assemblies = v->ops->assemblies;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One system over [t, t + dt], in one TS step unless an adaptor of the user's takes several. */
static PetscErrorCode ViscosityTrySystem(Viscosity *v, PetscInt c, PetscReal t, PetscReal dt, Vec u,
                                         StepFailure *failure)
{
  PetscReal h = dt;

  PetscFunctionBegin;
  PetscCall(TSSetSolution(v->ts[c], u));
  if (!v->row->multistep)
    PetscCall(TSRestartStep(v->ts[c])); /* stages of the last step are of another flow */
  if (v->nonlinear && v->ksp) PetscCall(IterationSetTolerance(v, t, u));
  PetscCall(TimeStepThrough(v->ts[c], v->row->name, v->ksp, &v->guard, t, dt, &h, &v->iterations,
                            failure));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The same, a viscosity that follows the flow by the iteration that gets there. */
static PetscErrorCode ViscosityStepSystem(Viscosity *v, PetscInt c, PetscReal t, PetscReal dt,
                                          Vec u, StepFailure *failure)
{
  Vec       before;
  PetscBool again;

  PetscFunctionBegin;
  if (!v->nonlinear || !v->ksp) {
    PetscCall(ViscosityTrySystem(v, c, t, dt, u, failure));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(VecDuplicate(u, &before));
  PetscCall(VecCopy(u, before));
  PetscCall(ViscosityTrySystem(v, c, t, dt, u, failure));
  PetscCall(IterationFallBack(v, failure, &again));
  if (again) {
    failure->code = PETSC_SUCCESS;
    PetscCall(VecCopy(before, u));
    PetscCall(ViscosityTrySystem(v, c, t, dt, u, failure));
    PetscCall(IterationGoBack(v));
  }
  PetscCall(VecDestroy(&before));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  ViscositySolve - Advances all velocity components over [t_new - dt, t_new], t_new = clock's t + dt

    du/dt = nu lap u - (v.grad) u + force

  Collective.

  Input Parameters:
+ dt        - length of this viscous step; less than the clock's where it starts from a history [s]
. projection_factor - see OperatorsSetWallVelocity()
. force     - per unit mass, constant over the step [m/s^2]
- advecting - v, NULL where particles move or the force holds the convection already [m/s]

  Input/Output Parameter:
. u - velocity components [m/s]

  Output Parameter:
. failure - set where a TS diverges, or no method reaches a small true residual
*/
PetscErrorCode ViscositySolve(const Scene *scene, const Clock *clock, Particles *p, PetscReal dt,
                              PetscReal projection_factor, const Vec force[], const Vec advecting[],
                              Operators *ops, Vec u[], Viscosity *v, StepFailure *failure)
{
  const PetscReal t_new = clock->t + clock->dt;

  PetscFunctionBegin;
  v->scene             = scene;
  v->particles         = p;
  v->ops               = ops;
  v->projection_factor = projection_factor;
  v->force             = force;
  v->advecting         = advecting;
  v->wall_t            = NAN;
  v->iterations        = 0;
  PetscCall(ViscosityUpdateJacobian(v));
  PetscCall(ClockWhere(clock, v->guard.where));
  for (PetscInt c = 0; c < v->dim && v->systems == 1; c++) {
    PetscCall(VecStrideScatter(u[c], c, v->all, INSERT_VALUES));
    PetscCall(VecStrideScatter(force[c], c, v->all_force, INSERT_VALUES));
  }
  for (PetscInt c = 0; c < v->systems && !failure->code; c++)
    PetscCall(ViscosityStepSystem(v, c, t_new - dt, dt, v->systems == 1 ? v->all : u[c], failure));
  for (PetscInt c = 0; c < v->dim && v->systems == 1; c++)
    PetscCall(VecStrideGather(v->all, c, u[c], INSERT_VALUES));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const ViscousIntegratorRow *ViscosityIntegrator(const Viscosity *v)
{
  return v->row;
}

/* ViscosityResponse - What a force newly switched on does to u in one step, over dt: 1, or less for
 * BDF */
PetscReal ViscosityResponse(const Viscosity *v)
{
  return v->row->Response ? v->row->Response(v->ts[0]) : 1.0;
}

/* ViscosityNames - Types of the TS, KSP and preconditioner; NULL where there is none */
PetscErrorCode ViscosityNames(const Viscosity *v, const char **ts, const char **ksp,
                              const char **pc)
{
  PetscFunctionBegin;
  *ts  = v->row->name;
  *ksp = *pc = NULL;
  if (!v->ksp) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SolverNames(v->ksp, ksp, pc));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ViscosityMatrix - Matrix of the last implicit solve, shift I - nu A; NULL: there was none */
Mat ViscosityMatrix(const Viscosity *v)
{
  return v->J;
}

/* ViscosityFalls - How many solves the fallback ladder has made */
PetscInt *ViscosityFalls(Viscosity *v)
{
  return &v->guard.falls;
}

/* ViscosityNote - What is unwise in the choice of solver and form, or "" */
const char *ViscosityNote(const Viscosity *v)
{
  return v->guard.note;
}

/* ViscosityIterations - KSP iterations of the last solve, all components together */
PetscInt ViscosityIterations(const Viscosity *v)
{
  return v->iterations;
}
