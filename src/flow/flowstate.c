/* The state of a flow: velocity and pressure as fields of the particles and as vectors, the initial
   values, and work vectors that a step borrows. */
#include "isph/flow.h"

/* Registers the work that stages of a step share for -log_view. */
static PetscErrorCode RegisterEvents(FlowState *s)
{
  PetscClassId id;

  PetscFunctionBegin;
  PetscCall(PetscClassIdRegister("Flow", &id));
  PetscCall(PetscLogEventRegister("NeighborsUpdate", id, &s->event[FLOW_EVENT_NEIGHBORS]));
  PetscCall(PetscLogEventRegister("OperatorsAssem", id, &s->event[FLOW_EVENT_OPERATORS]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FlowStateCreate - Creates the state */
PetscErrorCode FlowStateCreate(Flow *flow)
{
  const Scene *scene = flow->scene;
  FlowState   *s;

  PetscFunctionBegin;
  PetscCall(PetscNew(&s));
  s->has_convection = scene->motion && !SceneMoves(scene);
  PetscCall(RegisterEvents(s));
  flow->state = s;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FlowStateFree(FlowState *s)
{
  PetscFunctionBegin;
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) {
    PetscCall(VecDestroyAll(&s->u[a], &s->u_prev[a], &s->u_before[a], &s->convection_prev[a],
                            &s->convection_before[a], &s->correction_prev[a], &s->u_next[a],
                            &s->interface[a]));
  }
  PetscCall(VecDestroy(&s->p));
  PetscCall(PetscFree(s->kept_fits.number));
  s->kept_fits = (KeptFits){.n = 0};
  PetscCall(VecDestroyAll(&s->p_before, &s->divergence));
  for (PetscInt k = 0; k < FLOW_MAX_WORK; k++) PetscCall(VecDestroy(&s->work[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FlowStateDestroy - Frees the state; collective */
PetscErrorCode FlowStateDestroy(Flow *flow)
{
  PetscFunctionBegin;
  if (!flow->state) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FlowStateFree(flow->state));
  PetscCall(PetscFree(flow->state));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FlowStateRegister - Registers the fields of the state and sets the initial values of the case.
   Collective. Velocities from -particles take precedence over the case. */
PetscErrorCode FlowStateRegister(Flow *flow)
{
  const Scene *scene = flow->scene;
  Particles   *p     = flow->particles;
  FlowState   *s     = flow->state;

  PetscFunctionBegin;
  PetscCall(ParticlesRegister(p, "u_previous", scene->dim, HALO_NONE, ENTRY_MEAN, s->u_previous));
  if (flow->clock->adapt->estimates || flow->clock->order > 2)
    PetscCall(ParticlesRegister(p, "u_earlier", scene->dim, HALO_NONE, ENTRY_MEAN, s->u_earlier));
  if (s->has_convection && !s->implicit_convection)
    PetscCall(ParticlesRegister(p, "convection", scene->dim, HALO_NONE, ENTRY_MEAN, s->convection));
  if (s->has_convection && !s->implicit_convection && flow->clock->order > 2)
    PetscCall(ParticlesRegister(p, "convection_earlier", scene->dim, HALO_NONE, ENTRY_MEAN,
                                s->convection_earlier));
  if (flow->ops->cut_surface)
    PetscCall(ParticlesRegister(p, "wetness", 1, HALO_NONE, ENTRY_ZERO, &p->wetness));
  if (s->implicit_convection && p->p)
    PetscCall(ParticlesRegister(p, "correction", scene->dim, HALO_NONE, ENTRY_MEAN, s->correction));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscReal x[ISPH_MAX_DIM], u[ISPH_MAX_DIM] = {0.0}, pressure = scene->level;

    for (PetscInt a = 0; a < scene->dim; a++) x[a] = p->x[a][i];
    if (p->velocity_given) {
      for (PetscInt a = 0; a < scene->dim; a++) u[a] = p->u[a][i];
    } else if (scene->problem->Velocity) {
      scene->problem->Velocity(scene, 0.0, x, u);
    }
    for (PetscInt a = 0; a < scene->dim; a++) p->u[a][i] = s->u_previous[a][i] = u[a];
    if (p->p && scene->problem->Exact && !scene->velocity.n && !p->velocity_given)
      scene->problem->Exact(scene, 0.0, x, u, &pressure);
    if (p->p) p->p[i] = pressure;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FlowStateRenumber - Creates the vectors for the present numbering, once per epoch; collective */
PetscErrorCode FlowStateRenumber(Flow *flow)
{
  const Particles *p = flow->particles;
  FlowState       *s = flow->state;

  PetscFunctionBegin;
  if (s->epoch == p->epoch) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FlowStateFree(s));
  for (PetscInt a = 0; a < p->dim; a++) {
    PetscCall(FluidVec(p, p->u[a], &s->u[a]));
    PetscCall(FluidVec(p, s->u_previous[a], &s->u_prev[a]));
    if (s->u_earlier[a]) PetscCall(FluidVec(p, s->u_earlier[a], &s->u_before[a]));
    PetscCall(FluidVec(p, NULL, &s->u_next[a]));
    if (s->convection[a]) PetscCall(FluidVec(p, s->convection[a], &s->convection_prev[a]));
    if (s->convection_earlier[a])
      PetscCall(FluidVec(p, s->convection_earlier[a], &s->convection_before[a]));
    if (s->correction[a]) PetscCall(FluidVec(p, s->correction[a], &s->correction_prev[a]));
  }
  if (p->p) {
    PetscCall(FluidVec(p, p->p, &s->p));
    PetscCall(FluidVec(p, NULL, &s->p_before));
    PetscCall(FluidVec(p, NULL, &s->divergence));
  }
  for (PetscInt a = 0; a < p->dim; a++)
    if (SceneMixes(flow->scene) || (flow->ops->cut_surface && flow->scene->tension > 0.0))
      PetscCall(FluidVec(p, NULL, &s->interface[a]));
  s->epoch = p->epoch;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FlowGetWork - Returns a work vector over the own fluid, whose values are undefined. Collective
   when the vector is first created in an epoch. To be returned by FlowRestoreWork() before the
   epoch ends. */
PetscErrorCode FlowGetWork(Flow *flow, Vec *v)
{
  FlowState *s = flow->state;
  PetscInt   k = 0;

  PetscFunctionBegin;
  while (k < FLOW_MAX_WORK && s->lent[k]) k++;
  PetscCheck(k < FLOW_MAX_WORK, PETSC_COMM_SELF, PETSC_ERR_PLIB,
             "More than FLOW_MAX_WORK = %d work vectors are lent", FLOW_MAX_WORK);
  if (!s->work[k]) PetscCall(FluidVec(flow->particles, NULL, &s->work[k]));
  s->lent[k] = PETSC_TRUE;
  *v         = s->work[k];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FlowRestoreWork - Takes back a vector of FlowGetWork() and sets v to NULL */
PetscErrorCode FlowRestoreWork(Flow *flow, Vec *v)
{
  FlowState *s = flow->state;
  PetscInt   k = 0;

  PetscFunctionBegin;
  if (!*v) PetscFunctionReturn(PETSC_SUCCESS);
  while (k < FLOW_MAX_WORK && s->work[k] != *v) k++;
  PetscCheck(k < FLOW_MAX_WORK && s->lent[k], PETSC_COMM_SELF, PETSC_ERR_PLIB,
             "A vector is given back that was not lent");
  s->lent[k] = PETSC_FALSE;
  *v         = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}
