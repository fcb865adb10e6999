/* State and functions of the viscous step, for any scheme. terms.c has its callbacks, iteration.c
   the nonlinear solver, and integrators.c the table of integrators. */
#ifndef ISPH_SCHEMES_VISCOSITY_H
#define ISPH_SCHEMES_VISCOSITY_H

#include "isph/solvers.h"

extern const Table       ViscousIntegratorTable;
extern const OptionTable ViscosityOptions;

/* Callbacks of the terms of the viscous equation. */
typedef enum {
  TIME_IMPLICIT, /* IFunction: viscosity; convection in the force, or implicit */
  TIME_IMEX,     /* IFunction: viscosity; RHSFunction: convection */
  TIME_EXPLICIT  /* RHSFunction: all terms */
} ViscousTerms;
typedef struct {
  const char  *name, *brief, *citation; /* name: the TS type */
  ViscousTerms terms;
  PetscBool    history;     /* starts from (4u^n - u^{n-1})/3, for second order */
  PetscBool    substeps;    /* estimates the error of a step from this step alone */
  PetscBool    end_of_step; /* time of the force: end of the step, otherwise its middle */
} ViscousIntegratorRow;

typedef struct Viscosity Viscosity;
typedef struct {
  Viscosity *visc;
  PetscInt   c; /* component */
} Component;

struct Viscosity {
  const ViscousIntegratorRow *row;
  PetscInt                    dim;
  PetscInt                    systems;          /* one for each component, or a single system */
  PetscBool                   nonlinear;        /* the viscosity depends on the strain rate */
  TS                          ts[ISPH_MAX_DIM]; /* they share the KSP of the first */
  Component                   component[ISPH_MAX_DIM];
  Guard                       guard;         /* its KSP is NULL for explicit integrators */
  Mat                         J;             /* shift I - nu A */
  PetscBool                   shell;         /* J only has products and a diagonal */
  PetscReal                   shift;         /* in J; NaN: J is out of date [1/s] */
  Mat                         newton;        /* Jacobian of a rheology, J its preconditioner */
  Mat                         convection;    /* work matrix; NULL: convection not in J */
  const AffineOperator       *operator_of_J; /* the A in J */
  PetscInt                    assemblies;    /* stamp of the operators in J */
  PetscInt                    epoch;         /* epoch of the vectors below */
  Vec       boundary; /* B u_wall at wall_t, of all components in a single system */
  PetscReal wall_t;
  Vec       all, all_force, all_walls; /* of all components: velocity, force, wall velocity */
  Vec       part[ISPH_MAX_DIM];        /* their components; work vectors */

  StressTangent *tangent;             /* of the present solve, of a rheology */
  PetscReal      residual, tolerance; /* of the last iteration for a rheology [m/s^2] */

  Flow      *flow;              /* of the present solve, for callbacks */
  PetscReal  projection_factor; /* see WallValuesSetVelocity() */
  const Vec *force, *advecting;
};

PetscErrorCode ViscosityCreate(Flow *flow, Viscosity **visc);
PetscErrorCode ViscosityDestroy(Viscosity **visc);
PetscErrorCode ViscositySolve(Flow *flow, PetscReal dt, PetscReal projection_factor,
                              const Vec force[], const Vec advecting[], Vec u[], Viscosity *visc);
PetscErrorCode ViscosityView(const Viscosity *visc, PetscViewer viewer);

/* iteration.c */
PetscErrorCode IterationChoose(Viscosity *visc, SNES snes);
PetscErrorCode IterationCheck(TS ts, const char where[], StepFailure *failure);
PetscErrorCode IterationView(const Viscosity *visc, PetscViewer viewer);

/* terms.c */
PetscErrorCode ViscosityLinearise(Viscosity *visc, Vec u);
PetscErrorCode ViscosityCreateNewton(Viscosity *visc);
PetscErrorCode ViscosityIFunction(TS ts, PetscReal t, Vec u, Vec udot, Vec f, void *ctx);
PetscErrorCode ViscosityIJacobian(TS ts, PetscReal t, Vec u, Vec udot, PetscReal shift, Mat J,
                                  Mat P, void *ctx);
PetscErrorCode ViscosityRHSFunction(TS ts, PetscReal t, Vec u, Vec f, void *ctx);

#endif
