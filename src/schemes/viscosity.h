/* The viscous integrators: their state, and the callbacks in viscterms.c that a TS is
   given, the nonlinear solver in iteration.c. */
#ifndef ISPH_SCHEMES_VISCOSITY_H
#define ISPH_SCHEMES_VISCOSITY_H

#include "isph/guard.h"

typedef struct {
  Viscosity *visc;
  PetscInt   c; /* component */
} Component;

struct Viscosity {
  const ViscousIntegratorRow *row;
  PetscInt                    dim;
  PetscInt                    systems;          /* one for each component, or one of all together */
  PetscBool                   nonlinear;        /* the viscosity follows the strain rate */
  TS                          ts[ISPH_MAX_DIM]; /* they share the SNES's KSP of the first */
  Component                   component[ISPH_MAX_DIM];
  KSP                         ksp; /* NULL: explicit */
  Guard                       guard;
  PetscInt                    iterations;
  Mat                         J;                    /* shift I - nu A */
  PetscReal                   shift;                /* in J; NaN: J is not yet made [1/s] */
  PetscInt                    assemblies;           /* stamp of the operators in J */
  Vec       boundary[ISPH_MAX_DIM], gradient, work; /* B u_wall,c at wall_t; work */
  PetscReal wall_t;
  Vec       all, all_force, all_walls; /* of all components: velocity, force, walls' velocity */
  Vec       part[ISPH_MAX_DIM];        /* their components; work */

  const Scene *scene; /* of the solve at hand, for the callbacks */
  Particles   *particles;
  Operators   *ops;
  PetscReal    projection_factor;
  const Vec   *force, *advecting;
};

PetscErrorCode IterationChoose(SNES snes);
PetscErrorCode IterationFallBack(Viscosity *visc, const StepFailure *failure, PetscBool *again);
PetscErrorCode IterationGoBack(Viscosity *visc);
PetscErrorCode IterationSetTolerance(Viscosity *visc, PetscReal t, Vec u);
PetscErrorCode IterationCheck(TS ts, const char where[], StepFailure *failure);
PetscErrorCode ViscosityScale(Viscosity *visc, PetscReal t, Vec u, Vec force, PetscReal *scale);
PetscErrorCode ViscosityIFunction(TS ts, PetscReal t, Vec u, Vec udot, Vec f, void *ctx);
PetscErrorCode ViscosityIJacobian(TS ts, PetscReal t, Vec u, Vec udot, PetscReal shift, Mat J,
                                  Mat P, void *ctx);
PetscErrorCode ViscosityRHSFunction(TS ts, PetscReal t, Vec u, Vec f, void *ctx);

#endif
