/*
  The pressure Poisson equation. If the constant of the pressure is undetermined, the matrix A of
  the Laplacian L is singular. A regular system is solved instead, to a small true residual for
  every form:

    (A + c c^T) phi = b,   A = -dx_i^2 L,   c of GaugeColumn(),   preconditioner from A + 1e-6 I

  The rank-one term c c^T fixes the mean of phi, and subtracts from b the uniform source for which
  no phi exists. (The left null vector of an unsymmetric L is not constant.) If a boundary gives the
  pressure, the system is A phi = b.
*/
#include "splines.h"

struct Pressure {
  Guard    guard;
  Mat      preconditioner; /* of GaugePreconditioner() at the last set-up */
  Mat      gauge;          /* c; NULL: the pressure is determined */
  PetscInt assemblies;     /* stamp of the operators that the KSP has */
  PetscInt numbering;      /* stamp of the last set-up */
  PetscInt its_new;        /* iterations of the first solve after a set-up */
};

/*
  PressureCreate - Creates the KSP of the pressure equation and adds its solve to the scheme

  Collective on PETSC_COMM_WORLD.

  Options Database Keys:
. -ppe_ksp_type, -ppe_pc_type, ... - PETSc's options, see PoissonSolver()
*/
PetscErrorCode PressureCreate(Flow *flow, Pressure **ppe)
{
  Pressure *s;

  PetscFunctionBegin;
  PetscCall(PetscNew(&s));
  s->guard.solve = (LinearSolve){
      .name = "pressure", .label = "ppe solver", .prefix = "ppe_", .column = SOLVE_PRESSURE};
  PetscCall(PoissonSolver(
      ((Projection *)flow->scheme->data)->splines ? NULL : &flow->ops->forms.ppe, 1e-5, &s->guard));
  PetscCall(SolverMatType("ppe_", s->guard.mat_type, sizeof(s->guard.mat_type)));
  PetscCall(SchemeAddSolve(&s->guard.solve, flow->scheme));
  *ppe = s;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* PressureDestroy - Frees the KSP and its matrices; collective */
PetscErrorCode PressureDestroy(Pressure **ppe)
{
  PetscFunctionBegin;
  if (!*ppe) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(GuardDetach(&(*ppe)->guard));
  PetscCall(KSPDestroy(&(*ppe)->guard.solve.ksp));
  PetscCall(MatDestroy(&(*ppe)->preconditioner));
  PetscCall(MatDestroy(&(*ppe)->gauge));
  PetscCall(PetscFree(*ppe));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The matrices of the equation: on particles or on splines. */
typedef struct {
  Mat       A, P;                  /* without gauge; P: for the preconditioner */
  PetscBool lasting;               /* P stays the same until unknowns are renumbered */
  PetscInt  assemblies, numbering; /* stamps of A, and of the numbers of the unknowns */
} PressureMatrices;

static PetscErrorCode GetMatrices(Flow *flow, PressureMatrices *m)
{
  const Operators *ops = flow->ops;
  Splines         *sp  = ((Projection *)flow->scheme->data)->splines;

  PetscFunctionBegin;
  if (!sp) {
    *m = (PressureMatrices){ops->ppe.A, ops->ppe.A, PETSC_FALSE, ops->assemblies,
                            flow->particles->epoch};
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SplinesMatrix(flow, sp));
  *m = (PressureMatrices){sp->A, sp->K, PETSC_TRUE, sp->assemblies, sp->numbering};
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Resets the KSP, and creates the column c for the present numbering. */
static PetscErrorCode PressureRenumber(const Scene *scene, const PressureMatrices *m, Pressure *s)
{
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(KSPReset(s->guard.solve.ksp));
  PetscCall(MatDestroy(&s->preconditioner));
  PetscCall(MatDestroy(&s->gauge));
  PetscCall(MatGetLocalSize(m->P, &n, NULL));
  PetscCall(GaugeColumn(scene, PetscObjectComm((PetscObject)m->P), 0, n, &s->gauge));
  s->numbering = m->numbering;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes the regular matrix; copies A only if the user chose a matrix type. */
static PetscErrorCode PressureOperator(const PressureMatrices *m, const Pressure *s, Mat *A)
{
  PetscBool same;
  Mat       copy = m->A;

  PetscFunctionBegin;
  PetscCall(PetscStrcmp(s->guard.mat_type, MATSAME, &same));
  if (m->lasting) same = PETSC_TRUE; /* a shell */
  if (!same) PetscCall(MatConvert(m->A, s->guard.mat_type, MAT_INITIAL_MATRIX, &copy));
  PetscCall(GaugeMatrix(copy, s->gauge, A));
  if (!same) PetscCall(MatDestroy(&copy));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Gives new matrices to the KSP. The preconditioner is reused until unknowns are renumbered or the
  iterations have grown by half: displacements change it little, but a renumbering invalidates it.
*/
static PetscErrorCode PressureUpdateMatrices(Flow *flow, Pressure *s)
{
  const KSP        ksp     = s->guard.solve.ksp;
  const PetscInt   its     = s->guard.solve.iterations;
  PetscBool        rebuild = its > s->its_new + s->its_new / 2 + 2 ? PETSC_TRUE : PETSC_FALSE;
  PressureMatrices m       = {0};
  Mat              A;

  PetscFunctionBegin;
  PetscCall(GetMatrices(flow, &m));
  if (s->assemblies == m.assemblies) PetscFunctionReturn(PETSC_SUCCESS);
  if (m.lasting) rebuild = PETSC_FALSE;
  if (s->numbering != m.numbering) {
    PetscCall(PressureRenumber(flow->scene, &m, s));
    rebuild = PETSC_TRUE;
  }
  if (rebuild) {
    PetscCall(SolverRenewPC(ksp));
    PetscCall(MatDestroy(&s->preconditioner));
    PetscCall(MatConvert(m.P, s->guard.mat_type, MAT_INITIAL_MATRIX, &s->preconditioner));
    PetscCall(GaugePreconditioner(flow->scene, s->preconditioner));
    s->its_new = 0;
  }
  PetscCall(PressureOperator(&m, s, &A));
  PetscCall(KSPSetReusePreconditioner(ksp, rebuild ? PETSC_FALSE : PETSC_TRUE));
  PetscCall(KSPSetOperators(ksp, A, s->preconditioner));
  PetscCall(MatDestroy(&A));
  s->assemblies = m.assemblies;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  PressureSolve - Solves A phi = b, A = -dx_i^2 lap, for the pressure increment phi

  Collective. Sets scheme->failure if no method reaches a small true residual.

  Input Parameter:
. b - right-hand side, which contains the wall data n.grad phi [Pa]

  Output Parameter:
. phi - pressure increment, with mean zero if its constant is undetermined [Pa]
*/
PetscErrorCode PressureSolve(Flow *flow, Vec b, Vec phi, Pressure *s)
{
  LinearSolve *solve = &s->guard.solve;
  PetscReal    norm;

  PetscFunctionBegin;
  PetscCall(PressureUpdateMatrices(flow, s));
  PetscCall(VecNorm(b, NORM_2, &norm));
  solve->iterations = 0;
  if (norm == 0.0) {
    PetscCall(VecZeroEntries(phi));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(ClockWhere(flow->clock, s->guard.where));
  PetscCall(KSPSolve(solve->ksp, b, phi));
  PetscCall(GuardCheck(&s->guard, &flow->scheme->failure));
  solve->iterations = s->guard.iterations;
  if (s->its_new == 0) s->its_new = solve->iterations;
  if (((const Projection *)flow->scheme->data)->splines) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(GaugeRemove(flow->scene, flow->particles, phi));
  PetscFunctionReturn(PETSC_SUCCESS);
}
