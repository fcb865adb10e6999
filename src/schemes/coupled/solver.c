/*
  The solver of the coupled scheme for velocity and pressure together,

    du/dt = nu lap u - (v.grad) u - grad p/rho + f,   div u = 0,

  a differential-algebraic system with the matrix of saddle.c; v is the advecting velocity. A PETSc
  TS advances the system in time, or a steady flow is solved without du/dt. The pressure needs no
  earlier pressures and has no splitting error.
*/
#include "coupled.h"

static const OptionRow options[] = {
    {
        .name     = "-coupled_schur",
        .expert   = PETSC_TRUE,
        .kind     = VALUE_NAME,
        .brief    = "preconditioner of the pressure in the coupled scheme",
        .standard = "cahouet_chabard",
        .table    = &SchurTable,
        .where    = "-scheme coupled with -coupled_pc_type fieldsplit",
    },
};
const OptionTable CoupledSolverOptions = OPTIONS("Solver of the coupled scheme", options);

/* Sets defaults for the solvers of the field split's blocks: a single application of the
   preconditioners of velocityblock.c and schur.c. Options of the user may name others. */
static PetscErrorCode BlockDefaults(const Flow *flow, Coupled *c)
{
  const char *const prefix[] = {"coupled_fieldsplit_velocity_", "coupled_fieldsplit_pressure_"};
  char              type[32] = PCSHELL;
  PetscBool         same;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < 2; k++) {
    PetscCall(OptionDefault(prefix[k], "-ksp_type", KSPPREONLY));
    PetscCall(OptionDefault(prefix[k], "-pc_type", PCSHELL));
  }
  PetscCall(PetscOptionsGetString(NULL, prefix[0], "-pc_type", type, sizeof(type), NULL));
  PetscCall(PetscStrcmp(type, PCSHELL, &same));
  PetscCall(PetscStrcmp(c->guard.mat_type, MATSAME, &c->saddle.repeats));
  c->saddle.repeats = same && c->saddle.repeats && !flow->ops->forms.components_coupled &&
                      !(flow->scene->frame && flow->clock->steady_solve);
  if (same) PetscCall(VelocityBlockCreate(flow, c->saddle.repeats, &c->velocity));
  else PetscCall(AmgDefaults(prefix[0], "0"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the TS with its SNES and KSP from the options. */
static PetscErrorCode CoupledCreateTS(Coupled *c)
{
  SNES    snes;
  KSP     ksp;
  TSAdapt adapt;
  PC      pc;

  PetscFunctionBegin;
  PetscCall(TSCreate(PETSC_COMM_WORLD, &c->ts));
  PetscCall(TSSetOptionsPrefix(c->ts, "coupled_"));
  PetscCall(TSSetProblemType(c->ts, c->convects ? TS_NONLINEAR : TS_LINEAR));
  PetscCall(TSSetType(c->ts, c->row->name));
  PetscCall(TSSetEquationType(c->ts, TS_EQ_DAE_IMPLICIT_INDEX2));
  PetscCall(TSSetExactFinalTime(c->ts, TS_EXACTFINALTIME_STEPOVER));
  PetscCall(TSSetMaxSteps(c->ts, PETSC_INT_MAX - 1));
  PetscCall(TSSetMaxTime(c->ts, PETSC_MAX_REAL));
  PetscCall(TSSetErrorIfStepFails(c->ts, PETSC_FALSE));
  PetscCall(TSSetIFunction(c->ts, NULL, CoupledIFunction, c));
  PetscCall(TSGetAdapt(c->ts, &adapt));
  PetscCall(TSAdaptSetType(adapt, c->row->substeps ? TSADAPTBASIC : TSADAPTNONE));
  PetscCall(TSGetSNES(c->ts, &snes));
  PetscCall(SNESSetMaxLinearSolveFailures(snes, PETSC_INT_MAX)); /* the guard handles failures */
  PetscCall(SNESGetKSP(snes, &ksp));
  PetscCall(KSPSetType(ksp, KSPFGMRES));
  PetscCall(KSPGMRESSetRestart(ksp, 100));
  PetscCall(KSPSetTolerances(ksp, 1e-7, 0.0, PETSC_CURRENT, 300));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PCSetType(pc, PCFIELDSPLIT));
  PetscCall(KspViewsTake("coupled_", &c->guard.ksp_views));
  PetscCall(SolverViewTake("coupled_", "-ts_view", &c->guard.ts_view));
  PetscCall(TSSetFromOptions(c->ts));
  PetscCall(TimeToleranceRefuse(c->ts, "coupled_"));
  c->guard.solve.ksp = ksp;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Chooses a direct solver on a single rank in 2D for a weak form, whose viscosities vary: no field
   split holds with every ratio of them. */
static PetscErrorCode DirectDefault(const Flow *flow)
{
  PetscMPIInt ranks;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &ranks));
  if (ranks == 1 && flow->scene->dim == 2 && flow->ops->forms.visc.row->weak)
    PetscCall(OptionDefault("coupled_", "-pc_type", PCLU));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  CoupledSolverCreate - Creates the solver of the coupled scheme and adds its solve to the scheme

  Collective on PETSC_COMM_WORLD. The preconditioner depends on the clock's first time step.

  Options Database Keys:
+ -coupled_schur - row of the table of schur.c
. -coupled_ksp_type, -coupled_pc_type, -coupled_pc_fieldsplit_..., -coupled_ts_... - PETSc's options
. -coupled_fieldsplit_velocity_..., -coupled_fieldsplit_pressure_... - KSP and PC of the blocks
- -coupled_schur_ksp_type, -coupled_schur_pc_type, ... - solver of the Poisson equation in schur.c

  Errors: refuses options by which the TS would control time, and absolute tolerances
*/
PetscErrorCode CoupledSolverCreate(Flow *flow, Coupled *c)
{
  char      type[32] = PCFIELDSPLIT;
  PetscBool given, split, lu;

  PetscFunctionBegin;
  PetscCall(DirectDefault(flow));
  PetscCall(PetscOptionsGetString(NULL, "coupled_", "-pc_type", type, sizeof(type), NULL));
  PetscCall(PetscStrcmp(type, PCFIELDSPLIT, &split));
  PetscCall(PetscStrcmp(type, PCLU, &lu));
  c->guard.solve       = (LinearSolve){.name       = "coupled",
                                       .label      = "solver",
                                       .prefix     = "coupled_",
                                       .integrator = c->row->name,
                                       .column     = SOLVE_VELOCITY};
  c->guard.approximate = PETSC_TRUE;
  c->guard.flat        = flow->scene->dim == 2 ? PETSC_TRUE : PETSC_FALSE;
  c->guard.Flatten     = SaddleFlatten;
  c->guard.remedy      = "try a larger -coupled_ksp_max_it, or a smaller -dt";
  if (!lu)
    c->guard.remedy = "try -coupled_pc_type lu, a larger -coupled_ksp_max_it, or a smaller -dt";
  if (split) PetscCall(OptionGetRow(&options[0], NULL, &c->schur.row));
  PetscCall(TimeOptionsRefuse("coupled_", c->row->name));
  PetscCall(PetscOptionsHasName(NULL, "coupled_", "-ts_atol", &given));
  UserCheck(!given, "-coupled_ts_atol: an absolute tolerance depends on units; use "
                    "-coupled_ts_rtol, of |u| + U");
  PetscCall(SolverMatType("coupled_", c->guard.mat_type, sizeof(c->guard.mat_type)));
  if (split) PetscCall(BlockDefaults(flow, c));
  if (split) PetscCall(SchurCreate(&c->schur));
  PetscCall(CoupledCreateTS(c));
  PetscCall(GuardAttach(c->guard.solve.ksp, NULL, &c->guard));
  PetscCall(SchemeAddSolve(&c->guard.solve, flow->scheme));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CoupledFree(Coupled *c)
{
  PetscFunctionBegin;
  PetscCall(SaddleFree(&c->saddle));
  PetscCall(VecDestroy(&c->x));
  PetscCall(VecDestroy(&c->b));
  PetscCall(VecDestroy(&c->part));
  PetscCall(VecDestroy(&c->work));
  PetscCall(VecDestroy(&c->all_walls));
  PetscCall(VecDestroy(&c->boundary));
  PetscCall(MatDestroy(&c->flat));
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) PetscCall(VecDestroy(&c->u[a]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* CoupledSolverFree - Views the integrator, if its option is given, and frees solver and
   matrices; collective */
PetscErrorCode CoupledSolverFree(Coupled *c)
{
  PetscFunctionBegin;
  PetscCall(SolverViewShow((PetscObject)c->ts, &c->guard.ts_view));
  PetscCall(CoupledFree(c));
  PetscCall(SchurFree(&c->schur));
  PetscCall(VelocityBlockFree(&c->velocity));
  PetscCall(GuardDetach(&c->guard));
  PetscCall(TSDestroy(&c->ts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Replaces the preconditioner by a new PC of the same type, because PETSc's field split cannot
   change its sizes and blocks. */
static PetscErrorCode RenewPC(Coupled *c)
{
  PetscBool split;
  IS        rows[2];
  PC        pc, fresh;
  PCType    type;

  PetscFunctionBegin;
  PetscCall(KSPGetPC(c->guard.solve.ksp, &pc));
  PetscCall(PCGetType(pc, &type));
  PetscCall(PetscObjectTypeCompare((PetscObject)pc, PCFIELDSPLIT, &split));
  PetscCall(PCCreate(PetscObjectComm((PetscObject)c->guard.solve.ksp), &fresh));
  PetscCall(PCSetOptionsPrefix(fresh, "coupled_"));
  PetscCall(PCSetType(fresh, type));
  PetscCall(PCSetUseAmat(fresh, PETSC_FALSE));
  PetscCall(KSPSetPC(c->guard.solve.ksp, fresh));
  if (split) {
    PetscCall(PCFieldSplitSetType(fresh, PC_COMPOSITE_SCHUR));
    PetscCall(PCFieldSplitSetSchurFactType(fresh, PC_FIELDSPLIT_SCHUR_FACT_UPPER));
    PetscCall(MatNestGetISs(c->saddle.P, rows, NULL));
    PetscCall(PCFieldSplitSetIS(fresh, "velocity", rows[0]));
    PetscCall(PCFieldSplitSetIS(fresh, "pressure", rows[1]));
  }
  PetscCall(PCSetFromOptions(fresh));
  if (split) {
    PetscCall(PCFieldSplitSetSchurPre(fresh, PC_FIELDSPLIT_SCHUR_PRE_USER, c->schur.mass));
    PetscCall(KSPSetOperators(c->guard.solve.ksp, c->saddle.A, c->saddle.P));
    PetscCall(PCSetUp(fresh));
    PetscCall(VelocityBlockAttach(fresh, &c->saddle, &c->velocity));
    PetscCall(SchurAttach(fresh, &c->schur));
  } else {
    PetscCall(SaddleFlatten(c->saddle.P, &c->flat));
  }
  PetscCall(PCDestroy(&fresh));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Sets the allowed error of substeps, -coupled_ts_rtol times |u| + U. The error of the pressure is
  unlimited: the pressure is not integrated in time, and jumps when a wall velocity jumps.
*/
static PetscErrorCode SetTolerances(const Scene *scene, Coupled *c)
{
  const PetscInt n = c->saddle.dim * c->saddle.n;
  PetscReal      rtol;
  PetscScalar   *entry;
  PetscInt       size;
  Vec            atol;

  PetscFunctionBegin;
  PetscCall(TSGetTolerances(c->ts, NULL, NULL, &rtol, NULL));
  PetscCall(VecDuplicate(c->x, &atol));
  PetscCall(VecGetLocalSize(atol, &size));
  PetscCall(VecGetArray(atol, &entry));
  for (PetscInt i = 0; i < size; i++) entry[i] = i < n ? rtol * scene->speed : PETSC_INFINITY;
  PetscCall(VecRestoreArray(atol, &entry));
  PetscCall(TSSetTolerances(c->ts, PETSC_DETERMINE, atol, PETSC_DETERMINE, NULL));
  PetscCall(VecDestroy(&atol));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates matrices and vectors for the present operators; for `shift` and `advecting` see
   CoupledAssemble(). */
static PetscErrorCode CoupledMake(PetscReal shift, const Vec advecting[], Coupled *c)
{
  const Scene     *scene = c->flow->scene;
  const Particles *p     = c->flow->particles;
  LinearSolve     *solve = &c->guard.solve;
  const PetscBool  anew  = !c->velocity.flow || !SetUpHolds(&solve->setup, p->epoch, shift);

  PetscFunctionBegin;
  PetscCall(TSReset(c->ts));
  PetscCall(CoupledFree(c));
  PetscCall(SaddleAssemble(c->flow, advecting, c->guard.mat_type, &c->saddle));
  if (c->schur.row)
    PetscCall(SchurAssemble(c->flow, &c->saddle, c->guard.mat_type, anew, &c->schur));
  PetscCall(UnknownsVec(p, c->saddle.n_p, &c->x));
  PetscCall(VecDuplicate(c->x, &c->b));
  PetscCall(SetTolerances(scene, c));
  PetscCall(FluidVec(p, NULL, &c->part));
  PetscCall(FluidVec(p, NULL, &c->work));
  for (PetscInt a = 0; a < scene->dim; a++) PetscCall(FluidVec(p, NULL, &c->u[a]));
  if (c->flow->ops->forms.components_coupled && c->flow->ops->forms.wall) {
    PetscCall(WallVelocityVec(p, &c->all_walls));
    PetscCall(VelocityVec(p, &c->boundary));
  }
  c->b_t       = NAN;
  c->advecting = advecting;
  if (anew) solve->setup.exists = PETSC_FALSE;
  PetscCall(CoupledSetShift(shift, c));
  PetscCall(RenewPC(c));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  CoupledAssemble - Computes matrices, vectors and preconditioner for the present operators and step

  Collective. Does nothing if operators and SaddleTime() are unchanged and no convection is
  implicit.

  Input Parameters:
+ shift     - shift of the first solve: the factor of u in du/dt [1/s]
- advecting - advecting velocity of implicit convection [m/s], which must exist as long as the
              matrices; NULL: no implicit convection
*/
PetscErrorCode CoupledAssemble(PetscReal shift, const Vec advecting[], Coupled *c)
{
  const Scene    *scene = c->flow->scene;
  const PetscReal step  = SaddleTime(scene->nu, c->flow->clock, scene->dx);
  const PetscBool same  = c->saddle.A && c->saddle.assemblies == c->flow->ops->assemblies;

  PetscFunctionBegin;
  if (!same || advecting || c->advecting || step != c->saddle.step)
    PetscCall(CoupledMake(shift, advecting, c));
  PetscFunctionReturn(PETSC_SUCCESS);
}
