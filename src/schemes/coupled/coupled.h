/* The coupled scheme, which solves for velocity and pressure together. coupled.c has its row and
   options, solver.c the solver, terms.c its terms, saddle.c its matrix, saddlesplines.c a pressure
   on splines in it, velocityblock.c and schur.c the preconditioners of velocities and of pressures,
   rheology.c viscosities that follow the strain rate, step.c the step, velocityerror.c an
   estimate of the velocity's error. */
#ifndef ISPH_SCHEMES_COUPLED_H
#define ISPH_SCHEMES_COUPLED_H

#include "saddle.h"
#include "schemes/stages/pressurepoints.h"

/* The approximation of the inverse of the Schur complement of the pressure, see schur.c. */
typedef struct {
  const Scene     *scene;
  const Particles *particles;
  const Saddle    *saddle;         /* units of the particles */
  Splines         *splines;        /* NULL: the pressure is on particles */
  Mat              mass;           /* the identity, for other PCs than shell */
  Mat              poisson;        /* -dx_i^2 lap, regular by GaugePreconditioner() [-] */
  KSP              ksp;            /* solver of poisson */
  KspViews         views;          /* -coupled_schur_ksp_view, ... */
  Vec              work;           /* work vector */
  PC               products;       /* of the mass matrix of splines */
  Vec              root;           /* of splines: (nu_q/nu)^1/2 [-] */
  Vec              flux, part;     /* of splines: work vectors */
  PetscInt         stamp;          /* of the products of splines at the last set-up */
  PetscReal        viscous, inert; /* nu/sigma, shift dx^2/sigma of the reference spacing [-] */
} Schur;

PetscErrorCode SchurCreate(PetscBool layer, Schur *schur);
PetscErrorCode SchurAssemble(const Flow *flow, const Saddle *saddle, PetscBool anew, Schur *schur);
PetscErrorCode SchurAttach(PC fieldsplit, Schur *schur);
PetscErrorCode SchurFree(Schur *schur);

/* The preconditioner of velocities, see velocityblock.c. */
typedef struct {
  const char   *name; /* NULL: the user has chosen another one */
  const Flow   *flow;
  const Saddle *saddle;
  KSP           factors;            /* Jacobi, or factors of the blocks of ranks */
  KSP           cycle;              /* of AMG for a component; NULL: none */
  PetscBool     on_splines;         /* the cycle is on splines */
  Vec           residual, from, to; /* work vectors, the last two of a component */
  Vec           sums, part;         /* of splines: work */
} VelocityBlock;

const char    *VelocityBlockChoose(const Flow *flow, PetscBool *lu);
PetscErrorCode VelocityBlockCreate(const Flow *flow, PetscBool repeats, VelocityBlock *block);
PetscErrorCode VelocityBlockSetUp(const Saddle *saddle, VelocityBlock *block);
PetscErrorCode VelocityBlockAttach(PC fieldsplit, const Saddle *saddle, VelocityBlock *block);
PetscErrorCode VelocityBlockFree(VelocityBlock *block);

typedef struct {
  PetscReal     spacing; /* of splines: edge of a cell [dx]; 0: none */
  Guard         guard;
  Saddle        saddle;
  Mat           flat;   /* P for preconditioners without blocks, otherwise NULL */
  PetscBool     splits; /* the preconditioner has blocks */
  VelocityBlock velocity;
  Schur         schur;
  Vec           x, b;                /* unknowns; right-hand side [m/s] */
  Vec           part, work;          /* work vectors of a component */
  Vec           all_walls, boundary; /* wall velocities of interlaced components,
                                                    their viscous terms; NULL: not coupled */
  Vec           u[ISPH_MAX_DIM];     /* components of x [m/s] */

  Flow      *flow;      /* of the present step */
  Vec       *force;     /* [m/s^2] */
  PetscReal  end;       /* of the present step or stage [s] */
  const Vec *advecting; /* v of implicit convection; NULL: none [m/s] */

  StressTangent *tangent; /* of a rheology in an iteration; NULL: none */
} Coupled;

/* rheology.c */
PetscErrorCode CoupledJacobian(Coupled *coupled, Vec b, Mat *J, Vec *rhs);

/* solver.c */
PetscErrorCode CoupledSolverCreate(Flow *flow, Coupled *coupled);
PetscErrorCode CoupledSolverFree(Coupled *coupled);
PetscErrorCode CoupledAssemble(PetscReal shift, const Vec advecting[], Coupled *coupled);
PetscErrorCode CoupledSetShift(PetscReal shift, Coupled *coupled);
PetscErrorCode CoupledForget(Coupled *coupled);

/* terms.c */
PetscErrorCode CoupledForce(Coupled *coupled);
PetscErrorCode CoupledSecondForce(Coupled *coupled, PetscReal first, PetscReal weight);
PetscInt       CoupledNumbering(const Coupled *coupled);
PetscErrorCode CoupledRightHandSide(Coupled *coupled, PetscReal t);

/* step.c */
PetscErrorCode CoupledStart(Flow *flow);
PetscErrorCode CoupledSolve(Flow *flow);
PetscErrorCode CoupledFreeStart(Flow *flow);

/* velocityerror.c */
PetscErrorCode CoupledError(Flow *flow, PetscReal rate, PetscReal *error);

#endif
