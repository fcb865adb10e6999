/*
  Quantities of the fluid besides velocity and pressure, as they are typed: a temperature, the
  concentration of a dye. A scalar c obeys

    Dc/Dt = div (D grad c) + s

  with a value, a flux or an exchange at each boundary. Parts of the description may depend on
  place, time and all scalars.
*/
#ifndef ISPH_QUANTITIES_H
#define ISPH_QUANTITIES_H

#include "isph/options.h"

#define SCALARS_MOST EXPRESSION_FIELDS_MOST

/* The law of a scalar at a boundary; by default its flux is zero. */
typedef enum {
  SCALAR_VALUE,    /* c is given */
  SCALAR_FLUX,     /* D n.grad c is given, n out of the fluid: what enters [m/s] */
  SCALAR_EXCHANGE, /* D n.grad c = h (c_outside - c): h [m/s], c_outside */
  SCALAR_LAWS
} ScalarLaw;

typedef struct {
  char       place[24]; /* name of the boundary, or "walls" */
  ScalarLaw  law;
  Expression of; /* functions of place and t: the value, the flux, or h and c_outside */
} ScalarBoundary;

typedef struct {
  char            name[16];
  Expression      start, diffusivity, source; /* n = 0: zero */
  Expression      exact;                      /* n = 0: not given */
  ScalarBoundary *boundary;
  PetscInt        n_boundary;
} ScalarGiven;

PetscErrorCode ScalarsRead(ExpressionScope *scope, ScalarGiven **scalars, PetscInt *n);
PetscReal      ScalarAtStart(const ScalarGiven *given, const PetscReal x[]);
PetscErrorCode ScalarsFree(ScalarGiven **scalars, PetscInt n);

extern const OptionTable ScalarOptions;

#endif
