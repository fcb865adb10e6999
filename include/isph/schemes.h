/*
  Schemes: one step of the flow. The Clock owns time; the viscous TS and the pressure KSP are told
  what to do and asked how it went.
*/
#ifndef ISPH_SCHEMES_H
#define ISPH_SCHEMES_H

#include "isph/operators.h"

#define CLOCK_MAX_REPORTS 32
/* Held in every map of docs/results/stability.md. Shorter steps of moving particles are not better:
   at Re = 1000, n = 100, t = 40 the cavity has 1.7, 1.2, 0.5 % too much energy with 0.25, 0.4,
   0.5. */
#define CLOCK_CFL   0.5
#define CLOCK_WHERE 64 /* room for what ClockWhere() says */

/*
  What went wrong in a step. The step ends early and the run decides: to end with the sentence, or
  to undo the step and try a shorter one.
*/
typedef struct {
  PetscErrorCode code;          /* 0: nothing; else PETSC_ERR_NOT_CONVERGED or PETSC_ERR_FP */
  PetscBool      fatal;         /* a shorter step would not help */
  char           sentence[640]; /* step, quantity, likely cause and remedy */
} StepFailure;
void FailureSet(StepFailure *failure, PetscErrorCode code, const char format[], ...)
    PETSC_ATTRIBUTE_FORMAT(3, 4);

/* How the length of steps follows the flow. */
typedef struct {
  const char *name, *brief, *citation;
  PetscBool   follows; /* the present speed and the body force, else -dt or the reference speed */
  PetscBool   retries; /* a step that fails is undone and made in shorter ones */
} DtAdaptRow;
extern const Table DtAdaptTable;

/* Time, owned by the run; everything second order uses variable-step coefficients. */
typedef struct {
  PetscReal t, dt, dt_previous; /* [s]; dt_previous = 0 before the second step */
  PetscReal dt_wanted;          /* dt if no report were due; a run that is one step, that one [s] */
  PetscInt  step;               /* finished steps */
  PetscReal t_first;            /* where this process began: a restart has time and */
  PetscInt  step_first;         /* steps behind it [s] */
  PetscReal t_end;              /* [s] */
  PetscInt  max_steps;
  PetscReal dt_given, cfl;                  /* -dt, or else dt = cfl dx/speed [s], [-] */
  PetscReal steady_tol;                     /* 0: off [-] */
  PetscReal report_time[CLOCK_MAX_REPORTS]; /* times the steps must hit, ascending [s] */
  PetscInt  n_reports, next_report;
  PetscBool steady;       /* steady_tol was met, or the steady flow solved for */
  PetscBool steady_solve; /* no du/dt: one step to t_end */

  const DtAdaptRow *adapt;
  PetscReal         move_max;    /* displacement in a step above which it has failed [dx] */
  PetscInt          retries;     /* steps undone so far */
  PetscInt          halvings;    /* dt is what it would be over 2^cut */
  PetscInt          good_needed; /* good steps after which cut is lessened */
  PetscInt          good;        /* steps since the last failure or lessening */
} Clock;

PetscErrorCode ClockCreate(const Scene *scene, Clock **clock);
PetscErrorCode ClockDestroy(Clock **clock);
PetscErrorCode ClockChoose(const Scene *scene, PetscReal speed, PetscReal force, Clock *clock);
PetscErrorCode ClockAdvance(Clock *clock);
PetscErrorCode ClockRetry(Clock *clock, StepFailure *failure);
PetscReal      ClockRatio(const Clock *clock);
PetscBool      ClockPasses(PetscReal every, PetscReal last, PetscReal now);
PetscErrorCode ClockWhere(const Clock *clock, char where[]);
PetscReal      ClockMoment(const Clock *clock);
PetscReal      ClockExplicitLimit(const Scene *scene, PetscReal support_radius);

