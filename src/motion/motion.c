/* The motion of particles: with the flow (gradedmotion.c: along its streamlines), and by a small
   shift that keeps them evenly spread. Taylor series give the change of their fields. */
#include "isph/motion.h"
#include "isph/strain.h"

#define PASSES    0.5 /* distance from a side below which a particle passes it [dx_i] */
#define CLEARANCE 0.3 /* least distance of particles from walls [dx_i] */
#define MOVE_MOST 0.6 /* displacement with the flow above which a step is undone [dx_i] */

/* Derivatives at the old positions, which give the change of the fields of a displaced particle:
   the gradient of the pressure; with shifting also grad u and, if the viscous operator is a
   Laplacian, lap u; with the velocity filter also grad u and the residual of a quadratic fit of u.
   Unneeded vectors are NULL. */
typedef struct {
  Vec                p_vec[ISPH_MAX_DIM], u_vec[ISPH_MAX_DIM][ISPH_MAX_DIM];
  Vec                lap_vec[ISPH_MAX_DIM], residual_vec[ISPH_MAX_DIM];
  const PetscScalar *p[ISPH_MAX_DIM];               /* dp/dx_a */
  const PetscScalar *u[ISPH_MAX_DIM][ISPH_MAX_DIM]; /* du_c/dx_a at [c][a] */
  const PetscScalar *lap[ISPH_MAX_DIM];             /* lap u_c */
  const PetscScalar *residual[ISPH_MAX_DIM];        /* residual of the fit of u_c */
} Slopes;

