/*
  Forces and torques of the fluid on boundaries, by tractions, see tractions.c, and by the momentum
  of the fluid beside them. With a weight w that is 1 on boundary b and falls to 0 at the distance D
  from it, and the stress S = -p I + 2 mu E,

    F = - int [w rho (Du/Dt - f) + S grad w] dV - sum over other boundaries of w S n dA,

  n into the fluid, and the torque is the same with (x - c) x. This is the reaction of the wall's
  rows in a weak form: grad w is zero beside the wall, so that neither derivatives on the wall nor
  volumes of particles beside it matter, and the noise of many points averages out. A linear
  pressure, whose gradient is the body force, is taken out first; its force follows from the shape
  of the surface alone. See docs/theory.md, (390).

  Reference: V. John & G. Matthies, Int. J. Numer. Meth. Fluids 37 (2001) 885-903
*/
#include "isph/forces.h"

#define FLAT    1.0 /* distance up to which w is 1 [spacings at the boundary] */
#define REACH   5.0 /* distance from which w is 0 */
#define FINE    4   /* pieces along each edge of a facet, for a linear pressure */
#define SAMPLES 8   /* along each edge of a cell that a body cuts */

/* A pressure p0 + slope.(x - x0), whose gradient a body force balances. */
typedef struct {
  PetscReal p0, x0[ISPH_MAX_DIM], slope[ISPH_MAX_DIM]; /* [Pa], [m], [Pa/m] */
} LinearPressure;

/* The fluid beside a boundary: points of quadrature where w is not zero. */
typedef struct {
  const Scene *scene;
  PetscInt     side, n, capacity;
  PetscReal    unit;                  /* spacing at the boundary, largest along its normal [m] */
  PetscReal   *x, *volume, *gradient; /* [m], [m^dim], of w [1/m] */
} Layer;

/* Returns the distance of x from a boundary [m]. */
static PetscReal DistanceFrom(const Scene *scene, PetscInt side, const PetscReal x[])
{
  const Body *body = BoundaryBody(scene, side);
  PetscReal   normal[ISPH_MAX_DIM];

  return body ? BodyDistance(scene, body, x, normal) : SceneSideDistance(scene, side, x);
}

/* Returns w at x. */
static PetscReal Weight(const Layer *l, const PetscReal x[])
{
  const PetscReal q = DistanceFrom(l->scene, l->side, x) / l->unit;
  const PetscReal s = PetscMin(PetscMax((q - FLAT) / (REACH - FLAT), 0.0), 1.0);

  return 1.0 - s * s * s * (10.0 - s * (15.0 - 6.0 * s));
}

/* Computes the mean of grad w over a cell from w at the middles of its faces [1/m]: sums over cells
   are those of w over the border, so that a constant stress has an exact force. */
static void WeightGradient(const Layer *l, const PetscReal x[], const PetscReal edge[],
                           PetscReal gradient[])
{
  const PetscInt dim = l->scene->dim;
  PetscReal      y[ISPH_MAX_DIM], w[2];

  for (PetscInt a = 0; a < dim; a++) y[a] = x[a];
  for (PetscInt a = 0; a < dim; a++) {
    for (PetscInt end = 0; end < 2; end++) {
      y[a]   = x[a] + (end ? 0.5 : -0.5) * edge[a];
      w[end] = Weight(l, y);
    }
    y[a]        = x[a];
    gradient[a] = (w[1] - w[0]) / edge[a];
  }
}

