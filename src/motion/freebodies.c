/*
  The motion of free bodies. Velocity U and spin w of a body at the end of a step are unknowns of
  the step. With the formula in time of the flow, start and k of HistoryStartWeights(), Newton's
  law is

    (P - start)/k = F(U, w) + F_ext,   P = (m U, I w),

  with the load F of the fluid on the body at the end of the step, which moves with U and w there. A
  judge of the solution computes the residual R of this law, and the solves happen again with better
  U and w until |R| is small beside the forces: by Broyden's method for all bodies together, whose
  matrix dR/d(U, w) goes from step to step. In it is the fluid that a body sets into motion, so
  that light bodies move as well as heavy ones. The place follows from earlier velocities as those
  of particles do.

  Reference: C. G. Broyden, Math. Comput. 19 (1965) 577-593
*/
#include "isph/motion.h"
#include "splines/splines.h"

#define TOLERANCE 1e-4 /* of R, relative to the largest force on the body [-] */
#define TRIALS    25   /* most solves of a step */
#define PARTS     6    /* components of U, then of w */
#define GAP       1.0  /* gap below which bodies are pushed off [dx] */
#define PIECE     0.25 /* distance of points on the surface, for gaps [dx] */
#define PUSH      0.3  /* of the push-off: mass over dt^2 per length [-] */

/* The past of a body at the end of an earlier step: its velocity and spin, and its momenta. */
typedef struct {
  PetscReal v[PARTS], momentum[PARTS]; /* [m/s, rad/s], [kg m/s, kg m^2/s] */
} Past;

struct FreeBodies {
  PetscInt   n;                /* unknowns */
  PetscInt  *body, *part;      /* of each unknown */
  PetscReal *J, *kept;         /* dR/dv, of the present step and after the last, by rows [kg/s] */
  PetscReal *v, *R, *next, *s; /* of the last trial, of the next; work */
  PetscReal  length;           /* k of the kept matrix; 0: none [s] */
  PetscReal  contacts, solves; /* steps with a push-off; solves so far */
  Reaction **reaction;         /* of each body of the scene; NULL: not prepared */
  Past      *past[HISTORY];    /* of t^n, t^{n-1}, t^{n-2}; by bodies of the scene */
  Past      *storage;
  PetscBool  pushed; /* in the present step */
  PetscReal *push;   /* on each body of the scene, force and torque [N], [N m] */
};

static const Freedom *FreedomOf(const Scene *scene, PetscInt k)
{
  return &scene->boundary[SceneBodySide(scene, k)].freedom;
}

/* Returns velocity or spin of a body. */
static PetscReal *PartOf(Pose *pose, PetscInt part)
{
  return &(part < FREEDOM_SPIN ? pose->u : pose->spin)[part % FREEDOM_SPIN];
}

/* Returns the unit that makes an unknown a velocity: 1, or the length of the body for spins. */
static PetscReal UnitOf(const Scene *scene, PetscInt k, PetscInt part)
{
  return part < FREEDOM_SPIN ? 1.0 : scene->boundary[SceneBodySide(scene, k)].body.extent;
}

/* Computes the momenta m U and I w of a body that has turned. */
static void Momenta(const Freedom *f, const Pose *pose, PetscReal momentum[PARTS])
{
  PetscReal w[ISPH_MAX_DIM], *L = &momentum[FREEDOM_SPIN];

  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) {
    momentum[a] = f->mass * pose->u[a];
    w[a]        = pose->spin[a];
    L[a]        = 0.0;
  }
  PoseTurn(pose, PETSC_TRUE, w);
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++)
    for (PetscInt b = 0; b < ISPH_MAX_DIM; b++) L[a] += f->inertia[a][b] * w[b];
  PoseTurn(pose, PETSC_FALSE, L);
}