/* Computes y = op f in a work vector and gets the array of this vector in `slope`. */
static PetscErrorCode SlopeGet(Flow *flow, const AffineOperator *op, Vec f, Vec walls, Vec *y,
                               const PetscScalar **slope)
{
  PetscFunctionBegin;
  PetscCall(FlowGetWork(flow, y));
  PetscCall(AffineApply(op, f, walls, *y));
  PetscCall(VecGetArrayRead(*y, slope));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lists the operators whose products with velocity component c are needed, and the places of the
   products; returns their number. */
static PetscInt ListSlopes(const Flow *flow, PetscBool shifting, PetscInt c, Slopes *t,
                           const AffineOperator *op[], Vec *to[], const PetscScalar **slope[])
{
  const VelocityOperators *of = OperatorsOfVelocity(flow->ops, c);
  PetscInt                 n  = 0;

  for (PetscInt a = 0; (shifting || of->filter_u.needed) && a < flow->scene->dim; a++) {
    op[n]      = &of->grad_u[a];
    to[n]      = &t->u_vec[c][a];
    slope[n++] = &t->u[c][a];
  }
  if (shifting && of->visc.needed && flow->ops->forms.visc_is_laplacian) {
    op[n]      = &of->visc;
    to[n]      = &t->lap_vec[c];
    slope[n++] = &t->lap[c];
  }
  if (of->filter_u.needed) {
    op[n]      = &of->filter_u;
    to[n]      = &t->residual_vec[c];
    slope[n++] = &t->residual[c];
  }
  return n;
}

/* Computes the derivatives of all velocity components. */
static PetscErrorCode VelocitySlopesGet(Flow *flow, PetscBool shifting, Slopes *t)
{
  AffineProducts      products = {.fields = flow->scene->dim};
  const PetscScalar **slope[ISPH_MAX_DIM][AFFINE_MOST];

  PetscFunctionBegin;
  for (PetscInt c = 0; c < flow->scene->dim; c++) {
    Vec *to[AFFINE_MOST];

    products.f[c]     = flow->state->u[c];
    products.walls[c] = flow->walls.u[c];
    products.n        = ListSlopes(flow, shifting, c, t, products.op[c], to, slope[c]);
    for (PetscInt k = 0; k < products.n; k++) {
      PetscCall(FlowGetWork(flow, to[k]));
      products.y[c][k] = *to[k];
    }
  }
  PetscCall(AffineApplyFields(&products));
  for (PetscInt e = 0; e < products.fields * products.n; e++)
    PetscCall(VecGetArrayRead(products.y[e / products.n][e % products.n],
                              slope[e / products.n][e % products.n]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SlopeRestore(Flow *flow, Vec *y, const PetscScalar **slope)
{
  PetscFunctionBegin;
  if (!*y) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecRestoreArrayRead(*y, slope));
  PetscCall(FlowRestoreWork(flow, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SlopesGet(Flow *flow, PetscBool shifting, Slopes *t)
{
  const Operators *ops = flow->ops;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(t, sizeof(*t)));
  for (PetscInt a = 0; flow->state->p && ops->grad_p[0].needed && a < flow->scene->dim; a++)
    PetscCall(
        SlopeGet(flow, &ops->grad_p[a], flow->state->p, flow->walls.p, &t->p_vec[a], &t->p[a]));
  PetscCall(VelocitySlopesGet(flow, shifting, t));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SlopesRestore(Flow *flow, Slopes *t)
{
  PetscFunctionBegin;
  for (PetscInt a = 0; a < flow->scene->dim; a++) {
    PetscCall(SlopeRestore(flow, &t->p_vec[a], &t->p[a]));
    for (PetscInt c = 0; c < flow->scene->dim; c++)
      PetscCall(SlopeRestore(flow, &t->u_vec[c][a], &t->u[c][a]));
    PetscCall(SlopeRestore(flow, &t->lap_vec[a], &t->lap[a]));
    PetscCall(SlopeRestore(flow, &t->residual_vec[a], &t->residual[a]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lets no shift keep particle i in the box that leaves: closer to a side than half of its cell is
   long, the fluid beyond pushes it back, and where the velocity is small the fluid gets denser, by
   6 % in channels with an open top. */
static void ShiftOut(const Flow *flow, PetscInt i, PetscReal shift[])
{
  const Scene     *scene           = flow->scene;
  const Particles *p               = flow->particles;
  PetscReal        x[ISPH_MAX_DIM] = {0.0}, u[ISPH_MAX_DIM];

  for (PetscInt a = 0; a < p->dim; a++) {
    x[a] = p->x[a][i];
    u[a] = p->u[a][i];
  }
  for (PetscInt side = 0; flow->state->openings.open && side < 2 * p->dim; side++) {
    if (SideEntering(side, shift) <= 0.0 || SideEntering(side, u) > 0.0) continue;
    if (SceneSideDistance(scene, side, x) > PASSES * p->dx[i]) continue;
    if (BoundaryLetsOut(scene, side, flow->clock->t, x)) shift[side / 2] = 0.0;
  }
}

/* Computes the shift of particle i, in the stretched coordinates in which its cell is a cube. */
static void ShiftParticle(const Flow *flow, const Slopes *slopes, PetscInt i, PetscReal shift[])
{
  const Scene     *scene = flow->scene;
  const FlowState *state = flow->state;
  const PetscReal  dx    = flow->particles->dx[i];
  const PetscReal  speed = flow->scheme->stats.speed_max;
  PetscReal        gradient_c[ISPH_MAX_DIM], rate2 = 0.0, disturbance = 0.0;

  for (PetscInt a = 0; a < scene->dim; a++) {
    gradient_c[a] =
        flow->ops->concentration.gradient[a][i] / ParticlesStretch(flow->particles, a, i);
    for (PetscInt c = 0; c < scene->dim; c++) rate2 += PetscSqr(slopes->u[c][a][i]);
  }
  state->shift->Displace(scene->dim, dx, state->shift_strength, speed, PetscSqrtReal(rate2),
                         flow->clock->dt, gradient_c, shift);
  if (flow->clock->step == 0 && !SceneHasFreeSurface(scene))
    disturbance = state->shift->disturbance * dx * ShiftStepFactor(dx, speed, flow->clock->dt);
  for (PetscInt a = 0; a < scene->dim; a++) {
    if (disturbance > 0.0)
      shift[a] += disturbance * ParticlesHash(scene->seed + 1, flow->particles->id[i], a);
    shift[a] /= ParticlesStretch(flow->particles, a, i);
  }
  ShiftOut(flow, i, shift);
}

/* Computes the change of the velocity of particle i by its shift s, s.grad u + |s|^2/(2d) lap u in
   d dimensions. */
static void FollowShift(const Scene *scene, const Slopes *slopes, PetscInt i,
                        const PetscReal shift[], PetscReal change[])
{
  PetscReal length2 = 0.0;

  for (PetscInt a = 0; a < scene->dim; a++) length2 += PetscSqr(shift[a]);
  for (PetscInt c = 0; c < scene->dim; c++) {
    change[c] = slopes->lap[c] ? 0.5 * length2 / scene->dim * slopes->lap[c][i] : 0.0;
    for (PetscInt a = 0; a < scene->dim; a++) change[c] += shift[a] * slopes->u[c][a][i];
  }
}

/* Filters grid modes out of the velocity of particle i, see VelocityFilter(). */
static void FilterVelocity(const Flow *flow, const Slopes *slopes, PetscInt i, PetscBool across,
                           PetscReal change[])
{
  const PetscInt dim = flow->scene->dim;
  PetscReal      A[ISPH_MAX_DIM][ISPH_MAX_DIM], r[ISPH_MAX_DIM];

  for (PetscInt c = 0; c < dim; c++) {
    r[c] = slopes->residual[c][i];
    for (PetscInt a = 0; a < dim; a++) A[c][a] = slopes->u[c][a][i];
  }
  VelocityFilter(dim, A, r, flow->state->velocity_filter, across, flow->clock->dt, change);
}

/* Fails the step if a particle moved further than MOVE_MOST; collective. */
static PetscErrorCode CheckMove(Flow *flow, PetscReal moved)
{
  char where[CLOCK_WHERE];

  PetscFunctionBegin;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &moved, 1, MPIU_REAL, MPIU_MAX, PETSC_COMM_WORLD));
  if (moved <= MOVE_MOST) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ClockWhere(flow->clock, where));
  FailureSet(&flow->scheme->failure, PETSC_ERR_FP,
             "%s: a particle moved by %.3g dx, more than %.3g; try a smaller -dt or -cfl", where,
             (double)moved, MOVE_MOST);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Stops a particle without strain cells, on which no wall acts, where a wall keeps it off. Input:
   x - its place there; flown, shift - its displacement without the wall [m]. Output: change - of
   the velocity [m/s]. */
static void StopAtWall(const Particles *p, PetscInt i, const PetscReal x[], const PetscReal flown[],
                       const PetscReal shift[], PetscReal change[])
{
  PetscReal off[ISPH_MAX_DIM], size = 0.0, into = 0.0;

  for (PetscInt a = 0; a < p->dim; a++) {
    off[a] = x[a] - (p->x[a][i] + flown[a] + shift[a]);
    size += PetscSqr(off[a]);
    into += p->u[a][i] * off[a];
  }
  for (PetscInt a = 0; a < p->dim && into < 0.0; a++) change[a] -= into / size * off[a];
}

/* Displaces all own fluid particles and changes their fields; moved: largest displacement by the
   flow [dx_i], or [edges of the cell]. */
static PetscErrorCode DisplaceParticles(Flow *flow, const Slopes *slopes, PetscReal *moved,
                                        PetscReal *work)
{
  const Scene    *scene    = flow->scene;
  const Clock    *clock    = flow->clock;
  Particles      *p        = flow->particles;
  FlowState      *state    = flow->state;
  const PetscBool shifting = state->shift->Displace ? PETSC_TRUE : PETSC_FALSE;
  const PetscBool graded   = SceneMovesGraded(scene);
  const PetscBool across   = VelocityFilterActsOnShear(flow);

  PetscReal *const *filtered = state->acceleration.filtered;
  PetscReal         moved2   = 0.0, weight[HISTORY];

  PetscFunctionBegin;
  HistoryPath(clock, weight);
  *work = 0.0;
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscReal shift[ISPH_MAX_DIM] = {0.0}, change[ISPH_MAX_DIM] = {0.0}, d2 = 0.0;
    PetscReal flown[ISPH_MAX_DIM], x[ISPH_MAX_DIM], path[ISPH_MAX_DIM];
    PetscReal slip[ISPH_MAX_DIM];

    if (shifting) ShiftParticle(flow, slopes, i, shift);
    for (PetscInt a = 0; a < scene->dim; a++) {
      flown[a] = weight[0] * p->u[a][i] + weight[1] * state->u_previous[a][i];
      if (weight[2] != 0.0) flown[a] += weight[2] * state->u_earlier[a][i];
      flown[a] *= clock->dt;
    }
    for (PetscInt a = 0; a < scene->dim; a++) slip[a] = -p->x[a][i] - flown[a];
    if (graded) GradedPath(scene, p, i, flown);
    for (PetscInt a = 0; a < scene->dim; a++) {
      x[a] = p->x[a][i] + flown[a] + shift[a];
      d2 += PetscSqr(ParticlesStretch(p, a, i) * flown[a]);
    }
    if (SceneIsMapped(scene)) GradedKeepOffSides(scene, CLEARANCE, x);
    else SceneKeepOffWalls(scene, clock->t, CLEARANCE * p->dx[i], x);
    if (flow->ops->cut_surface && flow->ops->strain->apart[i])
      StopAtWall(p, i, x, flown, shift, change);
    for (PetscInt a = 0; a < scene->dim; a++) {
      path[a]  = x[a] - p->x[a][i];
      shift[a] = path[a] - flown[a];
    }
    for (PetscInt a = 0; a < scene->dim; a++) slip[a] += x[a];
    if (p->fluid) InterfaceSlip(p, i, slip);
    *work += EnergyWork(flow, i, path);
    if (shifting && !flow->ops->cut_surface) FollowShift(scene, slopes, i, shift, change);
    if (flow->ops->velocity[0].filter_u.needed) {
      PetscReal before[ISPH_MAX_DIM];

      for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) before[a] = change[a];
      FilterVelocity(flow, slopes, i, across, change);
      for (PetscInt a = 0; filtered[0] && a < scene->dim; a++)
        filtered[a][i] = (change[a] - before[a]) / clock->dt;
    }
    d2 /= PetscSqr(p->dx[i]);
    moved2 = PetscIsNanReal(d2) ? PETSC_INFINITY : PetscMax(moved2, d2);
    for (PetscInt a = 0; a < scene->dim; a++) {
      if (slopes->p[a]) p->p[i] += (x[a] - p->x[a][i]) * slopes->p[a][i];
      p->x[a][i] = x[a];
      p->u[a][i] += change[a];
      state->u_previous[a][i] += change[a];
      if (state->u_earlier[a]) state->u_earlier[a][i] += change[a];
    }
  }
  *moved = PetscSqrtReal(moved2);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  FlowMove - Moves particles from x^n to x^{n+1} by Adams-Bashforth with shifting, and changes their
  fields

    dr = dt (w_0 u^n + w_1 u^{n-1} + w_2 u^{n-2}) + s,   w of HistoryPath()
    u += s.grad u + |s|^2/(2d) lap u - filter of VelocityFilter(),   p += dr.grad p

  Collective. Earlier velocities receive the same change as u^n, so that it is no change in time.
  The pressure is carried as an Eulerian field, unless a scheme has it fixed in space.
  The velocity belongs to the particle and changes only by the shift s and the filter. s includes
  the displacement by SceneKeepOffWalls(). If the velocity did not change with this displacement,
  particles would carry the speed of a moving lid away from the lid, as they do without shifting.
  The term with lap u is the mean of s s : grad grad u/2 over directions of s; without it shifting
  feeds energy into the flow. Bodies move first, and particles keep off their new surfaces. On entry
  the operators belong to x^n; on exit they, owners and halo are out of date. See theory.md,
  (motion:step), (motion:fields) and (motion:shift).
*/
PetscErrorCode FlowMove(Flow *flow)
{
  PetscReal moved, work;
  Slopes    slopes;

  PetscFunctionBegin;
  PetscCall(SlopesGet(flow, flow->state->shift->Displace ? PETSC_TRUE : PETSC_FALSE, &slopes));
  if (flow->scene->pose) PetscCall(BodiesMove(flow)); /* slopes are of the old places of walls */
  PetscCall(DisplaceParticles(flow, &slopes, &moved, &work));
  PetscCall(EnergyAddWork(flow, work));
  PetscCall(SlopesRestore(flow, &slopes));
  if (flow->clock->adapt->retries) PetscCall(CheckMove(flow, moved));
  PetscFunctionReturn(PETSC_SUCCESS);
}
