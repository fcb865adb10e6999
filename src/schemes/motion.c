/*
  Moving particles: with the flow, then a little aside so that they stay evenly spread; the fields
  they carry follow by Taylor series.
*/
#include "projection.h"

#define FILTER_RATE 2.0 /* over |A A|^(1/2) [-] */

/* Keeps a displaced position 0.3 dx off every wall; mends x. */
static void KeepOffWalls(const Scene *scene, PetscReal x[])
{
  const PetscReal clearance = 0.3 * scene->dx;
  WallPlane       planes[SCENE_MAX_PLANES];
  PetscInt        n;

  SceneWallPlanes(scene, x, clearance, planes, &n);
  for (PetscInt q = 0; q < n; q++) {
    for (PetscInt a = 0; a < scene->dim; a++) {
      x[a] += (clearance - planes[q].distance) * planes[q].normal[a];
    }
  }
}

/*
  What changes fields, at the old positions: grad p always; grad u and, where it is at hand, lap
  u where there is shifting; grad u and u less its fit where velocities are filtered. Arrays are
  NULL where they are not needed.
*/
typedef struct {
  const PetscScalar *p[ISPH_MAX_DIM];               /* dp/dx_a */
  const PetscScalar *u[ISPH_MAX_DIM][ISPH_MAX_DIM]; /* du_c/dx_a at [c][a] */
  const PetscScalar *lap[ISPH_MAX_DIM];             /* lap u_c */
  const PetscScalar *rough[ISPH_MAX_DIM];           /* u_c - fit */
} Slopes;

