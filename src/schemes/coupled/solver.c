/*
  The solver of the coupled scheme for velocity and pressure together,

    du/dt = nu lap u - (v.grad) u - grad p/rho + f,   div u = 0,

  a differential-algebraic system with the matrix of saddle.c; v is the advecting velocity. Steps
  are implicit, or a steady flow is solved without du/dt. The pressure needs no earlier pressures
  and has no splitting error.
*/
#include "coupled.h"

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
  c->saddle.repeats = same && !flow->ops->forms.components_coupled &&
                      !(flow->scene->frame && flow->clock->steady_solve);
  if (same) PetscCall(VelocityBlockCreate(flow, c->saddle.repeats, &c->velocity));
  else PetscCall(AmgDefaults(prefix[0], "0"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the KSP from the options. The forces of strain cells with a free surface sum to zero, and
   the momentum of drops that touch nothing is kept as well as the equations are solved. */
static PetscErrorCode CreateKsp(Coupled *c)
{
  const PetscReal whole = c->flow->scene->dim == 2 ? 1e-10 : 1e-8;
  const PetscReal rtol  = c->flow->ops->cut_surface ? whole : 1e-7;
  KSP             ksp;
  PC              pc;

  PetscFunctionBegin;
  PetscCall(KSPCreate(PETSC_COMM_WORLD, &ksp));
  PetscCall(KSPSetOptionsPrefix(ksp, "coupled_"));
  PetscCall(KSPSetType(ksp, KSPFGMRES));
  PetscCall(KSPGMRESSetRestart(ksp, 100));
  PetscCall(KSPSetTolerances(ksp, rtol, 0.0, PETSC_CURRENT, 300));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PCSetType(pc, PCFIELDSPLIT));
  PetscCall(KspViewsTake("coupled_", &c->guard.ksp_views));
  PetscCall(KSPSetFromOptions(ksp));
  PetscCall(GuardAttach(ksp, NULL, &c->guard));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Chooses a direct solver on a single rank in 2D for a weak form if the fluid is closed, and its
   viscosities vary, or if the velocity block needs LU at a free surface: no field split holds with
   every ratio of viscosities, and each takes longer. On several ranks the sums of MUMPS have no
   fixed order: a restart would not be bitwise. */
static PetscErrorCode DirectDefault(const Flow *flow)
{
  PetscBool   lu;
  PetscMPIInt ranks;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &ranks));
  if (ranks > 1 || flow->scene->dim == 3 || !flow->ops->forms.visc.row->weak)
    PetscFunctionReturn(PETSC_SUCCESS);
  VelocityBlockChoose(flow, &lu);
  if (lu || !flow->ops->cut_surface) PetscCall(OptionDefault("coupled_", "-pc_type", PCLU));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  CoupledSolverCreate - Creates the solver of the coupled scheme and adds its solve to the scheme.
  Collective on PETSC_COMM_WORLD. The preconditioner depends on the clock's first time step.

  Options Database Keys:
  + -coupled_ksp_type, -coupled_pc_type, -coupled_pc_fieldsplit_... - PETSc's options
  . -coupled_fieldsplit_velocity_..., -coupled_fieldsplit_pressure_... - KSP and PC of the blocks
  - -coupled_schur_ksp_type, -coupled_schur_pc_type, ... - solver of the Poisson equation in schur.c
*/
PetscErrorCode CoupledSolverCreate(Flow *flow, Coupled *c)
{
  char      type[32] = PCFIELDSPLIT;
  PetscBool lu;

  PetscFunctionBegin;
  PetscCall(DirectDefault(flow));
  PetscCall(PetscOptionsGetString(NULL, "coupled_", "-pc_type", type, sizeof(type), NULL));
  PetscCall(PetscStrcmp(type, PCFIELDSPLIT, &c->splits));
  PetscCall(PetscStrcmp(type, PCLU, &lu));
  if (lu) PetscCall(FactorDefault("coupled_", "-pc_factor_mat_solver_type"));
  c->guard.solve       = (LinearSolve){.name       = "coupled",
                                       .label      = "solver",
                                       .prefix     = "coupled_",
                                       .integrator = TSBEULER,
                                       .column     = SOLVE_VELOCITY};
  c->guard.approximate = PETSC_TRUE;
  c->guard.keeps       = PETSC_TRUE;
  c->guard.flat        = flow->scene->dim == 2 ? PETSC_TRUE : PETSC_FALSE;
  c->guard.Flatten     = SaddleFlatten;
  c->guard.remedy      = "try a larger -coupled_ksp_max_it, or a smaller -dt";
  if (!lu)
    c->guard.remedy = "try -coupled_pc_type lu, a larger -coupled_ksp_max_it, or a smaller -dt";
  if (c->splits) PetscCall(BlockDefaults(flow, c));
  if (c->splits) PetscCall(SchurCreate(flow->ops->cut_surface, &c->schur));
  PetscCall(CreateKsp(c));
  PetscCall(SchemeAddSolve(&c->guard.solve, flow->scheme));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CoupledFree(Coupled *c)
{
  PetscFunctionBegin;
  PetscCall(SaddleFree(&c->saddle));
  PetscCall(VecDestroyAll(&c->x, &c->b, &c->part, &c->work, &c->all_walls, &c->boundary));
  PetscCall(MatDestroy(&c->flat));
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) PetscCall(VecDestroy(&c->u[a]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* CoupledForget - Frees matrices, vectors and preconditioner; the next CoupledAssemble() makes them
   anew. Collective. */
PetscErrorCode CoupledForget(Coupled *c)
{
  PetscFunctionBegin;
  PetscCall(KSPReset(c->guard.solve.ksp));
  PetscCall(CoupledFree(c));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* CoupledSolverFree - Frees solver and matrices; collective */
PetscErrorCode CoupledSolverFree(Coupled *c)
{
  PetscFunctionBegin;
  PetscCall(CoupledFree(c));
  PetscCall(SchurFree(&c->schur));
  PetscCall(VelocityBlockFree(&c->velocity));
  PetscCall(GuardDetach(&c->guard));
  PetscCall(KSPDestroy(&c->guard.solve.ksp));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Replaces the preconditioner by a new PC of the same type, because PETSc's field split cannot
   change its sizes and blocks. */
static PetscErrorCode RenewPC(Coupled *c)
{
  IS     rows[2];
  PC     pc, fresh;
  PCType type;

  PetscFunctionBegin;
  PetscCall(KSPGetPC(c->guard.solve.ksp, &pc));
  PetscCall(PCGetType(pc, &type));
  PetscCall(PCCreate(PetscObjectComm((PetscObject)c->guard.solve.ksp), &fresh));
  PetscCall(PCSetOptionsPrefix(fresh, "coupled_"));
  PetscCall(PCSetType(fresh, type));
  PetscCall(PCSetUseAmat(fresh, PETSC_FALSE));
  PetscCall(KSPSetPC(c->guard.solve.ksp, fresh));
  if (c->splits) {
    PetscCall(PCFieldSplitSetType(fresh, PC_COMPOSITE_SCHUR));
    PetscCall(PCFieldSplitSetSchurFactType(fresh, PC_FIELDSPLIT_SCHUR_FACT_UPPER));
    PetscCall(MatNestGetISs(c->saddle.P, rows, NULL));
    PetscCall(PCFieldSplitSetIS(fresh, "velocity", rows[0]));
    PetscCall(PCFieldSplitSetIS(fresh, "pressure", rows[1]));
  }
  PetscCall(PCSetFromOptions(fresh));
  if (c->splits) {
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

/* Creates matrices and vectors for the present operators; for `shift` and `advecting` see
   CoupledAssemble(). */
static PetscErrorCode CoupledMake(PetscReal shift, const Vec advecting[], Coupled *c)
{
  const Scene     *scene = c->flow->scene;
  const Particles *p     = c->flow->particles;
  LinearSolve     *solve = &c->guard.solve;
  const PetscBool  anew =
      !c->velocity.flow || !SetUpHolds(&solve->setup, CoupledNumbering(c), shift);

  PetscFunctionBegin;
  PetscCall(CoupledForget(c));
  PetscCall(SaddleAssemble(c->flow, advecting, &c->saddle));
  if (c->splits) PetscCall(SchurAssemble(c->flow, &c->saddle, anew, &c->schur));
  PetscCall(UnknownsVec(p, c->saddle.n_p, &c->x));
  PetscCall(VecDuplicate(c->x, &c->b));
  PetscCall(FluidVec(p, NULL, &c->part));
  PetscCall(FluidVec(p, NULL, &c->work));
  for (PetscInt a = 0; a < scene->dim; a++) PetscCall(FluidVec(p, NULL, &c->u[a]));
  if (c->flow->ops->forms.components_coupled && c->flow->ops->forms.wall) {
    PetscCall(WallVelocityVec(p, &c->all_walls));
    PetscCall(VelocityVec(p, &c->boundary));
  }
  c->advecting = advecting;
  if (anew) solve->setup.exists = PETSC_FALSE;
  PetscCall(CoupledSetShift(shift, c));
  PetscCall(RenewPC(c));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* CoupledAssemble - Computes matrices, vectors and preconditioner for the present operators and
   step. Collective. Does nothing if operators and SaddleTime() are unchanged and no convection is
   implicit. Input: shift - shift of the first solve: the factor of u in du/dt [1/s]; advecting -
   advecting velocity of implicit convection [m/s], which must exist as long as the matrices; NULL:
   no implicit convection. */
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
