/*
  Schemes: how one step of a flow is made. Flow bundles all that a step works on; FlowState holds
  the velocities and the pressure; a scheme is one folder of src/schemes/ and one row of its table.
*/
#ifndef ISPH_SCHEMES_H
#define ISPH_SCHEMES_H

#include "isph/clock.h"
#include "isph/operators.h"

#define FLOW_MAX_WORK 32

/* Stages that all steps have, as -log_view shows them. */
enum { FLOW_EVENT_MOVE, FLOW_EVENT_NEIGHBORS, FLOW_EVENT_OPERATORS, FLOW_EVENTS };

/* Particle shifting: where to move particles so that they stay evenly spread. */
typedef struct {
  const char *name, *brief, *citation;
  void (*Displace)(const Scene *scene, PetscReal strength, PetscReal speed, PetscReal rate,
                   PetscReal dt, const PetscReal gradient_c[],
                   PetscReal displacement[]); /* NULL: none */
  PetscReal disturbance; /* random, in the first step, which breaks the symmetry of lattices [dx] */
} ShiftRow;
extern const Table ShiftTable;

/*
  Velocity and pressure on the particles. Fields follow the particles through migration, restart
  and undo; vectors belong to one epoch and see the fields or hold the step at hand.
*/
typedef struct {
  const ShiftRow *shift; /* NULL: particles stay */
  PetscReal       shift_strength;
  PetscReal       velocity_filter; /* strength of the grid-scale filter of velocities [-] */
  PetscBool       has_convection;  /* particles stay and the flow is convected past them */

  PetscReal *u_previous[ISPH_MAX_DIM]; /* u^{n-1} (field) [m/s] */
  PetscReal *convection[ISPH_MAX_DIM]; /* (u.grad u)^{n-1} of fixed particles (field) [m/s^2] */

  PetscInt  epoch;                         /* of the vectors */
  Vec       u[ISPH_MAX_DIM];               /* u^n, on the particles' field */
  Vec       u_prev[ISPH_MAX_DIM];          /* u^{n-1}, on its field */
  Vec       convection_prev[ISPH_MAX_DIM]; /* on its field */
  Vec       p;                             /* p, on the particles' field; NULL: no pressure */
  Vec       u_next[ISPH_MAX_DIM];          /* u* and then u^{n+1} of the step at hand [m/s] */
  Vec       p_before;                      /* p^n of the step at hand [Pa] */
  Vec       divergence;                    /* div u* of the step at hand [1/s] */
  Vec       work[FLOW_MAX_WORK];           /* vectors lent by FlowGetWork() */
  PetscBool lent[FLOW_MAX_WORK];

  PetscLogEvent event[FLOW_EVENTS];
} FlowState;

/* Statistics of a step, for progress, the steady test and the report. */
typedef struct {
  PetscReal speed_max;      /* largest particle speed [m/s] */
  PetscReal force_max;      /* largest body force per unit mass [m/s^2] */
  PetscReal kinetic_energy; /* [J] (per metre of depth in 2D) */
  PetscReal divergence;     /* largest |D u| [1/s] */
  PetscReal change[3];      /* of u, div u* and p, relative, per shortest time scale [-] */
} StepStats;

/* The steady test: means of root mean squares over a stretch of steps; see steady.c. */
typedef struct {
  PetscReal start, count; /* of the stretch [s], and its steps so far */
  PetscReal sum[3];       /* of the root mean squares of u, div u* and p, relative [-] */
  PetscReal mean[3];      /* over the stretch before [-] */
  PetscReal divergence;   /* root mean square of div u* in the last step [1/s] */
} SteadyTest;

/* The bound on the velocity that the driving forces and walls allow; see check.c. */
typedef struct {
  PetscReal start;      /* root mean square of u at the start [m/s] */
  PetscReal impulse;    /* int max |f| dt [m/s] */
  PetscReal force;      /* largest |f| so far [m/s^2] */
  PetscReal force_step; /* largest |f| in the step at hand [m/s^2] */
  PetscReal walls;      /* fastest flow that walls can have made so far [m/s] */
} SpeedBound;

/* The column of the report that a linear solve fills. */
typedef enum { SOLVE_VELOCITY, SOLVE_PRESSURE } SolveColumn;