/* y = op u, read through slope; y is made when it is first wanted in an epoch. */
static PetscErrorCode SlopeOf(const AffineOperator *op, Vec u, Vec walls, Vec *y,
                              const PetscScalar **slope)
{
  PetscFunctionBegin;
  if (!*y) PetscCall(VecDuplicate(u, y));
  PetscCall(AffineApply(op, u, walls, *y));
  PetscCall(VecGetArrayRead(*y, slope));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SlopesGet(const Scene *scene, const Operators *ops, PetscBool shifting,
                                Projection *pr, Slopes *slopes)
{
  PetscFunctionBegin;
  PetscCall(PetscMemzero(slopes, sizeof(*slopes)));
  for (PetscInt a = 0; a < scene->dim; a++) {
    if (pr->p) {
      PetscCall(SlopeOf(&ops->grad_p[a], pr->p, ops->wall_dpdn, &pr->force[a], &slopes->p[a]));
    }
    for (PetscInt c = 0; (shifting || ops->filter_u.needed) && c < scene->dim; c++) {
      PetscCall(SlopeOf(&ops->grad_u[a], pr->u[c], ops->wall_u[c], &pr->velocity_slope[c][a],
                        &slopes->u[c][a]));
    }
    if (shifting && ops->visc.needed && ops->visc_is_laplacian) {
      PetscCall(SlopeOf(&ops->visc, pr->u[a], ops->wall_u[a], &pr->star[a], &slopes->lap[a]));
    }
    if (ops->filter_u.needed) {
      PetscCall(
          SlopeOf(&ops->filter_u, pr->u[a], ops->wall_u[a], &pr->rough[a], &slopes->rough[a]));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SlopesRestore(const Scene *scene, Projection *pr, Slopes *slopes)
{
  PetscFunctionBegin;
  for (PetscInt a = 0; a < scene->dim; a++) {
    if (slopes->p[a]) PetscCall(VecRestoreArrayRead(pr->force[a], &slopes->p[a]));
    for (PetscInt c = 0; c < scene->dim; c++) {
      if (slopes->u[c][a])
        PetscCall(VecRestoreArrayRead(pr->velocity_slope[c][a], &slopes->u[c][a]));
    }
    if (slopes->lap[a]) PetscCall(VecRestoreArrayRead(pr->star[a], &slopes->lap[a]));
    if (slopes->rough[a]) PetscCall(VecRestoreArrayRead(pr->rough[a], &slopes->rough[a]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Where particle i is shifted to, beside its flight. */
static void ShiftParticle(const Scene *scene, const Clock *clock, const Particles *p,
                          const Operators *ops, const Scheme *scheme, const Slopes *slopes,
                          PetscInt i, PetscReal shift[])
{
  PetscReal gradient_c[ISPH_MAX_DIM], rate2 = 0.0;

  for (PetscInt a = 0; a < scene->dim; a++) {
    gradient_c[a] = ops->gradient_c[a][i];
    for (PetscInt c = 0; c < scene->dim; c++) rate2 += PetscSqr(slopes->u[c][a][i]);
  }
  scheme->shift->Displace(scene, scheme->shift_strength, scheme->stats.speed_max,
                          PetscSqrtReal(rate2), clock->dt, gradient_c, shift);
  for (PetscInt a = 0; a < scene->dim; a++) {
    if (clock->step == 0)
      shift[a] +=
          scheme->shift->disturbance * scene->dx * ParticlesHash(scene->seed + 1, p->id[i], a);
  }
}

/* What particle i's velocity changes by where it is shifted: s.grad u + |s|^2/2d lap u. */
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

/*
  Takes from particle i's velocity what changes from one particle to the next,

    u -= S min(1, RATE dt |A A|^(1/2)) (u - fit),   A_ca = du_c/dx_a,   |.| Frobenius' norm

  |A A|^(1/2) is the rate at which the flow can feed disturbances: the eigenvalues of A in strain
  and rotation, nothing in parallel flow however sheared, so that boundary layers as thin as dx are
  left alone. Where the flow is resolved that is U/L, and the filter of third order.
*/
static void FilterVelocity(const Scene *scene, const Slopes *slopes, PetscInt i, PetscReal strength,
                           PetscReal dt, PetscReal change[])
{
  PetscReal square = 0.0, share;

  for (PetscInt c = 0; c < scene->dim; c++) {
    for (PetscInt a = 0; a < scene->dim; a++) {
      PetscReal entry = 0.0;

      for (PetscInt b = 0; b < scene->dim; b++) entry += slopes->u[c][b][i] * slopes->u[b][a][i];
      square += PetscSqr(entry);
    }
  }
  share = strength * PetscMin(1.0, FILTER_RATE * dt * PetscSqrtReal(PetscSqrtReal(square)));
  for (PetscInt c = 0; c < scene->dim; c++) change[c] -= share * slopes->rough[c][i];
}

/* A particle that flew further than is allowed makes the step a failed one. Collective. */
static PetscErrorCode CheckMove(const Scene *scene, const Clock *clock, PetscReal moved,
                                Scheme *scheme)
{
  char where[CLOCK_WHERE];

  PetscFunctionBegin;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &moved, 1, MPIU_REAL, MPIU_MAX, PETSC_COMM_WORLD));
  if (moved <= clock->move_max * scene->dx) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ClockWhere(clock, where));
  FailureSet(
      &scheme->failure, PETSC_ERR_FP,
      "%s: a particle moved by %.3g dx, more than -dt_move_max %.3g; try a smaller -dt or -cfl",
      where, (double)(moved / scene->dx), (double)clock->move_max);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  ParticlesMove - Takes particles from x^n to x^{n+1} by Adams-Bashforth and shifts them

    dr = dt ((1 + w/2) u^n - w/2 u^{n-1}) + s,   w = ClockRatio()
    u += s.grad u + |s|^2/(2d) lap u,   p += dr.grad p

  Collective. The pressure is carried as an Eulerian field, velocities as the particles' own but for
  the shift s, what keeps particles off walls included: without that, those pushed off a moving lid
  keep its speed, as they do where there is no shifting. The second-order term stands for
  s s : grad grad u, whose mean it is; without it shifting feeds energy into the flow. On entry the
  operators are those at x^n; on exit they are stale.
*/
PetscErrorCode ParticlesMove(const Scene *scene, const Clock *clock, Operators *ops, Particles *p,
                             Scheme *scheme)
{
  Projection     *pr       = (Projection *)scheme->data;
  const PetscBool shifting = scheme->shift->Displace ? PETSC_TRUE : PETSC_FALSE;
  const PetscReal w        = scheme->time_order == 2 ? ClockRatio(clock) : 0.0;
  PetscReal       moved2   = 0.0;
  Slopes          slopes;

  PetscFunctionBegin;
  PetscCall(SlopesGet(scene, ops, shifting, pr, &slopes));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscReal shift[ISPH_MAX_DIM] = {0.0}, change[ISPH_MAX_DIM] = {0.0}, d2 = 0.0;
    PetscReal flown[ISPH_MAX_DIM], x[ISPH_MAX_DIM];

    if (shifting) ShiftParticle(scene, clock, p, ops, scheme, &slopes, i, shift);
    for (PetscInt a = 0; a < scene->dim; a++) {
      flown[a] = clock->dt * ((1.0 + 0.5 * w) * p->u[a][i] - 0.5 * w * pr->u_previous[a][i]);
      x[a]     = p->x[a][i] + flown[a] + shift[a];
      d2 += PetscSqr(flown[a]);
    }
    KeepOffWalls(scene, x);
    for (PetscInt a = 0; a < scene->dim; a++) shift[a] = x[a] - p->x[a][i] - flown[a];
    if (shifting) FollowShift(scene, &slopes, i, shift, change);
    if (ops->filter_u.needed)
      FilterVelocity(scene, &slopes, i, ops->velocity_filter, clock->dt, change);
    moved2 = PetscIsNanReal(d2) ? PETSC_INFINITY : PetscMax(moved2, d2);
    for (PetscInt a = 0; a < scene->dim; a++) {
      if (p->p) p->p[i] += (x[a] - p->x[a][i]) * slopes.p[a][i];
      p->x[a][i] = x[a];
      p->u[a][i] += change[a];
      pr->u_previous[a][i] += change[a];
    }
  }
  PetscCall(SlopesRestore(scene, pr, &slopes));
  if (clock->adapt->retries) PetscCall(CheckMove(scene, clock, PetscSqrtReal(moved2), scheme));
  PetscFunctionReturn(PETSC_SUCCESS);
}
