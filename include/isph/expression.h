/*
  Numbers that a user types as expressions of place and time, "sin(2*pi*t), 0": parsed once, with
  muParser, and evaluated where and when they are wanted.
*/
#ifndef ISPH_EXPRESSION_H
#define ISPH_EXPRESSION_H

#include "isph/base.h"

/* What a text may hold besides numbers, functions and constants; what a component does hold. */
typedef enum {
  EXPRESSION_PLACE = 1 << 0, /* x, y and in 3D z [m] */
  EXPRESSION_TIME  = 1 << 1  /* t [s] */
} ExpressionUse;

/* What all expressions of a scene share: constants, variables, parsers, and the first bad value. */
typedef struct ExpressionScope ExpressionScope;

/* Components of one option; all zero where nothing was given. */
typedef struct {
  char             option[40];           /* for messages */
  PetscInt         n;                    /* components; 0: not given */
  PetscReal        value[ISPH_MAX_DIM];  /* of those that are numbers */
  void            *parser[ISPH_MAX_DIM]; /* of those that are not, else NULL */
  unsigned         uses[ISPH_MAX_DIM];   /* bits of ExpressionUse */
  ExpressionScope *scope;
} Expression;

PetscErrorCode ExpressionScopeCreate(PetscInt dim, ExpressionScope **scope);
PetscErrorCode ExpressionScopeDefine(ExpressionScope *scope, const char name[], PetscReal value);
PetscErrorCode ExpressionScopeDestroy(ExpressionScope **scope);
PetscBool      ExpressionScopeIsIdle(const ExpressionScope *scope);
PetscErrorCode ExpressionScopeCheck(const ExpressionScope *scope);

PetscErrorCode ExpressionSet(ExpressionScope *scope, const char option[], const char text[],
                             PetscInt fewest, PetscInt most, unsigned allowed, Expression *e);
PetscErrorCode ExpressionRead_Private(OptionItems items, ExpressionScope *scope,
                                      const char option[], const char text[], PetscInt fewest,
                                      PetscInt most, unsigned allowed, Expression *e,
                                      PetscBool *set);
#define ExpressionRead(...) ExpressionRead_Private(PetscOptionsObject, __VA_ARGS__)
Expression ExpressionNumber(PetscReal value);
PetscBool  ExpressionUses(const Expression *e, ExpressionUse what);
PetscReal  ExpressionValue(const Expression *e, PetscInt c, PetscReal t, const PetscReal x[]);
PetscReal  ExpressionRate(const Expression *e, PetscInt c, PetscReal t, const PetscReal x[],
                          PetscReal tau);

#endif
