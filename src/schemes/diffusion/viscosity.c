/*
  The viscous step by PETSc's TS. Each velocity component has a scalar system,

    du_c/dt = nu (A u_c + B u_wall,c) - (v.grad) u_c + force_c,

  with the matrices A and B of the viscous operator and the advecting velocity v of fixed particles,
  constant over the step. The systems share a KSP, and they share a matrix unless a boundary has
  different equations for each component. If the form couples components, or the viscosity depends
  on the strain rate, all components are in a single system. The integrator's row decides the
  callback of each term.
*/
#include "viscosity.h"

static const OptionRow options[] = {
    OPTION(NAME, "-visc_ts_type", "time integrator of viscosity", NULL, TSBEULER,
           .table = &ViscousIntegratorTable, .where = "-scheme projection with viscosity"),
};
const OptionTable ViscosityOptions = OPTIONS("Viscosity", options);

/* Refuses options by which the TS would control time. */
static PetscErrorCode RefuseTimeOptions(const ViscousIntegratorRow *row)
{
  PetscReal theta = 0.5;
  PetscBool given;

  PetscFunctionBegin;
  PetscCall(TimeOptionsRefuse("visc_", row->name));
  PetscCall(PetscOptionsHasName(NULL, "visc_", "-ts_adapt_type", &given));
  UserCheck(
      !given || row->substeps,
      "-visc_ts_adapt_type: %s takes a single step here, without an estimate of its error; use "
      "arkimex, rosw or rk",
      row->name);
  PetscCall(PetscOptionsGetReal(NULL, "visc_", "-ts_theta_theta", &theta, NULL));
  UserCheck(theta > 0.0 && theta <= 1.0, "-visc_ts_theta_theta %.6g: allowed is more than 0 to 1",
            (double)theta);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Chooses the linear solver by the stiffness of the step, nu dt/dx^2. */
static PetscErrorCode ViscosityCreateSolver(const Flow *flow, Viscosity *v)
{
  const Scene    *scene    = flow->scene;
  Regime         *regime   = scene->regime;
  const PetscBool convects = flow->state->implicit_convection;
  PetscBool       symmetric;
  PetscReal       rtol;
  KSP             ksp;
  SNES            snes;
  PC              pc;

  PetscFunctionBegin;
  regime->number[NUMBER_STIFFNESS] =
      scene->nu_high * flow->clock->dt / PetscSqr(SceneFinest(scene));
  PetscCall(TSGetSNES(v->ts[0], &snes));
  PetscCall(SNESGetKSP(snes, &ksp));
  symmetric = LaplacianIs(&flow->ops->forms.visc, FORM_SYMMETRIC) && !v->nonlinear && !convects;
  rtol      = RegimeValue(regime, REGIME_VISC_RTOL);
  PetscCall(KSPSetType(ksp, symmetric ? KSPCG : KSPGMRES));
  PetscCall(KSPSetTolerances(ksp, rtol, 0.0, PETSC_CURRENT, 1000));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PCSetType(pc, RegimeWord(regime, REGIME_VISC_PC)));
  if (flow->ops->forms.visc.row->weak) PetscCall(PCSetType(pc, PCBJACOBI)); /* AMG breaks down */
  if (OperatorsCutFluids(scene, flow->ops)) PetscCall(OptionDefault("visc_", "-sub_pc_type", PCLU));
  for (PetscInt c = 0; c < v->systems; c++) {
    PetscCall(TSGetSNES(v->ts[c], &snes));
    if (c) PetscCall(SNESSetKSP(snes, ksp));
    PetscCall(SNESSetMaxLinearSolveFailures(snes, PETSC_INT_MAX)); /* the guard handles failures */
  }
  if (v->nonlinear) PetscCall(IterationChoose(v, snes));
  v->guard.solve.ksp = ksp;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the TS of a system and sets the callbacks that the TS type needs. */
static PetscErrorCode CreateSystem(Viscosity *v, PetscInt c)
{
  const char *const names[] = {"u", "v", "w"};

  PetscFunctionBegin;
  v->component[c].visc = v;
  v->component[c].c    = c;
  PetscCall(TimeCreate("visc_", v->systems > 1 ? names[c] : "velocity", v->row->name, !v->nonlinear,
                       &v->ts[c]));
  if (v->row->terms != TIME_IMPLICIT)
    PetscCall(TSSetRHSFunction(v->ts[c], NULL, ViscosityRHSFunction, &v->component[c]));
  if (v->row->terms != TIME_EXPLICIT)
    PetscCall(TSSetIFunction(v->ts[c], NULL, ViscosityIFunction, &v->component[c]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses what implicit convection has no matrix for. */
static PetscErrorCode RefuseImplicitConvection(const Flow *flow, const ViscousIntegratorRow *row)
{
  const OperatorForms *forms = &flow->ops->forms;

  PetscFunctionBegin;
  if (!flow->state->implicit_convection) PetscFunctionReturn(PETSC_SUCCESS);
  UserCheck(row->terms == TIME_IMPLICIT,
            "-convection implicit: -visc_ts_type %s takes convection explicitly; use beuler, "
            "cn or theta",
            row->name);
  UserCheck(!forms->components_coupled,
            "-convection implicit: it needs a matrix for each velocity component, and %s couples "
            "them; use explicit",
            SceneIsNewtonian(flow->scene) ? forms->visc.row->name : "-rheology");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Decides if the solver takes a shell: it only multiplies, by default with Jacobi or none at small
   stiffness. */
static PetscErrorCode ChooseShell(Viscosity *v)
{
  SNES snes;

  PetscFunctionBegin;
  if (v->nonlinear || v->flow->state->implicit_convection || !v->flow->ops->velocity[0].visc.rows)
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TSGetSNES(v->ts[0], &snes));
  PetscCall(GuardOnlyMultiplies(snes, PCJACOBI, &v->guard, &v->shell));
  if (v->shell) v->guard.Flatten = AffineSystemFlatten;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ViscosityCreate - Creates the integrators of the viscous term and adds their solve to the scheme.
   Collective on PETSC_COMM_WORLD. The preconditioner depends on the clock's first time step. */
PetscErrorCode ViscosityCreate(Flow *flow, Viscosity **visc)
{
  Viscosity   *v;
  LinearSolve *solve;

  PetscFunctionBegin;
  PetscCall(PetscNew(&v));
  v->dim         = flow->scene->dim;
  v->systems     = flow->ops->forms.components_coupled ? 1 : v->dim;
  v->nonlinear   = SceneIsNewtonian(flow->scene) ? PETSC_FALSE : PETSC_TRUE;
  v->flow        = flow;
  v->guard.inner = v->nonlinear;
  v->guard.Check = v->nonlinear ? IterationCheck : NULL;
  solve          = &v->guard.solve;
  solve->name    = "viscous";
  solve->label   = "visc solver";
  solve->prefix  = "visc_";
  solve->column  = SOLVE_VELOCITY;
  PetscCall(OptionGetRow(&options[0], NULL, &v->row));
  solve->integrator = v->row->name;
  PetscCall(RefuseTimeOptions(v->row));
  PetscCall(RefuseImplicitConvection(flow, v->row));
  for (PetscInt c = 0; c < v->systems; c++) PetscCall(CreateSystem(v, c));
  if (v->row->terms != TIME_EXPLICIT) {
    PetscCall(ViscosityCreateSolver(flow, v));
    PetscCall(KspViewsTake("visc_", &v->guard.ksp_views));
  }
  PetscCall(SolverViewTake("visc_", "-ts_view", &v->guard.ts_view));
  for (PetscInt c = 0; c < v->systems; c++) {
    PetscCall(TSSetFromOptions(v->ts[c]));
    PetscCall(TimeToleranceRefuse(v->ts[c], "visc_"));
  }
  if (solve->ksp) {
    PetscCall(GuardAttach(
        solve->ksp, flow->state->implicit_convection ? NULL : &flow->ops->forms.visc, &v->guard));
    PetscCall(ChooseShell(v));
  }
  UserCheck(v->row->history || flow->clock->order < 3,
            "-time_order 3: %s %s has an order of its own; use beuler", options[0].name,
            v->row->name);
  if (!v->row->history) PetscCall(ClockDropEstimate(flow->clock, options[0].name, v->row->name));
  PetscCall(SchemeAddSolve(solve, flow->scheme));
  *visc = v;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ViscosityFree(Viscosity *v)
{
  PetscFunctionBegin;
  PetscCall(VecDestroyAll(&v->boundary, &v->all, &v->all_force, &v->all_walls));
  for (PetscInt c = 0; c < v->dim; c++) PetscCall(VecDestroy(&v->part[c]));
  PetscCall(MatDestroyAll(&v->newton, &v->J, &v->convection));
  v->assemblies = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ViscosityDestroy - Views the integrators, if their option is given, and frees them; collective */
PetscErrorCode ViscosityDestroy(Viscosity **visc)
{
  PetscFunctionBegin;
  if (!*visc) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt c = 0; c < (*visc)->systems; c++)
    PetscCall(SolverViewShow((PetscObject)(*visc)->ts[c], &(*visc)->guard.ts_view));
  PetscCall(ViscosityFree(*visc));
  PetscCall(GuardDetach(&(*visc)->guard));
  for (PetscInt c = 0; c < (*visc)->systems; c++) PetscCall(TSDestroy(&(*visc)->ts[c]));
  PetscCall(PetscFree(*visc));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the vectors for the present numbering. */
static PetscErrorCode ViscosityRenumber(Viscosity *v)
{
  const Particles *p = v->flow->particles;

  PetscFunctionBegin;
  if (v->epoch == p->epoch) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ViscosityFree(v));
  for (PetscInt c = 0; c < v->systems; c++) PetscCall(TSReset(v->ts[c]));
  v->epoch = p->epoch;
  if (v->systems > 1) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VelocityVec(p, &v->boundary));
  PetscCall(VelocityVec(p, &v->all));
  PetscCall(VelocityVec(p, &v->all_force));
  PetscCall(WallVelocityVec(p, &v->all_walls));
  for (PetscInt c = 0; c < v->dim; c++) PetscCall(FluidVec(p, NULL, &v->part[c]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Frees the Jacobian, also in the solvers that hold it, before the next is created: both at once
   would be the peak of the run's memory. The reset also renews the set-up of
   -visc_snes_mf_operator. */
static PetscErrorCode ViscosityFreeJacobian(Viscosity *v)
{
  PetscFunctionBegin;
  PetscCall(SolverRenewPC(v->guard.solve.ksp));
  for (PetscInt c = 0; c < v->systems; c++) {
    SNES snes;

    PetscCall(TSGetSNES(v->ts[c], &snes));
    PetscCall(SNESReset(snes));
  }
  PetscCall(MatDestroyAll(&v->newton, &v->J, &v->convection));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates a Jacobian with the sparsity pattern of the present operators, and renews the
   preconditioner. A shell serves all assemblies of an epoch. */
static PetscErrorCode ViscosityUpdateJacobian(Viscosity *v)
{
  Operators *ops = v->flow->ops;

  PetscFunctionBegin;
  if (!v->guard.solve.ksp || v->assemblies == ops->assemblies) PetscFunctionReturn(PETSC_SUCCESS);
  v->shift      = NAN;
  v->assemblies = ops->assemblies;
  if (v->shell && v->J) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ViscosityFreeJacobian(v));
  PetscCall(AffineSystemCreate(&ops->velocity[0].visc, v->shell ? MATSHELL : MATSAME, &v->J));
  if (v->flow->state->implicit_convection)
    PetscCall(MatDuplicate(v->J, MAT_DO_NOT_COPY_VALUES, &v->convection));
  if (v->nonlinear) PetscCall(ViscosityCreateNewton(v));
  for (PetscInt c = 0; c < v->systems; c++) {
    PetscCall(TSSetIJacobian(v->ts[c], v->newton ? v->newton : v->J, v->J, ViscosityIJacobian,
                             &v->component[c]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Advances a system over [t, t + dt], in a single TS step unless the user's -visc_ts_adapt_type
   takes several. */
static PetscErrorCode ViscosityStepSystem(Viscosity *v, PetscInt c, PetscReal t, PetscReal dt,
                                          Vec u, StepFailure *failure)
{
  PetscReal h = dt;

  PetscFunctionBegin;
  PetscCall(TSSetSolution(v->ts[c], u));
  PetscCall(TSRestartStep(v->ts[c])); /* stages of the last step belong to another flow */
  PetscCall(TimeStepThrough(v->ts[c], v->row->name, &v->guard, t, dt, &h, failure));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  ViscositySolve - Advances all velocity components over dt to the end of the clock's step

    du/dt = nu lap u - (v.grad) u + force

  Collective. Sets scheme->failure if a TS diverges, or if no method reaches a small true residual.
  Input: dt - length of the viscous step; shorter than the clock's step if it starts from two
  earlier velocities [s]; projection_factor - see WallValuesSetVelocity() [m^3 s/kg]; force - force
  per unit mass, constant over the step [m/s^2]; advecting - advecting velocity v; NULL if particles
  move or the force contains convection [m/s]. Input/Output: u - velocity components [m/s].
*/
PetscErrorCode ViscositySolve(Flow *flow, PetscReal dt, PetscReal projection_factor,
                              const Vec force[], const Vec advecting[], Vec u[], Viscosity *v)
{
  const PetscReal t_new   = flow->clock->t + flow->clock->dt;
  const PetscBool all     = v->systems == 1;
  StepFailure    *failure = &flow->scheme->failure;

  PetscFunctionBegin;
  v->projection_factor      = projection_factor;
  v->force                  = force;
  v->advecting              = advecting;
  v->wall_t                 = NAN;
  v->guard.solve.iterations = 0;
  PetscCall(ViscosityRenumber(v));
  PetscCall(ViscosityUpdateJacobian(v));
  if (v->convection) v->shift = NAN; /* the advecting velocity is new */
  PetscCall(ClockWhere(flow->clock, v->guard.where));
  for (PetscInt c = 0; c < v->dim && all; c++) {
    PetscCall(VecStrideScatter(u[c], c, v->all, INSERT_VALUES));
    PetscCall(VecStrideScatter(force[c], c, v->all_force, INSERT_VALUES));
  }
  if (v->newton) PetscCall(TangentCreate(flow->scene, flow->particles, flow->ops, &v->tangent));
  for (PetscInt c = 0; c < v->systems && !failure->code; c++)
    PetscCall(ViscosityStepSystem(v, c, t_new - dt, dt, all ? v->all : u[c], failure));
  PetscCall(TangentDestroy(&v->tangent));
  for (PetscInt c = 0; c < v->dim && all; c++)
    PetscCall(VecStrideGather(v->all, c, u[c], INSERT_VALUES));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ViscosityView - Prints the integrator and the nonlinear solver; collective on the viewer */
PetscErrorCode ViscosityView(const Viscosity *v, PetscViewer viewer)
{
  PetscFunctionBegin;
  PetscCall(TableViewRow("visc TS", v->row, viewer));
  PetscCall(IterationView(v, viewer));
  PetscFunctionReturn(PETSC_SUCCESS);
}
