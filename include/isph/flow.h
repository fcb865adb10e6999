/* Flow: all data of a step. FlowState holds velocities and pressure; a scheme is a list of stages,
   which FlowStep() does in turn; observers stand between stages, and judges repeat them. */
#ifndef ISPH_FLOW_H
#define ISPH_FLOW_H

#include "isph/operators.h"
#include "isph/time.h"

#define FLOW_MAX_WORK 32

/* The work on neighbours and matrices, which stages of a step share, for -log_view. */
enum { FLOW_EVENT_NEIGHBORS, FLOW_EVENT_OPERATORS, FLOW_EVENTS };

/* Particle shifting: small displacements that keep particles evenly spread. */
typedef struct {
  const char *name, *brief, *citation;
  void (*Displace)(PetscInt dim, PetscReal dx, PetscReal strength, PetscReal speed, PetscReal rate,
                   PetscReal dt, const PetscReal gradient_c[],
                   PetscReal displacement[]); /* NULL: none */
  PetscReal disturbance; /* random, in the first step; breaks the symmetry of lattices [dx] */
} ShiftRow;
typedef struct FreeBodies FreeBodies;
typedef struct Scalars    Scalars;

/* The rate of the last step, and the error in time of the steps; see src/flow/acceleration.c. */
typedef struct {
  PetscReal *rate[ISPH_MAX_DIM];     /* Du/Dt (field); NULL: steady, or Scheme.Accelerate [m/s^2] */
  PetscReal *filtered[ISPH_MAX_DIM]; /* change of u by the filter of moving particles, over dt
                                        (field); NULL: none [m/s^2] */
  PetscReal  time_error;             /* of the velocity by steps in time, root mean square [m/s] */
  PetscReal  sampled;                /* time of its last measurement [s] */
  PetscReal  speed[2]; /* root mean square of the velocity of the last two steps [m/s] */
} Acceleration;

/* Sums over the run of momentum and energy that graded particles add by their motion; see
   src/motion/gradedmotion.c. */
typedef struct {
  PetscReal momentum[ISPH_MAX_DIM]; /* [kg m/s] (per metre of depth in 2D) */
  PetscReal energy;                 /* [J] (per metre of depth in 2D) */
} Graded;

/* Weights of fits at points in the order in which a monitor asks for them, which fixed particles do
   not change; see src/forces/probe.c. */
typedef struct {
  PetscBool  on;              /* the monitor asks */
  PetscInt   at, n, capacity; /* next number, numbers, room for them */
  PetscReal *number;          /* for each fit its key and size, neighbours and weights */
} KeptFits;

/* Volume that enters and leaves through openings; see src/motion/openings.c. */
typedef struct {
  PetscBool open;                  /* particles can enter or leave */
  PetscReal volume_in, volume_out; /* of particles, so far [m^dim] */
  PetscReal room; /* volume of a box that fluid enters and cannot leave; 0: another box [m^dim] */
} Openings;

/* Velocity and pressure on the particles. Fields follow the particles through migration, restart
   and undo. Vectors are valid for an epoch; they share storage with the fields or hold the present
   step. */
