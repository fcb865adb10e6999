/* The fluid beside a boundary as points of quadrature, with the weight w of forces.c there: cells
   of the lattice, or the middles of the fluid in those that a body cuts. */
#include "layer.h"

#define FLAT    1.0 /* distance up to which w is 1 [spacings at the boundary] */
#define REACH   5.0 /* distance from which w is 0 */
#define SAMPLES 8   /* along each edge of a cell that a body cuts */

/* Returns the distance of x from a boundary [m]. */
static PetscReal DistanceFrom(const Scene *scene, PetscInt side, const PetscReal x[])
{
  const Body *body = BoundaryBody(scene, side);
  PetscReal   normal[ISPH_MAX_DIM];

  return body ? BodyDistance(scene, body, x, normal) : SceneSideDistance(scene, side, x);
}

/* LayerWeight - Returns w at x; not collective */
PetscReal LayerWeight(const Layer *l, const PetscReal x[])
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
      w[end] = LayerWeight(l, y);
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
  PetscReal      centre;

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
    if (!body || !SceneIsPeriodic(scene, a)) continue;
    centre = body->pose ? body->pose->x[a] : body->centre[a];
    l->x[l->n * dim + a] -= period * PetscFloorReal((x[a] - centre) / period + 0.5);
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

/* LayerSet - Sets the layer beside a boundary with these facets, from the cells of the lattice; not
   collective. Free with LayerFree(). */
PetscErrorCode LayerSet(const Scene *scene, PetscInt side, const Facets *s, Layer *l)
{
  const PetscInt dim = scene->dim;
  PetscInt       low[ISPH_MAX_DIM], count[ISPH_MAX_DIM], all = 1;

  PetscFunctionBegin;
  *l = (Layer){.scene = scene, .side = side, .unit = 0.0};
  if (s->n == 0) PetscFunctionReturn(PETSC_SUCCESS);
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

/* LayerFree - Frees a layer; not collective */
PetscErrorCode LayerFree(Layer *l)
{
  PetscFunctionBegin;
  PetscCall(FreeAll(&l->x, &l->gradient, &l->volume));
  PetscFunctionReturn(PETSC_SUCCESS);
}
