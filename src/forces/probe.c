/*
  Values at points: a quadratic moving-least-squares fit about each point,

    f(x + X) = c_0 + sum_t c_t phi_t(X/R),   min sum_k W_k (f_k - fit(X_k))^2,   value = c_0,

  with the offsets X_k of the neighbours k, the radius R of the support and the kernel W. The rank
  that owns the point computes the fit. It is exact for quadratic fields, on walls and in corners
  too. Points outside a free surface have no values.

  Reference: P. Lancaster & K. Salkauskas, Math. Comput. 37 (1981) 141-158
*/
#include "isph/forces.h"
#include "isph/strain.h"

#define DRY       0.49 /* concentration below which a point is dry; 1/2 on a surface */
#define KEY       (4 + ISPH_MAX_DIM) /* numbers that tell fits apart */
#define KEPT_MOST (1 << 24)          /* numbers of kept fits on a rank, 128 MiB */

/* Data shared by the fits of all points. */
typedef struct {
  const Flow *flow;
  Cells       cells;
  PetscReal  *field[ISPH_MAX_DIM + 1]; /* particle fields u, then p, with halo [m/s], [Pa] */
  PetscInt    n_fields;
  PetscInt    degree; /* of the fits, 2 or 3 */
  PetscReal   reach;  /* distance from own points within which this rank has all particles [m] */
  PetscInt   *list;   /* neighbours of the present point */
  PetscReal  *s[ISPH_MAX_DIM], *W; /* their offsets over the radius and kernels [-], [m^-dim] */
  PetscReal  *w[1 + ISPH_MAX_DIM]; /* weights in the value and its derivatives [-], [1/m] */
} Probe;

/* The support about a point: its radius along stretched axes, see SceneStretch(). */
typedef struct {
  PetscReal R, stretch[ISPH_MAX_DIM], least; /* [m], [-], the least of them */
} ProbeBall;

/* Returns the support for the spacing of the scene at x. */
static ProbeBall ProbeSupport(const Probe *probe, const PetscReal x[])
{
  const OperatorForms *forms = &probe->flow->ops->forms;
  const Scene         *scene = probe->flow->scene;
  ProbeBall            ball;

  ball.R = forms->kernel->support * (forms->h_over_dx * SceneSpacing(scene, x));
  SceneStretch(scene, x, ball.stretch);
  ball.least = ball.stretch[0];
  for (PetscInt a = 1; a < scene->dim; a++) ball.least = PetscMin(ball.least, ball.stretch[a]);
  return ball;
}

/* Returns true if particle j has a value of a field: all fluid, and wall particles on the surface
   of a boundary that gives this component of the velocity. */
static PetscBool ProbeHas(const Probe *probe, PetscInt j, PetscInt field)
{
  const Flow      *flow = probe->flow;
  const Particles *p    = flow->particles;

  if (!ParticlesIsWall(p, j)) return PETSC_TRUE;
  if (field == p->dim || !flow->ops->forms.wall->on_surface) return PETSC_FALSE;
  return BoundaryVelocityEquation(flow->scene, (PetscInt)p->side[j], field) == EQUATION_VALUE;
}

/* Finds the neighbours of a point that enter the fit of a field, their offsets over the radius and
   kernels, which are zero up to a multiple of 4. */
