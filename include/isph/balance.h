/* Balances of a step: energy, momentum, evenness, and the bounds that they give. */
#ifndef ISPH_BALANCE_H
#define ISPH_BALANCE_H

#include "isph/flow.h"

/* A row of the balance sheet: `name` in the report, `what` the sentence says that is not kept, by
   `value` relative to the scale, at most `bound`. */
typedef struct {
  const char *name, *brief;
  const char *what;   /* "the fluid ..." */
  const char *remedy; /* "try ..." */
  PetscReal   bound;  /* [-] */
} BalanceRow;
extern const BalanceRow BalanceRows[BALANCES];
extern const Observer   ObserverFlight;

void      BalanceSet(BalanceKind kind, PetscReal residual, PetscReal value, PetscReal t,
                     BalanceSheet *sheet);
PetscBool BalanceWorst(const Flow *flow, const char **name, PetscReal *value, PetscReal *bound);

PetscErrorCode FlowMeasureStart(Flow *flow);
PetscErrorCode FlowCheck(Flow *flow);
PetscErrorCode FlowRemember(Flow *flow);
PetscErrorCode UnevennessReport(Flow *flow);

PetscReal      EnergyWork(const Flow *flow, PetscInt i, const PetscReal path[]);
PetscErrorCode EnergyAddWork(Flow *flow, PetscReal work);
PetscErrorCode EnergyBound(Flow *flow, PetscReal before, PetscReal *bound);

PetscErrorCode MomentumKeep(Flow *flow);
PetscErrorCode MomentumRestore(Flow *flow);

#endif
