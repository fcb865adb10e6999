/*
  How the free surface of strain cells moves with the particles. Its corners y are on the level
  C = tau of the concentration, so along its normal they move as the level does, and otherwise with
  the fits:

    u(y) = sum_j Y_j u_j,   Y_j = n (dC/dx_j)^T/|dC/dy| + (1 - n n^T) N_j(y)

  On a wall they move along it. The matrices Y_j sum to 1 over particles and walls, and with them
  a body that turns has no area and no volume that change. Flux, weight and tension have the same
  velocity of the surface: then their work on the particles is that of area, volume and weight.

  Source: docs/developers/theory.md, (strain:motion)
*/
#include "strain.h"

#define LEAST_ALONG 0.2 /* sine of the least angle between a wall and the level for its motion */

/* Adds w to the entry of j in the last row; place - of particles in it, by local index. */
static PetscErrorCode EntryOf(PetscInt j, StrainBlocks *to, PetscInt place[], PetscReal **w)
{
  PetscFunctionBegin;
  if (place[j] < 0) {
    if (to->n == to->room) {
      to->room = 2 * to->room + 1024;
      PetscCall(PetscRealloc(sizeof(PetscInt) * (size_t)to->room, &to->j));
      PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)(to->room * to->size), &to->w));
    }
    place[j]     = to->n;
    to->j[to->n] = j;
    PetscCall(PetscArrayzero(&to->w[to->n++ * to->size], to->size));
  }
  *w = &to->w[place[j] * to->size];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Ends the last of the rows, which is number r. */
static void EndBlocks(PetscInt r, StrainBlocks *to, PetscInt place[])
{
  for (PetscInt e = to->start[r]; e < to->n; e++) place[to->j[e]] = -1;
  to->start[r + 1] = to->n;
}

