/*
  Values at points: a quadratic moving-least-squares fit about each point,

    f(x + X) = c_0 + sum_t c_t phi_t(X/R),   min sum_k W_k (f_k - fit(X_k))^2,   value = c_0,

  with the offsets X_k of the neighbours k, the radius R of the support and the kernel W. The rank
  that owns the point computes the fit. It is exact for quadratic fields, on walls and in corners
  too. Points outside a free surface have no values.

  Reference: P. Lancaster & K. Salkauskas, Math. Comput. 37 (1981) 141-158
*/
#include "monitors.h"

#define PROBE_MAX_TERMS 20  /* of a cubic fit in 3D */
#define WET             1.3 /* distance of the nearest particle from which on a point is dry [dx] */
#define ON_SURFACE      0.01 /* height above a free surface up to which a point is on it [dx] */

/* Data shared by the fits of all points. */
typedef struct {
  const Flow *flow;
  Cells       cells;
  PetscReal  *field[ISPH_MAX_DIM + 1]; /* particle fields u, then p, with halo [m/s], [Pa] */
  PetscInt    n_fields;
  PetscInt    degree; /* of the fits, 2 or 3 */
  PetscReal   reach;  /* distance from own points within which this rank has all particles [m] */
  PetscInt   *list;   /* neighbours of the present point */
  PetscReal  *w;      /* their weights in the value, then in its derivatives [-], [1/m] */
} Probe;

/* Computes the basis 1, X_a/R, X_a X_b/R^2, of degree 3 also X_a X_b X_c/R^3; returns the number of
   terms. */
static PetscInt ProbeBasis(PetscInt dim, PetscInt degree, const PetscReal s[], PetscReal phi[])
{
  PetscInt t = 0;

  phi[t++] = 1.0;
  for (PetscInt a = 0; a < dim; a++) phi[t++] = s[a];
  for (PetscInt a = 0; a < dim; a++) {
    for (PetscInt b = 0; b <= a; b++) phi[t++] = s[a] * s[b];
  }
  for (PetscInt a = 0; degree > 2 && a < dim; a++) {
    for (PetscInt b = 0; b <= a; b++)
      for (PetscInt c = 0; c <= b; c++) phi[t++] = s[a] * s[b] * s[c];
  }
  return t;
}

/* The support about a point: its radius along stretched axes, see SceneStretch(). */
typedef struct {
  PetscReal R, stretch[ISPH_MAX_DIM], least; /* [m], [-], the least of them */
} ProbeBall;

/* Computes the offset (x_j - x)/R of particle j; returns the kernel stretched to the radius R. */
static PetscReal ProbeOffset(const Probe *probe, PetscInt j, const PetscReal x[],
                             const ProbeBall *ball, PetscReal s[])
{
  const Operators *ops = probe->flow->ops;
  const Particles *p   = probe->flow->particles;
  PetscReal        r2  = 0.0, w[3];

  for (PetscInt a = 0; a < p->dim; a++) {
    s[a] = ball->stretch[a] * (p->x[a][j] - x[a]) / ball->R;
    r2 += PetscSqr(s[a]);
  }
  KernelEvaluate(ops->forms.kernel, p->dim, ops->forms.h, PetscSqrtReal(r2) * ops->forms.radius, w);
  return w[0];
}

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
  return BoundaryVelocityEquation(flow->scene, (PetscInt)p->side[j], field) == EQUATION_VALUE
             ? PETSC_TRUE
             : PETSC_FALSE;
}

