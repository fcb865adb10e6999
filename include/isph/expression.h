/*
  Expressions of position and time typed by the user, such as "sin(2*pi*t), 0". muParser parses them
  once; then they can be evaluated anywhere and at any time.
*/
#ifndef ISPH_EXPRESSION_H
#define ISPH_EXPRESSION_H

#include "isph/options.h"

/* Bits of the variables that a text may use, or that a component uses. */
typedef enum {
  EXPRESSION_PLACE = 1 << 0, /* x, y and in 3D z [m] */
  EXPRESSION_TIME  = 1 << 1  /* t [s] */
} ExpressionUse;

/* State common to all expressions of a scene: constants, variables, parsers, and the first
   fault. */
typedef struct ExpressionScope ExpressionScope;

#define EXPRESSION_MOST (ISPH_MAX_DIM + 1) /* components: velocity and pressure */

/* An expression: the components of an option. All members are zero if the option is absent. */
typedef struct {
  char             option[40];              /* for messages */
  PetscInt         n;                       /* components; 0: not given */
  PetscReal        value[EXPRESSION_MOST];  /* of components that are numbers */
  void            *parser[EXPRESSION_MOST]; /* of other components; NULL for numbers */
  unsigned         uses[EXPRESSION_MOST];   /* bits of ExpressionUse */
  ExpressionScope *scope;
} Expression;

PetscErrorCode ExpressionScopeCreate(PetscInt dim, ExpressionScope **scope);
PetscErrorCode ExpressionScopeDefine(ExpressionScope *scope, const char name[], PetscReal value);
PetscErrorCode ExpressionScopeDestroy(ExpressionScope **scope);
PetscBool      ExpressionScopeIsIdle(const ExpressionScope *scope);
PetscErrorCode ExpressionScopeCheck(const ExpressionScope *scope);

PetscErrorCode ExpressionSet(ExpressionScope *scope, const char option[], const char text[],
                             PetscInt fewest, PetscInt most, unsigned allowed, Expression *e);
PetscErrorCode ExpressionGet(ExpressionScope *scope, const OptionRow *option, PetscInt fewest,
                             PetscInt most, unsigned allowed, Expression *e, PetscBool *given);
Expression     ExpressionNumber(PetscReal value);
PetscBool      ExpressionUses(const Expression *e, ExpressionUse what);
PetscReal      ExpressionProbe(const Expression *e, PetscInt c, PetscReal t, const PetscReal x[]);
PetscReal      ExpressionValue(const Expression *e, PetscInt c, PetscReal t, const PetscReal x[]);
PetscReal      ExpressionRate(const Expression *e, PetscInt c, PetscReal t, const PetscReal x[],
                              PetscReal tau);

#endif
