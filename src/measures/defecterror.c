/*
  The error of the velocity that a defect makes: the solution e of a Stokes problem on compact rows,

    e/T - div(2 nu E(e)) + grad q = -r,   div e = -d,   e = 0 where a boundary gives the velocity,

  at the age T of the flow; a steady solve has no 1/T. The pressure is split off:

    r' = r - G phi,   N phi = G^T V r,   N = G^T V G       r' is orthogonal to all gradients
    V (1/T + K) v = -V r'                                  for each component
    V K_1 psi = -V d,   e = v + G psi

  K is the pairwise Laplacian with the viscosity of the pair, and K_1 that of viscosity 1 without
  walls. All systems are symmetric, and solved by conjugate gradients to one per cent, which is
  enough for an estimate. See theory.md, (forces:error).
*/
#include "defect.h"

#define RTOL 1e-2 /* of the solves [-] */
#define MOST 2000 /* iterations */
#define SLOW 1e-6 /* shift of K_1 [1/L^2] */

/* Gradients and their normal equations. */
typedef struct {
  PetscInt dim;
  Mat      G[ISPH_MAX_DIM], N;
  Vec      volume, diagonal, slope, product;
} Gradients;

/* Computes y = N f. */
static PetscErrorCode NormalMult(Mat N, Vec f, Vec y)
{
  Gradients *g;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(N, &g));
  PetscCall(VecZeroEntries(y));
  for (PetscInt a = 0; a < g->dim; a++) {
    PetscCall(MatMult(g->G[a], f, g->slope));
    PetscCall(VecPointwiseMult(g->slope, g->slope, g->volume));
    PetscCall(MatMultTranspose(g->G[a], g->slope, g->product));
    PetscCall(VecAXPY(y, 1.0, g->product));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode NormalDiagonal(Mat N, Vec diagonal)
{
  Gradients *g;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(N, &g));
  PetscCall(VecCopy(g->diagonal, diagonal));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates a matrix of compact rows, with their room. */
static PetscErrorCode CreateMatrix(const Particles *p, const CompactRows *rows, Mat *A)
{
  const PetscInt first = p->fluid_start, last = first + p->n_fluid;
  PetscInt      *own, *other; /* entries of a row in columns of this rank, and of others */

  PetscFunctionBegin;
  PetscCall(PetscCalloc2(p->n_fluid, &own, p->n_fluid, &other));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    for (PetscInt k = rows->row[i]; k < rows->row[i + 1]; k++) {
      const PetscInt column = p->row[rows->col[k]];

      if (column < first || column >= last) other[i]++;
    }
    own[i] = rows->row[i + 1] - rows->row[i] + 1 - other[i];
  }
  PetscCall(MatCreate(p->comm, A));
  PetscCall(MatSetSizes(*A, p->n_fluid, p->n_fluid, PETSC_DETERMINE, PETSC_DETERMINE));
  PetscCall(MatSetType(*A, MATAIJ));
  PetscCall(MatXAIJSetPreallocation(*A, 1, own, other, NULL, NULL));
  PetscCall(PetscFree2(own, other));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Assemble(Mat A)
{
  PetscFunctionBegin;
  PetscCall(MatAssemblyBegin(A, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(A, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the rows of d/dx_a. */
static PetscErrorCode SetGradient(const Flow *flow, const CompactRows *rows, PetscInt a, Mat G)
{
  const Particles *p = flow->particles;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscReal own = 0.0;

    for (PetscInt k = rows->row[i]; k < rows->row[i + 1]; k++) {
      own -= rows->slope[a][k];
      PetscCall(MatSetValue(G, p->row[i], p->row[rows->col[k]], rows->slope[a][k], ADD_VALUES));
    }
    PetscCall(MatSetValue(G, p->row[i], p->row[i], own, ADD_VALUES));
  }
  PetscCall(Assemble(G));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets volumes, and about the diagonal of N for a preconditioner: sum_j slope_ij^2 V_i. */
static PetscErrorCode SetDiagonal(const Particles *p, const CompactRows *rows, Gradients *g)
{
  PetscScalar *volume, *diagonal;

  PetscFunctionBegin;
  PetscCall(VecGetArrayWrite(g->volume, &volume));
  PetscCall(VecGetArrayWrite(g->diagonal, &diagonal));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscReal sum = 0.0;

    for (PetscInt a = 0; a < p->dim; a++)
      for (PetscInt k = rows->row[i]; k < rows->row[i + 1]; k++) sum += PetscSqr(rows->slope[a][k]);
    volume[i]   = ParticlesWeight(p, i);
    diagonal[i] = sum > 0.0 ? volume[i] * sum : 1.0;
  }
  PetscCall(VecRestoreArrayWrite(g->diagonal, &diagonal));
  PetscCall(VecRestoreArrayWrite(g->volume, &volume));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the gradients from the slopes of compact rows, and frees these. */
static PetscErrorCode GradientsCreate(const Flow *flow, CompactRows *rows, Gradients *g)
{
  const Particles *p = flow->particles;

  PetscFunctionBegin;
  *g = (Gradients){.dim = p->dim};
  PetscCall(FluidVec(p, NULL, &g->volume));
  PetscCall(VecDuplicate(g->volume, &g->diagonal));
  PetscCall(VecDuplicate(g->volume, &g->slope));
  PetscCall(VecDuplicate(g->volume, &g->product));
  PetscCall(SetDiagonal(p, rows, g));
  for (PetscInt a = 0; a < p->dim; a++) {
    PetscCall(CreateMatrix(p, rows, &g->G[a]));
    PetscCall(SetGradient(flow, rows, a, g->G[a]));
    PetscCall(PetscFree(rows->slope[a]));
  }
  PetscCall(
      MatCreateShell(p->comm, p->n_fluid, p->n_fluid, PETSC_DETERMINE, PETSC_DETERMINE, g, &g->N));
  PetscCall(MatShellSetOperation(g->N, MATOP_MULT, (void (*)(void))NormalMult));
  PetscCall(MatShellSetOperation(g->N, MATOP_GET_DIAGONAL, (void (*)(void))NormalDiagonal));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode GradientsDestroy(Gradients *g)
{
  PetscFunctionBegin;
  for (PetscInt a = 0; a < g->dim; a++) PetscCall(MatDestroy(&g->G[a]));
  PetscCall(VecDestroyAll(&g->volume, &g->diagonal, &g->slope, &g->product));
  PetscCall(MatDestroy(&g->N));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Solves A x = b by conjugate gradients. */
static PetscErrorCode Solve(MPI_Comm comm, Mat A, Vec b, Vec x)
{
  KSP ksp;
  PC  pc;

  PetscFunctionBegin;
  PetscCall(KSPCreate(comm, &ksp));
  PetscCall(KSPSetOperators(ksp, A, A));
  PetscCall(KSPSetType(ksp, KSPCG));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PCSetType(pc, PCJACOBI));
  PetscCall(KSPSetTolerances(ksp, RTOL, PETSC_DEFAULT, PETSC_DEFAULT, MOST));
  PetscCall(KSPSolve(ksp, b, x));
  PetscCall(KSPDestroy(&ksp));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates V (rate + K); nu NULL: K_1, with the viscosity 1 and without walls. */
static PetscErrorCode CreateLaplacian(const Particles *p, const CompactRows *rows,
                                      const PetscReal *nu, PetscReal rate, Mat *A)
{
  PetscFunctionBegin;
  PetscCall(CreateMatrix(p, rows, A));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    const PetscReal V   = ParticlesWeight(p, i);
    PetscReal       own = V * rate;

    if (nu) own += V * 2.0 * nu[i] * rows->wall[i];
    for (PetscInt k = rows->row[i]; k < rows->row[i + 1]; k++) {
      const PetscInt j = rows->col[k];
      PetscReal      F = rows->conductance[k];

      if (nu) F *= nu[i] > 0.0 && nu[j] > 0.0 ? PairViscosity(nu[i], nu[j]) : 0.0;
      PetscCall(MatSetValue(*A, p->row[i], p->row[j], -F, ADD_VALUES));
      own += F;
    }
    PetscCall(MatSetValue(*A, p->row[i], p->row[i], own, ADD_VALUES));
  }
  PetscCall(Assemble(*A));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Copies values of own fluid to a vector. */
static PetscErrorCode SetVec(const Particles *p, const PetscReal from[], Vec v)
{
  PetscScalar *value;

  PetscFunctionBegin;
  PetscCall(VecGetArrayWrite(v, &value));
  for (PetscInt i = 0; i < p->n_fluid; i++) value[i] = from[i];
  PetscCall(VecRestoreArrayWrite(v, &value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets r[] to the part of the residual of the momentum that is orthogonal to all gradients. */
static PetscErrorCode ProjectMomentum(const Flow *flow, const Defect *d, const Gradients *g,
                                      Vec r[])
{
  const Particles *p = flow->particles;
  Vec              b, phi;

  PetscFunctionBegin;
  PetscCall(VecDuplicate(g->volume, &b));
  PetscCall(VecDuplicate(g->volume, &phi));
  PetscCall(VecZeroEntries(b));
  for (PetscInt a = 0; a < p->dim; a++) {
    PetscCall(SetVec(p, d->momentum[a], r[a]));
    PetscCall(VecPointwiseMult(g->slope, r[a], g->volume));
    PetscCall(MatMultTransposeAdd(g->G[a], g->slope, b, b));
  }
  PetscCall(VecZeroEntries(phi));
  PetscCall(Solve(p->comm, g->N, b, phi));
  for (PetscInt a = 0; a < p->dim; a++) {
    PetscCall(MatMult(g->G[a], phi, g->slope));
    PetscCall(VecAXPY(r[a], -1.0, g->slope));
    if (SceneKeepsMomentum(flow->scene)) PetscCall(FluidRemoveMean(p, r[a]));
  }
  PetscCall(VecDestroyAll(&b, &phi));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes psi, whose gradient has the divergence -d. */
static PetscErrorCode SolveMass(const Flow *flow, const Defect *d, const Gradients *g, Vec psi)
{
  const Particles *p     = flow->particles;
  const PetscReal  shift = SLOW / PetscSqr(flow->scene->length);
  Mat              K;
  Vec              b;

  PetscFunctionBegin;
  PetscCall(VecDuplicate(psi, &b));
  PetscCall(SetVec(p, d->mass, b));
  PetscCall(FluidRemoveMean(p, b));
  PetscCall(VecPointwiseMult(b, b, g->volume));
  PetscCall(CreateLaplacian(p, &d->rows, NULL, shift, &K));
  PetscCall(VecZeroEntries(psi));
  PetscCall(Solve(p->comm, K, b, psi));
  PetscCall(MatDestroy(&K));
  PetscCall(VecDestroy(&b));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* DefectError - Computes the root mean square of the error e of the velocity [m/s], and frees the
   slopes of d. Collective. Input: rate - 1/T [1/s]. */
PetscErrorCode DefectError(const Flow *flow, PetscReal rate, Defect *d, PetscReal *error)
{
  const Particles *p   = flow->particles;
  PetscReal        sum = 0.0, part;
  Gradients        g;
  Mat              K;
  Vec              r[ISPH_MAX_DIM], e, psi;

  PetscFunctionBegin;
  PetscCall(GradientsCreate(flow, &d->rows, &g));
  for (PetscInt a = 0; a < p->dim; a++) PetscCall(VecDuplicate(g.volume, &r[a]));
  PetscCall(VecDuplicate(g.volume, &e));
  PetscCall(VecDuplicate(g.volume, &psi));
  PetscCall(ProjectMomentum(flow, d, &g, r));
  PetscCall(SolveMass(flow, d, &g, psi));
  PetscCall(CreateLaplacian(p, &d->rows, d->nu, rate, &K));
  for (PetscInt a = 0; a < p->dim; a++) {
    PetscCall(VecPointwiseMult(r[a], r[a], g.volume));
    PetscCall(VecScale(r[a], -1.0));
    PetscCall(VecZeroEntries(e));
    PetscCall(Solve(p->comm, K, r[a], e));
    PetscCall(MatMult(g.G[a], psi, g.slope));
    PetscCall(VecAXPY(e, 1.0, g.slope));
    PetscCall(FluidSum(p, e, PETSC_TRUE, &part));
    sum += part;
    PetscCall(VecDestroy(&r[a]));
  }
  *error = PetscSqrtReal(sum / p->weight);
  PetscCall(MatDestroy(&K));
  PetscCall(VecDestroyAll(&e, &psi));
  PetscCall(GradientsDestroy(&g));
  PetscFunctionReturn(PETSC_SUCCESS);
}
