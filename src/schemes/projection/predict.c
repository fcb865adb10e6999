/* The predictor of the projection: forces at the new time, then the viscous step to u*. */
#include "isph/motion.h"
#include "projection.h"

/* ProjectionForce - Sets the force on u* without convection, -grad p/rho + f, with the present
   pressure and the body force f at time t, and notes its largest value; collective */
PetscErrorCode ProjectionForce(Flow *flow, PetscReal t, Vec force[])
{
  const Scene      *scene = flow->scene;
  const Projection *pr    = (const Projection *)flow->scheme->data;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < scene->dim; a++) PetscCall(VecZeroEntries(force[a]));
  if (pr->row && pr->row->incremental)
    PetscCall(pr->space->Accelerate(flow, PETSC_FALSE, -1.0 / scene->rho, force));
  PetscCall(AddBodyForce(flow, t, force));
  if (SceneHas(scene, PHYSICS_BODY_FORCE) && pr->row && pr->row->incremental)
    PetscCall(NoteUnbalancedForce(flow, force));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* PredictVelocity - Predicts u* in u_next by a viscous step, and sets the wall gradient of the
   pressure; collective */
PetscErrorCode PredictVelocity(Flow *flow)
{
  Projection                 *pr       = (Projection *)flow->scheme->data;
  const PetscBool             convects = flow->state->has_convection;
  const ViscousIntegratorRow *row      = pr->visc ? pr->visc->row : NULL;
  const PetscBool             implicit = flow->state->implicit_convection;
  const PetscBool             inner  = convects && row && (implicit || row->terms != TIME_IMPLICIT);
  const PetscReal             at     = !row || row->end_of_step ? 1.0 : 0.5;
  const PetscInt              dim    = flow->scene->dim;
  const PetscReal             middle = flow->clock->t + at * flow->clock->dt;
  Vec                         force[ISPH_MAX_DIM] = {NULL}, v[ISPH_MAX_DIM] = {NULL};
  PetscReal                   dt;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < dim; a++) PetscCall(FlowGetWork(flow, &force[a]));
  for (PetscInt a = 0; a < dim && inner; a++) PetscCall(FlowGetWork(flow, &v[a]));
  PetscCall(HistoryStart(flow, !row || row->history, &dt));
  if (pr->row && pr->space->StartStep) PetscCall(pr->space->StartStep(flow));
  PetscCall(ProjectionForce(flow, middle, force));
  if (inner) {
    PetscCall(VelocityExtrapolate(flow, at, v));
    PetscCall(VelocityFilterRates(flow, v));
    for (PetscInt a = 0; a < dim; a++)
      PetscCall(ConvectionTurn(flow, middle, -1.0, v, a, force[a]));
    PetscCall(ConvectionPass(flow, middle, v));
  } else if (convects) {
    PetscCall(ConvectionExtrapolate(flow, at, force));
  }
  if (implicit) PetscCall(ConvectionOfCorrection(flow, at, v, force));
  if (SceneMovesGraded(flow->scene)) PetscCall(GradedConvection(flow, at, force));
  pr->k = dt;
  if (pr->visc) {
    const PetscReal factor = pr->row ? dt / flow->scene->rho : 0.0;

    PetscCall(
        ViscositySolve(flow, dt, factor, force, inner ? v : NULL, flow->state->u_next, pr->visc));
  } else {
    for (PetscInt a = 0; a < dim; a++) PetscCall(VecAXPY(flow->state->u_next[a], dt, force[a]));
  }
  if (!flow->scheme->failure.code && pr->row && pr->space->FollowForce)
    PetscCall(pr->space->FollowForce(flow));
  PetscCall(VelocityFilterForget(flow));
  for (PetscInt a = 0; a < dim; a++) {
    PetscCall(FlowRestoreWork(flow, &force[a]));
    PetscCall(FlowRestoreWork(flow, &v[a]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
