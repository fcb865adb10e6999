/*
  The error of the velocity of a free surface of strain cells, as the response of the flow to the
  error of its own equations. Fits of quadratic degree err with the third power of their radius, so
  fits with a radius WIDER_FITS times as large change all forces and the divergence by

    r = (R_w(u, p) - R(u, p))/(WIDER_FITS^3 - 1)

  where R are the residuals of momentum and mass. The error e of the velocity solves the equations
  of a step with these residuals and walls at rest,

    e/T = div 2 nu E(e) - grad q + r,   div e = -r_q

  with the age T of the flow, and for a rheology with the tangent of its stresses. Soft motions,
  such as the bending of a sheet, then err as much as they are soft. See theory.md, (strain:error).
*/
#include "coupled.h"
#include "isph/strain.h"
#include "splines/splines.h"

/* Computes what the cells give to the equations: the acceleration by pressure, body force, tension
   and viscosity, and the divergence. */
static PetscErrorCode Residuals(Flow *flow, Vec force[], Vec divergence)
{
  const PetscInt dim   = flow->scene->dim;
  const Clock   *clock = flow->clock;
  Splines       *sp    = flow->scheme->splines;
  StrainCells   *cells = flow->ops->strain;
  PetscScalar   *to[ISPH_MAX_DIM];

  PetscFunctionBegin;
  for (PetscInt a = 0; a < dim; a++) PetscCall(VecZeroEntries(force[a]));
  PetscCall(SplinesAccelerate(sp, sp->all, -1.0 / flow->scene->rho, force));
  PetscCall(AddBodyForce(flow, clock->t, force));
  PetscCall(StrainOfVelocity(flow->particles, flow->state->u, flow->walls.u, cells));
  if (!SceneIsNewtonian(flow->scene)) StrainRheology(flow->scene, cells);
  for (PetscInt a = 0; a < dim; a++) PetscCall(VecGetArray(force[a], &to[a]));
  StrainAddForce(flow->particles, cells, 1.0, to);
  for (PetscInt a = 0; a < dim; a++) PetscCall(VecRestoreArray(force[a], &to[a]));
  PetscCall(SplinesDivergence(flow, sp, flow->state->u, clock->t, divergence));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gives the flow the cells, and terms of the pressure and of the tension that follow. The stress of
   the layer below the surface stays. */
static PetscErrorCode UseCells(Flow *flow, StrainCells *cells)
{
  Splines *s = flow->scheme->splines;
  Vec      stress;

  PetscFunctionBegin;
  PetscCall(VecDuplicate(s->layer, &stress));
  PetscCall(VecCopy(s->layer, stress));
  flow->ops->strain = cells;
  s->in_cut         = -1;
  PetscCall(SplinesCutAssemble(flow, s));
  PetscCall(VecCopy(stress, s->layer));
  PetscCall(VecDestroy(&stress));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the residual r of the momentum [m/s^2] and of the mass [1/s]. */
static PetscErrorCode FindResidual(Flow *flow, Vec r[], Vec mass)
{
  const PetscReal  share = 1.0 / (PetscPowRealInt(WIDER_FITS, 3) - 1.0);
  StrainCells     *own = flow->ops->strain, *wide = NULL;
  const SpeedBound bound = flow->scheme->bound;
  const PetscReal  most  = flow->scheme->stats.force_max;
  Vec              work[ISPH_MAX_DIM], divergence;

  const StrainQuantity velocity = {.sets = own->sets, .cut = PETSC_TRUE, .wide = PETSC_TRUE};

  PetscFunctionBegin;
  for (PetscInt a = 0; a < flow->scene->dim; a++) PetscCall(VecDuplicate(r[a], &work[a]));
  PetscCall(VecDuplicate(mass, &divergence));
  PetscCall(Residuals(flow, work, divergence));
  if (SceneMoves(flow->scene)) PetscCall(NeighborsUpdate(flow->particles, 0.0, flow->neighbors));
  else PetscCall(NeighborsSearch(flow->particles, flow->neighbors));
  PetscCall(StrainAssemble(flow->scene, flow->particles, flow->neighbors, StrainEdge(flow->scene),
                           flow->ops->forms.degree, &velocity, &wide));
  if (!SceneMoves(flow->scene)) PetscCall(NeighborsRelease(flow->neighbors));
  StrainViscosities(flow->scene, flow->particles, wide);
  PetscCall(UseCells(flow, wide));
  PetscCall(Residuals(flow, r, mass));
  PetscCall(UseCells(flow, own));
  PetscCall(StrainDestroy(&wide));
  flow->scheme->bound           = bound; /* of the step, which forces of no step do not change */
  flow->scheme->stats.force_max = most;
  for (PetscInt a = 0; a < flow->scene->dim; a++) {
    PetscCall(VecAXPBY(r[a], -share, share, work[a]));
    PetscCall(VecDestroy(&work[a]));
  }
  PetscCall(VecAXPBY(mass, -share, share, divergence));
  PetscCall(VecDestroy(&divergence));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Solves for the velocity by the residuals alone; the preconditioner is as in a step. */
static PetscErrorCode Respond(PetscReal rate, Vec r[], Vec mass, Coupled *c)
{
  Flow           *flow      = c->flow;
  Particles      *p         = flow->particles;
  const PetscBool newtonian = SceneIsNewtonian(flow->scene);
  PetscReal      *nu;
  Mat             J;
  Vec             rhs;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(newtonian ? 0 : ParticlesAll(p), &nu));
  if (!newtonian) {
    PetscCall(PetscArraycpy(nu, p->nu, ParticlesAll(p))); /* the next step begins with them */
    PetscCall(TangentCreate(flow->scene, flow->particles, flow->ops, &c->tangent));
    PetscCall(TangentFollow(c->tangent, flow->state->u, &flow->walls));
  }
  PetscCall(CoupledAssemble(rate, NULL, c));
  PetscCall(VecZeroEntries(c->b));
  for (PetscInt a = 0; a < c->saddle.dim; a++)
    PetscCall(SaddleAdd(&c->saddle, a, c->saddle.step, r[a], c->b));
  PetscCall(SaddleAdd(&c->saddle, c->saddle.dim, -flow->scene->dx, mass, c->b));
  PetscCall(VecZeroEntries(c->x));
  PetscCall(CoupledJacobian(c, c->b, &J, &rhs));
  PetscCall(KSPSetOperators(c->guard.solve.ksp, J, c->flat ? c->flat : c->saddle.P));
  PetscCall(GuardSolve(&c->guard, rhs, c->x));
  PetscCall(VecDestroy(&rhs));
  PetscCall(MatDestroy(&J));
  PetscCall(TangentDestroy(&c->tangent));
  if (!newtonian) PetscCall(PetscArraycpy(p->nu, nu, ParticlesAll(p)));
  PetscCall(PetscFree(nu));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* CoupledError - Computes the root mean square of the error e of the velocity of a free surface of
   strain cells. Collective. Input: rate - 1/T [1/s]. Output: error - [m/s]; the largest number if
   the solve fails. The state of the solver and the flow are as before. */
PetscErrorCode CoupledError(Flow *flow, PetscReal rate, PetscReal *error)
{
  Coupled          *c     = (Coupled *)flow->scheme->data;
  const LinearSolve solve = c->guard.solve;
  PetscReal         sum   = 0.0, part;
  PetscBool         failed;
  Vec               r[ISPH_MAX_DIM], mass;

  PetscFunctionBegin;
  PetscCall(WallValuesSetVelocity(flow->scene, flow->particles, flow->clock->t, 0.0, &flow->walls));
  for (PetscInt a = 0; a < flow->scene->dim; a++) PetscCall(FluidVec(flow->particles, NULL, &r[a]));
  PetscCall(VecDuplicate(flow->scheme->splines->b, &mass));
  PetscCall(CoupledForget(c)); /* so that a report has the memory of a step */
  PetscCall(FindResidual(flow, r, mass));
  PetscCall(Respond(rate, r, mass, c));
  failed          = c->guard.failed;
  c->guard.solve  = solve;
  c->guard.failed = PETSC_FALSE;
  PetscCall(SaddleGet(&c->saddle, c->x, r, NULL));
  for (PetscInt a = 0; a < flow->scene->dim; a++) {
    PetscCall(FluidSum(flow->particles, r[a], PETSC_TRUE, &part));
    sum += part;
    PetscCall(VecDestroy(&r[a]));
  }
  PetscCall(VecDestroy(&mass));
  PetscCall(CoupledForget(c)); /* the next step has other terms and its own shift */
  *error = failed ? PETSC_MAX_REAL : PetscSqrtReal(sum / flow->particles->weight);
  PetscFunctionReturn(PETSC_SUCCESS);
}
