/* Stages of a step that schemes share; see stages.c. */
#ifndef ISPH_SCHEMES_STAGES_H
#define ISPH_SCHEMES_STAGES_H

#include "isph/motion.h"

extern const Stage StageMomentum, StageBodies, StageMove, StagePass, StageRebuild, StageFilter,
    StageMean, StageCheck, StageError;

extern const Judge    JudgeJump;
extern const Observer ObserverJump;

PetscErrorCode FlowFollow(Flow *flow);
PetscErrorCode FlowRebuildNeighbors(Flow *flow);
PetscErrorCode FlowBegin(Flow *flow);

#endif