typedef struct {
  const ShiftRow *shift; /* NULL: fixed particles */
  PetscReal       shift_strength;
  PetscReal       velocity_filter;     /* strength of the grid-scale filter of velocities [-] */
  PetscBool       has_convection;      /* particles are fixed and have a convective term */
  PetscBool       implicit_convection; /* this term is in the viscous matrix */

  Acceleration acceleration;       /* of the last step */
  PetscReal    mean[ISPH_MAX_DIM]; /* velocity before the step of a flow that keeps it [m/s] */
  Graded       graded;             /* zero unless particles move and are graded */
  Openings     openings;
  KeptFits     kept_fits;
  FreeBodies  *bodies;  /* NULL: no body is free */
  Scalars     *scalars; /* NULL: the fluid carries none */

  PetscReal *u_previous[ISPH_MAX_DIM]; /* u^{n-1} (field) [m/s] */
  PetscReal *u_earlier[ISPH_MAX_DIM];  /* u^{n-2} (field); NULL: not needed [m/s] */
  PetscReal *convection[ISPH_MAX_DIM]; /* (u.grad u)^{n-1} of fixed particles, explicit (field)
                                          [m/s^2] */
  PetscReal *convection_earlier[ISPH_MAX_DIM]; /* (u.grad u)^{n-2} (field); NULL: not needed */
  Vec        filter_rate[ISPH_MAX_DIM]; /* of VelocityFilterRates() in the present step [1/s] */
  PetscReal *correction[ISPH_MAX_DIM];  /* u - u* of the last projection (field); NULL without
                                          implicit convection [m/s] */

  PetscInt  epoch;                           /* epoch of the vectors */
  Vec       u[ISPH_MAX_DIM];                 /* u^n, on the particles' field */
  Vec       u_prev[ISPH_MAX_DIM];            /* u^{n-1}, on its field */
  Vec       u_before[ISPH_MAX_DIM];          /* u^{n-2}, on its field; NULL: not needed */
  Vec       convection_prev[ISPH_MAX_DIM];   /* convective term of the last step, on its field */
  Vec       convection_before[ISPH_MAX_DIM]; /* that of the step before, on its field; NULL: not
                                                needed */
  Vec       correction_prev[ISPH_MAX_DIM];   /* correction, on its field; NULL: not needed */
  Vec       p;                               /* p, on the particles' field; NULL: no pressure */
  Vec       u_next[ISPH_MAX_DIM];            /* u*, then u^{n+1} of the present step [m/s] */
  Vec       p_before;                        /* p^n of the present step [Pa] */
  Vec       divergence;                      /* div u* of the present step [1/s] */
  PetscReal tension_energy;                  /* of interfaces, twice, over the mass [m^2/s^2] */
  Vec       interface[ISPH_MAX_DIM];         /* forces of interfaces per unit mass, and weights less
                                                the body force; NULL: none [m/s^2] */
  Vec       work[FLOW_MAX_WORK];             /* vectors lent by FlowGetWork() */
  PetscBool lent[FLOW_MAX_WORK];

  PetscLogEvent event[FLOW_EVENTS];
} FlowState;

/* Statistics of a step, for progress, the steady test and the report. */
typedef struct {
  PetscReal speed_max;      /* largest particle speed [m/s] */
  PetscReal pace_max;       /* largest speed in cells, times the reference spacing [m/s]: of
                               particles, or of the fluid that passes them */
  PetscReal force_max;      /* largest body force per unit mass that no pressure is known to
                               balance [m/s^2] */
  PetscReal kinetic_energy; /* [J] (per metre of depth in 2D) */
  PetscReal density;        /* mean of the fluid [kg/m^3] */
  PetscReal divergence;     /* largest |D u| [1/s] */
  PetscReal change[3];      /* of u, div u* and p, relative, per shortest time scale [-] */
  PetscReal unevenness;     /* largest root mean square of C - 1 of the run so far [-] */
} StepStats;

/* The steady test: means of root mean squares over a window of steps; see steady.c. */
typedef struct {
  PetscReal start, count; /* start of the window [s]; number of its steps so far */
  PetscReal sum[3];       /* of the root mean squares of u, div u* and p, relative [-] */
  PetscReal mean[3];    /* over the last window; fixed particles: changes in the step before [-] */
  PetscReal divergence; /* root mean square of div u* in the last step [1/s] */
} SteadyTest;

/* The bound on the velocity that follows from driving forces and walls; see
   src/balance/stepcheck.c. */
typedef struct {
  PetscReal start;      /* root mean square of u at the start [m/s] */
  PetscReal impulse;    /* int max |f| dt [m/s] */
  PetscReal force;      /* largest |f| so far [m/s^2] */
  PetscReal force_step; /* largest |f| in the present step [m/s^2] */
  PetscReal walls;      /* largest speed that walls can have driven so far [m/s] */
  PetscReal sound;      /* root mean square velocity of sound in weakly compressible flows [m/s] */
} SpeedBound;

