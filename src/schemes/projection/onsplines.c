/* The projection with the pressure on splines: there is no wall condition of the pressure, as the
   splines take part in the balance of volume at walls. Sides may give the pressure. */
#include "projection.h"

static Splines *SplinesOf(const Flow *flow)
{
  return ((const Projection *)flow->scheme->data)->splines;
}

/* Takes the pressure from its kept copy. Walls have no data of the pressure. */
static PetscErrorCode BeginOnSplines(Flow *flow)
{
  PetscFunctionBegin;
  PetscCall(SplinesBegin(SplinesOf(flow)));
  if (flow->walls.p_step) PetscCall(VecZeroEntries(flow->walls.p_step));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static Vec UnknownsOnSplines(const Flow *flow)
{
  return SplinesOf(flow)->p;
}

/* Solves A phi = -scale^2 rho/k D u*. */
static PetscErrorCode SolveOnSplines(Flow *flow)
{
  Projection     *pr = (Projection *)flow->scheme->data;
  Splines        *s  = pr->splines;
  const PetscReal t  = flow->clock->t + flow->clock->dt;

  PetscFunctionBegin;
  PetscCall(SplinesDivergence(flow, s, flow->state->u_next, t, s->b));
  PetscCall(SplinesSetJumps(flow, flow->state->u_next, s));
  PetscCall(VecPointwiseDivide(s->divergence, s->b, s->mass));
  PetscCall(SplinesValue(s, s->divergence, flow->state->divergence));
  PetscCall(VecScale(s->b, -PetscSqr(s->scale) * flow->scene->rho / pr->k));
  PetscCall(SplinesGivePressure(t, pr->row->incremental, s, s->b));
  PetscCall(PressureSolve(flow, s->b, s->phi, pr->ppe));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AccelerateOnSplines(Flow *flow, PetscBool increment, PetscReal factor,
                                          const Vec u[])
{
  Splines *s = SplinesOf(flow);

  PetscFunctionBegin;
  PetscCall(SplinesAccelerate(s, increment ? s->phi : s->p, factor, u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode UpdateOnSplines(Flow *flow, PetscReal gain)
{
  const Projection *pr    = (const Projection *)flow->scheme->data;
  const Scene      *scene = flow->scene;
  Splines          *s     = pr->splines;

  PetscFunctionBegin;
  if (!pr->row->incremental) PetscCall(VecSet(s->p, scene->level));
  PetscCall(VecAXPY(s->p, gain, s->phi));
  if (pr->row->rotational && SceneHas(scene, PHYSICS_VISCOSITY)) {
    const PetscReal dilatation = LaplacianDilatation(&flow->ops->forms.visc, scene->dim);

    PetscCall(VecAXPY(s->p, -gain * dilatation * scene->rho * scene->nu_low, s->divergence));
  }
  PetscCall(SplinesGivePressure(flow->clock->t + flow->clock->dt, PETSC_FALSE, s, s->p));
  PetscCall(SplinesSpread(flow, s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets b of the first pressure from the force. Walls have the velocity after the projection in
   the divergence; that of a fluid at rest has their part alone. */
static PetscErrorCode FirstOnSplines(Flow *flow, const Vec force[], Vec b)
{
  Splines        *s = SplinesOf(flow);
  const PetscReal t = flow->clock->t;
  Vec             zero[ISPH_MAX_DIM];

  PetscFunctionBegin;
  PetscCall(SplinesDivergence(flow, s, force, t, b));
  for (PetscInt a = 0; a < flow->scene->dim; a++) {
    PetscCall(FlowGetWork(flow, &zero[a]));
    PetscCall(VecZeroEntries(zero[a]));
  }
  PetscCall(SplinesDivergence(flow, s, zero, t, s->b));
  for (PetscInt a = 0; a < flow->scene->dim; a++) PetscCall(FlowRestoreWork(flow, &zero[a]));
  PetscCall(VecAXPY(b, -1.0, s->b));
  PetscCall(VecScale(b, -PetscSqr(s->scale) * flow->scene->rho));
  PetscCall(SplinesGivePressure(t, PETSC_TRUE, s, b));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const PressureSpace PressureOnSplines = {
    .Begin          = BeginOnSplines,
    .Unknowns       = UnknownsOnSplines,
    .Solve          = SolveOnSplines,
    .Accelerate     = AccelerateOnSplines,
    .Update         = UpdateOnSplines,
    .SetFirstSource = FirstOnSplines,
};