/* Adds a point of quadrature, in a periodic box beside the body and not beside its image. */
static PetscErrorCode AddPoint(const PetscReal x[], const PetscReal edge[], PetscReal volume,
                               Layer *l)
{
  const Scene   *scene = l->scene;
  const PetscInt dim   = scene->dim;
  const Body    *body  = BoundaryBody(scene, l->side);

  PetscFunctionBegin;
  if (l->n == l->capacity) {
    l->capacity = 2 * l->capacity + 256;
    PetscCall(PetscRealloc(l->capacity * dim * sizeof(PetscReal), &l->x));
    PetscCall(PetscRealloc(l->capacity * dim * sizeof(PetscReal), &l->gradient));
    PetscCall(PetscRealloc(l->capacity * sizeof(PetscReal), &l->volume));
  }
  for (PetscInt a = 0; a < dim; a++) {
    const PetscReal period = scene->hi[a] - scene->lo[a];

    l->x[l->n * dim + a] = x[a];
    if (body && SceneIsPeriodic(scene, a))
      l->x[l->n * dim + a] -= period * PetscFloorReal((x[a] - body->centre[a]) / period + 0.5);
  }
  WeightGradient(l, x, edge, &l->gradient[l->n * dim]);
  l->volume[l->n++] = volume;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the middle of the fluid in a cell that a body cuts. */
static PetscErrorCode AddCut(const PetscReal lo[], const PetscReal edge[], PetscReal volume,
                             Layer *l)
{
  const PetscInt dim             = l->scene->dim,
                 all             = dim == 2 ? SAMPLES * SAMPLES : SAMPLES * SAMPLES * SAMPLES;
  PetscReal middle[ISPH_MAX_DIM] = {0.0}, y[ISPH_MAX_DIM], normal[ISPH_MAX_DIM];
  PetscInt  wet                  = 0, nearest;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < all; k++) {
    for (PetscInt a = 0, rest = k; a < dim; a++, rest /= SAMPLES)
      y[a] = lo[a] + (rest % SAMPLES + 0.5) / SAMPLES * edge[a];
    if (SceneDistance(l->scene, y, &nearest, normal) < 0.0) continue;
    for (PetscInt a = 0; a < dim; a++) middle[a] += y[a];
    wet++;
  }
  for (PetscInt a = 0; wet > 0 && a < dim; a++) middle[a] /= wet;
  if (wet > 0) PetscCall(AddPoint(middle, edge, volume * wet / all, l));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the fluid in a cell, by halves along all axes until it is as small as the spacing. */
static PetscErrorCode AddCell(const PetscReal lo[], const PetscReal edge[], Layer *l)
{
  const Scene   *scene = l->scene;
  const PetscInt dim   = scene->dim;
  PetscReal      x[ISPH_MAX_DIM], g[ISPH_MAX_DIM], half[ISPH_MAX_DIM], reach = 0.0, volume = 1.0;
  PetscReal      stretch[ISPH_MAX_DIM], excess = 0.0, distance;
  PetscInt       nearest;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < dim; a++) {
    half[a] = 0.5 * edge[a];
    x[a]    = lo[a] + half[a];
    reach += PetscSqr(half[a]);
    volume *= edge[a];
  }
  reach    = PetscSqrtReal(reach);
  distance = DistanceFrom(scene, l->side, x);
  if (distance > REACH * l->unit + reach || distance < -reach) PetscFunctionReturn(PETSC_SUCCESS);
  SceneStretch(scene, x, stretch);
  for (PetscInt a = 0; a < dim; a++)
    excess = PetscMax(excess, edge[a] * stretch[a] / SceneSpacing(scene, x));
  if (excess > 1.2) {
    for (PetscInt k = 0; k < (dim == 2 ? 4 : 8); k++) {
      PetscReal corner[ISPH_MAX_DIM];

      for (PetscInt a = 0; a < dim; a++) corner[a] = (k >> a) & 1 ? x[a] : lo[a];
      PetscCall(AddCell(corner, half, l));
    }
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  distance = SceneDistance(scene, x, &nearest, g);
  if (distance < -reach) PetscFunctionReturn(PETSC_SUCCESS);
  if (distance < reach) PetscCall(AddCut(lo, edge, volume, l));
  else PetscCall(AddPoint(x, edge, volume, l));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the cells of the lattice along an axis that the layer can reach: `count` from `low` on. */
static void CellsAlong(const Layer *l, PetscInt axis, PetscInt *low, PetscInt *count)
{
  const Scene    *scene   = l->scene;
  const Body     *body    = BoundaryBody(scene, l->side);
  const PetscReal reach   = REACH * l->unit;
  PetscReal       span[2] = {scene->lo[axis], scene->hi[axis]};
  PetscInt        end     = scene->cells[axis];

  if (body && !SceneIsPeriodic(scene, axis) && !BodyReachesThrough(body, axis))
    BodySpan(body, axis, span);
  if (!body && axis == l->side / 2) span[(l->side + 1) % 2] = span[l->side % 2];
  *low = 0;
  while (*low < end - 1 && SceneLatticePlace(scene, axis, *low + 1) < span[0] - reach) (*low)++;
  while (end > *low + 1 && SceneLatticePlace(scene, axis, end - 1) > span[1] + reach) end--;
  *count = end - *low;
}

/* Sets the layer beside a boundary with these facets, from the cells of the lattice. */
static PetscErrorCode LayerSet(const Scene *scene, PetscInt side, const Facets *s, Layer *l)
{
  const PetscInt dim = scene->dim;
  PetscInt       low[ISPH_MAX_DIM], count[ISPH_MAX_DIM], all = 1;

  PetscFunctionBegin;
  *l = (Layer){.scene = scene, .side = side, .unit = 0.0};
  for (PetscInt k = 0; k < s->n; k++)
    l->unit = PetscMax(l->unit, FacetHeight(scene, side, &s->x[k * dim]));
  for (PetscInt a = 0; a < dim; a++) {
    CellsAlong(l, a, &low[a], &count[a]);
    all *= count[a];
  }
  for (PetscInt k = 0; k < all; k++) {
    PetscReal lo[ISPH_MAX_DIM], edge[ISPH_MAX_DIM];

    for (PetscInt a = 0, rest = k; a < dim; rest /= count[a], a++) {
      const PetscInt i = low[a] + rest % count[a];

      lo[a]   = SceneLatticePlace(scene, a, i);
      edge[a] = SceneLatticePlace(scene, a, i + 1) - lo[a];
    }
    PetscCall(AddCell(lo, edge, l));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the centre of torques: the centre of a body, or the middle of the box. */
static void TorqueCentre(const Scene *scene, PetscInt side, PetscReal c[])
{
  const Body *body = BoundaryBody(scene, side);

  for (PetscInt a = 0; a < scene->dim; a++) {
    c[a] = 0.5 * (scene->lo[a] + scene->hi[a]);
    if (body && a < 2) c[a] = body->centre[a];
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

/* Adds the momentum of the layer to F and T. */
static PetscErrorCode AddMomentum(const Flow *flow, const Layer *l, const PetscReal centre[],
                                  const LinearPressure *linear, PetscReal F[], PetscReal T[])
{
  const Scene   *scene = flow->scene;
  const PetscInt dim   = scene->dim;
  PetscReal     *p, *A, *rate, *nu, *strain;

  PetscFunctionBegin;
  PetscCall(
      PetscMalloc5(l->n, &p, l->n * dim * dim, &A, l->n * dim, &rate, l->n, &nu, l->n, &strain));
  PetscCall(ProbeMotion(flow, l->n, l->x, A, rate, p));
  for (PetscInt k = 0; k < l->n; k++) strain[k] = StrainRate(dim, &A[k * dim * dim]);
  PetscCall(PointViscosity(flow, l->n, l->x, strain, nu));
  for (PetscInt k = 0; k < l->n; k++) {
    const PetscReal *x = &l->x[k * dim], *grad = &A[k * dim * dim];
    const PetscReal *g = &l->gradient[k * dim], w = Weight(l, x);
    PetscReal        f[ISPH_MAX_DIM] = {0.0}, load[ISPH_MAX_DIM];

    if (SceneHas(scene, PHYSICS_BODY_FORCE)) SceneBodyForce(scene, flow->clock->t, x, f);
    for (PetscInt a = 0; a < dim; a++) {
      load[a] = w * (scene->rho * (rate[k * dim + a] - f[a]) + linear->slope[a]);
      if (!PetscIsNanReal(p[k])) load[a] -= (p[k] - LinearAt(dim, linear, x)) * g[a];
      for (PetscInt b = 0; b < dim; b++)
        load[a] += scene->rho * nu[k] * (grad[a * dim + b] + grad[b * dim + a]) * g[b];
      load[a] *= -l->volume[k];
    }
    AddLoad(dim, centre, x, load, F, T);
  }
  PetscCall(PetscFree5(p, A, rate, nu, strain));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Subtracts the loads of another boundary where w is not zero. */
static PetscErrorCode SubtractOther(const Flow *flow, const Layer *l, PetscInt other,
                                    const PetscReal centre[], const LinearPressure *linear,
                                    PetscReal F[], PetscReal T[])
{
  const PetscInt dim  = flow->scene->dim;
  PetscInt       kept = 0;
  PetscReal     *f, *p;
  Facets         s;

  PetscFunctionBegin;
  PetscCall(FacetsOfWall(flow->scene, other, &s));
  for (PetscInt k = 0; k < s.n; k++)
    if (Weight(l, &s.x[k * dim]) > 0.0) FacetsCopy(k, kept++, &s);
  s.n = kept;
  PetscCall(FacetLoads(flow, other, &s, &f, &p));
  for (PetscInt k = 0; k < s.n; k++) {
    const PetscReal *x = &s.x[k * dim], w = Weight(l, x);
    PetscReal        load[ISPH_MAX_DIM];

    if (PetscIsNanReal(f[k * dim])) continue;
    for (PetscInt a = 0; a < dim; a++) {
      load[a] = f[k * dim + a];
      if (!PetscIsNanReal(p[k]))
        load[a] -= s.area[k] * (p[k] - LinearAt(dim, linear, x)) * s.normal[k * dim + a];
      load[a] *= -w;
    }
    AddLoad(dim, centre, x, load, F, T);
  }
  PetscCall(PetscFree(f));
  PetscCall(PetscFree(p));
  PetscCall(FacetsFree(&s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds force and torque on a boundary by the momentum of the fluid beside it, but for those of a
   linear pressure. */
static PetscErrorCode AddReaction(const Flow *flow, PetscInt side, const Facets *s,
                                  const PetscReal centre[], const LinearPressure *linear,
                                  PetscReal F[], PetscReal T[])
{
  const Scene *scene = flow->scene;
  Layer        layer;

  PetscFunctionBegin;
  PetscCall(LayerSet(scene, side, s, &layer));
  PetscCall(AddMomentum(flow, &layer, centre, linear, F, T));
  for (PetscInt other = 0; other < SceneBoundaries(scene); other++) {
    if (other == side || BoundaryIs(scene, other, BOUNDARY_CONTINUES)) continue;
    if (BoundaryIs(scene, other, BOUNDARY_FREE)) continue;
    PetscCall(SubtractOther(flow, &layer, other, centre, linear, F, T));
  }
  PetscCall(PetscFree(layer.x));
  PetscCall(PetscFree(layer.gradient));
  PetscCall(PetscFree(layer.volume));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the linear pressure that the forces of a boundary are relative to: that of a fluid at rest
   with the mean pressure on the facets, constant along periodic axes, as pressures are. With a free
   surface it is zero. */
static void SetLinear(const Flow *flow, const PetscReal centre[], const Facets *s,
                      const PetscReal p[], LinearPressure *linear)
{
  const Scene   *scene = flow->scene;
  const PetscInt dim   = scene->dim;
  PetscReal      area = 0.0, sum = 0.0;

  *linear = (LinearPressure){.p0 = 0.0};
  for (PetscInt a = 0; a < dim; a++) linear->x0[a] = centre[a];
  if (flow->ops->free || !flow->particles->p) return;
  if (SceneHas(scene, PHYSICS_BODY_FORCE))
    SceneBodyForce(scene, flow->clock->t, centre, linear->slope);
  for (PetscInt a = 0; a < dim; a++)
    linear->slope[a] *= SceneIsPeriodic(scene, a) ? 0.0 : scene->rho;
  for (PetscInt k = 0; k < s->n; k++) {
    if (PetscIsNanReal(p[k])) continue;
    sum += s->area[k] * (p[k] - LinearAt(dim, linear, &s->x[k * dim]));
    area += s->area[k];
  }
  if (area > 0.0) linear->p0 = sum / area;
}

/* Adds the loads of a linear pressure on facets; on a body, on finer ones. */
static PetscErrorCode AddLinear(const Flow *flow, PetscInt side, const Facets *s,
                                const PetscReal centre[], const LinearPressure *linear,
                                PetscReal F[], PetscReal T[])
{
  const PetscInt  dim  = flow->scene->dim;
  const PetscBool fine = BoundaryBody(flow->scene, side) ? PETSC_TRUE : PETSC_FALSE;
  Facets          of   = *s;

  PetscFunctionBegin;
  if (flow->ops->free) PetscFunctionReturn(PETSC_SUCCESS);
  if (fine) PetscCall(FacetsOfBody(flow->scene, side, FINE, &of));
  for (PetscInt k = 0; k < of.n; k++) {
    PetscReal load[ISPH_MAX_DIM];

    for (PetscInt a = 0; a < dim; a++)
      load[a] = -of.area[k] * LinearAt(dim, linear, &of.x[k * dim]) * of.normal[k * dim + a];
    AddLoad(dim, centre, &of.x[k * dim], load, F, T);
  }
  if (fine) PetscCall(FacetsFree(&of));
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

/*
  WallForce - Computes force and torque of the fluid on a boundary, a side of the box or a body, in
  two ways: by the momentum of the fluid beside it, which is the better one, and by tractions

  Collective. With a free surface both are tractions on the parts of the wall inside it. Output:
  force [N], then torque [N m] about the centre of a body or the middle of the box, at
  FORCE_MOMENTUM and FORCE_TRACTION. In 2D both are per metre of depth, and the torque is its third
  component.
*/
PetscErrorCode WallForce(const Flow *flow, PetscInt side, PetscReal force[2][2 * ISPH_MAX_DIM])
{
  const PetscInt dim      = flow->scene->dim;
  PetscReal     *momentum = force[FORCE_MOMENTUM], *traction = force[FORCE_TRACTION];
  PetscReal     *f, *p, centre[ISPH_MAX_DIM];
  LinearPressure linear;
  Facets         s;

  PetscFunctionBegin;
  PetscCall(PetscArrayzero(momentum, 2 * ISPH_MAX_DIM));
  TorqueCentre(flow->scene, side, centre);
  PetscCall(WallLoads(flow, side, &s, &f, &p));
  SetLinear(flow, centre, &s, p, &linear);
  PetscCall(AddLinear(flow, side, &s, centre, &linear, momentum, &momentum[ISPH_MAX_DIM]));
  PetscCall(PetscArraycpy(traction, momentum, 2 * ISPH_MAX_DIM));
  for (PetscInt k = 0; k < s.n; k++) {
    const PetscReal excess = p[k] - LinearAt(dim, &linear, &s.x[k * dim]);

    if (PetscIsNanReal(f[k * dim])) continue;
    for (PetscInt a = 0; a < dim; a++)
      if (!PetscIsNanReal(p[k])) f[k * dim + a] -= s.area[k] * excess * s.normal[k * dim + a];
    AddLoad(dim, centre, &s.x[k * dim], &f[k * dim], traction, &traction[ISPH_MAX_DIM]);
  }
  if (flow->ops->free || s.n == 0) PetscCall(PetscArraycpy(momentum, traction, 2 * ISPH_MAX_DIM));
  else PetscCall(AddReaction(flow, side, &s, centre, &linear, momentum, &momentum[ISPH_MAX_DIM]));
  CopyTorques(flow->scene, side, traction, momentum);
  PetscCall(PetscFree(f));
  PetscCall(PetscFree(p));
  PetscCall(FacetsFree(&s));
  PetscFunctionReturn(PETSC_SUCCESS);
}