/* The energy balance of a moving fluid with a free surface; see src/balance/energy.c. */
typedef struct {
  PetscReal work;       /* of the body force so far, per mass [m^2/s^2] */
  PetscReal dissipated; /* by viscosity so far, per mass [m^2/s^2] */
  PetscReal lag;        /* error of twice the work [m^2/s^2] */
  PetscReal most;       /* largest twice the energy per mass that start and work gave [m^2/s^2] */
  PetscReal gain;       /* largest energy beyond that so far, relative to `most` [-] */
  PetscReal gain_t;     /* its time [s] */
} EnergyBalance;

/* The balances of a run, rows of the table in src/balance/sheet.c. */
typedef enum {
  BALANCE_VOLUME,
  BALANCE_MASS,
  BALANCE_MOMENTUM,
  BALANCE_ANGULAR,
  BALANCE_ENERGY,
  BALANCE_FORCE,
  BALANCE_TORQUE,
  BALANCE_SOLID,
  BALANCE_SCALAR,
  BALANCE_BOUNDS,
  BALANCES
} BalanceKind;

/* Fluid that touches nothing: momentum and angular momentum less the impulse of the body force,
   per mass, against those of the start of the flight; see src/balance/flight.c. */
typedef struct {
  PetscReal on;                     /* 1: in flight */
  PetscReal start[2][ISPH_MAX_DIM]; /* momentum [m/s], angular momentum [m^2/s] */
  PetscReal given[2][ISPH_MAX_DIM]; /* by the body force since then */
  PetscReal speed;                  /* largest root mean square of the velocity [m/s] */
} Flight;

/* Violations of the balances, relative to their scales. */
typedef struct {
  PetscInt  applies[BALANCES];
  PetscReal residual[BALANCES]; /* as measured, positive or zero [-] */
  PetscReal value[BALANCES];    /* the part of it beyond its own error [-] */
  PetscReal t[BALANCES];        /* their times [s] */
  Flight    flight;
} BalanceSheet;

/* The column of the report that a linear solve fills. */
typedef enum { SOLVE_VELOCITY, SOLVE_PRESSURE, SOLVE_SCALAR } SolveColumn; /* the last: none */

/* The set-up of a preconditioner, see src/solvers/setup.c. */
typedef struct {
  PetscBool exists;
  PetscInt  numbering;   /* stamp of the unknowns */
  PetscInt  first, last; /* iterations of the first and of the last solve with it */
  PetscReal shift;       /* of its matrix */
} SetUp;

/* A linear solve of a scheme, for banner, report, progress and checkpoints. */
typedef struct {
  const char *name;           /* in messages: "viscous", "pressure", ... */
  const char *label;          /* in the banner */
  const char *prefix;         /* of its options: "visc_", "ppe_", "coupled_" */
  const char *integrator;     /* type of its TS; NULL: none */
  SolveColumn column;         /* of the report */
  KSP         ksp;            /* NULL: explicit */
  char        note[256];      /* allowed but unwise choices of the user; empty: none */
  PetscInt    iterations;     /* of the last step */
  PetscInt    iterations_sum; /* of all steps */
  PetscInt    setups;         /* of the preconditioner, since this program began */
  SetUp       setup;          /* the present one */
  PetscInt    falls;          /* solves that needed a fallback */
  PetscInt    falls_in_a_row; /* those since the last good solve */
} LinearSolve;

#define SCHEME_MAX_SOLVES    8
#define SCHEME_MAX_FIGURES   5
#define SCHEME_MAX_STAGES    16
#define SCHEME_MAX_OBSERVERS 3
#define SCHEME_MAX_JUDGES    4

