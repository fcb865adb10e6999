/* The projection scheme: its choices and state. Its options are in projectioncreate.c, the step in
   projection.c, the step's parts in predict.c, correct.c, pressure.c; onparticles.c,
   onsplines.c. */
#ifndef ISPH_PROJECTION_H
#define ISPH_PROJECTION_H

#include "schemes/diffusion/viscosity.h"
#include "schemes/stages/pressurepoints.h"

extern const Table       ProjectionTable, ConvectionTable;
extern const OptionTable ProjectionOptions;

/* The update of the pressure by the increment phi. */
typedef struct {
  const char *name, *brief, *citation;
  PetscBool   incremental; /* grad p^n acts in the predictor */
  PetscBool   rotational;  /* mu div u* is subtracted from p */
  PetscReal   alpha_max;   /* largest -ppe_alpha that does not grow: theory.md,
                              (projection:factors) */
} ProjectionRow;

/* The convective term of fixed particles. */
typedef struct {
  const char *name, *brief, *citation;
  PetscBool   implicit; /* in the viscous matrix */
} ConvectionRow;

typedef struct Pressure Pressure;

/* The space of the unknowns of the pressure: a row on the particles, and one on splines. The step
   is the same. Increment and pressure are vectors over the unknowns. */
typedef struct {
  PetscErrorCode (*Begin)(Flow *);       /* at the start, after a restart, after an undone step */
  PetscErrorCode (*StartStep)(Flow *);   /* before the predictor; NULL: nothing to do */
  PetscErrorCode (*FollowForce)(Flow *); /* after the predictor; NULL: nothing to do */
  Vec (*Unknowns)(const Flow *);         /* the pressure [Pa] */
  PetscErrorCode (*Solve)(Flow *);       /* for the increment phi, from div u_next */
  /* adds factor times the gradient of the pressure, or of phi, to vectors over fluid */
  PetscErrorCode (*Accelerate)(Flow *, PetscBool increment, PetscReal factor, const Vec u[]);
  PetscErrorCode (*Update)(Flow *, PetscReal gain);                   /* of the pressure by phi */
  PetscErrorCode (*SetFirstSource)(Flow *, const Vec force[], Vec b); /* of the first pressure */
} PressureSpace;

extern const PressureSpace PressureOnParticles, PressureOnSplines;

typedef struct {
  const ProjectionRow *row;              /* NULL: no pressure */
  const PressureSpace *space;            /* NULL: no pressure */
  PetscReal            alpha;            /* share of the density error in the pressure source [-] */
  PetscReal            filter;           /* strength of the grid-scale pressure filter [-] */
  Viscosity           *visc;             /* NULL: no viscosity */
  Splines             *splines;          /* NULL: the pressure is on the particles */
  PetscReal            spacing;          /* of the splines: edge of a cell [dx]; 0: none */
  Pressure            *ppe;              /* NULL: no pressure */
  PetscReal            wall_slope_share; /* share of full wall gradient in p [-] */
  PetscReal            k;                /* u = u* - k/rho grad phi [s] */
  PetscInt             epoch;            /* of the vectors below */
  Vec                  phi;              /* increment of the pressure on particles [Pa] */
} Projection;

/* projectioncreate.c */
PetscErrorCode ProjectionCreate(Flow *flow);

/* predict.c */
PetscErrorCode PredictVelocity(Flow *flow);

PetscErrorCode ProjectionForce(Flow *flow, PetscReal t, Vec force[]);

/* firstpressure.c */
PetscErrorCode ProjectionStart(Flow *flow);

/* correct.c */
PetscErrorCode ProjectVelocity(Flow *flow);

/* wallgradient.c */
PetscErrorCode WallGradientBegin(Flow *flow);
PetscErrorCode WallGradientPredict(Flow *flow);
PetscErrorCode WallGradientCorrect(Flow *flow, PetscReal gain);

/* pressuresolver.c */
typedef enum { PRESSURE_AMG, PRESSURE_GAMG, PRESSURE_LU, PRESSURE_TENSOR } PressureSolver;

PetscErrorCode PressureChoose(const Flow *flow, PressureSolver *solver);

/* pressure.c */
PetscErrorCode PressureCreate(Flow *flow, Pressure **ppe);
PetscErrorCode PressureDestroy(Pressure **ppe);
PetscErrorCode PressureSolve(Flow *flow, Vec b, Vec phi, Pressure *ppe);
PetscErrorCode PressureRefine(Flow *flow, const Vec b, Vec phi, Pressure *ppe);

#endif