static PetscErrorCode ProbeFind(Probe *probe, const PetscReal x[], const ProbeBall *ball,
                                PetscInt field, PetscInt *n)
{
  const Operators *ops = probe->flow->ops;
  const Particles *p   = probe->flow->particles;
  PetscInt         found;

  PetscFunctionBegin;
  PetscCall(
      CellsFind(&probe->cells, x, ball->R / ball->least, probe->cells.n, probe->list, &found));
  *n = 0;
  for (PetscInt k = 0; k < found; k++) {
    const PetscInt j  = probe->list[k];
    PetscReal      r2 = 0.0;

    for (PetscInt a = 0; a < p->dim; a++) {
      probe->s[a][*n] = ball->stretch[a] * (p->x[a][j] - x[a]) / ball->R;
      r2 += PetscSqr(probe->s[a][*n]);
    }
    if (r2 >= 1.0 || !ProbeHas(probe, j, field)) continue;
    probe->w[0][*n]     = PetscSqrtReal(r2) * ops->forms.radius;
    probe->list[(*n)++] = j;
  }
  KernelEvaluateAll(ops->forms.kernel, p->dim, ops->forms.h, *n, probe->w[0], probe->W, probe->w[1],
                    probe->w[2]);
  for (PetscInt k = *n; k < LanesPadded(*n); k++) {
    probe->W[k] = 0.0;
    for (PetscInt a = 0; a < p->dim; a++) probe->s[a][k] = 0.0;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the weights of the next fit that a monitor of fixed particles asked for before; returns
   false if it is another, and forgets it and all after it. */
static PetscBool TakeKept(Probe *probe, const PetscReal key[], PetscInt wanted, PetscInt *n)
{
  KeptFits  *kept = &probe->flow->state->kept_fits;
  PetscReal *next = kept->number + kept->at;
  PetscBool  same = kept->at < kept->n;

  for (PetscInt q = 0; q < KEY && same; q++) same = next[q] == key[q];
  if (!same) {
    kept->n = PetscMin(kept->n, kept->at);
    return PETSC_FALSE;
  }
  *n = (PetscInt)next[KEY];
  next += KEY + 1;
  for (PetscInt k = 0; k < *n; k++) probe->list[k] = (PetscInt)next[k];
  for (PetscInt t = 0; t < wanted; t++)
    for (PetscInt k = 0; k < *n; k++) probe->w[t][k] = next[(1 + t) * *n + k];
  kept->at += KEY + 1 + (1 + wanted) * *n;
  return PETSC_TRUE;
}

/* Keeps the weights of a fit behind those before it, as long as there is room. */
static PetscErrorCode Keep(const Probe *probe, const PetscReal key[], PetscInt wanted, PetscInt n)
{
  KeptFits      *kept = &probe->flow->state->kept_fits;
  const PetscInt size = KEY + 1 + (1 + wanted) * n;
  PetscReal     *next;

  PetscFunctionBegin;
  if (kept->at != kept->n || kept->n + size > KEPT_MOST) PetscFunctionReturn(PETSC_SUCCESS);
  if (kept->n + size > kept->capacity) {
    kept->capacity = 2 * (kept->n + size);
    PetscCall(PetscRealloc(kept->capacity * sizeof(PetscReal), &kept->number));
  }
  next = kept->number + kept->n;
  PetscCall(PetscArraycpy(next, key, KEY));
  next[KEY] = (PetscReal)n;
  next += KEY + 1;
  for (PetscInt k = 0; k < n; k++) next[k] = (PetscReal)probe->list[k];
  for (PetscInt t = 0; t < wanted; t++)
    PetscCall(PetscArraycpy(next + (1 + t) * n, probe->w[t], n));
  kept->at = kept->n += size;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the weights of the value of a field at x and, if `wanted` is 1 + dim, of its
   derivatives. The support grows, up to the reach of the halo, while it holds too few particles,
   for example in a corner; then a cubic fit becomes a quadratic one. */
static PetscErrorCode ProbeWeights(Probe *probe, const PetscReal x[], PetscInt field,
                                   PetscInt wanted, PetscInt *n)
{
  const PetscInt  dim = probe->flow->particles->dim, quadratic = (dim + 1) * (dim + 2) / 2;
  PetscInt        degree   = probe->degree;
  ProbeBall       ball     = ProbeSupport(probe, x);
  PetscReal       key[KEY] = {(PetscReal)field, (PetscReal)wanted, (PetscReal)degree,
                              (PetscReal)probe->flow->particles->epoch};
  const PetscBool keeps    = probe->flow->state->kept_fits.on;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < dim; a++) key[KEY - ISPH_MAX_DIM + a] = x[a];
  if (keeps && TakeKept(probe, key, wanted, n)) PetscFunctionReturn(PETSC_SUCCESS);
  while (PETSC_TRUE) {
    const PetscInt  terms = degree < 3 ? quadratic : quadratic * (dim + 3) / 3;
    const PetscBool ends  = ball.R >= probe->reach * ball.least;
    const PetscBool last  = ends && degree == 2;

    PetscCall(ProbeFind(probe, x, &ball, field, n));
    if ((last || *n >= 2 * terms) &&
        PointFit(dim, degree, LanesPadded(*n), probe->s, probe->W, wanted, last, probe->w))
      break;
    if (ends) {
      degree = 2;
      ball   = ProbeSupport(probe, x);
    } else ball.R = PetscMin(1.15 * ball.R, probe->reach * ball.least);
  }
  for (PetscInt t = 1; t < wanted; t++)
    for (PetscInt k = 0; k < *n; k++) probe->w[t][k] *= ball.stretch[t - 1] / ball.R;
  if (keeps) PetscCall(Keep(probe, key, wanted, *n));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Builds cells and fills the halo of velocity and pressure, which only probes read. Collective. */
static PetscErrorCode ProbeBegin(const Flow *flow, PetscBool pressure, Probe *probe)
{
  const Particles *p = flow->particles;
  PetscInt         room;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(probe, sizeof(*probe)));
  probe->flow   = flow;
  probe->degree = 2;
  /* Within an epoch a particle moves by less than half a skin. */
  probe->reach = PetscMax(flow->ops->forms.radius, p->halo_width + 0.5 * p->skin);
  PetscCall(CellsBuild(p, 0.5 * flow->ops->forms.radius, &probe->cells));
  room = LanesPadded(probe->cells.n);
  PetscCall(PetscMalloc2(probe->cells.n, &probe->list, 2 * (1 + ISPH_MAX_DIM) * room, &probe->W));
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) probe->s[a] = probe->W + (1 + a) * room;
  for (PetscInt t = 0; t <= ISPH_MAX_DIM; t++)
    probe->w[t] = probe->W + (1 + ISPH_MAX_DIM + t) * room;
  for (PetscInt c = 0; c < p->dim; c++) probe->field[probe->n_fields++] = p->u[c];
  if (pressure) probe->field[probe->n_fields++] = p->p;
  for (PetscInt f = 0; f < probe->n_fields; f++) PetscCall(ParticlesHaloField(p, probe->field[f]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ProbeEnd(Probe *probe)
{
  PetscFunctionBegin;
  PetscCall(PetscFree2(probe->list, probe->W));
  PetscCall(CellsFree(&probe->cells));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets place to x, wrapped into a periodic box; returns true on the rank that owns the point. */
static PetscBool ProbeOwns(const Flow *flow, const PetscReal x[], PetscReal place[])
{
  const Scene     *scene = flow->scene;
  const Particles *p     = flow->particles;
  PetscBool        owns  = PETSC_TRUE;

  for (PetscInt a = 0; a < p->dim; a++) {
    const PetscReal lo = scene->lo[a], period = scene->hi[a] - lo;

    place[a] = x[a];
    if (SceneIsPeriodic(scene, a) && !(place[a] >= lo && place[a] < scene->hi[a])) {
      place[a] -= period * PetscFloorReal((place[a] - lo) / period);
      if (!(place[a] >= lo && place[a] < scene->hi[a]))
        place[a] = lo; /* rounding at the upper end */
    }
    if (!(place[a] >= p->lo[a] && place[a] < p->hi[a])) owns = PETSC_FALSE;
  }
  return owns;
}

/* Finds the fluid particle nearest to x within a reach; j: -1 without one. */
static PetscErrorCode NearestFluid(Probe *probe, const PetscReal x[], PetscReal reach, PetscInt *j)
{
  const Particles *p    = probe->flow->particles;
  PetscReal        best = PetscSqr(reach);
  PetscInt         n;

  PetscFunctionBegin;
  *j = -1;
  PetscCall(CellsFind(&probe->cells, x, reach, probe->cells.n, probe->list, &n));
  for (PetscInt k = 0; k < n; k++) {
    const PetscInt i  = probe->list[k];
    PetscReal      r2 = 0.0;

    if (ParticlesIsWall(p, i)) continue;
    for (PetscInt a = 0; a < p->dim; a++) r2 += PetscSqr(p->x[a][i] - x[a]);
    if (r2 >= best) continue;
    best = r2;
    *j   = i;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns true if x is outside the free surface: the fluid around has less than half of the
   concentration inside. */
static PetscErrorCode ProbeIsDry(Probe *probe, const PetscReal x[], PetscBool *dry)
{
  const Scene *scene = probe->flow->scene;
  PetscReal    C;
  PetscInt     n;

  PetscFunctionBegin;
  *dry = PETSC_FALSE;
  if (!SceneHasFreeSurface(scene)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(
      StrainParts(scene, probe->flow->particles, &probe->cells, x, probe->list, &n, probe->W, &C));
  *dry = C < DRY ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Evaluates all fields at a point; they are NaN outside a free surface. Fields share weights if the
   same particles have their values; wall particles have no pressure. */
static PetscErrorCode ProbeEvaluate(Probe *probe, const PetscReal x[], PetscReal values[])
{
  const WallRow  *wall  = probe->flow->ops->forms.wall;
  const PetscBool walls = wall && wall->on_surface;
  const PetscBool slip  = SceneSlipKind(probe->flow->scene) ? PETSC_TRUE : PETSC_FALSE;
  PetscInt        n     = 0;
  PetscBool       dry;

  PetscFunctionBegin;
  PetscCall(ProbeIsDry(probe, x, &dry));
  for (PetscInt f = 0; f < probe->n_fields; f++) values[f] = NAN;
  for (PetscInt f = 0; !dry && f < probe->n_fields; f++) {
    const PetscBool pressure = f == probe->flow->particles->dim;

    if (f == 0 || slip || (pressure && walls)) PetscCall(ProbeWeights(probe, x, f, 1, &n));
    values[f] = 0.0;
    for (PetscInt k = 0; k < n; k++) values[f] += probe->w[0][k] * probe->field[f][probe->list[k]];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ProbePoints - Interpolates velocity and pressure at points. Collective. A scheme that has the
   pressure at all points gives its own in place of a fit. Input: flow - flow with up-to-date
   positions in the halo; n - number of points; x - the points, dim coordinates each, the same on
   all ranks; walls and periodic images are allowed [m]. Output: u - velocities, dim components
   each, on all ranks; NaN at points outside a free surface [m/s]; p - pressures, NaN there and if
   the run has none; may be NULL [Pa]. */
PetscErrorCode ProbePoints(const Flow *flow, PetscInt n, const PetscReal x[], PetscReal u[],
                           PetscReal p[])
{
  const PetscInt  dim      = flow->particles->dim;
  const PetscBool pressure = p && flow->particles->p;
  const PetscBool own      = pressure && flow->scheme->Pressure;
  const PetscInt  width    = dim + (pressure ? 1 : 0);
  Probe           probe;
  PetscReal      *values;

  PetscFunctionBegin;
  PetscCall(ProbeBegin(flow, pressure && !own, &probe));
  PetscCall(PetscCalloc1(n * width, &values));
  for (PetscInt k = 0; k < n; k++) {
    PetscReal place[ISPH_MAX_DIM];

    if (ProbeOwns(flow, &x[k * dim], place))
      PetscCall(ProbeEvaluate(&probe, place, &values[k * width]));
    if (own) PetscCall(flow->scheme->Pressure(flow, place, &values[k * width + dim]));
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, values, (PetscMPIInt)(n * width), MPIU_REAL, MPIU_SUM,
                             flow->particles->comm));
  for (PetscInt k = 0; k < n; k++) {
    for (PetscInt c = 0; c < dim; c++) u[k * dim + c] = values[k * width + c];
    if (p) p[k] = pressure ? values[k * width + dim] : NAN;
  }
  PetscCall(PetscFree(values));
  PetscCall(ProbeEnd(&probe));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes velocity, its gradient, acceleration and pressure at a point: u, d u_c/dx_a at
   [dim + c dim + a], the acceleration, then the pressure. Wall particles have none of the last two,
   which need a fit of their own beside them. */
static PetscErrorCode ProbeEvaluateMotion(Probe *probe, const PetscReal x[],
                                          PetscReal *const rate[], PetscReal values[])
{
  const Particles *p     = probe->flow->particles;
  const PetscInt   dim   = p->dim;
  const PetscBool  slip  = SceneSlipKind(probe->flow->scene) ? PETSC_TRUE : PETSC_FALSE;
  PetscBool        walls = PETSC_FALSE;
  PetscReal       *last  = &values[dim + dim * dim];
  PetscInt         n     = 0;

  PetscFunctionBegin;
  for (PetscInt c = 0; c < dim; c++) {
    if (c == 0 || slip) PetscCall(ProbeWeights(probe, x, c, 1 + dim, &n));
    for (PetscInt t = 0; t <= dim; t++) {
      PetscReal *value = &values[t == 0 ? c : dim + c * dim + t - 1];

      for (PetscInt k = 0; k < n; k++) *value += probe->w[t][k] * p->u[c][probe->list[k]];
    }
  }
  for (PetscInt k = 0; k < n && !walls; k++) walls = ParticlesIsWall(p, probe->list[k]);
  if (walls) PetscCall(ProbeWeights(probe, x, dim, 1, &n));
  for (PetscInt k = 0; k < n; k++) {
    for (PetscInt c = 0; c < dim; c++) last[c] += probe->w[0][k] * rate[c][probe->list[k]];
    if (probe->n_fields > dim) last[dim] += probe->w[0][k] * p->p[probe->list[k]];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the rates Du/Dt of local particles, with the change by the velocity filter, which is part
   of the change of the momentum [m/s^2]. */
static PetscErrorCode CreateRates(const Flow *flow, PetscReal *rate[])
{
  const Particles  *p        = flow->particles;
  PetscReal *const *filtered = flow->state->acceleration.filtered;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < p->dim; a++) PetscCall(PetscCalloc1(ParticlesAll(p), &rate[a]));
  PetscCall(AccelerationGet(flow, rate));
  for (PetscInt a = 0; a < p->dim; a++) {
    for (PetscInt i = 0; filtered[a] && i < p->n_fluid; i++) rate[a][i] += filtered[a][i];
    PetscCall(ParticlesHaloField(p, rate[a]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ProbeMotion - Computes velocity gradient, rate Du/Dt and pressure at points by cubic fits;
   collective. Input: as ProbePoints(), in a flow without a free surface. Output, on all ranks:
   gradient - d u_c/dx_a at [(k dim + c) dim + a] [1/s]; rate - dim components each [m/s^2];
   pressure - NaN if the run has none [Pa]. */
PetscErrorCode ProbeMotion(const Flow *flow, PetscInt n, const PetscReal x[], PetscReal gradient[],
                           PetscReal rate[], PetscReal pressure[])
{
  const Particles *p   = flow->particles;
  const PetscInt   dim = p->dim, last = dim + dim * dim, width = last + dim + 1;
  const PetscBool  own = flow->scheme->Pressure ? PETSC_TRUE : PETSC_FALSE;
  Probe            probe;
  PetscReal       *values, *du[ISPH_MAX_DIM];

  PetscFunctionBegin;
  PetscCall(ProbeBegin(flow, p->p && !own, &probe));
  probe.degree = 3;
  PetscCall(PetscCalloc1(n * width, &values));
  PetscCall(CreateRates(flow, du));
  for (PetscInt k = 0; k < n; k++) {
    PetscReal place[ISPH_MAX_DIM];

    if (ProbeOwns(flow, &x[k * dim], place))
      PetscCall(ProbeEvaluateMotion(&probe, place, du, &values[k * width]));
    if (own) PetscCall(flow->scheme->Pressure(flow, place, &values[k * width + last + dim]));
  }
  PetscCallMPI(
      MPI_Allreduce(MPI_IN_PLACE, values, (PetscMPIInt)(n * width), MPIU_REAL, MPIU_SUM, p->comm));
  for (PetscInt k = 0; k < n; k++) {
    const PetscReal *value = &values[k * width];
    PetscReal        N[ISPH_MAX_DIM];

    PetscCall(PetscArraycpy(&gradient[k * dim * dim], &value[dim], dim * dim));
    FlowConvective(flow, &x[k * dim], value, &value[dim], N);
    for (PetscInt a = 0; a < dim; a++) rate[k * dim + a] = value[last + a] + N[a];
    pressure[k] = p->p ? value[last + dim] : NAN;
  }
  for (PetscInt a = 0; a < dim; a++) PetscCall(PetscFree(du[a]));
  PetscCall(PetscFree(values));
  PetscCall(ProbeEnd(&probe));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ProbeDry - Finds out which points are outside a free surface; collective. Input: as
   ProbePoints(). Output: dry - on all ranks. */
PetscErrorCode ProbeDry(const Flow *flow, PetscInt n, const PetscReal x[], PetscBool dry[])
{
  const PetscInt dim = flow->particles->dim;
  Probe          probe;

  PetscFunctionBegin;
  PetscCall(ProbeBegin(flow, PETSC_FALSE, &probe));
  for (PetscInt k = 0; k < n; k++) {
    PetscReal place[ISPH_MAX_DIM];

    dry[k] = PETSC_FALSE;
    if (ProbeOwns(flow, &x[k * dim], place)) PetscCall(ProbeIsDry(&probe, place, &dry[k]));
  }
  PetscCallMPI(
      MPI_Allreduce(MPI_IN_PLACE, dry, (PetscMPIInt)n, MPIU_BOOL, MPI_LOR, flow->particles->comm));
  PetscCall(ProbeEnd(&probe));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ProbeInBody - Returns true if a point lies in a body; not collective */
PetscBool ProbeInBody(const Scene *scene, const PetscReal x[])
{
  PetscInt side;

  return SceneFluidDistance(scene, x, &side) < -SCENE_ON_SURFACE * SceneTolerance(scene);
}

/* Returns a property of particle j. */
typedef PetscReal (*PropertyFn)(const Flow *flow, PetscInt j);

static PetscReal ViscosityOf(const Flow *flow, PetscInt j)
{
  return flow->particles->nu[j];
}

static PetscReal DensityOf(const Flow *flow, PetscInt j)
{
  return ParticlesDensity(flow->scene, flow->particles, j);
}

/* Computes a property of the fluid particle nearest to each point, 0 if there is none. */
static PetscErrorCode ProbeNearest(const Flow *flow, PetscInt n, const PetscReal x[], PropertyFn Of,
                                   PetscReal value[])
{
  const Particles *p = flow->particles;
  Probe            probe;

  PetscFunctionBegin;
  PetscCall(ProbeBegin(flow, PETSC_FALSE, &probe));
  for (PetscInt k = 0; k < n; k++) {
    PetscReal place[ISPH_MAX_DIM];
    ProbeBall ball;
    PetscInt  j;

    value[k] = 0.0;
    if (!ProbeOwns(flow, &x[k * p->dim], place)) continue;
    ball = ProbeSupport(&probe, place);
    PetscCall(NearestFluid(&probe, place, ball.R / ball.least, &j));
    if (j >= 0) value[k] = Of(flow, j);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, value, (PetscMPIInt)n, MPIU_REAL, MPIU_SUM, p->comm));
  PetscCall(ProbeEnd(&probe));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ProbeViscosity - Returns the kinematic viscosity of the fluid particle nearest to each point;
   collective. An interpolation would mix the viscosities of two fluids. Input: as ProbePoints().
   Output: nu - on all ranks [m^2/s]. */
PetscErrorCode ProbeViscosity(const Flow *flow, PetscInt n, const PetscReal x[], PetscReal nu[])
{
  PetscFunctionBegin;
  PetscCall(ProbeNearest(flow, n, x, ViscosityOf, nu));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ProbeDensity - Returns the density at each point, as ProbeViscosity() [kg/m^3]; collective */
PetscErrorCode ProbeDensity(const Flow *flow, PetscInt n, const PetscReal x[], PetscReal rho[])
{
  PetscFunctionBegin;
  for (PetscInt k = 0; k < n; k++) rho[k] = flow->scene->rho;
  if (SceneMixes(flow->scene)) PetscCall(ProbeNearest(flow, n, x, DensityOf, rho));
  PetscFunctionReturn(PETSC_SUCCESS);
}