/* A number of a scheme for the report. The run prints a line if it has left its range. */
typedef struct {
  const char      *name;   /* in the report */
  const PetscReal *value;  /* largest of the run */
  PetscReal        most;   /* largest value of its range */
  const char      *remedy; /* "the fluid ...; try ..." */
  PetscBool        quiet;  /* the report has it only if it has left its range */
} SchemeFigure;

/* A stage of a step. The stages that apply to a flow are chosen once in a run, and FlowStep() does
   them in turn. A stage that fails sets scheme->failure, which ends the step. */
typedef struct {
  const char *name, *brief;
  PetscBool (*Applies)(const Flow *flow); /* NULL: to all flows */
  PetscErrorCode (*Do)(Flow *flow);
  PetscBool solves; /* u_next and p follow from it; it can be done again, see src/flow/attempt.c */
} Stage;

/* An observer of steps, which changes none. */
typedef struct {
  PetscBool (*Applies)(const Flow *flow);
  PetscErrorCode (*Begin)(Flow *flow); /* before the first stage; or NULL */
  PetscErrorCode (*End)(Flow *flow);   /* after the last stage, before the time advances */
} Observer;

/* Parts of a step that are done again: its last stage that solves; all that solve, from pressure
   and memory before them; all of it, in a shorter time. */
typedef enum { AGAIN_LAST, AGAIN_SOLVES, AGAIN_SHORTER, AGAIN_KINDS } Again;

/* Attempts of a judge: of solves in the present step, or of the step. */
typedef struct {
  PetscInt  times; /* so far */
  PetscReal first; /* its measure of the solution before them */
} Trial;

/* A judge of solutions. Decide sees the solution and tells if something is done again. Treat, after
   the restoring, prepares another treatment. Clear ends the treatment after the step. */
typedef struct {
  const char *name, *brief;
  PetscBool (*Applies)(const Flow *flow);
  Again again;
  PetscErrorCode (*Decide)(Flow *flow, Trial *trial, PetscBool *again);
  PetscErrorCode (*Treat)(Flow *flow); /* NULL: Decide does it */
  PetscErrorCode (*Clear)(Flow *flow); /* NULL: nothing to end */
} Judge;
typedef struct Attempt Attempt;
typedef struct Splines Splines;

/* Flows whose memory differs, see src/io/machinememory.c: fixed particles whose rows repeat, other
   fixed ones, moving ones, and those of free surfaces. */
typedef enum { MEMORY_EVEN, MEMORY_FIXED, MEMORY_MOVING, MEMORY_FREE, MEMORY_KINDS } MemoryKind;

/* A scheme, a folder of src/schemes/. Create reads the scheme's options, refuses unsuitable scenes,
   and sets scheme->needs. SetUp, after the choice of operators, refuses unsuitable forms and
   creates solvers. Register adds fields to the particles. Begin prepares the scheme for the present
   fields. Error estimates the root mean square error of the velocity [m/s] below a free surface of
   strain cells; its rate is 1/T, T the age of the flow [1/s]. Limit lowers the longest allowed
   step. View prints the scheme's lines of the banner. The stages make a step of the clock's dt. */
typedef struct {
  const char *name, *brief, *citation;
  PetscErrorCode (*Create)(Flow *flow);
  PetscErrorCode (*SetUp)(Flow *flow);
  PetscErrorCode (*Register)(Flow *flow); /* NULL: no additional fields */
  PetscErrorCode (*Assemble)(Flow *flow); /* NULL: no matrices of its own */
  PetscErrorCode (*Begin)(Flow *flow);
  PetscErrorCode (*Start)(Flow *flow); /* NULL: nothing at the start of a run, after Begin */
  PetscErrorCode (*Error)(Flow *flow, PetscReal rate, PetscReal *error); /* NULL: no surfaces */
  PetscErrorCode (*Limit)(const Flow *flow, StepLimit *limit);
  PetscErrorCode (*View)(const Flow *flow, PetscViewer viewer);
  PetscErrorCode (*Destroy)(Flow *flow);
  const Stage *const *stages;                  /* in their order; NULL ends the list */
  const Judge *const *judges;                  /* in their order; NULL ends the list */
  PetscReal           memory[2][MEMORY_KINDS]; /* of a fluid particle in 2D and 3D [kB] */
} SchemeRow;

