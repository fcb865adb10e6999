/* Compounds: unions, differences and intersections of shapes, combined in the order in which they
   are typed. The border of a compound in the plane consists of the parts of its shapes' curves that
   separate solid and fluid, so that distances from it are true everywhere. In space the distance is
   that of the nearest part: true if the nearest point of that part is on the surface, and a lower
   bound beside edges where parts meet; its sign is right everywhere. */
#include "curves.h"

#define TIGHT 1e-9 /* distance of points that are the same [extent] */
#define JOINT 1e-8 /* distance of ends of pieces that meet; shorter pieces are none [extent] */
#define SIDE  1e-6 /* distance at which both sides of a curve are tried [extent] */
#define LARGE 50.0 /* largest part of a solid [extent of the whole] */
#define STEP  1e-3 /* least step along a curve in the search of crossings [its length] */

/* Sorted places along a curve. */
typedef struct {
  PetscInt   n, capacity;
  PetscReal *s;
} Cuts;

static PetscErrorCode AddCut(PetscReal s, Cuts *cuts)
{
  PetscFunctionBegin;
  if (cuts->n == cuts->capacity) {
    cuts->capacity = 2 * cuts->capacity + 16;
    PetscCall(PetscRealloc(sizeof(*cuts->s) * (size_t)cuts->capacity, &cuts->s));
  }
  cuts->s[cuts->n++] = s;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the curves of the border of a plane shape, which the caller frees. */
static PetscErrorCode CurvesOf(const Body *body, PetscInt *n, Curve **curve)
{
  const PetscReal *x      = body->parameter;
  const Border    *border = (const Border *)body->data;

  PetscFunctionBegin;
  *n = body->data ? border->n : body->shape == &ShapeCircle ? 1 : body->n / 2;
  PetscCall(PetscMalloc1(*n, curve));
  if (body->data) {
    PetscCall(PetscArraycpy(*curve, border->curve, *n));
  } else if (body->shape == &ShapeCircle) {
    (*curve)[0] =
        CurveArc(x, (PetscReal[]){x[2], 0.0}, (PetscReal[]){0.0, x[2]}, 0.0, 2.0 * PETSC_PI);
  } else {
    for (PetscInt k = 0; k < *n; k++) (*curve)[k] = CurveLine(&x[2 * k], &x[2 * ((k + 1) % *n)]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscReal DistanceAt(const Curve *c, PetscReal s, const Body *part)
{
  PetscReal x[2], t[2], n[2];

  CurveAt(c, s, x, t);
  return part->shape->Distance(part, x, n);
}

/* Adds the places at which a curve crosses the border of a part: the distance from it is a bound
   for the way to the next. Places of corners on the curve are added as well, where borders
   coincide. */
static PetscErrorCode Cross(const Curve *c, const Body *part, PetscReal tight, Cuts *cuts)
{
  PetscReal from = 0.0, before = DistanceAt(c, 0.0, part), s;
  PetscInt  n;
  Curve    *other;

  PetscFunctionBegin;
  while (from < 1.0) {
    const PetscReal to =
        PetscMin(1.0, from + PetscMax(STEP, 0.2 * PetscAbsReal(before) / c->length));
    const PetscReal after = DistanceAt(c, to, part);
    PetscReal       low = from, high = to;

    for (PetscInt k = 0; k < 60 && before * after < 0.0; k++) {
      const PetscReal middle = 0.5 * (low + high);

      if (DistanceAt(c, middle, part) * before > 0.0) low = middle;
      else high = middle;
    }
    if (before * after < 0.0) PetscCall(AddCut(0.5 * (low + high), cuts));
    from   = to;
    before = after;
  }
  PetscCall(CurvesOf(part, &n, &other));
  for (PetscInt k = 0; k < n; k++)
    if (CurveNearest(c, other[k].a, PETSC_INFINITY, &s) < PetscSqr(tight))
      PetscCall(AddCut(s, cuts));
  PetscCall(PetscFree(other));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns 1 if the solid is on the left of a curve at its middle and the fluid on its right, -1 if
   it is the other way round, 0 if the curve does not separate them, or an earlier part has it. */
static PetscInt Separates(const Border *border, PetscInt k, const Curve *c, PetscReal extent)
{
  PetscReal x[2], t[2], y[2], n[2], speed, side[2];

  CurveAt(c, CurvePlace(c, 0.5), x, t);
  speed = PetscSqrtReal(t[0] * t[0] + t[1] * t[1]);
  for (PetscInt j = 0; j < k; j++)
    if (PetscAbsReal(border->part[j].shape->Distance(&border->part[j], x, n)) < TIGHT * extent)
      return 0;
  for (PetscInt right = 0; right < 2; right++) {
    const PetscReal off = (right ? SIDE : -SIDE) * extent / speed;

    y[0]        = x[0] + off * t[1];
    y[1]        = x[1] - off * t[0];
    side[right] = PartsDistance(border, y, n);
  }
  if ((side[0] < 0.0) == (side[1] < 0.0)) return 0;
  return side[0] < 0.0 ? 1 : -1;
}

/* Adds the pieces of a curve of part k that are on the border of the compound. */
static PetscErrorCode AddPieces(const Border *border, PetscInt k, const Curve *c, PetscReal extent,
                                PetscInt *n, Curve **pieces)
{
  Cuts cuts = {.n = 0};

  PetscFunctionBegin;
  PetscCall(AddCut(0.0, &cuts));
  PetscCall(AddCut(1.0, &cuts));
  for (PetscInt j = 0; j < border->parts; j++)
    if (j != k) PetscCall(Cross(c, &border->part[j], TIGHT * extent, &cuts));
  PetscCall(PetscSortReal(cuts.n, cuts.s));
  for (PetscInt q = 0; q + 1 < cuts.n; q++) {
    Curve    piece;
    PetscInt way;

    if ((cuts.s[q + 1] - cuts.s[q]) * c->length < JOINT * extent) {
      cuts.s[q + 1] = q + 2 < cuts.n ? cuts.s[q] : cuts.s[q + 1];
      continue;
    }
    piece = CurvePart(c, cuts.s[q], cuts.s[q + 1]);
    way   = Separates(border, k, &piece, extent);
    if (!way) continue;
    PetscCall(PetscRealloc(sizeof(piece) * (size_t)(*n + 1), pieces));
    (*pieces)[(*n)++] = way > 0 ? piece : CurvePart(&piece, 1.0, 0.0);
  }
  PetscCall(PetscFree(cuts.s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscReal Apart(const PetscReal a[2], const PetscReal b[2])
{
  return PetscMax(PetscAbsReal(a[0] - b[0]), PetscAbsReal(a[1] - b[1]));
}

/* Appends a curve to another if both are parts of one line, or of one arc. */
static PetscBool Joins(const Curve *next, PetscReal extent, Curve *c)
{
  if ((c->from == c->to) != (next->from == next->to)) return PETSC_FALSE;
  if (c->from == c->to) {
    const PetscReal u[2] = {c->b[0] - c->a[0], c->b[1] - c->a[1]},
                    v[2] = {next->b[0] - next->a[0], next->b[1] - next->a[1]};

    if (PetscAbsReal(u[0] * v[1] - u[1] * v[0]) >
            JOINT * extent * PetscMin(c->length, next->length) ||
        u[0] * v[0] + u[1] * v[1] < 0.0)
      return PETSC_FALSE;
    *c = CurveLine(c->a, next->b);
    return PETSC_TRUE;
  }
  if (Apart(c->c, next->c) > TIGHT * extent || Apart(c->p, next->p) > TIGHT * extent ||
      Apart(c->q, next->q) > TIGHT * extent)
    return PETSC_FALSE;
  *c = CurveArc(c->c, c->p, c->q, c->from, c->to + next->to - next->from);
  return PETSC_TRUE;
}

/* Joins the last piece of a loop and its first, if both are parts of one curve. */
static void JoinEnds(PetscReal extent, Curve piece[], PetscInt start, PetscInt *kept)
{
  if (*kept - start < 2 || !Joins(&piece[start], extent, &piece[*kept - 1])) return;
  piece[start] = piece[--*kept];
}

/* Orders pieces as closed loops and joins pieces of one line; returns NULL or a fault. */
static const char *Chain(PetscReal extent, PetscInt *count, Curve piece[])
{
  const PetscInt n     = *count;
  PetscInt       start = 0, kept = 0; /* of the present loop; pieces that are in place */

  for (PetscInt k = 0; k < n; k++) {
    const PetscReal *end  = k ? piece[k - 1].b : NULL;
    PetscInt         next = k;

    if (k > start) {
      while (next < n && Apart(end, piece[next].a) > JOINT * extent) next++;
      if (next == n) { /* the loop must be closed */
        if (Apart(end, piece[start].a) > JOINT * extent)
          return "its parts touch along a border that does not close; move one of them a little";
        start = k;
        next  = k;
      }
    }
    if (next != k) {
      const Curve other = piece[k];

      piece[k]    = piece[next];
      piece[next] = other;
    }
  }
  if (n && Apart(piece[n - 1].b, piece[start].a) > JOINT * extent)
    return "its parts touch along a border that does not close; move one of them a little";
  start = 0;
  for (PetscInt k = 0; k < n; k++) {
    if (kept > start && Apart(piece[kept - 1].b, piece[k].a) > JOINT * extent) {
      JoinEnds(extent, piece, start, &kept);
      start = kept;
    }
    if (kept > start && Joins(&piece[k], extent, &piece[kept - 1])) continue;
    piece[kept++] = piece[k];
  }
  JoinEnds(extent, piece, start, &kept);
  *count = kept;
  return NULL;
}

/* Copies the parts of a compound, and their numbers as its own: the operation as 1, 2 or 3, and the
   number of numbers of each come first. */
static PetscErrorCode CopyParts(PetscInt parts, const Body part[], const char operation[],
                                Border *border, Body *body)
{
  PetscInt n = 0;

  PetscFunctionBegin;
  border->parts = parts;
  PetscCall(PetscMalloc1(parts, &border->part));
  PetscCall(BodyStoreAdd(border->part, body->store));
  PetscCall(PetscMalloc1(parts, &border->operation));
  PetscCall(BodyStoreAdd(border->operation, body->store));
  for (PetscInt k = 0; k < parts; k++) {
    border->part[k] = part[k];
    if (!part[k].shape->plane && BodyReachesThrough(&part[k], 2))
      border->part[k].shape = part[k].shape->outline;
    border->operation[k] = operation[k];
    n += 2 + part[k].n;
  }
  PetscCall(PetscMalloc1(n, &body->parameter));
  PetscCall(BodyStoreAdd(body->parameter, body->store));
  for (PetscInt k = 0; k < parts; k++) {
    body->parameter[body->n++] = operation[k] == '+' ? 1.0 : operation[k] == '-' ? 2.0 : 3.0;
    body->parameter[body->n++] = (PetscReal)part[k].n;
    PetscCall(PetscArraycpy(body->parameter + body->n, part[k].parameter, part[k].n));
    body->n += part[k].n;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the border of a compound in the plane. Output: fault - NULL unless it is none. */
static PetscErrorCode SetPlane(PetscInt parts, const Body part[], const char operation[],
                               Body *body, const char **fault)
{
  PetscReal extent = 0.0;
  Border   *border;
  PetscInt  n      = 0;
  Curve    *pieces = NULL;

  PetscFunctionBegin;
  PetscCall(BorderMake(1, body, &border));
  PetscCall(CopyParts(parts, part, operation, border, body));
  for (PetscInt k = 0; k < parts; k++) extent = PetscMax(extent, part[k].extent);
  for (PetscInt k = 0; k < parts && !*fault; k++) {
    PetscInt curves;
    Curve   *curve;

    PetscCall(CurvesOf(&border->part[k], &curves, &curve));
    for (PetscInt c = 0; c < curves; c++)
      PetscCall(AddPieces(border, k, &curve[c], extent, &n, &pieces));
    PetscCall(PetscFree(curve));
  }
  if (!*fault) *fault = n ? Chain(extent, &n, pieces) : "nothing is left of it";
  if (pieces) PetscCall(BodyStoreAdd(pieces, body->store));
  border->n     = n;
  border->curve = pieces;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds a point of part k of a compound in space, unless it is no surface. Beside another part,
   whose surface ends this one at the distance s, the last point at s > e/4 has the area of its
   row to this end, e/2 + s in place of the spacing e; on the mean of all cuts of rows the area
   is right. */
static void AddIfSurface(const Border *border, PetscInt k, PetscReal extent, const PetscReal x[],
                         PetscReal n[], PetscReal area, SurfacePoints *points)
{
  const PetscReal edge = PetscSqrtReal(area);
  PetscReal       y[3], m[3], side[2], nearest = PETSC_INFINITY;

  for (PetscInt j = 0; j < border->parts; j++) {
    const Body     *other = &border->part[j];
    const PetscReal d     = PetscAbsReal(j == k ? 1.0 : other->shape->Distance(other, x, m));
    PetscReal       along = 0.0;

    if (j == k) continue;
    for (PetscInt a = 0; a < 3; a++) along += m[a] * n[a];
    if (d < TIGHT * extent && j < k && PetscAbsReal(along) > 0.999) return;
    nearest = PetscMin(nearest, d / PetscSqrtReal(PetscMax(1e-6, 1.0 - along * along)));
  }
  for (PetscInt out = 0; out < 2; out++) {
    for (PetscInt a = 0; a < 3; a++) y[a] = x[a] + (out ? SIDE : -SIDE) * extent * n[a];
    side[out] = PartsDistance(border, y, m);
  }
  if ((side[0] < 0.0) == (side[1] < 0.0) || nearest < 0.25 * edge) return;
  for (PetscInt a = 0; a < 3; a++) m[a] = side[0] < 0.0 ? n[a] : -n[a];
  SolidAdd(x, m, area * (nearest < 1.25 * edge ? 0.5 + nearest / edge : 1.0), points);
}

static void FillParts(const Body *body, SurfacePoints *points)
{
  const Border *border = &((const Solid *)body->data)->border;

  for (PetscInt k = 0; k < border->parts; k++) {
    const Body    *part = &border->part[k];
    const PetscInt n_of = part->shape->Count(part, points->dx);

    for (PetscInt q = 0; q < n_of; q++) {
      PetscReal       x[3] = {0.0}, n[3] = {0.0};
      const PetscReal area = part->shape->Point(part, q, points->dx, x, n);

      AddIfSurface(border, k, body->extent, x, n, area, points);
    }
  }
}

static PetscReal PartsOfSolid(const Body *body, const PetscReal x[], PetscReal normal[])
{
  return PartsDistance(&((const Solid *)body->data)->border, x, normal);
}

/* Computes the box of a compound in space from the boxes of its parts: that of unions, and of the
   first part less what intersections leave. */
static void PartsSpan(const Body *body, PetscInt axis, PetscReal span[2])
{
  const Border *border = &((const Solid *)body->data)->border;

  span[0] = border->part[0].lo[axis];
  span[1] = border->part[0].hi[axis];
  for (PetscInt k = 1; k < border->parts; k++) {
    const Body *part = &border->part[k];

    if (border->operation[k] == '+') {
      span[0] = PetscMin(span[0], part->lo[axis]);
      span[1] = PetscMax(span[1], part->hi[axis]);
    } else if (border->operation[k] == '&') {
      span[0] = PetscMax(span[0], part->lo[axis]);
      span[1] = PetscMin(span[1], part->hi[axis]);
    }
  }
}

static const ShapeRow compound_plane = {.name     = "compound",
                                        .brief    = "shapes with + - & between",
                                        .plane    = PETSC_TRUE,
                                        .Span     = BorderSpan,
                                        .Distance = BorderDistance,
                                        .Count    = BorderCount,
                                        .Point    = BorderPoint};

static const ShapeRow compound_prism = {.name  = "compound",
                                        .brief = "cylinders and prisms along z with + - & between",
                                        .outline  = &compound_plane,
                                        .Span     = PrismSpan,
                                        .Distance = PrismDistance,
                                        .Count    = PrismCount,
                                        .Point    = PrismPoint};

static const ShapeRow compound_solid = {.name     = "compound",
                                        .brief    = "shapes with + - & between",
                                        .Span     = PartsSpan,
                                        .Distance = PartsOfSolid,
                                        .Count    = SolidCount,
                                        .Point    = SolidPoint};

/* BodyCompound - Sets a body from parts that are combined in their order: added ('+'), cut away
   ('-'), or kept where both are ('&'). Output: fault - NULL, or a message about the parts. */
PetscErrorCode BodyCompound(PetscInt parts, const Body part[], const char operation[], Body *body,
                            const char **fault)
{
  const PetscBool plane   = part[0].shape->plane;
  PetscInt        through = 0;
  BodyMoments     moments;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < parts; k++) through += BodyReachesThrough(&part[k], 2) ? 1 : 0;
  *fault = NULL;
  if (plane || through == parts) {
    PetscCall(SetPlane(parts, part, operation, body, fault));
    if (*fault) PetscFunctionReturn(PETSC_SUCCESS);
  } else {
    if (through)
      *fault = "parts with ends and parts through the box are no compound; give all ends";
    if (*fault) PetscFunctionReturn(PETSC_SUCCESS);
    *fault = SolidCreate(FillParts, body);
    if (*fault) PetscFunctionReturn(PETSC_SUCCESS);
    PetscCall(CopyParts(parts, part, operation, &((Solid *)body->data)->border, body));
  }
  body->shape = plane ? &compound_plane : through ? &compound_prism : &compound_solid;
  for (PetscInt a = 0; a < (plane || through ? 2 : 3); a++) {
    PetscReal span[2];

    body->shape->Span(body, a, span);
    body->extent = PetscMax(body->extent, 0.5 * (span[1] - span[0]));
  }
  if (body->extent <= 0.0) *fault = "nothing is left of it";
  for (PetscInt k = 0; k < parts && !plane && !through; k++)
    if (part[k].extent > LARGE * body->extent)
      *fault = "a part is over 50 times as large as the rest";
  if (*fault) PetscFunctionReturn(PETSC_SUCCESS);
  BodySetBox(body);
  BodyFindMoments(body, &moments);
  if (moments.volume <= 0.0) *fault = "nothing is left of it";
  for (PetscInt a = 0; a < 3; a++) body->centre[a] = moments.centroid[a];
  for (PetscInt a = 0; a < (plane || through ? 2 : 3); a++)
    body->extent = PetscMax(body->extent,
                            PetscMax(body->hi[a] - body->centre[a], body->centre[a] - body->lo[a]));
  PetscFunctionReturn(PETSC_SUCCESS);
}
