/*
  The pressure Poisson equation. If the constant of the pressure is undetermined, the matrix A of
  the Laplacian L is singular. A regular system is solved instead, to a small true residual for
  every form:

    (A + c c^T) phi = b,   A = -dx_i^2 L,   c of GaugeColumn(),   preconditioner from A + s I

  In 3D multigrid has the compact pair-wise Laplacian in place of A: its cycle and set-up cost a
  third, more than the additional iterations. In disordered particles in 2D they would not pay.

  The rank-one term c c^T fixes the mean of phi, and subtracts from b the uniform source for which
  no phi exists. (The left null vector of an unsymmetric L is not constant.) If a boundary gives the
  pressure, the system is A phi = b.
*/
#include "projection.h"

#define LU_SHIFT      1e-8 /* s for LU: changes the solution little [-] */
#define FISCHER_MODEL 1    /* the residual of the guess is minimal */
#define REFINEMENTS   3    /* solves of the first pressure, each to 1e-5 of the residual before */
#define FISCHER_SIZE  8    /* earlier solutions; ten save 1 % of iterations, two vectors each */

struct Pressure {
  Guard guard;
  PetscBool
      passing; /* the preconditioner reads its matrix in the set-up only, and nothing shows it */
  Mat A;       /* of operators without matrices; NULL: they have it */
  Mat preconditioner;        /* its matrix; regular in the set-up, and later unless it is passing */
  Mat gauge;                 /* c; NULL: the pressure is determined */
  PetscBool      pairs;      /* the preconditioner is of the pair-wise Laplacian */
  PetscBool      direct;     /* the preconditioner is of A itself, for a factorisation */
  SplineInverse *inverse;    /* of the stiffness of splines, as the preconditioner; NULL: another */
  Vec            source;     /* its product with b is the uniform source in b; NULL: unknown */
  PetscBool      guesses;    /* solves begin with a guess from earlier solutions */
  PetscInt       assemblies; /* stamp of the operators that the KSP has */
  PetscInt       numbering;  /* stamp of the last set-up */
  PetscInt       epoch;      /* of the particles at the first solution that the guess may use */
};

/* Creates a matrix with the entries of a shell. */
static PetscErrorCode FlattenShell(Mat A, Mat *flat)
{
  PetscErrorCode (*Flatten)(Mat, Mat *);

  PetscFunctionBegin;
  PetscCall(PetscObjectQueryFunction((PetscObject)A, MAT_FLATTEN, &Flatten));
  PetscCall((*Flatten)(A, flat));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates a regular matrix for fallbacks from the matrix that the KSP has: products by rows, which
   may have the term c c^T, or a matrix without shift. */
static PetscErrorCode FlattenRegular(Mat P, Mat *flat)
{
  PetscBool has_column, is_shell;
  Mat       A = P;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)P, MATLRC, &has_column));
  if (has_column) PetscCall(MatLRCGetMats(P, &A, NULL, NULL, NULL));
  PetscCall(PetscObjectTypeCompare((PetscObject)A, MATSHELL, &is_shell));
  if (is_shell) PetscCall(FlattenShell(A, flat));
  else PetscCall(MatDuplicate(A, MAT_COPY_VALUES, flat));
  PetscCall(MatShift(*flat, GAUGE_SHIFT));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes solves begin with the combination of earlier solutions that has the smallest residual, for
   fixed particles unless LU solves exactly; the increments of moving particles differ too much from
   step to step (Fischer, Comput. Methods Appl. Mech. Eng. 163, 1998) */