typedef struct {
  const SchemeRow *row;
  const TableRow  *variant; /* row for the report's column projection; NULL: none */
  const Stage     *stage[SCHEME_MAX_STAGES];     /* those that apply */
  PetscLogStage    stage_log[SCHEME_MAX_STAGES]; /* without a log the main stage, 0 */
  PetscInt         n_stages;
  const Observer  *observer[SCHEME_MAX_OBSERVERS]; /* those that apply */
  PetscInt         n_observers;
  Attempt         *attempt;
  unsigned         needs; /* operators, bits of Need */
  StepStats        stats;
  SteadyTest       steady;
  SpeedBound       bound;
  EnergyBalance    energy;
  BalanceSheet     sheet;
  StepFailure      failure; /* of the last attempted step */
  Memory           memory;
  PetscErrorCode (*Divergence)(Flow *flow, const Vec u[],
                               PetscReal *largest); /* largest |div u|; NULL: by Operators.div */
  /* This rank's part of the pressure at a point in the box; NULL: by a fit of the particles' */
  PetscErrorCode (*Pressure)(const Flow *flow, const PetscReal x[], PetscReal *p);
  /* Adds the forces of the pressure on own wall particles in strain cells that a free surface cuts,
     component a on w at [w dim + a] [N] */
  PetscErrorCode (*PressOnWalls)(const Flow *flow, PetscReal force[]);
  /* Du/Dt at present, by components [m/s^2]; NULL: from the formula of the last step */
  PetscErrorCode (*Accelerate)(const Flow *flow, PetscReal *const rate[]);
  PetscReal *const *density; /* field of the fluid's densities; NULL: from masses [kg/m^3] */
  Splines          *splines; /* of the pressure; NULL: it is on the particles */
  Vec               kept; /* state that is not on particles, for undo and checkpoints; NULL: none */
  LinearSolve      *solve[SCHEME_MAX_SOLVES];
  PetscInt          n_solves;
  SchemeFigure      figure[SCHEME_MAX_FIGURES];
  PetscInt          n_figures;
  void             *data;
} Scheme;

PetscErrorCode LogStageGet(const char name[], PetscLogStage *stage);
PetscErrorCode SchemeLimit(const Flow *flow, StepLimit *limit);
PetscErrorCode SchemeChooseStep(Flow *flow);
PetscErrorCode SchemeAddSolve(LinearSolve *solve, Scheme *scheme);
PetscErrorCode SchemeAddFigure(SchemeFigure figure, Scheme *scheme);

/* All data of a step. A patch test has no clock, state or scheme. */
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

PetscErrorCode FlowPrepareOutput(const Flow *flow);

PetscErrorCode FlowStateCreate(Flow *flow);
PetscErrorCode FlowStateRegister(Flow *flow);
PetscErrorCode FlowStateRenumber(Flow *flow);
PetscErrorCode FlowSurfaceTension(Flow *flow);
PetscErrorCode FlowTensionMatrix(Flow *flow);
PetscErrorCode FlowStateDestroy(Flow *flow);
PetscErrorCode FlowMeanVelocity(const Flow *flow, const Vec u[], PetscReal mean[]);
PetscErrorCode FlowGetWork(Flow *flow, Vec *v);
PetscErrorCode FlowRestoreWork(Flow *flow, Vec *v);

/* The acceleration of the last step, and the error in time. */
PetscErrorCode AccelerationKeep(const Flow *flow);
PetscErrorCode AccelerationGet(const Flow *flow, PetscReal *const rate[]);
PetscErrorCode AccelerationRegister(Flow *flow);
PetscErrorCode AccelerationRemember(Flow *flow);

PetscErrorCode ConvectionApply(const Flow *flow, const Vec v[], PetscInt c, Vec u, Vec walls,
                               Vec work, Vec result);
