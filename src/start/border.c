/* Particles on the free borders of pools without lattice. A border consists of pieces: the parts of
   the outlines of regions that are inside the box, outside bodies and outside other regions,
   divided at corners. The particles of a piece are evenly spaced, about dx apart. A piece that ends
   at a wall has its last particle dx/2 above this wall, as a lattice has, and a meridian that ends
   at the axis has it dx/2 off the axis; a piece that ends at a corner has it in the corner; a piece
   that ends at another region, a body or a periodic side has it half a spacing before. */
#include "start.h"

#define FINE   32.0 /* samples of an outline along dx */
#define COARSE 8    /* samples from one that is checked to the next */
#define CORNER 0.9  /* cosine of the angle of normals at a corner */
#define NEAR   1e-6 /* distance from a side below which an outline follows it [dx] */

/* A run of consecutive samples of an outline. */
typedef struct {
  PetscInt  first, n;  /* in the pool's samples */
  PetscReal offset[2]; /* of the outer particles from the ends [spacings] */
  PetscBool shared;    /* the particle at the first end belongs to the piece before; an outline
                          without ends and corners is one piece with half a spacing at both ends */
} Piece;

/* Returns true unless region k is a ball: its border has an outline, in 3D the same at every z, or
   a meridian. */
static PetscBool HasOutline(const Scene *scene, PetscInt k)
{
  return BodyOutline(scene, &scene->filled[k]) ? PETSC_TRUE : PETSC_FALSE;
}

/* Computes a place in the box at a point of the outline of region k; for a meridian, whose points
   are (r, z), at y = 0. */
static void PlaceAt(const Scene *scene, PetscInt k, const PetscReal point[], PetscReal x[])
{
  const PetscBool revolves = scene->filled[k].shape->revolves;

  x[0] = point[0];
  x[1] = revolves ? 0.0 : point[1];
  x[2] = revolves ? point[1] : scene->filled[k].centre[2];
}

/* Computes the point in the plane of the outline of region k that is below or beside x. */
static void PointBelow(const Scene *scene, PetscInt k, const PetscReal x[], PetscReal point[])
{
  const PetscBool revolves = scene->filled[k].shape->revolves;

  point[0] = revolves ? PetscSqrtReal(PetscSqr(x[0]) + PetscSqr(x[1])) : x[0];
  point[1] = x[revolves ? 2 : 1];
}

/* Gets the axes, from the first to before the last, across which sides of the box end an outline:
   one that is the same at every z ends across x and y, a meridian across z. */
static void GetAxes(const Scene *scene, PetscInt k, PetscInt *first, PetscInt *last)
{
  *first = scene->filled[k].shape->revolves ? 2 : 0;
  *last  = scene->filled[k].shape->revolves ? 3 : 2;
}

/* Returns the distance of a point of the outline of region k from the nearest side of the box with
   wall particles, from the axis of a meridian and, if `bodies`, from the nearest body [m]. */
static PetscReal WallGap(const Scene *scene, PetscInt k, const PetscReal point[], PetscBool bodies)
{
  PetscReal gap = PETSC_INFINITY, x[ISPH_MAX_DIM], normal[ISPH_MAX_DIM];
  PetscInt  body, first, last;

  PlaceAt(scene, k, point, x);
  GetAxes(scene, k, &first, &last);
  if (bodies) gap = SceneDistance(scene, x, &body, normal);
  if (scene->filled[k].shape->revolves) gap = PetscMin(gap, point[0]);
  for (PetscInt side = 2 * first; side < 2 * last; side++) {
    if (BoundaryIs(scene, side, BOUNDARY_PARTICLES))
      gap = PetscMin(gap, SceneSideDistance(scene, side, x));
  }
  return gap;
}

/* Returns true if a point of the outline of region k is on a periodic side of the box, or beyond
   it. */
