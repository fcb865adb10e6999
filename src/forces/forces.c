/*
  Forces and torques of the fluid on boundaries, by tractions, see tractions.c, and by the momentum
  of the fluid beside them. With a weight w that is 1 on boundary b and falls to 0 at the distance D
  from it, and the stress S = -p I + 2 mu E,

    F = - int [w rho (Du/Dt - f) + S grad w] dV - sum over other boundaries of w S n dA,

  n into the fluid, and the torque is the same with (x - c) x. This is the reaction of the wall's
  rows in a weak form: grad w is zero beside the wall, so that neither derivatives on the wall nor
  volumes of particles beside it matter, and the noise of many points averages out. A linear
  pressure, whose gradient is the body force, is taken out first; its force follows from the shape
  of the surface alone. See theory.md, (forces:momentum).

  Reference: V. John & G. Matthies, Int. J. Numer. Meth. Fluids 37 (2001) 885-903
*/
#include "layer.h"

#define FINE 4 /* pieces along each edge of a facet, for a linear pressure */

/* A pressure p0 + slope.(x - x0), whose gradient a body force balances. */
typedef struct {
  PetscReal p0, x0[ISPH_MAX_DIM], slope[ISPH_MAX_DIM]; /* [Pa], [m], [Pa/m] */
} LinearPressure;

/* A boundary whose force is asked for. */
struct Reaction {
  PetscInt       side;
  PetscReal      centre[ISPH_MAX_DIM]; /* of torques [m] */
  Facets         facets, fine;         /* dx wide; narrower, for pressures with a formula */
  Layer          layer;
  LinearPressure linear; /* of the last call */
  KeptFits       fits;   /* of the points of the layer */
};

/* Returns the centre of torques: the centre of a body, or the middle of the box. */
static void TorqueCentre(const Scene *scene, PetscInt side, PetscReal c[])
{
  const Body *body = BoundaryBody(scene, side);

  for (PetscInt a = 0; a < scene->dim; a++) {
    c[a] = 0.5 * (scene->lo[a] + scene->hi[a]);
    if (body) c[a] = body->pose ? body->pose->x[a] : body->centre[a];
  }
}

/* Moves x to its periodic image nearest to the centre of a body. */
static void NearestImage(const Scene *scene, const Reaction *r, PetscReal x[])
{
  for (PetscInt a = 0; a < scene->dim && BoundaryBody(scene, r->side); a++) {
    const PetscReal period = scene->hi[a] - scene->lo[a];

    if (SceneIsPeriodic(scene, a))
      x[a] -= period * PetscFloorReal((x[a] - r->centre[a]) / period + 0.5);
  }
}

/* Adds a force at x to F, and its torque to T. */
static void AddLoad(PetscInt dim, const PetscReal centre[], const PetscReal x[],
                    const PetscReal load[], PetscReal F[], PetscReal T[])
{
  for (PetscInt a = 0; a < dim; a++) F[a] += load[a];
  AddTorque(dim, centre, x, load, T);
}

/* Returns a linear pressure at x [Pa]. */
static PetscReal LinearAt(PetscInt dim, const LinearPressure *linear, const PetscReal x[])
{
  PetscReal p = linear->p0;

  for (PetscInt a = 0; a < dim; a++) p += linear->slope[a] * (x[a] - linear->x0[a]);
  return p;
}

/* Sets the linear pressure that the forces of a boundary are relative to: that of a fluid at rest
   with the mean pressure p of the layer, constant along periodic axes, as pressures are. */
static void SetLinear(const Flow *flow, const PetscReal p[], Reaction *r)
{
  const Scene    *scene  = flow->scene;
  const PetscInt  dim    = scene->dim;
  LinearPressure *linear = &r->linear;
  PetscReal       volume = 0.0, sum = 0.0;

  *linear = (LinearPressure){.p0 = 0.0};
  for (PetscInt a = 0; a < dim; a++) linear->x0[a] = r->centre[a];
  if (!flow->particles->p) return;
  if (SceneHas(scene, PHYSICS_BODY_FORCE))
    SceneBodyForce(scene, flow->clock->t, r->centre, linear->slope);
  for (PetscInt a = 0; a < dim; a++)
    linear->slope[a] *= SceneIsPeriodic(scene, a) ? 0.0 : scene->rho;
  for (PetscInt k = 0; k < r->layer.n; k++) {
    sum += r->layer.volume[k] * (p[k] - LinearAt(dim, linear, &r->layer.x[k * dim]));
    volume += r->layer.volume[k];
  }
  if (volume > 0.0) linear->p0 = sum / volume;
}

