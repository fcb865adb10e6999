/* Schemes: their table, and the creation of the scheme of a run. */
#ifndef ISPH_SCHEMES_H
#define ISPH_SCHEMES_H

#include "isph/flow.h"

extern const Table       SchemeTable;
extern const OptionTable SchemeOptions;

PetscErrorCode SchemeCreate(Flow *flow);
PetscErrorCode SchemeSetUp(Flow *flow);
PetscErrorCode SchemeRegister(Flow *flow);
PetscErrorCode SchemeDestroy(Flow *flow);
PetscErrorCode SchemeArrange(Flow *flow);

#endif
