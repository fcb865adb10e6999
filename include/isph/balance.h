/* Balances of a step: energy, momentum, evenness, and the bounds that they give. */
#ifndef ISPH_BALANCE_H
#define ISPH_BALANCE_H

#include "isph/flow.h"

PetscErrorCode FlowMeasureStart(Flow *flow);
PetscErrorCode FlowCheck(Flow *flow);
PetscErrorCode FlowRemember(Flow *flow);
PetscErrorCode UnevennessRemember(Flow *flow);

PetscErrorCode EnergyTension(const Flow *flow, PetscReal *energy);
PetscReal      EnergyWork(const Flow *flow, PetscInt i, const PetscReal path[]);
PetscErrorCode EnergyAddWork(Flow *flow, PetscReal work);
PetscErrorCode EnergyBound(Flow *flow, PetscReal before, PetscReal *bound);
PetscErrorCode EnergyRemember(const Scene *scene, Scheme *scheme);

PetscErrorCode MomentumKeep(Flow *flow);
PetscErrorCode MomentumRestore(Flow *flow);

#endif