/* One linear solve of a scheme, as banner, report, progress and checkpoints see it. */
typedef struct {
  const char *name;           /* in messages: "viscous", "pressure", ... */
  const char *label;          /* in the banner */
  const char *prefix;         /* of its options: "visc_", "ppe_", "coupled_" */
  const char *integrator;     /* type of its TS; NULL: none */
  SolveColumn column;         /* of the report */
  KSP         ksp;            /* NULL: explicit */
  Mat         matrix;         /* of the last solve, for -<prefix>mat_view; NULL: none */
  PetscBool   views_matrix;   /* there is such an option */
  PetscBool   multistep;      /* the TS keeps earlier velocities, which no checkpoint holds */
  char        note[256];      /* legal but unwise choices of the user; empty: none */
  PetscInt    iterations;     /* of the last step */
  PetscInt    iterations_sum; /* of all steps */
  PetscInt    falls;          /* solves that needed the fallback */
} LinearSolve;

#define SCHEME_MAX_SOLVES 4

/*
  A scheme, one folder of src/schemes/. Create reads the scheme's options, refuses what the scene
  cannot have, and sets scheme->needs; SetUp refuses forms and makes solvers, when the operators are
  chosen; Register adds fields to the particles; Begin readies everything for the fields as they
  are; Step makes one step of the clock's dt; Limit lowers the longest step allowed; View writes the
  scheme's lines of the banner.
*/
typedef struct {
  const char *name, *brief, *citation;
  PetscErrorCode (*Create)(Flow *flow);
  PetscErrorCode (*SetUp)(Flow *flow);
  PetscErrorCode (*Register)(Flow *flow); /* NULL: no fields of its own */
  PetscErrorCode (*Begin)(Flow *flow);
  PetscErrorCode (*Step)(Flow *flow);
  PetscErrorCode (*Limit)(const Flow *flow, StepLimit *limit);
  PetscErrorCode (*View)(const Flow *flow, PetscViewer viewer);
  PetscErrorCode (*Destroy)(Flow *flow);
} SchemeRow;
extern const Table SchemeTable;

typedef struct {
  const SchemeRow *row;
  const TableRow  *variant; /* the row of the report's column projection; NULL: none */
  unsigned         needs;   /* operators, bits of Need */
  StepStats        stats;
  SteadyTest       steady;
  SpeedBound       bound;
  StepFailure      failure; /* of the step just tried */
  Memory           memory;
  LinearSolve     *solve[SCHEME_MAX_SOLVES];
  PetscInt         n_solves;
  void            *data;
} Scheme;

PetscErrorCode SchemeCreate(Flow *flow);
PetscErrorCode SchemeSetUp(Flow *flow);
PetscErrorCode SchemeRegister(Flow *flow);
PetscErrorCode SchemeLimit(const Flow *flow, StepLimit *limit);
PetscErrorCode SchemeAddSolve(LinearSolve *solve, Scheme *scheme);
PetscErrorCode SchemeDestroy(Flow *flow);

/* All that a step works on. A patch test has no clock, no state and no scheme. */
struct Flow {
  Scene     *scene;
  Clock     *clock;
  Operators *ops;
  Particles *particles;
  Neighbors *neighbors;
  WallValues walls;
  FlowState *state;
  Scheme    *scheme;
};

PetscErrorCode FlowStateCreate(Flow *flow, unsigned *needs);
PetscErrorCode FlowStateRegister(Flow *flow);
PetscErrorCode FlowStateRenumber(Flow *flow);
PetscErrorCode FlowStateDestroy(Flow *flow);
PetscErrorCode FlowGetWork(Flow *flow, Vec *v);
PetscErrorCode FlowRestoreWork(Flow *flow, Vec *v);

PetscErrorCode ConvectionCentral(PetscInt dim, const Operators *ops, const Vec v[], Vec u,
                                 Vec walls, Vec work, Vec result);
PetscErrorCode ConvectionApply(const Flow *flow, const Vec v[], Vec u, Vec walls, Vec work,
                               Vec result);

/* The flow before a step, to go back to. */
typedef struct Undo Undo;
PetscErrorCode      UndoCreate(Undo **undo);
PetscErrorCode      UndoDestroy(Undo **undo);
PetscErrorCode      UndoSave(const Flow *flow, Undo *undo);
PetscErrorCode      UndoRestore(const Undo *undo, Flow *flow);

extern const Table ProjectionTable, ViscousIntegratorTable, CoupledIntegratorTable, SchurTable;

#endif
