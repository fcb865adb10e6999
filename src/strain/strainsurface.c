/* The free surface of the fluid in the strain cells, and interfaces: facets, whose corners are on
   the level of the concentration, and how uneven particles are below it. */
#include "strain.h"

#define SAME_PLACE 1e-6 /* corners so near are the same, over the edge of a cell */

/* StrainFacetAdd - Adds a facet; not collective. Input: x - its dim corners, in the order that
   turns its normal out of the fluid; fluid - whose fits have its velocity; between - it is of an
   interface of fluids. */
PetscErrorCode StrainFacetAdd(PetscInt dim, const PetscReal x[][ISPH_MAX_DIM], PetscInt fluid,
                              PetscBool between, PetscReal tension, StrainSurface *s)
{
  PetscFunctionBegin;
  if (s->n == s->room) {
    s->room = 2 * s->room + 256;
    PetscCall(PetscRealloc(sizeof(PetscInt) * (size_t)(s->room * dim), &s->corner));
    PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)(s->room * dim * dim), &s->x));
    PetscCall(PetscRealloc(sizeof(PetscInt) * (size_t)s->room, &s->fluid));
    PetscCall(PetscRealloc(sizeof(PetscBool) * (size_t)s->room, &s->between));
    PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)s->room, &s->tension));
  }
  for (PetscInt e = 0; e < dim * dim; e++) s->x[s->n * dim * dim + e] = x[e / dim][e % dim];
  s->fluid[s->n]     = fluid;
  s->between[s->n]   = between;
  s->tension[s->n++] = tension;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* StrainWetAdd - Adds the dim corners x of a part of a body that fluid wets; not collective */
