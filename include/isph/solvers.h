/* Linear solvers: their defaults, and a guard. After each solve the guard computes the true
   residual, solves again by fallback methods if the residual is not small, and fails the step if no
   method helps. See src/solvers/guard.c and fallback.c. */
#ifndef ISPH_SOLVERS_H
#define ISPH_SOLVERS_H

#include "isph/flow.h"

#define FALLBACK_LEVELS 3 /* methods of fallback.c */

/* A viewer that the user gave for a solver. */
typedef struct {
  PetscViewer       viewer; /* NULL: none */
  PetscViewerFormat format;
} SolverView;

/* Viewers of a KSP, its matrix, the matrix of its preconditioner, right-hand side and solution. */
#define KSP_VIEWS 5
typedef struct {
  SolverView of[KSP_VIEWS];
} KspViews;

typedef struct {
  LinearSolve solve;
  KspViews    ksp_views;          /* -<prefix>ksp_view, -<prefix>ksp_view_mat, ... */
  SolverView  ts_view;            /* -<prefix>ts_view */
  const char *best;               /* type of KSP to recommend */
  const char *remedy;             /* advice; NULL: derived from the user's choice */
  char        where[CLOCK_WHERE]; /* the present step, for messages */
  PetscBool   symmetric;          /* the matrix is symmetric */
  PetscBool   flat; /* particles fill a plane, whose matrices have factors with few entries */
  PetscBool   approximate;  /* the preconditioner is of another matrix, even a factorisation */
  PetscBool   inner;        /* part of a nonlinear solve, which checks its own residual instead */
  PetscBool   keeps;        /* a fallback that solved twice in a row is kept, see GuardSolve() */
  PetscInt    max_in_a_row; /* allowed fallbacks in a row; -1: no fallback */
  KSP         level[FALLBACK_LEVELS]; /* fallback solvers; NULL until needed */
  PetscBool   failed;                 /* a solve has failed since the last GuardCheck() */
  PetscReal   residual;          /* true relative residual of the failed or else the last solve */
  KSPConvergedReason reason;     /* of the chosen method in that solve */
  PetscInt           iterations; /* of that solve */
  /* makes a sparse, regular matrix for fallbacks; NULL: they take the matrix of the solver */
  PetscErrorCode (*Flatten)(Mat matrix, Mat *flat);
  /* fails the step if the nonlinear solver of a TS did not converge; NULL: no such solver */
  PetscErrorCode (*Check)(TS ts, const char where[], StepFailure *failure);
} Guard;

PetscErrorCode GuardAttach(KSP ksp, const LaplacianForm *form, Guard *guard);
PetscErrorCode GuardDetach(Guard *guard);
PetscErrorCode GuardOnlyMultiplies(SNES snes, PCType type, const Guard *guard, PetscBool *only);
PetscErrorCode GuardSolve(Guard *guard, Vec b, Vec x);
PetscErrorCode GuardCheck(Guard *guard, StepFailure *failure);
PetscErrorCode SolveResidual(KSP ksp, Vec b, Vec x, PetscReal *residual, PetscBool *good);
PetscErrorCode FallbackSolve(Vec b, Vec x, Guard *guard, PetscBool *solved);
PetscBool      FallbackIsKept(const Guard *guard);

/* solverviews.c */
PetscErrorCode SolverViewTake(const char prefix[], const char name[], SolverView *view);
PetscErrorCode SolverViewShow(PetscObject solver, const SolverView *view);
PetscErrorCode SolverViewEnd(SolverView *view);
PetscErrorCode KspViewsTake(const char prefix[], KspViews *views);
PetscBool      KspViewsHaveMatrix(const KspViews *views);
PetscErrorCode KspViewsShow(KSP ksp, KspViews *views);
PetscErrorCode KspViewsEnd(KspViews *views);

/* defaults.c */
PetscErrorCode OptionDefault(const char prefix[], const char name[], const char value[]);
PetscErrorCode FactorDefault(const char prefix[], const char name[]);
PetscErrorCode AmgDefaults(const char prefix[], const char aggressive[]);
PetscErrorCode AmgDiagonal(Mat A);
PetscErrorCode PoissonSolver(const LaplacianForm *form, PetscReal rtol, PCType type, Guard *guard);
PetscErrorCode SolverRenewPC(KSP ksp);
PetscErrorCode SolverAttachShell(PC fieldsplit, PetscInt block, const char name[], void *ctx,
                                 PetscErrorCode (*Apply)(PC pc, Vec x, Vec y));
PetscErrorCode SolverSetUpGamg(KSP ksp);
PetscErrorCode SolverNames(KSP ksp, const char **type, const char **pc);

/* setup.c */
PetscBool SetUpHolds(const SetUp *setup, PetscInt numbering, PetscReal shift);
void      SetUpRenew(PetscInt numbering, PetscReal shift, LinearSolve *solve);
void      SetUpCount(PetscInt iterations, SetUp *setup);

/* pairlaplacian.c */
PetscErrorCode PairLaplacian(const Flow *flow, Vec row, const PetscReal nu[], Vec diagonal, Mat *A);
PetscErrorCode PairPoisson(const Flow *flow, Mat *A);

/* timestep.c */
PetscErrorCode TimeCreate(const char prefix[], const char name[], const char type[],
                          PetscBool linear, TS *ts);
PetscErrorCode TimeOptionsRefuse(const char prefix[], const char type[]);
PetscErrorCode TimeToleranceRefuse(TS ts, const char prefix[]);
PetscErrorCode TimeStepThrough(TS ts, const char name[], Guard *guard, PetscReal t, PetscReal dt,
                               PetscReal *h, StepFailure *failure);

/* The constant of the pressure, see src/solvers/gauge.c. */
#define GAUGE_SHIFT 1e-6 /* of matrices whose entries are of order 1 [-] */
PetscErrorCode GaugeRemove(const Scene *scene, const Particles *particles, Vec p);
PetscErrorCode GaugeColumn(const Scene *scene, MPI_Comm comm, PetscInt before, PetscInt n,
                           PetscReal strength, Mat *column);
PetscErrorCode GaugeMatrix(Mat A, Mat column, Mat *regular);
PetscErrorCode GaugePreconditioner(const Scene *scene, PetscReal shift, Mat A);

extern const OptionTable GuardOptions, SolverOptions;

#endif