/* Begins n rows of entries with `size` numbers. */
static PetscErrorCode BeginBlocks(PetscInt size, PetscInt n, StrainBlocks *to)
{
  PetscFunctionBegin;
  to->size = size;
  to->n    = 0;
  PetscCall(PetscRealloc(sizeof(PetscInt) * (size_t)(n + 1), &to->start));
  to->start[0] = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StrainBlocksFree(StrainBlocks *b)
{
  PetscFunctionBegin;
  PetscCall(FreeAll(&b->start, &b->j, &b->w));
  b->n = b->room = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the wall particle nearest to a place of those listed, a wet one if there is any; -1:
   none. Input: dry - walls that are not wet, by local index. */
static PetscInt NearestWall(const Particles *p, const PetscBool dry[], const PetscReal x[],
                            PetscInt n, const PetscInt list[])
{
  PetscReal least = PETSC_INFINITY;
  PetscInt  best  = -1;

  for (PetscInt q = 0; q < n; q++) {
    PetscReal y[ISPH_MAX_DIM], r2 = 0.0;

    if (!ParticlesIsWall(p, list[q])) continue;
    ParticlesWallPoint(p, list[q], y);
    for (PetscInt a = 0; a < p->dim; a++) r2 += PetscSqr(y[a] - x[a]);
    if (best >= 0 && dry[list[q]] != dry[best] ? dry[list[q]] : r2 >= least) continue;
    best  = list[q];
    least = r2;
  }
  return best;
}

/* Computes the direction in which a corner moves by a unit of the way of the level along its
   normal: along a wall that it is on, further by 1/sin of the angle between them, else along the
   normal. Input: side - the body that it is on, or another number. */
static void WayOf(const Scene *scene, PetscInt side, const PetscReal x[], const PetscReal normal[],
                  PetscReal way[])
{
  PetscReal wall[ISPH_MAX_DIM] = {0.0}, off = 0.0, along = 0.0;

  for (PetscInt a = 0; a < scene->dim; a++) {
    const PetscBool on = StrainOnSide(scene, 2 * a, x) || StrainOnSide(scene, 2 * a + 1, x);

    way[a] = on ? 0.0 : normal[a];
  }
  if (side >= 2 * scene->dim) {
    PetscReal y[ISPH_MAX_DIM];

    for (PetscInt a = 0; a < scene->dim; a++) y[a] = x[a];
    SceneIntoBox(scene, y);
    (void)BodyDistance(scene, BoundaryBody(scene, side), y, wall);
    for (PetscInt a = 0; a < scene->dim; a++) off += way[a] * wall[a];
  }
  for (PetscInt a = 0; a < scene->dim; a++) {
    way[a] -= off * wall[a];
    along += PetscSqr(way[a]);
  }
  for (PetscInt a = 0; a < scene->dim; a++)
    way[a] /= PetscMax(along, LEAST_ALONG * PetscSqrtReal(along) + PETSC_MACHINE_EPSILON);
}

/* StrainMotion - Computes the velocities of the corners of the surface. Not collective. Input:
   points - of the rows of the surface; corners - levels, and walls that are not wet. Output:
   cells->surface.motion. Mirror images and parts of the level behind walls move with the walls:
   their part goes to the nearest wall particle. */
PetscErrorCode StrainMotion(const Scene *scene, const Particles *p, const StrainPoints *points,
                            const StrainNodes *corners, StrainCells *cells)
{
  StrainSurface *s    = &cells->surface;
  const PetscInt d    = p->dim;
  Cells          near = {0};
  PetscInt      *list, *place;
  PetscReal     *slope, *part, *w;

  PetscFunctionBegin;
  PetscCall(CellsBuild(p, LEVEL_REACH * scene->dx, &near));
  PetscCall(PetscMalloc4(near.n + 1, &list, d * (near.n + 1), &slope, near.n + 1, &part,
                         ParticlesAll(p), &place));
  for (PetscInt j = 0; j < ParticlesAll(p); j++) place[j] = -1;
  PetscCall(BeginBlocks(d * d, s->n_corners, &s->motion));
  PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)(s->n_corners + 1), &s->depth));
  for (PetscInt v = 0; v < s->n_corners; v++) {
    PetscInt  n, wall;
    PetscReal x[ISPH_MAX_DIM], rest[ISPH_MAX_DIM], normal[ISPH_MAX_DIM], way[ISPH_MAX_DIM];
    PetscReal C = 0.0, size = PETSC_MACHINE_EPSILON, at[ISPH_MAX_DIM] = {0.0}, length;

    for (PetscInt a = 0; a < d; a++) x[a] = points->x[a][s->first + v];
    if (s->on_level[v])
      PetscCall(
          StrainSlopes(scene, p, &near, corners->level, x, list, part, &n, slope, normal, &C));
    else n = -1; /* it moves with the fits */
    for (PetscInt a = 0; a < d; a++) {
      if (n < 0) normal[a] = 0.0;
      size += PetscSqr(normal[a]);
    }
    size        = PetscSqrtReal(size);
    s->depth[v] = C / size;
    for (PetscInt a = 0; a < d; a++) {
      normal[a] /= -size;
      rest[a] = normal[a];
    }
    WayOf(scene, points->side[s->first + v], x, normal, way);
    wall = NearestWall(p, corners->dry, x, n, list);
    for (PetscInt q = 0; q <= n; q++) {
      const PetscInt   j  = q < n ? list[q] : wall;
      const PetscReal *of = q < n ? &slope[q * d] : rest;

      if (j < 0 || (q == n && !ParticlesIsWall(p, j))) continue;
      if (q < n && ParticlesIsWall(p, j) && !StrainWaits(scene, p, j, at, &length)) continue;
      PetscCall(EntryOf(j, &s->motion, place, &w));
      for (PetscInt k = 0; k < d * d; k++) w[k] += way[k / d] * of[k % d] / (q < n ? size : 1.0);
      for (PetscInt a = 0; a < d && q < n; a++) rest[a] -= of[a] / size;
    }
    for (PetscInt b = 0; b < d; b++) {
      const PetscInt row = (s->first + v) * cells->sets + (cells->sets == 1 ? 0 : b);

      for (PetscInt e = s->rows.start[row]; e < s->rows.start[row + 1]; e++) {
        PetscCall(EntryOf(s->rows.j[e], &s->motion, place, &w));
        for (PetscInt a = 0; a < d; a++)
          w[a * d + b] += s->rows.w[e] * ((a == b ? 1.0 : 0.0) - way[a] * normal[b]);
      }
    }
    EndBlocks(v, &s->motion, place);
  }
  PetscCall(PetscFree4(list, slope, part, place));
  PetscCall(CellsFree(&near));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  StrainLayer - Computes the weights of the divergence of cells in that at the surface,

    int psi l div u dA = sum_c (sum_v w_cv psi(y_v)) V_c (div u)_c,   w_cv = A_v l_v/sum_c' V_c'

  Not collective. The depth l = C/|grad C| of the layer that a level feels is that of corner v, and
  its divergence the mean over its cells c'. Output: cells->surface.layer. Source:
  docs/developers/theory.md, (strain:layer)