/* Adds the loads of the linear pressure. */
static void AddLinear(PetscInt dim, const Reaction *r, PetscReal F[], PetscReal T[])
{
  for (PetscInt k = 0; k < r->fine.n; k++) {
    const PetscReal *x = &r->fine.x[k * dim], p = LinearAt(dim, &r->linear, x);
    PetscReal        load[ISPH_MAX_DIM];

    for (PetscInt a = 0; a < dim; a++) load[a] = -r->fine.area[k] * p * r->fine.normal[k * dim + a];
    AddLoad(dim, r->centre, x, load, F, T);
  }
}

/* Adds the momentum of the layer to F and T, and sets the linear pressure. */
static PetscErrorCode AddMomentum(const Flow *flow, Reaction *r, PetscReal F[], PetscReal T[])
{
  const Scene   *scene = flow->scene;
  const Layer   *l     = &r->layer;
  const PetscInt dim   = scene->dim;
  PetscReal     *p, *A, *rate, *nu, *strain, *rho;

  PetscFunctionBegin;
  PetscCall(PetscMalloc6(l->n, &p, l->n * dim * dim, &A, l->n * dim, &rate, l->n, &nu, l->n,
                         &strain, l->n, &rho));
  PetscCall(ProbeMotion(flow, l->n, l->x, A, rate, p));
  for (PetscInt k = 0; k < l->n; k++) strain[k] = StrainRate(dim, &A[k * dim * dim]);
  PetscCall(PointViscosity(flow, l->n, l->x, strain, nu));
  PetscCall(ProbeDensity(flow, l->n, l->x, rho));
  SetLinear(flow, p, r);
  for (PetscInt k = 0; k < l->n; k++) {
    const PetscReal *x = &l->x[k * dim], *grad = &A[k * dim * dim];
    const PetscReal *g = &l->gradient[k * dim], w = LayerWeight(l, x);
    PetscReal        f[ISPH_MAX_DIM] = {0.0}, load[ISPH_MAX_DIM];

    if (SceneHas(scene, PHYSICS_BODY_FORCE)) SceneBodyForce(scene, flow->clock->t, x, f);
    for (PetscInt a = 0; a < dim; a++) {
      load[a] = w * (rho[k] * (rate[k * dim + a] - f[a]) + r->linear.slope[a]);
      if (!PetscIsNanReal(p[k])) load[a] -= (p[k] - LinearAt(dim, &r->linear, x)) * g[a];
      for (PetscInt b = 0; b < dim && !flow->ops->strain; b++)
        load[a] += scene->rho * nu[k] * (grad[a * dim + b] + grad[b * dim + a]) * g[b];
      load[a] *= -l->volume[k];
    }
    AddLoad(dim, r->centre, x, load, F, T);
  }
  PetscCall(PetscFree6(p, A, rate, nu, strain, rho));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the tractions on facets of a boundary, times -w with w of a layer, relative to the linear
   pressure of r. layer: NULL: times 1. */
static PetscErrorCode AddTractions(const Flow *flow, PetscInt side, const Reaction *r,
                                   const Layer *layer, PetscReal F[], PetscReal T[])
{
  const PetscInt dim  = flow->scene->dim;
  PetscInt       kept = 0;
  PetscReal     *f, *p;
  Facets         s;

  PetscFunctionBegin;
  PetscCall(FacetsOfWall(flow->scene, side, &s));
  PetscCall(FacetsKeepWet(flow, &s));
  for (PetscInt k = 0; k < s.n; k++)
    if (!layer || LayerWeight(layer, &s.x[k * dim]) > 0.0) FacetsCopy(k, kept++, &s);
  s.n = kept;
  PetscCall(FacetLoads(flow, side, &s, &f, &p));
  for (PetscInt k = 0; k < s.n; k++) {
    const PetscReal *x = &s.x[k * dim], excess = p[k] - LinearAt(dim, &r->linear, x);
    const PetscReal  w = layer ? -LayerWeight(layer, x) : 1.0;
    PetscReal        load[ISPH_MAX_DIM];

    if (PetscIsNanReal(f[k * dim])) continue;
    for (PetscInt a = 0; a < dim; a++) {
      load[a] = layer && flow->ops->strain ? 0.0 : f[k * dim + a];
      if (!PetscIsNanReal(p[k])) load[a] -= s.area[k] * excess * s.normal[k * dim + a];
      load[a] *= w;
    }
    AddLoad(dim, r->centre, x, load, F, T);
  }
  PetscCall(FreeAll(&f, &p));
  PetscCall(FacetsFree(&s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the forces of strain cells on the wall particles of a boundary, and, without a free surface,
   those on the fluid times w: they have no other walls, however near. */
static PetscErrorCode AddCells(const Flow *flow, const Reaction *r, PetscReal F[], PetscReal T[])
{
  const Particles *p                     = flow->particles;
  const PetscInt   dim                   = p->dim;
  PetscReal        sum[2 * ISPH_MAX_DIM] = {0.0}, *force;

  PetscFunctionBegin;
  PetscCall(CellForces(flow, &force));
  for (PetscInt j = 0; j < ParticlesAll(p); j++) {
    const PetscBool wall = ParticlesIsWall(p, j);
    PetscReal       x[ISPH_MAX_DIM], w = 1.0, *load = &force[dim * j];

    if (wall ? (PetscInt)p->side[j] != r->side : r->layer.n == 0) continue;
    for (PetscInt a = 0; a < dim; a++) x[a] = p->x[a][j];
    if (wall) ParticlesWallPoint(p, j, x);
    NearestImage(flow->scene, r, x);
    if (!wall) w = LayerWeight(&r->layer, x);
    for (PetscInt a = 0; a < dim; a++) load[a] *= w;
    if (w > 0.0) AddLoad(dim, r->centre, x, load, sum, &sum[ISPH_MAX_DIM]);
  }
  PetscCall(PetscFree(force));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 2 * ISPH_MAX_DIM, MPIU_REAL, MPIU_SUM, p->comm));
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) {
    F[a] += sum[a];
    T[a] += sum[ISPH_MAX_DIM + a];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes force and torque by the momentum of the layer; with a free surface by tractions; without
   lubrication. */
static PetscErrorCode Measure(const Flow *flow, Reaction *r, PetscReal force[])
{
  const Scene *scene  = flow->scene;
  PetscReal   *torque = &force[ISPH_MAX_DIM];

  PetscFunctionBegin;
  PetscCall(PetscArrayzero(force, 2 * ISPH_MAX_DIM));
  if (flow->ops->strain) PetscCall(AddCells(flow, r, force, torque));
  if (flow->ops->cut_surface) PetscFunctionReturn(PETSC_SUCCESS);
  if (SceneHasFreeSurface(scene)) {
    PetscCall(AddTractions(flow, r->side, r, NULL, force, torque));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(AddMomentum(flow, r, force, torque));
  AddLinear(scene->dim, r, force, torque);
  for (PetscInt other = 0; other < SceneBoundaries(scene); other++) {
    if (other == r->side || BoundaryIs(scene, other, BOUNDARY_CONTINUES)) continue;
    PetscCall(AddTractions(flow, other, r, &r->layer, force, torque));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ReactionCreate - Prepares the force of the fluid on a boundary, for all calls of ReactionForce()
   until particles or boundaries move; not collective. Input: side - a side of the box or a body.
   Free with ReactionDestroy(). */
PetscErrorCode ReactionCreate(const Flow *flow, PetscInt side, Reaction **reaction)
{
  const Scene *scene = flow->scene;
  Reaction    *r;

  PetscFunctionBegin;
  PetscCall(PetscNew(&r));
  r->side = side;
  TorqueCentre(scene, side, r->centre);
  PetscCall(FacetsOfWall(scene, side, &r->facets));
  if (BoundaryBody(scene, side)) PetscCall(FacetsOfBody(scene, side, FINE, &r->fine));
  else PetscCall(FacetsOfWall(scene, side, &r->fine));
  if (!SceneHasFreeSurface(scene)) PetscCall(LayerSet(scene, side, &r->facets, &r->layer));
  *reaction = r;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ReactionDestroy - Frees a reaction; not collective */
PetscErrorCode ReactionDestroy(Reaction **reaction)
{
  PetscFunctionBegin;
  if (!*reaction) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FacetsFree(&(*reaction)->facets));
  PetscCall(FacetsFree(&(*reaction)->fine));
  PetscCall(LayerFree(&(*reaction)->layer));
  PetscCall(FreeAll(&(*reaction)->fits.number, reaction));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Exchanges the fits that probes keep with those of a reaction, and, if u^{n+1} is wanted, present
   and new velocities. */
static PetscErrorCode Exchange(const Flow *flow, PetscBool next, Reaction *r)
{
  const KeptFits fits = flow->state->kept_fits;

  PetscFunctionBegin;
  flow->state->kept_fits = r->fits;
  r->fits                = fits;
  for (PetscInt a = 0; next && a < flow->scene->dim; a++)
    PetscCall(VecSwap(flow->state->u[a], flow->state->u_next[a]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ReactionForce - Computes force and torque of the fluid on the boundary of a reaction by the
   momentum of the fluid beside it, with a free surface by tractions. Collective. The same on all
   ranks, to rounding on different numbers of them. The first call fits the fluid at its points;
   later ones are sums. Input: next - PETSC_TRUE: at the end of the present step, after a stage that
   solves, from u_next, the rate of the step's formula and the present pressure; PETSC_FALSE:
   between steps. Output: force - force [N], then torque [N m] about the centre of a body or the
   middle of the box; in 2D per metre of depth, the torque is the third component. A boundary that
   ends at periodic sides has no torques about other axes. Wcsph has no next. */
PetscErrorCode ReactionForce(const Flow *flow, PetscBool next, Reaction *r, PetscReal force[])
{
  const PetscReal t = flow->clock->t;

  PetscFunctionBegin;
  if (next) PetscCall(AccelerationKeep(flow));
  PetscCall(Exchange(flow, next, r));
  if (next) flow->clock->t = t + flow->clock->dt;
  flow->state->kept_fits.on = PETSC_TRUE;
  flow->state->kept_fits.at = 0;
  PetscCall(Measure(flow, r, force));
  PetscCall(
      LubricationAdd(flow, r->side, &r->facets, &r->fine, r->centre, force, &force[ISPH_MAX_DIM]));
  flow->clock->t = t;
  PetscCall(Exchange(flow, next, r));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Copies those torques by tractions that the momentum does not give: a layer that ends at periodic
   sides has stresses there, whose arms differ by the period. */
static void CopyTorques(const Scene *scene, PetscInt side, const PetscReal traction[],
                        PetscReal momentum[])
{
  const Body *body = BoundaryBody(scene, side);

  for (PetscInt a = 0; a < scene->dim; a++) {
    if (!SceneIsPeriodic(scene, a) || (body && !BodyReachesThrough(body, a))) continue;
    for (PetscInt b = ISPH_MAX_DIM; b < 2 * ISPH_MAX_DIM; b++)
      if (b != ISPH_MAX_DIM + a) momentum[b] = traction[b];
  }
}

/* WallForce - Computes force and torque of the fluid on a boundary, a side of the box or a body, in
   two ways: by the momentum of the fluid beside it, which is the better one, and by tractions;
   collective. With a free surface both are tractions on the parts of the wall inside it. Output:
   force [N], then torque [N m] about the centre of a body or the middle of the box, at
   FORCE_MOMENTUM and FORCE_TRACTION. In 2D both are per metre of depth, and the torque is its third
   component. */
PetscErrorCode WallForce(const Flow *flow, PetscInt side,
                         PetscReal force[FORCE_WAYS][2 * ISPH_MAX_DIM])
{
  PetscReal *momentum = force[FORCE_MOMENTUM], *traction = force[FORCE_TRACTION];
  PetscReal *lubrication = force[FORCE_LUBRICATION];
  Reaction  *r;

  PetscFunctionBegin;
  PetscCall(PetscArrayzero(traction, 2 * ISPH_MAX_DIM));
  PetscCall(ReactionCreate(flow, side, &r));
  PetscCall(Measure(flow, r, momentum));
  if (SceneHasFreeSurface(flow->scene))
    PetscCall(PetscArraycpy(traction, momentum, 2 * ISPH_MAX_DIM));
  else {
    PetscCall(AddTractions(flow, side, r, NULL, traction, &traction[ISPH_MAX_DIM]));
    AddLinear(flow->scene->dim, r, traction, &traction[ISPH_MAX_DIM]);
  }
  CopyTorques(flow->scene, side, traction, momentum);
  PetscCall(PetscArrayzero(lubrication, 2 * ISPH_MAX_DIM));
  PetscCall(LubricationAdd(flow, side, &r->facets, &r->fine, r->centre, lubrication,
                           &lubrication[ISPH_MAX_DIM]));
  for (PetscInt a = 0; a < 2 * ISPH_MAX_DIM; a++) {
    momentum[a] += lubrication[a];
    traction[a] += lubrication[a];
  }
  for (PetscInt k = 0; k < 2 * FORCE_WAYS; k++)
    SceneOutOfFrame(flow->scene, ClockMoment(flow->clock), &force[k / 2][k % 2 * ISPH_MAX_DIM]);
  PetscCall(ReactionDestroy(&r));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ForceParts - Computes magnitudes: of the differences between both ways of WallForce(), of forces
   and of torques, NaN with a free surface, where there is one way, and of the lubrication in the
   force [N], [N m]. Not collective. A difference is no bound of the error of the flow. */
void ForceParts(const Scene *scene, PetscReal force[FORCE_WAYS][2 * ISPH_MAX_DIM],
                PetscReal part[FORCE_WAYS])
{
  for (PetscInt k = 0; k < FORCE_WAYS; k++) part[k] = 0.0;
  for (PetscInt a = 0; a < 2 * ISPH_MAX_DIM; a++)
    part[a / ISPH_MAX_DIM] += SceneHasFreeSurface(scene)
                                  ? NAN
                                  : PetscSqr(force[FORCE_MOMENTUM][a] - force[FORCE_TRACTION][a]);
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) part[2] += PetscSqr(force[FORCE_LUBRICATION][a]);
  for (PetscInt k = 0; k < FORCE_WAYS; k++) part[k] = PetscSqrtReal(part[k]);
}
