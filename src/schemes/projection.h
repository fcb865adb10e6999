/* The projection scheme: its state, and the parts of its step in projection.c, motion.c,
   predictor.c, corrector.c and measure.c. */
#ifndef ISPH_PROJECTION_H
#define ISPH_PROJECTION_H

#include "isph/schemes.h"

/* Stages of a step as -log_view shows them. */
enum {
  EVENT_MOVE,
  EVENT_NEIGHBORS,
  EVENT_OPERATORS,
  EVENT_VISCOSITY,
  EVENT_PRESSURE,
  EVENT_CORRECT,
  EVENT_COUPLED,
  EVENT_COUNT
};

/* What scheme->number holds: for the steady test, the integrator, the bound of the velocity. */
enum {
  NUMBER_START,                  /* of the stretch of steps that means are taken over [s] */
  NUMBER_COUNT,                  /* steps of it so far */
  NUMBER_SUM,                    /* 3: of root mean squares of u, div u* and p, relative */
  NUMBER_MEAN = NUMBER_SUM + 3,  /* 3: their means over the stretch before */
  NUMBER_DIV  = NUMBER_MEAN + 3, /* root mean square of div u* in the last step [1/s] */
  NUMBER_SUBSTEP,                /* the last of the coupled scheme's integrator [s] */
  NUMBER_SPEED,                  /* root mean square of u at the start [m/s] */
  NUMBER_IMPULSE,                /* int max |f| dt [m/s] */
  NUMBER_FORCE,                  /* largest |f| so far [m/s^2] */
  NUMBER_WALLS,                  /* fastest flow that walls can have made so far [m/s] */
  NUMBER_BALANCE                 /* share of n.grad p at walls that the pressure has */
};

/* State on the particles (fields) and the vectors through which it is seen in the present epoch. */
typedef struct {
  PetscReal *u_previous[ISPH_MAX_DIM]; /* u^{n-1} (field) [m/s] */
  PetscReal *convection[ISPH_MAX_DIM]; /* (u.grad u)^{n-1} of fixed particles (field) [m/s^2] */
  PetscBool  has_convection;           /* whether that field exists */

  PetscInt epoch; /* the vectors below belong to this one */
  Vec      u[ISPH_MAX_DIM], u_prev[ISPH_MAX_DIM], conv_prev[ISPH_MAX_DIM], p; /* on fields */
  Vec      star[ISPH_MAX_DIM];                                                /* u*, then u^{n+1} */
  Vec      force[ISPH_MAX_DIM];                                               /* on u* [m/s^2] */
  Vec      conv[ISPH_MAX_DIM];          /* (u.grad u)^n, or the advecting velocity of IMEX */
  Vec      p_before, phi, b, div, work; /* */
  Vec      velocity_slope[ISPH_MAX_DIM][ISPH_MAX_DIM]; /* du_c/dx_a of moving particles */
  Vec      rough[ISPH_MAX_DIM]; /* what the filter would take from them [m/s] */

  PetscLogEvent event[EVENT_COUNT];
  PetscReal     k; /* u = u* - k/rho grad phi [s] */
} Projection;

PetscErrorCode ProjectionCreate(const Scene *scene, const Clock *clock, Operators *ops,
                                Scheme *scheme);
PetscErrorCode ProjectionRegister(const Scene *scene, Particles *particles, Scheme *scheme);
PetscErrorCode ProjectionStep(const Scene *scene, Clock *clock, Particles *particles,
                              Neighbors *neighbors, Operators *ops, Scheme *scheme);
PetscErrorCode ProjectionBegin(const Scene *scene, const Clock *clock, Particles *particles,
                               Neighbors *neighbors, Operators *ops, Scheme *scheme);
PetscErrorCode ProjectionDestroy(Scheme *scheme);

/* What makes u^{n+1} of a flow whose particles are where they will be. */
typedef PetscErrorCode (*FlowSolve)(const Scene *scene, const Clock *clock, Particles *particles,
                                    Operators *ops, Scheme *scheme);
PetscErrorCode FlowStep(const Scene *scene, Clock *clock, Particles *particles,
                        Neighbors *neighbors, Operators *ops, FlowSolve Solve, Scheme *scheme);
PetscErrorCode CoupledStep(const Scene *scene, Clock *clock, Particles *particles,
                           Neighbors *neighbors, Operators *ops, Scheme *scheme);

PetscErrorCode PredictorStart(const Scene *scene, const Clock *clock, const Particles *particles,
                              const Operators *ops, PetscBool history, PetscReal at, Scheme *scheme,
                              PetscReal *dt);
PetscErrorCode PredictVelocity(const Scene *scene, const Clock *clock, Particles *particles,
                               Operators *ops, Scheme *scheme);
PetscErrorCode AddBodyForce(const Scene *scene, PetscReal t, const Particles *particles,
                            Vec force[], Scheme *scheme);
PetscReal      PressureGain(const Clock *clock, const Scheme *scheme);
PetscErrorCode ProjectVelocity(const Scene *scene, const Clock *clock, const Particles *particles,
                               Operators *ops, Scheme *scheme);
PetscErrorCode ParticlesMove(const Scene *scene, const Clock *clock, Operators *ops,
                             Particles *particles, Scheme *scheme);
PetscErrorCode MeasureBegin(const Scene *scene, const Particles *particles, const Operators *ops,
                            Scheme *scheme);
PetscErrorCode StepMeasure(const Scene *scene, const Clock *clock, const Particles *particles,
                           const Operators *ops, Scheme *scheme);

#endif
