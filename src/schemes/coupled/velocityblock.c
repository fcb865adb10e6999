/*
  The preconditioner of the velocity block F + G Z of saddle.c, by the regime of the step:

    jacobi      the diagonal of F
    factors     ILU(0) of the blocks of ranks
    two_level   ILU(0), then a cycle of AMG of the pair-wise Laplacian of each component on the
                residual: iterations that do not grow with the step. Forms whose cells end at
                interfaces of fluids, or in 2D at a free surface, have LU in its place; on a
                single rank LU of the whole system takes less time, see solver.c
    splines     the diagonal of F plus the inverse of its part on splines, where F has products only
                (3D with a free surface of strain cells):

                  F^-1 ~ diag(F)^-1 + P (P^T F P)^-1 P^T,
                  P^T F P ~ T h^d/V (shift M + nu_0 K)

                with the values P of splines at particles, their products M and the stiffness K of
                a component over the volume h^d of a cell of the splines. Modes that splines lack
                are those that fits smooth, so the diagonal serves for them at every step

  The factors are those of F plus the entries of G Z that lie in its pattern: without them they do
  not hold beside free surfaces, and the other entries gain nothing. A block that repeats is a
  single scalar matrix with one preconditioner for all components, and AMG of this matrix is the
  whole second method.
*/
#include "coupled.h"
#include "splines/splines.h"

#define FACTORS "coupled_velocity_"     /* prefix of the options of the factors */
#define CYCLE   "coupled_velocity_amg_" /* and of the cycle */