/* How a TS type is used: which callback carries viscosity and which convection. */
typedef enum {
  TIME_IMPLICIT, /* IFunction: viscosity; convection extrapolated into the force */
  TIME_IMEX,     /* IFunction: viscosity; RHSFunction: convection */
  TIME_EXPLICIT  /* RHSFunction: everything */
} ViscousTerms;
typedef struct {
  const char  *name, *brief, *citation; /* name: the TS type */
  ViscousTerms kind;
  PetscBool    history;         /* one stage: starts from (4u^n - u^{n-1})/3 for second order */
  PetscBool    multistep;       /* PETSc keeps earlier velocities; they cannot follow particles */
  PetscBool    end_of_step;     /* the force is taken at the end of the step, else at its middle */
  PetscReal (*Response)(TS ts); /* of u* to a force newly switched on, over dt; NULL: 1 */
} ViscousIntegratorRow;
extern const Table ViscousIntegratorTable;
PetscErrorCode     TimeOptionsRefuse(const char prefix[], const char type[]);

typedef struct Viscosity    Viscosity;
PetscErrorCode              ViscosityCreate(const Scene *scene, PetscReal dt, const Operators *ops,
                                            Viscosity **visc);
PetscErrorCode              ViscosityDestroy(Viscosity **visc);
PetscErrorCode              ViscosityRenumber(const Particles *particles, Viscosity *visc);
const ViscousIntegratorRow *ViscosityIntegrator(const Viscosity *visc);
PetscErrorCode ViscositySolve(const Scene *scene, const Clock *clock, Particles *particles,
                              PetscReal dt, PetscReal projection_factor, const Vec force[],
                              const Vec advecting[], Operators *ops, Vec u[], Viscosity *visc,
                              StepFailure *failure);
PetscReal      ViscosityResponse(const Viscosity *visc);
PetscErrorCode ViscosityNames(const Viscosity *visc, const char **ts, const char **ksp,
                              const char **pc);
PetscErrorCode ViscosityIteration(const Viscosity *visc, const char **snes, const char **search);
Mat            ViscosityMatrix(const Viscosity *visc);
PetscInt      *ViscosityFalls(Viscosity *visc);
const char    *ViscosityNote(const Viscosity *visc);
PetscInt       ViscosityIterations(const Viscosity *visc); /* of the last solve, all components */

PetscErrorCode ConvectionCentral(PetscInt dim, const Operators *ops, const Vec v[], Vec u,
                                 Vec walls, Vec work, Vec result);
PetscErrorCode ConvectionApply(const Scene *scene, const Operators *ops, const Vec v[], Vec u,
                               Vec walls, Vec work, Vec result);

typedef struct Pressure Pressure;
PetscErrorCode          PressureCreate(const Operators *ops, Pressure **ppe);
PetscErrorCode          PressureDestroy(Pressure **ppe);
PetscErrorCode PressureSolve(const Clock *clock, const Particles *particles, const Operators *ops,
                             Vec b, Vec phi, Pressure *ppe, StepFailure *failure);
PetscErrorCode PressureNames(const Pressure *ppe, const char **ksp, const char **pc);
PetscInt      *PressureFalls(Pressure *ppe);
const char    *PressureNote(const Pressure *ppe);
PetscInt       PressureIterations(const Pressure *ppe); /* of the last solve */

/* Particle shifting: where to move particles so that they stay evenly spread. */
typedef struct {
  const char *name, *brief, *citation;
  void (*Displace)(const Scene *scene, PetscReal strength, PetscReal speed, PetscReal rate,
                   PetscReal dt, const PetscReal gradient_c[],
                   PetscReal displacement[]); /* NULL: none */
  PetscReal disturbance; /* random, in the first step, which breaks the symmetry of lattices [dx] */
} ShiftRow;
extern const Table ShiftTable;

/* How the new pressure follows from the increment phi. */
typedef struct {
  const char *name, *brief, *citation;
  PetscBool   incremental; /* the predictor feels grad p^n */
  PetscBool   rotational;  /* p loses mu div u* */
} ProjectionRow;
extern const Table ProjectionTable;

/* What a step did, for progress, the steady test and the report. */
typedef struct {
  PetscReal speed_max;         /* largest particle speed [m/s] */
  PetscReal wall_speed_bound;  /* fastest flow that walls have been able to make [m/s] */
  PetscReal force_max;         /* largest body force per unit mass [m/s^2] */
  PetscReal kinetic_energy;    /* [J] (per metre of depth in 2D) */
  PetscReal divergence;        /* largest |D u| [1/s] */
  PetscReal change[3];         /* of u, div u* and p, relative, per shortest time scale [-] */
  PetscInt  visc_its, ppe_its; /* of the last step */
  PetscInt  visc_its_sum, ppe_its_sum;
} StepStats;