/* Frees the prepared loads, which belong to the places of particles and bodies. */
static PetscErrorCode FreeReactions(const Scene *scene, FreeBodies *b)
{
  PetscFunctionBegin;
  for (PetscInt k = 0; k < scene->n_bodies; k++) PetscCall(ReactionDestroy(&b->reaction[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FreeBodiesDestroy - Frees the state of free bodies; collective */
PetscErrorCode FreeBodiesDestroy(const Scene *scene, FreeBodies **bodies)
{
  PetscFunctionBegin;
  if (!*bodies) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FreeReactions(scene, *bodies));
  PetscCall(PetscFree2((*bodies)->body, (*bodies)->part));
  PetscCall(PetscFree2((*bodies)->J, (*bodies)->kept));
  PetscCall(PetscFree4((*bodies)->v, (*bodies)->R, (*bodies)->next, (*bodies)->s));
  PetscCall(PetscFree3((*bodies)->storage, (*bodies)->reaction, (*bodies)->push));
  PetscCall(PetscFree(*bodies));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds what steps keep of free bodies to the memory of the run. */
static PetscErrorCode Remember(const Scene *scene, FreeBodies *b, Scheme *scheme)
{
  const PetscInt size = HISTORY * scene->n_bodies * (PetscInt)(sizeof(Past) / sizeof(PetscReal));

  PetscFunctionBegin;
  PetscCall(MemoryAddReals(&scheme->memory, "bodies", size, (PetscReal *)b->storage));
  PetscCall(MemoryAddReals(&scheme->memory, "bodies_matrix", b->n * b->n, b->kept));
  PetscCall(MemoryAddReal(&scheme->memory, "bodies_length", &b->length));
  PetscCall(MemoryAddReal(&scheme->memory, "bodies_contacts", &b->contacts));
  PetscCall(MemoryAddReal(&scheme->memory, "bodies_solves", &b->solves));
  PetscCall(SchemeAddFigure(
      (SchemeFigure){
          .name = "body_solves", .value = &b->solves, .most = PETSC_INFINITY, .remedy = ""},
      scheme));
  PetscCall(SchemeAddFigure(
      (SchemeFigure){.name   = "body_contacts",
                     .value  = &b->contacts,
                     .remedy = "steps in which a free body came nearer than 1 dx to a wall or "
                               "another body and was pushed off; its motion there is no result",
                     .quiet  = PETSC_TRUE},
      scheme));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FreeBodiesCreate - Creates the state of free bodies, if the scene has any, and adds it to the
   memory of the run; collective. The poses have the velocities at the start. */
PetscErrorCode FreeBodiesCreate(Flow *flow)
{
  const Scene *scene = flow->scene;
  FreeBodies  *b;

  PetscFunctionBegin;
  if (!SceneHasFreeBodies(scene)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscNew(&b));
  flow->state->bodies = b;
  PetscCall(PetscMalloc2(PARTS * scene->n_bodies, &b->body, PARTS * scene->n_bodies, &b->part));
  for (PetscInt q = 0; q < PARTS * scene->n_bodies; q++) {
    const Freedom *f = FreedomOf(scene, q / PARTS);

    if (!scene->boundary[SceneBodySide(scene, q / PARTS)].free || f->held >> (q % PARTS) & 1u)
      continue;
    b->body[b->n]   = q / PARTS;
    b->part[b->n++] = q % PARTS;
  }
  PetscCall(PetscCalloc2(b->n * b->n, &b->J, b->n * b->n, &b->kept));
  PetscCall(PetscCalloc4(b->n, &b->v, b->n, &b->R, b->n, &b->next, b->n, &b->s));
  PetscCall(PetscCalloc3(HISTORY * scene->n_bodies, &b->storage, scene->n_bodies, &b->reaction,
                         PARTS * scene->n_bodies, &b->push));
  for (PetscInt j = 0; j < HISTORY; j++) b->past[j] = &b->storage[j * scene->n_bodies];
  PetscCall(Remember(scene, b, flow->scheme));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Notes the present velocity and momenta of body k for t^n. */
static void NotePast(const Scene *scene, PetscInt k, FreeBodies *b)
{
  Pose *pose = &scene->pose[k];
  Past *now  = &b->past[0][k];

  for (PetscInt j = HISTORY - 1; j > 0; j--) b->past[j][k] = b->past[j - 1][k];
  for (PetscInt part = 0; part < PARTS; part++) now->v[part] = *PartOf(pose, part);
  Momenta(FreedomOf(scene, k), pose, now->momentum);
}

/* Sets the rates of velocity and spin in the formula of the step, for the pressure at walls. */
static void SetRates(const Flow *flow, PetscInt k)
{
  const FreeBodies *b    = flow->state->bodies;
  Pose             *pose = &flow->scene->pose[k];
  PetscReal         weight[HISTORY];
  const PetscReal   length = flow->clock->dt * HistoryStartWeights(flow->clock, weight);

  for (PetscInt part = 0; part < PARTS; part++) {
    PetscReal *rate = &pose->rate[part / FREEDOM_SPIN][part % FREEDOM_SPIN];

    *rate = *PartOf(pose, part);
    for (PetscInt j = 0; j < HISTORY; j++) *rate -= weight[j] * b->past[j][k].v[part];
    *rate /= length;
  }
}

/*
  FreeBodyMove - Moves free body k to the end of the step along its earlier velocities, and predicts
  its velocity there

    X += dt (w_0 U^n + w_1 U^{n-1} + w_2 U^{n-2}),   w of HistoryPath()

  Components that are held follow their velocity as typed.
*/
void FreeBodyMove(Flow *flow, PetscInt k)
{
  const Scene    *scene = flow->scene;
  const Clock    *clock = flow->clock;
  const Freedom  *f     = FreedomOf(scene, k);
  FreeBodies     *b     = flow->state->bodies;
  Pose           *pose  = &scene->pose[k];
  const PetscReal moves = SceneMoves(scene) ? clock->dt : 0.0;
  PetscReal       path[HISTORY], ahead[HISTORY], way[PARTS], given[PARTS];

  NotePast(scene, k, b);
  HistoryPath(clock, path);
  HistoryAhead(clock, 1.0, ahead);
  BodyGivenMotion(scene, SceneBodySide(scene, k), clock->t + 0.5 * clock->dt, given,
                  &given[FREEDOM_SPIN]);
  for (PetscInt part = 0; part < PARTS; part++) {
    way[part] = *PartOf(pose, part) = 0.0;
    for (PetscInt j = 0; j < HISTORY; j++) {
      way[part] += moves * path[j] * b->past[j][k].v[part];
      *PartOf(pose, part) += ahead[j] * b->past[j][k].v[part];
    }
    if (f->held >> part & 1u) way[part] = moves * given[part];
  }
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) pose->x[a] += way[a];
  PoseRotate(&way[FREEDOM_SPIN], pose);
  BodyGivenMotion(scene, SceneBodySide(scene, k), clock->t + clock->dt, given,
                  &given[FREEDOM_SPIN]);
  for (PetscInt part = 0; part < PARTS; part++)
    if (f->held >> part & 1u) *PartOf(pose, part) = given[part];
  SetRates(flow, k);
}

/* Returns the mass of a body and of the fluid that moves with it, infinite if it is not free
   [kg]. */
static PetscReal MovedMass(const Scene *scene, PetscInt side)
{
  const Freedom *f = &scene->boundary[side].freedom;

  return scene->boundary[side].free ? f->mass + scene->rho * f->volume : PETSC_INFINITY;
}

/* Measures the gap between a free body and another boundary by points on the surface of the body.
   Output: x, out - mean place, and mean normal of the other boundary, of the points nearer than GAP
   dx, with their depths below it as weights. Returns: the least gap, less the way of a step in
   which both keep their velocities; infinite without such a point [m]. */
static PetscReal MeasureGap(const Flow *flow, PetscInt side, PetscInt other, PetscReal x[],
                            PetscReal out[])
{
  const Scene    *scene = flow->scene;
  const Body     *body = BoundaryBody(scene, side), *solid = BoundaryBody(scene, other);
  const PetscReal dt = flow->clock->dt, end = flow->clock->t + dt;
  const PetscInt  n   = BodyPoints(body, PIECE * scene->dx);
  PetscReal       gap = PETSC_INFINITY, sum = 0.0;

  for (PetscInt i = 0; i < n; i++) {
    PetscReal y[ISPH_MAX_DIM], normal[ISPH_MAX_DIM], to[ISPH_MAX_DIM] = {0.0};
    PetscReal u[ISPH_MAX_DIM], v[ISPH_MAX_DIM], distance, depth;

    (void)BodyPoint(body, i, PIECE * scene->dx, y, normal);
    distance = solid ? BodyDistance(scene, solid, y, to) : SceneSideDistance(scene, other, y);
    if (!solid) to[other / 2] = other % 2 ? -1.0 : 1.0;
    depth = GAP * scene->dx - distance;
    if (depth <= 0.0) continue;
    SceneWallVelocity(scene, side, end, y, u);
    SceneWallVelocity(scene, other, end, y, v);
    for (PetscInt a = 0; a < scene->dim; a++) distance += dt * to[a] * (u[a] - v[a]);
    gap = PetscMin(gap, distance);
    sum += depth;
    for (PetscInt a = 0; a < scene->dim; a++) {
      x[a] += depth * y[a];
      out[a] += depth * to[a];
    }
  }
  for (PetscInt a = 0; a < scene->dim && sum > 0.0; a++) {
    x[a] /= sum;
    out[a] /= sum;
  }
  return gap;
}

/* Adds a force at x to the push-off of a free body. */
static void AddPush(const Scene *scene, PetscInt k, const PetscReal x[], const PetscReal force[],
                    FreeBodies *b)
{
  PetscReal *load = &b->push[k * PARTS];

  for (PetscInt a = 0; a < scene->dim; a++) load[a] += force[a];
  AddTorque(scene->dim, scene->pose[k].x, x, force, &load[FREEDOM_SPIN]);
}

/*
  Sets the push-offs of free bodies from other boundaries: where a gap g at the end of the step is
  below GAP dx, a force along its normal from the present velocities,

    F = PUSH M (GAP dx - g - dt dg/dt)/dt^2,   1/M = sum of 1/(m + rho V) of the free bodies

  They act on two free bodies with opposite signs, and keep bodies out of openings, too. Solves that
  are repeated keep them. Returns true if there are any.
*/
static PetscBool SetPushes(const Flow *flow, FreeBodies *b)
{
  const Scene    *scene = flow->scene;
  const PetscReal least = GAP * scene->dx;
  PetscBool       any   = PETSC_FALSE;

  for (PetscInt i = 0; i < PARTS * scene->n_bodies; i++) b->push[i] = 0.0;
  for (PetscInt k = 0; k < scene->n_bodies && SceneMoves(scene); k++) {
    const PetscInt side = SceneBodySide(scene, k);

    for (PetscInt other = 0; other < SceneBoundaries(scene) && scene->boundary[side].free;
         other++) {
      const PetscBool both            = scene->boundary[other].free;
      PetscReal       x[ISPH_MAX_DIM] = {0.0}, out[ISPH_MAX_DIM] = {0.0}, gap, size;

      if (other == side || (both && other < side)) continue;
      if (BoundaryIs(scene, other, BOUNDARY_CONTINUES)) continue;
      gap = MeasureGap(flow, side, other, x, out);
      if (gap >= least) continue;
      any  = PETSC_TRUE;
      size = PUSH * (least - gap) / PetscSqr(flow->clock->dt) /
             (1.0 / MovedMass(scene, side) + 1.0 / MovedMass(scene, other));
      for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) out[a] *= size;
      AddPush(scene, k, x, out, b);
      for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) out[a] = -out[a];
      if (both) AddPush(scene, other - SceneBodySide(scene, 0), x, out, b);
    }
  }
  return any;
}

/* Computes the forces and torques on body k besides those of the fluid, at the end of the step;
   adds the sizes of forces to `size`. */
static void ExternalLoad(const Flow *flow, PetscInt k, PetscReal load[PARTS], PetscReal *size)
{
  const Scene    *scene                = flow->scene;
  const Freedom  *f                    = FreedomOf(scene, k);
  const Body     *body                 = &scene->boundary[SceneBodySide(scene, k)].body;
  const Pose     *pose                 = &scene->pose[k];
  const PetscReal t                    = flow->clock->t + flow->clock->dt;
  const PetscBool axes                 = f->torque.n > 1;
  PetscReal       weight[ISPH_MAX_DIM] = {0.0};

  if (SceneHas(scene, PHYSICS_BODY_FORCE)) SceneBodyForce(scene, t, pose->x, weight);
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) {
    const PetscReal spring = -f->spring[a] * (pose->x[a] - body->centre[a]);
    const PetscReal given  = a < scene->dim ? ExpressionValue(&f->force, a, t, NULL) : 0.0;

    load[a] = given + spring + f->mass * weight[a];
    load[FREEDOM_SPIN + a] =
        axes || a == 2 ? ExpressionValue(&f->torque, axes ? a : 0, t, NULL) : 0.0;
    *size += PetscAbsReal(given) + PetscAbsReal(spring) +
             PetscMax(f->mass, scene->rho * f->volume) * PetscAbsReal(weight[a]) +
             PetscAbsReal(load[FREEDOM_SPIN + a]) / body->extent;
  }
  for (PetscInt part = 0; part < PARTS; part++) {
    const PetscReal push = flow->state->bodies->push[k * PARTS + part];

    load[part] += push;
    *size += PetscAbsReal(push) / (part < FREEDOM_SPIN ? 1.0 : body->extent);
  }
}

/* Computes the residuals of Newton's law of body k, in the pose the load of the fluid. Output: R -
   [N], [N m]; size - sum of the sizes of the forces [N]. */
static PetscErrorCode BodyResidual(Flow *flow, PetscInt k, PetscReal R[PARTS], PetscReal *size)
{
  const Scene    *scene  = flow->scene;
  FreeBodies     *b      = flow->state->bodies;
  Pose           *pose   = &scene->pose[k];
  const PetscReal extent = scene->boundary[SceneBodySide(scene, k)].body.extent;
  PetscReal       fluid[2 * ISPH_MAX_DIM], load[PARTS], now[PARTS], weight[HISTORY], length;

  PetscFunctionBegin;
  length = flow->clock->dt * HistoryStartWeights(flow->clock, weight);
  if (!b->reaction[k]) PetscCall(ReactionCreate(flow, SceneBodySide(scene, k), &b->reaction[k]));
  PetscCall(ReactionForce(flow, PETSC_TRUE, b->reaction[k], fluid));
  *size = scene->rho * (SceneHas(scene, PHYSICS_VISCOSITY) ? scene->nu_low : 0.0) *
          flow->scheme->stats.speed_max * (scene->dim == 3 ? extent : 1.0);
  ExternalLoad(flow, k, load, size);
  Momenta(FreedomOf(scene, k), pose, now);
  for (PetscInt part = 0; part < PARTS; part++) {
    PetscReal *const to = &(part < FREEDOM_SPIN ? pose->force : pose->torque)[part % FREEDOM_SPIN];
    PetscReal        start = 0.0;

    for (PetscInt j = 0; j < HISTORY; j++) start += weight[j] * b->past[j][k].momentum[part];
    *to     = fluid[part];
    R[part] = (now[part] - start) / length - fluid[part] - load[part];
    *size += PetscAbsReal(fluid[part]) / (part < FREEDOM_SPIN ? 1.0 : extent);
    *size += PetscAbsReal(now[part] - start) / (length * (part < FREEDOM_SPIN ? 1.0 : extent));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns an estimate of the diagonal of dR/dv for an unknown: the inertia of the body and of the
   fluid that moves with it over k, and the drag, each in units of velocity and force [kg/s]. */
static PetscReal Estimate(const Flow *flow, PetscInt k, PetscInt part, PetscReal length)
{
  const Scene    *scene  = flow->scene;
  const Freedom  *f      = FreedomOf(scene, k);
  const PetscReal extent = scene->boundary[SceneBodySide(scene, k)].body.extent;
  const PetscReal nu     = SceneHas(scene, PHYSICS_VISCOSITY) ? scene->nu_low : 0.0;
  const PetscReal area   = 2.0 * PETSC_PI * (scene->dim == 2 ? extent : 2.0 * PetscSqr(extent));
  const PetscInt  axis   = part - FREEDOM_SPIN;
  const PetscReal mass   = part < FREEDOM_SPIN ? f->mass + scene->rho * f->volume
                                               : f->inertia[axis][axis] / PetscSqr(extent);

  return mass / length + scene->rho * area * (PetscSqrtReal(nu / length) + 2.0 * nu / extent);
}

/* Begins the matrix of a step: that of the last step, with the change of the inertia over k. */
static void BeginMatrix(const Flow *flow, PetscReal length, FreeBodies *b)
{
  for (PetscInt i = 0; i < b->n * b->n; i++) b->J[i] = b->kept[i];
  for (PetscInt i = 0; i < b->n && b->length != length; i++) {
    b->J[i * b->n + i] += Estimate(flow, b->body[i], b->part[i], length);
    if (b->length > 0.0) b->J[i * b->n + i] -= Estimate(flow, b->body[i], b->part[i], b->length);
  }
}

/* Improves the matrix by Broyden's formula from the last trial to the present one. */
static void ImproveMatrix(const PetscReal v[], const PetscReal R[], FreeBodies *b)
{
  const PetscInt n  = b->n;
  PetscReal      ss = 0.0;

  for (PetscInt i = 0; i < n; i++) {
    b->s[i] = v[i] - b->v[i];
    ss += PetscSqr(b->s[i]);
  }
  for (PetscInt i = 0; i < n && ss > 0.0; i++) {
    PetscReal y = R[i] - b->R[i];

    for (PetscInt j = 0; j < n; j++) y -= b->J[i * n + j] * b->s[j];
    for (PetscInt j = 0; j < n; j++) b->J[i * n + j] += y * b->s[j] / ss;
  }
}

/* Sets the next velocities, v - J^-1 R. */
static PetscErrorCode SetNext(const PetscReal v[], const PetscReal R[], FreeBodies *b)
{
  PetscReal *A, *d;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(b->n * b->n, &A, b->n, &d));
  for (PetscInt i = 0; i < b->n * b->n; i++) A[i] = b->J[i % b->n * b->n + i / b->n]; /* J^T */
  PetscCall(PetscArraycpy(d, R, b->n));
  DenseEliminate(b->n, A, 1, d);
  for (PetscInt i = 0; i < b->n; i++) {
    b->next[i] = v[i] - d[i] / A[i * b->n + i];
    b->v[i]    = v[i];
    b->R[i]    = R[i];
  }
  PetscCall(PetscFree2(A, d));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets unknowns and residuals in units of velocity and force; met: all residuals are small. */
static PetscErrorCode Measure(Flow *flow, PetscReal v[], PetscReal R[], PetscBool *met)
{
  const Scene *scene      = flow->scene;
  FreeBodies  *b          = flow->state->bodies;
  PetscReal    all[PARTS] = {0.0}, size = 0.0;
  PetscInt     at = -1;

  PetscFunctionBegin;
  *met = PETSC_TRUE;
  for (PetscInt i = 0; i < b->n; i++) {
    const PetscInt  k = b->body[i], part = b->part[i];
    const PetscReal unit = UnitOf(scene, k, part);

    if (k != at) PetscCall(BodyResidual(flow, k, all, &size));
    at   = k;
    v[i] = unit * *PartOf(&scene->pose[k], part);
    R[i] = all[part] / unit;
    if (!(PetscAbsReal(R[i]) <= TOLERANCE * size)) *met = PETSC_FALSE;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Fails a step whose bodies do not obey Newton's law. */
static PetscErrorCode FailBodies(Flow *flow, const PetscReal R[])
{
  PetscReal most = 0.0;
  char      where[CLOCK_WHERE];

  PetscFunctionBegin;
  for (PetscInt i = 0; i < flow->state->bodies->n; i++) most = PetscMax(most, PetscAbsReal(R[i]));
  PetscCall(ClockWhere(flow->clock, where));
  FailureSet(&flow->scheme->failure, PETSC_ERR_NOT_CONVERGED,
             "%s: forces on a free body are not balanced after %d solves: %.2g N remain; try a "
             "smaller -dt, or tighter tolerances of the solvers",
             where, TRIALS, (double)most);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Decides if Newton's law holds for the velocities that the bodies had in the solve. */
static PetscErrorCode DecideBodies(Flow *flow, Trial *trial, PetscBool *again)
{
  FreeBodies *b = flow->state->bodies;
  PetscReal   weight[HISTORY], length, *v, *R;
  PetscBool   met;

  PetscFunctionBegin;
  length = flow->clock->dt * HistoryStartWeights(flow->clock, weight);
  PetscCall(PetscMalloc2(b->n, &v, b->n, &R));
  if (trial->times == 0 && SceneMoves(flow->scene)) PetscCall(FreeReactions(flow->scene, b));
  if (trial->times == 0) b->pushed = SetPushes(flow, b);
  PetscCall(Measure(flow, v, R, &met));
  if (trial->times == 0) BeginMatrix(flow, length, b);
  else ImproveMatrix(v, R, b);
  if (!met && trial->times >= TRIALS) {
    PetscCall(FailBodies(flow, R));
  } else if (!met) {
    PetscCall(SetNext(v, R, b));
    *again = PETSC_TRUE;
  } else {
    PetscCall(PetscArraycpy(b->kept, b->J, b->n * b->n));
    b->length = length;
    b->contacts += b->pushed ? 1.0 : 0.0;
    b->solves += ((PetscReal)trial->times + 1.0 - b->solves) / ((PetscReal)flow->clock->step + 1.0);
  }
  PetscCall(PetscFree2(v, R));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gives the next velocities to the bodies. */
static PetscErrorCode TreatBodies(Flow *flow)
{
  const FreeBodies *b = flow->state->bodies;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < b->n; i++)
    *PartOf(&flow->scene->pose[b->body[i]], b->part[i]) =
        b->next[i] / UnitOf(flow->scene, b->body[i], b->part[i]);
  for (PetscInt i = 0; i < b->n; i++) SetRates(flow, b->body[i]);
  if (flow->scheme->splines) PetscCall(SplinesBegin(flow->scheme->splines));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool HasFreeBodies(const Flow *flow)
{
  return flow->state->bodies ? PETSC_TRUE : PETSC_FALSE;
}

const Judge JudgeBodies = {.name    = "bodies",
                           .brief   = "solves are repeated until Newton's law of free bodies holds",
                           .Applies = HasFreeBodies,
                           .again   = AGAIN_SOLVES,
                           .Decide  = DecideBodies,
                           .Treat   = TreatBodies};