*/
PetscErrorCode StrainLayer(PetscInt d, const StrainPoints *points, const Facets *facets,
                           StrainCells *s)
{
  const PetscInt n = s->surface.n_corners;
  PetscInt      *place;
  PetscReal     *area, *volume, *w;

  PetscFunctionBegin;
  PetscCall(PetscMalloc3(n + 1, &place, n + 1, &area, n + 1, &volume));
  for (PetscInt v = 0; v < n; v++) {
    place[v] = -1;
    area[v] = volume[v] = 0.0;
  }
  for (PetscInt c = 0; c < s->n; c++)
    for (PetscInt k = facets->first[c]; k < facets->first[c + 1]; k++) {
      const PetscInt v  = facets->facet[k].point - s->surface.first;
      PetscReal      n2 = 0.0;

      if (v < 0 || !s->surface.on_level[v]) continue;
      for (PetscInt a = 0; a < d; a++) n2 += PetscSqr(facets->facet[k].normal[a]);
      area[v] += s->volume[c] * PetscSqrtReal(n2);
      volume[v] += s->volume[c];
    }
  PetscCall(BeginBlocks(1 + d, s->n, &s->surface.layer));
  for (PetscInt c = 0; c < s->n; c++) {
    for (PetscInt k = facets->first[c]; k < facets->first[c + 1]; k++) {
      const PetscInt v = facets->facet[k].point - s->surface.first;

      if (v < 0 || !s->surface.on_level[v]) continue;
      PetscCall(EntryOf(v, &s->surface.layer, place, &w));
      w[0] += s->surface.depth[v] * area[v] / volume[v];
      for (PetscInt a = 0; a < d; a++) w[1 + a] = points->x[a][facets->facet[k].point];
    }
    EndBlocks(c, &s->surface.layer, place);
  }
  PetscCall(PetscFree3(place, area, volume));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds facet k of a cell to the weights: a component of the velocity through it times the way from
   the middle of the cell. Input: own - the cell is in the box of this rank, which adds walls'. */
static void AddWeights(const Particles *p, const StrainPoints *points, const StrainCells *s,
                       const Facet *facet, PetscInt c, PetscReal density, PetscBool own,
                       PetscReal *const weight[])
{
  const StrainSurface *surface = &s->surface;
  const PetscInt       d = p->dim, v = facet->point - surface->first;
  PetscReal            part[ISPH_MAX_DIM];

  for (PetscInt a = 0; a < d; a++)
    part[a] = density * s->volume[c] * (points->x[a][facet->point] - s->centre[a][c]);
  if (v >= 0) {
    for (PetscInt e = surface->motion.start[v]; e < surface->motion.start[v + 1]; e++) {
      const PetscInt j = surface->motion.j[e];

      if (j >= p->n_fluid && !(own && ParticlesIsWall(p, j))) continue;
      for (PetscInt k = 0; k < d * d * d; k++) {
        const PetscInt a = k / (d * d), b = k % d, of = k / d % d;

        weight[a * d + b][j] +=
            part[a] * facet->normal[of] * surface->motion.w[e * d * d + of * d + b];
      }
    }
    return;
  }
  for (PetscInt b = 0; b < d; b++) {
    const PetscInt row = facet->point * s->sets + (s->sets == 1 ? 0 : b);

    for (PetscInt e = surface->rows.start[row]; e < surface->rows.start[row + 1]; e++) {
      const PetscInt j = surface->rows.j[e];

      if (j >= p->n_fluid && !(own && ParticlesIsWall(p, j))) continue;
      for (PetscInt a = 0; a < d; a++)
        weight[a * d + b][j] += part[a] * facet->normal[b] * surface->rows.w[e];
    }
  }
}

/* Adds the flux out of a cell by the motion of a corner of the surface, less that of its fit. */
static PetscErrorCode AddFlux(PetscInt d, const StrainCells *s, const Facet *facet, PetscInt c,
                              PetscInt place[], StrainBlocks *flux)
{
  const StrainSurface *surface = &s->surface;
  const PetscInt       v       = facet->point - surface->first;
  PetscReal           *w;

  PetscFunctionBegin;
  for (PetscInt e = surface->motion.start[v]; e < surface->motion.start[v + 1]; e++) {
    PetscCall(EntryOf(surface->motion.j[e], flux, place, &w));
    for (PetscInt k = 0; k < d * d; k++)
      w[k % d] += s->volume[c] * facet->normal[k / d] * surface->motion.w[e * d * d + k];
  }
  for (PetscInt b = 0; b < d; b++) {
    const PetscInt row = facet->point * s->sets + (s->sets == 1 ? 0 : b);

    for (PetscInt e = surface->rows.start[row]; e < surface->rows.start[row + 1]; e++) {
      PetscCall(EntryOf(surface->rows.j[e], flux, place, &w));
      w[b] -= s->volume[c] * facet->normal[b] * surface->rows.w[e];
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the flux out of a cell of a group, by its own sides, less that of the gradient of the
   group. */
static PetscErrorCode AddOwnFlux(PetscInt d, const StrainCells *s, const Facets *facets, PetscInt c,
                                 PetscInt place[], StrainBlocks *flux)
{
  const StrainRows *rows = &s->surface.rows;
  PetscReal        *w;

  PetscFunctionBegin;
  for (PetscInt b = 0; b < d; b++) {
    const PetscInt q = s->sets == 1 ? 0 : b;

    for (PetscInt k = facets->first[c]; k < facets->first[c + 1]; k++) {
      const PetscInt row = facets->facet[k].point * s->sets + q;

      for (PetscInt e = rows->start[row]; e < rows->start[row + 1]; e++) {
        PetscCall(EntryOf(rows->j[e], flux, place, &w));
        w[b] += s->volume[c] * facets->facet[k].normal[b] * rows->w[e];
      }
    }
    for (PetscInt e = s->first[q][c]; e < s->first[q][c + 1]; e++) {
      PetscCall(EntryOf(s->j[q][e], flux, place, &w));
      w[b] -= s->volume[c] * s->g[q][b][e];
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  StrainFluxes - Computes for each cell the flux by the motion of the surface, less that of the fits
  there, that by its own sides if it shares a gradient, and the weights of the rows, on which body
  forces act,

    (w_i)_ab = sum_c r_c sum_f (x_f - x_c)_a (u_f.n_f A_f by component b of u_i)

  over facets f of c, with the density r_c of its fluid over that of fluid 0. A particle without
  cells has the weight of its own volume. Not collective. The gradient of a linear pressure in each
  fluid that vanishes on the surface then balances a uniform force.
*/
PetscErrorCode StrainFluxes(const Scene *scene, const Particles *p, const StrainPoints *points,
                            const Facets *facets, const StrainGroups *groups, StrainCells *s)
{
  const PetscInt d = p->dim;
  PetscInt      *place;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(ParticlesAll(p), &place));
  for (PetscInt j = 0; j < ParticlesAll(p); j++) place[j] = -1;
  for (PetscInt k = 0; k < d * d; k++) {
    PetscCall(PetscFree(s->weight[k]));
    PetscCall(PetscCalloc1(ParticlesAll(p) + 1, &s->weight[k]));
  }
  PetscCall(BeginBlocks(d, s->n, &s->flux));
  for (PetscInt c = 0; c < s->n; c++) {
    PetscReal       x[ISPH_MAX_DIM];
    const PetscBool own = StrainHasCell(p, s, c, x);

    for (PetscInt k = facets->first[c]; k < facets->first[c + 1]; k++) {
      const PetscInt v = facets->facet[k].point - s->surface.first;

      AddWeights(p, points, s, &facets->facet[k], c, SceneFluidDensity(scene, s->fluid[c]), own,
                 s->weight);
      if (v >= 0 && s->surface.on_level[v])
        PetscCall(AddFlux(d, s, &facets->facet[k], c, place, &s->flux));
    }
    if (groups->volume[groups->lead[c]] > s->volume[c])
      PetscCall(AddOwnFlux(d, s, facets, c, place, &s->flux));
    EndBlocks(c, &s->flux, place);
  }
  for (PetscInt i = 0; i < p->n_fluid; i++)
    for (PetscInt a = 0; a < d && s->apart[i]; a++)
      s->weight[a * d + a][i] += s->mass[s->sets == 1 ? 0 : a][i];
  PetscCall(PetscFree(place));
  PetscFunctionReturn(PETSC_SUCCESS);
}