PetscErrorCode ConvectionAddMatrix(const Flow *flow, const Vec v[], PetscInt c, Mat work, Vec rate,
                                   Mat sum);

PetscBool      VelocityFilterActsOnShear(const Flow *flow);
void           VelocityFilter(PetscInt dim, PetscReal A[][ISPH_MAX_DIM], const PetscReal r[],
                              PetscReal factor, PetscBool across, PetscReal dt, PetscReal change[]);
PetscErrorCode FlowFilter(Flow *flow);
PetscErrorCode VelocityFilterRates(Flow *flow, const Vec v[]);
PetscErrorCode VelocityFilterForget(Flow *flow);

/* The step, and its attempts. */
PetscErrorCode        FlowMakeStep(Flow *flow);
PetscErrorCode        FlowAssemble(Flow *flow);
extern const Judge    JudgeFailure;
PetscErrorCode        AttemptArrange(Flow *flow);
PetscErrorCode        AttemptDestroy(Attempt **attempt);
PetscErrorCode        AttemptBegin(Flow *flow);
PetscErrorCode        AttemptEnd(Flow *flow, PetscBool *again);
PetscErrorCode        AttemptNext(Flow *flow, PetscInt *k);
extern const Observer ObserverAcceleration;

/* Limits of steps. */
PetscErrorCode FlowLimit(const Flow *flow, StepLimit *limit);
PetscReal      ClockExplicitLimit(const Scene *scene, PetscReal support_radius);
PetscReal      CapillaryLimit(const Scene *scene);
PetscReal      InterfaceLimit(const Scene *scene);

/* Terms of the momentum equation. */
PetscErrorCode AddBodyForce(Flow *flow, PetscReal t, Vec force[]);
PetscErrorCode NoteUnbalancedForce(Flow *flow, const Vec force[]);
PetscErrorCode ConvectionExtrapolate(Flow *flow, PetscReal at, Vec force[]);
void FlowConvective(const Flow *flow, const PetscReal x[], const PetscReal u[], const PetscReal A[],
                    PetscReal N[]);
PetscErrorCode ConvectionPass(const Flow *flow, PetscReal t, const Vec v[]);
PetscErrorCode ConvectionTurn(const Flow *flow, PetscReal t, PetscReal scale, const Vec u[],
                              PetscInt c, Vec f);
PetscErrorCode ConvectionExplicit(Flow *flow, PetscReal t, const Vec u[], PetscInt c, Vec work,
                                  Vec result);
PetscErrorCode ConvectionOfCorrection(Flow *flow, PetscReal at, const Vec v[], Vec force[]);
PetscErrorCode VelocityExtrapolate(const Flow *flow, PetscReal at, const Vec v[]);
PetscErrorCode HistoryStart(Flow *flow, PetscBool history, PetscReal *dt);
/* Length of the step that frees the velocity at the start of divergence [dt]. */
#define FLOW_START_LENGTH 1e-6
PetscErrorCode FlowGiveStart(Flow *flow, PetscBool *moves);
PetscErrorCode FlowTakeStart(Flow *flow);

/* Norms, divergence and changes of velocities. */
PetscErrorCode FlowDivergence(const Flow *flow, const Vec u[], Vec div);
PetscErrorCode FlowAllVelocities(const Flow *flow, const Vec u[], PetscReal **all);
PetscErrorCode SolenoidalNorm(const Scene *scene, const Particles *particles, const Vec e[],
                              PetscReal *norm);
PetscReal      FlowRmsSpeed(const Flow *flow);
PetscErrorCode SteadyMeasure(Flow *flow);
PetscErrorCode SteadyView(const Flow *flow, PetscViewer viewer);
PetscErrorCode SteadyRefuse(const Flow *flow, const char projection[], PetscBool rotational);
PetscErrorCode TimeErrorStart(Flow *flow);
PetscErrorCode TimeErrorCheck(Flow *flow);

#endif