static PetscBool OnPeriodicSide(const Scene *scene, PetscInt k, const PetscReal point[])
{
  PetscReal x[ISPH_MAX_DIM];
  PetscInt  first, last;

  PlaceAt(scene, k, point, x);
  GetAxes(scene, k, &first, &last);
  for (PetscInt a = first; a < last; a++) {
    const PetscReal gap = PetscMin(x[a] - scene->lo[a], scene->hi[a] - x[a]);

    if (SceneIsPeriodic(scene, a) && gap < NEAR * scene->dx) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Returns true if a point on the outline of region k is on the free border; the mirror image of a
   meridian is not. */
static PetscBool IsFree(const Scene *scene, PetscInt k, const PetscReal point[])
{
  PetscReal x[ISPH_MAX_DIM];

  PlaceAt(scene, k, point, x);
  if (WallGap(scene, k, point, PETSC_TRUE) < NEAR * scene->dx) return PETSC_FALSE;
  if (OnPeriodicSide(scene, k, point)) return PETSC_FALSE;
  for (PetscInt m = 0; m < scene->n_filled; m++)
    if (m != k && SceneFilledDistance(scene, m, x) >= 0.0) return PETSC_FALSE;
  return PETSC_TRUE;
}

/* Returns true if the normals of two samples differ as on both sides of a corner. */
static PetscBool TurnsAt(const BorderSample *a, const BorderSample *b)
{
  return a->normal[0] * b->normal[0] + a->normal[1] * b->normal[1] < CORNER;
}

/* Adds the samples of the outline of region k, in order, beginning at the end of a piece if there
   is one. */
static PetscErrorCode SampleRegion(PetscInt k, Pools *pools)
{
  const Scene    *scene = pools->scene;
  const Body     *body  = &scene->filled[k];
  const ShapeRow *shape = BodyOutline(scene, body);
  const PetscReal step  = scene->dx / FINE;
  const PetscInt  n     = shape->Count(body, step);
  BorderSample   *all;
  PetscInt        start = 0;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(n, &all));
  for (PetscInt q = 0; q < n; q++) {
    all[q]        = (BorderSample){.region = k};
    all[q].length = shape->Point(body, q, step, all[q].x, all[q].normal);
    all[q].free   = IsFree(scene, k, all[q].x);
  }
  for (PetscInt q = n - 1; q >= 0; q--) {
    const BorderSample *before = &all[(q + n - 1) % n];

    if (before->free != all[q].free || TurnsAt(before, &all[q])) start = q;
  }
  PetscCall(PetscRealloc(sizeof(*all) * (size_t)(pools->n_border + n), &pools->border));
  for (PetscInt q = 0; q < n; q++) pools->border[pools->n_border + q] = all[(start + q) % n];
  pools->n_border += n;
  PetscCall(PetscFree(all));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the number of particles on the border at a point of the outline of region k: in 3D one in
   each layer of cells along z, or those of a ring about the axis. */
static PetscInt PlacesAlong(const Scene *scene, PetscInt k, const PetscReal point[])
{
  if (scene->dim == 2) return 1;
  return scene->filled[k].shape->revolves ? ShapeRingCount(point[0], scene->dx) : scene->cells[2];
}

/* Computes the place of particle l of PlacesAlong(); those of a ring may be outside the box. */
static void PlaceAlong(const Scene *scene, PetscInt k, const PetscReal point[], PetscInt l,
                       PetscReal x[])
{
  x[0] = point[0];
  x[1] = point[1];
  x[2] = 0.0;
  if (scene->filled[k].shape->revolves) {
    const PetscReal angle = 2.0 * PETSC_PI * (l + 0.5) / ShapeRingCount(point[0], scene->dx);

    x[0] = point[0] * PetscCosReal(angle);
    x[1] = point[0] * PetscSinReal(angle);
    x[2] = point[1];
  } else if (scene->dim == 3) {
    x[2] = scene->lo[2] + (l + 0.5) * SceneCellSide(scene, 2);
  }
}

static PetscBool InBox(const Scene *scene, const PetscReal x[])
{
  for (PetscInt a = 0; a < scene->dim; a++)
    if (x[a] < scene->lo[a] || x[a] > scene->hi[a]) return PETSC_FALSE;
  return PETSC_TRUE;
}

/* Returns true if a body or region cuts the border of a region alike at all places along it. */
static PetscBool CutsAlike(const Body *region, const Body *other)
{
  if (region->shape->revolves) return other->shape->revolves;
  return BodyReachesThrough(region, 2) && BodyReachesThrough(other, 2);
}

/* Refuses region k if the gap between its border and another shape vanishes at x. Input: option,
   number - of the other shape; gap - negative inside it [m]. */
static PetscErrorCode RefuseGap(const Scene *scene, PetscInt k, const char option[],
                                PetscInt number, const PetscReal x[], PetscReal gap)
{
  PetscFunctionBegin;
  UserCheck(gap >= NEAR * scene->dx,
            "-scene_filled_%" PetscInt_FMT ": its border meets %s_%" PetscInt_FMT
            " near (%.4g, %.4g, %.4g); in 3D cylinders and prisms may cut borders of each other, "
            "and revolved shapes those of each other; change a shape, or keep them apart",
            k + 1, option, number + 1, (double)x[0], (double)x[1], (double)x[2]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses region k if at place x on its border it meets a body, or another region, that does not
   cut it alike at all places: the outline cannot tell where the border is free. */
static PetscErrorCode RefusePlace(const Scene *scene, PetscInt k, const PetscReal x[])
{
  const Body *region = &scene->filled[k];
  PetscReal   y[ISPH_MAX_DIM];

  PetscFunctionBegin;
  if (!InBox(scene, x)) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt b = 0; b < scene->n_bodies; b++) {
    const Body *body = SceneBody(scene, b);

    if (CutsAlike(region, body)) continue;
    PetscCall(RefuseGap(scene, k, "-scene_body", b, x, BodyDistance(scene, body, x, y)));
  }
  for (PetscInt m = 0; m < scene->n_filled; m++) {
    if (m == k || CutsAlike(region, &scene->filled[m])) continue;
    PetscCall(RefuseGap(scene, k, "-scene_filled", m, x, -SceneFilledDistance(scene, m, x)));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses borders in 3D as RefusePlace(). */
static PetscErrorCode RefuseUneven(const Pools *pools)
{
  const Scene *scene = pools->scene;
  PetscReal    x[ISPH_MAX_DIM], normal[ISPH_MAX_DIM];

  PetscFunctionBegin;
  for (PetscInt q = 0; q < pools->n_border; q += COARSE) {
    const BorderSample *s = &pools->border[q];

    for (PetscInt l = 0; l < PlacesAlong(scene, s->region, s->x); l++) {
      PlaceAlong(scene, s->region, s->x, l, x);
      PetscCall(RefusePlace(scene, s->region, x));
    }
  }
  for (PetscInt k = 0; k < scene->n_filled; k++) {
    const Body *ball = &scene->filled[k];

    for (PetscInt q = 0; !HasOutline(scene, k) && q < BodyPoints(ball, scene->dx); q++) {
      (void)BodyPoint(ball, q, scene->dx, x, normal);
      PetscCall(RefusePlace(scene, k, x));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* BorderCreate - Samples the outlines of the regions of all pools without lattice; every rank has
   all samples. Errors: refuses borders in 3D whose free part has no outline. */
PetscErrorCode BorderCreate(Pools *pools)
{
  PetscFunctionBegin;
  for (PetscInt k = 0; k < pools->scene->n_filled; k++)
    if (!pools->lattice[pools->of[k]] && HasOutline(pools->scene, k))
      PetscCall(SampleRegion(k, pools));
  if (pools->scene->dim == 3) PetscCall(RefuseUneven(pools));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* BorderIsNear - Returns true if a free border, or a sample of it, is nearer to x than `reach`
   [m] */
PetscBool BorderIsNear(const Pools *pools, const PetscReal x[], PetscReal reach)
{
  for (PetscInt k = 0; k < pools->scene->n_filled; k++) {
    if (!HasOutline(pools->scene, k) &&
        PetscAbsReal(SceneFilledDistance(pools->scene, k, x)) < reach)
      return PETSC_TRUE;
  }
  for (PetscInt q = 0; q < pools->n_border; q++) {
    const BorderSample *s = &pools->border[q];
    PetscReal           y[2];

    if (!s->free) continue;
    PointBelow(pools->scene, s->region, x, y);
    if (PetscSqr(y[0] - s->x[0]) + PetscSqr(y[1] - s->x[1]) < PetscSqr(reach)) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Finds the end of the piece that begins at a sample: the number of samples to it. */
static PetscInt PieceLength(const Pools *pools, PetscInt first)
{
  const BorderSample *s = pools->border;
  PetscInt            n = 1;

  while (first + n < pools->n_border && s[first + n].region == s[first].region &&
         s[first + n].free && !TurnsAt(&s[first + n - 1], &s[first + n]))
    n++;
  return n;
}

/* Finds the neighbour of an end of a piece on the outline, which is closed. */
static const BorderSample *Beyond(const Pools *pools, const Piece *piece, PetscInt end)
{
  const BorderSample *s      = pools->border;
  const PetscInt      region = s[piece->first].region;
  PetscInt            k      = end ? piece->first + piece->n : piece->first - 1;

  if (end && (k == pools->n_border || s[k].region != region)) {
    k = piece->first;
    while (k > 0 && s[k - 1].region == region) k--;
  } else if (!end && (k < 0 || s[k].region != region)) {
    k = piece->first;
    while (k + 1 < pools->n_border && s[k + 1].region == region) k++;
  }
  return &s[k];
}

/* Sets the ends of a piece, and shortens it to the samples that are dx/2 above walls if it ends at
   them. Returns PETSC_FALSE if none is left. */
static PetscBool SetEnds(const Pools *pools, Piece *piece)
{
  const Scene   *scene  = pools->scene;
  const PetscInt region = pools->border[piece->first].region;

  piece->shared = PETSC_FALSE;
  for (PetscInt end = 0; end < 2; end++) {
    const BorderSample *own    = &pools->border[piece->first + (end ? piece->n - 1 : 0)];
    const BorderSample *beyond = Beyond(pools, piece, end);

    piece->offset[end] = 0.5;
    if (beyond->free && TurnsAt(own, beyond)) {
      piece->offset[end] = 0.0;
      if (!end) piece->shared = PETSC_TRUE;
    } else if (!beyond->free &&
               WallGap(scene, region, own->x, PETSC_FALSE) < 2.0 * scene->dx / FINE) {
      piece->offset[end] = 0.0;
      while (piece->n &&
             WallGap(scene, region, pools->border[piece->first + (end ? piece->n - 1 : 0)].x,
                     PETSC_FALSE) < (0.5 - NEAR) * scene->dx) {
        piece->n--;
        if (!end) piece->first++;
      }
    }
    if (!piece->n) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* Adds a particle at x, if this rank has it. */
static PetscErrorCode AddPoint(const Scene *scene, const PetscReal x[], Rows *rows)
{
  PetscMPIInt rank, ranks;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &ranks));
  if (rows->N % ranks == rank) {
    PetscCall(RowsAdd(scene, x, rows));
    rows->index[rows->n - 1] = rows->N;
  }
  rows->N++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AddPiece(const Pools *pools, const Piece *piece, Rows *rows)
{
  const Scene        *scene = pools->scene;
  const BorderSample *s     = &pools->border[piece->first];
  const PetscReal     ends  = piece->offset[0] + piece->offset[1];
  PetscReal           total = 0.0, sum = 0.0, edge;
  PetscInt            n, m;

  PetscFunctionBegin;
  for (PetscInt q = 0; q < piece->n; q++) total += s[q].length;
  n    = PetscMax(1, (PetscInt)PetscFloorReal(total / scene->dx + 1.5 - ends));
  edge = n - 1.0 + ends > 0.0 ? total / (n - 1.0 + ends) : 0.0;
  m    = piece->shared ? 1 : 0;
  for (PetscInt q = 0; q < piece->n && m < n; q++) {
    sum += s[q].length;
    if (sum < (m + piece->offset[0]) * edge && q + 1 < piece->n) continue;
    for (PetscInt l = 0; l < PlacesAlong(scene, s->region, s[q].x); l++) {
      PetscReal x[ISPH_MAX_DIM];

      PlaceAlong(scene, s->region, s[q].x, l, x);
      if (InBox(scene, x)) PetscCall(AddPoint(scene, x, rows));
    }
    m++;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the particles on the surface of a ball. */
static PetscErrorCode AddBall(const Scene *scene, const Body *ball, Rows *rows)
{
  PetscFunctionBegin;
  for (PetscInt k = 0; k < BodyPoints(ball, scene->dx); k++) {
    PetscReal x[ISPH_MAX_DIM], normal[ISPH_MAX_DIM];

    (void)BodyPoint(ball, k, scene->dx, x, normal);
    PetscCall(AddPoint(scene, x, rows));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* BorderParticles - Adds this rank's share of the particles on free borders of pools without
   lattice. Collective on PETSC_COMM_WORLD. */
PetscErrorCode BorderParticles(const Pools *pools, Rows *rows)
{
  Piece piece;

  PetscFunctionBegin;
  for (PetscInt q = 0; q < pools->n_border; q += piece.n) {
    PetscInt n;

    piece = (Piece){.first = q, .n = 1};
    if (!pools->border[q].free) continue;
    piece.n = n = PieceLength(pools, q);
    if (SetEnds(pools, &piece)) PetscCall(AddPiece(pools, &piece, rows));
    piece.n = n;
  }
  for (PetscInt k = 0; k < pools->scene->n_filled; k++) {
    const Body *body = &pools->scene->filled[k];

    if (!HasOutline(pools->scene, k)) PetscCall(AddBall(pools->scene, body, rows));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
