/* The regime of a flow: facts and numbers that decide defaults, and the table of these defaults. No
   other file compares a cell Reynolds number. */
#ifndef ISPH_REGIME_H
#define ISPH_REGIME_H

#include "isph/base.h"
#include <stdio.h>

struct Scene;

/* Facts of a flow and of its other options; RegimeCreate() sets those of the scene. */
typedef enum {
  FACT_MOVES      = 1 << 0,  /* particles move with the flow */
  FACT_SURFACE    = 1 << 1,  /* there is a free surface */
  FACT_WALLS      = 1 << 2,  /* PHYSICS_WALLS */
  FACT_CONVECTION = 1 << 3,  /* PHYSICS_CONVECTION */
  FACT_PRESSURE   = 1 << 4,  /* PHYSICS_PRESSURE */
  FACT_VARIES     = 1 << 5,  /* viscosity varies */
  FACT_CURVED     = 1 << 6,  /* there is a pressure or a body */
  FACT_GRADED     = 1 << 7,  /* particles have several sizes */
  FACT_DRIVEN     = 1 << 8,  /* walls or forces depend on time */
  FACT_NONLINEAR  = 1 << 9,  /* viscosity follows the strain rate */
  FACT_NARROW     = 1 << 10, /* the box is too narrow for splines */
  FACT_STEP_GIVEN = 1 << 11, /* -dt */
  FACT_STEADY     = 1 << 12, /* -steady */
  FACT_FLUIDS     = 1 << 13, /* there are interfaces of fluids */
  FACT_IMPLICIT   = 1 << 14, /* -convection implicit */
  FACT_ORDERED    = 1 << 15, /* particles stay on a lattice, or are relaxed */
  FACT_CUBIC      = 1 << 16, /* -mls_degree 3 */
  FACT_QUARTIC    = 1 << 17, /* -mls_degree 4 */
  FACT_EXACT      = 1 << 18, /* Laplacians are exact for quadratic functions */
  FACT_BLIND      = 1 << 19, /* a form needs particles behind walls */
  FACT_COARSE     = 1 << 20, /* -pressure_points coarse */
  FACT_ASKED      = 1 << 21, /* an option of a pressure on particles */
  FACT_STRONG     = 1 << 22, /* -velocity_filter above 1 */
  FACT_WCSPH      = 1 << 23, /* -scheme wcsph */
  FACT_SUMS       = 1 << 24, /* -density_form summation */
  FACT_SHIFTS     = 1 << 25, /* -scheme wcsph shifts particles */
  FACT_CLOUD      = 1 << 26, /* particles of several sizes are on no lattice */
  FACT_MIXES      = 1 << 27  /* SceneMixes() */
} Fact;
#define FACTS 27

/* Numbers that rows compare with their bounds. */
typedef enum {
  NUMBER_NONE,
  NUMBER_CELL,      /* U dx/nu with the least viscosity */
  NUMBER_STIFFNESS, /* nu dt/e^2 with the largest viscosity, e the smallest edge of a cell */
  NUMBER_COURANT,   /* U dt/dx */
  NUMBERS
} RegimeNumber;

/* Defaults and bounds that depend on the regime. */
typedef enum {
  REGIME_SCHEME,
  REGIME_POINTS,
  REGIME_KERNEL,
  REGIME_FILTER_U,
  REGIME_FILTER_P,
  REGIME_SHEAR,
  REGIME_LAPLACIAN,
  REGIME_CORRECTION,
  REGIME_WALL,
  REGIME_SHIFT,
  REGIME_SHIFT_STRENGTH,
  REGIME_DT_ADAPT,
  REGIME_COURANT,
  REGIME_VISC_PC,
  REGIME_VISC_RTOL,
  REGIME_BLOCK_PC,
  REGIME_CHORIN_HOLDS,
  REGIME_STEP_HOLDS,
  REGIMES
} RegimeChoice;

/* The change of a value within the range of a row. */
typedef enum {
  VALUE_CONSTANT,
  VALUE_RAMP,   /* linear, from 0 to the value */
  VALUE_INVERSE /* the value times the lower bound over the number */
} ValueLaw;

/* A range of numbers; a bound of 0 is none. */
typedef struct {
  PetscReal above, upto;
  ValueLaw  law;
} RegimeRange;

/* A default: it holds for flows with all facts of `holds`, none of `lacks`, and the number of the
   table in the range. */
typedef struct {
  unsigned    holds, lacks; /* bits of Fact */
  RegimeRange range;
  const char *value; /* a name or a number; NULL: the program refuses the option */
  const char *why;   /* a clause */
} RegimeRow;

/* A default that depends on the regime. For each flow one row holds. */
typedef struct {
  const char      *option; /* as typed */
  RegimeNumber     number; /* that the rows compare */
  const char      *page;   /* of the measurements, in docs/ */
  PetscBool        shown;  /* in the banner */
  const RegimeRow *rows;
  PetscInt         count;
} RegimeTable;

/* The regime of a run. */
typedef struct {
  unsigned  facts;
  PetscReal number[NUMBERS];
  unsigned  asked; /* bit k: choice k was read */
} Regime;

#define REGIME "by the regime" /* the default of an option with a table */

extern const RegimeTable RegimeTables[REGIMES]; /* src/scene/regimes.c */

PetscErrorCode   RegimeCreate(const struct Scene *scene, Regime **regime);
void             RegimeSetFact(Regime *regime, Fact fact, PetscBool holds);
PetscBool        RegimeHolds(const Regime *regime, RegimeChoice choice, const RegimeRow *row);
const RegimeRow *RegimeFind(const Regime *regime, RegimeChoice choice);
PetscReal        RegimeValue(Regime *regime, RegimeChoice choice);
const char      *RegimeWord(Regime *regime, RegimeChoice choice);
PetscBool        RegimeAllows(Regime *regime, RegimeChoice choice);
PetscErrorCode   RegimeView(const Regime *regime, PetscViewer viewer);
void             RegimePrint(FILE *out, PetscBool markdown);

#endif