static PetscErrorCode ChooseGuess(const Flow *flow, Pressure *s)
{
  const char *const prefix = s->guard.solve.prefix;
  PetscBool         given, zero;

  PetscFunctionBegin;
  PetscCall(PetscOptionsHasName(NULL, prefix, "-ksp_guess_type", &given));
  PetscCall(PetscOptionsHasName(NULL, prefix, "-ksp_initial_guess_nonzero", &zero));
  s->guesses = given || (!zero && !s->direct && !SceneMoves(flow->scene));
  if (s->guesses && !given)
    PetscCall(KSPSetUseFischerGuess(s->guard.solve.ksp, FISCHER_MODEL, FISCHER_SIZE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Decides if the solver needs no matrix but products after its set-up, and no option shows one. */
static PetscErrorCode ChoosePassing(Pressure *s)
{
  PetscBool multiplies, sets_up;
  PC        pc;

  PetscFunctionBegin;
  PetscCall(KSPGetPC(s->guard.solve.ksp, &pc));
  PetscCall(PetscObjectTypeCompareAny((PetscObject)s->guard.solve.ksp, &multiplies, KSPFGMRES,
                                      KSPGMRES, KSPCG, KSPBCGS, ""));
  PetscCall(PetscObjectTypeCompareAny((PetscObject)pc, &sets_up, PCLU, PCHYPRE, PCSHELL, ""));
  s->passing = multiplies && sets_up && !KspViewsHaveMatrix(&s->guard.ksp_views);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* PressureCreate - Creates the KSP of the pressure equation and adds its solve to the scheme;
   collective on PETSC_COMM_WORLD. Defaults: see PressureChoose() and ChooseGuess(). */
PetscErrorCode PressureCreate(Flow *flow, Pressure **ppe)
{
  const Splines *sp      = ((const Projection *)flow->scheme->data)->splines;
  const PCType   types[] = {[PRESSURE_AMG]    = PCHYPRE,
                            [PRESSURE_GAMG]   = PCGAMG,
                            [PRESSURE_LU]     = PCLU,
                            [PRESSURE_TENSOR] = PCSHELL};
  PressureSolver solver;
  Pressure      *s;
  PC             pc;

  PetscFunctionBegin;
  PetscCall(PetscNew(&s));
  s->guard.solve = (LinearSolve){
      .name = "pressure", .label = "ppe solver", .prefix = "ppe_", .column = SOLVE_PRESSURE};
  PetscCall(PressureChoose(flow, &solver));
  s->direct            = solver == PRESSURE_LU;
  s->guard.approximate = PETSC_TRUE;
  PetscCall(PoissonSolver(sp ? NULL : &flow->ops->forms.ppe, 1e-5, types[solver], &s->guard));
  if (solver == PRESSURE_TENSOR) {
    PetscCall(SplineInverseCreate(sp, &s->inverse));
    PetscCall(KSPGetPC(s->guard.solve.ksp, &pc));
    PetscCall(SplineInversePC(s->inverse, pc));
  }
  PetscCall(ChooseGuess(flow, s));
  if (!flow->ops->ppe.needed || !flow->ops->ppe.has_matrices) PetscCall(ChoosePassing(s));
  PetscCall(KSPGetPC(s->guard.solve.ksp, &pc));
  if (!sp && flow->scene->dim == 3)
    PetscCall(PetscObjectTypeCompareAny((PetscObject)pc, &s->pairs, PCHYPRE, PCGAMG, PCML, ""));
  if (s->passing) s->guard.Flatten = FlattenRegular;
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
  PetscCall(SplineInverseDestroy(&(*ppe)->inverse));
  PetscCall(MatDestroyAll(&(*ppe)->A, &(*ppe)->preconditioner, &(*ppe)->gauge));
  PetscCall(VecDestroy(&(*ppe)->source));
  PetscCall(PetscFree(*ppe));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The matrices of the equation: on particles or on splines. */
typedef struct {
  Mat       A, P;                  /* without gauge; P: for the preconditioner */
  PetscBool lasting;               /* P stays the same until unknowns are renumbered */
  PetscInt  assemblies, numbering; /* stamps of A, and of the numbers of the unknowns */
} PressureMatrices;

static PetscErrorCode GetMatrices(Flow *flow, Pressure *s, PressureMatrices *m)
{
  const Operators *ops = flow->ops;
  Splines         *sp  = ((Projection *)flow->scheme->data)->splines;

  PetscFunctionBegin;
  if (!sp) {
    Mat A = ops->ppe.A;

    if (!A && s->assemblies != ops->assemblies) {
      PetscCall(MatDestroy(&s->A));
      PetscCall(AffineSystemCreate(&ops->ppe, s->passing ? MATSHELL : MATSAME, &s->A));
      PetscCall(AffineSystemSet(&ops->ppe, 0.0, 1.0, s->A));
    }
    if (!A) A = s->A;
    *m = (PressureMatrices){A, A, PETSC_FALSE, ops->assemblies, flow->particles->epoch};
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SplinesMatrix(flow->particles, sp));
  *m = (PressureMatrices){
      .A          = sp->A,
      .P          = s->direct ? sp->A : sp->K,
      .lasting    = PETSC_TRUE,
      .assemblies = sp->assemblies,
      .numbering  = s->direct || sp->mixture.inertia ? sp->assemblies : sp->numbering,
  };
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Replaces the guess. PETSc's guess keeps its solutions unless the state of the matrix differs, and
   a new matrix may have the state of the old one. */
static PetscErrorCode RenewGuess(Pressure *s)
{
  const KSP    ksp = s->guard.solve.ksp;
  KSPGuess     old, guess;
  KSPGuessType type;

  PetscFunctionBegin;
  if (!s->guesses) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(KSPGetGuess(ksp, &old));
  PetscCall(KSPGuessGetType(old, &type));
  PetscCall(KSPGuessCreate(PetscObjectComm((PetscObject)ksp), &guess));
  PetscCall(KSPGuessSetType(guess, type));
  PetscCall(KSPGuessFischerSetModel(guess, FISCHER_MODEL, FISCHER_SIZE));
  PetscCall(PetscObjectSetOptionsPrefix((PetscObject)guess, s->guard.solve.prefix));
  PetscCall(KSPGuessSetFromOptions(guess));
  PetscCall(KSPSetGuess(ksp, guess));
  PetscCall(KSPGuessDestroy(&guess));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Resets the KSP, and creates the column c for the present numbering. */
static PetscErrorCode PressureRenumber(const Flow *flow, const PressureMatrices *m, Pressure *s)
{
  const Splines *sp = ((const Projection *)flow->scheme->data)->splines;
  PetscInt       n;

  PetscFunctionBegin;
  PetscCall(KSPReset(s->guard.solve.ksp));
  PetscCall(RenewGuess(s));
  PetscCall(MatDestroyAll(&s->preconditioner, &s->gauge));
  PetscCall(MatGetLocalSize(m->P, &n, NULL));
  PetscCall(GaugeColumn(flow->scene, PetscObjectComm((PetscObject)m->P), 0, n,
                        s->direct ? LU_SHIFT : 1.0, &s->gauge));
  if (s->inverse) {
    PetscCall(SplineInverseNumber(sp, flow->particles, s->inverse));
    if (s->gauge) PetscCall(SplineInverseColumn(sp, s->gauge));
  }
  s->numbering = m->numbering;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes y/y^T 1 from the left null vector y of A, y^T A = 0, by a step of inverse iteration with
   the factors. The c of a small s gives phi a mean as large as y^T b/s, which costs accuracy.
   PressureSolve() therefore subtracts the uniform source from b beforehand, and LU needs a single
   iteration. */
static PetscErrorCode PressureSource(Pressure *s)
{
  PCFailedReason failed;
  PetscScalar    sum;
  Vec            one;
  PC             pc;

  PetscFunctionBegin;
  PetscCall(VecDestroy(&s->source));
  if (!s->direct || !s->gauge) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(KSPSetUp(s->guard.solve.ksp));
  PetscCall(KSPGetPC(s->guard.solve.ksp, &pc));
  PetscCall(PCGetFailedReason(pc, &failed));
  if (failed) PetscFunctionReturn(PETSC_SUCCESS); /* the guard reports it */
  PetscCall(MatCreateVecs(s->preconditioner, &s->source, &one));
  PetscCall(VecSet(one, 1.0));
  PetscCall(PCApplyTranspose(pc, one, s->source));
  PetscCall(VecSum(s->source, &sum));
  PetscCall(VecScale(s->source, 1.0 / sum));
  PetscCall(VecDestroy(&one));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the matrix of the preconditioner: a copy, unless it is needed for the set-up only. */
static PetscErrorCode PreconditionerMat(Flow *flow, const PressureMatrices *m, Pressure *s)
{
  PetscBool is_shell;

  PetscFunctionBegin;
  PetscCall(MatDestroy(&s->preconditioner));
  PetscCall(PetscObjectTypeCompare((PetscObject)m->P, MATSHELL, &is_shell));
  if (s->pairs) {
    PetscCall(PairPoisson(flow, &s->preconditioner));
  } else if (is_shell) {
    PetscCall(FlattenShell(m->P, &s->preconditioner));
  } else if (s->passing) {
    PetscCall(PetscObjectReference((PetscObject)m->P));
    s->preconditioner = m->P;
  } else {
    PetscCall(MatDuplicate(m->P, MAT_COPY_VALUES, &s->preconditioner));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gives hypre's type to a matrix that only the set-up of hypre needs: hypre would copy another type
   and set up with both, the peak of the run's memory. */
static PetscErrorCode PassToHypre(const PressureMatrices *m, Pressure *s)
{
  PetscBool is_hypre;
  Mat       copy;
  PC        pc;

  PetscFunctionBegin;
  if (!s->passing || s->preconditioner == m->P) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(KSPGetPC(s->guard.solve.ksp, &pc));
  PetscCall(PetscObjectTypeCompare((PetscObject)pc, PCHYPRE, &is_hypre));
  if (!is_hypre) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MatConvert(s->preconditioner, MATHYPRE, MAT_INITIAL_MATRIX, &copy));
  PetscCall(MatDestroy(&s->preconditioner));
  s->preconditioner = copy;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Ends the use of the matrix of the preconditioner: a matrix of the splines gets its diagonal back,
   and the matrix of a shell is destroyed. */
static PetscErrorCode PassMatrix(Mat A, Vec diagonal, const PressureMatrices *m, Pressure *s)
{
  const KSP ksp = s->guard.solve.ksp;

  PetscFunctionBegin;
  PetscCall(KSPSetUp(ksp));
  PetscCall(KSPSetReusePreconditioner(ksp, PETSC_TRUE));
  if (s->preconditioner == m->P) {
    PetscCall(MatDiagonalSet(s->preconditioner, diagonal, INSERT_VALUES));
  } else {
    PetscCall(KSPSetOperators(ksp, A, A));
    PetscCall(MatDestroy(&s->preconditioner));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Renews the preconditioner of the matrix A. Small diagonal entries are raised, but not those of
   splines and of pairs, which are right, and not for LU, which needs A itself. */
static PetscErrorCode RenewPreconditioner(Flow *flow, Mat A, const PressureMatrices *m, Pressure *s)
{
  const KSP ksp = s->guard.solve.ksp;
  Vec       diagonal;

  PetscFunctionBegin;
  PetscCall(SolverRenewPC(ksp));
  PetscCall(PreconditionerMat(flow, m, s));
  PetscCall(MatCreateVecs(s->preconditioner, &diagonal, NULL));
  PetscCall(MatGetDiagonal(s->preconditioner, diagonal));
  if (!s->direct && !s->pairs && !((const Projection *)flow->scheme->data)->splines)
    PetscCall(AmgDiagonal(s->preconditioner));
  PetscCall(
      GaugePreconditioner(flow->scene, s->direct ? LU_SHIFT : GAUGE_SHIFT, s->preconditioner));
  PetscCall(PassToHypre(m, s));
  PetscCall(KSPSetReusePreconditioner(ksp, PETSC_FALSE));
  PetscCall(KSPSetOperators(ksp, A, s->preconditioner));
  PetscCall(SolverSetUpGamg(ksp));
  PetscCall(PressureSource(s));
  if (s->passing) PetscCall(PassMatrix(A, diagonal, m, s));
  PetscCall(VecDestroy(&diagonal));
  SetUpRenew(m->numbering, 1.0, &s->guard.solve);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gives new matrices to the KSP. The preconditioner is reused as SetUpHolds() says: displacements
   change it little, but a renumbering invalidates it. A checkpoint begins an epoch. A restarted run
   has no earlier solutions, so the guess forgets them. */
static PetscErrorCode PressureUpdateMatrices(Flow *flow, Pressure *s)
{
  const KSP        ksp = s->guard.solve.ksp;
  PressureMatrices m   = {0};
  PetscBool        rebuild;
  Mat              A;

  PetscFunctionBegin;
  PetscCall(GetMatrices(flow, s, &m));
  if (s->assemblies == m.assemblies) PetscFunctionReturn(PETSC_SUCCESS);
  rebuild = !m.lasting && !SetUpHolds(&s->guard.solve.setup, m.numbering, 1.0);
  if (s->numbering != m.numbering || (s->guesses && s->epoch != flow->particles->epoch)) {
    PetscCall(PressureRenumber(flow, &m, s));
    rebuild = PETSC_TRUE;
  }
  PetscCall(GaugeMatrix(m.A, s->gauge, &A));
  if (rebuild) {
    PetscCall(RenewPreconditioner(flow, A, &m, s));
  } else {
    PetscCall(KSPSetReusePreconditioner(ksp, PETSC_TRUE));
    PetscCall(KSPSetOperators(ksp, A, s->preconditioner ? s->preconditioner : A));
  }
  PetscCall(MatDestroy(&A));
  s->assemblies = m.assemblies;
  s->epoch      = flow->particles->epoch;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* PressureSolve - Solves A phi = b, A = -dx_i^2 lap, for the pressure increment phi. Collective.
   Sets scheme->failure if no method reaches a small true residual. Input: b - right-hand side,
   which contains the wall data n.grad phi; destroyed [Pa]. Output: phi - pressure increment, with
   mean zero if its constant is undetermined [Pa]. */
PetscErrorCode PressureSolve(Flow *flow, Vec b, Vec phi, Pressure *s)
{
  LinearSolve *solve = &s->guard.solve;
  PetscReal    norm;
  PetscScalar  uniform;

  PetscFunctionBegin;
  PetscCall(PressureUpdateMatrices(flow, s));
  PetscCall(VecNorm(b, NORM_2, &norm));
  solve->iterations = 0;
  if (norm == 0.0) {
    PetscCall(VecZeroEntries(phi));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (s->source) {
    PetscCall(VecDot(b, s->source, &uniform));
    PetscCall(VecShift(b, -uniform));
  }
  PetscCall(ClockWhere(flow->clock, s->guard.where));
  PetscCall(KSPSolve(solve->ksp, b, phi));
  PetscCall(GuardCheck(&s->guard, &flow->scheme->failure));
  solve->iterations = s->guard.iterations;
  if (((const Projection *)flow->scheme->data)->splines) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(GaugeRemove(flow->scene, flow->particles, phi));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* PressureRefine - Solves A phi = b to rounding, by solves for the residual. Collective. For the
   first pressure of a run, which has no earlier pressure that a tolerance could be relative to.
   Sets scheme->failure as PressureSolve() does. */
PetscErrorCode PressureRefine(Flow *flow, const Vec b, Vec phi, Pressure *s)
{
  Vec r, part;
  Mat A;

  PetscFunctionBegin;
  PetscCall(VecDuplicate(b, &r));
  PetscCall(VecDuplicate(phi, &part));
  PetscCall(VecCopy(b, r));
  PetscCall(VecZeroEntries(phi));
  for (PetscInt k = 0; k < REFINEMENTS && !flow->scheme->failure.code; k++) {
    PetscCall(PressureSolve(flow, r, part, s));
    PetscCall(VecAXPY(phi, 1.0, part));
    PetscCall(KSPGetOperators(s->guard.solve.ksp, &A, NULL));
    PetscCall(MatMult(A, phi, r));
    PetscCall(VecAYPX(r, -1.0, b));
  }
  s->guard.solve.iterations = 0; /* of steps */
  PetscCall(VecDestroyAll(&part, &r));
  PetscFunctionReturn(PETSC_SUCCESS);
}