PetscErrorCode StrainWetAdd(PetscInt dim, const PetscReal x[][ISPH_MAX_DIM], PetscInt body,
                            StrainSurface *s)
{
  PetscFunctionBegin;
  if (s->n_wet + dim > s->room_wet) {
    s->room_wet = 2 * s->room_wet + 256;
    PetscCall(PetscRealloc(sizeof(PetscInt) * (size_t)s->room_wet, &s->wet_body));
    PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)(s->room_wet * dim), &s->wet_x));
  }
  for (PetscInt v = 0; v < dim; v++) {
    for (PetscInt a = 0; a < dim; a++) s->wet_x[s->n_wet * dim + a] = x[v][a];
    s->wet_body[s->n_wet++] = body;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A corner of a facet: its place in units that are small against a cell. */
typedef struct {
  PetscInt64 x[ISPH_MAX_DIM];
  PetscInt   at; /* facet times dim plus the number of the corner; -1 - number of a wet one */
} Corner;

static int ComparePlaces(const void *a, const void *b)
{
  const Corner *of[] = {(const Corner *)a, (const Corner *)b};

  for (PetscInt c = 0; c < ISPH_MAX_DIM; c++)
    if (of[0]->x[c] != of[1]->x[c]) return of[0]->x[c] < of[1]->x[c] ? -1 : 1;
  return of[0]->at < of[1]->at ? -1 : 1;
}

/* Returns the boundary of the box that a place is on; -1: none. */
static PetscInt BoxSideAt(const Scene *scene, const PetscReal x[])
{
  PetscInt side = 2 * scene->dim - 1;

  while (side >= 0 && !StrainOnSide(scene, side, x)) side--;
  return side;
}

/* Returns the end of the corners from `first` on that have its place. */
static PetscInt EndOfPlace(PetscInt n, const Corner corner[], PetscInt first)
{
  PetscInt k = first + 1;

  for (; k < n; k++)
    for (PetscInt c = 0; c < ISPH_MAX_DIM; c++)
      if (corner[k].x[c] != corner[first].x[c]) return k;
  return k;
}

/* StrainCorners - Numbers the corners of the facets, and adds their points; not collective. Cells
   side by side compute the places of their corners alike but for rounding: corners on a line of
   the lattice lie in the middle of what counts as one place. A corner that wet bodies share is on a
   contact line. The stiffest fluid at a corner gives its velocity. */
PetscErrorCode StrainCorners(const Scene *scene, const StrainLattice *l, StrainSurface *s,
                             StrainPoints *points)
{
  const PetscInt d = l->dim, all = s->n * d, n = all + s->n_wet;
  Corner        *corner;

  PetscFunctionBegin;
  s->first     = points->n;
  s->n_corners = 0;
  PetscCall(PetscCalloc1(n, &corner));
  PetscCall(PetscRealloc(sizeof(PetscBool) * (size_t)(all + 1), &s->on_level));
  for (PetscInt k = 0; k < n; k++) {
    const PetscReal *x = k < all ? &s->x[k * d] : &s->wet_x[(k - all) * d];

    corner[k].at = k < all ? k : all - 1 - k;
    for (PetscInt a = 0; a < d; a++)
      corner[k].x[a] =
          (PetscInt64)PetscFloorReal((x[a] - scene->lo[a]) / (SAME_PLACE * l->edge[a]) + 0.5);
  }
  if (n) qsort(corner, (size_t)n, sizeof(*corner), ComparePlaces);
  for (PetscInt k = 0, end; k < n; k = end) {
    PetscInt  side = -1, fluid = -1;
    PetscBool on_level = PETSC_FALSE;

    end = EndOfPlace(n, corner, k);
    for (; k < end && corner[k].at < 0; k++) side = s->wet_body[-1 - corner[k].at];
    if (k == end) continue;
    for (PetscInt q = k; q < end; q++) {
      const PetscInt f = corner[q].at / d;

      s->corner[corner[q].at] = s->n_corners;
      if (fluid < 0 || StrainIsStiffer(scene, s->fluid[f], fluid)) fluid = s->fluid[f];
      if (!s->between[f]) on_level = PETSC_TRUE;
    }
    if (BoxSideAt(scene, &s->x[corner[k].at * d]) >= 0)
      side = BoxSideAt(scene, &s->x[corner[k].at * d]);
    PetscCall(StrainPointAdd(d, &s->x[corner[k].at * d], fluid, side, points));
    s->on_level[s->n_corners++] = on_level;
  }
  PetscCall(PetscFree(corner));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds f times kernel and gradient at the distance X from i to a point. */
static void AddKernel(const KernelSize *kernel, PetscInt dim, const PetscReal X[], PetscReal f,
                      PetscReal *value, PetscReal gradient[])
{
  PetscReal r = 0.0, w[3];

  for (PetscInt a = 0; a < dim; a++) r += PetscSqr(X[a]);
  r = PetscSqrtReal(r);
  if (r >= kernel->radius) return;
  KernelEvaluate(kernel->row, dim, kernel->h, r, w);
  *value += f * w[0];
  for (PetscInt a = 0; a < dim && r > 0.0; a++) gradient[a] -= f * w[1] * X[a] / r;
}

/*
  StrainUnevenness - Computes how much denser particles are than the fluid in the cells, and the
  gradient, for shifting

    c_i - 1 = sum_j V_j W_ij - sum_c V_c W(x_i - y_c)

  Not collective. Both sums end at walls and at the free surface alike, so that shifts do not leave
  the fluid. Output: value - c of own fluid; gradient - components.
*/
PetscErrorCode StrainUnevenness(const Scene *scene, const Particles *p, const Neighbors *nb,
                                const KernelSize *kernel, const StrainCells *cells,
                                PetscReal value[], PetscReal *const gradient[])
{
  const StrainLattice *l   = &cells->lattice;
  const PetscInt       all = StrainCellCount(l);
  PetscInt            *at, *next;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(all, &at, cells->n, &next));
  for (PetscInt k = 0; k < all; k++) at[k] = -1;
  for (PetscInt c = 0; c < cells->n; c++) {
    PetscInt k = 0;

    for (PetscInt a = l->dim - 1; a >= 0; a--)
      k = k * l->n[a] + StrainIndexAlong(scene, l, a, cells->centre[a][c]);
    next[c] = at[k];
    at[k]   = c;
  }
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscInt  low[ISPH_MAX_DIM] = {0}, n[ISPH_MAX_DIM] = {1, 1, 1};
    PetscReal g[ISPH_MAX_DIM] = {0.0}, X[ISPH_MAX_DIM];

    value[i] = 1.0;
    for (PetscInt q = nb->row[i] - 1; q < nb->row[i + 1]; q++) {
      const PetscInt j = q < nb->row[i] ? i : nb->col[q];

      if (ParticlesIsWall(p, j)) {
        PetscReal x[ISPH_MAX_DIM] = {0.0}, length;

        if (!StrainWaits(scene, p, j, x, &length)) continue;
        for (PetscInt a = 0; a < p->dim; a++)
          X[a] = x[a] + 0.5 * length * p->normal[a][j] - p->x[a][i];
        AddKernel(kernel, p->dim, X,
                  p->cell_volume * length / SceneCellSide(scene, (PetscInt)p->side[j] / 2),
                  &value[i], g);
        continue;
      }
      for (PetscInt a = 0; a < p->dim; a++) X[a] = p->x[a][j] - p->x[a][i];
      AddKernel(kernel, p->dim, X, p->volume[j], &value[i], g);
    }
    for (PetscInt a = 0; a < p->dim; a++) {
      low[a] = StrainIndexAlong(scene, l, a, p->x[a][i] - kernel->radius);
      n[a]   = StrainIndexAlong(scene, l, a, p->x[a][i] + kernel->radius) - low[a] + 1;
    }
    for (PetscInt k = 0; k < n[0] * n[1] * n[2]; k++) {
      const PetscInt step[] = {k % n[0], k / n[0] % n[1], k / (n[0] * n[1])};
      PetscInt       cell   = 0;

      for (PetscInt a = l->dim - 1; a >= 0; a--) cell = cell * l->n[a] + low[a] + step[a];
      for (PetscInt c = at[cell]; c >= 0; c = next[c]) {
        for (PetscInt a = 0; a < p->dim; a++) X[a] = cells->centre[a][c] - p->x[a][i];
        AddKernel(kernel, p->dim, X, -cells->volume[c], &value[i], g);
      }
    }
    for (PetscInt a = 0; a < p->dim; a++) gradient[a][i] = g[a];
  }
  PetscCall(PetscFree2(at, next));
  PetscFunctionReturn(PETSC_SUCCESS);
}
