/* Parts of a step that schemes share. */
#ifndef ISPH_SCHEMES_STEP_H
#define ISPH_SCHEMES_STEP_H

#include "isph/schemes.h"

/* step.c */
PetscErrorCode FlowStep(Flow *flow);
PetscErrorCode FlowAssemble(Flow *flow);
PetscErrorCode FlowPartDone(Flow *flow, StepPart part, PetscReal dt, const Vec f[]);

/* attempt.c */
extern const Judge JudgeFailure;
PetscErrorCode     AttemptArrange(Flow *flow);
PetscErrorCode     AttemptDestroy(Attempt **attempt);
PetscErrorCode     AttemptBegin(Flow *flow);
PetscErrorCode     AttemptEnd(Flow *flow, PetscBool *again);
PetscErrorCode     AttemptNext(Flow *flow, PetscInt *k);

/* shift.c */
PetscErrorCode MotionCreate(Flow *flow, unsigned *needs);

/* motion.c */
PetscErrorCode FlowMove(Flow *flow);

/* openings.c */
PetscErrorCode OpeningsCreate(Flow *flow);
PetscErrorCode OpeningsRegister(Flow *flow);
PetscErrorCode OpeningsPass(Flow *flow);

/* graded.c */
void GradedPath(const Scene *scene, const Particles *particles, PetscInt i, PetscReal way[]);
void GradedKeepOffSides(const Scene *scene, PetscReal share, PetscReal x[]);
PetscErrorCode GradedConvection(Flow *flow, PetscReal at, Vec force[]);
PetscErrorCode GradedRemember(Flow *flow);

/* flowstate.c */
StandingField *FlowAddStanding(PetscReal **field, Vec *vec, FlowState *state);

/* average.c, budget.c */
extern const Observer ObserverAverage, ObserverBudget;

/* balance/momentum.c */
PetscErrorCode MomentumKeep(Flow *flow);
PetscErrorCode MomentumRestore(Flow *flow);

/* limits.c */
PetscErrorCode FlowLimit(const Flow *flow, StepLimit *limit);
PetscReal      SurfaceStep(const Scene *scene);
PetscReal      ProjectionFreeLimit(const Scene *scene);

/* forces.c */
PetscErrorCode AddBodyForce(Flow *flow, PetscReal t, Vec force[]);

/* solenoidal.c */
PetscErrorCode SolenoidalNorm(const Flow *flow, const Vec e[], PetscReal *norm);

/* timeerror.c */
PetscErrorCode TimeErrorStart(Flow *flow);
PetscErrorCode TimeErrorCheck(Flow *flow);

/* convection.c */
PetscErrorCode ConvectionExtrapolate(Flow *flow, PetscReal at, Vec force[]);
PetscErrorCode ConvectionOfCorrection(Flow *flow, PetscReal at, const Vec v[], Vec force[]);
PetscErrorCode VelocityExtrapolate(const Flow *flow, PetscReal at, const Vec v[]);

/* history.c */
#define HISTORY 3 /* most earlier velocities in a formula */
void           HistoryAhead(const Clock *clock, PetscReal at, PetscReal weight[HISTORY]);
void           HistoryPredict(const Clock *clock, PetscInt n, PetscReal weight[HISTORY]);
void           HistoryPath(const Clock *clock, PetscReal weight[HISTORY]);
PetscErrorCode HistoryStart(Flow *flow, PetscBool history, PetscReal *dt);

/* jump.c */
extern const Judge JudgeJump;

/* burst.c */
extern const Judge JudgeBurst;

/* collisions.c */
PetscErrorCode FlowCollide(Flow *flow);
void           FlowSeparate(const Flow *flow, PetscReal apart[]);

/* surfaceshift.c */
void FlowLimitShift(const Flow *flow, const PetscReal apart[], PetscInt i, PetscReal shift[]);

/* ownedvolumes.c */
PetscErrorCode VolumesCreate(Flow *flow);
PetscErrorCode VolumesRegister(Flow *flow);
PetscErrorCode VolumesControl(Flow *flow);

/* flow/velocity.c */
PetscErrorCode FlowMassRows(const Flow *flow, const Vec u[], Vec rows);
PetscErrorCode FlowDivergence(Flow *flow, const Vec u[], Vec div);
PetscErrorCode FlowAllVelocities(const Flow *flow, const Vec u[], PetscReal **all);

/* balance/check.c */
PetscErrorCode FlowMeasureStart(Flow *flow);
PetscErrorCode FlowCheck(Flow *flow);
PetscErrorCode FlowRemember(Flow *flow);
PetscErrorCode UnevennessRemember(Flow *flow);

/* balance/energy.c */
PetscErrorCode EnergyTension(const Flow *flow, PetscReal *energy);
PetscReal      EnergyWork(const Flow *flow, PetscInt i, const PetscReal path[]);
PetscErrorCode EnergyAddWork(Flow *flow, PetscReal work);
PetscErrorCode EnergyBound(Flow *flow, PetscReal before, PetscReal *bound);
PetscErrorCode EnergyRemember(const Scene *scene, Scheme *scheme);

/* steady.c */
PetscReal      FlowRmsSpeed(const Flow *flow);
PetscErrorCode SteadyMeasure(Flow *flow);
PetscErrorCode SteadyRemember(Scheme *scheme);
PetscErrorCode SteadyRefuse(const Flow *flow, const char projection[], PetscBool rotational);

#endif