/* Creates a KSP that applies a preconditioner once, and is set up only when it is told to be. */
static PetscErrorCode CreateOnce(const char prefix[], PCType type, KSP *ksp)
{
  PC pc;

  PetscFunctionBegin;
  PetscCall(KSPCreate(PETSC_COMM_WORLD, ksp));
  PetscCall(KSPSetOptionsPrefix(*ksp, prefix));
  PetscCall(KSPSetType(*ksp, KSPPREONLY));
  PetscCall(KSPGetPC(*ksp, &pc));
  PetscCall(PCSetType(pc, type));
  PetscCall(KSPSetFromOptions(*ksp));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* VelocityBlockChoose - Returns the name of the preconditioner that the regime of the step chooses,
   and whether its factors are LU */
const char *VelocityBlockChoose(const Flow *flow, PetscBool *lu)
{
  const Scene *scene = flow->scene;
  const char  *name;

  scene->regime->number[NUMBER_STIFFNESS] =
      scene->nu_high * flow->clock->dt / PetscSqr(SceneFinest(scene));
  name = RegimeWord(scene->regime, REGIME_BLOCK_PC);
  if (!flow->ops->cut_surface) {
    *lu = OperatorsCutFluids(scene, flow->ops);
    return name;
  }
  *lu = scene->dim == 2 && (!strcmp(name, "two_level") || SceneFluids(scene) > 1);
  return scene->dim == 3 ? "splines" : name;
}

/* VelocityBlockCreate - Creates the preconditioner that the regime of the step chooses; collective
   on PETSC_COMM_WORLD. Input: repeats - the block is that of a component for all of them. */
PetscErrorCode VelocityBlockCreate(const Flow *flow, PetscBool repeats, VelocityBlock *v)
{
  PetscBool jacobi, both, lu;

  PetscFunctionBegin;
  v->flow = flow;
  v->name = VelocityBlockChoose(flow, &lu);
  PetscCall(PetscStrcmp(v->name, "splines", &v->on_splines));
  jacobi = v->on_splines || !strcmp(v->name, "jacobi");
  both   = v->on_splines || (!strcmp(v->name, "two_level") && !lu);
  if (lu) {
    PetscCall(OptionDefault(FACTORS, "-sub_pc_type", PCLU));
    PetscCall(FactorDefault(FACTORS, "-sub_pc_factor_mat_solver_type"));
  }
  if (!both || !repeats) PetscCall(CreateOnce(FACTORS, jacobi ? PCJACOBI : PCBJACOBI, &v->factors));
  if (!both) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(AmgDefaults(CYCLE, "0"));
  PetscCall(CreateOnce(CYCLE, PCHYPRE, &v->cycle));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FreeVectors(VelocityBlock *v)
{
  PetscFunctionBegin;
  PetscCall(VecDestroyAll(&v->residual, &v->sums, &v->part, &v->from, &v->to));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the sums of the rows of F - T_i shift for each component alone, the largest over the
   components: what walls add to the diagonal. */
static PetscErrorCode WallDiagonal(const Saddle *s, Vec *diagonal)
{
  Vec all, sums, part;

  PetscFunctionBegin;
  PetscCall(VecDuplicate(s->time, diagonal));
  PetscCall(VecZeroEntries(*diagonal));
  PetscCall(VecDuplicate(s->time, &part));
  PetscCall(MatCreateVecs(s->F, &all, &sums));
  PetscCall(VecSetBlockSize(all, s->dim));
  PetscCall(VecSetBlockSize(sums, s->dim));
  for (PetscInt c = 0; c < s->dim; c++) {
    PetscCall(VecZeroEntries(all));
    PetscCall(VecSet(part, 1.0));
    PetscCall(VecStrideScatter(part, c, all, INSERT_VALUES));
    PetscCall(MatMult(s->F, all, sums));
    PetscCall(VecStrideGather(sums, c, part, INSERT_VALUES));
    PetscCall(VecAXPY(part, -s->step * s->shift, s->time));
    PetscCall(VecPointwiseMax(*diagonal, *diagonal, part));
  }
  PetscCall(VecDestroyAll(&sums, &all, &part));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the pair-wise matrix of T_i (shift - nu lap) of a component. */
static PetscErrorCode CreatePairs(const Saddle *s, const Flow *flow, Mat *A)
{
  const Particles *p = flow->particles;
  Vec              diagonal, row;

  PetscFunctionBegin;
  PetscCall(WallDiagonal(s, &diagonal));
  PetscCall(VecAXPY(diagonal, s->step * s->shift, s->time));
  PetscCall(VecDuplicate(s->time, &row));
  PetscCall(VecPointwiseDivide(row, s->time, s->length));
  PetscCall(VecPointwiseDivide(row, row, s->length));
  PetscCall(VecScale(row, s->step / PetscSqr(flow->scene->dx) * (p->nu ? 1.0 : flow->scene->nu)));
  PetscCall(PairLaplacian(flow, row, p->nu, diagonal, A));
  PetscCall(VecDestroyAll(&row, &diagonal));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the matrix of a component on splines. */
static PetscErrorCode CreateOnSplines(const Saddle *s, const Flow *flow, Mat *A)
{
  const Splines  *sp   = flow->scheme->splines;
  const PetscReal cell = PetscPowReal(sp->scale, (PetscReal)s->dim);

  PetscFunctionBegin;
  PetscCall(MatDuplicate(sp->joint ? sp->joint : sp->M, MAT_COPY_VALUES,
                         A)); /* splines that are no unknowns have 1 */
  PetscCall(MatScale(*A, s->shift));
  PetscCall(MatAXPY(*A, s->nu, sp->slopes, DIFFERENT_NONZERO_PATTERN));
  PetscCall(MatScale(*A, s->step * cell / flow->particles->cell_volume));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets up the cycle of AMG. */
static PetscErrorCode SetUpCycle(const Saddle *s, VelocityBlock *v)
{
  Mat A;

  PetscFunctionBegin;
  if (v->on_splines) {
    PetscCall(CreateOnSplines(s, v->flow, &A));
  } else if (s->component) {
    A = s->component;
    PetscCall(PetscObjectReference((PetscObject)A));
  } else {
    PetscCall(CreatePairs(s, v->flow, &A));
  }
  PetscCall(KSPReset(v->cycle));
  PetscCall(KSPSetOperators(v->cycle, A, A));
  PetscCall(KSPSetUp(v->cycle));
  PetscCall(MatDestroy(&A));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets up the factors. */
static PetscErrorCode SetUpFactors(const Saddle *s, VelocityBlock *v)
{
  const Mat F = s->component ? s->component : s->F;

  PetscFunctionBegin;
  PetscCall(KSPReset(v->factors));
  PetscCall(KSPSetOperators(v->factors, F, F));
  PetscCall(KSPSetUp(v->factors));
  PetscCall(KSPSetUpOnBlocks(v->factors));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the work vectors anew: the particles of this rank may have changed. */
static PetscErrorCode RenewVectors(const Saddle *s, VelocityBlock *v)
{
  PetscFunctionBegin;
  PetscCall(FreeVectors(v));
  PetscCall(VecDuplicate(s->time, &v->from));
  PetscCall(VecDuplicate(s->time, &v->to));
  if (v->on_splines) PetscCall(MatCreateVecs(v->flow->scheme->splines->slopes, &v->sums, &v->part));
  if (v->on_splines || !v->cycle || s->component) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MatCreateVecs(s->F, NULL, &v->residual));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* VelocityBlockSetUp - Sets the preconditioner up for the present blocks; collective */
PetscErrorCode VelocityBlockSetUp(const Saddle *s, VelocityBlock *v)
{
  PetscFunctionBegin;
  PetscCall(RenewVectors(s, v));
  if (v->factors) PetscCall(SetUpFactors(s, v));
  if (v->cycle) PetscCall(SetUpCycle(s, v));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Applies the KSP of scalar systems to each component of x, and adds the result to y. */
static PetscErrorCode ApplyToComponents(KSP ksp, const VelocityBlock *v, Vec x, Vec y)
{
  const PetscInt dim = v->saddle->dim;

  PetscFunctionBegin;
  PetscCall(VecSetBlockSize(x, dim));
  PetscCall(VecSetBlockSize(y, dim));
  for (PetscInt c = 0; c < dim; c++) {
    PetscCall(VecStrideGather(x, c, v->from, INSERT_VALUES));
    PetscCall(KSPSolve(ksp, v->from, v->to));
    PetscCall(VecStrideScatter(v->to, c, y, ADD_VALUES));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the residual x - F y. */
static PetscErrorCode Residual(const VelocityBlock *v, Vec x, Vec y)
{
  const Saddle *s = v->saddle;

  PetscFunctionBegin;
  PetscCall(MatMult(s->F, y, v->residual));
  PetscCall(VecAYPX(v->residual, -1.0, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the part on splines of each component of x to y. */
static PetscErrorCode AddOnSplines(const VelocityBlock *v, Vec x, Vec y)
{
  const Mat      P   = v->flow->scheme->splines->values;
  const PetscInt dim = v->saddle->dim;

  PetscFunctionBegin;
  PetscCall(VecSetBlockSize(x, dim));
  PetscCall(VecSetBlockSize(y, dim));
  for (PetscInt c = 0; c < dim; c++) {
    PetscCall(VecStrideGather(x, c, v->from, INSERT_VALUES));
    PetscCall(MatMultTranspose(P, v->from, v->sums));
    PetscCall(KSPSolve(v->cycle, v->sums, v->part));
    PetscCall(MatMult(P, v->part, v->to));
    PetscCall(VecStrideScatter(v->to, c, y, ADD_VALUES));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Velocity_Apply(PC pc, Vec x, Vec y)
{
  VelocityBlock *v;

  PetscFunctionBegin;
  PetscCall(PCShellGetContext(pc, &v));
  if (v->saddle->component) {
    PetscCall(VecZeroEntries(y));
    PetscCall(ApplyToComponents(v->factors ? v->factors : v->cycle, v, x, y));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(KSPSolve(v->factors, x, y));
  if (v->on_splines) PetscCall(AddOnSplines(v, x, y));
  if (v->on_splines || !v->cycle) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Residual(v, x, y));
  PetscCall(ApplyToComponents(v->cycle, v, v->residual, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* VelocityBlockAttach - Sets the preconditioner as the shell of the velocity block; collective */
PetscErrorCode VelocityBlockAttach(PC fieldsplit, const Saddle *s, VelocityBlock *v)
{
  PetscFunctionBegin;
  v->saddle = s;
  PetscCall(SolverAttachShell(fieldsplit, 0, v->name, v, Velocity_Apply));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* VelocityBlockFree - Frees the solvers; collective */
PetscErrorCode VelocityBlockFree(VelocityBlock *v)
{
  PetscFunctionBegin;
  PetscCall(FreeVectors(v));
  PetscCall(KSPDestroy(&v->factors));
  PetscCall(KSPDestroy(&v->cycle));
  PetscFunctionReturn(PETSC_SUCCESS);
}