/* What stands for the inverse of the Schur complement of the pressure, see schur.c. */
typedef struct Schur Schur;
typedef struct {
  const char *name, *brief, *citation;
  PetscBool   poisson; /* it needs the pressure Laplacian */
  PetscErrorCode (*Apply)(Schur *schur, Vec x, Vec y);
} SchurRow;
extern const Table SchurTable;

/* How the coupled scheme goes through a step. */
typedef struct {
  const char *name, *brief, *citation; /* name: the TS type */
  PetscBool   substeps; /* several a step, as long as their error allows; else one, with history */
} CoupledIntegratorRow;
extern const Table CoupledIntegratorTable;

typedef struct Scheme       Scheme;
typedef struct Coupled      Coupled;
PetscErrorCode              CoupledCreate(const Scene *scene, PetscReal dt, PetscBool convects,
                                          Coupled **coupled);
PetscErrorCode              CoupledDestroy(Coupled **coupled);
PetscErrorCode              CoupledNames(const Coupled *coupled, const char **ts, const char **ksp,
                                         const char **pc);
const CoupledIntegratorRow *CoupledIntegrator(const Coupled *coupled);
const SchurRow             *CoupledSchur(const Coupled *coupled);
PetscInt                   *CoupledFalls(Coupled *coupled);
const char                 *CoupledNote(const Coupled *coupled);
PetscInt                    CoupledIterations(const Coupled *coupled); /* of the last step */

typedef struct {
  const char *name, *brief, *citation;
  PetscBool   splits; /* velocity and pressure are solved for in turn */
  PetscErrorCode (*Create)(const Scene *scene, const Clock *clock, Operators *ops, Scheme *scheme);
  PetscErrorCode (*Register)(const Scene *scene, Particles *particles, Scheme *scheme);
  PetscErrorCode (*Begin)(const Scene *scene, const Clock *clock, Particles *particles,
                          Neighbors *neighbors, Operators *ops, Scheme *scheme);
  PetscErrorCode (*Step)(const Scene *scene, Clock *clock, Particles *particles,
                         Neighbors *neighbors, Operators *ops, Scheme *scheme);
  PetscErrorCode (*Destroy)(Scheme *scheme);
} SchemeRow;
extern const Table SchemeTable;

#define SCHEME_NUMBERS 15
struct Scheme {
  const SchemeRow     *row;
  const ProjectionRow *projection; /* NULL: no pressure */
  const ShiftRow      *shift;
  PetscReal            shift_strength;
  PetscInt             time_order;
  PetscReal            alpha;      /* share of the density error in the pressure source [-] */
  PetscReal            filter;     /* strength of the grid-scale pressure filter [-] */
  PetscReal            force_step; /* largest body force met in the step [m/s^2] */
  Viscosity           *visc;
  Pressure            *ppe;
  Coupled             *coupled; /* in place of both; NULL: they are there */
  StepStats            stats;
  StepFailure          failure;                /* of the step just tried */
  PetscReal            number[SCHEME_NUMBERS]; /* what else a step remembers of those before it */
  void                *data;
};

PetscErrorCode SchemeCreate(const Scene *scene, const Clock *clock, Operators *ops,
                            Scheme **scheme);
PetscErrorCode SchemeRegister(const Scene *scene, Particles *particles, Scheme *scheme);
PetscErrorCode SchemeDestroy(Scheme **scheme);

/* The flow before a step, to go back to. */
typedef struct Undo Undo;
PetscErrorCode      UndoCreate(Undo **undo);
PetscErrorCode      UndoDestroy(Undo **undo);
PetscErrorCode      UndoSave(const Clock *clock, const Particles *particles, const Scheme *scheme,
                             Undo *undo);
PetscErrorCode UndoRestore(const Scene *scene, const Undo *undo, Clock *clock, Particles *particles,
                           Neighbors *neighbors, Operators *ops, Scheme *scheme);

#endif
