/* The choice of the discretisation in space. */
#ifndef ISPH_CHOOSE_H
#define ISPH_CHOOSE_H

#include "isph/operators.h"

PetscErrorCode OperatorsChoose(const Scene *scene, unsigned needs, OperatorForms *forms);

#endif
