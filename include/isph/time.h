/* The clock owns the time and the length of steps. This header also has the reason for a failed
   step. */
#ifndef ISPH_TIME_H
#define ISPH_TIME_H

#include "isph/scene.h"

extern const OptionTable TimeOptions;

#define CLOCK_MAX_REPORTS 32
/* The default CFL number, which is stable in every map of results/stability.md. In the cavity
   at Re = 1000, n = 50, t = 40, the energy of moving particles is 1.9, 0.4 and 0.2 % too small with
   CFL numbers of 1, 0.5 and 0.25. */
#define CLOCK_CFL  0.5
#define CLOCK_RTOL 5e-4 /* default of -dt_rtol */
/* Steps at the start with -time_order 3: their number, and the ratio in which they grow. Ratios
   below CLOCK_STABLE keep BDF3, which is zero-stable up to 1.534: M. Calvo, T. Grande, R. D.
   Grigorieff, Numer. Math. 57 (1990) 39-50. */
#define CLOCK_SHORT  8
#define CLOCK_GROWTH 1.5
#define CLOCK_STABLE 1.53
#define CLOCK_WHERE  64 /* length of the text of ClockWhere() */

/* The reason for a failed step. The step ends early; then the run either ends and prints the
   sentence, or undoes the step and tries a shorter step. */
typedef struct {
  PetscErrorCode code;          /* 0: none; else PETSC_ERR_NOT_CONVERGED or PETSC_ERR_FP */
  PetscBool      fatal;         /* a shorter step would not help */
  PetscReal      dt_next;       /* length with which the step is repeated; 0: half of it [s] */
  char           sentence[640]; /* step, quantity, likely cause and remedy */
} StepFailure;
void FailureSet(StepFailure *failure, PetscErrorCode code, const char format[], ...)
    PETSC_ATTRIBUTE_FORMAT(3, 4);

/* The longest step that a scheme allows, and the reason for the limit. */
typedef struct {
  PetscReal   dt; /* [s] */
  const char *reason;
} StepLimit;
void StepLimitLower(StepLimit *limit, PetscReal dt, const char reason[]);

/* Named numbers that a run keeps from step to step. The run restores them when it undoes a step
   (except counters) and writes them to checkpoints. Their owners keep the storage. */
#define MEMORY_MAX 96
typedef struct {
  char       name[32];
  PetscReal *real;    /* an array; NULL for an integer */
  PetscInt   count;   /* of numbers */
  PetscInt  *integer; /* NULL for real numbers */
  PetscBool  counter; /* keeps its value when a step is undone */
} MemoryItem;
typedef struct {
  MemoryItem item[MEMORY_MAX];
  PetscInt   n, size; /* items, and the numbers in them */
} Memory;
PetscErrorCode MemoryAddReal(Memory *memory, const char name[], PetscReal *value);
PetscErrorCode MemoryAddReals(Memory *memory, const char name[], PetscInt count,
                              PetscReal values[]);
PetscErrorCode MemoryAddInt(Memory *memory, const char name[], PetscInt *value);
PetscErrorCode MemoryAddCounter(Memory *memory, const char name[], PetscInt *value);
void           MemoryGet(const Memory *memory, PetscReal values[]);
PetscBool      MemoryFits(const Memory *memory, const PetscReal values[]);
void           MemorySet(const Memory *memory, PetscBool counters, const PetscReal values[]);

/* Control of the step length. */
typedef struct {
  const char *name, *brief, *citation;
  PetscBool   follows;   /* dt depends on present speed and body force; otherwise on -dt or U */
  PetscBool   retries;   /* a failed step is undone and repeated in shorter steps */
  PetscBool   estimates; /* dt depends on an estimate of the error in time, too */
} DtAdaptRow;
extern const Table DtAdaptTable;

