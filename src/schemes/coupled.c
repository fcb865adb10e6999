/*
  Velocity and pressure in one system,

    du/dt = nu lap u - (v.grad) u - grad p/rho + f,   div u = 0,

  differential-algebraic, its Jacobian that of saddle.c: advanced by a PETSc TS, or solved for
  without du/dt where the flow is steady. The pressure is no part of the history and has no
  splitting error.
*/
#include "coupled.h"

static const CoupledIntegratorRow kinds[] = {
    /* name, brief, citation, several substeps */
    {TSBEULER,
     "backward Euler, from (4u^n - u^{n-1})/3 over 2dt/3: BDF2 with the history on particles",
     "Hairer & Wanner, Solving ODEs II (1996)", PETSC_FALSE},
    {TSROSW, "Rosenbrock-W of order 3 in substeps that follow the error; particles fixed",
     "Rang & Angermann, BIT 45 (2005)", PETSC_TRUE},
    {TSBDF, "backward differentiation in substeps that follow the error; particles fixed",
     "Hairer & Wanner, Solving ODEs II (1996)", PETSC_TRUE},
};
const Table CoupledIntegratorTable =
    TABLE("-coupled_ts_type", "Time integrators of the coupled scheme", kinds);

/* CoupledSetShift - The matrix with a shift; the preconditioner of one within 3/2 of it is kept */
PetscErrorCode CoupledSetShift(PetscReal shift, Coupled *c)
{
  const PetscBool keep = shift <= 1.5 * c->shift && c->shift <= 1.5 * shift;

  PetscFunctionBegin;
  PetscCall(SaddleSetShift(shift, &c->saddle));
  if (!keep && c->flat) PetscCall(SaddleFlatten(c->saddle.P, &c->flat));
  if (!keep) c->shift = shift;
  PetscCall(KSPSetReusePreconditioner(c->ksp, keep));
  c->schur.viscous = c->scene->nu * c->saddle.step / PetscSqr(c->scene->dx);
  c->schur.inert   = shift * c->saddle.step;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  What the blocks of the field split are solved with unless the user tells: one application of block
  Jacobi to velocities where nu dt/dx^2 is below 2, else of AMG, and one of schur.c to pressures.
*/
static PetscErrorCode BlockDefaults(const Scene *scene, PetscReal dt)
{
  const char *velocity = scene->nu * dt / PetscSqr(scene->dx) < 2.0 ? PCBJACOBI : PCHYPRE;

  PetscFunctionBegin;
  PetscCall(OptionDefault("coupled_fieldsplit_velocity_", "-ksp_type", KSPPREONLY));
  PetscCall(OptionDefault("coupled_fieldsplit_velocity_", "-pc_type", velocity));
  PetscCall(AmgDefaults("coupled_fieldsplit_velocity_", "0"));
  PetscCall(OptionDefault("coupled_fieldsplit_pressure_", "-ksp_type", KSPPREONLY));
  PetscCall(OptionDefault("coupled_fieldsplit_pressure_", "-pc_type", PCSHELL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The TS, its SNES and KSP, from the options. */
static PetscErrorCode CoupledCreateTS(Coupled *c)
{
  SNES    snes;
  TSAdapt adapt;
  PC      pc;

  PetscFunctionBegin;
  PetscCall(TSCreate(PETSC_COMM_WORLD, &c->ts));
  PetscCall(TSSetOptionsPrefix(c->ts, "coupled_"));
  PetscCall(TSSetProblemType(c->ts, c->convects ? TS_NONLINEAR : TS_LINEAR));
  PetscCall(TSSetType(c->ts, c->row->name));
  PetscCall(TSSetEquationType(c->ts, TS_EQ_DAE_IMPLICIT_INDEX2));
  PetscCall(TSSetExactFinalTime(c->ts, TS_EXACTFINALTIME_STEPOVER));
  PetscCall(TSSetMaxSteps(c->ts, PETSC_MAX_INT - 1));
  PetscCall(TSSetMaxTime(c->ts, PETSC_MAX_REAL));
  PetscCall(TSSetErrorIfStepFails(c->ts, PETSC_FALSE));
  PetscCall(TSSetIFunction(c->ts, NULL, CoupledIFunction, c));
  PetscCall(TSGetAdapt(c->ts, &adapt));
  PetscCall(TSAdaptSetType(adapt, c->row->substeps ? TSADAPTBASIC : TSADAPTNONE));
  PetscCall(TSGetSNES(c->ts, &snes));
  PetscCall(SNESSetMaxLinearSolveFailures(snes, PETSC_MAX_INT)); /* the guard sees to those */
  PetscCall(SNESGetKSP(snes, &c->ksp));
  PetscCall(KSPSetType(c->ksp, KSPFGMRES));
  PetscCall(KSPGMRESSetRestart(c->ksp, 100));
  PetscCall(KSPSetTolerances(c->ksp, 1e-7, 0.0, PETSC_DEFAULT, 300));
  PetscCall(KSPGetPC(c->ksp, &pc));
  PetscCall(PCSetType(pc, PCFIELDSPLIT));
  PetscCall(TSSetFromOptions(c->ts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  CoupledCreate - The solver of velocity and pressure together

  Collective on PETSC_COMM_WORLD.

  Input Parameters:
+ dt       - first time step, for the choice of a preconditioner [s]
- convects - particles stay, so that u.grad u is part of the equations

  Options Database Keys:
+ -coupled_ts_type, -coupled_schur - rows of their tables
. -coupled_ksp_type, -coupled_pc_type, -coupled_pc_fieldsplit_..., -coupled_ts_... - any of PETSc's
. -coupled_fieldsplit_velocity_..., -coupled_fieldsplit_pressure_... - KSP and PC of the blocks
- -coupled_schur_ksp_type, -coupled_schur_pc_type, ... - of the Poisson equation in cahouet_chabard

  Errors: options that would give time to the TS, and absolute tolerances
*/
PetscErrorCode CoupledCreate(const Scene *scene, PetscReal dt, PetscBool convects,
                             Coupled **coupled)
{
  Coupled  *c;
  char      type[32] = PCFIELDSPLIT;
  PetscBool given, split, lu;

  PetscFunctionBegin;
  PetscCall(PetscNew(&c));
  PetscCall(PetscOptionsGetString(NULL, "coupled_", "-pc_type", type, sizeof(type), NULL));
  PetscCall(PetscStrcmp(type, PCFIELDSPLIT, &split));
  PetscCall(PetscStrcmp(type, PCLU, &lu));
  c->guard.what   = "coupled";
  c->guard.prefix = "coupled_";
  c->guard.remedy = lu ? "try a larger -coupled_ksp_max_it, or a smaller -dt"
                       : "try -coupled_pc_type lu, a larger -coupled_ksp_max_it, or a smaller -dt";
  if (split) PetscCall(BlockDefaults(scene, dt));
  PetscOptionsBegin(PETSC_COMM_WORLD, NULL, "Coupled scheme", "");
  PetscCall(TableSelect(&CoupledIntegratorTable, "-coupled_ts_type",
                        "Time integrator of the coupled scheme", TSBEULER, &c->row));
  if (split) {
    PetscCall(TableSelect(&SchurTable, "-coupled_schur",
                          "Preconditioner of the pressure in the coupled scheme", "cahouet_chabard",
                          &c->schur.row));
  }
  PetscOptionsEnd();
  PetscCall(TimeOptionsRefuse("coupled_", c->row->name));
  PetscCall(OptionGiven("-coupled_ts_atol", &given));
  UserCheck(!given, "-coupled_ts_atol: an absolute tolerance depends on units; use "
                    "-coupled_ts_rtol, of |u| + U");
  if (split) PetscCall(SchurCreate(&c->schur));
  c->convects = convects && c->row->substeps;
  PetscCall(CoupledCreateTS(c));
  PetscCall(GuardAttach(c->ksp, NULL, &c->guard));
  *coupled = c;
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
  PetscCall(MatDestroy(&c->flat));
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) PetscCall(VecDestroy(&c->u[a]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CoupledDestroy(Coupled **coupled)
{
  PetscFunctionBegin;
  if (!*coupled) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(CoupledFree(*coupled));
  PetscCall(SchurFree(&(*coupled)->schur));
  PetscCall(GuardDetach(&(*coupled)->guard));
  PetscCall(TSDestroy(&(*coupled)->ts));
  PetscCall(PetscFree(*coupled));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A field split keeps the sizes and blocks it was made for: a fresh one, of the user's options. */
static PetscErrorCode RenewPC(Coupled *c)
{
  PetscBool split;
  IS        rows[2];
  PC        pc, fresh;
  PCType    type;

  PetscFunctionBegin;
  PetscCall(KSPGetPC(c->ksp, &pc));
  PetscCall(PCGetType(pc, &type));
  PetscCall(PetscObjectTypeCompare((PetscObject)pc, PCFIELDSPLIT, &split));
  PetscCall(PCCreate(PetscObjectComm((PetscObject)c->ksp), &fresh));
  PetscCall(PCSetOptionsPrefix(fresh, "coupled_"));
  PetscCall(PCSetType(fresh, type));
  PetscCall(PCSetUseAmat(fresh, PETSC_FALSE));
  PetscCall(KSPSetPC(c->ksp, fresh));
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
    PetscCall(KSPSetOperators(c->ksp, c->saddle.A, c->saddle.P));
    PetscCall(PCSetUp(fresh));
    PetscCall(SchurAttach(fresh, &c->schur));
  } else {
    PetscCall(SaddleFlatten(c->saddle.P, &c->flat));
  }
  PetscCall(PCDestroy(&fresh));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  T, the time in which momentum changes a velocity of the grid's scale: 1/T = 1/(4 dt) + nu/dx^2.
  The quarter makes C weigh against inertia as it does against viscosity; of 1, 1/3, 1/6, 1/12, 1/24
  those about it take the fewest iterations, and moving vortices at Re = 100 half the error that 1
  has. dt is rounded to eighths of a power of two, so that steps that differ by rounding share their
  matrices.
*/
static PetscReal GridTime(const Scene *scene, PetscReal dt, PetscBool steady)
{
  const PetscReal diffusion = scene->nu / PetscSqr(scene->dx);
  int             exponent;

  if (steady) return 1.0 / diffusion;
  dt = PetscFloorReal(8.0 * frexp(dt, &exponent) + 0.5) / 8.0;
  return 1.0 / (0.25 / ldexp(dt, exponent) + diffusion);
}

/*
  The error that substeps may make: -coupled_ts_rtol times |u| + U. Of the pressure none is asked:
  it is no part of the history, and jumps where walls do.
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
  PetscCall(TSSetTolerances(c->ts, PETSC_DECIDE, atol, PETSC_DECIDE, NULL));
  PetscCall(VecDestroy(&atol));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Matrices and vectors for the operators as they are now. */
static PetscErrorCode CoupledMake(PetscReal step, PetscReal shift, const Vec advecting[],
                                  Coupled *c)
{
  const Scene     *scene = c->scene;
  const Particles *p     = c->particles;

  PetscFunctionBegin;
  PetscCall(TSReset(c->ts));
  PetscCall(CoupledFree(c));
  PetscCall(SaddleAssemble(scene, p, c->ops, step, advecting, &c->saddle));
  if (c->schur.row) PetscCall(SchurAssemble(p, c->ops, &c->schur));
  PetscCall(MatCreateVecs(c->saddle.A, &c->x, &c->b));
  PetscCall(SetTolerances(scene, c));
  PetscCall(FluidVec(p, NULL, &c->part));
  PetscCall(FluidVec(p, NULL, &c->work));
  for (PetscInt a = 0; a < scene->dim; a++) PetscCall(FluidVec(p, NULL, &c->u[a]));
  c->shift     = NAN;
  c->b_t       = NAN;
  c->advecting = advecting;
  PetscCall(CoupledSetShift(shift, c));
  PetscCall(RenewPC(c));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  CoupledAssemble - Matrices, vectors and preconditioner for the operators and a step

  Collective. Keeps what is there where it is of the same operators and T, and nothing is advected.

  Input Parameters:
+ clock     - its dt, or that the flow is steady
. shift     - the first [1/s]
- advecting - v of implicit convection, to stay as long as the matrices do; NULL: none [m/s]
*/
PetscErrorCode CoupledAssemble(const Clock *clock, PetscReal shift, const Vec advecting[],
                               Coupled *c)
{
  const PetscReal step = GridTime(c->scene, clock->dt, clock->steady_solve);
  const PetscBool same = c->saddle.A && c->saddle.assemblies == c->ops->assemblies;

  PetscFunctionBegin;
  if (!same || advecting || c->advecting || step != c->saddle.step)
    PetscCall(CoupledMake(step, shift, advecting, c));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* CoupledNames - Types of the TS, KSP and preconditioner; not collective */
PetscErrorCode CoupledNames(const Coupled *c, const char **ts, const char **ksp, const char **pc)
{
  PetscFunctionBegin;
  *ts = c->row->name;
  PetscCall(SolverNames(c->ksp, ksp, pc));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const CoupledIntegratorRow *CoupledIntegrator(const Coupled *c)
{
  return c->row;
}

const SchurRow *CoupledSchur(const Coupled *c)
{
  return c->schur.row;
}

/* CoupledFalls - How many solves the fallback ladder has made */
PetscInt *CoupledFalls(Coupled *c)
{
  return &c->guard.falls;
}

/* CoupledNote - What is unwise in the choice of solver, or "" */
const char *CoupledNote(const Coupled *c)
{
  return c->guard.note;
}

/* CoupledIterations - KSP iterations of the last step, all its solves together */
PetscInt CoupledIterations(const Coupled *c)
{
  return c->iterations;
}
