/*
  The coupled scheme: velocity and pressure in one system. Its row and options are in coupled.c, the
  solver in solver.c, its terms in terms.c, its matrix in saddle.c, the Schur complement in schur.c,
  the step in step.c.
*/
#ifndef ISPH_SCHEMES_COUPLED_H
#define ISPH_SCHEMES_COUPLED_H

#include "isph/guard.h"
#include "saddle.h"
#include "schemes/step.h"

/* How the coupled scheme advances in time. */
typedef struct {
  const char *name, *brief, *citation; /* name: the TS type */
  PetscBool   substeps; /* several a step, as long as their error allows; else one, with history */
} CoupledIntegratorRow;

/* The approximation of the inverse of the Schur complement of the pressure, see schur.c. */
typedef struct Schur Schur;
typedef struct {
  const char *name, *brief, *citation;
  PetscBool   poisson; /* it needs the pressure Laplacian */
  PetscErrorCode (*Apply)(Schur *schur, Vec x, Vec y);
} SchurRow;

struct Schur {
  const SchurRow *row;
  Mat             mass;           /* that of row mass, for PETSc */
  Mat             poisson;        /* -dx^2 lap + 1e-6 [-] */
  KSP             ksp;            /* for that; NULL: not needed */
  SolverView      view;           /* -coupled_schur_ksp_view */
  Vec             work;           /* */
  PetscReal       viscous, inert; /* nu/sigma, shift dx^2/sigma, see schur.c [-] */
};

PetscErrorCode SchurCreate(Schur *schur);
PetscErrorCode SchurAssemble(const Particles *particles, const Operators *ops, Schur *schur);
PetscErrorCode SchurAttach(PC fieldsplit, Schur *schur);
PetscErrorCode SchurFree(Schur *schur);

typedef struct {
  const CoupledIntegratorRow *row;
  TS                          ts;
  Guard                       guard;
  Saddle                      saddle;
  Mat                         flat; /* its P, if the preconditioner takes no blocks; else NULL */
  Schur                       schur;
  PetscReal                   shift;      /* of the preconditioner [1/s] */
  Vec                         x, b;       /* the unknowns; the right-hand side at b_t [m/s] */
  PetscReal                   b_t;        /* NaN: b is to be made [s] */
  Vec                         part, work; /* of one component */
  Vec           u[ISPH_MAX_DIM];          /* components of x, for convection at a stage [m/s] */
  PetscReal     substep;                  /* the last of the integrator [s] */
  PetscLogEvent event;

  Flow      *flow;      /* of the step at hand, for the callbacks */
  Vec       *force;     /* [m/s^2] */
  PetscBool  stages;    /* the force is made anew at each stage, without convection */
  PetscBool  convects;  /* each stage applies convection itself */
  const Vec *advecting; /* v of implicit convection; NULL: none [m/s] */
} Coupled;

/* solver.c */
PetscErrorCode CoupledSolverCreate(Flow *flow, Coupled *coupled);
PetscErrorCode CoupledSolverFree(Coupled *coupled);
PetscErrorCode CoupledAssemble(PetscReal shift, const Vec advecting[], Coupled *coupled);
PetscErrorCode CoupledSetShift(PetscReal shift, Coupled *coupled);

/* terms.c */
PetscErrorCode CoupledForce(Flow *flow, Vec force[]);
PetscErrorCode CoupledRightHandSide(Coupled *coupled, PetscReal t);
PetscErrorCode CoupledAddConvection(Coupled *coupled, Vec x, PetscReal scale, Vec f);
PetscErrorCode CoupledIFunction(TS ts, PetscReal t, Vec x, Vec xdot, Vec f, void *ctx);
PetscErrorCode CoupledIJacobian(TS ts, PetscReal t, Vec x, Vec xdot, PetscReal shift, Mat A, Mat P,
                                void *ctx);

/* step.c */
PetscErrorCode CoupledSolve(Flow *flow);

#endif
