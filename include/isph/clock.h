/*
  The clock: the only owner of time, and of how long steps are. It also holds what stops a step.
*/
#ifndef ISPH_CLOCK_H
#define ISPH_CLOCK_H

#include "isph/scene.h"

#define CLOCK_MAX_REPORTS 32
/* Holds in every map of docs/results/stability.md. Shorter steps of moving particles are not
   better: the energy of the cavity at Re = 1000, n = 100, t = 40 is 1.7, 1.2, 0.5 % too large with
   0.25, 0.4, 0.5. */
#define CLOCK_CFL   0.5
#define CLOCK_WHERE 64 /* room for the text of ClockWhere() */

/*
  The reason why a step failed. The step ends early and the run decides: it ends with the sentence,
  or undoes the step and tries a shorter one.
*/
typedef struct {
  PetscErrorCode code;          /* 0: none; else PETSC_ERR_NOT_CONVERGED or PETSC_ERR_FP */
  PetscBool      fatal;         /* a shorter step would not help */
  char           sentence[640]; /* step, quantity, likely cause and remedy */
} StepFailure;
void FailureSet(StepFailure *failure, PetscErrorCode code, const char format[], ...)
    PETSC_ATTRIBUTE_FORMAT(3, 4);

/* The longest step that a scheme allows, and the limit that sets it. */
typedef struct {
  PetscReal   dt; /* [s] */
  const char *reason;
} StepLimit;
void StepLimitLower(StepLimit *limit, PetscReal dt, const char reason[]);

/*
  The numbers that a run remembers from step to step, by name. They are undone with a failed step
  (counters are not), and a checkpoint holds them. The owner keeps the storage.
*/
#define MEMORY_MAX 48
typedef struct {
  char       name[32];
  PetscReal *real;    /* or */
  PetscInt  *integer; /* the other is NULL */
  PetscBool  counter; /* goes on when a step is undone */
} MemoryItem;
typedef struct {
  MemoryItem item[MEMORY_MAX];
  PetscInt   n;
} Memory;
PetscErrorCode MemoryAddReal(Memory *memory, const char name[], PetscReal *value);
PetscErrorCode MemoryAddInt(Memory *memory, const char name[], PetscInt *value);
PetscErrorCode MemoryAddCounter(Memory *memory, const char name[], PetscInt *value);
void           MemoryGet(const Memory *memory, PetscReal values[]);
void           MemorySet(const Memory *memory, PetscBool counters, const PetscReal values[]);

/* How the length of steps follows the flow. */
typedef struct {
  const char *name, *brief, *citation;
  PetscBool   follows; /* the present speed and the body force, else -dt or the reference speed */
  PetscBool   retries; /* a step that fails is undone and made in shorter ones */
} DtAdaptRow;
extern const Table DtAdaptTable;

/* Time, owned by the run; all second-order formulas use variable-step coefficients. */
typedef struct {
  PetscReal t, dt, dt_previous; /* [s]; dt_previous = 0 before the second step */
  PetscReal dt_wanted;          /* dt without the next report; a run of one step: dt [s] */
  PetscInt  step;               /* finished steps */
  PetscReal t_first;            /* start of this process: a restart has time and */
  PetscInt  step_first;         /* steps behind it [s] */
  PetscReal t_end;              /* [s] */
  PetscInt  max_steps;
  PetscReal dt_given, cfl;                  /* -dt, or else dt = cfl dx/speed [s], [-] */
  PetscInt  order;                          /* of the time integration, 1 or 2 */
  PetscReal steady_tol;                     /* 0: off [-] */
  PetscReal report_time[CLOCK_MAX_REPORTS]; /* times the steps must hit, ascending [s] */
  PetscInt  n_reports, next_report;
  PetscBool steady;       /* steady_tol was met, or the steady flow solved for */
  PetscBool steady_solve; /* no du/dt: one step to t_end */

  const DtAdaptRow *adapt;
  PetscReal         move_max;    /* displacement in a step above which it has failed [dx] */
  PetscInt          retries;     /* steps undone so far */
  PetscInt          halvings;    /* dt is divided by 2^halvings */
  PetscInt          good_needed; /* good steps after which halvings is lowered */
  PetscInt          good;        /* steps since the last failure or lowering */
} Clock;

PetscErrorCode ClockCreate(const Scene *scene, Clock **clock);
PetscErrorCode ClockDestroy(Clock **clock);
PetscErrorCode ClockRemember(Clock *clock, Memory *memory);
PetscErrorCode ClockRestart(Clock *clock);
PetscErrorCode ClockChoose(const StepLimit *limit, Clock *clock);
PetscErrorCode ClockAdvance(Clock *clock);
PetscErrorCode ClockRetry(Clock *clock, StepFailure *failure);
PetscReal      ClockRatio(const Clock *clock);
PetscBool      ClockPasses(PetscReal every, PetscReal last, PetscReal now);
PetscErrorCode ClockWhere(const Clock *clock, char where[]);
PetscReal      ClockMoment(const Clock *clock);
PetscReal      ClockExplicitLimit(const Scene *scene, PetscReal support_radius);

#endif
