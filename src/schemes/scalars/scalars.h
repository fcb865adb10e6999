/*
  Scalars that the fluid carries, in any scheme. In the cells of src/strain,

    V_i dc_i/dt = -sum_c V_c D_c g_i.(grad c)_c + sum_c V_c g_i.(w c)_c + V_i s_i + boundaries

  with the weights g_i of particle i in the mean gradient of a cell, and the velocity w of the fluid
  past the particles. The sum over all particles and points of walls of the first two terms is zero:
  what boundaries give is what the fluid gains. See theory.md, (scalars:cells) and
  (densities:momentum).
*/
#ifndef ISPH_SCHEMES_SCALARS_H
#define ISPH_SCHEMES_SCALARS_H

#include "isph/solvers.h"
#include "isph/strain.h"
#include "schemes/diffusion/viscosity.h"

/* The law of a part of the border: given - rate c enters, with the value c there [m^dim/s]. */
typedef struct {
  PetscReal given, rate, leaving; /* leaving: part of the rate that fluid carries out */
} PartLaw;

typedef struct {
  const ScalarGiven          *given;
  const ScalarBoundary      **law;   /* of each boundary; NULL: no flux */
  PetscBool                  *gives; /* boundaries that give the value */
  const ViscousIntegratorRow *row;
  char                        prefix[24], label[32], option[32]; /* of its solver */
  PetscReal                  *c, *before;   /* values, and those of the last step (fields) */
  PetscReal                  *wall;         /* values at own points of walls that give them */
  PetscReal                  *all;          /* values by local index, walls too */
  PetscBool                   active;       /* it has a solve; else particles carry it exactly */
  PetscBool                   is_nonlinear; /* its source depends on it */
  char                        before_name[24], kept_name[24], entering_name[32];

  StrainCells *cells;
  Pattern      columns[2]; /* of A, and over walls */
  PetscReal   *entry;      /* of A [m^dim/s] */
  PetscReal   *D;          /* of the cells [m^2/s] */
  PartLaw     *part;       /* of the parts of the border */
  PetscReal   *rate;       /* by local index, see ScalarRates() */
  PetscReal    average;    /* in the fluid; 0 without convection */
  /* due amount in the fluid, now and a step before [m^dim]; least and largest value of start and
     boundaries so far; kept by name in the memory of the scheme */
  PetscReal  kept[4];
  PetscReal *entering; /* by boundary: what entered per time in the last step [m^dim/s] */
  PetscBool  shell;    /* J only has products and a diagonal, and there is no A */
  Mat        A, J;     /* rates [m^dim/s]; shift V - A - V ds/dc */
  Vec        volume, source, slope, scratch, work, next; /* work: shift V - V ds/dc in J */
  PetscInt   epoch, moved, numbered; /* stamps of particles in A, and in the vectors */
  Flow      *flow;                   /* for callbacks */
  TS         ts;
  Guard      guard;
  PetscReal  shift; /* in J [1/s] */
} Scalar;

struct Scalars {
  PetscInt   n;
  Scalar    *scalar;
  Cells      cells;   /* of the present places, for ScalarsAt(); empty: no expression needs them */
  PetscBool  strain;  /* a source needs the strain rate */
  PetscReal *g;       /* strain rate of own fluid; NULL: not needed [1/s] */
  PetscReal *flow;    /* velocity of the fluid past the particles by local index, components
                         together; NULL: none [m/s] */
  PetscReal *volume;  /* of own fluid below a free surface: that of its cells at the start (field);
                         NULL: those of the particles [m^dim] */
  PetscInt64 next_id; /* of particles that enter in the next step */
};

/* Returns the volumes of own fluid in balances of scalars: half of them lies outside for particles
   on a free surface, and would hold heat there [m^dim]. */
static inline const PetscReal *ScalarVolumes(const Flow *flow)
{
  return flow->state->scalars->volume ? flow->state->scalars->volume : flow->particles->volume;
}

/* Returns the component of an expression for a fluid. */
static inline PetscInt ScalarFluid(const Expression *e, PetscInt fluid)
{
  return e->n > 1 ? fluid : 0;
}

enum { KEPT_AMOUNT, KEPT_BEFORE, KEPT_LOW, KEPT_HIGH, KEPT };

extern const Stage StageScalars;

PetscErrorCode ScalarsCreate(Flow *flow);
PetscErrorCode ScalarsSetUp(Flow *flow);
PetscErrorCode ScalarsRegister(Flow *flow);
PetscErrorCode ScalarsBegin(Flow *flow);
PetscErrorCode ScalarSlip(const Flow *flow, PetscReal u[]);
PetscErrorCode ScalarsDestroy(Flow *flow);

void ScalarBoundaryName(const Scene *scene, PetscInt side, char name[]);
void ScalarsAt(void *ctx, PetscReal t, const PetscReal x[], PetscReal value[]);

/* scalarcells.c */
PetscErrorCode ScalarSetWalls(const Flow *flow, PetscReal t, Scalar *s);
PetscErrorCode ScalarAssemble(Flow *flow, Scalar *s);
PetscErrorCode ScalarValues(const Flow *flow, const PetscReal c[], PetscReal share, Scalar *s);
PetscErrorCode ScalarRates(const Flow *flow, const PetscReal c[], PetscReal share, Scalar *s);
PetscErrorCode ScalarMatrix(const Flow *flow, Scalar *s);
void           ScalarDiagonal(const Flow *flow, const Scalar *s, PetscReal to[]);
PetscErrorCode ScalarEntering(const Flow *flow, Scalar *s);
PetscErrorCode ScalarFree(Scalar *s);

/* scalarsolve.c */
PetscErrorCode ScalarCreateSolver(Flow *flow, Scalar *s);
PetscErrorCode ScalarSolve(Flow *flow, Scalar *s);
PetscErrorCode ScalarFreeVectors(Scalar *s);

/* scalarbalance.c */
PetscErrorCode ScalarBalanceRegister(Flow *flow, Scalar *s);
PetscErrorCode ScalarBalanceStep(Flow *flow, const PetscReal weight[2], PetscReal dt,
                                 PetscReal made, Scalar *s);
PetscErrorCode ScalarAmount(const Flow *flow, const PetscReal c[], PetscReal amount[2]);

#endif
