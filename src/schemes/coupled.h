/*
  Velocity and pressure in one system: the solver in coupled.c, its terms in coupledterms.c, its
  matrix in saddle.c, the Schur complement in schur.c, the step in monolith.c.
*/
#ifndef ISPH_SCHEMES_COUPLED_H
#define ISPH_SCHEMES_COUPLED_H

#include "isph/guard.h"
#include "saddle.h"

/* The inverse of the Schur complement of the pressure, approximated. */
struct Schur {
  const SchurRow *row;
  Mat             mass;           /* that of row mass, for PETSc */
  Mat             poisson;        /* -dx^2 lap + 1e-6 [-] */
  KSP             ksp;            /* for that; NULL: not needed */
  Vec             work;           /* */
  PetscReal       viscous, inert; /* nu/sigma, shift dx^2/sigma, see schur.c [-] */
};

PetscErrorCode SchurCreate(Schur *schur);
PetscErrorCode SchurAssemble(const Particles *particles, const Operators *ops, Schur *schur);
PetscErrorCode SchurAttach(PC fieldsplit, Schur *schur);
PetscErrorCode SchurFree(Schur *schur);

struct Coupled {
  const CoupledIntegratorRow *row;
  TS                          ts;
  KSP                         ksp;
  Guard                       guard;
  Saddle                      saddle;
  Mat                         flat; /* its P, where the preconditioner knows no blocks; else NULL */
  Schur                       schur;
  PetscReal                   shift;      /* that the preconditioner was made for [1/s] */
  Vec                         x, b;       /* the unknowns; the right-hand side at b_t [m/s] */
  PetscReal                   b_t;        /* NaN: b is to be made [s] */
  Vec                         part, work; /* of one component */
  Vec      u[ISPH_MAX_DIM];               /* components of x, for convection at a stage [m/s] */
  PetscInt iterations;

  const Scene     *scene; /* of the step at hand, for the callbacks */
  const Particles *particles;
  Operators       *ops;
  Scheme          *scheme;
  Vec             *force;     /* [m/s^2] */
  PetscBool        stages;    /* made anew at each stage, without convection */
  PetscBool        convects;  /* which each stage takes on its own */
  const Vec       *advecting; /* v of implicit convection; NULL: none [m/s] */
};

PetscErrorCode CoupledAssemble(const Clock *clock, PetscReal shift, const Vec advecting[],
                               Coupled *coupled);
PetscErrorCode CoupledSetShift(PetscReal shift, Coupled *coupled);
PetscErrorCode CoupledRightHandSide(Coupled *coupled, PetscReal t);
PetscErrorCode CoupledAddConvection(Coupled *coupled, Vec x, PetscReal scale, Vec f);
PetscErrorCode CoupledIFunction(TS ts, PetscReal t, Vec x, Vec xdot, Vec f, void *ctx);
PetscErrorCode CoupledIJacobian(TS ts, PetscReal t, Vec x, Vec xdot, PetscReal shift, Mat A, Mat P,
                                void *ctx);

#endif