/* Finds the neighbours of a point that enter the fit of a field. */
static PetscErrorCode ProbeFind(Probe *probe, const PetscReal x[], const ProbeBall *ball,
                                PetscInt field, PetscInt *n)
{
  PetscInt found;

  PetscFunctionBegin;
  PetscCall(
      CellsFind(&probe->cells, x, ball->R / ball->least, probe->cells.n, probe->list, &found));
  *n = 0;
  for (PetscInt k = 0; k < found; k++) {
    const PetscInt j = probe->list[k];
    PetscReal      s[ISPH_MAX_DIM];

    if (ball->least != 1.0 && ProbeOffset(probe, j, x, ball, s) == 0.0) continue;
    if (ProbeHas(probe, j, field)) probe->list[(*n)++] = j;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the moment matrix sum_k W_k phi_k phi_k^T over n neighbours k, with the kernel W_k and
   the basis phi_k of ProbeBasis(); returns its size. */
static PetscInt ProbeMoments(const Probe *probe, const PetscReal x[], const ProbeBall *ball,
                             PetscInt n, PetscReal moments[])
{
  const PetscInt dim = probe->flow->particles->dim, quadratic = 1 + dim + dim * (dim + 1) / 2;
  const PetscInt terms = probe->degree < 3 ? quadratic : quadratic * (dim + 3) / 3;

  for (PetscInt t = 0; t < terms * terms; t++) moments[t] = 0.0;
  for (PetscInt k = 0; k < n; k++) {
    PetscReal       s[ISPH_MAX_DIM], phi[PROBE_MAX_TERMS];
    const PetscReal W = ProbeOffset(probe, probe->list[k], x, ball, s);

    (void)ProbeBasis(dim, probe->degree, s, phi);
    for (PetscInt t = 0; t < terms; t++) {
      for (PetscInt q = 0; q < terms; q++) moments[t * terms + q] += W * phi[t] * phi[q];
    }
  }
  return terms;
}

/*
  Computes and factors the moment matrix of the fit at x. The support grows, up to the reach of the
  halo, while it holds too few particles, for example in a corner; then a cubic fit becomes a
  quadratic one.
*/
static PetscErrorCode ProbeFit(Probe *probe, const PetscReal x[], PetscInt field, PetscInt *n,
                               ProbeBall *ball, PetscInt *terms, PetscReal moments[],
                               PetscReal factor[])
{
  PetscFunctionBegin;
  *ball = ProbeSupport(probe, x);
  while (PETSC_TRUE) {
    PetscCall(ProbeFind(probe, x, ball, field, n));
    *terms = ProbeMoments(probe, x, ball, *n, moments);
    PetscCall(PetscArraycpy(factor, moments, *terms * *terms));
    if (*n >= 2 * *terms && !DenseCholesky(*terms, factor)) break;
    if (ball->R >= probe->reach * ball->least && probe->degree > 2) {
      probe->degree = 2;
      *ball         = ProbeSupport(probe, x);
      continue;
    }
    if (ball->R >= probe->reach * ball->least) {
      DenseCholeskyRidge(*terms, moments, 1e-10, factor);
      break;
    }
    ball->R = PetscMin(1.15 * ball->R, probe->reach * ball->least);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Solves M c = e_t for a moment matrix M and its factor. Refines c: M may be ill conditioned. */
static void ProbeColumn(PetscInt terms, PetscInt t, const PetscReal moments[],
                        const PetscReal factor[], PetscReal c[])
{
  for (PetscInt q = 0; q < terms; q++) c[q] = 0.0;
  for (PetscInt pass = 0; pass < 3; pass++) {
    PetscReal residual[PROBE_MAX_TERMS] = {0.0};

    residual[t] = 1.0;
    for (PetscInt r = 0; r < terms; r++) {
      for (PetscInt q = 0; q < terms; q++) residual[r] -= moments[r * terms + q] * c[q];
    }
    DenseCholeskySolve(terms, factor, residual);
    for (PetscInt q = 0; q < terms; q++) c[q] += residual[q];
  }
}

/* Computes the weights w_k = W_k phi_k . M^-1 e_t of the coefficient t of the fit at x, from 0 to
   wanted - 1, with the kernel W_k, the basis phi_k and the moment matrix M: of f(x) and of its
   derivatives. */
static PetscErrorCode ProbeWeights(Probe *probe, const PetscReal x[], PetscInt field,
                                   PetscInt wanted, PetscInt *n)
{
  const PetscInt dim = probe->flow->particles->dim, degree = probe->degree;
  PetscReal      moments[PROBE_MAX_TERMS * PROBE_MAX_TERMS];
  PetscReal      factor[PROBE_MAX_TERMS * PROBE_MAX_TERMS];
  PetscReal      c[1 + ISPH_MAX_DIM][PROBE_MAX_TERMS];
  ProbeBall      ball;
  PetscInt       terms = 0;

  PetscFunctionBegin;
  PetscCall(ProbeFit(probe, x, field, n, &ball, &terms, moments, factor));
  for (PetscInt t = 0; t < wanted; t++) ProbeColumn(terms, t, moments, factor, c[t]);
  for (PetscInt k = 0; k < *n; k++) {
    PetscReal       s[ISPH_MAX_DIM], phi[PROBE_MAX_TERMS];
    const PetscReal W = ProbeOffset(probe, probe->list[k], x, &ball, s);

    (void)ProbeBasis(dim, probe->degree, s, phi);
    for (PetscInt t = 0; t < wanted; t++) {
      const PetscReal per_length = t > 0 ? ball.stretch[t - 1] / ball.R : 1.0;
      PetscReal       sum        = 0.0;

      for (PetscInt q = 0; q < terms; q++) sum += phi[q] * c[t][q];
      probe->w[t * probe->cells.n + k] = W * sum * per_length;
    }
  }
  probe->degree = degree;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Builds cells and fills the halo of velocity and pressure, which only probes read. Collective. */
static PetscErrorCode ProbeBegin(const Flow *flow, PetscBool pressure, Probe *probe)
{
  const Particles *p = flow->particles;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(probe, sizeof(*probe)));
  probe->flow   = flow;
  probe->degree = 2;
  /* Within an epoch a particle moves by less than half a skin. */
  probe->reach = PetscMax(flow->ops->forms.radius, p->halo_width + 0.5 * p->skin);
  PetscCall(CellsBuild(p, 0.5 * flow->ops->forms.radius, &probe->cells));
  PetscCall(PetscMalloc2(probe->cells.n, &probe->list, probe->cells.n * (1 + p->dim), &probe->w));
  for (PetscInt c = 0; c < p->dim; c++) probe->field[probe->n_fields++] = p->u[c];
  if (pressure) probe->field[probe->n_fields++] = p->p;
  for (PetscInt f = 0; f < probe->n_fields; f++) PetscCall(ParticlesHaloField(p, probe->field[f]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ProbeEnd(Probe *probe)
{
  PetscFunctionBegin;
  PetscCall(PetscFree2(probe->list, probe->w));
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

/* Returns true if x is outside the free surface: no particle is near, or the nearest one is on the
   surface and x is beyond its tangent plane. Particles of the surface lie on it. */
static PetscErrorCode ProbeIsDry(Probe *probe, const PetscReal x[], PetscBool *dry)
{
  const FreeSurface *free  = probe->flow->ops->free;
  const Particles   *p     = probe->flow->particles;
  const PetscReal    dx    = SceneSpacing(probe->flow->scene, x);
  PetscReal          above = 0.0;
  PetscInt           j;

  PetscFunctionBegin;
  *dry = PETSC_FALSE;
  if (!free) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(NearestFluid(probe, x, WET * dx, &j));
  *dry = j < 0 || free->kind[j] == SURFACE_ISOLATED ? PETSC_TRUE : PETSC_FALSE;
  if (*dry || free->kind[j] == SURFACE_INSIDE) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt a = 0; a < p->dim; a++) above += free->normal[j * p->dim + a] * (x[a] - p->x[a][j]);
  *dry = above > ON_SURFACE * dx ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Evaluates all fields at a point; they are NaN outside a free surface. Fields share weights if the
   same particles have their values; wall particles have no pressure. */
static PetscErrorCode ProbeEvaluate(Probe *probe, const PetscReal x[], PetscReal values[])
{
  const WallRow  *wall  = probe->flow->ops->forms.wall;
  const PetscBool walls = wall && wall->on_surface ? PETSC_TRUE : PETSC_FALSE;
  const PetscBool slip  = SceneSlipKind(probe->flow->scene) ? PETSC_TRUE : PETSC_FALSE;
  PetscInt        n     = 0;
  PetscBool       dry;

  PetscFunctionBegin;
  PetscCall(ProbeIsDry(probe, x, &dry));
  for (PetscInt f = 0; f < probe->n_fields; f++) values[f] = NAN;
  for (PetscInt f = 0; !dry && f < probe->n_fields; f++) {
    const PetscBool pressure = f == probe->flow->particles->dim ? PETSC_TRUE : PETSC_FALSE;

    if (f == 0 || slip || (pressure && walls)) PetscCall(ProbeWeights(probe, x, f, 1, &n));
    values[f] = 0.0;
    for (PetscInt k = 0; k < n; k++) values[f] += probe->w[k] * probe->field[f][probe->list[k]];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  ProbePoints - Interpolates velocity and pressure at points

  Collective. A scheme that has the pressure at all points gives its own in place of a fit.

  Input Parameters:
+ flow - flow with up-to-date positions in the halo
. n    - number of points
- x    - the points, dim coordinates each, the same on all ranks; walls and periodic images are
         allowed [m]

  Output Parameters:
+ u - velocities, dim components each, on all ranks; NaN at points outside a free surface [m/s]
- p - pressures, NaN there and if the run has none; may be NULL [Pa]
*/
PetscErrorCode ProbePoints(const Flow *flow, PetscInt n, const PetscReal x[], PetscReal u[],
                           PetscReal p[])
{
  const PetscInt  dim      = flow->particles->dim;
  const PetscBool pressure = p && flow->particles->p ? PETSC_TRUE : PETSC_FALSE;
  const PetscBool own      = pressure && flow->scheme->Pressure ? PETSC_TRUE : PETSC_FALSE;
  const PetscInt  width    = dim + (pressure ? 1 : 0);
  Probe           probe;
  PetscReal      *values;

  PetscFunctionBegin;
  PetscCall(ProbeBegin(flow, pressure && !own ? PETSC_TRUE : PETSC_FALSE, &probe));
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

      for (PetscInt k = 0; k < n; k++)
        *value += probe->w[t * probe->cells.n + k] * p->u[c][probe->list[k]];
    }
  }
  for (PetscInt k = 0; k < n && !walls; k++) walls = ParticlesIsWall(p, probe->list[k]);
  if (walls) PetscCall(ProbeWeights(probe, x, dim, 1, &n));
  for (PetscInt k = 0; k < n; k++) {
    for (PetscInt c = 0; c < dim; c++) last[c] += probe->w[k] * rate[c][probe->list[k]];
    if (probe->n_fields > dim) last[dim] += probe->w[k] * p->p[probe->list[k]];
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

/*
  ProbeMotion - Computes velocity gradient, rate Du/Dt and pressure at points by cubic fits

  Collective. Input: as ProbePoints(), in a flow without a free surface. Output, on all ranks:
  gradient - d u_c/dx_a at [(k dim + c) dim + a] [1/s]; rate - dim components each [m/s^2]; pressure
  - NaN if the run has none [Pa].
*/
PetscErrorCode ProbeMotion(const Flow *flow, PetscInt n, const PetscReal x[], PetscReal gradient[],
                           PetscReal rate[], PetscReal pressure[])
{
  const Particles *p   = flow->particles;
  const PetscInt   dim = p->dim, last = dim + dim * dim, width = last + dim + 1;
  const PetscBool  own = flow->scheme->Pressure ? PETSC_TRUE : PETSC_FALSE;
  Probe            probe;
  PetscReal       *values, *du[ISPH_MAX_DIM];

  PetscFunctionBegin;
  PetscCall(ProbeBegin(flow, p->p && !own ? PETSC_TRUE : PETSC_FALSE, &probe));
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

    PetscCall(PetscArraycpy(&gradient[k * dim * dim], &value[dim], dim * dim));
    for (PetscInt a = 0; a < dim; a++) {
      rate[k * dim + a] = value[last + a];
      for (PetscInt b = 0; flow->state->has_convection && b < dim; b++)
        rate[k * dim + a] += value[b] * value[dim + a * dim + b];
    }
    pressure[k] = p->p ? value[last + dim] : NAN;
  }
  for (PetscInt a = 0; a < dim; a++) PetscCall(PetscFree(du[a]));
  PetscCall(PetscFree(values));
  PetscCall(ProbeEnd(&probe));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  ProbeDry - Finds out which points are outside a free surface

  Collective. Input: as ProbePoints(). Output: dry - on all ranks.
*/
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

  return SceneFluidDistance(scene, x, &side) < -SCENE_ON_SURFACE * SceneTolerance(scene)
             ? PETSC_TRUE
             : PETSC_FALSE;
}

/* Finds the viscosity of the fluid particle nearest to x. */
static PetscErrorCode NearestViscosity(Probe *probe, const PetscReal x[], PetscReal *nu)
{
  const ProbeBall ball = ProbeSupport(probe, x);
  PetscInt        j;

  PetscFunctionBegin;
  PetscCall(NearestFluid(probe, x, ball.R / ball.least, &j));
  *nu = j < 0 ? 0.0 : probe->flow->particles->nu[j];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  ProbeViscosity - Returns the kinematic viscosity of the fluid particle nearest to each point

  Collective. An interpolation would mix the viscosities of two fluids. Input: as ProbePoints().
  Output: nu - on all ranks [m^2/s].
*/
PetscErrorCode ProbeViscosity(const Flow *flow, PetscInt n, const PetscReal x[], PetscReal nu[])
{
  const Particles *p = flow->particles;
  Probe            probe;

  PetscFunctionBegin;
  PetscCall(ProbeBegin(flow, PETSC_FALSE, &probe));
  for (PetscInt k = 0; k < n; k++) {
    PetscReal place[ISPH_MAX_DIM];

    nu[k] = 0.0;
    if (ProbeOwns(flow, &x[k * p->dim], place)) PetscCall(NearestViscosity(&probe, place, &nu[k]));
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, nu, (PetscMPIInt)n, MPIU_REAL, MPIU_SUM, p->comm));
  PetscCall(ProbeEnd(&probe));
  PetscFunctionReturn(PETSC_SUCCESS);
}
