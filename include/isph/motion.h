/* Motion of particles: paths, shifting, graded motion, openings. */
#ifndef ISPH_MOTION_H
#define ISPH_MOTION_H

#include "isph/balance.h"
#include "isph/forces.h"

extern const Table       ShiftTable;
PetscReal                ShiftStepFactor(PetscReal dx, PetscReal speed, PetscReal dt);
extern const OptionTable MotionOptions;

PetscErrorCode MotionCreate(Flow *flow, unsigned *needs);
PetscErrorCode FlowMove(Flow *flow);
PetscErrorCode BodiesMove(Flow *flow);
PetscErrorCode BodiesRegister(const Scene *scene, Scheme *scheme);

PetscErrorCode OpeningsCreate(Flow *flow);
PetscErrorCode OpeningsRegister(Flow *flow);
PetscErrorCode OpeningsPass(Flow *flow);

extern const Judge JudgeBodies;
PetscErrorCode     FreeBodiesCreate(Flow *flow);
PetscErrorCode     FreeBodiesDestroy(const Scene *scene, FreeBodies **bodies);
void               FreeBodyMove(Flow *flow, PetscInt k);

void GradedPath(const Scene *scene, const Particles *particles, PetscInt i, PetscReal way[]);
void GradedKeepOffSides(const Scene *scene, PetscReal share, PetscReal x[]);
PetscErrorCode GradedConvection(Flow *flow, PetscReal at, Vec force[]);
PetscErrorCode GradedRemember(Flow *flow);

#endif