/* Control of the step length by the error in time; see timeerror.c. */
typedef struct {
  PetscReal rtol;     /* largest error of a step, in units of the velocity scale [-] */
  PetscReal dt;       /* longest next step; infinite without control [s] */
  PetscReal last;     /* error of the last good step over its tolerance; 0: unknown [-] */
  PetscReal speed;    /* largest root mean square of the velocity so far [m/s] */
  PetscInt  rejected; /* number of steps repeated because of their error */
} StepControl;

/* Time, owned by the run; all second-order formulas use variable-step coefficients. */
typedef struct {
  PetscReal t, dt, dt_previous; /* [s]; dt_previous = 0 before the second step */
  PetscReal dt_before;          /* length of the step before the previous step [s] */
  PetscReal jump;       /* share of order 1 in the formulas of a step; see velocityjump.c [-] */
  PetscReal jump_next;  /* the same in the next path [-] */
  PetscReal dt_wanted;  /* dt before a report time shortens it; dt in a run of one step [s] */
  PetscInt  step;       /* finished steps */
  PetscReal t_first;    /* time at the start of this process, not 0 after a restart [s] */
  PetscInt  step_first; /* steps at the start of this process */
  PetscReal t_end;      /* [s] */
  PetscInt  max_steps;
  PetscReal dt_given, cfl;                  /* -dt; otherwise dt = cfl dx/speed [s], [-] */
  PetscReal dt_max;                         /* upper bound of dt if -dt is not given [s] */
  PetscInt  order;                          /* of the time integration, 1 to 3 */
  PetscReal steady_tol;                     /* 0: off [-] */
  PetscReal report_time[CLOCK_MAX_REPORTS]; /* times that steps must hit, ascending [s] */
  PetscInt  n_reports, next_report;
  PetscReal until;        /* a step ends there, if it is later than t [s] */
  PetscReal land_every;   /* steps end at its multiples; 0: no such interval [s] */
  PetscBool steady;       /* steady_tol was met, or the steady solve is done */
  PetscBool steady_solve; /* no du/dt: a single step to t_end */

  const DtAdaptRow *adapt;
  StepControl       control;     /* with -dt_adapt error */
  PetscInt          retries;     /* number of undone steps */
  PetscInt          halvings;    /* the limit of dt is divided by 2^halvings */
  PetscReal         limit;       /* of dt in this step, without halvings [s] */
  PetscInt          good_needed; /* good steps before halvings decreases */
  PetscInt          good;        /* good steps since the last change of halvings */
} Clock;

PetscErrorCode ClockCreate(const Scene *scene, Clock **clock);
PetscErrorCode ClockDestroy(Clock **clock);
PetscErrorCode ClockRemember(Clock *clock, Memory *memory);
PetscErrorCode ClockRestart(Clock *clock);
PetscErrorCode ClockChoose(const StepLimit *limit, Clock *clock);
PetscErrorCode ClockAdvance(Clock *clock);
PetscErrorCode ClockRetry(Clock *clock, StepFailure *failure);
PetscErrorCode ClockDropEstimate(Clock *clock, const char option[], const char integrator[]);
PetscReal      ClockRatio(const Clock *clock);
PetscInt       ClockOrder(const Clock *clock);
PetscReal      ClockShortening(const Clock *clock);
PetscBool      ClockPasses(PetscReal every, PetscReal last, PetscReal now);
PetscReal      ClockNext(PetscReal every, PetscReal t);
PetscErrorCode ClockWhere(const Clock *clock, char where[]);
PetscReal      ClockMoment(const Clock *clock);

/* Formulas in time for steps of unequal lengths, see src/time/history.c. */
#define HISTORY 3 /* most earlier velocities in a formula */
void      HistoryAhead(const Clock *clock, PetscReal at, PetscReal weight[HISTORY]);
void      HistoryPredict(const Clock *clock, PetscInt n, PetscReal weight[HISTORY]);
void      HistoryPath(const Clock *clock, PetscReal weight[HISTORY]);
PetscReal HistoryStartWeights(const Clock *clock, PetscReal weight[HISTORY]);

#endif
